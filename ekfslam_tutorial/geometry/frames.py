"""Reference frames: where a robot stands, or a sensor on its robot.

A frame is a state vector and the two transforms it defines. `Frame2` and `Frame3` have the same methods, so all that
is built on them works in 2D and in 3D. A frame never changes: a new pose is a new frame.
"""

from dataclasses import dataclass
from math import pi
from typing import Any, ClassVar

import numpy as np

from .angles import wrap
from .arrays import blank, cos_sin, floats, identity, leading, matrix, numbers, vector, zeros
from .lazy import lazy
from .quaternions import CONJUGATE, q2Q, q2qc, q2R_q, q2v, q_prod, unit

QUARTER = np.array([[0.0, -1.0], [1.0, 0.0]])  # p' QUARTER: p turned by -90 degrees


def _mul(A, v):
    """Matrix times vectors, shape (..., d): a single product where there is a single matrix."""
    return v.dot(A.T) if A.ndim == 2 else (A @ v[..., None])[..., 0]


def _weigh(w, a, matrix=False):
    """Weights of shape (..., 1) times vectors or matrices; the weight 1, of points, costs nothing."""
    if isinstance(w, float):
        return a if w == 1.0 else w * a
    return (np.asarray(w)[..., None] if matrix else w) * a


def _contract(v, Ro):
    """Sum over the rows of R_o of R_o times v, shape (..., 3, 4)."""
    J = v.dot(Ro) if Ro.ndim == 2 else (v[..., None, :] @ Ro)[..., 0, :]
    return J.reshape(*J.shape[:-1], 3, 4)


class _Frame:
    """What frames of both dimensions share: it needs `R`, and the derivatives of R' d and R p by the orientation."""

    x: np.ndarray
    size: ClassVar[int]
    dim: ClassVar[int]
    fields: ClassVar[str]
    R: Any
    R_o: Any
    _back_o: Any
    _forth_o: Any

    def __post_init__(self):
        x = floats(self.x)
        if x.ndim == 0 or x.shape[-1] != self.size:
            raise ValueError(f"{type(self).__name__} needs {self.size} numbers {self.fields}, got shape {x.shape}")
        object.__setattr__(self, "x", x)

    @lazy
    def t(self):
        """Position, shape (..., dim), metres."""
        return self.x[..., : self.dim]

    @lazy
    def Rt(self):
        """Transposed rotation matrix, shape (..., dim, dim)."""
        return np.swapaxes(self.R, -1, -2)

    def to_frame(self, p, w=1.0):
        """Express points in this frame: p_F = R' (p - t).

        Parameters
        ----------
        p : ndarray, shape (..., dim)
            Points in the parent frame.
        w : float or ndarray, shape (..., 1)
            Homogeneous weight: 1 for points, 0 for directions; p_F = R' (p - w t).

        Returns
        -------
        pf : ndarray, shape (..., dim)
        PF_f : ndarray, shape (..., dim, size)
            Derivative with respect to the frame's state vector.
        PF_p : ndarray, shape (..., dim, dim)
        """
        d = p - _weigh(w, self.t)
        pf = _mul(self.Rt, d)
        PF_f = blank(d, *d.shape, self.size)
        PF_f[..., : self.dim] = _weigh(w, self._minus_Rt, matrix=True)
        PF_f[..., self.dim :] = self._back_o(d, pf)
        return pf, PF_f, self.Rt

    def from_frame(self, pf, w=1.0):
        """Express points of this frame in its parent: p = R p_F + t.

        Parameters
        ----------
        pf : ndarray, shape (..., dim)
            Points in this frame.
        w : float or ndarray, shape (..., 1)
            Homogeneous weight: 1 for points, 0 for directions; p = R p_F + w t.

        Returns
        -------
        p : ndarray, shape (..., dim)
        P_f : ndarray, shape (..., dim, size)
            Derivative with respect to the frame's state vector.
        P_pf : ndarray, shape (..., dim, dim)
        """
        d = _mul(self.R, pf)
        P_f = blank(d, *d.shape, self.size)
        P_f[..., : self.dim] = _weigh(w, identity(self.dim), matrix=True)
        P_f[..., self.dim :] = self._forth_o(pf, d)
        return d + _weigh(w, self.t), P_f, self.R

    @lazy
    def _minus_Rt(self):
        return -self.Rt

    def __eq__(self, other):
        return type(self) is type(other) and np.array_equal(self.x, other.x)


