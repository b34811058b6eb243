"""The steps of EKF-SLAM: what each changes, in which order, and what it leaves alone."""

import numpy as np
import pytest

from ekfslam_tutorial.ekf import Map, MapFull
from ekfslam_tutorial.geometry import Frame2, Frame3
from ekfslam_tutorial.models import observe
from ekfslam_tutorial.models.landmarks import AhmPnt, EucPnt, IdpPnt
from ekfslam_tutorial.models.motion import ConstantVelocity
from ekfslam_tutorial.models.sensors import Gps, RangeBearing
from ekfslam_tutorial.slam import (
    Lmk,
    Options,
    Rob,
    add_landmark,
    correct_known_lmks,
    correct_without_lmks,
    init_new_lmks,
    move,
    normalize,
    place,
    project_lmks,
    reopen_gate,
)

from .scenes import SMALL7, Scene, kinds, mixed_scene, raw

P3 = np.diag([0.01, 0.02, 0.001])


def corrected(scene, measurements, **changes):
    """One call of `correct_known_lmks`; returns events and new."""
    return correct_known_lmks(*scene.all, scene.obs, measurements, scene.opt)


# --- move ------------------------------------------------------------------------------------------------------------


def test_a_known_robot_moves_by_its_control_alone():
    scene = Scene(pose=[1.0, 2.0, np.pi / 2])
    lmk = scene.add(1, [0.0, 0.0], np.eye(2))
    scene.rob.u = np.array([1.0, 0.0, np.pi])
    move(scene.map, scene.rob, 0.1)
    assert np.allclose(scene.rob.x, [1.0, 3.0, -np.pi / 2])  # the heading is wrapped
    assert np.array_equal(scene.map.x[lmk.r], [0, 0]) and np.array_equal(scene.map.P, np.eye(2))


def test_an_estimated_robot_becomes_less_certain():
    scene = Scene(pose=[1.0, 2.0, 3.0], P=P3)
    scene.rob.u = np.array([1.0, 0.0, 0.3])
    move(scene.map, scene.rob, 0.1)
    F = np.array([[1, 0, -np.sin(3.0)], [0, 1, np.cos(3.0)], [0, 0, 1]])
    G = np.eye(3)
    G[:2, :2] = Frame2(np.array([0, 0, 3.0])).R
    assert np.allclose(scene.map.P, F @ P3 @ F.T + G @ scene.rob.U @ G.T)
    assert np.allclose(scene.map.x, [1 + np.cos(3.0), 2 + np.sin(3.0), 3.3 - 2 * np.pi])


def test_velocities_behind_the_frame_are_part_of_the_state():
    """Uncertain speed becomes uncertain place, and the two are correlated."""
    map, rob = Map(), Rob(1, ConstantVelocity(), u=np.zeros(6), U=np.diag([1e-4] * 6))
    x = np.concatenate([np.zeros(3), [1.0, 0, 0, 0], [1.0, 0, 0], [0, 0, 0.5]])
    place(map, rob, x, np.diag([0.0] * 7 + [0.04] * 3 + [0.01] * 3))
    for _ in range(10):
        move(map, rob, 0.1)
    assert rob.frame(map).x.shape == (7,) and np.allclose(rob.frame(map).t, [1.0, 0, 0])
    assert np.isclose(map.P[0, 7] / np.sqrt(map.P[0, 0] * map.P[7, 7]), 1, atol=0.01)
    assert np.isclose(np.linalg.norm(rob.frame(map).q), 1)


def test_the_covariance_stays_in_the_tangent_space():
    """After every step the quaternion is of norm one and has no variance along itself."""
    scene = Scene(d=3, P=SMALL7)
    scene.rob.u, scene.rob.U = np.array([0.1, 0, 0, 0.02, -0.01, 0.1]), 1e-4 * np.eye(6)
    for _ in range(20):
        move(scene.map, scene.rob, 0.1)
        q = scene.rob.frame(scene.map).q
        assert np.isclose(np.linalg.norm(q), 1) and np.abs(scene.map.P[:, 3:7] @ q).max() < 1e-12


