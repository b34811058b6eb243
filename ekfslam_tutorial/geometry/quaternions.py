"""Rotations in 3D: quaternion `q`, matrix `R`, Euler angles `e`, rotation vector `v`, axis and angle `(a, u)`.

Conventions (Solà, "Quaternion kinematics for the error-state Kalman filter", arXiv:1711.02508, and the manual of the
EKF-SLAM toolbox): q = [a b c d], scalar first, Hamilton product, local to global, `p_global = R p_local`. Euler angles
are [roll, pitch, yaw] with R = Rz(yaw) Ry(pitch) Rx(roll). Angles are in radians.

All functions broadcast over leading axes and return `value, J_arg1, ...`. The quaternion is *not* assumed to have norm
one: R(q) is the homogeneous polynomial of degree two, so that its derivatives hold off the unit sphere as well, as an
EKF needs them. Jacobians of a matrix have the shape (3, 3, n).
"""

import numpy as np

# R(q) is quadratic in q, so its derivative is linear: R_q = T q, and by Euler's theorem on homogeneous
# functions R = R_q q / 2.  T[i, j, k, l] = d^2 R_ij / dq_k dq_l.
_HAT = np.zeros((3, 3, 3))  # hat(v) = _HAT v
_HAT[2, 1, 0] = _HAT[0, 2, 1] = _HAT[1, 0, 2] = 1
_HAT[1, 2, 0] = _HAT[2, 0, 1] = _HAT[0, 1, 2] = -1

_I3 = np.eye(3)
_T = np.zeros((3, 3, 4, 4))
_T[:, :, 0, 0] = 2 * _I3  # a^2 I
_T[:, :, 0, 1:] = 2 * _HAT  # 2 a hat(v)
_T[:, :, 1:, 0] = 2 * _HAT
_T[:, :, 1:, 1:] = 2 * (  # 2 v v' - v'v I
    np.einsum("ik,jl->ijkl", _I3, _I3) + np.einsum("il,jk->ijkl", _I3, _I3) - np.einsum("ij,kl->ijkl", _I3, _I3)
)

# Hamilton's product as a bilinear form: (q1 q2)_i = _H[i, j, k] q1_j q2_k.
_H = np.zeros((4, 4, 4))
_H[0, 0, 0] = 1
_H[0, 1:, 1:] = -_I3
_H[1:, 0, 1:] = _H[1:, 1:, 0] = _I3
_H[1:, 1:, 1:] = _HAT.transpose(0, 2, 1)

CONJUGATE = np.diag([1.0, -1.0, -1.0, -1.0])
TINY = 1e-150  # below it, the square of a number has lost its digits
SMALL = 1e-4  # radians: below it sin and atan are replaced by series whose next term is under 1e-17


def hat(v):
    """Cross-product matrix: hat(v) w = v x w, shape (..., 3, 3). Solà (2017), eq. 7.

    See Also
    --------
    w2omega : The same for the product of quaternions.
    """
    return np.einsum("ijk,...k->...ij", _HAT, v)


def unit(v):
    """Normalise vectors: u = v / |v|, U_v = (I - u u') / |v|.

    Parameters
    ----------
    v : ndarray, shape (..., n)

    Returns
    -------
    u : ndarray, shape (..., n)
    U_v : ndarray, shape (..., n, n)
        The exact derivative: the projector on the plane normal to v, over the norm.

    See Also
    --------
    Frame3.normalized : The same for the quaternion of a frame.
    """
    n = np.linalg.norm(v, axis=-1, keepdims=True)
    u = v / n
    return u, (np.eye(u.shape[-1]) - u[..., :, None] * u[..., None, :]) / n[..., None]


# --- the product -----------------------------------------------------------------------------------------------------


def q2Q(q):
    """Left-product matrix: q1 q2 = Q(q1) q2, shape (..., 4, 4). Solà (2017), eq. 18.

    See Also
    --------
    q2Qn : The other factor.
    q_prod : The product itself.
    """
    return np.einsum("ijk,...j->...ik", _H, q)


def q2Qn(q):
    """Right-product matrix: q1 q2 = Qn(q2) q1, shape (..., 4, 4). Solà (2017), eq. 18.

    See Also
    --------
    q2Q : The other factor.
    q_prod : The product itself.
    """
    return np.einsum("ijk,...k->...ij", _H, q)


def q_prod(q1, q2):
    """Hamilton product of quaternions.

    Returns
    -------
    q : ndarray, shape (..., 4)
        q1 q2, not commutative. Solà (2017), eq. 12.
    Q_q1, Q_q2 : ndarray, shape (..., 4, 4)

    See Also
    --------
    q2Q, q2Qn : Its matrices.
    q2qc : The inverse.
    Frame3.compose : The same for frames.
    """
    Q_q1, Q_q2 = q2Qn(q2), q2Q(q1)
    return np.einsum("...ij,...j->...i", Q_q2, q2), Q_q1, Q_q2


