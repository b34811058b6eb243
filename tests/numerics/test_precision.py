"""Rounding: the filter in double precision beside the same filter with more digits, and very long runs."""

import numpy as np
import pytest

from ekfslam_tutorial.ekf import Map, correct, covariance, cross, innovation, predict
from tests.ekf.textbook import odometry, range_bearing, wrap
from tools.long_run import long_run

LD = np.longdouble
STEPS = 400


class Dense:
    """The textbook's filter in any precision: numpy inverts doubles only, so the 2 x 2 inverse is written out."""

    def __init__(self, x, P, dtype):
        self.x, self.P = x.astype(dtype), P.astype(dtype)

    def predict(self, u, U):
        f, F_x, F_u = odometry(self.x[:3], u)
        F = np.eye(len(self.x), dtype=self.x.dtype)
        F[:3, :3] = F_x
        self.x[:3] = f
        self.P = F @ self.P @ F.T
        self.P[:3, :3] += F_u @ U @ F_u.T

    def correct(self, i, y, R):
        r = slice(3 + 2 * i, 5 + 2 * i)
        e, H_r, H_l = range_bearing(self.x[:3], self.x[r])
        H = np.zeros((2, len(self.x)), dtype=self.x.dtype)
        H[:, :3], H[:, r] = H_r, H_l
        z = y - e
        z[1] = wrap(z[1])
        PHt = self.P @ H.T
        (a, b), (c, d) = H @ PHt + R
        K = PHt @ (np.array([[d, -b], [-c, a]]) / (a * d - b * c))
        self.x = self.x + K @ z
        self.P = self.P - K @ PHt.T
        self.P = (self.P + self.P.T) / 2


class Ours:
    """The package's operations with the same models."""

    def __init__(self, x, P):
        self.map = Map()
        self.map.add(x, P)

    x = property(lambda self: self.map.x)
    P = property(lambda self: self.map.P)

    def predict(self, u, U):
        predict(self.map, slice(0, 3), *odometry(self.map.x[:3].copy(), u), U)

    def correct(self, i, y, R):
        r = slice(3 + 2 * i, 5 + 2 * i)
        e, H_r, H_l = range_bearing(self.map.x[:3].copy(), self.map.x[r].copy())
        z = y - e
        z[1] = wrap(z[1])
        blocks = ((slice(0, 3), H_r), (r, H_l))
        PHt = cross(self.map, blocks)
        correct(self.map, PHt, innovation(z, covariance(PHt, blocks), R))


def drive(*filters, range_std=0.1, scale=1.0):
    """The same controls and measurements for all filters; the worst relative difference of the second to the first."""
    rng = np.random.default_rng(4)
    landmarks = scale * rng.uniform(-8, 8, (10, 2))
    u, U = np.array([0.3 * scale, 0, 0.1]), np.diag([0.02 * scale, 0.01 * scale, 0.01]) ** 2
    R = np.diag([(range_std * scale) ** 2, 0.01**2])
    truth, worst = np.zeros(3), 0.0
    for _ in range(STEPS):
        truth = odometry(truth, u)[0]
        noisy = u + rng.multivariate_normal(np.zeros(3), U)
        for f in filters:
            f.predict(noisy.astype(f.x.dtype), U.astype(f.x.dtype))
        for i in rng.choice(10, 3, replace=False):
            y = range_bearing(truth, landmarks[i])[0] + rng.multivariate_normal([0, 0], R)
            for f in filters:
                f.correct(i, y.astype(f.x.dtype), R.astype(f.x.dtype))
        sigma = np.sqrt(np.diag(filters[0].P).astype(float))
        worst = max(worst, np.abs((filters[1].x - filters[0].x).astype(float) / sigma).max())
        worst = max(worst, np.abs(((filters[1].P - filters[0].P).astype(float)) / np.outer(sigma, sigma)).max())
    return worst


def start(scale=1.0):
    rng = np.random.default_rng(4)
    x = np.concatenate([np.zeros(3), scale * rng.uniform(-8, 8, (10, 2)).ravel() + 0.1 * scale * rng.normal(size=20)])
    return x, np.diag(np.concatenate([[1e-6 * scale**2] * 2, [1e-6], np.full(20, (0.3 * scale) ** 2)]))


@pytest.mark.skipif(np.finfo(LD).eps > 1e-18, reason="long double has no more digits than double here")
def test_double_precision_is_enough():
    """400 steps, 1200 corrections. The unit is the filter's own sigma; 1e-9 of it is far below any noise.

    A filter of 64 bits loses about log10 of the condition of P; measured 1e-12.
    """
    x, P = start()
    assert drive(Dense(x, P, LD), Ours(x, P)) < 1e-9


def test_a_wrong_filter_would_be_seen():
    x, P = start()
    off = Ours(x, P)
    honest, off.correct = off.correct, lambda i, y, R: honest(i, y, 1.0001 * R)
    assert drive(Dense(x, P, LD), off) > 1e-6


@pytest.mark.parametrize(("world", "frames"), [("plane", 3000), ("space", 300)])
def test_a_long_run_keeps_a_covariance(world, frames):
    """Symmetric to the last bit, positive to rounding, quaternions of length 1, and the pose inside what is claimed.

    Runs of a million and of a hundred thousand frames are recorded in TRUST.md. NEES below the 99.99 % quantile.
    """
    got = long_run(world, frames, looks=20)
    assert got["asymmetry"] == 0.0 and got["smallest_eigenvalue"] > -1e-12 and got["norm_error"] < 1e-12
    assert got["nees"] < (21.1 if world == "plane" else 27.9)
