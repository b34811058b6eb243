"""Numerical Jacobians of models that take stacks: one call for all differences, not two for each number."""

import numpy as np


def at_once(f, x, step):
    """Return what `numerical_jacobian` does, by one call of a function that takes stacks."""
    x0 = numbers(x)
    h = step * np.maximum(1.0, np.abs(x0))
    beyond, before = np.split(f(like(x, x0 + np.concatenate([np.diag(h), -np.diag(h)]))), 2)
    return np.moveaxis(beyond - before, 0, -1) / (2 * h)


def numbers(arg):
    """Of a vector or a frame."""
    return np.asarray(getattr(arg, "x", arg), float)


def like(arg, x):
    """A vector or a frame, as `arg` is one."""
    return type(arg)(x) if hasattr(arg, "x") else x


def stacked(*args):
    """Arguments of which one may be a stack, as stacks of the same length."""
    shape = np.broadcast_shapes(*(numbers(arg).shape[:-1] for arg in args))
    return [like(arg, np.broadcast_to(numbers(arg), (*shape, numbers(arg).shape[-1]))) for arg in args]


def of_stacks(f):
    """`observe` or `retro_project`, of frames and vectors of which one may be a stack."""

    def g(Rf, Sf, sensor, lmk, *rest):
        Rf, Sf, *rest = stacked(Rf, Sf, *rest)
        return f(Rf, Sf, sensor, lmk, *rest)

    return g
