"""A plain and a compiled map, run side by side: everything that can be seen of them is compared in every frame.

Tolerances: both do the same operations in another order, so each step adds some 1e-15 of the numbers it works with; a
correction multiplies what is there by how much it depends on the state. In 40 frames that stays below 1e-9 of a number,
or of the standard deviations it belongs to.
"""

import copy
from dataclasses import replace

import numpy as np

from ekfslam_tutorial.toolbox import universal_slam

TOL = 1e-9
COLUMNS = "e", "v", "E_r", "E_s", "y", "R", "z", "E", "E_l", "md2"
FLAGS = "sen", "lmk", "index", "measured", "matched", "updated", "visible"


def near(a, b, floor=1e-12):
    """Two arrays, up to rounding of their largest number, or of the floor."""
    if a is None or b is None:
        return a is b
    a, b = np.asarray(a), np.asarray(b)
    scale = np.abs(b[np.isfinite(b)]).max(initial=floor)
    return a.shape == b.shape and np.allclose(a, b, rtol=TOL, atol=TOL * scale, equal_nan=True)


def assert_same_maps(plain, compiled):
    """Mean, covariance and who owns what; a difference is measured by the standard deviations."""
    assert compiled.compiled and not plain.compiled
    assert np.array_equal(plain.used, compiled.used) and plain.ranges == compiled.ranges
    P, P_c = copy.deepcopy(plain).P, copy.deepcopy(compiled).P  # a map of one triangle stays one
    assert np.array_equal(P_c, P_c.T)
    std = np.sqrt(np.diag(P).clip(0)) + 1e-7
    worst_x = np.abs(plain.x - compiled.x).max(initial=0.0) / max(1.0, np.abs(plain.x).max(initial=0.0))
    worst_P = (np.abs(P - P_c) / np.outer(std, std)).max(initial=0.0)
    assert worst_x < TOL and worst_P < 1e3 * TOL, (worst_x, worst_P)


def assert_same_obs(plain, compiled):
    """All that an observation tells."""
    for name in FLAGS:
        assert getattr(plain, name) == getattr(compiled, name), name
    if not plain.visible:
        return  # its numbers may be infinite, and then mean nothing
    for name in COLUMNS:
        if name == "E" and np.isnan(plain.E).all():
            continue  # of a landmark that no measurement can belong to: compiled code knows it all the same
        floor = {"md2": 1.0, "z": np.abs(plain.e).max()}.get(name, 1e-12)  # a small z is left of two large numbers
        assert near(getattr(compiled, name), getattr(plain, name), floor), name
    assert [r for r, _ in plain.blocks] == [r for r, _ in compiled.blocks]
    assert all(near(J_c, J) for (_, J), (_, J_c) in zip(plain.blocks, compiled.blocks, strict=True))


def assert_same(plain, compiled):
    """Two snapshots."""
    assert plain.events == compiled.events and plain.refused == compiled.refused
    assert list(plain.lmks) == list(compiled.lmks)
    for a, b in zip(plain.lmks.values(), compiled.lmks.values(), strict=True):
        for name in ("id", "type", "r", "slot", "n_search", "n_match", "n_inlier"):
            assert getattr(a, name) == getattr(b, name), name
    assert_same_maps(plain.map, compiled.map)
    assert list(plain.obs) == list(compiled.obs)
    for key, o in plain.obs.items():
        assert_same_obs(o, compiled.obs[key])


def side_by_side(data, recording=None, frames=40):
    """Run a scenario on both; they are compared after each frame.

    Returns
    -------
    plain, compiled : Snapshot
        The last ones.
    kinds : set of (str, bool)
        Kinds of all events, and whether they went well.
    """
    compiled = replace(data, options=replace(data.options, compiled=True, compressed=False))
    plain = replace(data, options=replace(data.options, compressed=False))
    kinds = set()
    for i, (a, b) in enumerate(zip(universal_slam(plain, recording), universal_slam(compiled, recording), strict=True)):
        assert_same(a, b)
        kinds |= {(e.kind, e.flag) for e in a.events}
        if i + 1 == frames:
            break
    return a, b, kinds
