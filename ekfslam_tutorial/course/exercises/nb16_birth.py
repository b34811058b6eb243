"""Exercise 16.3: a range and an assumed bearing make a landmark."""

import numpy as np

from .. import expect
from ..exercise import Exercise
from .nb04_blocks import random_covariance


def hypothesis(x, P, r, var, beta, N):
    """One hypothesis of where a beacon is: the inverse model of a range, with a prior for what it leaves open.

    x = [x; y; theta], shape (3,), is the pose of the robot (m, rad) and P, shape (3, 3), its covariance. r (m) is a
    measured range with the variance var. The range says nothing of the bearing: beta (rad, from the robot's x axis) is
    assumed, with the variance N.
    Return the point p, shape (2,), in the world, its covariance P_pp, shape (2, 2), and its covariance with the robot
    P_px, shape (2, 3).
    """
    c, s = np.cos(x[2] + beta), np.sin(x[2] + beta)
    p = x[:2] + r * np.array([c, s])
    P_x = np.array([[1.0, 0.0, -r * s], [0.0, 1.0, r * c]])  # dp/dx
    P_r, P_beta = np.array([c, s]), r * np.array([-s, c])  # dp/dr, dp/dbeta
    P_pp = P_x @ P @ P_x.T + var * np.outer(P_r, P_r) + N * np.outer(P_beta, P_beta)
    return p, P_pp, P_x @ P


born = Exercise(
    "16.3",
    "A range and a prior make a point",
    hypothesis,
    hints=(
        "p = [x, y] + r [cos(theta + beta), sin(theta + beta)]. Uncertain in it: the pose, the range, the bearing.",
        "One Jacobian for each: by the pose (2 x 3), by r: m = [c, s], by beta: r [-s, c]. Each makes a term of P_pp.",
        "P_pp = P_x P P_x' + m var m' + (r m') N (r m')', with m' = [-s, c]; P_px = P_x P.",
    ),
)


def case(rng, scale=1.0):
    """A pose with a full covariance, a range, an assumed bearing, and their variances."""
    x = np.array([*rng.uniform(-5, 5, 2), rng.uniform(-3, 3)])
    P = random_covariance(rng, 3, 0.3 * scale)
    return (
        x,
        P,
        rng.uniform(1, 6),
        (0.1 * scale) ** 2 * rng.uniform(0.5, 2),
        rng.uniform(-3, 3),
        rng.uniform(0.01, 0.09),
    )


def _three(result):
    p, P_pp, P_px = expect.results(result, "p", "P_pp", "P_px")
    return expect.array(p, 2, "p"), expect.array(P_pp, (2, 2), "P_pp"), expect.array(P_px, (2, 3), "P_px")


@born.link("three results", "The function must end with `return p, P_pp, P_px`.")
def _(f, rng):
    _three(f(*case(rng)))


@born.link("the point", "From the robot, r metres in the direction theta + beta.", part=0)
def _(f, rng):
    for _ in range(3):
        args = case(rng)
        expect.close(_three(f(*args))[0], hypothesis(*args)[0], "p", at=f"theta {args[0][2]:.2f}, beta {args[4]:.2f}")


@born.link("pose and range known", "Then only the prior is left: the point is uncertain *across* the line of sight.", 1)
def _(f, rng):
    for _ in range(2):
        x, P, r, _, beta, N = case(rng)
        args = (x, 0 * P, r, 0.0, beta, N)
        expect.close(_three(f(*args))[1], hypothesis(*args)[1], "P_pp", at="P = 0 and var = 0")


@born.link(
    "pose and bearing known", "Then only the range is left: the point is uncertain *along* the line of sight.", 1
)
def _(f, rng):
    for _ in range(2):
        x, P, r, var, beta, _ = case(rng)
        args = (x, 0 * P, r, var, beta, 0.0)
        expect.close(_three(f(*args))[1], hypothesis(*args)[1], "P_pp", at="P = 0 and N = 0")


@born.link("covariance with the robot", "Error of the pose in, error of the point out: P_px = P_x P.", part=2)
def _(f, rng):
    for scale in (1.0, 0.1):
        args = case(rng, scale)
        expect.close(_three(f(*args))[2], hypothesis(*args)[2], "P_px")


@born.link("own covariance", "Three causes of error, three terms: pose, range, prior of the bearing.", part=1)
def _(f, rng):
    for scale in (1.0, 0.1, 3.0):
        args = case(rng, scale)
        P_pp = _three(f(*args))[1]
        expect.close(P_pp, hypothesis(*args)[1], "P_pp")
        expect.symmetric(P_pp, "P_pp", 1e-7)


def _wrong(name, hint, change):
    """A misconception: change(d) returns p, P_pp, P_px, from the right parts."""

    @born.wrong(name, hint)
    def _(x, P, r, var, beta, N):
        a = x[2] + beta
        m, n = np.array([np.cos(a), np.sin(a)]), np.array([-np.sin(a), np.cos(a)])
        P_x = np.column_stack([np.eye(2), r * n])
        own = [P_x @ P @ P_x.T, var * np.outer(m, m), N * r**2 * np.outer(n, n)]
        return change(dict(x=x, P=P, r=r, var=var, beta=beta, N=N, m=m, n=n, P_x=P_x, own=own, p=x[:2] + r * m))


