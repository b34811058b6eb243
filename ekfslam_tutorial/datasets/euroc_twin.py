"""A simulated log like EuRoC V1_01, for those who do not have the file: an IMU and a camera that fly in a room."""

import numpy as np
from scipy.spatial.transform import Rotation

from ..geometry import Frame3
from ..models.motion import Imu
from . import euroc_v101

RATE, EVERY = 200, 10
"""Rows of the IMU in a second, and how many of them there are from one frame of the camera to the next."""
BIASES = np.array([-0.002, 0.02, 0.077, -0.025, 0.12, 0.08])
"""Of gyrometer and accelerometer at the start, rad/s and m/s^2."""
ROOM = np.array([[-4.0, -4.0, -0.5], [4.0, 4.0, 2.5]])
CREEP = 0.003
"""A track creeps over what it is on: a random walk, m/sqrt(s)."""
CAREFUL = Imu(gyro_noise=5e-4, acc_noise=1e-2, gyro_walk=1.9e-5, acc_walk=3e-3)


def twin(seed=1, n=601, motion=CAREFUL, clock=0.0, clock_std=None, moves=1.0, turns=1.0):
    """A log as `euroc_v101.load` gives it; the noise is white and known, the true biases wander.

    Parameters
    ----------
    seed : int
        Of everything random.
    n : int
        Number of frames, 20 a second.
    motion : Imu
        Its noise.
    clock : float
        The clock of the IMU is ahead of that of the camera by so many seconds.
    clock_std : float, optional
        As in `euroc_v101.load`.
    moves, turns : float
        As in `path`.

    Returns
    -------
    Recording
        Landmarks have ids of tracks: who comes into view again is another one.
    """
    rng, h = np.random.default_rng(seed), 1 / RATE
    t = h * np.arange(EVERY * (n - 1) + 1)
    R, p, v = path(t, moves, turns)
    imu = np.concatenate([t[:, None], _measured(R, v, h, motion, rng)], 1)
    truth = np.concatenate([p, R.as_quat()[:, [3, 0, 1, 2]]], 1)[::EVERY]
    seen = _tracks(Frame3(truth), EVERY * h, rng)
    begun, told = euroc_v101.start(imu, 0.0)
    imu[:, 0] += clock
    notes = [f"simulated twin of EuRoC V1_01, seed {seed}: no real camera was here", told]
    return euroc_v101.recording("twin of EuRoC V1_01", imu, t[::EVERY], seen, truth, begun, notes, clock_std)


def path(t, moves=1.0, turns=1.0):
    """A flight through the room: it stands for a second, takes off, and turns about all axes.

    Parameters
    ----------
    t : ndarray, shape (n,)
        s.
    moves, turns : float
        How much of that it does: with 0 and 0 it stands, with 1 and 0 it does not turn.

    Returns
    -------
    R : Rotation
        Of the IMU in the world, n of them.
    p, v : ndarray, shape (n, 3)
    """
    far = np.clip((t - 1.0) / 4.0, 0, 1)  # how much of the motion there is already
    swell, rise = far**3 * (10 - 15 * far + 6 * far**2), 7.5 * far**2 * (1 - far) ** 2
    s = np.stack([1.2 * np.sin(0.7 * t), 1.0 * np.cos(0.6 * t), 0.8 + 0.4 * np.sin(0.9 * t)], -1)
    ds = np.stack([0.84 * np.cos(0.7 * t), -0.6 * np.sin(0.6 * t), 0.36 * np.cos(0.9 * t)], -1)
    p, v = moves * swell[:, None] * s, moves * (swell[:, None] * ds + rise[:, None] * s)
    angles = np.stack([0.5 * np.sin(0.35 * t), 0.15 * np.sin(0.8 * t), 0.15 * np.sin(1.1 * t + 1)], -1)
    ahead = Rotation.from_quat([0.0, -np.sqrt(0.5), 0.0, np.sqrt(0.5)])  # x of the IMU is up, its camera looks along z
    return Rotation.from_euler("ZYX", turns * swell[:, None] * angles) * ahead, p, v


def _measured(R, v, h, motion, rng):
    """Measurements of the IMU at each instant: the means from this one to the next, with biases and noise."""
    turns = (R[:-1].inv() * R[1:]).as_rotvec() / h
    middle = R[:-1] * Rotation.from_rotvec(turns * h / 2)
    forces = middle.inv().apply(np.diff(v, axis=0) / h - np.array(motion.gravity))
    ideal = np.concatenate([turns, forces], 1)
    ideal = np.concatenate([ideal[:1], (ideal[1:] + ideal[:-1]) / 2, ideal[-1:]])
    U = np.diag(motion.noise(h))
    walk = np.cumsum(rng.normal(size=ideal.shape) * np.sqrt(U[6:]), axis=0)
    return ideal + BIASES + walk + rng.normal(size=ideal.shape) * np.sqrt(U[:6])


def _tracks(poses, dt, rng, n_points=700, budget=30, ends=0.03):
    """Rows t, track, x, y: of so many points on the walls some are followed, until they leave the view or get lost."""
    on = rng.uniform(*ROOM, (n_points, 3))
    wall = rng.integers(0, 6, n_points)
    on[np.arange(n_points), wall % 3] = ROOM[wall // 3, wall % 3]
    cameras = poses.compose(euroc_v101.MOUNT)[0]
    track, last, rows = {}, 0, []
    for k in range(len(poses.x)):
        on += rng.normal(size=on.shape) * CREEP * np.sqrt(dt)
        c = Frame3(cameras.x[k])
        q = (on - c.t) @ c.R
        y, depth = euroc_v101.CAMERA.project(q)[0], q[:, 2]
        image = np.array(euroc_v101.CAMERA.image_size)
        view = np.flatnonzero((depth > 0.3) & (y > 10).all(-1) & (y < image - 10).all(-1))
        view = set(view[rng.random(len(view)) > ends].tolist())
        track = {i: number for i, number in track.items() if i in view}
        for i in rng.permutation(sorted(view - set(track)))[: budget - len(track)].tolist():
            last += 1
            track[i] = last
        for i in sorted(track, key=track.__getitem__):
            u = y[i] + rng.normal(size=2) * euroc_v101.CAMERA.pixel_std
            rows.append([k * dt, track[i], *((u - euroc_v101.CAMERA.k[:2]) / euroc_v101.CAMERA.k[2:])])
    return np.array(rows)
