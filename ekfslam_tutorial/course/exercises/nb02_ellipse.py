"""Exercise 02.6: the k-sigma ellipse, from P to a curve."""

import numpy as np
from scipy.special import erf

from ...geometry import wrap
from .. import expect
from ..exercise import Exercise


def ellipse(mean, P, k):
    """Points of the k-sigma ellipse of a Gaussian in the plane.

    mean, shape (2,): the centre. P, shape (2, 2): the covariance. k > 0: the size of the ellipse, in sigmas.
    Return some 100 points, shape (n, 2), one after the other once round the ellipse: a closed curve to be plotted.
    """
    a = np.linspace(0, 2 * np.pi, 100)
    circle = np.array([np.cos(a), np.sin(a)])  # radius 1; a column for each point
    D, V = np.linalg.eigh(P)  # variances along the axes; the axes, as columns
    return mean + (k * V @ np.diag(np.sqrt(D)) @ circle).T


def as_curve(points):
    """What matters of the points of a curve: centre and shape of the ellipse they lie on, and how they go round it.

    How many points there are, and where the first one is, does not matter. Points on no ellipse stay as they are.
    """
    p = np.array(points, float)
    if p.ndim != 2 or p.shape[1] != 2 or len(p) < 6 or not np.isfinite(p).all():
        return p
    middle, unit = p.mean(0), p.std()
    if not unit > 0:  # all points are one; of 0 / 0 LAPACK would print an error
        return p
    x, y = (p - middle).T / unit
    conic = np.stack([x * x, 2 * x * y, y * y, 2 * x, 2 * y], -1)
    if not np.isfinite(conic).all():
        return p
    (a, b, c, d, e), *_ = np.linalg.lstsq(conic, np.ones(len(p)), rcond=None)
    if not a * c - b * b > 1e-9 or np.abs(conic @ [a, b, c, d, e] - 1).max() > 1e-6:
        return p
    Q = np.array([[a, b], [b, c]])
    centre = -np.linalg.solve(Q, [d, e])
    S = np.linalg.inv(Q) * (1 + centre @ Q @ centre)  # (p - centre)' S^-1 (p - centre) = 1
    turned, steps = _round(p, middle + unit * centre, unit**2 * S)
    return np.array([*(middle + unit * centre), *(unit**2 * S).flat, turned > 6, steps < 0.7], float)


def _round(p, mean, P):
    """How far the points go round the ellipse, in all, and the greatest step: angles on the circle that it is made of."""
    u = np.linalg.solve(np.linalg.cholesky(P), (p - mean).T)
    steps = wrap(np.diff(np.arctan2(u[1], u[0])))
    return abs(steps.sum()), np.abs(steps).max()


drawn = Exercise(
    "02.6",
    "The ellipse",
    ellipse,
    hints=(
        "Make a circle of radius 1 first: points (cos a, sin a) for a from 0 to 2 pi. Then stretch it, turn it, shift it.",
        "np.linalg.eigh(P) gives variances D and, as the columns of V, the directions of the axes. Along column j the half axis is k sqrt(D[j]).",
        "A point is mean + k V diag(sqrt(D)) u, with u = (cos a, sin a). With all u as columns of one matrix, transpose the product to get the shape (n, 2).",
    ),
    canonical=as_curve,
)


def _points(value):
    """The student's points, shape (n, 2)."""
    try:
        shape = np.shape(value)
    except ValueError:
        shape = ()
    if len(shape) == 2 and shape[0] == 2 != shape[1]:
        raise expect.Failed(
            f"the result has shape {shape}, it must be ({shape[1]}, 2)",
            "One row for each point: transpose the result, `.T`.",
        )
    p = expect.array(value, (shape[0] if shape else 100, 2), "the result")
    if len(p) < 20:
        raise expect.Failed(f"{len(p)} points make a curve with corners", "Take some 100 points.", certain=True)
    return p


def _on_the_ellipse(f, mean, P, k):
    """All points are k sigma away from the mean."""
    mean, P = np.array(mean, float), np.array(P, float)
    p = _points(f(mean, P, k))
    away = np.sqrt(np.maximum(((p - mean) @ np.linalg.inv(P) * (p - mean)).sum(1), 0))
    if np.abs(away - k).max() > 1e-6 * k:
        raise expect.Failed(
            f"with mean {mean.tolist()}, P = {P.tolist()}, k = {k:g} your points are {away.min():.3g} to "
            f"{away.max():.3g} sigma away from the mean, sqrt((p - mean)' P^-1 (p - mean)); all should be {k:g}"
        )


@drawn.link("points of the plane", "Return an array of shape (n, 2): one row (x, y) for each point.")
def _(f, rng):
    for k in (1.0, 2.0):
        _points(f(np.array([1.0, 2.0]), np.array([[0.5, 0.2], [0.2, 0.3]]), k))


@drawn.link(
    "a circle", "With P = sigma^2 I the ellipse is a circle around the mean: its radius is k sigma, in x and in y."
)
def _(f, rng):
    for mean, s, k in (([0, 0], 0.5, 1), ([0, 0], 0.5, 3), ([2, -1], 3.0, 2)):
        _on_the_ellipse(f, mean, s**2 * np.eye(2), k)


@drawn.link(
    "upright",
    "With a diagonal P the axes lie along x and y: half axis k sqrt(P[0, 0]) along x, k sqrt(P[1, 1]) along y.",
)
def _(f, rng):
    for P, k in (([[0.25, 0], [0, 4]], 1), ([[9, 0], [0, 0.04]], 3)):
        _on_the_ellipse(f, rng.normal(size=2), P, k)


