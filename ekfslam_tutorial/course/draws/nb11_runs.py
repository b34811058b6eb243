"""Motions of notebook 11: a drone on a screw line, with noise of several kinds."""

from __future__ import annotations

from functools import cache

import numpy as np

from ...geometry import Frame3, e2q, q2e, q_prod, v2q
from ..exercises.nb11_odo3 import odo3

STEPS, SAMPLES = 40, 300
STD = np.array([0.10, 0.02, 0.02, 0.01, 0.01, 0.02])  # of one step: ahead, sideways, up (m), roll, pitch, yaw (rad)
STEP = np.array([0.4, 0, 0, *np.radians([1.25, 0, 5.87])])  # 6 degrees about the vertical, nose 12 degrees up
START = np.concatenate([[0, 0, 0.5], e2q(np.radians([0.0, -12.0, 0.0]))[0]])


def small(q):
    """Derivative of q v2q(v) by v at v = 0, shape (4, 3)."""
    return q_prod(q, np.array([1.0, 0, 0, 0]))[2] @ v2q(np.zeros(3))[1]


def twist_path(v, w, seconds=6.0, dt=0.1):
    """Frames of a robot with constant speed v ahead (m/s) and turn rate w (rad/s) in its own axes."""
    F, frames = Frame3(np.eye(7)[3]), []
    step = np.concatenate([[v * dt, 0, 0], np.asarray(w) * dt])
    for _ in range(round(seconds / dt) + 1):
        frames.append(F)
        F = Frame3(odo3(F.x, step)[0])
    return frames


def std_of(turning: bool) -> np.ndarray:
    """Standard deviations of a step, with or without the noise of the turn."""
    return STD * np.array([1, 1, 1, turning, turning, turning])


@cache
def flights(fly, turning: bool) -> np.ndarray:
    """All frames of the robots, shape (STEPS + 1, SAMPLES, 7)."""
    return np.array([np.tile(START, (SAMPLES, 1)), *fly(START, turning, np.random.default_rng(11))])


@cache
def beliefs(believe, turning: bool, axes: str):
    """Mean (STEPS + 1, 7) and covariance (STEPS + 1, 7, 7) of the filter after each step."""
    x, P = zip((START, np.zeros((7, 7))), *believe(START, np.zeros((7, 7)), turning, axes), strict=True)
    return np.array(x), np.array(P)


def euler_sigmas(roll, pitch, sigma):
    """Standard deviations of roll, pitch and yaw (degrees) of an attitude that is uncertain by `sigma` about each axis.

    All in degrees.
    """
    q = e2q(np.radians([roll, pitch, 0.0]))[0]
    E = q2e(q)[1] @ small(q)
    return sigma * np.sqrt((E**2).sum(1))


def spread(rate: int, law: str, seconds=10.0, sigma=0.2):
    """Standard deviations of velocity (m/s) and position (m) after some seconds of random impulses, one axis.

    Parameters
    ----------
    rate : int
        Steps per second.
    law : str
        How the variance of one impulse depends on dt: "1", "dt" or "dt^2", times sigma^2.
    """
    dt = 1 / rate
    U = sigma**2 * {"1": 1.0, "dt": dt, "dt^2": dt**2}[law]
    F, P = np.array([[1, dt], [0, 1]]), np.zeros((2, 2))
    for _ in range(round(seconds * rate)):
        P = F @ P @ F.T
        P[1, 1] += U
    return float(np.sqrt(P[1, 1])), float(np.sqrt(P[0, 0]))
