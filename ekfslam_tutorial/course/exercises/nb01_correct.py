"""Exercise 01.4: the correction."""

import numpy as np

from .. import expect
from ..exercise import Exercise


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


correction = Exercise(
    "01.4",
    "The correction",
    correct,
    hints=(
        "Three steps: the covariance Z of the innovation, the gain K, then the new x and P.",
        "Z = H P H' + R. K = P H' inv(Z), with @ for all products.",
        "x + K z, and P - K H P, which is the same as (I - K H) P and as P - K Z K'.",
    ),
)


def _covariance(rng, n, scale):
    """A covariance of no special form."""
    A = rng.normal(size=(n, n))
    return scale * (A @ A.T / n + 0.3 * np.eye(n))


def _case(rng, n=3, m=2, p=0.3, r=0.2):
    return (
        rng.uniform(-2, 2, n),
        _covariance(rng, n, p),
        rng.normal(size=m) * 0.2,
        rng.normal(size=(m, n)),
        _covariance(rng, m, r),
    )


def _both(f, x, P, z, H, R):
    new, C = expect.results(f(x, P, z, H, R), "x", "P")
    return expect.array(new, len(x), "x"), expect.array(C, P.shape, "P")


def _by_information(x, P, z, H, R):
    """The corrected state by adding information: no gain in it."""
    W = np.linalg.solve(R, H)
    C = np.linalg.inv(np.linalg.inv(P) + H.T @ W)
    return x + C @ W.T @ z, C


SIZES = ((3, 2), (3, 1), (5, 2), (3, 4), (1, 1), (2, 3))


@correction.link("two results", "The function must end with `return x, P`.")
def _(f, rng):
    for n, m in SIZES:
        _both(f, *_case(rng, n, m))


@correction.link("no surprise, no change", "If z = 0, x stays as it is.", part=0)
def _(f, rng):
    x, P, z, H, R = _case(rng)
    expect.close(_both(f, x, P, 0 * z, H, R)[0], x, "x after z = 0")


@correction.link("the mean", "x + K z with K = P H' inv(H P H' + R).", part=0)
def _(f, rng):
    for n, m in SIZES:
        for p, r in ((0.3, 0.2), (1e-3, 1.0), (2.0, 0.01)):
            case = _case(rng, n, m, p, r)
            expect.close(_both(f, *case)[0], _by_information(*case)[0], f"x ({n} states, {m} measured)")


@correction.link("the covariance", "P - K H P: what was measured is known better.", part=1)
def _(f, rng):
    for n, m in SIZES:
        for p, r in ((0.3, 0.2), (1e-3, 1.0), (2.0, 0.01)):
            case = _case(rng, n, m, p, r)
            expect.close(_both(f, *case)[1], _by_information(*case)[1], f"P ({n} states, {m} measured)")


@correction.link("P does not depend on z", "How sure the filter is does not depend on what was measured.", part=1)
def _(f, rng):
    x, P, z, H, R = _case(rng)
    a = _both(f, x, P, z, H, R)[1]
    for k in (-20, 500):
        expect.close(_both(f, x, P, k * z, H, R)[1], a, "P after another innovation")


@correction.link("P shrinks", "P must stay symmetric, and lose uncertainty in every direction.", part=1)
def _(f, rng):
    x, P, z, H, R = _case(rng)
    for _ in range(10):
        new = _both(f, x, P, z, H, R)[1]
        expect.symmetric(new, "P", 1e-6)
        expect.psd(new, "P", 1e-7)
        expect.psd(P - new, "what P has lost", 1e-6)
        P = (new + new.T) / 2


# ---- wrong and right answers -----------------------------------------------------------------------------------------

inv, pinv = np.linalg.inv, np.linalg.pinv


def _wrong(name, hint, K=None, x_of=None, P_of=None):
    """A misconception in the gain, in the new mean or in the new covariance."""

    @correction.wrong(name, hint)
    def _(x, P, z, H, R):
        Z = H @ P @ H.T + R
        G = K(P, H, R, Z) if K else P @ H.T @ inv(Z)
        return x_of(x, G, z) if x_of else x + G @ z, P_of(P, G, H, R, Z) if P_of else (np.eye(len(x)) - G @ H) @ P


# fmt: off
_wrong("Z without R", "The measurement has noise, too: Z = H P H' + R.", lambda P, H, R, Z: P @ H.T @ pinv(Z - R))
_wrong("R for Z", "The gain divides by the whole uncertainty of the innovation, Z = H P H' + R, not by R alone.",
       lambda P, H, R, Z: P @ H.T @ inv(R))
_wrong("R subtracted", "Noise adds up: Z = H P H' *plus* R.", lambda P, H, R, Z: P @ H.T @ inv(Z - 2 * R))
_wrong("Z not inverted", "K = P H' inv(Z): a large uncertainty of the innovation makes a small gain.",
       lambda P, H, R, Z: P @ H.T @ Z)