@dataclass(frozen=True, eq=False)
class Frame2(_Frame):
    """Reference frame in the plane.

    Parameters
    ----------
    x : array_like, shape (..., 3)
        [x, y, theta]: position in metres and heading in radians, counter-clockwise from the parent's x axis.
    """

    x: np.ndarray
    size: ClassVar[int] = 3
    dim: ClassVar[int] = 2
    dof: ClassVar[int] = 3
    fields: ClassVar[str] = "[x, y, theta]"

    @lazy
    def theta(self):
        """Heading, radians."""
        return self.x[..., 2]

    @lazy
    def _cos_sin(self):
        return cos_sin(numbers(self.x)[2])

    @lazy
    def R(self):
        """Rotation matrix, shape (..., 2, 2)."""
        c, s = self._cos_sin
        return matrix(self.x.shape[:-1], [c, -s], [s, c])

    @lazy
    def R_o(self):
        """Derivative of R by the heading, shape (..., 2, 2, 1)."""
        c, s = self._cos_sin
        return matrix(self.x.shape[:-1], [-s, -c], [c, -s])[..., None]

    def _back_o(self, d, pf):
        """Derivative of pf = R' d by the heading: the quarter turn of pf to the right."""
        return pf.dot(QUARTER)[..., None]

    def _forth_o(self, pf, d):
        """Derivative of d = R pf by the heading: the quarter turn of d to the left."""
        return d.dot(QUARTER.T)[..., None]

    def compose(self, G):
        """Frame G, given in this frame, expressed in this frame's parent.

        Returns
        -------
        FG : Frame2
        FG_f, FG_g : ndarray, shape (..., 3, 3)
        """
        (x, y, a), (gx, gy, b), (c, s) = numbers(self.x), numbers(G.x), self._cos_sin
        lead = leading(self.x, G.x)
        dx, dy = c * gx - s * gy, s * gx + c * gy
        FG_f = matrix(lead, [1.0, 0.0, -dy], [0.0, 1.0, dx], [0.0, 0.0, 1.0])
        FG_g = matrix(lead, [c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0])
        return Frame2(vector(lead, x + dx, y + dy, a + b)), FG_f, FG_g

    def inverse(self):
        """The parent's frame expressed in this one. Returns I, I_f (..., 3, 3)."""
        t, T_f, _ = self.to_frame(np.zeros(2))
        I_f = -_eye_like(T_f, 3)
        I_f[..., :2, :] = T_f
        return Frame2(np.concatenate([t, np.expand_dims(-self.theta, -1)], -1)), I_f

    @property
    def is_normal(self):
        """Whether `normalized` would leave everything as it is: the heading is in (-pi, pi]."""
        if self.x.ndim == 1:
            return -pi < self.x.item(2) < pi
        return bool((np.abs(self.theta) < pi).all())

    def normalized(self):
        """The same frame with its heading in (-pi, pi]; itself, if it is. Returns N, N_f (..., 3, 3)."""
        if self.is_normal:
            return self, _eye_like(self.x[..., None], 3)
        x = np.concatenate([self.t, wrap(self.x[..., 2:])], -1)
        return Frame2(x), _eye_like(x[..., None], 3)

    def minus(self, G):
        """Difference of poses, for errors: [t - t_G; wrapped heading difference].

        Returns
        -------
        e : ndarray, shape (..., 3)
        E_f : ndarray, shape (..., 3, 3)
            Derivative with respect to this frame; the covariance of `e` is E_f P E_f'.
        """
        e = self.x - G.x
        e = np.concatenate([e[..., :2], wrap(e[..., 2:])], -1)
        return e, _eye_like(e[..., None], 3)


