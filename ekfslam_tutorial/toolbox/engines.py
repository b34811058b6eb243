"""The two engines of the loop: the steps as they are written in `slam`, and the same steps made quick in `fast`.

Only this file knows that there are two. Both give the same estimate, to rounding; with `compressed` and the invariant
error, to an effect of the second order.
"""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

from .. import slam

ENGINES = "plain", "fast"
STEPS = "move", "correct_known_lmks", "init_new_lmks", "correct_met_robots", "correct_without_lmks"
OF_THE_FAST = "compressed", "compiled"
"""Options that only the fast engine has."""


class Engine(NamedTuple):
    """Map and steps of one engine.

    Parameters
    ----------
    name : str
        What runs, for the reader: "plain", "fast", "fast, compressed, compiled".
    new_map : callable
        capacity -> map.
    move, correct_known_lmks, init_new_lmks, correct_met_robots, correct_without_lmks : callable
        With the signatures that they have in `slam`.
    """

    name: str
    new_map: Callable
    move: Callable
    correct_known_lmks: Callable
    init_new_lmks: Callable
    correct_met_robots: Callable
    correct_without_lmks: Callable


def engine(options):
    """Choose the engine that the options name.

    Parameters
    ----------
    options : Options

    Returns
    -------
    Engine
    """
    if options.engine == "plain":
        return Engine("plain", slam.new_map, *(getattr(slam, step) for step in STEPS))
    from .. import fast  # here and below: it brings scipy.linalg along, a third of the time of all imports

    chosen = {name: getattr(options, name) for name in OF_THE_FAST}
    name = ", ".join(["fast", *(name for name, on in chosen.items() if on)])
    new_map = partial(fast.new_map, **chosen)
    return Engine(name, new_map, *(getattr(fast, step) for step in STEPS))


def check_engine(options):
    """Refuse an engine that does not exist, and options of the fast engine for the plain one.

    Parameters
    ----------
    options : Options

    Raises
    ------
    ValueError
    """
    if options.engine not in ENGINES:
        raise ValueError(f"engine must be {' or '.join(map(repr, ENGINES))}, got {options.engine!r}")
    chosen = [name for name in OF_THE_FAST if getattr(options, name)]
    if options.engine == "plain" and chosen:
        raise ValueError(
            f"{chosen[0]} is an option of the engine 'fast', got it with the engine 'plain': "
            f"take the engine 'fast', or {chosen[0]} = false"
        )
    if options.compiled:
        from .. import fast

        fast.check_compiled(ValueError)
