"""`ekfslam convert`: logs of anybody become a recording and a scenario; wrong ones get a sentence."""

import json
import re
import sys
from types import SimpleNamespace

import numpy as np
import pytest

from ekfslam_tutorial.analysis import History
from ekfslam_tutorial.analysis.noise_fit import numbers
from ekfslam_tutorial.cli import main, views
from ekfslam_tutorial.datasets.foreign import convert
from ekfslam_tutorial.datasets.foreign.converting import at_times
from ekfslam_tutorial.datasets.foreign.earth import east_north_up, to_metres
from ekfslam_tutorial.datasets.foreign.looks import heading_unit, time_unit
from ekfslam_tutorial.datasets.foreign.meaning import columns_of
from ekfslam_tutorial.datasets.foreign.scans import scatter
from ekfslam_tutorial.datasets.foreign.tables import Table
from ekfslam_tutorial.toolbox import Recording, UserData, universal_slam


@pytest.fixture(scope="module")
def drive():
    """Two rounds of a robot among 12 landmarks: speeds at 10 Hz, sightings at 2 Hz, truth at 5 Hz."""
    rng, dt = np.random.default_rng(4), 0.1
    world = rng.uniform(-7, 7, (12, 2))
    x, odo, seen, true = np.zeros(3), [], [], []
    for k in range(1, 401):
        v, w = 1.0, 0.3 + 0.1 * np.sin(0.01 * k)
        x = x + dt * np.array([v * np.cos(x[2]), v * np.sin(x[2]), w])
        odo.append((k * dt, v + rng.normal(0, 0.02), w + rng.normal(0, 0.005)))
        true += [(k * dt, *x)] if k % 2 == 0 else []
        if k % 5 == 0:
            way = world - x[:2]
            r, b = np.hypot(*way.T), np.arctan2(way[:, 1], way[:, 0]) - x[2]
            b = np.arctan2(np.sin(b), np.cos(b))
            y = np.column_stack([r + rng.normal(0, 0.03, 12), b + rng.normal(0, 0.01, 12)])
            seen += [(k * dt, i + 1, *y[i]) for i in np.flatnonzero(r < 6)]
    return SimpleNamespace(odo=np.array(odo), seen=np.array(seen), true=np.array(true), world=world)


def write(path, head, rows, mark=","):
    np.savetxt(path, rows, delimiter=mark, header=mark.join(head.split()), comments="", fmt="%.9g")


def played(done):
    """Figures of a run of what was converted."""
    history = History()
    for _ in history.watch(universal_slam(UserData.from_dict(done.scenario), done.recording)):
        pass
    return history.summary()


def test_points_in_metres_of_landmarks_without_ids(drive, tmp_path):
    r, b = drive.seen[:, 2:].T
    points = np.column_stack([drive.seen[:, 0], r * np.cos(b), r * np.sin(b)])
    write(tmp_path / "wheels.csv", "time speed yaw_rate", drive.odo)
    write(tmp_path / "cones.tsv", "stamp x y", points, "\t")
    write(tmp_path / "ground_truth.txt", "t x y yaw", drive.true, ";")
    write(tmp_path / "cone_map.csv", "id x y", np.column_stack([np.arange(101, 113), drive.world]))
    done = convert(tmp_path)
    said = "\n".join(done.said)
    assert "10 Hz" in said and "no ids" in said and "theta: rad, as the path goes" in said
    assert done.scenario["sensor"][0]["type"] == "point_xy"
    f = played(done)
    assert f["landmarks_by"] == "place" and f["n_left_over"] == 0
    assert f["ate_rmse_m"] < 0.2 and f["landmark_rmse_m"] < 0.2


def test_points_to_the_right(drive, tmp_path):
    r, b = drive.seen[:, 2:].T
    write(tmp_path / "odo.csv", "t v w", drive.odo)
    write(tmp_path / "cones.csv", "t x y", np.column_stack([drive.seen[:, 0], r * np.cos(b), -r * np.sin(b)]))
    done = convert(tmp_path, {"scan": {"clockwise": True}})
    np.testing.assert_allclose(done.recording.raw[1].y[:, 1], r * np.sin(b), atol=1e-6)


def test_degrees_milliseconds_millimetres_and_words_in_one_file(drive, tmp_path):
    """A decimal point, empty cells, names for landmarks, the time of day."""
    lines = [(t, f"{1e3 * t + 1.7e12:.0f};{v:.3f};{np.rad2deg(w):.3f};;;") for t, v, w in drive.odo]
    lines += [
        (t, f"{1e3 * t + 1.7e12:.0f};;;tree {i:.0f};{1e3 * r:.0f};{np.rad2deg(b):.3f}") for t, i, r, b in drive.seen
    ]
    text = "\n".join(line for _, line in sorted(lines, key=lambda pair: pair[0]))
    (tmp_path / "all.csv").write_text(f"Timestamp (ms);v;w;landmark;dist;angle\n{text}\n")
    done = convert(tmp_path / "all.csv")
    said = "\n".join(done.said)
    for words in ("t: ms, by its name", "range: mm", "bearing: deg", "w: deg/s", "numbered by the alphabet"):
        assert words in said
    assert done.recording.t[-1] == pytest.approx(40.0, abs=0.2)
    sensor = done.scenario["sensor"][0]
    assert sensor["type"] == "range_bearing" and 0.02 < sensor["range_std"] < 0.15
    f = played(done)
    assert f["n_refused"] < 0.05 * f["n_innovations"] and f["n_landmarks"] == len(np.unique(drive.seen[:, 1]))


