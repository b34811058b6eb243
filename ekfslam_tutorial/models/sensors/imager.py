"""What cameras with an image share."""

import numpy as np

from .parameters import check_positive, finite_numbers


class Imager:
    """A camera with an image of a given size.

    See Also
    --------
    PinHole, OmniCam : Cameras with one.
    """

    image_size: tuple
    pixel_std: float

    def check_image(self):
        """Refuse an image without pixels and noise that is not positive."""
        if not (finite_numbers(self, "image_size", 2) > 0).all():
            raise ValueError(f"{type(self).__name__}: image_size must be two positive numbers, got {self.image_size!r}")
        check_positive(self, "pixel_std")

    def inside(self, u):
        """Return True for pixels in the image, borders included."""
        u, v = u[..., 0], u[..., 1]
        return (u >= 0) & (v >= 0) & (u <= self.image_size[0]) & (v <= self.image_size[1])

    def residual(self, y, e):
        """Innovation y - e, pixels."""
        return np.subtract(y, e)
