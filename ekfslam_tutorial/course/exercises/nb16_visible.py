"""Exercise 16.2: which points a sensor can see."""

import numpy as np

from ..table import table


def beacon_visible(y, p, max_range, fov):
    """Return True for each point that a range-only sensor can see.

    y, shape (..., 1): the ranges (m) of the points p, shape (..., 2), in the frame of the sensor (m); any number of
    leading axes, also none. The antenna looks along the x axis. It sees a point that is not further away than
    max_range (m), and not more than fov / 2 (rad) to the left or to the right; fov is the whole width of its view.
    Return True or False for each point, shape (...).
    """
    bearing = np.arctan2(p[..., 1], p[..., 0])
    return (y[..., 0] <= max_range) & (np.abs(bearing) <= fov / 2)


def polar(r, bearing_deg):
    """Ranges and points, y and p, from ranges and bearings in degrees."""
    r, a = np.broadcast_arrays(np.asarray(r, float), np.radians(np.asarray(bearing_deg, float)))
    return r[..., None].copy(), r[..., None] * np.stack([np.cos(a), np.sin(a)], -1)


def one_by_one(r, bearings_deg, max_range, fov_deg):
    """One call for each point, so that a message can show it; and one for all of them."""
    r = np.broadcast_to(r, len(bearings_deg))
    view = float(max_range), float(np.radians(fov_deg))
    return [*((*polar(a, b), *view) for a, b in zip(r, bearings_deg, strict=True)), (*polar(r, bearings_deg), *view)]


def stack(rng, lead):
    """Points in a stack of any shape."""
    y, p = polar(rng.uniform(1, 8, lead), rng.uniform(-180, 180, lead))
    return y, p, rng.uniform(3, 6), rng.uniform(1, 5)


def _exactly(p, max_range, fov):
    return np.array([np.hypot(*p)]), np.array(p, float), max_range, fov


