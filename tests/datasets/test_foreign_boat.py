"""`ekfslam convert`: compasses, true bearings, several robots in one log, rows that are there twice."""

from types import SimpleNamespace

import numpy as np
import pytest

from ekfslam_tutorial.analysis import History
from ekfslam_tutorial.analysis.noise_fit import fit_noise
from ekfslam_tutorial.cli import main
from ekfslam_tutorial.datasets.foreign import convert
from ekfslam_tutorial.datasets.foreign.heading import Compass, from_the_bow
from ekfslam_tutorial.geometry import wrap
from ekfslam_tutorial.toolbox import Recording, UserData, universal_slam

KNOT = 1852 / 3600
FROM_NORTH = {"odometry": {"compass": True}, "scan": {"compass": True}}


def sail(start, seed, T=240.0, begin=0.0, std=0.5):
    """A boat on a bow, its compass and its radar: rows of the odometry, of the radar with ids, and of the truth.

    Headings are degrees from the north to the right. The radar adds what the compass says, as radars do.
    """
    rng, dt, x = np.random.default_rng(seed), 0.5, np.array(start, float)
    odo, seen, true = [], [], []
    for k in range(int(T / dt) + 1):
        v, w, t = 3.0, 0.02 + 0.02 * np.sin(0.02 * k), begin + k * dt
        if k:
            x = x + dt * np.array([v * np.sin(x[2] + dt * w / 2), v * np.cos(x[2] + dt * w / 2), w])
        error = rng.normal(0, np.radians(std))
        odo.append((t, np.rad2deg(x[2] + error) % 360, (v + rng.normal(0, 0.1)) / KNOT))
        true.append((t, *x[:2], np.rad2deg(x[2]) % 360))
        way = BUOYS - x[:2]
        r, b = np.hypot(*way.T), np.arctan2(way[:, 0], way[:, 1]) + error
        for i in np.flatnonzero(r < 250) if k % 4 == 0 else ():
            seen.append((t, i + 1, r[i] + rng.normal(0, 1.0), np.rad2deg(b[i] + rng.normal(0, 0.01)) % 360))
    return SimpleNamespace(odo=np.array(odo), seen=np.array(seen), true=np.array(true))


BUOYS = np.random.default_rng(5).uniform([-150, -100], [250, 300], (15, 2))


@pytest.fixture(scope="module")
def boat():
    return sail((0, 0, 0.4), 1)


def write(path, head, rows):
    path.parent.mkdir(exist_ok=True)
    cells = (",".join(a if isinstance(a, str) else f"{a:.9g}" for a in row) for row in rows)
    path.write_text(f"{','.join(head.split())}\n" + "".join(f"{line}\n" for line in cells))


def harbour(boat, folder, ids=True):
    """The boat's log as a stranger writes it."""
    columns = [0, 1, 2, 3] if ids else [0, 2, 3]
    write(folder / "nav.csv", "time heading_deg sog_kn", boat.odo)
    write(folder / "radar.csv", f"time {'id ' * ids}range_m true_bearing_deg", boat.seen[:, columns])
    write(folder / "truth.csv", "time x y heading", boat.true)
    return folder


def played(scenario, recording):
    """Figures of a run."""
    history = History()
    for _ in history.watch(universal_slam(UserData.from_dict(scenario), recording)):
        pass
    return history.summary()


# --- compasses ---


def test_a_boat_with_a_compass_and_true_bearings(boat, tmp_path):
    done = convert(harbour(boat, tmp_path), FROM_NORTH)
    assert [sensor["type"] for sensor in done.scenario["sensor"]] == ["range_bearing", "compass"]
    assert done.told == ["robot.1.w_std_deg", "sensor.2.heading_std_deg"]
    # 481 headings tell their scatter to 10 %
    assert done.scenario["sensor"][1]["heading_std_deg"] == pytest.approx(0.5, rel=0.15)
    assert "turned by the heading at its time, theta = heading_deg of the odometry" in "\n".join(done.said)
    bow = -np.deg2rad(boat.seen[:, 3] - boat.odo[np.searchsorted(boat.odo[:, 0], boat.seen[:, 0]), 1])
    np.testing.assert_allclose(wrap(done.recording.raw[1].y[:, 1] - bow), 0, atol=1e-7)  # nine digits are written
    fit = fit_noise(done.scenario, done.recording, told=done.told)
    assert set(fit.changes) == {"sensor.1.range_std", "sensor.1.bearing_std_deg", "robot.1.v_std"}
    f = played(fit.scenario, fit.recording)
    # radar and dead reckoning agree to a metre; without the compass the map would turn, 0.5 deg are 2 m at its end
    assert f["ate_rmse_m"] < 1.0 and f["n_landmarks"] == len(np.unique(boat.seen[:, 1]))
    assert 0.5 < f["nees_mean"] < 8.0  # one run: the band of one pose is 0.07 to 12.8
    assert convert(tmp_path, done.scenario["convert"]).scenario == done.scenario