def test_measurements_with_noise_of_their_own(drive, tmp_path):
    """Standard deviations in units of their own; a covariance in those of the points, cm; and left out again."""
    write(tmp_path / "odo.csv", "t v w", drive.odo)
    (t, _, r, b), std = drive.seen.T, 0.02 + 0.01 * drive.seen[:, 2]
    columns = np.column_stack([drive.seen, 1000 * std, np.full(len(std), 0.6)])
    write(tmp_path / "scan.csv", "t id range bearing sigma_range[mm] bearing_std_deg", columns)
    done = convert(tmp_path)
    R = done.recording.raw[1].R
    np.testing.assert_allclose(R[:, 0, 0], std**2, rtol=1e-8)  # nine digits are written
    np.testing.assert_allclose(R[:, 1, 1], np.radians(0.6) ** 2)
    assert not R[:, 0, 1].any() and done.scenario["sensor"][0]["bearing_std_deg"] == 0.6
    assert "range_std, bearing_std: the noise of each measurement" in "\n".join(done.said)
    assert [number.name for number in numbers(done.scenario, done.recording)] == ["robot.1.v_std", "robot.1.w_std_deg"]

    without = convert(tmp_path, {"scan": {"range_std": False}})
    assert without.recording.raw[1].R is None and without.scenario["convert"]["scan"]["range_std"] is False
    assert "bearing_std: not used; needed are range_std, bearing_std, or all" in "\n".join(without.said)

    cov = np.tile([4.0, 1.0, 9.0], (len(t), 1))
    points = np.column_stack([drive.seen[:, :2], 100 * r * np.cos(b), 100 * r * np.sin(b), cov])
    write(tmp_path / "scan.csv", "t id x_cm y_cm cov_xx cov_xy cov_yy", points)
    R = convert(tmp_path).recording.raw[1].R
    np.testing.assert_allclose(R, np.tile([[4e-4, 1e-4], [1e-4, 9e-4]], (len(t), 1, 1)))
    points[3, 5] = 7.0
    write(tmp_path / "scan.csv", "t id x_cm y_cm cov_xx cov_xy cov_yy", points)
    words = f"scan: cov_xx, cov_xy, cov_yy must be a positive definite covariance, but at {t[3]:g} s they are not"
    with pytest.raises(ValueError, match=words):
        convert(tmp_path)


def test_lines_that_begin_with_a_word_and_columns_by_number(drive, tmp_path):
    lines = [(t, f"ODOM {t:.3f} {v:.4f} {w:.4f}") for t, v, w in drive.odo]
    lines += [(t, f"UWB {t:.3f} {i:.0f} {r:.3f} ok") for t, i, r, _ in drive.seen]
    (tmp_path / "car.log").write_text("\n".join(line for _, line in sorted(lines, key=lambda pair: pair[0])))
    asked = r"which columns are the odometry .* car.log/ODOM: 1, 2, 3, line; car.log/UWB: 1"
    with pytest.raises(ValueError, match=asked):
        convert(tmp_path / "car.log")
    plan = {
        "odometry": {"from": "car.log/ODOM", "t": 1, "v": 2, "w": 3},
        "scan": {"from": "car.log/UWB", "t": 1, "id": 2, "range": 3},
    }
    done = convert(tmp_path / "car.log", plan)
    assert done.scenario["sensor"][0]["type"] == "range" and done.scenario["landmark"]["hypotheses"] == 64
    again = convert(tmp_path / "car.log", done.scenario["convert"])
    assert again.scenario == done.scenario


def test_poses_of_an_odometry_become_steps(drive, tmp_path):
    write(tmp_path / "odom.csv", "t x y theta", drive.true)
    write(tmp_path / "laser.csv", "t id range bearing", drive.seen)
    done = convert(tmp_path)
    assert done.scenario["robot"][0]["motion"] == "odometry2"
    f = played(done)
    assert f["n_refused"] < 0.02 * f["n_innovations"]


def test_wheels_need_their_base(drive, tmp_path):
    t, v, w = drive.odo.T
    write(tmp_path / "wheels.csv", "t left right", np.column_stack([t, v - 0.2 * w, v + 0.2 * w]))
    write(tmp_path / "laser.csv", "t id range bearing", drive.seen)
    with pytest.raises(ValueError, match=r"speeds of wheels need base, .*: --set odometry.base=\.\.\.$"):
        convert(tmp_path)
    done = convert(tmp_path, {"odometry": {"base": 0.4}})
    np.testing.assert_allclose(done.recording.robots[1].u[10], [v[10], w[10]], rtol=1e-6)
    turning = np.column_stack([t, (v - 0.2 * w) / 0.05, (v + 0.2 * w) / 0.05])
    write(tmp_path / "wheels.csv", "t left_rad_s right_rad_s", turning)
    with pytest.raises(ValueError, match="need their radius in m: --set odometry.radius="):
        convert(tmp_path, {"odometry": {"base": 0.4}})
    done = convert(tmp_path, {"odometry": {"base": 0.4, "radius": 0.05}})
    np.testing.assert_allclose(done.recording.robots[1].u[10], [v[10], w[10]], rtol=1e-6)


