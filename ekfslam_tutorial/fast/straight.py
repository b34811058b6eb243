"""The models without machine code: what they do as straight lines of Python, for one vector or for a stack.

A model that is called for one robot or one landmark calls numpy for a handful of numbers, a hundred times. What it does
is known from its trace: floats and Python's own `math` do the same for one vector in a tenth of the time, and numpy for
a stack of landmarks, operation by operation, in half of it. What cannot be traced, or has no finite result, is left to
the model itself.
"""

import math
from typing import Any

import numpy as np

from ..models.observation import observe, retro_project
from .expectation import expect
from .programs import program
from .traces import (
    line,
    name_of,
    operations,
    trace_birth,
    trace_expectation,
    trace_inside,
    trace_move,
    trace_orientation,
)

FAILED = ArithmeticError, ValueError, TypeError  # of Python's math, where numpy gives infinity or NaN
LONG = 400  # operations for each of a stack: from here on the model's own products of matrices are quicker


def moved(motion, x, u, dt):
    """`motion.move` of one state."""
    run = program(_write_move, motion)
    if run is not None and x.shape == (motion.size,):
        try:
            return run(x.tolist(), u.tolist(), float(dt))
        except FAILED:
            pass
    return motion.move(x, u, dt)


def oriented(F):
    """The orientation of a frame in its normal form, and its derivative by that of the frame."""
    run = program(_write_orientation, type(F))
    if run is not None:
        try:
            return run(F.x.tolist())
        except FAILED:
            pass
    N, N_f = F.normalized()
    return N.x[F.dim :], N_f[F.dim :, F.dim :]


def expected(Rf, Sf, sensor, kind, l):
    """`expect` of a stack of landmarks, and which of them are visible: e, v, E_r, E_s, E_l, visible."""
    run = program(_write_expectation, type(Rf), sensor, kind) if type(Sf) is type(Rf) else None
    if run is not None and l.shape[-1] == kind.size:
        try:
            e, v, visible, J = run(Rf.x.tolist(), Sf.x.tolist(), l)
            n = Rf.size
            return e, v, J[..., :n], J[..., n : 2 * n], J[..., 2 * n :], visible
        except FAILED:
            pass
    e, v, *E_ = expect(Rf, Sf, sensor, kind, l)
    return e, v, *E_, np.broadcast_to(sensor.visible(e, v), e.shape[:-1])


def expected_of_one(Rf, Sf, sensor, kind, l):
    """`observe` of one landmark: e, E_r, E_s, E_l."""
    run = program(_write_expectation_of_one, type(Rf), sensor, kind) if type(Sf) is type(Rf) else None
    if run is not None and l.shape == (kind.size,):
        try:
            e, J = run(Rf.x.tolist(), Sf.x.tolist(), l.tolist())
            n = Rf.size
            return e, J[:, :n], J[:, n : 2 * n], J[:, 2 * n :]
        except FAILED:
            pass
    return observe(Rf, Sf, sensor, kind, l)


def inside(sensor, y):
    """Return True if a measurement is one of something visible."""
    run = program(_write_inside, sensor)
    if run is not None and y.shape == (len(sensor.R),):
        try:
            return bool(run(y.tolist()))
        except FAILED:
            pass
    return bool(np.all(sensor.visible(y, sensor.retro(y)[0])))


def retro_projected(Rf, Sf, sensor, kind, y, n):
    """`retro_project` of one measurement: l, L_r, L_s, L_y, L_n."""
    run = program(_write_birth, type(Rf), sensor, kind) if type(Sf) is type(Rf) else None
    if run is not None and y.shape == (len(sensor.R),) and len(n) == sensor.bearing_only:
        try:
            l, L, L_y, L_n = run(Rf.x.tolist(), Sf.x.tolist(), y.tolist(), n.tolist())
            return l, L[:, : Rf.size], L[:, Rf.size :], L_y, L_n
        except FAILED:
            pass
    return retro_project(Rf, Sf, sensor, kind, y, n)


# --- programs --------------------------------------------------------------------------------------------------------


def _write_move(motion):
    return _of_one("x, u, dt", *trace_move(motion))


def _write_orientation(frame):
    return _of_one("x", *trace_orientation(frame))


def _write_expectation_of_one(frame, sensor, kind):
    tape, found = trace_expectation(frame, sensor, kind)
    return _of_one("rf, sf, l", tape, {name: found[name] for name in ("e", "J")})


def _write_inside(sensor):
    return _of_one("y", *trace_inside(sensor))


def _write_birth(frame, sensor, kind):
    return _of_one("rf, sf, y, n", *trace_birth(frame, sensor, kind))


def _of_one(arguments, tape, results):
    """The program for lists of floats: it returns the results as arrays, in their order."""
    steps = operations(tape, results.values())
    lines = [line(at, _for_floats(template), args) for at, template, args, _ in steps]
    return _function(arguments, [*lines, f"return {', '.join(map(_array, results.values()))}"])


def _array(a):
    """Return the text of an array of symbols and numbers."""
    if not np.ndim(a):
        return name_of(np.array(a, object).item())
    if not np.size(a):
        return f"np.empty({a.shape})"
    return f"np.array({_nested(np.array(a, object))})"


def _nested(a):
    return f"[{', '.join(map(_nested, a))}]" if a.ndim > 1 else f"[{', '.join(map(name_of, a))}]"


def _write_expectation(frame, sensor, kind):
    """The program for a stack: what varies from landmark to landmark is an array."""
    tape, found = trace_expectation(frame, sensor, kind)
    lines = []
    steps = operations(tape, found.values(), each="[k")
    if sum(varies for *_, varies in steps) > LONG:
        return None
    for at, template, args, varies in steps:
        lines.append(line(at, _for_arrays(template) if varies else template, args))
    lines.append("K = len(l)")
    for name, a in found.items():
        a, kind_of = np.array(a, object), "bool" if name == "visible" else "float"
        lines.append(f"{name} = np.empty(({', '.join(map(str, ('K', *a.shape)))},), {kind_of})")
        lines += [f"{name}[{', '.join(map(str, (':', *i)))}] = {name_of(a[i])}" for i in np.ndindex(a.shape)]
    return np.errstate(all="ignore")(_function("rf, sf, l", [*lines, f"return {', '.join(found)}"]))


INFIX = {"{} and {}": "np.logical_and({}, {})", "{} or {}": "np.logical_or({}, {})", "not {}": "np.logical_not({})"}
INFIX |= {"{} ** {}": "np.power({}, {})"}  # of integers it is still a float: one of both is a symbol
INFIX |= {"{1} if {0} else {2}": "np.where({0}, {1}, {2})", "math.hypot({}, {})": "np.hypot({}, {})"}


def _for_floats(template):
    """Return the template of an operation for floats: a root of a negative number is an error, not complex."""
    return "math.pow({}, {})" if template == "{} ** {}" else template.replace("[k, ", "[")


def _for_arrays(template):
    """Return the template of an operation for arrays instead of floats."""
    if template in INFIX:
        return INFIX[template]
    if template.startswith("math.a"):
        return template.replace("math.a", "np.arc")
    return template.replace("math.", "np.").replace("[k, ", "[:, ")


def _function(arguments, lines):
    """Return the function with this body."""
    namespace: dict[str, Any] = {"math": math, "np": np}
    exec("".join([f"def run({arguments}):\n", *(f"    {each}\n" for each in lines)]), namespace)
    return namespace["run"]
