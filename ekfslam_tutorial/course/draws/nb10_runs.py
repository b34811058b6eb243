"""The experiment of notebook 10: an attitude filter with an additive correction, which breaks the norm of q."""

from __future__ import annotations

from functools import cache

import numpy as np

from ...geometry import Frame3, q2qc, q2R, q_prod, unit, v2q

NEVER, VALUE, BOTH = "never", "value only", "value and covariance"
STEPS, RUNS = 100, 40
DIRECTIONS = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])  # up and north, in the world
RATE = np.array([0.05, 0.02, 0.1])  # turn in one step, rad
GYRO, SIGHT = np.radians(1.0), 0.1  # noise: of a turn, rad; of a measured direction


def attitude(mode: str, prior: float, seed: int):
    """One run, step by step; every fifth step two known directions are measured.

    Parameters
    ----------
    mode : str
        How the quaternion is normalised after each correction.
    prior : float
        Standard deviation of the first orientation about each axis, degrees.
    seed : int

    Yields
    ------
    q, P, true : ndarray
        Orientation, its covariance (4, 4), and the true orientation, after each step.
    """
    start, gyro, sight = (np.random.default_rng(s) for s in np.random.SeedSequence(seed).spawn(3))
    q, true = np.array([1.0, 0, 0, 0]), v2q(np.radians(prior) * start.normal(size=3))[0]
    J = v2q(np.zeros(3))[1]
    P = np.radians(prior) ** 2 * J @ J.T
    for k in range(STEPS):
        true = q_prod(true, v2q(RATE)[0])[0]
        dq, DQ_v = v2q(RATE + GYRO * gyro.normal(size=3))
        q, Q_q, Q_dq = q_prod(q, dq)
        Q_v = Q_dq @ DQ_v
        P = Q_q @ P @ Q_q.T + GYRO**2 * Q_v @ Q_v.T
        for d in DIRECTIONS if k % 5 == 0 else ():
            y = q2R(true)[0].T @ d + SIGHT * sight.normal(size=3)
            q, P = correct(q, P, d, y)
            if mode != NEVER:
                q, Q_q = unit(q)
                P = Q_q @ P @ Q_q.T if mode == BOTH else P
        yield q, P, true


def correct(q, P, d, y):
    """Correct an orientation with the measured direction y = R(q)' d; the correction is added to q."""
    R, R_q = q2R(q)
    H = np.einsum("ijk,i->jk", R_q, d)
    Z = H @ P @ H.T + SIGHT**2 * np.eye(3)
    K = np.linalg.solve(Z, H @ P).T
    return q + K @ (y - R.T @ d), P - K @ Z @ K.T


def _judge(q, P, true):
    """Sigma along q, NEES and error (degrees) of an orientation."""
    u = unit(q)[0]
    e, E = Frame3(np.r_[0, 0, 0, q]).minus(Frame3(np.r_[0, 0, 0, true]))
    e, E = e[3:], E[3:, 3:]
    return np.sqrt(max(u @ P @ u, 0)), e @ np.linalg.solve(E @ P @ E.T, e), np.degrees(np.linalg.norm(e))


@cache
def judged(attitude, mode: str, prior: float) -> np.ndarray:
    """Norm of q, sigma along q, tangent-space NEES (3 dof) and error (degrees) of all runs, (RUNS, STEPS, 4)."""
    runs = (attitude(mode, prior, seed) for seed in range(RUNS))
    return np.array([[(np.linalg.norm(q), *_judge(q, P, true)) for q, P, true in run] for run in runs])


def slerp(q0, q1, s):
    """Between two orientations: the same axis, a part s of the angle. Takes the way that the signs of q0, q1 say."""
    dq = q_prod(q2qc(q0)[0], q1)[0]
    n = np.linalg.norm(dq[1:])
    a = s * np.arctan2(n, dq[0])
    part = np.concatenate([[np.cos(a)], np.sin(a) * dq[1:] / n])
    return q_prod(q0, part)[0]
