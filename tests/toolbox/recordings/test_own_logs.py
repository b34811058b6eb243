"""The log of one's own robot: what is wrong with it is said before the run, in one sentence that says where."""

from dataclasses import replace

import numpy as np
import pytest

from ekfslam_tutorial.toolbox import RawLog, Recorder, Recording, UserData, universal_slam
from tests.toolbox.scenarios import FLAT


@pytest.fixture(scope="module")
def log():
    """The recording of a simulated walk, as a robot of one's own would write it."""
    recorder = Recorder()
    for now in universal_slam(UserData.from_dict(FLAT, {"time.last": 10})):
        recorder.add(now)
    return recorder.recording("hall")


def with_sensor(log, ids=lambda ids: ids, y=lambda y: y):
    """The same log with other ids or measurements of sensor 1."""
    raw = log.raw[1]
    return Recording(log.name, log.t, log.robots, {1: RawLog(1, raw.offsets, ids(raw.ids), y(raw.y))}, log.truth)


WRONG = [
    (dict(y=lambda y: y[:, :1]), r"sensor 1 \(RangeBearing\) measures 2 numbers, but the recording 'hall' has 1$"),
    (dict(y=lambda y: np.c_[y, y]), r"sensor 1 \(RangeBearing\) measures 2 numbers, but the recording 'hall' has 4$"),
    (
        dict(y=lambda y: np.c_[y[:, 0], np.degrees(y[:, 1])]),
        r"sensor 1 \(RangeBearing\): y2 = -?\d+\.\d in frame 0 is beyond 2 pi; recordings have radians",
    ),
    (
        dict(ids=lambda ids: np.full_like(ids, -1)),
        r"sensor 1 \(RangeBearing\): all ids in the recording 'hall' are -1, .*nearest_neighbour or jcbb",
    ),
]


@pytest.mark.parametrize(("change", "message"), WRONG, ids=["too few", "too many", "degrees", "no ids"])
def test_a_log_that_does_not_fit_is_refused_before_the_run(log, change, message):
    with pytest.raises(ValueError, match=message):
        universal_slam(UserData.from_dict(FLAT), with_sensor(log, **change))


def test_landmarks_in_space_do_not_fit_into_the_plane(log):
    points = np.c_[log.landmarks.points, np.zeros(len(log.landmarks.ids))]
    other = replace(log, landmarks=(log.landmarks.ids, points))
    with pytest.raises(ValueError, match="the landmarks of the recording 'hall' have 3 coordinates, needed are 2$"):
        universal_slam(UserData.from_dict(FLAT), other)


def test_landmark_ids_are_not_negative(log):
    with pytest.raises(ValueError, match="landmark ids must be 0 or more, got -1$"):
        replace(log, landmarks=(np.array([-1, 4]), np.zeros((2, 2))))


def heads_only(folder, *but):
    """The same folder without a row, except in some files."""
    (folder / "recording.json").write_text('{"format": "ekfslam recording 1", "name": "hall"}')
    for file in folder.glob("*.csv"):
        if file.name not in but:
            file.write_text(file.read_text().partition("\n")[0] + "\n")
    return folder


def test_a_log_without_frames_is_refused(log, tmp_path):
    empty = Recording.load(heads_only(log.save(tmp_path / "hall")))
    with pytest.raises(ValueError, match="the recording 'hall' has no frames$"):
        universal_slam(UserData.from_dict(FLAT), empty)
    folder = heads_only(log.save(tmp_path / "controls"), "robot-1-controls.csv")
    with pytest.raises(
        ValueError, match=r"robot-1-controls\.csv, line 2: frame 0 does not exist; frames.csv has none$"
    ):
        Recording.load(folder)


def test_some_measurements_without_an_id_and_bearings_of_any_turn_are_fine(log):
    other = with_sensor(log, lambda ids: np.where(np.arange(len(ids)) % 2, ids, -1), lambda y: y % [99, 2 * np.pi])
    *_, now = universal_slam(UserData.from_dict(FLAT), other)
    assert len(now.lmks) >= 3


def test_measurements_without_ids_are_for_the_other_associations(log):
    other = with_sensor(log, lambda ids: np.full_like(ids, -1))
    *_, now = universal_slam(UserData.from_dict(FLAT, {"options.association": "nearest_neighbour"}), other)
    assert len(now.lmks) >= 3


FILES = [
    ("frames.csv", lambda text: text.replace("1.0\n", "0.2\n"), "{}: times t must .* not fall, but frame 1 does"),
    ("sensor-1.csv", lambda text: text.replace(",", ";"), "{}/sensor-1.csv, line 1: columns are separated by commas"),
    ("sensor-1.csv", lambda text: text.replace(",", "\t"), "{}/sensor-1.csv, line 1: columns are separated by commas"),
    ("landmarks.csv", lambda text: text + text.splitlines()[1] + "\n", "{}.*: landmark ids must .* 1 stands twice"),
    (
        "recording.json",
        lambda text: '{"format": "mine", "name": "hall"}',
        "{}/recording.json: its format is 'mine', known is 'ekfslam",
    ),
    ("recording.json", lambda text: '{"format": "ekfslam recording 1"}', "{}/recording.json must .* a name"),
]


@pytest.mark.parametrize(("file", "edit", "message"), FILES)
def test_every_complaint_about_a_folder_says_which(log, tmp_path, file, edit, message):
    folder = log.save(tmp_path / "hall")
    head = folder / "recording.json"
    head.write_text('{"format": "ekfslam recording 1", "name": "hall"}')
    (folder / file).write_text(edit((folder / file).read_text()))
    with pytest.raises(ValueError, match=message.format(folder)):
        Recording.load(folder)


def test_the_time_of_day_is_no_time_since_the_start(log):
    """Without the truth to start at, the robot would drive on since 1970 in the first frame."""
    with pytest.raises(
        ValueError, match=r"times t are seconds since the start, but begin at 1763750000.5: subtract the first"
    ):
        Recording(log.name, log.t + 1763750000, log.robots, log.raw)


def test_a_covariance_that_is_none_is_named_with_its_file(log, tmp_path):
    folder = log.save(tmp_path / "hall")
    (folder / "recording.json").write_text('{"format": "ekfslam recording 1", "name": "hall"}')
    head, *rows = (folder / "sensor-1.csv").read_text().splitlines()
    lines = [head + ",R11,R12,R22", *(row + ",-1,0,1" for row in rows)]
    (folder / "sensor-1.csv").write_text("\n".join(lines) + "\n")
    with pytest.raises(ValueError, match=r"hall/sensor-1\.csv: sensor 1: covariances R must be positive semi-definite"):
        Recording.load(folder)


def test_one_file_of_a_folder_is_not_the_folder(log, tmp_path):
    folder = log.save(tmp_path / "hall")
    with pytest.raises(ValueError, match=r"sensor-1\.csv .*: give the folder that it is in"):
        Recording.load(folder / "sensor-1.csv")
