"""`ekfslam smooth` and `ekfslam graph`, as a user calls them; and what other programs read of a graph."""

import ast
import importlib.util
import json
import shlex

import numpy as np
import pytest

from ekfslam_tutorial.analysis.factors import graph_of
from ekfslam_tutorial.analysis.g2o import read_g2o
from ekfslam_tutorial.analysis.graph_files import APART, g2o_text, gtsam_script
from ekfslam_tutorial.analysis.smoother import smooth
from ekfslam_tutorial.cli import smoothing
from ekfslam_tutorial.cli.main import main
from ekfslam_tutorial.toolbox import UserData

pytestmark = pytest.mark.usefixtures("undrawn")

SHORT = "time.last=15"
SPACE = {
    "world": {"type": "cloister"},
    "time": {"last": 8},
    "robot": [
        {
            "motion": "odometry3",
            "position": [0.0, -5.0, 0.0],
            "dx": [0.3, 0.0, 0.0],
            "da_deg": [0.0, 0.0, 5.0],
            "dx_std": 0.02,
            "da_std_deg": 0.5,
        }
    ],
    "sensor": [{"type": "range_bearing_elevation", "max_range": 8.0, "position": [0.1, 0.0, 0.5]}],
}
PLANE = {
    "world": {"type": "ring", "n": 12, "radius": 6.0},
    "time": {"last": 12, "dt": 0.5},
    "robot": [
        {"motion": "odometry2", "position": [0, -4], "dx": [0.5, 0.0], "da_deg": 7, "dx_std": 0.03, "da_std_deg": 1}
    ],
    "sensor": [
        {"type": "range_bearing", "range_std": 0.05, "bearing_std_deg": 1.0, "max_range": 6.0, "position": [0.2, 0.1]}
    ],
}


def call(capsys, *arguments):
    code = main(list(map(str, arguments)))
    return code, capsys.readouterr()


def test_a_run_of_beacons_ends_with_the_command_that_smooths_it(tmp_path, capsys, monkeypatch):
    monkeypatch.setenv("EKFSLAM_DATA", str(tmp_path))  # nothing is there: the twin runs
    monkeypatch.chdir(tmp_path)
    words = "plaza", "--set", "time.last=12", "--seed", 3, "--set", "options.smooth=false"
    code, said = call(capsys, "run", *words, "--out", "filter")
    assert code == 0, said.err
    last = said.out.splitlines()[-1]
    assert last.startswith("next: `ekfslam smooth plaza --set time.last=12 --set options.smooth=false --seed 3` f")
    code, said = call(capsys, *shlex.split(last.split("`")[1])[1:])
    assert code == 0 and "robot 1, smoother" in said.out, said.err


def test_a_run_may_end_with_the_smoothed_path(tmp_path, capsys):
    """It is that of `ekfslam smooth`; the next run takes its files away."""
    out, alone = tmp_path / "run", tmp_path / "alone"
    words = "range_bearing_2d", "--set", SHORT
    code, said = call(capsys, "run", *words, "--set", "options.smooth=true", "--out", out)
    assert code == 0 and "robot 1, filter" in said.out and "robot 1, smoother" in said.out, said.err
    assert "smoothed.json" in said.out.splitlines()[-1] and "smoothing: " in said.err
    assert call(capsys, "smooth", *words, "--out", alone)[0] == 0
    for file in "smoothed-1.csv", "smoothed-map.csv", "smoothed.json":
        assert (out / file).read_bytes() == (alone / file).read_bytes()
    figures = json.loads((out / "result.json").read_text())
    filtered, smoothed = figures["smoothed"]
    assert filtered["position_rmse_m"] == pytest.approx(figures["ate_rmse_m"])
    assert smoothed == json.loads((alone / "smoothed.json").read_text())[1]
    assert call(capsys, "run", *words, "--out", out)[0] == 0
    assert (out / "map.csv").exists() and not list(out.glob("smooth*"))


