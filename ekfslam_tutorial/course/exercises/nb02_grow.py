"""Exercise 02.4: a new landmark in the state and in the covariance."""

import numpy as np

from .. import expect
from ..table import table
from .nb02_q import landmark_of, q, random_pose, random_y


def add_landmark(x, P, y, x_r, R):
    """Put a new landmark behind those in the map.

    x, shape (2n,), and P, shape (2n, 2n), are the map so far; n may be 0. y = [range, bearing] is the first
    measurement of the new landmark, with noise covariance R (slide: Q), from the known pose x_r.
    Return the new x, shape (2n + 2,), and the new P, shape (2n + 2, 2n + 2).
    """
    l, L_y = q(y, x_r)
    n = len(x)
    P_new = np.zeros((n + 2, n + 2))
    P_new[:n, :n] = P
    P_new[n:, n:] = L_y @ R @ L_y.T
    return np.concatenate([x, l]), P_new


def noise(rng):
    """Return a noise covariance that is not diagonal."""
    s = np.array([rng.uniform(0.1, 0.4), rng.uniform(0.02, 0.1)])
    return np.outer(s, s) * [[1, 0.6], [0.6, 1]]


def some(rng, n):
    """Return a map of n landmarks with a covariance of no special form, and a measurement of a new one."""
    A = rng.normal(size=(2 * n, 2 * n))
    P = 0.1 * A @ A.T + 0.05 * np.eye(2 * n)
    return rng.uniform(-5, 5, 2 * n), P, random_y(rng), random_pose(rng), noise(rng)


grown = table(
    "02.4 The map grows",
    add_landmark,
    hints=(
        "The new landmark comes from y and the known x_r. Whose noise is in it? Do the old ones share it?",
        "x_new = [x, l]. P_new has four blocks: the old P, two blocks of zeros, and the covariance of l.",
        "The noise of y reaches l through L_y: covariance L_y R L_y'. The zeros have shapes (2n, 2) and (2, 2n).",
    ),
    returns="x, P",
    symbols="L = the derivative of the landmark by y; L_y = the second result of q, the derivative of the landmark by y",
    cases={"any": lambda rng: [some(rng, n) for n in (3, 1, 2)], "empty": lambda rng: [some(rng, 0)]},
    checks="""
    sizes                          | x[:0], P[:0]        | any   | Each landmark brings two numbers to x, two rows and two columns to P.
    old landmarks                  | x[:-2], P[:-2, :-2] | any   | What was in the map stays where it was, as it was.
    mean of the new landmark       | x[-2:]              | any   | It is l = q(y, x_r), at the end of x.
    covariance of the new landmark | P[-2:, -2:]         | any   | y has the covariance R. What is the covariance of q(y)?
    the first landmark             | x, P                | empty | An empty map has x of shape (0,) and P of shape (0, 0). The same formulas hold: the new x is l alone, the new P is the covariance of l alone.
    """,
    wrong="""
    R itself | L_y @ R @ L_y.T -> R | R is the covariance of range and bearing (m^2, rad^2). A landmark has x and y: carry R over with L_y R L_y'.
    L' R L | L_y @ R @ L_y.T -> L_y.T @ R @ L_y | The transpose is on the wrong side: cov(L y) = L R L'.
    L R only | L_y @ R @ L_y.T -> L_y @ R | A covariance is multiplied from both sides: L R L'.
    no transpose | L_y @ R @ L_y.T -> L_y @ R @ L_y | A covariance is multiplied from both sides, the second time by the transpose: L R L'.
    elementwise product | L_y @ R @ L_y.T -> L_y * R * L_y.T | `*` multiplies entry by entry; matrices are multiplied by `@`.
    standard deviation taken for variance | L_y @ R @ L_y.T -> L_y @ R @ R @ L_y.T | R holds variances already: do not square it.
    square root | L_y @ R @ L_y.T -> L_y @ np.sqrt(np.abs(R)) @ L_y.T | R holds variances, and P wants variances: no square root.
    variances only | L_y @ R @ L_y.T -> np.diag(np.diag(L_y @ R @ L_y.T)) | Your block is diagonal. In the map frame x and y of a landmark are correlated: keep the whole product L R L'.
    noise of range and bearing independent | L_y @ R @ L_y.T -> L_y @ np.diag(np.diag(R)) @ L_y.T | You used the diagonal of R only. R may have a covariance between range and bearing.
    L L' | L_y @ R @ L_y.T -> L_y @ L_y.T | Where is the noise of the sensor? cov(L y) = L R L'.
    identity | L_y @ R @ L_y.T -> np.eye(2) | The sensor tells how uncertain the landmark is: L R L', not 1 m^2 for all.
    zero | L_y @ R @ L_y.T -> 0 | A zero block says that the new landmark is known exactly. It was measured with noise R.
    double counting | L_y @ R @ L_y.T -> L_y @ R @ L_y.T / 2 | Your block is exactly half of L R L': the measurement that starts the landmark must not update it, too.
    very large | L_y @ R @ L_y.T -> 1e6 * np.eye(2) | A large first guess is honest only if the measurement then corrects it. Or directly: L R L'.
    inverse of H missing | L_y @ R @ L_y.T -> np.linalg.inv(L_y) @ R @ np.linalg.inv(L_y).T | Yours is H R H', with H the derivative of range and bearing by x and y. The noise goes the other way: L_y = dl/dy, the inverse of H.
    new landmark first | P_new[:n, :n] = P -> P_new[2:, 2:] = P | The new landmark goes behind the others: the places of the old ones must not change.
        P_new[n:, n:] -> P_new[:2, :2]
        [x, l] -> [l, x]
    measurement instead of landmark | [x, l] -> [x, y] | The map holds x and y of each landmark: append q(y, x_r), not the measurement y.
    correlated with the old ones: Only an uncertain robot would tie the new landmark to the old ones (SLAM). Here the pose is known: zeros.
        P_new[n:, n:] = L_y @ R @ L_y.T -> P_new[n:, :] = np.tile(L_y @ R @ L_y.T, n // 2 + 1); P_new[:, n:] = P_new[n:, :].T
    noise added to all | P_new[n:, n:] = L_y @ R @ L_y.T -> P_new[n:, n:] = L_y @ R @ L_y.T; P_new += np.kron(np.eye(n // 2 + 1), L_y @ R @ L_y.T) | A new landmark tells nothing about the old ones: their block of P stays as it is.
    old covariance lost | P_new[:n, :n] = P -> pass | The old P must stand in the upper left block.
    only the variances of the old ones | P_new[:n, :n] = P -> P_new[:n, :n] = np.diag(np.diag(P)) | The old P stands in the upper left block as it was, with all its covariances.
    bearing column not differentiated | l, L_y = q(y, x_r) -> l, L_y = q(y, x_r); L_y = np.column_stack([L_y[:, 0], y[0] * L_y[:, 0]]) | The second column of L_y is the derivative by the bearing: cos becomes -sin, sin becomes cos.
    heading forgotten in L_y | l, L_y = q(y, x_r) -> l, L_y = q(y, x_r); L_y = q(y, np.array([*x_r[:2], 0.0]))[1] | In L_y, too, sin and cos are taken of the whole direction theta + beta.
    range forgotten in L_y | l, L_y = q(y, x_r) -> l, L_y = q(y, x_r); L_y = L_y / [1, y[0]] | A landmark twice as far away moves twice as much when the bearing changes: the second column of L_y has a factor r.
    sign in L_y | l, L_y = q(y, x_r) -> l, L_y = q(y, x_r); L_y = L_y * [[1, -1], [1, 1]] | d cos(a) = -sin(a) da: the upper right entry of L_y is -r sin(a).
    ones beside the blocks | np.zeros((n + 2, n + 2)) -> np.ones((n + 2, n + 2)) | The pose is known, so the new landmark has nothing in common with the old ones: zeros beside the blocks.
    old covariance lost, an identity in its place: The old landmarks keep their covariance: P comes into the first n rows and columns, in the place of the identity.
        np.zeros((n + 2, n + 2)) -> np.eye(n + 2)
        P_new[:n, :n] = P -> pass
    correlated with the last one: The pose is known: the error of the new landmark has nothing to do with that of the last one. Zeros.
        P_new[n:, n:] = L_y @ R @ L_y.T -> P_new[n:, :n], P_new[:n, n:] = P[-2:, :] if n else 0, P[:, -2:] if n else 0; P_new[n:, n:] = L_y @ R @ L_y.T
    cross-covariance by the sensor | P_new[n:, n:] = L_y @ R @ L_y.T -> P_new[n:, n:] = L_y @ R @ L_y.T; P_new[n:, :n] = np.tile(L_y @ R, n // 2); P_new[:n, n:] = P_new[n:, :n].T | The noises of two measurements have nothing in common, though it is the same sensor, and the pose is known: zeros.
    R on each of the old ones | P_new[:n, :n] = P -> P_new[:n, :n] = P + np.kron(np.eye(n // 2), R) | The old block of P stays as it is: the noise of this measurement is that of the new landmark alone.
    """,
)


