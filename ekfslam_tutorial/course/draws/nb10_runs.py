"""What notebook 10 asks of its attitude filter, and the way between two orientations."""

from __future__ import annotations

from functools import cache

import numpy as np

from ...geometry import Frame3, q2qc, q_prod, unit

NEVER, VALUE, BOTH = "never", "value only", "value and covariance"
STEPS, RUNS = 100, 40
DIRECTIONS = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])  # up and north, in the world
RATE = np.array([0.05, 0.02, 0.1])  # turn in one step, rad
GYRO, SIGHT = np.radians(1.0), 0.1  # noise: of a turn, rad; of a measured direction


def _judge(q, P, true):
    """Norm of q, sigma along q, NEES and error (degrees) of orientations."""
    u = unit(q)[0]
    at = lambda q: Frame3(np.concatenate([np.zeros((*q.shape[:-1], 3)), q], -1))
    e, E = at(q).minus(at(true))
    e, E = e[..., 3:], E[..., 3:, 3:]
    nees = (e * np.linalg.solve(E @ P @ np.swapaxes(E, -1, -2), e[..., None])[..., 0]).sum(-1)
    sigma = np.sqrt(np.einsum("...i,...ij,...j", u, P, u).clip(0))
    return np.stack([np.linalg.norm(q, axis=-1), sigma, nees, np.degrees(np.linalg.norm(e, axis=-1))], -1)


@cache
def judged(attitude, mode: str, prior: float) -> np.ndarray:
    """Norm of q, sigma along q, tangent-space NEES (3 dof) and error (degrees) of all runs, (RUNS, STEPS, 4)."""
    runs = [list(attitude(mode, prior, seed)) for seed in range(RUNS)]
    return _judge(*(np.array([[step[i] for step in run] for run in runs], float) for i in range(3)))


def slerp(q0, q1, s):
    """Between two orientations: the same axis, a part s of the angle. Takes the way that the signs of q0, q1 say."""
    dq = q_prod(q2qc(q0)[0], q1)[0]
    n = np.linalg.norm(dq[1:])
    a = s * np.arctan2(n, dq[0])
    part = np.concatenate([[np.cos(a)], np.sin(a) * dq[1:] / n])
    return q_prod(q0, part)[0]
