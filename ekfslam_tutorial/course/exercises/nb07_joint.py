"""Exercise 07.3: are several pairs plausible together?"""

import numpy as np
from scipy.stats import chi2

from ..table import table
from .nb04_blocks import random_covariance


def jointly_compatible(zs, Hs, P, R, confidence):
    """Are m pairs of measurement and landmark plausible *together*?

    zs, shape (m, 2): the innovation of each pair.
    Hs, shape (m, 2, n): derivative of each expectation by the joint state.
    P, shape (n, n): covariance of the joint state. R, shape (2, 2): noise of each measurement, independent.
    Return ok (True or False): the joint distance passes the chi2 gate of this confidence; d2: the joint squared
    Mahalanobis distance; Z, shape (2m, 2m): the covariance of all innovations, stacked.
    """
    z, H = np.concatenate(zs), np.concatenate(Hs)
    Z = H @ P @ H.T + np.kron(np.eye(len(zs)), R)
    d2 = z @ np.linalg.solve(Z, z)
    return d2 <= chi2.ppf(confidence, len(z)), d2, Z


def some(rng, m, n=7, confidence=0.99):
    """Return m pairs whose stacked innovation has about one sigma in each direction."""
    P, R, Hs = random_covariance(rng, n, 0.1), random_covariance(rng, 2, 0.02), rng.normal(size=(m, 2, n))
    Z = jointly_compatible(np.zeros((m, 2)), Hs, P, R, confidence)[2]
    return (np.linalg.cholesky(Z) @ rng.normal(size=2 * m)).reshape(m, 2), Hs, P, R, confidence


def leaning(sign):
    """Return two pairs that lean by 2 sigma, to the same side or to opposite sides."""
    H = np.array([[[-1.0, 0], [0, -1]], [[-1, 0], [0, -1]]])
    return np.array([[0.8, 0.0], [0.8 * sign, 0.0]]), H, 0.16 * np.eye(2), 0.01 * np.eye(2), 0.99


def at_the_limit(rng, m, confidence):
    """Return the same m pairs just inside and just outside of the gate."""
    zs, *others = some(rng, m, confidence=confidence)
    scale = np.sqrt(chi2.ppf(confidence, 2 * m) / jointly_compatible(zs, *others)[1])
    return [(zs * scale * factor, *others) for factor in (0.99, 1.01)]


def pairs(zs, Hs, P, R, confidence):
    """Return what the messages say of the arguments."""
    d2 = jointly_compatible(zs, Hs, P, R, confidence)[1]
    return f"{len(zs)} pairs of joint distance d2 = {d2:.2f}, confidence {confidence:g}"


