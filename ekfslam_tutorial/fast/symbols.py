"""Numbers that remember where they come from: a function that is called with them writes itself down.

The models are written once, in plain numpy, for people to read. Called with arrays of `Symbol` instead of floats they
do what they always do, and a `Tape` notes each operation. What comes out is the same computation as straight code,
without arrays, calls or branches: a program that can be compiled.

numpy lets the arguments of its functions decide what is done with them (`__array_ufunc__`, `__array_function__`). An
array of objects does most of it by itself; the tables at the end have the rest. What asks for the value of a symbol
fails: an `if`, a cast to float, an item put into an array of floats. Such a model has no straight code.
"""

import math
import operator

import numpy as np


class NotTraceable(TypeError):
    """The function decides something by the value of a number; it has no straight code."""


class Tape:
    """Operations in the order in which they were done, each only once.

    Attributes
    ----------
    operations : list of (str, tuple)
        Template of the expression, with braces for its arguments, and the arguments: symbols or numbers.
    """

    def __init__(self):
        self.operations, self._known = [], {}

    def inputs(self, name, n):
        """An array of n symbols that stand for numbers of an argument, "x[{}]", shape (n,)."""
        return np.array([self.note(name.format(i)) for i in range(n)], object).view(Symbols)

    def note(self, template, *args):
        """The symbol for an operation; the same one if that has been done already."""
        key = template, *(arg.at if isinstance(arg, Symbol) else ("number", arg, math.copysign(1, arg)) for arg in args)
        if key not in self._known:
            self._known[key] = Symbol(self, len(self.operations))
            self.operations.append((template, args))
        return self._known[key]


def _with_arrays(operation):
    """An operation with a number or a symbol; one with an array is numpy's."""
    return lambda self, other: NotImplemented if isinstance(other, np.ndarray) else operation(self, other)


class Symbol:
    """The result of one operation on a tape. It computes as a float does, and decides nothing.

    numpy's functions on arrays of symbols call the method of their name.
    """

    __slots__ = ("at", "tape")
    __hash__ = None  # pyright: ignore[reportAssignmentType] -- a set decides by values, too
    shape, ndim = (), 0

    def __init__(self, tape, at):
        self.tape, self.at = tape, at

    def __repr__(self):
        return f"Symbol({self.tape.operations[self.at][0]})"

    def __bool__(self):
        raise NotTraceable("what a model does must not depend on the values of its numbers: use numpy's where")

    @_with_arrays
    def __add__(self, other):
        if _is(other, 0):
            return self
        a, b = _negated(self), _negated(other)
        if a is not None:
            return other - a if b is None else -(a + b)
        return self.tape.note("{} + {}", self, other) if b is None else self - b

    __radd__ = __add__

    @_with_arrays
    def __sub__(self, other):
        if _is(other, 0):
            return self
        a, b = _negated(self), _negated(other)
        if b is not None:
            return self + b
        return self.tape.note("{} - {}", self, other) if a is None else -(a + other)

    @_with_arrays
    def __rsub__(self, other):
        return -self if _is(other, 0) else self.tape.note("{} - {}", other, self)

    @_with_arrays
    def __mul__(self, other):
        if _is(other, 0):
            return 0.0
        if _is(other, 1) or _is(other, -1):
            return self if other > 0 else -self
        a, b = _negated(self), _negated(other)
        if a is not None:
            return -(a * other)
        return self.tape.note("{} * {}", self, other) if b is None else -(self * b)

    __rmul__ = __mul__

    @_with_arrays
    def __truediv__(self, other):
        return self if _is(other, 1) else self.tape.note("{} / {}", self, other)

    @_with_arrays
    def __rtruediv__(self, other):
        return 0.0 if _is(other, 0) else self.tape.note("{} / {}", other, self)

    @_with_arrays
    def __pow__(self, n):
        if not _is(n, round(n)) or not 1 <= n <= 8:
            return self.tape.note("{} ** {}", self, n)
        return math.prod([self] * int(n - 1), start=self)

    def __neg__(self):
        a = _negated(self)
        return self.tape.note("-{}", self) if a is None else a

    def __pos__(self):
        return self

    def __abs__(self):
        return self.tape.note("abs({})", self)

    @_with_arrays
    def __and__(self, other):
        if isinstance(other, bool):
            return self if other else False
        return self.tape.note("{} and {}", self, other)

    @_with_arrays
    def __or__(self, other):
        if isinstance(other, bool):
            return True if other else self
        return self.tape.note("{} or {}", self, other)

    __rand__, __ror__ = __and__, __or__

    def __invert__(self):
        return self.tape.note("not {}", self)

    def choose(self, a, b):
        """Return a where this is true, else b."""
        return self.tape.note("{1} if {0} else {2}", self, a, b)

    def __array_ufunc__(self, ufunc, method, *inputs, **kwargs):
        return _apply(ufunc, method, *inputs, **kwargs)

    def __array_function__(self, function, types, args, kwargs):
        return function(*_arrays(args), **kwargs)


