"""A landmark that is locked out: it is not where the map has it, so every measurement of it fails the gate."""

import numpy as np

from ..ekf import predict
from ..geometry import ORIGIN
from .objects import Event


def retry_lmks(map, rob, events, opt, lmks):
    """Make a landmark more uncertain when its measurements have been refused too often in a row: as for a lost robot.

    One wrong measurement, or one that has passed the gate by chance, can put a landmark where no right one passes any
    more. A step of no motion and large noise opens the gate again: the landmark keeps its mean, and only its own
    covariance grows. If that is not enough, it grows again after as many refusals.

    Parameters
    ----------
    map : Map
    rob : Rob
        Who has looked.
    events : list of Event
        What `correct_known_lmks` and `reopen_gate` did in this frame. After the recovery of the robot itself all
        landmarks begin anew: they were not to blame.
    opt : Options
        `retry_after` refusals, None for never; the first of `reopen_std`, the position (m), of the added noise.
    lmks : dict of int to Lmk
        Count in `n_refused` how many of their innovations in a row failed the gate.

    Returns
    -------
    list of Event
        One of kind recovery for each landmark that is tried again.
    """
    if opt.retry_after is None:
        return []
    if any(event.kind == "recovery" for event in events):
        for lmk in lmks.values():
            lmk.n_refused = 0
        return []
    done = []
    for event in events:
        lmk = lmks.get(event.lmk) if event.kind == "innovation" else None
        if lmk is not None:
            lmk.n_refused = 0 if event.flag else lmk.n_refused + 1
            if lmk.r is not None and lmk.n_refused >= opt.retry_after:
                _loosen(map, lmk, opt.reopen_std[0], rob.motion.frame.dim)
                done.append(Event("recovery", rob.id, event.sen, lmk.id))
    return done


def _loosen(map, lmk, std, dim):
    """Add the noise of a shift in the world: L_t is the derivative of `from_frame` by the position of the frame."""
    l = lmk.state(map)
    L_t = lmk.type.from_frame(ORIGIN[dim], l)[1][:, :dim]
    predict(map, lmk.r, l, np.eye(len(l)), L_t, std**2 * np.eye(dim))
    lmk.n_refused, lmk.first = 0, None
