"""Filters for the logs of notebook 21: EKF, invariant EKF, iterated EKF, first estimates.

All runs of a log see the same landmarks in the same frames, so every array carries the run as leading axis. The robot,
its noise and its way are in the notebook.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..analysis.consistency import md2
from ..geometry import wrap
from ..models.motion import Odometry2
from .museum import T, augment, correct, enlarge, innovation, join, observe, predict, start

TURN = np.array([[0.0, -1.0], [1.0, 0.0]])  # derivative of a rotation by its angle, at zero


# ---- the log -------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Log:
    """What the robots of R runs have measured in K steps.

    Attributes
    ----------
    first : ndarray, shape (3,)
        First pose: known, it is the origin of the map.
    u : ndarray, shape (R, K, 3)
        Odometry; `U` (3, 3) is its covariance.
    seen : list of K lists of int
        Landmarks in view after each step, by their number in the order of first sight.
    y : list of K arrays, shape (R, m, 2)
        Range and bearing of each; `S` (2, 2) is the covariance of one.
    truth : ndarray, shape (K, 3)
    points : ndarray, shape (N, 2)
        True landmarks, in the order of first sight.
    """

    first: np.ndarray
    u: np.ndarray
    U: np.ndarray
    seen: list
    y: list
    S: np.ndarray
    truth: np.ndarray
    points: np.ndarray

    @property
    def frames(self) -> int:
        """Number of steps K."""
        return len(self.truth)

    @property
    def runs(self) -> int:
        """Number of runs R."""
        return len(self.u)

    def one(self, run) -> Log:
        """One run alone, without the axis of runs: u (K, 3), y[k] (m, 2); or some, by a slice."""
        return replace(self, u=self.u[run], y=[y[run] for y in self.y])


@dataclass(frozen=True)
class Estimate:
    """The end of all runs: pose and map, shape (R, n), and the covariance (R, n, n); the poses on the way (R, K, 3)."""

    x: np.ndarray
    P: np.ndarray
    path: np.ndarray

    def errors(self, log: Log):
        """Estimate minus truth, the heading wrapped."""
        e = self.x - np.concatenate([log.truth[-1], log.points.ravel()])
        e[:, 2] = wrap(e[:, 2])
        return e

    def nees(self, log: Log):
        """Of pose and map together, one number for each run."""
        return md2(self.errors(log), self.P)

    def nees_heading(self, log: Log):
        """Of the heading alone."""
        return self.errors(log)[:, 2] ** 2 / self.P[:, 2, 2]

    def map_rmse(self, log: Log):
        """Error of the map, m, one number for each run."""
        e = self.errors(log)[:, 3:]
        return np.sqrt((e**2).sum(-1) * 2 / e.shape[-1])

    def path_rmse(self, log: Log):
        """Error of the positions on the way, m, one number for each run."""
        e = self.path[..., :2] - log.truth[:, :2]
        return np.sqrt((e**2).sum(-1).mean(-1))


# ---- filters -------------------------------------------------------------------------------------------------------


def lmk(i):
    """Range of landmark i."""
    return slice(3 + 2 * i, 5 + 2 * i)


def _filter(log, step, sights, born):
    """The loop of every filter: move, correct with known landmarks, start new ones."""
    R = log.runs
    x, P, path = np.tile(log.first, (R, 1)), np.zeros((R, 3, 3)), []
    for k in range(log.frames):
        x, P = step(x, P, log.u[:, k])
        n = (x.shape[-1] - 3) // 2
        old = [(i, log.y[k][:, j]) for j, i in enumerate(log.seen[k]) if i < n]
        if old:
            x, P = sights(x, P, old)
        for j, i in enumerate(log.seen[k]):
            if i >= n:
                x, P = born(x, P, log.y[k][:, j])
        x[:, 2] = wrap(x[:, 2])
        path.append(x[:, :3])
    return Estimate(x, P, np.stack(path, 1))


def ekf(log):
    """The filter of notebook 05: one landmark after the other."""

    def sights(x, P, old):
        """Correct with each landmark seen, one after the other."""
        for i, y in old:
            e, H = observe(x, lmk(i))
            x, P = correct(x, P, innovation(y, e), H @ P @ T(H) + log.S, H)
        return x, P

    return _filter(log, lambda x, P, u: predict(x, P, u, log.U), sights, lambda x, P, y: augment(x, P, y, log.S))


def invariant(log):
    """The EKF, and one line after each correction: notebook 08, and `options.error = "invariant"` of the toolbox."""

    def turning(x):
        """B = dx/dtheta: how all states change if the whole world turns about the origin, shape (R, n)."""
        B = np.ones_like(x)
        for r in (slice(0, 2), *(lmk(i) for i in range((x.shape[-1] - 3) // 2))):
            B[:, r] = x[:, r] @ TURN.T
        return B

    def sights(x, P, old):
        """Correct with each landmark seen, and carry the covariance along."""
        for i, y in old:
            e, H = observe(x, lmk(i))
            x2, P = correct(x, P, innovation(y, e), H @ P @ T(H) + log.S, H)
            D = np.zeros_like(P)
            D[:, :, 2] = turning(x2) - turning(x)
            x, P = x2, P + D @ P + P @ T(D) + D @ P @ T(D)
        return x, P

    return _filter(log, lambda x, P, u: predict(x, P, u, log.U), sights, lambda x, P, y: augment(x, P, y, log.S))


def stacked(x, old):
    """Expectations and Jacobians of several landmarks, one below the other."""
    parts = [observe(x, lmk(i)) for i, _ in old]
    return np.concatenate([e for e, _ in parts], -1), np.concatenate([H for _, H in parts], -2)


def iterated(log, iterations=4):
    """Iterated EKF: all landmarks of a frame at once, linearised again at the corrected state."""

    def sights(x, P, old):
        """Correct with all landmarks seen, again and again at the new estimate."""
        y = np.concatenate([y for _, y in old], -1)
        W, x0 = np.kron(np.eye(len(old)), log.S), x
        for _ in range(iterations):
            e, H = stacked(x, old)
            z = y - e
            z[:, 1::2] = wrap(z[:, 1::2])
            K = T(np.linalg.solve(H @ P @ T(H) + W, H @ P))
            x = x0 + (K @ (z - (H @ (x0 - x)[..., None])[..., 0])[..., None])[..., 0]
        return x, P - K @ (H @ P @ T(H) + W) @ T(K)

    return _filter(log, lambda x, P, u: predict(x, P, u, log.U), sights, lambda x, P, y: augment(x, P, y, log.S))


def first_estimates(log):
    """EKF whose Jacobians are taken at first estimates: notebook 08, and `Options.first_estimates` of the toolbox."""
    pose, lmks = [np.tile(log.first, (log.runs, 1))], []

    def step(x, P, u):
        """Move, with the Jacobian between first estimates."""
        x2, X_x, X_u = Odometry2().move(x[:, :3], u, 1.0)
        X_x = X_x.copy()
        X_x[:, :2, 2] = (x2[:, :2] - pose[0][:, :2]) @ TURN.T
        P = P.copy()
        P[:, :3] = X_x @ P[:, :3]
        P[:, :, :3] = P[:, :, :3] @ T(X_x)
        P[:, :3, :3] += X_u @ log.U @ T(X_u)
        pose[0] = x2
        return join(x2, x), P

    def sights(x, P, old):
        """Correct with Jacobians at the first estimates."""
        at = np.concatenate([pose[0], *lmks], -1)
        for i, y in old:
            H = observe(at, lmk(i))[1]
            x, P = correct(x, P, innovation(y, observe(x, lmk(i))[0]), H @ P @ T(H) + log.S, H)
        return x, P

    def born(x, P, y):
        """A new landmark, with the Jacobian at the first estimates."""
        l, L_r, L_y = start(x, y)
        L_r = L_r.copy()
        L_r[:, :, 2] = (l - pose[0][:, :2]) @ TURN.T
        lmks.append(l)
        P_lx = L_r @ P[:, :3]
        return enlarge(x, P, l, P_lx, P_lx[..., :3] @ T(L_r) + L_y @ log.S @ T(L_y))

    return _filter(log, step, sights, born)


FILTERS = {"iterated EKF": iterated, "first estimates": first_estimates, "invariant EKF": invariant}
"""What notebook 21 compares with the EKF of notebook 05, by name."""
