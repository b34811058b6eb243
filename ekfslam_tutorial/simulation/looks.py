"""What landmarks look like: a descriptor of each, and how sensors measure it."""

import numpy as np


class Looks:
    """True descriptors of landmarks, and noisy ones of their measurements.

        d = d_true + std w,    w white noise, d_true white noise of its own

    Two landmarks are sqrt(2 n) apart in the mean, two measurements of one landmark std sqrt(2 n): n numbers each.

    Parameters
    ----------
    ids : ndarray of int, shape (N,)
        Of all landmarks.
    size : int
        n.
    std : float
        Noise of each number.
    rng, noise : numpy.random.Generator
        What draws the landmarks' looks, the same for all sensors; and what draws the noise.
    """

    def __init__(self, ids, size, std, rng, noise):
        self._true = dict(zip(ids.tolist(), rng.standard_normal((len(ids), size)), strict=True))
        self._size, self._std, self._noise = size, std, noise

    def of(self, ids):
        """Descriptors of measurements of some landmarks, shape (k, n); what is none (-1) looks like nothing else."""
        own = [self._true[i] if i in self._true else self._noise.standard_normal(self._size) for i in ids.tolist()]
        noise = self._noise.standard_normal((len(ids), self._size))
        return np.reshape(own, (-1, self._size)) + self._std * noise
