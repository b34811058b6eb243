"""One robot over a whole run: estimate, truth and dead reckoning, and what they differ by."""

from dataclasses import dataclass, replace

import numpy as np

from ..geometry import align


@dataclass(frozen=True)
class Track:
    """Poses of one robot in all frames.

    Parameters
    ----------
    id : int
    frame : type
        Frame2 or Frame3, with poses of size 3 or 7.
    t : ndarray, shape (F,)
        Seconds since the start.
    x : ndarray, shape (F, size)
        Estimates.
    P : ndarray, shape (F, size, size)
        Their covariances; zero where the pose is known.
    truth : ndarray, shape (F, size)
        True poses, NaN where not known.
    dead : ndarray, shape (F, size)
        Dead reckoning: poses by the controls alone, from the estimate of the first frame on.
    """

    id: int
    frame: type
    t: np.ndarray
    x: np.ndarray
    P: np.ndarray
    truth: np.ndarray
    dead: np.ndarray

    @property
    def known(self):
        """Frames (F,) whose true pose is known."""
        return np.isfinite(self.truth).all(axis=1)

    def positions(self, name):
        """Positions of 'x', 'truth' or 'dead' in the frames with known truth, shape (K, d), metres."""
        return getattr(self, name)[self.known, : self.frame.dim]

    def moved(self, F):
        """The same track after the alignment F, a frame: poses and covariances seen from F's parent."""
        G, _, G_x = F.compose(self.frame(self.x))
        P = G_x @ self.P @ np.swapaxes(G_x, -1, -2)
        return replace(self, x=G.x, P=P, dead=F.compose(self.frame(self.dead))[0].x)

    def errors(self, name="x"):
        """Errors of 'x' or 'dead' in the tangent space: [position; angle or angles], where the truth is known.

        Returns
        -------
        e : ndarray, shape (K, 3) or (K, 6)
            Metres and radians.
        P : ndarray, shape (K, 3, 3) or (K, 6, 6)
            What the covariance of the estimate says about them.
        """
        k = self.known
        e, E_x = self.frame(getattr(self, name)[k]).minus(self.frame(self.truth[k]))
        return e, E_x @ self.P[k] @ np.swapaxes(E_x, -1, -2)

    def aligned_dead(self):
        """The same track with its dead reckoning laid on the truth as well as it can be: no frame is given to it."""
        F = align(self.positions("dead"), self.positions("truth"))
        return replace(self, dead=F.compose(self.frame(self.dead))[0].x)


def rmse(e):
    """Root of the mean squared length of the rows of e; NaN for none."""
    return float(np.sqrt((e**2).sum(-1).mean())) if len(e) else float("nan")
