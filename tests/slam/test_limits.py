"""Limits of the steps: what is exactly at a gate, a count or a share, and the next number to it."""

import numpy as np
import pytest

from ekfslam_tutorial import fast, slam
from ekfslam_tutorial.models.landmarks import AhmPnt, EucPnt, IdpPnt
from ekfslam_tutorial.models.motion import Odometry2
from ekfslam_tutorial.slam import (
    KnownIds,
    NearestNeighbour,
    Options,
    Rob,
    correct_known_lmks,
    correct_met_robots,
    init_new_lmks,
    let_go,
    place,
    project_lmks,
)
from ekfslam_tutorial.slam.association import far
from ekfslam_tutorial.slam.projection import by_type
from ekfslam_tutorial.slam.upkeep import tidy

from .scenes import SMALL7, Scene, raw

P3 = np.diag([0.01, 0.02, 0.001])


def one_post(**options):
    scene = Scene(P=P3, **options)
    scene.add(1, [3.0, 0.5], 0.01 * np.eye(2))
    return scene, raw([1], [[3.2, 0.1]])


@pytest.mark.parametrize("joint", [False, True], ids=["one by one", "joint"])
def test_at_the_gate_itself_a_measurement_is_refused(joint):
    """'Of this or more is not used': the next larger gate takes it."""
    scene, seen = one_post(joint=joint)
    correct_known_lmks(*scene.all, scene.obs, seen, scene.opt)
    gate = scene.obs[1, 1].md2
    for threshold, used in ((gate, False), (np.nextafter(gate, np.inf), True)):
        scene, seen = one_post(joint=joint, md2_threshold=threshold)
        correct_known_lmks(*scene.all, scene.obs, seen, scene.opt)
        assert scene.obs[1, 1].updated == used and scene.obs[1, 1].md2 == gate


def test_at_the_gate_itself_a_met_robot_is_refused():
    def meet(threshold):
        scene = Scene(P=P3, md2_threshold=threshold)
        other = Rob(2, Odometry2())
        place(scene.map, other, np.array([3.0, 0.5, 0.2]), P3)
        [event] = correct_met_robots(
            scene.map, scene.rob, scene.sen, [scene.rob, other], raw([2], [[3.2, 0.1]]), scene.opt
        )
        return event.flag

    low, high = 1e-3, 1e3
    assert not meet(low) and meet(high)
    while np.nextafter(low, np.inf) < high:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if meet(middle) else (middle, high)
    scene = Scene(P=P3)
    scene.add(2, [3.0, 0.5], P3[:2, :2])  # the same place as a landmark
    correct_known_lmks(*scene.all, scene.obs, raw([2], [[3.2, 0.1]]), scene.opt)
    assert low == scene.obs[1, 2].md2


@pytest.mark.parametrize(("n_search", "deleted"), [(4, False), (5, True), (6, True)])
def test_who_is_looked_for_just_often_enough_may_be_deleted(n_search, deleted):
    scene, _ = one_post(min_search=6, min_match_ratio=0.9)
    scene.lmks[1].n_search = n_search  # and once more
    events, _ = correct_known_lmks(*scene.all, scene.obs, raw([], np.zeros((0, 2))), scene.opt)
    assert (1 not in scene.lmks) == deleted and (events[-1].kind == "deletion") == deleted


def test_a_landmark_that_is_not_looked_for_is_not_counted():
    """`n_updates` leaves some out: they are not searched, nor found, nor deleted for it."""
    for joint in (False, True):
        scene = Scene(P=P3, n_updates=1, joint=joint)
        for id, p in {1: [3.0, 0.0], 2: [0.0, 3.0]}.items():
            scene.add(id, p, 0.01 * id * np.eye(2))
        correct_known_lmks(*scene.all, scene.obs, scene.see({1: [3.0, 0.1], 2: [0.1, 3.0]}), scene.opt)
        counts = [(m.n_search, m.n_match, m.n_inlier) for m in scene.lmks.values()]
        assert counts == [(1, 1, 1), (2, 2, 2)]
        assert [scene.obs[1, id].measured for id in (1, 2)] == [False, True]
        assert [scene.obs[1, id].index for id in (1, 2)] == [None, 1]


# --- association ---


