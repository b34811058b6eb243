"""Numbers that remember where they come from: a function that is called with them writes itself down.

The models are written once, with numpy, for people to read. Called with arrays of `Symbol` instead of floats they do
what they always do, and a `Tape` notes each operation. What comes out is the same computation as straight code, without
arrays, calls or branches: a program that can be compiled.
"""

import math

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
        return self if _is(other, 0) else self.tape.note("{} + {}", self, other)

    __radd__ = __add__

    @_with_arrays
    def __sub__(self, other):
        return self if _is(other, 0) else self.tape.note("{} - {}", self, other)

    @_with_arrays
    def __rsub__(self, other):
        return -self if _is(other, 0) else self.tape.note("{} - {}", other, self)

    @_with_arrays
    def __mul__(self, other):
        if _is(other, 0):
            return 0.0
        return self if _is(other, 1) else -self if _is(other, -1) else self.tape.note("{} * {}", self, other)

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
        return self.tape.note("-{}", self)

    def __abs__(self):
        return self.tape.note("abs({})", self)

    def __rand__(self, other):
        return self & other

    def __invert__(self):
        return self.tape.note("not {}", self)

    def choose(self, a, b):
        """Where this is true a, else b."""
        return self.tape.note("{1} if {0} else {2}", self, a, b)

    def __array_function__(self, function, types, args, kwargs):
        return _where(*map(_plain, args)) if function is np.where else NotImplemented


def _is(x, number):
    """Whether x is this number, and no symbol."""
    return not isinstance(x, Symbol) and x == number


def _infix(sign):
    """An operation whose sign stands between two numbers."""
    template = f"{{}} {sign} {{}}"
    return _with_arrays(lambda self, other: self.tape.note(template, self, other))


def _function(name):
    """The method that numpy's function of this name calls."""
    template = f"math.{name.replace('arc', 'a')}({{}})"
    return lambda self: self.tape.note(template, self)


def _of_two(name):
    """A function of two arrays of symbols or numbers."""
    template, known = f"math.{name.replace('arc', 'a')}({{}}, {{}})", getattr(np, name)

    def value(a, b):
        symbols = [x for x in (a, b) if isinstance(x, Symbol)]
        return symbols[0].tape.note(template, a, b) if symbols else float(known(a, b))

    return np.frompyfunc(value, 2, 1)


SIGNS = {"eq": "==", "ne": "!=", "lt": "<", "le": "<=", "gt": ">", "ge": ">=", "mod": "%", "and": "and", "or": "or"}
for _name, _sign in SIGNS.items():
    setattr(Symbol, f"__{_name}__", _infix(_sign))
for _name in ("cos", "sin", "tan", "arctan", "arcsin", "arccos", "sqrt", "exp", "log", "sinh", "cosh", "tanh"):
    setattr(Symbol, _name, _function(_name))


OF_TWO = {np.arctan2: _of_two("arctan2"), np.hypot: _of_two("hypot")}
COMPARISONS = {np.less, np.less_equal, np.greater, np.greater_equal, np.equal, np.not_equal}
BLIND = {np.nan_to_num}
"""Functions of numpy that leave objects as they are, whatever they would do with numbers."""


class Symbols(np.ndarray):
    """An array of symbols, and of numbers that are known beforehand.

    An array of objects does most of it. What is left: a comparison gives symbols, not truth values, and `where` keeps
    both of its branches.
    """

    def __array_ufunc__(self, ufunc, method, *inputs, **kwargs):
        if kwargs.get("where", True) is not True:
            return NotImplemented
        if ufunc in COMPARISONS or "dtype" in kwargs:
            kwargs["dtype"] = object
        if "out" in kwargs:
            kwargs["out"] = tuple(map(_plain, kwargs["out"]))
        return _symbols(getattr(OF_TWO.get(ufunc, ufunc), method)(*map(_plain, inputs), **kwargs))

    def __array_function__(self, function, types, args, kwargs):
        if function is np.where:
            return _symbols(_where(*map(_plain, args)))
        if function in BLIND:
            return NotImplemented
        return _symbols(super().__array_function__(function, types, args, kwargs))


def _plain(x):
    """An array of symbols as one of objects."""
    return x.view(np.ndarray) if isinstance(x, Symbols) else x


def _symbols(x):
    """The reverse."""
    return x.view(Symbols) if type(x) is np.ndarray and x.dtype == object else x


_where = np.frompyfunc(lambda c, a, b: c.choose(a, b) if isinstance(c, Symbol) else (a if c else b), 3, 1)