def test_smoothing_that_is_stopped_leaves_the_run(tmp_path, capsys, monkeypatch):
    def stopped(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(smoothing, "smooth", stopped)
    words = "range_bearing_2d", "--set", SHORT, "--set", "options.smooth=true"
    code, said = call(capsys, "run", *words, "--out", tmp_path)
    assert code == 130 and "smoothing stopped; the run of the filter is written" in said.err
    figures = json.loads((tmp_path / "result.json").read_text())
    assert figures["complete"] and "smoothed" not in figures and (tmp_path / "map.png").exists()
    assert said.out.splitlines()[-1].startswith(f"written to {tmp_path}: ") and not list(tmp_path.glob("smooth*"))


def test_a_run_that_cannot_be_smoothed_does_not_begin(tmp_path, capsys):
    for name, why in ("house_apl", "sensor 1 measures lines"), ("lecture_mapping", "all poses are known"):
        code, said = call(capsys, "run", name, "--set", "options.smooth=true", "--out", tmp_path)
        assert code == 2 and why in said.err and not (tmp_path / "result.json").exists()
    code, said = call(capsys, "run", "range_bearing_2d", "--set", "options.smooth=2", "--out", tmp_path)
    assert code == 2 and "[options]: smooth must be true or false, got 2" in said.err


def test_a_run_is_smoothed(tmp_path, capsys):
    code, said = call(capsys, "smooth", "range_bearing_2d", "--set", SHORT, "--out", tmp_path)
    assert code == 0, said.err
    first, *_ = said.out.splitlines()
    assert first.startswith("range_bearing_2d: 15 frames, ") and "robot 1, smoother" in said.out
    rows = np.loadtxt(tmp_path / "smoothed-1.csv", delimiter=",", skiprows=1)
    assert rows.shape == (16, 10)
    path = np.loadtxt(tmp_path / "smoothed-1.tum")
    assert path.shape == (16, 8) and np.allclose(path[:, :3], rows[:, :3], atol=1e-8)  # nine digits are written
    assert (tmp_path / "smoothed-map.csv").read_text().startswith("id,x,y,P_xx,P_xy,P_yy\n")
    assert (tmp_path / "smooth.png").stat().st_size > 20_000
    filtered, smoothed = json.loads((tmp_path / "smoothed.json").read_text())
    assert (filtered["of"], smoothed["of"]) == ("filter", "smoother") and "landmarks RMSE m" in said.out
    assert 0 < smoothed["landmark_aligned_rmse_m"] < 0.2 and len(smoothed["landmark_errors_m"]) > 3
    squares = np.square(list(filtered["landmark_errors_m"].values()))
    assert np.sqrt(squares.mean()) == pytest.approx(filtered["landmark_aligned_rmse_m"])
    code, said = call(capsys, "smooth", "range_bearing_2d", "--set", SHORT, "--out", tmp_path, "--lag", 3)
    assert code == 0 and "a lag of 3 frames" in said.out
    late = np.loadtxt(tmp_path / "smoothed-1.csv", delimiter=",", skiprows=1)
    assert 1e-6 < np.abs(late[:, 1:4] - rows[:, 1:4]).max() < 0.5


def test_what_cannot_be_smoothed_gets_one_sentence(tmp_path, capsys):
    code, said = call(capsys, "smooth", "range_bearing_2d", "--set", SHORT, "--lag", 0, "--out", tmp_path)
    assert code == 2 and said.err.count("\n") <= 2 and "the lag is a number of frames, 1 or more, got 0" in said.err
    code, said = call(capsys, "graph", "cloister_idp", "--set", "time.last=4", "--out", tmp_path / "g.g2o")
    assert code == 2 and "measures directions only: there is no edge for it" in said.err
    assert not (tmp_path / "g.g2o").exists()


@pytest.mark.parametrize("table", [PLANE, SPACE], ids=["plane", "space"])
def test_the_graph_of_g2o_is_read_back(table, tmp_path):
    """Poses, landmarks and marginals; the edges are linearised, so the variances agree to 10 %."""
    found = smooth(graph_of(UserData.from_dict(table)))
    (tmp_path / "run.g2o").write_text(g2o_text(found.graph))
    back = read_g2o(tmp_path / "run.g2o")
    x, P = found.track(1)
    np.testing.assert_allclose(back.x.x, x, atol=1e-12)
    if back.x.dim == 3:
        E = np.array([back.x.minus(back.x)[1][k] for k in range(len(x))])
        P = E @ P @ np.swapaxes(E, 1, 2)
    np.testing.assert_allclose(back.P[1:], P[1:], atol=0.1 * np.abs(P[1:]).max())
    diagonals = [np.diagonal(A[1:], axis1=1, axis2=2) for A in (back.P, P)]
    np.testing.assert_allclose(*diagonals, rtol=0.1, atol=1e-8)
    places = found.landmarks()
    assert set(back.ids) == {1000 * APART + id for id in places}
    for id, p in zip(back.ids, back.points, strict=True):
        np.testing.assert_allclose(p, places[id - 1000 * APART][0])


def test_the_command_writes_both(tmp_path, capsys):
    for way, name in (("g2o", "run.g2o"), ("gtsam", "run.py")):
        code, said = call(
            capsys, "graph", "range_bearing_2d", "--set", SHORT, "--to", way, "--out", tmp_path / "new" / name
        )
        assert code == 0 and said.out.startswith("16 poses, "), said.err
    assert len(read_g2o(tmp_path / "new" / "run.g2o").t) == 16
    kinds = [line.split()[0] for line in (tmp_path / "new" / "run.g2o").read_text().splitlines()]
    assert kinds.index("FIX") > max(k for k, kind in enumerate(kinds) if kind != "FIX")  # GTSAM stops reading there
    tree = ast.parse((tmp_path / "new" / "run.py").read_text())
    tables = {n.targets[0].id: ast.literal_eval(n.value) for n in tree.body[3:8] if isinstance(n, ast.Assign)}
    assert len(tables["POSES"]) == 16 and len(tables["STEPS"]) == 15 and tables["FIXED"] == [0]


def test_robots_and_known_landmarks_are_told_apart():
    table = PLANE | {
        "robot": [PLANE["robot"][0], PLANE["robot"][0] | {"id": 2, "position": [0, 4]}],
        "sensor": [PLANE["sensor"][0], PLANE["sensor"][0] | {"id": 2, "robot": 2}],
    }
    text = g2o_text(graph_of(UserData.from_dict(table)))
    assert "VERTEX_SE2 0 " in text and f"VERTEX_SE2 {APART} " in text and f"FIX {APART}\n" in text
    known = g2o_text(graph_of(UserData.from_dict(PLANE | {"landmark": {"type": "euc_pnt", "in_map": False}})))
    assert f"VERTEX_XY {2000 * APART}" in known and f"FIX {2000 * APART}" in known


@pytest.mark.skipif(importlib.util.find_spec("gtsam") is None, reason="GTSAM is not installed: pip install gtsam")
@pytest.mark.parametrize("table", [PLANE, SPACE], ids=["plane", "space"])
def test_the_program_for_gtsam_finds_what_the_smoother_finds(table, tmp_path):
    """Positions to a fifth of their sigma: the edges are linearised where they were measured."""
    import gtsam

    graph = graph_of(UserData.from_dict(table))
    namespace = {"__name__": "a graph"}
    exec(compile(gtsam_script(graph), "graph", "exec"), namespace)
    end = gtsam.LevenbergMarquardtOptimizer(namespace["graph"], namespace["initial"]).optimize()
    assert namespace["graph"].error(end) < namespace["graph"].error(namespace["initial"])
    x, P = smooth(graph).track(1)
    d = 2 if x.shape[1] == 3 else 3
    for k in range(1, len(x)):
        pose = end.atPose2(k) if d == 2 else end.atPose3(k)
        sigma = np.sqrt(np.trace(P[k, :d, :d]))
        assert np.linalg.norm(pose.translation() - x[k, :d]) < 0.2 * sigma
