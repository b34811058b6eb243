"""Reference frames: where a robot stands, or a sensor on its robot.

A frame is a state vector and the two transforms it defines. `Frame2` and `Frame3` have the same methods, so all that
is built on them works in 2D and in 3D. A frame never changes: a new pose is a new frame.
"""

from dataclasses import dataclass
from functools import cached_property
from math import pi
from typing import Any, ClassVar

import numpy as np

from .angles import wrap
from .quaternions import q2Q, q2qc, q2R, q2R_q, q2v, q_prod, unit

ONE = np.eye(1)  # derivative of a heading by a heading
QUARTER = np.array([[0.0, -1.0], [1.0, 0.0]])  # a turn to the left: R = cos I + sin QUARTER, and R_o = R QUARTER


@dataclass(frozen=True, eq=False)
class _Frame:
    """Base of both frames: a state x = [t; o] of position and orientation, and the transforms.

    `Frame2` and `Frame3` add the rotation matrix R(o), its derivative, the product and the inverse of orientations.
    """

    x: np.ndarray
    size: ClassVar[int]
    dim: ClassVar[int]
    fields: ClassVar[str]
    X_step: ClassVar[Any]  # derivative of the origin by a small step [t; turn] away from it
    R: ClassVar[Any]
    R_o: ClassVar[Any]
    _product: ClassVar[Any]
    _inverse: ClassVar[Any]

    def __post_init__(self):
        x = np.positive(self.x, dtype=float)  # floats, and the frame's own
        if x.ndim == 0 or x.shape[-1] != self.size:
            raise ValueError(f"{type(self).__name__} needs {self.size} numbers {self.fields}, got shape {x.shape}")
        object.__setattr__(self, "x", x)

    @property
    def t(self):
        """Position, shape (..., dim), metres."""
        return self.x[..., : self.dim]

    @property
    def o(self):
        """Orientation, shape (..., size - dim): the heading, or the quaternion."""
        return self.x[..., self.dim :]

    @cached_property
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

        See Also
        --------
        from_frame : The inverse.
        """
        w = np.asanyarray(w)
        d = p - w * self.t
        pf = (self.Rt @ d[..., None])[..., 0]
        PF_o = np.einsum("...jik,...j->...ik", self.R_o, d)
        return pf, _side_by_side(pf, -w[..., None] * self.Rt, PF_o), self.Rt

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

        See Also
        --------
        to_frame : The inverse.
        compose : The same for frames.
        """
        w = np.asanyarray(w)
        p = (self.R @ pf[..., None])[..., 0] + w * self.t
        P_o = np.einsum("...ijk,...j->...ik", self.R_o, pf)
        return p, _side_by_side(p, w[..., None] * np.eye(self.dim), P_o), self.R

    def compose(self, G):
        """Frame G, given in this frame, expressed in this frame's parent.

        Returns
        -------
        FG : Frame2 or Frame3
        FG_f, FG_g : ndarray, shape (..., size, size)

        See Also
        --------
        inverse : F.compose(F.inverse()[0]) is the origin.
        from_frame : The same for points.
        minus : The difference of two frames.
        """
        t, T_f, T_t = self.from_frame(G.t)
        o, O_f, O_g = self._product(self.o, G.o)
        FG = type(self)(np.concatenate([t, o], -1))
        return FG, _one_above_the_other(FG.x, T_f, O_f), _one_above_the_other(FG.x, T_t, O_g)

    def inverse(self):
        """The parent's frame expressed in this one. Returns I, I_f (..., size, size).

        See Also
        --------
        compose : F.compose(F.inverse()[0]) is the origin.
        """
        t, T_f, _ = self.to_frame(np.zeros(self.dim))
        o, O_o = self._inverse(self.o)
        I = type(self)(np.concatenate([t, o], -1))
        return I, _one_above_the_other(I.x, T_f, O_o)

    def __eq__(self, other):
        return type(self) is type(other) and np.array_equal(self.x, other.x)


def _side_by_side(p, P_t, P_o):
    """Jacobian [P_t P_o] of points p, from those by position and orientation of a frame."""
    return np.concatenate([np.broadcast_to(P_t, (*p.shape, P_t.shape[-1])), P_o], -1)


def _one_above_the_other(x, T, O):
    """Jacobian [T 0; 0 O] of x = [t; o], from those of position and orientation; T may reach over all columns."""
    d = T.shape[-2]
    J = np.zeros_like(x, shape=(*x.shape, d + O.shape[-1]))
    J[..., :d, : T.shape[-1]], J[..., d:, d:] = T, O
    return J


