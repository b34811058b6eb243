"""The controls of a widget as plain values: what they allow, what tests try."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Float:
    """A slider of real numbers. `unit` is shown behind the label, `tip` when the pointer rests on it."""

    value: float
    low: float
    high: float
    step: float
    label: str = ""
    unit: str = ""
    tip: str = ""

    def __post_init__(self):
        _within(self)

    def corners(self) -> list:
        """Return the values that a test must try."""
        return [self.low, self.value, self.high]

    def draw(self, rng):
        """Return a random value that the control can take."""
        steps = round((self.high - self.low) / self.step)
        return min(self.low + self.step * int(rng.integers(steps + 1)), self.high)


@dataclass(frozen=True)
class Int(Float):
    """A slider of whole numbers; with `play`, a button moves it on, one step each `play` milliseconds."""

    step: int = 1
    play: int = 0

    def draw(self, rng):
        """Return a random value that the control can take."""
        return int(min(super().draw(rng), self.high))


@dataclass(frozen=True)
class Choice:
    """One of a few named options; `options` is a list, or a dictionary {text: value}."""

    value: Any
    options: Any
    label: str = ""
    tip: str = ""

    def __post_init__(self):
        if self.value not in self.corners():
            raise ValueError(f"the default {self.value!r} is none of the options {self.corners()}")

    def corners(self) -> list:
        """Return all values."""
        return list(self.options.values()) if isinstance(self.options, dict) else list(self.options)

    def draw(self, rng):
        """Return a random option."""
        options = self.corners()
        return options[int(rng.integers(len(options)))]


@dataclass(frozen=True)
class Toggle:
    """On or off."""

    value: bool
    label: str = ""
    tip: str = ""

    def corners(self) -> list:
        """Return both values."""
        return [False, True]

    def draw(self, rng):
        """Return either value."""
        return bool(rng.integers(2))


Control = Float | Int | Choice | Toggle


def _within(c):
    if not c.low <= c.value <= c.high or not c.step > 0:
        raise ValueError(f"{c.label or 'a slider'}: needs low <= value <= high and step > 0, got {c}")
