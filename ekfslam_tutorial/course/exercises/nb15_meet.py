"""Exercise 15.3: two robots meet. Where is the map of the second one in that of the first?"""

import numpy as np

from ...geometry import Frame2, wrap
from .. import expect
from ..exercise import Exercise


def map_in_map(F1, F2, y):
    """Where is the origin of the second robot's map in the map of the first?

    F1 is the frame of robot 1 in map 1, F2 that of robot 2 in map 2; both are Frame2. y = [r, b12, b21], shape (3,):
    the robots are r metres apart, robot 1 sees robot 2 under the bearing b12, and robot 2 sees robot 1 under b21 (rad,
    each from its own x axis, to the left).
    `F.from_frame(p)` returns the point p of the frame F in its parent, `F.compose(G)` the frame G of F in the parent
    of F, `F.inverse()` the parent in F; each is the first of several results. F.theta is the heading.
    Return [x, y, theta], shape (3,): the frame of map 2 in map 1.
    """
    r, b12, b21 = y
    p, *_ = F1.from_frame(r * np.array([np.cos(b12), np.sin(b12)]))
    theta = F1.theta + b12 + np.pi - b21
    robot2, back = Frame2(np.array([*p, theta])), F2.inverse()[0]
    return robot2.compose(back)[0].x


exercise = Exercise(
    "15.3",
    "Two maps, one meeting",
    map_in_map,
    hints=(
        "First find robot 2 in map 1: its place from r and b12, its heading from both bearings. Then go from robot 2 "
        "back to the origin of its map.",
        "Robot 2 looks back: its line of sight points the other way, theta1 + b12 + pi = theta2 + b21.",
        "theta2 = theta1 + b12 + pi - b21; robot2 = Frame2([p_x, p_y, theta2]); result robot2.compose(F2.inverse()).",
    ),
    canonical=lambda result: np.append(np.asarray(result, float)[:2], np.cos(np.asarray(result, float)[2] + [0, 1])),
)


def _frame(rng):
    return Frame2(np.array([*rng.uniform(-4, 4, 2), rng.uniform(-3, 3)]))


def case(rng, F1=None, F2=None, M=None):
    """Two maps and a meeting without noise; the answer is M."""
    M, F1, F2 = M or _frame(rng), F1 or _frame(rng), F2 or _frame(rng)
    G2 = M.compose(F2)[0]
    d = G2.t - F1.t
    there = np.arctan2(d[1], d[0])
    return F1, F2, np.array([np.hypot(*d), wrap(there - F1.theta), wrap(there + np.pi - G2.theta)]), M


def _check(f, F1, F2, y, M, at):
    got = expect.array(f(F1, F2, y), 3, "the result")
    expect.close(got[:2], M.t, "[x, y]", at=at)
    expect.angle(got[2], M.theta, "theta", at=at)


ORIGIN = Frame2(np.zeros(3))


@exercise.link("three numbers", "Return [x, y, theta].")
def _(f, rng):
    expect.array(f(*case(rng)[:3]), 3, "the result")


@exercise.link("both maps begin here", "Both robots stand at the origin of their maps: the answer is robot 2 itself.")
def _(f, rng):
    at = "both robots at the origin of their maps"
    f(*case(rng)[:3])
    _check(f, *case(rng, ORIGIN, ORIGIN, Frame2(np.array([3.0, 0, np.pi]))), at + ", face to face")
    _check(f, *case(rng, ORIGIN, ORIGIN, Frame2(np.array([2.0, 1, 0]))), at + ", same heading")
    _check(f, *case(rng, ORIGIN, ORIGIN), at)


@exercise.link("robot 1 anywhere", "r and b12 are in the frame of robot 1: F1.from_frame, and its heading F1.theta.")
def _(f, rng):
    for _ in range(3):
        _check(f, *case(rng, None, ORIGIN), "robot 2 at the origin of its map")


@exercise.link("robot 2 anywhere", "The origin of map 2, seen from robot 2, is F2.inverse(). Compose.")
def _(f, rng):
    _check(f, *case(rng, ORIGIN, None), "robot 1 at the origin of its map")
    for _ in range(4):
        F1, F2, y, M = case(rng)
        _check(f, F1, F2, y, M, f"y = {y.round(2)}")


def _robot2(F1, y, theta):
    p = F1.from_frame(y[0] * np.array([np.cos(y[1]), np.sin(y[1])]))[0]
    return Frame2(np.array([*p, theta]))