def test_a_folder_of_a_stranger(drive, tmp_path):
    """Prose beside the log, ids in base 16, a map and a truth without names and ids, a table that nobody needs."""
    (tmp_path / "README.txt").write_text("Wheels, a radar.\nThe map, by hand: x, y; in m, to 2 cm\n")
    write(tmp_path / "odo.csv", "t v w", drive.odo)
    hexed = "\n".join(f"{t:.2f} {int(i) + 160:#x} {r:.4f} {b:.5f}" for t, i, r, b in drive.seen)
    (tmp_path / "radar.txt").write_text(f"# t id range bearing\n{hexed}\n")
    np.savetxt(tmp_path / "surveyed.txt", drive.world)
    t, x, y, theta = drive.true.T
    nothing = np.zeros(len(t))
    quaternion = [nothing, nothing, np.sin(theta / 2), np.cos(theta / 2)]
    np.savetxt(tmp_path / "truth.tum.txt", np.column_stack([t, x, y, nothing, *quaternion]))
    done = convert(tmp_path)
    said = "\n".join(done.said)
    assert "README" not in said and "not used: surveyed.txt" in said
    assert sorted(set(done.recording.raw[1].ids)) == sorted({int(i) + 160 for i in drive.seen[:, 1]})
    np.testing.assert_allclose(done.recording.truth[1][-1, 2], theta[-1] - 2 * np.pi * np.round(theta[-1] / 2 / np.pi))
    done = convert(tmp_path, {"map": {"from": "surveyed.txt", "x": 1, "y": 2}})
    np.testing.assert_array_equal(done.recording.landmarks.ids, np.arange(1, 13))
    assert "no id of the map is one of the scan's" in "\n".join(done.said)
    with pytest.raises(ValueError, match="map: x and y are needed: --set map.x=COLUMN --set map.y=COLUMN, of 1, 2"):
        convert(tmp_path, {"map": {"from": "surveyed.txt"}})


def test_a_word_is_one_landmark_in_all_tables(drive, tmp_path):
    """The map has a landmark more, the first of the alphabet; the scan must not count without it."""
    name = lambda i: f"tree {chr(97 + int(i))}"
    write(tmp_path / "odo.csv", "t v w", drive.odo)
    rows = "".join(f"{t:.2f},{name(i)},{r:.4f},{b:.5f}\n" for t, i, r, b in drive.seen)
    (tmp_path / "scan.csv").write_text(f"t,id,range,bearing\n{rows}")
    places = [(0, 50.0, 50.0), *((i, *p) for i, p in enumerate(drive.world, 1))]
    (tmp_path / "map.csv").write_text("id,x,y\n" + "".join(f"{name(i)},{x:.4f},{y:.4f}\n" for i, x, y in places))
    done = convert(tmp_path)
    assert played(done)["landmark_rmse_m"] < 0.2 and 1 not in done.recording.raw[1].ids
    assert all(word == f"tree {chr(96 + n)}" for n, word in done.recording.names.items()) and done.recording.names


def test_names_and_the_first_stamp_stay(drive, tmp_path, monkeypatch):
    """They go through both forms of a recording, and into map.csv and result.json of a run."""
    monkeypatch.setattr(views, "write_figures", lambda *arguments: [])
    log_in, out = tmp_path / "log", tmp_path / "out"
    log_in.mkdir()
    write(log_in / "odo.csv", "t v w", drive.odo + [1000, 0, 0])
    rows = "".join(f"{1000 + t:.2f},T{i:02.0f},{r:.4f},{b:.5f}\n" for t, i, r, b in drive.seen)
    (log_in / "scan.csv").write_text(f"t,id,range,bearing\n{rows}")
    log = convert(log_in).recording
    assert log.t0 + log.t[0] == pytest.approx(1000.1) and "T01" in log.names.values()
    for name in ("folder", "log.npz"):
        again = Recording.load(log.save(tmp_path / name))
        assert again.names == log.names and again.t0 == log.t0
    assert main(["convert", str(log_in), "--guess", "--out", str(out)]) == 0
    words = ["--recording", str(out / "recording"), "--out", str(tmp_path / "run"), "--set", "time.last=200"]
    assert main(["run", str(out / "scenario.toml"), *words]) == 0
    head, *rows = (tmp_path / "run/map.csv").read_text().splitlines()
    assert head.endswith(",name") and rows
    assert all(log.names[int(row.split(",")[0])] == row.rpartition(",")[2] for row in rows)
    assert json.loads((tmp_path / "run/result.json").read_text())["t0"] == log.t0


def test_descriptors_tell_landmarks_apart(drive, tmp_path):
    rng = np.random.default_rng(1)
    looks = rng.normal(0, 1, (13, 6))[drive.seen[:, 1].astype(int)] + rng.normal(0, 0.1, (len(drive.seen), 6))
    write(tmp_path / "odo.csv", "t v w", drive.odo)
    head = "t range bearing " + " ".join(f"d{k}" for k in range(6))
    write(tmp_path / "features.csv", head, np.column_stack([drive.seen[:, [0, 2, 3]], looks]))
    done = convert(tmp_path, {"scan": {"descriptor": ["d0", "d5"]}})
    association = done.scenario["options"]["association"]
    assert association["type"] == "descriptors" and association["std"] == pytest.approx(0.1, rel=0.1)
    np.testing.assert_allclose(done.recording.raw[1].d[3], looks[3], rtol=1e-6)
    with pytest.raises(ValueError, match="descriptor must be its first and its last column"):
        convert(tmp_path, {"scan": {"descriptor": "d0"}})


@pytest.mark.parametrize(
    ("factors", "says"),
    [
        ([1, 1], None),
        ([1.3, 1], "goes 1.3 times as far as the truth"),
        ([1, -1], "turns -1 times as far as the truth: is it counted to the right"),
    ],
)
def test_an_odometry_that_does_not_go_with_the_truth(drive, tmp_path, factors, says):
    write(tmp_path / "odo.csv", "t v w", drive.odo * [1, *factors])
    write(tmp_path / "laser.csv", "t id range bearing", drive.seen)
    write(tmp_path / "truth.csv", "t x y yaw", drive.true)
    doubts = [line for line in convert(tmp_path).said if line.startswith("note:")]
    assert len(doubts) == (says is not None) and (says is None or says in doubts[0])


