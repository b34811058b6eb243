"""Figures of a run of pictures: of the one camera, and of the corners of its target."""

import numpy as np

from .tracks import rmse


def picture_figures(history, log):
    """Figures of a run of pictures, where the truth is known.

    Parameters
    ----------
    history : History
    log : Pictures

    Returns
    -------
    dict
        rotation_rmse_deg, in the gauge of the run; landmark_rmse_aligned_m, of the corners of the target that are still
        in the map, after alignment of the trajectories. None where the truth is not known.
    """
    figures = dict.fromkeys(("rotation_rmse_deg", "landmark_rmse_aligned_m"))
    e, _ = history.errors(log.robot)
    known = np.isfinite(e).all(-1)
    if not known.any():
        return figures
    figures["rotation_rmse_deg"] = float(np.rad2deg(rmse(e[known, e.shape[1] // 2 :])))
    F, _ = history.alignment()
    corners = corner_errors(history.last, log.corners, F)
    figures["landmark_rmse_aligned_m"] = rmse(corners) if len(corners) else None
    return figures


def corner_errors(s, corners, F):
    """Errors (n, 3) of the corners of the target that are in the map, which the frame F lays on the truth."""
    if corners is None or F is None:
        return np.zeros((0, 3))
    given = {i: s.lmks.get(i + 1) for i in range(len(corners))}
    there = [i for i, lmk in given.items() if lmk is not None and (lmk.appearance or {}).get("given")]
    points = np.array([given[i].point(s.map)[0] for i in there]).reshape(-1, 3)
    return F.from_frame(points)[0] - np.asarray(corners)[there]
