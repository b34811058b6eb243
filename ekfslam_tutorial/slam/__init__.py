"""Robots, sensors, landmarks and observations, and the steps of EKF-SLAM on them: Solà's interface level.

Lives here: the only code that sees objects and the map together, and the only one that changes them.
May not: simulate, read files or draw.
"""

from .association import Jcbb, KnownIds, Matches, NearestNeighbour
from .lockout import retry_lmks
from .meetings import correct_met_robots, correct_without_lmks, project_robots
from .objects import Event, Lmk, Obs, Rob, Sen, Tim
from .options import Options
from .projection import normalize, place, project_lmks
from .recovery import reopen_gate
from .steps import add_landmark, correct_known_lmks, init_new_lmks, move, new_map, travel
from .upkeep import let_go, tilt, wander

__all__ = [
    "Event",
    "Jcbb",
    "KnownIds",
    "Lmk",
    "Matches",
    "NearestNeighbour",
    "Obs",
    "Options",
    "Rob",
    "Sen",
    "Tim",
    "add_landmark",
    "correct_known_lmks",
    "correct_met_robots",
    "correct_without_lmks",
    "init_new_lmks",
    "let_go",
    "move",
    "new_map",
    "normalize",
    "place",
    "project_lmks",
    "project_robots",
    "reopen_gate",
    "retry_lmks",
    "tilt",
    "travel",
    "wander",
]
