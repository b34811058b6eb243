"""Exercise 02.4: a new landmark in the state and in the covariance."""

import numpy as np

from .. import expect
from ..exercise import Exercise
from .nb02_h import h
from .nb02_q import landmark_of, q, random_pose, random_y


def add_landmark(x, P, y, x_r, R):
    """Put a new landmark behind those in the map.

    x, shape (2n,), and P, shape (2n, 2n), are the map so far; n may be 0. y = [range, bearing] is the first
    measurement of the new landmark, with noise covariance R (slide: Q), from the known pose x_r.
    Return the new x, shape (2n + 2,), and the new P, shape (2n + 2, 2n + 2).
    """
    l, L_y = q(y, x_r)
    n = len(x)
    P_new = np.zeros((n + 2, n + 2))
    P_new[:n, :n] = P
    P_new[n:, n:] = L_y @ R @ L_y.T
    return np.concatenate([x, l]), P_new


grown = Exercise(
    "02.4",
    "The map grows",
    add_landmark,
    hints=(
        "The new landmark comes from y and the known x_r. Whose noise is in it? Do the old ones share it?",
        "x_new = [x, l]. P_new has four blocks: the old P, two blocks of zeros, and the covariance of l.",
        "The noise of y reaches l through L_y: covariance L_y R L_y'. The zeros have shapes (2n, 2) and (2, 2n).",
    ),
)


def _map(rng, n):
    """A map of n landmarks, with a covariance of no special form."""
    A = rng.normal(size=(2 * n, 2 * n))
    return rng.uniform(-5, 5, 2 * n), 0.1 * A @ A.T + 0.05 * np.eye(2 * n)


def _R(rng):
    """A noise covariance that is not diagonal."""
    s = np.array([rng.uniform(0.1, 0.4), rng.uniform(0.02, 0.1)])
    return np.outer(s, s) * [[1, 0.6], [0.6, 1]]


def _grown(f, rng, n):
    x, P, y, x_r, R = *_map(rng, n), random_y(rng), random_pose(rng), _R(rng)
    x2, P2 = expect.results(f(x, P, y, x_r, R), "x", "P")
    x2 = expect.array(x2, 2 * n + 2, "the new x")
    P2 = expect.array(P2, (2 * n + 2, 2 * n + 2), "the new P")
    return x, P, y, x_r, R, x2, P2


@grown.link("shapes", "Each landmark brings two numbers to x, two rows and two columns to P.")
def _(f, rng):
    _grown(f, rng, 3)


@grown.link("old landmarks", "What was in the map stays where it was, as it was.")
def _(f, rng):
    x, P, *_, x2, P2 = _grown(f, rng, 3)
    expect.close(x2[:6], x, "the old part of x")
    expect.close(P2[:6, :6], P, "the old block of P")


@grown.link("mean of the new landmark", "It is l = q(y, x_r), at the end of x.", part=0)
def _(f, rng):
    x, P, y, x_r, R, x2, P2 = _grown(f, rng, 2)
    expect.close(x2[-2:], q(y, x_r)[0], "the new landmark")


@grown.link("symmetric", "The block below the diagonal is the transpose of the one above it.", part=1)
def _(f, rng):
    expect.symmetric(_grown(f, rng, 2)[-1], "the new P")


@grown.link("zero blocks", "The pose is known: what could the new landmark have in common with the old ones?", part=1)
def _(f, rng):
    n, P2 = 4, _grown(f, rng, 2)[-1]
    expect.true(
        not np.any(P2[:n, n:]) and not np.any(P2[n:, :n]),
        "the blocks between the new landmark and the old ones are not exactly zero",
    )


@grown.link("covariance of the new landmark", "y has the covariance R. What is the covariance of q(y)?", part=1)
def _(f, rng):
    for n in (1, 3, 2):
        *_, y, x_r, R, x2, P2 = _grown(f, rng, n)
        L_y = q(y, x_r)[1]
        expect.close(P2[-2:, -2:], L_y @ R @ L_y.T, "the block of the new landmark")


