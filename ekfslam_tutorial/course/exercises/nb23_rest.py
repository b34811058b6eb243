"""Exercise 23.4: what an IMU at rest knows."""

import numpy as np

from ...geometry import e2q, q2R, unit, v2q
from .. import expect
from ..table import table


def from_rest(w, a, acc_bias_std):
    """What an IMU that lies still knows of itself: what is down, and the bias of its gyrometer.

    w (rad/s) and a (m/s^2), both of shape (n, 3): what the two have measured, n times, in the axes of the IMU. An
    accelerometer at rest measures what holds it up: 9.81 m/s^2, upwards. The world's z axis points up. The IMU may lie
    in any way, upside down, too. acc_bias_std (m/s^2): of the bias of the accelerometer nothing is known but this
    standard deviation, the same for each axis.
    Return q, shape (4,): an orientation that brings the mean of a to z; any yaw will do, nobody can know it. b_w, shape
    (3,): the bias of the gyrometer. And tilt_std (rad): by so much each of the two angles of the tilt is uncertain (1
    sigma), because of the bias of the accelerometer. Let n be so large that the noise does not matter beside it.
    """
    up = a.mean(0) / np.linalg.norm(a.mean(0))
    q = np.array([1 + up[2], up[1], -up[0], 0.0])  # the shortest turn from up to z
    if not q.any():
        q[1] = 1.0  # upside down: half a turn about any axis across z
    return q / np.linalg.norm(q), w.mean(0), acc_bias_std / 9.81


def rows(rng, up, noise=1.0, n=40):
    """Return what is measured at rest, by the direction that is up."""
    w = rng.uniform(-0.05, 0.05, 3) + noise * 0.01 * rng.normal(size=(n, 3))
    a = 9.81 * unit(np.asarray(up, float))[0] + noise * (rng.uniform(-0.2, 0.2, 3) + 0.1 * rng.normal(size=(n, 3)))
    return w, a, float(rng.uniform(0.02, 0.3))


def any_yaw(taken, right=None):
    """Return the results with the orientation without its yaw, but with its length: all right ones become the same."""
    q, *rest = taken
    q = np.asarray(q, float)
    length = np.linalg.norm(q)
    if length < 1e-9:
        return taken
    up = q2R(q / length)[0][2]
    level = np.array([1 + up[2], up[1], -up[0], 0.0])
    level = level if level[0] > 1e-9 else np.array([0, 1.0, 0, 0])
    return length * unit(level)[0], *rest


