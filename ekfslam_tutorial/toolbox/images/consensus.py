"""1-point RANSAC: which matches of a frame agree with each other, by what they have in common in the map.

J. Civera, O. G. Grasa, A. J. Davison, J. M. M. Montiel, "1-Point RANSAC for extended Kalman filtering", J. Field
Robotics 27(5), 2010; here the hypotheses are linear, and each match is one.
"""

import numpy as np

from ...ekf import covariance, cross


class Consensus:
    """Expectations of one frame with their joint covariance, and what follows for the others from some of them.

    Parameters
    ----------
    map : Map
    obs : list of Obs
        K of them, of measurements with m numbers.
    z : ndarray, shape (K, m)
        Innovations.
    R : ndarray, shape (m, m)
        Noise of each.
    """

    def __init__(self, map, obs, z, R):
        K, m = z.shape
        PHt = np.hstack([cross(map, o.blocks) for o in obs])
        self.E = np.vstack([covariance(PHt, o.blocks) for o in obs]).reshape(K, m, K, m)  # H_i P H_j'
        self.z, self.R = z, R

    def agreeing(self, pixels):
        """The largest set of matches that one of them explains.

        Match i moves all expectations by E_ji S_i^-1 z_i, S_i = E_ii + R; those that are then nearer than so many
        pixels to what was measured agree with it.

        Returns
        -------
        ndarray of bool, shape (K,)
        """
        i = np.arange(len(self.z))
        w = np.linalg.solve(self.E[i, :, i] + self.R, self.z[:, :, None])[..., 0]
        left = self.z - np.einsum("jaib,ib->ija", self.E, w)
        agree = (left * left).sum(-1) < pixels**2
        return agree[agree.sum(1).argmax()]

    def given(self, some):
        """Innovations and their covariances of the others, once the map is corrected by some matches.

        Parameters
        ----------
        some : ndarray of bool, shape (K,)

        Returns
        -------
        z : ndarray, shape (k, m)
        Z : ndarray, shape (k, m, m)
        """
        K, m = self.z.shape
        flat = lambda rows, columns: self.E[rows][:, :, columns].reshape(rows.sum() * m, columns.sum() * m)
        S = flat(some, some) + np.kron(np.eye(some.sum()), self.R)
        G = np.linalg.solve(S, flat(some, ~some)).T
        z = self.z[~some] - (G @ self.z[some].ravel()).reshape(-1, m)
        E = (flat(~some, ~some) - G @ flat(some, ~some)).reshape(K - some.sum(), m, K - some.sum(), m)
        i = np.arange(len(z))
        return z, E[i, :, i] + self.R