@grown.link(
    "a cloud of measurements",
    "Draw many y with covariance R: the landmarks q(y) must scatter as your block says.",
    part=1,
)
def _(f, rng):
    x_r, y, R = random_pose(rng), np.array([4.0, 1.0]), _R(rng) * 0.01  # small noise: q is a straight line there
    P2 = expect.array(expect.results(f(np.zeros(0), np.zeros((0, 0)), y, x_r, R), "x", "P")[1], (2, 2), "the new P")
    S = np.linalg.cholesky(R)
    cloud = np.array([landmark_of(y + S @ w, x_r) for w in rng.normal(size=(2000, 2))])
    ratio = np.linalg.eigvals(np.linalg.solve(P2, np.cov(cloud.T))).real
    # 2000 draws: a variance is right within 3.3 sqrt(2 / 2000) = 10 % (99.9 %), an eigenvalue within 15 %
    expect.true(
        np.all(np.abs(ratio - 1) < 0.15), f"the cloud is {ratio.max():.2f} times as large as your block (variance)"
    )


@grown.link("the first landmark", "An empty map has x of shape (0,) and P of shape (0, 0): no special case is needed.")
def _(f, rng):
    *_, y, x_r, R, x2, P2 = _grown(f, rng, 0)
    L_y = q(y, x_r)[1]
    expect.close(x2, q(y, x_r)[0], "x")
    expect.close(P2, L_y @ R @ L_y.T, "P")


def _blocks(x, P, l, C, B, old=1.0):
    """The grown map with the cross block C and the new block B."""
    return np.concatenate([x, l]), np.block([[old * P, C], [C.T, B]])


def _wrong_block(name, hint, B_of):
    """A misconception in the new block only: B_of(L_y, R)."""

    @grown.wrong(name, hint)
    def _(x, P, y, x_r, R):
        l, L_y = q(y, x_r)
        return _blocks(x, P, l, np.zeros((len(x), 2)), B_of(L_y, R))


_wrong_block(
    "R itself",
    "R is the covariance of range and bearing (m^2, rad^2). A landmark has x and y: carry R over with L_y R L_y'.",
    lambda L, R: R,
)
_wrong_block(
    "L' R L",
    "The transpose is on the wrong side: cov(L y) = L R L'.",
    lambda L, R: L.T @ R @ L,
)
_wrong_block(
    "L R only",
    "A covariance is multiplied from both sides: L R L'.",
    lambda L, R: L @ R,
)
_wrong_block(
    "elementwise product",
    "`*` multiplies entry by entry; matrices are multiplied by `@`.",
    lambda L, R: L * R * L.T,
)
_wrong_block(
    "standard deviation taken for variance",
    "R holds variances already: do not square it.",
    lambda L, R: L @ R @ R @ L.T,
)
_wrong_block(
    "square root",
    "R holds variances, and P wants variances: no square root.",
    lambda L, R: L @ np.sqrt(np.abs(R)) @ L.T,
)
_wrong_block(
    "variances only",
    "Your block is diagonal. In the map frame x and y of a landmark are correlated: keep the whole product L R L'.",
    lambda L, R: np.diag(np.diag(L @ R @ L.T)),
)
_wrong_block(
    "noise of range and bearing independent",
    "You used the diagonal of R only. R may have a covariance between range and bearing.",
    lambda L, R: L @ np.diag(np.diag(R)) @ L.T,
)
_wrong_block(
    "L L'",
    "Where is the noise of the sensor? cov(L y) = L R L'.",
    lambda L, R: L @ L.T,
)
_wrong_block(
    "identity",
    "The sensor tells how uncertain the landmark is: L R L', not 1 m^2 for all.",
    lambda L, R: np.eye(2),
)
_wrong_block(
    "zero",
    "A zero block says that the new landmark is known exactly. It was measured with noise R.",
    lambda L, R: np.zeros((2, 2)),
)
_wrong_block(
    "double counting",
    "Your block is exactly half of L R L': the measurement that starts the landmark must not update it, too.",
    lambda L, R: L @ R @ L.T / 2,
)
_wrong_block(
    "very large",
    "A large first guess is honest only if the measurement then corrects it. Or directly: L R L'.",
    lambda L, R: 1e6 * np.eye(2),
)
_wrong_block(
    "inverse of H missing",
    "You used H (range and bearing by x and y). The noise goes the other way: L_y = dl/dy, the inverse of H.",
    lambda L, R: np.linalg.inv(L) @ R @ np.linalg.inv(L).T,
)


