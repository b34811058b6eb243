"""Exercise 18.1: one robot sees another: the measurement and its Jacobians by both poses."""

import numpy as np

from ...geometry import wrap
from .. import expect
from ..table import table


def meet(a, b):
    """What robot a should see of robot b, and how it depends on both.

    a and b, shape (3,): the poses [x, y, theta] of two robots in the map, m and rad. The camera of a sits at its
    origin and looks along its x axis; b is seen as a point, the origin of b.
    Return e = [range, bearing], shape (2,), and the Jacobians E_a = de/da and E_b = de/db, shape (2, 3) each.
    The bearing may hold whole turns: a correction wraps the innovation.
    """
    dx, dy = b[:2] - a[:2]
    r = np.hypot(dx, dy)
    e = np.array([r, wrap(np.arctan2(dy, dx) - a[2])])
    E_p = np.array([[dx / r, dy / r], [-dy / r**2, dx / r**2]])
    E_a = np.column_stack([-E_p, [0.0, -1.0]])
    E_b = np.column_stack([E_p, [0.0, 0.0]])
    return e, E_a, E_b


def case(rng, theta=None):
    """Return two poses, a few metres apart, with any headings."""
    a = np.array([*rng.uniform(-5, 5, 2), rng.uniform(-3, 3) if theta is None else theta])
    angle, r = rng.uniform(-np.pi, np.pi), rng.uniform(0.5, 6)
    return a, np.array([a[0] + r * np.cos(angle), a[1] + r * np.sin(angle), rng.uniform(-3, 3)])


def _turn(a):
    """R, with a row for the angle."""
    return np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]])


def _unwrapped(a, b):
    """Range and bearing without a seam."""
    return np.array([np.hypot(*(b - a)[:2]), np.arctan2(*(b - a)[1::-1]) - a[2]])


ROWS, COLUMNS = "range, bearing", "x, y, theta"

