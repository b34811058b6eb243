"""Worlds: where the landmarks of a simulated scenario are. Each function is one world type of the user's file.

Every world returns `ids, points`: identifiers 1, 2, ... of shape (N,), and positions in metres, (N, 2) or (N, 3). One
with straight edges returns `segment_ids, segments` behind them, (M,) and both ends of each, (M, 6); their identifiers
go on where those of the points end.
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


def columns(x_min=-6.0, x_max=6.0, y_min=-6.0, y_max=6.0, n=7, height=2.0):
    """The cloister, seen as edges and points: its columns are vertical segments, their lower and upper ends points.

    Parameters are those of `cloister`; the height must be a number.
    """
    ids, p = cloister(x_min, x_max, y_min, y_max, n, height)
    return ids, p, *_segments(len(ids), np.concatenate(np.split(p, 2), 1))


def house(width=5.0, depth=5.0, wall=2.6, ridge=1.4, corners=False):
    """A house with a gable roof, a door and a window: 23 straight edges. Its middle is the origin, its floor at z = 0.

    Parameters
    ----------
    width, depth : float
        Along x and along y, m. The ridge of the roof goes along x.
    wall, ridge : float
        Height of the walls, and of the ridge above them, m.
    corners : bool
        The ends of the edges are landmarks, too: points.

    Returns
    -------
    ids, points : ndarray, shape (N,), (N, 3)
        The corners, or none.
    segment_ids, segments : ndarray, shape (23,), (23, 6)
    """
    x, y, top = width / 2, depth / 2, wall + ridge
    plan = [(-x, -y), (x, -y), (x, y), (-x, y)]
    ring = lambda z: [((*plan[i], z), (*plan[(i + 1) % 4], z)) for i in range(4)]
    edges = ring(0.0) + ring(wall) + [((*c, 0.0), (*c, wall)) for c in plan]
    edges += [((s * x, t * y, wall), (s * x, 0.0, top)) for s in (-1, 1) for t in (-1, 1)] + [
        ((-x, 0, top), (x, 0, top))
    ]
    door = [(-x, 0.2 * y, 0.0), (-x, 0.2 * y, 2.0), (-x, 0.6 * y, 2.0), (-x, 0.6 * y, 0.0)]
    window = [(-x, -0.2 * y, 1.0), (-x, -0.2 * y, 2.0), (-x, -0.7 * y, 2.0), (-x, -0.7 * y, 1.0)]
    edges += list(zip(door[:-1], door[1:], strict=True)) + list(zip(window[:-1], window[1:], strict=True))
    edges = np.array(edges, float).reshape(-1, 6)
    points = np.unique(edges.reshape(-1, 3), axis=0) if corners else np.zeros((0, 3))
    return *_numbered(points), *_segments(len(points), edges)


def _segments(n, edges):
    """Edges behind n points, numbered on from there."""
    return np.arange(n + 1, n + len(edges) + 1), edges


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