def test_arrays_of_matlab_and_numpy(drive, tmp_path):
    from scipy.io import savemat

    arrays = {"odo": drive.odo, "look": drive.seen}
    savemat(tmp_path / "log.mat", arrays)
    np.savez(tmp_path / "log.npz", **arrays)
    numbers = {"t": 1, "id": 2, "range": 3, "bearing": 4}
    for kind in "mat", "npz":
        plan = {
            "odometry": {"from": f"log.{kind}/odo", "t": 1, "v": 2, "w": 3},
            "scan": {"from": f"log.{kind}/look"} | numbers,
        }
        assert len(convert(tmp_path / f"log.{kind}", plan).recording.raw[1].ids) == len(drive.seen)


def test_homework_with_a_column_for_each_landmark(drive, tmp_path):
    """Ranges and bearings (K, 12), zero where not seen; the landmarks (12, 2); true poses in the same file."""
    from scipy.io import savemat

    n, true = len(drive.true), drive.true
    r, b = np.zeros((n, 12)), np.zeros((n, 12))
    rows = {round(t, 6): k for k, t in enumerate(true[:, 0])}
    here = [row for row in drive.seen if round(row[0], 6) in rows]
    for t, id, *y in here:
        r[rows[round(t, 6)], int(id) - 1], b[rows[round(t, 6)], int(id) - 1] = y
    odo = drive.odo[1::2]
    column = lambda a: np.reshape(a, (-1, 1))
    arrays = {
        "t": column(true[:, 0]),
        "v": column(odo[:, 1]),
        "om": column(odo[:, 2]),
        "r": r,
        "b": b,
        "l": drive.world,
    }
    arrays |= {"x_true": column(true[:, 1]), "y_true": column(true[:, 2]), "th_true": column(true[:, 3]), "r_var": 0.01}
    savemat(tmp_path / "hw.mat", arrays)
    done = convert(tmp_path / "hw.mat")
    assert "r and b have a column for each of 12 landmarks, ids 1 to 12; 0: not seen" in "\n".join(done.said)
    assert len(done.recording.raw[1].ids) == len(here) and len(done.recording.landmarks.ids) == 12
    assert np.isfinite(done.recording.truth[1]).all()
    known = done.scenario | {"landmark": done.scenario["landmark"] | {"in_map": False}}
    history = History()
    for _ in history.watch(universal_slam(UserData.from_dict(known), done.recording)):
        pass
    assert history.summary()["ate_rmse_m"] < 0.1


def test_rows_without_an_id_are_left_out_and_their_look_stays(drive, tmp_path):
    seen = drive.seen.copy()
    last = seen[:, 0] == seen[-1, 0]
    seen[last, 1] = -1  # all of one look
    seen[::5, 1] = -1
    write(tmp_path / "odo.csv", "t v w", drive.odo)
    write(tmp_path / "laser.csv", "t id range bearing", seen)
    done = convert(tmp_path)
    without = int((seen[:, 1] < 0).sum())
    assert f"{without} measurements without an id are left out" in "\n".join(done.said)
    assert len(done.recording.raw[1].ids) == len(seen) - without


def test_kinds_of_lines_of_the_same_length_and_a_large_map(tmp_path):
    lines = [f"STEP {0.5 * k} 0.4 0.0 0.01" for k in range(20)]
    lines += [f"CONE {0.5 * k} {1 + i % 3} {i // 3} {120 * (k % 2) + i}" for k in range(20) for i in range(80)]
    (tmp_path / "grid.log").write_text("\n".join(lines))
    done = convert(
        tmp_path / "grid.log",
        {
            "odometry": {"from": "grid.log/STEP", "t": 1, "dx": 2, "dy": 3, "dtheta": 4},
            "scan": {"from": "grid.log/CONE", "t": 1, "x": 2, "y": 3, "id": 4},
        },
    )
    options = done.scenario["options"]
    assert options["joint"] and "more than 100 landmarks: joint" in "\n".join(done.said)
    assert "compressed" not in options  # where a sensor has no max_range, all that is known counts as looked at


@pytest.mark.parametrize("timed", [False, True])
def test_the_order_of_lines_stands_for_times(drive, tmp_path, timed):
    """As logs of steps have it: what was seen follows the step, and has no time of its own."""
    lines, k = ["# STEP <t> <dx> <dy> <dphi>", "SAW 9 9 99 too many", "ELSE 1", "ELSE 1", "ELSE 1 2"], 0
    for t, v, w in drive.odo:
        lines.append(f"STEP picture{k:04d}.ppm {t:.3f} {0.1 * v:.6f} 0.0 {0.1 * w:.6f}")
        lines += [f"SAW {i:.0f} {r:.4f} {b:.4f}" for a, i, r, b in drive.seen if abs(a - t) < 1e-6]
        k += 1
    (tmp_path / "steps.log").write_text("\n".join(lines))
    plan = {
        "odometry": {"from": "steps.log/STEP", "dx": 3, "dy": 4, "dtheta": 5} | ({"t": 2} if timed else {}),
        "scan": {"from": "steps.log/SAW", "id": 1, "range": 2, "bearing": 3},
    }
    done = convert(tmp_path / "steps.log", plan)
    said, raw = "\n".join(done.said), done.recording.raw[1]
    assert ("a step of 1 s each" in said) is not timed and "1 of 3 rows have not 1 cells" in said
    (note,) = done.recording.notes  # of SAW: nobody uses the others
    assert note.startswith("1 of ") and "row 1 first" in note
    assert done.scenario["convert"]["scan"]["t"] == "line" and len(raw.ids) == len(drive.seen)
    rows = np.searchsorted(drive.odo[:, 0], np.unique(drive.seen[:, 0]) - 1e-6)
    seen_at = done.recording.t[np.diff(raw.offsets) > 0]
    times = drive.odo[rows, 0] if timed else rows + 1.0
    np.testing.assert_allclose(np.diff(seen_at), np.diff(times), atol=1e-6)
    np.testing.assert_allclose(
        done.recording.robots[1].u.sum(0)[2], 0.1 * drive.odo[: rows[-1] + 1, 2].sum(), atol=1e-3
    )
    assert convert(tmp_path / "steps.log", done.scenario["convert"]).scenario == done.scenario
    f = played(done)
    assert f["n_refused"] < 0.02 * f["n_innovations"]


