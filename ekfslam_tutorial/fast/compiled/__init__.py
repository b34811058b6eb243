"""The arithmetic of a step, compiled: for maps with `compiled`, if numba is installed.

A step in a small map is hundreds of calls for a handful of numbers each. Here it is five.

* The models are not written a second time. They are run once with symbols instead of numbers (`symbols`),
  and what they do is written down as straight code and compiled (`program.py`).
* The filter's equations stand here once more, as loops over P (`kernels.py`), and are held against `filter.py` by the
  tests.
* `filter.py` and `maps.py` have what the filter and the maps call, `step.py` the pieces of a step. What cannot be
  compiled, a model with a loop that ends by itself, or one that may change, is computed as ever: the pieces return None
  or False then.

Nothing imports this before a map asks for it.
"""

from .filter import carry, correct_some, predict, update
from .maps import (
    between,
    copy_lower,
    explained,
    follow,
    joined,
    mirror,
    overwrite,
    rows,
    settle,
    settled,
    spots,
    subtract,
)
from .step import born, correct_found, expected, expected_in_view, left_out, move, normalized

__all__ = [
    "between",
    "born",
    "carry",
    "copy_lower",
    "correct_found",
    "correct_some",
    "expected",
    "expected_in_view",
    "explained",
    "follow",
    "joined",
    "left_out",
    "mirror",
    "move",
    "normalized",
    "overwrite",
    "predict",
    "rows",
    "settle",
    "settled",
    "spots",
    "subtract",
    "update",
]
