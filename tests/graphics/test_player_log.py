"""State logs: what is read back is what happened, hostile numbers do no harm, and a log stays small."""

import base64
import json
from io import BytesIO
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from PIL import Image

from ekfslam_tutorial.graphics.player import StateLog
from ekfslam_tutorial.graphics.player.coding import lower_factor, pack_factor, unpack_factor
from ekfslam_tutorial.graphics.player.images import image_of
from ekfslam_tutorial.graphics.player.recorder import FINE, GROWN, MOVED
from ekfslam_tutorial.toolbox import UserData, universal_slam

SCENARIOS = Path(__file__).resolve().parents[2] / "data" / "scenarios"


def logged(run, **options):
    """Return the log of a run, and what was true of every frame: a copy, for the run goes on."""
    log, truth = StateLog("a run", **options), []
    for s in run:
        log.add(s)
        truth.append(
            SimpleNamespace(
                lmks={id: lmk.point(s.map) for id, lmk in s.lmks.items()},
                robots={rob.id: (rob.frame(s.map).x.copy(), s.map.P[rob.r, rob.r].copy()) for rob in s.robs},
                truth={id: x.copy() for id, x in s.truth.items()},
                obs={key: (o.z.copy(), o.Z.copy(), o.md2, o.updated) for key, o in s.obs.items() if o.matched},
                events=list(s.events),
            )
        )
    return log, truth


# --- images of a camera ---


def test_every_so_many_frames_have_an_image_with_what_was_measured_in_it(run):
    """Wide images become small ones; the middle of a square and of a cross is where it was measured."""
    log = StateLog("a run", period=2, images=3)
    square = SimpleNamespace(y=np.array([100.0, 60.0]), matched=True, updated=True)
    cross = SimpleNamespace(y=np.array([400.0, 200.0]), matched=True, updated=False)
    sen = SimpleNamespace(id=7)
    for s in run(True):
        log.add(s)
    assert "images" not in log.head and not any("img" in record for record in log.records)
    seen = SimpleNamespace(sens=[sen], raw={7: SimpleNamespace(image=np.full((480, 640), 90, np.uint8))},
                           obs={(7, 1): square, (7, 2): cross})  # fmt: skip
    address = image_of(seen)
    picture = Image.open(BytesIO(base64.b64decode(address.removeprefix("data:image/jpeg;base64,"))))
    assert picture.size == (320, 240) and len(address) < 10_000
    a = np.asarray(picture, float)
    coloured = np.ptp(a, axis=2) > 40
    v, u = np.nonzero(coloured)
    for x, y in (50, 30), (200, 100):
        near = (np.abs(u - x) < 9) & (np.abs(v - y) < 9)
        assert near.any() and abs(u[near].mean() - x) < 1.5 and abs(v[near].mean() - y) < 1.5
    assert image_of(SimpleNamespace(sens=[sen], raw={}, obs={})) is None


def test_a_log_with_images_is_read_back(run):
    log = StateLog("a run", period=2, images=3)
    for s in run(True):
        s.raw[s.sens[0].id] = SimpleNamespace(image=np.zeros((24, 32), np.uint8))
        log.add(s)
    with_image = [i for i, record in enumerate(log.records) if "img" in record]
    assert with_image == list(range(0, len(log), 3)) and log.head["images"] == 6
    assert StateLog.from_json(log.to_json()).to_dict() == log.to_dict()


# --- reading back ---


@pytest.mark.parametrize("flat", [True, False])
def test_what_is_read_back_is_what_happened(run, flat):
    log, truth = logged(run(flat))
    for frame, true in zip(StateLog.from_json(log.to_json()).frames(), truth, strict=True):
        d = 2 if flat else 3
        for id, (x, P) in true.robots.items():
            x_read, L, _ = frame.robots[id]
            assert np.abs(x_read[:d] - x[:d]).max() <= 0.0005 + 1e-9  # rounded to 1 mm ...
            assert np.abs(x_read[d:] - x[d:]).max() <= 0.00005 + 1e-9  # ... and 1e-4
            assert np.abs(L @ L.T - P[:d, :d]).max() <= 0.02 * np.abs(P[:d, :d]).max() + 1e-12
        assert frame.lmks.keys() == true.lmks.keys()
        for id, (p, P) in true.lmks.items():
            assert_close_enough(*frame.lmks[id], p, P)
        read = {(o.sen, o.lmk): o for o in frame.obs}
        assert read.keys() == true.obs.keys()
        for key, (z, Z, md2, updated) in true.obs.items():
            std = np.sqrt(np.diag(Z))
            assert read[key].updated == updated
            assert read[key].md2 == pytest.approx(md2, abs=0.0051)
            assert read[key].std == pytest.approx(std, rel=0.051)  # two digits
            assert (np.abs(read[key].z - z) <= 0.0056 * std).all()
        assert frame.new == [id for id in frame.lmks if ("initialisation", id) in kinds(true.events)]
    assert len(log) == len(truth)


