"""Exercise 05.4: a new landmark comes into the joint state."""

import numpy as np

from .. import expect
from ..exercise import Exercise
from .nb04_blocks import random_covariance
from .nb04_inverse import inverse_observation
from .nb05_predict import heading_wrapped, two


def augment(x, P, y, R):
    """Start a new landmark with its first measurement: it comes to the end of the state.

    x, shape (n,), and P, shape (n, n): joint state, the robot's pose first, and its covariance.
    y = [range, bearing]: the measurement; R, shape (2, 2): its covariance.
    Return the new x, shape (n + 2,), and P, shape (n + 2, n + 2). Do not change the inputs.
    """
    l, L_r, L_y = inverse_observation(x[:3], y)
    P_lx = L_r @ P[:3]
    P_ll = P_lx[:, :3] @ L_r.T + L_y @ R @ L_y.T
    return np.concatenate([x, l]), np.block([[P, P_lx.T], [P_lx, P_ll]])


augmentation = Exercise(
    "05.4",
    "Augment",
    augment,
    canonical=heading_wrapped,
    hints=(
        "l, L_r, L_y = inverse_observation(x[:3], y) gives the landmark. Then the blocks of notebook 04.",
        "P_lx = L_r P[:3], with all columns, and P_ll = L_r P_rr L_r' + L_y R L_y'.",
        "x: np.concatenate([x, l]). P: np.block([[P, P_lx.T], [P_lx, P_ll]]).",
    ),
)


def case(rng, n=7, scale=0.1):
    """Return a joint state, its covariance, and the first measurement of a new landmark."""
    x = rng.uniform(-4, 4, n)
    x[2] = rng.uniform(-3, 3)
    y = np.array([rng.uniform(1, 8), rng.uniform(-3, 3)])
    return x, random_covariance(rng, n, scale), y, random_covariance(rng, 2, 0.1 * scale)


def _out(f, c):
    return two(f(*c), len(c[0]) + 2)


@augmentation.link("two numbers more", "The state grows by the two numbers of the landmark, and P with it.")
def _(f, rng):
    for n in (7, 3, 5, 11):
        _out(f, case(rng, n))


@augmentation.link("the old state", "A new landmark tells nothing about the old ones: x and P so far do not change.")
def _(f, rng):
    for n in (7, 3):
        x, P, *rest = case(rng, n)
        x2, P2 = _out(f, (x, P, *rest))
        expect.close(np.delete(x2[:n], 2), np.delete(x, 2), "the old part of x")
        expect.angle(x2[2], x[2], "the heading")
        expect.close(P2[:n, :n], P, "the old part of P", 1e-3)


@augmentation.link("the landmark", "l = x_r + r [cos(theta + beta), sin(theta + beta)], at the end of x.", part=0)
def _(f, rng):
    for n in (7, 3, 9):
        c = case(rng, n)
        expect.close(_out(f, c)[0][n:], inverse_observation(c[0][:3], c[2])[0], "the new landmark")


def _blocks(c):
    x, P, y, R = c
    _, L_r, L_y = inverse_observation(x[:3], y)
    return L_r @ P[:3], L_r @ P[:3, :3] @ L_r.T, L_y @ R @ L_y.T


@augmentation.link("P_ll, pose known", "If the pose had no error, P_ll would be L_y R L_y'.", part=1)
def _(f, rng):
    for n in (7, 3):
        c = case(rng, n)
        c[1][:3], c[1][:, :3] = 0, 0
        want = _blocks(c)[2]
        expect.close(_out(f, c)[1][n:, n:], want, "P_ll", 1e-3, at="a pose that is known exactly")


@augmentation.link("P_ll", "Two independent causes of error, pose and measurement: their covariances add.", part=1)
def _(f, rng):
    for n, scale in ((7, 0.1), (3, 1.0), (9, 1e-5)):
        c = case(rng, n, scale)
        _, pose, noise = _blocks(c)
        expect.close(_out(f, c)[1][n:, n:], pose + noise, "P_ll", 1e-3)


