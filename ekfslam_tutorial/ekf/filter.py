"""The extended Kalman filter on a stochastic map, in a few short functions.

A *block* is a pair `(range, Jacobian)`: the derivative of something by the state in that range. A range of `None` means
that the state is known; its block drops out. So the same `correct` does

* mapping with known poses, where the robot is known (the lecture),
* localisation, where the landmarks are known,
* SLAM, where nothing is known,
* self-calibration, where the sensor's own frame is in the map as well.

H, the derivative by the whole map, has the Jacobians of the blocks at their ranges and zeros elsewhere. It is never
written out: only the blocks are multiplied.

Names: z innovation, Z its covariance, E covariance of the expectation, R of the measurement, U of the control
(manual, figs. 4 and 9).
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .covariances import real, real_blocks
from .stochastic_map import symmetric


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

    @cached_property
    def iL(self):
        """Inverse of the Cholesky factor: Z = L L', Z^-1 = iL' iL."""
        if not np.isfinite(self.z).all():
            raise ValueError(f"the innovation must be finite, got {np.asarray(self.z).tolist()}")
        try:
            L = np.linalg.cholesky(self.Z)
        except np.linalg.LinAlgError:
            L = np.array(np.nan)
        if not np.isfinite(L).all():
            raise ValueError(f"the innovation covariance must be positive definite, got {np.asarray(self.Z).tolist()}")
        return np.linalg.inv(L)

    @property
    def w(self):
        """Whitened innovation L^-1 z: of unit covariance, if all is well."""
        return self.iL @ self.z

    @property
    def md2(self):
        """Squared Mahalanobis distance z' Z^-1 z: chi-square with m degrees of freedom, if all is well."""
        return float(self.w @ self.w)


