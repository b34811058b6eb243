"""A simulated twin of the MRCLAM data sets: the same files with the same troubles, but the truth is known exactly.

For those who do not have the real logs, and for tests: five robots drive among 15 landmarks and each other and write
the files that `mrclam_log` reads. Barcodes, spurious barcodes, gaps in the odometry, rows out of order, a first command
left over from before, turns that come late and too small, sightings that go wrong, dense and sparse ground truth.
"""

import tempfile
from functools import lru_cache
from pathlib import Path

import numpy as np

from ..geometry import Frame2, wrap
from ..models.motion import Unicycle
from ..models.sensors import RangeBearing
from ..simulation import Streams
from . import mrclam
from .mrclam_log import ROBOTS, check_robots, read_set
from .odometry import OdometryNoise
from .sources import Source

START = 1_250_000_000.0  # s, Unix time: stamps as large as the real ones
TICK = 0.05  # s between commands
RETHINK = 20  # ticks between two decisions where to go
LOOK = 4  # ticks between two pictures of the camera
ARENA = np.array([[-1.0, 6.0], [-5.0, 4.0]])  # m
TURN_SCALE, DELAY_TICKS, SPEED_SCALE = 0.9, 4, 1.02
CAMERA = RangeBearing(range_std=0.08, bearing_std=0.012, max_range=6.0, fov=1.1)
RANGE_GROWTH = 0.02  # of range_std, per metre
NOISE = (0.02, 0.15)  # of the real speed and turn rate, m/s and rad/s, anew at each tick
SIGHTING_NOISE = mrclam.SightingNoise(range_std=0.1, range_growth=0.03, bearing_std=0.012)
ODOMETRY_NOISE = OdometryNoise(along=0.03, across=0.02, turn=0.08, drift=0.035)
"""What `load` tells a filter. These robots slip less and see better than the real ones, whose noise would be too much
for them (NIS at half of what it should be). Sightings: `CAMERA` with its growth; a drift of 0.15 rad/s at each tick is
0.034 rad per root second; along and turn have room for the scale of the speed, and for what a calibration leaves."""
GAP = 1.2  # s without odometry, three times a log
SPURIOUS = (3, 77)  # barcodes that nobody wears


def load(robots=(1,), seed=1, duration=300.0):
    """The twin as a recording: its files are written to a temporary folder and read like the real ones.

    Parameters
    ----------
    robots : sequence of int
        Which robots, 1 to 5.
    seed : int
        Of everything random.
    duration : float
        Length of the log, s.

    Returns
    -------
    Recording
    """
    with tempfile.TemporaryDirectory() as folder:
        path = write(Path(folder) / "MRCLAM_Twin", seed, duration, robots=robots)
        log = read_set(Source(path), robots)
        recording = mrclam.recording(log, odometry_noise=ODOMETRY_NOISE, sighting_noise=SIGHTING_NOISE)
    recording.notes.insert(0, f"simulated twin of the MRCLAM data sets, seed {seed}: no real robot was here")
    return recording


def write(folder, seed=1, duration=300.0, sparse=(5,), robots=ROBOTS):
    """Simulate the five robots and write the files of a set.

    Parameters
    ----------
    folder : path
        Is made if it does not exist.
    seed : int
    duration : float
        s.
    sparse : sequence of int
        Robots with sparse instead of dense ground truth.
    robots : sequence of int
        Whose files to write; all five drive in any case.

    Returns
    -------
    Path
        The folder.
    """
    check_robots(robots)
    if not duration > 10:
        raise ValueError(f"the twin needs more than 10 s to show its troubles, got {duration} s")
    streams = Streams(seed)
    barcodes = np.sort(streams.world.choice(np.arange(5, 73), 20, replace=False))[streams.world.permutation(20)]
    points = _scattered(streams.world)
    commands, poses = _drive(seed, round(duration / TICK))

    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    subjects = np.arange(1, 21)
    _save(folder / "Barcodes.dat", "Subject #    Barcode #", np.column_stack([subjects, barcodes]), "%3d \t %3d")
    survey = np.column_stack([subjects[5:], points, np.full((15, 2), 5e-5)])
    header = "Subject #    x [m]    y [m]    x std-dev [m]    y std-dev [m]"
    _save(folder / "Landmark_Groundtruth.dat", header, survey, "%3d \t %.8f \t %.8f \t %.8f \t %.8f")
    for robot in robots:
        k = ROBOTS.index(robot)
        _save_robot(folder, robot, commands[:, k], poses[:, k], robot in sparse, streams.clutter(robot))
        rows = _look(robot, poses, points, barcodes, streams.sensing(robot))
        header = "Time [s]    Subject #    range [m]    bearing [rad]"
        _save(folder / f"Robot{robot}_Measurement.dat", header, rows, "%.3f \t %3d \t %.3f \t %.3f")
    return folder


def _scattered(rng, n=15, apart=1.0):
    """Landmarks in the arena, not too near to each other."""
    points = np.zeros((0, 2))
    while len(points) < n:
        p = rng.uniform(ARENA[:, 0], ARENA[:, 1])
        if (np.linalg.norm(points - p, axis=1) > apart).all():
            points = np.vstack([points, p])
    return points


