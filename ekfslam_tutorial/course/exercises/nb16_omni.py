"""Exercise 16.5 (stretch): the direct model of a camera that looks all round."""

import numpy as np

from ...geometry import wrap
from .. import expect
from ..exercise import Exercise


def omni_project(p):
    """Azimuth and elevation of points, and their derivatives.

    p, shape (..., 3): points in the frame of the camera (m), x ahead, y to the left, z up; or rays, points up to a
    positive factor. Any number of leading axes, also none.
    Return y = [azimuth; elevation], shape (..., 2) (rad): the angle round the z axis, counted from x towards y, and the
    angle above the x-y plane; and the Jacobian Y_p, shape (..., 2, 3).
    """
    x, y, z = p[..., 0], p[..., 1], p[..., 2]
    s2 = x**2 + y**2  # square of the distance in the plane
    s, r2 = np.sqrt(s2), s2 + z**2
    A_p = np.stack([-y / s2, x / s2, 0 * x], axis=-1)
    E_p = np.stack([-x * z / (s * r2), -y * z / (s * r2), s / r2], axis=-1)
    return np.stack([np.arctan2(y, x), np.arctan2(z, s)], axis=-1), np.stack([A_p, E_p], axis=-2)


def _wrapped(result):
    """The azimuth without whole turns."""
    y, Y_p = result
    y = np.array(y, float)
    y[..., 0] = wrap(y[..., 0])
    return y, Y_p


omni = Exercise(
    "16.5",
    "A camera that looks all round (stretch)",
    omni_project,
    canonical=_wrapped,
    hints=(
        "Azimuth = arctan2(y, x). With s = sqrt(x^2 + y^2), elevation = arctan2(z, s).",
        "d arctan2(a, b) = (b da - a db) / (a^2 + b^2). For the elevation a = z, b = s; ds/dx = x / s, ds/dy = y / s.",
        "Rows: [-y, x, 0] / s^2 and [-x z / s, -y z / s, s] / (s^2 + z^2). np.stack(..., axis=-2) puts them together.",
    ),
)


def some(rng, lead):
    """Points all round, up to 60 degrees above and below."""
    a, e, r = rng.uniform(-3, 3, lead), rng.uniform(-1, 1, lead), rng.uniform(1, 6, lead)
    return np.stack([r * np.cos(e) * np.cos(a), r * np.cos(e) * np.sin(a), r * np.sin(e)], -1)


def _two(result, lead):
    y, Y_p = expect.results(result, "y", "Y_p")
    return expect.array(y, (*lead, 2), "y"), expect.array(Y_p, (*lead, 2, 3), "Y_p")


def _angles(got, want, at):
    for i, name in enumerate(("azimuth", "elevation")):
        off = np.abs(wrap(got[..., i] - want[..., i])) if i == 0 else np.abs(got[..., i] - want[..., i])
        if np.max(off, initial=0) > 1e-6:
            k = np.unravel_index(np.argmax(off), off.shape)
            expect.close(got[..., i][k], want[..., i][k], f"the {name}", at=at)


@omni.link("one point", "One point of shape (3,) gives y of shape (2,) and Y_p of shape (2, 3).")
def _(f, rng):
    _two(f(some(rng, ())), ())


@omni.link("angles", "Azimuth = arctan2(y, x), elevation = arctan2(z, sqrt(x^2 + y^2)), in radians.", part=0)
def _(f, rng):
    for p in (np.array([1.0, 1.0, 0.0]), np.array([-2.0, 1.0, 1.0]), some(rng, ()), some(rng, ())):
        _angles(_two(f(p), ())[0], omni_project(p)[0], f"p = {p.round(2)}")


@omni.link("rays", "A ray has no length: three times as far, the same angles.", part=0)
def _(f, rng):
    p = some(rng, ())
    for s in (0.01, 1.0, 100.0):
        _angles(_two(f(s * p), ())[0], omni_project(p)[0], f"{s} times the same ray")


for row, name in enumerate(("azimuth", "elevation")):

    @omni.link(f"derivative of the {name}", f"Row {row} of Y_p: the derivative of the {name}.", part=1)
    def _(f, rng, row=row):
        for p in (some(rng, ()), some(rng, ()), np.array([-1.0, 2.0, 0.0]), 20 * some(rng, ())):
            Y_p = _two(f(p), ())[1]
            value = lambda q: omni_project(q)[0]
            expect.jacobian(Y_p, value, p, "Y_p", ["azimuth", "elevation"], ["x", "y", "z"], row=row, atol=1e-8)


@omni.link("many points", "Write p[..., 0], not p[0], and stack along axis=-1 and axis=-2.")
def _(f, rng):
    for lead in ((5,), (2, 3), (3,), (1,)):
        p = some(rng, lead)
        y, Y_p = _two(f(p), lead)
        want, WANT = omni_project(p)
        _angles(y, want, f"p of shape {p.shape}")
        expect.close(Y_p, WANT, "Y_p", at=f"p of shape {p.shape}")


