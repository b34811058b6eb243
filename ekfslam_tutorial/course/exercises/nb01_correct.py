"""Exercise 01.4: the correction."""

import numpy as np

from ..table import table


def correct(x, P, z, H, R):
    """Correct a state with an innovation.

    x, shape (n,), and P, shape (n, n): state and covariance; here the pose, but write it for any n.
    z, shape (m,): innovation, H, shape (m, n): Jacobian of the expected measurement, R, shape (m, m): noise covariance
    of the measurement.
    Return the new x and P. Do not change the inputs.
    """
    Z = H @ P @ H.T + R
    K = P @ H.T @ np.linalg.inv(Z)
    return x + K @ z, P - K @ Z @ K.T


def covariance(rng, n, scale):
    """Return a covariance of no special form."""
    A = rng.normal(size=(n, n))
    return scale * (A @ A.T / n + 0.3 * np.eye(n))


def some(rng, n=3, m=2, p=0.3, r=0.2, z=0.2):
    """Return the arguments of a correction: n states, metres but for the heading, and m numbers measured."""
    H, x = rng.normal(size=(m, n)), rng.uniform(-2, 2, n) * np.where(np.arange(n) == 2, 1, 6)
    return x, covariance(rng, n, p), rng.normal(size=m) * z, H, covariance(rng, m, r)


SIZES = ((3, 2), (3, 1), (5, 2), (3, 4), (1, 1), (2, 3))


def sizes(rng):
    """Return states and measurements of many sizes, before and after good and bad measurements."""
    return [some(rng, n, m, p, r) for n, m in SIZES for p, r in ((0.3, 0.2), (1e-3, 1.0), (2.0, 0.01))]


def one_after_the_other(rng):
    """Return ten corrections with the same sensor, each with the covariance that the one before has left."""
    x, P, z, H, R = some(rng)
    calls = []
    for _ in range(10):
        calls.append((x, P, z, H, R))
        P = correct(x, P, z, H, R)[1]
    return calls