def predict(map, r, x, X_x, X_u, U):
    """Motion of the state in range r: its own covariance, and its covariance with everything else.

        P_rr = X_x P_rr X_x' + X_u U X_u',    P_rm = X_x P_rm

    All other states stand still, so their blocks of P do not change.

    Parameters
    ----------
    map : Map
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
    x, X_x, X_u, U = real("x", x), real("X_x", X_x), real("X_u", X_u), real("U", U)
    _check_motion(map, r, x, X_x, X_u, U)
    P_rm = X_x @ map.P[r]
    P_rr = P_rm[:, r] @ X_x.T + X_u @ U @ X_u.T
    if not (np.isfinite(x).all() and np.isfinite(P_rr).all()):
        raise ValueError(f"a state that moves must stay finite, got {x} with the covariance {P_rr.tolist()}")
    map.put(r, x, P_rm, P_rr)


def _check_motion(map, r, x, X_x, X_u, U):
    k, nu = r.stop - r.start, len(U)
    if not 0 <= r.start < r.stop <= map.n:
        raise ValueError(f"range {r.start}:{r.stop} is not in this map of {map.n} states")
    shapes = x.shape, X_x.shape, X_u.shape, U.shape
    if shapes != ((k,), (k, k), (k, nu), (nu, nu)):
        got = ", ".join(str(shape) for shape in shapes)
        raise ValueError(f"x, X_x, X_u, U must have shapes ({k},), ({k}, {k}), ({k}, nu), (nu, nu), got {got}")


def cross(map, blocks):
    """Cross-covariance of the whole map with something that depends on the blocks: P H'.

    Parameters
    ----------
    map : Map
    blocks : sequence of (slice or None, ndarray of shape (m, k))
        At least one; those of known states have the range None.

    Returns
    -------
    ndarray, shape (n, m)
    """
    return sum((map.P[:, r] @ J.T for r, J in blocks if r is not None), np.zeros((len(map.x), len(blocks[0][1]))))


def covariance(PHt, blocks):
    """Covariance of something that depends on the blocks: H P H', shape (m, m).

    Parameters
    ----------
    PHt : ndarray, shape (n, m)
        From `cross`. That of another thing, with blocks of its own, gives the covariance between the two.
    blocks : sequence of (slice or None, ndarray of shape (m, k))
    """
    return sum((J @ PHt[r] for r, J in blocks if r is not None), np.zeros((len(blocks[0][1]), PHt.shape[1])))


def innovation(z, E, R):
    """Innovation of a measurement: z with the covariance Z = E + R.

    Parameters
    ----------
    z : ndarray, shape (m,)
        Measurement minus expectation, angles wrapped.
    E : ndarray, shape (m, m)
        Covariance of the expectation, H P H'.
    R : ndarray, shape (m, m)
        Covariance of the measurement noise. It is not tested for being one; `correct_known_lmks` of `slam` does that.

    Raises
    ------
    ValueError
        If R has another shape.
    """
    if np.shape(R) != E.shape:
        raise ValueError(f"R must have shape {E.shape}, got {np.shape(R)}")
    return Innovation(np.asarray(z), E + R)


def correct(map, PHt, inn):
    """Correction of the whole map by one innovation.

        K = P H' Z^-1,    x = x + K z,    P = P - K H P

    With Z = L L' and W = P H' L^-T these are x + W L^-1 z and P - W W': symmetric by construction.

    Parameters
    ----------
    map : Map
    PHt : ndarray, shape (n, m)
        From `cross`.
    inn : Innovation

    Raises
    ------
    ValueError
        If the innovation is not finite, or its covariance not positive definite. Nothing has been changed then.
    """
    W = PHt @ inn.iL.T
    map.x[:] += W @ inn.w
    map.P[:] -= W @ W.T


def carry(map, r, B, B2):
    """Carry the covariance along, from the estimate before a correction to that after it.

        P = T P T',    T = I + (B2 - B) E,    E B_r = I

    B = dx/dg says how the whole state changes if the world is moved by a little g, and E reads g from the state in
    range r: g = E x_r. So T B = B2: what is known of moving the world stays what it was. A correction alone does not
    see to that, because B is another one at the new estimate. (`slam.gauge` has B, and says why it matters.)

    Parameters
    ----------
    map : Map
    r : slice
        Of a state that moves with the world in all ways: the pose of a robot.
    B, B2 : ndarray, shape (n, k)
        At the estimate before the correction, and at that after it.
    """
    Q, R = np.linalg.qr(B[r])  # E is the inverse of B_r by QR, shifts first: exact, however far from the origin
    D, E = B2 - B, np.linalg.solve(R, Q.T)
    TP = map.P + D @ (E @ map.P[r])
    map.P = symmetric(TP + (TP[:, r] @ E.T) @ D.T)


def update(map, blocks, z, R):
    """Correction of the whole map by one measurement: `cross` to `correct` in one call.

        E = H P H',    Z = E + R,    K = P H' Z^-1,    x = x + K z,    P = P - K H P

    Parameters
    ----------
    map : Map
    blocks : sequence of (slice or None, ndarray of shape (m, k))
        Derivatives of the expectation, as in `cross`.
    z, R : ndarray
        Innovation and covariance of the measurement noise, as in `innovation`.

    Raises
    ------
    ValueError
        As `innovation` and `correct`. Nothing has been changed then.
    """
    z, R, blocks = real("z", z), real("R", R), real_blocks(blocks)
    PHt = cross(map, blocks)
    correct(map, PHt, innovation(z, covariance(PHt, blocks), R))


def augment(map, l, blocks, Q):
    """A new state l = g(x, noise), correlated with those it depends on.

        P_lm = L_x P,    P_ll = L_x P L_x' + Q

    With known poses all ranges are None, and this is the lecture's formula: zero cross-covariance, and P_ll = Q.

    Parameters
    ----------
    map : Map
    l : ndarray, shape (k,)
        Mean of the new state.
    blocks : sequence of (slice or None, ndarray of shape (k, ·))
        Derivatives of g by the states in the map.
    Q : ndarray, shape (k, k)
        Covariance of all that is not in the map: L_y R L_y' of the measurement, and L_n N L_n' of the prior.

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
    l, Q, blocks = real("l", l), real("Q", Q), real_blocks(blocks)
    PLt = cross(map, blocks)
    P_ll, shape = covariance(PLt, blocks), np.shape(l) * 2
    if not P_ll.shape == np.shape(Q) == shape:
        raise ValueError(
            f"a new state of shape {np.shape(l)} needs L_x P L_x' and Q of {shape}, got {P_ll.shape}, {np.shape(Q)}"
        )
    P_ll = P_ll + Q
    if not (np.isfinite(P_ll).all() and np.isfinite(l).all()):
        raise ValueError(f"a new state must be finite, got {l} with the covariance {P_ll.tolist()}")
    return map.add(l, P_ll, PLt.T)


def transform(map, r, x, J):
    """Replace the state in range r by a function of itself: its covariances follow by the Jacobian J.

        P_rm = J P_rm,    P_rr = J P_rr J'

    Normalising a quaternion and turning an inverse-depth point into a Euclidean one are both this.

    Parameters
    ----------
    map : Map
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
    P_rm = J @ map.P[r]
    return map.put(r, x, P_rm, P_rm[:, r] @ J.T)