@lru_cache(maxsize=1)
def _drive(seed, n):
    """Commands [v, w] (n, 5, 2) and true poses (n, 5, 3): every robot goes from one random goal to the next.

    One twin after another is asked for, of other robots: the last drive is kept.
    """
    streams = Streams(seed)
    rngs = [streams.motion(robot) for robot in ROBOTS]
    low, high = ARENA[:, 0] + 0.5, ARENA[:, 1] - 0.5
    x = np.array([[*rng.uniform(low, high), rng.uniform(-np.pi, np.pi)] for rng in rngs])
    noise = np.stack([rng.normal(size=(n, 2)) for rng in rngs], 1) * NOISE
    goals = np.array([rng.uniform(low, high) for rng in rngs])
    commands, poses = np.zeros((n, len(ROBOTS), 2)), np.zeros((n, len(ROBOTS), 3))
    for k in range(n):
        poses[k] = x
        for i in np.flatnonzero(np.linalg.norm(goals - x[:, :2], axis=1) < 0.5):
            goals[i] = rngs[i].uniform(low, high)
        to_goal = goals - x[:, :2]
        error = wrap(np.arctan2(to_goal[:, 1], to_goal[:, 0]) - x[:, 2])
        if k % RETHINK == 0:
            spin = abs(error) > 1.2
            commands[k, :, 0] = np.where(spin, 0.0, 0.15)
            commands[k, :, 1] = np.where(spin, 0.6 * np.sign(error), np.clip(error, -0.5, 0.5)).round(1)
        else:
            commands[k] = commands[k - 1]
        real = np.column_stack([SPEED_SCALE * commands[k, :, 0], TURN_SCALE * commands[max(k - DELAY_TICKS, 0), :, 1]])
        moving = real.any(axis=1, keepdims=True)
        x = Unicycle().move(x, real + np.where(moving, noise[k], 0.0), TICK)[0]
    commands.flags.writeable = poses.flags.writeable = False
    return commands, poses


def _look(robot, poses, points, barcodes, rng):
    """Rows [t, barcode, range, bearing] of what one robot's camera sees, some of it wrong; one row comes too late."""
    me = ROBOTS.index(robot)
    rows = []
    for k in range(4 + me % LOOK, len(poses), LOOK):
        others = np.delete(poses[k, :, :2], me, axis=0)
        codes = np.concatenate([np.delete(barcodes[:5], me), barcodes[5:]])
        ps = Frame2(poses[k, me]).to_frame(np.vstack([others, points]))[0]
        y = CAMERA.project(ps)[0]
        growth = np.array([1.0, 0.0]) * RANGE_GROWTH * y[:, :1]
        y = y + rng.normal(size=y.shape) * (np.sqrt(np.diag(CAMERA.R)) + growth)
        y[:, 0] += np.where(rng.random(len(y)) < 0.01, rng.uniform(0.5, 1.5, len(y)), 0.0)
        seen = CAMERA.visible(y, ps) & (rng.random(len(y)) < 0.6)
        found = np.column_stack([codes, y])[seen]
        if len(found) and rng.random() < 0.004:
            found[0, 0] = rng.choice(SPURIOUS)
        rows += [[START + k * TICK, *row] for row in found]
    late = len(rows) // 2
    return np.array(rows[: late - 1] + rows[late : late + 1] + rows[late - 1 : late] + rows[late + 1 :])


def _save_robot(folder, robot, commands, poses, sparse, rng):
    """Odometry with gaps and a bad beginning; ground truth."""
    t = START + np.arange(len(poses)) * TICK
    odometry = np.column_stack([t, commands])
    keep = np.ones(len(t), bool)
    for start in rng.uniform(0.1, 0.9, 3) * (t[-1] - START):
        keep[(t - START > start) & (t - START < start + GAP)] = False
    left_over = [[t[0] + 0.1, 0.294, 0.0]]
    odometry = np.vstack([left_over, np.column_stack([t[:3] + 0.001, np.zeros((3, 2))]), odometry[keep][3:]])
    header = "Time [s]    forward velocity [m/s]    angular velocity[rad/s]"
    _save(folder / f"Robot{robot}_Odometry.dat", header, odometry, "%.3f \t %6.3f \t %6.3f")

    truth = np.column_stack([t, poses[:, :2], wrap(poses[:, 2])])
    if sparse:
        instants = np.sort(rng.choice(len(t), 40, replace=False))
        rows = np.repeat(truth[instants], 3, axis=0)
        rows[:, 1:3] += np.tile([-0.001, 0.0, 0.001], 40)[:, None]
        name = f"Robot{robot}_Groundtruth_sparse.csv"
        np.savetxt(folder / name, rows, "%.3f,%.8f,%.8f,%.8f", header="t_s,x_m,y_m,theta_rad")
    else:
        header = "Time [s]    x [m]    y [m]    orientation [rad]"
        _save(folder / f"Robot{robot}_Groundtruth.dat", header, truth, "%.3f \t %.8f \t %.8f \t %.8f")


def _save(path, columns, rows, format):
    head = f"Simulated twin of the UTIAS MRCLAM data sets\nmade by ekfslam_tutorial\nColumns:\n{columns}"
    np.savetxt(path, rows, format, header=head)
