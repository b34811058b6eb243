"""Exercise 04.4: what the sight of one landmark does to another one."""

import numpy as np

from ...geometry import Frame2
from ...models.landmarks import EucPnt
from ...models.observation import observe
from ...models.sensors import RangeBearing
from .. import expect
from ..exercise import Exercise
from .nb04_blocks import random_covariance


def effect_on(P, H, R, b):
    """What a measurement of one landmark does to another one, landmark B, that is not in view.

    P, shape (n, n): covariance of the joint state.
    H, shape (m, n): derivative of the measurement by the joint state; zero in the columns of B.
    R, shape (m, m): covariance of the measurement.
    b: the range of landmark B, a slice; P[b, b] is its covariance now.
    Return K_b, shape (2, m): landmark B moves by K_b z; and P_bb, shape (2, 2), its covariance afterwards.
    """
    PHt = P @ H.T
    Z = H @ PHt + R
    K_b = PHt[b] @ np.linalg.inv(Z)
    P_bb = P[b, b] - K_b @ Z @ K_b.T
    return K_b, P_bb


effect = Exercise(
    "04.4",
    "Seeing landmark A changes landmark B",
    effect_on,
    hints=(
        "Correct the whole state on paper: K = P H' inv(Z), x + K z, P - K Z K'. Landmark B owns some rows of K.",
        "The rows of P H' that belong to B are (P @ H.T)[b] = P[b] @ H.T: not zero, although H is zero in B's columns.",
        "Z = H P H' + R, K_b = P[b] H' inv(Z), P_bb = P[b, b] - K_b Z K_b'.",
    ),
)

B = slice(7, 9)


def _case(rng, n=9, scale=1.0, m=2, noise=0.05):
    """Robot, landmark A in the range 3:5, other landmarks; a measurement of A, of m numbers."""
    x = rng.uniform(-4, 4, n)
    x[3:5] = x[:2] + rng.uniform(2, 4, 2)
    _, E_r, _, E_l = observe(Frame2(x[:3]), Frame2(np.zeros(3)), RangeBearing(1, 1), EucPnt(2), x[3:5])
    H = np.zeros((2, n))
    H[:, :3], H[:, 3:5] = E_r, E_l
    return random_covariance(rng, n, scale), H[:m], random_covariance(rng, m, noise * scale)


def _out(result, m=2):
    K_b, P_bb = expect.results(result, "K_b", "P_bb")
    return expect.array(K_b, (2, m), "K_b"), expect.array(P_bb, (2, 2), "P_bb")


@effect.link("shapes", "K_b has the 2 rows of landmark B and one column for each number of the measurement.")
def _(f, rng):
    for n, b in ((9, B), (7, slice(5, 7)), (13, slice(9, 11))):
        _out(f(*_case(rng, n), b))
    _out(f(*_case(rng, m=1), B), 1)


@effect.link("B shares nothing", "If B has no covariance with robot and A, its gain is zero and it stays as it is.")
def _(f, rng):
    P, H, R = _case(rng)
    P[7:, :7], P[:7, 7:] = 0, 0
    K_b, P_bb = _out(f(P, H, R, B))
    expect.close(K_b, np.zeros((2, 2)), "K_b of a landmark that shares no error with robot and A")
    expect.close(P_bb, P[B, B], "P_bb of a landmark that shares no error with robot and A")


@effect.link("the gain of B", "K = P H' inv(H P H' + R): which rows of it are B's?", part=0)
def _(f, rng):
    for n, b, scale in ((9, B, 1.0), (7, slice(5, 7), 1.0), (13, slice(9, 11), 1e-3)):
        P, H, R = _case(rng, n, scale)
        want = np.linalg.solve(H @ P @ H.T + R, H @ P[:, b]).T
        expect.close(_out(f(P, H, R, b))[0], want, "K_b", 1e-4)


@effect.link("the covariance of B", "P - K Z K' for the whole state; B's block of it is P[b, b] - K_b Z K_b'.", part=1)
def _(f, rng):
    for n, b, scale in ((9, B, 1.0), (7, slice(5, 7), 1.0), (13, slice(9, 11), 1e-3)):
        P, H, R = _case(rng, n, scale)
        want = np.linalg.inv(np.linalg.inv(P) + H.T @ np.linalg.solve(R, H))[b, b]  # information adds up
        expect.close(_out(f(P, H, R, b))[1], want, "P_bb", 1e-4)


@effect.link("a measurement of one number", "Nothing here needs two numbers: a range alone, with m = 1, works, too.")
def _(f, rng):
    P, H, R = _case(rng, m=1)
    want = np.linalg.solve(H @ P @ H.T + R, H @ P[:, B]).T
    expect.close(_out(f(P, H, R, B), 1)[0], want, "K_b of a measurement of one number")


@effect.link("a covariance that shrinks", "What was P_bb before, minus what it is now, has no negative eigenvalue.")
def _(f, rng):
    for _ in range(3):
        P, H, R = _case(rng)
        P_bb = _out(f(P, H, R, B))[1]
        expect.symmetric(P_bb, "P_bb", 1e-6)
        expect.psd(P_bb, "P_bb")
        expect.psd(P[B, B] - P_bb, "the loss of covariance of B", 1e-6)


