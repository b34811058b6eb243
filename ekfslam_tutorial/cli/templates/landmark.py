"""NewLandmark: a landmark type of your own. It works as it is (Euclidean points); make it yours.

What a landmark type must have, and the equation of each part:

    size                    how many numbers it takes in the map
    to_frame    l_F = ...   the landmark as seen from a frame F, and its Jacobians by F and by l
    from_frame  l = ...     the landmark given in F, in F's parent: the inverse of `to_frame`
    point       p = ...     its Euclidean point, and P_l = dp/dl
    ray         v = ...     the point up to a positive scale: what a camera needs, good at infinity too
    from_point, from_ray    birth in the sensor's frame, from what a sensor has measured; one of the two may be missing

`from_ray` takes a prior n of what a ray leaves open (an inverse distance) and must normalise the ray. States come as
rows (..., size), so one call serves many landmarks.
"""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class NewLandmark:
    """Say here what the numbers of the state are, with units.

    Parameters
    ----------
    dim : int
        2 in the plane, 3 in space.
    """

    dim: int = 3

    @property
    def size(self):
        """Length of the state."""
        return self.dim

    def to_frame(self, F, l):
        """The landmark in frame F: R' (l - t).

        Returns
        -------
        lf : ndarray, shape (..., size)
        LF_f : ndarray, shape (..., size, F.size)
        LF_l : ndarray, shape (..., size, size)
        """
        return F.to_frame(l)

    def from_frame(self, F, l):
        """The landmark of frame F in F's parent: R l + t. Returns l, L_f, L_lf."""
        return F.from_frame(l)

    def point(self, l):
        """Euclidean point. Returns p, P_l."""
        return l, np.eye(self.dim)

    def ray(self, l):
        """Point up to a positive scale. Returns v, V_l."""
        return l, np.eye(self.dim)

    def from_point(self, p):
        """Birth at a point. Returns l, L_p, and L_n, which has no columns: no prior is needed."""
        return p, np.eye(self.dim), np.zeros((self.dim, 0))
