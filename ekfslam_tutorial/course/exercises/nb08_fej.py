"""Exercise 08.2: a correction with first-estimates Jacobians."""

import numpy as np

from ...geometry import Frame2, wrap
from ...models.sensors.range_bearing import polar
from .. import expect
from ..exercise import Exercise
from .nb04_blocks import random_covariance


def observe(x, i):
    """Expected measurement [range, bearing] of landmark i, shape (2,), and its Jacobian, shape (2, n).

    x, shape (n,): the robot's pose [x, y, theta], then the landmarks, two numbers each; i counts from 0.
    """
    l = slice(3 + 2 * i, 5 + 2 * i)
    p, P_r, P_l = Frame2(x[:3]).to_frame(x[l])
    e, E_p = polar(p)
    H = np.zeros((2, len(x)))
    H[:, :3], H[:, l] = E_p @ P_r, E_p @ P_l
    return e, H


def correct_fej(x, P, y, i, x_first, R):
    """Correct the joint state with first-estimates Jacobians.

    x, shape (n,): the robot's pose [x, y, theta], then the landmarks; P, shape (n, n): its covariance.
    y = [range, bearing] of landmark i (counted from 0); R, shape (2, 2): its covariance.
    x_first, shape (n,): the first estimates, where the Jacobian is taken. observe(x, i) returns e and H at x.
    Return the new x and P.
    """
    e, _ = observe(x, i)
    _, H = observe(x_first, i)
    z = np.array([y[0] - e[0], wrap(y[1] - e[1])])
    Z = H @ P @ H.T + R
    K = np.linalg.solve(Z, H @ P).T
    return x + K @ z, P - K @ Z @ K.T


def heading_wrapped(result):
    """Results (x, P) with the heading in (-pi, pi], to compare answers that differ by whole turns."""
    x, P = result
    x = np.array(x, float)
    x[2] = wrap(x[2])
    return x, P


fej = Exercise(
    "08.2",
    "First-estimates Jacobians",
    correct_fej,
    canonical=heading_wrapped,
    hints=(
        "Only one thing differs from the ordinary correction: *where* the Jacobian H is taken. What stays as it was?",
        "Two calls of observe: the expectation e at the present x, the Jacobian H at x_first.",
        "z = y - e with the bearing wrapped, Z = H P H' + R, K = P H' inv(Z); x + K z, and (I - K H) P.",
    ),
)


def case(rng, n=2, i=None):
    """Return the arguments at random; the first estimates are close to x, but clearly others."""
    x_first = np.concatenate([rng.uniform(-1, 1, 2), [rng.uniform(-3, 3)], rng.uniform(3, 9, 2 * n)])
    P = random_covariance(rng, 3 + 2 * n, 0.05)
    x = x_first + rng.uniform(0.1, 0.4, len(x_first)) * rng.choice([-1, 1], len(x_first))
    i = int(rng.integers(n)) if i is None else i
    R = random_covariance(rng, 2, 0.02)
    y = observe(x, i)[0] + rng.normal(size=2) * [0.3, 0.1]
    return x, P, np.array([y[0], wrap(y[1])]), i, x_first, R


def two(result, n):
    """Return the results x and P as arrays."""
    x, P = expect.results(result, "x", "P")
    return expect.array(x, n, "x"), expect.array(P, (n, n), "P")


def _ekf(x, P, y, i, x_first, R, H_at=None, e_at=None):
    """Correction with the Jacobian and the expectation at any two places."""
    H = observe(x_first if H_at is None else H_at, i)[1]
    e = observe(x if e_at is None else e_at, i)[0]
    z = np.array([y[0] - e[0], wrap(y[1] - e[1])])
    K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
    return x + K @ z, (np.eye(len(x)) - K @ H) @ P


def _same(got, want, what):
    expect.close(got[0][[0, 1, *range(3, len(want[0]))]], want[0][[0, 1, *range(3, len(want[0]))]], f"x {what}", 1e-5)
    expect.angle(got[0][2], want[0][2], f"the heading {what}", 1e-5)
    expect.close(got[1], want[1], f"P {what}", 1e-5)


@fej.link("two results", "The function must end with `return x, P`.")
def _(f, rng):
    for n in (1, 2, 4):
        two(f(*case(rng, n)), 3 + 2 * n)


