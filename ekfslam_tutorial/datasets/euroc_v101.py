"""EuRoC V1_01_easy: a flying robot with an IMU and one camera, the first 30 s, as a recording.

M. Burri et al., "The EuRoC micro aerial vehicle datasets", Int. J. Robotics Research 35(10), 2016. The file
`eqvio_processed_30s.csv`, which comes with the Python package `gtsam`, has what the IMU measured, 200 a second, and
tracks of features in the left camera, 20 a second. The true poses are in a file of their own, and may be missing.
"""

import csv
import gzip
from dataclasses import replace

import numpy as np

from ..geometry import Frame3
from ..models.motion import Imu
from ..models.motion.at_rest import at_rest
from ..models.sensors import PinHole
from ..toolbox.messages import integrate
from ..toolbox.recordings import ControlLog, RawLog, Recording
from .sources import find_file, get_file

FILE, TRUTH = "eqvio_processed*.csv*", "V1_01_easy_truth*.txt*"
PART = "eqvio_processed_30s.csv"
SHA256 = "3b62cc8093e2cbb081460abfffba663a61a5a9702a382acc3a583c5d056e27af"
"""Of the file as it is in the wheel, not packed."""
WHEEL = "gtsam==4.3.0"
HOME = f"the wheel of a Python package, which has it among its own files: pip download --no-deps {WHEEL}"

CAMERA = PinHole((367.215, 248.375, 458.654, 457.296), image_size=(752.0, 480.0), pixel_std=1.0, margin=-400.0)
"""The distortion has been taken off the pixels, so some lie outside of the image."""
MOUNT = Frame3(np.array([-0.0216401455, -0.064676986768, 0.00981073059, 0.712301461, -0.00770717976, 0.01049932337,
                         0.7017528003])).normalized()[0]  # fmt: skip
"""The camera in the frame of the IMU."""

WINDOW = 0.25
"""Seconds in which the IMU is looked at, to see whether the robot is still where it stood."""
SMOOTH = 41
"""Rows of the IMU that tell how quickly what it measures changes: 0.2 s."""
SAME_TURN, SAME_FORCE = 0.03, 0.3
"""By so much the means of two windows differ if the robot still stands, rad/s and m/s^2: its propellers shake it."""


def load(path=None, first=0, last=None, clock_std=None):
    """The log as a recording of robot 1 and its camera, sensor 1.

    Parameters
    ----------
    path : str or Path, optional
        The file, packed by gzip or not, or a folder with it; without it, below the folders of `EKFSLAM_DATA`.
    first, last : int
        Frames of the camera to take, from 0, both included; all of them without.
    clock_std : float, optional
        Controls and start are those of `models.ImuClock`: the clocks of IMU and camera differ by about so many seconds.

    Returns
    -------
    Recording
        Many controls a frame, those of `models.Imu`: means of two neighbouring rows hold in between. `y` are the pixels
        [u, v] of `CAMERA`, ids are those of the tracks. Where the robot starts is found from the IMU: at rest, and if
        `first` is later, by the IMU alone from there.

    Raises
    ------
    FileNotFoundError, ValueError
        Naming the file.
    """
    file = get_file("EuRoC V1_01", FILE, path)
    imu, seen = _read(file)
    t = np.unique(seen[:, 0])
    stop = len(t) if last is None else last + 1
    if not 0 <= first < stop <= len(t):
        asked = f"{first} to {'the end' if last is None else last}"
        raise ValueError(f"{file}: it has the frames 0 to {len(t) - 1}, asked for are {asked}")
    t = t[first:stop]
    truth = find_file(TRUTH, path if path is None else file.parent)
    poses, notes = _true(truth, t), []
    if truth is None:
        notes.append(f"no {TRUTH} is here: the true path is not known")
    begun, told = start(imu, t[0] - imu[0, 0])
    return recording("EuRoC V1_01", imu, t, seen, poses, begun, [*notes, told], clock_std)


def recording(name, imu, t, seen, truth, start, notes, clock_std=None):
    """Rows of the IMU between the frames t, and what the camera has seen in them, as a recording.

    Parameters
    ----------
    name : str
    imu : ndarray, shape (n, 7)
        Time, gyrometer, accelerometer.
    t : ndarray, shape (F,)
    seen : ndarray, shape (m, 4)
        Time, number of the track, x and y in the image at distance 1.
    truth : ndarray, shape (F, 7), or None
    start : tuple of ndarray
        State of `Imu` in the first frame, and its covariance.
    notes : list of str
    clock_std : float, optional
        As in `load`.

    Returns
    -------
    Recording
    """
    log = controls_between(imu, t)
    if clock_std is not None:
        log, start = with_clock(log, imu, t, start, clock_std)
    seen = seen[(seen[:, 0] >= t[0]) & (seen[:, 0] <= t[-1])]
    y = seen[:, 2:] * CAMERA.k[2:] + CAMERA.k[:2]
    offsets = np.append(np.searchsorted(seen[:, 0], t), len(seen))
    raw = RawLog(1, offsets, seen[:, 1].astype(int), y)
    poses = {} if truth is None else {1: truth}
    return Recording(name, t - t[0], {1: log}, {1: raw}, poses, notes=notes, starts={1: start})


def controls_between(imu, t):
    """Controls of `Imu` from frame to frame: the IMU is split at the frames, and linear between its own rows."""
    knots = np.unique(np.round(np.concatenate([imu[:, 0], t]), 5))
    knots = knots[(knots >= t[0] - 1e-6) & (knots <= t[-1] + 1e-6)]
    at = np.stack([np.interp(knots, imu[:, 0], column) for column in imu[:, 1:].T], -1)
    u = np.zeros((len(knots) - 1, 12))
    u[:, :6] = (at[1:] + at[:-1]) / 2
    offsets = np.concatenate([[0], np.searchsorted(knots, np.round(t, 5))])
    return ControlLog(u, None, offsets, np.round(np.diff(knots), 5))


