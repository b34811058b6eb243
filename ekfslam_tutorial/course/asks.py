"""What the task of a project may ask of a scenario.

Each function here makes a question, a function of the `UserData` that returns a sentence or None. The sentences
go on "the scenario is not the one of the task: ...".
"""

from __future__ import annotations

import numpy as np

from ..simulation import Streams
from ..toolbox.scenario.keys import snake


def robots(*motions):
    """Ask for robots with these motion models, in any order."""
    return lambda data: _same("robot", "motion", motions, [snake(type(r.motion).__name__) for r in data.robots])


def sensors(*types):
    """Ask for sensors of these types, in any order."""
    return lambda data: _same("sensor", "type", types, [snake(type(s.model).__name__) for s in data.sensors])


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


def noise(controls=0.0, pixels=0.0):
    """Ask for odometry and pixels that are not too good: standard deviations of each control and each pixel."""

    def ask(data):
        for r in data.robots:
            std = float(np.sqrt(np.diag(r.U()).min()))
            if std < controls:
                return (
                    f"the odometry of robot {r.id} has the noise {std:.2g} m or rad (dx_std, da_std_deg), the task "
                    f"asks for {controls:.2g} or more"
                )
        for s in data.sensors:
            std = float(np.sqrt(s.model.R[0, 0]))
            if std < pixels:
                return f"sensor {s.id} has the noise {std:.2g} px (pixel_std), the task asks for {pixels:.2g} or more"
        return None

    return ask


def estimated(robots=True, mountings=0):
    """Ask that robots are estimated, and so many mountings."""

    def ask(data):
        for r in data.robots:
            if r.in_map != robots:
                return f"robot {r.id} has in_map = {str(r.in_map).lower()}: its pose is to be estimated"
        n = sum(s.frame_in_map for s in data.sensors)
        if n < mountings:
            return f"{n} mountings are estimated (frame_in_map), the task asks for {mountings}"
        return None

    return ask


def _same(kind, key, wanted, got):
    if sorted(wanted) == sorted(got):
        return None
    return f"its {kind}s have the {key}s [{', '.join(got) or 'none'}], the task asks for [{', '.join(wanted)}]"
