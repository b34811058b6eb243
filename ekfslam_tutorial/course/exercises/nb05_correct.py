"""Exercise 05.3: the correction of the whole state by one measurement."""

import numpy as np

from ...geometry import wrap
from .. import expect
from ..exercise import Exercise
from .nb04_blocks import random_covariance
from .nb05_observe import case as state_with_landmark
from .nb05_observe import observe
from .nb05_predict import heading_wrapped, two


def correct(x, P, y, R, e, H):
    """Correct the whole state with one measurement of range and bearing.

    x, shape (n,), and P, shape (n, n): joint state, the robot's pose first, and its covariance.
    y = [range, bearing]: the measurement; R, shape (2, 2): its covariance.
    e, shape (2,), and H, shape (2, n): the expected measurement and its derivative by x. The bearings in y and e
    may be several whole turns apart.
    Return the new x and P. Do not change the inputs.
    """
    z = np.array([y[0] - e[0], wrap(y[1] - e[1])])
    PHt = P @ H.T
    Z = H @ PHt + R
    K = np.linalg.solve(Z, PHt.T).T
    x = x + K @ z
    P = P - K @ Z @ K.T
    return x, P


correction = Exercise(
    "05.3",
    "Correct",
    correct,
    canonical=heading_wrapped,
    hints=(
        "Innovation z = y - e, its covariance Z, the gain K, then x and P: five lines, for the whole state at once.",
        "Z = H P H' + R and K = P H' inv(Z). The second number of z is an angle.",
        "z = [y[0] - e[0], wrap(y[1] - e[1])]; x + K z; P - K Z K', which is (I - K H) P.",
    ),
)


def case(rng, n=9, at=5, scale=0.01, z=None):
    """Return the arguments of `correct`: a state, and a measurement of one landmark that is off by z."""
    x, l = state_with_landmark(rng, n, at)
    e, H = observe(x, l)
    y = e + (rng.normal(size=2) * [0.2, 0.1] if z is None else np.asarray(z))
    y[1] = wrap(y[1])
    return x, random_covariance(rng, n, scale), y, random_covariance(rng, 2, 0.02), e, H


def textbook(x, P, y, R, e, H):
    """The corrected mean and covariance by adding information."""
    W = np.linalg.solve(R, H)
    new = np.linalg.inv(np.linalg.inv(P) + H.T @ W)
    return x + new @ W.T @ np.array([y[0] - e[0], wrap(y[1] - e[1])]), new


def _mean(f, c, what, at="", rtol=1e-4):
    got, want = two(f(*c), len(c[0]))[0], textbook(*c)[0]
    pose, where = np.r_[0:2, 3 : len(want)], f" {at}" if at else ""
    expect.close(got[pose], want[pose], f"{what}, without the heading,{where}", rtol, 1e-7)
    expect.angle(got[2], want[2], f"the heading{where}")


@correction.link("two results", "The function must end with `return x, P`.")
def _(f, rng):
    for n, at in ((9, 5), (5, 3), (13, 11)):
        two(f(*case(rng, n, at)), n)


@correction.link("no surprise, no change", "If the measurement is exactly as expected, x stays as it is.", part=0)
def _(f, rng):
    _mean(f, case(rng, z=[0, 0]), "x", "after a measurement that is exactly as expected")


@correction.link("the mean", "x + K z with K = P H' inv(H P H' + R): the whole state, not a part of it.", part=0)
def _(f, rng):
    for n, at, scale in ((9, 5, 0.01), (5, 3, 1.0), (9, 7, 0.01), (13, 3, 1e-4)):
        _mean(f, case(rng, n, at, scale), "x")


@correction.link("the seam", "At +-pi a small difference of bearings looks large: wrap the second number of z.", part=0)
def _(f, rng):
    for expected, measured in (
        (np.pi + 0.02, -np.pi + 0.01),
        (np.pi - 0.02, -np.pi + 0.03),
        (-np.pi + 0.02, np.pi - 0.03),
    ):
        x, P, y, R, e, H = case(rng)
        e[1], y[1] = expected, measured
        _mean(f, (x, P, y, R, e, H), "x", "across the seam")


@correction.link("whole turns", "A bearing of 350 degrees and one of -10 degrees are the same direction.", part=0)
def _(f, rng):
    for turns in (2, -2, 4):
        x, P, y, R, e, H = case(rng)
        _mean(f, (x, P, y + [0, turns * np.pi], R, e, H), "x", "after a bearing with whole turns more")


@correction.link("the range is no angle", "Only the bearing is wrapped: a range may be off by more than pi.", part=0)
def _(f, rng):
    for far in (4.0, -3.6):
        c = case(rng, scale=1.0, z=[far, 0.05])
        _mean(f, c, "x", f"after a range that is {abs(far)} m off")


