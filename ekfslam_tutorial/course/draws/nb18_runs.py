"""Logs and runs for notebook 18: the five robots of a MRCLAM set where there is one, and of its twin."""

import tempfile
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np

from ...analysis import History
from ...datasets import mrclam, mrclam_twin
from ...datasets.mrclam_log import ROBOTS, read_set
from ...datasets.odometry import OdometryNoise
from ...ekf import correct, covariance, cross, innovation
from ...geometry import Frame2
from ...slam.meetings import project_robots
from ...toolbox import RawLog, UserData, universal_slam
from ...toolbox.rendezvous import find_starts

TWIN, REAL = "simulated twin", "real log"
SETS = (7, 1, 2, 3, 4, 5, 6, 8, 9)  # one with dense ground truth first
SECONDS = {REAL: 240.0, TWIN: 120.0}  # of a log; the whole of set 7 in one filter takes a quarter of a minute
TWIN_NOISE = OdometryNoise(along=0.03, across=0.02, turn=0.06, drift=0.034), mrclam.SightingNoise(0.1, 0.03, 0.013)
"""About what the twin was made with. Its errors are white, so its filter may be told the truth about them."""

SCENARIO = {
    "name": "mrclam_joint",
    "robot": [{"id": 1, "motion": "odometry2", "position": [0, 0], "orientation_deg": 0}],
    "sensor": [{"id": 1, "robot": 1, "type": "range_bearing", "range_std": 0.2, "bearing_std_deg": 1.4}],
    "landmark": {"type": "euc_pnt"},
    "options": {
        "association": "known_ids",
        "md2_threshold": 13.8,
        "reopen_after": 4,
        "reopen_std": [0.3, 0.5],
        "min_inlier_ratio": 0.4,
    },
}
"""That of `mrclam_joint.toml`."""


def _real_set():
    return next((n for n in SETS if mrclam.find_set(n) is not None), None)


def here():
    """Which log the notebook uses: REAL if a set of MRCLAM is found, else TWIN."""
    return REAL if _real_set() is not None else TWIN


@cache
def recording(which=TWIN):
    """The log of the five robots as a recording; the real one is whole, runs stop after `SECONDS`."""
    if which == REAL:
        n = _real_set()
        if n is None:
            raise FileNotFoundError("no set of MRCLAM is found; set EKFSLAM_DATA to the folder with your data sets")
        return mrclam.load(n, ROBOTS)
    with tempfile.TemporaryDirectory() as folder:
        path = mrclam_twin.write(Path(folder) / "MRCLAM_Twin", 1, SECONDS[TWIN], sparse=())
        log = read_set(mrclam.find_set(1, path), ROBOTS)
    return mrclam.recording(log, None, *TWIN_NOISE)


def frames(which=TWIN, seconds=None):
    """How many frames the first seconds of the log have."""
    return int(np.searchsorted(recording(which).t, seconds or SECONDS[which]))


@cache
def starts(which=TWIN):
    """The scenario with the five robots, each with the start that the log itself tells, and what was done for it."""
    return find_starts(UserData.from_dict(SCENARIO).for_robots(list(ROBOTS)), recording(which))


def scenario(which=TWIN, robots=ROBOTS, seconds=None):
    """The scenario with some of the robots."""
    data = starts(which)[0]
    return replace(
        data,
        robots=[r for r in data.robots if r.id in robots],
        sensors=[s for s in data.sensors if s.robot in robots],
        time=replace(data.time, last=frames(which, seconds)),
    )


def part(recording, robots=ROBOTS, met=True):
    """Some robots of a recording, with or without their sightings of each other."""
    keep = lambda logs: {i: log for i, log in logs.items() if i in robots}
    return replace(
        recording,
        robots=keep(recording.robots),
        raw=keep(recording.raw),
        truth=keep(recording.truth),
        met=keep(recording.met) if met else {},
    )


def _run(data, recording):
    history = History("free")
    for _ in history.watch(universal_slam(data, recording)):
        pass
    return history


