"""A plain textbook EKF-SLAM: dense matrices, formulas by hand, nothing clever. What every variant must agree with.

x = f(x, u),   P = F P F' + G U G'
K = P H' (H P H' + R)^-1,   x = x + K z,   P = (I - K H) P
"""

import numpy as np

from .world import R, U, wrap


def odometry(pose, u):
    """x2 = x + R(theta) [dx, dy], theta2 = theta + dtheta; with F = d x2/d x and G = d x2/d u."""
    (x, y, t), (dx, dy, a) = pose, u
    c, s = np.cos(t), np.sin(t)
    F = np.array([[1, 0, -s * dx - c * dy], [0, 1, c * dx - s * dy], [0, 0, 1]])
    G = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    return np.array([x + c * dx - s * dy, y + s * dx + c * dy, wrap(t + a)]), F, G


def range_bearing(pose, l):
    """h = [range, bearing] of a landmark, with its derivatives by pose and landmark."""
    dx, dy = l - pose[:2]
    q = dx * dx + dy * dy
    r = np.sqrt(q)
    H_r = np.array([[-dx / r, -dy / r, 0], [dy / q, -dx / q, -1]])
    H_l = np.array([[dx / r, dy / r], [-dy / q, dx / q]])
    return np.array([r, wrap(np.arctan2(dy, dx) - pose[2])]), H_r, H_l


def inverse_range_bearing(pose, y):
    """l = p + r [cos, sin](theta + bearing), with its derivatives by pose and measurement."""
    r, a = y[0], pose[2] + y[1]
    c, s = np.cos(a), np.sin(a)
    return (
        pose[:2] + r * np.array([c, s]),
        np.array([[1, 0, -r * s], [0, 1, r * c]]),
        np.array([[c, -r * s], [s, r * c]]),
    )


class Oracle:
    """The dense filter on a world. `at` says where a landmark is in the state.

    Parameters
    ----------
    world : World
    joint : bool
        All measurements of a step stacked in one correction; else one after another, each linearised anew.
    uncertain_first : bool
        One after another in the order of decreasing det(H P H'), taken before the first of them.
    """

    def __init__(self, world, joint, uncertain_first=False):
        self.world, self.joint, self.uncertain_first = world, joint, uncertain_first
        self.x, self.P = world.x0.copy(), world.P0.copy()
        self.at = {i: slice(3 + 2 * i, 5 + 2 * i) for i in range((len(self.x) - 3) // 2)}

    def step(self, k):
        """Move, correct with what is in the map, then start the landmarks that are new."""
        step = self.world.steps[k % len(self.world.steps)]
        x2, F_r, G = odometry(self.x[:3], step.u)
        F, Q = np.eye(len(self.x)), np.zeros_like(self.P)
        F[:3, :3], Q[:3, :3] = F_r, G @ U @ G.T
        self.x[:3], self.P = x2, F @ self.P @ F.T + Q

        seen = [(i, y) for i, y in zip(step.ids, step.y, strict=True) if i in self.at]
        new = [(i, y) for i, y in zip(step.ids, step.y, strict=True) if i not in self.at]
        if self.joint:
            self.correct(seen)
        else:
            for one in self.ordered(seen):
                self.correct([one])
        for i, y in new:
            self.start(i, y)

    def ordered(self, seen):
        """The measurements in the order in which they are used."""
        if not self.uncertain_first:
            return seen
        sizes = []
        for one in seen:
            _, H = self.linearised([one])
            sizes.append(np.linalg.det(H @ self.P @ H.T))
        return [seen[i] for i in np.argsort(-np.array(sizes), kind="stable")]

    def linearised(self, seen):
        """Innovation z and dense Jacobian H of measurements, stacked."""
        z, H = np.zeros(2 * len(seen)), np.zeros((2 * len(seen), len(self.x)))
        for k, (i, y) in enumerate(seen):
            rows = slice(2 * k, 2 * k + 2)
            e, H[rows, :3], H[rows, self.at[i]] = range_bearing(self.x[:3], self.x[self.at[i]])
            z[rows] = y - e
            z[2 * k + 1] = wrap(z[2 * k + 1])
        return z, H

    def correct(self, seen):
        """One correction with all these measurements."""
        if seen:
            z, H = self.linearised(seen)
            self.apply(z, H, np.kron(np.eye(len(seen)), R))

    def apply(self, z, H, R):
        """The equations of the Kalman filter."""
        K = self.P @ H.T @ np.linalg.inv(H @ self.P @ H.T + R)
        self.x = self.x + K @ z
        self.P = (np.eye(len(self.x)) - K @ H) @ self.P
        self.x[2] = wrap(self.x[2])

    def start(self, i, y):
        """A new landmark: P_new = [[P, P G'], [G P, G P G' + L_y R L_y']]."""
        l, L_r, L_y = inverse_range_bearing(self.x[:3], y)
        n = len(self.x)
        G = np.zeros((2, n))
        G[:, :3] = L_r
        GP = G @ self.P
        self.x = np.append(self.x, l)
        self.P = np.block([[self.P, GP.T], [GP, GP @ G.T + L_y @ R @ L_y.T]])
        self.at[i] = slice(n, n + 2)


class GivenOracle(Oracle):
    """The same equations where the models are not asked: innovations and Jacobians come from a list (`given.py`)."""

    def __init__(self, world, given, joint):
        super().__init__(world, joint)
        self.given = given

    def step(self, k):
        """One step with given blocks."""
        g, n = self.given[k % len(self.given)], len(self.x)
        F, Q = np.eye(n), np.zeros((n, n))
        F[:3, :3], Q[:3, :3] = g.X_x, g.X_u @ U @ g.X_u.T
        self.x[:3], self.P = g.x, F @ self.P @ F.T + Q
        H = np.zeros((len(g.ids), 2, n))
        for i, id in enumerate(g.ids):
            H[i, :, :3], H[i, :, self.at[id]] = g.H_r[i], g.H_l[i]
        if self.joint:
            self.add(H.reshape(-1, n), g.z.ravel(), np.kron(np.eye(len(H)), R))
        else:
            for H_i, z_i in zip(H, g.z, strict=True):
                self.add(H_i, z_i, R)

    def add(self, H, z, R):
        """One correction; the heading is not wrapped, nothing asks for it."""
        K = self.P @ H.T @ np.linalg.inv(H @ self.P @ H.T + R)
        self.x = self.x + K @ z
        self.P = (np.eye(len(self.x)) - K @ H) @ self.P
