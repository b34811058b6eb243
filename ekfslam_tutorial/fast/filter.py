"""The extended Kalman filter on a stochastic map, in eight short functions.

A *block* is a pair `(range, Jacobian)`: the derivative of something by the state in that range. A range of `None` means
that the state is known; its block drops out. So the same `correct` does

* mapping with known poses, where the robot is known (the lecture),
* localisation, where the landmarks are known,
* SLAM, where nothing is known,
* self-calibration, where the sensor's own frame is in the map as well.

Names: z innovation, Z its covariance, E covariance of the expectation, R of the measurement, U of the control
(manual, figs. 4 and 9). Only the blocks are multiplied: H is never written out.

The same functions take a *stack* of K observations at once, for one joint correction. A Jacobian then has the shape
(K, m, k), and its range is a slice (the state that all K depend on: the robot) or an array of int, shape (K, k) (the
states that each has of its own: its landmark). H has K m rows then.
"""

from dataclasses import dataclass
from functools import reduce
from math import isfinite
from operator import add

import numpy as np
from scipy.linalg.lapack import dpotrf, dtrtri  # pyright: ignore[reportAttributeAccessIssue]

from .core import real, real_blocks
from .extra import compiled
from .lazy import lazy
from .storage import symmetric


@dataclass(frozen=True)
class Innovation:
    """Innovation z = y - e with its covariance Z.

    Parameters
    ----------
    z : ndarray, shape (m,)
    Z : ndarray, shape (m, m)

    Raises
    ------
    ValueError
        When used, if z is not finite or Z not positive definite.
    """

    z: np.ndarray
    Z: np.ndarray

    @lazy
    def iL(self):
        """Inverse of the Cholesky factor: Z = L L', Z^-1 = iL' iL."""
        if not np.isfinite(self.z).all():
            raise ValueError(f"the innovation must be finite, got {np.asarray(self.z).tolist()}")
        L, info = dpotrf(self.Z, lower=1, clean=1)
        if info != 0 or not isfinite(L[-1, -1]):
            raise ValueError(f"the innovation covariance must be positive definite, got {np.asarray(self.Z).tolist()}")
        return dtrtri(L, lower=1)[0]

    @lazy
    def w(self):
        """Whitened innovation L^-1 z: of unit covariance, if all is well."""
        return self.iL.dot(self.z)

    @property
    def md2(self):
        """Squared Mahalanobis distance z' Z^-1 z: chi-square with m degrees of freedom, if all is well."""
        return float(self.w.dot(self.w))


def floats(*arrays):
    """Return True if these are plain arrays of floats; what is not is looked at more closely."""
    return all(type(a) is np.ndarray and a.dtype.char == "d" for a in arrays)


def predict(map, r, x, X_x, X_u, U):
    """Motion of the state in range r: its own covariance, and its covariance with everything else.

        P_rr = X_x P_rr X_x' + X_u U X_u',    P_rm = X_x P_rm

    All other states stand still, so their blocks of P do not change.

    Parameters
    ----------
    map : FastMap or CompressedMap
    r : slice
    x : ndarray, shape (k,)
        State after the motion.
    X_x, X_u : ndarray, shape (k, k) and (k, nu)
        Jacobians of the motion, taken at the state *before* the motion.
    U : ndarray, shape (nu, nu)
        Covariance of the control. It is not tested for being one; `move` of `slam` does that.

    Raises
    ------
    ValueError
        If the range is not in the map, for shapes that do not fit, or if the result is not finite. Nothing has been
        changed then.
    """
    plain = floats(x, X_x, X_u, U)
    if map.compiled and plain and compiled().predict(map, r, x, X_x, X_u, U):
        return
    if not plain:
        x, X_x, X_u, U = real("x", x), real("X_x", X_x), real("X_u", X_u), real("U", U)
    k, nu = r.stop - r.start, len(U)
    if not 0 <= r.start < r.stop <= map.n:
        raise ValueError(f"range {r.start}:{r.stop} is not in this map of {map.n} states")
    if x.shape != (k,) or X_x.shape != (k, k) or X_u.shape != (k, nu) or U.shape != (nu, nu):
        shapes = ", ".join(str(np.shape(a)) for a in (x, X_x, X_u, U))
        raise ValueError(f"x, X_x, X_u, U must have shapes ({k},), ({k}, {k}), ({k}, nu), (nu, nu), got {shapes}")
    P_rm = X_x.dot(map.rows(r))
    P_rr = P_rm[:, map.spot(r)].dot(X_x.T) + X_u.dot(U).dot(X_u.T)
    if not isfinite(sum(x.tolist() + P_rr.diagonal().tolist())):  # a NaN in U, X_x or X_u reaches the diagonal
        raise ValueError(f"a state that moves must stay finite, got {x} with the covariance {P_rr.tolist()}")
    map.replace(r, x, P_rm, P_rr)