def _is(x, number):
    """Return True if x is this number, and no symbol."""
    return not isinstance(x, Symbol) and x == number


def _negated(x):
    """The symbol a, if x is -a: a sign is written once for all terms, so that equal ones are found."""
    template, args = x.tape.operations[x.at] if isinstance(x, Symbol) else ("", (None,))
    return args[0] if template == "-{}" else None


def _infix(sign):
    """An operation whose sign stands between two numbers."""
    template = f"{{}} {sign} {{}}"
    return _with_arrays(lambda self, other: self.tape.note(template, self, other))


def _method(name):
    """The method that numpy's function of this name calls."""
    template = f"math.{name.replace('arc', 'a')}({{}})"
    return lambda self: self.tape.note(template, self)


SIGNS = {"eq": "==", "ne": "!=", "lt": "<", "le": "<=", "gt": ">", "ge": ">=", "mod": "%"}
for _name, _sign in SIGNS.items():
    setattr(Symbol, f"__{_name}__", _infix(_sign))
for _name in ("cos", "sin", "tan", "arctan", "arcsin", "arccos", "sqrt", "exp", "log", "sinh", "cosh", "tanh"):
    setattr(Symbol, _name, _method(_name))


# --- arrays ----------------------------------------------------------------------------------------------------------


class Symbols(np.ndarray):
    """An array of symbols, and of numbers that are known beforehand."""

    def __array_ufunc__(self, ufunc, method, *inputs, **kwargs):
        return _apply(ufunc, method, *inputs, **kwargs)

    def __array_function__(self, function, types, args, kwargs):
        if function in FUNCTIONS:
            return FUNCTIONS[function](*_arrays(args), **kwargs)
        if function in BLIND:
            return NotImplemented
        return _symbols(super().__array_function__(function, (Symbols,), _arrays(args), kwargs))


def _apply(ufunc, method, *inputs, where=True, out=(), **kwargs):
    """A function of numpy's that works entry by entry, or its `reduce`, on arrays of objects."""
    if where is not True:
        return NotImplemented
    if "dtype" in kwargs:
        kwargs["dtype"] = object
    if any(x is not None for x in out):
        kwargs["out"] = tuple(map(_plain, out))
    function = getattr(UFUNCS.get(ufunc.__name__, ufunc), method)
    return _symbols(function(*(_plain(x) for x in _arrays(inputs)), **kwargs))


def _arrays(x):
    """Arguments with each symbol as an array without axes, also in lists."""
    if isinstance(x, (list, tuple)):
        return type(x)(map(_arrays, x))
    return _symbols(x) if isinstance(x, Symbol) else x


def _symbols(x):
    """Results: an array of objects, or a symbol, as an array of symbols."""
    if isinstance(x, (list, tuple)):
        return type(x)(map(_symbols, x))
    if isinstance(x, Symbol):
        return np.array(x, object).view(Symbols)
    return x.view(Symbols) if type(x) is np.ndarray and x.dtype == object else x


