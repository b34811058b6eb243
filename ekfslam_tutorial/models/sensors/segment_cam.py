"""Camera that measures straight edges: the two end points of a segment, of a line that may go on beyond them."""

from dataclasses import dataclass, field
from functools import cached_property
from typing import ClassVar

import numpy as np

from .imager import Imager
from .parameters import check_positive
from .pin_hole import PinHole, pixellise, project

SAMPLES = 65
"""Points of an edge at which a lens with distortion is asked whether it sees them."""


@dataclass(frozen=True)
class SegmentCam(Imager):
    """Pin-hole camera for lines: measures the end points y = [u1, v1, u2, v2] of a segment of its image, pixels.

    Where a segment ends says little: the edge of a door may end there, or a shadow. So the ends are not compared with
    expected ones. What is expected is the image of the line, a u + b v + c = 0, e = [a, b, c] with a^2 + b^2 = 1, and
    the innovation are the distances of both ends from it, with signs:

        z_i = [u_i, v_i, 1] e / |[a, b]|

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
        v1, V_1 = self.camera.retro(y[..., :2])
        v2, V_2 = self.camera.retro(y[..., 2:])
        v = np.concatenate([v1, v2], -1)
        V_y = np.zeros_like(v, shape=(*v.shape, 4))
        V_y[..., :3, :2], V_y[..., 3:, 2:] = V_1, V_2
        return v, V_y

    def innovation(self, y, e):
        """Distances of both end points from an expected line, pixels of the ideal image. Returns z, Z_y, Z_e.

        The innovation has the covariance Z_e E Z_e' + Z_y R Z_y'.
        """
        ends, zero = self.retro(y), np.zeros_like(e, shape=(*e.shape[:-1], 1, 2))
        length = np.hypot(e[..., :1], e[..., 1:2])
        u = e / length
        A = np.concatenate([u[..., :2], 0 * length], -1)  # d |[a, b]| / de
        z, Z_y, Z_e = [], [], []
        for i in (0, 1):
            v, V_y = ends[0][..., 3 * i : 3 * i + 3], ends[1][..., 3 * i : 3 * i + 2, 2 * i : 2 * i + 2]
            q, Q_v, _ = pixellise(v[..., :2], self.k)
            z.append((q * u[..., :2]).sum(-1) + u[..., 2])
            Z_q = u[..., None, :2] @ Q_v @ V_y
            Z_y.append(np.concatenate([Z_q, zero] if i == 0 else [zero, Z_q], -1))
            q1 = np.concatenate([q, np.ones_like(q[..., :1])], -1)
            Z_e.append((q1 - z[-1][..., None] * A) / length)
        return np.stack(z, -1), np.concatenate(Z_y, -2), np.stack(Z_e, -2)

    def residual(self, y, e):
        """Innovation: the two distances."""
        return self.innovation(y, e)[0]

    def visible(self, e, p):
        """Return True for each line of which enough is in the image: p are its ends [p1; p2] in the camera's frame."""
        return self.segments(p)[1]

    def segments(self, p):
        """Images of the parts that are seen of edges [p1; p2]. Returns y (..., 4), and which are long enough."""
        a, b = p[..., :3], p[..., 3:]
        s = self._stretch(a, b - a)
        with np.errstate(all="ignore"):
            q = a[..., None, :] + s[..., None] * (b - a)[..., None, :]
            y, ideal = self.camera.project(q)[0], project(q)[0] * np.asarray(self.k[2:])
            length = np.linalg.norm(ideal[..., 1, :] - ideal[..., 0, :], axis=-1)
        return y.reshape(*y.shape[:-2], 4), (s[..., 0] < s[..., 1]) & (length >= self.min_length)

    def _stretch(self, a, way):
        """First and last s of the points a + s way that the camera sees, 0 <= s <= 1; the last is less if none are."""
        with np.errstate(all="ignore"):
            at, slope = a @ self._walls.T, way @ self._walls.T  # inside where at + s slope >= 0
            cut = -at / slope
            first = np.where(slope > 0, cut, np.where((slope == 0) & (at < 0), np.inf, 0)).max(-1, initial=0.0)
            last = np.where(slope < 0, cut, 1.0).min(-1, initial=1.0)
            if len(self.d):
                first, last = self._through_lens(a, way, first, last)
        return np.stack([first, last], -1)

    def _through_lens(self, a, way, first, last):
        """The stretch between s = first and last that is in the image of a lens: sampled, its ends then halved down."""
        sees = lambda s: self.camera.visible(self.camera.project(q := a + s[..., None] * way)[0], q)
        s = first + np.linspace(0, 1, SAMPLES).reshape(-1, *[1] * first.ndim) * (last - first)
        seen, ends = sees(s), []
        for k, step in ((seen.argmax(0), -1), (SAMPLES - 1 - seen[::-1].argmax(0), 1)):
            good, bad = (np.take_along_axis(s, np.clip(m, 0, SAMPLES - 1)[None], 0)[0] for m in (k, k + step))
            for _ in range(40 if (good != bad).any() else 0):
                middle = (good + bad) / 2
                ok = sees(middle)
                good, bad = np.where(ok, middle, good), np.where(ok, bad, middle)
            ends.append(good)
        return ends[0], np.where(seen.any(0), ends[1], -np.inf)

    @cached_property
    def _walls(self):
        """Normals, pointing inwards, of the planes that bound what can be in the image."""
        w, h = np.subtract(self.image_size, self.margin)
        m, n = self.margin, np.linspace(0, 1, 33)[:, None]
        corners = np.array([[m, m], [w, m], [w, h], [m, h], [m, m]])
        border = np.concatenate([p + n * (q - p) for p, q in zip(corners[:-1], corners[1:], strict=True)])
        rays = self.camera.retro(border)[0][:, :2]
        if np.isfinite(rays).all():
            (x0, y0), (x1, y1) = rays.min(0), rays.max(0)
        else:
            x1 = y1 = self.camera.fold
            x0 = y0 = -x1
        return np.array([[1, 0, -x0], [-1, 0, x1], [0, 1, -y0], [0, -1, y1], [0, 0, 1]], float)
