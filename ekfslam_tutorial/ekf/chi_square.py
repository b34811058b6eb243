"""The chi-square distribution, without the second that the import of scipy.stats takes."""

import scipy  # which loads scipy.special at its first use: it takes a while, and few runs need it


def quantile(probability, dof):
    """Return what a chi-square number of `dof` degrees stays below with this probability; arrays broadcast."""
    return 2.0 * scipy.special.gammaincinv(dof / 2, probability)


def cdf(x, dof):
    """Probability that a chi-square number with so many degrees of freedom is below x; arrays broadcast."""
    return scipy.special.gammainc(dof / 2, x / 2)