seen = table(
    "16.2 What the sensor can see",
    beacon_visible,
    hints=(
        "Two conditions, and both must hold: the range, and the bearing of the point.",
        "The bearing is arctan2(py, px). fov is the whole width, half of it on each side: |bearing| <= fov / 2.",
        "For arrays `and` does not work: (y[..., 0] <= max_range) & (np.abs(bearing) <= fov / 2).",
    ),
    returns="seen",
    cases={
        "any": lambda rng: [(*polar(2.0, 10.0), 5.0, np.pi), (*polar(9.0, 10.0), 5.0, np.pi)],
        "range": lambda rng: [
            case
            for max_range in (5, 15)
            for case in one_by_one(
                [1.0, 4.9, 5.1, 20.0, 3, 3, 3, 3, 3, 3], [0, 5, -5, 0, 40, -40, 60, -60, 130, -130], max_range, 100
            )
        ],
        "sides": lambda rng: [
            case
            for fov in (60, 200)
            for case in one_by_one(3.0, [25, 35, -25, -35, 55, -55, 95, -95, 110, -110], 5, fov)
        ],
        "behind": lambda rng: [
            *one_by_one(3.0, [180, 170, -170, 95, -95, 20], 5, 90),
            *one_by_one(3.0, [179, -179, 100, -100, 20], 5, 360),
        ],
        "limits": lambda rng: [
            _exactly([3, 4], 5.0, 3.0),
            _exactly([4, -3], 5.0, 3.0),
            _exactly([5, 0], 5.0, 0.0),
            _exactly([-2, 0], 5.0, 2 * np.pi),
        ],
        "many": lambda rng: [stack(rng, lead) for lead in ((40,), (6, 7), (2,), (1,), ())],
    },
    checks="""
    one point  | seen | any    | Seen: the range is at most max_range, and the angle from the x axis at most fov / 2. One point gives one truth value, an array or a number without axes.
    range      | seen | range  | Not further away than max_range, and the angle from the x axis not more than fov / 2, one truth value for each point.
    both sides | seen | sides  | All points are within max_range here. Seen are those at an angle of at most fov / 2 (rad) from the x axis, to the left as to the right, with a fov of 60 degrees and with one of 200 degrees.
    behind it  | seen | behind | Points behind the sensor are more than 90 degrees from the x axis: none of them is seen with a fov of 90 degrees, all are with one of 360 degrees. arctan2(py, px) gives angles from -pi to pi.
    limits     | seen | limits | "Not further away than" and "not more than": a point on the limit itself is seen, <=.
    any number of points | seen | many | One truth value for each point: y (6, 7, 1) and p (6, 7, 2) give the shape (6, 7). p[..., 0] and y[..., 0] work for one point, for a list, and for a table of points.
    """,
    wrong="""
    the whole fov on each side | fov / 2 -> fov | fov is the *whole* width: only half of it lies on each side.
    sign of the bearing | np.abs(bearing) -> bearing | A point to the right has a negative bearing, and would always be seen: take |bearing|.
    only to the left | (np.abs(bearing) <= fov / 2) -> (bearing >= 0) & (bearing <= fov / 2) | The view goes to the right, too: -fov / 2 <= bearing <= fov / 2.
    from zero to fov | (np.abs(bearing) <= fov / 2) -> (bearing >= 0) & (bearing <= fov) | The x axis is the *middle* of the view: -fov / 2 to fov / 2.
    degrees | np.abs(bearing) -> np.abs(np.degrees(bearing)) | Everything is in radians, fov too.
    one of the two | max_range) & (np -> max_range) | (np | Both must hold, the range *and* the view: `&` joins two conditions.
    range forgotten | (y[..., 0] <= max_range) & (np.abs(bearing) <= fov / 2) -> np.abs(bearing) <= fov / 2 | A point beyond max_range is not seen.
    range along x | y[..., 0] <= max_range -> p[..., 0] <= max_range | The range is y, the distance of the point; p[..., 0] is only how far ahead it is.
    view forgotten | (y[..., 0] <= max_range) & (np.abs(bearing) <= fov / 2) -> y[..., 0] <= max_range | A point outside the field of view is not seen.
    arctan | np.arctan2(p[..., 1], p[..., 0]) -> np.arctan(p[..., 1] / p[..., 0]) | A point behind is more than 90 degrees from the x axis. arctan2(py, px) tells it from one ahead, arctan(py / px) does not.
    px and py swapped | np.arctan2(p[..., 1], p[..., 0]) -> np.arctan2(p[..., 0], p[..., 1]) | arctan2 takes y first: arctan2(py, px).
    the other way round | return (y[..., 0] <= max_range) & (np.abs(bearing) <= fov / 2) -> return (y[..., 0] > max_range) | (np.abs(bearing) > fov / 2) | That is True where the sensor is blind.
    a point at max_range | y[..., 0] <= max_range -> y[..., 0] < max_range | "Not further away than max_range": a point just there is seen, <=.
    a point on the edge of the view | <= fov / 2 -> < fov / 2 | "Not more than fov / 2": a point just there is seen, <=, as it is at max_range.
    last axis of the ranges kept | y[..., 0] <= max_range -> y <= max_range | y has a last axis of length one: y[..., 0] is one range for each point.
    one of the two, and from zero to fov: Both must hold, the range *and* the view, and the view reaches fov / 2 to each side of the x axis.
        bearing = np.arctan2(p[..., 1], p[..., 0]) -> bearing = np.mod(np.arctan2(p[..., 1], p[..., 0]), 2 * np.pi)
        (y[..., 0] <= max_range) & (np.abs(bearing) <= fov / 2) -> (y[..., 0] <= max_range) | (bearing <= fov)
    only ahead | (np.abs(bearing) <= fov / 2) -> (np.abs(bearing) <= fov / 2) & (p[..., 0] > 0) | The sector alone decides: where fov is more than half a turn points behind are seen, too.
    range squared | (y[..., 0] <= max_range) -> (y[..., 0] ** 2 <= max_range) | y is the range itself: compare it with max_range without a square.
    """,
)
