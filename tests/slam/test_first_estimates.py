"""First-estimates Jacobians: what cannot be observed is not learnt, and the filter stays honest on a loop."""

import numpy as np
import pytest

from ekfslam_tutorial.analysis import anees_band, nees
from ekfslam_tutorial.geometry import Frame2
from ekfslam_tutorial.models.landmarks import AhmPnt
from ekfslam_tutorial.models.sensors import RangeBearing
from ekfslam_tutorial.simulation import draw
from ekfslam_tutorial.slam import (
    Event,
    Rob,
    correct_known_lmks,
    correct_met_robots,
    init_new_lmks,
    move,
    place,
    project_robots,
    reopen_gate,
    steps,
)
from ekfslam_tutorial.toolbox import UserData, universal_slam

from .scenes import Scene, raw

POSTS = {1: [3.0, 0.5], 2: [0.5, 4.0], 3: [-3.0, -2.0], 4: [4.0, -3.0]}
SENSOR = RangeBearing(0.1, np.radians(1.0))
J = np.array([[0.0, -1.0], [1.0, 0.0]])


def look(scene, true, rng, ids=POSTS, noise=1.0):
    """One frame of measurements: correct with what is known, start the rest."""
    measurements = scene.see({id: POSTS[id] for id in ids}, noise, rng, true)
    _, new = correct_known_lmks(*scene.all, scene.obs, measurements, scene.opt)
    init_new_lmks(*scene.all, measurements, new, scene.opt)


def unobservable(scene):
    """N of a map as it is linearised: shifts and the turn about the origin, shape (n, 3)."""
    N = np.zeros((scene.map.n, 3))
    p = scene.rob.state(scene.map) if scene.rob.first is None else scene.rob.first
    N[:3, :2], N[:3, 2] = np.eye(3)[:, :2], [*(J @ p[:2]), 1.0]
    for lmk in scene.lmks.values():
        N[lmk.r, :2], N[lmk.r, 2] = np.eye(2), J @ (lmk.state(scene.map) if lmk.first is None else lmk.first)
    return N


# --- the robot that stands still --------------------------------------------------------------------------------------


