"""Exercise 06.4: what no measurement on the way can ever take away."""

import numpy as np

from .. import expect
from ..exercise import Exercise
from .nb04_blocks import random_covariance


def floor_of(P_0, x_0, l):
    """Covariance of a landmark if the map is perfect, but for the first pose: no landmark can be better.

    P_0, shape (3, 3): covariance of the first pose x_0 = [x, y, theta].
    l, shape (2,): the landmark. Seen from the first pose its place is known exactly; the first pose is not.
    Return the covariance of l in the world, shape (2, 2).
    """
    J = np.array([[1, 0, -(l[1] - x_0[1])], [0, 1, l[0] - x_0[0]]])
    return J @ P_0 @ J.T


floor = Exercise(
    "06.4",
    "The floor",
    floor_of,
    hints=(
        "l = t_0 + R(theta_0) m, where m is the place of the landmark seen from the first pose: m is exact. How does l "
        "move if x_0, y_0 or theta_0 changes a little?",
        "Shift the first pose: the landmark shifts with it. Turn the first pose by a small angle: the landmark moves "
        "on a circle round the first position, across the line to it.",
        "J = [[1, 0, -(l_y - y_0)], [0, 1, l_x - x_0]], and the floor is J P_0 J'.",
    ),
)


def _case(rng, scale=1.0):
    x_0 = rng.uniform([-5, -5, -3], [5, 5, 3])
    return random_covariance(rng, 3, 0.1 * scale), x_0, x_0[:2] + rng.uniform(2, 8, 2) * rng.choice([-1, 1], 2)


def _out(result):
    return expect.array(result, (2, 2), "the floor")


def _truth(P_0, x_0, l):
    c, s = np.cos(x_0[2]), np.sin(x_0[2])
    m = np.array([[c, s], [-s, c]]) @ (l - x_0[:2])  # seen from the first pose
    J = np.array([[1, 0, -s * m[0] - c * m[1]], [0, 1, c * m[0] - s * m[1]]])
    return J @ P_0 @ J.T


@floor.link("shape", "The floor is the covariance of the two numbers of the landmark.")
def _(f, rng):
    _out(f(*_case(rng)))


@floor.link("heading exact", "If the first heading is exact, the whole map is shifted with the first position.")
def _(f, rng):
    P_0, x_0, l = _case(rng)
    P_0[2], P_0[:, 2] = 0, 0
    expect.close(_out(f(P_0, x_0, l)), P_0[:2, :2], "the floor for an exact first heading")


@floor.link(
    "position exact", "A wrong heading moves a landmark across the line to it, by the angle times the distance."
)
def _(f, rng):
    P_0, x_0 = np.diag([0, 0, 0.04]), np.array([1.0, 2.0, 0.7])
    for l, want in (
        ([6, 2], [[0, 0], [0, 1.0]]),
        ([1, 7], [[1.0, 0], [0, 0]]),
        ([4, 6], [[0.64, -0.48], [-0.48, 0.36]]),
    ):
        got = _out(f(P_0, x_0, np.array(l, float)))
        expect.close(got, want, "the floor for an exact first position", at=f"first pose [1, 2, 0.7], landmark {l}")


@floor.link("the general case", "How does l change with each of the three numbers of the first pose? That is J.")
def _(f, rng):
    for scale in (1.0, 1.0, 1e-4):
        P_0, x_0, l = _case(rng, scale)
        expect.close(_out(f(P_0, x_0, l)), _truth(P_0, x_0, l), "the floor", 1e-4)


@floor.link("at the start", "A landmark at the first position feels no rotation.")
def _(f, rng):
    P_0, x_0, _ = _case(rng)
    expect.close(_out(f(P_0, x_0, x_0[:2].copy())), P_0[:2, :2], "the floor of a landmark at the first position")


@floor.link("a covariance", "The floor must be symmetric and without negative eigenvalues.")
def _(f, rng):
    F = _out(f(*_case(rng)))
    expect.symmetric(F, "the floor", 1e-6)
    expect.psd(F, "the floor")


