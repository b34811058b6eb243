"""How the states of a motion model beside its frame turn with the world: velocities, biases and what else there is."""

from itertools import product

import numpy as np

from ..geometry import ORIGIN, hat
from .trials import random_frame


def turning(motion, x):
    """Derivative of the states beside the frame by a small turn of the world about its axes, per radian.

    A model may say it, with a method `turning(x)`. For one that does not, it is found out: a state of as many numbers
    as the world has dimensions is a vector of the world, or one of the robot, as all others are; and a model moves on
    a turned state as it does on the state itself, but turned. What of both makes that true is right.

    Parameters
    ----------
    motion : MotionModel
    x : ndarray, shape (size,)

    Returns
    -------
    ndarray, shape (size - frame.size, 1), or (size - frame.size, 3) in space

    Raises
    ------
    TypeError
        If the model depends on where north is, and does not say how its states turn.

    See Also
    --------
    ConstantVelocity.turning : A velocity in the world above one in the robot.
    """
    if hasattr(motion, "turning"):
        return motion.turning(x)
    return _turned(motion, x, _found(motion))


def _turned(motion, x, of_the_world):
    """The derivative, if those fields are vectors of the world of which it is said."""
    d, start, rows = motion.frame.dim, motion.frame.size, []
    for n, world in zip(motion.state_fields.values(), of_the_world, strict=True):
        v, start = x[start : start + n], start + n
        rows.append(
            (np.array([[-v[1]], [v[0]]]) if d == 2 else -hat(v)) if world else np.zeros((n, 1 if d == 2 else 3))
        )
    return np.concatenate(rows)


def _found(motion):
    """Find the fields that are vectors of the world: X_x B(x) = B(x2), about the vertical: gravity has a direction."""
    rng, F = np.random.default_rng(1), motion.frame
    x = np.concatenate([random_frame(F, rng).x, rng.normal(size=motion.size - F.size)])
    x2, X_x, _ = motion.move(x, np.zeros(sum(motion.control_fields.values())), 0.1)
    for chosen in product(*[(False, True) if n == F.dim else (False,) for n in motion.state_fields.values()]):
        B, B2 = (_turn(motion, x, _turned(motion, x, chosen)) for x in (x, x2))
        if np.allclose(X_x @ B, B2, rtol=0, atol=1e-6):
            return chosen
    raise TypeError(
        f"{type(motion).__name__}: how {', '.join(motion.state_fields)} turn with the world is not clear from move: "
        "write a method turning, or take the option error = 'additive'"
    )


def _turn(motion, x, fields):
    """Derivative of the whole state by a turn about the vertical."""
    O, n = ORIGIN[motion.frame.dim], motion.frame.size
    return np.concatenate([O.compose(type(O)(x[:n]))[1] @ O.X_step[:, -1], fields[:, -1]])
