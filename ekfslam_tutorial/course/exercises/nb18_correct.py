"""Exercise 18.2: one sighting of a robot corrects both robots, and all that hangs together with them."""

import numpy as np

from .. import expect
from ..exercise import Exercise


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


both = Exercise(
    "18.2",
    "One sighting, two robots",
    correct_both,
    hints=(
        "It is the correction of notebook 05. Only H is new: which columns are not zero?",
        "H is m x n, zero but for H[:, a] = E_a and H[:, b] = E_b. Then Z = H P H' + R and K = P H' Z^-1.",
        "Z holds four products: E_a P_aa E_a', E_a P_ab E_b', its transpose, E_b P_bb E_b'. K has rows for all n "
        "numbers, also those of robots and landmarks that are not in z.",
    ),
)

CASES = ((9, 0, 3, 2), (9, 6, 0, 2), (13, 3, 8, 2), (6, 0, 3, 1), (18, 12, 3, 3))  # n, start of a, start of b, m


def case(rng, n=9, a=0, b=3, m=2):
    """Return the arguments: a state whose parts hang together, and a full R."""
    A = rng.normal(size=(n, n)) * rng.uniform(0.3, 1.5, n)[:, None]
    B = rng.normal(size=(m, m))
    x, z = rng.normal(size=n), 0.3 * rng.normal(size=m)
    E_a, E_b = rng.normal(size=(2, m, 3))
    return x, A @ A.T / n + 0.05 * np.eye(n), slice(a, a + 3), slice(b, b + 3), z, E_a, E_b, B @ B.T + 0.2 * np.eye(m)


def _two(result, n):
    x, P = expect.results(result, "x", "P")
    return expect.array(x, n, "x"), expect.array(P, (n, n), "P")


@both.link("two results", "The function must end with `return x, P`.")
def _(f, rng):
    for n, a, b, m in CASES:
        _two(f(*case(rng, n, a, b, m)), n)


@both.link(
    "one robot each", "One number a robot, so that you can follow it by hand: the gain of b is P_bb / Z.", part=0
)
def _(f, rng):
    P = np.diag([1.0, 1e-6, 1e-6, 3.0, 1e-6, 1e-6])
    E_a, E_b = np.array([[-1.0, 0, 0]]), np.array([[1.0, 0, 0]])
    x, _ = _two(f(np.zeros(6), P, slice(0, 3), slice(3, 6), np.array([1.0]), E_a, E_b, np.array([[1.0]])), 6)
    want = [-0.2, 0, 0, 0.6, 0, 0]
    expect.close(x, want, "x", 1e-5, 1e-6, at="P_aa = 1, P_bb = 3, R = 1 and z = 1 along x")


@both.link("mean", "x + K z, with K = P H' Z^-1: rows for all numbers of the state.", part=0)
def _(f, rng):
    for c in CASES:
        args = case(rng, *c)
        expect.close(_two(f(*args), c[0])[0], correct_both(*args)[0], "x", 1e-6, at=f"n = {c[0]}")


@both.link("covariance", "P - K Z K', or (I - K H) P, or Joseph's form.", part=1)
def _(f, rng):
    for c in CASES:
        args = case(rng, *c)
        P = _two(f(*args), c[0])[1]
        expect.close(P, correct_both(*args)[1], "P", 1e-6, at=f"n = {c[0]}")
        expect.symmetric(P, "P", 1e-7)
        expect.psd(P, "P", 1e-7)


@both.link("a third robot", "A robot that hangs together with b must move, too: K has rows for it.")
def _(f, rng):
    n = 9
    P = np.eye(n)
    P[3:6, 6:9] = P[6:9, 3:6] = 0.9 * np.eye(3)
    args = (np.zeros(n), P, slice(0, 3), slice(3, 6), np.array([0.5, -0.2]), *case(rng)[5:])
    x, Q = _two(f(*args), n)
    expect.close(x[6:], 0.9 * x[3:6], "the third robot", 1e-6, at="0.9 of the correction of b")
    expect.true(np.trace(Q[6:, 6:]) < np.trace(P[6:, 6:]), "the third robot is as uncertain as before")


@both.link("order of the robots", "The same with a behind b in the state: nothing may depend on the order.")
def _(f, rng):
    x, P, a, b, z, E_a, E_b, R = case(rng, 9, 6, 0)
    one, two = _two(f(x, P, a, b, z, E_a, E_b, R), 9), _two(f(x, P, b, a, z, E_b, E_a, R), 9)
    expect.close(two[0], one[0], "x with the names of the robots exchanged", 1e-7)
    expect.close(two[1], one[1], "P with the names of the robots exchanged", 1e-7)


def _H(x, a, b, z, E_a, E_b):
    H = np.zeros((len(z), len(x)))
    H[:, a], H[:, b] = E_a, E_b
    return H


