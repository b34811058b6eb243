"""Exercise 12.5: the way back through the lens."""

import numpy as np
from scipy.optimize import fsolve

from ...models.sensors.lens import exact_undistort
from ...models.sensors.lens import radial as package_distort
from .. import expect
from ..exercise import Exercise
from .nb12_distort import distort


def undistort(ud, d):
    """The ideal image point of a distorted one: `distort(up, d)` must give ud again, to 1e-6.

    ud, shape (2,), is the distorted point; it may be [0, 0]. d, shape (n,), is the distortion vector, maybe empty.
    ud lies well before the fold of the lens, so that there is one answer near the axis: the one that is wanted.
    `distort(up, d)` returns the distorted point, its derivative UD_up, shape (2, 2), and one by d.
    Return up, shape (2,), and UP_ud, shape (2, 2): its derivative by ud.
    """
    up = ud.copy()
    for _ in range(20):
        u, UD_up, _ = distort(up, d)
        up = up + np.linalg.solve(UD_up, ud - u)
    return up, np.linalg.inv(distort(up, d)[1])


undistorted = Exercise(
    "12.5",
    "The way back",
    undistort,
    hints=(
        "No formula: solve distort(up, d) = ud. Start at up = ud, and repeat a step that makes the difference smaller.",
        "Newton: up + inv(UD_up) (ud - distorted point). Or simply up = ud / f(up), some 60 times.",
        "The derivative of an inverse is the inverse of the derivative: UP_ud = inv(UD_up), with UD_up taken at up.",
    ),
)

LENSES = ([-0.25], [-0.3, 0.09], [0.2], [-0.28, 0.1, -0.02], [0.05, 0.1])


def case(rng, d, r=None):
    """A distorted point whose ideal one has the radius r, and that one."""
    a, r = rng.uniform(-np.pi, np.pi), rng.uniform(0.4, 0.75) if r is None else r
    up = r * np.array([np.cos(a), np.sin(a)])
    return package_distort(up, d)[0], up


def _out(result):
    up, UP_ud = expect.results(result, "up", "UP_ud")
    return expect.array(up, 2, "up"), expect.array(UP_ud, (2, 2), "UP_ud")


@undistorted.link("two results", "The function must end with `return up, UP_ud`.")
def _(f, rng):
    _out(f(case(rng, np.array([-0.2]))[0], np.array([-0.2])))


@undistorted.link("an ideal lens", "Where d = 0, or empty, nothing has been bent: up = ud.", part=0)
def _(f, rng):
    for d in (np.zeros(1), np.zeros(2), np.zeros(0)):
        ud = rng.uniform(-0.6, 0.6, 2)
        expect.close(_out(f(ud, d))[0], ud, "up", atol=2e-6, at=f"d = {d.tolist()}")


@undistorted.link("there and back", "distort(up, d) must give ud again, to 1e-6.", part=0)
def _(f, rng):
    for d in map(np.array, LENSES):
        ud, up = case(rng, d)
        got = _out(f(ud, d))[0]
        expect.close(got, up, "up", rtol=2e-6, atol=2e-6, at=f"ud = {ud.round(3)}, d = {d.tolist()}")


@undistorted.link("in the middle of the image", "ud = [0, 0]: do not divide by its length.")
def _(f, rng):
    d = np.array([-0.25, 0.05])
    up, UP_ud = _out(f(np.zeros(2), d))
    expect.close(up, np.zeros(2), "up", atol=2e-6, at="ud = [0, 0]")
    expect.close(UP_ud, np.eye(2), "UP_ud", rtol=1e-4, at="ud = [0, 0]")


@undistorted.link("near the fold", "Here the map is steep: one step, or a few, are not enough.", part=0)
def _(f, rng):
    d = np.array([-0.25])
    ud, up = case(rng, d, 0.95)  # the fold is at 1.155
    expect.close(_out(f(ud, d))[0], up, "up", rtol=5e-6, at="a point at 0.82 of the radius of the fold")


@undistorted.link("UP_ud", "The derivative of the inverse is the inverse of the derivative, both at up.", part=1)
def _(f, rng):
    for d in map(np.array, LENSES[:4]):
        ud, _ = case(rng, d)
        back = lambda x, d=d: exact_undistort(x, d)[0]
        J = _out(f(ud, d))[1]
        expect.jacobian(J, back, ud, "UP_ud", "xy", "xy", rtol=1e-4)


