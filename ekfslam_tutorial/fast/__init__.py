"""The wing for speed: the steps of `slam` and the filter of `ekf`, quicker. One law: **fast is plain**.

Whatever is done with these steps and maps, events, messages and numbers (to rounding) are those of the plain ones; the
tests in `tests/fast` are that law. (One exception is chosen: a compressed map with the invariant error, `carrying.py`.)
So nothing here has to be read to understand what the package does.

The steps, with the signatures of `slam`: `move`, `correct_known_lmks`, `init_new_lmks`, `new_map`.

* `steps.py` has them, `births.py` the last of the three; `joint.py` and `one_by_one.py` are the two ways to correct.
* `tables.py` asks what a sensor should see of all landmarks at once and makes a table of it, `sightings.py`; one row
  of it, an `Obs`, is in `obs.py`. `gating.py` finds those landmarks that any measurement can belong to.
* `expectation.py` is the observation chain for stacks, `frames.py` normalises frames, `tidy.py` looks after landmarks.
* `refused.py` finds out quickly that input is good; if it is not, the core says what is wrong.
* `notes.py` is what is remembered from one step to the next: of frames, of landmarks in groups.

The filter and its maps, which have the public interface of `ekf.Map`; all functions of the core work on them.

* `filter.py` has the functions of `ekf`, which take stacks of observations, too.
* `fast_map.py` keeps one triangle of the covariance while that is enough (`triangle.py`), in storage that suits the
  processor (`storage.py`, `blas.py`).
* `compressed_map.py` is for many landmarks of which few are seen: states are *active* or *far* (`virtual.py`,
  `columns.py`).
* `batch.py` does many runs at once.
* `compiled/` is all that needs numba: models are traced with symbols and become machine code, and the filter stands
  there in loops. `extra.py` asks whether numba is there.

Names of the core are taken from `core.py`. Nothing in the core imports the wing.
"""

from .batch import Batch
from .births import init_new_lmks
from .compressed_map import CompressedMap
from .extra import check_compiled
from .fast_map import FastMap
from .filter import Innovation, augment, correct, covariance, cross, innovation, predict, transform, update
from .steps import correct_known_lmks, correct_met_robots, correct_without_lmks, move, new_map

__all__ = [
    "Batch",
    "CompressedMap",
    "FastMap",
    "Innovation",
    "augment",
    "check_compiled",
    "correct",
    "correct_known_lmks",
    "correct_met_robots",
    "correct_without_lmks",
    "covariance",
    "cross",
    "init_new_lmks",
    "innovation",
    "move",
    "new_map",
    "predict",
    "transform",
    "update",
]