def new_P(f, args):
    """Return the covariance of a student's map."""
    n = len(args[0]) + 2
    return expect.array(expect.results(f(*args), "x", "P")[1], (n, n), "P")


KNOWN = "covariance of the new landmark"


@grown.link(
    "symmetric",
    "A covariance is its own transpose: the block of the new landmark is symmetric, the two blocks beside the old P are each other's transpose.",
    1,
    KNOWN,
)
def _(f, rng):
    expect.symmetric(new_P(f, some(rng, 2)), "the new P")


@grown.link("zero blocks", "The pose is known: what could the new landmark have in common with the old ones?", 1, KNOWN)
def _(f, rng):
    P = new_P(f, some(rng, 2))
    zero = not np.any(P[:4, 4:]) and not np.any(P[4:, :4])
    expect.true(zero, "the blocks between the new landmark and the old ones are not exactly zero")


CLOUD = "The map is empty: the new P is one block. Draw many y with covariance R: the landmarks q(y) must scatter as it says."


@grown.link("a cloud of measurements", CLOUD, 1, "the first landmark")
def _(f, rng):
    x_r, y, R = random_pose(rng), np.array([4.0, 1.0]), noise(rng) * 0.01  # small noise: q is a straight line there
    P = new_P(f, (np.zeros(0), np.zeros((0, 0)), y, x_r, R))
    S = np.linalg.cholesky(R)
    cloud = np.array([landmark_of(y + S @ w, x_r) for w in rng.normal(size=(2000, 2))])
    ratio = np.linalg.eigvals(np.linalg.solve(P, np.cov(cloud.T))).real
    # 2000 draws: a variance is right within 3.3 sqrt(2 / 2000) = 10 % (99.9 %), an eigenvalue within 15 %
    within = np.all(np.abs(ratio - 1) < 0.15)
    expect.true(within, f"the cloud is {ratio.max():.2f} times as large as your block (variance)")
