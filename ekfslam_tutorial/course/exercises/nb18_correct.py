"""Exercise 18.2: one sighting of a robot corrects both robots, and all that is correlated with them."""

import numpy as np

from ..table import table


def correct_both(x, P, a, b, z, E_a, E_b, R):
    """Correct the joint state with a sighting of robot b by robot a.

    x, shape (n,), and P, shape (n, n): mean and covariance of all robots and landmarks in one filter.
    a and b: slices, x[a] and x[b] are the poses of the two robots.
    z, shape (m,): the innovation. E_a and E_b, shape (m, 3): its Jacobians by the two poses. R, shape (m, m): noise.
    Return the corrected x, shape (n,), and P, shape (n, n).
    """
    H = np.zeros((len(z), len(x)))
    H[:, a], H[:, b] = E_a, E_b
    Z = H @ P @ H.T + R
    K = np.linalg.solve(Z, H @ P).T
    return x + K @ z, P - K @ Z @ K.T


def case(rng, n=9, a=0, b=3, m=2):
    """Return the arguments: a state whose parts are correlated, and a full R."""
    A = rng.normal(size=(n, n)) * rng.uniform(0.3, 1.5, n)[:, None]
    B = rng.normal(size=(m, m))
    x, z = rng.normal(size=n) * np.where(np.isin(range(n), (a + 2, b + 2)), 1, 6), 0.3 * rng.normal(size=m)
    E_a, E_b = rng.normal(size=(2, m, 3))
    return x, A @ A.T / n + 0.05 * np.eye(n), slice(a, a + 3), slice(b, b + 3), z, E_a, E_b, B @ B.T + 0.2 * np.eye(m)


def by_hand(rng):
    """One number a robot: P_aa = 1, P_bb = 3, R = 1 and z = 1 along x."""
    P, E = np.diag([1.0, 1e-6, 1e-6, 3.0, 1e-6, 1e-6]), np.eye(3)[:1]
    return [(np.zeros(6), P, slice(0, 3), slice(3, 6), np.ones(1), -E, E, np.eye(1))]


def third(rng):
    """A third robot that is correlated with b."""
    P = np.eye(9)
    P[3:6, 6:9] = P[6:9, 3:6] = 0.9 * np.eye(3)
    return [(np.zeros(9), P, slice(0, 3), slice(3, 6), np.array([0.5, -0.2]), *case(rng)[5:])]


def both_orders(x, P, a, b, z, E_a, E_b, R):
    """The same sighting with the names of the robots exchanged."""
    return [(x, P, a, b, z, E_a, E_b, R), (x, P, b, a, z, E_b, E_a, R)]