def q2qc(q):
    """Conjugate quaternion: the inverse rotation, for a unit quaternion. Returns qc, QC_q.

    See Also
    --------
    q_prod : The product of q and its conjugate is the identity.
    pi2pc : Its PI matrix.
    """
    qc = q * np.diag(CONJUGATE)
    return qc, np.broadcast_to(CONJUGATE, (*qc.shape, 4))


def q2Pi(q):
    """PI matrix: q_dot = 1/2 Pi(q) w for an angular rate w in the local frame, shape (..., 4, 3). Manual, fig. 18.

    See Also
    --------
    pi2pc : That of the conjugate.
    w2omega : The same product as a matrix of w.
    """
    return q2Q(q)[..., :, 1:]


def pi2pc(Pi):
    """Conjugate PI matrix Pc = Pi(qc), from Pi = Pi(q), shape (..., 4, 3). Manual, fig. 18.

    See Also
    --------
    q2Pi : The PI matrix itself.
    q2qc : The conjugate quaternion.
    """
    Pi = np.asarray(Pi, float)
    Pc = -Pi
    Pc[..., 1:, :] = np.swapaxes(Pi[..., 1:, :], -1, -2)
    return Pc


def w2omega(w):
    """Matrix Omega(w) with q_dot = 1/2 Omega(w) q for an angular rate w in the local frame, shape (..., 4, 4).

    See Also
    --------
    q2Pi : The same product as a matrix of q.
    """
    return np.einsum("ijk,...k->...ij", _H[:, :, 1:], w)


# --- rotation matrix -------------------------------------------------------------------------------------------------


def q2R_q(q):
    """Derivative of the rotation matrix: R_q[..., i, j, k] = d R_ij / d q_k, shape (..., 3, 3, 4).

    See Also
    --------
    q2R : The matrix itself.
    """
    return np.einsum("ijkl,...l->...ijk", _T, q)


def q2R(q):
    """Quaternion to rotation matrix.

    Parameters
    ----------
    q : ndarray, shape (..., 4)

    Returns
    -------
    R : ndarray, shape (..., 3, 3)
        p_global = R p_local. R is |q|^2 times a rotation; a rotation for |q| = 1. Solà (2017), eq. 115.
    R_q : ndarray, shape (..., 3, 3, 4)

    See Also
    --------
    R2q : The inverse.
    q2R_q : The derivative alone.
    e2R : From Euler angles.
    """
    R_q = q2R_q(q)
    return 0.5 * np.einsum("...ijk,...k->...ij", R_q, q), R_q


def R2q(R):
    """Rotation matrix to quaternion, with the branch that divides by the largest component (Shepperd 1978).

    Parameters
    ----------
    R : ndarray, shape (..., 3, 3)

    Returns
    -------
    q : ndarray, shape (..., 4)
        Unit quaternion, its largest component positive.
    Q_R : ndarray, shape (..., 4, 3, 3)
        Derivative of that branch's formula with respect to the nine entries.

    See Also
    --------
    q2R : The inverse.
    """
    R = np.asarray(R, float)
    diagonal = np.diagonal(R, axis1=-2, axis2=-1)
    trace = diagonal.sum(-1)
    # 4 q q' - |q|^2 ... is linear in R: row k of the matrix M below is 4 q_k q, for a unit quaternion.
    M_R = _four_qq_R()
    M = np.einsum("klij,...ij->...kl", M_R, R) + np.eye(4)
    k = np.argmax(np.concatenate([trace[..., None], diagonal], axis=-1), axis=-1)

    m = np.take_along_axis(M, k[..., None, None], axis=-2)[..., 0, :]  # 4 q_k q
    mk = np.take_along_axis(m, k[..., None], axis=-1)  # 4 q_k^2
    root = np.sqrt(mk)
    q = m / (2 * root)

    m_R = M_R[k]
    mk_R = np.take_along_axis(m_R, k[..., None, None, None], axis=-3)
    Q_R = m_R / (2 * root[..., None, None]) - m[..., None, None] * mk_R / (4 * (root * mk)[..., None, None])
    return q, Q_R


