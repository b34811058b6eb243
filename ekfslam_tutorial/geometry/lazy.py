"""Values that are computed when they are asked for, and kept."""

from functools import cached_property


class lazy(cached_property):
    """A `functools.cached_property` without its lock, which takes longer than a small matrix (before Python 3.12).

    Two threads that ask at once compute the same value twice; there is no harm in that.
    """

    def __get__(self, instance, owner=None):
        if instance is None:
            return self
        value = instance.__dict__[self.attrname] = self.func(instance)
        return value