@pytest.mark.parametrize("joint", [False, True])
@pytest.mark.parametrize("moves", [False, True])
def test_a_robot_that_stands_still_does_not_learn_its_heading(rng, joint, moves):
    """Julier and Uhlmann 2001: the classical counter-example. Landmarks come in later, too, after corrections."""
    sigma, left = np.radians(30.0), {}
    for first in (False, True):
        scene = Scene(P=np.diag([0, 0, sigma**2]), sensor=SENSOR, first_estimates=first, joint=joint, error="additive")
        scene.rob.u, scene.rob.U = np.zeros(3), np.zeros((3, 3))
        for k in range(100):
            if moves:
                move(scene.map, scene.rob, 0.1)
            look(scene, np.zeros(3), rng, list(POSTS)[: 1 + k // 10])
        left[first] = np.degrees(np.sqrt(scene.map.P[2, 2]))
    assert left[True] == pytest.approx(30.0, abs=1e-6)  # rounding of 300 corrections
    assert left[False] < 28.0


# --- observability ----------------------------------------------------------------------------------------------------


def observability(scene, rng, monkeypatch, frames=12):
    """The observability matrix of a run: H_k X_{k-1} ... X_0, one below the other, for robot and landmarks."""
    seen = []
    spy = lambda map, r, x, X_x, X_u, U: (seen.append(X_x), predict(map, r, x, X_x, X_u, U))
    predict = steps.predict
    monkeypatch.setattr(steps, "predict", spy)
    true, u = Frame2(np.zeros(3)), np.array([0.4, 0.0, 0.3])
    scene.rob.U = np.diag([0.1, 0.05, np.radians(5)]) ** 2
    look(scene, true.x, rng)
    Phi, rows = np.eye(scene.map.n), []
    for _ in range(frames):
        true = true.compose(Frame2(u))[0]
        scene.rob.u = u + draw(rng, scene.rob.U)
        move(scene.map, scene.rob, 0.1)
        Phi[:3] = seen[-1] @ Phi[:3]
        look(scene, true.x, rng)
        for o in scene.obs.values():
            H = np.zeros((2, scene.map.n))
            H[:, o.blocks[0][0]], H[:, o.blocks[2][0]] = o.E_r, o.E_l
            rows.append(H @ Phi)
    return np.concatenate(rows)


@pytest.mark.parametrize("joint", [False, True])
def test_three_directions_cannot_be_observed(rng, monkeypatch, joint):
    """With first estimates 3, as in truth: the shifts and the turn. The plain filter believes in 2."""
    for first, unseen in (False, 2), (True, 3):
        P = np.diag([0.1, 0.1, 0.1]) ** 2
        scene = Scene(P=P, sensor=SENSOR, first_estimates=first, joint=joint, error="additive")
        s = np.linalg.svd(observability(scene, rng, monkeypatch), compute_uv=False)
        assert s[-unseen] < 1e-9 * s[0] and s[-unseen - 1] > 1e-4 * s[0]


def test_a_new_landmark_keeps_the_unobservable_directions(rng):
    """L_r T N1 = [I, J l], at a birth after a correction that moved the pose."""
    scene = Scene(P=np.diag([0.3, 0.3, 0.3]) ** 2, sensor=SENSOR, first_estimates=True)
    look(scene, np.array([0.3, -0.2, 0.2]), rng, [1, 2])
    scene.rob.u, scene.rob.U = np.array([0.3, 0.0, 0.1]), 0.01 * np.eye(3)
    move(scene.map, scene.rob, 0.1)
    N = unobservable(scene)
    scene.map.P[:] = N @ N.T  # nothing is uncertain but where the whole scene lies
    y = scene.see(POSTS, pose=[0.7, 0.0, 0.4])
    init_new_lmks(*scene.all, raw([3], y.y[2:3]), [0], scene.opt)
    P_lx = scene.map.P[scene.lmks[3].r, : len(N)]
    assert np.allclose(P_lx, unobservable(scene)[scene.lmks[3].r] @ N.T, atol=1e-12)
    scene.map.x[:3] += [0.2, 0.1, 0.3]  # as if corrected
    init_new_lmks(*scene.all, raw([4], y.y[3:4]), [0], scene.opt)
    P_lx = scene.map.P[scene.lmks[4].r, : len(N)]
    assert np.allclose(P_lx, unobservable(scene)[scene.lmks[4].r] @ N.T, atol=1e-12)


def test_robots_that_meet_do_not_learn_where_they_are(rng):
    """The sighting's Jacobian by both robots, times N, is zero, also after the first correction of the frame."""
    scene = Scene(P=0.04 * np.eye(3), sensor=SENSOR, first_estimates=True)
    other = Rob(2, scene.rob.motion, u=np.zeros(3), U=0.01 * np.eye(3))
    place(scene.map, other, np.array([3.0, 1.0, 0.5]), 0.04 * np.eye(3))
    for i in range(3):
        correct_met_robots(scene.map, scene.rob, scene.sen, [scene.rob, other], raw([2], [[3.3, 0.4]]), scene.opt)
        assert not np.allclose(scene.rob.first, scene.rob.state(scene.map), atol=1e-3)
        (o,) = project_robots(scene.map, scene.rob, scene.sen, [other])
        (_, E_r), _, (r, E_o) = o.blocks
        assert r == slice(3, 5) and np.abs(E_r[:, :2] + E_o).max() < 1e-12
        assert np.abs(E_r @ [*(J @ scene.rob.first[:2]), 1.0] + E_o @ J @ other.first[:2]).max() < 1e-12
        assert i or np.allclose(other.first, [3.0, 1.0, 0.5])
        scene.rob.u = other.u = np.array([0.1, 0.0, 0.1])
        move(scene.map, scene.rob, 0.1)
        move(scene.map, other, 0.1)


# --- what stays as it was ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("joint", [False, True])
def test_without_errors_both_filters_are_the_same(rng, joint):
    """Where estimates are true from the first, first and latest are one: same P, to rounding."""
    P = []
    for first in (False, True):
        scene = Scene(P=np.zeros((3, 3)), sensor=SENSOR, first_estimates=first, joint=joint)
        true, scene.rob.u, scene.rob.U = Frame2(np.zeros(3)), np.array([0.4, 0.0, 0.3]), 1e-4 * np.eye(3)
        for _ in range(10):
            look(scene, true.x, rng, noise=0.0)
            move(scene.map, scene.rob, 0.1)
            true = true.compose(Frame2(scene.rob.u))[0]
        P.append(scene.map.P.copy())
    assert np.allclose(*P, rtol=0, atol=1e-13)


def test_a_known_pose_is_its_own_first_estimate(rng):
    """Mapping: the robot is put where it is, without `move`."""
    scene = Scene(P=None, sensor=SENSOR, first_estimates=True)
    for pose in ([0.0, 0, 0], [1.0, 0.5, 0.3]):
        scene.rob.x = np.array(pose)
        look(scene, pose, rng)
        assert np.array_equal(scene.rob.first, pose)


def test_a_recovery_begins_anew(rng):
    """A lost robot's first estimates are as far off as it was: they are forgotten, and noted at the next correction."""
    scene = Scene(P=0.01 * np.eye(3), sensor=SENSOR, first_estimates=True, reopen_after=1)
    look(scene, [0.3, 0.2, 0.3], rng)
    look(scene, [0.3, 0.2, 0.3], rng)
    assert not np.array_equal(scene.lmks[1].first, scene.lmks[1].state(scene.map))
    refused = Event("innovation", 1, 1, 1, False)
    assert reopen_gate(scene.map, scene.rob, [refused], scene.opt, scene.lmks)
    before = scene.lmks[1].state(scene.map), scene.rob.state(scene.map)
    look(scene, [0.3, 0.2, 0.3], rng)
    assert np.array_equal(scene.lmks[1].first, before[0]) and np.array_equal(scene.rob.first, before[1])


def test_landmarks_in_space_or_without_a_point_are_refused():
    bad = "first_estimates is for robots in the plane and Euclidean points, got "
    scene = Scene(d=3, P=1e-4 * np.eye(7), first_estimates=True)
    with pytest.raises(ValueError, match=bad + "a robot in space"):
        correct_known_lmks(*scene.all, scene.obs, raw([], np.zeros((0, 2))), scene.opt)
    scene = Scene(P=np.eye(3), first_estimates=True, lmk_type=AhmPnt(2))
    with pytest.raises(ValueError, match=bad + "landmarks of type AhmPnt"):
        init_new_lmks(*scene.all, raw([1], [[3.0, 0.1]]), [0], scene.opt)
    scene.add(1, AhmPnt(2).from_point(np.array([3.0, 1.0]))[0], 0.1 * np.eye(5))
    with pytest.raises(ValueError, match=bad + "landmarks of type AhmPnt"):
        correct_known_lmks(*scene.all, scene.obs, raw([], np.zeros((0, 2))), scene.opt)
    anchored = LOOP | {"options": {"first_estimates": True}, "landmark": {"type": "ahm_pnt"}}
    with pytest.raises(ValueError, match=bad + "landmarks of type AhmPnt"):  # at once, not in the first frame
        UserData.from_dict(anchored)


# --- what it buys -----------------------------------------------------------------------------------------------------

LOOP = {
    "time": {"dt": 0.5, "last": 150},
    "world": {"type": "lecture"},
    "robot": [{"motion": "unicycle", "position": [0, -4], "v": 1.0, "w_deg": 14.4, "v_std": 0.1, "w_std_deg": 6.0}],
    "sensor": [{"type": "range_bearing", "range_std": 0.3, "bearing_std_deg": 3.0, "max_range": 5.0}],
    "options": {},
}


def test_three_rounds_with_large_noise_are_honest_only_with_first_estimates():
    """NEES at the end of the run over independent seeds: inside its 99.9 % band, where the plain filter is above."""
    seeds, last = 16, {}
    for first in (False, True):
        data = UserData.from_dict(LOOP | {"options": {"first_estimates": first, "error": "additive"}})
        last[first] = []
        for seed in range(seeds):
            *_, now = universal_slam(data, seed=seed)
            rob = now.robs[0]
            last[first].append(nees(rob.frame(now.map), now.map.block(rob.r), Frame2(now.truth[1])))
    low, high = anees_band(3, seeds, 0.999)
    assert low < np.mean(last[True]) < high < np.mean(last[False])
