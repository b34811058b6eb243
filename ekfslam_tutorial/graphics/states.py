"""What the figures read from a snapshot: landmarks as points, the state of each observation, true poses."""

from __future__ import annotations

from typing import Any

import numpy as np

Array = np.ndarray

STATES = ("updated", "rejected", "predicted")


def obs_state(obs) -> str | None:
    """Return what became of one landmark in one sensor's frame, or None if the sensor cannot see it.

    ``updated``: measured, and the map was corrected. ``rejected``: measured, but the innovation is outside the
    gate. ``predicted``: expected in view, but no measurement was matched to it.
    """
    if obs.updated:
        return "updated"
    if obs.matched:
        return "rejected"
    return "predicted" if obs.visible else None


def lmk_states(snapshot) -> dict[Any, str]:
    """Return the state of each landmark that some sensor sees; updated counts before rejected before predicted."""
    best: dict[Any, str] = {}
    for (_, lmk), obs in snapshot.obs.items():
        state = obs_state(obs)
        if state is not None and STATES.index(state) < STATES.index(best.get(lmk, STATES[-1])) + (lmk not in best):
            best[lmk] = state
    return best


def is_line(lmk) -> bool:
    """Return True for a landmark that is a line: it remembers where its ends are."""
    return getattr(lmk, "par", None) is not None


def lmk_points(snapshot, dim: int) -> tuple[list, Array, Array]:
    """Return ids, Euclidean means (n, dim) and covariances (n, dim, dim) of the landmarks that are points."""
    lmks = [lmk for lmk in snapshot.lmks.values() if not is_line(lmk)]
    points = [lmk.point(snapshot.map) for lmk in lmks]
    mean = np.array([p for p, _ in points], dtype=float).reshape(-1, dim)
    cov = np.array([P for _, P in points], dtype=float).reshape(-1, dim, dim)
    return [lmk.id for lmk in lmks], mean, cov


def lmk_lines(snapshot) -> tuple[list, Array, Array]:
    """Return ids, ends (n, 2, 3) and their covariances (n, 2, 3, 3) of the landmarks that are lines."""
    lmks = [lmk for lmk in snapshot.lmks.values() if is_line(lmk)]
    ends = [lmk.ends(snapshot.map) for lmk in lmks]
    mean = np.array([p for p, _ in ends], dtype=float).reshape(-1, 2, 3)
    cov = np.array([P for _, P in ends], dtype=float).reshape(-1, 2, 3, 3)
    return [lmk.id for lmk in lmks], mean, cov


class TruthInMap:
    """True robots and landmarks, in the frame of the map.

    Parameters
    ----------
    align : bool
        Lay the truth on the map: the first true pose that is known, of the first robot that has one, on that robot's
        estimate in the same frame. Without it the truth is shown as it is.
    """

    def __init__(self, align: bool):
        self.align = align
        self.origin: Any = None  # the frame of the truth in the map, once known

    def frames(self, snapshot) -> dict[Any, Any]:
        """Return the true frame of each robot, by id, where it is known in this frame."""
        robs = {rob.id: rob for rob in snapshot.robs}
        known = {id: robs[id].motion.frame(x) for id, x in snapshot.truth.items() if np.isfinite(x).all()}
        if not self.align:
            return known
        if self.origin is None and known:
            id, true = next(iter(known.items()))
            estimate = type(true)(robs[id].frame(snapshot.map).x.copy())
            self.origin = estimate.compose(true.inverse()[0])[0]
        origin: Any = self.origin
        return {id: origin.compose(frame)[0] for id, frame in known.items()}

    def points(self, snapshot, dim: int) -> Array:
        """Return the true landmarks (n, dim): none where they, or the frame they are in, are not known."""
        if snapshot.sim_lmk is None or (self.align and self.origin is None):
            return np.zeros((0, dim))
        p = np.asarray(snapshot.sim_lmk.points, dtype=float)
        return self.origin.from_frame(p)[0] if self.align else p

    def segments(self, snapshot) -> Array:
        """Return the true edges (n, 2, 3), where they are known."""
        if snapshot.sim_lmk is None or (self.align and self.origin is None):
            return np.zeros((0, 2, 3))
        p = np.asarray(snapshot.sim_lmk.segments, dtype=float).reshape(-1, 3)
        return (self.origin.from_frame(p)[0] if self.align else p).reshape(-1, 2, 3)
