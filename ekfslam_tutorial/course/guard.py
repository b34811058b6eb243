"""A student's function as the links see it: copies in, a copy out, every call remembered."""

from __future__ import annotations

import copy
import inspect
import linecache
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .deadline import Stopped
from .expect import Failed

OTHER_NAME = "write into what the caller has, also by another name for it: `b = a` is no copy."
IN_PLACE = f"`+=`, `-=`, `*=` and `x[i] = ...` {OTHER_NAME}"
IN_PLACE_LIST = f"`append`, `insert`, `+=` and `x[i] = ...` {OTHER_NAME}"


ADVICE = {
    NameError: "Is the name spelt as in the `def` line, and defined before it is used?",
    KeyError: "The dictionary has no entry of that name: `key in d` asks first, and d.get(key, default) never fails.",
    IndexError: "The index is too large. Print it, and the shape of the array: the last place has the number len - 1. "
    "Is it a place, and not an id? Is it the right axis: a[i] is a row, a[:, i] is a column? And argmin, argmax "
    "without an axis count through all rows, one after the other.",
    np.linalg.LinAlgError: "Print the matrix of that line: is it the one that you mean?",
    RecursionError: "The function calls itself without end.",
    ValueError: "Print what goes into that line: values, and the shapes of arrays by `np.shape(...)`. Are they what "
    "you think they are?",
    TypeError: "Print what is in that line: is each name the array, number or function that you think it is?",
    AttributeError: "Print what is in that line: is each name the array, number or function that you think it is?",
    SystemExit: "A function gives its result back by `return`; it never ends Python.",
}


WHOLE = "An index is a whole number, and this is none: most often a float. `int(i)`, or `a.astype(int)` for an array."

# What numpy says of slips that every student makes once: a part of its message, and what it means.
SLIPS = {
    "(0,)": "One of the arrays is empty: a slice that begins behind the end has no entries. Counting starts at 0, and "
    "a place is no id.",
    "not enough values to unpack": "There are fewer values than names on the left. Print what is taken apart: a slice "
    "that begins before 0, or behind the end, is empty. Counting starts at 0, and a place is no id.",
    "can be converted to Python scalar": "An array came where one number is wanted. The functions of `math` take "
    "single numbers; those of numpy (np.sin, np.arctan2 ...) take arrays, too.",
    "truth value of an array": "`if`, `while`, `and` and `or` decide about one number. For all entries of an array "
    "at once there are np.where, np.all, np.any, & and |.",
    "could not be broadcast": "Print both shapes: `*`, `+`, `-` and `=` go entry by entry, so they want equal ones. "
    "One more or less: was something added or deleted in one array and not in the other? The product of matrices is "
    "`@`.",
    "ufunc 'positive'": "A frame is made of 7 numbers, in the plane of 3, and here is something else. Is it None? A "
    "mounting that is in the map is `x[sen.r]`, and `sen.x` is None.",
    "negative dimensions": "A size in that line is negative. Print the numbers that it is made of: which of them did "
    "you expect to be the larger one?",
    "mismatch in its core dimension": "In A @ B the columns of A must be as many as the rows of B: look at the "
    "order of the factors, and at the transposes (.T).",
    "object is not subscriptable": "What stands before the bracket [ ] is a single number or a function, not an array.",
    "'tuple' object has no attribute": "A function with several results gives all of them together: take them apart, "
    "`a, b = f(x)`, or take the first one, `f(x)[0]`.",
    "object is not callable": "What stands before the bracket ( ) is not a function: is a `*` or an `@` missing?",
    "only integers, slices": WHOLE,
    "indices must be integers": WHOLE,
    "must be of integer (or boolean) type": WHOLE,
    "Singular matrix": "This matrix has no inverse. Print it: is it the one that you mean, and is the noise in it?",
}


class NotAttempted(Exception):
    """The first call of the student's function ended in NotImplementedError."""


@dataclass(frozen=True)
class Raised:
    """In place of a result: the call ended in this kind of exception, with this message."""

    kind: str
    text: str = ""


@dataclass(frozen=True)
class Call:
    """One call of the student's function: what went in, what came out; and what other functions answer to it."""

    args: tuple
    result: Any
    answers: dict = field(default_factory=dict, compare=False, repr=False)


class Guarded:
    """The student's function as the properties see it.

    Each call gets copies of the arguments and returns a copy of the result. An exception, or a changed
    argument, is reported as `Failed`. All calls are remembered in `calls`.

    Parameters
    ----------
    function : callable
        The student's function.
    may_change : collection of str
        Names of parameters that the function is asked to change in place.
    names : sequence of str
        Names of the parameters, for the messages.
    """

    def __init__(self, function, may_change=(), names=()):
        self.function = function
        self.may_change = frozenset(may_change)
        self.names = tuple(names)
        self.calls: list[Call] = []

    def __call__(self, *args):
        given = copy.deepcopy(args)
        try:
            result = _copied(self.function(*given))
        except Stopped:
            raise
        except NotImplementedError as error:
            if not self.calls:
                raise NotAttempted from None
            raise Failed(_blame(self.function, error), _advice(error)) from None
        except BaseException as error:
            self.calls.append(Call(args, Raised(type(error).__name__, str(error))))
            raise Failed(_blame(self.function, error), _advice(error)) from None
        self.calls.append(Call(args, result))
        self._unchanged(args, given)
        return result

    def _unchanged(self, args, given):
        for i, (before, after) in enumerate(zip(args, given, strict=True)):
            name = self.names[i] if i < len(self.names) else f"argument {i + 1}"
            if name not in self.may_change and not equal(before, after):
                raise Failed(f"your function changes its input `{name}`", _copy_advice(name, before), certain=True)


