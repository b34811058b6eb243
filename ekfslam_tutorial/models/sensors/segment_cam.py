"""Camera that measures straight edges: the two end points of a segment, of a line that may go on beyond them."""

from dataclasses import dataclass, field
from functools import cached_property
from typing import ClassVar

import numpy as np

from .clipping import stretch, walls
from .imager import Imager
from .parameters import check_positive
from .pin_hole import PinHole, pixellise, project


@dataclass(frozen=True)
class SegmentCam(Imager):
    """Pin-hole camera for lines: measures the end points y = [u1, v1, u2, v2] of a segment of its image, pixels.

    Where a segment ends says little: the edge of a door may end there, or a shadow. So the ends are not compared with
    expected ones. What is expected is the image of the line, a u + b v + c = 0, e = [a, b, c] with a^2 + b^2 = 1, and
    the innovation are the distances of both ends from it, with signs:

        z_i = [u_i, v_i, 1] e / |[a, b]|

    J. Solà et al., "Impact of landmark parametrization on monocular EKF-SLAM with points and lines", IJCV 97, 2012.

    With a lens that distorts, straight lines have bent images. The measured ends go back through the lens then, to the
    *ideal* image, and all this is meant there.

    Parameters
    ----------
    k, d, c, image_size, margin
        As in `PinHole`.
    pixel_std : float
        Standard deviation of each coordinate of an end, pixels.
    min_length : float
        A segment must be so long to be seen, pixels of the ideal image.

    See Also
    --------
    PinHole : For points. Both at the same place on a robot see points and lines.
    """

    k: tuple = (320.0, 240.0, 320.0, 320.0)
    d: tuple = ()
    c: tuple | None = field(default=None, kw_only=True)
    image_size: tuple = field(default=(640.0, 480.0), kw_only=True)
    pixel_std: float = field(default=1.0, kw_only=True)
    margin: float = field(default=0.0, kw_only=True)
    min_length: float = field(default=20.0, kw_only=True)

    dim: ClassVar[int] = 3
    bearing_only: ClassVar[bool] = True
    asks: ClassVar[str] = "normal"
    starts: ClassVar[str] = "from_rays"
    units: ClassVar = ("px", "px", "px", "px")

    def __post_init__(self):
        self.camera  # noqa: B018  refuses what no camera can have
        check_positive(self, "min_length")

    @cached_property
    def camera(self):
        """The same camera for points."""
        names = ("c", "image_size", "pixel_std", "margin")
        return PinHole(self.k, self.d, **{name: getattr(self, name) for name in names})

    @cached_property
    def R(self):
        """Measurement noise covariance of both ends, pixel_std^2 I."""
        return self.pixel_std**2 * np.eye(4)

    def project(self, n):
        """Plane through the camera, by its normal n, to the line where it meets the image. Returns e, E_n.

        The line is divided by |[a, b]|, and the derivative takes that for a constant: a line has no scale, and the
        innovation does not depend on it.

        See Also
        --------
        retro : The inverse, from two points.
        """
        u0, v0, au, av = self.k
        H_n = np.array([[av, 0, 0], [0, au, 0], [-av * u0, -au * v0, au * av]])
        h = n @ H_n.T
        with np.errstate(divide="ignore", invalid="ignore"):
            scale = np.hypot(h[..., :1], h[..., 1:2])
            return h / scale, H_n / scale[..., None]

    def retro(self, y):
        """End points to rays v = [v1; v2], [x/z, y/z, 1] each. Returns v, V_y.

        See Also
        --------
        project : The inverse.
        """
        v, V = self.camera.retro(_ends(y))
        V_y = np.zeros_like(y, shape=(*y.shape[:-1], 6, 4))
        V_y[..., :3, :2], V_y[..., 3:, 2:] = V[..., 0, :, :], V[..., 1, :, :]
        return v.reshape(*y.shape[:-1], 6), V_y

    def innovation(self, y, e):
        """Distances of both end points from an expected line, pixels of the ideal image. Returns z, Z_y, Z_e.

        The innovation has the covariance Z_e E Z_e' + Z_y R Z_y'.
        """
        v, V_y = self.camera.retro(_ends(y))
        q, Q_v, _ = pixellise(v[..., :2], self.k)  # the ends in the ideal image
        q1 = np.concatenate([q, np.ones_like(q[..., :1])], -1)
        length = np.hypot(e[..., :1], e[..., 1:2])
        u = e / length
        z = (q1 @ u[..., None])[..., 0]
        Z_q = u[..., None, None, :2] @ Q_v @ V_y[..., :2, :]
        Z_y = np.zeros_like(z, shape=(*z.shape, 4))
        Z_y[..., 0, :2], Z_y[..., 1, 2:] = Z_q[..., 0, 0, :], Z_q[..., 1, 0, :]
        U_e = np.concatenate([u[..., :2], 0 * length], -1)  # d |[a, b]| / de
        return z, Z_y, (q1 - z[..., None] * U_e[..., None, :]) / length[..., None]

    def residual(self, y, e):
        """Innovation: the two distances."""
        return self.innovation(y, e)[0]

    def visible(self, e, p):
        """Return True for each line of which enough is in the image: p are its ends [p1; p2] in the camera's frame."""
        return self.segments(p)[1]

    @cached_property
    def walls(self):
        """Planes between which is all that it sees."""
        return walls(self.camera)

    def segments(self, p):
        """Images of the parts that are seen of edges [p1; p2]. Returns y (..., 4), and which are long enough."""
        a, way = p[..., :3], p[..., 3:] - p[..., :3]
        first, last = stretch(self.camera, self.walls, a, way)
        with np.errstate(all="ignore"):
            q = a[..., None, :] + np.stack([first, last], -1)[..., None] * way[..., None, :]
            y, ideal = self.camera.project(q)[0], project(q)[0] * np.asarray(self.k[2:])
            length = np.linalg.norm(ideal[..., 1, :] - ideal[..., 0, :], axis=-1)
        return y.reshape(*y.shape[:-2], 4), (first < last) & (length >= self.min_length)


def _ends(y):
    """A segment as two pixels, one in each row."""
    return y.reshape(*y.shape[:-1], 2, 2)
