"""Exercise 15.3: two robots meet. Where is the map of the second one in that of the first?"""

import numpy as np

from ...geometry import Frame2, wrap
from ..table import table


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


ORIGIN = Frame2(np.zeros(3))


def case(rng, F1=None, F2=None, M=None):
    """Two maps and a meeting without noise; the answer is M."""
    M, F1, F2 = (F or Frame2(np.array([*rng.uniform(-4, 4, 2), rng.uniform(-3, 3)])) for F in (M, F1, F2))
    G2 = M.compose(F2)[0]
    d = G2.t - F1.t
    there = np.arctan2(d[1], d[0])
    return F1, F2, np.array([np.hypot(*d), wrap(there - F1.theta), wrap(there + np.pi - G2.theta)])


exercise = table(
    "15.3 Two maps, one meeting",
    map_in_map,
    hints=(
        "First find robot 2 in map 1: its place from r and b12, its heading from both bearings. Then go from robot 2 back to the origin of its map.",
        "Robot 2 looks back: its line of sight points the other way, theta1 + b12 + pi = theta2 + b21.",
        "theta2 = theta1 + b12 + pi - b21; robot2 = Frame2([p_x, p_y, theta2]); result robot2.compose(F2.inverse()).",
    ),
    returns="pose",
    angles={"pose": 2},
    cases={
        "any": lambda rng: [case(rng, ORIGIN), *(case(rng) for _ in range(4))],
        "origins": lambda rng: [
            case(rng, ORIGIN, ORIGIN, M)
            for M in (Frame2(np.array([3.0, 0, np.pi])), Frame2(np.array([2.0, 1, 0])), None)
        ],
        "robot 1": lambda rng: [case(rng, None, ORIGIN) for _ in range(3)],
    },
    checks="""
    both maps begin here | pose | origins | [x, y, theta]: where both robots stand at the origin of their maps it is robot 2 itself, r away in the direction b12, with the heading b12 + pi - b21.
    robot 1 anywhere     | pose | robot 1 | Robot 2 stands at the origin of its map here: the answer is robot 2 in map 1. Its place is a point of the frame of robot 1: F1.from_frame. b12 counts from the x axis of robot 1, whose heading in map 1 is F1.theta.
    robot 2 anywhere     | pose | any     | The origin of map 2, as robot 2 sees it, is F2.inverse(). The answer is that frame in map 1: it gets there through the frame of robot 2 in map 1.
    """,
    wrong="""
    half a turn forgotten | b12 + np.pi - b21 -> b12 - b21 | Robot 2 looks *back*: its line of sight is that of robot 1 turned by pi.
    second bearing added | np.pi - b21 -> np.pi + b21 | theta2 + b21 is the direction back: so theta2 is that direction *minus* b21.
    first bearing subtracted | F1.theta + b12 -> F1.theta - b12 | The line of sight of robot 1 points to theta1 + b12.
    bearings exchanged | r, b12, b21 = y -> r, b21, b12 = y | b12 is what robot 1 sees: y = [r, b12, b21].
    heading of robot 1 forgotten | F1.theta + b12 -> b12 | Bearings count from the robot's own x axis: add the heading of robot 1.
    range along the heading | [np.cos(b12), np.sin(b12)] -> [1.0, 0.0] | Robot 2 is r metres away in the direction b12, and not straight ahead: r [cos(b12), sin(b12)].
    heading from the first bearing only | b12 + np.pi - b21 -> b12 | How robot 2 is turned is seen from *its* bearing, b21.
    place in the frame of robot 1 | p, *_ = F1.from_frame(r -> p = (r | r and b12 are in the frame of robot 1: F1.from_frame takes them into map 1.
    place without the heading | p, *_ = F1.from_frame(r -> p = F1.t + (r | The bearing counts from the robot's x axis: use F1.from_frame, or add F1.theta.
    to_frame | F1.from_frame -> F1.to_frame | The place of robot 2 comes out of the frame of robot 1: from_frame.
    sine and cosine exchanged | [np.cos(b12), np.sin(b12)] -> [np.sin(b12), np.cos(b12)] | The bearing counts from the x axis: [cos, sin].
    robot for map | robot2.compose(back)[0].x -> robot2.x | That is robot 2 in map 1. The origin of its map is another place: compose with F2.inverse().
    F2 not inverted | F2.inverse()[0] -> F2 | F2 is robot 2 in map 2. You want the way back, map 2 as robot 2 sees it: F2.inverse().
    composed in the other order | robot2.compose(back) -> back.compose(robot2) | First robot 2 in map 1, then the origin of map 2 in robot 2: robot2.compose.
    map 1 in map 2 | robot2.compose(back)[0].x -> robot2.compose(back)[0].inverse()[0].x | That is the inverse of what is asked: map 2 in map 1.
    poses subtracted | robot2.compose(back)[0].x -> robot2.x - F2.x | Frames are composed, not subtracted: the place of F2 must be turned, too.
    F2 turned with robot 2 | robot2.compose(back)[0].x -> np.array([*(p - Frame2(np.array([0, 0, theta])).from_frame(F2.t)[0]), theta - F2.theta]) | The place of F2 is told in map 2: turn it with the heading of map 2, which is that of robot 2 less F2.theta.
    F2 turned the wrong way | robot2.compose(back)[0].x -> np.array([*(p - Frame2(np.array([0, 0, theta - F2.theta])).to_frame(F2.t)[0]), theta - F2.theta]) | The place of F2 goes from map 2 into map 1: turn it forwards with the heading of map 2, from_frame, not back.
    theta in degrees | robot2.compose(back)[0].x -> robot2.compose(back)[0].x * [1, 1, 180 / np.pi] | theta is asked in radians, as all angles are.
    degrees | r, b12, b21 = y -> r, b12, b21 = y[0], *np.radians(y[1:]) | All angles are in radians already: no conversion.
    both bearings the wrong way | F1.theta + b12 + np.pi - b21 -> F1.theta - b12 + np.pi + b21 | theta1 + b12 is the direction to robot 2, and theta2 + b21 the one back: so theta2 = theta1 + b12 + pi - b21.
    the way back before the meeting: First F1, then robot 2 as robot 1 sees it, then F2.inverse(): the steps do not commute.
        robot2.compose(back)[0].x -> F1.compose(back)[0].compose(Frame2(np.array([r * np.cos(b12), r * np.sin(b12), b12 + np.pi - b21])))[0].x
    heading of robot 1 forgotten in theta only | robot2.compose(back)[0].x -> robot2.compose(back)[0].x - np.array([0, 0, F1.theta]) | Bearings count from the robot's own x axis: add the heading of robot 1 to theta, too.
    F2 added to the heading, not its inverse | F2.inverse()[0] -> Frame2(np.array([*F2.inverse()[0].x[:2], F2.theta])) | The heading of map 2 is that of robot 2 in map 1 *less* that in map 2: F2.inverse() has -F2.theta.
    place of F2 added | robot2.compose(back)[0].x -> np.array([*(p + Frame2(np.array([0, 0, theta - F2.theta])).from_frame(F2.t)[0]), theta - F2.theta]) | The origin of map 2 is F2.t behind robot 2: turned into map 1, that is subtracted from the place of robot 2.
    turned with the heading of map 2 | return robot2.compose(back)[0].x -> c, s = np.cos(theta - F2.theta), np.sin(theta - F2.theta); return np.array([p[0] + c * back.t[0] - s * back.t[1], p[1] + s * back.t[0] + c * back.t[1], theta - F2.theta]) | The origin of map 2, as robot 2 sees it, is turned with the heading of the *robot*, then it is added to where the robot is.
    heading of robot 2 for that of the map | return robot2.compose(back)[0].x -> return np.array([*robot2.compose(back)[0].t, theta]) | That is the heading of robot 2 in map 1. That of map 2 is F2.theta less.
    """,
)