sight = table(
    "18.1 A robot is a landmark that moves",
    meet,
    hints=(
        "It is the range and bearing of notebook 05, with the origin of robot b as the landmark.",
        "Only the difference of the two positions counts, so their columns differ in the sign only. Which heading shows in the measurement, and which does not?",
        "With E_p = [[dx/r, dy/r], [-dy/r^2, dx/r^2]]: E_a = [-E_p, [0, -1]'], E_b = [E_p, [0, 0]'].",
    ),
    returns="e, E_a, E_b",
    angles={"e": 1},
    jacobians={"E_a": _unwrapped, "E_b": _unwrapped},
    entries={"E_a": ROWS, "E_b": ROWS, "a": COLUMNS, "b": COLUMNS},
    cases={
        "any": lambda rng: [case(rng) for _ in range(5)],
        "headings": lambda rng: [case(rng, theta) for theta in (0.0, 0.7, -2.5, 2.9)],
    },
    checks="""
    range        | e[:1]     | any      | The range is the distance between the two origins.
    bearing      | e         | headings | From a to b: the direction arctan2(dy, dx), minus the heading of a.
    Jacobian E_a | d E_a / a | any      | Rows: range, bearing. Columns: x, y and theta of a. How does each of the two change when a goes towards b, when a steps aside, and when a turns to the left?
    Jacobian E_b | d E_b / b | any      | Range and bearing by x, y and theta of b. For the position it is the block of a landmark. Does the heading of b show in its place?
    """,
    wrong="""
    heading forgotten | wrap(np.arctan2(dy, dx) - a[2]) -> np.arctan2(dy, dx) | That is the direction in the map. Robot a measures from its own x axis: subtract its heading.
    heading of the other robot | - a[2])]) -> - b[2])]) | The camera is on a: subtract the heading of a, not that of b.
    both headings | np.arctan2(dy, dx) - a[2] -> np.arctan2(dy, dx) - a[2] + b[2] | The camera is on a, and b is seen as a point: only the heading of a counts.
    relative heading | np.arctan2(dy, dx) - a[2] -> b[2] - a[2] | The camera measures where b is, not how b is turned.
    seen from b | np.arctan2(dy, dx) - a[2] -> np.arctan2(-dy, -dx) - b[2] | That is what b sees of a. Use b minus a, and the heading of a.
    from b to a | np.arctan2(dy, dx) -> np.arctan2(-dy, -dx) | From a to b: b[:2] - a[:2].
    bearing to the right | np.arctan2(dy, dx) - a[2] -> a[2] - np.arctan2(dy, dx) | Angles count to the left: direction minus heading.
    arctan2 swapped | np.arctan2(dy, dx) -> np.arctan2(dx, dy) | arctan2 takes y first: arctan2(dy, dx).
    plain arctan | np.arctan2(dy, dx) -> np.arctan(dy / dx) | np.arctan cannot tell ahead from behind: arctan2(dy, dx).
    bearing in degrees | wrap(np.arctan2(dy, dx) - a[2]) -> np.degrees(wrap(np.arctan2(dy, dx) - a[2])) | Angles are in radians everywhere.
    brackets of the wrapping | wrap(np.arctan2(dy, dx) - a[2]) -> (np.arctan2(dy, dx) - a[2] + np.pi) % 2 * np.pi - np.pi | `%` and `*` are done from left to right: (angle + pi) % (2 * pi) - pi needs the brackets round 2 * pi.
    range squared | np.array([r, wrap -> np.array([r**2, wrap | Take the square root: the range is in metres.
    heading of b in the bearing row | [E_p, [0.0, 0.0]] -> [E_p, [0.0, 1.0]] | b is seen as a point: turn it on the spot, and nothing changes. The heading column of E_b is zero.
    heading of b as that of a | [E_p, [0.0, 0.0]] -> [E_p, [0.0, -1.0]] | b is seen as a point: its own heading does not show. The heading column of E_b is zero.
    heading of a forgotten | [-E_p, [0.0, -1.0]] -> [-E_p, [0.0, 0.0]] | Turn a to the left: b moves to the right in its view. d bearing / d theta_a = -1.
    heading of a positive | [-E_p, [0.0, -1.0]] -> [-E_p, [0.0, 1.0]] | Turn a to the left: b moves to the right in its view. d bearing / d theta_a = -1.
    heading in the range | [-E_p, [0.0, -1.0]] -> [-E_p, [-1.0, -1.0]] | Turning on the spot changes no distance: d range / d theta = 0.
    bearing row of E_a exchanged | [-E_p, [0.0, -1.0]] -> [[-E_p[0], -E_p[1, ::-1]], [0.0, -1.0]] | In the bearing row of E_a the entries by x and y are exchanged: [dy/r^2, -dx/r^2, -1].
    range row with the wrong sign | [[dx / r, dy / r], -> [[-dx / r, -dy / r], | Let b go away from a: the range grows. Plus dx/r, dy/r belong in E_b, minus in E_a.
    same sign for both | [-E_p, [0.0, -1.0]] -> [E_p, [0.0, -1.0]] | Let a go towards b: the range becomes smaller. The position columns of E_a are minus those of E_b.
    signs exchanged | [-E_p, [0.0, -1.0]] -> [E_p, [0.0, -1.0]] | Let b go away from a: the range grows. Plus signs belong in E_b, minus in E_a.
        [E_p, [0.0, 0.0]] -> [-E_p, [0.0, 0.0]]
    b is a fixed mark | np.column_stack([E_p, [0.0, 0.0]]) -> np.zeros((2, 3)) | b is in the state, too: its position columns are those of a landmark.
    a is exact | np.column_stack([-E_p, [0.0, -1.0]]) -> np.zeros((2, 3)) | a is in the state, too: a step of a changes the measurement.
    r for r^2 | [-dy / r**2, dx / r**2] -> [-dy / r, dx / r] | The bearing row is divided by r^2, not by r.
    block transposed | [[dx / r, dy / r], [-dy / r**2, dx / r**2]] -> [[dx / r, -dy / r**2], [dy / r, dx / r**2]] | The first row is the derivative of the range: your block is transposed.
    in the frame of a | return e, E_a, E_b -> return e, E_a @ _turn(a[2]), E_b @ _turn(a[2]) | The states are in the map frame, and so are the columns of E_a and E_b: derivatives by x and y of the map, of b[:2] - a[:2] as it is.
    two columns | np.column_stack([E_p, [0.0, 0.0]]) -> E_p | The state of b has three numbers: give its heading a column of zeros.
    Jacobians exchanged | return e, E_a, E_b -> return e, E_b, E_a | Return E_a before E_b: the one with -1 in the heading column first.
    range with the heading | r = np.hypot(dx, dy) -> r = np.linalg.norm(b - a) | The range is the distance in x and y: the headings are no part of it.
    bearing like a compass | np.arctan2(dy, dx) - a[2] -> np.pi / 2 - np.arctan2(dy, dx) + a[2] | The bearing counts from straight ahead to the left: arctan2(left, ahead).
    """,
)


@sight.link(
    "the pair as a whole",
    "Shift both robots by the same, or turn b on the spot: no measurement changes. So the position columns of E_a and E_b add up to zero.",
)
def _(f, rng):
    a, b = case(rng)
    e, E_a, E_b = (np.asarray(part, float) for part in f(a, b))
    expect.close(E_a[:, :2] + E_b[:, :2], np.zeros((2, 2)), "E_a + E_b for the positions", 0, 1e-7)
    turned = np.asarray(f(a, b + [0, 0, 1.0])[0], float)
    expect.close(turned[0], e[0], "the range after a turn of b", 0, 1e-9)
    expect.angle(turned[1], e[1], "the bearing after a turn of b", 1e-9)
