"""Exercise 09.3: a clock offset, found by the NIS."""

import numpy as np

from ..table import table
from .nb04_blocks import random_covariance


def clock_offset(offsets, z, Z):
    """The clock offset with the smallest mean NIS.

    offsets, shape (K,), are the candidates, s. The filter ran once with each of them: z[k], shape (m, p), are the
    innovations of run k, one row for each measurement, and Z[k], shape (m, p, p), their covariances.
    Return the best offset, s, and the mean NIS of each run, shape (K,).
    """
    nis = np.mean(np.einsum("kmi,kmi->km", z, np.linalg.solve(Z, z[..., None])[..., 0]), axis=1)
    return offsets[np.argmin(nis)], nis


def case(rng, K, m, p, best):
    """Return offsets in any order, and innovations that grow with the distance from the best of them."""
    offsets = np.round(rng.permutation(K) * 0.1 - 0.33, 2)
    Z = np.array([[random_covariance(rng, p, rng.uniform(0.05, 3)) for _ in range(m)] for _ in range(K)])
    # the size of Z differs from run to run, so that |z| and the NIS choose differently
    Z = Z * rng.uniform(0.2, 5, (K, 1, 1, 1))
    z = np.einsum("kmij,kmj->kmi", np.linalg.cholesky(Z), rng.standard_normal((K, m, p)))
    z *= (0.3 + 0.5 * np.abs(np.arange(K) - best))[:, None, None]
    return offsets, z, Z


def in_units(offsets, z, Z):
    """Return the same with millimetres and hectoradians, or so."""
    S = np.diag([1e3, 1e-2])
    return offsets, z @ S, S @ Z @ S


