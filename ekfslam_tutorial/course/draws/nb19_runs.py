"""Logs and runs for notebook 19: the truck of Victoria Park where its file is, and its twin everywhere."""

from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from ...datasets import victoria_park, victoria_park_raw, victoria_park_twin
from ...datasets.sources import find_file
from ...graphics import StateLog
from ...models.motion import Vehicle
from ...slam import Jcbb, NearestNeighbour, move
from ...slam.association import Matches, distances
from ...slam.projection import project_lmks
from ...toolbox import UserData, universal_slam

TWIN, REAL = "simulated twin", "real log"
SHORT = {REAL: 1200, TWIN: 600}  # scans of the experiments: four minutes, and two
RATIO = 0.2  # a tree that is found in less than this share of its searches is deleted
PICTURES = 80  # of the film, and of the park
SCENARIO = {
    "name": "victoria_park",
    "robot": [{"id": 1, "motion": "vehicle", "position": [-68.3, -40.6], "orientation_deg": 36.6}],
    "sensor": [
        {
            "id": 1,
            "robot": 1,
            "type": "range_bearing",
            "range_std": 0.15,
            "bearing_std_deg": 0.7,
            "max_range": 40.0,
            "fov_deg": 180.0,
        }
    ],
    "landmark": {"type": "euc_pnt"},
    "options": {"joint": True, "compressed": True, "min_search": 10},
}
"""That of `victoria_park.toml`, without its association and its deletion of trees."""

NOISE = victoria_park.ParkNoise(speed=0.2, speed_growth=0.03, steer=np.radians(1.5), slip=np.radians(6.0))


def here():
    """Which log the notebook uses: REAL if a file of Victoria Park is found, else TWIN."""
    found = [find_file(name) for name in (victoria_park.FILE, victoria_park_raw.SCANS)]
    return REAL if any(path is not None for path in found) else TWIN


@cache
def _log(which):
    """The log, and the calibration that belongs to its detections."""
    if which == TWIN:
        return victoria_park_twin.simulate()[0], victoria_park.CALIBRATION
    if find_file(victoria_park.FILE) is not None:
        return victoria_park.read_log(), victoria_park.CALIBRATION
    return victoria_park_raw.read_raw_log(), victoria_park_raw.OWN_CALIBRATION


@cache
def recording(which=TWIN, every=1):
    """The log as a recording: a frame for each scan, detections without ids, GPS beside it.

    Parameters
    ----------
    which : str
    every : int
        Only one scan in so many is kept; the odometry goes on.
    """
    log, calibration = _log(which)
    kept = np.arange(0, len(log.scan_t), every)
    n = np.diff(log.offsets)
    scans = np.repeat(np.arange(len(n)), n)
    thinned = replace(
        log,
        scan_t=log.scan_t[kept],
        offsets=np.concatenate([[0], np.cumsum(n[kept])]),
        detections=log.detections[scans % every == 0],
    )
    return victoria_park.recording(thinned, calibration, NOISE)


def scenario(association=None, min_match_ratio=RATIO, last=None, car=None):
    """The scenario with some rules changed."""
    data = UserData.from_dict(SCENARIO)
    rules = dict(association=association or rule("nn", 0.99, 0.999996), min_match_ratio=min_match_ratio)
    return replace(
        data,
        robots=[replace(data.robots[0], motion=car or Vehicle())],
        options=replace(data.options, **rules),
        time=replace(data.time, last=last),
    )


def rule(name, confidence, new_confidence):
    """An association of the package: "nn" or "jcbb"."""
    kind = {"nn": NearestNeighbour, "jcbb": Jcbb}[name]
    return kind(confidence=confidence, new_confidence=max(new_confidence, confidence))


class Rule:
    """An association made of a student's `sort_scan(D, gate, new_gate)`; it counts what became of the detections."""

    def __init__(self, sort_scan, gate, new_gate):
        self.sort_scan, self.limits, self.counts = sort_scan, (gate, new_gate), {"used": 0, "new": 0, "not used": 0}

    def __call__(self, map, obs, raw, sensor):
        """Match by distance. Returns Matches."""
        D = distances(obs, raw, sensor)
        j = np.asarray(self.sort_scan(D, *self.limits)).astype(int)
        for what, is_it in (("used", j >= 0), ("new", j == -1), ("not used", j == -2)):
            self.counts[what] += int(is_it.sum())
        pairs = {obs[t].lmk: i for i, t in enumerate(j.tolist()) if t >= 0 and obs[t].visible}
        return Matches(pairs, np.flatnonzero(j == -1).tolist())

    birth_id = NearestNeighbour.birth_id