@correction.link("the covariance", "P - K Z K' (or (I - K H) P, or Joseph's form), for the whole state.", part=1)
def _(f, rng):
    for n, at, scale in ((9, 5, 0.01), (5, 3, 1.0), (9, 7, 0.01), (13, 3, 1e-4)):
        c = case(rng, n, at, scale)
        expect.close(two(f(*c), n)[1], textbook(*c)[1], "P", 1e-4)


@correction.link("a covariance that shrinks", "P must stay symmetric and lose uncertainty in every direction.", part=1)
def _(f, rng):
    x, P, y, R, e, H = case(rng)
    for _ in range(10):
        new = two(f(x, P, y, R, e, H), 9)[1]
        expect.symmetric(new, "P", 1e-6)
        expect.psd(new, "P", 1e-7)
        expect.psd(P - new, "what P has lost", 1e-6)
        P = new


# ---- wrong and right answers -----------------------------------------------------------------------------------------

inv = np.linalg.inv


def _wrong(name, hint, z=None, K=None, x_of=None, P_of=None):
    """A misconception in one step: the innovation, the gain, the new mean or the new covariance."""

    @correction.wrong(name, hint)
    def _(x, P, y, R, e, H):
        v = z(y, e) if z else np.array([y[0] - e[0], wrap(y[1] - e[1])])
        Z = H @ P @ H.T + R
        G = K(P, H, R, Z) if K else P @ H.T @ inv(Z)
        new = x_of(x, G, v, H) if x_of else x + G @ v
        return new, P_of(P, G, H, R, Z) if P_of else (np.eye(len(x)) - G @ H) @ P


def _only(x, K, z, H, rows):
    new = x.copy()
    new[rows] += (K @ z)[rows]
    return new


def _seen(H):
    return np.flatnonzero(H.any(0))


def _in(P, rows):
    """P with a correction in some rows and columns only."""

    def of(P, K, H, R, Z):
        i = rows(H)
        new, full = P.copy(), P - K @ Z @ K.T
        new[np.ix_(i, i)] = full[np.ix_(i, i)]
        return new

    return of


# fmt: off
_wrong("bearing not wrapped", "3.12 and -3.12 rad are nearly the same direction: wrap the difference of the bearings.",
       z=lambda y, e: y - e)
_wrong("range wrapped, too", "The range is a distance, not an angle: wrap z[1] only.", z=lambda y, e: wrap(y - e))
_wrong("bearings wrapped, not their difference", "Wrap the difference: two wrapped angles can still be nearly 2 pi "
       "apart.",
       z=lambda y, e: np.array([y[0] - e[0], wrap(y[1]) - wrap(e[1])]))
_wrong("at most one turn", "A heading that has counted several turns puts e several turns away: one correction by 2 pi "
       "is not enough. wrap() takes off all turns.",
       z=lambda y, e: np.array([y[0] - e[0], (d := y[1] - e[1]) - 2 * np.pi * (d > np.pi) + 2 * np.pi * (d < -np.pi)]))
_wrong("wrapped to 0 ... 2 pi", "A small negative difference must stay small and negative: wrap into (-pi, pi].",
       z=lambda y, e: np.array([y[0] - e[0], (y[1] - e[1]) % (2 * np.pi)]))
_wrong("expected minus measured", "The innovation is measurement minus expectation, z = y - e, and x + K z moves "
       "towards it.",
       z=lambda y, e: np.array([e[0] - y[0], wrap(e[1] - y[1])]))
_wrong("bearing in degrees", "Angles are in radians everywhere.",
       z=lambda y, e: np.array([y[0] - e[0], np.degrees(wrap(y[1] - e[1]))]))
_wrong("measurement instead of innovation", "What moves the state is the surprise, z = y - e.", z=lambda y, e: y)
_wrong("Z without R", "The measurement has noise, too: Z = H P H' + R.", K=lambda P, H, R, Z: P @ H.T @ inv(Z - R))
_wrong("R for Z", "The gain divides by the whole uncertainty of the innovation, Z = H P H' + R, not by R alone.",
       K=lambda P, H, R, Z: P @ H.T @ inv(R))
_wrong("Z not inverted", "K = P H' inv(Z): a large uncertainty of the innovation makes a small gain.",
       K=lambda P, H, R, Z: P @ H.T @ Z)
_wrong("R squared", "R holds variances already: do not square it.", K=lambda P, H, R, Z: P @ H.T @ inv(Z - R + R**2))
_wrong("square root of R", "R holds variances, and Z = H P H' + R needs variances: no square root.",
       K=lambda P, H, R, Z: P @ H.T @ inv(Z - R + np.sqrt(np.abs(R))))
