"""Edges of the steps: what just counts, what just does not, and what is to be left alone."""

from types import SimpleNamespace

import numpy as np
import pytest

from ekfslam_tutorial.ekf import Map
from ekfslam_tutorial.fast import tidy
from ekfslam_tutorial.geometry import Frame2
from ekfslam_tutorial.models.motion import Odometry2
from ekfslam_tutorial.models.sensors import PinHoleDepth, RangeBearing
from ekfslam_tutorial.slam import Jcbb, KnownIds, Options, Rob, Sen, association, correct_met_robots, place, reopen_gate
from ekfslam_tutorial.slam.objects import Event
from ekfslam_tutorial.slam.upkeep import free_slot, most_uncertain, well_inside

from .scenes import Scene, raw

# --- who may start, who comes first ---


class Strip:
    """A sensor that does not say its units and sees numbers between 0 and 10."""

    units = ("px", "px")

    def visible(self, y, v):
        return ((y >= 0) & (y <= 10)).all(-1)

    def retro(self, y):
        return y, np.eye(y.shape[-1])


@pytest.mark.parametrize("y", [[2.0, 5.0], [8.0, 5.0], [5.0, 2.0], [5.0, 8.0]])
def test_a_margin_counts_on_both_sides_of_each_number(y):
    sensor, y = Strip(), np.array(y)
    assert well_inside(sensor, y, 2.0) and not well_inside(sensor, y, 2.001) and well_inside(sensor, y, 0.0)
    sensor.units = ("px", "m")  # the second is of another unit: left alone
    assert well_inside(sensor, y, 2.001) == (y[0] == 5.0)


def test_a_sensor_without_units_has_one_for_all():
    class Plain(Strip):
        units = property()

    assert not hasattr(Plain(), "units")
    assert well_inside(Plain(), np.array([5.0, 2.0]), 2.0) and not well_inside(Plain(), np.array([5.0, 2.0]), 2.1)


def test_a_depth_needs_no_margin():
    camera = PinHoleDepth()
    assert well_inside(camera, np.array([320.0, 240.0, 1.0]), 200.0)


def uncertain(*dets):
    return [SimpleNamespace(E=np.diag([d, 1.0]), id=i) for i, d in enumerate(dets)]


def test_equally_uncertain_ones_stay_in_their_order():
    ids = lambda *args: [o.id for o in most_uncertain(uncertain(*args[:-1]), args[-1])]
    assert ids(1.0, 3.0, 1.0, 3.0, 2.0, None) == [1, 3, 4, 0, 2]
    assert ids(1.0, 3.0, 1.0, 3.0, 2.0, 2) == [1, 3] and ids(1.0, 2.0, 0) == [] and most_uncertain([], 3) == []


def test_rounding_does_not_decide_who_is_more_uncertain():
    dets = [1.0, 3.0, 1.0 + 1e-9, 3.0 - 1e-9, 1.0 + 1e-5]
    assert [o.id for o in most_uncertain(uncertain(*dets), None)] == [1, 3, 4, 0, 2]
    table = SimpleNamespace(E=np.array([o.E for o in uncertain(*dets)]))
    assert tidy.most_uncertain(table, list(range(5)), None) == [1, 3, 4, 0, 2]


def test_the_first_free_slot():
    slots = lambda *used: free_slot([SimpleNamespace(slot=s) for s in used])
    assert [slots(), slots(0), slots(1), slots(0, 1, 3), slots(2, 0, 1)] == [0, 1, 0, 2, 3]


# --- where things start ---


