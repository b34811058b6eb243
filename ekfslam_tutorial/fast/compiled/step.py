"""Compiled pieces of a step: what the steps call for a map with `compiled`, instead of numpy's small arrays."""

from math import inf

import numpy as np

from .. import programs
from ..core import EUCLIDEAN, MapFull, Tape
from ..expectation import may_be_seen
from ..programs import program
from ..traces import straight_code, trace_birth, trace_expectation, trace_move, trace_orientation
from .filter import MANY_ROWS, NO_INDICES, RANGE, floats, integers, noises, start_of
from .program import build


def left_out():
    """Return what could not be compiled so far and is computed as ever, in words: "born: OmniCam, AhmPnt"."""
    mine = [(at[0], *found) for at, found in programs.known.items() if at[0].__module__ == __name__]
    missing = [(write, models) for write, models, made in mine if made is None]
    words = lambda models: ", ".join(type(model).__name__ for model in models if not isinstance(model, type))
    return sorted({f"{write.__name__.removeprefix('_write_')}: {words(models)}" for write, models in missing})


# --- motion ----------------------------------------------------------------------------------------------------------


def move(map, r, motion, u, U, dt):
    """`motion.move` and `predict`; a heading is wrapped before and after that. Returns True if done."""
    run = program(_write_move, motion)
    if run is None or r.stop - r.start != motion.size or not isinstance(spot := map.spots(r)[0], slice):
        return False
    x, (_, P, n, lower) = map.means[r], map.storage
    run(x, P, n, lower, spot.start, floats(u), floats(U), float(dt))
    map.set_mean(r, x)
    return True


def _write_move(motion):
    tape, found = trace_move(motion)
    m, size = found["X_u"].shape[1], motion.size
    outputs = ("x2[{}]", found["x2"]), ("X_x[{}, {}]", found["X_x"]), ("X_u[{}, {}]", found["X_u"])
    plane = motion.frame.dim == 2
    lines = [
        *["x[2] = heading(x[2])"] * plane,
        f"x2, X_x, X_u = np.empty({size}), np.empty(({size}, {size})), np.empty(({size}, {m}))",
        f"Q = np.empty(({size}, {size}))",
        *straight_code(tape, outputs)[0],
        "sandwich(X_u, U, Q)",
        "propagate(P, n, lower, r, X_x, Q)",
        "x[:] = x2",
        *["x[2] = heading(x[2])"] * plane,
    ]
    return build("void(f8[::1], f8[::1, :], i8, b1, i8, f8[::1], f8[:, ::1], f8)", "x, P, n, lower, r, u, U, dt", lines)


def normalized(map, r, frame):
    """`transform` of the orientation of the frame that begins at r to its normal form. Returns True if done."""
    run = program(_write_normalized, frame)
    if run is None or not isinstance(spot := map.spots(r)[0], slice):
        return False
    x, (_, P, n, lower) = map.state(r), map.storage
    run(x, P, n, lower, spot.start)
    map.set_mean(r, x)
    return True


def _write_normalized(frame):
    tape, found = trace_orientation(frame)
    o = frame.size - frame.dim
    outputs = ("o[{}]", found["o"]), ("J[{}, {}]", found["J"])
    lines = [
        f"o, J, Q = np.empty({o}), np.empty(({o}, {o})), np.zeros(({o}, {o}))",
        *straight_code(tape, outputs)[0],
        f"propagate(P, n, lower, r + {frame.dim}, J, Q)",
        f"x[{frame.dim} : {frame.size}] = o",
    ]
    return build("void(f8[::1], f8[::1, :], i8, b1, i8)", "x, P, n, lower, r", lines)


# --- corrections -----------------------------------------------------------------------------------------------------


def expected(map, Rf, Sf, sensor, kind, l, r, s, indices, every):
    """`expect`, what is visible, and the covariance of each: `covariance`.

    Parameters
    ----------
    Rf, Sf, sensor, kind, l
        As in `expect`, l of shape (K, k).
    r, s : slice or None
        Ranges of both frames in the map.
    indices : ndarray of int, shape (K, k), or None
        Where the landmarks are in the map.
    every : bool
        Compute E of all of them, not of the visible ones only.

    Returns
    -------
    e, v, visible, J, E : ndarray, shape (K, m), (K, d), (K,), (K, m, ·) and (K, m, m), or None
        J is [E_r E_s E_l], shape (K, m, ·); E is NaN where it was not computed, and None for a compressed map.
    """
    found = program(_write_expected, type(Rf), sensor, kind)
    if found is None or type(Sf) is not type(Rf) or l.shape[-1] != kind.size:
        return None
    run, m, d, size = found
    K, l, known = len(l), np.ascontiguousarray(l, float), indices is None
    e, v, visible = np.empty((K, m)), np.empty((K, d)), np.empty(K, bool)
    J, E = np.empty((K, m, size)), np.empty((K, m, m))
    _, P, n, lower = map.storage
    if not map.all_active:
        run(Rf.x, Sf.x, l, P, lower, -1, -1, NO_INDICES, True, False, e, v, visible, J, E)
        return e, v, visible, J, None
    indices = NO_INDICES if known else indices
    run(Rf.x, Sf.x, l, P, lower, start_of(r), start_of(s), indices, known, every, e, v, visible, J, E)
    return e, v, visible, J, E


