"""The 50-step simulator of the mapping lecture (Dayoub, "Mapping", slide "Running the initialisation function").

The slide's listing runs as it stands there, with Python's brackets::

    load_data()
    for k in range(1, n_steps() + 1):
        x_r = get_pose(k)              # the true pose of the robot is known
        for z in sense(k):             # ranges and bearings to the landmarks
            l = initL(z, x_r)          # (x, y) of the landmark in the map

Time steps count from 1, as in the lecture. All is read from a recorded log, ``data/lecture``; the script that made it
lies beside it. The same log as a `Recording` (`load_data()`) goes through `universal_slam`.
"""

from functools import cache
from pathlib import Path

import numpy as np

from ..models.sensors import RangeBearing
from ..toolbox.recordings import Recording

ROBOT = SENSOR_ID = 1

# What the log was made with, and what a filter on it should be told.
SENSOR = RangeBearing(range_std=0.3, bearing_std=np.radians(5.0))
SIGHT = 5.0  # m: landmarks that are truly nearer are measured, whatever the noise makes of their range
ODOMETRY_STD = np.array([0.05, 0.02, np.radians(1.0)])  # of one step: forward m, sideways m, turn rad


def folder():
    """Folder of the log: inside an installed package, or in the repository."""
    package = Path(__file__).resolve().parent.parent
    shipped = package / "_share" / "data" / "lecture"
    return shipped if shipped.is_dir() else package.parent / "data" / "lecture"


@cache
def load_data():
    """The recorded log.

    Returns
    -------
    Recording
        Frame k-1 is time step k. ``truth[1]`` true poses (50, 3), ``robots[1].u`` odometry (50, 3), ``raw[1]``
        measurements, ``landmarks`` the true landmarks.

    Raises
    ------
    FileNotFoundError, ValueError
        Naming the file, and the line of it, that is missing or wrong.
    """
    return Recording.load(folder())


def n_steps():
    """Number of time steps, 50."""
    return len(load_data())


def get_pose(k):
    """True pose of the robot at time step k.

    Parameters
    ----------
    k : int
        1, 2, ... 50.

    Returns
    -------
    ndarray, shape (3,)
        [x, y, theta], m and rad, in the map frame.

    Raises
    ------
    ValueError
        If there is no such step.
    """
    return load_data().truth[ROBOT][_frame(k)].copy()


def sense(k):
    """Return what the sensor measures at time step k.

    Returns
    -------
    ndarray, shape (m, 2)
        Rows [range, bearing], m and rad, in the robot's own frame; one row for each landmark in view.
    """
    return load_data().raw[SENSOR_ID][_frame(k)].y.copy()


def seen(k):
    """Return whose measurements `sense(k)` returns: the known correspondences.

    Returns
    -------
    ndarray of int, shape (m,)
        Landmark ids, in the order of the rows.
    """
    return load_data().raw[SENSOR_ID][_frame(k)].ids.copy()


def odometry(k):
    """Measured step of the robot from time step k-1 to k: [dx, dy, dtheta] in its frame at k-1. Zero for k = 1."""
    return load_data().robots[ROBOT].u[_frame(k)].copy()


def true_landmarks():
    """The true map: ids, shape (N,), and positions, shape (N, 2), m."""
    landmarks = load_data().landmarks
    assert landmarks is not None  # the log has them
    return landmarks.ids.copy(), landmarks.points.copy()


def initL(z, x_r):
    """Landmark initialisation function q: the landmark in the map frame, from one measurement and the known pose.

        l = [x_r + r cos(theta_r + beta),  y_r + r sin(theta_r + beta)]

    Parameters
    ----------
    z : array_like, shape (2,)
        [range, bearing], m and rad.
    x_r : array_like, shape (3,)
        [x, y, theta], m and rad.

    Returns
    -------
    ndarray, shape (2,)
    """
    r, beta = z
    x, y, theta = x_r
    return np.array([x + r * np.cos(theta + beta), y + r * np.sin(theta + beta)])


def _frame(k):
    if k not in range(1, n_steps() + 1):
        raise ValueError(f"the lecture's simulator has the time steps 1 to {n_steps()}, got {k!r}")
    return int(k) - 1
