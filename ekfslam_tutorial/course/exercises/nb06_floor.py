"""Exercise 06.4: what no measurement on the way can ever take away."""

import numpy as np

from .. import expect
from ..table import table
from .nb04_blocks import random_covariance


def floor_of(P_0, x_0, l):
    """Covariance of a landmark if the map is perfect, but for the first pose: no landmark can be better.

    P_0, shape (3, 3): covariance of the first pose x_0 = [x, y, theta].
    l, shape (2,): the landmark. Seen from the first pose its place is known exactly; the first pose is not.
    Return the covariance of l in the world, shape (2, 2).
    """
    J = np.array([[1, 0, -(l[1] - x_0[1])], [0, 1, l[0] - x_0[0]]])
    return J @ P_0 @ J.T


def some(rng, scale=1.0):
    """Return a first pose, its covariance, and a landmark some metres away."""
    x_0 = rng.uniform([-5, -5, -3], [5, 5, 3])
    return random_covariance(rng, 3, 0.1 * scale), x_0, x_0[:2] + rng.uniform(2, 8, 2) * rng.choice([-1, 1], 2)


def heading_exact(rng):
    """Return the same with an exact first heading."""
    P_0, x_0, l = some(rng)
    P_0[2], P_0[:, 2] = 0, 0
    return P_0, x_0, l


def at_the_start(rng):
    """Return a landmark at the first position."""
    P_0, x_0, _ = some(rng)
    return P_0, x_0, x_0[:2].copy()


def around(*landmarks):
    """Return landmarks round a first pose whose position is exact."""
    return [(np.diag([0, 0, 0.04]), np.array([1.0, 2.0, 0.7]), np.array(l, float)) for l in landmarks]


