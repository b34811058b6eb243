"""Exercise 07.4: which measurements may start a landmark? With a bearing, behind the robot, too."""

import numpy as np
from scipy.stats import chi2

from ...geometry import wrap
from ..table import table
from .nb04_blocks import random_covariance


def new_ones(ys, es, Es, R, confidence):
    """Which measurements are far from every landmark in the map, and so may start a new one?

    ys, shape (k, 2): measurements [range, bearing]. R, shape (2, 2): their noise.
    es, shape (n, 2), and Es, shape (n, 2, 2): expectation of each landmark in the map, and its covariance; n may be 0.
    confidence: the gate of new landmarks; a measurement outside of *all* n gates is new.
    Return the list of the indices of the new ones; and D, shape (k, n), the squared Mahalanobis distances.
    """
    D = np.zeros((len(ys), len(es)))
    for i, y in enumerate(ys):
        for j, (e, E) in enumerate(zip(es, Es, strict=True)):
            z = np.array([y[0] - e[0], wrap(y[1] - e[1])])
            D[i, j] = z @ np.linalg.solve(E + R, z)
    limit = chi2.ppf(confidence, 2)
    return [i for i in range(len(ys)) if all(D[i] > limit)], D


FAR = 1 - 1e-6


def some(rng, k, n, scale=1.0):
    """Return k measurements and n landmarks at random."""
    es = np.column_stack([rng.uniform(2, 9, n), rng.uniform(-1.2, 1.2, n)])
    ys = np.column_stack([rng.uniform(2, 9, k), rng.uniform(-1.2, 1.2, k)])
    Es = np.array([random_covariance(rng, 2, 0.02 * scale) for _ in range(n)]).reshape(n, 2, 2)
    return ys, es, Es, random_covariance(rng, 2, 0.02 * scale), FAR


def at(ys, es, confidence=FAR, E=((0.01, 0), (0, 0.01)), R=((0.01, 0), (0, 0.001))):
    """Return measurements and landmarks with equal covariances."""
    es = np.array(es, float).reshape(-1, 2)
    return np.array(ys, float), es, np.array([E] * len(es)).reshape(-1, 2, 2), np.array(R, float), confidence


def beside(order):
    """Return measurements just outside of a narrow gate, but inside of a wide one whose landmark is farther away.

    What is near is a matter of the covariances. The last measurement is near in neither sense.
    """
    es, Es = np.array([[5.0, 0.3], [5.8, 0.1]]), np.array([np.diag([0.001, 0.001]), np.diag([0.3, 0.06])])
    ys = np.array([[5.25, 0.3], [5.0, 0.6], [5.01, 0.31], [12.0, -1.0]])
    return ys, es[order], Es[order], np.diag([0.001, 0.001]), FAR


def behind(side, turns):
    """Return a landmark straight behind, and its measurement on the other side of the seam."""
    ys = [[4.05, -side * (np.pi - 0.01) + 2 * np.pi * turns], [5.0, 0.32 - 2 * np.pi]]
    return at(ys, [[4.0, side * (np.pi - 0.02)], [5.0, 0.3]])


def many_behind(rng):
    """Return 40 measurements of one landmark straight behind."""
    y = np.column_stack([4.0 + 0.05 * rng.normal(size=40), wrap(np.pi + 0.03 * rng.normal(size=40))])
    return at(y, [[4.0, np.pi]], E=0.001 * np.eye(2), R=np.diag([0.0025, 0.0009]))


def at_the_limit(rng):
    """Return measurements near the gate, and near gates of other degrees of freedom; other landmarks are far away."""
    others = [[40.0, 1.0], [60.0, -0.5], [80.0, 0.0]]

    def near(n, confidence):
        """Measurements just inside and outside of gates, with n landmarks."""
        sigmas = np.sqrt(chi2.ppf(confidence, [2, 2, 1, 3, 6, 12])) * [1.03, -0.97, -0.97, 0.97, 0.97, 0.97]
        ys = np.column_stack([5 + 0.2 * sigmas, [0.3] * 6])
        return at(ys, [[5.0, 0.3], *others[: n - 1]], confidence, np.diag([0.03, 0.001]))

    return [near(n, confidence) for n in (3, 1, 2, 4) for confidence in (FAR, 0.99)]


MAP = [[3.0, 0.0], [6.0, 0.5], [6.0, -0.5]]

