"""Exercise 18.1: one robot sees another: the measurement and its Jacobians by both poses."""

import numpy as np

from ...geometry import wrap
from .. import expect
from ..exercise import Exercise


def meet(a, b):
    """What robot a should see of robot b, and how it depends on both.

    a and b, shape (3,): the poses [x, y, theta] of two robots in the map, m and rad. The camera of a sits at its
    origin and looks along its x axis; b is seen as a point, the origin of b.
    Return e = [range, bearing], shape (2,), and the Jacobians E_a = de/da and E_b = de/db, shape (2, 3) each.
    """
    dx, dy = b[:2] - a[:2]
    r = np.hypot(dx, dy)
    e = np.array([r, wrap(np.arctan2(dy, dx) - a[2])])
    E_p = np.array([[dx / r, dy / r], [-dy / r**2, dx / r**2]])
    E_a = np.column_stack([-E_p, [0.0, -1.0]])
    E_b = np.column_stack([E_p, [0.0, 0.0]])
    return e, E_a, E_b


def bearing_wrapped(result):
    """Results with the bearing in (-pi, pi], to compare answers that differ by whole turns."""
    e, E_a, E_b = result
    return np.array([e[0], wrap(e[1])], float), E_a, E_b


sight = Exercise(
    "18.1",
    "A robot is a landmark that moves",
    meet,
    canonical=bearing_wrapped,
    hints=(
        "It is the range and bearing of notebook 05, with the origin of robot b as the landmark.",
        "Only the difference of the two positions counts, so their columns differ in the sign only. Which heading "
        "shows in the measurement, and which does not?",
        "With E_p = [[dx/r, dy/r], [-dy/r^2, dx/r^2]]: E_a = [-E_p, [0, -1]'], E_b = [E_p, [0, 0]'].",
    ),
)

ROWS, COLUMNS = ("range", "bearing"), ("x", "y", "theta")


def case(rng):
    """Return two poses, a few metres apart, with any headings."""
    a = np.array([*rng.uniform(-5, 5, 2), rng.uniform(-3, 3)])
    angle, r = rng.uniform(-np.pi, np.pi), rng.uniform(0.5, 6)
    return a, np.array([a[0] + r * np.cos(angle), a[1] + r * np.sin(angle), rng.uniform(-3, 3)])


def _three(result):
    e, E_a, E_b = expect.results(result, "e", "E_a", "E_b")
    return expect.array(e, 2, "e"), expect.array(E_a, (2, 3), "E_a"), expect.array(E_b, (2, 3), "E_b")


@sight.link("three results", "The function must end with `return e, E_a, E_b`.")
def _(f, rng):
    _three(f(*case(rng)))


@sight.link("range", "The range is the distance between the two origins.", part=0)
def _(f, rng):
    for _ in range(4):
        a, b = case(rng)
        expect.close(_three(f(a, b))[0][0], np.hypot(*(b[:2] - a[:2])), "the range")


@sight.link("bearing", "From a to b: the direction arctan2(dy, dx), minus the heading of a.", part=0)
def _(f, rng):
    for theta in (0.0, 0.7, -2.5, 2.9):
        a, b = case(rng)
        a[2] = theta
        want = np.arctan2(*(b[:2] - a[:2])[::-1]) - theta
        expect.angle(_three(f(a, b))[0][1], want, "the bearing", at=f"the heading {theta} of a")


def _smooth(a, b, direction):
    """[range, bearing] without a seam: the direction is counted from the given one."""
    dx, dy = b[:2] - a[:2]
    c, s = np.cos(direction), np.sin(direction)
    return np.array([np.hypot(dx, dy), np.arctan2(c * dy - s * dx, c * dx + s * dy) - a[2]])


def _by(which, name, help):
    @sight.link(f"Jacobian {name}", help, part=1 + which)
    def _(f, rng):
        for _ in range(5):
            poses = case(rng)
            J = _three(f(*poses))[1 + which]
            direction = np.arctan2(*(poses[1][:2] - poses[0][:2])[::-1])

            def h(v, poses=poses, direction=direction):
                both = list(poses)
                both[which] = v
                return _smooth(both[0], both[1], direction)

            expect.jacobian(J, h, poses[which], name, ROWS, COLUMNS)


