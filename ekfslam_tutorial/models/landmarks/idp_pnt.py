"""Inverse-depth point: six numbers for a point whose distance is not known yet."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from .projective import ahead, anchored, anchored_point, anchored_ray, linearity, scalar, weight

POLE = 1e-8  # radians: how near to the z axis a direction may come, see `vec2py`


def py2vec(py):
    """Pitch and yaw to a unit direction: m = [cos p cos y, cos p sin y, sin p].

    Parameters
    ----------
    py : ndarray, shape (..., 2)
        Elevation over the x-y plane and azimuth from x, radians.

    Returns
    -------
    m : ndarray, shape (..., 3)
    M_py : ndarray, shape (..., 3, 2)

    See Also
    --------
    vec2py : The inverse.
    """
    c, s = np.cos(py), np.sin(py)
    cp, sp, cy, sy = c[..., 0], s[..., 0], c[..., 1], s[..., 1]
    m = np.stack([cp * cy, cp * sy, sp], -1)
    M_pitch = np.stack([-sp * cy, -sp * sy, cp], -1)
    M_yaw = np.stack([-cp * sy, cp * cy, np.zeros_like(cp)], -1)
    return m, np.stack([M_pitch, M_yaw], -1)


def vec2py(v):
    """Direction of any length to pitch and yaw.

    Returns
    -------
    py : ndarray, shape (..., 2)
        [atan2(z, hypot(x, y)), atan2(y, x)], radians.
    PY_v : ndarray, shape (..., 2, 3)

    See Also
    --------
    py2vec : The inverse.

    Notes
    -----
    On the z axis the yaw has no meaning. A camera looks along its z axis, so a direction can come to lie there on
    its way through the sensor frame. It is moved off the axis by `POLE` radians then, 3e-6 pixels in a camera of
    focal length 320, and the chain of Jacobians holds through it.
    """
    x, y, z = v[..., 0], v[..., 1], v[..., 2]
    x = np.where(x * x + y * y < (POLE * z) ** 2, POLE * np.abs(z), x)
    r2 = x * x + y * y
    r, n2 = np.sqrt(r2), r2 + z * z
    k = z / (r * n2)
    pitch_v = np.stack([-x * k, -y * k, r / n2], -1)
    yaw_v = np.stack([-y / r2, x / r2, np.zeros_like(r2)], -1)
    return np.stack([np.arctan2(z, r), np.arctan2(y, x)], -1), np.stack([pitch_v, yaw_v], -2)


@dataclass(frozen=True)
class IdpPnt:
    """A point l = [x0; pitch; yaw; rho] at p = x0 + m(pitch, yaw) / rho, rho the inverse distance (1/m).

    Civera, Davison, Montiel, "Inverse depth parametrization for monocular SLAM", IEEE T-RO 24(5), 2008; pitch is
    positive upwards here, as in the manual.

    See Also
    --------
    AhmPnt : With a vector instead of the two angles.
    EucPnt : What it can become once its distance is known.
    """

    dim: ClassVar[int] = 3
    size: ClassVar[int] = 6

    def to_frame(self, F, l):
        """Anchor as a point, direction through its vector. Returns l_F, LF_f, LF_l.

        See Also
        --------
        from_frame : The inverse.
        """
        return self._change(F.to_frame, l)

    def from_frame(self, F, l):
        """Anchor as a point, direction through its vector. Returns l, L_f, L_lf.

        See Also
        --------
        to_frame : The inverse.
        """
        return self._change(F.from_frame, l)

    @staticmethod
    def _change(transform, l):
        t, T_f, T_t = transform(l[..., :3])
        m, M_py = py2vec(l[..., 3:5])
        m2, M2_f, M2_m = transform(m, 0.0)
        py, PY_m2 = vec2py(m2)
        return anchored(t, py, l[..., 5:], T_f, T_t, PY_m2 @ M2_f, PY_m2 @ M2_m @ M_py)

    def point(self, l):
        """p = x0 + m / rho. Returns p, P_l. Not finite at rho = 0: the point is at infinity.

        See Also
        --------
        from_point : The inverse.
        ray : Also at infinity.
        """
        m, M_py = py2vec(l[..., 3:5])
        return anchored_point(l[..., :3], m, l[..., 5:], M_py)

    def ray(self, l):
        """v = x0 rho + m, turned round where rho < 0. Returns v, V_l.

        See Also
        --------
        from_ray : The inverse.
        homogeneous : With its weight.
        """
        m, M_py = py2vec(l[..., 3:5])
        return anchored_ray(l[..., :3], m, l[..., 5:], M_py)

    def homogeneous(self, l):
        """The ray and its weight |rho|: p = v / |rho|. Returns v, w, V_l, W_l.

        See Also
        --------
        ray : Without its weight.
        """
        v, V_l = self.ray(l)
        w, W_l = weight(l[..., -1:], 6)
        return v, w, V_l, W_l

    def from_ray(self, v, n):
        """l = [0; pitch, yaw of v; n], n the prior inverse distance. Returns l, L_v, L_n.

        See Also
        --------
        ray : The inverse.
        """
        py, PY_v = vec2py(v)
        l = np.concatenate([np.zeros_like(v), py, scalar(n, v)], -1)
        L_v = np.zeros_like(l, shape=(*l.shape, 3))
        L_v[..., 3:5, :] = PY_v
        return l, L_v, np.eye(6)[:, 5:]

    def from_point(self, p):
        """l = [0; pitch, yaw of p; 1 / |p|]. Returns l, L_p, L_n (no columns).

        See Also
        --------
        point : The inverse.
        """
        rho = 1 / np.linalg.norm(p, axis=-1, keepdims=True)
        l, L_v, L_n = self.from_ray(p, rho)
        RHO_p = -(rho**3)[..., None] * p[..., None, :]
        return l, L_v + L_n @ RHO_p, np.zeros((6, 0))

    def ahead(self, l, min_rho):
        """The landmark with an inverse distance that is not negative."""
        return ahead(l, min_rho)

    def linearity(self, l, P, camera):
        """Linearity index, seen from a camera at this place; below about 0.1 a Euclidean point will do."""
        return linearity(l[:3], py2vec(l[3:5])[0], l[-1], P[-1, -1], camera)