@drawn.link(
    "tilted",
    "The axes lie along the eigenvectors of P. With D, V = np.linalg.eigh(P), the half axis along column j of V is k sqrt(D[j]).",
)
def _(f, rng):
    for k in (3.0, 1.0, 2.5, 3.0, 0.7, 3.0):
        A = rng.normal(size=(2, 2)) * rng.uniform(0.1, 3.0)
        _on_the_ellipse(f, 5 * rng.normal(size=2), A @ A.T + 0.01 * np.eye(2), k)


@drawn.link(
    "once round",
    "The points go once round the ellipse in small steps, as an angle from 0 to 2 pi does: one closed curve.",
)
def _(f, rng):
    for P in (np.eye(2), np.array([[2.0, 0.6], [0.6, 0.5]])):
        p = _points(f(np.zeros(2), P, 3.0))
        turned, step = _round(p, np.zeros(2), P)
        if step > 0.7:
            raise expect.Failed(f"from one point to the next the curve jumps by {np.degrees(step):.0f} degrees")
        if not 6.0 < turned < 6.6:
            raise expect.Failed(f"the curve goes round by {np.degrees(turned):.0f} degrees, it should be 360")


# eigh makes V symmetric in the plane, so that its rows do no harm; those of eig do.
drawn.edited("""
the root forgotten | np.sqrt(D) -> D | P and its eigenvalues D are *variances*. Along an axis, one sigma is the root of its variance.
k under the root | k * V @ np.diag(np.sqrt(D)) -> V @ np.diag(np.sqrt(k * D)) | The half axis is k sigma: the root of the variance first, then times k.
k forgotten | k * V -> V | That is the ellipse of 1 sigma, whatever k is.
always 3 sigma | k * V -> 3 * V | The size of the ellipse is the argument k; 3 is only what is drawn most.
k squared | k * V -> k**2 * V | k squared belongs to the squared distance, (p - mean)' P^-1 (p - mean) = k^2. The half axis is k sigma.
rows of V | np.linalg.eigh -> np.linalg.eig | Yours is tilted the other way. The axes lie along the *columns* of V: its rows, or minus the angle, turn to the wrong side.
    k * V -> k * V.T
mean scaled, too | return mean + (k -> return k * mean + (k | Only the circle grows with k: scale it first, then move it to the mean.
columns for points | return mean + (k -> return mean[:, None] + (k | One row for each point, shape (n, 2): yours has them in columns: transpose the result, `.T`.
    circle).T -> circle)
axes swapped | np.sqrt(D) -> np.sqrt(D[::-1]) | eigh sorts: D[j] belongs to column j of V. Yours has the long axis where the short one should be.
not turned | k * V @ np.diag(np.sqrt(D)) -> k * np.diag(np.sqrt(np.diag(P))) | The variances on the diagonal of P do not know the tilt. The half axes come from the eigenvectors of all of P.
eigenvalues, but not turned | k * V @ -> k * | These are the right half axes, but they lie along x and y: turn them, by V, the eigenvectors.
root of each entry | V @ np.diag(np.sqrt(D)) -> np.sqrt(np.abs(P)) | A root of a matrix is not the root of each entry. Take the eigenvalues, or np.linalg.cholesky(P).
the inverse | np.sqrt(D) -> 1 / np.sqrt(D) | 1 / sqrt(D) is small where P is large. The ellipse is long where the variance is large.
whole axis for half | k * V -> 2 * k * V | That is twice too large: k sigma is *half* an axis, from the centre to the curve.
half of the half axis | k * V -> k / 2 * V | That is half as large as it should be: k sigma is already *half* an axis (a width would be 2 k sigma).
mean forgotten | mean + ( -> ( | The ellipse belongs around the mean: add it to every point.
half of the circle | 2 * np.pi -> np.pi | The angle must go once round: from 0 to 2 pi.
angles in degrees | 2 * np.pi -> 360 | The points must follow one another round the curve, in small steps: let the angle rise from 0 to 2 pi. Degrees taken for radians, or angles in no order, jump across the ellipse.
Cholesky factor transposed | V @ np.diag(np.sqrt(D)) -> np.linalg.cholesky(P).T | np.linalg.cholesky gives L with P = L L', and each point of the circle is multiplied by L: L @ circle for points in columns, circle @ L.T for points in rows. Yours has the covariance L' L.
""")


def _wrong(name, hint):
    """A misconception in the matrix that makes the ellipse of a unit circle."""

    def add(matrix):
        @drawn.wrong(name, hint)
        def _(mean, P, k):
            a = np.linspace(0, 2 * np.pi, 100)
            return mean + np.stack([np.cos(a), np.sin(a)], -1) @ matrix(P, k).T

    return add


@_wrong("99.7 per cent", "A k-sigma ellipse is where (p - mean)' P^-1 (p - mean) = k^2, in any dimension. That it holds 98.9 % for k = 3, and not 99.7 %, is how things are in the plane.")  # fmt: skip
def _(P, k):
    return np.sqrt(-2 * np.log(1 - erf(k / np.sqrt(2)))) * np.linalg.cholesky(P)


@_wrong("always 95 per cent", "5.99 is the 95 % value of chi-square. Here the size is given in sigmas: k.")
def _(P, k):
    return np.sqrt(5.991464547107979) * np.linalg.cholesky(P)


def _by_angle(turn):
    """Half axes, turned by an angle that is computed from the eigenvector of the longer one."""

    def matrix(P, k):
        D, V = np.linalg.eigh(P)
        t = turn(np.arctan2(V[1, 1], V[0, 1]))
        return k * np.array([[np.cos(t), -np.sin(t)], [np.sin(t), np.cos(t)]]) @ np.diag(np.sqrt(D[::-1]))

    return matrix


_wrong("turned by degrees", "The angle of the ellipse is in degrees, as matplotlib's Ellipse wants it; np.cos and np.sin want radians.")(_by_angle(np.degrees))  # fmt: skip
