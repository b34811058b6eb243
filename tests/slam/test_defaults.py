"""What holds where the user says nothing, and the edges of what may be said: somebody relies on each number."""

from dataclasses import MISSING, fields

import numpy as np
import pytest

from ekfslam_tutorial import slam
from ekfslam_tutorial.ekf import Map, MapFull, augment
from ekfslam_tutorial.models.landmarks import EucPnt
from ekfslam_tutorial.slam import Jcbb, KnownIds, Lmk, NearestNeighbour, Obs, Options, Rob, Sen

INF = np.inf
DEFAULTS = {
    NearestNeighbour: {"confidence": 0.99, "new_confidence": 1 - 1e-6},
    Jcbb: {"confidence": 0.99, "new_confidence": 1 - 1e-6, "max_nodes": 20_000},
    Lmk: {"slot": 0, "n_search": 1, "n_match": 1, "n_inlier": 1,
        "x": None, "r": None, "n": None, "N": None, "par": None,
        "n_refused": 0, "n_missed": 0, "first": None, "appearance": None},
    Rob: {"n_refused": 0, "name": "", "type": "", "x": None, "r": None, "u": None, "U": None, "dt": None,
        "first": None},
    Sen: {"name": "", "x": None, "r": None, "lmk_type": None, "tilt": 0.0, "walk": 0.0},
    Obs: {"visible": True, "y": None, "R": None, "z": None, "index": None, "measured": False,
        "matched": False, "updated": False},
    Options: {
        "lmk_type": None, "n": (0.01,), "N": ((0.25,),), "n_updates": None, "md2_threshold": INF, "reopen_after": None,
        "reopen_std": (0.3, 0.5), "retry_after": None, "reproject": True, "reparametrize": False, "lin_test": 0.1,
        "n_inits": None,
        "init_margin": 0.0, "max_lmks": None, "min_search": 10, "min_match_ratio": 0.0, "min_inlier_ratio": 0.0,
        "ends": "extend", "lost_after": None, "keep_lost": 0, "wander": 0.0,
        "min_rho": 1e-3, "joint": False, "error": None, "first_estimates": False,
    },
}  # fmt: skip


@pytest.mark.parametrize("kind", DEFAULTS, ids=lambda kind: kind.__name__)
def test_defaults(kind):
    given = {f.name: f.default for f in fields(kind) if f.default is not MISSING}
    assert given == DEFAULTS[kind]


def test_the_options_of_a_run_that_says_nothing():
    opt = Options()
    assert opt.n.tolist() == [0.01] and opt.N.tolist() == [[0.25]] and opt.association == KnownIds()


EDGES = {  # the last value that is allowed, and the first that is not
    "n_updates": [(0, -1)],
    "max_lmks": [(0, -1)],
    "reopen_after": [(1, 0)],
    "retry_after": [(1, 0)],
    "lost_after": [(1, 0)],
    "keep_lost": [(0, -1)],
    "wander": [(0.0, -1e-9), (1e300, INF)],
    "n_inits": [((0, 0), (-1, 0)), ((1, 0), (1, -1))],
    "reopen_std": [((0.0, 0.0), (-1e-9, 0.0)), ((0.0, 1e300), (0.0, INF)), ((1e300, 0.0), (INF, 0.0))],
    "min_search": [(0, -1)],
    "init_margin": [(0.0, -1e-9)],
    "md2_threshold": [(1e-300, 0.0), (INF, np.nan)],
    "lin_test": [(1e-300, 0)],
    "min_rho": [(1e-300, 0)],
    "min_match_ratio": [(0, -1e-9), (1, 1 + 1e-9), (1.0, 2)],
    "min_inlier_ratio": [(0, -1e-9), (1, 1 + 1e-9), (1.0, 2)],
}


@pytest.mark.parametrize("name", EDGES)
def test_the_edges_of_an_option(name):
    for good, bad in EDGES[name]:
        assert getattr(Options(**{name: good}), name) == good
        with pytest.raises(ValueError, match=f"{name} must be"):
            Options(**{name: bad})


@pytest.mark.parametrize("kind", [NearestNeighbour, Jcbb])
def test_the_edges_of_a_confidence(kind):
    kind(confidence=1e-9, new_confidence=1 - 1e-12)
    for bad in ({"confidence": 0.0}, {"confidence": 1.0}, {"new_confidence": 1.0}, {"new_confidence": 0.0}):
        with pytest.raises(ValueError):
            kind(**bad)


# --- the map ---------------------------------------------------------------------------------------------------------


def a_map():
    """States 0:2, 2:5 and 5:7."""
    map = Map()
    for k in (2, 3, 2):
        map.add(np.arange(k) + 1.0, np.eye(k))
    return map


