"""Recordings: every bit comes back, and a damaged file is named, with its line."""

import json

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from ekfslam_tutorial.simulation import SimLmk, SimObs
from ekfslam_tutorial.toolbox import ControlLog, RawLog, Recorder, Recording, UserData, universal_slam
from tests.toolbox.scenarios import FLAT, SPACE


def small(R=True, U=True):
    """Three frames, two robots, two sensors; frame 1 is empty; numbers that do not end in binary."""
    rng = np.random.default_rng(1)
    spd = lambda n, m: np.array([np.diag(rng.uniform(0.1, 1, m)) + 0.01 for _ in range(n)])
    counts = [2, 0, 3]
    raw = [SimObs(5, rng.integers(-1, 9, n), rng.normal(size=(n, 2)) / 3, spd(n, 2) if R else None) for n in counts]
    return Recording(
        name="a 'small' run, with commas",
        t=[0.1, 0.2, 0.30000000000000004],
        robots={1: ControlLog(rng.normal(size=(3, 3)) / 7, spd(3, 3) if U else None), 4: rng.normal(size=(3, 3))},
        raw={5: raw, 6: [SimObs(6, np.zeros(0, int), np.zeros((0, 2)))] * 3},
        truth={1: np.array([[1, 2, 3], [np.nan] * 3, [1e-17, 0.1, -0.0]])},
        landmarks=SimLmk(np.array([3, 9]), np.array([[1 / 3, 2.0], [1e300, -5e-324]])),
        notes=["line one", 'quotes " and ümlauts'],
        met={6: [SimObs(6, np.array([4] * n), rng.normal(size=(n, 2)), spd(n, 2) if R else None) for n in (1, 0, 2)]},
        by_event=R,
        fixes={4: rng.normal(size=(2, 3)), 1: rng.normal(size=(4, 4))} if R else {},
    )


def assert_same(a, b):
    assert (a.name, a.notes) == (b.name, b.notes) and np.array_equal(a.t, b.t)
    assert list(a.robots) == list(b.robots) and list(a.raw) == list(b.raw) and list(a.truth) == list(b.truth)
    for i in a.robots:
        assert np.array_equal(a.robots[i].u, b.robots[i].u) and same(a.robots[i].U, b.robots[i].U)
    for i in a.truth:
        assert a.truth[i].tobytes() == b.truth[i].tobytes()
    assert sorted(a.fixes) == sorted(b.fixes)
    assert all(np.array_equal(a.fixes[i], b.fixes[i]) for i in a.fixes)
    assert list(a.met) == list(b.met) and a.by_event == b.by_event
    for c, d in [(a.raw[i], b.raw[i]) for i in a.raw] + [(a.met[i], b.met[i]) for i in a.met]:
        assert np.array_equal(c.offsets, d.offsets) and np.array_equal(c.ids, d.ids)
        assert same(c.y, d.y) and same(c.R, d.R)
    assert (a.landmarks is None) == (b.landmarks is None)
    if a.landmarks is not None:
        assert np.array_equal(a.landmarks.ids, b.landmarks.ids)
        assert np.array_equal(a.landmarks.points, b.landmarks.points)


def same(a, b):
    return a is b if a is None or b is None else np.array_equal(a, b) and a.shape == b.shape


@pytest.mark.parametrize("name", ["run.npz", "run"])
@pytest.mark.parametrize("full", [True, False])
def test_every_bit_comes_back(tmp_path, name, full):
    rec = small(R=full, U=full)
    assert_same(rec, Recording.load(rec.save(tmp_path / name)))


@pytest.mark.parametrize("name", ["run.npz", "run"])
@pytest.mark.parametrize("table", [FLAT, SPACE], ids=["flat", "space"])
def test_simulated_runs_come_back(tmp_path, name, table):
    recorder = Recorder()
    for s in universal_slam(UserData.from_dict(table, {"time.last": 5})):
        recorder.add(s)
    rec = recorder.recording("simulated", notes=["a note"])
    assert len(rec) == 5 and rec.landmarks is not None
    assert_same(rec, Recording.load(rec.save(tmp_path / name)))


numbers = st.floats(allow_nan=False, allow_infinity=False, width=64)


@settings(max_examples=30, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.lists(st.lists(st.tuples(st.integers(-1, 2**40), numbers, numbers), max_size=3), min_size=1, max_size=4))
def test_any_finite_numbers_come_back_from_both_formats(tmp_path, frames):
    raw = [
        SimObs(1, np.array([i for i, *_ in f], int), np.array([y for _, *y in f], float).reshape(-1, 2)) for f in frames
    ]
    rec = Recording("any", np.arange(len(frames), dtype=float), {}, {1: raw})
    for name in ("any.npz", "any"):
        assert_same(rec, Recording.load(rec.save(tmp_path / name)))


def test_a_raw_log_is_a_sequence_of_frames():
    log = small().raw[5]
    assert len(log) == 3 and [len(o) for o in log] == [2, 0, 3] and len(log[-1]) == 3 and len(log[1:]) == 2
    assert log[0].R.shape == (2, 2, 2)
    with pytest.raises(IndexError):
        log[3]


