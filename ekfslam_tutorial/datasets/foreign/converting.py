"""Tables of a log become messages, messages a recording, and a scenario is written that plays it."""

from dataclasses import dataclass, replace

import numpy as np

from ...geometry import q2e, wrap
from ...simulation import SimLmk
from ...toolbox import UserData
from ...toolbox.messages import recording_of
from ...toolbox.recordings import Recording
from .driving import InPlane, InSpace, poses
from .log import Log
from .meaning import LINE, OUT_OF_THE_PLANE, PLANE, SPACE, checked, columns_of, find, guess
from .scans import Scan, scatter
from .tables import read_tables

WANTED = {
    "odometry": ("v and w, or dx and dtheta, or x, y and theta", "twists, steps, poses or an IMU"),
    "scan": ("range, or x and y", "x, y and z, or px and py"),
}
"""What a role needs, in words: in the plane, and in space besides."""

TURN = 2 * np.pi
AGREE = 1.25
"""An odometry goes and turns as far as the truth, up to this factor: slip and noise are less."""
FEW = 10
"""Seconds that are needed to compare the two."""
LEAST_WAY = 0.05
"""A robot moves if it goes so far in a second, m."""
LEAST_TURN = 0.02
"""A robot turns if its turns of a second are so large, rad."""
TOGETHER = 0.8
"""Turns of odometry and truth are of one motion if the cosine between all of them is larger."""
START = "position_std", "orientation_std_deg"
LEAST_START = 1e-3, 1e-3
"""A truth that scatters by less than so many m and rad counts as exact."""
FAR = 1e4
"""Positions from a receiver that are larger count from somewhere else, m."""


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
    """Make a recording and a scenario of a log of any form, in the plane or in space.

    Parameters
    ----------
    path : path
        A file, a folder of files, or a bag.
    plan : dict, optional
        What the columns mean, `{"odometry": {"from": "odo.csv", "t": "time", "v": "speed", "w": "yaw_rate"}, ...}`:
        see docs/your_log.md. What is not said is guessed by the names; `"space": True` or False says where it is.
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
    left_out = {
        role: {m: c for m, c in e.items() if c is False} for role, e in (plan or {}).items() if isinstance(e, dict)
    }
    unwanted = [role for role, entry in (plan or {}).items() if entry is False]
    plan, space = completed(plan or {}, tables)
    log = Log(*in_order(plan, {table.name: table for table in tables}), space)
    said += not_used(plan, tables, unwanted)
    drive, scan = (InSpace if space else InPlane)(log), Scan(log)
    scenario = scenario_of(log, drive, scan, name or "log")
    recording = recording_from(log, drive, scan, UserData.from_dict(scenario))
    used = {entry["from"] for entry in plan.values()}
    recording.notes += [note for table in tables if table.name in used for note in table.notes]
    plan = {role: entry | left_out.get(role, {}) for role, entry in plan.items()}
    scenario |= {"convert": plan | ({"space": True} if space else {})}
    return Converted(recording, scenario, said + log.said + after(recording) + doubts(log, recording))


def seen(table):
    """Lines on a table: its columns, and what was noted when it was read."""
    kind = f" ({table.kind})" if table.kind else ""
    yield f"{table.name}{kind}: {len(table):,} row{'s' * (len(table) != 1)} of {', '.join(table.columns) or 'nothing'}"
    for note in table.notes:
        yield f"  {note}"


def not_used(plan, tables, unwanted):
    """A line on the tables that no role needs, where a truth or a map is missing that they may be."""
    used = {entry["from"].partition("/")[0] for entry in plan.values()}
    rest = [table.name for table in tables if table.name.partition("/")[0] not in used]
    missing = [role for role in ("truth", "map") if role not in plan and role not in unwanted]
    if rest and missing:
        ask = " or ".join(f"--set {role}.from=TABLE" for role in missing)
        yield f"not used: {', '.join(rest)}; is it the {' or the '.join(missing)}, to compare with? {ask}"


def completed(plan, tables):
    """The plan with what names tell of the rest, and whether the log is one in space."""
    plan = dict(plan)
    space = plan.pop("space", None)
    if space not in (None, True, False):
        raise ValueError(f"[convert] space must be true or false, got {space!r}")
    if space is None and any(OUT_OF_THE_PLANE & set(e) for e in plan.values() if isinstance(e, dict)):
        space = True
    guessed = guess(tables, space)
    if space is None:
        space = any(OUT_OF_THE_PLANE & set(entry) for role, entry in guessed.items() if role in ("odometry", "scan"))
    place = lambda role, entry: {"from": guessed[role]["from"]} | entry if role in guessed else entry
    told = checked({role: place(role, e) if isinstance(e, dict) else e for role, e in plan.items()}, tables)
    ways = SPACE if space else PLANE
    for role, entry in told.items():  # what is not said, by the names
        table = next(table for table in tables if table.name == entry["from"])
        named = guessed[role] if guessed.get(role, {}).get("from") == table.name else columns_of(table, role, space)
        whole = any(way <= set(entry) for way in ways.get(role, ()))
        told[role] = {m: c for m, c in named.items() if not whole or m in ("t", "id")} | entry
    told |= {role: entry for role, entry in guessed.items() if role not in plan}
    told = {role: {m: c for m, c in e.items() if c != str(False)} for role, e in told.items()}
    timed = lambda role, entry: entry if role in ("map", "camera") else _with_time(role, entry, tables)
    told = {role: timed(role, entry) for role, entry in told.items()}
    for role in {"truth", "gps", "map"} & set(told):
        if not any(place <= set(told[role]) for place in ({"x", "y"}, {"lat", "lon"})):
            columns = next(", ".join(table.columns) for table in tables if table.name == told[role]["from"])
            raise ValueError(
                f"{role}: x and y are needed: --set {role}.x=COLUMN --set {role}.y=COLUMN, of {columns}; "
                f"--set {role}=false leaves it out"
            )
    there = "; ".join(f"{table.name}: {', '.join(table.columns)}" for table in tables)
    for role, (what, more) in WANTED.items():
        if role not in told and not (role == "odometry" and space and plan.get(role) is False):
            raise ValueError(
                f"which columns are the {role} ({what}{f'; {more}' * space})? Say so with --set {role}.from=TABLE and "
                f"--set {role}.NAME=COLUMN"
                f"{' (or odometry=false: a hand-held camera)' * (space and role == 'odometry')}. The log has {there}"
            )
    return told, space


def _with_time(role, entry, tables):
    """An entry with its column of times, found by its name if need be."""
    if "t" in entry:
        return entry
    table = next(table for table in tables if table.name == entry["from"])
    column = find(table, "t")
    if column is None:
        there = ", ".join(table.columns)
        raise ValueError(f"{role}: which column of {table.name} is the time? --set {role}.t=COLUMN, one of {there}")
    return entry | {"t": column}


def in_order(plan, tables):
    """The plan and the tables, with times where the order of lines stands for them.

    A line of the odometry is a step of one second, if it has no time. What follows it has its time.

    Raises
    ------
    ValueError
        The odometry is in another file, or there is none.
    """
    odo = plan.get("odometry", {})
    steps = tables[odo["from"]].columns if odo else {}
    if odo.get("t") == LINE:
        first, times = 0.0, np.arange(1.0, len(steps[LINE]) + 1)
    elif odo:
        first, times = steps[odo["t"]][0], steps[odo["t"]]
    plan, timed = dict(plan), dict(tables)
    for role, entry in plan.items():
        if entry.get("t") != LINE:
            continue
        table, file = tables[entry["from"]], entry["from"].partition("/")[0]
        if LINE not in steps or odo["from"].partition("/")[0] != file:
            raise ValueError(f"{role}: the lines of {file} have no times, and no odometry among them that could tell")
        t = np.append(first, times)[np.searchsorted(steps[LINE], table.columns[LINE], side="right")]
        timed[table.name] = replace(table, columns=table.columns | {LINE: t})
        plan[role] = entry | {key: odo[key] for key in ("t_unit", "t_offset") if key in odo}
    return plan, timed


def start_noise(log):
    """How well it is known where the robot starts: as well as the truth scatters, for it begins there.

    A filter that were certain of a start that is off by a fifth of a degree would look too sure ever after.
    """
    truth = log.parts.get("truth", {})
    if not {"theta", "qw"} & set(truth):
        return {}
    if log.space:
        known = poses(truth)
        known = np.column_stack([known[:, :3], np.unwrap(q2e(known[:, 3:])[0], axis=0)])
    else:
        known = np.column_stack([truth["x"], truth["y"], np.unwrap(truth["theta"])])
    stds = np.nan_to_num([scatter(column, truth["t"]) for column in known.T])
    d = 3 if log.space else 2
    if (stds[:d] < LEAST_START[0]).all() and (stds[d:] < LEAST_START[1]).all():
        return {}
    angles = np.rad2deg(stds[d:]).round(3).tolist()
    started = dict(zip(START, (stds[:d].round(4).tolist(), angles if log.space else angles[0]), strict=True))
    words = ", ".join(f"{key} = {value}" for key, value in started.items())
    log.said.append(f"the truth scatters, and so the start is known: {words}")
    return started


def scenario_of(log, drive, scan, name):
    """Tables of a scenario, with noise by the scatter of the log."""
    robot, sensor, landmark, options = drive.robot() | start_noise(log), scan.sensor(), scan.landmark(), scan.options()
    table = {"name": name, "robot": [robot], "sensor": [sensor], "landmark": landmark, "options": options}
    noise = [
        f"{k} = {v}"
        for k, v in (robot | sensor).items()
        if ("_std" in k and k not in START) or k in ("std", "gyro_noise", "acc_noise")
    ]
    noise += [f"association = {options['association']}"]
    log.said.append(f"taken from the log: {robot['motion']}, {scan.kind}; {', '.join(noise)}")
    return table


def recording_from(log, drive, scan, data):
    """The recording, with what is known of the truth."""
    t0, messages = log.t0, list(scan.messages())
    if log.space and drive.by_imu:
        recording = _with_imu(drive, messages, data)
        t0 = messages[0].t
    else:
        recording = recording_of([*drive.controls(), *messages], data, data.name, t0)
    if "truth" in log.parts:
        truth = log.parts["truth"]
        if {"theta", "qw"} & set(truth):
            known = poses(truth) if log.space else np.column_stack([truth[m] for m in ("x", "y", "theta")])
            recording.truth = {1: at_times(recording.t + t0, truth["t"], known)}
        else:
            log.parts.setdefault("gps", truth)
    axes = [m for m in "xyz" if m in scan_axes(log)]
    if "gps" in log.parts:
        gps = log.parts["gps"]
        p = np.column_stack([gps[m] for m in axes if m in gps])
        if np.abs(p[0]).max() > FAR:
            log.said.append(f"gps: positions are of the size {np.abs(p[0]).max():.2g} m: counted from the first one")
            p = p - p[0]
        recording.fixes = {1: np.column_stack([gps["t"] - t0, p])}
    if "map" in log.parts:
        survey = log.parts["map"]
        ids = survey["id"] if "id" in survey else np.arange(1, len(survey["x"]) + 1)  # the order of the lines
        ids, first = np.unique(ids.astype(int), return_index=True)
        if scan.known and not np.isin(log.parts["scan"]["id"], ids).any():
            log.said.append(
                "note: no id of the map is one of the scan's: its landmarks are not compared; do both count alike?"
            )
        if log.space and "z" not in survey:
            raise ValueError("map: in space its landmarks need z; --set map=false leaves it out")
        recording.landmarks = SimLmk(ids, np.column_stack([survey[m] for m in axes])[first])
    return Recording(**vars(recording))


def scan_axes(log):
    """The axes of a position."""
    return "xyz" if log.space else "xy"


def _with_imu(drive, messages, data):
    """A recording whose frames are those of the scan: an IMU has many controls between two of them."""
    odo = drive.log.parts["odometry"]["t"]
    messages[:] = [m for m in messages if odo[0] <= m.t <= odo[-1]]
    if not messages:
        raise ValueError("nothing was seen while the IMU measured")
    seen = recording_of(messages, data, data.name, messages[0].t)
    log, begun = drive.imu(seen.t + messages[0].t)
    return replace(seen, robots={1: log}, starts={1: begun})


def after(recording):
    """Lines on the recording."""
    known = int(np.isfinite(recording.truth[1]).all(1).sum()) if recording.truth else 0
    words = f"{len(recording):,} frames, {len(recording.raw[1].ids):,} measurements"
    words += f"; the true pose is known in {known:,}" if recording.truth else "; no true poses"
    if recording.fixes:
        words += f", {len(recording.fixes[1]):,} fixes; they have a frame of their own, so look at"
        words += " gps_rmse_best95_aligned_m in result.json"
    return [words + (f", {len(recording.landmarks.ids)} true landmarks" if recording.landmarks else "")]


def doubts(log, recording):
    """Lines on an odometry in the plane that does not go the way of the truth: units, wheels, a sign."""
    if log.space or not recording.truth or len(recording.robots[1].u) != len(recording) or len(recording) < FEW:
        return []
    told_way, told_turn, way, turn = by_seconds(recording)
    found = []
    if len(way) < FEW or max(way.mean(), told_way.mean()) < LEAST_WAY:
        return found
    ratio = told_way.sum() / max(way.sum(), 1e-9)
    if not 1 / AGREE < ratio < AGREE:
        found.append(
            f"note: the odometry goes {ratio:.2g} times as far as the truth: are the units of speeds, positions and "
            "times right, and the radius of the wheels?"
        )
    size, told_size = np.linalg.norm(turn), np.linalg.norm(told_turn)
    if size < LEAST_TURN * np.sqrt(len(turn)) or abs(told_turn @ turn) < TOGETHER * size * told_size:
        return found
    slope = (told_turn @ turn) / size**2
    if not 1 / AGREE < slope < AGREE:
        why = "are the units of angles, and the base of the wheels, right?"
        if slope < 0:
            why = (
                "is it counted to the right (--set odometry.clockwise=true), are left and right wheels swapped, "
                "or does y of the truth go to the right?"
            )
        found.append(f"note: the odometry turns {slope:.2g} times as far as the truth: {why}")
    return found


def by_seconds(recording):
    """Ways, m, and turns, rad, of each second: of the odometry and of the truth, four arrays as long as each other."""
    t, u = recording.t, recording.robots[1].u
    speeds = u.shape[1] == 2  # else steps
    dt = np.diff(t, prepend=t[0])[:, None]
    steps = u * dt if speeds else np.column_stack([np.hypot(u[:, 0], u[:, 1]), u[:, 2]])
    ends = np.unique(np.searchsorted(t, np.arange(t[0], t[-1], 1.0)))
    told, true = np.diff(np.cumsum(steps, axis=0)[ends], axis=0), np.diff(recording.truth[1][ends], axis=0)
    known = np.isfinite(true).all(1)
    way, turn = np.linalg.norm(true[known, :2], axis=1), wrap(true[known, 2])
    return np.abs(told[known, 0]), told[known, 1], way, turn


def at_times(t, times, known):
    """True poses at some times: on an arc between two in the plane, straight in space; NaN in gaps and outside.

    In the plane the robot turns evenly between two rows, and its way is that of the chord, seen as a number: of a turn
    by a, the share s of it is (exp(i s a) - 1) / (exp(i a) - 1) of the chord. A path that were straight would be off by
    a centimetre where one row a second tells of a robot that turns.

    Parameters
    ----------
    t : ndarray, shape (F,)
    times : ndarray, shape (n,)
    known : ndarray, shape (n, 3) or (n, 7)
        Poses in the plane, or in space.

    Returns
    -------
    ndarray, shape (F, 3) or (F, 7)
    """
    times, first = np.unique(times, return_index=True)
    known = known[first].copy()
    if known.shape[1] == 3:
        known[:, 2] = np.unwrap(known[:, 2])
    else:  # q and -q are the same: the nearer one
        turned = np.sum(known[1:, 3:] * known[:-1, 3:], axis=1) < 0
        known[1:, 3:] *= np.where(np.cumsum(turned) % 2, -1, 1)[:, None]
    at = np.column_stack([np.interp(t, times, column) for column in known.T])
    if known.shape[1] == 3:
        if len(times) > 1:
            k = np.clip(np.searchsorted(times, t), 1, len(times) - 1)
            s = np.clip((t - times[k - 1]) / (times[k] - times[k - 1]), 0, 1)
            turn, z = known[k, 2] - known[k - 1, 2], known[:, 0] + 1j * known[:, 1]
            share = s * np.sinc(s * turn / TURN) / np.sinc(turn / TURN) * np.exp(0.5j * (s - 1) * turn)
            z = z[k - 1] + share * (z[k] - z[k - 1])
            at[:, :2] = np.column_stack([z.real, z.imag])
        at[:, 2] = wrap(at[:, 2])
    else:
        at[:, 3:] /= np.linalg.norm(at[:, 3:], axis=1, keepdims=True)
    if len(times) > 1:
        longest = 3 * float(np.median(np.diff(times)))
        k = np.clip(np.searchsorted(times, t), 1, len(times) - 1)
        within = (t - times[k - 1] <= longest) & (times[k] - t <= longest)
        at[(times[k] - times[k - 1] > longest) & ~(within & np.isin(t, times))] = np.nan
    at[(t < times[0]) | (t > times[-1])] = np.nan
    return at