def _wrong(name, hint, angles=None, rows=None):
    """A misconception: angles(x, y, z, s) or rows(x, y, z, s, r2) of the Jacobian."""

    @omni.wrong(name, hint)
    def _(p):
        x, y, z = p[..., 0], p[..., 1], p[..., 2]
        s = np.sqrt(x * x + y * y)
        value, J = omni_project(p)
        if angles:
            value = np.stack(angles(x, y, z, s), -1)
        if rows:
            J = np.stack([np.stack(row, -1) for row in rows(x, y, z, s, s * s + z * z)], -2)
        return value, J


# fmt: off
_wrong("arctan", "arctan(y / x) cannot tell ahead from behind: arctan2(y, x).",
       lambda x, y, z, s: (np.arctan(y / x), np.arctan2(z, s)))
_wrong("x and y swapped", "arctan2 takes the second coordinate first: arctan2(y, x).",
       lambda x, y, z, s: (np.arctan2(x, y), np.arctan2(z, s)))
_wrong("elevation first", "The order is [azimuth; elevation].",
       lambda x, y, z, s: (np.arctan2(z, s), np.arctan2(y, x)))
_wrong("angle from the vertical", "Elevation is counted from the x-y plane: arctan2(z, s), not arctan2(s, z).",
       lambda x, y, z, s: (np.arctan2(y, x), np.arctan2(s, z)))
_wrong("elevation against x", "Elevation is the angle above the *plane*: arctan2(z, sqrt(x^2 + y^2)).",
       lambda x, y, z, s: (np.arctan2(y, x), np.arctan2(z, x)))
_wrong("image coordinates", "A camera that looks all round has no image plane: the angles themselves, not y / x and "
       "z / s.", lambda x, y, z, s: (y / x, z / s))
_wrong("degrees", "All angles are in radians.",
       lambda x, y, z, s: (np.degrees(np.arctan2(y, x)), np.degrees(np.arctan2(z, s))))
_wrong("azimuth: sign", "d azimuth / dp = [-y, x, 0] / s^2: the minus belongs to y.",
       rows=lambda x, y, z, s, r2: ((y / s**2, -x / s**2, 0*x), (-x*z/s/r2, -y*z/s/r2, s/r2)))
_wrong("azimuth: not squared", "Check the units, rad/m: [-y, x, 0] / s^2.",
       rows=lambda x, y, z, s, r2: ((-y / s, x / s, 0*x), (-x*z/s/r2, -y*z/s/r2, s/r2)))
_wrong("azimuth: divided by r^2", "The azimuth is an angle in the plane: divide by s^2 = x^2 + y^2, without z.",
       rows=lambda x, y, z, s, r2: ((-y / r2, x / r2, 0*x), (-x*z/s/r2, -y*z/s/r2, s/r2)))
_wrong("elevation: s taken as constant", "s depends on x and y: the elevation of a point falls as it moves away.",
       rows=lambda x, y, z, s, r2: ((-y / s**2, x / s**2, 0*x), (0*x, 0*x, s/r2)))
_wrong("elevation: sign", "A point that moves away at constant height sinks: -x z / (s r^2).",
       rows=lambda x, y, z, s, r2: ((-y / s**2, x / s**2, 0*x), (x*z/s/r2, y*z/s/r2, s/r2)))
_wrong("elevation: inner derivative forgotten", "ds/dx = x / s: the s in the denominator is missing.",
       rows=lambda x, y, z, s, r2: ((-y / s**2, x / s**2, 0*x), (-x*z/r2, -y*z/r2, s/r2)))
# fmt: on


@omni.wrong("one point only", "p[0] is the first *point* of a list. Write p[..., 0].")
def _(p):
    if p.ndim == 1:
        return omni_project(p)
    return omni_project(p[0])


@omni.variant("with arcsin and complex numbers")
def _(p):
    p = np.asarray(p, float)
    s, r = np.linalg.norm(p[..., :2], axis=-1), np.linalg.norm(p, axis=-1)
    J = np.zeros((*p.shape[:-1], 2, 3))
    J[..., 0, 0], J[..., 0, 1] = -p[..., 1] / s**2, p[..., 0] / s**2
    J[..., 1, :] = (np.array([0, 0, 1]) - p * (p[..., 2] / r**2)[..., None]) / s[..., None]
    a = np.angle(p[..., 0] + 1j * p[..., 1])
    return np.stack([np.where(a < 0, a + 2 * np.pi, a), np.arcsin(p[..., 2] / r)], -1), J


@omni.variant("through the unit vector")
def _(p):
    r = np.linalg.norm(p, axis=-1, keepdims=True)
    m = p / r
    M_p = (np.eye(3) - m[..., :, None] * m[..., None, :]) / r[..., None]
    y, Y_m = omni_project(m)
    return y, Y_m @ M_p
