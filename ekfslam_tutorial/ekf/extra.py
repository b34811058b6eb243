"""The optional extra `compiled`: whether it is there, and the code that needs it."""

from functools import cache
from importlib import import_module
from importlib.util import find_spec


def check_compiled(error):
    """Refuse to compile where numba is not installed."""
    if find_spec("numba") is None:
        raise error("a compiled map needs numba: pip install 'ekfslam_tutorial[compiled]'")


@cache
def compiled():
    """The package of compiled code: imported when a map asks for it, because numba takes its time."""
    return import_module("..compiled", __package__)
