"""Exercise 23.6: NEES of a flight, in the gauge of its start."""

import numpy as np

from ..table import table
from .nb04_blocks import random_covariance


def flight_nees(p, v, P, p_true, v_true, yaw):
    """NEES of position and velocity of a flight, where only the start says which frame is meant.

    p (m) and v (m/s), shape (n, 3): estimates in the filter's world, in n frames; P, shape (n, 6, 6): the covariances
    of [p, v]. The filter's world begins where the filter began: its position there is certain. p_true and v_true, shape
    (n, 3): the true ones, in another world. To be that of the filter, the true world must be turned by `yaw` (rad)
    about its z axis, which points up in both, and moved so that the two paths begin in the same point.
    e = estimate - truth, six numbers [e_p, e_v].
    Return the NEES, shape (n - 1,), of all frames but the first, in which P has no inverse.
    """
    c, s = np.cos(yaw), np.sin(yaw)
    R = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    e_p = (p - p[0]) - (p_true - p_true[0]) @ R.T
    e = np.hstack([e_p, v - v_true @ R.T])[1:]
    return np.sum(e * np.linalg.solve(P[1:], e[..., None])[..., 0], axis=1)


def case(rng, n=6, turned=True, moved=True):
    """Return a flight, and the truth in another world."""
    p = np.cumsum(rng.normal(size=(n, 3)), axis=0)
    v = rng.normal(size=(n, 3))
    P = np.array([random_covariance(rng, 6, 0.3) for _ in range(n)])
    P[0, :3] = P[0, :, :3] = 0
    e = 0.2 * rng.normal(size=(n, 6))
    e[0, :3] = 0
    yaw = float(rng.uniform(0.5, 2.5)) if turned else 0.0
    c, s = np.cos(yaw), np.sin(yaw)
    R = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    shift = 3 * rng.normal(size=3) if moved else -p[0]
    return p, v, P, (p - e[:, :3]) @ R + shift, (v - e[:, 3:]) @ R, yaw


