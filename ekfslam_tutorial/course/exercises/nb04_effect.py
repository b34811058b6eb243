"""Exercise 04.4: what the sight of one landmark does to another one."""

import numpy as np

from ...geometry import Frame2
from ...models.landmarks import EucPnt
from ...models.observation import observe
from ...models.sensors import RangeBearing
from ..table import table
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


def some(rng, n=9, b=slice(7, 9), scale=1.0, m=2):
    """Robot, landmark A in the range 3:5, other landmarks; a measurement of A, of m numbers."""
    x = rng.uniform(-4, 4, n)
    x[3:5] = x[:2] + rng.uniform(2, 4, 2)
    _, E_r, _, E_l = observe(Frame2(x[:3]), Frame2(np.zeros(3)), RangeBearing(1, 1), EucPnt(2), x[3:5])
    H = np.zeros((2, n))
    H[:, :3], H[:, 3:5] = E_r, E_l
    return random_covariance(rng, n, scale), H[:m], random_covariance(rng, m, 0.05 * scale), b


def nothing_shared(rng):
    """Return a landmark B whose error has nothing to do with those of robot and A."""
    P, *others = some(rng)
    P[7:, :7], P[:7, 7:] = 0, 0
    return P, *others


SIZES = ((9, slice(7, 9)), (7, slice(5, 7)), (13, slice(9, 11)))

