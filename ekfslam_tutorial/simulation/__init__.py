"""Worlds and simulated robots: the truth of a scenario.

Lives here: where landmarks are, how robots really move and what their sensors really measure.
May not: filter, know of estimates, draw.
"""

from . import worlds
from .looks import Looks
from .simulator import MOST_CLUTTER as MOST_CLUTTER
from .simulator import SimLmk, SimObs, SimRob, SimSen, sim_motion, sim_observation
from .streams import Streams, draw

__all__ = [
    "Looks",
    "SimLmk",
    "SimObs",
    "SimRob",
    "SimSen",
    "Streams",
    "draw",
    "sim_motion",
    "sim_observation",
    "worlds",
]
