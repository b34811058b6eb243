"""EKF-SLAM in the plane as textbooks write it: one dense state, full matrices, formulas by hand.

Nothing of the package is used, so it is a second view of models, filter and augmentation at once. State: the robot
[x, y, theta] if it is estimated, then landmarks [x, y] in the order of their birth.
"""

import numpy as np


def wrap(a):
    return np.arctan2(np.sin(a), np.cos(a))


class Textbook:
    """The dense filter: x = f(x, u), K = P H' (H P H' + R)^-1, P = (I - K H) P, and np.block for a new state."""

    def __init__(self, x, P):
        self.x, self.P = np.array(x, float), np.array(P, float)

    def predict(self, x, F, Q):
        self.x, self.P = x, F @ self.P @ F.T + Q

    def correct(self, z, H, R):
        Z = H @ self.P @ H.T + R
        K = self.P @ H.T @ np.linalg.inv(Z)
        self.x = self.x + K @ z
        self.P = (np.eye(len(self.x)) - K @ H) @ self.P

    def augment(self, l, G, Q):
        """P_new = [[P, P G'], [G P, G P G' + Q]]."""
        P, GP = self.P, G @ self.P
        self.x = np.append(self.x, l)
        self.P = np.block([[P, GP.T], [GP, GP @ G.T + Q]])


def odometry(pose, u):
    """x2 = x + R(theta) d, theta2 = theta + a, with F = d x2/d x and G = d x2/d u."""
    x, y, t = pose
    c, s = np.cos(t), np.sin(t)
    dx, dy, a = u
    x2 = np.array([x + c * dx - s * dy, y + s * dx + c * dy, t + a])
    F = np.array([[1, 0, -s * dx - c * dy], [0, 1, c * dx - s * dy], [0, 0, 1]])
    G = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    return x2, F, G


def range_bearing(pose, l):
    """h = [r, atan2(dy, dx) - theta], with its derivatives by pose and landmark."""
    dx, dy = l - pose[:2]
    q = dx * dx + dy * dy
    r = np.sqrt(q)
    H_r = np.array([[-dx / r, -dy / r, 0], [dy / q, -dx / q, -1]])
    H_l = np.array([[dx / r, dy / r], [-dy / q, dx / q]])
    return np.array([r, wrap(np.arctan2(dy, dx) - pose[2])]), H_r, H_l


def inverse_range_bearing(pose, y):
    """l = p + r [cos(theta + b), sin(theta + b)], with its derivatives by pose and measurement."""
    r, a = y[0], pose[2] + y[1]
    c, s = np.cos(a), np.sin(a)
    G_r = np.array([[1, 0, -r * s], [0, 1, r * c]])
    G_y = np.array([[c, -r * s], [s, r * c]])
    return pose[:2] + r * np.array([c, s]), G_r, G_y


class Slam2:
    """Mapping, localisation and SLAM on a dense filter.

    Parameters
    ----------
    make : callable
        Dense filter from x and P: `Textbook`, or one that wraps another library.
    pose, P : ndarray
        Robot; P None where its pose is known.
    known : dict of int to ndarray
        Landmarks that are known, by id.
    """

    def __init__(self, make, pose, P=None, known=None):
        self.pose = None if P is not None else np.array(pose)
        self.filter = make(pose, P) if P is not None else make(np.zeros(0), np.zeros((0, 0)))
        self.known = known or {}
        self.at = {}

    @property
    def robot(self):
        return self.filter.x[:3] if self.pose is None else self.pose

    def move(self, u, U):
        x2, F_r, G = odometry(self.robot, u)
        x2[2] = wrap(x2[2])
        if self.pose is not None:
            self.pose = x2
            return
        n = len(self.filter.x)
        x, F, Q = self.filter.x.copy(), np.eye(n), np.zeros((n, n))
        x[:3], F[:3, :3], Q[:3, :3] = x2, F_r, G @ U @ G.T
        self.filter.predict(x, F, Q)

    def correct(self, id, y, R):
        l = self.known[id] if id in self.known else self.filter.x[self.at[id]]
        e, H_r, H_l = range_bearing(self.robot, l)
        H = np.zeros((2, len(self.filter.x)))
        if self.pose is None:
            H[:, :3] = H_r
        if id in self.at:
            H[:, self.at[id]] = H_l
        z = y - e
        z[1] = wrap(z[1])
        self.filter.correct(z, H, R)
        if self.pose is None:
            self.filter.x[2] = wrap(self.filter.x[2])

    def start(self, id, y, R):
        l, G_r, G_y = inverse_range_bearing(self.robot, y)
        n = len(self.filter.x)
        G = np.zeros((2, n))
        if self.pose is None:
            G[:, :3] = G_r
        self.filter.augment(l, G, G_y @ R @ G_y.T)
        self.at[id] = slice(n, n + 2)