correction = table(
    "01.4 The correction",
    correct,
    hints=(
        "Three steps: the covariance Z of the innovation, the gain K, then the new x and P.",
        "Z = H P H' + R. K = P H' inv(Z), with @ for all products.",
        "x + K z, and P - K H P, which is the same as (I - K H) P and as P - K Z K'.",
    ),
    returns="x, P",
    cases={
        "any": lambda rng: [some(rng, n, m) for n, m in ((3, 2), (5, 2), (3, 1), (2, 2))],
        "no surprise": lambda rng: [some(rng, z=0.0)],
        "sizes": sizes,
        "surprises": lambda rng: [some(np.random.default_rng(1), z=z) for z in (0.2, -4.0, 100.0)],
        "often": one_after_the_other,
    },
    checks="""
    no surprise, no change   | x | no surprise | If z = 0, x stays as it is.
    the mean                 | x | sizes       | x + K z with K = P H' inv(H P H' + R).
    the covariance           | P | sizes       | P - K H P, a covariance: what was measured is known better.
    P does not depend on z   | P | surprises   | How sure the filter is does not depend on what was measured.
    P shrinks                | P | often       | Ten corrections, one after the other. P stays symmetric, and the uncertainty grows in no direction.
    """,
    wrong="""
    Z without R | H @ P @ H.T + R -> H @ P @ H.T | The measurement has noise, too: Z = H P H' + R.
    R for Z | np.linalg.inv(Z) -> np.linalg.inv(R) | The gain divides by the whole uncertainty of the innovation, Z = H P H' + R, not by R alone.
        P - K @ Z @ K.T -> P - K @ H @ P
    R subtracted | H @ P @ H.T + R -> H @ P @ H.T - R | Noise adds up: Z = H P H' *plus* R.
    Z not inverted | np.linalg.inv(Z) -> Z | K = P H' inv(Z): a large uncertainty of the innovation makes a small gain.
    inverse entry by entry | np.linalg.inv(Z) -> (1 / Z) | inv(Z) is the inverse of a matrix, not 1 / Z for each entry.
    R squared | H.T + R -> H.T + R @ R | R holds variances already: do not square it.
    square root of R | H.T + R -> H.T + np.sqrt(np.abs(R)) | R holds variances, and Z = H P H' + R needs variances: no square root.
    only the diagonal of R | H.T + R -> H.T + np.diag(np.diag(R)) | Use the whole R: the noise of range and bearing may be correlated.
    only the diagonal of P | Z = -> P = np.diag(np.diag(P)); Z = | Use the whole P: position and heading are correlated.
    P forgotten in the gain | K = P @ H.T -> K = H.T | K = P H' inv(Z): the gain begins with P.
    P forgotten in Z | Z = H @ P @ H.T -> Z = H @ H.T | The state is uncertain, too: Z = H P H' + R, with P in the middle.
    minus K z | x + K @ z -> x - K @ z | z is measured minus expected: x *plus* K z moves towards the measurement.
    x unchanged | x + K @ z -> x.copy() | The innovation moves the state: x + K z.
    K z only | x + K @ z -> K @ z | K z is the *change* of the state: x + K z.
    P unchanged | P - K @ Z @ K.T -> P.copy() | The measurement brings information: P - K H P.
    covariance added | P - K @ Z -> P + K @ Z | The measurement brings information: P *minus* K H P.
    R missing in K Z K' | K @ Z @ K.T -> K @ (Z - R) @ K.T | That is P - K (H P H') K': R is missing. P - K Z K' has the whole Z = H P H' + R, and P - K H P has one K only.
    K z added twice | x + K @ z -> x + 2 * K @ z | Add K z once.
    gain of the new P | x + K @ z -> x + (P - K @ Z @ K.T) @ H.T @ np.linalg.inv(Z) @ z | K = P H' inv(Z) has the P before the correction, for x as for P. Yours takes the new P for x.
    K R K' subtracted | K @ Z @ K.T -> K @ R @ K.T | P - K Z K' has the whole Z = H P H' + R in it.
    K Z subtracted | K @ Z @ K.T -> K @ K.T | P - K Z K': Z = H P H' + R stands between the two gains.
    half of Joseph's form | P - K @ Z @ K.T -> (np.eye(len(P)) - K @ H) @ P @ (np.eye(len(P)) - K @ H).T | (I - K H) stands twice in your P. Once is right: (I - K H) P. With it on both sides, as in Joseph's form, a second term belongs there: + K R K'.
    P (I - K H) | P - K @ Z @ K.T -> P @ (np.eye(len(P)) - K @ H) | The order matters: (I - K H) P. Yours is not symmetric.
    K H transposed | P - K @ Z @ K.T -> P - (K @ H).T @ P | K H P, in this order and not transposed: yours is P - (K H)' P.
    P - K H | P - K @ Z @ K.T -> P - K @ H | The last P is missing: P - K H P.
    I - K H | P - K @ Z @ K.T -> np.eye(len(P)) - K @ H | I - K H is only the factor: multiply it by P.
    only the diagonal of the new P | P - K @ Z @ K.T -> np.diag(np.diag(P - K @ Z @ K.T)) | Keep the whole new P: after a measurement, position and heading are correlated.
    H x subtracted again | x + K @ z -> x + K @ (z - H @ x) | z is the innovation already, measured minus expected: do not subtract H x from it.
    column instead of vector | return x + K @ z, -> return (x + K @ z)[:, None], | Vectors have one axis here: x has shape (n,), no columns.
    sizes of the pose only | P - K @ Z @ K.T -> (np.eye(3) - K @ H) @ P | Write np.eye(len(x)), not np.eye(3): the state may have any size.
    whole state wrapped | x + K @ z, -> (x + K @ z + np.pi) % (2 * np.pi) - np.pi, | x and y are lengths, not angles: a state is not wrapped as a whole.
    gain and Z of the new P | x + K @ z -> x + (Q := P - K @ Z @ K.T) @ H.T @ np.linalg.inv(H @ Q @ H.T + R) @ z | K = P H' inv(Z), with Z = H P H' + R, has the P before the correction, for x as for P. Yours takes the new P for x.
    1 for the identity | P - K @ Z @ K.T -> (1 - K @ H) @ P | 1 - K H takes K H from a matrix full of ones. Where the state has several numbers the 1 is the identity, np.eye(n).
    """,
    forms="""
    P - K H P | P - K @ Z @ K.T -> P - K @ H @ P | P - K H P
    Joseph | P - K @ Z @ K.T -> (np.eye(len(P)) - K @ H) @ P @ (np.eye(len(P)) - K @ H).T + K @ R @ K.T | of Joseph
    """,
)