STEPS = {
    "corrections one by one": lambda s: correct_known_lmks(*s.all, {}, raw([], np.zeros((0, 2))), s.opt),
    "a joint correction": lambda s: correct_known_lmks(*s.all, {}, raw([], np.zeros((0, 2))), Options(joint=True)),
    "without landmarks": lambda s: correct_without_lmks(*s.all[:3], {}, raw([], np.zeros((0, 3))), s.opt, {}),
    "motion": lambda s: move(s.map, s.rob, 0.1),
}


@pytest.mark.parametrize("step", STEPS)
def test_each_step_begins_with_poses_in_their_normal_form(step):
    """Another robot's correction has moved this one and its sensor: their quaternions are not of length one."""
    sensor = Gps(dim=3) if step == "without landmarks" else None
    scene = Scene(d=3, P=SMALL7, sensor=sensor, sensor_P=1e-4 * np.eye(7))
    scene.rob.u, scene.rob.U = np.zeros(6), np.zeros((6, 6))
    ranges = [scene.rob.r] + [scene.sen.r] * (step != "motion")
    for r in ranges:
        scene.map.x[r.start + 3 : r.stop] *= 1.01
        scene.map.P[r, r] += 1e-4 * np.eye(7)
    STEPS[step](scene)
    for r in ranges:
        q = scene.map.x[r.start + 3 : r.stop]
        assert np.isclose(np.linalg.norm(q), 1, rtol=1e-12)
        assert np.allclose(scene.map.P[:, r.start + 3 : r.stop] @ q, 0, atol=1e-15)


def test_normalising_what_is_known_is_nothing():
    scene = Scene()
    normalize(scene.map, scene.rob)
    assert scene.map.n == 0


# --- project ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("sensor_P", [None, 1e-4 * np.eye(7)], ids=["known-sensor", "self-calibration"])
def test_all_landmarks_at_once_and_one_by_one(sensor_P, rng):
    scene = mixed_scene(rng, sensor_P=sensor_P)
    A = 0.01 * rng.normal(size=(scene.map.n, scene.map.n))
    scene.map.P[:] = A @ A.T
    obs = project_lmks(*scene.all[:3], scene.lmks.values())
    assert [o.lmk for o in obs] == list(scene.lmks)
    Rf, Sf = scene.rob.frame(scene.map), scene.sen.frame(scene.map)
    for o, lmk in zip(obs, scene.lmks.values(), strict=True):
        e, *E_ = observe(Rf, Sf, scene.sen.model, lmk.type, lmk.state(scene.map))
        assert np.allclose(o.e, e)
        H = np.zeros((2, scene.map.n))
        for (r, J), want, owner in zip(o.blocks, E_, (scene.rob, scene.sen, lmk), strict=True):
            assert r == owner.r and np.allclose(J, want)
            if r is not None:
                H[:, r] = J
        assert np.allclose(o.E, H @ scene.map.P @ H.T)
        assert [np.array_equal(a, b) for a, b in zip((o.E_r, o.E_s, o.E_l), E_, strict=True)]


def test_no_landmarks():
    assert project_lmks(*Scene().all[:3], []) == []


def test_a_landmark_at_the_lens_is_not_visible():
    """What has no finite expectation cannot be looked for."""
    scene = Scene(d=3, P=SMALL7)
    scene.add(1, [0.0, 0.0, 0.0], 0.01 * np.eye(3), EucPnt())
    (o,) = project_lmks(*scene.all[:3], scene.lmks.values())
    assert not o.visible


# --- correct ---------------------------------------------------------------------------------------------------------


def posts(**options):
    """A robot and four posts round it, of growing uncertainty."""
    scene = Scene(P=P3, **options)
    for id, p in {1: [3, 0], 2: [0, 4], 3: [-2, -2], 4: [5, 5]}.items():
        scene.add(id, p, id * 0.01 * np.eye(2))
    return scene


POINTS = {1: [3.05, 0.02], 2: [0.03, 4.1], 3: [-2.1, -2.05], 4: [5.2, 4.9]}


