"""Exercise 07.3: are several pairs plausible together?"""

import numpy as np
from scipy.stats import chi2

from .. import expect
from ..exercise import Exercise
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


joint = Exercise(
    "07.3",
    "Plausible together",
    jointly_compatible,
    hints=(
        "Stack the innovations to one long vector of 2m numbers, and the Jacobians to one matrix of 2m rows.",
        "H P H' has blocks between different pairs: their expectations share the error of the robot. The noises of the "
        "measurements are independent: R is repeated along the diagonal.",
        "z = np.concatenate(zs), H = np.concatenate(Hs), Z = H P H' + np.kron(np.eye(m), R), d2 = z' inv(Z) z, and the "
        "limit is chi2.ppf(confidence, 2 m).",
    ),
)


def _case(rng, m, n=7, k=1.0):
    """m pairs whose stacked innovation has about k sigma in each direction."""
    P, R, Hs = random_covariance(rng, n, 0.1), random_covariance(rng, 2, 0.02), rng.normal(size=(m, 2, n))
    S = _Z(Hs, P, R)
    z = np.linalg.cholesky(S) @ rng.normal(size=2 * m) * k
    return z.reshape(m, 2), Hs, P, R


def _Z(Hs, P, R):
    m = len(Hs)
    return np.block([[Hs[i] @ P @ Hs[j].T + (R if i == j else 0) for j in range(m)] for i in range(m)])


def _out(result, m):
    ok, d2, Z = expect.results(result, "ok", "d2", "Z")
    d2 = expect.array(d2, (), "d2")
    return _yes(ok), float(d2), expect.array(Z, (2 * m, 2 * m), "Z")


def _yes(ok):
    good = isinstance(ok, (bool, np.bool_)) or (isinstance(ok, np.ndarray) and ok.shape == () and ok.dtype == bool)
    expect.true(good, f"ok must be True or False, got {ok!r:.40}")
    return bool(ok)


@joint.link("three results", "End with `return ok, d2, Z`; Z is 2m x 2m.")
def _(f, rng):
    for m in (2, 1, 4):
        _out(f(*_case(rng, m), 0.99), m)


@joint.link("one pair", "For m = 1 it is the gate of a single pair: Z = H P H' + R.", part=2)
def _(f, rng):
    zs, Hs, P, R = _case(rng, 1)
    expect.close(_out(f(zs, Hs, P, R, 0.99), 1)[2], Hs[0] @ P @ Hs[0].T + R, "Z of one pair")


@joint.link("the joint covariance", "Z = H P H' + (R on the diagonal), with all pairs stacked.", part=2)
def _(f, rng):
    for m, n in ((2, 7), (3, 9), (5, 5)):
        zs, Hs, P, R = _case(rng, m, n)
        expect.close(_out(f(zs, Hs, P, R, 0.99), m)[2], _Z(Hs, P, R), "Z")


@joint.link("the joint distance", "d2 = z' inv(Z) z, with the stacked z.", part=1)
def _(f, rng):
    for m, n in ((2, 7), (3, 9), (5, 5), (1, 4)):
        zs, Hs, P, R = _case(rng, m, n)
        w = np.linalg.solve(np.linalg.cholesky(_Z(Hs, P, R)), zs.ravel())
        expect.close(_out(f(zs, Hs, P, R, 0.99), m)[1], w @ w, "d2")


@joint.link("together plausible", "The same shift of both pairs is what an uncertain robot does: plausible.", part=0)
def _(f, rng):
    for sign, want in ((1, True), (-1, False)):
        H = np.array([[[-1.0, 0], [0, -1]], [[-1, 0], [0, -1]]])
        zs = np.array([[0.8, 0.0], [0.8 * sign, 0.0]])
        ok, d2, _ = _out(f(zs, H, 0.16 * np.eye(2), 0.01 * np.eye(2), 0.99), 2)
        how = "to the same side" if want else "to opposite sides"
        expect.true(ok == want, f"two pairs that lean {how} by 2 sigma (d2 = {d2:.1f}): ok must be {want}")


@joint.link("the gate", "The limit is the chi-square quantile for 2m numbers: chi2.ppf(confidence, 2 m).", part=0)
def _(f, rng):
    for m in (1, 2, 4):
        for confidence in (0.99, 0.9):
            zs, Hs, P, R = _case(rng, m)
            z = zs.ravel()
            scale = np.sqrt(chi2.ppf(confidence, 2 * m) / (z @ np.linalg.solve(_Z(Hs, P, R), z)))
            for factor, want in ((0.99, True), (1.01, False)):
                ok, d2, _ = _out(f(zs * scale * factor, Hs, P, R, confidence), m)
                expect.true(
                    ok == want, f"{m} pairs, d2 = {d2:.2f}, confidence {confidence}: ok must be {want}, got {ok}"
                )


