"""`ekfslam audit`, as a user calls it."""

import json
import re

import numpy as np
import pytest

from ekfslam_tutorial.analysis.audit import RunErrors, audit
from ekfslam_tutorial.cli.main import main
from ekfslam_tutorial.geometry import Frame2, Frame3, v2q
from ekfslam_tutorial.toolbox import Recording

FRAMES = 40


def written(folder, rng, runs, factor=1.0, world=None):
    """Honest poses in the plane, as files of an estimate and its truth; the truth may lie in another world."""
    P = np.diag([0.04, 0.01, 0.0025]) + 0.002
    t = np.arange(FRAMES) * 0.1
    names = []
    for k in range(runs):
        truth = np.column_stack([t, np.sin(t), 0.3 * t])
        e = rng.multivariate_normal(np.zeros(3), P, FRAMES)
        rows = np.column_stack([t, truth + e, np.tile((P / factor).ravel(), (FRAMES, 1))])
        truth = truth if world is None else world.compose(Frame2(truth))[0].x
        np.savetxt(folder / f"est-{k}.txt", rows)
        np.savetxt(folder / f"truth-{k}.txt", np.column_stack([t, truth]))
        names.append((str(folder / f"est-{k}.txt"), str(folder / f"truth-{k}.txt")))
    return [list(column) for column in zip(*names, strict=True)]


def run(capsys, *arguments):
    code = main(["audit", *map(str, arguments)])
    return code, capsys.readouterr()


def test_several_runs_in_one_call(tmp_path, capsys, rng):
    est, truth = written(tmp_path, rng, 12)
    code, said = run(capsys, *est, "--truth", *truth, "--out", tmp_path / "out")
    assert code == 0, said.err
    assert "12 runs, 480 poses" in said.out and "verdict (95 %): honest" in said.out and "power: " in said.out
    figures = json.loads((tmp_path / "out" / "audit.json").read_text())
    assert figures["verdict"] == "honest" and figures["runs"] == 12 and 0.8 < figures["pose"]["ratio"] < 1.25
    assert (tmp_path / "out" / "audit.png").stat().st_size > 20_000


def test_covariances_too_small_by_two_are_found(tmp_path, capsys, rng):
    est, truth = written(tmp_path, rng, 4, factor=2.0)
    code, said = run(capsys, *est, "--truth", *truth, "--out", tmp_path / "out")
    assert code == 1 and "verdict (95 %): over-confident" in said.out


def test_a_record_of_our_own_run(tmp_path, capsys):
    """A run in the truth's frame and the same with a free gauge; the map and the innovations are heard, too."""
    out = tmp_path / "run"
    options = ["--set", "time.last=40", "--record", "--out", str(out)]
    assert main(["run", "range_bearing_2d", *options]) == 0
    assert "estimate.rec" in capsys.readouterr().out
    code, said = run(capsys, out, "--out", tmp_path / "out")
    assert code in (0, 1) and "map" in said.out and "innovations that follow" in said.out, said.err
    figures = json.loads((tmp_path / "out" / "audit.json").read_text())
    result = json.loads((out / "result.json").read_text())
    assert figures["per_run"][0]["nees_mean"] == pytest.approx(result["nees_mean"])
    assert figures["innovations"]["ratio"] == pytest.approx(result["nis_mean"] / result["nis_dof"])


def test_a_record_takes_its_truth_from_a_file(tmp_path, capsys):
    """The truth of a record and the same in a file have the same NEES; a record that has none is judged by a file."""
    known, blind, truth = (tmp_path / name for name in ("known", "blind", "truth.txt"))
    assert main(["run", "range_bearing_2d", "--set", "time.last=40", "--record", "--out", str(known)]) == 0
    log = Recording.load(known / "recording.npz")
    np.savetxt(truth, np.column_stack([log.t, log.truth[1]]))
    path = Recording("blind", log.t, log.robots, log.raw).save(tmp_path / "blind.npz")
    assert main(["run", "range_bearing_2d", "--recording", str(path), "--record", "--out", str(blind)]) == 0
    nees = []
    for words in ([known], [known, "--truth", truth], [blind, "--truth", truth]):
        code, said = run(capsys, *words, "--out", tmp_path / "audit")
        assert code in (0, 1), said.err
        nees.append(json.loads((tmp_path / "audit" / "audit.json").read_text())["per_run"][0]["nees_mean"])
    assert nees[1] == pytest.approx(nees[0], rel=1e-9) and 0 < nees[2] < np.inf
    code, said = run(capsys, blind, "--out", tmp_path / "audit")
    assert code == 2 and "no true pose of robot 1 is known: give them by --truth" in said.err


def test_the_verdict_says_what_half_of_the_pose_does_otherwise(rng):
    """Positions are half as wrong as they say, headings 1.4 times. 1200 numbers tell 1.4^2 = 1.96 to 0.24, 3 sigma."""
    t, P, none = np.arange(FRAMES) * 0.1, np.tile(np.eye(3), (FRAMES, 1, 1)), np.zeros((0, 0))
    e = rng.standard_normal((30, FRAMES, 3)) * [0.5, 0.5, 1.4]
    found = audit([RunErrors("a", t, each, P, float("nan"), 0, none, none, np.zeros((0, 2))) for each in e])
    assert found.verdict == "too cautious"
    assert re.search(r"; but rotation is over-confident \((1\.[789]|2\.[01])\d\)", found.sentence)