joint = table(
    "07.3 Plausible together",
    jointly_compatible,
    hints=(
        "Stack the innovations to one long vector of 2m numbers, and the Jacobians to one matrix of 2m rows.",
        "H P H' has blocks between different pairs: their expectations share the error of the robot. The noises of the measurements are independent: R is repeated along the diagonal.",
        "z = np.concatenate(zs), H = np.concatenate(Hs), Z = H P H' + np.kron(np.eye(m), R), d2 = z' inv(Z) z, and the limit is chi2.ppf(confidence, 2 m).",
    ),
    returns="ok, d2, Z",
    symbols="H_i, H_j = the Jacobians of two pairs",
    kinds={"ok": "True or False"},
    shown=pairs,
    cases={
        "any": lambda rng: [some(rng, m) for m in (2, 1, 4)],
        "one": lambda rng: [some(rng, 1)],
        "several": lambda rng: [some(rng, m, n) for m, n in ((2, 7), (3, 9), (5, 5), (1, 4))],
        "leaning": lambda rng: [leaning(1), leaning(-1)],
        "limit": lambda rng: [args for m in (1, 2, 4) for c in (0.99, 0.9) for args in at_the_limit(rng, m, c)],
    },
    checks="""
    one pair             | Z  | one     | For m = 1 it is the gate of a single pair: Z = H P H' + R.
    the joint covariance | Z  | several | With all pairs stacked, one after the other: Z = H P H', plus R in each 2 x 2 block on the diagonal.
    the joint distance   | d2 | several | d2 = z' inv(Z) z, with the stacked z and the whole Z: one number for all pairs.
    together plausible   | ok | leaning | Both pairs shifted to the same side is what an uncertain robot does: plausible. Shifted to opposite sides they are not: ok tells if the joint d2 passes the gate.
    the gate             | ok | limit   | The limit is the chi-square quantile for 2m numbers: chi2.ppf(confidence, 2 m).
    """,
    wrong="""
    pairs as if independent: All expectations share the error of the robot: the blocks H_i P H_j' between different pairs are not zero. Without them it is only many single gates.
        d2 = z @ -> Z = Z * np.kron(np.eye(len(zs)), np.ones((2, 2))); d2 = z @
    R everywhere | np.eye(len(zs)), R -> np.ones((len(zs), len(zs))), R | The noises of two measurements are independent: R belongs to the diagonal blocks only.
    R forgotten | np.kron(np.eye(len(zs)), R) -> 1e-9 * np.eye(len(z)) | The measurements have noise, too: add R to each diagonal block.
    R in the first block only | np.kron(np.eye(len(zs)), R) -> np.pad(R, (0, len(z) - 2)) | Every pair has its own measurement noise: R in each diagonal block.
    order of the Kronecker product | np.kron(np.eye(len(zs)), R) -> np.kron(R, np.eye(len(zs))) | np.kron(np.eye(m), R) repeats R along the diagonal; np.kron(R, np.eye(m)) does not.
    diagonal of R | np.eye(len(zs)), R) -> np.eye(len(zs)), np.diag(np.diag(R))) | R may have a covariance between range and bearing: use all of it.
    diagonal of P | H @ P @ H.T -> H @ np.diag(np.diag(P)) @ H.T | The covariances in P are what connects the pairs: use the whole P.
    Z not inverted | z @ np.linalg.solve(Z, z) -> z @ Z @ z | In units of sigma: divide by Z, z' inv(Z) z.
    2 degrees of freedom | chi2.ppf(confidence, len(z)) -> chi2.ppf(confidence, 2) | 2m numbers are tested together: chi2 has 2m degrees of freedom.
    m degrees of freedom | chi2.ppf(confidence, len(z)) -> chi2.ppf(confidence, len(zs)) | Each pair brings two numbers: 2m degrees of freedom.
    m times the single gate | chi2.ppf(confidence, len(z)) -> len(zs) * chi2.ppf(confidence, 2) | Quantiles do not add up: take chi2 with 2m degrees of freedom.
    as many degrees of freedom as states | chi2.ppf(confidence, len(z)) -> chi2.ppf(confidence, len(P)) | The innovations are tested, 2m numbers, not the n states behind them.
    always 99 % | chi2.ppf(confidence, -> chi2.ppf(0.99, | The limit follows from `confidence`: 0.99 is only an example.
    other tail | chi2.ppf(confidence, -> chi2.ppf(1 - confidence, | Your gate lets almost nothing in, as with the probability 1 - confidence to be *inside*. Wanted is d2 <= chi2.ppf(confidence, 2 m); as a p-value, 1 - chi2.cdf(d2, 2 m) >= 1 - confidence.
    confidence to the power of m | chi2.ppf(confidence, -> chi2.ppf(confidence ** len(zs), | One joint test is made, with this confidence: no power of it, as for m tests of single pairs.
    not squared | d2 = z @ np.linalg.solve(Z, z) -> d2 = np.sqrt(z @ np.linalg.solve(Z, z)) | The gate is for the squared distance: no root.
    sum of the single distances | z @ np.linalg.solve(Z, z) -> sum(a @ np.linalg.solve(Z[2 * i : 2 * i + 2, 2 * i : 2 * i + 2], a) for i, a in enumerate(zs)) | The sum of single distances looks at each pair alone. Use the stacked z and Z.
    all first numbers, then all second ones | d2 = z -> z = zs.T.ravel(); d2 = z | z and Z must have the same order: pair after pair.
    each pair by its own gate: ok must come from the joint d2. Each pair in its own gate is not enough: look at two that lean to opposite sides.
        return d2 <= chi2.ppf(confidence, len(z)) -> return max(a @ np.linalg.solve(Z[2 * i : 2 * i + 2, 2 * i : 2 * i + 2], a) for i, a in enumerate(zs)) <= chi2.ppf(confidence, 2)
    the other way round | return d2 <= chi2 -> return d2 > chi2 | ok is True if the distance is *below* the limit.
    averaged over the pairs | z @ np.linalg.solve(Z, z) -> z @ np.linalg.solve(Z, z) / len(zs) | The joint distance is that of all 2m numbers together: do not divide it by the number of pairs.
    all ranges, then all bearings: The order is another one: z1 (range, bearing), then z2, and so on, in z and in Z.
        return d2 <= chi2 -> o = np.arange(len(z)).reshape(-1, 2).T.ravel(); Z = Z[np.ix_(o, o)]; return d2 <= chi2
    mean innovation taken off | z, H = np.concatenate(zs), -> z, H = np.concatenate(zs - np.mean(zs, axis=0)), | What the pairs have in common is in Z already, by the error of the robot: z stays as it is.
    blocks off the diagonal transposed | d2 = z @ np -> n = len(zs); Z = np.reshape(Z, (n, 2, n, 2)).transpose(2, 1, 0, 3).reshape(2 * n, 2 * n); d2 = z @ np | The block H_i P H_j' stands in the rows of pair i and the columns of pair j: yours are exchanged.
    degrees of freedom less those of the pose | chi2.ppf(confidence, len(z)) -> chi2.ppf(confidence, max(len(z) - 3, 1)) | Nothing is fitted to these innovations: all 2m numbers count.
    blocks of the diagonal counted twice | d2 = z @ np -> Z = Z * (1 + np.kron(np.eye(len(zs)), np.ones((2, 2)))); d2 = z @ np | Mirrored and added, the blocks on the diagonal count twice: each stands in Z once.
    """,
)