@cache
def joint(which=TWIN, met=True, robots=ROBOTS, seconds=None):
    """One filter for all robots, with or without the sightings of robots. Returns its history."""
    return _run(scenario(which, robots, seconds), part(recording(which), robots, met))


@cache
def alone(which=TWIN):
    """Five filters that know nothing of each other, each from its own origin. Returns {robot: history}."""
    return {r: _run(_from_origin(scenario(which, (r,))), part(recording(which), (r,), False)) for r in ROBOTS}


def _from_origin(data):
    origin = dict(position=[0.0, 0.0], orientation_deg=0.0, position_std=0.0, orientation_std_deg=0.0)
    return replace(data, robots=[replace(data.robots[0], **origin)])


@cache
def gossip(which=TWIN):
    """Five filters. Who sees another asks it where it is, and takes the answer for news. Returns {robot: history}."""
    rec = recording(which)
    runs = [universal_slam(scenario(which, (r,)), part(rec, (r,), False)) for r in ROBOTS]
    histories = {r: History("free") for r in ROBOTS}
    for k, snapshots in enumerate(zip(*runs, strict=True)):
        of = dict(zip(ROBOTS, snapshots, strict=True))
        for r in ROBOTS:
            seen = rec.met[r][k]
            for id, y, R in zip(seen.ids.tolist(), seen.y, seen.R, strict=True):
                tell(of[r], of[id], y, R)
        for r in ROBOTS:
            histories[r].add(of[r])
    return histories


def tell(me, other, y, R):
    """Correct my map with a sighting of another robot, whose place and covariance it tells me, as if independent."""
    (rob,), (sen,), (him,) = me.robs, me.sens, other.robs
    (o,) = project_robots(me.map, rob, sen, [replace(him, r=None, x=him.state(other.map).copy())])
    P = other.map.P[him.r, him.r][:2, :2]
    PHt = cross(me.map, o.blocks)
    inn = innovation(sen.model.residual(y, o.e), covariance(PHt, o.blocks), R + o.E_l @ P @ o.E_l.T)
    if inn.md2 < SCENARIO["options"]["md2_threshold"]:
        correct(me.map, PHt, inn)


# ---- one sighting ---------------------------------------------------------------------------------------------------


@cache
def sighting(which=TWIN, seconds=60.0):
    """Of all sightings of a robot in the first minute the one that tells the others most, in a filter that uses none.

    Returns
    -------
    dict
        x (n,), P (n, n): the state before; robots {id: slice}, lmks {id: slice}; a, b: who sees whom; y (2,), R (2, 2);
        t, s.
    """
    rec, best = recording(which), (0.0, {})
    for k, now in enumerate(universal_slam(scenario(which, seconds=seconds), part(rec, met=False))):
        for rob in now.robs:
            seen = rec.met[rob.id][k]
            for i, id in enumerate(seen.ids.tolist()):
                gain = _gain(now, rob, id, seen.y[i], seen.R[i])
                if gain > best[0]:
                    best = gain, dict(a=rob.id, b=id, y=seen.y[i], R=seen.R[i], t=now.t, **_state(now))
    return best[1]


def _gain(now, rob, id, y, R):
    """How much of their variance the robots that have no part in it lose by a sighting; 0 for one outside the gate."""
    sen = next(s for s in now.sens if s.id == rob.sensors[0])
    (o,) = project_robots(now.map, rob, sen, [r for r in now.robs if r.id == id])
    PHt = cross(now.map, o.blocks)
    inn = innovation(sen.model.residual(y, o.e), covariance(PHt, o.blocks), R)
    if inn.md2 > 4:
        return 0.0
    less = np.einsum("ij,jk,ik->i", PHt, np.linalg.inv(inn.Z), PHt)
    at = [[r.r.start, r.r.start + 1] for r in now.robs if r.id not in (rob.id, id)]
    return float(sum(less[i].sum() / (np.diag(now.map.P)[i].sum() + 0.01) for i in at))  # 10 cm are small enough