def _wrong(name, hint, J=None, answer=None):
    def from_jacobian(P_0, x_0, l):
        assert J is not None
        M = np.array(J(*x_0, *l), float)
        return M @ P_0 @ M.T

    floor.wrong(name, hint)(answer or from_jacobian)


# fmt: off
_wrong("heading forgotten", "The first heading is uncertain, too: it turns the whole map round the first position.",
       J=lambda x, y, t, a, b: [[1, 0, 0], [0, 1, 0]])
_wrong("no correlation with the heading", "P_0 has covariances between position and heading: use the whole P_0.",
       answer=lambda P, x, l: _truth(P * [[1, 1, 0], [1, 1, 0], [0, 0, 1]], x, l))
_wrong("diagonal of P_0 only", "P_0 has covariances, too: use the whole P_0.",
       answer=lambda P, x, l: _truth(np.diag(np.diag(P)), x, l))
_wrong("turned round the origin", "A wrong first heading turns the map round the first *position*, not round the "
       "origin: use l - t_0.", J=lambda x, y, t, a, b: [[1, 0, -b], [0, 1, a]])
_wrong("sign of the rotation", "Turned to the left, a landmark ahead moves to the left: d(l)/d(theta) is "
       "[-(l_y - y_0), l_x - x_0].", J=lambda x, y, t, a, b: [[1, 0, b - y], [0, 1, -(a - x)]])
_wrong("moved along the line", "A rotation moves the landmark *across* the line to it: swap the two entries, and mind "
       "the sign.", J=lambda x, y, t, a, b: [[1, 0, a - x], [0, 1, b - y]])
_wrong("one sign of the rotation", "d(l)/d(theta) = [-(l_y - y_0), l_x - x_0]: the first entry has a minus.",
       J=lambda x, y, t, a, b: [[1, 0, b - y], [0, 1, a - x]])
_wrong("position forgotten", "The first position is uncertain, too: the map shifts with it.",
       J=lambda x, y, t, a, b: [[0, 0, -(b - y)], [0, 0, a - x]])
_wrong("the position in the robot's frame", "P_0 is in world coordinates already: shift the first pose by 1 m in x, "
       "and the landmark shifts by 1 m in x.",
       J=lambda x, y, t, a, b: [[np.cos(t), -np.sin(t), -(b - y)], [np.sin(t), np.cos(t), a - x]])
_wrong("sigma of the heading in degrees", "P_0 holds rad^2 already: no conversion.",
       J=lambda x, y, t, a, b: [[1, 0, -np.degrees(b - y)], [0, 1, np.degrees(a - x)]])
_wrong("distance instead of components", "The movement has a direction: -(l_y - y_0) in x and l_x - x_0 in y.",
       J=lambda x, y, t, a, b: [[1, 0, np.hypot(a - x, b - y)], [0, 1, np.hypot(a - x, b - y)]])
_wrong("no distance", "A heading error of 1 degree moves a far landmark more than a near one: the distance is missing.",
       J=lambda x, y, t, a, b: [[1, 0, -(b - y) / np.hypot(a - x, b - y)], [0, 1, (a - x) / np.hypot(a - x, b - y)]])
# fmt: on


@floor.variant("with the frame's own derivatives")
def _(P_0, x_0, l):
    m = np.array([[np.cos(x_0[2]), np.sin(x_0[2])], [-np.sin(x_0[2]), np.cos(x_0[2])]]) @ (l - x_0[:2])
    dR = np.array([[-np.sin(x_0[2]), -np.cos(x_0[2])], [np.cos(x_0[2]), -np.sin(x_0[2])]])
    J = np.column_stack([np.eye(2), dR @ m])
    return J @ P_0 @ J.T


@floor.variant("written out, lists")
def _(P_0, x_0, l):
    u, v = -(l[1] - x_0[1]), l[0] - x_0[0]
    a = P_0[0][0] + 2 * u * P_0[0][2] + u * u * P_0[2][2]
    b = P_0[0][1] + u * P_0[1][2] + v * P_0[0][2] + u * v * P_0[2][2]
    c = P_0[1][1] + 2 * v * P_0[1][2] + v * v * P_0[2][2]
    return [[a, b], [b, c]]
