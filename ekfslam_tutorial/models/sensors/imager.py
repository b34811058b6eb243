"""What cameras with an image share."""

from functools import cached_property

import numpy as np

from .parameters import check_positive, finite_numbers


class Imager:
    """A camera with an image of a given size.

    See Also
    --------
    PinHole, OmniCam : Cameras with one.
    """

    k: tuple
    image_size: tuple
    pixel_std: float
    margin: float

    @cached_property
    def R(self):
        """Measurement noise covariance of a pixel [u, v], pixel_std^2 I."""
        return self.pixel_std**2 * np.eye(2)

    def check_image(self):
        """Refuse an image without pixels, noise that is not positive, and a margin that leaves nothing."""
        if not (finite_numbers(self, "image_size", 2) > 0).all():
            raise ValueError(f"{type(self).__name__}: image_size must be two positive numbers, got {self.image_size!r}")
        check_positive(self, "pixel_std")
        if not -np.inf < self.margin < min(self.image_size) / 2:
            half = min(self.image_size) / 2
            raise ValueError(
                f"{type(self).__name__}: margin must be less than {half:g}, half of the image, got {self.margin!r}"
            )

    def check_intrinsics(self):
        """Refuse intrinsic parameters [u0, v0, au, av] that have no inverse."""
        k = finite_numbers(self, "k", 4)
        if k[2] == 0 or k[3] == 0:
            raise ValueError(
                f"{type(self).__name__}: k = [u0, v0, au, av] is singular, au and av must not be zero, got {self.k!r}"
            )

    def inside(self, u):
        """Return True for pixels in the image and not in its margin, borders included."""
        u, v, m = u[..., 0], u[..., 1], self.margin
        return (u >= m) & (v >= m) & (u <= self.image_size[0] - m) & (v <= self.image_size[1] - m)

    def residual(self, y, e):
        """Innovation y - e, pixels."""
        return np.subtract(y, e)
