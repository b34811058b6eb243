"""Programs executed as plain Python: what numba would compile, without the seconds that it takes.

The text is the same, the arguments are refused where numba would refuse them, and numbers behave as numba's: a division
by zero is infinite, a root of a negative number is NaN. So `step.py` and the programs are tested on every model.
"""

from types import SimpleNamespace

import numpy as np
from numba import typeof, types
from numba.core.registry import cpu_target
from numba.core.sigutils import normalize_signature

from ekfslam_tutorial.fast import programs
from ekfslam_tutorial.fast.compiled import kernels

NAMES = {name: name.replace("a", "arc", 1) for name in ("acos", "asin", "atan", "atan2")}
NAMES |= {name: name for name in ("cos", "sin", "tan", "sqrt", "exp", "log", "sinh", "cosh", "tanh", "hypot")}
MATH = SimpleNamespace(**{name: getattr(np, numpys) for name, numpys in NAMES.items()})
SPACE = {"math": MATH, "np": np, "isfinite": np.isfinite}
USED = "columns_of", "covariance_of", "covariances", "follow", "gated", "heading", "join", "near", "own"
SPACE |= {name: getattr(kernels, name) for name in (*USED, "propagate", "put", "sandwich")}


def look(given, wanted):
    """Refuse arguments that machine code would misread: it does not look itself. It writes into none that it is given.

    Parameters
    ----------
    given : sequence
    wanted : sequence of numba types
    """
    assert len(given) == len(wanted)
    for value, kind in zip(given, wanted, strict=True):
        layout = (value.dtype, value.ndim, value.flags.num) if isinstance(value, np.ndarray) else None
        if layout is None or (layout, kind) not in _right:  # numba takes as long as the step, and it has been asked
            found = typeof(value)
            if isinstance(found, types.Array):
                found = found.copy(readonly=False)
            if cpu_target.typing_context.can_convert(found, kind) is None:
                raise TypeError(f"No matching definition: {found} is not {kind}")
            _right.add((layout, kind))


_right = set()
"""Layouts of arrays that are right for a type of numba."""


def build(signature, arguments, lines):
    """In the place of `program.build`."""
    wanted, _ = normalize_signature(signature)
    space, text = dict(SPACE), "".join(f"    {line}\n" for line in lines)
    exec(f"def run({arguments}):\n{text}", space)

    @np.errstate(all="ignore")
    def quietly(*given):
        return space["run"](*given)

    run = looked_at(quietly, wanted)
    run.lines = lines
    return run


def looked_at(code, wanted):
    """Machine code that gets its arguments looked at."""

    def run(*given):
        look(given, wanted)
        return code(*given)

    return run


def forget():
    """Forget all programs."""
    programs.known.clear()
    programs._tried.cache_clear()
