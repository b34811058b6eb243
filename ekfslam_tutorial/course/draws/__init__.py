"""The drawings of the widgets: one module ``nbNN.py`` per notebook, each drawing marked with `explorable`."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Callable


def everything() -> list[Callable]:
    """Return every drawing of every notebook, in the order of their modules."""
    found = []
    for info in pkgutil.iter_modules(__path__):
        if info.name.startswith("nb"):
            module = importlib.import_module(f"{__name__}.{info.name}")
            found += [v for v in vars(module).values() if hasattr(v, "controls") and v.__module__ == module.__name__]
    return found
