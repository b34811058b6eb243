"""Tables of a log become messages, messages a recording, and a scenario is written that plays it."""

from dataclasses import dataclass

import numpy as np

from ...geometry import Frame2, wrap
from ...simulation import SimLmk
from ...toolbox import UserData
from ...toolbox.messages import Control, Measurement, recording_of
from ...toolbox.recordings import Recording
from ..odometry import OdometryNoise
from . import looks
from .meaning import NAMES, WAYS, checked, find, guess
from .tables import read_tables

STEP_NOISE = OdometryNoise(along=0.05, across=0.02, turn=0.05, drift=0.01)
"""Of an odometry that gives steps or poses; speeds have a noise of their own in the scenario."""
SHARE = 0.1
"""Speeds are taken for wrong by this share of their usual size, at least: wheels slip, all the same way."""
LEAST = {"v": 0.02, "w": 0.01, "range": 0.05, "bearing": 0.005, "xy": 0.05}
"""No noise is taken for smaller than this: m/s, rad/s, m, rad, m."""
UNKNOWN = {"range": 0.1, "bearing": 0.03, "xy": 0.1}
"""Noise where the log cannot tell it."""
APART = 1e5
"""Times of two tables that are so many seconds apart are in different time bases."""


@dataclass
class Converted:
    """A log as the package has it.

    Parameters
    ----------
    recording : Recording
    scenario : dict
        Tables of a scenario file that plays it, the plan in `convert` included.
    said : list of str
        What was seen, line by line.
    """

    recording: Recording
    scenario: dict
    said: list


def convert(path, plan=None, name=None):
    """Make a recording and a scenario of a log of any form, in the plane.

    Parameters
    ----------
    path : path
        A file, a folder of files, or a bag.
    plan : dict, optional
        What the columns mean, `{"odometry": {"from": "odo.csv", "t": "time", "v": "speed", "w": "yaw_rate"}, ...}`:
        see docs/your_log.md. What is not said is guessed by the names.
    name : str, optional

    Returns
    -------
    Converted

    Raises
    ------
    ValueError, OSError
        One sentence.
    """
    tables = read_tables(path)
    said = [line for table in tables for line in seen(table)]
    plan = completed(plan or {}, tables)
    log = _Log(plan, {table.name: table for table in tables})
    scenario, data = log.scenario(name or "log")
    said += log.said
    recording = log.recording(data)
    recording.notes += [note for table in tables for note in table.notes]
    return Converted(recording, scenario | {"convert": plan}, [*said, *log.after(recording)])


def seen(table):
    """Lines on a table: its columns, and what was noted when it was read."""
    kind = f" ({table.kind})" if table.kind else ""
    yield f"{table.name}{kind}: {len(table):,} rows of {', '.join(table.columns) or 'nothing'}"
    for note in table.notes:
        yield f"  {note}"


def completed(plan, tables):
    """The plan with what names tell of the rest."""
    guessed = guess(tables)
    place = lambda role, entry: {"from": guessed[role]["from"]} | entry if role in guessed else entry
    told = checked({role: place(role, e) if isinstance(e, dict) else e for role, e in plan.items()}, tables)
    for role, entry in guessed.items():
        if role not in plan:
            told[role] = entry
        elif role in told and told[role]["from"] == entry["from"]:
            whole = any(way <= set(told[role]) for way in WAYS.get(role, ()))
            told[role] = {m: c for m, c in entry.items() if not whole or m in ("t", "id")} | told[role]
    told = {role: _with_time(entry, tables) if role != "map" else entry for role, entry in told.items()}
    there = "; ".join(f"{table.name}: {', '.join(table.columns)}" for table in tables)
    for role, what in (("odometry", "v and w, or dx and dtheta, or x, y and theta"), ("scan", "range, or x and y")):
        if role not in told:
            raise ValueError(
                f"which columns are the {role} ({what})? Say so with --set {role}.NAME=COLUMN. The log has {there}"
            )
    return told


def _with_time(entry, tables):
    """An entry with its column of times, found by its name if need be."""
    if "t" in entry:
        return entry
    table = next(table for table in tables if table.name == entry["from"])
    column = find(table, "t")
    if column is None:
        raise ValueError(f"{table.name}: which column is the time? t = one of {', '.join(table.columns)}")
    return entry | {"t": column}