@pytest.mark.parametrize(
    ("r", "near"),
    [
        (slice(2, 4), "2:5"),
        (slice(1, 3), "0:2, 2:5"),
        (slice(3, 4), "2:5"),
        (slice(0, 5), "0:2, 2:5"),
        (slice(5, 6), "5:7"),
    ],
)
def test_which_states_a_wrong_range_touches(r, near):
    """Those that it overlaps; those that it only borders on are not meant."""
    with pytest.raises(ValueError, match=f"range {r.start}:{r.stop} is not that of a state; there is {near}$"):
        a_map().remove(r)


@pytest.mark.parametrize("r", [slice(1, 3), slice(0, 2), slice(6, 8), slice(7, 8), slice(3, 3), slice(-2, 2)])
def test_a_range_that_is_partly_free_is_not_in_use(r):
    map = a_map()
    map.remove(slice(0, 2))
    before = map.P.tobytes()
    with pytest.raises(ValueError, match="is not in use in this map of 7 states"):
        map.remove(r)
    assert map.P.tobytes() == before and map.ranges == [slice(2, 5), slice(5, 7)]


def test_a_gap_takes_what_just_fits():
    map = a_map()
    map.remove(slice(2, 5))
    assert map.add(np.ones(4), np.eye(4)) == slice(7, 11)  # too long for the gap
    assert map.add(np.ones(3), np.eye(3)) == slice(2, 5)  # just as long
    map.remove(slice(2, 5))
    assert map.add(np.ones(1), np.eye(1)) == slice(2, 3) and map.add(np.ones(2), np.eye(2)) == slice(3, 5)
    assert [(r.start, r.stop) for r in map.ranges] == [(0, 2), (2, 3), (3, 5), (5, 7), (7, 11)] and map.n_used == 11


def test_a_capacity_is_what_may_be_in_use():
    """Not the extent: what was removed gives room again."""
    map = Map(5)
    first = map.add(np.ones(2), np.eye(2))
    map.add(np.ones(3), np.eye(3))  # just full
    with pytest.raises(MapFull, match="5 of 5 states are in use, a new state needs 1 more"):
        map.add(np.ones(1), np.eye(1))
    map.remove(first)
    with pytest.raises(MapFull, match="3 of 5 states are in use, a new state needs 3 more"):
        map.add(np.ones(3), np.eye(3))
    assert map.add(np.ones(2), np.eye(2)) == first and map.n == 5
    for bad in (0, -1, 1.5, "3"):
        with pytest.raises(ValueError, match="a map must be a positive number"):
            Map(bad)
    assert Map(1).capacity == 1


def test_what_is_removed_is_zero_and_only_that():
    map = a_map()
    map.P[:] = 0.1 + 2 * np.eye(7)
    map.remove(slice(2, 5))
    kept = [0, 1, 5, 6]
    assert not map.P[2:5].any() and not map.P[:, 2:5].any() and not map.x[2:5].any()
    assert (map.P[np.ix_(kept, kept)] == 0.1 + 2 * np.eye(4)).all() and map.used.tolist() == [
        i in kept for i in range(7)
    ]
    assert slam.new_map(3).capacity == 3


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_a_new_state_with_one_number_that_is_none(bad):
    """Told as what it is, a new state, before the map is asked."""
    r = (map := a_map()).ranges[0]
    l, Q, before = np.ones(2), np.eye(2), map.P.tobytes()
    l[1], Q[1, 1] = bad, 2.0
    for x, P in ((l, np.eye(2)), (np.ones(2), np.where(Q == 2.0, bad, Q))):
        with pytest.raises(ValueError, match="a new state must be finite, got .* with the covariance"):
            augment(map, x, ((r, np.eye(2)),), P)
    assert map.P.tobytes() == before and len(map.ranges) == 3


def test_what_is_not_shown_of_a_record():
    """Jacobians and pictures would fill the page; who has ids is asked for."""
    hidden = {kind: {f.name for f in fields(kind) if not f.repr} for kind in (Rob, Sen, Lmk, Obs)}
    assert hidden == {Rob: {"first"}, Sen: set(), Lmk: {"first", "appearance"}, Obs: {"blocks"}}
    shown = Lmk(7, EucPnt(2), x=np.zeros(2))._repr_html_()
    assert "n_missed" in shown and "appearance" not in shown and "first" not in shown
    o = Obs(1, 2, None, None, None, [(None, "by the robot"), (None, "by the sensor"), (None, "by the landmark")])
    assert (o.E_r, o.E_s, o.E_l) == ("by the robot", "by the sensor", "by the landmark")
    assert KnownIds.by_id is True and not hasattr(NearestNeighbour, "by_id") and not hasattr(Jcbb, "by_id")