def test_a_recording_without_anything_seen_knows_the_sensors_dimension(tmp_path):
    rec = Recording("blind", [0.0], {}, {2: [SimObs(2, np.zeros(0, int), np.zeros((0, 3)))]})
    for name in ("a.npz", "a"):
        assert Recording.load(rec.save(tmp_path / name)).raw[2].y.shape == (0, 3)


# --- mistakes in memory ----------------------------------------------------------------------------------------------

NAN = float("nan")
BROKEN = [
    (dict(t=[0.0, NAN, 1.0]), r"times t must be finite, got \[0.0, nan, 1.0\]"),
    (dict(t=[0.0, 2.0, 1.0]), "not fall, but frame 2 does"),
    (dict(t=[-1.0, 2.0, 3.0]), "not fall, but frame 0 does"),
    (dict(t=[0.0, 1.0]), "controls of robot 1: 3 frames, but the recording has 2 times t"),
    (
        dict(fixes={1: np.zeros((3, 2))}),
        "fixes of robot 1 must have a time and 2 or 3 coordinates",
    ),
    (dict(fixes={1: [[0.0, NAN, 1.0]]}), "fixes of robot 1 must be finite"),
    (dict(robots={1: np.zeros((3, 2, 1))}), "controls u must have 2 axes"),
    (dict(robots={1: [[1, 2], [3], [4, 5]]}), "controls u must be numbers, in rows of equal length"),
    (dict(robots={1: [[1.0], [np.inf], [2.0]]}), "controls u must be finite"),
    (dict(truth={1: np.zeros((3, 4))}), "truth of robot 1 must have 3 columns .* or 7 .*got shape"),
    (dict(truth={1: np.full((3, 3), np.inf)}), "truth of robot 1 must be finite, or NaN"),
    (dict(landmarks=([1, 1], np.zeros((2, 2)))), "landmark ids must differ"),
    (dict(landmarks=([1.5, 2.0], np.zeros((2, 2)))), "landmarks need N whole ids"),
    (dict(landmarks=([1], np.zeros((1, 4)))), "landmarks need N whole ids and N points in 2D or 3D"),
]


@pytest.mark.parametrize(("change", "message"), BROKEN, ids=[m[:30] for _, m in BROKEN])
def test_mistakes_are_noticed_at_once(change, message):
    rec = small()
    parts = {name: getattr(rec, name) for name in ("name", "t", "robots", "raw", "truth", "landmarks")} | change
    with pytest.raises(ValueError, match=message):
        Recording(**parts)


@pytest.mark.parametrize(
    ("U", "message"),
    [
        (np.ones((3, 2, 2)) * [[1, 2], [0, 1]], "control covariances U must be symmetric, but row 0 is not"),
        (np.stack([np.eye(2), np.eye(2), -np.eye(2)]), "U must be positive semi-definite, but row 2 is not"),
        (np.ones((3, 3, 3)), "U must be 2 x 2 matrices"),
        (np.ones((2, 2, 2)), "2 matrices for 3 rows"),
    ],
)
def test_covariances_must_be_such(U, message):
    with pytest.raises(ValueError, match=message):
        ControlLog(np.zeros((3, 2)), U)


@pytest.mark.parametrize(
    ("parts", "message"),
    [
        (dict(offsets=[0, 1], ids=[1], y=[[NAN, 1]]), "sensor 7: measurements y must be finite"),
        (dict(offsets=[0, 1], ids=[1, 2], y=[[1.0, 1]]), "sensor 7: 2 landmark ids for 1 measurements"),
        (dict(offsets=[0, 2], ids=[1], y=[[1.0, 1]]), "offsets must rise from 0 to the 1 measurements"),
        (dict(offsets=[0, 1, 0, 1], ids=[1], y=[[1.0, 1]]), "offsets must rise"),
        (dict(offsets=[0, 1], ids=[1.5], y=[[1.0, 1]]), "ids must be whole numbers"),
        (dict(offsets=[0, 1], ids=[1], y=[[1.0, 1]], R=[[[1.0, 0], [0, -1]]]), "R must be positive semi-definite"),
    ],
)
def test_raw_logs_must_fit_together(parts, message):
    with pytest.raises(ValueError, match=message):
        RawLog(7, **parts)


def test_covariances_for_all_or_none():
    one, two = small(R=True).raw[5][0], small(R=False).raw[5][2]
    with pytest.raises(ValueError, match="sensor 5: some frames have a covariance R and some do not"):
        RawLog.of(5, [one, two])


# --- mistakes in files -----------------------------------------------------------------------------------------------


def edited(tmp_path, file, old, new):
    """A saved CSV recording with one text replaced."""
    folder = small().save(tmp_path / "run")
    text = (folder / file).read_text()
    assert old in text
    (folder / file).write_text(text.replace(old, new, 1))
    return folder