_wrong("inverse entry by entry", "inv(Z) is the inverse of a matrix, not 1 / Z for each entry.",
       lambda P, H, R, Z: P @ H.T @ (1 / Z))
_wrong("R squared", "R holds variances already: do not square it.", lambda P, H, R, Z: P @ H.T @ inv(Z - R + R @ R))
_wrong("square root of R", "R holds variances, and Z = H P H' + R needs variances: no square root.",
       lambda P, H, R, Z: P @ H.T @ inv(Z - R + np.sqrt(np.abs(R))))
_wrong("only the diagonal of R", "Use the whole R: the noise of range and bearing may be correlated.",
       lambda P, H, R, Z: P @ H.T @ inv(Z - R + np.diag(np.diag(R))))
_wrong("only the diagonal of P", "Use the whole P: position and heading are correlated.",
       lambda P, H, R, Z: np.diag(np.diag(P)) @ H.T @ inv(H @ np.diag(np.diag(P)) @ H.T + R))
_wrong("P forgotten in the gain", "K = P H' inv(Z): the gain begins with P.", lambda P, H, R, Z: H.T @ inv(Z))
_wrong("minus K z", "z is measured minus expected: x *plus* K z moves towards the measurement.",
       x_of=lambda x, K, z: x - K @ z)
_wrong("x unchanged", "The innovation moves the state: x + K z.", x_of=lambda x, K, z: x.copy())
_wrong("K z only", "K z is the *change* of the state: x + K z.", x_of=lambda x, K, z: K @ z)
_wrong("P unchanged", "The measurement brings information: P - K H P.", P_of=lambda P, K, H, R, Z: P.copy())
_wrong("covariance added", "The measurement brings information: P *minus* K H P.",
       P_of=lambda P, K, H, R, Z: P + K @ H @ P)
_wrong("R missing in K Z K'", "That is P - K (H P H') K': R is missing. P - K Z K' has the whole Z = H P H' + R, and "
       "P - K H P has one K only.", P_of=lambda P, K, H, R, Z: P - K @ H @ P @ H.T @ K.T)
_wrong("K z added twice", "Add K z once.", x_of=lambda x, K, z: x + 2 * K @ z)
_wrong("K R K' subtracted", "P - K Z K' has the whole Z = H P H' + R in it.",
       P_of=lambda P, K, H, R, Z: P - K @ R @ K.T)
_wrong("half of Joseph's form", "Joseph's form has two terms: (I - K H) P (I - K H)' + K R K'.",
       P_of=lambda P, K, H, R, Z: (np.eye(len(P)) - K @ H) @ P @ (np.eye(len(P)) - K @ H).T)
_wrong("P (I - K H)", "The order matters: (I - K H) P. Yours is not symmetric.",
       P_of=lambda P, K, H, R, Z: P @ (np.eye(len(P)) - K @ H))
_wrong("I - K H", "I - K H is only the factor: multiply it by P.", P_of=lambda P, K, H, R, Z: np.eye(len(P)) - K @ H)
_wrong("only the diagonal of the new P", "Keep the whole new P: after a measurement, position and heading are "
       "correlated.", P_of=lambda P, K, H, R, Z: np.diag(np.diag(P - K @ Z @ K.T)))
# fmt: on


@correction.wrong(
    "H x subtracted again", "z is the innovation already, measured minus expected: do not subtract H x from it."
)
def _(x, P, z, H, R):
    return correct(x, P, z - H @ x, H, R)


@correction.wrong("column instead of vector", "Vectors have one axis here: x has shape (n,), no columns.")
def _(x, P, z, H, R):
    new, C = correct(x, P, z, H, R)
    return new[:, None], C


@correction.wrong("sizes of the pose only", "Write np.eye(len(x)), not np.eye(3): the state may have any size.")
def _(x, P, z, H, R):
    K = P @ H.T @ inv(H @ P @ H.T + R)
    return x + K @ z, (np.eye(3) - K @ H) @ P


@correction.variant("(I - K H) P, with solve, as lists")
def _(x, P, z, H, R):
    PHt = P @ H.T
    K = np.linalg.solve(H @ PHt + R, PHt.T).T
    return list(x + K @ z), ((np.eye(len(x)) - K @ H) @ P).tolist()


@correction.variant("Joseph's form")
def _(x, P, z, H, R):
    K = P @ H.T @ np.linalg.pinv(H @ P @ H.T + R)
    A = np.eye(len(x)) - K @ H
    return x + K.dot(z), A @ P @ A.T + K @ R @ K.T


@correction.variant("by adding information")
def _(x, P, z, H, R):
    return _by_information(np.asarray(x), P, z, H, R)