floor = table(
    "06.4 The floor",
    floor_of,
    hints=(
        "l = t_0 + R(theta_0) m, where m is the place of the landmark seen from the first pose: m is exact. How does l move if x_0, y_0 or theta_0 changes a little?",
        "Shift the first pose: the landmark shifts with it. Turn the first pose by a small angle: the landmark moves on a circle round the first position, across the line to it.",
        "J = [[1, 0, -(l[1] - x_0[1])], [0, 1, l[0] - x_0[0]]], and the floor is J P_0 J'.",
    ),
    returns="floor",
    symbols="t_0 = the first position, x_0[:2]; J = the derivative of l by the first pose",
    cases={
        "any": lambda rng: [some(rng), some(rng), some(rng, 1e-4)],
        "heading": lambda rng: [heading_exact(rng)],
        "position": lambda rng: around([6, 2], [1, 7], [4, 6]),
        "start": lambda rng: [at_the_start(rng)],
    },
    checks="""
    shape            | floor[:0] | any      | The floor is the covariance of the two numbers of the landmark.
    heading exact    | floor     | heading  | If the first heading is exact, the whole map is shifted with the first position.
    position exact   | floor     | position | A wrong heading moves a landmark across the line to it, by the angle times the distance.
    the general case | floor     | any      | First position and heading are uncertain here, and their errors are correlated. How does l change with each of the three numbers of the first pose? That is J.
    at the start     | floor     | start    | A landmark at the first position feels no rotation.
    """,
    wrong="""
    heading forgotten | [[1, 0, -(l[1] - x_0[1])], [0, 1, l[0] - x_0[0]]] -> [[1, 0, 0], [0, 1, 0]] | The first heading is uncertain, too: it turns the whole map round the first position.
    no correlation with the heading | J @ P_0 @ J.T -> J @ (P_0 * [[1, 1, 0], [1, 1, 0], [0, 0, 1]]) @ J.T | P_0 has covariances between position and heading: use the whole P_0.
    diagonal of P_0 only | J @ P_0 @ J.T -> J @ np.diag(np.diag(P_0)) @ J.T | P_0 has covariances, too: use the whole P_0.
    no correlation of x and y | J @ P_0 @ J.T -> J @ (P_0 * [[1, 0, 1], [0, 1, 1], [1, 1, 1]]) @ J.T | The errors of x and y of the first pose are correlated, too: use the whole P_0.
    P_0 squared | J @ P_0 @ J.T -> J @ P_0 @ P_0 @ J.T | P_0 holds variances already: do not square it.
    turned round the origin | [[1, 0, -(l[1] - x_0[1])], [0, 1, l[0] - x_0[0]]] -> [[1, 0, -l[1]], [0, 1, l[0]]] | A wrong first heading turns the map round the first *position*, not round the origin: use l - t_0.
    turned round the origin, the other way | [[1, 0, -(l[1] - x_0[1])], [0, 1, l[0] - x_0[0]]] -> [[1, 0, l[1]], [0, 1, -l[0]]] | A wrong first heading turns the map round the first *position*, and a landmark ahead to the left: d(l)/d(theta) is [-(l[1] - x_0[1]), l[0] - x_0[0]].
    turned round the origin, one sign | [[1, 0, -(l[1] - x_0[1])], [0, 1, l[0] - x_0[0]]] -> [[1, 0, l[1]], [0, 1, l[0]]] | A wrong first heading turns the map round the first *position*, not round the origin, and the first entry has a minus: d(l)/d(theta) is [-(l[1] - x_0[1]), l[0] - x_0[0]].
    sign of the rotation | [[1, 0, -(l[1] - x_0[1])], [0, 1, l[0] - x_0[0]]] -> [[1, 0, l[1] - x_0[1]], [0, 1, -(l[0] - x_0[0])]] | Turned to the left, a landmark ahead moves to the left: d(l)/d(theta) is [-(l[1] - x_0[1]), l[0] - x_0[0]].
    moved along the line | [[1, 0, -(l[1] - x_0[1])], [0, 1, l[0] - x_0[0]]] -> [[1, 0, l[0] - x_0[0]], [0, 1, l[1] - x_0[1]]] | A rotation moves the landmark *across* the line to it: swap the two entries, and mind the sign.
    one sign of the rotation | -(l[1] - x_0[1]) -> l[1] - x_0[1] | d(l)/d(theta) = [-(l[1] - x_0[1]), l[0] - x_0[0]]: the first entry has a minus.
    position forgotten | [[1, 0, -(l[1] - x_0[1])], [0, 1, l[0] - x_0[0]]] -> [[0, 0, -(l[1] - x_0[1])], [0, 0, l[0] - x_0[0]]] | The first position is uncertain, too: the map shifts with it.
    the position in the robot's frame | return J -> c, s = np.cos(x_0[2]), np.sin(x_0[2]); J[:, :2] = [[c, -s], [s, c]]; return J | P_0 is in world coordinates already: shift the first pose by 1 m in x, and the landmark shifts by 1 m in x.
    turned with the heading | return J -> c, s = np.cos(x_0[2]), np.sin(x_0[2]); J[:, 2] = np.array([[c, -s], [s, c]]) @ J[:, 2]; return J | The landmark is given in the world already: its distance in x and in y is l - t_0, not turned.
    sigma of the heading in degrees | return J -> J[:, 2] = np.degrees(J[:, 2]); return J | P_0 holds rad^2 already: no conversion.
    distance in degrees | return J -> J[:, 2] = np.radians(J[:, 2]); return J | P_0 is in rad^2 already, and an angle in rad times a distance is a length: no conversion.
    distance instead of components | return J -> J[:, 2] = np.hypot(*(l - x_0[:2])); return J | The movement has a direction: -(l[1] - x_0[1]) in x and l[0] - x_0[0] in y.
    no distance | return J -> J[:, 2] /= max(np.hypot(*(l - x_0[:2])), 1e-12); return J | A heading error of 1 degree moves a far landmark more than a near one: the distance is missing.
    sigma of the heading for its variance | return J @ P_0 -> P_0 = P_0.copy(); P_0[2, 2] = np.sqrt(P_0[2, 2]); return J @ P_0 | P_0[2, 2] is a variance, in rad^2, and J P_0 J' needs it as it is: no root.
    standard deviations for variances | return J @ P_0 -> P_0 = np.sqrt(np.abs(P_0)); return J @ P_0 | P_0 holds variances already, and J P_0 J' needs variances: no root.
    the result in the robot's frame | return J @ P_0 @ J.T -> c, s = np.cos(x_0[2]), np.sin(x_0[2]); T = np.array([[c, s], [-s, c]]); return T @ (J @ P_0 @ J.T) @ T.T | The covariance is asked in the world, in x and y: nothing is turned by the heading.
    the arm in the robot's axes | return J -> c, s = np.cos(x_0[2]), np.sin(x_0[2]); J[:, 2] = np.array([[c, s], [-s, c]]) @ J[:, 2]; return J | The landmark is given in the world already: its distance in x and in y is l - t_0, not turned with the heading.
    one cross term | return J @ P_0 @ J.T -> P_0 = P_0.copy(); P_0[2, :2] = 0; return J @ P_0 @ J.T | Position and heading are correlated: there are two cross terms, one the transpose of the other.
    twice one cross term | return J @ P_0 @ J.T -> F = J @ P_0 @ J.T; X = np.outer(P_0[:2, 2], J[:, 2]); return F + X - X.T | The two cross terms are transposes of each other, not the same: one of each.
    variance of the heading squared | return J @ P_0 -> P_0 = P_0.copy(); P_0[2, 2] **= 2; return J @ P_0 | P_0[2, 2] is a variance already: do not square it.
    heading in all directions | return J @ P_0 @ J.T -> F = J @ P_0 @ J.T; b = J[:, 2]; return F + P_0[2, 2] * ((b @ b) * np.eye(2) - np.outer(b, b)) | A wrong heading moves the landmark across the line to it only: b b' times its variance, not |b|^2 in all directions.
    """,
)


@floor.link("a covariance", "The floor must be symmetric and without negative eigenvalues.")
def _(f, rng):
    F = expect.array(f(*some(rng)), (2, 2), "floor")
    expect.symmetric(F, "the floor", 1e-6)
    expect.psd(F, "the floor")