def test_without_a_truth_the_map_has_the_north_up(boat, tmp_path):
    (harbour(boat, tmp_path) / "truth.csv").unlink()
    done = convert(tmp_path, FROM_NORTH)
    angle = done.scenario["robot"][0]["orientation_deg"]
    assert wrap(np.deg2rad(angle - (90 - boat.odo[0, 1]))) == pytest.approx(0, abs=1e-4)  # written to 0.01 deg


def test_what_no_ids_mean_is_said(boat, tmp_path):
    done = convert(harbour(boat, tmp_path, ids=False), FROM_NORTH)
    said, (sensor, _) = "\n".join(done.said), done.scenario["sensor"]
    far = np.median(boat.seen[:, 2])
    assert sensor["range_std"] == pytest.approx(0.01 * far, abs=1e-3)
    words = f"it is a guess: range_std = {sensor['range_std']}, bearing_std_deg = {sensor['bearing_std_deg']}"
    assert words in said and "association = nearest_neighbour" in said
    assert "is the bearing one from the north" not in said
    plain = "\n".join(convert(tmp_path).said)
    assert "is the bearing one from the north" in plain and "theta counts to the left; if from the north" in plain


def test_a_heading_without_a_compass_gives_its_turns_only(boat, tmp_path):
    write(tmp_path / "nav.csv", "t v yaw", boat.odo[:, [0, 2, 1]] * [1, KNOT, np.pi / 180])
    write(tmp_path / "scan.csv", "t id range bearing", [(1.0, 1, 5.0, 0.1)])
    done = convert(tmp_path, {"odometry": {"clockwise": True}})
    assert len(done.scenario["sensor"]) == 1 and not done.told and "orientation_deg" not in done.scenario["robot"][0]
    turns = -np.deg2rad(np.diff(boat.odo[:, 1]))
    i = np.searchsorted(done.recording.t, 1.5)  # t = 1 s: the recording begins a step before the log
    np.testing.assert_allclose(done.recording.robots[1].u[i + 1 : i + 9, 1], wrap(turns[2:10]) / 0.5, atol=1e-7)


def test_what_is_seen_along_the_axes_of_the_world_is_turned(rng):
    """Points and covariances by the matrix of the turn; two standard deviations become a covariance."""
    theta, p, std = rng.uniform(-3, 3, 5), rng.normal(size=(5, 2)), rng.uniform(0.1, 0.5, (5, 2))
    seen = {"x": p[:, 0], "y": p[:, 1], "x_std": std[:, 0], "y_std": std[:, 1]}
    turned = from_the_bow(seen, theta)
    for i, a in enumerate(theta):
        R = np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]])
        np.testing.assert_allclose([turned["x"][i], turned["y"][i]], R.T @ p[i])
        C = np.array([[turned[f"cov_{a}"][i] for a in pair] for pair in (("xx", "xy"), ("xy", "yy"))])
        np.testing.assert_allclose(C, R.T @ np.diag(std[i] ** 2) @ R, atol=1e-15)
    assert "x_std" not in turned and from_the_bow({"bearing": theta}, theta)["bearing"].tolist() == [0.0] * 5


