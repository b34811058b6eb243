"""Tables of a log become messages, messages a recording, and a scenario is written that plays it."""

from dataclasses import dataclass, field, replace

import numpy as np

from ...geometry import wrap
from ...simulation import SimLmk
from ...toolbox import UserData
from ...toolbox.messages import recording_of
from ...toolbox.recordings import Recording
from .driving import poses
from .fleet import WITH_ROBOT, stacked
from .meaning import LINE, OUT_OF_THE_PLANE, PLANE, SPACE, checked, columns_of, find, guess
from .members import START, members_of, place, scan_axes, start_noise, told_by
from .tables import read_tables

WANTED = {
    "odometry": (
        "v and w, v and theta, v and steer, left and right, dx and dtheta, or x, y and theta",
        "twists, steps, poses or an IMU",
    ),
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
    told : list of str
        Keys of the noise that the log itself tells, `sensor.2.heading_std_deg`: a fit leaves them as they are.
    """

    recording: Recording
    scenario: dict
    said: list
    told: list = field(default_factory=list)


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
    tables, plan, lists = stacked(read_tables(path), plan or {})
    said = [line for table in tables for line in seen(table)]
    left_out = {role: {m: c for m, c in e.items() if c is False} for role, e in plan.items() if isinstance(e, dict)}
    unwanted = [role for role, entry in plan.items() if entry is False]
    plan, space = completed(plan, tables)
    members = members_of(*in_order(plan, {table.name: table for table in tables}), space)
    said += not_used(plan, tables, unwanted)
    scenario = scenario_of(members, name or "log")
    recording = recording_from(members, UserData.from_dict(scenario))
    if len(members) > 1:
        place(members, scenario, recording)
    scan = next(table for table in tables if table.name == plan["scan"]["from"])
    recording.names = {int(n): word for word, n in scan.words.get(plan["scan"].get("id"), {}).items()}
    if not members[0].drive.by_imu:  # else it begins with the first scan
        recording.t0 = float(min(m.log.t0 for m in members))
    used = {entry["from"] for entry in plan.values()}
    noted = [note for table in tables if table.name in used for note in table.notes]
    recording.notes += dict.fromkeys(noted)  # a column of several tables has one
    recording.notes += [f"{m.name}: {note}" if m.name else note for m in members for note in m.log.notes]
    plan = {role: entry | left_out.get(role, {}) for role, entry in plan.items()}
    plan = {role: entry | {"from": lists.get(entry["from"], entry["from"])} for role, entry in plan.items()}
    scenario |= {"convert": plan | ({"space": True} if space else {})}
    for m in members:
        said += [f"robot {m.id}: {m.name}"] * bool(m.name) + m.log.said
    n = sum(len(recording.raw[m.id].ids) for m in members)
    said += after(recording, n) + [line for m in members for line in doubts(m, recording)]
    return Converted(recording, scenario, said, [key for m in members for key in told_by(m)])


def seen(table):
    """Lines on a table: its columns, and what was noted when it was read."""
    kind = f" ({table.kind})" if table.kind else ""
    yield f"{table.name}{kind}: {len(table):,} row{'s' * (len(table) != 1)} of {', '.join(table.columns) or 'nothing'}"
    for note in table.notes:
        yield f"  {note}"


def not_used(plan, tables, unwanted):
    """Lines on the tables that no role needs: may they be of another robot, or a truth or a map that is missing?"""
    by_name, names = {table.name: table for table in tables}, {entry["from"] for entry in plan.values()}
    for role in (role for role in WITH_ROBOT if role in plan):
        columns, name = [*by_name[plan[role]["from"]].columns], plan[role]["from"]
        alike = [table.name for table in tables if table.name not in names and [*table.columns] == columns]
        if alike:
            both = ", ".join(f'"{n}"' for n in (name, *alike))
            yield f"not used: {', '.join(alike)}, like {name}; of another robot? --set '{role}.from=[{both}]'"
    used = {name.partition("/")[0] for name in names}
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
        told[role] = {m: c for m, c in named.items() if not whole or m in ("t", "id", "robot")} | entry
    told |= {role: entry for role, entry in guessed.items() if role not in plan}
    told = {role: {m: c for m, c in e.items() if c != str(False)} for role, e in told.items()}
    told = _with_heading(told, tables)
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


def _with_heading(plan, tables):
    """The plan, with a heading of the odometry where a compass, or the axes of the world, ask for one."""
    odo = plan.get("odometry", {"theta": None})
    if "theta" in odo or not ({"compass", "world"} & set(plan.get("scan", {})) or "compass" in odo):
        return plan
    heading = find(next(table for table in tables if table.name == odo["from"]), "theta")
    return plan | ({"odometry": odo | {"theta": heading}} if heading else {})


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


def scenario_of(members, name):
    """Tables of a scenario, with noise by the scatter of the log."""
    robots, sensors, compasses = [], [], []
    unknown = next((m for m in members if not m.scan.known), members[0])
    landmark, options = unknown.scan.landmark(), unknown.scan.options()
    for m in members:
        robot = {"id": m.id} | ({"name": m.name} if m.name else {}) | m.drive.robot() | start_noise(m.log)
        sensor = {"id": m.id, "robot": m.id} | m.scan.sensor()
        robots.append(robot)
        sensors.append(sensor)
        if m.compass is not None:
            compasses.append({"id": m.compass, "robot": m.id} | m.drive.compass.sensor())
            if "theta" not in m.log.parts.get("truth", {}):  # y of the map is the north
                robot["orientation_deg"] = round(float(np.rad2deg(m.log.parts["odometry"]["theta"][0])), 2)
        noise = [
            f"{k} = {v}"
            for table in (robot, sensor, *(c for c in compasses if c["robot"] == m.id))
            for k, v in table.items()
            if ("_std" in k and k not in START) or k in ("std", "gyro_noise", "acc_noise")
        ]
        noise += [f"association = {options['association']}"]
        m.log.said.append(f"taken from the log: {robot['motion']}, {m.scan.kind}; {', '.join(noise)}")
    return {"name": name, "robot": robots, "sensor": sensors + compasses, "landmark": landmark, "options": options}


def recording_from(members, data):
    """The recording, with what is known of the truth."""
    t0, messages = min(m.log.t0 for m in members), [s for m in members for s in m.scan.messages(m.id)]
    if members[0].drive.by_imu:
        recording = _with_imu(members[0].drive, messages, data)
        t0 = messages[0].t
    else:
        for m in members:
            messages += m.controls(t0)
            messages += m.drive.compass.messages(m.compass) if m.compass is not None else []
        recording = recording_of(messages, data, data.name, t0)
    for m in members:
        if "truth" in m.log.parts:
            add_truth(m, recording, t0)
    add_fixes(members, recording, t0)
    if "map" in members[0].log.parts:
        recording.landmarks = surveyed(members[0])
    return Recording(**vars(recording))


def add_truth(m, recording, t0):
    """The true poses of a robot, at the times of the frames; without headings they are positions of a receiver."""
    truth = m.log.parts["truth"]
    if not {"theta", "qw"} & set(truth):
        m.log.parts.setdefault("gps", truth)
        return
    known = poses(truth) if m.log.space else np.column_stack([truth[a] for a in ("x", "y", "theta")])
    recording.truth[m.id] = at_times(recording.t + t0, truth["t"], known)


def add_fixes(members, recording, t0):
    """Positions of receivers; those far from zero count from the first one of all."""
    first = None
    for m in (m for m in members if "gps" in m.log.parts):
        gps = m.log.parts["gps"]
        p = np.column_stack([gps[a] for a in scan_axes(m.log) if a in gps])
        if np.abs(p[0]).max() > FAR or first is not None:
            first = p[0] if first is None else first
            size = f"{np.abs(p[0]).max():.2g}"
            m.log.said.append(f"gps: positions are of the size {size} m: counted from the first one")
            p = p - first
        recording.fixes[m.id] = np.column_stack([gps["t"] - t0, p])


def surveyed(m):
    """The true landmarks; words where they have not the ids of the scan."""
    log, survey = m.log, m.log.parts["map"]
    ids = survey["id"] if "id" in survey else np.arange(1, len(survey["x"]) + 1)  # the order of the lines
    ids, first = np.unique(ids.astype(int), return_index=True)
    if m.scan.known and not np.isin(log.parts["scan"]["id"], ids).any():
        log.said.append(
            "note: no id of the map is one of the scan's: its landmarks are not compared; do both count alike?"
        )
    if log.space and "z" not in survey:
        raise ValueError("map: in space its landmarks need z; --set map=false leaves it out")
    return SimLmk(ids, np.column_stack([survey[a] for a in scan_axes(log)])[first])


def _with_imu(drive, messages, data):
    """A recording whose frames are those of the scan: an IMU has many controls between two of them."""
    odo = drive.log.parts["odometry"]["t"]
    messages[:] = [m for m in messages if odo[0] <= m.t <= odo[-1]]
    if not messages:
        raise ValueError("nothing was seen while the IMU measured")
    seen = recording_of(messages, data, data.name, messages[0].t)
    log, begun = drive.imu(seen.t + messages[0].t)
    return replace(seen, robots={1: log}, starts={1: begun})


def after(recording, n):
    """Lines on the recording with n measurements of landmarks."""
    known = ", ".join(f"{np.isfinite(x).all(1).sum():,}" for x in recording.truth.values())
    words = f"{len(recording):,} frames, {n:,} measurements"
    words += f"; the true pose is known in {known}" if recording.truth else "; no true poses"
    if recording.fixes:
        words += f", {sum(map(len, recording.fixes.values())):,} fixes; they have a frame of their own, so look at"
        words += " gps_rmse_best95_aligned_m in result.json"
    return [words + (f", {len(recording.landmarks.ids)} true landmarks" if recording.landmarks else "")]


def doubts(m, recording):
    """Lines on an odometry in the plane that does not go the way of the truth: units, wheels, a sign."""
    u, truth = recording.robots[m.id].u, recording.truth.get(m.id)
    if m.log.space or truth is None or len(u) != len(recording) or len(recording) < FEW:
        return []
    told_way, told_turn, way, turn = by_seconds(recording.t, u, truth)
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
                "is it counted to the right (--set odometry.clockwise=true; a heading from the north: "
                "odometry.compass=true), are left and right wheels swapped, "
                "or does y of the truth go to the right?"
            )
        found.append(f"note: the odometry turns {slope:.2g} times as far as the truth: {why}")
    return found


def by_seconds(t, u, truth):
    """Ways, m, and turns, rad, of each second: of the odometry and of the truth, four arrays as long as each other."""
    speeds = u.shape[1] == 2  # else steps
    dt = np.diff(t, prepend=t[0])[:, None]
    steps = u * dt if speeds else np.column_stack([np.hypot(u[:, 0], u[:, 1]), u[:, 2]])
    ends = np.unique(np.searchsorted(t, np.arange(t[0], t[-1], 1.0)))
    told, true = np.diff(np.cumsum(steps, axis=0)[ends], axis=0), np.diff(truth[ends], axis=0)
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