def _plain(x):
    """An array of symbols as one of objects."""
    return x.view(np.ndarray) if isinstance(x, Symbols) else x


# --- what an array of objects does not do by itself ------------------------------------------------------------------


def _entries(known, f, n=2):
    """A function of n numbers that is f where one of them is a symbol, and numpy's `known` for numbers."""

    def value(*args):
        args = [x.item() if isinstance(x, np.generic) else x for x in args]
        return f(*args) if any(isinstance(x, Symbol) for x in args) else known(*args).item()

    return np.frompyfunc(value, n, 1, identity=getattr(known, "identity", None))


def _call(name):
    """A function of two numbers in Python's module math."""
    template = f"math.{name}({{}}, {{}})"
    return lambda a, b: next(x for x in (a, b) if isinstance(x, Symbol)).tape.note(template, a, b)


def _choose(c, a, b):
    """a where c is true, else b."""
    return c.choose(a, b) if isinstance(c, Symbol) else a if c else b


def _larger(a, b):
    """The larger one of two numbers; one that is not a number wins."""
    return _choose((a >= b) | (a != a), a, b)


def _smaller(a, b):
    """The smaller one; one that is not a number wins."""
    return _choose((a <= b) | (a != a), a, b)


def _signum(a):
    """The sign of a number: -1, 0 or 1."""
    return _choose(a > 0, 1.0, _choose(a < 0, -1.0, a))


def _norm(v, ord=None, axis=None, keepdims=False):
    """Euclidean norm of vectors."""
    if ord not in (None, 2) or (axis is None and v.ndim != 1):
        raise NotTraceable("of numpy's norms only that of vectors is known, |v| along an axis")
    return np.sqrt(np.sum(v * v, axis=axis, keepdims=keepdims))


UFUNCS = {
    "arctan2": _entries(np.arctan2, _call("atan2")),
    "hypot": _entries(np.hypot, _call("hypot")),
    "less": _entries(np.less, operator.lt),
    "less_equal": _entries(np.less_equal, operator.le),
    "greater": _entries(np.greater, operator.gt),
    "greater_equal": _entries(np.greater_equal, operator.ge),
    "equal": _entries(np.equal, operator.eq),
    "not_equal": _entries(np.not_equal, operator.ne),
    "logical_and": _entries(np.logical_and, lambda a, b: (a != 0) & (b != 0)),
    "logical_or": _entries(np.logical_or, lambda a, b: (a != 0) | (b != 0)),
    "logical_not": _entries(np.logical_not, lambda a: a == 0, 1),
    "bitwise_and": _entries(np.bitwise_and, operator.and_),
    "bitwise_or": _entries(np.bitwise_or, operator.or_),
    "invert": _entries(np.invert, operator.invert, 1),
    "maximum": _entries(np.maximum, _larger),
    "minimum": _entries(np.minimum, _smaller),
    "clip": _entries(np.clip, lambda a, low, high: _smaller(_larger(a, low), high), 3),
    "sign": _entries(np.sign, _signum, 1),
    "isnan": _entries(np.isnan, lambda a: a != a, 1),
    "isfinite": _entries(np.isfinite, lambda a: a - a == 0, 1),
    "deg2rad": _entries(np.deg2rad, lambda a: a * (math.pi / 180), 1),
    "radians": _entries(np.radians, lambda a: a * (math.pi / 180), 1),
    "rad2deg": _entries(np.rad2deg, lambda a: a * (180 / math.pi), 1),
    "degrees": _entries(np.degrees, lambda a: a * (180 / math.pi), 1),
}
"""Functions of each entry, by name. A comparison gives a symbol, no truth value."""

FUNCTIONS = {
    np.where: lambda c, a, b: _symbols(np.frompyfunc(_choose, 3, 1)(*map(_plain, (c, a, b)))),
    np.linalg.norm: _norm,
}
"""Functions of whole arrays."""

BLIND = {np.nan_to_num}
"""Functions that leave objects as they are, whatever they would do with numbers."""