@augmentation.link("P_lx", "cov(l, x) = L_r P[:3]: with the robot and with all old landmarks.", part=1)
def _(f, rng):
    for n in (7, 3, 9):
        c = case(rng, n)
        expect.close(_out(f, c)[1][n:, :n], _blocks(c)[0], "P_lx, rows of the new landmark,", 1e-3)


@augmentation.link("symmetric", "P_xl is the transpose of P_lx: fill both blocks.", part=1)
def _(f, rng):
    for n in (7, 3):
        P = _out(f, case(rng, n))[1]
        expect.symmetric(P, "P", 1e-6)
        expect.psd(P, "P", 1e-6)


@augmentation.link("two in turn", "The second new landmark shares the robot's error with the first one.", part=1)
def _(f, rng):
    c = case(rng, 3)
    x, P = _out(f, c)
    y = c[2] + [0.5, 1.0]
    P2 = _out(f, (x, P, y, c[3]))[1]
    want = inverse_observation(c[0][:3], y)[1] @ P[:3, 3:5]
    expect.close(P2[5:, 3:5], want, "the covariance of two landmarks started one after the other", 1e-3)


# ---- wrong and right answers -----------------------------------------------------------------------------------------


def _wrong(name, hint, l=None, P_lx=None, P_ll=None, P_xl=None, old=None):
    """A misconception in one of the parts; each is a function of (x, P, y, R, L_r, L_y)."""

    @augmentation.wrong(name, hint)
    def _(x, P, y, R):
        right, L_r, L_y = inverse_observation(x[:3], y)
        a = x, P, y, R, L_r, L_y
        C = P_lx(*a) if P_lx else L_r @ P[:3]
        D = P_ll(*a) if P_ll else L_r @ P[:3, :3] @ L_r.T + L_y @ R @ L_y.T
        new = np.block([[old(*a) if old else P, P_xl(*a) if P_xl else C.T], [C, D]])
        return np.concatenate([x, l(*a) if l else right]), new


# fmt: off
_wrong("zero cross-covariance", "P_ll is right, but zero beside it says: landmark and robot err independently. Yet the "
       "landmark was seen from that very pose: P_lx = L_r P[:3].", P_lx=lambda x, P, y, R, L, J: np.zeros((2, len(x))))
_wrong("mapping formula", "That is the mapping formula, for a pose without error. The robot is uncertain, too: its "
       "error enters through L_r, into P_ll and into P_lx.", P_lx=lambda x, P, y, R, L, J: np.zeros((2, len(x))),
       P_ll=lambda x, P, y, R, L, J: J @ R @ J.T)
_wrong("pose term forgotten", "P_ll has two terms: the pose is uncertain, too. Did you forget L_r P_rr L_r'?",
       P_ll=lambda x, P, y, R, L, J: J @ R @ J.T)
_wrong("measurement noise forgotten", "P_ll has two terms: did you forget L_y R L_y'?",
       P_ll=lambda x, P, y, R, L, J: L @ P[:3, :3] @ L.T)
_wrong("only the robot", "The old landmarks are correlated with the robot, so the new one is correlated with them: "
       "take all columns of P[:3].",
       P_lx=lambda x, P, y, R, L, J: np.hstack([L @ P[:3, :3], np.zeros((2, len(x) - 3))]))
_wrong("P_xl forgotten", "P must be symmetric: above the diagonal stands P_lx'.",
       P_xl=lambda x, P, y, R, L, J: np.zeros((len(x), 2)))
_wrong("noise not in metres", "R is in range and bearing, P_ll in x and y: L_y brings one to the other, L_y R L_y'.",
       P_ll=lambda x, P, y, R, L, J: L @ P[:3, :3] @ L.T + R)
_wrong("L_y transposed", "The noise goes through L_y from the left: L_y R L_y'.",
       P_ll=lambda x, P, y, R, L, J: L @ P[:3, :3] @ L.T + J.T @ R @ J)
_wrong("R squared", "R holds variances already: do not square it.",
       P_ll=lambda x, P, y, R, L, J: L @ P[:3, :3] @ L.T + J @ R**2 @ J.T)
_wrong("identity", "An identity says: 1 m^2 of variance, whatever the pose and the sensor.",
       P_ll=lambda x, P, y, R, L, J: np.eye(2))