def kinds(events):
    return {(e.kind, e.lmk) for e in events}


def assert_close_enough(p_read, L, p, P):
    """What `StateLog` promises: 0.2 sigma and 20 % of the variance in any direction, of 1 cm at least, and rounding.

    Rounding: 1 mm in the mean, and half a unit of 1/64 of the largest entry in the factor.
    """
    P0 = L @ L.T
    D, V = np.linalg.eigh(P0)
    W = V / np.sqrt(np.maximum(D, 0) + FINE**2)
    coarse = 1.5 / 64 * np.abs(L).max() / np.sqrt(D.min() + FINE**2)
    assert np.linalg.norm(W.T @ (p_read - p)) <= MOVED * (1 + coarse) + 0.0005 * np.sqrt(3) / FINE + 1e-9
    assert np.linalg.norm(W.T @ (P0 - P) @ W, ord=2) <= GROWN * (1 + coarse) ** 2 + 2 * coarse + coarse**2


def test_measured_points_lie_where_the_sensor_saw_them(run):
    """Range and bearing are turned into a point: the robot's pose, as corrected, and the measurement."""
    log = StateLog()
    for s in run(True):
        record = log.add(s)
        F = s.robs[0].frame(s.map)
        for row in record.get("used", {}).get("1", []):
            y = s.obs[1, row[0]].y
            point = F.t + F.R @ (y[0] * np.array([np.cos(y[1]), np.sin(y[1])]))
            assert 0.001 * np.array(row[-2:]) == pytest.approx(point, abs=0.0006)


def test_json_is_read_back_whole(run):
    log, _ = logged(run(False))
    text = log.to_json()
    again = StateLog.from_json(text)
    assert again.to_json() == text
    assert (again.title, again.k, len(again)) == (log.title, log.k, len(log))


def test_a_log_goes_through_a_file(run, tmp_path):
    log, _ = logged(run(True))
    log.title = "Zwei Runden, σ = 0.1 m"
    log.save(tmp_path / "log.json")
    assert StateLog.load(tmp_path / "log.json").to_json() == log.to_json()


def test_a_whole_record_stands_alone(run):
    """A viewer that comes late sees what one sees that was there from the start."""
    log = StateLog()
    for s in run(False):
        log.add(s)
        last = s
    whole = StateLog.from_json(json.dumps({**log.to_dict(), "frames": [log.whole(last)]})).frames()[0]
    frame = log.frames()[-1]
    assert whole.lmks.keys() == frame.lmks.keys() and whole.sens.keys() == frame.sens.keys()
    assert [whole.world[id].tolist() for id in whole.world] == [frame.world[id].tolist() for id in frame.world]
    for id, lmk in last.lmks.items():
        p, P = lmk.point(last.map)
        p_read, L = whole.lmks[id]
        assert p_read == pytest.approx(p, abs=0.00051)
        assert np.abs(L @ L.T - P).max() <= 0.05 * np.abs(P).max()