new = table(
    "07.4 New landmarks",
    new_ones,
    hints=(
        "First the table D: each measurement against each expectation. What is the covariance of y - e?",
        "z = y - e with the bearing wrapped, Z = E + R. A measurement is new if its whole row of D is beyond the gate.",
        "z = [y[0] - e[0], wrap(y[1] - e[1])], D[i, j] = z' inv(E_j + R) z; new if all(D[i] > limit), with the limit chi2.ppf(confidence, 2). For an empty map every measurement is new: all([]) is True.",
    ),
    returns="new, D",
    symbols="E = the covariance of an expectation, one of Es; y_i, e_j, E_j = one entry each of ys, es and Es",
    kinds={"new": "a list of indices"},
    cases={
        "any": lambda rng: [some(rng, 3, 4), some(rng, 2, 1)],
        "sizes": lambda rng: [some(rng, 3, 4), some(rng, 5, 2, 0.01), some(rng, 1, 1, 5.0)],
        "behind": lambda rng: [behind(1, 0), behind(-1, 0), behind(1, 1), behind(-1, -2)],
        "ranges": lambda rng: [at([[9.0, 0.1]], [[2.0, 0.1]], 0.9, np.eye(2), 0.1 * np.eye(2))],
        "far": lambda rng: [
            at([[3.05, 0.01], [8.0, 1.0], [6.0, -0.48], [3.0, 2.5]], MAP),
            at([[3.05, 0.01]], MAP),
            at([[3.0, 2.5], [6.0, 0.51]], MAP),
        ],
        "beside": lambda rng: [beside([0, 1]), beside([1, 0])],
        "empty": lambda rng: [at([[3.0, 0.1], [4.0, -0.2]], []), at([[3.0, 0.1]], [], 0.9)],
        "limit": at_the_limit,
        "many behind": lambda rng: [many_behind(rng)],
    },
    checks="""
    the distances                | D      | sizes       | D[i, j] = z' inv(Z) z, with z = y_i - e_j and Z = E_j + R.
    behind the robot             | D      | behind      | Two bearings of one direction may differ by whole turns, one or more. The difference y - e of the bearings is wrapped: between -pi and pi.
    the range is no angle        | D      | ranges      | Wrap the bearing only: ranges may differ by more than pi metres.
    new is far from all          | new    | far         | A measurement is new if it is outside of the gates of *all* landmarks. Return the list of the indices of the new ones, counted from 0.
    a wide gate beside a narrow  | new    | beside      | Ask the gate of *every* landmark: the nearest in range and bearing may have the narrower gate.
    an empty map                 | new, D | empty       | At the start there is no landmark: every measurement is new, and D has no columns.
    the gate                     | new    | limit       | The limit is chi2.ppf(confidence, 2), whatever the number of landmarks: just outside of all gates a measurement is new, just inside of one it is not.
    behind the robot, as a whole | new    | many behind | A landmark straight behind is in the map already: it must not be born again.
    """,
    wrong="""
    bearing not wrapped | wrap(y[1] - e[1]) -> y[1] - e[1] | A landmark straight behind is expected at +179 degrees and measured at -179: wrap the difference, or it is created again and again.
    brackets forgotten | wrap(y[1] - e[1]) -> (y[1] - e[1] + np.pi) % 2 * np.pi - np.pi | Python reads `% 2*np.pi` as `(... % 2) * np.pi`. The whole turn needs brackets: % (2 * np.pi).
    wrapped to 0 ... 2 pi | wrap(y[1] - e[1]) -> (y[1] - e[1]) % (2 * np.pi) | A small negative difference must stay small and negative: wrap into -pi ... pi.
    bearing in degrees | wrap(y[1] - e[1]) -> np.degrees(wrap(y[1] - e[1])) | Angles are in radians everywhere.
    range wrapped, too | [y[0] - e[0], -> [wrap(y[0] - e[0]), | Only the bearing is an angle: do not wrap the range.
    bearings wrapped one by one | wrap(y[1] - e[1]) -> wrap(y[1]) - wrap(e[1]) | Wrap the *difference*: two wrapped bearings can still differ by almost 2 pi.
    absolute values of the bearings | wrap(y[1] - e[1]) -> np.abs(wrap(y[1])) - np.abs(wrap(e[1])) | Left behind and right behind are not the same: wrap the difference.
    R forgotten | E + R -> E | y has noise, too: the covariance of y - e is E + R.
    E forgotten | E + R -> R | The expectation is uncertain, too: the covariance of y - e is E + R.
    R subtracted | E + R -> E - R | The errors of y and e are independent: their covariances add up, E + R.
    Euclidean distance | z @ np.linalg.solve(E + R, z) -> z @ z | Range and bearing have different units and sigmas: use z' inv(Z) z.
    not squared | z @ np.linalg.solve(E + R, z) -> np.sqrt(z @ np.linalg.solve(E + R, z)) | The limit is for the squared distance: no root.
    diagonal of Z | np.linalg.solve(E + R, z) -> (z / np.diag(E + R)) | Use the whole Z: range and bearing may be correlated.
    far from one is enough | all(D[i] > limit) -> any(D[i] > limit) or len(es) == 0 | Almost every measurement is far from some landmark. New means far from *all*.
    only the nearest is asked | if all(D[i] > limit) -> if not len(es) or D[i, np.argmin([np.hypot(ys[i][0] - e[0], wrap(ys[i][1] - e[1])) for e in es])] > limit | A landmark farther away, with a larger covariance, may have the measurement inside its gate: ask the gates of *all* landmarks, the smallest entry of row i of D.
    the old ones | if all(D[i] > limit) -> if not all(D[i] > limit) | These are the measurements near a landmark: return the others.
    True and False | [i for i in range(len(ys)) if all(D[i] > limit)] -> [all(D[i] > limit) for i in range(len(ys))] | Return the list of the indices, for instance [1, 3].
    the measurements themselves | [i for i in range(len(ys)) if all(D[i] > limit)] -> [sum(all(row > limit) for row in D)] | Return indices, counted from 0; not how many there are.
    counted from 1 | return [i for -> return [i + 1 for | Indices are counted from 0.
    nothing new on an empty map | if all(D[i] > limit) -> if len(es) and all(D[i] > limit) | With no landmark in the map every measurement is new: all([]) is True.
    one degree of freedom | chi2.ppf(confidence, 2) -> chi2.ppf(confidence, 1) | Two numbers are compared: chi2 with 2 degrees of freedom.
    as many degrees of freedom as landmarks | chi2.ppf(confidence, 2) -> chi2.ppf(confidence, len(es)) | Each landmark has its own gate, of two numbers: 2 degrees of freedom, however many landmarks there are.
    degrees of freedom of all landmarks | chi2.ppf(confidence, 2) -> chi2.ppf(confidence, 2 * len(es)) | Each landmark has its own gate, of two numbers: 2 degrees of freedom, however many landmarks there are.
    degrees of freedom of all measurements | chi2.ppf(confidence, 2) -> chi2.ppf(confidence, 2 * len(ys)) | Each measurement is tested alone, by two numbers: 2 degrees of freedom.
    other tail | chi2.ppf(confidence, -> chi2.ppf(1 - confidence, | chi2.ppf(confidence, 2), not of 1 - confidence.
    range wrapped instead of the bearing | [y[0] - e[0], -> [wrap(y[0] - e[0]), | The range is a length: wrap the bearing, z[1].
        wrap(y[1] - e[1]) -> y[1] - e[1]
    row of a stack wrapped | z = np.array([y[0] - e[0], wrap(y[1] - e[1])]) -> z = wrap(y - e) if i == 1 else y - e | In a stack of innovations z[1] is the second *row*. The bearings are the second column: z[:, 1].
    R counted twice | E + R -> E + 2 * R | The noise of a measurement counts once: Z = E + R.
    R squared | E + R -> R @ R + E | R is a covariance already: do not square it.
    E of the first landmark | E + R -> Es[0] + R | Each landmark has an expectation and a covariance of its own: es[j] and Es[j].
    measurement of another row | z = np.array([y[0] -> y = ys[j % len(ys)]; z = np.array([y[0] | Row i of D belongs to measurement i, column j to landmark j: z = ys[i] - es[j].
    second column of the landmarks wrapped | z = np.array([y[0] - e[0], wrap(y[1] - e[1])]) -> z = np.array([y[0] - e[0], wrap(y[1] - e[1]) if j == 1 else y[1] - e[1]]) | In a stack of innovations, one row for each landmark, z[1] is the second *row*. The bearings are the last column: z[..., 1].
    landmarks instead of measurements | for i in range(len(ys)) if all(D[i] > limit)] -> for i in range(len(es)) if all(D[:, i] > limit)] | One answer for each *measurement*, a row of D: yours are the landmarks, by its columns.
    logarithm of the determinant added | z @ np.linalg.solve(E + R, z) -> z @ np.linalg.solve(E + R, z) + np.log(np.linalg.det(E + R)) | The gate is for z' inv(Z) z alone. With log det Z it is a likelihood, and not chi-square.
    the other Cholesky factor | np.linalg.solve(E + R, z) -> np.linalg.solve(np.linalg.cholesky(E + R).T @ np.linalg.cholesky(E + R), z) | With Z = L L' the whitened innovation is L^-1 z, and not the inverse of L' times z.
    measurements and landmarks mixed by reshape: The distances came landmark by landmark: reshape them to (n, k), then transpose. Row i of D belongs to measurement i.
        limit = chi2 -> D = D.T.reshape(D.shape); limit = chi2
    """,
)
