"""What the user writes: robots, sensors, world, time, landmarks, options, in Python or as a TOML file.

Read from below: `robots.py` and `sections.py` are the parts, `reading.py` makes them of tables, `userdata.py` is the
whole.
"""

from .overrides import parse_override
from .robots import Robot, Sensor
from .sections import Data, FigureOptions, Landmark, Options, Surveyed, Time, World
from .userdata import UserData

__all__ = [
    "Data",
    "FigureOptions",
    "Landmark",
    "Options",
    "Robot",
    "Sensor",
    "Surveyed",
    "Time",
    "UserData",
    "World",
    "parse_override",
]
