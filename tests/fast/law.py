"""The law of the wing, **fast is plain**: what is done with both engines, and how what comes out is compared.

Tolerances: both do the same sums in another order, so each step adds some 1e-15 of the numbers it works with; a
correction multiplies what is there by how much it depends on the state. In 40 frames that stays below 1e-9 of a number,
or of the standard deviations that it belongs to.
"""

import copy
from dataclasses import replace
from functools import partial
from importlib.util import find_spec
from typing import NamedTuple

import numpy as np

from ekfslam_tutorial import fast, slam
from ekfslam_tutorial.toolbox import universal_slam

TOL = 1e-9
NUMBERS = "e", "v", "E_r", "E_s", "y", "R", "z", "E", "E_l", "md2"
FLAGS = "sen", "lmk", "index", "measured", "matched", "updated", "visible"
LMK = "id", "type", "r", "slot", "n_search", "n_match", "n_inlier"


class Engine(NamedTuple):
    """Map and steps."""

    new_map: object
    move: object
    correct_known_lmks: object
    init_new_lmks: object


def _fast(new_map):
    return Engine(new_map, fast.move, fast.correct_known_lmks, fast.init_new_lmks)


def exact(how, error):
    """Return True if a kind of fast map has the numbers of the plain one: with the invariant error some are lazy."""
    return error == "additive" or "compressed" not in how


PLAIN = Engine(slam.new_map, slam.move, slam.correct_known_lmks, slam.init_new_lmks)
HOW = {"numpy": {}, "compressed": {"compressed": True}}
if find_spec("numba"):
    HOW |= {"compiled": {"compiled": True}, "compressed, compiled": {"compressed": True, "compiled": True}}


def fast_engines(active=8):
    """All kinds of fast maps; the compressed ones settle often."""
    few = lambda capacity=None, **how: fast.CompressedMap(capacity, active, **how)
    engines = {"numpy": _fast(fast.new_map), "compressed": _fast(few)}
    if find_spec("numba"):
        engines["compiled"] = _fast(partial(fast.new_map, compiled=True))
        engines["compressed, compiled"] = _fast(partial(few, compiled=True))
    return engines


# --- what is compared ------------------------------------------------------------------------------------------------


def near(a, b, floor=1e-12):
    """Return True if two arrays are the same up to rounding of their largest number, or of the floor."""
    if a is None or b is None:
        return a is b
    a, b = np.asarray(a, float), np.asarray(b, float)
    finite = np.isfinite(b)
    scale = np.abs(b[finite]).max(initial=floor)
    if a.shape == b.shape and finite.all():  # as allclose, in few steps: it is asked a dozen times for each observation
        return bool((np.abs(a - b) <= TOL * (scale + np.abs(b))).all())
    return a.shape == b.shape and np.allclose(a, b, rtol=TOL, atol=TOL * scale, equal_nan=True)


def assert_same_maps(plain, quick, whole=True):
    """Mean, covariance and who owns what; a difference is measured by the standard deviations.

    Asking a compressed map for all of P settles it: without `whole` it is asked for means and blocks only.
    """
    assert np.array_equal(plain.used, quick.used) and plain.ranges == quick.ranges
    assert (plain.n, plain.n_used, plain.capacity) == (quick.n, quick.n_used, quick.capacity)
    std = np.sqrt(np.diag(plain.P).clip(0)) + 1e-7
    pairs = [(plain.P[r, r], quick.block(r), std[r]) for r in plain.ranges]
    if whole:
        assert (np.abs(quick.P - quick.P.T) <= TOL * np.outer(std, std)).all()
        pairs = [(plain.P, quick.P, std)]
        worst_x = np.abs(plain.x - quick.x).max(initial=0.0)
    else:
        worst_x = max((np.abs(plain.x[r] - quick.state(r)).max() for r in plain.ranges), default=0.0)
    worst_P = max(((np.abs(a - b) / np.outer(s, s)).max(initial=0.0) for a, b, s in pairs), default=0.0)
    assert not worst_x > TOL * max(1.0, np.abs(plain.x).max(initial=0.0)), worst_x
    assert not worst_P > 1e3 * TOL, worst_P


def assert_same_obs(plain, quick):
    """Two dicts of observations: all that they tell.

    A text is made of what is compared here, by the same method for each: that of one observation is looked at.
    """
    assert plain.keys() == quick.keys()
    told = [repr(obs[key]).split(", expected")[0] for obs in (plain, quick) for key in list(obs)[:1]]
    assert len(set(told)) <= 1, told
    numbers = [pair for key, o in plain.items() for pair in _numbers(o, quick[key])]
    if not _all_near(numbers):
        bad = [name for name, *pair in numbers if not near(*pair)]
        assert not bad, bad


