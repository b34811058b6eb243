"""Exercise 05.3: the correction of the whole state by one measurement."""

import numpy as np

from ...geometry import wrap
from ..table import table
from .nb04_blocks import random_covariance
from .nb05_observe import case as state_with_landmark
from .nb05_observe import observe


def correct(x, P, y, R, e, H):
    """Correct the whole state with one measurement of range and bearing.

    x, shape (n,), and P, shape (n, n): joint state, the robot's pose first, and its covariance.
    y = [range, bearing]: the measurement; R, shape (2, 2): its covariance.
    e, shape (2,), and H, shape (2, n): the expected measurement and its derivative by x. The bearings in y and e
    may be several whole turns apart.
    Return the new x and P. Do not change the inputs.
    """
    z = np.array([y[0] - e[0], wrap(y[1] - e[1])])
    PHt = P @ H.T
    Z = H @ PHt + R
    K = np.linalg.solve(Z, PHt.T).T
    x = x + K @ z
    P = P - K @ Z @ K.T
    return x, P


def case(rng, n=9, at=5, scale=0.01, z=None):
    """Return the arguments of `correct`: a state, and a measurement of one landmark that is off by z."""
    x, l = state_with_landmark(rng, n, at)
    e, H = observe(x, l)
    y = e + (rng.normal(size=2) * [0.2, 0.1] if z is None else np.asarray(z))
    y[1] = wrap(y[1])
    return x, random_covariance(rng, n, scale), y, random_covariance(rng, 2, 0.02), e, H


def with_bearings(rng, expected, measured):
    """Return a measurement with these bearings."""
    x, P, y, R, e, H = case(rng)
    return x, P, np.array([y[0], measured]), R, np.array([e[0], expected]), H


def turns_more(rng, turns):
    """Return a measurement whose bearing has whole turns more."""
    x, P, y, R, e, H = case(rng)
    return x, P, y + [0, 2 * np.pi * turns], R, e, H


def one_after_the_other(rng):
    """Return ten corrections with the same sensor, each with the covariance that the one before has left."""
    x, P, *others = case(rng)
    calls = []
    for _ in range(10):
        calls.append((x, P, *others))
        P = correct(x, P, *others)[1]
    return calls


