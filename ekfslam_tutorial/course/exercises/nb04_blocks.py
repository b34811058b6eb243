"""Exercise 04.2: what a new landmark brings to the covariance of the joint state."""

import numpy as np

from .. import expect
from ..exercise import Exercise
from .nb04_inverse import inverse_observation, pose_and_measurement


def new_blocks(P, L_r, L_y, R):
    """Blocks that a new landmark brings to the covariance of the joint state.

    P, shape (n, n): covariance of the state so far; the robot's pose is its first 3 numbers.
    L_r, shape (2, 3), and L_y, shape (2, 2): derivatives of the landmark by the pose and by the measurement.
    R, shape (2, 2): covariance of the measurement.
    Return P_lx, shape (2, n), the landmark's covariance with all of the state so far, and P_ll, shape (2, 2).
    """
    P_lx = L_r @ P[:3]
    P_ll = P_lx[:, :3] @ L_r.T + L_y @ R @ L_y.T
    return P_lx, P_ll


blocks = Exercise(
    "04.2",
    "The covariance of a new landmark",
    new_blocks,
    hints=(
        "Write the error of the landmark: dl = L_r dx_r + L_y v, with v the error of the measurement. Each block of "
        "the covariance is the mean of a product of two errors.",
        "cov(dl, dx) = L_r cov(dx_r, dx), as v has nothing to do with dx. The rows of P that belong to the robot are "
        "P[:3].",
        "P_lx = L_r P[:3] and P_ll = L_r P_rr L_r' + L_y R L_y' with P_rr = P[:3, :3].",
    ),
)


def random_covariance(rng, n, scale=1.0):
    """Return a covariance with no zero in it, nothing equal, units mixed: n x n, well conditioned."""
    A = rng.normal(size=(n, n + 3)) * rng.uniform(0.3, 1.5, (n, 1))
    return scale * A @ A.T / n


def _blocks_case(rng, n, scale=1.0):
    _, L_r, L_y = inverse_observation(*pose_and_measurement(rng))
    return random_covariance(rng, n, scale), L_r, L_y, random_covariance(rng, 2, 0.1 * scale)


def _two(result, n):
    P_lx, P_ll = expect.results(result, "P_lx", "P_ll")
    return expect.array(P_lx, (2, n), "P_lx"), expect.array(P_ll, (2, 2), "P_ll")


@blocks.link("shapes", "P_lx has the 2 rows of the landmark and one column for each number of the state so far.")
def _(f, rng):
    for n in (7, 3, 5, 13):
        _two(f(*_blocks_case(rng, n)), n)


@blocks.link(
    "pose known exactly", "If the pose has no error, this must be notebook 02 again: P_ll = L_y R L_y'.", part=1
)
def _(f, rng):
    for n in (7, 3):
        P, L_r, L_y, R = _blocks_case(rng, n)
        P[:3], P[:, :3] = 0, 0
        expect.close(_two(f(P, L_r, L_y, R), n)[1], L_y @ R @ L_y.T, "P_ll", at="a robot whose pose is known exactly")


@blocks.link(
    "measurement exact",
    "If the measurement has no error, the landmark is exactly as uncertain as the pose makes it.",
    part=1,
)
def _(f, rng):
    for n in (5, 9):
        P, L_r, L_y, _ = _blocks_case(rng, n)
        want = L_r @ P[:3, :3] @ L_r.T
        expect.close(_two(f(P, L_r, L_y, np.zeros((2, 2))), n)[1], want, "P_ll", 1e-3, at="a measurement without noise")


@blocks.link(
    "P_ll", "Two causes of error, pose and measurement, and they are independent: what do their covariances do?", part=1
)
def _(f, rng):
    for n, scale in ((7, 1.0), (3, 1e-4), (11, 5.0)):
        P, L_r, L_y, R = _blocks_case(rng, n, scale)
        want = L_r @ P[:3, :3] @ L_r.T + L_y @ R @ L_y.T
        expect.close(_two(f(P, L_r, L_y, R), n)[1], want, "P_ll", 1e-3)


@blocks.link(
    "covariance with the robot", "The error of the pose is in the landmark, too: cov(dl, dx_r) = L_r P_rr.", part=0
)
def _(f, rng):
    for n in (3, 7):
        P, L_r, L_y, R = _blocks_case(rng, n)
        got = _two(f(P, L_r, L_y, R), n)[0][:, :3]
        expect.close(got, L_r @ P[:3, :3], "P_lx[:, :3], the covariance with the robot,", 1e-3)


