"""filterpy's ExtendedKalmanFilter: as its documentation shows it, one measurement after another, and in better ways.

Better is one update with all measurements of a step stacked. Its correction is in Joseph's form and its `predict` takes
dense F and Q; the first cannot be chosen, the second can be left out: see `FilterPyJoint`.
"""

import numpy as np
from filterpy.kalman import ExtendedKalmanFilter

from ..oracle import inverse_range_bearing, odometry, range_bearing
from ..world import R, U, wrap
from . import models


def residual(y, e):
    """Innovation with the bearing wrapped."""
    z = y - e
    z[1] = wrap(z[1])
    return z


class FilterPy:
    """One filter with room for all landmarks from the start: filterpy's dimensions are fixed."""

    def __init__(self, world):
        self.world, self.n = world, 3 + 2 * world.n_lmks
        self.kf = ExtendedKalmanFilter(dim_x=self.n, dim_z=2)
        self.kf.x, self.kf.P, self.kf.R = np.zeros(self.n), np.zeros((self.n, self.n)), R
        n0 = len(world.x0)
        self.kf.x[:n0], self.kf.P[:n0, :n0] = world.x0, world.P0
        self.known = set(range((n0 - 3) // 2))

    def step(self, k):
        """One step."""
        step, kf = self.world.steps[k % len(self.world.steps)], self.kf
        x2, F_r, G = odometry(kf.x[:3], step.u)
        F, Q = np.eye(self.n), np.zeros((self.n, self.n))
        F[:3, :3], Q[:3, :3] = F_r, G @ U @ G.T
        kf.F, kf.Q = F, Q
        kf.predict_x = lambda u=0: kf.x.__setitem__(slice(3), x2)
        kf.predict()
        new = []
        for i, y in zip(step.ids, step.y, strict=True):
            if i not in self.known:
                new.append((i, y))
                continue
            kf.update(y.copy(), self.H, self.h, args=(i,), hx_args=(i,), residual=residual)
            kf.x[2] = wrap(kf.x[2])
        for i, y in new:
            self.start(i, y)

    def h(self, x, i):
        """Expected measurement of landmark i."""
        return range_bearing(x[:3], x[3 + 2 * i : 5 + 2 * i])[0]

    def H(self, x, i):
        """Its Jacobian, dense."""
        H = np.zeros((2, self.n))
        _, H[:, :3], H[:, 3 + 2 * i : 5 + 2 * i] = range_bearing(x[:3], x[3 + 2 * i : 5 + 2 * i])
        return H

    def start(self, i, y):
        """A new landmark, written into its place."""
        x, P, r = self.kf.x, self.kf.P, slice(3 + 2 * i, 5 + 2 * i)
        x[r], L_r, L_y = inverse_range_bearing(x[:3], y)
        P_lm = L_r @ P[:3]
        P_lm[:, r] = 0
        P[r], P[:, r] = P_lm, P_lm.T
        P[r, r] = L_r @ P[:3, :3] @ L_r.T + L_y @ R @ L_y.T
        self.known.add(i)

    def state(self):
        """Mean and covariance."""
        return self.kf.x.copy(), self.kf.P.copy()


class FilterPyJoint:
    """All measurements of a step in one update, and a filter that grows with the map: a new one for new landmarks.

    Parameters
    ----------
    world : World
    by_hand : bool
        The user writes what a motion changes in x and P, three rows and columns, instead of calling `predict`.
    """

    def __init__(self, world, by_hand=False):
        self.world, self.by_hand = world, by_hand
        self.at = {i: 3 + 2 * i for i in range((len(world.x0) - 3) // 2)}
        self.kf = self.filter(world.x0, world.P0)

    def filter(self, x, P):
        """A filter of this size; how many numbers a measurement has is said by each update."""
        kf = ExtendedKalmanFilter(dim_x=len(x), dim_z=2 * self.world.m)
        kf.x, kf.P = x.copy(), P.copy()
        return kf

    def step(self, k):
        """One step."""
        step = self.world.steps[k % len(self.world.steps)]
        self.move(step.u)
        seen = [(self.at[i], y) for i, y in zip(step.ids, step.y, strict=True) if i in self.at]
        new = [(i, y) for i, y in zip(step.ids, step.y, strict=True) if i not in self.at]
        if seen:
            at, y = np.array([r for r, _ in seen]), np.concatenate([y for _, y in seen])
            kf = self.kf
            kf.update(y, models.jacobian, models.expected, models.noise(len(at)), (at,), (at,), models.residual)
            kf.x[2] = wrap(kf.x[2])
        if new:
            self.start(new)

    def move(self, u):
        """Prediction: filterpy's own, or the three rows and columns that change."""
        kf = self.kf
        x2, F_r, G = odometry(kf.x[:3], u)
        if self.by_hand:
            kf.x[:3] = x2
            kf.P[:3] = F_r @ kf.P[:3]
            kf.P[:, :3] = kf.P[:, :3] @ F_r.T
            kf.P[:3, :3] += G @ U @ G.T
            return
        n = len(kf.x)
        F, Q = np.eye(n), np.zeros((n, n))
        F[:3, :3], Q[:3, :3] = F_r, G @ U @ G.T
        kf.F, kf.Q = F, Q
        kf.predict_x = lambda u=0: kf.x.__setitem__(slice(3), x2)
        kf.predict()

    def start(self, new):
        """A larger filter, with the new landmarks at its end."""
        n = len(self.kf.x)
        x, P = np.zeros(n + 2 * len(new)), np.zeros((n + 2 * len(new),) * 2)
        x[:n], P[:n, :n] = self.kf.x, self.kf.P
        for i, y in new:
            r = slice(n, n + 2)
            x[r], L_r, L_y = inverse_range_bearing(x[:3], y)
            P[r, :n] = L_r @ P[:3, :n]
            P[:n, r] = P[r, :n].T
            P[r, r] = L_r @ P[:3, :3] @ L_r.T + L_y @ R @ L_y.T
            self.at[i], n = n, n + 2
        self.kf = self.filter(x, P)

    def state(self):
        """Mean and covariance."""
        return self.kf.x.copy(), self.kf.P.copy()


class FilterPyGiven:
    """The class with given blocks: no models, only the dense matrices are filled in. One measurement after another."""

    def __init__(self, world, given):
        self.given, self.n = given(world), len(world.x0)
        self.kf = ExtendedKalmanFilter(dim_x=self.n, dim_z=2)
        self.kf.x, self.kf.P, self.kf.R = world.x0.copy(), world.P0.copy(), R

    def step(self, k):
        """One step."""
        g, kf = self.given[k % len(self.given)], self.kf
        F, Q = np.eye(self.n), np.zeros((self.n, self.n))
        F[:3, :3], Q[:3, :3] = g.X_x, g.X_u @ U @ g.X_u.T
        kf.F, kf.Q = F, Q
        kf.predict_x = lambda u=0: kf.x.__setitem__(slice(3), g.x)
        kf.predict()
        for i, H_r, H_l, z in zip(g.ids, g.H_r, g.H_l, g.z, strict=True):
            H = np.zeros((2, self.n))
            H[:, :3], H[:, 3 + 2 * i : 5 + 2 * i] = H_r, H_l
            kf.update(z, lambda x, H=H: H, lambda x: 0.0)

    def state(self):
        """Mean and covariance."""
        return self.kf.x.copy(), self.kf.P.copy()


class FilterPyJointGiven(FilterPyGiven):
    """The same in its better way: the motion by hand, and one update."""

    def step(self, k):
        """One step."""
        g, kf = self.given[k % len(self.given)], self.kf
        kf.x[:3] = g.x
        kf.P[:3] = g.X_x @ kf.P[:3]
        kf.P[:, :3] = kf.P[:, :3] @ g.X_x.T
        kf.P[:3, :3] += g.X_u @ U @ g.X_u.T
        H, rows = np.zeros((len(g.ids), 2, self.n)), np.arange(len(g.ids))
        H[:, :, :3] = g.H_r
        for axis in 0, 1:
            H[rows, :, 3 + 2 * g.ids + axis] = g.H_l[:, :, axis]
        H = H.reshape(-1, self.n)
        kf.update(g.z.ravel(), lambda x: H, lambda x: 0.0, models.noise(len(g.ids)))
