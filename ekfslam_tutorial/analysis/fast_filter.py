"""The quick filter, for those who measure what a filter costs: its maps and functions take stacks of observations."""

from ..fast import CompressedMap, FastMap, predict, update

__all__ = ["CompressedMap", "FastMap", "predict", "update"]