def with_clock(log, imu, t, start, clock_std):
    """The same controls and start for `ImuClock`.

    Rates are those of parabolas through `SMOOTH` rows. Rates of single rows are nearly all noise: the filter would look
    for a motion like that, find none at any offset, and believe that there is no offset.
    """
    from scipy.signal import savgol_filter  # here: it takes a while, and few runs need it

    rates = savgol_filter(imu[:, 1:], SMOOTH, 2, deriv=1, delta=np.median(np.diff(imu[:, 0])), axis=0)
    middles = t[0] + np.cumsum(log.dt) - log.dt / 2
    at = np.stack([np.interp(middles, imu[:, 0], column) for column in np.asarray(rates, float).T], -1)
    x, P = np.append(start[0], 0.0), np.zeros((17, 17))
    P[:16, :16], P[16, 16] = start[1], clock_std**2
    return replace(log, u=np.concatenate([log.u, at], 1)), (x, P)


def start(imu, t):
    """State in the first frame, t seconds after the first row of the IMU, its covariance, and how it was found."""
    windows = _means(imu)
    same = np.abs(windows - windows[0]) < np.repeat([SAME_TURN, SAME_FORCE], 3)
    n_still = int(np.argmin(np.append(same.all(-1), False)))
    end = n_still * WINDOW
    begin = max(0.0, min(t, end - WINDOW))
    rest = _between(imu, max(0.0, begin - 0.5), begin + WINDOW)
    x, P = at_rest(rest[:, 1:4].mean(0), rest[:, 4:].mean(0), gyro_std=2e-3, acc_std=0.05, vel_std=0.03)
    if t <= begin:
        return (x, P), f"it starts at rest: gravity, and the gyrometer's bias, from {len(rest)} rows of the IMU"
    log = controls_between(imu, imu[0, 0] + np.array([begin, t]))
    motion = Imu()
    x, P = integrate(
        motion, x, P, ((u, motion.noise(h), h) for u, h in zip(log.u, np.asarray(log.dt).tolist(), strict=True))
    )
    x[:3], P[:3], P[:, :3] = 0.0, 0.0, 0.0  # it starts where the map begins
    return (x, P), f"it starts in flight: by the IMU alone, from {begin:.2f} s, when it stood, to {t:.2f} s"


def _means(imu):
    """Means of what the IMU measures in one window after the other, shape (n, 6)."""
    window = ((imu[:, 0] - imu[0, 0]) / WINDOW).astype(int)
    return np.array([imu[window == k, 1:].mean(0) for k in np.unique(window)[:-1]])


def _between(imu, a, b):
    t = imu[:, 0] - imu[0, 0]
    return imu[(t >= a) & (t < b - 1e-6)]


def _true(file, t):
    """True poses at these times, NaN where there are none; None without a file."""
    from scipy.spatial.transform import Rotation, Slerp  # here, too

    if file is None:
        return None
    try:
        rows = np.loadtxt(file)
    except (OSError, ValueError, EOFError) as error:
        raise ValueError(f"{file} is no file of true poses: {' '.join(str(error).split())[:100]}") from error
    if rows.ndim != 2 or rows.shape[1] != 8 or not np.isfinite(rows).all() or not (np.diff(rows[:, 0]) > 0).all():
        raise ValueError(f"{file}: wanted are rows of t, x, y, z, qx, qy, qz, qw, and times that rise")
    inside = (t >= rows[0, 0]) & (t <= rows[-1, 0])
    poses = np.full((len(t), 7), np.nan)
    poses[inside, :3] = np.stack([np.interp(t[inside], rows[:, 0], column) for column in rows[:, 1:4].T], -1)
    turns = Slerp(rows[:, 0], Rotation.from_quat(rows[:, 4:]))(t[inside]).as_quat()
    poses[inside, 3:] = turns[:, [3, 0, 1, 2]]
    return poses


def _read(file):
    """Rows of the IMU, t, gyrometer, accelerometer, and of the camera, t, track, x and y in its image at distance 1."""
    try:
        with (gzip.open if file.suffix == ".gz" else open)(file, "rt", newline="", encoding="utf-8") as text:
            rows = list(csv.DictReader(text))
        imu = [[r[c] for c in ("t_abs", "gx", "gy", "gz", "ax", "ay", "az")] for r in rows if r["row_type"] == "imu"]
        columns = "t_abs", "landmark_id", "u_norm", "v_norm"
        seen = [[r[c] for c in columns] for r in rows if r["row_type"] == "vision_feature"]
        imu, seen = np.array(imu, float).reshape(-1, 7), np.array(seen, float).reshape(-1, 4)
    except (OSError, EOFError, KeyError, TypeError, ValueError, csv.Error) as error:
        raise ValueError(f"{file} is not the file of EuRoC V1_01: {' '.join(str(error).split())[:100]}") from error
    imu[:, 0], seen[:, 0] = np.round(imu[:, 0], 5), np.round(seen[:, 0], 5)
    if not (np.isfinite(imu).all() and np.isfinite(seen).all()) or len(imu) < 60 or not len(seen):
        raise ValueError(f"{file} is not whole: wanted are rows of an IMU and of a camera, all numbers finite")
    if not (np.diff(imu[:, 0]) > 0).all() or not (np.diff(seen[:, 0]) >= 0).all():
        raise ValueError(f"{file}: the times of its rows do not rise")
    return imu, seen
