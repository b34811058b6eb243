"""Exercise 16.5 (stretch): the direct model of a camera that looks all round."""

import numpy as np

from ..table import table


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
    angles = np.stack([np.arctan2(y, x), np.arctan2(z, s)], axis=-1)
    A_p = np.stack([-y / s2, x / s2, 0 * x], axis=-1)
    E_p = np.stack([-x * z / (s * r2), -y * z / (s * r2), s / r2], axis=-1)
    return angles, np.stack([A_p, E_p], axis=-2)


def some(rng, lead=()):
    """Points all round, up to 60 degrees above and below."""
    a, e, r = rng.uniform(-3, 3, lead), rng.uniform(-1, 1, lead), rng.uniform(1, 6, lead)
    return np.stack([r * np.cos(e) * np.cos(a), r * np.cos(e) * np.sin(a), r * np.sin(e)], -1)


omni = table(
    "16.5 A camera that looks all round (stretch)",
    omni_project,
    hints=(
        "Azimuth = arctan2(y, x). With s = sqrt(x^2 + y^2), elevation = arctan2(z, s).",
        "d arctan2(a, b) = (b da - a db) / (a^2 + b^2). For the elevation a = z, b = s; ds/dx = x / s, ds/dy = y / s.",
        "Rows: [-y, x, 0] / s^2 and [-x z / s, -y z / s, s] / (s^2 + z^2). np.stack(..., axis=-2) puts them together.",
    ),
    returns="y, Y_p",
    angles={"y": np.s_[..., 0]},
    cases={
        "any": lambda rng: [
            (p,) for p in (np.array([1.0, 1, 0]), np.array([-2.0, 1, 1]), np.array([-1.0, 2, 0]), some(rng), some(rng))
        ],
        "rays": lambda rng: [(scale * some(rng),) for scale in (0.01, 1, 20, 100)],
        "many": lambda rng: [(some(rng, lead),) for lead in ((5,), (2, 3), (3,), (1,))],
    },
    checks="""
    angles      | y               | any  | Azimuth = arctan2(y, x), elevation = arctan2(z, sqrt(x^2 + y^2)), in radians. One point gives y of shape (2,).
    rays        | y               | rays | Points on all sides, 0.01 to 600 m away. A ray has no length: three times as far, the same angles.
    derivative of the azimuth   | Y_p[..., 0, :] | any | Row 0 of Y_p: the derivative of the azimuth. One point gives Y_p of shape (2, 3).
    derivative of the elevation | Y_p[..., 1, :] | any | Row 1 of Y_p: the derivative of the elevation.
    derivatives for rays | Y_p   | rays | Points on all sides, 0.01 to 600 m away. Three times as far, a third of the derivatives: the nearer the point, the more the angles change when it moves.
    many points | y, Y_p | many | Any number of leading axes, in their order: x = p[..., 0], and stack along axis=-1 and axis=-2.
    """,
    wrong="""
    arctan | np.arctan2(y, x) -> np.arctan(y / x) | arctan(y / x) cannot tell ahead from behind: arctan2(y, x).
    x and y swapped | np.arctan2(y, x) -> np.arctan2(x, y) | arctan2 takes the second coordinate first: arctan2(y, x).
    rows stacked behind the columns | np.stack([A_p, E_p], axis=-2) -> np.stack([A_p, E_p], axis=-1) | axis=-1 makes columns of the two rows, shape (..., 3, 2): a Jacobian has its outputs in rows, axis=-2.
    elevation first | [np.arctan2(y, x), np.arctan2(z, s)] -> [np.arctan2(z, s), np.arctan2(y, x)] | The order is [azimuth; elevation].
    angle from the vertical | np.arctan2(z, s) -> np.arctan2(s, z) | Elevation is counted from the x-y plane, 0 in the plane and pi / 2 straight up: arctan2(z, sqrt(x^2 + y^2)).
    elevation against x | np.arctan2(z, s) -> np.arctan2(z, x) | Elevation is the angle above the *plane*: arctan2(z, sqrt(x^2 + y^2)).
    image coordinates | [np.arctan2(y, x), np.arctan2(z, s)] -> [y / x, z / s] | A camera that looks all round has no image plane: the angles themselves, not y / x and z / s.
    degrees | return angles -> return np.degrees(angles) | All angles are in radians.
    azimuth from y: The azimuth is counted from x towards y: arctan2(y, x), and its derivative is that of this angle.
        np.arctan2(y, x) -> np.arctan2(x, y)
        [-y / s2, x / s2, 0 * x] -> [y / s2, -x / s2, 0 * x]
    azimuth: sign | [-y / s2, x / s2, 0 * x] -> [y / s2, -x / s2, 0 * x] | The derivative of the azimuth is [-y, x, 0] / (x^2 + y^2): the minus belongs to y.
    azimuth: not squared | [-y / s2, x / s2, 0 * x] -> [-y / s, x / s, 0 * x] | Check the units, rad/m: [-y, x, 0] / (x^2 + y^2).
    azimuth: divided by r^2 | [-y / s2, x / s2, 0 * x] -> [-y / r2, x / r2, 0 * x] | The azimuth is an angle in the plane: divide by x^2 + y^2, without z.
    elevation: s taken as constant | [-x * z / (s * r2), -y * z / (s * r2), s / r2] -> [0 * x, 0 * x, s / r2] | s depends on x and y: the elevation of a point falls as it moves away.
    elevation: sign | [-x * z / (s * r2), -y * z / (s * r2), s / r2] -> [x * z / (s * r2), y * z / (s * r2), s / r2] | A point that moves away at constant height sinks: by x and y there is a minus.
    elevation: inner derivative forgotten | [-x * z / (s * r2), -y * z / (s * r2), s / r2] -> [-x * z / r2, -y * z / r2, s / r2] | sqrt(x^2 + y^2) has the derivative x / sqrt(x^2 + y^2) by x: that root in the denominator is missing.
    elevation: divided by s^2 | [-x * z / (s * r2), -y * z / (s * r2), s / r2] -> [-x * z / (s * s2), -y * z / (s * s2), s / s2] | The elevation is an angle in space: divide by x^2 + y^2 + z^2, the square of the whole distance.
    one point only | x, y, z = p[..., 0], p[..., 1], p[..., 2] -> x, y, z = p if p.ndim == 1 else p[0].reshape(-1, 3)[0] | p[0] is the first *point* of a list. Write p[..., 0].
    angle from the vertical, in all: Elevation is counted from the x-y plane, 0 in the plane and pi / 2 straight up: arctan2(z, sqrt(x^2 + y^2)).
        np.arctan2(z, s) -> np.arctan2(s, z)
        [-x * z / (s * r2), -y * z / (s * r2), s / r2] -> [x * z / (s * r2), y * z / (s * r2), -s / r2]
    derivative by the unit vector | return angles, np.stack([A_p, E_p], axis=-2) -> return angles, np.stack([A_p, E_p], axis=-2) * np.sqrt(r2)[..., None, None] | Y_p is the derivative by p itself: the same error turns a far point less. Yours is that by p / |p|.
    square for the distance in the plane | np.arctan2(z, s)], -> np.arctan2(z, s2)], | Elevation is arctan2(z, sqrt(x^2 + y^2)): the root is missing.
    downwards, in all: Elevation is positive upwards, as z is: arctan2(z, sqrt(x^2 + y^2)), and so are its derivatives.
        np.arctan2(z, s)], -> -np.arctan2(z, s)],
        E_p = np.stack([-x * z / (s * r2), -y * z / (s * r2), s / r2], -> E_p = np.stack([x * z / (s * r2), y * z / (s * r2), -s / r2],
    elevation: divided by the distance in the plane | [-x * z / (s * r2), -y * z / (s * r2), s / r2] -> [0 * x, 0 * x, 1 / s] | s depends on x and y, and r on z: the elevation of a point falls as it moves away, and its row is [-x z / s, -y z / s, s] / r^2, with s = sqrt(x^2 + y^2) and r = |p|.
    elevation by the arcsine of z | np.arctan2(z, s)] -> np.arcsin(np.clip(z, -1, 1))] | arcsin takes z / |p|, and p has any length: arctan2(z, sqrt(x^2 + y^2)) needs no |p|.
    """,
)
