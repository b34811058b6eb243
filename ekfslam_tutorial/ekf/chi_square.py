"""The chi-square distribution, without the second that the import of scipy.stats takes."""

from scipy.special import gammainc, gammaincinv


def quantile(probability, dof):
    """Return what a chi-square number of `dof` degrees stays below with this probability; arrays broadcast."""
    return 2.0 * gammaincinv(dof / 2, probability)


def cdf(x, dof):
    """Probability that a chi-square number with so many degrees of freedom is below x; arrays broadcast."""
    return gammainc(dof / 2, x / 2)
