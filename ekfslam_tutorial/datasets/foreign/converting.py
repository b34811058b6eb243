"""Tables of a log become messages, messages a recording, and a scenario is written that plays it."""

from dataclasses import dataclass, replace

import numpy as np

from ...geometry import wrap
from ...simulation import SimLmk
from ...toolbox import UserData
from ...toolbox.messages import recording_of
from ...toolbox.recordings import Recording
from .driving import InPlane, InSpace, poses
from .log import Log
from .meaning import LINE, NOISE, OUT_OF_THE_PLANE, PLANE, SPACE, checked, find, guess
from .scans import Scan
from .tables import read_tables

WANTED = {
    "odometry": ("v and w, or dx and dtheta, or x, y and theta", "twists, steps, poses or an IMU"),
    "scan": ("range, or x and y", "x, y and z, or px and py"),
}
"""What a role needs, in words: in the plane, and in space besides."""

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
    plan, space = completed(plan or {}, tables)
    log = Log(*in_order(plan, {table.name: table for table in tables}), space)
    drive, scan = (InSpace if space else InPlane)(log), Scan(log)
    scenario = scenario_of(log, drive, scan, name or "log")
    recording = recording_from(log, drive, scan, UserData.from_dict(scenario))
    used = {entry["from"] for entry in plan.values()}
    recording.notes += [note for table in tables if table.name in used for note in table.notes]
    plan = {role: entry | left_out.get(role, {}) for role, entry in plan.items()}
    scenario |= {"convert": plan | ({"space": True} if space else {})}
    return Converted(recording, scenario, said + log.said + after(recording))


def seen(table):
    """Lines on a table: its columns, and what was noted when it was read."""
    kind = f" ({table.kind})" if table.kind else ""
    yield f"{table.name}{kind}: {len(table):,} row{'s' * (len(table) != 1)} of {', '.join(table.columns) or 'nothing'}"
    for note in table.notes:
        yield f"  {note}"


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
    for role, entry in guessed.items():
        if role not in plan:
            told[role] = entry
        elif role in told and told[role]["from"] == entry["from"]:
            whole = any(way <= set(told[role]) for way in (SPACE if space else PLANE).get(role, ()))
            told[role] = {m: c for m, c in entry.items() if not whole or m in ("t", "id")} | told[role]
    told = {role: {m: c for m, c in e.items() if m not in NOISE or c != str(False)} for role, e in told.items()}
    told = {role: entry if role in ("map", "camera") else _with_time(entry, tables) for role, entry in told.items()}
    there = "; ".join(f"{table.name}: {', '.join(table.columns)}" for table in tables)
    for role, (what, more) in WANTED.items():
        if role not in told and not (role == "odometry" and space and plan.get(role) is False):
            raise ValueError(
                f"which columns are the {role} ({what}{f'; {more}' * space})? Say so with --set {role}.from=TABLE and "
                f"--set {role}.NAME=COLUMN"
                f"{' (or odometry=false: a hand-held camera)' * (space and role == 'odometry')}. The log has {there}"
            )
    return told, space


def _with_time(entry, tables):
    """An entry with its column of times, found by its name if need be."""
    if "t" in entry:
        return entry
    table = next(table for table in tables if table.name == entry["from"])
    column = find(table, "t")
    if column is None:
        raise ValueError(f"{table.name}: which column is the time? t = one of {', '.join(table.columns)}")
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


def scenario_of(log, drive, scan, name):
    """Tables of a scenario, with noise by the scatter of the log."""
    robot, sensor, landmark, options = drive.robot(), scan.sensor(), scan.landmark(), scan.options()
    table = {"name": name, "robot": [robot], "sensor": [sensor], "landmark": landmark, "options": options}
    noise = [
        f"{k} = {v}" for k, v in (robot | sensor).items() if "_std" in k or k in ("std", "gyro_noise", "acc_noise")
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
        ids, first = np.unique(survey["id"].astype(int), return_index=True)
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


def at_times(t, times, known):
    """True poses at some times: straight between two, NaN in gaps and outside.

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