exercise = table(
    "23.4 Start from rest",
    from_rest,
    hints=(
        "Means over the n rows: that of w is the bias, as nothing turns. That of a points up, in the axes of the IMU.",
        "Roll and pitch, for e2q: arctan2(a_y, a_z) and arctan2(-a_x, hypot(a_y, a_z)), with yaw 0. A bias across gravity, b, looks like a tilt by the angle b / 9.81.",
        "Without Euler angles: up = mean of a, divided by its length; the shortest turn from up to z is [1 + up_z, up_y, -up_x, 0], divided by its length; upside down, where that is zero, [0, 1, 0, 0]. tilt_std = acc_bias_std / 9.81.",
    ),
    returns="q, b_w, tilt_std",
    rtol={"tilt_std": 1e-3},  # arctan(b / 9.81) is another 3e-4, at most, and as good
    settled=any_yaw,
    canonical=any_yaw,
    cases={
        "any": lambda rng: [rows(rng, rng.normal(size=3) * [1, 1, 0.8] + [0, 0, 0.4], n=n) for n in (40, 7, 100, 25)],
        "level": lambda rng: [rows(rng, [0, 0, 1], noise=0.0)],
        "upside down": lambda rng: [rows(rng, [0, 0, -1], noise=0.0)],
        "on its tail": lambda rng: [rows(rng, [1, 0, 0], noise=0.0), rows(rng, [0, -1, 0], noise=0.0)],
    },
    checks="""
    level       | q        | level       | It lies level: R(q) must leave the z axis where it is. q has the length 1.
    on its tail | q        | on its tail | R(q) must bring the measured a to the z axis of the world.
    upside down | q        | upside down | a points along -z: half a turn about x, or any other axis across z. Where a formula divides by zero there, or gives no turn at all, this case wants its own line.
    orientation | q        | any         | The mean of a points up, and R(q) brings it to z: R(q) mean(a) = [0, 0, |mean(a)|], and |mean(a)| need not be 9.81. q has the length 1.
    gyrometer   | b_w      | any         | Nothing turns: what the gyrometer measures, in the mean, is its bias.
    tilt        | tilt_std | any         | A bias b across gravity looks like gravity that is tilted by b / 9.81 rad. It is the same in all n rows.
    """,
    wrong="""
    down for up | up = a.mean(0) -> up = -a.mean(0) | At rest an accelerometer measures what holds it *up*, not gravity.
    the other way round | np.array([1 + up[2], up[1], -up[0], 0.0]) -> np.array([1 + up[2], -up[1], up[0], 0.0]) | q brings vectors from the IMU into the world: R(q) a must be along z. Yours is the conjugate.
    first row only: One row has all its noise: take the mean over the n rows.
        up = a.mean(0) / np.linalg.norm(a.mean(0)) -> up = a[0] / np.linalg.norm(a[0])
        w.mean(0) -> w[0]
    a not made a unit vector | / np.linalg.norm(a.mean(0)) -> / 9.81 | The length of the measured a is not exactly 9.81, as it has a bias: divide by its own length.
    a in m/s^2 | up = a.mean(0) / np.linalg.norm(a.mean(0)) -> up = a.mean(0) | A direction is wanted: divide by the length.
    twice the turn | np.array([1 + up[2], up[1], -up[0], 0.0]) -> np.array([up[2], up[1], -up[0], 0.0]) | That quaternion turns by the whole angle on either side, twice too much: halve the angle.
    arcsine | q = np.array([1 + up[2], up[1], -up[0], 0.0]) -> q = _by_arcsine(up) | An arcsine ends at 90 degrees: a tilt of 120 degrees looks like one of 60. The angle is arctan2(hypot(up_x, up_y), up_z).
    arcsine, but for half a turn | q = np.array([1 + up[2], up[1], -up[0], 0.0]) -> q = _by_arcsine(up) if np.hypot(*up[:2]) > 1e-9 else np.array([1.0 + up[2], 0.0, 0.0, 0.0]) | An arcsine ends at 90 degrees: a tilt of 120 degrees looks like one of 60. The angle is arctan2(hypot(up_x, up_y), up_z).
    pitch from two of three | q = np.array([1 + up[2], up[1], -up[0], 0.0]) -> q = _by_euler(np.arctan2(up[1], up[2]), np.arctan2(-up[0], up[2])) | The roll is arctan2(a_y, a_z). The pitch is what is left: arctan2(-a_x, hypot(a_y, a_z)), with both a_y and a_z.
    roll by a quotient | q = np.array([1 + up[2], up[1], -up[0], 0.0]) -> q = _by_euler(np.arctan(np.divide(*up[1:])), np.arctan2(-up[0], np.hypot(*up[1:]))) | arctan(a_y / a_z) does not tell up from down, and has no value on the side. np.arctan2(a_y, a_z) does.
    q not made a unit quaternion | q / np.linalg.norm(q) -> q | An orientation is a quaternion of length 1.
    no turn | q / np.linalg.norm(q) -> np.array([1.0, 0, 0, 0]) | It does not lie level: roll and pitch follow from the mean of a. A turn about z changes neither.
    median | w.mean(0) -> np.median(w, 0) | The mean is asked for: of white noise it is the best there is.
    one mean for all axes | w.mean(0) -> w.mean() * np.ones(3) | Each axis has a bias of its own: w.mean(0), not one mean of all numbers.
    no bias | w.mean(0) -> 0 * w.mean(0) | What a gyrometer at rest measures is its bias.
    sign of the bias | w.mean(0) -> -w.mean(0) | measured = true + bias, and the true rate is zero: the bias is what is measured.
    spread for bias | w.mean(0) -> w.std(0) | That is the noise. The bias is the mean.
    averaged away | acc_bias_std / 9.81 -> acc_bias_std / 9.81 / np.sqrt(len(a)) | A bias is the same in all rows: no mean makes it smaller.
    gravity forgotten | acc_bias_std / 9.81 -> acc_bias_std | b across 9.81 m/s^2: the angle is b / 9.81.
    length of the mean | acc_bias_std / 9.81 -> acc_bias_std / np.linalg.norm(a.mean(0)) | Gravity is known, 9.81 m/s^2: divide by it. The length of the mean has the bias in it.
    nothing upside down | q[1] = 1.0 -> pass | Upside down [1 + up_z, up_y, -up_x, 0] is zero: take half a turn about any axis across z, [0, 1, 0, 0].
    times gravity | acc_bias_std / 9.81 -> acc_bias_std * 9.81 | The larger gravity is, the less a bias tilts it: b / 9.81.
    tilt in degrees | acc_bias_std / 9.81 -> np.degrees(acc_bias_std / 9.81) | tilt_std is asked for in radians.
    length of both | acc_bias_std / 9.81 -> np.sqrt(2) * acc_bias_std / 9.81 | Each of the two angles has its own bias: acc_bias_std / 9.81 for each.
    b_w turned into the world: The bias of the gyrometer belongs to the axes of the IMU: the mean of w as it is, not turned.
        w.mean(0) -> q2R(_by_euler(np.arctan2(up[1], up[2]), np.arctan2(-up[0], np.hypot(*up[1:]))))[0] @ w.mean(0)
    b_w turned into the world by the shortest turn: The bias of the gyrometer belongs to the axes of the IMU: the mean of w as it is, not turned.
        w.mean(0) -> q2R(q / np.linalg.norm(q))[0] @ w.mean(0)
    divided by the vertical part | acc_bias_std / 9.81 -> acc_bias_std / abs(a.mean(0)[2]) | A bias across gravity tilts by b / 9.81, however the IMU lies: not by b over its own z component.
    roll and pitch in the wrong order | q = np.array([1 + up[2], up[1], -up[0], 0.0]) -> q = q_prod(e2q(np.array([np.arctan2(up[1], up[2]), 0, 0]))[0], e2q(np.array([0, np.arctan2(-up[0], np.hypot(*up[1:])), 0]))[0])[0] | The roll is found first, so it turns first and stands on the right: q = q_pitch q_roll.
    no turn upside down | q[1] = 1.0 -> q[0] = 1.0 | [1, 0, 0, 0] is no turn at all: right where the IMU lies level, but upside down it takes half a turn about any axis across z, [0, 1, 0, 0]. The sign of the mean of a_z tells which.
    """,
)


@exercise.link("any number of rows", "The means are over the n rows, whatever n is.")
def _(f, rng):
    args = rows(rng, [0.2, -0.3, 0.9], n=1)
    q, b_w, tilt = expect.results(f(*args), "q", "b_w", "tilt_std")
    want = from_rest(*args)
    got = any_yaw([expect.array(q, 4, "q"), expect.array(b_w, 3, "b_w"), expect.array(tilt, (), "tilt_std")], want)
    for name, a, b, rtol in zip(("q", "b_w", "tilt_std"), got, want, (1e-5, 1e-5, 1e-3), strict=True):
        expect.close(a, b, name, rtol, at="one row")


def _by_arcsine(up):
    """The turn from up to z about the axis across both, with the arcsine of its length for the angle."""
    axis = np.array([up[1], -up[0], 0.0])
    s = np.linalg.norm(axis)
    return v2q(np.arcsin(min(s, 1.0)) * (axis / s if s else axis))[0]


def _by_euler(roll, pitch):
    """The orientation with these two angles, and no yaw."""
    return e2q(np.array([roll, pitch, 0.0]))[0]
