"""All that the wing takes from `ekf` and `slam`, public names only; and the symbols by which it traces models."""

from ..ekf import MapFull, check_covariance, real
from ..ekf.covariances import faults, real_blocks
from ..ekf.html import map_html, table_html
from ..geometry import ORIGIN
from ..models.calibrated import Calibrated
from ..slam.association import Jcbb, KnownIds, NearestNeighbour, gate
from ..slam.first_estimates import check_first_estimates, first_jacobians, note_first_estimates, transport
from ..slam.meetings import correct_met_robots, correct_without_lmks
from ..slam.objects import Event, Lmk, short
from ..slam.projection import by_type
from ..slam.steps import check_control, check_raw, correct_known_lmks, init_new_lmks, travel
from ..slam.upkeep import ALIKE, EUCLIDEAN, delete_bad, free_slot, well_inside
from .symbols import Symbol, Tape


def as_written(sensor):
    """Return True for a sensor that is left to the steps as they are written in `slam`.

    Those of lines, of velocities, and those with parameters that are states. They take as long as by the plain engine.
    """
    asked, answer = _left.get(id(sensor), (None, False))
    if asked is not sensor:
        answer = hasattr(sensor, "innovation") or hasattr(sensor, "asks_robot") or isinstance(sensor, Calibrated)
        if len(_left) >= 256:
            _left.clear()
        _left[id(sensor)] = sensor, answer
    return answer


_left = {}
"""By the id of a sensor model: the model, kept so that its id stays its own, and whether it is left to `slam`."""


__all__ = [
    "ALIKE",
    "EUCLIDEAN",
    "Event",
    "Jcbb",
    "KnownIds",
    "Lmk",
    "MapFull",
    "NearestNeighbour",
    "ORIGIN",
    "Symbol",
    "Tape",
    "as_written",
    "by_type",
    "check_control",
    "check_covariance",
    "check_first_estimates",
    "check_raw",
    "correct_known_lmks",
    "correct_met_robots",
    "correct_without_lmks",
    "delete_bad",
    "faults",
    "first_jacobians",
    "free_slot",
    "gate",
    "init_new_lmks",
    "map_html",
    "note_first_estimates",
    "real",
    "real_blocks",
    "short",
    "table_html",
    "transport",
    "travel",
    "well_inside",
]
