"""The robots of a log: what it holds of each, and where each of them starts."""

from contextlib import nullcontext
from dataclasses import dataclass
from itertools import count

import numpy as np

from ...geometry import q2e
from ...toolbox import UserData
from ...toolbox.messages import Control
from ...toolbox.rendezvous import MISFIT, find_starts
from ...toolbox.user_input import errors_at
from .driving import InPlane, InSpace, poses
from .fleet import by_robot, robots_of
from .log import Log
from .scans import Scan, scatter

START = "position_std", "orientation_std_deg"
LEAST_START = 1e-3, 1e-3
"""A truth that scatters by less than so many m and rad counts as exact."""
AT_ONCE = 1.0
"""A truth begins with its robot if it begins so soon, s."""
ROUGH = 3.0
"""A receiver whose scatter cannot be told is taken for so good, m."""


@dataclass
class Member:
    """A robot of a log: what it holds of it, how it drives, what it sees.

    Parameters
    ----------
    id : int
        Of the robot, and of the sensor that scans.
    name : str
        As the log has it; empty where there is one only.
    log : Log
    drive : InPlane or InSpace
    scan : Scan
    compass : int, optional
        Id of the sensor that tells its heading, if there is one.
    """

    id: int
    name: str
    log: Log
    drive: InPlane | InSpace
    scan: Scan
    compass: int | None = None

    @property
    def begin(self):
        """Time at which it starts, s: where its truth begins, if that is at once."""
        truth, t0 = self.log.parts.get("truth", {}), self.log.t0
        first = float(truth["t"][0]) if {"theta", "qw"} & set(truth) else t0
        return first if t0 < first < t0 + AT_ONCE else t0

    def controls(self, t0):
        """Controls, each until its time; one of several robots, with a name, stands still from t0 until it begins."""
        controls = self.drive.controls(self.id)
        if not controls or not self.name or self.begin <= t0:
            return controls
        nothing = 0 * controls[0].u
        still = Control(self.begin, nothing, self.id, 1e-10 * np.eye(len(nothing)))
        return [still, *(c for c in controls if c.t > self.begin)]


def members_of(plan, tables, space):
    """The robots of a log, in the order of their names."""
    found, tables = [], by_robot(plan, tables)
    for id, (name, numbers) in enumerate(robots_of(plan, tables).items(), 1):
        with errors_at(f"robot {name}") if name else nullcontext():
            log = Log(plan, tables, space, numbers, found[0].log.origin if found else None)
            found.append(Member(id, name, log, (InSpace if space else InPlane)(log), Scan(log)))
            if len(found) > 1 and (found[0].drive.by_imu or found[0].scan.kind != found[-1].scan.kind):
                raise ValueError("several robots need speeds or steps each, and scans of one kind")
    ids = count(len(found) + 1)
    for m in found:
        m.compass = next(ids) if m.drive.compass else None
    return found


def told_by(m):
    """Keys of the noise that the log of a robot tells; robots and sensors count from 1, in their order."""
    keys = [f"robot.{m.id}.{key}" for key in m.drive.told]
    return keys if m.compass is None else [*keys, f"sensor.{m.compass}.heading_std_deg"]


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


def place(members, scenario, recording):
    """Say where each of several robots starts: by its truth, by its receiver and its compass, or by what all have seen.

    If the scenario says it of one, it says it of all: starts of two frames, the one of the scenario and the one of a
    truth that a recording has, would make no map.

    Parameters
    ----------
    members : list of Member
    scenario : dict
        Its robots get their starts.
    recording : Recording
    """
    lost, t0 = [], min(m.log.t0 for m in members)
    for m, robot in zip(members, scenario["robot"], strict=True):
        truth, fixes = recording.truth.get(m.id), recording.fixes.get(m.id)
        known = np.zeros(0, bool) if truth is None else np.isfinite(truth).all(1)
        if known[:1].all() and len(known):
            continue  # a run starts there
        if known.any() and recording.t[known][0] + t0 <= m.begin + AT_ONCE:
            robot |= start_at(recording.truth[m.id][known][0])
        elif fixes is not None and m.compass is not None:
            std = [float(np.nan_to_num(scatter(a, fixes[:, 0]), nan=ROUGH)) for a in fixes[:, 1:].T]
            robot |= {"position": fixes[0, 1:].tolist(), "position_std": np.round(std, 3).tolist()}
            m.log.said.append("it starts where its receiver and its compass say")
        else:
            lost.append(m)
    if lost not in ([], members[:1]):
        by_landmarks(members, lost, scenario, recording)
    if any("position" in robot for robot in scenario["robot"]):
        for m, robot in zip(members, scenario["robot"], strict=True):
            nowhere = np.r_[0, 0, 0, 1, 0, 0, 0] if m.log.space else np.zeros(3)
            begun = recording.truth.get(m.id, nowhere[None])[0]
            robot |= start_at(begun if np.isfinite(begun).all() else nowhere) | robot


def start_at(x):
    """What a scenario says of a robot that starts with this pose, in the plane or in space."""
    position, angles = (x[:2], x[2]) if len(x) == 3 else (x[:3], q2e(x[3:])[0])
    return {"position": position.tolist(), "orientation_deg": np.rad2deg(angles).tolist()}


def by_landmarks(members, lost, scenario, recording):
    """Find starts by the landmarks that robots have in common; words on it, also if there are none."""
    try:
        blur = max(MISFIT, *(m.scan.blur(table) for m, table in zip(members, scenario["sensor"], strict=False)))
        data, note = find_starts(UserData.from_dict(scenario), recording, blur)
    except ValueError as error:
        lost[-1].log.said.append(f"note: {error}: --plan and the starts in scenario.toml, [[robot]], tell them")
        return
    for robot, found in zip(scenario["robot"], data.robots, strict=True):
        if found.position is not None:
            robot |= {key: getattr(found, key) for key in ("position", "orientation_deg", *START)}
            robot["position_std"] = round(max(robot["position_std"], blur), 3)
    members[0].log.said.append(note)
    recording.notes.append(note)


def scan_axes(log):
    """The axes of a position."""
    return "xyz" if log.space else "xy"
