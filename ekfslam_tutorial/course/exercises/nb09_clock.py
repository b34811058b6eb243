"""Exercise 09.3: a clock offset, found by the NIS."""

import numpy as np

from .. import expect
from ..exercise import Exercise
from .nb04_blocks import random_covariance


def clock_offset(offsets, z, Z):
    """The clock offset with the smallest mean NIS.

    offsets, shape (K,), are the candidates, s. The filter ran once with each of them: z[k], shape (m, p), are the
    innovations of run k, one row for each measurement, and Z[k], shape (m, p, p), their covariances.
    Return the best offset, s, and the mean NIS of each run, shape (K,).
    """
    nis = np.mean(np.einsum("kmi,kmi->km", z, np.linalg.solve(Z, z[..., None])[..., 0]), axis=1)
    return offsets[np.argmin(nis)], nis


clock = Exercise(
    "09.3",
    "A clock offset from the NIS",
    clock_offset,
    hints=(
        "Wrong stamps make the innovations larger than Z lets expect. Which number compares z with Z?",
        "NIS of one measurement: z' inv(Z) z. Average it over the measurements of a run; compare the runs.",
        "np.linalg.solve(Z[k, j], z[k, j]) in two loops; then offsets[np.argmin(nis)].",
    ),
)


def case(rng, K, m, p, best):
    """Return offsets in any order, and innovations that grow with the distance from the best of them."""
    offsets = np.round(rng.permutation(K) * 0.1 - 0.3, 1)
    Z = np.array([[random_covariance(rng, p, rng.uniform(0.05, 3)) for _ in range(m)] for _ in range(K)])
    # the size of Z differs from run to run, so that |z| and the NIS choose differently
    Z = Z * rng.uniform(0.2, 5, (K, 1, 1, 1))
    z = np.einsum("kmij,kmj->kmi", np.linalg.cholesky(Z), rng.standard_normal((K, m, p)))
    z *= (0.3 + 0.5 * np.abs(np.arange(K) - best))[:, None, None]
    return offsets, z, Z


def _two(result, K):
    best, nis = expect.results(result, "offset", "nis")
    return float(expect.array(best, (), "offset")), expect.array(nis, K, "nis")


CASES = ((8, 15, 2, 5), (3, 20, 2, 0), (6, 8, 1, 2), (5, 12, 3, 4), (1, 4, 2, 0))


@clock.link("two results", "The function must end with `return offset, nis`: a number, and one number for each run.")
def _(f, rng):
    for K, m, p, best in CASES:
        _two(f(*case(rng, K, m, p, best)), K)


@clock.link("mean NIS", "NIS = z' inv(Z) z for each measurement, with its own Z; then the mean over a run.", part=1)
def _(f, rng):
    one = np.array([0.0]), np.array([[[0.2]]]), np.array([[[[0.01]]]])
    expect.close(_two(f(*one), 1)[1], [4.0], "nis", at="one innovation of 0.2 with the variance 0.01")
    for K, m, p, best in CASES:
        data = case(rng, K, m, p, best)
        expect.close(_two(f(*data), K)[1], clock_offset(*data)[1], "nis", at=f"{K} runs of {m} measurements")


@clock.link("best offset", "The offset, in seconds, of the run with the smallest mean NIS.", part=0)
def _(f, rng):
    for K, m, p, best in CASES:
        data = case(rng, K, m, p, best)
        expect.close(_two(f(*data), K)[0], clock_offset(*data)[0], "the offset", at=f"{K} runs")


@clock.link("units", "Metres or millimetres: the NIS has no unit and must not change.", part=1)
def _(f, rng):
    offsets, z, Z = case(rng, 4, 9, 2, 1)
    S = np.diag([1e3, 1e-2])
    want = clock_offset(offsets, z, Z)[1]
    expect.close(_two(f(offsets, z @ S, S @ Z @ S), 4)[1], want, "nis after a change of units")


def _wrong(name, hint, nis=None, best=None):
    """A misconception in nis(z, Z) of all measurements (K, m), or in best(offsets, nis)."""

    @clock.wrong(name, hint)
    def _(offsets, z, Z):
        n = nis(z, Z) if nis else clock_offset(offsets, z, Z)[1]
        return best(offsets, n) if best else offsets[np.argmin(n)], n


def _nis(z, Z):
    return np.einsum("kmi,kmij,kmj->km", z, np.linalg.inv(Z), z)


# fmt: off
_wrong("no Z", "z' z adds square metres to square radians. Measure z in units of Z: z' inv(Z) z.",
       lambda z, Z: (z**2).sum(-1).mean(1))
_wrong("multiplied by Z", "A large Z forgives a large innovation: divide by Z, z' inv(Z) z.",
       lambda z, Z: np.einsum("kmi,kmij,kmj->km", z, Z, z).mean(1))
_wrong("square root", "That is the Mahalanobis distance. The NIS is its square.",
       lambda z, Z: np.sqrt(_nis(z, Z)).mean(1))
_wrong("diagonal of Z only", "Range and bearing innovations are correlated: use the whole Z.",
       lambda z, Z: (z**2 / np.diagonal(Z, axis1=2, axis2=3)).sum(-1).mean(1))
_wrong("sum instead of mean", "The mean NIS of an honest filter is the number of components of z. Divide by m.",
       lambda z, Z: _nis(z, Z).sum(1))
_wrong("divided by the components", "Here the NIS is not divided: for range and bearing an honest filter has 2.",
       lambda z, Z: _nis(z, Z).mean(1) / z.shape[2])
_wrong("NIS of the mean innovation", "Signs cancel in the mean. Take the NIS of each innovation first.",
       lambda z, Z: np.einsum("ki,kij,kj->k", z.mean(1), np.linalg.inv(Z.mean(1)), z.mean(1)))
_wrong("median", "The mean is wanted: its expectation is the number of components of z.",
       lambda z, Z: np.median(_nis(z, Z), axis=1))
_wrong("number of the run", "Return the offset itself, in seconds: offsets[np.argmin(nis)].",
       best=lambda c, n: float(np.argmin(n)))
_wrong("largest NIS", "A large NIS is a bad fit: take the smallest.", best=lambda c, n: c[np.argmax(n)])
_wrong("sign of the offset", "The offsets are the candidates already: return the best one with its own sign.",
       best=lambda c, n: -c[np.argmin(n)])
_wrong("the smallest NIS returned", "Return the offset that belongs to the smallest NIS.", best=lambda c, n: n.min())
_wrong("NIS nearest to the ideal",
       "Two filters differ here only in their stamps: the better stamps surprise less. Nearest to 2 is for tuning R.",
       best=lambda c, n: c[np.argmin(abs(n - 2))])
# fmt: on


@clock.variant("loops and solve, lists")
def _(offsets, z, Z):
    nis = [
        sum(a @ np.linalg.solve(B, a) for a, B in zip(zk, Zk, strict=True)) / len(zk)
        for zk, Zk in zip(z, Z, strict=True)
    ]
    return min(zip(nis, offsets, strict=True))[1], nis


@clock.variant("inverse and matrix products")
def _(offsets, z, Z):
    nis = (z[:, :, None, :] @ np.linalg.inv(Z) @ z[:, :, :, None])[:, :, 0, 0].mean(axis=1)
    return [float(offsets[list(nis).index(nis.min())]), nis]


@clock.variant("Cholesky")
def _(offsets, z, Z):
    white = np.linalg.solve(np.linalg.cholesky(Z), z[..., None])[..., 0]
    nis = np.sum(white**2, axis=(1, 2)) / z.shape[1]
    return offsets[nis.argmin()], nis
