"""Sensors that ask for more than a point: against filters written by hand, and in whole runs with both engines."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from ekfslam_tutorial import fast, slam
from ekfslam_tutorial.analysis import anees_band
from ekfslam_tutorial.cli.results import parameters
from ekfslam_tutorial.geometry import ORIGIN, Frame2, Frame3, numerical_jacobian
from ekfslam_tutorial.models import Calibrated, state_class
from ekfslam_tutorial.models.landmarks import AhmPnt, EucPnt, IdpPnt
from ekfslam_tutorial.models.motion import ConstantTurn, Odometry2
from ekfslam_tutorial.models.sensors import (
    BearingOnly2,
    Compass,
    Doppler,
    Gps,
    GroundFlow,
    OmniCam,
    PinHole,
    PinHoleDepth,
    RangeBearing,
    RangeBearingElevation,
    RangeRate,
    SegmentCam,
    WheelSpeed,
)
from ekfslam_tutorial.models.state_contracts import check_parameters, check_states
from ekfslam_tutorial.models.trials import random_frame
from ekfslam_tutorial.slam import Lmk, Options, Rob, Sen, place, tilt
from ekfslam_tutorial.toolbox import UserData, universal_slam

from ..fast.law import ALL, assert_same_runs
from .scenes import raw

SCENARIOS = Path(__file__).parents[2] / "data" / "scenarios"
NEW = "doppler", "focal_length", "gps_compass", "ground_flow", "lever_arm", "lidar_in_space"


# --- the chain --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "sensor, names, lmk",
    [
        (PinHole(d=(-0.3, 0.1)), ("f", "d"), AhmPnt()),
        (PinHole(d=(-0.3,)), ("k", "bias"), IdpPnt()),
        (PinHoleDepth(), ("k", "delay"), EucPnt(3)),
        (RangeBearing(0.1, 0.02), ("delay", "bias"), EucPnt(2)),
        (RangeBearingElevation(0.1, 0.02, 0.02), ("delay",), EucPnt(3)),
    ],
    ids=lambda a: type(a).__name__ if not isinstance(a, tuple) else ", ".join(a),
)
def test_the_whole_chain_with_parameters(sensor, names, lmk, rng):
    check_states(sensor, names, lmk, rng)


def test_parameters_that_are_exported_have_their_derivatives():
    omni = OmniCam((668.0, 438.0, 1.01, 0.002, -0.003), (644.7, -341.0, -29.01, -57.7), image_size=(1280, 960), fov=3.0)
    for sensor in (omni, Compass(0.02, 0.3), WheelSpeed(0.1, 1.1), GroundFlow(0.1, 2.0), BearingOnly2(0.1)):
        check_parameters(sensor)


class Wrong(WheelSpeed):
    def project_parameters(self, v):
        y, Y_scale = super().project_parameters(v)
        return y, 1.01 * Y_scale


def test_a_wrong_derivative_is_found():
    with pytest.raises(AssertionError, match="differs at entry"):
        check_parameters(Wrong(0.1))


# --- one correction, by hand ------------------------------------------------------------------------------------------

# the state is [x, y, theta, v, w], the sensor's [x, y, theta], its parameters, a landmark [x, y]
POSE, PARAMS = np.array([1.0, -2.0, 0.7, 1.5, 0.4]), {"scale": 1.1, "height": 1.5, "declination": 0.1}
MOUNT, POINT = np.array([0.5, 0.3, 0.2]), np.array([4.0, 1.0])


def seat(x):
    """Position, heading and velocity of a sensor, in the world, by the elements of mechanics."""
    (px, py, th, v, w), (sx, sy, sth) = x[:5], x[5:8]
    lever = np.array([np.cos(th) * sx - np.sin(th) * sy, np.sin(th) * sx + np.cos(th) * sy])
    rate = v * np.array([np.cos(th), np.sin(th)]) + w * np.array([-lever[1], lever[0]])
    return np.array([px, py]) + lever, th + sth, rate


def ahead(x):
    _, heading, rate = seat(x)
    axes = np.array([[np.cos(heading), np.sin(heading)], [-np.sin(heading), np.cos(heading)]])
    return axes @ rate


def radar(x):
    p, heading, rate = seat(x)
    d = x[-2:] - p
    r = np.hypot(*d)
    return np.array([r, np.arctan2(d[1], d[0]) - heading, -d @ rate / r])


def late(x):
    """Range and bearing from where the robot was x[8] seconds ago, on its arc."""
    v, w, t = x[3], x[4], x[8]
    th = x[2] - w * t
    back = v / w * np.array([np.sin(th) - np.sin(x[2]), np.cos(x[2]) - np.cos(th)])
    past = np.concatenate([x[:2] + back, [th], x[3:]])
    return radar(past)[:2]


CASES = {
    "doppler": (Doppler(0.1, 0.02, rate_std=0.05), (), radar),
    "range rate": (RangeRate(0.05), (), lambda x: radar(x)[2:]),
    "wheel speed": (WheelSpeed(0.05, 1.1), ("scale",), lambda x: x[8] * ahead(x)[:1]),
    "ground flow": (GroundFlow(0.05, 1.5), ("height",), lambda x: ahead(x) / x[8]),
    "gps": (Gps(0.2), (), lambda x: seat(x)[0]),
    "compass": (Compass(0.05, 0.1), ("declination",), lambda x: np.array([seat(x)[1] + x[8]])),
    "biased": (RangeBearing(0.1, 0.02), ("bias",), lambda x: radar(x)[:2] + x[8:10]),
    "late": (RangeBearing(0.1, 0.02), ("delay",), late),
}


@pytest.mark.parametrize("steps", [slam, fast], ids=["plain", "fast"])
@pytest.mark.parametrize("case", CASES)
def test_a_correction_is_that_of_a_filter_written_by_hand(case, steps, rng):
    """The mean to 1e-7 and the covariance to 1e-6: the other filter differentiates numerically. The arc of the late one
    is a straight step there, turned: the same to first order in the delay, so it is 0 here, and it is found."""
    sensor, names, h = CASES[case]
    model = Calibrated(sensor, names) if names else sensor
    map, lmks = steps.new_map(), {}
    rob = Rob(1, ConstantTurn(), sensors=[1])
    sen = Sen(1, 1, model, state_class(Frame2, model))
    s = np.concatenate([MOUNT, model.start if names else []])
    place(map, rob, POSE, 0.01 * np.eye(5))
    place(map, sen, s, 0.01 * np.eye(len(s)))
    lmks[4] = Lmk(4, EucPnt(2), r=map.add(POINT, 0.01 * np.eye(2)))
    A = rng.normal(size=map.P.shape)
    map.P[:] = 0.002 * A @ A.T + 0.01 * np.eye(len(A))  # all is correlated with all
    x, P = map.x.copy(), map.P.copy()
    y = h(x) + rng.normal(size=len(sensor.R)) * np.sqrt(np.diag(sensor.R))

    H = numerical_jacobian(h, x)
    K = P @ H.T @ np.linalg.inv(H @ P @ H.T + sensor.R)
    opt = Options(lmk_type=EucPnt(2), error="additive")
    if hasattr(sensor, "without_lmks"):
        done = steps.correct_without_lmks(map, rob, sen, {}, raw([-1], y[None]), opt, lmks)
        assert [(e.kind, e.lmk, e.flag) for e in done] == [("innovation", -1, True)]
    else:
        done, _ = steps.correct_known_lmks(map, rob, sen, lmks, {}, raw([4], y[None]), opt)
        assert [e.kind for e in done] == ["search", "innovation", "correction"]
    assert np.allclose(map.x, x + K @ (y - h(x)), rtol=0, atol=1e-7)
    assert np.allclose(map.P, P - K @ H @ P, rtol=0, atol=1e-6)


def test_a_gate_holds_for_what_sees_no_landmark(rng):
    map = slam.new_map()
    rob, sen, obs = Rob(1, Odometry2(), sensors=[1]), Sen(1, 1, Gps(0.1), Frame2), {}
    place(map, rob, np.zeros(3), 0.01 * np.eye(3))
    place(map, sen, np.zeros(3))
    two = raw([-1, -1], np.array([[5.0, 0.0], [0.1, 0.0]]))
    done = slam.correct_without_lmks(map, rob, sen, obs, two, Options(md2_threshold=9.0), {})
    assert [e.flag for e in done] == [False, True] and obs[1, -1].updated and obs[1, -1].lmk == -1
    assert 0.02 < map.x[0] < 0.1


def test_parameters_walk():
    map, model = slam.new_map(), Calibrated(WheelSpeed(0.1), ("scale",))
    sen = Sen(1, 1, model, state_class(Frame2, model), walk=np.array([0.1]))
    place(map, sen, np.array([0.0, 0.0, 0.0, 1.0]), np.zeros((4, 4)))
    tilt(map, [sen], 0.25)
    assert np.allclose(map.P, np.diag([0, 0, 0, 0.1**2 * 0.25]))


@pytest.mark.parametrize("F", [Frame2, Frame3])
@pytest.mark.parametrize("names", [(), ("bias",)])
def test_a_mounting_gives_way_about_its_own_axes(F, names, rng):
    """A random walk of its angles: by a small turn behind the frame, wherever it looks and stands in the map."""
    sensor = RangeBearing(0.1, 0.1) if F is Frame2 else PinHole()
    model = Calibrated(sensor, names) if names else sensor
    map, x = slam.new_map(), np.concatenate([random_frame(F, rng).x, [0.0, 0.0] * len(names)])
    map.add(np.zeros(2), np.eye(2))
    sen = Sen(1, 1, model, state_class(F, model), tilt=0.2, walk=0.3 if names else 0.0)
    place(map, sen, x, 0.01 * np.eye(len(x)))
    P, dim = map.P.copy(), F.dim
    tilt(map, [sen], 0.25)
    turned = lambda a: F(x[: F.size]).compose(F(ORIGIN[dim].x + ORIGIN[dim].X_step[:, dim:] @ a))[0].x
    J = numerical_jacobian(turned, np.zeros(F.dof - dim))
    P[2 : 2 + F.size, 2 : 2 + F.size] += 0.2**2 * 0.25 * J @ J.T
    P[2 + F.size :, 2 + F.size :] += 0.3**2 * 0.25 * np.eye(2 * len(names))
    assert np.allclose(map.P, P, rtol=0, atol=1e-9)
    known = Sen(2, 1, sensor, F, tilt=0.2)
    place(map, known, x[: F.size])
    tilt(map, [known], 0.25)
    assert np.allclose(map.P, P, rtol=0, atol=1e-9)


# --- whole runs -------------------------------------------------------------------------------------------------------


def scenario(name, **overrides):
    return UserData.from_toml(SCENARIOS / f"{name}.toml", overrides)


@pytest.mark.parametrize("name", NEW)
def test_both_engines(name):
    """What they have beside the landmarks is computed as in `slam`: few frames show that nothing is left out."""
    data = scenario(name, **{"time.last": 5})
    assert ("correction", True) in assert_same_runs(data, hows=ALL[:2])[1]


def errors(data, seeds):
    """NEES of the pose at the end of runs, and errors of the parameters in their standard deviations."""
    nees, z, std = [], [], []
    for seed in seeds:
        *_, now = universal_slam(data, seed=seed, engine="plain")
        (rob, *_), map = now.robs, now.map
        F = rob.frame(map)
        e, E_f = F.minus(type(F)(now.truth[1]))
        nees.append(e @ np.linalg.solve(E_f @ map.P[rob.r, rob.r][: F.size, : F.size] @ E_f.T, e))
        for sen, true in zip(now.sens, now.sim_sens, strict=True):
            if isinstance(sen.model, Calibrated):
                at = slice(sen.r.stop - len(sen.frame(map).a), sen.r.stop)
                std.append(np.sqrt(np.diag(map.P[at, at])))
                z.append((sen.frame(map).a - true.frame.a) / std[-1])
    return np.array(nees), np.array(z), np.array(std)


@pytest.mark.parametrize(
    "name, dof, frames, prior, factor",
    [
        ("doppler", 3, 40, 0.05, 5),
        ("focal_length", 6, 25, 10.0, 1.9),
        ("gps_compass", 3, 50, np.radians(5), 2),
        ("ground_flow", 3, 30, 0.1, 4),
    ],
)
def test_what_is_found_is_honest(name, dof, frames, prior, factor):
    """6 runs: NEES of the pose, and of the parameter, within the 99.9 % band; it is known better than before."""
    nees, z, std = errors(scenario(name, **{"time.last": frames}), range(1, 7))
    low, high = anees_band(dof, 6, 0.999)
    assert low < nees.mean() < high, nees
    low, high = anees_band(1, z.size, 0.999)
    assert low < np.mean(z**2) < high, z
    assert (factor * std < prior).all(), std


def test_the_run_tells_what_was_found():
    *_, now = universal_slam(scenario("gps_compass", **{"time.last": 3}))
    found = parameters(SimpleNamespace(last=now))
    (sen,) = (sen for sen in now.sens if isinstance(sen.model, Calibrated))
    assert {sen: set(names) for sen, names in found.items()} == {"2": {"position"}, "3": {"declination"}}
    gps = now.sens[1]
    assert found["2"]["position"] == {
        "value": gps.state(now.map)[:2].tolist(),
        "std": np.sqrt(np.diag(now.map.block(gps.r))[:2]).tolist(),
        "true": now.sim_sens[1].frame.t.tolist(),
    }
    told = found["3"]["declination"]
    assert told["value"] == [now.map.x[sen.r.stop - 1]] and told["true"] == now.sim_sens[2].frame.a.tolist()
    assert np.isclose(told["std"][0] ** 2, now.map.P[sen.r.stop - 1, sen.r.stop - 1])


def test_a_delay_is_found():
    """The camera's stamps are late by what nobody has told the filter."""
    data = scenario("doppler", **{"time.last": 60, "sensor.1.params_in_map": ["delay"], "sensor.1.delay_std": 0.1})
    _, z, std = errors(data, range(1, 4))
    assert (std[::2] < 0.08).all() and np.abs(z[::2]).max() < 3.5


