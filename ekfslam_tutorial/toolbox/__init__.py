"""Solà's high level: what the user writes, the main loop, and logs of runs.

Lives here: user data in Python and TOML, `universal_slam`, recordings.
May not: models, filters, figures; those are above and below.
"""

from .overrides import parse_override
from .recording import ControlLog, RawLog, Recorder, Recording
from .structures import create_sim_structures, create_slam_structures
from .universal_slam import Run, Snapshot, universal_slam
from .userdata import Data, FigureOptions, Landmark, Options, Robot, Sensor, Time, UserData, World

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
