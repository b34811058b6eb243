"""The known errors of sets 1 and 8, put into simulated sets: found, told, put right; a joint run is none the worse."""

from pathlib import Path

import numpy as np
import pytest

from ekfslam_tutorial.analysis import History
from ekfslam_tutorial.datasets import mrclam_twin, prepare
from ekfslam_tutorial.datasets.mrclam_log import read_set
from ekfslam_tutorial.datasets.sources import Source
from ekfslam_tutorial.toolbox import UserData, universal_slam

SCENARIO = Path(__file__).parents[2] / "data" / "scenarios" / "mrclam_joint.toml"
ROBOTS = [1, 3]


def jointly(folder):
    """Notes, landmarks at the end and figures of a joint run of two robots, 90 s."""
    userdata, recording = prepare(UserData.from_toml(SCENARIO, {"data.path": str(folder), "data.robots": ROBOTS}))
    history = History()
    for _ in history.watch(universal_slam(userdata, recording)):
        pass
    return recording.notes, history.last.lmks, history.summary()


def rewrite(path, change):
    """Change the rows of a table, each a list of words; `change` takes and gives all of them. Comments stay."""
    lines = path.read_text().splitlines()
    head, rows = [l for l in lines if l.startswith("#")], [l.split() for l in lines if not l.startswith("#")]
    path.write_text("\n".join([*head, *(" \t ".join(row) for row in change(rows))]) + "\n")


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A set without these errors, and what a joint run makes of it."""
    folder = mrclam_twin.write(
        tmp_path_factory.mktemp("whole") / "MRCLAM_Dataset2", seed=4, duration=90.0, sparse=(), robots=ROBOTS
    )
    return folder, jointly(folder)


def copy(whole, name, tmp_path):
    folder = tmp_path / name
    folder.mkdir()
    for file in whole[0].iterdir():
        (folder / file.name).write_text(file.read_text())
    return folder


def test_a_set_without_errors_is_left_alone(whole):
    notes, lmks, f = whole[1]
    assert not any("interchanged" in note or "never surveyed" in note for note in notes)
    assert f["landmark_rmse_aligned_m"] < 0.15 and f["ate_aligned_m"] < 0.25


def test_interchanged_survey_of_set_1(whole, tmp_path):
    """Subjects 11 and 17 in each other's places: without the correction their error is their distance, metres."""
    folder = copy(whole, "MRCLAM_Dataset1", tmp_path)
    rows = {}

    def swap(table):
        rows.update({row[0]: np.array(row[1:3], float) for row in table})
        other = {"11": "17", "17": "11"}
        return [[other.get(row[0], row[0]), *row[1:]] for row in table]

    rewrite(folder / "Landmark_Groundtruth.dat", swap)
    assert np.linalg.norm(rows["11"] - rows["17"]) > 1.0
    notes, _, f = jointly(folder)
    assert sum("landmarks 11 and 17 are interchanged" in note and "put right" in note for note in notes) == 1
    assert f["landmark_rmse_aligned_m"] == pytest.approx(whole[1][2]["landmark_rmse_aligned_m"], abs=1e-9)


def test_the_interchange_is_found_with_a_sparse_truth_too(tmp_path):
    folder = mrclam_twin.write(tmp_path / "MRCLAM_Dataset1", seed=4, duration=90.0, sparse=ROBOTS, robots=ROBOTS)
    before = read_set(Source(folder), ROBOTS)
    other = {"11": "17", "17": "11"}
    swap = lambda table: [[other.get(row[0], row[0]), *row[1:]] for row in table]
    rewrite(folder / "Landmark_Groundtruth.dat", swap)
    after = read_set(Source(folder), ROBOTS)
    assert not any(robot.dense for robot in after.robots.values())
    assert sum("landmarks 11 and 17 are interchanged" in note for note in after.notes) == 1
    np.testing.assert_array_equal(after.points[np.argsort(after.ids)], before.points[np.argsort(before.ids)])


def test_the_landmark_that_was_never_surveyed_of_set_8(whole, tmp_path):
    """Subject 9 wears barcode 61 and is in neither list: it is mapped all the same, and its errors are nobody's."""
    folder = copy(whole, "MRCLAM_Dataset8", tmp_path)
    code = {}

    def forget(table):
        code.update({row[0]: row[1] for row in table})
        return [row for row in table if row[0] != "9"]

    rewrite(folder / "Landmark_Groundtruth.dat", lambda table: [row for row in table if row[0] != "9"])
    rewrite(folder / "Barcodes.dat", forget)
    assert "61" not in code.values()
    for robot in ROBOTS:
        renamed = lambda table: [[row[0], "61" if row[1] == code["9"] else row[1], *row[2:]] for row in table]
        rewrite(folder / f"Robot{robot}_Measurement.dat", renamed)
    notes, lmks, f = jointly(folder)
    assert sum("barcode 61" in note and "never surveyed" in note for note in notes) >= 1
    assert 1061 in lmks and 9 not in lmks
    assert f["landmark_rmse_aligned_m"] < 0.15 and f["ate_aligned_m"] == pytest.approx(
        whole[1][2]["ate_aligned_m"], abs=0.05
    )