def _write_expected(frame, sensor, kind):
    lines, (m, d, size) = _expectations(frame, sensor, kind, "every or visible[k]")
    signature = (
        "void(f8[::1], f8[::1], f8[:, ::1], f8[::1, :], b1, i8, i8, i8[:, ::1], b1, b1, "
        "f8[:, ::1], f8[:, ::1], b1[::1], f8[:, :, ::1], f8[:, :, ::1])"
    )
    arguments = "rf, sf, l, P, lower, r, s, indices, known, every, e, v, visible, J, E"
    return build(signature, arguments, lines), m, d, size


def _expectations(frame, sensor, kind, wanted):
    """Lines that write e, v, visible, J of landmarks l, and E of those that are wanted; and their sizes m, d, J's."""
    tape, found = trace_expectation(frame, sensor, kind)
    n_f, n_l, m, d, size = frame.size, kind.size, *found["e"].shape, *found["v"].shape, found["J"].shape[1]
    places = {"e": "e[k, {}]", "v": "v[k, {}]", "visible": "visible[k]", "J": "J[k, {}, {}]"}
    outputs = [(place, found[name]) for name, place in places.items()]
    before, loop = straight_code(tape, outputs, each="[k")
    finite = " + ".join(f"J[k, {a}, {2 * n_f + c}]" for a, c in np.ndindex(m, n_l))
    loop += [
        f"visible[k] = visible[k] and isfinite({finite})",
        f"if {wanted}:",
        f"    covariance_of(P, lower, J, cols, at, indices, k, {2 * n_f}, E[k])",
        "elif len(E) > 0:",
        "    E[k] = np.nan",
    ]
    lines = [f"cols, at = columns_of(r, s, {n_f}, {n_f}, {n_l}, known)", *before]
    return [*lines, "for k in range(len(l)):", *(f"    {line}" for line in loop)], (m, d, size)


ROOM = 32  # landmarks in view, at first
NO_E = np.zeros((0, 0, 0))


def expected_in_view(map, Rf, Sf, sensor, kind, indices, r, s):
    """`expected` of those that `may_be_seen`, of many that are in the map: a quick look at all, most are elsewhere.

    The means of far states are taken as they were last settled, and settled if one of them may be in range.

    Parameters
    ----------
    Rf, Sf, sensor, kind, r, s
        As in `expected`.
    indices : ndarray of int, shape (N, k)
        Where the landmarks are in the map.

    Returns
    -------
    some, indices : ndarray of int, shape (K,) and (K, k)
        Which of them may be seen, and where those are in the map.
    e, v, visible, J, E : ndarray, or None
        Of these, as `expected` has them; E of the visible ones. None instead of all if it cannot be.
    """
    found = program(_write_expected_in_view, type(Rf), sensor, kind)
    if found is None or type(Sf) is not type(Rf) or indices.shape[-1] != kind.size:
        return None
    run, by_range, (m, d, size) = found
    _, P, _, lower = map.storage
    some, room, settled, whole = np.empty(len(indices), np.int64), ROOM, not by_range, map.all_active
    r, s = (start_of(r), start_of(s)) if whole else (-1, -1)
    while True:
        e, v, visible = np.empty((room, m)), np.empty((room, d)), np.empty(room, bool)
        E = np.empty((room, m, m)) if whole else NO_E
        J, at = np.empty((room, m, size)), np.empty((room, kind.size), np.int64)
        K = run(Rf.x, Sf.x, *map.roughly(settled), indices, P, lower, r, s, some, at, e, v, visible, J, E)
        if 0 <= K <= room:
            return some[:K], at[:K], e[:K], v[:K], visible[:K], J[:K], E[:K] if whole else None
        room, settled = max(room, K), settled or K < 0


