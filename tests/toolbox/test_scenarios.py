"""The scenario files that come with the package: explained, as the recorded runs, and estimated honestly."""

import json
import re

import numpy as np
import pytest

from ekfslam_tutorial.analysis import History
from ekfslam_tutorial.cli.files import scenarios
from ekfslam_tutorial.models.motion import ConstantVelocity, Odometry3
from ekfslam_tutorial.models.sensors import PinHole, PinHoleDepth
from ekfslam_tutorial.toolbox import UserData, universal_slam

SIMULATED = {name: path for name, path in scenarios().items() if "[data]" not in path.read_text()}
KEY = re.compile(r"^([a-z_]+) = ", re.MULTILINE)


@pytest.mark.parametrize("name", SIMULATED)
def test_every_key_is_explained(name):
    lines = SIMULATED[name].read_text().splitlines()
    silent = {"id", "name", "type", "position", "orientation_deg", "position_std", "orientation_std_deg"}  # or above
    for above, line in zip(["", *lines], lines, strict=False):
        key = KEY.match(line)
        assert not key or "#" in line or above.startswith("#") or key[1] in silent | _twins(above), line


def _twins(above):
    """The keys that the comment of the line above covers: the noise of the second part of a control."""
    return {"w_std_deg", "da_std_deg", "ang_vel_std_deg", "dw_std_deg"} if "_std" in above else set()


@pytest.mark.parametrize("name", SIMULATED)
def test_a_whole_run_is_good_and_knows_it(name):
    history = History()
    few = {"time.last": 40} if name.startswith(("house", "columns")) else {}
    for snapshot in universal_slam(UserData.from_toml(SIMULATED[name], few)):
        history.add(snapshot)
    figures, P = history.summary(), snapshot.map.P[np.ix_(snapshot.map.used, snapshot.map.used)]
    # Some processors round [i, j] and [j, i] of a BLAS product differently: 500 corrections, 2e-16 each, are 1e-13.
    assert np.abs(P - P.T).max() <= 1e-13 * np.abs(P).max() and np.linalg.eigvalsh(P)[0] > -1e-12
    assert figures["ate_rmse_m"] < (0.5 if name == "constant_velocity" else 0.25)
    assert figures["ate_rmse_m"] <= figures["dead_reckoning_ate_m"]
    # one run and frames that hang together: a wide band, which still tells honest filters from broken ones (> 20)
    assert figures["nees_mean"] < 4 * figures["nees_dof"]
    assert 0.7 * figures["nis_dof"] < figures["nis_mean"] < 1.3 * figures["nis_dof"] + 0.2
    assert len(snapshot.lmks) >= SEEN_SO_FAR.get(name, _many(snapshot))


SEEN_SO_FAR = {"focal_length": 25}
"""Landmarks of a run that goes a short way."""


def _many(snapshot):
    """At least so many landmarks must be in the map: 40 points in space, 16 in the plane, 23 where there are edges."""
    if len(snapshot.sim_lmk.segments):
        return 23
    return 16 if snapshot.robs[0].motion.frame.dim == 2 else 40


RECORDED = {
    "cloister_idp": "pnt_idp",
    "depth_camera": "phd_euc",
    "constant_velocity": "constvel_noise",
    "two_robots_four_cameras": "multi_2rob_4sen",
}


@pytest.mark.parametrize("name", RECORDED)
def test_numbers_are_those_of_the_recorded_runs(name, golden_dir):
    data = UserData.from_toml(SIMULATED[name])
    recorded = json.loads((golden_dir / "runs" / f"{RECORDED[name]}.json").read_text())
    several = lambda part: recorded[part] if isinstance(recorded[part], list) else [recorded[part]]
    assert (data.time.dt, data.time.last) == (recorded["Time"]["dt"], recorded["Time"]["lastFrame"])
    _, points = data.world.build(None)
    assert np.array_equal(points.T, recorded["World"]["points"]["data"])

    for robot, was, con in zip(data.robots, several("Robot"), several("robCon"), strict=True):
        assert np.allclose(robot.U(), con["U"]["data"], rtol=1e-12)
        x, _ = robot.start()
        assert np.allclose(x[:3], was["position"])
        names = {ConstantVelocity: ("dv", "dwDegrees"), Odometry3: ("dx", "daDegrees")}[type(robot.motion)]
        assert np.allclose(robot.controls()[0], [*was[names[0]], *np.radians(was[names[1]])])
        assert np.allclose(np.atleast_1d(robot.position_std), was["positionStd"])

    for sensor, was, par in zip(data.sensors, several("Sensor"), several("senPar"), strict=True):
        model = sensor.model
        assert isinstance(model, PinHole) and sensor.robot == was["robot"] and sensor.frame_in_map == was["frameInMap"]
        assert np.allclose(sensor.position, was["position"]) and np.allclose(model.image_size, par["imSize"])
        assert np.allclose(sensor.orientation_deg, was["orientationDegrees"]) and np.allclose(model.k, par["k"])
        assert np.allclose(model.d, par["d"]) and model.pixel_std == was["pixErrorStd"]
        assert not isinstance(model, PinHoleDepth) or model.depth_std == was.get("depthErrorStd", 0.1)

    opt, was = data.slam_options(), recorded["Opt"]
    assert opt.max_lmks == was["map"]["numLmks"] and list(opt.n_inits) == was["init"]["nbrInits"]
    assert opt.n_updates == was["correct"]["nUpdates"] and opt.md2_threshold == was["correct"]["MD2th"]
    assert opt.init_margin == par["imSize"][0] / 25 and opt.lin_test == was["correct"]["linTestIdp"]
    assert opt.n[0] == was["init"]["idpPnt"]["nonObsMean"] and opt.N[0, 0] == was["init"]["idpPnt"]["nonObsStd"] ** 2
    with np.load(golden_dir / "runs" / f"{RECORDED[name]}.npz") as arrays:
        assert data.options.capacity == len(arrays["map_x0"])