def test_another_world_is_laid_on_the_start(tmp_path, capsys, rng):
    """A walk whose start is known and whose world is turned by 130 deg: seen by itself, and honest."""
    world, Q, n = Frame2([50.0, -20.0, 2.3]), np.diag([1e-4, 1e-4, 1e-5]), 60
    est, truth = [], []
    for k in range(10):
        x, true, P, rows, places = Frame2(np.zeros(3)), Frame2(np.zeros(3)), np.zeros((3, 3)), [], []
        for i in range(n):
            rows.append(np.r_[0.1 * i, x.x, P.ravel()])
            places.append(np.r_[0.1 * i, world.compose(true)[0].x])
            w = rng.multivariate_normal(np.zeros(3), Q)
            x, X_x, X_w = x.compose(Frame2([0.1, 0.0, 0.05]))
            true = true.compose(Frame2(np.array([0.1, 0.0, 0.05]) + w))[0]
            P = X_x @ P @ X_x.T + X_w @ Q @ X_w.T
        for name, table, files in (("e", rows, est), ("t", places, truth)):
            np.savetxt(tmp_path / f"{name}{k}.txt", table)
            files.append(str(tmp_path / f"{name}{k}.txt"))
    code, said = run(capsys, *est, "--truth", *truth, "--out", tmp_path / "out", "--confidence", "0.999")
    assert code == 0, said.out + said.err
    assert run(capsys, *est, "--truth", *truth, "--out", tmp_path / "out", "--gauge", "fixed")[0] == 1


def test_space_and_a_map(tmp_path, capsys, rng):
    """Poses in space in the form of OpenVINS, and landmarks with covariances of their own."""
    n = 30
    t, var = np.arange(n) * 0.1, np.array([0.01, 0.02, 0.03, 1e-3, 2e-3, 3e-3])
    true = Frame3(np.column_stack([t, t, 0 * t, v2q(np.array([0.1, 0.2, 0.3]))[0] * np.ones((n, 1))]))
    e = rng.normal(size=(n, 6)) * np.sqrt(var)
    q = true.compose(Frame3(np.column_stack([0 * e[:, :3], v2q(e[:, 3:])[0]])))[0].q
    tum = lambda p, q: np.column_stack([t, p, q[:, 1:], q[:, 0]])
    cov = np.tile([var[3], 0, 0, var[4], 0, var[5], var[0], 0, 0, var[1], 0, var[2]], (n, 1))
    np.savetxt(tmp_path / "e.txt", np.column_stack([tum(true.t + e[:, :3], q), cov]))
    np.savetxt(tmp_path / "t.txt", tum(true.t, true.q))
    names = "id,x,y,z,P_xx,P_xy,P_xz,P_yy,P_yz,P_zz,true_x,true_y,true_z"
    places = rng.normal(size=(20, 3))
    points = places + 0.1 * rng.normal(size=(20, 3))
    rows = np.column_stack([np.arange(20), points, np.tile([0.01, 0, 0, 0.01, 0, 0.01], (20, 1)), places])
    np.savetxt(tmp_path / "m.csv", rows, delimiter=",", header=names, comments="")
    args = [tmp_path / "e.txt", "--truth", tmp_path / "t.txt", "--map", tmp_path / "m.csv", "--out", tmp_path / "out"]
    code, said = run(capsys, *args, "--confidence", "0.999", "--gauge", "fixed")
    assert code == 0, said.out + said.err
    figures = json.loads((tmp_path / "out" / "audit.json").read_text())
    assert 0.5 < figures["map"]["ratio"] < 2 and figures["map"]["dof"] <= 60


def test_graphs(tmp_path, capsys, rng):
    """A graph of two poses and three points, and the true one: the map is judged with its joint covariance."""
    edge = "EDGE_SE2 0 1 1 0 0 100 0 0 100 0 100\n"
    sights = "".join(f"EDGE_SE2_XY 0 {i} {i} {i % 2} 100 0 100\n" for i in (2, 3, 4))
    points = "".join(f"VERTEX_XY {i} {i} {i % 2}\n" for i in (2, 3, 4))
    moved = "".join(f"VERTEX_XY {i} {i + 0.1} {i % 2}\n" for i in (2, 3, 4))
    (tmp_path / "e.g2o").write_text("VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\n" + points + edge + sights)
    (tmp_path / "t.g2o").write_text("VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1.1 0.1 0.05\n" + moved)
    code, said = run(
        capsys, tmp_path / "e.g2o", "--truth", tmp_path / "t.g2o", "--out", tmp_path / "o", "--gauge", "fixed"
    )
    assert code == 0, said.err
    figures = json.loads((tmp_path / "o" / "audit.json").read_text())
    assert figures["per_run"][0]["nees_mean"] == pytest.approx(1 + 1 + 0.25)
    assert figures["map"]["ratio"] == pytest.approx(0.5) and figures["map"]["dof"] == 6


def test_bad_calls_are_told_in_one_sentence(tmp_path, capsys, rng):
    (est,), (truth,) = written(tmp_path, rng, 1)
    (tmp_path / "x.rec").write_bytes(b"nothing")
    for arguments, sentence in (
        ([est], "comes without true poses: give them by --truth"),
        ([est, est, est, "--truth", truth, truth], "--truth needs as many files as there are estimates, 3, got 2"),
        ([tmp_path / "none.txt"], "no file"),
        ([tmp_path], "`ekfslam run --record` writes it"),
        ([tmp_path / "x.rec"], "x.rec"),
        ([est, "--truth", truth, "--confidence", "2"], "--confidence is a probability"),
        ([est, "--truth", truth, "--max-dt", "nan"], "--max-dt is a time"),
    ):
        code, said = run(capsys, *arguments, "--out", tmp_path / "out")
        assert code == 2 and sentence in said.err and said.err.count("\n") == 1, said.err
