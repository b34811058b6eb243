"""Random numbers of a simulated run: one stream for each cause of chance."""

import numpy as np


def draw(rng, cov, shape=()):
    """Gaussian noise of zero mean.

    Parameters
    ----------
    rng : numpy.random.Generator
    cov : ndarray, shape (m, m)
        Symmetric positive semi-definite; zero variances are welcome.
    shape : tuple of int
        How many draws.

    Returns
    -------
    ndarray, shape (*shape, m)
        S times white noise. S is the symmetric square root of `cov`: unlike any other root it is unique, so the draws
        do not depend on the linear-algebra library.
    """
    variances, axes = np.linalg.eigh(cov)
    S = (axes * np.sqrt(variances.clip(0))) @ axes.T
    return rng.standard_normal((*shape, len(cov))) @ S


class Streams:
    """Independent generators for the world and for each robot's motion, each sensor's noise, clutter and descriptors.

    All come from one seed by `SeedSequence.spawn`. A robot or sensor is told apart by its id, not by its turn: adding
    a sensor, or turning one on, changes no other draw of the run.

    Parameters
    ----------
    seed : int
    """

    def __init__(self, seed):
        children = np.random.SeedSequence(seed).spawn(5)
        self._world, self._motion, self._sensing, self._clutter, self._looks = children
        self.world = np.random.default_rng(self._world)

    def motion(self, robot):
        """Noise of a robot's controls, and the error of its first pose."""
        return _child(self._motion, robot)

    def sensing(self, sensor):
        """Measurement noise of a sensor, and the error of its first calibration."""
        return _child(self._sensing, sensor)

    def clutter(self, sensor):
        """Missed and false measurements of a sensor."""
        return _child(self._clutter, sensor)

    def looks(self, sensor=None):
        """Random numbers for what landmarks look like; or for the noise of what a sensor sees of that."""
        return np.random.default_rng(self._looks) if sensor is None else _child(self._looks, sensor)


def _child(sequence, id):
    """The generator number `id` below a seed sequence, whichever were asked for before."""
    child = np.random.SeedSequence(sequence.entropy, spawn_key=(*sequence.spawn_key, id))
    return np.random.default_rng(child)