def _pp(d, *terms):
    return d["p"], sum(terms), d["P_x"] @ d["P"]


def _turned(d, a):
    """The point in another direction, with the right covariances."""
    return d["x"][:2] + d["r"] * np.array([np.cos(a), np.sin(a)]), sum(d["own"]), d["P_x"] @ d["P"]


def _bare_heading(d):
    """The third column of P_x without the range."""
    J = np.column_stack([np.eye(2), d["n"]])
    return d["p"], J @ d["P"] @ J.T + d["own"][1] + d["own"][2], J @ d["P"]


I2 = np.column_stack([np.eye(2), np.zeros(2)])
# fmt: off
_wrong("heading forgotten", "beta is counted from the robot's x axis. In the world the direction is theta + beta.",
       lambda d: _turned(d, d["beta"]))
_wrong("heading subtracted", "From the robot into the world: theta + beta, with a plus.",
       lambda d: _turned(d, d["beta"] - d["x"][2]))
_wrong("left in the robot's frame", "Add the position of the robot.",
       lambda d: (d["r"] * d["m"], sum(d["own"]), d["P_x"] @ d["P"]))
_wrong("sine and cosine swapped", "x goes with the cosine, y with the sine.",
       lambda d: (d["x"][:2] + d["r"] * d["m"][::-1], sum(d["own"]), d["P_x"] @ d["P"]))
_wrong("prior forgotten", "Without the term of N the filter believes that it has measured the bearing.",
       lambda d: _pp(d, d["own"][0], d["own"][1]))
_wrong("angle for a length", "An angle is no length: across the line of sight it makes r times the angle, so r^2 N.",
       lambda d: _pp(d, d["own"][0], d["own"][1], d["N"] * np.outer(d["n"], d["n"])))
_wrong("range once", "The variance goes with the *square* of the Jacobian: r^2 N, not r N.",
       lambda d: _pp(d, d["own"][0], d["own"][1], d["N"] * d["r"] * np.outer(d["n"], d["n"])))
_wrong("N as a standard deviation", "N is a variance already: do not square it.",
       lambda d: _pp(d, d["own"][0], d["own"][1], d["N"] * d["own"][2]))
_wrong("range noise forgotten", "The range is noisy, too: its variance lies along the line of sight.",
       lambda d: _pp(d, d["own"][0], d["own"][2]))
_wrong("var as a standard deviation", "var is a variance already: do not square it.",
       lambda d: _pp(d, d["own"][0], d["var"] * d["own"][1], d["own"][2]))
_wrong("along and across swapped", "The range is known *along* the line of sight, the bearing is open *across* it.",
       lambda d: _pp(d, d["own"][0], d["var"] * np.outer(d["n"], d["n"]),
                     d["N"] * d["r"]**2 * np.outer(d["m"], d["m"])))
_wrong("pose taken as known", "That is the formula of mapping. The pose is uncertain: P_x P P_x' belongs into P_pp, "
       "and P_px = P_x P.", lambda d: (d["p"], d["own"][1] + d["own"][2], 0 * d["P_x"]))
_wrong("pose forgotten in P_pp", "P_px is there, but P_pp lacks the error of the pose: P_x P P_x'.",
       lambda d: _pp(d, d["own"][1], d["own"][2]))
_wrong("zero cross-covariance", "The point is made from the robot's pose: their errors hang together, P_px = P_x P.",
       lambda d: (d["p"], sum(d["own"]), 0 * d["P_x"]))
_wrong("heading taken as known", "A wrong heading turns the point round the robot: the third column of P_x is "
       "r [-s, c].", lambda d: (d["p"], I2 @ d["P"] @ I2.T + d["own"][1] + d["own"][2], I2 @ d["P"]))
_wrong("heading column without the range", "An angle is no length: a wrong heading moves the point by r times it. "
       "The third column of P_x is r [-s, c].", _bare_heading)
_wrong("P_x instead of P_px", "A Jacobian is not a covariance: P_px = P_x P.",
       lambda d: (d["p"], sum(d["own"]), d["P_x"]))
_wrong("P_xp", "P_px has the point in its rows: shape (2, 3).",
       lambda d: (d["p"], sum(d["own"]), (d["P_x"] @ d["P"]).T))
# fmt: on


@born.variant("one big Jacobian")
def _(x, P, r, var, beta, N):
    a = x[2] + beta
    m, n = np.array([np.cos(a), np.sin(a)]), np.array([-np.sin(a), np.cos(a)])
    J = np.column_stack([np.eye(2), r * n, m, r * n])
    C = np.zeros((5, 5))
    C[:3, :3], C[3, 3], C[4, 4] = P, var, N
    return (x[:2] + r * m).tolist(), J @ C @ J.T, (J @ C)[:, :3]


@born.variant("by rotation matrices")
def _(x, P, r, var, beta, N):
    def R(a):
        return np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]])

    p = R(x[2]) @ R(beta) @ [r, 0.0]
    J = np.array([[1, 0, -p[1]], [0, 1, p[0]]])
    return x[:2] + p, R(x[2] + beta) @ np.diag([var, r * r * N]) @ R(x[2] + beta).T + J @ P @ J.T, J @ P