def _wrong(name, hint, K=None, Pb=None):
    """A misconception in the gain (the covariance follows from it unless given) or in the covariance alone."""

    @effect.wrong(name, hint)
    def _(P, H, R, b):
        Z = H @ P @ H.T + R
        K_b = P[b] @ H.T @ np.linalg.inv(Z)
        if K:
            K_b = K(P, H, R, b, Z)
        return K_b, P[b, b] - K_b @ Z @ np.transpose(K_b) if Pb is None else Pb(P, H, R, b, Z, K_b)


inv = np.linalg.inv
# fmt: off
_wrong("B is not in view, so it stays", "A and B were seen by the same uncertain robot: they share errors, and what "
       "corrects A corrects B. H is zero in B's own columns, so take B's whole rows of P: P[b] @ H.T.",
       K=lambda P, H, R, b, Z: np.zeros((2, len(R))))
_wrong("(I - K H) with B's block only", "In P - K H P the row of B is P[b] - K_b H P, with the whole H and P. B's own "
       "part of H is zero, so (I - K_b H_b) P_bb changes nothing.", Pb=lambda P, H, R, b, Z, K: P[b, b])
_wrong("Z without R", "Z is the covariance of z = y - e: the measurement has noise, too. Z = H P H' + R.",
       K=lambda P, H, R, b, Z: P[b] @ H.T @ inv(Z - R))
_wrong("R for Z", "The gain divides by the whole uncertainty of the innovation, Z = H P H' + R, not by R alone.",
       K=lambda P, H, R, b, Z: P[b] @ H.T @ inv(R))
_wrong("only the diagonal of R", "Use the whole R: the noise of range and bearing may be correlated.",
       K=lambda P, H, R, b, Z: P[b] @ H.T @ inv(Z - R + np.diag(np.diag(R))))
_wrong("Z not inverted", "K = P H' inv(Z): a large uncertainty of the innovation makes a small gain.",
       K=lambda P, H, R, b, Z: P[b] @ H.T @ Z)
_wrong("sign of the gain", "With z = y - e the gain is + P H' inv(Z).", K=lambda P, H, R, b, Z: -P[b] @ H.T @ inv(Z))
_wrong("the whole gain", "K has a row for each number of the state: return only those of landmark B, K[b].",
       K=lambda P, H, R, b, Z: P @ H.T @ inv(Z), Pb=lambda P, H, R, b, Z, K: P[b, b] - K[b] @ Z @ K[b].T)
_wrong("gain transposed", "K_b has 2 rows (landmark B) and m columns (the measurement): yours is transposed.",
       K=lambda P, H, R, b, Z: (P[b] @ H.T @ inv(Z)).T, Pb=lambda P, H, R, b, Z, K: P[b, b] - K.T @ Z @ K)
_wrong("covariance added", "A measurement brings information: K_b Z K_b' is subtracted.",
       Pb=lambda P, H, R, b, Z, K: P[b, b] + K @ Z @ K.T)
_wrong("R in the covariance", "P_bb falls by K_b Z K_b' with Z = H P H' + R, not by K_b R K_b'.",
       Pb=lambda P, H, R, b, Z, K: P[b, b] - K @ R @ K.T)
_wrong("H P H' in the covariance", "P_bb falls by K_b Z K_b' with the whole Z = H P H' + R.",
       Pb=lambda P, H, R, b, Z, K: P[b, b] - K @ (Z - R) @ K.T)
_wrong("the loss itself", "K_b Z K_b' is what B loses: return what is left, P[b, b] - K_b Z K_b'.",
       Pb=lambda P, H, R, b, Z, K: K @ Z @ K.T)
_wrong("the whole covariance", "P_bb is the 2 x 2 block of landmark B: return P_new[b, b].",
       Pb=lambda P, H, R, b, Z, K: P - P @ H.T @ inv(Z) @ H @ P)
# fmt: on


@effect.wrong("covariances with B left out", "P H' needs the whole rows of B, with its covariances: P[b] @ H.T.")
def _(P, H, R, b):
    D = np.zeros_like(P)
    D[:3, :3], D[3:, 3:] = P[:3, :3], P[3:, 3:]
    return effect_on(D, H, R, b)


@effect.variant("correct the whole state in the Joseph form, then cut out B")
def _(P, H, R, b):
    K = np.linalg.solve(H @ P @ H.T + R, H @ P).T
    A = np.eye(len(P)) - K @ H
    return K[b], (A @ P @ A.T + K @ R @ K.T)[b, b]


@effect.variant("by adding information")
def _(P, H, R, b):
    W = inv(R)
    new = inv(inv(P) + H.T @ W @ H)
    return (new @ H.T @ W)[b], new[b, b]


@effect.variant("the conditional Gaussian of B given the measurement, lists")
def _(P, H, R, b):
    n = len(P)
    J = np.vstack([np.eye(n)[b], H])
    S = J @ P @ J.T
    S[2:, 2:] += R
    K = S[:2, 2:] @ inv(S[2:, 2:])
    return K.tolist(), (S[:2, :2] - K @ S[2:, :2]).tolist()
