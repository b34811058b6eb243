"""What a log says about its own odometry: scale of its turns and delay, from landmarks that move through the view.

When a robot turns, the bearing of every landmark runs the other way. Two sightings of one landmark, a second or two
apart, therefore measure the turn in between; set against the commanded turn they give the scale of the turns and the
delay between command and motion. No ground truth and no map is used, only what the robot itself logged.
"""

from dataclasses import dataclass

import numpy as np

from ..geometry import wrap
from .odometry import dead_reckon

APART = (1.0, 2.0)
"""Sightings are compared when they are so far apart, s: long against the delay, short against the drift."""

LOSS_WIDTH = 0.05
"""Bearing errors (rad) above this lose their weight (Cauchy loss): outliers, slips, collisions."""

BEARING_STD = 0.1
"""Standard deviation of one pair against the prior, rad: large, because the pairs of one turn err together."""

PRIOR_STD = 0.1
"""How far scales and delay (s) are from the typical ones, at 1 sigma."""

STANDING = 0.01
"""A robot slower than this, m/s, turns on the spot."""


@dataclass(frozen=True)
class OdometryCalibration:
    """Calibration of an odometry: how real motion follows commanded motion.

    Parameters
    ----------
    left, right : float
        Real over commanded turn rate in left and in right turns under way.
    spin : float
        The same for turns on the spot.
    delay : float
        Time from a command to its effect in the measurements, s.
    source : str
        Where the numbers come from, for reports.
    """

    left: float
    right: float
    spin: float
    delay: float
    source: str = "given"

    def __post_init__(self):
        for name in ("left", "right", "spin"):
            scale = getattr(self, name)
            if not 0 < scale < 10:
                raise ValueError(f"the scale of {name} turns makes no sense: {scale}; 1 means as commanded")
        if not abs(self.delay) < 10:
            raise ValueError(f"the delay of odometry makes no sense: {self.delay} s")

    def __str__(self):
        scales = f"left {self.left:.2f}, right {self.right:.2f}, on the spot {self.spin:.2f}"
        return f"turns scaled: {scales}; delayed by {self.delay:.2f} s ({self.source})"

    def turn_rate(self, v, w):
        """Real turn rates for commanded speeds v (n,), m/s, and w (n,), rad/s."""
        return w * np.where(abs(v) < STANDING, self.spin, np.where(w > 0, self.left, self.right))


def self_calibration(odometry, t, ids, y, typical):
    """Estimate scales and delay from the bearings of landmarks that stand still.

    Parameters
    ----------
    odometry : ndarray, shape (n, 3)
        Commands: time, s; forward speed, m/s; turn rate, rad/s. Times rise.
    t, ids, y : ndarray, shapes (m,), (m,), (m, 2)
        Sightings of landmarks: time, identity, [range, bearing] (m, rad). Times rise.
    typical : OdometryCalibration
        The prior mean: where the search starts, and the answer to what the log says nothing about.

    Returns
    -------
    OdometryCalibration
    """
    first, second = _pairs(t, ids)
    odometry = _thinned(odometry)
    mean = np.array([typical.left, typical.right, typical.spin, typical.delay])

    def surprise(p):
        """Bearing of each second sighting minus the one that the first and the commands let expect; and the prior."""
        time, v, w = odometry.T
        path = dead_reckon(time, v, OdometryCalibration(*p).turn_rate(v, w))
        px, py, heading = (np.interp(t - p[3], time, c) for c in path.T)
        a = heading[first] + y[first, 1]
        dx = px[first] + y[first, 0] * np.cos(a) - px[second]
        dy = py[first] + y[first, 0] * np.sin(a) - py[second]
        bearing = np.arctan2(dy, dx) - heading[second]
        z = wrap(y[second, 1] - bearing) / LOSS_WIDTH
        cauchy = np.sign(z) * np.sqrt(np.log1p(z * z)) * LOSS_WIDTH
        return np.concatenate([cauchy / BEARING_STD, (p - mean) / PRIOR_STD])

    from scipy.optimize import least_squares  # it takes 0.3 s to import

    low, high = [0.3, 0.3, 0.3, -0.2], [1.5, 1.5, 1.5, 0.8]
    fit = least_squares(surprise, mean, bounds=(low, high), diff_step=1e-3, xtol=1e-4, ftol=1e-6)
    return OdometryCalibration(*map(float, fit.x), source=f"from {len(first)} pairs of sightings")


def _thinned(odometry, every=0.1):
    """The rows in which a command changes, and one each `every` seconds: all that the path of the robot depends on."""
    changed = np.diff(odometry[:, 1:], axis=0, prepend=np.inf).any(axis=1)
    tick = np.diff(odometry[:, 0] // every, prepend=-np.inf) > 0
    return odometry[changed | tick]


def _pairs(t, ids):
    """Indices of sightings of one landmark: each, and the first one that is later by APART[0], at most by APART[1]."""
    order = np.lexsort((t, ids))
    t, ids = t[order], ids[order]
    first, second = [np.zeros(0, int)], [np.zeros(0, int)]
    for i in np.unique(ids):
        k = np.flatnonzero(ids == i)
        j = np.searchsorted(t[k], t[k] + APART[0])
        k, j = k[j < len(k)], k[j[j < len(k)]]
        near = t[j] - t[k] <= APART[1]
        first.append(order[k[near]])
        second.append(order[j[near]])
    return np.concatenate(first), np.concatenate(second)
