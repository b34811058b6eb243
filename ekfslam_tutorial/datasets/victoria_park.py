"""Victoria Park: a truck among trees, as a recording of its vehicle model and its laser.

ACFR, University of Sydney. J. E. Guivant, E. M. Nebot, "Optimization of the simultaneous localization and map-building
algorithm for real-time implementation", IEEE Trans. Robotics and Automation 17(3):242-257, 2001. Read is the file
`victoria_park_detections.npz`: odometry, GPS, and the trees that the publisher's detector finds in each laser scan.
"""

from dataclasses import dataclass

import numpy as np

from ..models.motion import Vehicle
from ..toolbox.files.archives import DAMAGE, brief, read_npz
from ..toolbox.recordings import ControlLog, RawLog, Recording
from .sources import get_file

FILE = "victoria_park_detections.npz"
ARRAYS = (
    *("odo_t_ms", "speed", "steering", "gps_t_ms", "gps_x", "gps_y"),
    *("scan_t_ms", "det_per_scan", "det_range", "det_bearing", "det_diameter"),
)
MAX_RANGE, MAX_DIAMETER = 40.0, 1.3
"""Detections further away or thicker than this, m, are left out: bushes, walls and cars rather than trees."""


@dataclass(frozen=True)
class ParkCalibration:
    """Values that the files do not give, by one least squares of laser and odometry, without GPS (docs/data_tuning.md).

    Parameters
    ----------
    bearing : float
        Added to all bearings, rad: the laser looks a little to the side.
    per_diameter : float
        Times the diameter of a tree, added to its range: the detector puts the centre too far behind the bark.
    steer_scale, steer_offset : float
        Real steering = scale times the logged one plus offset, rad.
    delay : float
        The odometry is so much later than its stamps, seen by the clock of the laser, s.
    """

    bearing: float = np.radians(-1.1)
    per_diameter: float = -0.2
    steer_scale: float = 1.06
    steer_offset: float = np.radians(0.32)
    delay: float = 0.067


@dataclass(frozen=True)
class ParkNoise:
    """Standard deviations of the control between two scans; nothing is uncertain while the truck stands still.

    Parameters
    ----------
    speed, speed_growth : float
        Of the wheel's speed v: speed + speed_growth |v|, m/s.
    steer, slip : float
        Of the two angles of `models.Vehicle`, rad.
    """

    speed: float = 0.2
    speed_growth: float = 0.03
    steer: float = np.radians(1.5)
    slip: float = np.radians(6.0)


CALIBRATION, NOISE = ParkCalibration(), ParkNoise()
STANDING = 1e-3
"""A truck that drives less than this between two scans, m, stands still."""


@dataclass(frozen=True)
class ParkLog:
    """Log of the truck, in s, m, rad, and the times of one clock.

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
        arrays = read_npz(file)
        a = {k: arrays[k].astype(float) for k in ARRAYS}
    except KeyError as error:
        raise ValueError(f"{file} is not the file of Victoria Park: {error}") from error
    except DAMAGE as error:
        raise ValueError(f"{file} is damaged or no npz file ({brief(error)}); get it again") from error
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


def load(path=None, calibration=CALIBRATION, noise=NOISE):
    """The log as a recording: a frame for each laser scan, robot 1 a `models.Vehicle`, sensor 1 its laser.

    Parameters
    ----------
    path : str or Path, optional
        The file, or a folder with it; without it, below the folders of `EKFSLAM_DATA`.
    calibration : ParkCalibration
    noise : ParkNoise

    Returns
    -------
    Recording
        Measurements are range and bearing of trees, without ids. The true poses are not known; `fixes` has the GPS.
    """
    return recording(read_log(path), calibration, noise)


def recording(log, calibration=CALIBRATION, noise=NOISE):
    """The recording of a `ParkLog`; parameters as in `load`."""
    odometry = log.odometry * [1.0, 1.0, calibration.steer_scale] + [calibration.delay, 0.0, calibration.steer_offset]
    controls = ControlLog(*commands(odometry, log.scan_t, noise))
    r, bearing, diameter = log.detections.T
    good = (r < MAX_RANGE) & (diameter < MAX_DIAMETER)
    y = np.column_stack([r + calibration.per_diameter * diameter, bearing + calibration.bearing])[good]
    offsets = np.concatenate([[0], np.cumsum(good)])[log.offsets]
    raw = RawLog(1, offsets, np.full(len(y), -1), y)
    notes = [f"{(~good).sum()} detections beyond {MAX_RANGE:g} m or thicker than {MAX_DIAMETER:g} m left out"]
    start, end = log.scan_t[[0, -1]]
    fixes = log.gps[(log.gps[:, 0] >= start) & (log.gps[:, 0] <= end)] - [start, 0.0, 0.0]
    return Recording("Victoria Park", log.scan_t - start, {1: controls}, {1: raw}, notes=notes, fixes={1: fixes})


def commands(odometry, times, noise=NOISE, vehicle=Vehicle()):  # noqa: B008 - a frozen value
    """One control of the vehicle for each frame: the same way and the same turn as all commands in between.

    Parameters
    ----------
    odometry : ndarray, shape (n, 3)
        Time, s; wheel speed, m/s; steering, rad. Before the first row the truck stands still.
    times : ndarray, shape (F,)
        Of the frames, s.
    noise : ParkNoise
    vehicle : Vehicle

    Returns
    -------
    u : ndarray, shape (F, 3)
        [v, steer, slip]; the first one is zero.
    U : ndarray, shape (F, 3, 3)
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
    v = way / dt * (1 - tan * vehicle.track / vehicle.wheelbase)
    u = np.column_stack([v, np.arctan(tan), np.zeros_like(v)]) * moves[:, None]
    std = np.column_stack(
        [noise.speed + noise.speed_growth * np.abs(v), np.full((len(v), 2), [noise.steer, noise.slip])]
    )
    U = (std * moves[:, None])[:, :, None] ** 2 * np.eye(3)
    return u, U