def test_a_lever_arm_of_bearings_is_found():
    """Bearings alone, from a place on the robot that is known to 20 cm: `frame_in_map`, and no landmark is known.

    5 runs, straight on and round a corner: in the 99.9 % band, and known to 3 cm."""
    z = []
    for seed in range(1, 6):
        *_, now = universal_slam(scenario("lever_arm", **{"time.last": 25}), seed=seed)
        (sen,), (true,) = now.sens, now.sim_sens
        P = now.map.block(sen.r)[:2, :2]
        e = sen.state(now.map)[:2] - true.frame.t
        z.append(e @ np.linalg.solve(P, e))
        assert np.sqrt(np.trace(P)) < 0.03
    low, high = anees_band(2, 5, 0.999)
    assert low < np.mean(z) < high, z


# --- sentences --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "name, overrides, said",
    [
        ("doppler", {"robot.1.in_map": False}, "asks for the velocity of robot 1, which must be in the map"),
        ("gps_compass", {"sensor.1.params_in_map": ["delay"]}, "depends on a velocity, and Odometry2 of"),
        ("gps_compass", {"sensor.1.params_in_map": ["fov"]}, "of RangeBearing cannot be a state; possible: bias, "),
        ("gps_compass", {"sensor.1.bias_std": 1.0}, r"write params_in_map = \['bias'\]"),
        ("gps_compass", {"sensor.2.clutter": 1.0}, "Gps sees no landmarks"),
        ("gps_compass", {"sensor.1.params_in_map": "bias"}, "must be a list of names"),
        ("gps_compass", {"sensor.1.params_in_map": ["bias"], "options.first_estimates": True}, "first_estimates know"),
        ("focal_length", {"sensor.1.params_in_map": ["f", "k"]}, "f is a part of k"),
    ],
)
def test_what_cannot_be_estimated_is_refused(name, overrides, said):
    with pytest.raises(ValueError, match=said):
        scenario(name, **overrides)


def test_models_that_do_not_go_together():
    with pytest.raises(TypeError, match="Odometry2 has no method velocity"):
        Rob(1, Odometry2(), x=np.zeros(3)).moving(slam.new_map())
    with pytest.raises(ValueError, match="'k' of SegmentCam cannot be a state; possible: none"):
        Calibrated(SegmentCam(), ("k",))
    with pytest.raises(ValueError, match="c is the inverse of one d"):
        Calibrated(PinHole(d=(0.1,), c=(-0.1,)), ("d",))
    with pytest.raises(ValueError, match="named twice"):
        Calibrated(PinHole(), ("f", "f"))
    assert not hasattr(Calibrated(Gps(), ("bias",)), "retro") and hasattr(Calibrated(PinHole(), ("f",)), "retro")