def test_lines_without_times_and_without_an_odometry_among_them(drive, tmp_path):
    write(tmp_path / "odo.csv", "t v w", drive.odo)
    (tmp_path / "seen.log").write_text("SAW 1 2.0 0.1\nSAW 2 3.0 0.1\n")
    with pytest.raises(ValueError, match=r"scan: the lines of seen.log have no times, and no odometry among them"):
        convert(tmp_path, {"scan": {"from": "seen.log/SAW", "id": 1, "range": 2, "bearing": 3}})


def test_a_car_with_an_angle_of_steering_and_a_receiver_in_degrees(drive, tmp_path):
    """Speed and steering of a car 2.5 m long; latitude and longitude beside them, in whole numbers of 1e-7 deg."""
    t, v, w = drive.odo.T
    lat, lon = 50.0 + drive.true[:, 2] / 111_229.0, 8.0 + drive.true[:, 1] / 71_696.0
    write(
        tmp_path / "car.csv", "time velocity steering_deg", np.column_stack([t, v, np.rad2deg(np.arctan(2.5 * w / v))])
    )
    write(tmp_path / "laser.csv", "t id range bearing", drive.seen, "|")
    (tmp_path / "beacons.csv").write_text(f"name,lat,lon\nwest,{lat[0]:.9f},{lon[0] - 1e-3:.9f}\neast,50.0,8.001\n")
    rows = [f"{a:.3f},{1e7 * b:.0f},{1e7 * c:.0f}" for a, b, c in zip(drive.true[:, 0], lat, lon, strict=True)]
    (tmp_path / "receiver.csv").write_text("stamp,lat,lng\n" + "\n".join(rows))
    with pytest.raises(ValueError, match="an angle of steering needs wheelbase, from the rear axle to the front one"):
        convert(tmp_path)
    done = convert(tmp_path, {"odometry": {"wheelbase": 2.5}})
    np.testing.assert_allclose(done.recording.robots[1].u[10], [v[10], w[10]], rtol=1e-5)
    assert "lat, lon: degrees on the ellipsoid WGS 84; x is metres to the east of 50.00" in "\n".join(done.said)
    np.testing.assert_allclose(
        done.recording.fixes[1][:, 1:], drive.true[:, 1:3] - drive.true[0, 1:3], atol=0.03
    )  # 1e-7 deg are 1.1 cm
    west, first = done.recording.landmarks.points[1], done.recording.fixes[1][0, 1:]
    np.testing.assert_allclose(west - first, [-71.696, 0], atol=0.03)
    assert len(done.recording.raw[1].ids) == len(drive.seen)


def test_degrees_on_the_earth_are_metres():
    """A degree of latitude and of longitude as tables of the ellipsoid have it, m; right to 1 mm over 100 m."""
    for lat, north, east in (0, 110_574.3, 111_319.5), (45, 111_131.8, 78_846.8), (60, 111_412.2, 55_800.1):
        p = east_north_up(np.array([lat, lat + 1e-3]), np.array([10 + 1e-3, 10.0]), lat, 10.0)
        np.testing.assert_allclose(p[:2], 1e-3 * np.array([[east, 0], [0, north]]), atol=2e-3)
    with pytest.raises(ValueError, match="degrees from -90 to 90 are needed, got 95"):
        to_metres({"lat": np.array([50.0, 95.0]), "lon": np.zeros(2)})


def test_fixes_far_from_zero_count_from_the_first_one(drive, tmp_path):
    write(tmp_path / "odo.csv", "Zeit_ms v_km_h yaw_rate_deg_s", drive.odo * [1e3, 3.6, 180 / np.pi])
    write(tmp_path / "laser.csv", "t id range bearing", drive.seen)
    write(tmp_path / "gps.csv", "t east north", drive.true[:, :3] + [0, 5e5, 5.4e6])
    done = convert(tmp_path, {"odometry": {"v": "v_km_h"}})  # what ends in _ms, and nothing else, is the time
    said = "\n".join(done.said)
    assert "v: kmh, by its name" in said and "w: deg, by its name" in said and "counted from the first one" in said
    np.testing.assert_allclose(
        done.recording.fixes[1][-1, 1:], drive.true[-1, 1:3] - drive.true[0, 1:3], atol=0.02
    )  # written to cm


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "is empty"),
        ("# nothing\n", "holds nothing but remarks"),
        ("t,v,w\n", "a line of names and no rows"),
        ("t,v,v\n1,2,3\n", "two columns of the name 'v'"),
        ("t,v,w\n1,2\n", "3 names in its first line, but 2 cells"),
        ("a,b,c\n1,2,3\n", "which columns are the odometry (v and w, v and theta, v and steer, left and right, "),
        ("v,w,id,range,bearing\n1,0,1,2,0\n", "odometry: which column of log.csv is the time"),
        ("t,v,w,id,bearing\n1,0,1,2,0\n2,0,1,2,0\n", "which columns are the scan"),
        ("t,v,w,range\n0,1,0,3\n1,1,0,3\n", "Which column is the bearing: --set scan.bearing=COLUMN? Ranges alone"),
        (
            "t,v,w,id,range,range_std\n0,1,0,1,3,1\n1,1,0,1,3,-1\n",
            "scan: range_std must be positive, but at 1 s it is -1",
        ),
        ("t,v,w,id,range\n,1,0,1,3\n,1,0,1,3\n", "no row of log.csv has a number in each of t, v, w"),
    ],
)
def test_what_is_wrong_is_one_sentence(tmp_path, capsys, text, says):
    (tmp_path / "log.csv").write_text(text)
    assert main(["convert", str(tmp_path / "log.csv"), "--out", str(tmp_path / "out")]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert says in line and not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["odometry.v=sped"], "has no column 'sped'; there are t, speed, w; did you mean 'speed'"),
        (["odom.v=speed"], r"no 'odom'; possible: odometry, .*; did you mean 'odometry'"),
        (["odometry.t_unit=hours"], "t_unit must be one of s, ms, us, ns, got 'hours'"),
        (["odometry.speed=v"], "no key 'speed'"),
        (["scan.from=lazer.csv"], "the log has no 'lazer.csv'"),
        (["scan.max_range=30"], "a key of the scenario: ekfslam run ... --set sensor.1.max_range=30"),
        (["sensor.1.max_range=30"], "ekfslam run ... --set sensor.1.KEY=VALUE"),
        (["scan.t_offset=1e6"], "they are in different time bases"),
    ],
)
def test_a_plan_that_does_not_fit_is_one_sentence(tmp_path, capsys, words, says):
    (tmp_path / "odo.csv").write_text("t,speed,w\n0,1,0\n1,1,0\n2,1,0\n")
    (tmp_path / "laser.csv").write_text("t,id,range,bearing\n0,1,3,0\n1,1,2,0\n")
    assert main(["convert", str(tmp_path), *(x for word in words for x in ("--set", word))]) == 2
    assert re.search(says, capsys.readouterr().err)


