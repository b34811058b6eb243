"""`ekfslam export`: what is written is read back by evo, by readers of MCAP and Rerun, and by `ekfslam audit`."""

import numpy as np
import pytest

from ekfslam_tutorial.analysis.estimate_files import read_estimate, read_truth, with_truth
from ekfslam_tutorial.cli import main
from ekfslam_tutorial.cli.files import find_scenario
from ekfslam_tutorial.geometry import Frame3
from ekfslam_tutorial.toolbox import UserData, universal_slam

SPACE, PLANE = "cloister_idp", "range_bearing_2d"


def exported(folder, to, name=SPACE, frames=8):
    words = ["export", name, "--to", to, "--out", str(folder), "--set", f"time.last={frames}"]
    assert main(words) == 0
    return folder


@pytest.fixture(scope="module")
def run():
    """Poses and covariances of the last frame of the run in space."""
    *_, now = universal_slam(UserData.from_toml(find_scenario(SPACE), {"time.last": 8}))
    return now.robs[0].state(now.map)[:7].copy(), now.map.block(now.robs[0].r)[:7, :7].copy()


@pytest.mark.parametrize(("to", "ending"), [("tum", "tum"), ("kitti", "kitti"), ("euroc", "csv")])
def test_trajectories_come_back_with_their_covariances(tmp_path, run, to, ending):
    exported(tmp_path, to)
    estimate, truth = read_estimate(tmp_path / f"trajectory-1.{ending}"), read_truth(tmp_path / f"truth-1.{ending}")
    x, P = run
    np.testing.assert_allclose(estimate.x.x[-1] * np.sign(estimate.x.x[-1, 3]), x * np.sign(x[3]), atol=1e-8)
    _, E_x = Frame3(x).minus(Frame3(x))
    np.testing.assert_allclose(estimate.P[-1], E_x @ P @ E_x.T, rtol=1e-9, atol=1e-15)
    assert len(with_truth(estimate, truth).t) == 8


@pytest.mark.parametrize(("to", "ending"), [("tum", "tum"), ("kitti", "kitti"), ("euroc", "csv")])
def test_evo_reads_them(tmp_path, run, to, ending):
    file_interface = pytest.importorskip("evo.tools.file_interface", reason="evo is not installed")
    exported(tmp_path, to)
    read = getattr(file_interface, {"kitti": "read_kitti_poses_file"}.get(to, f"read_{to}_trajectory_file"), None)
    read = read or file_interface.read_euroc_csv_trajectory
    path = read(str(tmp_path / f"trajectory-1.{ending}"))
    assert path.num_poses == 8 and path.check()[0]
    np.testing.assert_allclose(path.positions_xyz[-1], run[0][:3], atol=1e-8)


def test_the_plane_is_a_space_without_height(tmp_path, capsys):
    exported(tmp_path, "euroc", PLANE)
    estimate = read_estimate(tmp_path / "trajectory-1.csv")
    assert (estimate.x.t[:, 2] == 0).all() and (estimate.P[-1].diagonal() > 0).all()
    files = [str(tmp_path / name) for name in ("trajectory-1.csv", "truth-1.csv")]
    assert main(["audit", files[0], "--truth", files[1], "--out", str(tmp_path / "audit")]) in (0, 1)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda f: (f / "trajectory-1-times.txt").unlink(), "KITTI, which has no stamps: trajectory-1-times.txt"),
        (lambda f: (f / "trajectory-1-times.txt").write_text("1\n2\n"), "has 2 numbers for the 8 poses"),
        (lambda f: (f / "trajectory-1-cov.txt").write_text("1 2 3\n"), "a row of 6 or 21 numbers for each of the 8"),
        (lambda f: (f / "trajectory-1.kitti").write_text("2 0 0 0 0 2 0 0 0 0 2 0\n" * 8), "must be rotations"),
    ],
)
def test_what_does_not_fit_is_one_sentence(tmp_path, change, says):
    change(exported(tmp_path, "kitti"))
    with pytest.raises(ValueError, match=says):
        read_estimate(tmp_path / "trajectory-1.kitti")


def test_an_mcap_holds_poses_paths_and_landmarks(tmp_path, run):
    pytest.importorskip("rosbags", reason="MCAP needs rosbags: pip install ekfslam_tutorial[bags]")
    from rosbags.highlevel import AnyReader

    path = exported(tmp_path, "mcap") / "run.mcap"
    with AnyReader([path]) as bag:
        found = {}
        for connection, logged, data in bag.messages():
            found.setdefault(connection.topic, []).append(bag.deserialize(data, connection.msgtype))
            if connection.topic == "/robot_1/pose":
                stamp = found[connection.topic][-1].header.stamp
                assert stamp.sec * 10**9 + stamp.nanosec == logged
    assert set(found) == {"/robot_1/pose", "/robot_1/path", "/truth_1/path", "/map"}
    pose, (path,) = found["/robot_1/pose"][-1].pose, found["/robot_1/path"]
    assert len(path.poses) == len(found["/robot_1/pose"]) == 8
    p = pose.pose.position
    np.testing.assert_allclose([p.x, p.y, p.z], run[0][:3], atol=1e-12)
    covariance = np.asarray(pose.covariance).reshape(6, 6)
    np.testing.assert_allclose(covariance[:3, :3], run[1][:3, :3], atol=1e-12)
    assert {marker.ns for marker in found["/map"][0].markers} == {"landmarks", "truth"}


def test_a_rerun_file_is_written_where_rerun_is(tmp_path):
    pytest.importorskip("rerun", reason="Rerun needs rerun-sdk: pip install ekfslam_tutorial[rerun]")
    assert (exported(tmp_path, "rerun", PLANE) / "run.rrd").read_bytes().startswith(b"RRF")


def test_without_rerun_it_says_what_to_install(tmp_path, monkeypatch, capsys):
    import sys

    monkeypatch.setitem(sys.modules, "rerun", None)
    words = ["export", PLANE, "--to", "rerun", "--out", str(tmp_path), "--set", "time.last=2"]
    assert main(words) == 2 and "pip install ekfslam_tutorial[rerun]" in capsys.readouterr().err
