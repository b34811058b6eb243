"""What a property may ask of an answer. Each function raises `Failed` with a sentence for the student."""

from __future__ import annotations

import numpy as np

from ..geometry import numerical_jacobian, wrap
from .diagnose import diagnose, same

RETURN = "`print` shows a result, `return` hands it back. Each branch of an `if` needs its own `return`."

NO_NUMBER = (
    "NaN or infinity comes from a division by zero, from the root of a negative number, or from the log of zero."
)


SMALL = 5e-5  # below it four decimals say zero
ALL_SMALL = 1e-3  # where all is below it, they say too little


class Failed(Exception):
    """A property does not hold; the message says what was got and what was expected.

    `hint` replaces the help of the link. Where the cause is `certain`, no misconception is looked for.
    """

    def __init__(self, message, hint="", certain=False):
        super().__init__(message)
        self.hint, self.certain = hint, certain


def array(value, shape, what):
    """Return `value` as a float array of the given shape.

    Nested lists and tuples will do. What will not: None, text, complex numbers, NaN, another shape (a column
    (n, 1) is not a vector (n,)).
    """
    if value is None:
        raise Failed(f"{what} is None: is the `return` line missing?", RETURN)
    if value is NotImplemented or value is Ellipsis:
        raise Failed(f"{what} is {value}: put your own expression there")
    try:
        a = np.asarray(value)
        if a.dtype == object:
            a = np.array(a.tolist(), dtype=float)
    except Exception:
        raise Failed(f"{what} is not an array of numbers: got {_short(value)}") from None
    if isinstance(value, (list, tuple)) and any(v is None for v in value):
        raise Failed(f"{what} holds None at [{[v is None for v in value].index(True)}]: it must hold numbers only")
    if np.iscomplexobj(a):
        raise Failed(f"{what} has complex numbers: return their real numbers")
    if a.dtype.kind not in "fiub":
        raise Failed(f"{what} is not an array of numbers: got {_short(value)}")
    shape = (shape,) if isinstance(shape, int) else tuple(shape)
    if a.shape != shape:
        raise Failed(f"{what} has shape {a.shape}, it must be {shape}" + _shape_help(a.shape, shape))
    a = a.astype(float)
    if not np.isfinite(a).all():
        place = [int(i) for i in np.argwhere(~np.isfinite(a))[0]]
        raise Failed(f"{what} holds NaN or infinity" + (f" at {place}" if place else ""), NO_NUMBER)
    return a


def results(value, *names):
    """Return the tuple of the `len(names)` results that a function must give back."""
    wanted = f"return {', '.join(names)}"
    if value is None:
        raise Failed(f"your function returns None: it must end with `{wanted}`", RETURN)
    if not isinstance(value, (tuple, list)) or len(value) != len(names):
        got = f"{len(value)} values" if isinstance(value, (tuple, list)) else _short(value)
        raise Failed(f"your function must return {len(names)} results, `{wanted}`; it returns {got}")
    return tuple(value)


def close(got, want, what, rtol=1e-5, atol=1e-8, at=""):
    """The numbers must be those wanted, up to rounding (`rtol` is relative to the largest entry)."""
    got, want = np.asarray(got, float), np.asarray(want, float)
    if not same(got, want, rtol, atol):
        where = f" for {at}" if at else ""
        slip = diagnose(got, want, min(rtol or 1e-5, 1e-5))
        if got.size > 16:  # too large to be shown: the entry that is most off
            worst = np.unravel_index(np.argmax(np.abs(got - want)), got.shape)
            what = f"{what}, entry {[int(i) for i in worst]},"
            got, want = got[worst], want[worst]
        is_, should = _apart(got, want)
        raise Failed(f"{what} is {is_}{where}, it should be {should}. {slip}".rstrip())


def angle(got, want, what, atol=1e-6, at=""):
    """The angle must be the one wanted; whole turns of 2 pi more or less do not count."""
    if abs(wrap(float(got) - float(want))) > atol:
        where = f" for {at}" if at else ""
        slip = diagnose(got, want)
        is_, should = _apart(got, want)
        raise Failed(f"{what} is {is_}{where}, it should be {should}. {slip}".rstrip())


