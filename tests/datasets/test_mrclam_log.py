"""The troubles of the MRCLAM files, one by one, on files made by hand."""

import re

import numpy as np
import pytest

from ekfslam_tutorial.datasets.mrclam_log import RobotLog, SetLog, Sightings, _check_survey, read_set, truth_at
from ekfslam_tutorial.datasets.sources import Source
from ekfslam_tutorial.geometry import wrap

T = 1.25e9


@pytest.fixture
def log(handmade):
    return read_set(Source(handmade), (1, 2))


def says(log, *words):
    """Whether one note has all the words."""
    return any(all(word in note for word in words) for note in log.notes)


def edit(path, change):
    """Replace the lines of data of a file by change(lines)."""
    lines = path.read_text().splitlines()
    head = [l for l in lines if l.startswith("#")]
    path.write_text("\n".join([*head, *change([l for l in lines if not l.startswith("#")])]) + "\n")


def test_barcodes_become_subjects(log):
    s = log.robots[1].landmarks
    assert set(s.ids.tolist()) == {6, 11, 17}
    first = s.t == T
    np.testing.assert_array_equal(s.ids[first], [6, 11, 17])
    np.testing.assert_allclose(s.y[first], [[2.0, 0.0], [3.162, -0.322], [3.162, 1.249]], atol=1e-15)


def test_a_spurious_barcode_is_dropped_and_counted(log):
    assert says(log, "robot 1", "barcode 99", "1 sightings", "spurious, dropped")
    assert 1099 not in log.robots[1].landmarks.ids


def test_an_unknown_barcode_that_is_seen_often_is_a_landmark_nobody_surveyed(handmade):
    extra = [f"{T + 0.05 * k:.3f} \t  61 \t 1.000 \t 0.000" for k in range(60)]
    edit(handmade / "Robot1_Measurement.dat", lambda lines: lines + extra)
    log = read_set(Source(handmade), (1,))
    assert (log.robots[1].landmarks.ids == 1061).sum() == 60
    assert 1061 not in log.ids
    assert says(log, "barcode 61", "60 sightings", "never surveyed")


def test_other_robots_are_kept_apart_with_their_ids(log):
    met = log.robots[1].robots
    assert met.t.tolist() == [T + 0.8] and met.ids.tolist() == [2] and met.y.tolist() == [[1.5, 0.25]]
    assert log.robots[2].robots.ids.tolist() == [1]
    assert says(log, "robot 1", "1 of other robots")


def test_rows_out_of_order_are_sorted_and_stay_in_order_within_a_stamp(log):
    s = log.robots[1].landmarks
    assert (np.diff(s.t) >= 0).all()
    assert says(log, "robot 1: measurement", "out of order")
    np.testing.assert_array_equal(s.ids[abs(s.t - T - 0.8) < 1e-3], [6, 11, 17])


def test_a_row_that_is_there_twice_counts_once(log):
    s = log.robots[1].landmarks
    last = abs(s.t - T - 4.0) < 1e-3
    assert sorted(s.ids[last]) == [6, 11, 17]


def test_the_first_command_left_over_from_before_is_dropped(log):
    odometry = log.robots[1].odometry
    assert says(log, "robot 1", "first odometry row dropped")
    assert odometry[:, 1].max() == 0.1
    assert odometry[0].tolist() == [T - 0.05, 0, 0]
    assert (np.diff(odometry[:, 0]) > 0).all()


def test_a_robot_that_starts_at_once_keeps_its_first_command(log):
    assert log.robots[2].odometry[0].tolist() == [T, 0.1, 0]
    assert not says(log, "robot 2", "first odometry row")


def test_a_gap_in_the_odometry_is_counted(log):
    assert says(log, "robot 1", "1 odometry gaps", "1.2 s", "command held")


def test_interchanged_places_are_put_right(log):
    assert says(log, "landmarks 11 and 17 are interchanged")
    places = dict(zip(log.ids.tolist(), log.points.tolist(), strict=True))
    assert places == {6: [-2, 0], 11: [-3, 1], 17: [-1, -3]}


def test_places_that_are_right_stay(handmade):
    right = {"11": "-3.0 1.0", "17": "-1.0 -3.0"}

    def swap(lines):
        return [f"{l.split()[0]} {right[l.split()[0]]} 0.1 0.1" if l.split()[0] in right else l for l in lines]

    edit(handmade / "Landmark_Groundtruth.dat", swap)
    log = read_set(Source(handmade), (1,))
    assert not says(log, "interchanged")
    assert log.points.tolist() == [[-2, 0], [-3, 1], [-1, -3]]


def test_without_a_dense_truth_nobody_can_tell(handmade):
    log = read_set(Source(handmade), (2,))
    assert not says(log, "interchanged")
    assert log.points.tolist() == [[-2, 0], [-1, -3], [-3, 1]]