def _wrong(name, hint, Z=_Z, d2=None, limit=lambda c, m: chi2.ppf(c, 2 * m)):
    @joint.wrong(name, hint)
    def _(zs, Hs, P, R, confidence):
        S = Z(np.asarray(Hs), P, R)
        d = np.ravel(zs) @ np.linalg.solve(S, np.ravel(zs)) if d2 is None else d2(np.asarray(zs), S)
        return bool(d <= limit(confidence, len(zs))), d, S


def _block(S, i):
    return S[2 * i : 2 * i + 2, 2 * i : 2 * i + 2]


def _blocks_only(Hs, P, R):
    return _Z(Hs, P, R) * np.kron(np.eye(len(Hs)), np.ones((2, 2)))


# fmt: off
_wrong("pairs as if independent", "All expectations share the error of the robot: the blocks H_i P H_j' between "
       "different pairs are not zero. Without them it is only many single gates.", Z=_blocks_only)
_wrong("R everywhere", "The noises of two measurements are independent: R belongs to the diagonal blocks only.",
       Z=lambda Hs, P, R: np.concatenate(Hs) @ P @ np.concatenate(Hs).T + np.kron(np.ones((len(Hs), len(Hs))), R))
_wrong("R forgotten", "The measurements have noise, too: add R to each diagonal block.",
       Z=lambda Hs, P, R: np.concatenate(Hs) @ P @ np.concatenate(Hs).T + 1e-9 * np.eye(2 * len(Hs)))
_wrong("R in the first block only", "Every pair has its own measurement noise: R in each diagonal block.",
       Z=lambda Hs, P, R: _Z(Hs, P, 0 * R) + np.pad(R, (0, 2 * len(Hs) - 2)))
_wrong("order of the Kronecker product", "np.kron(np.eye(m), R) repeats R along the diagonal; np.kron(R, np.eye(m)) "
       "does not.", Z=lambda Hs, P, R: _Z(Hs, P, 0 * R) + np.kron(R, np.eye(len(Hs))))
_wrong("diagonal of R", "R may have a covariance between range and bearing: use all of it.",
       Z=lambda Hs, P, R: _Z(Hs, P, np.diag(np.diag(R))))
_wrong("diagonal of P", "The covariances in P are what connects the pairs: use the whole P.",
       Z=lambda Hs, P, R: _Z(Hs, np.diag(np.diag(P)), R))
_wrong("2 degrees of freedom", "2m numbers are tested together: chi2 has 2m degrees of freedom.",
       limit=lambda c, m: chi2.ppf(c, 2))
_wrong("m degrees of freedom", "Each pair brings two numbers: 2m degrees of freedom.",
       limit=lambda c, m: chi2.ppf(c, m))
_wrong("m times the single gate", "Quantiles do not add up: take chi2 with 2m degrees of freedom.",
       limit=lambda c, m: m * chi2.ppf(c, 2))
_wrong("not squared", "The gate is for the squared distance: no root.",
       d2=lambda zs, S: float(np.sqrt(zs.ravel() @ np.linalg.solve(S, zs.ravel()))))
_wrong("sum of the single distances", "The sum of single distances looks at each pair alone. Use the stacked z and Z.",
       d2=lambda zs, S: float(sum(z @ np.linalg.solve(_block(S, i), z) for i, z in enumerate(zs))))
_wrong("all first numbers, then all second ones", "z and Z must have the same order: pair after pair.",
       d2=lambda zs, S: float(zs.T.ravel() @ np.linalg.solve(S, zs.T.ravel())))
# fmt: on


@joint.wrong(
    "each pair by its own gate",
    "ok must come from the joint d2. Each pair in its own gate is not enough: look at two that lean to opposite sides.",
)
def _(zs, Hs, P, R, confidence):
    S = _Z(np.asarray(Hs), P, R)
    single = [z @ np.linalg.solve(_block(S, i), z) for i, z in enumerate(zs)]
    return max(single) <= chi2.ppf(confidence, 2), np.ravel(zs) @ np.linalg.solve(S, np.ravel(zs)), S


@joint.wrong("the other way round", "ok is True if the distance is *below* the limit.")
def _(zs, Hs, P, R, confidence):
    ok, d2, Z = jointly_compatible(zs, Hs, P, R, confidence)
    return not ok, d2, Z


@joint.variant("block by block, plain types")
def _(zs, Hs, P, R, confidence):
    Z = _Z(Hs, P, R)
    z = np.ravel(zs)
    d2 = float(z @ np.linalg.inv(Z) @ z)
    return bool(chi2.cdf(d2, 2 * len(zs)) <= confidence), d2, Z.tolist()


@joint.variant("pair by pair: conditional distances")
def _(zs, Hs, P, R, confidence):
    Z, z, d2 = _Z(Hs, P, R), np.ravel(zs), 0.0
    for i in range(0, len(z), 2):
        K = np.linalg.solve(Z[:i, :i], Z[:i, i : i + 2]).T if i else np.zeros((2, 0))
        w = z[i : i + 2] - K @ z[:i]
        d2 += w @ np.linalg.solve(Z[i : i + 2, i : i + 2] - K @ Z[:i, i : i + 2], w)
    return d2 < chi2.ppf(confidence, z.size), d2, Z
