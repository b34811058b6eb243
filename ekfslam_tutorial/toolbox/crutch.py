"""What `fast` will be, until it is there: the steps of `slam` on the maps of `ekf`. It goes when `fast` comes."""

from ..ekf import CompressedMap, Map
from ..ekf.extra import check_compiled
from ..slam import correct_known_lmks, init_new_lmks, move

__all__ = ["check_compiled", "correct_known_lmks", "init_new_lmks", "move", "new_map"]


def new_map(capacity=None, *, compiled=False, compressed=False):
    """Make an empty map of one of the kinds of today."""
    return (CompressedMap if compressed else Map)(capacity, compiled=compiled)