def cross(map, blocks):
    """Cross-covariance of the whole map with something that depends on the blocks: P H'.

    Parameters
    ----------
    map : FastMap or CompressedMap
    blocks : sequence of (slice or None, ndarray of shape (m, k))
        At least one; those of known states have the range None. Or a stack, see above.

    Returns
    -------
    ndarray, shape (n, m), or (n, K m)
    """
    HP = [_times(J, P_rm) for J, P_rm in map.fetch(blocks)]
    return map.columns(reduce(add, HP), blocks)


def covariance(PHt, blocks):
    """Covariance of something that depends on the blocks: H P H', shape (m, m), or (K m, K m) for a stack.

    Parameters
    ----------
    PHt : ndarray, shape (n, m)
        From `cross`.
    blocks : sequence of (slice or None, ndarray of shape (m, k))
    """
    HPHt = [_times(J, PHt[r]) for r, J in blocks if r is not None]
    return reduce(add, HPHt) if HPHt else np.zeros((PHt.shape[1], PHt.shape[1]))


def _times(J, rows):
    """J times rows of a matrix, shape (m, n). For a stack: all K products one below the other, shape (K m, n)."""
    if J.ndim == 2:
        return J.dot(rows)
    if rows.ndim == 2:
        return J.reshape(-1, J.shape[-1]).dot(rows)
    return (J @ rows).reshape(-1, rows.shape[-1])


def innovation(z, E, R):
    """Innovation of a measurement: z with the covariance Z = E + R.

    Parameters
    ----------
    z : ndarray, shape (m,), or (K, m) for a stack
        Measurement minus expectation, angles wrapped.
    E : ndarray, shape (m, m), or (K m, K m)
        Covariance of the expectation, H P H'.
    R : ndarray, shape (m, m), or (K, m, m)
        Covariance of the measurement noise; of a stack, each has the same or its own, independent of the others. It is
        not tested for being one: `correct_known_lmks` of `slam` does that.

    Raises
    ------
    ValueError
        If R has another shape.
    """
    z, R = np.asarray(z), np.asarray(R)
    shape = E.shape if z.ndim == 1 else (*z.shape, z.shape[-1])
    if R.shape != shape and (z.ndim == 1 or R.shape != shape[1:]):
        raise ValueError(f"R must have shape {shape}{f' or {shape[1:]}' if z.ndim > 1 else ''}, got {R.shape}")
    if z.ndim == 1:
        return Innovation(z, E + R)
    Z = E.copy()
    blocks = np.einsum("kikj->kij", Z.reshape(*z.shape, *z.shape))  # a view: the K blocks on the diagonal
    blocks += R
    return Innovation(z.ravel(), Z)


def correct(map, PHt, inn):
    """Correction of the whole map by one innovation.

        K = P H' Z^-1,    x = x + K z,    P = P - K H P

    With Z = L L' and W = P H' L^-T the last line is P - W W': half the work, and symmetric by construction, but for the
    last digit on some processors, whose BLAS rounds [i, j] and [j, i] differently.

    Parameters
    ----------
    map : FastMap or CompressedMap
    PHt : ndarray, shape (n, m)
        From `cross`.
    inn : Innovation

    Raises
    ------
    ValueError
        If the innovation is not finite, or its covariance not positive definite. Nothing has been changed then.
    """
    Wt = inn.iL.dot(PHt.T)
    map.shift(inn.w.dot(Wt))
    map.subtract(Wt)