exercise = table(
    "23.6 NEES in the right gauge",
    flight_nees,
    hints=(
        "Bring the truth into the filter's world first: shift both paths so that they begin at zero, then turn the true one about z.",
        "The velocity is turned, too, but not shifted. Then e' P^-1 e in each frame, with the whole 6 x 6 matrix.",
        "R = [[c, -s, 0], [s, c, 0], [0, 0, 1]]; e_p = (p - p[0]) - (p_true - p_true[0]) @ R.T; e_v = v - v_true @ R.T; np.linalg.solve(P[1:], e[1:, :, None])[..., 0].",
    ),
    returns="nees",
    shown=lambda p, v, P, p_true, v_true, yaw: f"a flight of {len(p)} frames, yaw = {yaw:.3g}",
    cases={
        "any": lambda rng: [case(rng), case(rng, 3), case(rng, 9)],
        "same world": lambda rng: [case(rng, turned=False, moved=False)],
        "moved": lambda rng: [case(rng, turned=False)],
        "turned": lambda rng: [case(rng, moved=False)],
    },
    checks="""
    same world | nees | same world | Nothing to turn: e = [p - p[0] - (p_true - p_true[0]), v - v_true]; the NEES is e' P^-1 e in each frame but the first.
    moved      | nees | moved      | Both paths begin in the same point: subtract p[0] from one, p_true[0] from the other.
    turned     | nees | turned     | The truth is turned by yaw about z, after its start is taken off: positions and velocities.
    any        | nees | any        | First subtract the starts, then turn the truth, then e' P^-1 e.
    """,
    wrong="""
    not turned: Nobody told the filter where north is: turn the truth by yaw, positions and velocities.
        - (p_true - p_true[0]) @ R.T -> - (p_true - p_true[0])
        v - v_true @ R.T -> v - v_true
    velocity not turned | v - v_true @ R.T -> v - v_true | A velocity has a direction, too: it turns with the world.
    position not turned | - (p_true - p_true[0]) @ R.T -> - (p_true - p_true[0]) | The path turns with the world, as the velocities do.
    turned the wrong way: The truth is turned by +yaw: R = [[c, -s, 0], [s, c, 0], [0, 0, 1]], and each point becomes R p.
        (p_true - p_true[0]) @ R.T -> (p_true - p_true[0]) @ R
        v - v_true @ R.T -> v - v_true @ R
    not moved | (p_true - p_true[0]) @ R.T -> p_true @ R.T | The origin of the truth is another one: subtract p_true[0] from it.
    nothing moved | e_p = (p - p[0]) - (p_true - p_true[0]) @ R.T -> e_p = p - p_true @ R.T | The two paths must begin in the same point: subtract p[0] from one, p_true[0] from the other.
    turned about the origin | (p_true - p_true[0]) @ R.T -> (p_true @ R.T - p_true[0]) | Subtract the start first, then turn: else the start is turned away.
    means put on each other | e_p = (p - p[0]) - (p_true - p_true[0]) @ R.T -> e_p = (p - p.mean(0)) - (p_true - p_true.mean(0)) @ R.T | P is relative to the *start*, where the filter is certain; means put on each other hide errors that P knows of.
    ends put on each other | e_p = (p - p[0]) - (p_true - p_true[0]) @ R.T -> e_p = (p - p[-1]) - (p_true - p_true[-1]) @ R.T | The filter is certain of its *start*, and P is relative to it: let the two paths begin in the same point.
    velocity moved, too | v - v_true @ R.T -> v - v[0] - (v_true - v_true[0]) @ R.T | A shift of the world does not change a velocity, and that of the start is not known exactly.
    position only | e = np.hstack([e_p, v - v_true @ R.T])[1:] -> e, P = e_p[1:], P[:, :3, :3] | Six numbers: the velocity belongs to it.
    correlations forgotten | np.linalg.solve(P[1:], -> np.linalg.solve(P[1:] * np.kron(np.eye(2), np.ones((3, 3))), | Position and velocity are correlated: take the whole 6 x 6 matrix.
    variances only | np.linalg.solve(P[1:], -> np.linalg.solve(P[1:] * np.eye(6), | The six errors are correlated: take the whole matrix, not its diagonal.
    inverse forgotten | np.linalg.solve(P[1:], e[..., None])[..., 0] -> (P[1:] @ e[..., None])[..., 0] | Large where P is *small*: e' P^-1 e.
    P forgotten | np.linalg.solve(P[1:], e[..., None])[..., 0] -> e | Scale the errors by what the filter says of them: e' P^-1 e.
    divided by six | [..., 0], axis=1) -> [..., 0], axis=1) / 6 | The NEES is not divided by its six degrees of freedom here: honest is 6.
    root taken | return np.sum(e * np.linalg.solve(P[1:], e[..., None])[..., 0], axis=1) -> return np.sqrt(np.sum(e * np.linalg.solve(P[1:], e[..., None])[..., 0], axis=1)) | NEES is the squared distance: no root.
    mean over the frames | return np.sum(e * np.linalg.solve(P[1:], e[..., None])[..., 0], axis=1) -> return np.full(len(e), np.mean(np.sum(e * np.linalg.solve(P[1:], e[..., None])[..., 0], axis=1))) | One NEES for each frame, not their mean.
    yaw in degrees | c, s = np.cos(yaw), np.sin(yaw) -> c, s = np.cos(np.radians(yaw)), np.sin(np.radians(yaw)) | yaw is in radians already.
    turned about x | np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) -> np.array([[1, 0, 0], [0, c, -s], [0, s, c]]) | Gravity says what is up: the world can be turned about z only.
    moved before it is turned | e_p = (p - p[0]) - (p_true - p_true[0]) @ R.T -> e_p = p - (p_true - p_true[0] + p[0]) @ R.T | Turn first, then move to p[0]: else the start of the path is turned away, too.
    P of the frame before | P[1:] -> P[[1, *range(1, len(P) - 1)]] | Each error has the covariance of its own frame: P[i] belongs to e[i].
    P turned, too | return np.sum( -> P = np.kron(np.eye(2), R) @ P @ np.kron(np.eye(2), R).T; return np.sum( | Error and P belong in one world, that of the filter: turn the truth into it, and leave P and the estimate as they are.
    P turned back | return np.sum( -> P = np.kron(np.eye(2), R.T) @ P @ np.kron(np.eye(2), R); return np.sum( | Error and P belong in one world, that of the filter: turn the truth into it, and leave P and the estimate as they are.
    """,
)
