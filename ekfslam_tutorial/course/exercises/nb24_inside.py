"""Exercise 24.3: the search ellipse."""

import numpy as np

from ..table import table
from .nb04_blocks import random_covariance


def inside(pixels, e, S, k):
    """Which pixels are worth a look: those inside the k-sigma ellipse of what is expected.

    pixels, shape (n, 2), are places [u, v] in the image (px). The filter expects the landmark at e, shape (2,), and
    S, shape (2, 2), is the covariance of the innovation: that of the expectation and of the noise (px^2). A pixel on
    the ellipse counts as inside.
    Return n truth values, shape (n,).
    """
    z = pixels - e
    return np.sum(z * np.linalg.solve(S, z.T).T, axis=1) <= k**2


NARROW = np.array([[9.0, 7.5], [7.5, 9.0]])  # a needle along the diagonal
CIRCLE = 4.0 * np.eye(2)


def around(rng, e, S, n=40):
    """Pixels around e, some of them inside."""
    z = rng.normal(size=(n, 2)) @ np.linalg.cholesky(S).T * rng.uniform(1.0, 6.0, (n, 1))
    return np.rint(e + z)


def case(rng, S=None, k=3.0, n=40):
    """Pixels, an expectation between pixels, and its covariance."""
    e = rng.uniform([40.0, 30.0], [120.0, 90.0])
    S = random_covariance(rng, 2, 2.0) if S is None else S
    return around(rng, e, S, n), e, S, k


def on_it(rng):
    """Pixels on the ellipse itself, and one step beyond: all numbers are exact."""
    e = np.array([80.0, 60.0])
    return e + np.array([[6.0, 0], [-6, 0], [0, 6], [0, -6], [7, 0], [0, -7]]), e, CIRCLE, 3.0