def update(map, blocks, z, R):
    """Correction of the whole map by one measurement, or a stack of them: `cross` to `correct` in one call.

        E = H P H',    Z = E + R,    K = P H' Z^-1,    x = x + K z,    P = P - K H P

    Parameters
    ----------
    map : FastMap or CompressedMap
    blocks : sequence of (slice or None, ndarray of shape (m, k)), or a stack
        Derivatives of the expectation, as in `cross`.
    z, R : ndarray
        Innovations and covariance of the measurement noise, as in `innovation`.

    Raises
    ------
    ValueError
        As `innovation` and `correct`. Nothing has been changed then.
    """
    plain = floats(z, R, *(J for _, J in blocks))
    if map.compiled and plain and compiled().update(map, blocks, z, R):
        return
    if not plain:
        z, R, blocks = real("z", z), real("R", R), real_blocks(blocks)
    PHt = cross(map, blocks)
    correct(map, PHt, innovation(z, covariance(PHt, blocks), R))


def augment(map, l, blocks, Q):
    """A new state l = g(x, noise), correlated with those it depends on.

        P_lm = L_x P,    P_ll = L_x P L_x' + Q

    With known poses all ranges are None, and this is the lecture's formula: zero cross-covariance, and P_ll = Q.

    Parameters
    ----------
    map : FastMap or CompressedMap
    l : ndarray, shape (k,)
        Mean of the new state.
    blocks : sequence of (slice or None, ndarray of shape (k, ·))
        Derivatives of g by the states in the map.
    Q : ndarray, shape (k, k)
        Covariance of all that is not in the map: L_y R L_y' of the measurement, and L_n N L_n' of the prior. It is not
        tested for being one.

    Returns
    -------
    slice
        Range of the new state.

    Raises
    ------
    MapFull
        If it does not fit. Nothing has been changed then.
    ValueError
        For shapes that do not fit each other, or numbers that are not finite.
    """
    if not floats(*(J for _, J in blocks)):
        blocks = real_blocks(blocks)
    PLt = cross(map, blocks)
    P_ll = covariance(PLt, blocks)
    if not floats(l, Q, P_ll):
        l, Q, P_ll = real("l", l), real("Q", Q), real("L_x P L_x'", P_ll)
    shape = l.shape * 2
    if not P_ll.shape == Q.shape == shape:
        raise ValueError(
            f"a new state of shape {l.shape} needs L_x P L_x' and Q of {shape}, got {P_ll.shape}, {Q.shape}"
        )
    P_ll = P_ll + Q
    if not isfinite(P_ll.sum()) or not isfinite(l.sum()):
        raise ValueError(f"a new state must be finite, got {l} with the covariance {P_ll.tolist()}")
    return map.insert(l, symmetric(P_ll), PLt.T)


def transform(map, r, x, J):
    """Replace the state in range r by a function of itself: its covariances follow by the Jacobian J.

    Normalising a quaternion and turning an inverse-depth point into a Euclidean one are both this.

    Parameters
    ----------
    map : FastMap or CompressedMap
    r : slice
        Range of the old state, of length k.
    x : ndarray, shape (k2,), k2 <= k
        New state.
    J : ndarray, shape (k2, k)
        Derivative of the new state by the old one.

    Returns
    -------
    slice
        Range of the new state: the head of r. The rest of r is free again.
    """
    P_rm = J @ map.rows(r)
    P_rr = P_rm[:, map.spot(r)] @ J.T

    head, tail = slice(r.start, r.start + len(x)), slice(r.start + len(x), r.stop)
    map.replace(head, x, P_rm, P_rr)
    if tail.start < tail.stop:
        map.notes.changes += 1
        map.vacate(tail)
    return head