def _wrong(name, hint, theta=None, place=None, end=None):
    """A misconception in the heading, the place of robot 2, or the last step."""

    @exercise.wrong(name, hint)
    def _(F1, F2, y):
        angle = theta(F1, y) if theta else F1.theta + y[1] + np.pi - y[2]
        p = place(F1, y) if place else F1.from_frame(y[0] * np.array([np.cos(y[1]), np.sin(y[1])]))[0]
        G = Frame2(np.array([*p, angle]))
        return end(F1, F2, G) if end else G.compose(F2.inverse()[0])[0].x


# fmt: off
_wrong("half a turn forgotten", "Robot 2 looks *back*: its line of sight is that of robot 1 turned by pi.",
       theta=lambda F1, y: F1.theta + y[1] - y[2])
_wrong("second bearing added", "theta2 + b21 is the direction back: so theta2 is that direction *minus* b21.",
       theta=lambda F1, y: F1.theta + y[1] + np.pi + y[2])
_wrong("first bearing subtracted", "The line of sight of robot 1 points to theta1 + b12.",
       theta=lambda F1, y: F1.theta - y[1] + np.pi - y[2])
_wrong("bearings exchanged", "b12 is what robot 1 sees: y = [r, b12, b21].",
       theta=lambda F1, y: F1.theta + y[2] + np.pi - y[1],
       place=lambda F1, y: F1.from_frame(y[0] * np.array([np.cos(y[2]), np.sin(y[2])]))[0])
_wrong("heading of robot 1 forgotten", "Bearings count from the robot's own x axis: add the heading of robot 1.",
       theta=lambda F1, y: y[1] + np.pi - y[2])
_wrong("range along the heading", "Robot 2 is r metres away in the direction b12, and not straight ahead: "
       "r [cos(b12), sin(b12)].", place=lambda F1, y: F1.from_frame(np.array([y[0], 0.0]))[0])
_wrong("heading from the first bearing only", "How robot 2 is turned is seen from *its* bearing, b21.",
       theta=lambda F1, y: F1.theta + y[1])
_wrong("place in the frame of robot 1", "r and b12 are in the frame of robot 1: F1.from_frame takes them into map 1.",
       place=lambda F1, y: y[0] * np.array([np.cos(y[1]), np.sin(y[1])]))
_wrong("place without the heading", "The bearing counts from the robot's x axis: use F1.from_frame, or add F1.theta.",
       place=lambda F1, y: F1.t + y[0] * np.array([np.cos(y[1]), np.sin(y[1])]))
_wrong("to_frame", "The place of robot 2 comes out of the frame of robot 1: from_frame.",
       place=lambda F1, y: F1.to_frame(y[0] * np.array([np.cos(y[1]), np.sin(y[1])]))[0])
_wrong("sine and cosine exchanged", "The bearing counts from the x axis: [cos, sin].",
       place=lambda F1, y: F1.from_frame(y[0] * np.array([np.sin(y[1]), np.cos(y[1])]))[0])
_wrong("robot for map", "That is robot 2 in map 1. The origin of its map is another place: compose with F2.inverse().",
       end=lambda F1, F2, G: G.x)
_wrong("F2 not inverted", "F2 goes from the map to the robot. You want the way back: F2.inverse().",
       end=lambda F1, F2, G: G.compose(F2)[0].x)
_wrong("composed in the other order", "First robot 2 in map 1, then the origin of map 2 in robot 2: robot2.compose.",
       end=lambda F1, F2, G: F2.inverse()[0].compose(G)[0].x)
_wrong("map 1 in map 2", "That is the inverse of what is asked: map 2 in map 1.",
       end=lambda F1, F2, G: G.compose(F2.inverse()[0])[0].inverse()[0].x)
_wrong("poses subtracted", "Frames are composed, not subtracted: the place of F2 must be turned, too.",
       end=lambda F1, F2, G: G.x - F2.x)
# fmt: on


@exercise.variant("rotation matrices, a list")
def _(F1, F2, y):
    r, b12, b21 = (float(v) for v in y)
    a = F1.theta + b12
    theta = a + np.pi - b21 - F2.theta
    R = np.array([[np.cos(theta), -np.sin(theta)], [np.sin(theta), np.cos(theta)]])
    return [*(F1.t + r * np.array([np.cos(a), np.sin(a)]) - R @ F2.t), theta + 2 * np.pi]


@exercise.variant("complex numbers")
def _(F1, F2, y):
    one, turn = complex(*F1.t), np.exp(1j * (F1.theta + y[1] - y[2] - F2.theta))
    place = one + y[0] * np.exp(1j * (F1.theta + y[1])) + turn * complex(*F2.t)
    return np.array([place.real, place.imag, np.angle(-turn)])