correction = table(
    "05.3 Correct",
    correct,
    hints=(
        "Innovation z = y - e, its covariance Z, the gain K, then x and P: five lines, for the whole state at once.",
        "Z = H P H' + R and K = P H' inv(Z). The second number of z is an angle.",
        "z = [y[0] - e[0], wrap(y[1] - e[1])]; x + K z; P - K Z K', which is (I - K H) P.",
    ),
    returns="x, P",
    angles={"x": 2},
    cases={
        "any": lambda rng: [case(rng, n, at) for n, at in ((9, 5), (5, 3), (13, 11))],
        "expected": lambda rng: [case(rng, z=[0, 0])],
        "scales": lambda rng: [
            case(rng, n, at, scale) for n, at, scale in ((9, 5, 0.01), (5, 3, 1.0), (9, 7, 0.01), (13, 3, 1e-4))
        ],
        "seam": lambda rng: [
            with_bearings(rng, np.pi + 0.02, -np.pi + 0.01),
            with_bearings(rng, np.pi - 0.02, -np.pi + 0.03),
            with_bearings(rng, -np.pi + 0.02, np.pi - 0.03),
        ],
        "turns": lambda rng: [turns_more(rng, turns) for turns in (1, -1, 2, -3)],
        "aside": lambda rng: [case(rng, z=[0.1, off]) for off in (2.0, -2.5)],
        "far": lambda rng: [case(rng, scale=1.0, z=[far, 0.05]) for far in (4.0, -3.6)],
        "often": one_after_the_other,
    },
    checks="""
    no surprise, no change   | x | expected | If the measurement is exactly as expected, z = y - e is zero: the new x is the old one, with shape (n,).
    the mean                 | x | scales   | x + K z, all numbers of the state, with z = y - e (its bearing wrapped), K = P H' inv(Z) and the 2 x 2 matrix Z = H P H' + R.
    the seam                 | x | seam     | The bearings in y and e lie close to +-pi. There a small difference can look large: the second number of z, wrapped, is less than 0.1 rad in size here.
    whole turns              | x | turns    | 350, -10 and 710 degrees are the same direction: whole turns of a bearing do not count, however many.
    a bearing far off        | x | aside    | The bearing of y - e is 2 rad here, and then -2.5 rad, or a whole turn more or less. Wrapped it lies between -pi and pi.
    the range is no angle    | x | far      | The range is a distance: z[0] = y[0] - e[0], also where that is 4 m, which is more than pi.
    the covariance           | P | scales   | P - K Z K' (or (I - K H) P, or Joseph's form), an n x n matrix, with the same K and Z as for the mean.
    a covariance that shrinks | P | often   | P must stay symmetric, and a correction makes no direction less certain.
    """,
    wrong="""
    bearing not wrapped | wrap(y[1] - e[1]) -> y[1] - e[1] | 3.12 and -3.12 rad are nearly the same direction: wrap the difference of the bearings.
    range wrapped, too | [y[0] - e[0], -> [wrap(y[0] - e[0]), | The range is a distance, not an angle: wrap z[1] only.
    bearings wrapped, not their difference | wrap(y[1] - e[1]) -> wrap(y[1]) - wrap(e[1]) | Wrap the difference: two wrapped angles can still be nearly 2 pi apart.
    at most one turn: A heading that has counted several turns puts e several turns away: one correction by 2 pi is not enough. wrap() takes off all turns.
        wrap(y[1] - e[1]) -> (d := y[1] - e[1]) - 2 * np.pi * (d > np.pi) + 2 * np.pi * (d < -np.pi)
    wrapped to 0 ... 2 pi | wrap(y[1] - e[1]) -> (y[1] - e[1]) % (2 * np.pi) | A small negative difference must stay small and negative: wrap into (-pi, pi].
    brackets forgotten | wrap(y[1] - e[1]) -> (y[1] - e[1] + np.pi) % 2 * np.pi - np.pi | Python reads `% 2*np.pi` as `(... % 2) * np.pi`. The whole turn needs brackets: % (2 * np.pi).
    expected minus measured | PHt = P @ H.T -> z = -z; PHt = P @ H.T | The innovation is measurement minus expectation, z = y - e, and x + K z moves towards it.
    bearing in degrees | wrap(y[1] - e[1]) -> np.degrees(wrap(y[1] - e[1])) | Angles are in radians everywhere.
    measurement instead of innovation | np.array([y[0] - e[0], wrap(y[1] - e[1])]) -> y | What moves the state is the surprise, z = y - e.
    Z without R | H @ PHt + R -> H @ PHt | The measurement has noise, too: Z = H P H' + R.
    R for Z | np.linalg.solve(Z, PHt.T).T -> np.linalg.solve(R, PHt.T).T | The gain divides by the whole uncertainty of the innovation, Z = H P H' + R, not by R alone.
        K @ Z @ K.T -> K @ H @ P
    Z not inverted | np.linalg.solve(Z, PHt.T).T -> PHt @ Z | K = P H' inv(Z): a large uncertainty of the innovation makes a small gain.
    R squared | H @ PHt + R -> H @ PHt + R**2 | R holds variances already: do not square it.
    square root of R | H @ PHt + R -> H @ PHt + np.sqrt(np.abs(R)) | R holds variances, and Z = H P H' + R needs variances: no square root.
    only the diagonal of R | H @ PHt + R -> H @ PHt + np.diag(np.diag(R)) | Use the whole R: the noise of range and bearing may be correlated.
    inverse entry by entry | np.linalg.solve(Z, PHt.T).T -> PHt @ (1 / Z) | inv(Z) is the inverse of a matrix, not 1 / Z for each entry.
    P forgotten in the gain | np.linalg.solve(Z, PHt.T).T -> np.linalg.solve(Z, H).T | K = P H' inv(Z): the gain begins with P.
    x unchanged | x = x + K @ z -> pass | The innovation moves the state: x + K z.
    only the robot | x = x + K @ z -> x = x + (np.arange(len(x)) < 3) * (K @ z) | That is localisation: in SLAM the landmarks are uncertain, too. Correct the whole state.
    only the landmarks | x = x + K @ z -> x = x + (np.arange(len(x)) >= 3) * (K @ z) | That is mapping: in SLAM the pose is uncertain, too. Correct the whole state.
    only robot and seen landmark | x = x + K @ z -> x = x + H.any(0) * (K @ z) | The other landmarks share errors with robot and landmark: correct the whole state. A filter that does not do so diverges.
    covariance unchanged | P = P - K @ Z @ K.T -> pass | The measurement brings information: P - K Z K'.
    covariance added | P = P - K -> P = P + K | The measurement brings information: K Z K' is subtracted.
    K R K' subtracted | K @ Z @ K.T -> K @ R @ K.T | P - K Z K' has the whole Z = H P H' + R in it.
    K H P H' K' subtracted | K @ Z @ K.T -> K @ (Z - R) @ K.T | P - K Z K' has the whole Z = H P H' + R in it.
    half of Joseph's form | P = P - K @ Z @ K.T -> A = np.eye(len(P)) - K @ H; P = A @ P @ A.T | (I - K H) stands twice in your P. Once is right: (I - K H) P. With it on both sides, as in Joseph's form, a second term belongs there: + K R K'.
    I - K H | P = P - K @ Z @ K.T -> P = np.eye(len(P)) - K @ H | I - K H is only the factor: multiply it by P.
    P (I - K H) | P = P - K @ Z @ K.T -> P = P @ (np.eye(len(P)) - K @ H) | The order matters: (I - K H) P. Yours is not symmetric.
    only the seen block of P | P = P - K @ Z @ K.T -> P = P - np.outer(H.any(0), H.any(0)) * (K @ Z @ K.T) | All of P changes: the other landmarks and their covariances, too.
    only the robot's block of P | P = P - K @ Z @ K.T -> i = np.arange(len(x)) < 3; P = P - np.outer(i, i) * (K @ Z @ K.T) | All of P changes: landmarks and covariances, too.
    cross-covariances deleted | return x, P -> return x, P * (np.kron(np.eye((len(P) + 1) // 2), np.ones((2, 2)))[1:, 1:] > 0) | A correction does not make robot and landmarks independent: keep all blocks of P.
    gain transposed | np.linalg.solve(Z, PHt.T).T -> np.linalg.solve(Z, PHt.T) | K = P H' inv(Z) has a row for each number of the state: n x 2, not 2 x n.
    columns instead of vectors | return x, P -> return x[:, None], P | Vectors have one axis here: x has shape (n,), no columns.
    only the diagonal of Z | Z = H @ PHt + R -> Z = np.diag(np.diag(H @ PHt + R)) | Range and bearing are correlated through P: use the whole Z, not only its diagonal.
    R counted twice | H @ PHt + R -> H @ PHt + 2 * R | The noise of a measurement counts once: Z = H P H' + R.
    K H subtracted | K @ Z @ K.T -> K @ H | K H has no unit: it is K H P, or K Z K', that is taken off P.
    only the variances of P | return x, P -> return x, np.diag(np.diag(P)) | A correction does not make the states independent: keep all of P, not only its diagonal.
    half turns removed | wrap(y[1] - e[1]) -> np.arctan(np.tan(y[1] - e[1])) | A whole turn is 2 pi. Directions that differ by pi are opposite, not the same.
    arcsine of the sine | wrap(y[1] - e[1]) -> np.arcsin(np.sin(y[1] - e[1])) | An arcsine ends at 90 degrees: a difference of 100 degrees becomes one of 80. arctan2(sine, cosine) knows all directions.
    shift not undone | wrap(y[1] - e[1]) -> (y[1] - e[1] + np.pi) % (2 * np.pi) | The bearing of z comes out half a turn too large. What may be taken off are whole turns, 2 pi; what is shifted by pi before a % is shifted back after it.
    bearing without its sign | wrap(y[1] - e[1]) -> abs(wrap(y[1] - e[1])) | The innovation of the bearing has a sign: to the left is positive, to the right is negative.
    gain of the others zero | K = np.linalg.solve(Z, PHt.T).T -> K = np.linalg.solve(Z, PHt.T).T * H.any(0)[:, None] | The other landmarks share errors with robot and landmark: K has all its rows, and x and all of P change.
    """,
    forms="""
    P - K H P | P - K @ Z @ K.T -> P - K @ H @ P | P - K H P
    Joseph | P - K @ Z @ K.T -> (np.eye(len(P)) - K @ H) @ P @ (np.eye(len(P)) - K @ H).T + K @ R @ K.T | of Joseph
    """,
)