both = table(
    "18.2 One sighting, two robots",
    correct_both,
    hints=(
        "It is the correction of notebook 05. Only H is new: which columns are not zero?",
        "H is m x n, zero but for H[:, a] = E_a and H[:, b] = E_b. Then Z = H P H' + R and K = P H' Z^-1.",
        "Z holds four products: E_a P_aa E_a', E_a P_ab E_b', its transpose, E_b P_bb E_b'. K has rows for all n numbers, also those of robots and landmarks that are not in z.",
    ),
    returns="x, P",
    symbols="P_bb = P[b, b]; P_ab = P[a, b]",
    cases={
        "any": lambda rng: [case(rng, *c) for c in ((9,), (9, 6, 0), (13, 3, 8), (6, 0, 3, 1), (18, 12, 3, 3))],
        "by hand": by_hand,
        "third": third,
        "order": lambda rng: both_orders(*case(rng, 9, 6, 0)),
    },
    checks="""
    one robot each      | x | by hand | One number a robot, so that you can follow it by hand: E_a goes into the columns a of H, E_b into b, Z = H P H' + R; the gain of b is P_bb / Z here.
    mean                | x | any     | x + K z, with K = P H' Z^-1 and Z = H P H' + R: K has a row for each number of the state. Here all numbers are correlated, R is full, and b may stand before a.
    covariance          | P | any     | P - K Z K', or (I - K H) P, or Joseph's form.
    a third robot       | x[6:], P | third | A robot that is correlated with b must move, too: K has rows for it.
    order of the robots | x, P | order   | The same with a behind b in the state: nothing may depend on the order.
    """,
    wrong="""
    robot b taken as known | H[:, a], H[:, b] = E_a, E_b -> H[:, a] = E_a | Robot b is uncertain, too. Without E_b in H robot a believes it as if it were a surveyed mark, and b learns nothing.
    robot a taken as known | H[:, a], H[:, b] = E_a, E_b -> H[:, b] = E_b | Robot a is uncertain, too: its block E_a belongs in H.
    only the one who looks | return x + K @ z, P - K @ Z @ K.T -> K = _rows(K, a); return x + K @ z, P - K @ H @ P | K has rows for all numbers: b, and all that is correlated with either of them, must move.
    only the one who is seen | return x + K @ z, P - K @ Z @ K.T -> K = _rows(K, b); return x + K @ z, P - K @ H @ P | K has rows for all numbers: a moves, too.
    only the two robots | return x + K @ z, P - K @ Z @ K.T -> K = _rows(K, a, b); return x + K @ z, P - K @ H @ P | Landmarks and other robots are correlated with the two: K has a row for every number of the state, in x as in P.
    cross-covariance left out of Z | H @ P @ H.T + R -> E_a @ P[a, a] @ E_a.T + E_b @ P[b, b] @ E_b.T + R | The two robots share landmarks, so they are correlated: Z holds E_a P[a, b] E_b' and its transpose, too. H P H' does it all.
    cross-covariance counted once | H @ P @ H.T + R -> E_a @ P[a, a] @ E_a.T + E_b @ P[b, b] @ E_b.T + R + E_a @ P[a, b] @ E_b.T | E_a P[a, b] E_b' comes twice in Z, once transposed. H P H' does it all.
    b left out of Z | H @ P @ H.T + R -> E_a @ P[a, a] @ E_a.T + R | The place of b is uncertain, too: Z = H P H' + R with both blocks in H.
    no R | H.T + R -> H.T | The camera is noisy: Z = H P H' + R.
    R counted twice | H.T + R -> H.T + 2 * R | One sighting has one R, although it is about two robots.
    robots exchanged | = E_a, E_b -> = E_b, E_a | E_a belongs in the columns a of H, E_b in the columns b.
    x minus K z | x + K @ z -> x - K @ z | z is measured minus expected: the correction is added, x + K z, with E_a and E_b in H as they are. A minus stands in one of these places.
    x left as it was | x + K @ z -> x | Add K z to the mean.
    P left as it was | P - K @ Z @ K.T -> P | The sighting makes all that is correlated with it more certain: P - K Z K'.
    P grows | P - K @ Z -> P + K @ Z | A correction takes uncertainty away: minus.
    corrected twice | x + K @ z, P - K @ Z @ K.T -> x + 2 * K @ z, P - 2 * K @ Z @ K.T | One sighting is one correction, although it is about two robots. Used for a and then again for b, it counts twice.
    one correction for a, one for b | return x + K @ z, P - K @ Z @ K.T -> return _in_turn(x, P, z, R, (a, E_a), (b, E_b)) | One sighting is one correction. Two in a row, one for each robot, use the same z twice, and P[a, b] is missing in Z: put E_a and E_b into one H.
    one correction for b, one for a | return x + K @ z, P - K @ Z @ K.T -> return _in_turn(x, P, z, R, (b, E_b), (a, E_a)) | One sighting is one correction. Two in a row, one for each robot, use the same z twice, and P[a, b] is missing in Z: put E_a and E_b into one H.
    the first two robots always | H[:, a], H[:, b] = E_a, E_b -> H[:, 0:3], H[:, 3:6] = E_a, E_b | a and b are slices: H[:, a] = E_a and H[:, b] = E_b, not 0:3 and 3:6.
    P corrected once | P - K @ Z @ K.T -> P - K @ H | K goes on both sides: P - K Z K', or P - K H P.
    sign of E_b | = E_a, E_b -> = E_a, -E_b | E_b is a derivative already, with its sign: H[:, b] = E_b.
    Joseph without the noise | P - K @ Z @ K.T -> (np.eye(len(x)) - K @ H) @ P @ (np.eye(len(x)) - K @ H).T | The new P is (I - K H) P, with (I - K H) once. With it on both sides, as in Joseph's form, a second term belongs there: + K R K'.
    only the blocks of the two robots | P - K @ Z @ K.T -> P - _rows(K, a, b) @ Z @ _rows(K, a, b).T | All of P changes: P - K Z K'. What is correlated with the two robots is known better, too.
    columns sorted | H[:, a], H[:, b] = E_a, E_b -> at = sorted([*range(len(x))[a], *range(len(x))[b]]); H[:, at] = np.hstack([E_a, E_b]) | E_a belongs in the columns of a, E_b in those of b, also where b stands before a in the state.
    whole state wrapped | return x + K @ z, -> return (x + K @ z + np.pi) % (2 * np.pi) - np.pi, | Positions are no angles: wrap a heading, if anything, and not the whole state.
    K R K' taken off | K @ Z @ K.T -> K @ R @ K.T | P - K Z K' has the whole Z = H P H' + R in it, not R alone.
    E_a in both | H[:, a], H[:, b] = E_a, E_b -> H[:, a], H[:, b] = E_a, -E_a | The columns of b are E_b, as it is given. E_b is not -E_a: their columns of the heading differ.
    """,
    forms="""
    P - K H P | P - K @ Z @ K.T -> P - K @ H @ P | P - K H P
    """,
)


def _rows(K, *kept):
    """K, with zeros in all rows but these."""
    out = np.zeros_like(K)
    for rows in kept:
        out[rows] = K[rows]
    return out


def _in_turn(x, P, z, R, *robots):
    """A correction for each robot, as if the other one were known, all with the same innovation."""
    for rows, E in robots:
        H = np.zeros((len(z), len(x)))
        H[:, rows] = E
        Z = H @ P @ H.T + R
        K = np.linalg.solve(Z, H @ P).T
        x, P = x + K @ z, P - K @ Z @ K.T
    return x, P
