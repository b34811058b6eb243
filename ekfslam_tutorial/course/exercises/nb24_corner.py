"""Exercise 24.4: which places of an image are good corners."""

import numpy as np

from ..table import table


def corner_score(windows):
    """How good a corner each of n windows of an image is: the smaller eigenvalue of Shi and Tomasi.

    windows, shape (n, s, s), are grey values. `np.gradient(windows, axis=(1, 2))` returns their slopes, two arrays of
    the shape (n, s, s): first g_v, from row to row, then g_u, from column to column. Summed over a window, the products
    of the slopes make the matrix A = [[sum g_u g_u, sum g_u g_v], [sum g_u g_v, sum g_v g_v]].
    Return the smaller eigenvalue of each A, shape (n,).
    """
    g_v, g_u = np.gradient(windows, axis=(1, 2))
    add = lambda products: products.sum(axis=(1, 2))
    a, b, c = add(g_u * g_u), add(g_u * g_v), add(g_v * g_v)
    A = np.stack([a, b, b, c], axis=1).reshape(-1, 2, 2)
    return np.linalg.eigvalsh(A)[:, 0]


def smooth(rng, s=7):
    """A window of a smooth image."""
    v, u = np.mgrid[:s, :s]
    a, b, c = rng.uniform(-0.9, 0.9, 3)
    return 100 + 40 * np.sin(a * u + b * v) + 30 * np.cos(c * v - b * u)


def edge(s=7, turned=0.0):
    """A straight edge through the middle."""
    v, u = np.mgrid[:s, :s] - s // 2
    return 100.0 + 80 * (np.cos(turned) * u + np.sin(turned) * v > 0)


def wave(turned, s=7):
    """A pattern that changes in one direction only, without steps."""
    v, u = np.mgrid[:s, :s] - s // 2
    return 100.0 + 12 * (np.cos(turned) * u + np.sin(turned) * v)


def corner(s=7):
    """The corner of a rectangle."""
    v, u = np.mgrid[:s, :s] - s // 2
    return 100.0 + 80 * ((u > 0) & (v > 0))


