"""State of a run after one of its frames, as nested values: enough to go on from there to the same end, bit for bit."""

from dataclasses import fields

from ..slam import Lmk
from ..slam.upkeep import EUCLIDEAN
from .rings import Ring

ROB = ("x", "r", "n_refused", "first")
SEN = ("x", "r")
LMK = [f.name for f in fields(Lmk) if f.name != "type"]
RING = [f.name for f in fields(Ring) if f.name != "type"]


def run_state(snapshot, data):
    """Take the state of a run, as nested values for `value_file.save`.

    The random numbers of a simulation are not a part of it: the robots of the world are driven through their frames
    again, which takes no estimation.

    Parameters
    ----------
    snapshot : Snapshot
    data : UserData

    Returns
    -------
    dict
    """
    types = _types(data, snapshot.sens)
    lmks = [{name: getattr(lmk, name) for name in LMK} for lmk in snapshot.lmks.values()]
    return {
        "frames": snapshot.k - data.time.first + 1,
        "map": _without_records(snapshot.map.__getstate__()),
        "robs": [{name: getattr(rob, name) for name in ROB} for rob in snapshot.robs],
        "sens": [{name: getattr(sen, name) for name in SEN} for sen in snapshot.sens],
        "lmks": lmks,
        "types": [types.index(lmk.type) for lmk in snapshot.lmks.values()],
        "rings": [{name: getattr(ring, name) for name in RING} for ring in snapshot.rings.values()],
        "ring_types": [types.index(ring.type) for ring in snapshot.rings.values()],
        "refused": snapshot.refused,
    }


def restore(state, data, map, robs, sens):
    """Put the state of a run into fresh structures.

    Parameters
    ----------
    state : dict
        From `run_state`.
    data : UserData
    map, robs, sens
        As `create_slam_structures` makes them of the same data.

    Returns
    -------
    lmks : dict of int to Lmk
    refused : set of int
    rings : dict of int to Ring
    """
    getattr(map, "__setstate__", vars(map).update)(state["map"])
    for things, kept in ((robs, state["robs"]), (sens, state["sens"])):
        for thing, values in zip(things, kept, strict=True):
            for name, value in values.items():
                setattr(thing, name, value)
    types = _types(data, sens)
    lmks = [Lmk(type=types[t], **values) for t, values in zip(state["types"], state["lmks"], strict=True)]
    rings = [Ring(type=types[t], **values) for t, values in zip(state["ring_types"], state["rings"], strict=True)]
    return {lmk.id: lmk for lmk in lmks}, state["refused"], {ring.id: ring for ring in rings}


def _without_records(state):
    """The state of a map, or of the map in it: the robots put themselves there when a run begins."""
    inside = {name: _without_records(value) if name == "whole" else value for name, value in state.items()}
    return {name: value for name, value in inside.items() if name != "robs"}


def _types(data, sens):
    """All landmark types that a run of these data can have, always in the same order."""
    own = [data.slam_options().lmk_type, *(sen.lmk_type for sen in sens)]
    return [*EUCLIDEAN.values(), *(type for type in own if type is not None)]