def test_the_most_uncertain_expectation_comes_first():
    scene = posts()
    expected = project_lmks(*scene.all[:3], scene.lmks.values())
    order = [o.lmk for o in sorted(expected, key=lambda o: -np.linalg.det(o.E))]
    events, _ = corrected(scene, scene.see(POINTS))
    assert [e.lmk for e in events if e.kind == "search"] == order
    assert kinds(events)[:3] == [("search", order[0]), ("innovation", order[0]), ("correction", order[0])]
    assert all(event.rob == 1 and event.sen == 1 for event in events) and all(o.updated for o in scene.obs.values())


def test_at_most_so_many_updates():
    scene = posts(n_updates=2)
    events, _ = corrected(scene, scene.see(POINTS))
    assert [e.kind for e in events].count("correction") == 2
    assert sum(o.measured for o in scene.obs.values()) == 2


def test_each_expectation_is_computed_again_from_the_corrected_map():
    """All measurements in one call are the same as one after the other; without it they are not."""
    again, once, single = posts(), posts(reproject=False), posts()
    measurements = again.see({id: np.array(p) + [0.3, 0.0] for id, p in POINTS.items()})
    order = [e.lmk for e in corrected(again, measurements)[0] if e.kind == "search"]
    corrected(once, measurements)
    for id in order:
        i = list(measurements.ids).index(id)
        corrected(single, raw([id], measurements.y[i : i + 1]))
    assert np.allclose(again.map.x, single.map.x, atol=1e-12) and np.allclose(again.map.P, single.map.P, atol=1e-12)
    assert not np.allclose(once.map.x, single.map.x, atol=1e-4)


def test_the_gate_refuses_and_says_so():
    scene = posts(md2_threshold=9.0)
    x, P = scene.map.x.copy(), scene.map.P.copy()
    events, _ = corrected(scene, raw([1], [[3.0, 1.5]]))  # 90 degrees off
    assert ("innovation", 1) in kinds(events) and ("correction", 1) not in kinds(events)
    assert not next(e for e in events if e.kind == "innovation").flag
    o = scene.obs[1, 1]
    assert o.matched and not o.updated and o.md2 > 9
    assert np.array_equal(scene.map.x, x) and np.array_equal(scene.map.P, P)


def test_counters():
    scene = posts(md2_threshold=9.0)
    corrected(scene, raw([1, 2], [[3.0, 0.0], [4.0, 0.0]]))  # 1 fits, 2 is 90 degrees off, 3 and 4 are not seen
    counts = {id: (lmk.n_search, lmk.n_match, lmk.n_inlier) for id, lmk in scene.lmks.items()}
    assert counts == {1: (2, 2, 2), 2: (2, 2, 1), 3: (2, 1, 1), 4: (2, 1, 1)}


def test_observations_of_the_frame_before_are_gone():
    scene = posts()
    corrected(scene, scene.see(POINTS))
    scene.obs[2, 1] = "of another sensor"
    corrected(scene, raw([], np.zeros((0, 2))))
    assert scene.obs.pop((2, 1)) == "of another sensor"
    assert len(scene.obs) == 4 and not any(o.matched for o in scene.obs.values())


def test_what_is_out_of_view_is_not_looked_for():
    scene = posts(sensor=RangeBearing(0.05, 0.01, max_range=4.5))
    events, _ = corrected(scene, scene.see(POINTS))
    assert {e.lmk for e in events} == {1, 2, 3} and not scene.obs[1, 4].visible


def test_known_landmarks_correct_the_robot_only():
    scene = Scene(pose=[0.1, -0.1, 0.05], P=P3)
    for id, p in POINTS.items():
        scene.add(id, p)
    corrected(scene, scene.see(POINTS, pose=[0.0, 0.0, 0.0]))
    assert np.allclose(scene.map.x, 0, atol=0.01) and np.trace(scene.map.P) < 0.1 * np.trace(P3)
    assert all(np.array_equal(lmk.x, POINTS[id]) for id, lmk in scene.lmks.items())