def test_zero_is_an_id_and_minus_one_is_none():
    scene = Scene(P=P3)
    for id in (0, 3):
        scene.add(id, [3.0 + id, 0.0], 0.01 * np.eye(2))
    obs = project_lmks(*scene.all[:3], scene.lmks.values())
    found = KnownIds()(scene.map, obs, raw([-1, 0, 0, 3, -1, 7], np.ones((6, 2))), scene.sen.model)
    assert found.pairs == {0: 1, 3: 3} and found.new == [1, 3, 5]  # of two the first
    assert KnownIds().birth_id(raw([0, 3], np.ones((2, 2))), 1, {0: None}) == 3
    assert KnownIds().birth_id(raw([0, 3], np.ones((2, 2))), 0, {0: None}) is None


def test_a_distance_at_the_gate_is_near():
    """For a pair, and for a start: `<=` in both, and NaN is not near."""
    D = np.array([[4.0, 9.0], [np.nan, 5.0]])
    lmks = [type("Obs", (), {"lmk": id})() for id in (7, 8)]
    assert NearestNeighbour._mutual(D[:1], lmks, 4.0) == {7: 0}
    assert NearestNeighbour._mutual(D[:1], lmks, np.nextafter(4.0, 0.0)) == {}
    assert far(D, 4.0) == [1] and far(D, np.nextafter(4.0, 0.0)) == [0, 1] and far(D, 5.0) == []
    assert far(np.full((2, 1), np.nan), 9.0) == [0, 1] and far(np.zeros((2, 0)), 9.0) == [0, 1]


def test_landmarks_are_computed_together_that_are_alike():
    """Of one type, and all in the map or all known."""
    scene = Scene(P=P3)
    kinds = {1: np.eye(2), 2: None, 3: np.eye(2), 4: None}
    for id, P in kinds.items():
        scene.add(id, [3.0, id], P)
    scene.lmks[5] = type(scene.lmks[1])(5, EucPnt(3), x=np.zeros(3))
    assert [[lmk.id for lmk in group] for group in by_type(scene.lmks.values())] == [[1, 3], [2, 4], [5]]


# --- births ---


@pytest.mark.parametrize("engine", [slam, fast], ids=["plain", "fast"])
def test_each_birth_has_the_noise_of_its_own_measurement(engine):
    """In any order, some of them in the map already: P of the new one is L_y R L_y', R its own."""
    stds = np.array([0.3, 0.01, 0.1, 0.02])
    R = stds[:, None, None] ** 2 * np.eye(2)
    map, scene = engine.new_map(), Scene()
    engine_args = map, scene.rob, scene.sen, {}
    seen = raw([4, 1, 3, 2], [[2.0, 0.0]] * 4, R)
    engine.init_new_lmks(*engine_args, seen, [2, 0, 3, 1], scene.opt)
    for i, id in enumerate([4, 1, 3, 2]):
        P = map.block(engine_args[3][id].r)
        np.testing.assert_allclose(P, stds[i] ** 2 * np.diag([1.0, 4.0]), rtol=1e-12, atol=1e-18)
    again = engine.init_new_lmks(*engine_args, seen, [0, 1], scene.opt)
    assert again == [] and map.n_used == 8


def test_how_many_start_at_most():
    for n_max, n in ((None, 3), (3, 3), (2, 2), (1, 1), (0, 0)):
        scene = Scene(P=P3)
        events = init_new_lmks(*scene.all, raw([5, 6, 7], [[3.0, 0.0]] * 3), [2, 0, 1], scene.opt, n_max)
        assert [e.lmk for e in events] == [7, 5, 6][:n]
    for max_lmks, n in ((0, 0), (1, 1), (None, 3)):
        scene = Scene(P=P3, max_lmks=max_lmks)
        events = init_new_lmks(*scene.all, raw([5, 6, 7], [[3.0, 0.0]] * 3), [0, 1, 2], scene.opt)
        assert len(scene.lmks) == n and [e.kind for e in events] == ["initialisation"] * n + ["refused"] * (3 - n)


def test_a_prior_is_for_sensors_without_range_only():
    """One that measures the distance starts a landmark without it, whatever the options say."""
    ends = []
    for n, N in ((0.01, 0.25), (0.5, 4.0)):
        scene = Scene(P=P3, n=n, N=N)
        init_new_lmks(*scene.all, raw([5], [[3.0, 0.2]]), [0], scene.opt)
        ends.append(scene.map.P)
        assert scene.lmks[5].n.shape == (0,) and scene.lmks[5].N.shape == (0, 0) and scene.lmks[5].first is None
    assert np.array_equal(*ends)