def test_the_command_writes_what_run_takes(drive, tmp_path, capsys):
    write(tmp_path / "odo.csv", "t v w", drive.odo)
    write(tmp_path / "laser.csv", "t id range bearing", drive.seen[::-1])
    out = tmp_path / "out"
    assert main(["convert", str(tmp_path), "--look"]) == 0 and not out.exists()
    assert main(["convert", str(tmp_path), "--guess", "--out", str(out), "--set", "scan.clockwise=true"]) == 0
    said = capsys.readouterr().out
    assert "times go back" in said and "next: ekfslam run" in said
    recording, data = Recording.load(out / "recording"), UserData.from_toml(out / "scenario.toml")
    assert next(universal_slam(data, recording)).k == 1
    assert main(["convert", str(tmp_path), "--plan", str(out / "scenario.toml"), "--guess", "--out", str(out)]) == 0
    np.testing.assert_array_equal(Recording.load(out / "recording").raw[1].y, recording.raw[1].y)


def test_times_and_headings_tell_their_units():
    for unit, factor in {"s": 1.0, "ms": 1e3, "us": 1e6, "ns": 1e9}.items():
        assert time_unit(factor * np.arange(0, 10, 0.1)) == unit
    assert time_unit(1e9 * (1.7e9 + np.arange(3.0))) == "ns"
    theta = np.linspace(0, 6, 100)
    x, y = np.cos(theta), np.sin(theta)
    assert heading_unit(x, y, theta + 1.6)[0] == "rad" and heading_unit(x, y, np.rad2deg(theta))[0] == "deg"
    assert "do not go with the path" in heading_unit(x, -y, theta)[1]


@pytest.mark.parametrize(
    ("column", "says", "factor"),
    [
        ("Speed [km/h]", "kmh, by its name", 1 / 3.6),
        ("speed_mps", "mps, by its name", 1.0),
        ("Speed (knots)", "knots, by its name", 1852 / 3600),
        ("Speed (furlongs)", "its unit 'furlongs' is not known", 1.0),
    ],
)
def test_units_in_the_names_of_columns(tmp_path, column, says, factor):
    (tmp_path / "odo.csv").write_text(f"t,{column},Yaw Rate [°/s]\n0,1,10\n1,1,10\n2,1,10\n")
    (tmp_path / "laser.csv").write_text("t,id,range,bearing\n0,1,3,0\n1,1,2,0\n")
    done = convert(tmp_path)
    assert says in "\n".join(done.said)
    np.testing.assert_allclose(done.recording.robots[1].u[-1], [factor, np.deg2rad(10)])


def test_scatter_is_that_of_white_noise():
    """1000 numbers on a parabola: within 10 %, three standard deviations of such an estimate."""
    a = np.linspace(0, 3, 1000) ** 2 + np.random.default_rng(0).normal(0, 0.2, 1000)
    assert scatter(a) == pytest.approx(0.2, rel=0.1)
    rng = np.random.default_rng(1)  # a beacon that answers now and then
    t = np.cumsum(rng.exponential(1.0, 1000))
    assert scatter(2 * t + rng.normal(0, 0.2, 1000), t) == pytest.approx(0.2, rel=0.1)


def test_the_truth_has_gaps():
    poses = np.column_stack([np.arange(5.0), np.zeros(5), np.zeros(5)])
    known = np.isfinite(at_times(np.array([-1, 0.5, 5, 10.5, 12]), np.array([0, 1, 2, 10, 11.0]), poses)).all(1)
    assert known.tolist() == [False, True, False, True, False]


def test_between_two_rows_the_truth_goes_on_an_arc():
    t, w, v = np.linspace(0, 4, 41), -0.7, 1.3
    arc = np.column_stack([v / w * np.sin(w * t), v / w * (1 - np.cos(w * t)), w * t])
    np.testing.assert_allclose(at_times(t, t[::10], arc[::10]), arc, atol=1e-12)
    straight = np.column_stack([t, t, 0 * t])
    np.testing.assert_allclose(at_times(t, t[::10], straight[::10]), straight, atol=1e-12)


