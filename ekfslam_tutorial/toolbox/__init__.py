"""Solà's high level: what the user writes, the main loop, and logs of runs.

Lives here: `universal_slam` and its engines; `OnlineSlam`, the same loop for a stream of messages; in `scenario/` user
data in Python and TOML; in `recordings/` logs in and out; in `files/` how files are read and written.
May not: models, filters, figures; those are above and below.
"""

from .descriptors import Descriptors
from .messages import Control, Measurement, Timeline, integrate, recording_of
from .online import OnlineSlam, as_stream
from .recordings import ControlLog, RawLog, Recorder, Recording
from .scenario import (
    Data,
    FigureOptions,
    Landmark,
    Options,
    Robot,
    Sensor,
    Surveyed,
    Time,
    UserData,
    World,
    parse_override,
)
from .structures import create_sim_structures, create_slam_structures
from .universal_slam import Run, Snapshot, universal_slam

__all__ = [
    "Control",
    "ControlLog",
    "Data",
    "Descriptors",
    "FigureOptions",
    "Landmark",
    "Measurement",
    "OnlineSlam",
    "Options",
    "RawLog",
    "Recorder",
    "Recording",
    "Robot",
    "Run",
    "Sensor",
    "Snapshot",
    "Surveyed",
    "Time",
    "Timeline",
    "UserData",
    "World",
    "as_stream",
    "create_sim_structures",
    "create_slam_structures",
    "integrate",
    "parse_override",
    "recording_of",
    "universal_slam",
]