_wrong("only the diagonal of R", "Use the whole R: the noise of range and bearing may be correlated.",
       K=lambda P, H, R, Z: P @ H.T @ inv(Z - R + np.diag(np.diag(R))))
_wrong("inverse entry by entry", "inv(Z) is the inverse of a matrix, not 1 / Z for each entry.",
       K=lambda P, H, R, Z: P @ H.T @ (1 / Z))
_wrong("only the robot", "That is localisation: in SLAM the landmarks are uncertain, too. Correct the whole state.",
       x_of=lambda x, K, z, H: _only(x, K, z, H, slice(0, 3)))
_wrong("only the landmarks", "That is mapping: in SLAM the pose is uncertain, too. Correct the whole state.",
       x_of=lambda x, K, z, H: _only(x, K, z, H, slice(3, None)))
_wrong("only robot and seen landmark", "The other landmarks share errors with robot and landmark: correct the whole "
       "state. A filter that does not do so diverges.", x_of=lambda x, K, z, H: _only(x, K, z, H, _seen(H)))
_wrong("covariance unchanged", "The measurement brings information: P - K Z K'.", P_of=lambda P, K, H, R, Z: P)
_wrong("covariance added", "The measurement brings information: K Z K' is subtracted.",
       P_of=lambda P, K, H, R, Z: P + K @ Z @ K.T)
_wrong("K R K' subtracted", "P - K Z K' has the whole Z = H P H' + R in "
       "it.", P_of=lambda P, K, H, R, Z: P - K @ R @ K.T)
_wrong("K H P H' K' subtracted", "P - K Z K' has the whole Z = H P H' + R in it.",
       P_of=lambda P, K, H, R, Z: P - K @ (Z - R) @ K.T)
_wrong("half of Joseph's form", "Joseph's form has two terms: (I - K H) P (I - K H)' + K R K'.",
       P_of=lambda P, K, H, R, Z: (np.eye(len(P)) - K @ H) @ P @ (np.eye(len(P)) - K @ H).T)
_wrong("P (I - K H)", "The order matters: (I - K H) P. Yours is not symmetric.",
       P_of=lambda P, K, H, R, Z: P @ (np.eye(len(P)) - K @ H))
_wrong("only the seen block of P", "All of P changes: the other landmarks and their covariances, too.",
       P_of=_in(None, _seen))
_wrong("only the robot's block of P", "All of P changes: landmarks and covariances, too.",
       P_of=_in(None, lambda H: np.arange(3)))
_wrong("cross-covariances deleted", "A correction does not make robot and landmarks independent: keep all blocks of P.",
       P_of=lambda P, K, H, R, Z: (P - K @ Z @ K.T) * (np.kron(np.eye((len(P) + 1) // 2), np.ones((2, 2)))[1:, 1:] > 0))
# fmt: on


@correction.wrong("gain transposed", "K = P H' inv(Z) has a row for each number of the state: n x 2, not 2 x n.")
def _(x, P, y, R, e, H):
    K = (P @ H.T @ inv(H @ P @ H.T + R)).T
    return x + K @ np.array([y[0] - e[0], wrap(y[1] - e[1])]), (np.eye(len(x)) - K @ H) @ P


@correction.wrong("columns instead of vectors", "Vectors have one axis here: x has shape (n,), no columns.")
def _(x, P, y, R, e, H):
    new, P = correct(x, P, y, R, e, H)
    return new[:, None], P


@correction.variant("Joseph's form")
def _(x, P, y, R, e, H):
    K = P @ H.T @ inv(H @ P @ H.T + R)
    A = np.eye(len(x)) - K @ H
    d = y[1] - e[1]
    return x + K @ [y[0] - e[0], np.arctan2(np.sin(d), np.cos(d))], A @ P @ A.T + K @ R @ K.T


@correction.variant("by adding information, lists, heading with a turn more")
def _(x, P, y, R, e, H):
    new, P = textbook(x, P, y, R, e, H)
    new[2] += 2 * np.pi
    return list(new), P.tolist()


@correction.variant("(I - K H) P, the angle wrapped by hand")
def _(x, P, y, R, e, H):
    z = np.array(y, float) - e
    while z[1] > np.pi:
        z[1] -= 2 * np.pi
    while z[1] <= -np.pi:
        z[1] += 2 * np.pi
    K = P @ H.T @ np.linalg.pinv(H @ P @ H.T + R)
    return x + K.dot(z), (np.identity(len(x)) - K.dot(H)).dot(P)


@correction.variant("square root of Z")
def _(x, P, y, R, e, H):
    L = np.linalg.cholesky(H @ P @ H.T + R)
    W = np.linalg.solve(L, H @ P).T
    z = np.array([y[0] - e[0], (y[1] - e[1] + np.pi) % (2 * np.pi) - np.pi])
    return x + W @ np.linalg.solve(L, z), P - W @ W.T