class _Log:
    """Columns by role and meaning, in SI units and radians, sorted by time."""

    def __init__(self, plan, tables):
        self.plan, self.said, self.parts = plan, [], {}
        degrees, of_time = False, None
        for role in sorted(plan, key=["odometry", "scan", "truth", "gps", "map"].index):
            entry, table = plan[role], tables[plan[role]["from"]]
            alike = self._alike(entry, table, of_time)
            units = looks.units(entry, table, alike, degrees)
            degrees = degrees or any("deg" in words for m, (_, words) in units.items() if m in ("bearing", "theta"))
            if role == "odometry" and "t" in entry:
                of_time = units["t"][1].partition(",")[0], table.columns[entry["t"]]
            self.parts[role] = self._read(role, entry, table, units)
        if "scan" in self.parts and degrees and "angle_unit" not in plan["odometry"]:  # bearings tell of turn rates
            entry, table = plan["odometry"], tables[plan["odometry"]["from"]]
            again = looks.units(entry, table, None, True)
            if again != looks.units(entry, table):
                self.said = [line for line in self.said if not line.startswith("odometry")]
                self.parts["odometry"] = self._read("odometry", entry, table, again)
        self._check_times()

    @staticmethod
    def _alike(entry, table, of_time):
        """The unit of the odometry's times, if those of this table are of the same size."""
        if of_time is None or "t" not in entry:
            return None
        mine, other = (np.nanmedian(np.abs(a)) for a in (table.columns[entry["t"]], of_time[1]))
        return of_time[0] if 0.1 < mine / max(other, 1e-12) < 10 else None

    def _read(self, role, entry, table, units):
        part = {m: table.columns[c] for m, c in entry.items() if m in NAMES}
        if role != "map":
            t = part["t"] * units["t"][0] + float(entry.get("t_offset", 0.0))
            part["t"] = np.round(t, 6)  # what is measured at one time has one time, whatever was added
        part |= {m: part[m] * factor for m, (factor, _) in units.items() if m != "t"}
        if entry.get("clockwise"):
            part |= {m: -part[m] for m in ("bearing", "theta", "w", "dtheta") if m in part}
        needed = [m for m in part if m != "id" or role == "map"]
        whole = np.all([np.isfinite(part[m]) for m in needed], axis=0)
        part = {m: a[whole] for m, a in part.items()}
        lost = int((~whole).sum())
        if not whole.any():
            raise ValueError(f"{role}: no row of {entry['from']} has a number in each of {', '.join(needed)}")
        words = [f"{role}: {', '.join(f'{m} = {entry[m]}' for m in part)} of {entry['from']}"]
        words += [f"  {m}: {text}" for m, (_, text) in units.items()]
        if lost:
            words.append(f"  {lost:,} of {len(whole):,} rows have no number in one of them and are left out")
        if "t" in part:
            back = int((np.diff(part["t"]) < 0).sum())
            order = np.argsort(part["t"], kind="stable")
            part = {m: a[order] for m, a in part.items()}
            words.append(f"  {looks.rate(part['t'])}")
            if back:
                words.append(f"  times go back {back} time{'s' * (back > 1)}: rows are put in order")
        if {"x", "y"} <= set(part) and role in ("odometry", "truth", "gps"):
            jump = looks.jumps(np.column_stack([part["x"], part["y"]]))
            words += [f"  {jump}"] if jump else []
        if role == "scan":
            words.append(f"  {looks.ids(part.get('id', np.zeros(0)))}")
        self.said += words
        return part

    def _check_times(self):
        begin = {role: float(part["t"][0]) for role, part in self.parts.items() if "t" in part}
        end = {role: float(part["t"][-1]) for role, part in self.parts.items() if "t" in part}
        for role in begin:
            if role == "odometry" or (begin[role] <= end["odometry"] and end[role] >= begin["odometry"]):
                continue
            spans = [f"{begin[r]:.10g} to {end[r]:.10g} s" for r in ("odometry", role)]
            other = abs(begin[role] - begin["odometry"]) > APART
            why = "they are in different time bases" if other else "they do not meet"
            raise ValueError(
                f"odometry lasts from {spans[0]}, {role} from {spans[1]}: {why}; --set {role}.t_unit=ms, or "
                f"--set {role}.t_offset={begin['odometry'] - begin[role]:.6f} (s), puts them together"
            )

    # --- what is made of it ---

    @property
    def sensor(self):
        """What the scan measures: "range_bearing", "range" or "point_xy"."""
        scan = self.parts["scan"]
        if "range" in scan:
            return "range_bearing" if "bearing" in scan else "range"
        if {"x", "y"} <= set(scan):
            return "point_xy"
        raise ValueError(
            f"scan: {', '.join(m for m in scan if m != 't') or 'the time'} alone starts no landmarks; "
            "range, range and bearing, or x and y are needed"
        )

    @property
    def way(self):
        """How the odometry says what the robot did: "v", "left", "dx" or "x"."""
        odo = set(self.parts["odometry"])
        for way in WAYS["odometry"]:
            if way <= odo:
                return next(m for m in ("v", "left", "dx", "x") if m in way)
        raise ValueError(
            f"odometry: {', '.join(sorted(odo - {'t'})) or 'the time'} alone does not say how the robot moves; v and "
            "w, dx and dtheta, x, y and theta, or left and right (with base, m) are needed"
        )

    def scenario(self, name):
        """Tables of a scenario, with noise by the scatter of the log; and the same, read."""
        robot = {"id": 1, "motion": "odometry2"}
        if self.way in ("v", "left"):
            robot = {"id": 1, "motion": "unicycle"} | self._speed_noise()
        kind, scan = self.sensor, self.parts["scan"]
        sensor = {"id": 1, "robot": 1, "type": kind}
        known = "id" in scan and bool((scan["id"][np.isfinite(scan["id"])] >= 0).any())
        landmark: dict = {"type": "euc_pnt"}
        if kind == "range" and not known:
            raise ValueError("scan: ranges without ids cannot be told apart; which column is the id of the beacon?")
        if kind == "point_xy":
            sensor["std"] = max(self._scatter("x"), self._scatter("y"))
        else:
            sensor["range_std"] = self._scatter("range")
        if kind == "range_bearing":
            sensor["bearing_std_deg"] = round(float(np.rad2deg(self._scatter("bearing"))), 3)
        if kind == "range":
            landmark["hypotheses"] = 64
        options = {"association": "known_ids" if known else "nearest_neighbour", "md2_threshold": 13.8}
        table = {"name": name, "robot": [robot], "sensor": [sensor], "landmark": landmark, "options": options}
        words = [f"{k} = {v}" for k, v in (robot | sensor | options).items() if k.endswith(("_std", "_deg", "ation"))]
        self.said.append(f"taken from the log: {robot['motion']}, {kind}; {', '.join(words)}")
        return table, UserData.from_dict(table)

    def _speed_noise(self):
        v, w = self._speeds()
        low = lambda a, key: max(SHARE * float(np.quantile(np.abs(a), 0.9)), scatter(a), LEAST[key])
        return {"v_std": round(low(v, "v"), 3), "w_std_deg": round(float(np.rad2deg(low(w, "w"))), 2)}

    def _speeds(self):
        odo = self.parts["odometry"]
        if self.way == "v":
            return odo["v"], odo["w"]
        base = self.plan["odometry"].get("base")
        if not isinstance(base, int | float) or base <= 0:
            raise ValueError(f"odometry: speeds of wheels need base, how far they are apart in m, got {base!r}")
        return (odo["left"] + odo["right"]) / 2, (odo["right"] - odo["left"]) / base

    def _scatter(self, meaning):
        """Noise of a measurement by the scatter of neighbouring ones of the same landmark."""
        scan, key = self.parts["scan"], "xy" if meaning in "xy" else meaning
        if "id" not in scan:
            return UNKNOWN[key]
        found = []
        for id in np.unique(scan["id"][scan["id"] >= 0]):
            mine = scan["id"] == id
            a = np.unwrap(scan[meaning][mine]) if meaning == "bearing" else scan[meaning][mine]
            found.append(scatter(a))
        found = [std for std in found if np.isfinite(std)]
        return round(max(float(np.median(found)), LEAST[key]), 4) if found else UNKNOWN[key]

    def messages(self):
        """Controls and measurements."""
        odo, scan, kind = self.parts["odometry"], self.parts["scan"], self.sensor
        t, first = np.unique(odo["t"], return_index=True)
        if self.way in ("v", "left"):
            yield from (Control(a, u) for a, u in zip(t, np.column_stack(self._speeds())[first], strict=True))
        else:
            yield from self._steps(t, first)
        y = {"range": ["range"], "range_bearing": ["range", "bearing"], "point_xy": ["x", "y"]}[kind]
        y = np.column_stack([wrap(scan[m]) if m == "bearing" else scan[m] for m in y])
        ids = np.where(np.isfinite(scan["id"]), scan["id"], -1).astype(int) if "id" in scan else np.full(len(y), -1)
        times, start = np.unique(scan["t"], return_index=True)
        for a, rows in zip(times, np.split(np.arange(len(y)), start[1:]), strict=True):
            yield Measurement(a, ids[rows], y[rows])

    def _steps(self, t, first):
        odo = {m: a[first] for m, a in self.parts["odometry"].items()}
        if self.way == "dx":
            steps = np.column_stack([odo["dx"], odo.get("dy", 0 * t), odo["dtheta"]])
        else:
            poses = np.column_stack([odo["x"], odo["y"], odo["theta"]])
            before = Frame2(poses[:-1])
            way = before.to_frame(poses[1:, :2])[0] if len(t) > 1 else np.zeros((0, 2))
            steps = np.vstack([np.zeros(3), np.column_stack([way, wrap(np.diff(poses[:, 2]))])])
        dt = np.diff(t, prepend=self.t0)
        far, turn = np.linalg.norm(steps[:, :2], axis=1), np.abs(steps[:, 2])
        q = STEP_NOISE
        var = np.column_stack([q.along**2 * far, q.across**2 * far, q.turn**2 * turn + q.drift**2 * dt]) + 1e-10
        yield from (Control(a, u, U=np.diag(v)) for a, u, v in zip(t, steps, var, strict=True))

    @property
    def t0(self):
        """When the robot starts: one step of the odometry before the first of its messages, s."""
        t = np.unique(self.parts["odometry"]["t"])
        step = float(np.median(np.diff(t))) if len(t) > 1 else 0.1
        return min(float(t[0]), float(self.parts["scan"]["t"][0])) - step

    def recording(self, data):
        """The recording, with what is known of the truth."""
        t0 = self.t0
        recording = recording_of(self.messages(), data, data.name, t0)
        if "truth" in self.parts:
            truth = self.parts["truth"]
            if "theta" in truth:
                recording.truth = {1: at_times(recording.t + t0, truth)}
            else:
                self.parts.setdefault("gps", truth)
        if "gps" in self.parts:
            gps = self.parts["gps"]
            recording.fixes = {1: np.column_stack([gps["t"] - t0, gps["x"], gps["y"]])}
        if "map" in self.parts:
            survey = self.parts["map"]
            ids, first = np.unique(survey["id"].astype(int), return_index=True)
            recording.landmarks = SimLmk(ids, np.column_stack([survey["x"], survey["y"]])[first])
        return Recording(**vars(recording))

    def after(self, recording):
        """Lines on the recording."""
        known = int(np.isfinite(recording.truth[1]).all(1).sum()) if recording.truth else 0
        words = f"{len(recording):,} frames, {len(recording.raw[1].ids):,} measurements"
        words += f"; the true pose is known in {known:,}" if recording.truth else "; no true poses"
        if recording.fixes:
            words += f", {len(recording.fixes[1]):,} fixes; they have a frame of their own, so look at"
            words += " gps_rmse_best95_aligned_m in result.json"
        return [words + (f", {len(recording.landmarks.ids)} true landmarks" if recording.landmarks else "")]


def scatter(a):
    """Standard deviation of white noise on a smooth signal: by its second differences, whose variance is six times."""
    if len(a) < 5:
        return float("nan")
    second = np.diff(a, 2)
    return float(1.4826 * np.median(np.abs(second - np.median(second))) / np.sqrt(6))


def at_times(t, truth):
    """True poses at some times, (n, 3): straight between two, NaN in gaps and outside."""
    times, first = np.unique(truth["t"], return_index=True)
    x, y, theta = truth["x"][first], truth["y"][first], np.unwrap(truth["theta"][first])
    poses = np.column_stack([np.interp(t, times, a) for a in (x, y, theta)])
    poses[:, 2] = wrap(poses[:, 2])
    if len(times) > 1:
        longest = 3 * float(np.median(np.diff(times)))
        k = np.clip(np.searchsorted(times, t), 1, len(times) - 1)
        within = (t - times[k - 1] <= longest) & (times[k] - t <= longest)
        poses[(times[k] - times[k - 1] > longest) & ~(within & np.isin(t, times))] = np.nan
    poses[(t < times[0]) | (t > times[-1])] = np.nan
    return poses
