"""Angles live on a circle: the one place where that is taken care of."""

import numpy as np


def wrap(angle):
    """Bring angles into the half-open interval (-pi, pi].

    Parameters
    ----------
    angle : array_like
        Angles of any shape, radians.

    Returns
    -------
    ndarray or float
        The same directions in (-pi, pi], radians.

    See Also
    --------
    Frame2.normalized : The same for the heading of a frame.

    Examples
    --------
    >>> float(wrap(3 * np.pi))
    3.141592653589793
    """
    return np.pi - np.subtract(np.pi, angle) % (2 * np.pi)
