"""Worlds: where the landmarks of a simulated scenario are. Each function is one world type of the user's file.

Every world returns `ids, points`: identifiers 1, 2, ... of shape (N,), and positions in metres, (N, 2) or (N, 3).
A world that needs chance takes a `numpy.random.Generator` called `rng`.
"""

import numpy as np

MOST = 10**6
"""Landmarks: more would fill the memory before anybody has seen one."""


def _numbered(points):
    points = np.asarray(points, float)
    return np.arange(1, len(points) + 1), points


def _count(n):
    if n < 1:
        raise ValueError(f"a world needs 1 landmark or more, got n = {n}")
    if n > MOST:
        raise ValueError(f"a world has {MOST} landmarks at most, got n = {n:g}")
    return n


def _in_box(rng, n, **limits):
    for axis, (low, high) in limits.items():
        if low > high:
            raise ValueError(f"{axis}_min must not be above {axis}_max, got {low} and {high}")
    low, high = zip(*limits.values(), strict=True)
    return _numbered(rng.uniform(low, high, (_count(n), len(limits))))


def cloister(x_min=-6.0, x_max=6.0, y_min=-6.0, y_max=6.0, n=7, height=1.0):
    """Four walkways of columns around a court: the manual's default world (72 points as it is).

    Parameters
    ----------
    x_min, x_max, y_min, y_max : float
        Outer walls, metres.
    n : int
        Columns on a wall, corners included; the inner row stands one column spacing inside. At least 4.
    height : float or None
        Height of the upper end of the columns, whose lower ends are at 0. None gives the plan in 2D.

    Returns
    -------
    ids : ndarray, shape (N,)
    points : ndarray, shape (N, 3), or (N, 2) where `height` is None
        4 (2 n - 5) columns: north, west, south, east wall, the outer row of each before its inner row; first all lower
        ends, then all upper ends. The corners of the outer wall are empty.
    """
    if n < 4:
        raise ValueError(f"a cloister needs at least 4 columns on a wall to have an inner row, got n = {n}")
    x, y = np.linspace(x_min, x_max, _count(n)), np.linspace(y_min, y_max, n)

    def wall(along, outer, inner):
        """Outer row between the corners, then the inner row up to the corner that the next wall owns."""
        rows = [(a, outer) for a in along[1:-1]], [(a, inner) for a in along[1:-2]]
        return np.array(rows[0] + rows[1])

    north, south = wall(x, y[-1], y[-2]), wall(x[::-1], y[0], y[1])
    west, east = wall(y, x[0], x[1])[:, ::-1], wall(y[::-1], x[-1], x[-2])[:, ::-1]
    plan = np.concatenate([north, west, south, east])
    if height is None:
        return _numbered(plan)
    return _numbered([[*p, z] for z in (0.0, height) for p in plan])


def ring(n=20, radius=6.0, centre=(0.0, 0.0)):
    """`n` landmarks at equal angles on a circle in the plane, the first on its x axis."""
    a = 2 * np.pi * np.arange(_count(n)) / n
    return _numbered(np.asarray(centre) + radius * np.stack([np.cos(a), np.sin(a)], -1))


def random2(rng, n=30, x_min=-6.0, x_max=6.0, y_min=-6.0, y_max=6.0):
    """`n` landmarks spread at random over a rectangle in the plane."""
    return _in_box(rng, n, x=(x_min, x_max), y=(y_min, y_max))


def random3(rng, n=60, x_min=-6.0, x_max=6.0, y_min=-6.0, y_max=6.0, z_min=0.0, z_max=2.0):
    """`n` landmarks spread at random over a box in space."""
    return _in_box(rng, n, x=(x_min, x_max), y=(y_min, y_max), z=(z_min, z_max))


def lecture():
    """The world of the mapping lecture's figures: 16 landmarks in the plane around the robot's round."""
    # fmt: off
    return _numbered([
        ( 1.6, -5.2), ( 4.6, -3.6), ( 6.3, -0.9), ( 5.2,  2.2),
        ( 3.4,  4.9), ( 0.4,  5.9), (-2.7,  5.3), (-5.1,  3.4),
        (-6.2,  0.3), (-5.4, -2.8), (-3.1, -5.0), (-0.8, -2.2),
        ( 1.9, -1.4), ( 2.0,  1.5), (-0.6,  2.4), (-2.3,  0.2),
    ])
    # fmt: on


def points(points: tuple, ids: tuple | None = None):
    """Landmarks written down one by one, in metres; numbered 1, 2, ... unless `ids` says otherwise."""
    numbers, p = _numbered(points)
    return (numbers if ids is None else np.asarray(ids)), p
