"""Victoria Park: a truck among trees, as a recording of its vehicle model and its laser.

ACFR, University of Sydney. J. E. Guivant, E. M. Nebot, "Optimization of the simultaneous localization and map-building
algorithm for real-time implementation", IEEE Trans. Robotics and Automation 17(3):242-257, 2001. Read is the file
`victoria_park_detections.npz`: odometry, GPS, and the trees that the publisher's detector finds in each laser scan.
"""

from dataclasses import dataclass

import numpy as np

from ..models.motion import Vehicle
from ..toolbox.recording import DAMAGE, ControlLog, RawLog, Recording
from .sources import get_file

FILE = "victoria_park_detections.npz"
ARRAYS = (
    *("odo_t_ms", "speed", "steering", "gps_t_ms", "gps_x", "gps_y"),
    *("scan_t_ms", "det_per_scan", "det_range", "det_bearing", "det_diameter"),
)
MAX_RANGE, MAX_DIAMETER = 50.0, 1.3
"""Detections further away or thicker than this, m, are left out: bushes, walls and cars rather than trees."""

MISALIGNED = np.radians(-1.0)
"""Added to all bearings, rad. With it the normalised innovation is half of what it is without (docs/data_tuning.md)."""

SPEED_STD, SPEED_GROWTH, STEER_STD = 0.3, 0.05, np.radians(2.0)
"""Control noise: speed SPEED_STD + SPEED_GROWTH |v| (m/s), steering (rad); none while the truck stands still."""

STANDING = 1e-3
"""A truck that drives less than this between two scans, m, stands still."""


@dataclass(frozen=True)
class ParkLog:
    """What the truck logged, in s, m, rad, and the times of one clock.

    Parameters
    ----------
    odometry : ndarray, shape (n, 3)
        Time, speed of the rear left wheel, steering.
    gps : ndarray, shape (g, 3)
        Time, x east, y north.
    scan_t : ndarray, shape (F,)
        Times of the laser scans.
    offsets : ndarray of int, shape (F + 1,)
        Scan k has the detections offsets[k] to offsets[k + 1].
    detections : ndarray, shape (M, 3)
        Range, bearing counter-clockwise from straight ahead, diameter.
    """

    odometry: np.ndarray
    gps: np.ndarray
    scan_t: np.ndarray
    offsets: np.ndarray
    detections: np.ndarray


def read_log(path=None):
    """Read the file.

    Parameters
    ----------
    path : str or Path, optional
        The file, or a folder with it; without it, below the folders of `EKFSLAM_DATA`.

    Returns
    -------
    ParkLog

    Raises
    ------
    FileNotFoundError, ValueError
        Naming the file.
    """
    file = get_file("Victoria Park", FILE, path)
    try:
        with np.load(file, allow_pickle=False) as z:
            a = {k: z[k].astype(float) for k in ARRAYS}
    except KeyError as error:
        raise ValueError(f"{file} is not the file of Victoria Park: {error}") from error
    except DAMAGE as error:
        raise ValueError(f"{file} is damaged or no npz file ({type(error).__name__}); get it again") from error
    offsets = np.concatenate([[0], np.cumsum(a["det_per_scan"])]).astype(int)
    if offsets[-1] != len(a["det_range"]) or len(offsets) != len(a["scan_t_ms"]) + 1:
        raise ValueError(f"{file}: det_per_scan counts {offsets[-1]} detections, there are {len(a['det_range'])}")
    return ParkLog(
        np.column_stack([a["odo_t_ms"] / 1e3, a["speed"], a["steering"]]),
        np.column_stack([a["gps_t_ms"] / 1e3, a["gps_x"], a["gps_y"]]),
        a["scan_t_ms"] / 1e3,
        offsets,
        np.column_stack([a["det_range"], a["det_bearing"] - np.pi / 2, a["det_diameter"]]),
    )


def load(path=None):
    """The log as a recording: a frame for each laser scan, robot 1 a `models.Vehicle`, sensor 1 its laser.

    Parameters
    ----------
    path : str or Path, optional
        The file, or a folder with it; without it, below the folders of `EKFSLAM_DATA`.

    Returns
    -------
    Recording
        Measurements are range and bearing of trees, without ids. The true poses are not known.
    """
    log = read_log(path)
    u, U = controls(log.odometry, log.scan_t)
    good = (log.detections[:, 0] < MAX_RANGE) & (log.detections[:, 2] < MAX_DIAMETER)
    offsets = np.concatenate([[0], np.cumsum(good)])[log.offsets]
    y = log.detections[good, :2] + [0.0, MISALIGNED]
    raw = RawLog(1, offsets, np.full(len(y), -1), y)
    notes = [f"{(~good).sum()} detections beyond {MAX_RANGE:g} m or thicker than {MAX_DIAMETER:g} m left out"]
    return Recording("Victoria Park", log.scan_t - log.scan_t[0], {1: ControlLog(u, U)}, {1: raw}, notes=notes)


def controls(odometry, times, vehicle=Vehicle()):  # noqa: B008 - a frozen value
    """One control of the vehicle for each frame: the same way and the same turn as all commands in between.

    Parameters
    ----------
    odometry : ndarray, shape (n, 3)
        Time, s; wheel speed, m/s; steering, rad. Before the first row the truck stands still.
    times : ndarray, shape (F,)
        Of the frames, s.
    vehicle : Vehicle

    Returns
    -------
    u : ndarray, shape (F, 2)
        [v, steer]; the first one is zero.
    U : ndarray, shape (F, 2, 2)
        Covariances.
    """
    t = odometry[:, 0]
    rates = vehicle.axle(odometry[:, 1:])[0]
    path = np.concatenate([np.zeros((1, 2)), np.cumsum(rates[:-1] * np.diff(t)[:, None], axis=0)])
    way, turn = (np.diff(np.interp(times, t, c), prepend=0.0) for c in path.T)
    way[0] = turn[0] = 0.0
    moves = np.abs(way) > STANDING
    dt = np.diff(times, prepend=times[0] - 1.0)
    tan = np.where(moves, turn * vehicle.wheelbase / np.where(moves, way, 1.0), 0.0)
    u = np.column_stack([way / dt * (1 - tan * vehicle.track / vehicle.wheelbase), np.arctan(tan)])
    u[~moves] = 0.0
    U = np.zeros((len(times), 2, 2))
    U[:, 0, 0] = np.where(moves, (SPEED_STD + SPEED_GROWTH * np.abs(u[:, 0])) ** 2, 0.0)
    U[:, 1, 1] = np.where(moves, STEER_STD**2, 0.0)
    return u, U