class Frame2(_Frame):
    """Reference frame in the plane.

    Parameters
    ----------
    x : array_like, shape (..., 3)
        [x, y, theta]: position in metres and heading in radians, counter-clockwise from the parent's x axis.

    See Also
    --------
    Frame3 : The same in space.
    """

    size: ClassVar[int] = 3
    dim: ClassVar[int] = 2
    dof: ClassVar[int] = 3
    fields: ClassVar[str] = "[x, y, theta]"
    X_step: ClassVar = np.eye(3)

    @property
    def theta(self):
        """Heading, radians."""
        return self.x[..., 2]

    @cached_property
    def R(self):
        """Rotation matrix, shape (..., 2, 2)."""
        return np.cos(self.o)[..., None] * np.eye(2) + np.sin(self.o)[..., None] * QUARTER

    @cached_property
    def R_o(self):
        """Derivative of R by the heading, shape (..., 2, 2, 1)."""
        return (self.R @ QUARTER)[..., None]

    @staticmethod
    def _product(a, b):
        return a + b, ONE, ONE

    @staticmethod
    def _inverse(a):
        return -a, -ONE

    def normalized(self):
        """The same frame with its heading in (-pi, pi]; itself, if it is. Returns N, N_f (..., 3, 3).

        See Also
        --------
        wrap : The same for an angle.
        """
        N = self if np.all(np.abs(self.o) < pi) else Frame2(np.concatenate([self.t, wrap(self.o)], -1))
        return N, _one_above_the_other(N.x, np.eye(2), ONE)

    def minus(self, G):
        """Difference of poses, for errors: [t - t_G; wrapped heading difference].

        Returns
        -------
        e : ndarray, shape (..., 3)
        E_f : ndarray, shape (..., 3, 3)
            Derivative with respect to this frame; the covariance of `e` is E_f P E_f'.

        See Also
        --------
        compose : The product of two frames.
        """
        e = np.concatenate([self.t - G.t, wrap(self.o - G.o)], -1)
        return e, _one_above_the_other(e, np.eye(2), ONE)


class Frame3(_Frame):
    """Reference frame in space.

    Parameters
    ----------
    x : array_like, shape (..., 7)
        [t; q]: position in metres and orientation quaternion [a b c d], Hamilton, local to global.

    See Also
    --------
    Frame2 : The same in the plane.
    """

    size: ClassVar[int] = 7
    dim: ClassVar[int] = 3
    dof: ClassVar[int] = 6
    fields: ClassVar[str] = "[t(3), q(4)]"
    X_step: ClassVar = np.diag([1, 1, 1, 0, 0.5, 0.5, 0.5])[:, [0, 1, 2, 4, 5, 6]]

    @property
    def q(self):
        """Orientation quaternion, shape (..., 4)."""
        return self.o

    @cached_property
    def R(self):
        """Rotation matrix R = q2R(q), shape (..., 3, 3)."""
        return q2R(self.q)[0]

    @cached_property
    def R_o(self):
        """Derivative of R by the quaternion, shape (..., 3, 3, 4)."""
        return q2R_q(self.q)

    @property
    def R_q(self):
        """The same as `R_o`, by the manual's name."""
        return self.R_o

    _product = staticmethod(q_prod)
    _inverse = staticmethod(q2qc)

    def normalized(self):
        """The same frame with a unit quaternion. Returns N, N_f (..., 7, 7).

        The Jacobian of the quaternion is the projector on the tangent plane of the unit sphere: a covariance that
        passes through it has no part left along q, which no measurement could ever remove.

        See Also
        --------
        unit : The same for a vector.
        """
        q, Q_q = unit(self.q)
        N = Frame3(np.concatenate([self.t, q], -1))
        return N, _one_above_the_other(N.x, np.eye(3), Q_q)

    def minus(self, G):
        """Difference of poses in the tangent space, for errors: [t - t_G; v], v the rotation vector of q_G* q.

        Returns
        -------
        e : ndarray, shape (..., 6)
            Metres, and radians in the frame G; the rotation is the shorter one.
        E_f : ndarray, shape (..., 6, 7)
            Derivative with respect to this frame; the covariance of `e` is E_f P E_f', of full rank 6.

        See Also
        --------
        compose : The product of two frames.
        q2v : The rotation vector of a quaternion.
        """
        Q = q2Q(q2qc(G.q)[0])
        dq = np.einsum("...ij,...j->...i", Q, self.q)
        sign = np.where(dq[..., :1] < 0, -1.0, 1.0)
        v, V_dq = q2v(sign * dq)
        e = np.concatenate([self.t - G.t, v], -1)
        return e, _one_above_the_other(e, np.eye(3), sign[..., None] * V_dq @ Q)


ORIGIN = {2: Frame2(np.zeros(3)), 3: Frame3(np.eye(7)[3])}
"""The frame of the world itself, by dimension."""