def jacobian(J, f, x, what, rows=None, cols=None, row=None, rtol=1e-5, atol=1e-7):
    """`J` must agree with the central differences of `f` at `x`; the message names the worst entry.

    Parameters
    ----------
    J : ndarray, shape (m, n)
    f : callable
        Function of `x` alone, m numbers. It must be smooth near `x`: leave angles unwrapped.
    what : str
        Name of the matrix.
    rows, cols : sequence of str, optional
        Names of the outputs and the inputs.
    row : int, optional
        Look at this row only.
    rtol, atol : float
        Central differences with step 1e-6 are good to about 1e-9; the tolerances leave room for float32.
    """
    N = numerical_jacobian(f, np.asarray(x, float))
    seen = slice(None) if row is None else slice(row, row + 1)
    error = np.zeros_like(N)
    error[seen] = np.abs(J - N)[seen]
    i, j = (int(k) for k in np.unravel_index(np.argmax(error), error.shape))
    if error[i, j] > atol + rtol * np.abs(N[seen]).max():
        name = f" = d({rows[i]})/d({cols[j]})" if rows and cols else ""
        slip = diagnose(J[seen], N[seen]) if row is None else diagnose(J[row], N[row])
        is_, should = _apart(J[i, j], N[i, j], 4)
        raise Failed(f"{what}[{i}, {j}]{name} is {is_}, finite differences give {should}. {slip}".rstrip())


def symmetric(P, what, rtol=1e-9):
    """A covariance must be symmetric, up to rounding."""
    if not np.abs(P - P.T).max(initial=0) <= rtol * max(np.abs(P).max(initial=0), 1e-300):
        i, j = (int(k) for k in np.unravel_index(np.argmax(np.abs(P - P.T)), P.shape))
        one, other = _apart(P[i, j], P[j, i], 4)
        raise Failed(f"{what} is not symmetric: [{i}, {j}] is {one}, [{j}, {i}] is {other}")


def psd(P, what, rtol=1e-9):
    """A covariance has no negative eigenvalue, up to rounding."""
    least, most = np.linalg.eigvalsh((P + P.T) / 2)[[0, -1]]
    if least < -rtol * max(abs(most), 1e-300):
        raise Failed(f"{what} has the negative eigenvalue {least:.3g}: no covariance can have that")


def true(condition, message):
    """Any other property: `condition` must hold, else the student reads `message`."""
    if not condition:
        raise Failed(message)


def _shape_help(got, want):
    if want == () and set(got) == {1}:
        return ": a plain number, not an array"
    if len(want) == 1 and got in ((want[0], 1), (1, want[0])):
        return ": a vector has one axis here, no columns and no rows"
    if len(got) == 2 and got[::-1] == want:
        return ": is it the transpose?"
    return ""


def _apart(a, b, digits=6):
    """Show two arrays with so many digits that they do not look alike; where all is small, significant ones."""
    a, b, texts = np.asarray(a, float), np.asarray(b, float), ("", "")
    small = 0 < max(np.max(np.abs(v), initial=0) for v in (a, b)) < ALL_SMALL or _hidden(a) or _hidden(b)
    while texts[0] == texts[1] and digits < 18:
        texts = _show(a, digits, small), _show(b, digits, small)
        digits += 1
    return texts


def _show(a, digits, small=False):
    if a.ndim == 0:
        return f"{float(a):.{digits}g}"
    if small:
        rounding = np.max(np.abs(a), initial=0) * 10.0 ** (-digits - 3)
        significant = lambda v: f"{v:.{digits - 2}g}" if abs(v) > rounding else "0"
        with np.printoptions(formatter={"float_kind": significant}):
            return np.array2string(a, separator=", ").replace("\n", "")
    return np.array2string(a, precision=digits - 2, suppress_small=True, separator=", ").replace("\n", "")


def _hidden(a) -> bool:
    """Return True if an entry that is more than rounding would be shown as zero."""
    size = np.abs(a)
    return bool(((size > 1e-9 * np.max(size, initial=0)) & (size < SMALL)).any())


def _short(value):
    text = " ".join(repr(value).split())
    return f"{type(value).__name__} {text if len(text) <= 60 else text[:57] + '...'}"
