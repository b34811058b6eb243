"""A filter in plain loops, compiled by numba: what a compiler makes of the textbook, models included; two ways."""

import numpy as np
from numba import njit

from ..world import R, U


@njit(cache=True, fastmath=False)
def wrap(a):
    return (a + np.pi) % (2 * np.pi) - np.pi


@njit(cache=True)
def predict(x, P, u, U):
    n = len(x)
    c, s = np.cos(x[2]), np.sin(x[2])
    a, b = -s * u[0] - c * u[1], c * u[0] - s * u[1]
    x[0] += c * u[0] - s * u[1]
    x[1] += s * u[0] + c * u[1]
    x[2] = wrap(x[2] + u[2])
    for j in range(n):  # rows of F P
        P[0, j] += a * P[2, j]
        P[1, j] += b * P[2, j]
    for j in range(n):  # columns of (F P) F'
        P[j, 0] += a * P[j, 2]
        P[j, 1] += b * P[j, 2]
    P[0, 0] += c * c * U[0, 0] + s * s * U[1, 1]
    P[1, 1] += s * s * U[0, 0] + c * c * U[1, 1]
    P[0, 1] += c * s * (U[0, 0] - U[1, 1])
    P[1, 0] += c * s * (U[0, 0] - U[1, 1])
    P[2, 2] += U[2, 2]


@njit(cache=True)
def correct(x, P, W, i, y, R):
    n, l = len(x), 3 + 2 * i
    dx, dy = x[l] - x[0], x[l + 1] - x[1]
    q = dx * dx + dy * dy
    r = np.sqrt(q)
    z0, z1 = y[0] - r, wrap(y[1] - np.arctan2(dy, dx) + x[2])
    for j in range(n):  # P H'
        a, b = P[l, j] - P[0, j], P[l + 1, j] - P[1, j]
        W[0, j] = (dx * a + dy * b) / r
        W[1, j] = (dx * b - dy * a) / q - P[2, j]
    a, b = W[0, l] - W[0, 0], W[0, l + 1] - W[0, 1]
    Z00, Z10 = (dx * a + dy * b) / r + R[0, 0], (dx * b - dy * a) / q - W[0, 2]
    a, b = W[1, l] - W[1, 0], W[1, l + 1] - W[1, 1]
    Z11 = (dx * b - dy * a) / q - W[1, 2] + R[1, 1]
    L00 = np.sqrt(Z00)
    L10 = Z10 / L00
    L11 = np.sqrt(Z11 - L10 * L10)
    w0 = z0 / L00
    w1 = (z1 - L10 * w0) / L11
    for j in range(n):  # W = P H' L^-T
        W[0, j] /= L00
        W[1, j] = (W[1, j] - L10 * W[0, j]) / L11
        x[j] += W[0, j] * w0 + W[1, j] * w1
    for k in range(n):
        a, b = W[0, k], W[1, k]
        for j in range(n):
            P[k, j] -= a * W[0, j] + b * W[1, j]
    x[2] = wrap(x[2])


@njit(cache=True)
def step(x, P, W, u, U, ids, y, R):
    predict(x, P, u, U)
    for k in range(len(ids)):
        correct(x, P, W, ids[k], y[k], R)


@njit(cache=True)
def correct_jointly(x, P, W, Z, z, H, ids, y, R):
    n, m = len(x), len(ids)
    for k in range(m):
        l = 3 + 2 * ids[k]
        dx, dy = x[l] - x[0], x[l + 1] - x[1]
        q = dx * dx + dy * dy
        r = np.sqrt(q)
        z[2 * k], z[2 * k + 1] = y[k, 0] - r, wrap(y[k, 1] - np.arctan2(dy, dx) + x[2])
        H[k, 0], H[k, 1], H[k, 2], H[k, 3] = dx / r, dy / r, -dy / q, dx / q
        for j in range(n):  # P H'
            a, b = P[l, j] - P[0, j], P[l + 1, j] - P[1, j]
            W[2 * k, j] = H[k, 0] * a + H[k, 1] * b
            W[2 * k + 1, j] = H[k, 2] * a + H[k, 3] * b - P[2, j]
    for k in range(m):  # Z = H P H' + R
        l = 3 + 2 * ids[k]
        for i in range(2 * m):
            a, b = W[i, l] - W[i, 0], W[i, l + 1] - W[i, 1]
            Z[i, 2 * k] = H[k, 0] * a + H[k, 1] * b
            Z[i, 2 * k + 1] = H[k, 2] * a + H[k, 3] * b - W[i, 2]
        for i in range(2):
            for j in range(2):
                Z[2 * k + i, 2 * k + j] += R[i, j]
    for i in range(2 * m):  # Z = L L'; with it W = P H' L^-T and w = L^-1 z, and x + W w
        for j in range(i + 1):
            for a in range(j):
                Z[i, j] -= Z[i, a] * Z[j, a]
            Z[i, j] = np.sqrt(Z[i, i]) if i == j else Z[i, j] / Z[j, j]
        for a in range(i):
            z[i] -= Z[i, a] * z[a]
            for j in range(n):
                W[i, j] -= Z[i, a] * W[a, j]
        z[i] /= Z[i, i]
        for j in range(n):
            W[i, j] /= Z[i, i]
            x[j] += W[i, j] * z[i]
    for k in range(n):
        for i in range(0, 2 * m, 2):
            a, b = W[i, k], W[i + 1, k]
            for j in range(n):
                P[k, j] -= a * W[i, j] + b * W[i + 1, j]
    x[2] = wrap(x[2])


@njit(cache=True)
def step_jointly(x, P, W, Z, z, H, u, U, ids, y, R):
    predict(x, P, u, U)
    correct_jointly(x, P, W, Z, z, H, ids, y, R)


@njit(cache=True)
def runs(x, P, W, u, U, ids, y, R):
    """Many runs through the same steps, one after another: x (runs, n), P (runs, n, n), y (steps, runs, m, 2)."""
    for r in range(len(x)):
        for k in range(len(u)):
            step(x[r], P[r], W, u[k], U, ids[k], y[k, r], R)


class Compiled:
    """The compiled step in a loop."""

    def __init__(self, world):
        self.world = world
        self.x, self.P = world.x0.copy(), world.P0.copy()
        self.W = np.zeros((2, len(self.x)))

    def step(self, k):
        """One step."""
        s = self.world.steps[k % len(self.world.steps)]
        step(self.x, self.P, self.W, s.u, U, s.ids, s.y, R)

    def state(self):
        """Mean and covariance."""
        return self.x.copy(), self.P.copy()


class CompiledJoint(Compiled):
    """The same with one correction."""

    def __init__(self, world):
        super().__init__(world)
        m = world.m
        self.W = np.zeros((2 * m, len(self.x)))
        self.room = np.zeros((2 * m, 2 * m)), np.zeros(2 * m), np.zeros((m, 4))

    def step(self, k):
        """One step."""
        s = self.world.steps[k % len(self.world.steps)]
        step_jointly(self.x, self.P, self.W, *self.room, s.u, U, s.ids, s.y, R)
