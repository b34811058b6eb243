"""Models of motion, sensors and landmarks, and the observation chain that joins them.

Lives here: one file per model, each a frozen dataclass of its parameters, and `observation.py`, the chain rule.
May not: know of maps, filters, robots or ids.
"""

from . import landmarks, motion, sensors
from .behind import frame_with
from .calibrated import Calibrated, state_class
from .contracts import check_landmark, check_motion, check_pair, check_sensor
from .moving import Moving
from .observation import (
    check_fit,
    expect,
    observe,
    observe_parameters,
    retro_project,
    retro_project_parameters,
    to_sensor,
)
from .turning import turning

__all__ = [
    "Calibrated",
    "Moving",
    "check_fit",
    "check_landmark",
    "check_motion",
    "check_pair",
    "check_sensor",
    "expect",
    "frame_with",
    "landmarks",
    "motion",
    "observe",
    "observe_parameters",
    "retro_project",
    "retro_project_parameters",
    "sensors",
    "state_class",
    "to_sensor",
    "turning",
]