@fej.link("first estimate = estimate", "If x_first is x, this is the ordinary EKF correction.")
def _(f, rng):
    for n in (2, 1, 3):
        x, P, y, i, _, R = case(rng, n)
        _same(two(f(x, P, y, i, x, R), 3 + 2 * n), _ekf(x, P, y, i, x, R), "where x_first = x")


@fej.link("no innovation, no change", "Where y is what x makes us expect, the mean must not move.", part=0)
def _(f, rng):
    for _ in range(3):
        x, P, _, i, x_first, R = case(rng)
        got = two(f(x, P, observe(x, i)[0], i, x_first, R), len(x))[0]
        expect.close(np.delete(got, 2), np.delete(x, 2), "x (without the heading) after an expected measurement", 1e-6)
        expect.angle(got[2], x[2], "the heading after an expected measurement")


@fej.link("covariance", "H is taken at x_first, and H alone decides what happens to P.", part=1)
def _(f, rng):
    for n in (1, 2, 3):
        c = case(rng, n)
        expect.close(two(f(*c), 3 + 2 * n)[1], _ekf(*c)[1], "P", 1e-5)


@fej.link("mean", "e is taken at x: the innovation is what it always was. The gain comes from x_first.", part=0)
def _(f, rng):
    for n in (1, 2, 3):
        c = case(rng, n)
        got, want = two(f(*c), 3 + 2 * n), _ekf(*c)
        _same((got[0], want[1]), want, "after the correction")


@fej.link("seam of the bearing", "A landmark behind the robot: the bearing innovation must be wrapped.", part=0)
def _(f, rng):
    for side in (-1, 1):
        x, P, y, i, x_first, R = case(rng, 2, 1)
        back = np.arctan2(*(x[5:7] - x[:2])[::-1]) + np.pi - side * 0.02
        x_first[2] += back - x[2]
        x[2] = back
        y = np.array([observe(x, 1)[0][0] + 0.1, wrap(observe(x, 1)[0][1] + side * 0.05)])
        got, want = two(f(x, P, y, i, x_first, R), 7), _ekf(x, P, y, i, x_first, R)
        _same((got[0], want[1]), want, "for a landmark behind the robot")


@fej.link("a robot that stands still", "Heading sigma 30 degrees before, 30 degrees after: nothing tells the heading.")
def _(f, rng):
    std = np.radians(30)
    x, P, R = born(rng, std)
    x_first = x.copy()
    for _ in range(20):
        y = np.array([8.0, 0.2]) + rng.normal(size=2) * np.sqrt(np.diag(R))
        x, P = two(f(x, P, y, 0, x_first, R), 5)
        x[2] = wrap(x[2])
    sigma = np.degrees(np.sqrt(P[2, 2]))
    expect.true(abs(sigma - 30) < 0.01, f"the heading sigma is {sigma:.1f} degrees after 20 sights, it was 30")
    expect.symmetric(P, "P", 1e-6)


def born(rng, std):
    """One landmark, just seen for the first time by a robot whose heading is uncertain."""
    y, R, theta = np.array([8.0, 0.2]), np.diag([0.1, np.radians(1)]) ** 2, float(rng.normal() * std)
    c, s = np.cos(theta + y[1]), np.sin(theta + y[1])
    L_r, L_y = y[0] * np.array([[0, 0, -s], [0, 0, c]]), np.array([[c, -y[0] * s], [s, y[0] * c]])
    L_r[:, :2] = np.eye(2)
    P_rr = np.diag([0, 0, std**2])
    P = np.block([[P_rr, P_rr @ L_r.T], [L_r @ P_rr, L_r @ P_rr @ L_r.T + L_y @ R @ L_y.T]])
    return np.array([0, 0, theta, y[0] * c, y[0] * s]), P, R


# ---- wrong and right answers -----------------------------------------------------------------------------------------


@fej.wrong("ordinary EKF", "You take H at the present estimate. That is the ordinary EKF: take H at x_first.")
def _(x, P, y, i, x_first, R):
    return _ekf(x, P, y, i, x_first, R, H_at=x)


@fej.wrong(
    "all at the first estimate", "The expectation e belongs to the present x. Only the Jacobian is taken at x_first."
)
def _(x, P, y, i, x_first, R):
    return _ekf(x, P, y, i, x_first, R, e_at=x_first)


@fej.wrong("the two places swapped", "It is the other way round: e at the present x, H at x_first.")
def _(x, P, y, i, x_first, R):
    return _ekf(x, P, y, i, x_first, R, H_at=x, e_at=x_first)