def test_own_noise_of_a_measurement_counts():
    loose, tight = posts(), posts()
    measurements = loose.see({1: POINTS[1]})
    measurements.R = np.array([np.eye(2)])
    corrected(loose, measurements)
    corrected(tight, tight.see({1: POINTS[1]}))
    assert loose.map.P[3, 3] > 1.5 * tight.map.P[3, 3] and np.array_equal(loose.obs[1, 1].R, np.eye(2))


def test_negative_inverse_distances_are_brought_back():
    """A correction that throws a new landmark behind the camera leaves it far away, ahead."""
    scene = Scene(d=3, P=SMALL7, lmk_type=IdpPnt())
    init_new_lmks(*scene.all, raw([1], [[300.0, 200.0]]), [0], scene.opt)
    scene.rob.u, scene.rob.U = np.array([0, -0.5, 0, 0, 0, 0.0]), 1e-6 * np.eye(6)
    move(scene.map, scene.rob, 0.1)
    # the camera went to the right, but the image of the point went right as well
    corrected(scene, raw([1], [[330.0, 200.0]]))
    assert scene.obs[1, 1].updated and scene.lmks[1].state(scene.map)[5] == scene.opt.min_rho


@pytest.mark.parametrize("kind", [IdpPnt(), AhmPnt()])
def test_a_landmark_that_has_become_linear_becomes_euclidean(kind):
    """Its point and the point's covariance stay; the states that are not needed any more are free."""
    before, after = (Scene(d=3, P=SMALL7, lmk_type=kind, reparametrize=r) for r in (False, True))
    for scene in (before, after):
        l = kind.from_point(np.array([4.0, 0.5, 0.2]))[0]
        scene.add(1, l, 1e-8 * np.eye(kind.size))
        other = scene.add(2, [4.0, -0.5, 0.3], 1e-4 * np.eye(3), EucPnt())
        corrected(scene, scene.see({1: [4.0, 0.5, 0.2]}))
    p, P = before.lmks[1].point(before.map)
    lmk = after.lmks[1]
    assert lmk.type == EucPnt(3) and lmk.r == slice(7, 10) and np.allclose(lmk.state(after.map), p)
    assert np.allclose(after.map.P[lmk.r, lmk.r], P)
    P_l = kind.point(before.lmks[1].state(before.map))[1]
    cross = P_l @ before.map.P[before.lmks[1].r, : before.map.n]
    assert np.allclose(after.map.P[lmk.r, :7], cross[:, :7])
    assert np.allclose(after.map.P[lmk.r, other.r], cross[:, before.lmks[2].r])
    free = slice(10, 7 + kind.size)
    assert not after.map.used[free].any() and not after.map.P[free].any()


def test_landmarks_that_are_rarely_found_or_rarely_fit_are_deleted():
    scene = posts(md2_threshold=9.0, min_search=4, min_match_ratio=0.5, min_inlier_ratio=0.5)
    deleted = []
    for _ in range(5):
        events, _ = corrected(scene, raw([1, 2], [[3.0, 0.0], [4.0, 0.0]]))  # 2 never fits; 3 and 4 are never found
        deleted += [e.lmk for e in events if e.kind == "deletion"]
    assert sorted(deleted) == [2, 3, 4] and list(scene.lmks) == [1]
    assert not scene.map.P[5:].any() and not scene.map.x[5:].any() and scene.map.n_used == 5


def test_exactly_the_share_that_is_asked_for_is_enough():
    scene = posts(min_search=4, min_match_ratio=0.5, min_inlier_ratio=0.5)
    scene.lmks[1].n_search, scene.lmks[1].n_match, scene.lmks[1].n_inlier = 9, 5, 2
    corrected(scene, raw([], np.zeros((0, 2))))  # searched once more: 5 of 10, and 2 of 5 are used
    assert 1 not in scene.lmks
    scene = posts(min_search=4, min_match_ratio=0.5, min_inlier_ratio=0.5)
    scene.lmks[1].n_search, scene.lmks[1].n_match, scene.lmks[1].n_inlier = 7, 4, 2
    corrected(scene, raw([], np.zeros((0, 2))))
    assert 1 in scene.lmks


