"""Pin-hole camera with a depth channel (RGB-D): it measures all three coordinates of a point."""

from dataclasses import dataclass, field
from functools import cached_property
from typing import ClassVar

import numpy as np

from .parameters import check_positive
from .pin_hole import PinHole


@dataclass(frozen=True)
class PinHoleDepth(PinHole):
    """Camera that measures [u, v, depth]: pixel, and the distance along its optical axis (not the range).

    F. Endres et al., "3-D mapping with an RGB-D camera", IEEE T-RO 30(1), 2014.

    Parameters
    ----------
    k, d, c, image_size, pixel_std
        As in `PinHole`.
    depth_std : float
        Standard deviation of the depth, m.

    See Also
    --------
    PinHole : Without the depth.
    """

    depth_std: float = field(default=0.1, kw_only=True)

    bearing_only: ClassVar[bool] = False
    units: ClassVar = ("px", "px", "m")

    def __post_init__(self):
        super().__post_init__()
        check_positive(self, "depth_std")

    @cached_property
    def R(self):
        """Measurement noise covariance, diag(pixel_std^2, pixel_std^2, depth_std^2)."""
        return np.diag([self.pixel_std**2, self.pixel_std**2, self.depth_std**2])

    def project(self, p):
        """Point in the camera frame to [u, v, z]. Returns y, Y_p.

        See Also
        --------
        retro : The inverse.
        """
        u, U_p = super().project(p)
        z = p[..., 2:]
        Z_p = np.broadcast_to([0.0, 0.0, 1.0], (*z.shape, 3))
        return np.concatenate([u, z], -1), np.concatenate([U_p, Z_p], -2)

    def retro(self, y):
        """[u, v, depth] to a point in the camera frame: depth times the ray. Returns v, V_y.

        See Also
        --------
        project : The inverse.
        """
        ray, RAY_u = super().retro(y[..., :2])
        s = y[..., 2:]
        return s * ray, np.concatenate([s[..., None] * RAY_u, ray[..., None]], -1)

    def project_parameters(self, p):
        """Derivatives of `project` by k and d; the depth does not depend on them. Returns y, Y_k, Y_d.

        See Also
        --------
        retro_parameters : The way back.
        """
        u, U_k, U_d = super().project_parameters(p)
        y = np.concatenate([u, p[..., 2:]], -1)
        return y, *(np.concatenate([U, np.zeros((*U.shape[:-2], 1, U.shape[-1]))], -2) for U in (U_k, U_d))

    def retro_parameters(self, y):
        """Derivatives of `retro` by k and c (or d, see `PinHole`). Returns v, V_k, V_c.

        See Also
        --------
        project_parameters : The way there.
        """
        ray, RAY_k, RAY_c = super().retro_parameters(y[..., :2])
        s = y[..., 2:]
        return s * ray, s[..., None] * RAY_k, s[..., None] * RAY_c
