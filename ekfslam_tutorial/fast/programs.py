"""Programs of models: each is written when it is needed for the first time, from what the model does with symbols."""

from dataclasses import fields
from functools import lru_cache

KEEP = 256  # programs

known = {}
"""By function that writes and ids of the models: the models, and the program, or None where there can be none."""


def program(write, a, b=None, c=None):
    """Return the program that `write` makes of these models; None where it cannot be."""
    at = write, id(a), id(b), id(c)
    found = known.get(at)
    if found is None:
        if len(known) >= KEEP:
            known.clear()
        key = tuple(model for model in (a, b, c) if model is not None)
        known[at] = found = key, _written(write, *key)  # the models are kept, so that their ids stay theirs
    return found[1]


def _written(write, *key):
    if not all(isinstance(model, type) or _cannot_change(model) for model in key):
        return None
    alike = tuple(_text(model) for model in key)
    try:
        hash((key, alike))
    except TypeError:  # parameters in lists
        return _tried.__wrapped__(write, alike, *key)
    return _tried(write, alike, *key)


def _text(model):
    """Return what two equal models may still differ in: the code of their methods, and fields that do not count."""
    kind = model if isinstance(model, type) else type(model)
    methods = [getattr(each, "__code__", None) for base in kind.__mro__ for each in vars(base).values()]
    hidden = () if model is kind else (getattr(model, f.name) for f in fields(model) if not f.compare)
    return tuple(code for code in methods if code is not None), *hidden


@lru_cache(KEEP)
def _tried(write, alike, *key):
    """Return the program, or None; models that are alike share it."""
    try:
        return write(*key)
    except Exception:  # a model that is not made for symbols may fail in any way; with numbers it says what is wrong
        return None


def _cannot_change(model):
    """Return True if a model is a frozen dataclass: its parameters become a part of the program."""
    parameters = getattr(type(model), "__dataclass_params__", None)
    return parameters is not None and parameters.frozen