def test_every_third_frame(run):
    """What happened in the frames between is not lost."""
    snapshots, full, thin = run(True), StateLog(), StateLog(period=3)
    started = set()
    for s in snapshots:
        full.add(s)
        thin.add(s)
        started |= {e.lmk for e in s.events if e.kind == "initialisation"}
    assert len(thin) == -(-len(full) // 3)
    assert [f.k for f in thin.frames()] == [f.k for f in full.frames()][::3]
    told = {id for frame in thin.frames() for id in frame.new}
    assert told == started & set().union(*(frame.lmks for frame in thin.frames()))


# --- size ---


@pytest.mark.parametrize("name, limit_kb", [("range_bearing_2d", 45), ("cloister_idp", 70)])
def test_a_hundred_frames_are_small(name, limit_kb, capsys):
    """Measured: 35 kB in the plane (16 landmarks), 66 kB in the cloister (34 landmarks, 10 corrections a frame)."""
    log = StateLog(name)
    for s in universal_slam(UserData.from_toml(SCENARIOS / f"{name}.toml", {"time.last": 100})):
        log.add(s)
    size_kb = len(log.to_json().encode()) / 1000
    with capsys.disabled():
        print(f" {name}: {size_kb:.1f} kB for {len(log)} frames", end=" ")
    assert len(log) == 100
    assert size_kb <= limit_kb


def test_what_does_not_change_is_not_repeated(run):
    log = StateLog()
    for s in run(True):
        log.add(s)
        last = s
    before = json.dumps(log.records[-1])
    again = log.add(last)
    assert "lmk" not in again and "sen" not in again and "world" not in again
    assert len(json.dumps(again)) < len(before)
    assert log.frames()[-1].lmks.keys() == log.frames()[-2].lmks.keys()


# --- hostile numbers ---

finite = st.floats(-1e3, 1e3)


@given(hnp.arrays(float, (3, 3), elements=finite))
def test_any_covariance_is_kept(A):
    """Singular ones too: entries are kept to 1/64 of the largest one, or 2 %."""
    P = A @ A.T
    L = lower_factor(P)
    assert L == pytest.approx(np.tril(L)) and (np.diag(L) >= 0).all()
    assert L @ L.T == pytest.approx(P, abs=1e-9 * max(P.max(), 1e-30))
    read = unpack_factor(pack_factor(L), 3)
    assert np.abs(read - L).max() <= np.abs(L).max() / 127 + 1e-9


@pytest.mark.parametrize(
    "P", [np.full((2, 2), np.nan), np.diag([1.0, np.inf]), np.diag([1e300, 1.0]), np.diag([1e13, 1])]
)
def test_a_covariance_that_cannot_be_drawn_is_left_out(P):
    assert pack_factor(lower_factor(P)) == []
    assert np.isnan(unpack_factor([], 2)).all()


def test_a_covariance_that_rounding_made_indefinite():
    P = np.array([[1.0, 1.0], [1.0, 1.0 - 1e-12]])
    L = unpack_factor(pack_factor(lower_factor(P)), 2)
    assert L @ L.T == pytest.approx(P, rel=0.02)


class Broken:
    """A landmark whose numbers are what the test says."""

    def __init__(self, id, p, P):
        self.id, self.p, self.P = id, np.array(p, float), np.array(P, float)

    def point(self, map):
        return self.p, self.P


def test_hostile_landmarks(run):
    """NaN, infinity, landmarks that vanish and come again: the log is valid JSON, and says what is not known."""
    s = next(run(True))
    good = {7: Broken(7, [1, 2], np.diag([0.01, 0.04]))}
    bad = {
        1: Broken(1, [np.nan, 0], np.eye(2)),
        2: Broken(2, [1, 1], [[np.nan, 0], [0, 1]]),
        3: Broken(3, [1, 1], np.diag([np.inf, 1])),
        4: Broken(4, [1e300, 1], np.eye(2)),
        5: Broken(5, [2, 2], np.zeros((2, 2))),
        6: Broken(6, [3, 3], np.diag([-1e-18, 1e-4])),
    }
    log = StateLog()
    for s.lmks in (good | bad, {}, good | bad, good, {7: Broken(7, [np.inf, 0], np.eye(2))}, good):
        log.add(s)
    frames = StateLog.from_json(log.to_json()).frames()
    assert [sorted(f.lmks) for f in frames] == [list(range(1, 8)), [], list(range(1, 8)), [7], [7], [7]]
    assert [sorted(f.gone) for f in frames] == [[], list(range(1, 8)), [], list(range(1, 7)), [], []]
    for frame in frames[0], frames[2]:
        assert np.isnan(frame.lmks[1][0]).all() and np.isnan(frame.lmks[4][0]).all()
        assert frame.lmks[2][0].tolist() == [1, 1] and np.isnan(frame.lmks[2][1]).all()
        assert frame.lmks[3][0].tolist() == [1, 1] and np.isnan(frame.lmks[3][1]).all()
        assert (frame.lmks[5][1] == 0).all()
        assert frame.lmks[6][1] == pytest.approx(np.diag([0, 0.01]), abs=2e-4)
    assert np.isnan(frames[4].lmks[7][0]).all()
    assert frames[5].lmks[7][0].tolist() == [1, 2]
    assert frames[5].lmks[7][1] == pytest.approx(np.diag([0.1, 0.2]), abs=0.002)


def test_a_landmark_that_becomes_uncertain_beyond_all_bounds(run):
    s = next(run(True))
    log = StateLog()
    for P in np.eye(2), np.full((2, 2), np.nan), np.eye(2):
        s.lmks = {1: Broken(1, [1, 1], P)}
        log.add(s)
    assert [np.isfinite(f.lmks[1][1]).all() for f in log.frames()] == [True, False, True]


def test_a_lost_robot(run):
    s = next(run(True))
    log = StateLog()
    s.map.x[s.robs[0].r] = np.nan
    log.add(s)
    x, L, _ = StateLog.from_json(log.to_json()).frames()[0].robots[1]
    assert np.isnan(x).all()


def test_innovations_that_are_not_finite(run):
    for s in run(True):
        if len(s.obs) > 2:
            break
    obs = list(s.obs.values())[0]
    obs.z, obs.E = np.array([np.nan, 0.1]), np.diag([1.0, np.inf])
    obs.matched, obs.updated, obs.y = True, False, np.array([1.0, 0.5])
    log = StateLog()
    log.add(s)
    read = next(o for o in StateLog.from_json(log.to_json()).frames()[0].obs if o.lmk == obs.lmk)
    assert np.isnan(read.md2) and np.isnan(read.z).all() and not read.updated


def test_a_frame_without_anything(run):
    s = next(run(True))
    s.lmks, s.obs, s.events, s.truth, s.sim_lmk = {}, {}, [], {}, None
    log = StateLog()
    log.add(s)
    frame = StateLog.from_json(log.to_json()).frames()[0]
    assert frame.lmks == {} and frame.obs == [] and frame.truth == {} and frame.world == {}
    assert set(log.records[0]) == {"k", "t", "rob", "sen"}


def test_a_log_without_a_frame():
    log = StateLog("nothing yet")
    assert StateLog.from_json(log.to_json()).frames() == [] and len(log) == 0


def test_a_known_robot_has_no_covariance(run):
    """Mapping with known poses: the robot is not in the map."""
    data = UserData.from_toml(SCENARIOS / "lecture_mapping.toml", {"time.last": 3})
    log = StateLog()
    for s in universal_slam(data):
        log.add(s)
    assert s.robs[0].r is None
    x, L, std = log.frames()[-1].robots[1]
    assert (L == 0).all() and std == 0 and x == pytest.approx(s.robs[0].frame(s.map).x, abs=0.0006)


# --- a log that is not one ---


@pytest.mark.parametrize(
    "change, words",
    [
        (lambda d: d.update(format="something else"), "begins with"),
        (lambda d: d.update(version=2), "version 2; this program reads version 1"),
        (lambda d: d.pop("robots"), "lacks robots"),
        (lambda d: d.update(units={"m": 1, "rad": 1}), "units"),
        (lambda d: d.update(dim=4), "dimension of a state log is 2 or 3, got 4"),
        (lambda d: d.update(k=-1), "positive number of sigmas"),
        (lambda d: d["sensors"][0].pop("units"), "every sensor id, units and point"),
        (lambda d: d["frames"].append(7), "record 40 of the state log must have k, t, rob.*got int"),
        (lambda d: d["frames"][3].pop("rob"), "record 3 .*must have k, t, rob"),
        (lambda d: d["frames"][3].update(surprise=1), "record 3 .*got .*surprise"),
        (lambda d: d["frames"][2].update(lmk=[[1, 2]]), "record 2 .*a row of 'lmk' is an id and 0 or 2 or 3 or 6"),
        (lambda d: d["frames"][2].update(lmk=[[1, 0.5, 1]]), "record 2 .*whole numbers, got \\[1, 0.5, 1\\]"),
        (lambda d: d["frames"][2].update(lmk=[[1, None, 1]]), "record 2 .*whole numbers"),
        (lambda d: d["frames"][2].update(lmk=[[1, 2, None]]), "record 2 .*whole numbers"),
        (lambda d: d["frames"][2].update(used={"9": [[1, 2, 3]]}), "record 2 "),
        (lambda d: d["frames"][2].update(used={"1": [[1, 2, 3]]}), "record 2 .*observation by sensor 1 has 6 numbers"),
        (lambda d: d["frames"][2].update(t="noon"), "record 2 "),
    ],
)
def test_a_bad_log_is_refused_with_the_reason(run, change, words):
    log, _ = logged(run(True))
    data = json.loads(log.to_json())
    change(data)
    with pytest.raises(ValueError, match=words):
        StateLog.from_json(json.dumps(data))


@pytest.mark.parametrize("text", ["", "{", "[1, 2]", "null", "7"])
def test_a_text_that_is_no_log(text):
    with pytest.raises(ValueError, match="state log"):
        StateLog.from_json(text)


@pytest.mark.parametrize("options", [{"period": 0}, {"period": 1.5}, {"k": 0}, {"k": np.nan}])
def test_bad_options(options):
    with pytest.raises(ValueError, match="period|sigmas"):
        StateLog(**options)


# --- lines ---


def test_lines_are_read_back_with_both_ends():
    data = UserData.from_toml(SCENARIOS / "house_idp.toml", {"time.last": 4})
    log, ends = StateLog("a house"), []
    for s in universal_slam(data):
        log.add(s)
        ends.append({id: lmk.ends(s.map) for id, lmk in s.lmks.items()})
    for frame, true in zip(StateLog.from_json(log.to_json()).frames(), ends, strict=True):
        assert frame.lmks == {} and frame.lines.keys() == true.keys()
        for id, (p, P) in true.items():
            for i in (0, 1):
                assert_close_enough(frame.lines[id][0][i], frame.lines[id][1][i], p[i], P[i])
        assert len(frame.edges) == 23 and all(len(o.z) == 2 for o in frame.obs)
    assert frame.obs and "edge" not in log.records[-1]