def _four_qq_R():
    """Derivative of the matrix 4 q q' (for |q| = 1) with respect to R, shape (4, 4, 3, 3)."""
    M_R = np.zeros((4, 4, 3, 3))
    M_R[0, 0] = _I3
    M_R[0, 1:] = M_R[1:, 0] = np.moveaxis(_HAT, -1, 0)  # sum over ij of hat_ij R_ij = 4 a v
    M_R[1:, 1:] = np.einsum("ki,lj->klij", _I3, _I3) + np.einsum("kj,li->klij", _I3, _I3)
    M_R[1:, 1:] -= np.einsum("kl,ij->klij", _I3, _I3)
    return M_R


# --- Euler angles ----------------------------------------------------------------------------------------------------


def e2q(e):
    """Euler angles [roll pitch yaw] to quaternion: q = q_z(yaw) q_y(pitch) q_x(roll). Returns q, Q_e (..., 4, 3).

    See Also
    --------
    q2e : The inverse.
    e2R : To the rotation matrix.
    """
    e = np.asarray(e, float)
    c, s, zero = np.cos(e / 2), np.sin(e / 2), np.zeros(e.shape[:-1])
    qx, qy, qz = (np.stack([c[..., i], *(s[..., i] if j == i else zero for j in range(3))], -1) for i in range(3))
    dx, dy, dz = (np.stack([-s[..., i], *(c[..., i] if j == i else zero for j in range(3))], -1) / 2 for i in range(3))

    qyx, QYX_qy, QYX_qx = q_prod(qy, qx)
    q, Q_qz, Q_qyx = q_prod(qz, qyx)
    Q_qy, Q_qx = Q_qyx @ QYX_qy, Q_qyx @ QYX_qx
    Q_e = np.stack([(J @ d[..., None])[..., 0] for J, d in ((Q_qx, dx), (Q_qy, dy), (Q_qz, dz))], -1)
    return q, Q_e


def q2e(q):
    """Quaternion to Euler angles [roll pitch yaw].

    Parameters
    ----------
    q : ndarray, shape (..., 4)

    Returns
    -------
    e : ndarray, shape (..., 3)
        roll = atan2(r32, r33), pitch = atan2(-r31, hypot(r11, r21)), yaw = atan2(r21, r11).
    E_q : ndarray, shape (..., 3, 4)
        Infinite at pitch = +-pi/2, where roll and yaw are one and the same rotation ("gimbal lock"). The angles still
        give the rotation back: near there the yaw is taken from what is left of R once the roll is undone.

    See Also
    --------
    e2q : The inverse.
    """
    R, R_q = q2R(q)
    r11, r21, r31, r32, r33 = (R[..., i, j] for i, j in ((0, 0), (1, 0), (2, 0), (2, 1), (2, 2)))
    R11, R21, R31, R32, R33 = (R_q[..., i, j, :] for i, j in ((0, 0), (1, 0), (2, 0), (2, 1), (2, 2)))
    rho = np.hypot(r11, r21)
    with np.errstate(divide="ignore", invalid="ignore"):
        Rho = (r11[..., None] * R11 + r21[..., None] * R21) / rho[..., None]

        def atan2_q(y, x, Y, X):
            return (x[..., None] * Y - y[..., None] * X) / (x * x + y * y)[..., None]

        E_q = np.stack([atan2_q(r32, r33, R32, R33), atan2_q(-r31, rho, -R31, Rho), atan2_q(r21, r11, R21, R11)], -2)
    roll = np.arctan2(r32, r33)
    c, s = np.cos(roll), np.sin(roll)
    left = np.arctan2(s * R[..., 0, 2] - c * R[..., 0, 1], c * R[..., 1, 1] - s * R[..., 1, 2])
    yaw = np.where(rho < SMALL * np.abs(r31), left, np.arctan2(r21, r11))
    return np.stack([roll, np.arctan2(-r31, rho), yaw], -1), E_q


def e2R(e):
    """Euler angles [roll pitch yaw] to rotation matrix R = Rz Ry Rx. Returns R, R_e (..., 3, 3, 3).

    See Also
    --------
    e2q : To the quaternion.
    q2R : From the quaternion.
    """
    q, Q_e = e2q(e)
    R, R_q = q2R(q)
    return R, np.einsum("...ijk,...kl->...ijl", R_q, Q_e)


# --- rotation vector, axis and angle ---------------------------------------------------------------------------------


def v2au(v):
    """Rotation vector to angle and axis: v = a u, a >= 0, |u| = 1. Returns a, u, A_v (..., 3), U_v (..., 3, 3).

    The axis of a zero rotation is not defined; it is [1 0 0] with a zero derivative here.

    See Also
    --------
    au2v : The inverse.
    v2q : To the quaternion.
    """
    a = np.linalg.norm(v, axis=-1)
    zero = a < TINY
    safe = np.where(zero[..., None], [1.0, 0.0, 0.0], v)
    u, U_v = unit(safe)
    return a, u, np.where(zero[..., None], 0.0, u), np.where(zero[..., None, None], 0.0, U_v)


