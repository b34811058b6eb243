"""Joint corrections: one innovation of all landmarks in view, the same bookkeeping as one after the other."""

import numpy as np
import pytest

from ekfslam_tutorial.geometry import Frame3
from ekfslam_tutorial.models import observe, to_sensor
from ekfslam_tutorial.models.landmarks import AhmPnt, HmgPnt, IdpPnt
from ekfslam_tutorial.models.sensors import PinHole, RangeBearing
from ekfslam_tutorial.slam import NearestNeighbour, correct_known_lmks

from .scenes import Scene, kinds, mixed_scene, raw

P3 = np.diag([0.01, 0.02, 0.001])
POINTS = {1: [3.05, 0.02], 2: [0.03, 4.1], 3: [-2.1, -2.05], 4: [5.2, 4.9]}


def posts(**options):
    """A robot and four posts round it, of growing uncertainty."""
    scene = Scene(P=P3, **{"joint": True} | options)
    for id, p in {1: [3, 0], 2: [0, 4], 3: [-2, -2], 4: [5, 5]}.items():
        scene.add(id, p, id * 0.01 * np.eye(2))
    return scene


def stacked(scene, measurements):
    """The correction by full matrices: every landmark's own expectation, one below the other."""
    Rf, Sf, H, z = scene.rob.frame(scene.map), scene.sen.frame(scene.map), [], []
    for id, y in zip(measurements.ids.tolist(), measurements.y, strict=True):
        lmk = scene.lmks[id]
        e, E_r, _, E_l = observe(Rf, Sf, scene.sen.model, lmk.type, lmk.state(scene.map))
        row = np.zeros((len(e), scene.map.n))
        row[:, scene.rob.r] = E_r
        if lmk.r is not None:
            row[:, lmk.r] = E_l
        H.append(row)
        z.append(scene.sen.model.residual(y, e))
    H, z, P = np.concatenate(H), np.concatenate(z), scene.map.P.copy()
    K = P @ H.T @ np.linalg.inv(H @ P @ H.T + np.kron(np.eye(len(measurements.ids)), scene.sen.model.R))
    return scene.map.x + K @ z, P - K @ H @ P


def test_a_joint_correction_is_that_of_the_stacked_matrices():
    scene = posts(error="additive")
    measurements = scene.see(POINTS)
    x, P = stacked(scene, measurements)
    events, _ = correct_known_lmks(*scene.all, scene.obs, measurements, scene.opt)
    assert np.allclose(scene.map.x, x, atol=1e-12) and np.allclose(scene.map.P, P, atol=1e-12)
    assert kinds(events)[:3] == [("search", 1), ("innovation", 1), ("correction", 1)] and len(events) == 12
    assert all(o.updated and np.isfinite(o.md2) and o.Z.shape == (2, 2) for o in scene.obs.values())


def test_noise_may_be_a_list():
    """In the second frame, when the landmarks are known, as in the first."""
    scenes = posts(), posts()
    for scene, form in zip(scenes, (np.array, list), strict=True):
        measurements = scene.see(POINTS)
        measurements.R = form([(0.01 * np.eye(2)).tolist()] * len(POINTS))
        correct_known_lmks(*scene.all, scene.obs, measurements, scene.opt)
    assert np.array_equal(scenes[0].map.x, scenes[1].map.x) and np.array_equal(scenes[0].map.P, scenes[1].map.P)


def test_landmarks_of_several_types_and_known_ones_together(rng):
    """The frame of the robot is normalised afterwards; the landmarks are compared as they are."""
    scene = mixed_scene(rng, joint=True, error="additive")
    points = {id: lmk.type.point(lmk.state(scene.map))[0] + 0.01 for id, lmk in scene.lmks.items()}
    measurements = scene.see(points)
    x, P = stacked(scene, measurements)
    correct_known_lmks(*scene.all, scene.obs, measurements, scene.opt)
    assert np.allclose(scene.map.x[7:], x[7:], atol=1e-11) and np.allclose(scene.map.P[7:, 7:], P[7:, 7:], atol=1e-11)
    assert all(o.updated for o in scene.obs.values()) and len(scene.obs) == 12


def test_each_landmark_passes_the_gate_on_its_own():
    scene, clean = posts(md2_threshold=9.0), posts(md2_threshold=9.0)
    points = POINTS | {2: [4.0, 0.0]}  # 90 degrees off
    events, _ = correct_known_lmks(*scene.all, scene.obs, scene.see(points), scene.opt)
    assert [e.lmk for e in events if e.kind == "innovation" and not e.flag] == [2]
    assert scene.obs[1, 2].matched and not scene.obs[1, 2].updated and scene.obs[1, 2].md2 > 9
    others = {id: p for id, p in points.items() if id != 2}
    correct_known_lmks(*clean.all, clean.obs, clean.see(others), clean.opt)
    assert np.allclose(scene.map.x, clean.map.x) and np.allclose(scene.map.P, clean.map.P)
    counts = {id: (lmk.n_search, lmk.n_match, lmk.n_inlier) for id, lmk in scene.lmks.items()}
    assert counts == {1: (2, 2, 2), 2: (2, 2, 1), 3: (2, 2, 2), 4: (2, 2, 2)}