@dataclass(frozen=True, eq=False)
class Frame3(_Frame):
    """Reference frame in space.

    Parameters
    ----------
    x : array_like, shape (..., 7)
        [t; q]: position in metres and orientation quaternion [a b c d], Hamilton, local to global.
    """

    x: np.ndarray
    size: ClassVar[int] = 7
    dim: ClassVar[int] = 3
    dof: ClassVar[int] = 6
    fields: ClassVar[str] = "[t(3), q(4)]"

    @lazy
    def q(self):
        """Orientation quaternion, shape (..., 4)."""
        return self.x[..., 3:]

    @lazy
    def R(self):
        """Rotation matrix R = q2R(q), shape (..., 3, 3)."""
        return 0.5 * (self.R_o.dot(self.q) if self.x.ndim == 1 else _mul(self.R_o, self.q[..., None, :]))

    @lazy
    def R_o(self):
        """Derivative of R by the quaternion, shape (..., 3, 3, 4)."""
        return q2R_q(self.q)

    @property
    def R_q(self):
        """The same as `R_o`, by the manual's name."""
        return self.R_o

    @lazy
    def _Ro_rows(self):
        """R_o[i, j, k] as a matrix of rows i: v' R_o is one matrix product."""
        return self.R_o.reshape(*self.R_o.shape[:-2], -1)

    @lazy
    def _Ro_columns(self):
        """R_o[i, j, k] as a matrix of rows j."""
        return np.swapaxes(self.R_o, -3, -2).reshape(*self.R_o.shape[:-2], -1)

    def _back_o(self, d, pf):
        """Derivative of pf = R' d by the quaternion."""
        return _contract(d, self._Ro_rows)

    def _forth_o(self, pf, d):
        """Derivative of d = R pf by the quaternion."""
        return _contract(pf, self._Ro_columns)

    def compose(self, G):
        """Frame G, given in this frame, expressed in this frame's parent.

        Returns
        -------
        FG : Frame3
        FG_f, FG_g : ndarray, shape (..., 7, 7)
        """
        t, T_f, T_g = self.from_frame(G.t)
        q, Q_q, Q_gq = q_prod(self.q, G.q)
        FG_f, FG_g = zeros(t, *t.shape[:-1], 7, 7), zeros(t, *t.shape[:-1], 7, 7)
        FG_f[..., :3, :], FG_f[..., 3:, 3:] = T_f, Q_q
        FG_g[..., :3, :3], FG_g[..., 3:, 3:] = T_g, Q_gq
        x = blank(t, *t.shape[:-1], 7)
        x[..., :3], x[..., 3:] = t, q
        return Frame3(x), FG_f, FG_g

    def inverse(self):
        """The parent's frame expressed in this one. Returns I, I_f (..., 7, 7)."""
        t, T_f, _ = self.to_frame(np.zeros(3))
        qc, _ = q2qc(self.q)
        I_f = np.zeros((*t.shape[:-1], 7, 7))
        I_f[..., :3, :], I_f[..., 3:, 3:] = T_f, CONJUGATE
        return Frame3(np.concatenate([t, qc], -1)), I_f

    is_normal: ClassVar[bool] = False  # a covariance must always pass through the projector of `normalized`

    def normalized(self):
        """The same frame with a unit quaternion. Returns N, N_f (..., 7, 7).

        The Jacobian of the quaternion is the projector on the tangent plane of the unit sphere: a covariance that
        passes through it has no part left along q, which no measurement could ever remove.
        """
        q, Q_q = unit(self.q)
        x, N_f = np.empty_like(self.x), _eye_like(Q_q, 7)
        x[..., :3], x[..., 3:] = self.t, q
        N_f[..., 3:, 3:] = Q_q
        return Frame3(x), N_f

    def minus(self, G):
        """Difference of poses in the tangent space, for errors: [t - t_G; v], v the rotation vector of q_G* q.

        Returns
        -------
        e : ndarray, shape (..., 6)
            Metres, and radians in the frame G; the rotation is the shorter one.
        E_f : ndarray, shape (..., 6, 7)
            Derivative with respect to this frame; the covariance of `e` is E_f P E_f', of full rank 6.
        """
        Q = q2Q(q2qc(G.q)[0])
        dq = _mul(Q, self.q)
        sign = np.where(dq[..., :1] < 0, -1.0, 1.0)
        v, V_dq = q2v(sign * dq)
        E_f = np.zeros((*v.shape[:-1], 6, 7))
        E_f[..., :3, :3] = identity(3)
        E_f[..., 3:, 3:] = sign[..., None] * V_dq @ Q
        return np.concatenate([self.t - G.t, v], -1), E_f


def _eye_like(J, n):
    """A stack of n x n identities, one for each leading index of J, that may be written to."""
    E = zeros(J, *J.shape[:-2], n, n)
    E[...] = identity(n)
    return E
