"""The arithmetic of a step, compiled: for `Map(compiled=True)`, if numba is installed.

A step in a small map is hundreds of calls for a handful of numbers each. Here it is five.

* The models are not written a second time. They are run once with symbols instead of numbers (`geometry/symbols.py`),
  and what they do is written down as straight code and compiled (`program.py`).
* The filter's equations stand here once more, as loops over P (`kernels.py`), and are held against `ekf/filter.py` by
  the tests.
* `filter.py` and `maps.py` have what `ekf/` calls, `step.py` the pieces of a step that `slam/` calls. What cannot be
  compiled, a model with a loop that ends by itself, or one that may change, is computed as ever: the pieces return None
  or False then.

Nothing above `models` and `ekf` may be imported here, and nothing imports this before a map asks for it.
"""

from .filter import correct_some, predict, update
from .maps import between, cholesky, explained, follow, here, joined, mirror, overwrite, rows, settle, subtract
from .step import born, correct_found, expected, inside, left_out, move, near, normalized

__all__ = [
    "between",
    "born",
    "cholesky",
    "correct_found",
    "correct_some",
    "expected",
    "explained",
    "follow",
    "here",
    "inside",
    "joined",
    "left_out",
    "mirror",
    "move",
    "near",
    "normalized",
    "overwrite",
    "predict",
    "rows",
    "settle",
    "subtract",
    "update",
]