def test_what_is_out_of_view_has_no_record_and_what_is_not_found_has_an_expectation():
    scene = posts(sensor=RangeBearing(0.05, 0.01, max_range=4.5))
    correct_known_lmks(*scene.all, scene.obs, scene.see({1: POINTS[1]}), scene.opt)
    assert set(scene.obs) == {(1, 1), (1, 2), (1, 3)}
    assert np.linalg.eigvalsh(scene.obs[1, 2].E)[0] > 0 and not scene.obs[1, 2].matched


def test_at_most_so_many_updates_and_the_most_uncertain_first():
    scene = posts(n_updates=2)
    events, _ = correct_known_lmks(*scene.all, scene.obs, scene.see(POINTS), scene.opt)
    sequential = posts(n_updates=2, joint=False)
    want, _ = correct_known_lmks(*sequential.all, sequential.obs, scene.see(POINTS), sequential.opt)
    assert [e.lmk for e in events if e.kind == "search"] == [e.lmk for e in want if e.kind == "search"]


def test_association_by_distance_sees_what_is_just_out_of_view():
    scene = posts(sensor=RangeBearing(0.05, 0.01, max_range=4.5), association=NearestNeighbour())
    measurements = scene.see({2: POINTS[2], 4: [5.01, 5.0]})
    _, new = correct_known_lmks(*scene.all, scene.obs, raw([-1, -1], measurements.y), scene.opt)
    assert new == [] and scene.obs[1, 2].updated and (1, 4) not in scene.obs


def test_nothing_in_view_is_no_correction():
    scene = posts(sensor=RangeBearing(0.05, 0.01, max_range=0.5))
    P = scene.map.P.copy()
    assert correct_known_lmks(*scene.all, scene.obs, raw([], np.zeros((0, 2))), scene.opt) == ([], [])
    assert np.array_equal(scene.map.P, P) and scene.obs == {}


@pytest.mark.parametrize("kind", [IdpPnt(), AhmPnt(), HmgPnt()])
def test_the_short_way_of_a_ray_is_the_long_one(kind, rng):
    """Through the frames as a landmark, or as a ray with its weight: the same image and the same Jacobians. (By the
    quaternion only along the unit sphere: off it the two ways scale in different ways.)"""
    camera = PinHole()
    Rf = Frame3(np.concatenate([0.1 * rng.normal(size=3), [1, 0.02, -0.03, 0.01]])).normalized()[0]
    Sf = Frame3(np.concatenate([0.1 * rng.normal(size=3), [0.5, -0.5, 0.5, -0.5]])).normalized()[0]
    l = np.array([kind.from_point(p)[0] for p in rng.uniform([3, -1, -1], [8, 1, 1], (5, 3))])
    lr, LR_r, LR_l = kind.to_frame(Rf, l)
    ls, LS_s, LS_lr = kind.to_frame(Sf, lr)
    e, E_v = camera.project(kind.ray(ls)[0])
    E_lr = E_v @ kind.ray(ls)[1] @ LS_lr
    got, G_r, G_s, G_l = observe(Rf, Sf, camera, kind, l)
    N_r, N_s = Rf.normalized()[1], Sf.normalized()[1]
    assert np.allclose(got, e, atol=1e-9) and np.allclose(G_l, E_lr @ LR_l, atol=1e-8)
    assert np.allclose(G_r @ N_r, E_lr @ LR_r @ N_r, atol=1e-8)
    assert np.allclose(G_s @ N_s, E_v @ kind.ray(ls)[1] @ LS_s @ N_s, atol=1e-8)


def test_on_the_axis_of_the_camera_there_is_no_pole():
    Sf = Frame3(np.array([0, 0, 0, 0.5, -0.5, 0.5, -0.5]))
    l = IdpPnt().from_point(np.array([5.0, 0.0, 0.0]))[0]
    v, *V = to_sensor(Frame3(np.eye(7)[3]), Sf, PinHole(), IdpPnt(), l)
    assert np.allclose(v, [0, 0, 1], atol=1e-15) and max(np.abs(J).max() for J in V) < 10


def test_a_limit_that_all_are_within_changes_nothing():
    """The most uncertain come first in the list of what is looked for, but not in the table of what is expected."""
    ends = []
    for n_updates in (None, 4):
        scene = posts(n_updates=n_updates)
        correct_known_lmks(*scene.all, scene.obs, scene.see(POINTS), scene.opt)
        assert all(o.updated for o in scene.obs.values()) and len(scene.obs) == 4
        ends.append(scene.map)
    assert np.array_equal(ends[0].x, ends[1].x) and np.array_equal(ends[0].P, ends[1].P)