@blocks.link("covariance with the old landmarks", "The old landmarks share errors with the robot, the new one does, "
             "too: so they share errors with each other.", part=0)  # fmt: skip
def _(f, rng):
    for n in (9, 5):
        P, L_r, L_y, R = _blocks_case(rng, n)
        got = _two(f(P, L_r, L_y, R), n)[0][:, 3:]
        expect.close(got, L_r @ P[:3, 3:], "P_lx[:, 3:], the covariance with the old landmarks,", 1e-3)


@blocks.link("the whole covariance", "Robot, old landmarks and the new one together must be a covariance.")
def _(f, rng):
    P, L_r, L_y, R = _blocks_case(rng, 9)
    P_lx, P_ll = _two(f(P, L_r, L_y, R), 9)
    expect.symmetric(P_ll, "P_ll", 1e-6)
    expect.psd(np.block([[P, P_lx.T], [P_lx, P_ll]]), "the whole covariance", 1e-6)


def _blocks_wrong(name, hint, answer):
    blocks.wrong(name, hint)(answer)


# fmt: off
_blocks_wrong(
    "zero cross-covariance",
    "P_ll is right, but P_lx = 0 says: landmark and robot err independently. Yet the landmark was seen from that very "
    "pose.",
    lambda P, L_r, L_y, R: (np.zeros((2, len(P))), L_r @ P[:3, :3] @ L_r.T + L_y @ R @ L_y.T),
)
_blocks_wrong(
    "mapping formula",
    "That is the mapping formula of notebook 02, for a pose without error. The robot itself is uncertain now: its "
    "error enters through L_r, into P_ll and into P_lx.",
    lambda P, L_r, L_y, R: (np.zeros((2, len(P))), L_y @ R @ L_y.T),
)
_blocks_wrong(
    "pose term only in P_lx",
    "P_ll has two terms: the pose is uncertain, too. Did you forget L_r P_rr L_r'?",
    lambda P, L_r, L_y, R: (L_r @ P[:3], L_y @ R @ L_y.T),
)
_blocks_wrong(
    "measurement noise forgotten",
    "P_ll has two terms: the measurement has noise, too. Did you forget L_y R L_y'?",
    lambda P, L_r, L_y, R: (L_r @ P[:3], L_r @ P[:3, :3] @ L_r.T),
)
_blocks_wrong(
    "only the robot",
    "The old landmarks are correlated with the robot, so the new one is correlated with them: take all columns of "
    "P[:3].",
    lambda P, L_r, L_y, R: (np.hstack([L_r @ P[:3, :3], np.zeros((2, len(P) - 3))]), new_blocks(P, L_r, L_y, R)[1]),
)
_blocks_wrong(
    "P_lx transposed",
    "Rows belong to the landmark, columns to the state so far: P_lx is 2 x n. Yours is its transpose, P_xl.",
    lambda P, L_r, L_y, R: (P[:, :3] @ L_r.T, new_blocks(P, L_r, L_y, R)[1]),
)
_blocks_wrong(
    "P_lr only",
    "P_lx must reach over the whole state: one column for each number in it, not only for the robot's three.",
    lambda P, L_r, L_y, R: (L_r @ P[:3, :3], new_blocks(P, L_r, L_y, R)[1]),
)
_blocks_wrong(
    "measurement noise not in metres",
    "R is in range and bearing (m, rad), P_ll in x and y (m, m): the Jacobian L_y brings one to the other, L_y R L_y'.",
    lambda P, L_r, L_y, R: (L_r @ P[:3], L_r @ P[:3, :3] @ L_r.T + R),
)
_blocks_wrong(
    "L_y transposed",
    "The noise goes through L_y from the left: L_y R L_y'. Yours is L_y' R L_y.",
    lambda P, L_r, L_y, R: (L_r @ P[:3], L_r @ P[:3, :3] @ L_r.T + L_y.T @ R @ L_y),
)
_blocks_wrong(
    "only the diagonal of R",
    "Use the whole R: the noise of range and bearing may be correlated.",
    lambda P, L_r, L_y, R: (L_r @ P[:3], L_r @ P[:3, :3] @ L_r.T + L_y @ np.diag(np.diag(R)) @ L_y.T),
)
_blocks_wrong(
    "R squared",
    "R holds variances already: do not square it.",
    lambda P, L_r, L_y, R: (L_r @ P[:3], L_r @ P[:3, :3] @ L_r.T + L_y @ R @ R @ L_y.T),
)
_blocks_wrong(
    "R entry by entry squared",
    "R holds variances already: do not square it.",
    lambda P, L_r, L_y, R: (L_r @ P[:3], L_r @ P[:3, :3] @ L_r.T + L_y @ R**2 @ L_y.T),
)
_blocks_wrong(
    "double counting",
    "Your P_ll is half of what it should be: the measurement was used twice, to start the landmark and to correct it.",
    lambda P, L_r, L_y, R: (L_r @ P[:3], (L_r @ P[:3, :3] @ L_r.T + L_y @ R @ L_y.T) / 2),
)
_blocks_wrong(
    "identity",
    "An identity says: 1 m^2 of variance, whatever the pose and the sensor. The covariance follows from L_r, P, L_y "
    "and R.",
    lambda P, L_r, L_y, R: (L_r @ P[:3], np.eye(2)),
)
_blocks_wrong(
    "identity and zero",
    "An identity says: 1 m^2 of variance, whatever the pose and the sensor. And zero says: no error in common with the "
    "robot.",
    lambda P, L_r, L_y, R: (np.zeros((2, len(P))), np.eye(2)),
)
_blocks_wrong(
    "heading left out",
    "Far landmarks suffer most from the heading: take all three columns of L_r and all three rows of the robot.",
    lambda P, L_r, L_y, R: (L_r[:, :2] @ P[:2], L_r[:, :2] @ P[:2, :2] @ L_r[:, :2].T + L_y @ R @ L_y.T),
)
_blocks_wrong(
    "noise in the cross-covariance",
    "The noise of a new measurement has nothing to do with the state so far: it is in P_ll, not in P_lx.",
    lambda P, L_r, L_y, R: (L_r @ P[:3] + np.hstack([L_y @ R @ L_y.T, np.zeros((2, len(P) - 2))]),
                            new_blocks(P, L_r, L_y, R)[1]),
)
_blocks_wrong(
    "sign of the cross-covariance",
    "If the robot is further to the left than it thinks, the landmark is so, too: the sign of P_lx is plus.",
    lambda P, L_r, L_y, R: (-L_r @ P[:3], new_blocks(P, L_r, L_y, R)[1]),
)
_blocks_wrong(
    "results in the wrong order",
    "The order is P_lx, then P_ll.",
    lambda P, L_r, L_y, R: new_blocks(P, L_r, L_y, R)[::-1],
)
# fmt: on