def test_a_start_that_is_none():
    rob, sen = Rob(1, Odometry2()), Sen(2, 1, RangeBearing(0.1, 0.1), Frame2)
    for thing, name in ((rob, "Rob 1"), (sen, "Sen 2")):
        for bad in (np.zeros(2), np.zeros(4), [0.0, np.nan, 0.0], [np.inf, 0.0, 0.0], np.zeros((1, 3))):
            with pytest.raises(ValueError, match=f"{name}: the state must be 3 finite numbers, got"):
                place(Map(), thing, bad)
    start = np.array([1.0, 2.0, 3.0])
    place(Map(), rob, start)
    start[:] = 0  # a known state is a copy
    assert rob.x.tolist() == [1.0, 2.0, 3.0] and rob.r is None
    map = Map()
    place(map, rob, start, np.eye(3))
    assert rob.x is None and rob.r == slice(0, 3)


# --- a robot that is lost ---


def lost(n, **options):
    """A robot that looks along its y axis, with n refusals behind it."""
    map, rob = Map(), Rob(1, Odometry2(), n_refused=n)
    place(map, rob, np.array([1.0, 2.0, 0.5]), np.diag([0.01, 0.02, 0.003]))
    return map, rob, Options(**{"reopen_after": 5, "reopen_std": (0.3, 0.5)} | options)


def said(*flags):
    return [Event("search", 1, 7, 3, True), *(Event("innovation", 1, 7, 3, flag) for flag in flags)]


def test_the_gate_opens_with_the_refusal_that_was_asked_for():
    map, rob, opt = lost(3)
    assert reopen_gate(map, rob, said(False), opt) == [] and rob.n_refused == 4
    [event] = reopen_gate(map, rob, said(False), opt)
    assert event == Event("recovery", 1, 7, -1) and rob.n_refused == 0
    assert np.allclose(map.x, [1.0, 2.0, 0.5])  # the mean stays
    assert np.allclose(map.P, np.diag([0.01 + 0.09, 0.02 + 0.09, 0.003 + 0.25]))  # metres, then radians


def test_one_that_passes_begins_the_count_anew():
    map, rob, opt = lost(4)
    assert reopen_gate(map, rob, said(False, True, False, False), opt) == [] and rob.n_refused == 2
    assert reopen_gate(map, rob, [Event("search", 1, 7, 3, False)], opt) == [] and rob.n_refused == 2


def test_without_events_nothing_opens():
    map, rob, opt = lost(9)
    assert reopen_gate(map, rob, [], opt) == [] and rob.n_refused == 9
    off = lost(9, reopen_after=None)
    assert reopen_gate(off[0], off[1], said(False), off[2]) == [] and off[1].n_refused == 10
    place(map, rob, np.zeros(3))  # a known robot is not lost
    assert reopen_gate(map, rob, said(False), opt) == []


# --- robots that see each other ---


def three_robots():
    map, robs = Map(), []
    for id, x in ((1, [0.0, 0.0, 0.0]), (2, [3.0, 1.0, 0.0]), (3, [2.0, -1.0, 0.5])):
        robs.append(Rob(id, Odometry2()))
        place(map, robs[-1], np.array(x), np.diag([0.04, 0.04, 0.01]))
    sen = Sen(1, 1, RangeBearing(0.1, 0.02), Frame2, x=np.zeros(3))
    return map, robs, sen


def met(ids, far=0.0, R=None):
    places = {1: [0.5, 0.5], 2: [3.0, 1.0], 3: [2.0, -1.0], 9: [1.0, 1.0]}
    p = np.array([places[id] for id in ids])
    return raw(ids, np.stack([np.hypot(*p.T) + far, np.arctan2(p[:, 1], p[:, 0])], -1) + 0.01, R)


def test_who_is_not_there_and_who_looks_are_passed_over():
    """In the middle of others: these still count."""
    (map, robs, sen), (other, others, _) = three_robots(), three_robots()
    events = correct_met_robots(map, robs[0], sen, robs, met([9, 2, 1, 3]), Options())
    assert [(e.kind, e.lmk, e.flag) for e in events] == [("meeting", 2, True), ("meeting", 3, True)]
    correct_met_robots(other, others[0], sen, others, met([2, 3]), Options())
    assert np.array_equal(map.x, other.x) and np.array_equal(map.P, other.P)