# --- bags ---


@pytest.fixture(scope="module", params=["bag", "db3", "mcap"])
def bag(request, drive, tmp_path_factory):
    """The drive as a bag: an odometry, markers with ids, true poses, and a laser scan that is of no use."""
    pytest.importorskip("rosbags", reason="bags need rosbags: pip install ekfslam_tutorial[bags]")
    from rosbags import rosbag1, rosbag2
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC if request.param == "bag" else Stores.ROS2_HUMBLE)
    T, folder = store.types, tmp_path_factory.mktemp("bags")
    point, turn = T["geometry_msgs/msg/Point"], T["geometry_msgs/msg/Quaternion"]
    vector, twist = T["geometry_msgs/msg/Vector3"], T["geometry_msgs/msg/Twist"]

    def header(t):
        stamp = T["builtin_interfaces/msg/Time"](int(t), round(t % 1 * 1e9))
        return T["std_msgs/msg/Header"](*([0] if request.param == "bag" else []), stamp, "map")

    def pose(x, y, theta):
        q = turn(0.0, 0.0, np.sin(theta / 2), np.cos(theta / 2))
        return T["geometry_msgs/msg/Pose"](point(x, y, 0.0), q)

    def odometry(t, v, w):
        speed = twist(vector(v, 0.0, 0.0), vector(0.0, 0.0, w))
        unknown = T["geometry_msgs/msg/PoseWithCovariance"](pose(0.0, 0.0, 0.0), np.zeros(36))
        speed = T["geometry_msgs/msg/TwistWithCovariance"](speed, np.zeros(36))
        return T["nav_msgs/msg/Odometry"](header(t), "base", unknown, speed)

    def poses(t, rows):
        return T["geometry_msgs/msg/PoseArray"](header(t), [pose(r * np.cos(b), r * np.sin(b), 0.0) for r, b in rows])

    messages = [(t, "/odom", odometry(t, v, w)) for t, v, w in drive.odo]
    for t in np.unique(drive.seen[:, 0]):
        messages.append((t, "/landmarks", poses(t, drive.seen[drive.seen[:, 0] == t, 2:])))
    for t, *x in drive.true:
        messages.append((t, "/ground_truth", T["geometry_msgs/msg/PoseStamped"](header(t), pose(*x))))
    if request.param == "bag":
        path = folder / "drive.bag"
        writer = rosbag1.Writer(path)
    else:
        path, plugin = folder / "drive", rosbag2.StoragePlugin
        plugin = plugin.MCAP if request.param == "mcap" else plugin.SQLITE3
        writer = rosbag2.Writer(path, version=9, storage_plugin=plugin)
    with writer:
        topics = {}
        for t, topic, message in sorted(messages, key=lambda m: m[0]):
            if topic not in topics:
                topics[topic] = writer.add_connection(topic, message.__msgtype__, typestore=store)
            serialize = store.serialize_ros1 if request.param == "bag" else store.serialize_cdr
            writer.write(topics[topic], round(1e9 * t) + 5_000_000, serialize(message, message.__msgtype__))
    return path


def test_bags_are_read_without_ros(bag, drive):
    """The stamps are those of the headers, 5 ms before those of the bag."""
    done = convert(bag)
    plan = done.scenario["convert"]
    assert plan["odometry"]["v"] == "twist.twist.linear.x" and plan["scan"]["x"] == "poses.position.x"
    assert plan["truth"]["theta"] == "pose.orientation.yaw"
    assert done.recording.t[-1] == pytest.approx(40.0, abs=1e-6) and len(done.recording.raw[1].ids) == len(drive.seen)
    r, b = drive.seen[0, 2:]
    np.testing.assert_allclose(done.recording.raw[1].y[0], [r * np.cos(b), r * np.sin(b)], atol=1e-9)
    if bag.suffix == ".bag":
        assert played(done)["ate_rmse_m"] < 0.2


def test_a_bag_that_is_cut_off_is_one_sentence(bag, tmp_path):
    file = bag if bag.is_file() else next(p for p in sorted(bag.iterdir()) if p.suffix != ".yaml")
    broken = tmp_path / f"broken{file.suffix}"
    broken.write_bytes(file.read_bytes()[:200])
    with pytest.raises(ValueError, match="is no bag that can be read"):
        convert(broken)


def test_without_rosbags_it_says_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "rosbags.highlevel", None)
    (tmp_path / "a.bag").write_bytes(b"#ROSBAG V2.0\n")
    with pytest.raises(ValueError, match=r"pip install ekfslam_tutorial\[bags\]"):
        convert(tmp_path / "a.bag")