region = table(
    "24.3 The search ellipse",
    inside,
    hints=(
        "A squared Mahalanobis distance, as in notebook 07: how many sigmas is the pixel from what is expected?",
        "z = pixel - e; z' S^-1 z <= k^2. Of all pixels at once: np.linalg.solve(S, z.T).T has a row for each.",
        "np.sum(z * np.linalg.solve(S, z.T).T, axis=1) are the squared distances. Compare them with the square of k.",
    ),
    returns="inside",
    cases={
        "any": lambda rng: [case(rng) for _ in range(3)],
        "circle": lambda rng: [case(rng, CIRCLE), case(rng, CIRCLE, 2.0)],
        "needle": lambda rng: [
            case(rng, NARROW),
            case(rng, NARROW * [[1, -1], [-1, 1]]),
            case(rng, np.diag([16.0, 1.0])),
        ],
        "sigmas": lambda rng: [case(rng, k=k) for k in (1.0, 2.0, 4.0)],
        "on it": lambda rng: [on_it(rng)],
        "few": lambda rng: [case(rng, n=1), case(rng, n=2), case(rng, n=0)],
    },
    checks="""
    a circle       | inside | circle | With S = s^2 I it is a circle of the radius k s: 3 sigma of 2 px are 6 px.
    a needle       | inside | needle | Two ellipses lie along a diagonal, where u and v are correlated; a third one is narrow, with the sigmas 4 px in u and 1 px in v. Inside is where z' S^-1 z <= k^2, with the whole S.
    another k      | inside | sigmas | The squared distance is compared with k^2.
    on the ellipse | inside | on it  | A pixel on the ellipse counts as inside.
    few pixels     | inside | few    | One truth value for each row of pixels, also for one row or none.
    any            | inside | any    | z' S^-1 z <= k^2.
    """,
    wrong="""
    k not squared | <= k**2 -> <= k | z' S^-1 z is a *squared* distance: compare it with k^2, or take its root.
    S not inverted | np.linalg.solve(S, z.T).T -> z @ S | A large S makes a large ellipse: z' S^-1 z, with the inverse.
    a box | np.sum(z * np.linalg.solve(S, z.T).T, axis=1) <= k**2 -> np.all(np.abs(z) <= k * np.sqrt(np.diag(S)), axis=1) | That is the box around the ellipse, and its corners lie outside. u and v count together, with their correlation: z' S^-1 z.
    a box of variances | np.sum(z * np.linalg.solve(S, z.T).T, axis=1) <= k**2 -> np.all(np.abs(z) <= k * np.diag(S), axis=1) | A sigma is the root of a variance; and a box of k sigma is not the ellipse: u and v are correlated, z' S^-1 z.
    correlation forgotten | np.linalg.solve(S, z.T).T -> z / np.diag(S) | The ellipse is turned: the covariance of u and v belongs to it. Use the whole S.
    the largest circle | np.linalg.solve(S, z.T).T -> z / np.linalg.eigvalsh(S)[-1] | That is a circle around the ellipse: where S is narrow it is much too large.
    no S at all | np.linalg.solve(S, z.T).T -> z | k counts sigmas, not pixels: S says how large a sigma is.
    sigma for variance | np.linalg.solve(S, z.T).T -> np.linalg.solve(S @ S, z.T).T | S holds variances, in px^2: it is not squared, and half axes are the *roots* of its eigenvalues.
    outside | <= k**2 -> > k**2 | True is for those that are *inside*.
    the ellipse itself | <= k**2 -> < k**2 | A pixel on the ellipse counts as inside: <=.
    around the origin | z = pixels - e -> z = pixels - 0 * e | The ellipse is around the expectation e: z = pixel - e.
    e rounded | z = pixels - e -> z = pixels - np.rint(e) | The expectation lies between pixels: do not round it.
    u and v of e swapped | z = pixels - e -> z = pixels - e[::-1] | e = [u; v] as the pixels: no swap.
    one half | axis=1) <= -> axis=1) / 2 <= | Nothing is halved or doubled: on the ellipse z' S^-1 z is k^2, in the plane, too. The one half is in the exponent of the Gaussian.
    one answer for all | axis=1) <= k**2 -> axis=1).max() <= k**2 | One truth value for each pixel.
    u and v of the pixels swapped | z = pixels - e -> z = pixels[:, ::-1] - e | The pixels are [u, v], as e and S: no swap.
    always one sigma | <= k**2 -> <= 1 | The ellipse is that of k sigma: compare with k^2, not with 1.
    k twice | <= k**2 -> <= 2 * k | k squared is k times k, not 2 k.
    root beside k squared | axis=1) <= k**2 -> axis=1) <= k**4 | The distance squared goes with k^2, or its root with k: yours is the root beside k^2.
    a circle of the mean variance | np.linalg.solve(S, z.T).T -> z / (np.trace(S) / 2) | That is a circle around the ellipse's middle: the ellipse has the shape of S, z' S^-1 z.
    the other Cholesky factor | np.linalg.solve(S, z.T).T -> np.linalg.solve(np.linalg.cholesky(S).T @ np.linalg.cholesky(S), z.T).T | With S = L L' the whitened difference is L^-1 z, and not the inverse of L' times z.
    determinant forgotten | np.linalg.solve(S, z.T).T -> np.linalg.det(S) * np.linalg.solve(S, z.T).T | The inverse of [[a, b], [b, c]] is [[c, -b], [-b, a]] / (a c - b b): the determinant is missing.
    mixed term once | np.sum(z * np.linalg.solve(S, z.T).T, axis=1) -> (np.sum(z * np.linalg.solve(S, z.T).T, axis=1) - np.linalg.inv(S)[0, 1] * z[:, 0] * z[:, 1]) | z' S^-1 z has the mixed term twice, u v and v u: it comes with the factor 2.
    a pixel of noise more | np.linalg.solve(S, z.T).T -> np.linalg.solve(S + np.eye(2), z.T).T | S is that of the innovation, the noise of the pixels included: nothing is added.
    """,
)
