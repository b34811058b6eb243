"""The blocks of a lap, computed beforehand at the true poses: for a filter that knows no models."""

from dataclasses import dataclass

import numpy as np

from .oracle import odometry, range_bearing
from .world import wrap


@dataclass(frozen=True)
class Given:
    """One step: the moved robot x with X_x, X_u; for m landmarks z (m, 2), H_r (m, 2, 3), H_l (m, 2, 2)."""

    x: np.ndarray
    X_x: np.ndarray
    X_u: np.ndarray
    ids: np.ndarray
    z: np.ndarray
    H_r: np.ndarray
    H_l: np.ndarray


def given(world):
    """List of Given, one for each step of the lap."""
    steps, last = [], world.steps[-1].pose
    for step in world.steps:
        _, X_x, X_u = odometry(last, step.u)
        seen = [range_bearing(step.pose, world.lmks[i]) for i in step.ids]
        e, H_r, H_l = (np.array(a) for a in zip(*seen, strict=True))
        z = step.y - e
        z[:, 1] = wrap(z[:, 1])
        steps.append(Given(step.pose, X_x, X_u, step.ids, z, H_r, H_l))
        last = step.pose
    return steps