_by(0, "E_a", "A robot that goes forward comes nearer: minus signs. And turn a to the left: what does the bearing do?")
_by(1, "E_b", "The block of a landmark for the position. Does the heading of b show in its place?")


@sight.link("the pair as a whole", "Shift both robots by the same: no measurement changes, so the position columns of "
            "E_a and E_b add up to zero.")  # fmt: skip
def _(f, rng):
    a, b = case(rng)
    _, E_a, E_b = _three(f(a, b))
    expect.close(E_a[:, :2] + E_b[:, :2], np.zeros((2, 2)), "E_a + E_b for the positions", 0, 1e-7)
    e, turned = (_three(f(a, p))[0] for p in (b, b + np.array([0, 0, 1.0])))
    expect.close(turned[0], e[0], "the range after a turn of b", 0, 1e-9)
    expect.angle(turned[1], e[1], "the bearing after a turn of b", 1e-9)


def _wrong(name, hint, e=None, E_a=None, E_b=None):
    """A misconception in one of the results; E_a and E_b take (right Jacobian, a, b)."""

    @sight.wrong(name, hint)
    def _(a, b):
        right = meet(a, b)
        value = right[0] if e is None else np.array(e(*(b[:2] - a[:2]), a[2], b[2]))
        return value, right[1] if E_a is None else E_a(right[1], a, b), right[2] if E_b is None else E_b(right[2], a, b)


def _columns(position=1.0, heading=None):
    """A change of a Jacobian: a factor for the position columns, other numbers for the heading."""
    return lambda E, a, b: np.column_stack([position * E[:, :2], E[:, 2] if heading is None else heading])


def _turn(a):
    return np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]])


# fmt: off
_wrong("heading forgotten", "That is the direction in the map. Robot a measures from its own x axis: subtract its "
       "heading.", e=lambda dx, dy, ta, tb: [np.hypot(dx, dy), np.arctan2(dy, dx)])
_wrong("heading of the other robot", "The camera is on a: subtract the heading of a, not that of b.",
       e=lambda dx, dy, ta, tb: [np.hypot(dx, dy), np.arctan2(dy, dx) - tb])
_wrong("relative heading", "The camera measures where b is, not how b is turned.",
       e=lambda dx, dy, ta, tb: [np.hypot(dx, dy), tb - ta])
_wrong("seen from b", "That is what b sees of a. Use b minus a, and the heading of a.",
       e=lambda dx, dy, ta, tb: [np.hypot(dx, dy), np.arctan2(-dy, -dx) - tb])
_wrong("from b to a", "From a to b: b[:2] - a[:2].",
       e=lambda dx, dy, ta, tb: [np.hypot(dx, dy), np.arctan2(-dy, -dx) - ta])
_wrong("bearing to the right", "Angles count to the left: direction minus heading.",
       e=lambda dx, dy, ta, tb: [np.hypot(dx, dy), ta - np.arctan2(dy, dx)])
_wrong("arctan2 swapped", "arctan2 takes y first: arctan2(dy, dx).",
       e=lambda dx, dy, ta, tb: [np.hypot(dx, dy), np.arctan2(dx, dy) - ta])
_wrong("bearing in degrees", "Angles are in radians everywhere.",
       e=lambda dx, dy, ta, tb: [np.hypot(dx, dy), np.degrees(wrap(np.arctan2(dy, dx) - ta))])
_wrong("range squared", "Take the square root: the range is in metres.",
       e=lambda dx, dy, ta, tb: [dx**2 + dy**2, np.arctan2(dy, dx) - ta])
_wrong("heading of b in the bearing row", "b is seen as a point: turn it on the spot, and nothing changes. The heading "
       "column of E_b is zero.", E_b=_columns(heading=[0, 1]))