def test_whole_degrees_hide_no_noise():
    """A compass that tells whole degrees is no better than they are, 1 / sqrt(12) deg, while the boat goes straight."""
    t = np.arange(0.0, 60.0, 0.5)
    compass = Compass({"t": t, "theta": np.deg2rad(np.round(0.02 * t))}, t[::4])
    assert np.rad2deg(compass.std) == pytest.approx(1 / np.sqrt(12))


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["scan.compass=true", "odometry.clockwise=true"], "clockwise does not say where zero is; --set odometry.comp"),
        (["gps.compass=true"], "gps: compass is true or false, of odometry and scan and truth, got True"),
        (["scan.world=1"], "scan: world is true or false, of scan, got 1"),
        (["scan.world=true", "odometry.v=sog_kn", "odometry.w=time"], "and it has none: --set odometry.theta=COLUMN"),
    ],
)
def test_a_compass_that_does_not_fit_is_one_sentence(boat, tmp_path, capsys, words, says):
    harbour(boat, tmp_path)
    if "w=time" in words[-1]:
        write(tmp_path / "nav.csv", "time tilt sog_kn", boat.odo)
    write(tmp_path / "gps.csv", "time x y", boat.true[:, :3])
    assert main(["convert", str(tmp_path), "--look", *(x for word in words for x in ("--set", word))]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert says in line


# --- several robots ---


@pytest.fixture(scope="module")
def boats(boat):
    """Two boats; the second one begins six seconds later."""
    return {"Ada": boat, "Bo": sail((60, 30, 2.0), 2, begin=6.0)}


def by_column(boats, folder):
    """All rows in the same files, by time."""
    for name, head, part in (
        ("nav.csv", "robot time heading_deg sog_kn", "odo"),
        ("radar.csv", "robot time id range_m bearing_deg", "seen"),
        ("truth.csv", "robot time x y heading", "true"),
    ):
        rows = [(who, *row) for who, one in boats.items() for row in getattr(one, part)]
        write(folder / name, head, sorted(rows, key=lambda row: row[1]))
    return folder


def test_three_ways_to_tell_robots_apart_are_one(boats, tmp_path):
    one = convert(by_column(boats, tmp_path / "column"), FROM_NORTH)
    for who, boat in boats.items():
        (tmp_path / "folders").mkdir(exist_ok=True)
        harbour(boat, tmp_path / "folders" / who)
    two = convert(tmp_path / "folders", FROM_NORTH)
    names = {"odometry": "nav", "scan": "radar", "truth": "truth"}
    for who in boats:
        for name in names.values():
            text = (tmp_path / "folders" / who / f"{name}.csv").read_text()
            write(tmp_path / "files" / f"{name}_{who}.csv", "", [])
            (tmp_path / "files" / f"{name}_{who}.csv").write_text(text)
    hints = convert(tmp_path / "files", FROM_NORTH).said
    assert """not used: nav_Bo.csv, like nav_Ada.csv; of another robot? --set 'odometry.from=["nav_Ada""" in "".join(
        hints
    )
    lists = {role: {"from": [f"{name}_{who}.csv" for who in boats]} for role, name in names.items()}
    three = convert(tmp_path / "files", {role: lists[role] | FROM_NORTH.get(role, {}) for role in lists})
    assert [robot["name"] for robot in one.scenario["robot"]] == ["Ada", "Bo"]
    for other in two, three:
        for id in 1, 2:
            np.testing.assert_array_equal(other.recording.raw[id].y, one.recording.raw[id].y)
            np.testing.assert_array_equal(other.recording.raw[id].ids, one.recording.raw[id].ids)
            np.testing.assert_array_equal(other.recording.robots[id].u, one.recording.robots[id].u)
            np.testing.assert_array_equal(other.recording.truth[id], one.recording.truth[id])
    again = convert(tmp_path / "files", three.scenario["convert"])
    assert again.scenario == three.scenario and again.scenario["convert"]["scan"]["from"] == lists["scan"]["from"]


def test_two_robots_make_one_map(boats, tmp_path):
    """The second robot stands still until its log begins, at its first true pose."""
    done = convert(by_column(boats, tmp_path), FROM_NORTH)
    before = done.recording.t < done.recording.t[-1] - 240.0 - 1e-6
    assert before.sum() == 12 and not done.recording.robots[2].u[before].any()
    f = played(done.scenario, done.recording)
    ids = np.unique(np.concatenate([one.seen[:, 1] for one in boats.values()]))
    assert f["n_landmarks"] == len(ids) and f["ate_rmse_m"] < 1.0  # as of one boat


@pytest.mark.parametrize("told", ["landmarks", "receiver"])
def test_where_robots_start_without_a_truth(boats, tmp_path, told):
    """By the landmarks that both have seen, or by a receiver and a compass."""
    (by_column(boats, tmp_path) / "truth.csv").unlink()
    rng, plan = np.random.default_rng(0), FROM_NORTH
    if told == "receiver":
        rows = [(who, *(row[:3] + [0, *rng.normal(0, 1.0, 2)])) for who, one in boats.items() for row in one.true[::4]]
        write(tmp_path / "gps.csv", "robot t x y", rows)
    else:
        plan = {"odometry": {"clockwise": True}, "scan": {"world": True, "clockwise": True}}
    done = convert(tmp_path, plan)
    one, two = (np.array(robot.get("position", [0, 0])) for robot in done.scenario["robot"])
    if told == "receiver":
        np.testing.assert_allclose(two - one, [60, 30], atol=6.0)  # four sigma of the difference of two fixes
        assert done.scenario["robot"][1]["position_std"] == pytest.approx([1.0, 1.0], rel=0.4)  # 121 fixes
    else:
        assert np.linalg.norm(two) == pytest.approx(np.hypot(60, 30), abs=3.0)  # the frame is the first boat's
        assert "starts of robots [2] relative to robot 1 found" in "\n".join(done.said + done.recording.notes)
        # the scenario says where both start: a truth in the recording moves neither of them
        assert done.scenario["robot"][0]["position"] == [0, 0] and "position" in done.scenario["robot"][1]


def test_robots_that_do_not_fit_are_one_sentence(boats, tmp_path):
    by_column(boats, tmp_path)
    write(tmp_path / "radar.csv", "time id range_m bearing_deg", boats["Ada"].seen)
    with pytest.raises(
        ValueError, match=r"odometry is of the robots Ada, Bo; whose are the rows of radar.csv\? --set sc"
    ):
        convert(tmp_path)
    write(tmp_path / "radar.csv", "robot time id range_m bearing_deg", [("Ada", *row) for row in boats["Ada"].seen])
    with pytest.raises(ValueError, match="odometry is of the robots Ada, Bo, scan of Ada: each robot needs both"):
        convert(tmp_path)
    with pytest.raises(ValueError, match=r"odometry: from = \[...\] names the tables of several robots"):
        convert(tmp_path, {"odometry": {"from": ["nav.csv", "else.csv"]}})


def test_folders_whose_files_have_no_common_name(boats, tmp_path):
    for who, boat in boats.items():
        write(tmp_path / who / f"nav_{who}.csv", "t v theta", boat.odo)
    with pytest.raises(ValueError, match="have no file of the same name, got Ada/nav_Ada.csv, Bo/nav_Bo.csv"):
        convert(tmp_path)


# --- rows that are there twice ---


def test_copies_are_left_out_and_counted(boat, tmp_path):
    clean = convert(harbour(boat, tmp_path / "clean"), FROM_NORTH)
    twice = SimpleNamespace(
        odo=np.vstack([boat.odo, boat.odo[3:4]]), seen=np.vstack([boat.seen, boat.seen[5:25]]), true=boat.true
    )
    done = convert(harbour(twice, tmp_path / "twice"), FROM_NORTH)
    np.testing.assert_array_equal(done.recording.raw[1].y, clean.recording.raw[1].y)
    np.testing.assert_array_equal(done.recording.robots[1].u, clean.recording.robots[1].u)
    one, many = done.recording.notes
    assert one.startswith("odometry: 1 of 482 rows of nav.csv is a copy of another one (the same t, v, theta)")
    assert many == (
        f"scan: 20 of {len(twice.seen):,} rows of radar.csv are copies of another one (the same t, id, range, bearing) "
        "and left out: what is told twice is not known better"
    )
    assert f"  {many.removeprefix('scan: ')}" in done.said and not clean.recording.notes
    done.recording.save(tmp_path / "kept")
    assert Recording.load(tmp_path / "kept").notes == [one, many]