def _write_expected_in_view(frame, sensor, kind):
    """A program that says how many may be seen, -1 if it takes a mean that is not exact to say so.

    If that is more than there is room for, it does no more. And whether it can tell from means that are not exact: they
    tell what is out of range.
    """
    tape, by_range = Tape(), kind == EUCLIDEAN[frame.dim] and getattr(sensor, "max_range", inf) < inf
    Rf, Sf = frame(tape.inputs("rf[{}]", frame.size)), frame(tape.inputs("sf[{}]", frame.size))
    l, std = (tape.inputs(f"{name}[every[k, {{}}]]", kind.size) for name in ("x", "std"))
    off = tape.inputs("norm", 1)[0] * std.sum()
    seen = may_be_seen(Rf, Sf, sensor, kind, l[None], off if by_range else 0.0)
    before, loop = straight_code(tape, [("seen", np.asarray(seen)[0]), ("off", off)], each="[k")
    loop += ["if seen:", "    if off > 0:", "        return -1", "    some[K] = k", "    K += 1"]
    then, sizes = _expectations(frame, sensor, kind, "len(E) > 0 and visible[k]")
    lines = ["K, norm = 0, 0.0", "for step in moved:", "    norm += step * step", "norm = math.sqrt(norm)", *before]
    lines += [
        "for k in range(len(every)):",
        *(f"    {line}" for line in loop),
        "if K > len(e):",
        "    return K",
        f"l, known = np.empty((K, {kind.size})), False",
        "for k in range(K):",
        f"    for c in range({kind.size}):",
        "        indices[k, c] = every[some[k], c]",
        "        l[k, c] = x[indices[k, c]]",
        *then,
        "return K",
    ]
    signature = (
        "i8(f8[::1], f8[::1], f8[::1], f8[::1], f8[::1], i8[:, ::1], f8[::1, :], b1, i8, i8, "
        "i8[::1], i8[:, ::1], f8[:, ::1], f8[:, ::1], b1[::1], f8[:, :, ::1], f8[:, :, ::1])"
    )
    arguments = "rf, sf, x, std, moved, every, P, lower, r, s, some, indices, e, v, visible, J, E"
    return build(signature, arguments, lines), by_range, sizes


def correct_found(map, sensor, ranges, n, J, e, E, no_E, found, index, y, R, threshold):
    """Innovations of those found, the gate, and `update` by those that pass, all at once. None if that cannot be.

    Parameters
    ----------
    map, n, J
        As in `correct_some`; n are the numbers of a frame.
    sensor : SensorModel
    ranges : tuple (slice or None, slice or None, ndarray of int of shape (K, k) or None)
        Where the states are in the map that the columns of J belong to.
    e, E : ndarray, shape (K, m) and (K, m, m)
        Expectations and their covariances.
    no_E : list of int, or None
        Of these E is not there yet: it is computed, too; for all others it becomes NaN.
    found, index : list of int, shape (k,)
        Which of the K, and which measurement each of them has.
    y : ndarray, shape (·, m)
        All measurements.
    R : ndarray, shape (m, m), or (k, m, m)
    threshold : float
        Of the squared Mahalanobis distance.

    Returns
    -------
    z : ndarray, shape (k, m)
    passed : list of int
        Those of the found that pass.
    """
    run, m, indices = program(_write_correction, sensor), e.shape[1], ranges[2]
    if run is None or len(found) * m > MANY_ROWS:
        return None
    z, R, at, of = np.empty((len(found), m)), noises(R), integers(found), integers(index)
    if R.shape[1:] != (m, m) or len(R) not in (1, len(z)):
        return None
    indices, no_E = NO_INDICES if indices is None else indices, at if no_E == found else integers(no_E or ())
    q = FAR
    while q == FAR:
        r, s, _ = map.spots(*ranges[:2])
        if not isinstance(r, RANGE) or not isinstance(s, RANGE):
            return None
        map.keep_one_triangle()
        rest = n, J, e, E, no_E, at, of, y, R, threshold, z
        q = run(*map.storage, start_of(r), start_of(s), indices, *map.bookkeeping, *rest)
        if q == FAR:
            map.spots(*ranges, at if len(no_E) == 0 else no_E)
    if q < 0:
        return None  # numpy says what is wrong
    map.relieve(followed=True)
    return z, found if q == len(found) else at[:q].tolist()


FAR = -2