score = table(
    "24.4 A good corner",
    corner_score,
    hints=(
        "A patch on an edge looks the same one pixel along the edge. A corner changes in both directions.",
        "A has four sums over the window: sum g_u g_u, sum g_u g_v twice, sum g_v g_v. np.linalg.eigvalsh(A) sorts: the smaller eigenvalue is the first.",
        "Without eigvalsh: with a, b, c for sum g_u g_u, sum g_u g_v, sum g_v g_v it is (a + c) / 2 - sqrt(((a - c) / 2)^2 + b^2).",
    ),
    returns="score",
    cases={
        "any": lambda rng: [(np.array([smooth(rng) for _ in range(n)]),) for n in (4, 2, 1)],
        "straight": lambda rng: [(np.array([edge(), edge().T, np.full((7, 7), 80.0)]),)],
        "slanted": lambda rng: [(np.array([wave(a) for a in (0.4, 0.8, 2.0)]),)],
        "corner": lambda rng: [(np.array([corner(), 200.0 - corner(), corner()[::-1]]),), (np.array([corner(5)]),)],
        "contrast": lambda rng: [(np.array([f * smooth(np.random.default_rng(3)) for f in (1.0, 2.0, 0.5)]),)],
    },
    checks="""
    flat, or a straight edge | score | straight | On a straight edge the patch does not change along the edge: the smaller eigenvalue is 0.
    a slanted slope          | score | slanted  | A slope at an angle changes in one direction, as a straight edge does: sum g_u g_v is not 0, but the determinant of A is 0, and so is its smaller eigenvalue.
    a corner                 | score | corner   | A corner changes in both directions: the smaller eigenvalue is above 0. It is that of A, with the sums over the whole window of the products of the slopes.
    twice the contrast       | score | contrast | One window, then with twice and with half of its contrast. A holds products of slopes: the smaller eigenvalue of the first, then four times as much, then a quarter.
    any windows              | score | any      | A = sums over each window of the products; the smaller eigenvalue of each A.
    """,
    wrong="""
    larger eigenvalue | eigvalsh(A)[:, 0] -> eigvalsh(A)[:, 1] | The *smaller* eigenvalue: the larger one is large on an edge, too, and a patch slides along an edge.
    trace | np.linalg.eigvalsh(A)[:, 0] -> np.trace(A, axis1=1, axis2=2) | The trace is the sum of both eigenvalues: an edge would be as good as a corner.
    determinant | np.linalg.eigvalsh(A)[:, 0] -> np.linalg.det(A) | The determinant is the product of both eigenvalues: the task asks for the smaller one.
    mean of both | np.linalg.eigvalsh(A)[:, 0] -> np.linalg.eigvalsh(A).mean(1) | Not their mean: the smaller of the two.
    off-diagonal forgotten | np.linalg.eigvalsh(A)[:, 0] -> np.minimum(A[:, 0, 0], A[:, 1, 1]) | An edge at an angle has slopes along u and along v, and is no corner: sum g_u g_v tells. Eigenvalues of the whole A.
    four forgotten | np.linalg.eigvalsh(A)[:, 0] -> (A[:, 0, 0] + A[:, 1, 1] - np.hypot(A[:, 0, 0] - A[:, 1, 1], A[:, 0, 1])) / 2 | With a, b, c for sum g_u g_u, sum g_u g_v, sum g_v g_v it is half of a + c - sqrt((a - c)^2 + 4 b^2): yours lacks the 4.
    mean for sum | products.sum(axis=(1, 2)) -> products.mean(axis=(1, 2)) | A holds *sums* over the window, not means.
    product of the sums | add(g_u * g_v) -> add(g_u) * add(g_v) | Multiply first, then add: sum g_u g_v, not (sum g_u) (sum g_v).
    root | return np.linalg.eigvalsh(A)[:, 0] -> return np.sqrt(np.abs(np.linalg.eigvalsh(A)[:, 0])) | The eigenvalue itself, no root.
    summed over all windows | products.sum(axis=(1, 2)) -> products.sum() + np.zeros(len(products)) | Each window has its own A: sum over its rows and columns only.
    grey values for slopes | np.gradient(windows, axis=(1, 2)) -> windows, windows | Yours is 0 whatever the window is, as if A always had the rank 1. A holds products of the two *slopes*, g_u g_u, g_u g_v and g_v g_v; multiply first, then add: sum g_u g_v is another number than (sum g_u) (sum g_v).
    slopes without sign | np.gradient(windows, axis=(1, 2)) -> np.abs(np.gradient(windows, axis=(1, 2))) | Slopes have signs: without them a slope to the left and one to the right add up in sum g_u g_v.
    slopes along the wrong axes | np.gradient(windows, axis=(1, 2)) -> np.gradient(windows, axis=(0, 1)) | axis 0 goes from window to window: the slopes of a window are along its rows and columns, axis=(1, 2).
    half forgotten under the root | np.linalg.eigvalsh(A)[:, 0] -> (A[:, 0, 0] + A[:, 1, 1]) / 2 - np.hypot(A[:, 0, 0] - A[:, 1, 1], A[:, 0, 1]) | By hand: (a + c) / 2 - root(((a - c) / 2)^2 + b^2): the half belongs to a - c, too.
    Harris | np.linalg.eigvalsh(A)[:, 0] -> np.linalg.det(A) - 0.04 * np.trace(A, axis1=1, axis2=2) ** 2 | That is the score of Harris. Here the smaller eigenvalue is asked for.
    mean slope taken off | g_v, g_u = np.gradient(windows, axis=(1, 2)) -> g_v, g_u = (g - g.mean(axis=(1, 2), keepdims=True) for g in np.gradient(windows, axis=(1, 2))) | A holds the products of the slopes themselves: no mean is taken off. A plain ramp has slopes, too.
    border left out | products.sum(axis=(1, 2)) -> products[:, 1:-1, 1:-1].sum(axis=(1, 2)) | The sum goes over the whole window, its border included.
    half forgotten | return np.linalg.eigvalsh(A)[:, 0] -> return 2 * np.linalg.eigvalsh(A)[:, 0] | Yours is twice as much. With a, b, c for sum g_u g_u, sum g_u g_v, sum g_v g_v it is *half* of a + c - sqrt((a - c)^2 + 4 b^2).
    forward differences: The slopes are those of np.gradient: in the middle half of the difference between the two neighbours, not the difference to the next one.
        g_v, g_u = np.gradient(windows, axis=(1, 2)) -> w = np.asarray(windows, float); g_v, g_u = np.diff(w, axis=1)[:, :, :-1], np.diff(w, axis=2)[:, :-1, :]
    windows made alike first | g_v, g_u = np.gradient(windows, axis=(1, 2)) -> d = np.std(windows, axis=(1, 2), keepdims=True); g_v, g_u = np.gradient((windows - np.mean(windows, axis=(1, 2), keepdims=True)) / np.where(d > 0, d, 1.0), axis=(1, 2)) | The slopes are those of the grey values as they are: strong contrast makes a good corner, and it is not taken away first.
    singular value of the slopes | return np.linalg.eigvalsh(A)[:, 0] -> return np.linalg.svd(np.stack([g_u, g_v], -1).reshape(len(A), -1, 2), compute_uv=False)[:, 1] | That is the singular value of the slopes: the eigenvalue of A is its square.
    """,
)
