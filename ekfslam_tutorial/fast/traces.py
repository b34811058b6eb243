"""What the models do, written down: each function here calls a model with symbols, and returns the tape and results.

The results are arrays of symbols and numbers, by name. `straight_code` makes lines of Python of them.
"""

import numpy as np

from ..models.observation import retro_project
from .core import Symbol, Tape
from .expectation import expect


def trace_move(motion):
    """`move` of a motion model, of x[.], u[.] and dt: x2, X_x, X_u."""
    m, size = sum(motion.control_fields.values()), motion.size
    tape = Tape()
    x, u, dt = tape.inputs("x[{}]", size), tape.inputs("u[{}]", m), tape.note("dt")
    x2, X_x, X_u = map(_single, motion.move(x[None], u[None], dt), (1, 2, 2))
    _check_shapes((x2, size), (X_x, size, size), (X_u, size, m))
    return tape, {"x2": x2, "X_x": X_x, "X_u": X_u}


def trace_orientation(frame):
    """The orientation of a frame x[.] in its normal form, o, and its derivative J by that of the frame."""
    tape = Tape()
    N, N_f = frame(tape.inputs("x[{}]", frame.size)).normalized()
    return tape, {"o": N.x[frame.dim :], "J": N_f[frame.dim :, frame.dim :]}


def trace_expectation(frame, sensor, kind):
    """Expectation of landmark l[k, .] by frames rf[.], sf[.]: e, v, visible, and J = [E_r E_s E_l]."""
    tape, n_f, n_l, m = Tape(), frame.size, kind.size, len(sensor.R)
    Rf, Sf = frame(tape.inputs("rf[{}]", n_f)), frame(tape.inputs("sf[{}]", n_f))
    e, v, E_r, E_s, E_l = expect(Rf, Sf, sensor, kind, tape.inputs("l[k, {}]", n_l)[None])
    visible = np.asarray(sensor.visible(e, v))[0]
    E_r, E_s, E_l = (_single(E, 2) for E in (E_r, E_s, E_l))
    _check_shapes((e[0], m), (E_r, m, n_f), (E_s, m, n_f), (E_l, m, n_l))
    return tape, {"e": e[0], "v": v[0], "visible": visible, "J": np.concatenate([E_r, E_s, E_l], -1)}


def trace_inside(sensor):
    """Return True of a measurement y[.] of something visible: `sensor.visible` of `sensor.retro`."""
    tape = Tape()
    return tape, {"seen": _seen(sensor, tape.inputs("y[{}]", len(sensor.R))[None])}


def trace_birth(frame, sensor, kind, look=False):
    """`retro_project` by frames rf[.], sf[.] of y[.] and n[.]: l, L = [L_r L_s], L_y, L_n; with `look` also `seen`."""
    tape, n_f, n_l = Tape(), frame.size, kind.size
    m, n_n = len(sensor.R), 1 if sensor.bearing_only else 0
    Rf, Sf = frame(tape.inputs("rf[{}]", n_f)), frame(tape.inputs("sf[{}]", n_f))
    y, n = tape.inputs("y[{}]", m), tape.inputs("n[{}]", n_n)
    l, *Ls = retro_project(Rf, Sf, sensor, kind, y[None], n[None])
    L_r, L_s, L_y, L_n = (_single(L, 2) for L in Ls)
    _check_shapes((l[0], n_l), (L_r, n_l, n_f), (L_s, n_l, n_f), (L_y, n_l, m), (L_n, n_l, n_n))
    found = {"l": l[0], "L": np.concatenate([L_r, L_s], -1), "L_y": L_y, "L_n": L_n}
    return tape, found | ({"seen": _seen(sensor, y[None])} if look else {})


def _seen(sensor, y):
    """Return True of measurements y, shape (1, m), of something visible."""
    return np.asarray(sensor.visible(y, sensor.retro(y)[0]))[0]


def _single(a, ndim):
    """An array of the only member of a stack; one that is the same for all may stand without the stack."""
    return a[0] if a.ndim > ndim else a


def _check_shapes(*arrays):
    """Refuse a model whose results have other shapes than they should: a program would not notice."""
    for a, *shape in arrays:
        if a.shape != tuple(shape):
            raise ValueError(f"expected the shape {tuple(shape)}, got {a.shape}")


# --- as lines of Python ----------------------------------------------------------------------------------------------


def operations(tape, results, each=None):
    """The operations on a tape that lead to some results, in their order.

    Parameters
    ----------
    tape : Tape
    results : iterable of ndarray
        Symbols and numbers.
    each : str, optional
        What depends on inputs that contain this, "[k", varies from landmark to landmark.

    Returns
    -------
    list of (int, str, tuple, bool)
        Number, template, arguments, and True if it varies.
    """
    symbols = [value for a in results for value in np.ravel(np.array(a, object)) if isinstance(value, Symbol)]
    needed, todo = set(), [value.at for value in symbols]
    while todo:
        at = todo.pop()
        if at not in needed:
            needed.add(at)
            todo += [arg.at for arg in tape.operations[at][1] if isinstance(arg, Symbol)]
    found, varies = [], set()
    for at in sorted(needed):
        template, args = tape.operations[at]
        if each and (each in template or any(isinstance(arg, Symbol) and arg.at in varies for arg in args)):
            varies.add(at)
        found.append((at, template, args, at in varies))
    return found


def line(at, template, args):
    """Return an operation as a line of Python: the variable of symbol 7 is t7."""
    return f"t{at} = {template.format(*map(name_of, args)) if args else template}"


def straight_code(tape, outputs, each=None):
    """The operations on a tape that lead to some outputs, as lines of Python.

    Parameters
    ----------
    tape : Tape
    outputs : list of (str, ndarray)
        Where to write, with braces for the indices, "E[k, {}, {}]", and the symbols or numbers to be written.
    each : str, optional
        What depends on inputs that contain this, "[k", is computed in a loop; the rest of it before, once.

    Returns
    -------
    before, loop : list of str
    """
    before, loop = [], []
    for at, template, args, varies in operations(tape, [a for _, a in outputs], each):
        (loop if varies else before).append(line(at, template, args))
    arrays = [(target, np.array(a, object)) for target, a in outputs]
    assigned = [(target.format(*i), a[i]) for target, a in arrays for i in np.ndindex(a.shape)]
    (loop if each else before).extend(f"{target} = {name_of(value)}" for target, value in assigned)
    return before, loop


def name_of(value):
    """A symbol's variable, or a number."""
    if isinstance(value, Symbol):
        return f"t{value.at}"
    number = float(value)
    return repr(number) if number == number and abs(number) != float("inf") else f"float('{number}')"