def _wrong_up(name, hint, back):
    """A misconception in the point, with the Jacobian that belongs to it."""

    @undistorted.wrong(name, hint)
    def _(ud, d):
        h = 1e-6
        J = np.array([(back(ud + h * e, d) - back(ud - h * e, d)) / (2 * h) for e in np.eye(2)]).T
        return back(ud, d), J


def _wrong_J(name, hint, J):
    """A misconception in the Jacobian alone: J(ud, up, d)."""

    @undistorted.wrong(name, hint)
    def _(ud, d):
        up, _ = undistort(ud, d)
        return up, J(ud, up, d)


def _f(u, d):
    return 1 + (u @ u) ** np.arange(1, len(d) + 1) @ d


# fmt: off
_wrong_up("minus d", "distort(ud, -d) is only a first guess. Try the round trip: distort(up, d) does not give ud.",
          lambda u, d: distort(u, -np.asarray(d))[0])
_wrong_up("divided once", "ud / f(ud) uses f at the distorted point. It is a first step: put its result into f, and "
          "repeat.", lambda u, d: u / _f(u, d))
_wrong_up("divided twice", "Two steps are not enough. Repeat until nothing changes.",
          lambda u, d: u / _f(u / _f(u, d), d))
_wrong_up("distorted once more", "distort goes from up to ud. The way back is its inverse.",
          lambda u, d: distort(u, d)[0])
_wrong_up("returned as it came", "ud is where you start, not the answer: distort(up, d) must give ud.",
          lambda u, d: np.array(u))
_wrong_up("one Newton step", "One Newton step is a good guess, not the answer. Repeat it.",
          lambda u, d: u + np.linalg.solve(distort(u, d)[1], u - distort(u, d)[0]))
_wrong_J("Jacobian not inverted", "UD_up is the derivative of the way there. That of the way back is its inverse.",
         lambda ud, up, d: distort(up, d)[1])
_wrong_J("Jacobian at the distorted point", "UD_up must be taken at up, the result, not at ud.",
         lambda ud, up, d: np.linalg.inv(distort(ud, d)[1]))
_wrong_J("1 / f for the Jacobian", "f changes with up as well: invert the whole matrix UD_up.",
         lambda ud, up, d: np.eye(2) / _f(up, d))
_wrong_J("entries inverted one by one", "1 / UD_up inverts each entry. The inverse of a matrix is np.linalg.inv.",
         lambda ud, up, d: np.array([[1 / v if v else 0 for v in row] for row in distort(up, d)[1]]))
_wrong_J("Jacobian with minus d", "The derivative of the inverse is inv(UD_up); distort with -d has another one.",
         lambda ud, up, d: distort(ud, -np.asarray(d))[1])
_wrong_J("identity", "The lens stretches: UP_ud is I only in the middle of the image.", lambda ud, up, d: np.eye(2))
# fmt: on


@undistorted.variant("fixed point, lists")
def _(ud, d):
    up = np.array(ud, float)
    for _ in range(150):
        up = np.asarray(ud) / _f(up, d)
    return up.tolist(), np.linalg.inv(np.asarray(distort(up, d)[1])).tolist()


@undistorted.variant("Newton on the radius")
def _(ud, d):
    rd, k = np.linalg.norm(ud), np.arange(1, len(d) + 1)
    r = rd
    for _ in range(30):
        r = r - (r * (1 + r ** (2 * k) @ d) - rd) / (1 + r ** (2 * k) @ ((2 * k + 1) * d))
    up = np.asarray(ud) * (r / rd if rd else 1.0)
    return up, np.linalg.solve(np.asarray(distort(up, d)[1]), np.eye(2))


@undistorted.variant("scipy's fsolve, central differences")
def _(ud, d):
    back = lambda u: np.asarray(fsolve(lambda x: np.asarray(distort(x, d)[0]) - u, u, xtol=1e-11))
    h = 1e-5
    return back(ud), np.array([(back(ud + h * e) - back(ud - h * e)) / (2 * h) for e in np.eye(2)]).T


@undistorted.variant("roots of a polynomial")
def _(ud, d):
    rd = np.linalg.norm(ud)
    c = np.zeros(2 * len(d) + 2)
    c[1::2] = [1, *d]
    c[0] = -rd
    roots = np.roots(c[::-1])
    r = min(roots[(np.abs(roots.imag) < 1e-9) & (roots.real >= -1e-12)].real) if rd else 0.0
    up = np.asarray(ud) * (r / rd if rd else 1.0)
    return up, np.linalg.inv(distort(up, d)[1])