# --- self-calibration ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("estimated", [True, False])
def test_a_sensor_whose_frame_is_in_the_map_is_calibrated(estimated, rng):
    """Known robot, known landmarks, a sensor that is mounted crookedly: measurements put its frame right."""
    scene = Scene(sensor_P=np.diag([0.01, 0.01, 0.01]) if estimated else None)
    truth = np.array([0.1, -0.05, 0.1])
    for id, p in POINTS.items():
        scene.add(id, p)
    p = Frame2(truth).to_frame(np.array(list(POINTS.values())))[0]
    for _ in range(10):
        y = scene.sen.model.project(p)[0] + rng.normal(size=(4, 2)) @ np.sqrt(scene.sen.model.R)
        corrected(scene, raw(list(POINTS), y))
    error = scene.sen.frame(scene.map).minus(Frame2(truth))[0]
    if estimated:
        assert error @ np.linalg.solve(scene.map.P, error) < 16.3  # 99.9 % of chi-square with 3 degrees of freedom
        assert np.linalg.norm(error) < 0.03 and np.trace(scene.map.P) < 1e-3
    else:
        assert np.allclose(error, -truth) and scene.map.n == 0


def test_blocks_of_a_sensor_in_the_map_are_its_own(rng):
    """Robot and sensor frame are corrected by the same measurement; what is known keeps out of it."""
    scene = mixed_scene(rng, sensor_P=1e-4 * np.eye(7))
    (o,) = project_lmks(*scene.all[:3], [scene.lmks[1]])
    assert [r for r, _ in o.blocks] == [slice(0, 7), slice(7, 14), scene.lmks[1].r]
    x = scene.map.x.copy()
    corrected(scene, scene.see({1: [5.0, 0.3, 0.1]}))
    assert np.isclose(np.linalg.norm(scene.sen.frame(scene.map).q), 1)
    assert not np.allclose(scene.map.x[7:14], x[7:14])


# --- new landmarks ---------------------------------------------------------------------------------------------------


def started(scene, measurements, n_max=None):
    return init_new_lmks(*scene.all, measurements, range(len(measurements.ids)), scene.opt, n_max)


def test_a_new_landmark_lies_where_it_was_measured():
    scene = Scene(pose=[1.0, 2.0, np.pi / 2], P=P3)
    assert kinds(started(scene, raw([7], [[3.0, 0.0]]))) == [("initialisation", 7)]
    lmk = scene.lmks[7]
    assert np.allclose(lmk.state(scene.map), [1.0, 5.0]) and (lmk.n_search, lmk.n_match, lmk.n_inlier) == (1, 1, 1)
    L_r = np.array([[1, 0, -3.0], [0, 1, 0]])
    L_y = np.array([[0, -3.0], [1, 0]])
    assert np.allclose(scene.map.P[lmk.r, :3], L_r @ P3)
    assert np.allclose(scene.map.P[lmk.r, lmk.r], L_r @ P3 @ L_r.T + L_y @ scene.sen.model.R @ L_y.T)


def test_a_landmark_that_is_there_is_not_started_again():
    scene = posts()
    assert started(scene, raw([2, 9], [[4.0, 1.5], [2.0, 0.0]]))[0].lmk == 9 and len(scene.lmks) == 5


def test_at_most_so_many_at_once():
    scene = Scene(P=P3)
    assert len(started(scene, raw(range(1, 6), np.ones((5, 2))), n_max=2)) == 2
    assert started(scene, raw(range(1, 6), np.ones((5, 2))), n_max=0) == []


def test_a_margin_keeps_births_away_from_the_border():
    scene = Scene(d=3, P=SMALL7, lmk_type=IdpPnt(), init_margin=20.0)
    edge, inside = [15.0, 200.0], [25.0, 200.0]
    assert kinds(started(scene, raw([1, 2], [edge, inside]))) == [("initialisation", 2)]