def au2v(a, u):
    """Angle and axis to rotation vector: v = a u. Returns v, V_a (..., 3), V_u (..., 3, 3).

    See Also
    --------
    v2au : The inverse.
    au2q : To the quaternion.
    """
    a, u = np.asarray(a), np.asarray(u)
    return a[..., None] * u, u, a[..., None, None] * np.broadcast_to(_I3, (*u.shape, 3))


def au2q(a, u):
    """Angle and axis to quaternion: q = [cos a/2, u sin a/2]. Returns q, Q_a (..., 4), Q_u (..., 4, 3).

    See Also
    --------
    q2au : The inverse.
    v2q : From the rotation vector.
    """
    a, u = np.asarray(a)[..., None], np.asarray(u)
    c, s = np.cos(a / 2), np.sin(a / 2)
    Q_u = np.concatenate([np.zeros((*u.shape[:-1], 1, 3)), s[..., None] * _I3], -2)
    return np.concatenate([c, s * u], -1), np.concatenate([-s, c * u], -1) / 2, Q_u


def q2au(q):
    """Quaternion to angle and axis. Returns a, u, A_q (..., 4), U_q (..., 3, 4).

    The angle is 2 atan2(|[b c d]|, a), in [0, 2 pi]: q and -q give angles that add up to 2 pi.

    See Also
    --------
    au2q : The inverse.
    q2v : To the rotation vector.
    """
    w, v = np.split(q, [1], axis=-1)
    n, u, N_v, U_v = v2au(v)
    n = n[..., None]
    A_q = 2 * np.concatenate([-n, w * N_v], -1) / (n * n + w * w)
    return 2 * np.arctan2(n, w)[..., 0], u, A_q, np.concatenate([np.zeros((*v.shape, 1)), U_v], -1)


def v2q(v):
    """Rotation vector to quaternion: q = [cos |v|/2, sin(|v|/2) v/|v|]. Solà (2017), eq. 101.

    Parameters
    ----------
    v : ndarray, shape (..., 3)
        Radians. Smooth through zero.

    Returns
    -------
    q : ndarray, shape (..., 4)
    Q_v : ndarray, shape (..., 4, 3)

    See Also
    --------
    q2v : The inverse.
    au2q : From axis and angle.
    """
    v = np.asanyarray(v)
    a2 = np.sum(v * v, axis=-1, keepdims=True)
    a = np.sqrt(a2)
    small = a < SMALL
    safe = np.where(small, 1.0, a)
    c = np.cos(a / 2)
    s = np.where(small, 0.5 - a2 / 48, np.sin(safe / 2) / safe)  # sin(a/2) / a
    ds = np.where(small, -1 / 24 + a2 / 960, (c / 2 - s) / safe**2)  # its derivative by a, over a

    Q_v = np.concatenate([-s[..., None] * v[..., None, :] / 2, s[..., None] * _I3], -2)
    Q_v[..., 1:, :] += ds[..., None] * v[..., :, None] * v[..., None, :]
    return np.concatenate([c, s * v], -1), Q_v


def q2v(q):
    """Quaternion to rotation vector: v = a u with the angle of `q2au`, in [0, 2 pi].

    Parameters
    ----------
    q : ndarray, shape (..., 4)

    Returns
    -------
    v : ndarray, shape (..., 3)
        Radians. For the shortest rotation give the one of q and -q whose first component is not negative. At
        [-1 0 0 0], a whole turn, no axis is defined: it is [1 0 0] with a zero derivative, as in `v2au`.
    V_q : ndarray, shape (..., 3, 4)

    See Also
    --------
    v2q : The inverse.
    q2au : To axis and angle.
    """
    w, v = np.split(np.asarray(q, float), [1], axis=-1)
    n2 = np.sum(v * v, axis=-1, keepdims=True)
    small = (np.sqrt(n2) < SMALL * np.abs(w)) & (w > 0)
    w = np.where(small, w, 1.0)
    k = (2 - 2 * n2 / (3 * w * w)) / w  # v = k [b c d], by the series of atan
    V_v = k[..., None] * _I3 - 4 / (3 * w**3)[..., None] * v[..., :, None] * v[..., None, :]
    V_w = -2 * v / (n2 + w * w)

    a, u, A_q, U_q = q2au(q)
    V_q = a[..., None, None] * U_q + u[..., :, None] * A_q[..., None, :]
    V_small = np.concatenate([V_w[..., None], V_v], -1)
    return np.where(small, k * v, a[..., None] * u), np.where(small[..., None], V_small, V_q)