def test_a_sighting_outside_of_the_gate_changes_nothing():
    map, robs, sen = three_robots()
    x, P = map.x.copy(), map.P.copy()
    events = correct_met_robots(map, robs[0], sen, robs, met([2], far=5.0), Options(md2_threshold=9.0))
    assert [e.flag for e in events] == [False] and np.array_equal(map.x, x) and np.array_equal(map.P, P)


def test_each_sighting_has_its_own_noise():
    weak, strong = 100.0 * np.eye(2), 1e-4 * np.eye(2)
    moved = {}
    for name, R in (("second is good", [weak, strong]), ("first is good", [strong, weak])):
        map, robs, sen = three_robots()
        correct_met_robots(map, robs[0], sen, robs, met([2, 3], R=np.array(R)), Options())
        moved[name] = np.abs(map.P.diagonal()[3:5]).sum(), np.abs(map.P.diagonal()[6:8]).sum()
    assert moved["first is good"][0] < 0.9 * moved["second is good"][0]
    assert moved["second is good"][1] < 0.9 * moved["first is good"][1]


# --- association ---


def corridor(n, **options):
    scene = Scene(P=np.diag([0.04, 0.04, 0.01]), **options)
    for id in range(1, n + 1):
        scene.add(id, [2.0 + id, 0.3 * (-1) ** id], 0.01 * np.eye(2))
    return scene


def search(scene, seen, **more):
    expected = association_obs(scene)
    jcbb = Jcbb(**more)
    return association._Search(
        jcbb, scene.map, expected, seen, scene.sen.model, candidates(expected, seen, scene, jcbb)
    )


def association_obs(scene):
    from ekfslam_tutorial.slam import project_lmks

    return project_lmks(scene.map, scene.rob, scene.sen, scene.lmks.values())


def candidates(expected, seen, scene, jcbb):
    D = association.distances(expected, seen, scene.sen.model)
    limit = association.gate(jcbb.confidence, 2)
    return [np.array(sorted(np.flatnonzero(row <= limit), key=lambda j, row=row: row[j]), int) for row in D]


def test_branches_that_cannot_win_are_cut():
    """Where the first hypothesis is right, few others are looked at: without the bound they are thousands."""
    scene = corridor(6)
    seen = scene.see({id: lmk.state(scene.map) for id, lmk in scene.lmks.items()})
    found = search(scene, seen)
    assert found.best == list(range(6)) and found.best_key[0] == 6
    assert found.nodes < 40


def test_a_search_that_is_stopped_keeps_the_best_so_far():
    scene = corridor(6)
    seen = scene.see({id: lmk.state(scene.map) for id, lmk in scene.lmks.items()})
    assert search(scene, seen, max_nodes=6).best == list(range(6))  # the nodes on the way to the first hypothesis
    assert search(scene, seen, max_nodes=5).best == [None] * 6


@pytest.mark.parametrize("kind", [association.NearestNeighbour, Jcbb])
def test_each_measurement_is_gated_with_its_own_noise(kind):
    """The same distance is near for a bad measurement, and far for a good one."""
    scene = corridor(2, association=kind())
    seen = scene.see({id: lmk.state(scene.map) for id, lmk in scene.lmks.items()})
    seen.y[:, 0] += 1.2
    good, bad = np.diag([1e-4, 1e-4]), np.diag([1.0, 1e-4])
    expected = association_obs(scene)
    for R, paired in (([good, bad], {2: 1}), ([bad, good], {1: 0})):
        seen.R = np.array(R)
        assert scene.opt.association(scene.map, expected, seen, scene.sen.model).pairs == paired


def test_ids_are_matched_in_any_order():
    scene = corridor(3, association=KnownIds())
    seen = scene.see({3: [5.0, -0.3], 1: [3.0, -0.3], 8: [1.0, 1.0]})
    matches = scene.opt.association(scene.map, association_obs(scene), seen, scene.sen.model)
    assert matches.pairs == {3: 0, 1: 1} and 2 in matches.new