def _wrong(name, hint, H=None, Z=None, keep=None, x_of=None, P_of=None):
    """A misconception in one step: H(H, a, b), Z(Z, P, a, b, E_a, E_b, R), rows of K that are kept, x or P."""

    @both.wrong(name, hint)
    def _(x, P, a, b, z, E_a, E_b, R):
        G = _H(x, a, b, z, E_a, E_b)
        if H:
            G = H(G.copy(), a, b)
        S = G @ P @ G.T + R
        if Z:
            S = Z(S, P, a, b, E_a, E_b, R)
        K = np.linalg.solve(S, G @ P).T
        if keep:
            rows = np.zeros(len(x), bool)
            for s in keep(a, b):
                rows[s] = True
            K = K * rows[:, None]
        new_P = P - K @ G @ P if keep else P - K @ S @ K.T
        return x_of(x, K, z) if x_of else x + K @ z, P_of(P, K, S, G) if P_of else new_P


def _without(which):
    def change(H, a, b):
        H[:, (a, b)[which]] = 0
        return H

    return change


# fmt: off
_wrong("robot b taken as known", "Robot b is uncertain, too. Without E_b in H robot a believes it as if it were a "
       "surveyed mark, and b learns nothing.", H=_without(1))
_wrong("robot a taken as known", "Robot a is uncertain, too: its block E_a belongs into H.", H=_without(0))
_wrong("only the one who looks", "K has rows for all numbers: b, and all that hangs together with either of them, must "
       "move.", keep=lambda a, b: (a,))
_wrong("only the one who is seen", "K has rows for all numbers: a moves, too.", keep=lambda a, b: (b,))
_wrong("only the two robots", "Landmarks and other robots hang together with the two. Leave the rows of K in: whoever "
       "drops them, breaks P.", keep=lambda a, b: (a, b))
_wrong("cross-covariance left out of Z", "The two robots share landmarks, so they are correlated: Z holds E_a P_ab "
       "E_b' and its transpose, too. H P H' does it all.",
       Z=lambda Z, P, a, b, E_a, E_b, R: E_a @ P[a, a] @ E_a.T + E_b @ P[b, b] @ E_b.T + R)
_wrong("cross-covariance counted once", "E_a P_ab E_b' comes twice in Z, once transposed. H P H' does it all.",
       Z=lambda Z, P, a, b, E_a, E_b, R: E_a @ P[a, a] @ E_a.T + E_b @ P[b, b] @ E_b.T + R + E_a @ P[a, b] @ E_b.T)
_wrong("b left out of Z", "The place of b is uncertain, too: Z = H P H' + R with both blocks in H.",
       Z=lambda Z, P, a, b, E_a, E_b, R: E_a @ P[a, a] @ E_a.T + R)
_wrong("no R", "The camera is noisy: Z = H P H' + R.", Z=lambda Z, P, a, b, E_a, E_b, R: Z - R)
_wrong("R counted twice", "One sighting has one R, although it is about two robots.",
       Z=lambda Z, P, a, b, E_a, E_b, R: Z + R)
_wrong("robots exchanged", "E_a belongs into the columns a of H, E_b into the columns b.",
       H=lambda H, a, b: _swapped(H, a, b))
_wrong("x minus K z", "z is measured minus expected, so the correction is added.", x_of=lambda x, K, z: x - K @ z)
_wrong("x left as it was", "Add K z to the mean.", x_of=lambda x, K, z: x.copy())
_wrong("P left as it was", "The sighting makes all that hangs together with it more certain: P - K Z K'.",
       P_of=lambda P, K, Z, H: P.copy())
_wrong("P grows", "A correction takes uncertainty away: minus.", P_of=lambda P, K, Z, H: P + K @ Z @ K.T)
_wrong("corrected twice", "One sighting is one correction, although it is about two robots. Used for a and then again "
       "for b, it counts twice.", x_of=lambda x, K, z: x + 2 * K @ z, P_of=lambda P, K, Z, H: P - 2 * K @ Z @ K.T)
# fmt: on


def _swapped(H, a, b):
    G = H.copy()
    G[:, a], G[:, b] = H[:, b], H[:, a]
    return G


@both.wrong("the first two robots always", "a and b are slices: H[:, a] = E_a and H[:, b] = E_b, not 0:3 and 3:6.")
def _(x, P, a, b, z, E_a, E_b, R):
    return correct_both(x, P, slice(0, 3), slice(3, 6), z, E_a, E_b, R)


@both.variant("with the inverse, and Joseph's form")
def _(x, P, a, b, z, E_a, E_b, R):
    H = _H(x, a, b, z, E_a, E_b)
    K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
    L = np.eye(len(x)) - K @ H
    return x + K @ z, L @ P @ L.T + K @ R @ K.T


@both.variant("block by block, lists")
def _(x, P, a, b, z, E_a, E_b, R):
    PHt = P[:, a] @ E_a.T + P[:, b] @ E_b.T
    Z = E_a @ PHt[a] + E_b @ PHt[b] + R
    K = PHt @ np.linalg.inv(Z)
    return (x + K @ z).tolist(), (P - K @ PHt.T).tolist()


@both.variant("Cholesky factor")
def _(x, P, a, b, z, E_a, E_b, R):
    H = _H(x, a, b, z, E_a, E_b)
    L = np.linalg.cholesky(H @ P @ H.T + R)
    W = np.linalg.solve(L, H @ P)
    return x + W.T @ np.linalg.solve(L, z), P - W.T @ W
