"""Exercise 22.6: which part of a line has been seen."""

import numpy as np

from ..table import table
from .nb22_project import line_of


def extend(t, l, c, m):
    """The part of a line that has been seen, after one more segment.

    l = [n; v], shape (6,), is a Plücker line. Its points are p0 + t d, with p0 = v x n / v'v, the point nearest to the
    origin, and d = v / |v|; so t, in metres, says where on the line. t = [t1, t2], shape (2,), t1 < t2, is the part
    seen so far. A camera at c, shape (3,), has seen a segment of it: m, shape (2, 3), are the rays of its two ends, in
    the world, in any order and of any length. A measured ray misses the line a little: take the point of the line that
    is nearest to the ray.
    Return the new [t1, t2], shape (2,): it holds all that was seen before, and all that is seen now.
    """
    n, v = l[:3], l[3:]
    p0, d = np.cross(v, n) / (v @ v), v / np.linalg.norm(v)
    both = [np.column_stack([d, -ray]) for ray in m]  # p0 + t d = c + s ray, for t and s
    seen = [np.linalg.solve(A.T @ A, A.T @ (c - p0))[0] for A in both]
    return np.array([min(t[0], *seen), max(t[1], *seen)])


def case(rng, seen, t=(-1.0, 1.0), miss=0.02):
    """A line, what was seen of it, and a camera that sees it between two places, by their share of t."""
    a = rng.uniform(-3, 3, 3)
    d = rng.normal(size=3)
    d /= np.linalg.norm(d)
    l = line_of(a, a + rng.uniform(0.4, 2.5) * d)
    p0 = np.cross(l[3:], l[:3]) / (l[3:] @ l[3:])
    c = p0 + 4 * rng.normal(size=3)
    rays = p0 + np.array(seen)[:, None] * d - c + miss * rng.normal(size=(2, 3))
    return np.array(t), l, c, rays * rng.uniform(0.3, 2.0, (2, 1))