def test_logs_of_other_trades_say_the_same(drive, tmp_path):
    """Stamps as dates, signals one a line, JSON lines, things side by side, compass headings: the same recording."""
    plain, other = tmp_path / "plain", tmp_path / "other"
    plain.mkdir(), other.mkdir()
    write(plain / "odo.csv", "t v w", drive.odo)
    write(plain / "scan.csv", "t id range bearing", drive.seen)
    write(plain / "truth.csv", "t x y theta", drive.true)
    day = lambda t: f"2024-05-14T09:{31 + int(t // 60):02d}:{t % 60:06.3f}+02:00"
    lines = [f"{day(t)};{name};{a:.9g}\n" for t, *row in drive.odo for name, a in zip("vw", row, strict=True)]
    (other / "bus.csv").write_text("stamp;signal;value\n" + "".join(lines))
    seen = [f'{{"type": "det", "ms": {1e3 * (t + 1715671860):.0f}, "seen": []}}\n' for t in (1.0, 2.0)]
    for t in np.unique(drive.seen[:, 0]):
        of = drive.seen[drive.seen[:, 0] == t]
        things = ", ".join(f'{{"id": {i:.0f}, "range": {r:.9g}, "bearing": {b:.9g}}}' for _, i, r, b in of)
        seen.append(f'{{"type": "det", "ms": {1e3 * (t + 1715671860):.0f}, "seen": [{things}]}}\n')
    (other / "scan.jsonl").write_text("".join(seen))
    t, x, y, theta = drive.true.T
    rows = zip(t, x, y, (90 - np.rad2deg(theta)) % 360, strict=True)
    cells = [f"{day(a)},{b:.9g},{c:.9g},{h:.9g}\n" for a, b, c, h in rows]
    (other / "rtk_reference.csv").write_text("utc,easting,northing,heading\n" + "".join(cells))
    one, two = convert(plain), convert(other)
    np.testing.assert_allclose(two.recording.raw[1].y, one.recording.raw[1].y, atol=1e-6)
    np.testing.assert_allclose(two.recording.robots[1].u, one.recording.robots[1].u, atol=1e-6)
    known = np.isfinite(one.recording.truth[1]).all(1)
    np.testing.assert_allclose(two.recording.truth[1][known], one.recording.truth[1][known], atol=1e-5)
    assert "theta: from the north to the right" in "\n".join(two.said)


def test_things_side_by_side_and_names_in_the_last_remark(drive, tmp_path):
    rows = [f"{t:.6g},{v:.6g},{w:.6g}\n" for t, v, w in drive.odo]
    (tmp_path / "odo.csv").write_text("% a logger\n% robot A\n% time,v,w\n" + "".join(rows) + "% battery low\n")
    (tmp_path / "scan.csv").write_text("t,id1,range1,bearing1,id2,range2,bearing2\n0.5,4,2,0.1,,,\n1,7,3,0.2,4,2,0.3\n")
    done = convert(tmp_path)
    np.testing.assert_array_equal(done.recording.raw[1].ids, [4, 7, 4])
    np.testing.assert_allclose(done.recording.raw[1].y[:, 0], [2, 3, 2])


def test_the_start_is_as_uncertain_as_the_truth_that_tells_it(drive, tmp_path):
    """A start by a rough truth that the filter took for exact made the NEES as large as one pleases."""
    rough = drive.true + np.random.default_rng(2).normal(0, [0, 0.02, 0.02, 0.01], drive.true.shape)
    write(tmp_path / "odo.csv", "t v w", drive.odo)
    write(tmp_path / "scan.csv", "t id range bearing", drive.seen)
    write(tmp_path / "truth.csv", "t x y theta", rough)
    robot = convert(tmp_path).scenario["robot"][0]
    # 200 rows: the scatter of white noise by its differences is found within a third
    np.testing.assert_allclose(robot["position_std"], 0.02, rtol=0.35)
    np.testing.assert_allclose(robot["orientation_std_deg"], np.rad2deg(0.01), rtol=0.35)


def test_a_folder_of_folders_is_named(tmp_path):
    (tmp_path / "robot_A").mkdir()
    (tmp_path / "robot_A" / "odo.csv").write_text("t,v,w\n0,1,0\n")
    with pytest.raises(ValueError, match="holds no log; but its folder robot_A does"):
        convert(tmp_path)


def test_two_columns_of_words_in_one_file(drive, tmp_path):
    write(tmp_path / "odo.csv", "t v w", drive.odo)
    rows = "".join(f"{t:.2f},{'ab'[int(i) % 2]}{int(i)},{'xy'[int(i) % 2]},{r},{b}\n" for t, i, r, b in drive.seen)
    (tmp_path / "scan.csv").write_text(f"t,id,colour,range,bearing\n{rows}")
    assert len(np.unique(convert(tmp_path).recording.raw[1].ids)) == len(np.unique(drive.seen[:, 1]))


def test_names_of_other_makers_are_known():
    """Headers of a ship, of two lorries that tell steps, and of robots that tell poses of an odometry."""
    known = lambda head, role: columns_of(Table("log.csv", {c: np.ones(2) for c in head.split()}), role)
    assert known("utc hdg_true_deg stw_kn", "odometry") == {"t": "utc", "v": "stw_kn", "theta": "hdg_true_deg"}
    assert known("utc brg_true_deg rng_nm", "scan") == {"t": "utc", "bearing": "brg_true_deg", "range": "rng_nm"}
    steps = {"t": "ts_ms", "robot": "truck", "dx": "d_x", "dy": "d_y", "dtheta": "d_theta_deg"}
    assert known("ts_ms truck d_x d_y d_theta_deg", "odometry") == steps
    poses = {"t": "t", "robot": "unit", "x": "odom_x", "y": "odom_y", "theta": "odom_yaw_deg"}
    assert known("t unit odom_x odom_y odom_yaw_deg", "odometry") == poses


def test_a_mounting_that_was_told_is_said_back(drive, tmp_path):
    write(tmp_path / "odo.csv", "t v w", drive.odo)
    write(tmp_path / "laser.csv", "t id range bearing", drive.seen)
    done = convert(tmp_path, {"scan": {"position": [0.85, -0.25], "orientation_deg": 35}})
    assert "  the sensor is at x 0.85, y -0.25 m, turned 35 deg to the left" in done.said
    done = convert(tmp_path, {"scan": {"orientation_deg": -90.0}})
    assert "  the sensor is at x 0, y 0 m, turned 90 deg to the right" in done.said
    with pytest.raises(ValueError, match=r"of the sensors of all robots alike; got \[\[1, 0\], \[0, 1\]\]"):
        convert(tmp_path, {"scan": {"position": [[1, 0], [0, 1]]}})