@blocks.variant("one Jacobian of everything, np.block")
def _(P, L_r, L_y, R):
    n = len(P)
    J = np.block([[np.eye(n), np.zeros((n, 2))], [L_r, np.zeros((2, n - 3)), L_y]])
    S = J @ np.block([[P, np.zeros((n, 2))], [np.zeros((2, n)), R]]) @ J.T
    return S[n:, :n], S[n:, n:]


@blocks.variant("start with a huge covariance, then correct with the measurement")
def _(P, L_r, L_y, R):
    n, W = len(P), np.linalg.inv(L_y)
    S = np.block([[P, np.zeros((n, 2))], [np.zeros((2, n)), 1e6 * np.eye(2)]])
    H = np.hstack([-W @ L_r, np.zeros((2, n - 3)), W])
    S = S - S @ H.T @ np.linalg.inv(H @ S @ H.T + R) @ H @ S
    return S[n:, :n], S[n:, n:]


@blocks.variant("sums over entries, lists")
def _(P, L_r, L_y, R):
    n = len(P)
    P_lx = [[sum(L_r[i][k] * P[k][j] for k in range(3)) for j in range(n)] for i in range(2)]
    P_ll = [[sum(P_lx[i][k] * L_r[j][k] for k in range(3)) for j in range(2)] for i in range(2)]
    noise = np.einsum("ik,kl,jl->ij", L_y, R, L_y)
    return P_lx, [[P_ll[i][j] + noise[i][j] for j in range(2)] for i in range(2)]


@blocks.variant("square roots of the covariances")
def _(P, L_r, L_y, R):
    w, V = np.linalg.eigh(P)
    A = V * np.sqrt(np.clip(w, 0, None))
    B = L_r @ A[:3]
    r, Q = np.linalg.eigh(R)
    C = L_y @ (Q * np.sqrt(np.clip(r, 0, None)))
    return B @ A.T, B @ B.T + C @ C.T
