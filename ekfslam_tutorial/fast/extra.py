"""The optional extra `compiled`: numba, and the code that needs it."""

from functools import cache
from importlib.util import find_spec
from typing import Any


def check_compiled(error):
    """Refuse to compile where numba is not installed."""
    if find_spec("numba") is None:
        raise error("a compiled map needs numba: pip install 'ekfslam_tutorial[compiled]'")


@cache
def compiled() -> Any:
    """Return the package of compiled code: imported when a map asks for it, because numba takes its time."""
    from . import compiled

    return compiled