clock = table(
    "09.3 A clock offset from the NIS",
    clock_offset,
    hints=(
        "Wrong stamps make the innovations larger than Z predicts. Which number compares z with Z?",
        "NIS of one measurement: z' inv(Z) z. Average it over the measurements of a run; compare the runs.",
        "np.linalg.solve(Z[k, j], z[k, j]) in two loops; then offsets[np.argmin(nis)].",
    ),
    returns="offset, nis",
    cases={
        "any": lambda rng: [case(rng, *sizes) for sizes in ((8, 15, 2, 5), (3, 20, 2, 0), (6, 8, 1, 2), (5, 12, 3, 4))],
        "one": lambda rng: [
            (np.array([0.5]), np.array([[[0.2], [0.2]]]), np.array([[[[0.01]], [[0.01]]]])),
            case(rng, 1, 4, 2, 0),
        ],
        "single": lambda rng: [case(rng, 4, 1, 2, 3)],
        "units": lambda rng: [in_units(*case(rng, 4, 9, 2, 1))],
    },
    checks="""
    one run     | nis    | one   | NIS = z' inv(Z) z for each measurement, with its own Z; then the mean over a run.
    mean NIS    | nis    | any   | NIS = z' inv(Z) z for each measurement, with its own Z; then the mean over a run.
    best offset | offset | any   | The offset, in seconds, of the run with the smallest mean NIS.
    one offset  | offset | one   | The offset, in seconds, of the run with the smallest mean NIS.
    one measurement | nis, offset | single | Each run has one measurement here: its NIS is the mean NIS of the run. The offset is that of the run with the smallest.
    units       | nis    | units | Metres or millimetres: the NIS has no unit and must not change.
    """,
    wrong="""
    no Z | np.linalg.solve(Z, z[..., None])[..., 0] -> z | z' z adds square metres to square radians. Measure z in units of Z: z' inv(Z) z.
    multiplied by Z | np.linalg.solve(Z, z[..., None]) -> (Z @ z[..., None]) | A large Z forgives a large innovation: divide by Z, z' inv(Z) z.
    square root | np.mean(np.einsum("kmi,kmi->km", z, np.linalg.solve(Z, z[..., None])[..., 0]), axis=1) -> np.mean(np.sqrt(_each(z, Z)), axis=1) | That is the Mahalanobis distance. The NIS is its square.
    diagonal of Z only | np.linalg.solve(Z, z[..., None])[..., 0] -> z / np.diagonal(Z, axis1=2, axis2=3) | Range and bearing innovations are correlated: use the whole Z.
    sum instead of mean | np.mean( -> np.sum( | The mean NIS of an honest filter is the number of components of z. Divide by m.
    divided by the components | axis=1) -> axis=1) / z.shape[2] | Here the NIS is not divided: for range and bearing an honest filter has 2.
    NIS of the mean innovation | np.mean(np.einsum("kmi,kmi->km", z, np.linalg.solve(Z, z[..., None])[..., 0]), axis=1) -> _each(z.mean(1), Z.mean(1)) | Signs cancel in the mean. Take the NIS of each innovation first.
    median | np.mean( -> np.median( | The mean is wanted: its expectation is the number of components of z.
    number of the run | offsets[np.argmin(nis)] -> float(np.argmin(nis)) | Return the offset itself, in seconds: offsets[np.argmin(nis)].
    largest NIS | argmin -> argmax | A large NIS is a bad fit: take the smallest.
    sign of the offset | return offsets -> return -offsets | The offsets are the candidates already: return the best one with its own sign.
    the smallest NIS returned | offsets[np.argmin(nis)] -> nis.min() | Return the offset that belongs to the smallest NIS.
    NIS nearest to the ideal | np.argmin(nis) -> np.argmin(abs(nis - z.shape[2])) | Two filters differ here only in their stamps: the better stamps surprise less. Nearest to 2 is for tuning R.
    the first offset | np.argmin(nis) -> 0 | Which run has the smallest NIS differs from log to log: offsets[np.argmin(nis)].
    one Z for the run | solve(Z, -> solve(Z.mean(1, keepdims=True), | Each measurement has its own Z[k, j]: yours takes one for the whole run.
    NIS nearest to one | np.argmin(nis) -> np.argmin(abs(nis - 1)) | Two filters differ here only in their stamps: the better stamps surprise less. No ideal value is asked for.
    the first Z of a run | solve(Z, -> solve(Z[:, :1], | Each measurement has its own Z[k, j]: yours takes the first one of the run for all.
    offsets sorted, the runs not | return offsets[np.argmin(nis)] -> return np.sort(offsets)[np.argmin(nis)] | nis[k] belongs to offsets[k], in the order in which they come: do not sort one of them.
    offset without its sign | return offsets[np.argmin(nis)] -> return abs(offsets[np.argmin(nis)]) | A clock may be behind as well as ahead: return the offset with its sign.
    m - 1 | np.mean( -> np.divide(z.shape[1], z.shape[1] - 1) * np.mean( | A mean over m measurements is their sum divided by m, not by m - 1.
    likelihood for the NIS | nis = np.mean(np.einsum("kmi,kmi->km", z, np.linalg.solve(Z, z[..., None])[..., 0]), axis=1) -> nis = np.mean(np.einsum("kmi,kmi->km", z, np.linalg.solve(Z, z[..., None])[..., 0]) + np.linalg.slogdet(Z)[1], axis=1) | log det Z belongs to the likelihood. The NIS is z' inv(Z) z alone.
    the other Cholesky factor | np.linalg.solve(Z, z[..., None]) -> np.linalg.solve((L := np.linalg.cholesky(Z)).swapaxes(-1, -2) @ L, z[..., None]) | With Z = L L' the whitened innovation is L^-1 z, and not the inverse of L' times z.
    mean innovation taken off | nis = np.mean( -> z = z - z.mean(axis=1, keepdims=True); nis = np.mean( | The innovations are taken as they are. A wrong clock shows in their mean: without it nobody sees it.
    covariances of the first run | np.linalg.solve(Z, z[..., None]) -> np.linalg.solve(Z[:1], z[..., None]) | Each run has its own covariances: Z[k] belongs to z[k].
    first of the least ones | np.argmin(nis) -> next((k for k in range(len(nis) - 1) if nis[k + 1] > nis[k]), len(nis) - 1) | The smallest of *all* is wanted: behind the first dip there may be a deeper one.
    """,
)


def _each(z, Z):
    """The NIS of each innovation."""
    return np.einsum("...i,...i", z, np.linalg.solve(Z, z[..., None])[..., 0])
