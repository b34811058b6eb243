"""All that the wing takes from `ekf` and `slam`, public names only; and the symbols by which it traces models."""

from ..ekf import MapFull
from ..ekf.html import map_html, table_html
from ..geometry.symbols import Symbol, Tape
from ..slam.association import KnownIds
from ..slam.first_estimates import check_first_estimates, first_jacobians, transport
from ..slam.objects import Event, Lmk, short
from ..slam.upkeep import EUCLIDEAN, delete_bad

try:
    from ..ekf.covariances import check_covariance
    from ..slam.first_estimates import note_first_estimates
    from ..slam.inputs import check_control, check_raw
    from ..slam.upkeep import free_slot, well_inside
except ImportError:  # the core as it was: these names are on their way
    from types import SimpleNamespace

    from ..ekf.stochastic_map import check_covariance
    from ..slam.first_estimates import begin as note_first_estimates
    from ..slam.steps import _check_control as check_control
    from ..slam.steps import _check_raw as check_raw
    from ..slam.steps import _free_slot as free_slot
    from ..slam.steps import _well_inside

    def well_inside(sensor, y, margin):
        """As it will be in `slam.upkeep`."""
        return _well_inside(SimpleNamespace(compiled=False), sensor, y, margin)


__all__ = [
    "EUCLIDEAN",
    "Event",
    "KnownIds",
    "Lmk",
    "MapFull",
    "Symbol",
    "Tape",
    "check_control",
    "check_covariance",
    "check_first_estimates",
    "check_raw",
    "delete_bad",
    "first_jacobians",
    "free_slot",
    "map_html",
    "note_first_estimates",
    "short",
    "table_html",
    "transport",
    "well_inside",
]