def _write_correction(sensor):
    """A program that says how many pass the gate, -1 where `gated` does, `FAR` if a landmark is not active."""
    tape, m = Tape(), len(sensor.R)
    z = sensor.residual(tape.inputs("y[i, {}]", m)[None], tape.inputs("e[k, {}]", m)[None])
    _, loop = straight_code(tape, [("z[q, {}]", z[0])], each="[")
    lines = [
        "indices = every",
        "if len(spot_of) > 0:",
        "    indices = np.empty(every.shape, np.int64)",
        "    if not near(spot_of, last_use, now, every, no_E if len(no_E) > 0 else found, indices):",
        f"        return {FAR}",
        "if len(no_E) > 0:",
        "    E[:] = np.nan",
        "    if isfinite(threshold) or len(no_E) > len(found):",  # if not, E comes with the correction
        "        covariances(P, lower, r, s, indices, n_f, n_f, J, no_E, E)",
        "for q in range(len(found)):",
        "    k, i = found[q], of[q]",
        *(f"    {line}" for line in loop),
        "q = gated(x, P, n, lower, r, s, indices, n_f, J, E, found, z, R, threshold)",
        "if q >= 0 and len(spot_of) > 0:",
        "    follow(means, x[:n], state_at)",
        "return q",
    ]
    signature = (
        "i8(f8[::1], f8[::1, :], i8, b1, i8, i8, i8[:, ::1], i8[::1], i8[::1], i8, f8[::1], i8[::1], "
        "i8, f8[:, :, ::1], f8[:, ::1], f8[:, :, ::1], "
        "i8[::1], i8[::1], i8[::1], f8[:, ::1], f8[:, :, ::1], f8, f8[:, ::1])"
    )
    arguments = "x, P, n, lower, r, s, every, spot_of, last_use, now, means, state_at"
    return build(signature, f"{arguments}, n_f, J, e, E, no_E, found, of, y, R, threshold, z", lines)


# --- new landmarks ---------------------------------------------------------------------------------------------------


def born(map, rob, sen, x, kind, y, n, R, N):
    """`retro_project` and `augment`: the range of a new landmark in the map, False if what was measured is out of view.

    x has the states of both, None for one that is in the map. y, n, R, N are arrays of float. None if it could not be
    started, for one if the map is full.
    """
    found = program(_write_born, rob.motion.frame, sen.model, kind)
    if found is None or sen.frame_type is not rob.motion.frame:
        return None
    run, size, shapes = found
    size_f = rob.motion.frame.size
    if (y.shape, n.shape, R.shape, N.shape) != shapes:
        return None
    r, s, _ = map.spots(rob.r, sen.r)
    if not isinstance(r, RANGE) or not isinstance(s, RANGE):
        return None
    x_r, x_s = x
    x_r, x_s = map.means[rob.r] if x_r is None else floats(x_r), map.means[sen.r] if x_s is None else floats(x_s)
    if len(x_r) < size_f or len(x_s) < size_f:
        return None
    try:
        at = map.free(size)
    except MapFull:
        return None
    _, P, n_states, lower = map.storage
    where = P, n_states, lower, start_of(r), start_of(s), at.start
    done = run(x_r, x_s, floats(y), n, floats(R), N, *where, *map.ledger(at))
    if done == BORN:
        return map.take(at)
    return False if done == OUT_OF_VIEW else None  # numpy says what is wrong


OUT_OF_VIEW, BORN = 1, 2


def _write_born(frame, sensor, kind):
    tape, found = trace_birth(frame, sensor, kind, look=True)
    n_f, n_l, m, n_n = frame.size, kind.size, found["L_y"].shape[1], found["L_n"].shape[1]
    ledger = "state, now, x, used, spot_used, start_of, refers, spot_of, last_use, std, state_at"
    places = {"l": "l[{}]", "L": "L[{}, {}]", "L_y": "L_y[{}, {}]", "L_n": "L_n[{}, {}]"}
    outputs = [("seen", found["seen"]), *((place, found[name]) for name, place in places.items())]
    lines = [
        f"l, L, Q_n = np.empty({n_l}), np.empty(({n_l}, {2 * n_f})), np.empty(({n_l}, {n_l}))",
        f"L_y, L_n = np.empty(({n_l}, {m})), np.empty(({n_l}, {n_n}))",
        f"P_lm, P_ll = np.empty(({n_l}, n_states)), np.empty(({n_l}, {n_l}))",
        *straight_code(tape, outputs)[0],
        "if not seen:",
        f"    return {OUT_OF_VIEW}",
        "sandwich(L_y, R, P_ll)",
        "sandwich(L_n, N, Q_n)",
        "P_ll += Q_n",
        f"if not join(P, n_states, lower, r, s, {n_f}, {n_f}, L, P_lm, P_ll) or not isfinite(np.sum(l)):",
        "    return 0",
        "put(P, n_states, lower, at, P_lm, P_ll)",
        f"own(l, at, {ledger})",
        f"return {BORN}",
    ]
    signature = (
        "i8(f8[::1], f8[::1], f8[::1], f8[::1], f8[:, ::1], f8[:, ::1], f8[::1, :], i8, b1, i8, i8, i8, "
        "i8, i8, f8[::1], b1[::1], b1[::1], i8[::1], f8[::1], i8[::1], i8[::1], f8[::1], i8[::1])"
    )
    arguments = f"rf, sf, y, n, R, N, P, n_states, lower, r, s, at, {ledger}"
    return build(signature, arguments, lines), n_l, ((m,), (n_n,), (m, m), (n_n, n_n))
