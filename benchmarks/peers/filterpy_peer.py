"""filterpy's ExtendedKalmanFilter as its documentation shows it: dense F, Q and H, one measurement after another."""

import numpy as np
from filterpy.kalman import ExtendedKalmanFilter

from ..oracle import inverse_range_bearing, odometry, range_bearing
from ..world import R, U, wrap


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


class FilterPyGiven:
    """The same class with given blocks: no models, only the dense matrices are filled in."""

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