def test_the_prior_is_kept_with_the_landmark():
    scene = Scene(d=3, P=SMALL7, lmk_type=IdpPnt(), n=0.1, N=0.25)
    started(scene, raw([1], [[320.0, 240.0]]))
    lmk = scene.lmks[1]
    assert np.array_equal(lmk.n, [0.1]) and np.array_equal(lmk.N, [[0.25]])
    assert lmk.state(scene.map)[5] == 0.1 and np.isclose(scene.map.P[lmk.r, lmk.r][5, 5], 0.25)


def test_the_sensor_may_have_a_type_of_its_own():
    scene = Scene(d=3, P=SMALL7, lmk_type=IdpPnt())
    scene.sen.lmk_type = AhmPnt()
    started(scene, raw([1], [[320.0, 240.0]]))
    assert scene.lmks[1].type == AhmPnt()


@pytest.mark.parametrize("options", [dict(capacity=8), dict(max_lmks=2)])
def test_a_full_map_refuses_and_the_run_goes_on(options):
    scene = Scene(P=P3, **options)
    events = started(scene, raw([1, 2, 3, 4], [[3.0, 0.0], [3.0, 1.0], [3.0, 2.0], [3.0, 3.0]]))
    assert [e.kind for e in events] == ["initialisation"] * 2 + ["refused"] * 2 and list(scene.lmks) == [1, 2]
    x, P = scene.map.x.copy(), scene.map.P.copy()
    with pytest.raises(MapFull):
        add_landmark(*scene.all, 5, np.array([3.0, 0.0]), None, scene.opt)
    assert np.array_equal(scene.map.x, x) and np.array_equal(scene.map.P, P)
    events, _ = corrected(scene, raw([1, 2], [[3.0, 0.0], [3.0, 1.0]]))
    assert [e.kind for e in events].count("correction") == 2


def test_slots_are_taken_again():
    scene = Scene(P=P3)
    started(scene, raw([1, 2, 3], np.ones((3, 2))))
    scene.map.remove(scene.lmks.pop(2).r)
    started(scene, raw([9], np.ones((1, 2))))
    assert {id: lmk.slot for id, lmk in scene.lmks.items()} == {1: 0, 3: 2, 9: 1}


# --- records ---------------------------------------------------------------------------------------------------------


def test_a_known_landmark_has_no_covariance():
    p, P = Lmk(1, EucPnt(2), x=np.array([1.0, 2.0])).point(Map())
    assert np.array_equal(p, [1, 2]) and not P.any()


def test_the_point_of_a_landmark_has_the_propagated_covariance(rng):
    scene = mixed_scene(rng)
    lmk = scene.lmks[1]
    p, P = lmk.point(scene.map)
    want, P_l = lmk.type.point(lmk.state(scene.map))
    assert np.allclose(p, want) and np.allclose(P, P_l @ scene.map.P[lmk.r, lmk.r] @ P_l.T)


def test_a_state_read_from_the_map_is_a_copy():
    scene = Scene(P=P3)
    scene.rob.state(scene.map)[:] = 9.0
    assert not scene.map.x.any() and isinstance(scene.rob.frame(scene.map), Frame2)
    assert isinstance(Scene(d=3).sen.frame(None), Frame3)


# --- recovery --------------------------------------------------------------------------------------------------------


def test_a_lost_robot_opens_its_gate_again():
    """Refused so often in a row, it becomes less certain where it is; the map stays as it was."""
    scene = posts(md2_threshold=9.0, reopen_after=4, reopen_std=(0.5, 0.3), error="additive")
    far = [1.5, -1.0, 0.4]
    lmks = scene.map.P[3:, 3:].copy()
    recovered = []
    for _ in range(4):
        events, _ = corrected(scene, scene.see(POINTS, pose=far))
        recovered += reopen_gate(scene.map, scene.rob, events, scene.opt)
        if recovered:
            break
        assert np.array_equal(scene.map.P[3:, 3:], lmks)
    assert recovered[0].kind == "recovery" and scene.rob.n_refused == 0
    for _ in range(6):
        events, _ = corrected(scene, scene.see(POINTS, pose=far))
        reopen_gate(scene.map, scene.rob, events, scene.opt)
    assert np.allclose(scene.map.x[:3], far, atol=0.5)