effect = table(
    "04.4 Seeing landmark A changes landmark B",
    effect_on,
    hints=(
        "Correct the whole state on paper: K = P H' inv(Z), x + K z, P - K Z K'. Landmark B owns some rows of K.",
        "The rows of P H' that belong to B are (P @ H.T)[b] = P[b] @ H.T: not zero, although H is zero in B's columns.",
        "Z = H P H' + R, K_b = P[b] H' inv(Z), P_bb = P[b, b] - K_b Z K_b'.",
    ),
    returns="K_b, P_bb",
    symbols="H_b = the columns of H of landmark B; P_new = P afterwards",
    cases={
        "any": lambda rng: [*(some(rng, n, b) for n, b in SIZES), some(rng, m=1)],
        "nothing shared": lambda rng: [nothing_shared(rng)],
        "scales": lambda rng: [some(rng, n, b, scale) for (n, b), scale in zip(SIZES, (1.0, 1.0, 1e-3), strict=True)],
        "one number": lambda rng: [some(rng, m=1)],
    },
    checks="""
    shapes                      | K_b[:0], P_bb[:0] | any      | K_b is 2 x m: the 2 rows of landmark B, one column for each number of the measurement. P_bb is 2 x 2: landmark B with itself.
    B shares nothing            | K_b, P_bb | nothing shared   | If B has no covariance with robot and A, its gain is zero and it stays as it is.
    the gain of B               | K_b       | scales           | K = P H' inv(H P H' + R) for the whole state; K_b are the rows of B.
    the covariance of B         | P_bb      | scales           | P - K Z K' for the whole state; B's block of it is P[b, b] - K_b Z K_b'.
    a measurement of one number | K_b, P_bb | one number       | Nothing here needs two numbers: a range alone, with m = 1, works, too.
    a covariance that shrinks   | P_bb      | any              | What was P_bb before, minus what it is now, has no negative eigenvalue.
    """,
    wrong="""
    B is not in view, so it stays: A and B were seen by the same uncertain robot: they share errors, and what corrects A corrects B. H is zero in B's own columns, so take B's whole rows of P: P[b] @ H.T.
        PHt[b] @ np.linalg.inv(Z) -> np.zeros((2, len(R)))
    (I - K H) with B's block only | P[b, b] - K_b @ Z @ K_b.T -> P[b, b] | Your P_bb is that of before. What is wanted is the block [b, b] of the whole new covariance, P - K H P: P_bb - K_b H P[:, b]. The columns of B in H are zero, and still B changes: H P[:, b] is not zero.
    Z without R | H @ PHt + R -> H @ PHt | Z is the covariance of z = y - e: the measurement has noise, too. Z = H P H' + R.
    R for Z | np.linalg.inv(Z) -> np.linalg.inv(R) | The gain divides by the whole uncertainty of the innovation, Z = H P H' + R, not by R alone.
    only the diagonal of R | H @ PHt + R -> H @ PHt + np.diag(np.diag(R)) | Use the whole R: the noise of range and bearing may be correlated.
    R squared | H @ PHt + R -> H @ PHt + R @ R | R holds variances already: do not square it.
    Z not inverted | np.linalg.inv(Z) -> Z | K = P H' inv(Z): a large uncertainty of the innovation makes a small gain.
    inverse entry by entry | np.linalg.inv(Z) -> (1 / Z) | inv(Z) is the inverse of a matrix, not 1 / Z for each entry.
    sign of the gain | K_b = PHt[b] -> K_b = -PHt[b] | With z = y - e the gain is + P H' inv(Z).
    the whole gain | return K_b, -> return PHt @ np.linalg.inv(Z), | K has a row for each number of the state: return only those of landmark B, K[b].
    gain transposed | return K_b, -> return K_b.T, | K_b has 2 rows (landmark B) and m columns (the measurement): yours is transposed.
    covariance added | P[b, b] - K_b @ Z @ K_b.T -> P[b, b] + K_b @ Z @ K_b.T | A measurement brings information: K_b Z K_b' is subtracted.
    R in the covariance | K_b @ Z @ K_b.T -> K_b @ R @ K_b.T | P_bb falls by K_b Z K_b' with Z = H P H' + R, not by K_b R K_b'.
    H P H' in the covariance | K_b @ Z @ K_b.T -> K_b @ (Z - R) @ K_b.T | P_bb falls by K_b Z K_b' with the whole Z = H P H' + R.
    Z missing in the covariance | K_b @ Z @ K_b.T -> K_b @ K_b.T | P_bb falls by K_b Z K_b': Z stands between the two gains.
    the loss itself | P[b, b] - K_b @ Z @ K_b.T -> K_b @ Z @ K_b.T | K_b Z K_b' is what B loses: return what is left, P[b, b] - K_b Z K_b'.
    the whole covariance | return K_b, P_bb -> return K_b, P - PHt @ np.linalg.inv(Z) @ PHt.T | P_bb is the 2 x 2 block of landmark B: return P_new[b, b].
    covariances with B left out | PHt = P @ H.T -> P = P.copy(); P[:3, 3:], P[3:, :3] = 0, 0; PHt = P @ H.T | P H' needs the whole rows of B, with its covariances: P[b] @ H.T.
    Z with the robot's block only | Z = H @ PHt + R -> Z = H[:, :3] @ P[:3, :3] @ H[:, :3].T + R | Landmark A is uncertain as well, and shares errors with the robot: Z = H P H' + R with the whole P.
    Z without the covariances | Z = H @ PHt + R -> Z = H @ (P * np.eye(len(P))) @ H.T + R | Robot and landmark share errors: Z = H P H' + R with the whole P, not with its diagonal.
    the robot's part of the gain only | K_b = PHt[b] @ -> K_b = P[b, :3] @ H[:, :3].T @ | B is correlated with the landmark that is seen, too, not with the robot alone: the whole rows of P, P[b] @ H.T.
    half of Joseph's form | P[b, b] - K_b @ Z @ K_b.T -> ((A := np.eye(len(P)) - PHt @ np.linalg.inv(Z) @ H) @ P @ A.T)[b, b] | (I - K H) stands twice in your P. Once is right: (I - K H) P. With it on both sides, as in Joseph's form, a second term belongs there: + K R K'.
    """,
    forms="""
    rows of K H P | P[b, b] - K_b @ Z @ K_b.T -> P[b, b] - K_b @ PHt[b].T | P - K H P
    """,
)
