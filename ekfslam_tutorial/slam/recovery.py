"""A robot that is lost: every measurement of known landmarks fails the gate, so none can put the robot right."""

import numpy as np

from ..ekf import predict
from ..models.motion import Odometry2, Odometry3
from .objects import Event
from .projection import frame_range, normalize

NO_STEP = {2: Odometry2(), 3: Odometry3()}
"""Motion models, by dimension, whose control can be zero: then only the noise acts."""


def reopen_gate(map, rob, events, opt, lmks=()):
    """Make the pose of a robot more uncertain when its measurements have been refused too often in a row.

    After a long turn without a landmark in view, a slip or a push, the robot is further off than the filter believes.
    All innovations are then outside the gate and stay there (lock-out). A step of no motion and large noise opens the
    gate again: the pose keeps its mean, and the map is not touched.

    Parameters
    ----------
    map : Map
    rob : Rob
        Counts in `n_refused` how many innovations in a row failed the gate; one that passes sets it back to 0.
    events : list of Event
        What `correct_known_lmks` did in this frame.
    opt : Options
        `reopen_after` refusals, None for never; `reopen_std`, position (m) and heading (rad) of the added noise.
    lmks : dict of int to Lmk, optional
        What the robot took for first estimates while it was lost is far off: with `opt.first_estimates` those of robot
        and landmarks are noted anew.

    Returns
    -------
    list of Event
        One of kind recovery, or none.
    """
    for event in events:
        if event.kind == "innovation":
            rob.n_refused = 0 if event.flag else rob.n_refused + 1
    if not events or opt.reopen_after is None or rob.r is None or rob.n_refused < opt.reopen_after:
        return []
    F = rob.frame(map)
    position, angle = opt.reopen_std
    U = np.diag([position**2] * F.dim + [angle**2] * (F.dof - F.dim))
    predict(map, frame_range(rob, F), *NO_STEP[F.dim].move(F.x, np.zeros(F.dof), 0.0), U)  # pyright: ignore
    normalize(map, rob)
    rob.n_refused = 0
    for each in (rob, *dict(lmks).values()):
        each.first = None
    return [Event("recovery", rob.id, events[-1].sen, -1)]