@pytest.mark.parametrize("offset, found", [(0.03, True), (0.3, False)])
def test_interchanged_places_are_found_by_a_sparse_truth(offset, found):
    """A robot in rest whose truth has a row each second; it sees 11 and 17 near these stamps, or far from them."""
    t = np.arange(30.0)
    seen = Sightings(np.repeat(t + offset, 2), np.tile([11, 17], 30), np.tile([[2.0, 0.0], [3.0, np.pi / 2]], (30, 1)))
    nothing = Sightings(np.zeros(0), np.zeros(0, int), np.zeros((0, 2)))
    truth = np.column_stack([t, np.zeros((30, 3))])
    robot = RobotLog(1, np.zeros((0, 3)), seen, nothing, truth, False)
    log = _check_survey(SetLog("x", {1: robot}, np.array([11, 17]), np.array([[0.0, 3.0], [2.0, 0.0]]), []))
    assert says(log, "landmarks 11 and 17 are interchanged") == found
    assert log.points.tolist() == ([[2, 0], [0, 3]] if found else [[0, 3], [2, 0]])


def test_dense_truth_is_interpolated_with_its_heading_on_the_circle(log):
    """Heading pi until 2 s, then 0.5 rad/s to the left; position -0.1 t until 1 s. Kept with 6 decimals."""
    pose = truth_at(log.robots[1], T + np.array([0.525, 1.975, 2.13, 3.0]))
    np.testing.assert_allclose(pose[:, 0], [-0.0525, -0.1, -0.1, -0.1], atol=1e-6)
    off = wrap(pose[:, 2] - [np.pi, np.pi, -np.pi + 0.065, -np.pi + 0.5])  # pi and -pi are one heading
    np.testing.assert_allclose(off, 0, atol=1e-6)


def test_dense_truth_is_not_made_up(log):
    """Before its first row, after its last, and in its gap of 2 s."""
    pose = truth_at(log.robots[1], T + np.array([-0.3, 4.1, 5.0, 6.2, 6.4]))
    assert np.isnan(pose[[0, 2, 3, 4]]).all() and np.isfinite(pose[1]).all()


def test_rows_of_one_sparse_instant_are_one_pose(log):
    """Three rows with headings 3.1405, 3.14159 and -3.1405: their mean is at pi, not at 1.05."""
    truth = log.robots[2].truth
    np.testing.assert_allclose(truth[:, 0], [T + 1.0, T + 2.2])
    np.testing.assert_allclose(truth[0, 1:3], [-0.1, 0], atol=1e-9)
    assert abs(abs(truth[0, 3]) - np.pi) < 1e-3
    assert says(log, "robot 2", "2 instants")


def test_sparse_truth_belongs_to_the_nearest_frame_only(log):
    times = T + np.array([0.9, 1.02, 1.1, 2.0, 2.3])
    pose = truth_at(log.robots[2], times)
    assert np.isfinite(pose[1]).all() and np.isnan(pose[[0, 2, 3, 4]]).all()


def test_no_truth_at_all(handmade):
    (handmade / "Robot1_Groundtruth.dat").unlink()
    log = read_set(Source(handmade), (1,))
    assert says(log, "robot 1: no ground truth")
    assert np.isnan(truth_at(log.robots[1], T + np.arange(3.0))).all()


def test_subjects_without_a_barcode_are_reported(handmade):
    edit(handmade / "Barcodes.dat", lambda lines: lines[:-1])
    assert says(read_set(Source(handmade), (1,)), "subjects [17] have no barcode")


def test_a_barcode_twice(handmade):
    edit(handmade / "Barcodes.dat", lambda lines: [*lines, "18 63"])
    with pytest.raises(ValueError, match=r"Barcodes\.dat has the barcode 63 twice"):
        read_set(Source(handmade), (1,))


@pytest.mark.parametrize("robots", [(), (6,), (0, 1), (1, 1), (1.5,), ("1",)])
def test_robots_that_do_not_exist(handmade, robots):
    with pytest.raises(ValueError, match=r"MRCLAM robots must be some of \[1, 2, 3, 4, 5\], each once; got"):
        read_set(Source(handmade), robots)


@pytest.mark.parametrize("name", ["Barcodes.dat", "Landmark_Groundtruth.dat", "Robot1_Odometry.dat"])
def test_a_missing_file(handmade, name):
    (handmade / name).unlink()
    with pytest.raises(FileNotFoundError, match=f"MRCLAM_Dataset1: no file {name}; there is: "):
        read_set(Source(handmade), (1,))


@pytest.mark.parametrize(
    ("name", "line"),
    [("Robot1_Odometry.dat", 9), ("Robot1_Measurement.dat", 8), ("Robot1_Groundtruth.dat", 7), ("Barcodes.dat", 6)],
)
def test_a_damaged_line(handmade, name, line):
    lines = (handmade / name).read_text().splitlines()
    lines[line - 1] = re.sub(r"\t\s*", "\t x", lines[line - 1], count=1)
    (handmade / name).write_text("\n".join(lines))
    with pytest.raises(ValueError, match=f"MRCLAM_Dataset1: {name}, line {line}: .* is not a finite number: 'x"):
        read_set(Source(handmade), (1,))