_wrong("identity and zero", "An identity says: 1 m^2, whatever pose and sensor. And zero says: nothing in common with "
       "the robot.",
       P_ll=lambda x, P, y, R, L, J: np.eye(2), P_lx=lambda x, P, y, R, L, J: np.zeros((2, len(x))))
_wrong("very uncertain, and that is all", "A huge covariance must be followed by a correction with the same "
       "measurement; otherwise it is simply wrong.", P_ll=lambda x, P, y, R, L, J: 1e6 * np.eye(2),
       P_lx=lambda x, P, y, R, L, J: np.zeros((2, len(x))))
_wrong("old map forgotten", "A new landmark changes nothing between the others: the old P stays as it is.",
       old=lambda x, P, y, R, L, J: np.diag(np.diag(P)))
_wrong("sign of the cross-covariance", "If the robot is further left than it thinks, so is the landmark: plus L_r "
       "P[:3].",
       P_lx=lambda x, P, y, R, L, J: -L @ P[:3])
_wrong("landmark in the robot's frame", "That is where the robot sees it. The map wants the map frame: "
       "inverse_observation.",
       l=lambda x, P, y, R, L, J: y[0] * np.array([np.cos(y[1]), np.sin(y[1])]))
_wrong("the measurement itself", "Range and bearing are no place in the map: inverse_observation(x[:3], y) gives it.",
       l=lambda x, P, y, R, L, J: y)
# fmt: on


@augmentation.wrong(
    "double counting",
    "The measurement is used up when it has started the landmark. A correction with it again counts it twice.",
)
def _(x, P, y, R):
    new, S = augment(x, P, y, R)
    _, L_r, L_y = inverse_observation(x[:3], y)
    W, n = np.linalg.inv(L_y), len(x)
    H = np.hstack([-W @ L_r, np.zeros((2, n - 3)), W])
    K = S @ H.T @ np.linalg.inv(H @ S @ H.T + R)
    return new, S - K @ H @ S


@augmentation.wrong(
    "landmark in front", "The new landmark comes to the end of the state: the ranges of the others stay."
)
def _(x, P, y, R):
    new, S = augment(x, P, y, R)
    n = len(x)
    order = np.r_[0:3, n : n + 2, 3:n]
    return new[order], S[np.ix_(order, order)]


@augmentation.wrong("P does not grow", "P needs two rows and columns more, as x does.")
def _(x, P, y, R):
    return augment(x, P, y, R)[0], P


@augmentation.variant("one Jacobian of everything")
def _(x, P, y, R):
    n = len(x)
    l, L_r, L_y = inverse_observation(x[:3], y)
    J = np.zeros((n + 2, n + 2))
    J[:n, :n], J[n:, :3], J[n:, n:] = np.eye(n), L_r, L_y
    A = np.zeros((n + 2, n + 2))
    A[:n, :n], A[n:, n:] = P, R
    return [*x, *l], J @ A @ J.T


@augmentation.variant("start with a huge covariance, then correct with the measurement")
def _(x, P, y, R):
    n = len(x)
    l, L_r, L_y = inverse_observation(x[:3], y)
    W = np.linalg.inv(L_y)
    S = np.zeros((n + 2, n + 2))
    S[:n, :n], S[n:, n:] = P, 1e6 * np.eye(2)
    H = np.hstack([-W @ L_r, np.zeros((2, n - 3)), W])
    return np.append(x, l), S - S @ H.T @ np.linalg.solve(H @ S @ H.T + R, H @ S)


@augmentation.variant("into a matrix of zeros, lists")
def _(x, P, y, R):
    n = len(x)
    a = x[2] + y[1]
    c, s = np.cos(a), np.sin(a)
    L_r, L_y = np.array([[1, 0, -y[0] * s], [0, 1, y[0] * c]]), np.array([[c, -y[0] * s], [s, y[0] * c]])
    S = np.zeros((n + 2, n + 2))
    S[:n, :n] = P
    S[:n, n:] = P[:, :3] @ L_r.T
    S[n:, :n] = S[:n, n:].T
    S[n:, n:] = L_r @ P[:3, :3] @ L_r.T + L_y @ R @ L_y.T
    return [*x, x[0] + y[0] * c, x[1] + y[0] * s], S.tolist()
