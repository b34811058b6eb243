"""From keys and values, as in TOML, to objects: names become classes, degrees radians, mistakes sentences.

Nothing here knows any model. A class is known by being exported; its keys are its parameters.
"""

import difflib
import inspect
import math
import re
import types
import typing

import numpy as np

from ..user_input import finite_array, short_text

# --- names -----------------------------------------------------------------------------------------------------------


def snake(name):
    """The name of a class as users write it: RangeBearing -> range_bearing."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name).lower()


def exported(module):
    """The classes a package exports, by the names users write."""
    return {snake(name): getattr(module, name) for name in module.__all__}


def functions(module):
    """The public functions a module defines, by name."""
    defined = inspect.getmembers(module, lambda f: inspect.isfunction(f) and f.__module__ == module.__name__)
    return {name: f for name, f in defined if not name.startswith("_")}


def look_up(kind, name, known):
    """The class or function of a name."""
    if not isinstance(name, str):
        raise ValueError(f"the {kind} is given by its name, got {short_text(name)}; known: {', '.join(known)}")
    if name not in known:
        raise ValueError(f"unknown {kind} {name!r}; known: {', '.join(known)}{nearest(name, known)}")
    return known[name]


def check_keys(table, known, also=()):
    """Refuse keys that are neither known nor, without being advertised, accepted `also`."""
    for key in table:
        if key not in known and key not in also:
            raise ValueError(f"unknown key {key!r}; possible: {', '.join(known) or 'none'}{nearest(key, known)}")


def nearest(name, known):
    """'; did you mean ...?' if one of the known names is near, else nothing."""
    close = difflib.get_close_matches(str(name), list(known), n=1, cutoff=0.5)
    return f"; did you mean {close[0]!r}?" if close else ""


# --- parameters ------------------------------------------------------------------------------------------------------


def parameters(target):
    """Parameters of a class or function that a user can give, by name; a generator `rng` is not the user's business."""
    try:
        found = inspect.signature(target, eval_str=True).parameters
    except NameError:  # annotations that cannot be evaluated
        found = inspect.signature(target).parameters
    return {name: p for name, p in found.items() if name != "rng"}


def keys_of(target):
    """The keys of a class as users write them: its parameters, the angles in degrees."""
    angles = getattr(target, "angles", ())
    return [f"{name}_deg" if name in angles else name for name in parameters(target)]


def radian_keys(keys):
    """The same angles in radians: what `_deg` keys may be called instead."""
    return [key.removesuffix("_deg") for key in keys if key.endswith("_deg")]


def arguments(target, table):
    """Arguments of a class or function from a table of its parameters.

    A key `NAME_deg` is an angle in degrees and gives the parameter NAME in radians. A class may list in `angles` which
    of its parameters are angles; then only these can be given so, and nothing beyond 2 pi is taken for radians, nor a
    standard deviation beyond 1.
    """
    accepted, angles = parameters(target), getattr(target, "angles", None)
    in_degrees = [f"{name}_deg" for name in (accepted if angles is None else angles)]
    check_keys(table, keys_of(target), also=[*(accepted if angles is None else angles), *in_degrees])
    values = {}
    for key, value in table.items():
        name = key if key in accepted else key.removesuffix("_deg")
        if name in values:
            raise ValueError(f"{name} is given twice, in degrees and in radians")
        value = typed(key, value, accepted[name])
        if name != key:
            value = typed(key, np.deg2rad(value).tolist(), accepted[name])
        elif name in (angles or ()):
            check_radians(key, value)
        values[name] = value
    missing = [
        key for key, (name, p) in zip(keys_of(target), accepted.items(), strict=True) if _needed(p, name, values)
    ]
    if missing:
        raise ValueError(f"missing: {', '.join(missing)}")
    return values


def _needed(parameter, name, values):
    return parameter.default is parameter.empty and name not in values


def check_radians(key, value):
    """Refuse angles beyond 2 pi, and standard deviations beyond 1: they are in degrees, most likely."""
    limit, said = (1.0, "1") if key.endswith("_std") else (2 * math.pi, "2 pi")
    if np.abs(finite_array(key, value)).max(initial=0.0) > limit * (1 + 1e-12):
        raise ValueError(
            f"{key} = {short_text(value)} is in radians and beyond {said}; "
            f"write {key}_deg = {short_text(value)} for degrees"
        )


def to_degrees(table, keys):
    """A table with its angles in degrees: where `keys` has NAME_deg and the table has NAME, in radians."""
    table = dict(table)
    for key, name in zip([k for k in keys if k.endswith("_deg")], radian_keys(keys), strict=True):
        if name in table:
            check_radians(name, table[name])
            if key in table:
                raise ValueError(f"{name} is given twice, in degrees and in radians")
            table[key] = np.rad2deg(table.pop(name)).tolist()
    return table


def construct(cls, table, **made):
    """Make an object of a class from a table of its parameters, beside some that are made already."""
    accepted = parameters(cls)
    missing = [name for name, p in accepted.items() if _needed(p, name, table | made)]
    if missing:
        raise ValueError(f"missing: {', '.join(missing)}")
    return cls(**{key: typed(key, value, accepted[key]) for key, value in table.items()}, **made)


# --- values ----------------------------------------------------------------------------------------------------------

CHECKS = {
    bool: ("true or false", lambda v: isinstance(v, bool)),
    str: ("a text in quotes", lambda v: isinstance(v, str)),
    int: ("a whole number", lambda v: isinstance(v, int) and not isinstance(v, bool)),
    float: ("a number", lambda v: isinstance(v, int | float) and not isinstance(v, bool)),
    tuple: ("a list of numbers", lambda v: isinstance(v, list | tuple)),
    dict: ("a table", lambda v: isinstance(v, dict)),
}


def typed(key, value, parameter):
    """The value, if it is of the type that its parameter is annotated with, or that its default value has.

    Infinity is taken only where it is the default; NaN never.
    """
    wanted = _type(parameter)
    if wanted in CHECKS:
        name, is_it = CHECKS[wanted]
        if not is_it(value):
            raise ValueError(f"{key} must be {name}, got {short_text(value)}")
    if wanted is tuple:
        finite_array(key, value)
        return tuple(value)
    if wanted is float:
        return value if value == parameter.default else float(finite_array(key, value))
    return value


def _type(parameter):
    """Return what a parameter wants: its annotation, without None if it may be None, or the type of its default."""
    wanted = parameter.annotation
    if wanted is parameter.empty:
        return type(parameter.default)
    if isinstance(wanted, types.UnionType):
        choices = [t for t in typing.get_args(wanted) if t is not type(None)]
        return choices[0] if len(choices) == 1 else None
    return wanted