_wrong("heading of b as that of a", "b is seen as a point: its own heading does not show. The heading column of E_b is "
       "zero.", E_b=_columns(heading=[0, -1]))
_wrong("heading of a forgotten", "Turn a to the left: b moves to the right in its view. d bearing / d theta_a = -1.",
       E_a=_columns(heading=[0, 0]))
_wrong("heading of a positive", "Turn a to the left: b moves to the right in its view. d bearing / d theta_a = -1.",
       E_a=_columns(heading=[0, 1]))
_wrong("heading in the range", "Turning on the spot changes no distance: d range / d theta = 0.",
       E_a=_columns(heading=[-1, -1]))
_wrong("same sign for both", "Let a go towards b: the range becomes smaller. The position columns of E_a are minus "
       "those of E_b.", E_a=_columns(position=-1.0))
_wrong("signs exchanged", "Let b go away from a: the range grows. Plus signs belong into E_b, minus into E_a.",
       E_a=_columns(position=-1.0), E_b=_columns(position=-1.0))
_wrong("b is a fixed mark", "b is in the state, too: its position columns are those of a landmark.",
       E_b=lambda E, a, b: np.zeros((2, 3)))
_wrong("a is exact", "a is in the state, too: a step of a changes the measurement.",
       E_a=lambda E, a, b: np.zeros((2, 3)))
_wrong("r for r^2", "The bearing row is divided by r^2, not by r.",
       E_a=lambda E, a, b: E * [[1, 1, 1], [meet(a, b)[0][0]] * 2 + [1]],
       E_b=lambda E, a, b: E * [[1, 1, 1], [meet(a, b)[0][0]] * 2 + [1]])
_wrong("block transposed", "The first row is the derivative of the range: your block is transposed.",
       E_a=lambda E, a, b: np.column_stack([E[:, :2].T, E[:, 2]]),
       E_b=lambda E, a, b: np.column_stack([E[:, :2].T, E[:, 2]]))
_wrong("in the frame of a", "The states are in the map frame, and so are the columns: no rotation by theta.",
       E_a=lambda E, a, b: np.column_stack([E[:, :2] @ _turn(a[2]), E[:, 2]]),
       E_b=lambda E, a, b: np.column_stack([E[:, :2] @ _turn(a[2]), E[:, 2]]))
_wrong("two columns", "The state of b has three numbers: give its heading a column of zeros.",
       E_b=lambda E, a, b: E[:, :2])
_wrong("Jacobians exchanged", "Return E_a before E_b: the one with -1 in the heading column first.",
       E_a=lambda E, a, b: meet(a, b)[2], E_b=lambda E, a, b: meet(a, b)[1])
# fmt: on


@sight.variant("by the chain rule, in the frame of a")
def _(a, b):
    T = _turn(a[2]).T
    p = T @ (b[:2] - a[:2])
    r = np.hypot(*p)
    E_p = np.array([p / r, [-p[1] / r**2, p[0] / r**2]])
    E_a = E_p @ np.column_stack([-T, [p[1], -p[0]]])
    return (r, np.arctan2(p[1], p[0])), E_a, np.hstack([E_p @ T, np.zeros((2, 1))])


@sight.variant("complex numbers, lists, a whole turn more")
def _(a, b):
    d = complex(*(np.asarray(b[:2]) - a[:2]))
    u, g = d / abs(d), 1 / d
    e = [abs(d), np.angle(d) - float(a[2]) + 2 * np.pi]
    E_a = [[-u.real, -u.imag, 0], [-g.imag, -g.real, -1]]
    return e, E_a, [[u.real, u.imag, 0], [g.imag, g.real, 0]]


@sight.variant("the package")
def _(a, b):
    from ...geometry import Frame2
    from ...models import observe
    from ...models.landmarks import EucPnt
    from ...models.sensors import RangeBearing

    e, E_r, _, E_l = observe(Frame2(a), Frame2(np.zeros(3)), RangeBearing(0.1, 0.1), EucPnt(2), b[:2])
    return e, E_r, np.pad(E_l, ((0, 0), (0, 1)))
