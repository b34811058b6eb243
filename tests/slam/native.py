"""A second author of the invariant error: right-invariant filters in their own coordinates, which turn nothing.

Of the error of a pose and points they keep theta, the turn of the pose in the world, and xi = dp - theta x p of the
position and of every point. Motion leaves that error alone, F = I, and adds noise to all of it; what is measured does
not depend on theta at all. A. Barrau, S. Bonnabel, arXiv:1510.06263, section 4. The estimate is shifted in the
coordinates of the package, with the first order of the group's exponential.

Nothing of the package is used here.
"""

import numpy as np

J = np.array([[0.0, -1.0], [1.0, 0.0]])


def hat(v):
    """[v]x."""
    x, y, z = v
    return np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])


def rotation(q):
    """Of a unit quaternion [w, x, y, z]."""
    return np.eye(3) + 2 * q[0] * hat(q[1:]) + 2 * hat(q[1:]) @ hat(q[1:])


def product(p, q):
    """Of quaternions."""
    return np.concatenate([[p[0] * q[0] - p[1:] @ q[1:]], p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:])])


def left_jacobian(v):
    """Of SO(3): Exp(v + dv) = Exp(J_l dv) Exp(v)."""
    a = np.linalg.norm(v)
    if a < 1e-9:
        return np.eye(3) + hat(v) / 2
    return np.eye(3) + (1 - np.cos(a)) / a**2 * hat(v) + (a - np.sin(a)) / a**3 * hat(v) @ hat(v)


class Native:
    """What both dimensions share; the error is [theta, xi of the position, xi of each point].

    Parameters
    ----------
    x, P : ndarray
        Pose and its covariance, in the coordinates of the package: [p, heading] or [p, quaternion].
    """

    def __init__(self, x, P):
        self.p, self.o, self.points, self.ids = np.array(x[: self.d]), np.array(x[self.d :]), {}, []
        A = np.linalg.pinv(self.to_package())
        self.P = A @ P @ A.T

    def cross(self, p):
        """Derivative of a point by a turn of the world."""
        return J @ p[:, None] if self.d == 2 else -hat(p)

    def at(self, id):
        """Where the point with this id stands in the error."""
        start = self.k + self.d * (1 + self.ids.index(id))
        return slice(start, start + self.d)

    def to_package(self):
        """Derivative of the state of the package, [p, o, l1, l2, ...], by the error."""
        n, k, d = self.k + self.d * (1 + len(self.ids)), self.k, self.d
        A = np.zeros((n - k + len(self.o), n))
        A[:d, :k], A[:d, k : k + d], A[d : d + len(self.o), :k] = self.cross(self.p), np.eye(d), self.turned()
        for i, id in enumerate(self.ids):
            row, column = d + len(self.o) + d * i, k + d * (1 + i)
            A[row : row + d, :k], A[row : row + d, column : column + d] = self.cross(self.points[id]), np.eye(d)
        return A

    @property
    def x(self):
        """State of the package."""
        return np.concatenate([self.p, self.o, *(self.points[id] for id in self.ids)])

    def noise(self, turn, step, U):
        """Add the noise of a motion to the error of everything: by theta all that is known goes round the origin."""
        G = np.zeros((len(self.P), len(U)))
        G[: self.k], G[self.k : self.k + self.d] = turn, step - self.cross(self.p) @ turn
        for id in self.ids:
            G[self.at(id)] = -self.cross(self.points[id]) @ turn
        self.P = self.P + G @ U @ G.T

    def look(self, sightings, R):
        """Correct by known points at once: (id, innovation, derivative of the measurement by the point)."""
        if not sightings:
            return
        H, m = np.zeros((len(R) * len(sightings), len(self.P))), len(R)
        for i, (id, _, D) in enumerate(sightings):
            H[m * i : m * i + m, self.k : self.k + self.d], H[m * i : m * i + m, self.at(id)] = -D, D
        z = np.concatenate([z for _, z, _ in sightings])
        Z = H @ self.P @ H.T + np.kron(np.eye(len(sightings)), R)
        K = np.linalg.solve(Z, H @ self.P).T
        dx = self.to_package() @ (K @ z)
        self.P = self.P - K @ Z @ K.T
        self.p, self.o = self.p + dx[: self.d], self.o + dx[self.d : self.d + len(self.o)]
        if self.d == 3:
            self.o = self.o / np.linalg.norm(self.o)
        for i, id in enumerate(self.ids):
            start = self.d + len(self.o) + self.d * i
            self.points[id] = self.points[id] + dx[start : start + self.d]

    def start(self, id, l, D, R):
        """A new point l, measured with the noise R; D is the derivative of the point by the measurement."""
        n = len(self.P)
        self.ids, self.points[id] = [*self.ids, id], l
        L = np.vstack([np.eye(n), np.eye(n)[self.k : self.k + self.d]])  # its xi is that of the position
        self.P = L @ self.P @ L.T
        self.P[n:, n:] += D @ R @ D.T


class Plane(Native):
    """Odometry, and a sensor of range and bearing in the middle of the robot."""

    d, k = 2, 1

    def turned(self):
        return np.eye(1)

    @property
    def R(self):
        c, s = np.cos(self.o[0]), np.sin(self.o[0])
        return np.array([[c, -s], [s, c]])

    def move(self, u, U):
        step = np.concatenate([self.R, np.zeros((2, 1))], 1)
        self.p, self.o = self.p + self.R @ u[:2], self.o + u[2:]
        self.noise(np.eye(3)[2:], step, U)

    def see(self, id, y):
        c = self.R.T @ (self.points[id] - self.p)
        r = np.hypot(*c)
        z = y - [r, np.arctan2(c[1], c[0])]
        z[1] = (z[1] + np.pi) % (2 * np.pi) - np.pi
        return id, z, np.array([c / r, [-c[1] / r**2, c[0] / r**2]]) @ self.R.T

    def born(self, id, y, R):
        c, s = np.cos(y[1]), np.sin(y[1])
        D = self.R @ np.array([[c, -y[0] * s], [s, y[0] * c]])
        self.start(id, self.p + self.R @ (y[0] * np.array([c, s])), D, R)


class Space(Native):
    """Odometry, and a sensor of points [x, y, z] in the middle of the robot."""

    d, k = 3, 3

    def turned(self):
        w, x, y, z = self.o
        return 0.5 * np.array([[-x, -y, -z], [w, z, -y], [-z, w, x], [y, -x, w]])

    @property
    def R(self):
        return rotation(self.o)

    def move(self, u, U):
        v, a = u[3:], np.linalg.norm(u[3:])
        R, turn = self.R, self.R @ left_jacobian(v)
        self.p = self.p + R @ u[:3]
        self.o = product(self.o, np.concatenate([[np.cos(a / 2)], np.sinc(a / 2 / np.pi) / 2 * v]))
        self.noise(np.concatenate([np.zeros((3, 3)), turn], 1), np.concatenate([R, np.zeros((3, 3))], 1), U)

    def see(self, id, y):
        return id, y - self.R.T @ (self.points[id] - self.p), self.R.T

    def born(self, id, y, R):
        self.start(id, self.p + self.R @ y, self.R, R)
