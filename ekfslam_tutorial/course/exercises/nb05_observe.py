"""Exercise 05.2: the expected measurement and its Jacobian by the whole state."""

import numpy as np

from ...geometry import wrap
from .. import expect
from ..exercise import Exercise


def observe(x, l):
    """Expected measurement of one landmark, and its derivative by the whole joint state.

    x, shape (n,): the robot's pose [x, y, theta], then the landmarks.
    l: the range of the landmark in the state, a slice: its position is x[l].
    Return e = [range, bearing], shape (2,), and H = de/dx, shape (2, n).
    """
    dx, dy = x[l] - x[:2]
    r2 = dx**2 + dy**2
    r = np.sqrt(r2)
    e = np.array([r, wrap(np.arctan2(dy, dx) - x[2])])
    E_l = np.array([[dx / r, dy / r], [-dy / r2, dx / r2]])
    H = np.zeros((2, len(x)))
    H[:, :2], H[:, 2], H[:, l] = -E_l, [0, -1], E_l
    return e, H


def bearing_wrapped(result):
    """Results (e, H) with the bearing in (-pi, pi], to compare answers that differ by whole turns."""
    e, H = result
    return np.array([e[0], wrap(e[1])], float), H


observation = Exercise(
    "05.2",
    "Expect",
    observe,
    canonical=bearing_wrapped,
    hints=(
        "e is that of notebook 02. What is new: the pose is in the state, so H has columns for the robot, too.",
        "e depends on differences only, landmark minus robot. So what are the first two columns, compared with those "
        "of the landmark? And what happens to range and bearing when the robot turns?",
        "With E_l the 2 x 2 block of the landmark: H[:, l] = E_l, H[:, :2] = -E_l, H[:, 2] = [0, -1], and zero "
        "elsewhere.",
    ),
)

E_ROWS = ("range", "bearing")


def case(rng, n=9, at=5):
    """Return a state with a landmark in the range at:at+2, a few metres from the robot."""
    x = rng.uniform(-5, 5, n)
    x[2] = rng.uniform(-3, 3)
    a, r = rng.uniform(-np.pi, np.pi), rng.uniform(1, 6)
    x[at : at + 2] = x[:2] + r * np.array([np.cos(a), np.sin(a)])
    return x, slice(at, at + 2)


def _two(result, n):
    e, H = expect.results(result, "e", "H")
    return expect.array(e, 2, "e"), expect.array(H, (2, n), "H")


def _e(result):
    return expect.array(expect.results(result, "e", "H")[0], 2, "e")


@observation.link("two results", "The function must end with `return e, H`.")
def _(f, rng):
    e, H = expect.results(f(*case(rng)), "e", "H")
    expect.array(e, 2, "e")
    expect.true(H is not None, "H is None: return the Jacobian as the second result")


@observation.link("range", "The range is the distance from the robot to the landmark in x[l].", part=0)
def _(f, rng):
    for n, at in ((9, 5), (5, 3), (11, 7), (9, 3)):
        x, l = case(rng, n, at)
        expect.close(_e(f(x, l))[0], np.hypot(*(x[l] - x[:2])), "the range")


@observation.link("bearing", "Look from the robot: the direction arctan2(dy, dx), minus the heading theta.", part=0)
def _(f, rng):
    for n, at, theta in ((9, 5, 0.0), (5, 3, 0.7), (11, 7, -2.5), (9, 3, 2.9)):
        x, l = case(rng, n, at)
        x[2] = theta
        want = np.arctan2(*(x[l] - x[:2])[::-1]) - theta
        expect.angle(_e(f(x, l))[1], want, "the bearing", at=f"theta = {theta}")


@observation.link("shape of H", "H has one column for each number of the joint state: robot and all landmarks.", part=1)
def _(f, rng):
    for n, at in ((9, 5), (5, 3), (13, 11)):
        x, l = case(rng, n, at)
        _two(f(x, l), n)


def _smooth(x, l, direction):
    """[range, bearing] without a seam: the direction is counted from the given one."""
    dx, dy = x[l] - x[:2]
    c, s = np.cos(direction), np.sin(direction)
    return np.array([np.hypot(dx, dy), np.arctan2(c * dy - s * dx, c * dx + s * dy) - x[2]])


def _columns(f, rng, columns, names):
    """The given columns of H are the derivative; `columns` is a function of the landmark's range."""
    for n, at in ((9, 5), (5, 3), (9, 7), (7, 3)):
        x, l = case(rng, n, at)
        H = _two(f(x, l), n)[1]
        where = columns(l, n)
        direction = np.arctan2(*(x[l] - x[:2])[::-1])

        def part(v, x=x, l=l, where=where, direction=direction):
            full = x.copy()
            full[where] = v
            return _smooth(full, l, direction)

        name = names if names else [f"x[{i}]" for i in where]
        expect.jacobian(H[:, where], part, x[where], f"H[:, {where[0]}:{where[-1] + 1}]", E_ROWS, name)


