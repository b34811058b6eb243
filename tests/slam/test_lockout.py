"""A landmark that a gate has locked out is tried again: it becomes uncertain, and what is measured of it passes."""

import numpy as np
import pytest

from ekfslam_tutorial.models.landmarks import AhmPnt, EucPnt, HmgPnt, IdpPnt
from ekfslam_tutorial.slam import Event, Options, retry_lmks
from ekfslam_tutorial.toolbox import UserData, universal_slam

from .scenes import Scene

REFUSED, ACCEPTED = Event("innovation", 1, 1, 7, False), Event("innovation", 1, 1, 7, True)
P3 = 1e-4 * np.eye(3)


def scene(kind=None, **options):
    """A robot and landmark 7, both in the map."""
    kind = kind or EucPnt(2)
    scene = Scene(kind.dim, P=None if kind.dim == 3 else P3, lmk_type=kind, **{"retry_after": 3} | options)
    l = kind.from_point(np.array([3.0, 1.0, 2.0][: kind.dim]))[0]
    scene.add(7, l, 1e-4 * np.eye(len(l)))
    return scene


@pytest.mark.parametrize("kind", [EucPnt(2), AhmPnt(2), HmgPnt(2), EucPnt(3), IdpPnt(), AhmPnt(), HmgPnt()], ids=str)
def test_the_landmark_becomes_more_uncertain_and_nothing_else_changes(kind):
    """By as much in all directions, whatever its type."""
    ours = scene(kind, reopen_std=(0.3, 0.5))
    lmk, x, P = ours.lmks[7], ours.map.x.copy(), ours.map.P.copy()
    _, before = lmk.point(ours.map)
    (event,) = retry_lmks(ours.map, ours.rob, [REFUSED] * 3, ours.opt, ours.lmks)
    assert event == Event("recovery", 1, 1, 7) and lmk.n_refused == 0
    assert np.allclose(lmk.point(ours.map)[1] - before, 0.3**2 * np.eye(kind.dim), rtol=0, atol=1e-12)
    added = ours.map.P - P
    added[lmk.r, lmk.r] = 0.0
    assert np.array_equal(ours.map.x, x) and not added.any()


def test_refusals_of_a_landmark_are_counted_in_a_row():
    ours = scene()
    P, retry = ours.map.P.copy(), lambda *events: retry_lmks(ours.map, ours.rob, list(events), ours.opt, ours.lmks)
    assert retry(REFUSED, REFUSED) == [] and retry() == [] and ours.lmks[7].n_refused == 2
    assert retry(ACCEPTED) == [] and ours.lmks[7].n_refused == 0
    assert retry(REFUSED, Event("innovation", 1, 1, 8, False), Event("search", 1, 1, 7), REFUSED) == []
    assert np.array_equal(ours.map.P, P) and len(retry(REFUSED)) == 1


def test_when_the_robot_was_lost_the_landmarks_were_not_to_blame():
    ours = scene()
    retry = lambda *events: retry_lmks(ours.map, ours.rob, list(events), ours.opt, ours.lmks)
    assert retry(REFUSED, REFUSED) == [] and retry(REFUSED, Event("recovery", 1, 1, -1)) == []
    assert ours.lmks[7].n_refused == 0


def test_never_unless_asked_and_never_a_known_one():
    ours = scene(retry_after=None)
    assert retry_lmks(ours.map, ours.rob, [REFUSED] * 9, ours.opt, ours.lmks) == [] and ours.lmks[7].n_refused == 0
    known = Scene(P=P3, retry_after=1)
    known.add(7, [3.0, 1.0])
    assert retry_lmks(known.map, known.rob, [REFUSED] * 9, known.opt, known.lmks) == []
    with pytest.raises(ValueError, match="retry_after must be a whole number of 1 or more, or None, got 0"):
        Options(retry_after=0)


WORLD = {
    "time": {"dt": 0.5, "last": 60},
    "world": {"type": "lecture"},
    "robot": [{"motion": "unicycle", "position": [0, -4], "v": 1.0, "w_deg": 14.4, "v_std": 0.02, "w_std_deg": 0.5}],
    "sensor": [{"type": "range_bearing", "range_std": 0.1, "bearing_std_deg": 1.0, "max_range": 8.0}],
}


@pytest.mark.parametrize("how", [{"engine": "plain"}, {}, {"compressed": True}], ids=["plain", "fast", "compressed"])
@pytest.mark.parametrize("error", ["additive", "invariant"])
@pytest.mark.parametrize("after", [None, 4])
def test_a_landmark_in_the_wrong_place_comes_back(how, error, after):
    """In frame 10 the map has it a metre off. It is refused for good; or it is tried again, and comes back."""
    options = {"md2_threshold": 13.8, "error": error} | how | ({} if after is None else {"retry_after": after})
    events = []
    for now in universal_slam(UserData.from_dict(WORLD | {"options": options})):
        events += now.events if now.k > 10 else []
        if now.k == 10:
            id = next(iter(now.lmks))
            now.map.x[now.lmks[id].r] += [1.0, -0.5]
    own = [e.flag for e in events if e.kind == "innovation" and e.lmk == id]
    off = np.linalg.norm(now.lmks[id].point(now.map)[0] - now.sim_lmk.points[now.sim_lmk.ids == id][0])
    tried = [e.lmk for e in events if e.kind == "recovery"]
    if after is None:
        assert not any(own) and off > 0.9 and not tried
    else:
        assert all(own[-10:]) and off < 0.3 and set(tried) == {id}


def test_both_engines_do_the_same():
    ends = []
    for engine in "plain", "fast":
        options = {"md2_threshold": 2.0, "retry_after": 2, "engine": engine}
        ends.append([now.events for now in universal_slam(UserData.from_dict(WORLD | {"options": options}))])
    assert ends[0] == ends[1] and any(e.kind == "recovery" for frame in ends[0] for e in frame)