@dataclass(frozen=True)
class Drive:
    """What is kept of a run over F scans."""

    t: np.ndarray  # (F,) s
    path: np.ndarray  # (F, 2) m
    std: np.ndarray  # (F,) m, of the position
    n_trees: np.ndarray  # (F,)
    used: int  # detections that corrected
    seen: int  # detections there were
    born: int  # trees ever started
    trees: np.ndarray  # (N, 2) at the end
    finds: np.ndarray  # (N,) how often each was found
    views: list  # now and then: time, pose, trees


def drive(which, data, every=1):
    """Run EKF-SLAM over the log."""
    rec = recording(which, every)
    n = min(data.time.last or len(rec), len(rec))
    rows, views, used, born, now = [], [], 0, 0, None
    for now in universal_slam(replace(data, time=replace(data.time, last=n)), rec):
        r = now.robs[0].r
        P = now.map.block(r)
        rows.append([now.t, *now.map.state(r)[:2], np.sqrt(P[0, 0] + P[1, 1]), len(now.lmks)])
        kinds = [e.kind for e in now.events]
        used, born = used + kinds.count("correction"), born + kinds.count("initialisation")
        if now.k % max(n // PICTURES, 1) == 0:
            views.append((now.t, now.map.state(r)[:3].copy(), _trees(now)))
    assert now is not None  # a log has scans
    t, x, y, std, count = np.array(rows).T
    seen = int(rec.raw[1].offsets[n])
    finds = np.array([lmk.n_match for lmk in now.lmks.values()])
    return Drive(t, np.column_stack([x, y]), std, count.astype(int), used, seen, born, _trees(now), finds, views)


def _trees(now):
    return np.array([lmk.point(now.map)[0] for lmk in now.lmks.values()]).reshape(-1, 2)


@cache
def park(which=TWIN):
    """The whole log."""
    return drive(which, scenario())


@cache
def film(which=TWIN):
    """The first part of the log for the player: estimates only, no part of the log itself."""
    log = StateLog(f"Victoria Park, {which}", period=SHORT[which] // PICTURES)
    for now in universal_slam(scenario(last=SHORT[which]), recording(which)):
        now.truth, now.obs = {}, {}
        log.add(now)
    return log


@cache
def short(which=TWIN, name="nn", min_match_ratio=RATIO, every=1, ahead=None):
    """A part of the log with other rules.

    Parameters
    ----------
    which : str
    name : str
        "nn" or "jcbb".
    min_match_ratio : float
        Trees that are found in less than this share of their searches are deleted.
    every : int
        One scan in so many is used.
    ahead : float, optional
        Where the filter believes the laser to be, m before the middle of the axle.
    """
    car = None if ahead is None else Vehicle(ahead=ahead, left=0.0)
    data = scenario(rule(name, 0.99, 0.999996), min_match_ratio, SHORT[which] // every, car)
    return drive(which, data, every=every)


@cache
def scan(which=TWIN):
    """The scan that leaves most detections without a tree, before it is used.

    Returns
    -------
    dict
        y (k, 2): detections. e (n, 2), Z (n, 2, 2): expectations of the trees in view and covariances of innovations.
        D (k, n): squared distances. t: s. trees: how many there are in the map.
    """
    rec, n = recording(which), SHORT[which] // 2
    raw, left = rec.raw[1], []
    for now in universal_slam(scenario(last=n), rec):
        left.append(sum(e.kind == "correction" for e in now.events) - len(now.raw[1].y))
    k = n // 2 + int(np.argmin(left[n // 2 :]))
    now = next(s for s in universal_slam(scenario(last=n), rec) if s.k == k)  # the last scan before it: frames from 1
    (rob,), (sen,), control = now.robs, now.sens, rec.robots[1]
    rob.u, rob.U = control.u[k], control.U[k]
    move(now.map, rob, float(rec.t[k] - rec.t[k - 1]))
    obs = [o for o in project_lmks(now.map, rob, sen, now.lmks.values()) if o.visible]
    e, Z = np.array([o.e for o in obs]), np.array([o.E for o in obs]) + sen.model.R
    return dict(y=raw[k].y, e=e, Z=Z, D=distances(obs, raw[k], sen.model), t=float(rec.t[k]), trees=len(now.lmks))


@cache
def views(which=TWIN):
    """A run that deletes nothing: in which scans each tree should have been in view, and in which it was found.

    Returns
    -------
    visible, matched : ndarray, shape (F, N), bool
    """
    rows, n = [], SHORT[which]
    for now in universal_slam(scenario(min_match_ratio=0.0, last=n), recording(which)):
        seen = {e.lmk: e.flag for e in now.events if e.kind == "search"}
        rows.append(seen)
    ids = sorted(set().union(*rows))
    at = {i: k for k, i in enumerate(ids)}
    visible, matched = np.zeros((2, len(rows), len(ids)), bool)
    for k, seen in enumerate(rows):
        for i, found in seen.items():
            visible[k, at[i]], matched[k, at[i]] = True, found
    return visible, matched