@observation.link("columns of the landmark", "The block of notebook 02, in the columns l of H.", part=1)
def _(f, rng):
    _columns(f, rng, lambda l, n: np.arange(n)[l], ("x_l", "y_l"))


@observation.link("columns of the robot's position", "Only differences count: landmark minus robot.", part=1)
def _(f, rng):
    _columns(f, rng, lambda l, n: np.arange(2), ("x", "y"))


@observation.link(
    "column of the heading", "Turn the robot a bit to the left: what happens to range and bearing?", part=1
)
def _(f, rng):
    _columns(f, rng, lambda l, n: np.array([2]), ("theta",))


@observation.link("columns of the others", "A measurement of one landmark does not depend on the others.", part=1)
def _(f, rng):
    for n, at in ((9, 5), (11, 3)):
        x, l = case(rng, n, at)
        others = np.delete(_two(f(x, l), n)[1][:, 3:], np.arange(at - 3, at - 1), axis=1)
        expect.true(not others.any(), "H is not zero in the columns of other landmarks")


@observation.link("the world as a whole", "Shift or turn robot and landmarks together: no measurement changes.", part=1)
def _(f, rng):
    x, l = case(rng)
    H = _two(f(x, l), 9)[1]
    shift, turn = np.zeros((9, 2)), np.zeros(9)
    shift[[0, 3, 5, 7], 0] = shift[[1, 4, 6, 8], 1] = 1
    turn[:3], turn[3::2], turn[4::2] = [-x[1], x[0], 1], -x[4::2], x[3::2]
    expect.close(H @ shift, np.zeros((2, 2)), "H times a shift of the whole world", 0, 1e-7)
    expect.close(H @ turn, np.zeros(2), "H times a turn of the whole world", 0, 1e-6)


# ---- wrong and right answers -----------------------------------------------------------------------------------------


def _wrong_e(name, hint, e_of):
    """A misconception in the value: e_of(dx, dy, theta)."""

    @observation.wrong(name, hint)
    def _(x, l):
        dx, dy = x[l] - x[:2]
        return np.array(e_of(dx, dy, x[2])), observe(x, l)[1]


def _wrong_H(name, hint, change):
    """A misconception in the Jacobian: change(H, l, E_l, x) works on the right one, in place, or returns another."""

    @observation.wrong(name, hint)
    def _(x, l):
        e, H = observe(x, l)
        other = change(H, l, H[:, l].copy(), x)
        return e, H if other is None else other


def _block(change):
    """A change of the landmark's block that the robot's position block takes over with the other sign."""
    return _set(lmk=lambda E, x: change(E), position=lambda E, x: -change(E))


def _set(**columns):
    """A change of H that sets its columns: position, heading, lmk, each a function of (E_l, x)."""

    def change(H, l, E, x):
        for name, value in columns.items():
            H[:, {"position": slice(0, 2), "heading": 2, "lmk": l}[name]] = value(E, x)

    return change


def _polar(dx, dy, theta):
    return [np.hypot(dx, dy), np.arctan2(dy, dx) - theta]


# fmt: off
_wrong_e("heading forgotten", "That is the direction in the map. The robot measures from its own x axis: subtract "
       "theta.",
         lambda dx, dy, th: _polar(dx, dy, 0))
_wrong_e("heading added", "Turn the robot to the left: the landmark moves to the right in its view. Subtract theta.",
         lambda dx, dy, th: _polar(dx, dy, -th))
_wrong_e("from the landmark to the robot", "Use landmark minus robot in "
       "arctan2.", lambda dx, dy, th: _polar(-dx, -dy, th))
_wrong_e("arctan2 swapped", "arctan2 takes y first: arctan2(dy, dx).",
         lambda dx, dy, th: [np.hypot(dx, dy), np.arctan2(dx, dy) - th])
_wrong_e("arctan of the quotient", "arctan(dy / dx) cannot tell ahead from behind. Use arctan2(dy, dx).",
         lambda dx, dy, th: [np.hypot(dx, dy), np.arctan(dy / dx) - th])
_wrong_e("bearing to the right", "Your bearing has the wrong sign: angles count to the left (counter-clockwise).",
         lambda dx, dy, th: [np.hypot(dx, dy), th - np.arctan2(dy, dx)])
_wrong_e("bearing in degrees", "Angles are in radians everywhere.",
         lambda dx, dy, th: [np.hypot(dx, dy), np.degrees(wrap(np.arctan2(dy, dx) - th))])
_wrong_e("range squared", "Take the square root: the range is in metres.",
         lambda dx, dy, th: [dx**2 + dy**2, np.arctan2(dy, dx) - th])

_wrong_H("the mapping Jacobian", "That is H of notebook 02, where the pose was known. Now the pose is in the state: it "
         "has columns of its own, the first three.", _set(position=lambda E, x: 0, heading=lambda E, x: 0))
_wrong_H("the localisation Jacobian", "The landmark is in the state, too: its block belongs into the columns l.",
         _set(lmk=lambda E, x: 0))