def _numbers(plain, quick):
    """Yield name, fast and plain array and floor of all that are to be compared; the rest has been."""
    for name in FLAGS:
        assert getattr(plain, name) == getattr(quick, name), name
    if not plain.visible:
        return  # its numbers may be infinite, and then mean nothing
    for name in NUMBERS:
        if name == "E" and np.isnan(quick.E).all():
            continue  # no measurement can belong to it, so nobody has asked for its covariance
        floor = {"md2": 1.0, "z": np.abs(plain.e).max()}.get(name, 1e-12)  # a small z is left of two large numbers
        yield name, getattr(quick, name), getattr(plain, name), floor
    assert [r for r, _ in plain.blocks] == [r for r, _ in quick.blocks]
    for (_, J), (_, J_q) in zip(plain.blocks, quick.blocks, strict=True):
        yield "blocks", J_q, J, 1e-12


def _all_near(numbers):
    """Return True if `near` would say so of each pair: a frame has a thousand of them, here they are one long array."""
    pairs = [(np.asarray(a, float), np.asarray(b, float), floor) for _, a, b, floor in numbers if a is not b]
    if not pairs:
        return True
    if any(a.shape != b.shape or not b.size for a, b, _ in pairs):
        return False
    *both, floors = zip(*pairs, strict=True)
    sizes = [each.size for each in both[1]]
    a, b = (np.concatenate([each.ravel() for each in some]) for some in both)
    if not np.isfinite(b).all():
        return False
    scale = np.maximum(np.maximum.reduceat(np.abs(b), np.cumsum([0, *sizes[:-1]])), floors)
    return bool((np.abs(a - b) <= TOL * (np.repeat(scale, sizes) + np.abs(b))).all())


def assert_same_lmks(plain, quick):
    """Two dicts of landmarks: what each is, where it is, what has happened to it."""
    assert list(plain) == list(quick)
    for a, b in zip(plain.values(), quick.values(), strict=True):
        for name in LMK:
            assert getattr(a, name) == getattr(b, name), name
        assert near(b.first, a.first)


def assert_same_frames(plain, quick, whole):
    """Two snapshots."""
    assert plain.events == quick.events and plain.refused == quick.refused
    assert_same_lmks(plain.lmks, quick.lmks)
    assert_same_maps(plain.map, quick.map, whole)
    assert_same_obs(plain.obs, quick.obs)


# --- whole runs ------------------------------------------------------------------------------------------------------


ALL = tuple(HOW.values())


def runs(data, recording, hows):
    """A run of the fast engine with each of these options, and beside each the error it has and a plain run with that.

    It is that of the scenario; lazy maps are held to the law with the additive one, `test_lazy.py` has the rest.
    """
    off = {"compiled": False, "compressed": False}
    start = lambda how: universal_slam(replace(data, options=replace(data.options, **off | how)), recording)
    given = data.options.error
    errors = [given if exact(how, given) else "additive" for how in hows]
    plain = {error: start({"engine": "plain", "error": error}) for error in sorted(set(errors))}
    return plain, [start({"engine": "fast", "error": e} | how) for e, how in zip(errors, hows, strict=True)], errors


def assert_same_runs(data, recording=None, frames=None, hows=ALL):
    """Run a scenario with the plain engine and with all kinds of the fast one; they are compared after each frame.

    Returns
    -------
    plain : Snapshot
        The last one, with the error of the first kind.
    kinds : set of (str, bool)
        Kinds of all events of the plain runs, and whether they went well.
    """
    kinds, (plain, quick, errors) = set(), runs(data, recording, hows)
    for i, (now, each) in enumerate(zip(zip(*plain.values(), strict=True), zip(*quick, strict=True), strict=True)):
        by_error = dict(zip(plain, now, strict=True))
        for how, error, fast_one in zip(hows, errors, each, strict=True):
            assert_same_frames(by_error[error], fast_one, whole="compressed" not in how)
        kinds |= {(e.kind, e.flag) for each_plain in by_error.values() for e in each_plain.events}
        if i + 1 == frames:
            break
    for error, fast_one in zip(errors, each, strict=True):
        assert_same_maps(by_error[error].map, copy.deepcopy(fast_one.map))
    return by_error[errors[0]], kinds
