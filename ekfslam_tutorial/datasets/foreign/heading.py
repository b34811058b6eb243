"""Headings of a compass as measurements; and what was seen along the axes of the world, seen from the bow."""

import numpy as np

from ...geometry import wrap
from ...toolbox.messages import Measurement
from .scans import scatter

LEAST = np.deg2rad(0.1)
"""No compass is taken for better, rad."""


class Compass:
    """The compass of a robot in the plane: it tells the heading whenever something is seen.

    Where the robot turns by the differences of the same headings, their white noise, of std s, comes in twice. It is
    told from the log by its scatter, and no fit may move it: differences, bearings and headings that all have the same
    error agree with each other, however large that is. From one scan to the next, T s later, the difference of two
    headings has the variance 2 s^2, so a control of dt seconds has the noise sqrt(2 / (dt T)) s of a turn rate.

    Parameters
    ----------
    odometry : dict of str to ndarray, shape (n,)
        With `t` and `theta`, in the order of the times.
    times : ndarray, shape (k,)
        When something is seen, s.
    """

    def __init__(self, odometry, times):
        self.odometry = odometry
        inside = (times >= odometry["t"][0]) & (times <= odometry["t"][-1])
        self.times = np.unique(times[inside])
        theta = np.unwrap(odometry["theta"])
        grain = np.diff(np.unique(odometry["theta"])).min(initial=np.inf)  # whole degrees hide the scatter
        grain = grain / np.sqrt(12) if np.isfinite(grain) else 0.0
        self.std = float(max(np.nan_to_num(scatter(theta, odometry["t"])), grain, LEAST))

    @property
    def turn_rate_std(self):
        """Noise of a turn rate that is a difference of headings, rad/s."""
        dt, T = (float(np.median(np.diff(t))) if len(t) > 1 else 1.0 for t in (self.odometry["t"], self.times))
        return float(np.sqrt(2 / (dt * max(T, dt))) * self.std)

    def sensor(self):
        """Table of the sensor."""
        return {"type": "compass", "heading_std_deg": round(float(np.rad2deg(self.std)), 3)}

    def messages(self, sensor):
        """Its measurements."""
        for t, theta in zip(self.times, wrap(heading_at(self.odometry, self.times)), strict=True):
            yield Measurement(t, [-1], [[theta]], sensor)


def from_the_bow(scan, theta):
    """Turn a scan that counts from the axes of the world by the heading of the robot.

    A bearing b becomes b - theta, a point p becomes R(theta)' p, its covariance R(theta)' C R(theta).

    Parameters
    ----------
    scan : dict of str to ndarray, shape (n,)
        Columns by meaning: bearings, or x and y.
    theta : ndarray, shape (n,)
        Heading at the time of each row, rad, from the x axis to the left.

    Returns
    -------
    dict of str to ndarray
    """
    turned = dict(scan)
    if "bearing" in scan:
        turned["bearing"] = wrap(scan["bearing"] - theta)
    if not {"x", "y"} <= set(scan):
        return turned
    c, s = np.cos(theta), np.sin(theta)
    turned |= {"x": c * scan["x"] + s * scan["y"], "y": c * scan["y"] - s * scan["x"]}
    axes = [a for a in "xyz" if a in scan]
    pairs = [(i, j) for j in range(len(axes)) for i in range(j + 1)]
    names = [f"cov_{axes[i]}{axes[j]}" for i, j in pairs]
    stds = [f"{a}_std" for a in axes]
    C, R = (np.zeros((len(theta), len(axes), len(axes))) for _ in range(2))
    if set(names) <= set(scan):
        for (i, j), name in zip(pairs, names, strict=True):
            C[:, i, j] = C[:, j, i] = scan[name]
    elif set(stds) <= set(scan):
        for i, name in enumerate(stds):
            C[:, i, i] = turned.pop(name) ** 2
    else:
        return turned
    R[:] = np.eye(len(axes))
    R[:, 0, 0], R[:, 0, 1], R[:, 1, 0], R[:, 1, 1] = c, -s, s, c
    C = np.swapaxes(R, 1, 2) @ C @ R
    return turned | {name: C[:, i, j] for (i, j), name in zip(pairs, names, strict=True)}


def heading_at(odometry, t):
    """Heading at some times, between two rows the shorter way round, rad.

    Parameters
    ----------
    odometry : dict of str to ndarray, shape (n,)
        With `t` and `theta`, in the order of the times.
    t : ndarray, shape (k,)

    Returns
    -------
    ndarray, shape (k,)
    """
    times, first = np.unique(odometry["t"], return_index=True)
    return np.interp(t, times, np.unwrap(odometry["theta"][first]))