_wrong_H("heading column forgotten", "The bearing is measured from the robot's own axis: d bearing / d theta = -1. "
         "Without it the filter never corrects its heading, and diverges.", _set(heading=lambda E, x: 0))
_wrong_H("heading column positive", "Turn the robot to the left: the landmark moves to the right in its view. "
         "d bearing / d theta = -1.", _set(heading=lambda E, x: [0, 1]))
_wrong_H("heading in the range", "Turning on the spot changes no distance: d range / d theta = 0, d bearing / d theta "
       "= -1.",
         _set(heading=lambda E, x: [-1, 0]))
_wrong_H("heading in both rows", "Turning on the spot changes no distance: d range / d theta = 0.",
         _set(heading=lambda E, x: [-1, -1]))
_wrong_H("heading in degrees", "The column of the heading is in degrees: keep to radians.",
         _set(heading=lambda E, x: [0, -180 / np.pi]))
_wrong_H("same sign for robot and landmark", "A robot that comes nearer makes the range smaller: the columns of the "
         "robot are minus those of the landmark.", _set(position=lambda E, x: E))
_wrong_H("signs swapped", "The signs of robot and landmark are exchanged: dr/dx_l = +dx/r.",
         _set(position=lambda E, x: E, lmk=lambda E, x: -E))
_wrong_H("position columns zero", "A robot that moves sees the landmark at another range: the first two columns "
         "are -E_l.",
         _set(position=lambda E, x: 0))
_wrong_H("r for r^2", "The bearing row is divided by r^2, not by r.",
         _block(lambda E: E * [[1], [1 / np.hypot(*E[1])]]))
_wrong_H("r^2 for r", "The range row is divided by r, not by r^2: it is a unit vector.",
         _block(lambda E: E * [[np.hypot(*E[1])], [1]]))
_wrong_H("minus sign forgotten", "d bearing / d x_l = -dy / r^2: the lower left entry of the block has a minus sign.",
         _block(lambda E: E * [[1, 1], [-1, 1]]))
_wrong_H("sign of the bearing row", "d bearing / d x_l = -dy/r^2 and d bearing / d y_l = +dx/r^2.",
         _block(lambda E: E * [[1], [-1]]))
_wrong_H("block transposed", "The first row is the derivative of the range, by x and by y: your block is transposed.",
         _block(lambda E: E.T))
_wrong_H("turned by theta", "The state is in the map frame, and so are the columns of H: theta only shifts the "
       "bearing.",
         _set(lmk=lambda E, x: E @ _turn(x[2]), position=lambda E, x: -E @ _turn(x[2])))
_wrong_H("only five columns", "H has a column for each number of the state: put the blocks into a matrix of zeros, 2 x "
       "n.",
         lambda H, l, E, x: np.hstack([-E, [[0], [-1]], E]))
_wrong_H("landmark right behind the robot", "The landmark's block belongs into the columns l, not always into 3:5.",
         lambda H, l, E, x: np.hstack([-E, [[0], [-1]], E, np.zeros((2, len(x) - 5))]))
_wrong_H("H transposed", "Rows are outputs (range, bearing), columns are inputs (the state): H is 2 x n.",
         lambda H, l, E, x: H.T)
# fmt: on


@observation.wrong("the first landmark always", "The landmark asked for is x[l], not always x[3:5].")
def _(x, l):
    return observe(x, slice(3, 5))


@observation.wrong("columns instead of vectors", "Vectors have one axis here: e = np.array([r, beta]), no columns.")
def _(x, l):
    e, H = observe(x, l)
    return e[:, None], H


def _turn(a):
    return np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]])


@observation.variant("by the chain rule, through the robot frame")
def _(x, l):
    T = _turn(x[2]).T
    p = T @ (x[l] - x[:2])
    r = np.hypot(*p)
    E_p = np.array([p / r, [-p[1] / r**2, p[0] / r**2]])
    H = np.zeros((2, len(x)))
    H[:, l] += E_p @ T
    H[:, :3] += E_p @ np.column_stack([-T, [p[1], -p[0]]])
    return (r, np.arctan2(p[1], p[0])), H


@observation.variant("complex numbers, whole turns added, lists")
def _(x, l):
    i, d = l.start, complex(*(x[l] - x[:2]))
    H = [[0.0] * len(x), [0.0] * len(x)]
    H[0][0], H[0][1], H[0][i], H[0][i + 1] = -d.real / abs(d), -d.imag / abs(d), d.real / abs(d), d.imag / abs(d)
    g = 1 / d
    H[1][0], H[1][1], H[1][2], H[1][i], H[1][i + 1] = -g.imag, -g.real, -1.0, g.imag, g.real
    return [abs(d), np.angle(d) - float(x[2]) - 2 * np.pi], H


@observation.variant("finite differences")
def _(x, l):
    direction = np.arctan2(*(x[l] - x[:2])[::-1])
    J = [(_smooth(x + d, l, direction) - _smooth(x - d, l, direction)) / 2e-6 for d in 1e-6 * np.eye(len(x))]
    return _smooth(x, l, 0.0), np.transpose(J)
