"""Solà's high level: what the user writes, the main loop, and logs of runs.

Lives here: `universal_slam` and its engines; in `scenario/` user data in Python and TOML; in `recordings/` logs in and
out; in `files/` how files are read and written.
May not: models, filters, figures; those are above and below.
"""

from .recordings import ControlLog, RawLog, Recorder, Recording
from .scenario import (
    Data,
    FigureOptions,
    Landmark,
    Options,
    Robot,
    Sensor,
    Time,
    UserData,
    World,
    parse_override,
)
from .structures import create_sim_structures, create_slam_structures
from .universal_slam import Run, Snapshot, universal_slam

__all__ = [
    "ControlLog",
    "Data",
    "FigureOptions",
    "Landmark",
    "Options",
    "RawLog",
    "Recorder",
    "Recording",
    "Robot",
    "Run",
    "Sensor",
    "Snapshot",
    "Time",
    "UserData",
    "World",
    "create_sim_structures",
    "create_slam_structures",
    "parse_override",
    "universal_slam",
]