@grown.wrong(
    "new landmark first", "The new landmark goes behind the others: the ranges of the old ones must not change."
)
def _(x, P, y, x_r, R):
    l, L_y = q(y, x_r)
    Z = np.zeros((2, len(x)))
    return np.concatenate([l, x]), np.block([[L_y @ R @ L_y.T, Z], [Z.T, P]])


@grown.wrong(
    "measurement instead of landmark",
    "The map holds x and y of each landmark: append q(y, x_r), not the measurement y.",
)
def _(x, P, y, x_r, R):
    L_y = q(y, x_r)[1]
    return _blocks(x, P, np.asarray(y), np.zeros((len(x), 2)), L_y @ R @ L_y.T)


@grown.wrong(
    "correlated with the old ones",
    "That would be right if an uncertain robot tied them together (SLAM). Here the pose is known: zeros.",
)
def _(x, P, y, x_r, R):
    l, L_y = q(y, x_r)
    B = L_y @ R @ L_y.T
    C = np.vstack([B] * (len(x) // 2)) if len(x) else np.zeros((0, 2))
    return _blocks(x, P, l, C, B)


@grown.wrong("noise added to all", "A new landmark tells nothing about the old ones: their block of P stays as it is.")
def _(x, P, y, x_r, R):
    l, L_y = q(y, x_r)
    B = L_y @ R @ L_y.T
    x2, P2 = _blocks(x, P, l, np.zeros((len(x), 2)), B)
    return x2, P2 + np.kron(np.eye(len(x) // 2 + 1), B)


@grown.wrong("old covariance lost", "The old P must stand in the upper left block.")
def _(x, P, y, x_r, R):
    l, L_y = q(y, x_r)
    return _blocks(x, P, l, np.zeros((len(x), 2)), L_y @ R @ L_y.T, old=0.0)


@grown.variant("np.block, as lists")
def _(x, P, y, x_r, R):
    l, L_y = q(y, x_r)
    n = len(x)
    return [*x, *l], np.block([[P, np.zeros((n, 2))], [np.zeros((2, n)), L_y @ R @ L_y.T]]).tolist()


@grown.variant("scipy block_diag")
def _(x, P, y, x_r, R):
    from scipy.linalg import block_diag

    l, L_y = q(y, x_r)
    return np.append(x, l), block_diag(P, L_y @ R @ L_y.T)[-len(x) - 2 :, -len(x) - 2 :]


@grown.variant("large first guess, then one update with the same measurement")
def _(x, P, y, x_r, R):
    l, _ = q(y, x_r)
    H = h(l, 0, x_r)[1]
    prior = 1e6 * np.eye(2)
    K = prior @ H.T @ np.linalg.inv(H @ prior @ H.T + R)
    A = np.eye(2) - K @ H
    return _blocks(x, P, l, np.zeros((len(x), 2)), A @ prior @ A.T + K @ R @ K.T)


@grown.variant("information of the measurement, inverted")
def _(x, P, y, x_r, R):
    l, _ = q(y, x_r)
    H = h(l, 0, x_r)[1]
    return _blocks(x, P, l, np.zeros((len(x), 2)), np.linalg.inv(H.T @ np.linalg.solve(R, H)))
