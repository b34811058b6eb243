"""`ekfslam evaluate`, and trajectories that evo reads."""

import json

import numpy as np
import pytest
from evo.core import metrics, sync
from evo.tools import file_interface

from ekfslam_tutorial.cli import main
from ekfslam_tutorial.cli.evaluate import shown
from ekfslam_tutorial.cli.trajectories import tum_rows


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("runs")
    for seed in (1, 2):
        main(
            ["run", "range_bearing_2d", "--set", "time.last=60", "--seed", str(seed), "--out", str(folder / f"s{seed}")]
        )
    return folder


def result(runs, name):
    return json.loads((runs / name / "result.json").read_text())


def test_evo_finds_the_same_error(runs):
    """evo itself reads both files, aligns nothing (the frame is that of the truth) and finds our ATE and heading."""
    truth, estimate = (
        file_interface.read_tum_trajectory_file(str(runs / "s1" / f)) for f in ("truth-1.tum", "trajectory-1.tum")
    )
    pair = sync.associate_trajectories(truth, estimate)
    ours = result(runs, "s1")
    for relation, key in (
        (metrics.PoseRelation.translation_part, "ate_rmse_m"),
        (metrics.PoseRelation.rotation_angle_deg, "heading_rmse_deg"),
    ):
        ape = metrics.APE(relation)
        ape.process_data(pair)
        assert ape.get_statistic(metrics.StatisticsType.rmse) == pytest.approx(ours[key], rel=1e-5)


def test_rows_in_space_have_the_scalar_last():
    row = tum_rows(np.array([2.0]), np.array([[1.0, 2.0, 3.0, 0.5, 0.1, 0.2, 0.3]]))
    assert row.tolist() == [[2.0, 1.0, 2.0, 3.0, 0.1, 0.2, 0.3, 0.5]]
    flat = tum_rows(np.array([0.0]), np.array([[1.0, 2.0, np.pi / 2]]))
    np.testing.assert_allclose(flat[0, 4:], [0, 0, np.sqrt(0.5), np.sqrt(0.5)], atol=1e-12)


def test_one_table_for_all_runs(runs, capsys):
    assert main(["evaluate", str(runs / "s1"), str(runs / "s2" / "result.json"), "--robots"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == ["run", "s1", "robot", "s2", "robot"]
    assert "ATE aligned m" in lines[0] and "map aligned m" in lines[0]
    for line, name in ((lines[1], "s1"), (lines[3], "s2")):
        assert shown(result(runs, name)["ate_aligned_m"]) in line.split()
    assert len({len(line) for line in lines[:2]}) == 1


def test_the_same_as_csv(runs, capsys):
    assert main(["evaluate", str(runs / "s1"), "--csv"]) == 0
    head, row = capsys.readouterr().out.splitlines()
    values = dict(zip(head.split(","), row.split(","), strict=True))
    assert float(values["ate_aligned_m"]) == result(runs, "s1")["ate_aligned_m"]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (None, "no result"),
        ("{", "is not JSON"),
        ("[1]", "is not the result of a run"),
        ('{"frames": 1}', "no frames and"),
        ('{"frames": 1, "robots": {"1": 3}}', "robot 1 must be a table, got 3"),
        ('{"frames": 1, "robots": {}, "ate_aligned_m": [1]}', "ate_aligned_m of the whole must be a number or null"),
        ('{"frames": 1, "robots": {"2": {"nis_mean": "x"}}}', "nis_mean of robot 2 must be a number or null, got 'x'"),
        ('{"frames": true, "robots": {}}', "frames of the whole must be a number or null, got True"),
    ],
)
def test_what_is_no_result_is_named(tmp_path, capsys, text, words):
    if text is not None:
        (tmp_path / "result.json").write_text(text)
    assert main(["evaluate", str(tmp_path)]) == 2
    said = capsys.readouterr().err
    assert words in said and "result.json" in said


def test_what_is_not_known_is_a_dash():
    assert [shown(v) for v in (None, float("nan"), 12, 0.123456, 1234.5)] == ["-", "-", "12", "0.123", "1.23e+03"]
