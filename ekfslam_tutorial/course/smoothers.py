"""The smoothers of notebook 21: a window of the last poses, all poses at once, and the matrices they solve."""

from __future__ import annotations

import numpy as np

from ..geometry import Frame2, wrap
from ..models.motion import Odometry2
from ..models.sensors.range_bearing import polar
from .estimators import Estimate, ekf, first_estimates, invariant, iterated
from .museum import T, innovation, start


class Window:
    """A smoother that keeps the last poses and all landmarks, and marginalises older poses.

    Parameters
    ----------
    log : Log
    lag : int
        Poses that stay in the state; 1 is a filter.
    iterations : int
        Gauss-Newton steps in each frame.
    """

    def __init__(self, log, lag, iterations=3):
        self.log, self.lag, self.iterations, self.Z = log, lag, iterations, np.linalg.inv(log.S)
        R = log.runs
        self.poses, self.l = np.zeros((R, 0, 3)), np.zeros((R, 0, 2))
        self.oldest = 0  # frame of the oldest pose in the window
        self.prior = None  # information matrix, vector and place of what is known of oldest pose and map

    def run(self):
        """Go through the log; return the estimate at the end."""
        left = []  # the poses, as they were when they left the window
        for k in range(self.log.frames):
            self.grow(k)
            for _ in range(self.iterations):
                self.step()
            while self.poses.shape[1] > self.lag:
                left.append(self.poses[:, 0])
                self.marginalise()
        return self.estimate(left)

    def estimate(self, left=()):
        """Last pose and map with their covariance; the path: the poses that left, then those in the window."""
        A, _ = self.normal_equations(range(self.oldest, self.log.frames))
        n, R = 3 * (self.poses.shape[1] - 1), self.log.runs
        x = np.concatenate([self.poses[:, -1], self.l.reshape(R, -1)], -1)
        path = np.concatenate([*(pose[:, None] for pose in left), self.poses], 1)
        return Estimate(x, np.linalg.inv(A)[:, n:, n:], path)

    def grow(self, k):
        """The next pose, by the odometry, and the landmarks that are new."""
        log = self.log
        last = self.poses[:, -1] if self.poses.shape[1] else np.tile(log.first, (log.runs, 1))
        pose = Odometry2().move(last, log.u[:, k], 1.0)[0]
        self.poses = np.concatenate([self.poses, pose[:, None]], 1)
        for j, i in enumerate(log.seen[k]):
            if i >= self.l.shape[1]:
                self.l = np.concatenate([self.l, start(pose, log.y[k][:, j])[0][:, None]], 1)

    def step(self):
        """One step of Gauss-Newton for all that is in the window."""
        A, g = self.normal_equations(range(self.oldest, self.oldest + self.poses.shape[1]))
        d = np.linalg.solve(A, g[..., None])[..., 0]
        n = 3 * self.poses.shape[1]
        self.poses = self.poses + d[:, :n].reshape(self.poses.shape)
        self.l = self.l + d[:, n:].reshape(self.l.shape)
        return d

    def normal_equations(self, frames, ahead=True):
        """J' W J and J' W z of the measurements of some frames and of the steps to them, and of the prior.

        With `ahead` false only the step *from* the oldest pose is taken: what is needed to marginalise it.
        """
        log, w = self.log, self.poses.shape[1]
        n = 3 * w + 2 * self.l.shape[1]
        A, g = np.zeros((log.runs, n, n)), np.zeros((log.runs, n))
        if self.prior is not None:
            A0, g0, x0 = self.prior
            at = np.r_[0:3, 3 * w : 3 * w + A0.shape[-1] - 3]
            x = np.concatenate([self.poses[:, 0], self.l.reshape(log.runs, -1)], -1)[:, : A0.shape[-1]]
            d = x0 - x
            d[:, 2] = wrap(d[:, 2])
            A[:, at[:, None], at] += A0
            g[:, at] += g0 + (A0 @ d[..., None])[..., 0]
        for k in frames:
            self._sights(A, g, k)
        first = 0 if self.oldest == 0 else self.oldest + 1  # the step to an older pose is in the prior
        for k in range(first, self.oldest + (w if ahead else 2)):
            self._odometry(A, g, k)
        return A, g

    def _odometry(self, A, g, k):
        """Factor of step k, in the frame of the robot before it: covariance U."""
        log, j = self.log, k - self.oldest
        before = Frame2(self.poses[:, j - 1] if j else np.tile(log.first, (log.runs, 1)))
        I, I_f = before.inverse()
        B, B_i, B_g = I.compose(Frame2(self.poses[:, j]))
        z = log.u[:, k] - B.x
        z[:, 2] = wrap(z[:, 2])
        _add(
            A,
            g,
            z,
            np.linalg.inv(log.U),
            [(slice(3 * j - 3, 3 * j), B_i @ I_f)] * (j > 0) + [(slice(3 * j, 3 * j + 3), B_g)],
        )

    def _sights(self, A, g, k):
        """Factors of all landmarks seen in frame k."""
        j, n = k - self.oldest, 3 * self.poses.shape[1]
        for i, y in zip(self.log.seen[k], np.moveaxis(self.log.y[k], 1, 0), strict=True):
            p, P_f, P_l = Frame2(self.poses[:, j]).to_frame(self.l[:, i])
            e, E_p = polar(p)
            blocks = [(slice(3 * j, 3 * j + 3), E_p @ P_f), (slice(n + 2 * i, n + 2 * i + 2), E_p @ P_l)]
            _add(A, g, innovation(y, e), self.Z, blocks)

    def marginalise(self):
        """Take the oldest pose out of the state; what it knew of the others stays, as a prior."""
        A, g = self.normal_equations([self.oldest], ahead=False)
        keep = np.r_[3:6, 3 * self.poses.shape[1] : A.shape[-1]]
        A_ba = A[:, :3, keep]
        S = T(np.linalg.solve(A[:, :3, :3], A_ba))
        x = np.concatenate([self.poses[:, 1], self.l.reshape(len(self.l), -1)], -1)
        self.prior = A[:, keep[:, None], keep] - S @ A_ba, g[:, keep] - (S @ g[:, :3, None])[..., 0], x
        self.poses, self.oldest = self.poses[:, 1:], self.oldest + 1


def _add(A, g, z, W, blocks):
    """Add a factor with the innovation z, its information W and its Jacobians to the normal equations."""
    for r, J in blocks:
        g[:, r] += (T(J) @ W @ z[..., None])[..., 0]
        for s, L in blocks:
            A[:, r, s] += T(J) @ W @ L


def batch(log, iterations=12):
    """All at once: start at the path and the map of the EKF, then Gauss-Newton with nothing marginalised."""
    w, start_at = Window(log, log.frames), ekf(log)
    for k in range(log.frames):
        w.grow(k)
    w.poses, w.l = start_at.path, start_at.x[:, 3:].reshape(log.runs, -1, 2)
    for _ in range(iterations):
        if np.abs(w.step()).max() < 1e-8:
            break
    return w.estimate()


METHODS = {"iterated EKF": iterated, "first estimates": first_estimates, "invariant EKF": invariant, "batch": batch}
"""What notebook 21 compares with the EKF of notebook 05, by name."""