@fej.wrong(
    "first estimate of the robot only", "The landmark, too, is taken at its first estimate: H at the whole x_first."
)
def _(x, P, y, i, x_first, R):
    return _ekf(x, P, y, i, x_first, R, H_at=np.concatenate([x_first[:3], x[3:]]))


@fej.wrong(
    "first estimate of the landmark only", "The pose, too, is taken at its first estimate: H at the whole x_first."
)
def _(x, P, y, i, x_first, R):
    return _ekf(x, P, y, i, x_first, R, H_at=np.concatenate([x[:3], x_first[3:]]))


@fej.wrong("correction added to x_first", "Add the correction to the present x: x + K z.")
def _(x, P, y, i, x_first, R):
    new, P = _ekf(x, P, y, i, x_first, R)
    return new - x + x_first, P


@fej.wrong("bearing not wrapped", "Near the seam y and e may differ by 2 pi: wrap the bearing of z.")
def _(x, P, y, i, x_first, R):
    H, z = observe(x_first, i)[1], y - observe(x, i)[0]
    K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
    return x + K @ z, (np.eye(len(x)) - K @ H) @ P


@fej.wrong("innovation with the wrong sign", "The innovation is measured minus expected: z = y - e.")
def _(x, P, y, i, x_first, R):
    new, P = _ekf(x, P, y, i, x_first, R)
    return 2 * x - new, P


@fej.wrong("R forgotten in Z", "Z = H P H' + R: the noise of the measurement is missing.")
def _(x, P, y, i, x_first, R):
    return _ekf(x, P, y, i, x_first, 0 * R)


@fej.wrong("R squared", "R holds variances already: do not square it.")
def _(x, P, y, i, x_first, R):
    return _ekf(x, P, y, i, x_first, R @ R)


@fej.wrong("covariance not corrected", "P shrinks in a correction: (I - K H) P.")
def _(x, P, y, i, x_first, R):
    return _ekf(x, P, y, i, x_first, R)[0], P


@fej.wrong("always the first landmark", "y belongs to landmark i: observe(..., i).")
def _(x, P, y, i, x_first, R):
    return _ekf(x, P, y, 0, x_first, R)


@fej.wrong("gain at x, covariance at x_first", "One H, taken at x_first, for the gain and for the covariance.")
def _(x, P, y, i, x_first, R):
    return _ekf(x, P, y, i, x_first, R, H_at=x)[0], _ekf(x, P, y, i, x_first, R)[1]


@fej.wrong("gain at x_first, covariance at x", "One H, taken at x_first, for the gain and for the covariance.")
def _(x, P, y, i, x_first, R):
    return _ekf(x, P, y, i, x_first, R)[0], _ekf(x, P, y, i, x_first, R, H_at=x)[1]


@fej.variant("Joseph form, whole turns added, lists")
def _(x, P, y, i, x_first, R):
    (e, _), (_, H) = observe(x, i), observe(x_first, i)
    z = [y[0] - e[0], np.arctan2(np.sin(y[1] - e[1]), np.cos(y[1] - e[1]))]
    K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
    A = np.eye(len(x)) - K @ H
    new = x + K @ z
    return [*new[:2], new[2] + 2 * np.pi, *new[3:]], (A @ P @ A.T + K @ R @ K.T).tolist()


@fej.variant("information form")
def _(x, P, y, i, x_first, R):
    e, H = observe(x, i)[0], observe(x_first, i)[1]
    z = np.subtract(y, e)
    z[1] = (z[1] + np.pi) % (2 * np.pi) - np.pi
    A = np.eye(len(x)) + P @ H.T @ np.linalg.solve(R, H)
    P = np.linalg.solve(A, P)
    return x + P @ H.T @ np.linalg.solve(R, z), 0.5 * (P + P.T)


@fej.variant("by the blocks of the package")
def _(x, P, y, i, x_first, R):
    from ...ekf import Map, correct, covariance, cross, innovation
    from ...models.sensors import RangeBearing

    map = Map()
    map.add(x, P)
    H = [(slice(0, len(x)), observe(x_first, i)[1])]
    PHt = cross(map, H)
    correct(map, PHt, innovation(RangeBearing(1, 1).residual(y, observe(x, i)[0]), covariance(PHt, H), R))
    return map.x, map.P
