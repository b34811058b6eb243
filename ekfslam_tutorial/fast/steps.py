"""The steps of `slam`, quicker: the same signatures, events, messages, and the same numbers to rounding."""

from functools import partial

import numpy as np

from . import core
from .carrying import all_parts, before, follow
from .compressed_map import CompressedMap
from .core import note_first_estimates, transport, travel
from .extra import compiled
from .fast_map import FastMap
from .filter import predict
from .frames import normal_frame, normalize, normalized_state
from .joint import correct_jointly
from .one_by_one import correct_one_by_one
from .refused import check_measurements, check_step
from .straight import moved

LARGEST = np.finfo(float).max  # as a gate: what is too far away for a float does not pass, everything else does


def new_map(capacity=None, *, compiled=False, compressed=False):
    """Return an empty map for these steps.

    Parameters
    ----------
    capacity : int, optional
        Most states that may be in use at a time. Without it the map grows as needed.
    compiled : bool
        Let the steps be compiled: see `FastMap`.
    compressed : bool
        For long runs with many landmarks, of which few are seen at a time: see `CompressedMap`.
    """
    return (CompressedMap if compressed else FastMap)(capacity, compiled=compiled)


def move(map, rob, dt):
    """Motion of a robot by its control: see `slam.move`."""
    check_step(map, rob, dt)
    kind = rob.motion.frame
    if kind.dim == 3:
        map.notes.forget_normal()
        normalize(map, rob, kind)
    if map.compiled and rob.r is not None and rob.first is None and _moved_compiled(map, rob, dt):
        if kind.dim == 3:  # a heading is wrapped where it is compiled
            normalize(map, rob, kind)
        return
    normalize(map, rob, kind)
    before = rob.state(map)
    x, X_x, X_u, U = travel(partial(moved, rob.motion), before, np.asarray(rob.u, float), rob.U, dt)
    if rob.r is None:
        rob.x = normalized_state(rob.motion, x)
    else:
        X_x = X_x if rob.first is None else X_x @ transport(rob.first, before)
        predict(map, rob.r, x, X_x, X_u, np.asarray(U, float))
        normalize(map, rob, kind)
    if rob.first is not None:
        rob.first = rob.state(map)


def _moved_compiled(map, rob, dt):
    """Motion by one control, or by several one after the other. Returns True if done."""
    u, U = rob.u, rob.U
    if (u.ndim if type(u) is np.ndarray else np.ndim(u)) == 1:
        return compiled().move(map, rob.r, rob.motion, u, U, dt)
    steps = zip(u, U, dt, strict=True)
    return all(compiled().move(map, rob.r, rob.motion, *step) for step in steps)  # the first one fails, or none


def correct_known_lmks(map, rob, sen, lmks, obs, raw, opt):
    """Correct the map with the landmarks that are in it: see `slam.correct_known_lmks`."""
    near = check_measurements(map, raw, sen)
    if core.as_written(sen.model):
        whole(map, rob, lmks, opt)
        return core.correct_known_lmks(map, rob, sen, lmks, obs, raw, opt)
    Rf, Sf = normal_frame(map, rob, rob.motion.frame), normal_frame(map, sen, sen.frame_type)
    if opt.first_estimates:
        note_first_estimates(map, rob, lmks)
    id = sen.id
    others = {key: o for key, o in obs.items() if key[0] != id}
    obs.clear()
    if others:
        obs.update(others)
    if not opt.joint:
        return correct_one_by_one(map, rob, sen, lmks, obs, raw, opt, Rf, Sf)
    gate = opt.md2_threshold if near else min(opt.md2_threshold, LARGEST)
    return correct_jointly(map, rob, sen, lmks, obs, raw, opt, Rf, Sf, gate)


def whole(map, rob, lmks, opt):
    """Let all states of a lazy map follow: the plain steps ask for the whole of it."""
    if not map.all_active and (referred := before(map, rob, opt)) is not None:
        follow(map, rob, all_parts(map, lmks), referred)


def correct_met_robots(map, rob, sen, robs, raw, opt, lmks=None):
    """Correct the map with sightings of other robots: see `slam.correct_met_robots`."""
    if len(raw.ids):
        whole(map, rob, lmks or {}, opt)
    return core.correct_met_robots(map, rob, sen, robs, raw, opt, lmks)


def correct_without_lmks(map, rob, sen, obs, raw, opt, lmks):
    """Correct the map with measurements of the robot's own state: see `slam.correct_without_lmks`."""
    if len(raw.ids):
        whole(map, rob, lmks, opt)
    return core.correct_without_lmks(map, rob, sen, obs, raw, opt, lmks)