def _copy_advice(name, value):
    """How to leave an input of this kind as it is. A copied list still holds the caller's arrays."""
    if isinstance(value, (list, tuple)):
        if any(isinstance(item, (np.ndarray, list, dict)) for item in value):
            return f"{IN_PLACE_LIST} Build a new list, of copies: `{name} = [item.copy() for item in {name}]`."
        return f"{IN_PLACE_LIST} Build a new list: `{name} = list({name})`."
    if isinstance(value, dict):
        return f"{IN_PLACE} Work on a copy: `dict({name})`."
    floats = isinstance(value, np.ndarray) and value.dtype.kind == "f"  # of whole numbers, type int keeps no decimals
    of_floats = ", dtype=float" if floats else ""
    return f"{IN_PLACE} Work on a copy: `np.array({name}{of_floats})`."


def misses_arguments(function, names):
    """Return a sentence if `function` cannot be called with the arguments `names`, else None."""
    try:
        signature = inspect.signature(function)
    except (TypeError, ValueError):
        return None
    try:
        signature.bind(*names)
    except TypeError:
        has = ", ".join(signature.parameters) or "none"
        return f"your function must take {len(names)} arguments, ({', '.join(names)}); yours takes ({has})"
    return None


def equal(a, b, rtol=0.0, atol: float | None = 0.0):
    """Return True if two results are the same: arrays, numbers, lists, dictionaries, objects with attributes.

    A list of numbers equals the array of the same numbers; a column does not equal a vector. With `atol` None small
    numbers may differ by 1e-8 of the largest one beside them, and of 1 where that is larger.
    """
    A, B = numbers(a), numbers(b)
    if A is not None and B is not None:
        return A.shape == B.shape and _near(A, B + 0.0, rtol, atol)
    if isinstance(a, (list, tuple)) and isinstance(b, (list, tuple)):
        return len(a) == len(b) and all(equal(x, y, rtol, atol) for x, y in zip(a, b, strict=True))
    if isinstance(a, dict) and isinstance(b, dict):
        return a.keys() == b.keys() and all(equal(a[key], b[key], rtol, atol) for key in a)
    if type(a) is not type(b):
        return False
    if hasattr(a, "__dict__") and type(a).__eq__ is object.__eq__:
        return equal(vars(a), vars(b), rtol, atol)
    try:
        return bool(a == b)
    except Exception:
        return False


SMALLEST = 1e-4  # of the largest number beside zeros: what rounding leaves of them is smaller than 1e-8 of that


def _near(A, B, rtol, atol) -> bool:
    """As `numpy.allclose`, where NaN equals NaN: it is asked a thousand times for one wrong answer, so in few steps."""
    with np.errstate(all="ignore"):
        if atol is None:
            largest = float(np.abs(B).max()) if B.size else 0.0
            atol = 1e-8 * max(largest, SMALLEST) if largest < 1 else 1e-8  # also of what is not finite
        far = ~((np.abs(A - B) <= atol + rtol * np.abs(B)) & np.isfinite(B))
    if not far.any():
        return True
    A, B = A[far], B[far]
    if rtol:  # a quotient by zero: whether infinity or no number comes of it depends on how a line is written
        return not (np.isfinite(A) | np.isfinite(B)).any()
    return bool(((A == B) | np.isnan(A) & np.isnan(B)).all())  # what is left may still be infinite, or no number


def numbers(value):
    """Return the value as an array of floats (complex if need be), or None if it is something else."""
    if value is None or isinstance(value, (str, bytes, dict, set)) or _nests(value, DEEPEST):
        return None
    try:
        a = np.asarray(value)
        return a if a.dtype.kind in "fiubc" else None
    except Exception:
        return None


DEEPEST = 8  # levels of lists in lists: of a list that holds itself numpy would make an array until the memory is full


def _nests(value, levels) -> bool:
    """Return True if there are lists in lists on more levels than that."""
    return isinstance(value, (list, tuple)) and (levels == 0 or any(_nests(v, levels - 1) for v in value))


def _copied(value):
    try:
        return copy.deepcopy(value)
    except Exception:
        return value


def _advice(error):
    """What to look at first after an exception of this kind."""
    known = [advice for words, advice in SLIPS.items() if words in str(error)]
    known += [ADVICE[kind] for kind in ADVICE if isinstance(error, kind)]
    return next(iter(known), "Read the error: it names the line, and what went wrong there.")


def _blame(function, error):
    """One sentence: the exception, and the last line of the student's own code on the way to it."""
    text = f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
    frame, code = None, getattr(function, "__code__", None)
    trace = error.__traceback__
    while trace is not None:
        if code is not None and trace.tb_frame.f_code.co_filename == code.co_filename:
            frame = trace
        trace = trace.tb_next
    if frame is None or code is None:
        return f"your function raised {text}"
    line = linecache.getline(code.co_filename, frame.tb_lineno).strip()
    number, name = frame.tb_lineno - code.co_firstlineno + 1, frame.tb_frame.f_code.co_name
    inside = frame.tb_frame.f_code is code or (name.startswith("<") and number > 0)  # a list in brackets has no name
    place = f"line {number}" if inside else f"`{name}`"
    return f"your function raised {text[:300]}, in {place}" + (f": `{line}`" if line else "")