grown = table(
    "22.6 The part that has been seen",
    extend,
    hints=(
        "First where the two rays meet the line: two abscissas. Then the smallest and the largest of four numbers.",
        "p0 + t d = c + s m has three equations for t and s: least squares gives the point nearest to the ray.",
        "A = np.column_stack([d, -ray]); t, s = np.linalg.solve(A.T @ A, A.T @ (c - p0)), for each ray.",
    ),
    returns="t",
    cases={
        "any": lambda rng: [case(rng, (-0.4, 2.0)), case(rng, (-3.0, 1.4), (-0.5, 0.7))],
        "inside": lambda rng: [case(rng, (-0.5, 0.3)), case(rng, (0.4, -0.2))],
        "one side": lambda rng: [case(rng, (0.2, 2.0)), case(rng, (-2.0, 0.1)), case(rng, (1.7, 2.4))],
        "backwards": lambda rng: [case(rng, (2.0, -1.6)), case(rng, (0.5, -1.8)), case(rng, (2.2, 0.1))],
    },
    checks="""
    seen on both sides | t | any       | For each of the two rays, c + s m with any s, the abscissa t of the point of the line that is nearest to it: that point is p0 + t d, and t has a sign. Then the smallest and the largest of all.
    seen inside        | t | inside    | What was seen before stays: a shorter segment takes nothing away.
    seen on one side   | t | one side  | What is new lies on one side, in one of the cases beyond a gap: the end on that side moves out to it, the other end stays.
    ends in any order  | t | backwards | Which end of a segment comes first means nothing: take the smallest and the largest of all.
    """,
    wrong="""
    what is seen now | np.array([min(t[0], *seen), max(t[1], *seen)]) -> np.sort(seen) | What was seen before is forgotten: the part must hold both.
    what was seen before | np.array([min(t[0], *seen), max(t[1], *seen)]) -> t | The segment adds something: the part grows by what is seen now.
    what both have | np.array([min(t[0], *seen), max(t[1], *seen)]) -> np.array([max(t[0], min(seen)), min(t[1], max(seen))]) | That is the part seen both times. All that was seen at any time is asked for.
    ends taken in order | np.array([min(t[0], *seen), max(t[1], *seen)]) -> np.array([min(t[0], seen[0]), max(t[1], seen[1])]) | The ends come in any order: the second may be the smaller one. Compare with both.
    distance from the camera | (c - p0))[0] -> (c - p0))[1] | That is s, how far along the ray. What is asked for is t, along the line.
    direction not of length one | v / np.linalg.norm(v) -> v | t is in metres: d has the length one, v has not.
    direction not of length one, in the formula | np.linalg.solve(A.T @ A, A.T @ (c - p0))[0] -> (v @ (w := c - p0) - (k := v @ (g := -A[:, 1] / np.linalg.norm(A[:, 1]))) * (g @ w)) / (1 - k * k) | t is in metres: d has the length one, v has not.
    p0 on the other side | np.cross(v, n) / -> np.cross(n, v) / | The point nearest to the origin is v x n / v'v, in this order.
    p0 too far | np.cross(v, n) / (v @ v) -> np.cross(v, n) / np.linalg.norm(v) | p0 = v x n / v'v: divide by the square of the length.
    from the camera to the line | (c - p0))[0] -> (p0 - c))[0] | t has the wrong sign. p0 + t d = c + s m says t d - s m = c - p0, not p0 - c; and d = v / |v|, not -v / |v|.
    camera at the origin | (c - p0))[0] -> -p0)[0] | The rays begin at the camera, c, not at the origin.
    counted from the camera | (c - p0))[0] -> c)[0] | t is counted from p0: p0 + t d = c + s m.
    nearest to the camera | np.linalg.solve(A.T @ A, A.T @ (c - p0))[0] -> d @ (c - A[:, 1] - p0) | That is the foot of the ray's end. The ray has any length: take the point of the line nearest to the whole ray.
    one end only | for ray in m -> for ray in m[:1] | The segment has two ends, and both tell how far the line has been seen.
    second ray only | for ray in m -> for ray in m[1:] | The segment has two ends, and both tell how far the line has been seen: use both rays.
    ray not of length one: With k = d'm and w = c - p0, t = (d'w - k m'w) / (1 - k^2) holds for rays m of length one: divide each ray by its length first.
        np.linalg.solve(A.T @ A, A.T @ (c - p0))[0] -> (d @ (w := c - p0) - (k := d @ (g := -A[:, 1])) * (g @ w)) / (1 - k * k)
    k for its square | np.linalg.solve(A.T @ A, A.T @ (c - p0))[0] -> (d @ (w := c - p0) - (k := d @ (g := -A[:, 1] / np.linalg.norm(A[:, 1]))) * (g @ w)) / (1 - k) | With k = d'm and w = c - p0 the two equations give t = (d'w - k m'w) / (1 - k^2): k is squared.
    sign of the second term | np.linalg.solve(A.T @ A, A.T @ (c - p0))[0] -> (d @ (w := c - p0) + (k := d @ (g := -A[:, 1] / np.linalg.norm(A[:, 1]))) * (g @ w)) / (1 - k * k) | With k = d'm and w = c - p0 the two equations give t = (d'w - k m'w) / (1 - k^2): the second term is taken off.
    either the one end or the other | max(t[1], *seen)]) -> t[1] if min(seen) < t[0] else max(t[1], *seen)]) | A segment may reach beyond both ends: each end is compared by itself, whatever came out for the other one.
    point of the ray nearest to p0 | np.linalg.solve(A.T @ A, A.T @ (c - p0))[0] -> d @ (c - A[:, 1] * (-A[:, 1] @ (p0 - c)) / (A[:, 1] @ A[:, 1]) - p0) | The point of the ray that is nearest to p0 is another one. Line and ray have their parameters t and s, and both are solved for together.
    """,
)