def _state(now):
    """Copies of mean and covariance without gaps, and the places of robots and landmarks in them."""
    owners = [*((r.id, r.r) for r in now.robs), *((i, lmk.r) for i, lmk in now.lmks.items())]
    stops = np.cumsum([r.stop - r.start for _, r in owners]).tolist()
    places = {i: slice(stop - (r.stop - r.start), stop) for (i, r), stop in zip(owners, stops, strict=True)}
    at = np.concatenate([np.arange(r.start, r.stop) for _, r in owners])
    robots = {r.id: places[r.id] for r in now.robs}
    lmks = {i: place for i, place in places.items() if i not in robots}
    return dict(x=now.map.x[at], P=now.map.P[np.ix_(at, at)], robots=robots, lmks=lmks)


# ---- maps -----------------------------------------------------------------------------------------------------------


def landmarks(history, ids):
    """Mean (2 n,) and covariance (2 n, 2 n) of some landmarks at the end of a run."""
    s = history.last
    at = np.concatenate([np.arange(s.lmks[i].r.start, s.lmks[i].r.stop) for i in ids])
    return s.map.x[at], s.map.P[np.ix_(at, at)]


def surveyed(which=TWIN):
    """Ids (N,) and true places (N, 2) of the landmarks."""
    true = recording(which).landmarks
    assert true is not None  # every set of MRCLAM has its survey
    return true.ids, true.points


def common(which=TWIN):
    """Landmarks that all five robots have mapped, and that were surveyed."""
    known = set(surveyed(which)[0].tolist())
    return sorted(known.intersection(*(h.last.lmks for h in alone(which).values())))


def maps_in_one_frame(which=TWIN):
    """The five maps, each made alone, laid into the frame of robot 1 by the uncertain start of its robot.

    Returns
    -------
    list of (l, P)
        (2 n,) and (2 n, 2 n): the landmarks of `common`.
    """
    maps = []
    for robot in starts(which)[0].robots:
        l, P = landmarks(alone(which)[robot.id], common(which))
        start = np.array([*robot.position, np.radians(robot.orientation_deg)])
        std = np.array([robot.position_std] * 2 + [np.radians(robot.orientation_std_deg)], float).ravel()
        q, Q_f, Q_p = Frame2(start).from_frame(l.reshape(-1, 2))
        J = np.zeros((len(l), len(l)))
        for i, block in enumerate(np.broadcast_to(Q_p, (len(q), 2, 2))):
            J[2 * i : 2 * i + 2, 2 * i : 2 * i + 2] = block
        S = Q_f.reshape(len(l), 3)
        maps.append((q.ravel(), J @ P @ J.T + S @ np.diag(std**2) @ S.T))
    return maps


def survey(which=TWIN):
    """True places of the landmarks of `common`, shape (n, 2)."""
    ids, places = surveyed(which)
    of = dict(zip(ids.tolist(), places, strict=True))
    return np.array([of[i] for i in common(which)])


# ---- a wrong list ---------------------------------------------------------------------------------------------------


def mixed_up(pair, which=TWIN, seconds=60.0):
    """The joint run when the barcodes of two robots are mixed up in the list.

    Returns
    -------
    history : History
    accepted, refused : int
        Sightings of robots that passed the gate, and that did not.
    """
    other = {pair[0]: pair[1], pair[1]: pair[0]}
    rec = part(recording(which))
    swap = lambda log: np.array([other.get(i, i) for i in log.ids.tolist()], int)
    rec.met = {s: RawLog(s, log.offsets, swap(log), log.y, log.R) for s, log in rec.met.items()}
    history, passed = History("free"), []
    for s in history.watch(universal_slam(scenario(which, seconds=seconds), rec)):
        passed += [e.flag for e in s.events if e.kind == "meeting"]
    return history, sum(passed), len(passed) - sum(passed)