FILES = [
    ("frames.csv", "0.2\n", "nan\n", r"frames\.csv, line 3: t must be a finite number, got 'nan'"),
    ("frames.csv", "0.2\n", "", r"frames\.csv, line 3: the file ends here with 2 rows; recording\.json says 3"),
    ("frames.csv", "t\n", "time\n", r"frames\.csv, line 1: no column 't' for t; there are: time"),
    ("sensor-5.csv", "frame,id", "frame,is", r"sensor-5\.csv, line 1: no column 'id' for id"),
    ("sensor-5.csv", "\n2,", "\n7,", r"sensor-5\.csv, line 4: frame 7 does not exist; frames.csv has 0 to 2"),
    ("sensor-5.csv", "\n0,", "\n2,", r"sensor-5\.csv, line 3: frame 0 after frame 2; rows go by frame"),
    ("sensor-5.csv", "\n0,", "\n0,,", r"sensor-5\.csv, line 2: 8 values, but there are 7 columns: frame, id, y1, y2"),
    ("sensor-5.csv", "\n0,", "\n0.5,", r"sensor-5\.csv, line 2: frame must be a whole number, got '0\.5'"),
    ("robot-1-controls.csv", "\n1,", "\n2,", r"controls\.csv, line 3: frame 2 where frame 1 was expected"),
    ("robot-1-controls.csv", "u2", "u7", r"controls\.csv, line 1: no column 'u2' for the vector u"),
    ("robot-1-controls.csv", "U12", "V12", r"controls\.csv, line 1: no column 'U12' for the covariance U"),
    (
        "robot-1-truth.csv",
        "x,y,theta",
        "x,y,phi",
        r"truth\.csv, line 1: columns x, y, phi, but possible are x, y, theta",
    ),
    ("landmarks.csv", "\n9,", "\n3,", "landmark ids must differ"),
    ("recording.json", "ekfslam recording 1", "ekfslam recording 9", "json: its format is 'ekfslam recording 9'"),
    ("recording.json", "{", "{{", r"recording\.json is not JSON"),
]


@pytest.mark.parametrize(("file", "old", "new", "message"), FILES, ids=[f"{f}-{m[-25:]}" for f, _, _, m in FILES])
def test_damaged_csv_files_are_named_with_their_line(tmp_path, file, old, new, message):
    with pytest.raises(ValueError, match=message) as caught:
        Recording.load(edited(tmp_path, file, old, new))
    assert "\n" not in str(caught.value)


def test_a_cut_off_csv_file_is_noticed_wherever_it_was_cut(tmp_path):
    folder = small().save(tmp_path / "run")
    whole = (folder / "sensor-5.csv").read_bytes()
    for n in range(len(whole)):
        (folder / "sensor-5.csv").write_bytes(whole[:n])
        with pytest.raises(ValueError, match=r"sensor-5\.csv, line \d+: "):
            Recording.load(folder)


def test_a_cut_off_npz_file_is_noticed_wherever_it_was_cut(tmp_path):
    path = small().save(tmp_path / "run.npz")
    whole = path.read_bytes()
    for n in range(0, len(whole), 61):
        path.write_bytes(whole[:n])
        with pytest.raises(ValueError, match=r"run\.npz is not a whole recording"):
            Recording.load(path)


def test_flipped_bytes_in_npz_never_give_other_numbers_silently(tmp_path):
    rec = small()
    path = rec.save(tmp_path / "run.npz")
    whole = bytearray(path.read_bytes())
    for n in range(0, len(whole), 37):
        damaged = whole.copy()
        damaged[n] ^= 0xFF
        path.write_bytes(damaged)
        try:
            assert_same(Recording.load(path), rec)  # a byte that does not matter, such as a date
        except ValueError as error:
            assert "is not a whole recording" in str(error)


def test_nothing_in_a_file_is_executed(tmp_path):
    path = tmp_path / "evil.npz"
    np.savez(path, format=np.array([print], dtype=object))
    with pytest.raises(ValueError, match="is not a whole recording"):
        Recording.load(path)


def test_missing_files_are_named(tmp_path):
    with pytest.raises(FileNotFoundError, match="no recording at .*nowhere"):
        Recording.load(tmp_path / "nowhere")
    with pytest.raises(FileNotFoundError, match=r"recording\.json is missing: this folder is not a recording"):
        Recording.load(tmp_path)
    folder = small().save(tmp_path / "run")
    (folder / "frames.csv").unlink()
    with pytest.raises(FileNotFoundError, match=r"frames\.csv is missing"):
        Recording.load(folder)
    np.savez(tmp_path / "other.npz", a=np.zeros(3))
    with pytest.raises(ValueError, match=r"other\.npz is not a whole recording: it has no array 'format'"):
        Recording.load(tmp_path / "other.npz")


def test_a_folder_made_by_hand_needs_no_row_counts(tmp_path):
    folder = small().save(tmp_path / "run")
    head = json.loads((folder / "recording.json").read_text())
    del head["rows"], head["notes"]
    (folder / "recording.json").write_text(json.dumps(head))
    assert len(Recording.load(folder)) == 3
