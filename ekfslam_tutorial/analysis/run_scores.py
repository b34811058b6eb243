"""What is kept of a run among many: its errors in every frame, what the filter says about them, the map at its end."""

import numpy as np
from threadpoolctl import threadpool_limits

from ..toolbox.universal_slam import universal_slam
from .batch_slam import batch_slam
from .consistency import md2
from .partners import identity, named, placed

FRAMES = ("position", "heading", "position_std", "heading_std", "nees")
"""Figures of each run, frame and robot, shape (R, F, K)."""
ENDS = ("landmark_rmse", "landmark_nees", "n_landmarks", "n_left_over")
"""Figures of each run at its end, shape (R,)."""


def score_block(data, seeds, together):
    """Run a scenario with some seeds.

    Parameters
    ----------
    data : UserData
    seeds : sequence of int
    together : bool
        All at once, by `batch_slam`; else one after the other.

    Returns
    -------
    scores : dict of str to ndarray
        position and heading, lengths of the errors (m, rad); position_std and heading_std, the same as the filter
        expects them (root of the trace of its covariance); nees; landmark_rmse (m), landmark_nees, n_landmarks, and
        n_left_over of them without a true one. NaN is what is not known, or not estimated.
    failures : dict of int to str
        Seeds whose run could not be finished, and why; their scores are NaN.
    """
    with threadpool_limits(1, user_api="blas"):  # for the speed, and so that the last digit is the same everywhere
        if together:
            try:
                return _scores_together(data, seeds), {}
            except (ValueError, ArithmeticError, np.linalg.LinAlgError):
                pass  # one of them has failed: find out which
        parts, failures = [], {}
        for seed in seeds:
            try:
                parts.append(_scores_together(data, [seed]) if together else _scores_alone(data, seed))
            except (ValueError, ArithmeticError, np.linalg.LinAlgError) as error:
                parts.append(None)
                failures[seed] = str(error)
    shape = (1, data_frames(data), len(data.robots))
    lost = {name: np.full(shape if name in FRAMES else 1, np.nan) for name in (*FRAMES, *ENDS)}
    parts = [lost if part is None else part for part in parts]
    return {name: np.concatenate([part[name] for part in parts]) for name in lost}, failures


def data_frames(data):
    """Number of frames of a simulation."""
    return len(universal_slam(data))


def _scores_together(data, seeds):
    n_seeds, poses = len(seeds), []
    for now in batch_slam(data, seeds):
        poses.append((now.x[:, :3].copy(), now.P[:, :3, :3].copy(), now.truth))
    x, P, truth = (np.array(a)[:, :, None].swapaxes(0, 1) for a in zip(*poses, strict=True))

    at = np.arange(len(now.ids))
    e = now.x[:, 3:].reshape(n_seeds, -1, 2) - now.points
    P_ll = np.moveaxis(now.P[:, 3:, 3:].reshape(n_seeds, len(at), 2, len(at), 2)[:, at, :, at], 0, 1)
    return _errors(data.frame, x, P, truth) | _ends([(e[r, s], P_ll[r, s]) for r, s in enumerate(now.seen)])


def _scores_alone(data, seed):
    poses, n = [], data.frame.size
    for now in universal_slam(data, seed=seed):
        for rob in now.robs:
            P = np.zeros((n, n)) if rob.r is None else now.map.block(rob.r)[:n, :n]
            poses.append((rob.state(now.map)[:n], P, now.truth[rob.id]))
    shape = (1, -1, len(now.robs))
    x, P, truth = (np.array(a) for a in zip(*poses, strict=True))
    x, P, truth = (a.reshape(*shape, *a.shape[1:]) for a in (x, P, truth))

    rows = named(now) if now.named else placed(now, identity(data.frame.dim))[0]
    pairs = [(now.lmks[id].point(now.map), now.sim_lmk.points[k]) for id, k in rows.items()
             if now.lmks[id].r is not None]  # fmt: skip
    e = np.array([p - place for (p, _), place in pairs]).reshape(-1, data.frame.dim)
    P_ll = np.array([P for (_, P), _ in pairs]).reshape(-1, data.frame.dim, data.frame.dim)
    return _errors(data.frame, x, P, truth) | _ends([(e, P_ll)], [len(now.lmks)], [len(now.lmks) - len(rows)])


def _errors(frame, x, P, truth):
    """Scores of poses: x and truth (R, F, K, size), P (R, F, K, size, size)."""
    e, E_x = frame(x).minus(frame(truth))
    P, d = E_x @ P @ np.swapaxes(E_x, -1, -2), frame.dim
    variances = np.diagonal(P, axis1=-2, axis2=-1)
    values = np.linalg.norm(e[..., :d], axis=-1), np.linalg.norm(e[..., d:], axis=-1)
    stds = np.sqrt(variances[..., :d].sum(-1)), np.sqrt(variances[..., d:].sum(-1))
    return dict(zip(FRAMES, (*values, *stds, md2(e, P)), strict=True))


def _ends(maps, n=None, left_over=None):
    """Scores of maps: for each run the errors of its landmarks (N, d) and their covariances (N, d, d)."""
    mean = lambda a: a[np.isfinite(a)].mean() if np.isfinite(a).any() else np.nan
    rmse = [np.sqrt(mean((e**2).sum(-1))) for e, _ in maps]
    nees = [mean(md2(e, P)) for e, P in maps]
    n = [float(len(e)) for e, _ in maps] if n is None else n
    left_over = np.zeros(len(maps)) if left_over is None else left_over
    return dict(zip(ENDS, map(np.array, (rmse, nees, n, left_over)), strict=True))
