"""What the task of a project may ask of a scenario.

Each function here makes a question, a function of the `UserData` that returns a sentence or None. The sentences
go on "the scenario is not the one of the task: ...".
"""

from __future__ import annotations

import numpy as np

from ..simulation import Streams
from ..toolbox import UserData
from ..toolbox.scenario.keys import snake
from ..toolbox.scenario.robots import std_key


def robots(*motions):
    """Ask for robots with these motion models, in any order."""
    return lambda data: _same("robot", "motion", motions, [snake(type(r.motion).__name__) for r in data.robots])


def sensors(*types):
    """Ask for sensors of these types, in any order."""
    return lambda data: _same("sensor", "type", types, [snake(type(s.model).__name__) for s in data.sensors])


def places(scenario):
    """Ask that robots start and drive as in this scenario, and that they carry the same sensors at the same places."""
    wanted = UserData.from_text(scenario)

    def ask(data):
        for robot, want in zip(data.robots, wanted.robots, strict=True):
            if not _same_place(robot.start()[0], want.start()[0], robot.frame):
                return f"robot {robot.id} starts at {_said(robot)}, in the task at {_said(want)}"
            if not np.array_equal(robot.controls(), want.controls()):
                return f"robot {robot.id} drives with {_said(robot, True)}, in the task with {_said(want, True)}"
        numbers, frame = {r.id: i for i, r in enumerate(data.robots)}, data.frame
        free = list(data.sensors)
        for want in wanted.sensors:
            of_robot = [s for s in free if numbers[s.robot] == [r.id for r in wanted.robots].index(want.robot)]
            same = [s for s in of_robot if type(s.model) is type(want.model)]
            there = [s for s in same if _same_place(s.start(frame)[0], want.start(frame)[0], frame)]
            what = f"{snake(type(want.model).__name__)} on robot {want.robot}"
            if not same:
                return f"the task has one more {what}"
            if not there:
                return f"the {what} is at {' and at '.join(map(_said, same))}, in the task at {_said(want)}"
            free.remove(there[0])
        return None

    return ask


def _same_place(x, y, frame):
    """Return True if two frames are the same to a millimetre and a milliradian."""
    a, b = frame(x[: frame.size]), frame(y[: frame.size])
    return bool(np.allclose(a.t, b.t, atol=1e-3) and np.allclose(a.R, b.R, atol=1e-3))


def _said(thing, control=False):
    """A robot's or a sensor's place, or a robot's control, as its keys say it."""
    of = {key: getattr(thing, key) for key in ("position", "orientation_deg")} if not control else thing.control
    said = [f"{key} = {np.round(np.atleast_1d(v), 3).tolist()}" for key, v in of.items() if v is not None]
    return ", ".join(said) or ("no steps" if control else "the origin")


def landmarks(*types):
    """Ask for one of these landmark types."""

    def ask(data):
        got = snake(type(data.landmark.model).__name__)
        return None if got in types else f"the landmarks are {got}, the task asks for {' or '.join(types)}"

    return ask


def frames(least, most):
    """Ask for a run of so many frames."""

    def ask(data):
        n = 100 if data.time.last is None else data.time.last - data.time.first + 1
        return None if least <= n <= most else f"the run has {n} frames, the task asks for {least} to {most}"

    return ask


def points(least):
    """Ask for a world with so many landmarks at least."""

    def ask(data):
        n = 0 if data.world is None else len(data.world.build(Streams(data.seed).world)[0])
        return None if n >= least else f"the world has {n} landmarks, the task asks for {least} or more"

    return ask


def noise(pixels=0.0, **controls):
    """Ask for odometry and pixels that are not too good: least standard deviations, as ``dx_std=0.01``."""

    def ask(data):
        for r in data.robots:
            std, sizes = np.sqrt(np.diag(r.U())), r.motion.control_fields
            parts = np.split(std, np.cumsum(list(sizes.values()))[:-1])
            for name, part in zip(sizes, parts, strict=True):
                got = np.degrees(part.min()) if name.endswith("_deg") else part.min()
                if got < controls.get(key := std_key(name), 0.0) * (1 - 1e-9):
                    return f"robot {r.id} has {key} = {got:.2g}, the task asks for {controls[key]:g} or more"
        for s in data.sensors:
            std = float(np.sqrt(s.model.R[0, 0]))
            if std < pixels:
                return f"sensor {s.id} has the noise {std:.2g} px (pixel_std), the task asks for {pixels:.2g} or more"
        return None

    return ask


def estimated(robots=True, mountings=0, angles=(0.0, 180.0)):
    """Ask that robots are estimated, and so many mountings, whose angles are known to so many degrees."""

    def ask(data):
        for r in data.robots:
            if r.in_map != robots:
                return f"robot {r.id} has in_map = {str(r.in_map).lower()}: its pose is to be estimated"
        n = sum(s.frame_in_map for s in data.sensors)
        if n < mountings:
            return f"{n} mountings are estimated (frame_in_map), the task asks for {mountings}"
        for s in (s for s in data.sensors if s.frame_in_map):
            std = np.atleast_1d(np.asarray(s.orientation_std_deg, float))
            if not angles[0] <= std.min() <= std.max() <= angles[1]:
                got = ", ".join(f"{v:.3g}" for v in np.unique(std))
                return (
                    f"the mounting of sensor {s.id} has orientation_std_deg = {got}, the task asks for "
                    f"{angles[0]:g} to {angles[1]:g}"
                )
        return None

    return ask


def _same(kind, key, wanted, got):
    if sorted(wanted) == sorted(got):
        return None
    return f"its {kind}s have the {key}s [{', '.join(got) or 'none'}], the task asks for [{', '.join(wanted)}]"