# --- bad input ---


def test_one_prior_for_each_number_that_is_left_open():
    assert Options(n=0.3, N=0.5).N.tolist() == [[0.5]] and Options(n=[1, 2], N=np.eye(2)).n.tolist() == [1.0, 2.0]
    for n, N in ((0.3, np.eye(2)), ([0.1, 0.2], 0.5), (0.3, -0.1), (0.3, np.nan)):
        with pytest.raises(ValueError, match="the covariance N of the prior must"):
            Options(n=n, N=N)


def test_when_a_landmark_is_tried_again_nobody_says():
    assert Options().retry_after is None and Options(retry_after=1).retry_after == 1
    for bad in (0, -1, 1.5, True):
        with pytest.raises(ValueError, match="retry_after must be a whole number of 1 or more, or None"):
            Options(retry_after=bad)
    assert type(Scene().add(1, [0.0, 0.0]))(1, EucPnt(2)).n_refused == 0


# --- the order of what is equal ---


def four_alike(joint, **options):
    """Landmarks that are expected as well as each other; their slots go against the order in which they are kept."""
    scene = Scene(P=np.zeros((3, 3)), joint=joint, **options)
    for k, id in enumerate((5, 3, 8, 1)):
        scene.add(id, [3.0, 0.0], 0.01 * np.eye(2)).slot = 3 - k
    return scene, scene.see({id: [3.0, 0.0] for id in (8, 5, 1, 3)})


@pytest.mark.parametrize("engine", [slam, fast], ids=["plain", "fast"])
def test_who_comes_first_among_equals(engine):
    """One by one, and with a limit: by their slots, as in the manual. All at once: as they are kept."""
    for joint, n_updates, wanted in (
        (False, None, [1, 8, 3, 5]),
        (False, 2, [1, 8]),
        (True, None, [5, 3, 8, 1]),
    ):
        scene, seen = four_alike(joint, n_updates=n_updates)
        if engine is fast:
            map = fast.new_map()
            map.add(scene.map.x[:3], scene.map.P[:3, :3])
            for lmk in scene.lmks.values():
                lmk.r = map.add(scene.map.state(lmk.r), scene.map.block(lmk.r))
            scene.map = map
        events, _ = engine.correct_known_lmks(*scene.all, scene.obs, seen, scene.opt)
        assert [event.lmk for event in events if event.kind == "search"] == wanted
        assert [id for _, id in scene.obs] == ([5, 3, 8, 1] if joint else [1, 8, 3, 5])


@pytest.mark.parametrize("kind", [AhmPnt(), IdpPnt()], ids=str)
def test_a_landmark_at_the_limit_itself_is_not_linear_enough(kind):
    scene = Scene(d=3, P=SMALL7, lmk_type=kind)
    l, camera = kind.from_point(np.array([4.0, 0.5, 0.2]))[0], np.array([0.1, 0.2, 0.3])
    lmk = scene.add(1, l, 1e-4 * np.eye(len(l)))
    limit = kind.linearity(l, scene.map.block(lmk.r), camera)
    for lin_test, wanted in ((limit, kind), (np.nextafter(limit, np.inf), EucPnt(3))):
        tidy(scene.map, lmk, camera, Options(reparametrize=True, lin_test=lin_test))
        assert lmk.type == wanted


@pytest.mark.parametrize("n", [0, 2, 3])
def test_a_track_is_lost_after_just_so_many_looks(n):
    scene = Scene(P=P3, lost_after=3)
    scene.add(1, [3.0, 0.5], 0.01 * np.eye(2)).n_missed = n
    done = let_go(*scene.all, [], scene.opt)
    assert [e.kind for e in done] == (["deletion"] if n + 1 >= 3 else []) and (1 in scene.lmks) == (n + 1 < 3)


def test_known_landmarks_are_never_lost():
    scene = Scene(P=P3, lost_after=1)
    scene.add(1, [3.0, 0.5])
    assert let_go(*scene.all, [], scene.opt) == [] and scene.lmks[1].n_missed == 1
