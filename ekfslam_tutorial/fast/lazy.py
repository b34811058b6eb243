"""Values that are computed when they are asked for, and kept."""

from functools import cached_property
from typing import Any


class lazy(cached_property):
    """A `functools.cached_property` without its lock, which takes longer than a small matrix (before Python 3.12).

    Two threads that ask at once compute the same value twice; there is no harm in that.
    """

    def __get__(self, instance, owner=None) -> Any:
        if instance is None:
            return self
        value = instance.__dict__[self.attrname] = self.func(instance)
        return value
