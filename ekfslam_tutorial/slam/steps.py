"""The steps of EKF-SLAM (manual, section 4.2): move, correct known landmarks, initialise new ones.

For every frame, every robot moves; then each of its sensors corrects with the landmarks that it knows and starts the
ones that it does not. The order matters: a measurement that starts a landmark has been used, and must not correct it.
"""

from math import isfinite
from operator import attrgetter

import numpy as np

from ..ekf import MapFull, augment, correct, covariance, cross, innovation, predict
from ..ekf.extra import compiled
from ..ekf.stochastic_map import are_covariances, check_covariance
from ..models.observation import observe, retro_project
from .first_estimates import begin, check_first_estimates, transport
from .joint import correct_jointly, correct_with
from .objects import Event, Lmk
from .projection import frame_range, normal_frame, normalize, project_lmks
from .upkeep import EUCLIDEAN, delete_bad, most_uncertain, tidy

# --- motion ----------------------------------------------------------------------------------------------------------


def move(map, rob, dt):
    """Motion of a robot by its control `rob.u` with covariance `rob.U` (manual: `motion`).

    Parameters
    ----------
    map : Map
    rob : Rob
        With a known state (r is None) only the state moves: the control is taken as true.
    dt : float
        Duration of the step, s.

    Raises
    ------
    ValueError
        If the control or its covariance is not finite or has the wrong shape.
    """
    _check_control(rob, dt)
    normal_frame(map, rob)
    if map.compiled and rob.r is not None and rob.first is None:
        if compiled().move(map, rob.r, rob.motion, rob.u, rob.U, dt):
            normalize(map, rob)
            return
    before = rob.state(map)
    x, X_x, X_u = rob.motion.move(before, rob.u, dt)
    if rob.r is None:
        rob.x = np.concatenate(
            [rob.motion.frame(x[: rob.motion.frame.size]).normalized()[0].x, x[rob.motion.frame.size :]]
        )
    else:
        predict(map, rob.r, x, X_x if rob.first is None else X_x @ transport(rob.first, before), X_u, rob.U)
        normalize(map, rob)
    if rob.first is not None:
        rob.first = rob.state(map)


def _check_control(rob, dt):
    m, u = sum(rob.motion.control_fields.values()), np.asarray(rob.u)
    if u.shape != (m,) or not (isfinite(sum(u.tolist())) or np.isfinite(u).all()):
        fields = ", ".join(rob.motion.control_fields).replace("_deg", "")
        raise ValueError(f"robot {rob.id}: the control must be {m} finite numbers [{fields}], got {rob.u}")
    if not 0 <= dt < np.inf:
        raise ValueError(f"robot {rob.id}: the duration of a step must be a number of seconds, got {dt}")
    if rob.r is not None:
        U = np.asarray(rob.U, float)
        if U.shape != (m, m) or U.tobytes() != rob.checked_U:
            check_covariance(U, m, f"robot {rob.id}: the control covariance")
            rob.checked_U = U.tobytes()


# --- corrections -----------------------------------------------------------------------------------------------------


def correct_known_lmks(map, rob, sen, lmks, obs, raw, opt):
    """Correct the map with the landmarks that are in it (manual: `correctKnownLmks`).

    Active search: all landmarks are projected in one call; the visible ones are matched; those with the most uncertain
    expectation come first, at most `opt.n_updates` of them; each is projected again from the map as corrected so far.

    Parameters
    ----------
    map : Map
    rob : Rob
    sen : Sen
    lmks : dict of int to Lmk
        Landmarks may be reparametrised, and deleted.
    obs : dict of (int, int) to Obs
        Gets this sensor's observations of this frame, by (sensor id, landmark id).
    raw : raw measurements: `ids` (k,), `y` (k, m), `R` (k, m, m) or None
    opt : Options

    Returns
    -------
    events : list of Event
    new : list of int
        Indices of the raw measurements that may start landmarks.

    Raises
    ------
    ValueError
        If a measurement is not finite or has the wrong shape.
    """
    _check_raw(raw, sen)
    Rf, Sf = normal_frame(map, rob), normal_frame(map, sen)
    if opt.first_estimates:
        begin(map, rob, lmks)
    for key in [key for key in obs if key[0] == sen.id]:
        del obs[key]
    if opt.joint:
        return correct_jointly(map, rob, sen, lmks, obs, raw, opt, Rf, Sf)
    expected = project_lmks(map, rob, sen, sorted(lmks.values(), key=attrgetter("slot")))
    obs.update({(sen.id, o.lmk): o for o in expected})
    seen = [o for o in expected if o.visible]
    matches = opt.association(map, expected, raw, sen.model)

    events, stale = [], False
    for o in most_uncertain(seen, opt.n_updates):
        events += _search(map, rob, sen, lmks[o.lmk], o, matches.pairs.get(o.lmk), raw, opt, stale)
        stale = stale or o.updated
    events += delete_bad(map, rob, sen, lmks, seen, opt)
    return events, matches.new


def _search(map, rob, sen, lmk, o, index, raw, opt, stale):
    """Look for one landmark: match, project again if its expectation is stale, gate, correct. Returns the events."""
    table, k, found = o.table, o.k, index is not None
    lmk.n_search += 1
    table.measured[k], table.matched[k], table.index[k] = True, found, index
    events = [Event("search", rob.id, sen.id, lmk.id, found)]
    if not found:
        return events

    lmk.n_match += 1
    Rf, Sf, PHt = rob.normal, sen.normal, None
    if opt.reproject and stale:
        _project_again(map, rob, sen, lmk, o, Rf, Sf)
    if not table.has_E or (stale and not opt.reproject):  # E is not there, or not that of now
        PHt = cross(map, o.blocks)
        table.E[k] = covariance(PHt, o.blocks)
    y, R = raw.y[index], sen.model.R if raw.R is None else raw.R[index]
    inn = innovation(sen.model.residual(y, table.e[k]), table.E[k], R)
    table.y[k], table.R[k], table.z[k] = y, R, inn.z
    accepted = inn.md2 < opt.md2_threshold
    events.append(Event("innovation", rob.id, sen.id, lmk.id, accepted))
    if not accepted:
        return events

    lmk.n_inlier += 1
    camera = Rf.R.dot(Sf.t) + Rf.t if opt.reparametrize else None
    if PHt is None:
        correct_with(map, table, [k], inn.z[None], R)
    else:
        correct(map, PHt, inn)
    table.updated[k] = True
    normalize(map, rob)
    if sen.r is not None:
        normalize(map, sen)
    tidy(map, lmk, camera, opt)
    events.append(Event("correction", rob.id, sen.id, lmk.id))
    return events


def _project_again(map, rob, sen, lmk, o, Rf, Sf):
    """The expectation of a landmark from the map as corrected so far."""
    table, k = o.table, o.k
    if table.J is not None:
        size, l = lmk.type.size, lmk.state(map)[None]
        rows = None if lmk.r is None else table.ranges[2][k : k + 1, :size].copy()
        e, _, _, J, E = compiled().expected(map, Rf, Sf, sen.model, lmk.type, l, *table.ranges[:2], rows, True)
        n = J.shape[-1] - size
        table.e[k], table.J[k, :, :n], table.E_l[k, :, :size] = e[0], J[0, :, :n], J[0, :, n:]
        if lmk.r is not None:
            table.H_l[k, :, :size] = J[0, :, n:]
        if E is not None:
            table.E[k] = E[0]
        return
    e, E_r, E_s, E_l = observe(Rf, Sf, sen.model, lmk.type, lmk.state(map))
    table.e[k] = e
    if rob.first is None:
        o.blocks = (frame_range(rob, Rf), E_r), (sen.r, E_s), (lmk.r, E_l)


def _check_raw(raw, sen):
    m, ids, y = len(sen.model.R), np.asarray(raw.ids), np.asarray(raw.y)
    if ids.ndim != 1:
        raise ValueError(f"sensor {sen.id}: ids must be a list of integers, got shape {ids.shape}")
    if ids.size and ids.dtype.kind not in "iu":
        raise ValueError(f"sensor {sen.id}: ids must be integers, got {ids.tolist()}")
    if raw.R is not None and np.shape(raw.R) != (len(ids), m, m):
        raise ValueError(
            f"sensor {sen.id}: noise covariances must have shape {(len(ids), m, m)}, got {np.shape(raw.R)}"
        )
    if raw.R is not None and not are_covariances(np.asarray(raw.R, float)):
        for id, R in zip(ids, raw.R, strict=True):
            check_covariance(R, m, f"sensor {sen.id}: the noise covariance of landmark {id}")
    if y.shape != (len(ids), m):
        raise ValueError(
            f"sensor {sen.id}: measurements must have shape {(len(ids), m)}, one row per id, got {y.shape}"
        )
    if not isfinite(np.vdot(y, y)) and not np.isfinite(y).all():
        bad = int(np.flatnonzero(~np.isfinite(y).all(-1))[0])
        raise ValueError(
            f"sensor {sen.id}: measurement {bad} of landmark {int(ids[bad])} must be finite, got {y[bad].tolist()}"
        )


# --- new landmarks ---------------------------------------------------------------------------------------------------


def init_new_lmks(map, rob, sen, lmks, raw, new, opt, n_max=None):
    """Start landmarks from measurements that belong to none (manual: `initNewLmk`).

    Parameters
    ----------
    map, rob, sen, lmks, raw, opt
        As in `correct_known_lmks`.
    new : list of int
        Indices of the measurements that may start a landmark, from `correct_known_lmks`.
    n_max : int, optional
        Most landmarks to start.

    Returns
    -------
    list of Event
        initialisation, or refused where the map had no room: the run can go on.
    """
    events = []
    for i in new:
        if n_max is not None and len(events) >= n_max:
            break
        id, y = opt.association.birth_id(raw, i, lmks), np.asarray(raw.y[i], float)
        if id is None or not _well_inside(map, sen.model, y, opt.init_margin):
            continue
        try:
            lmk = add_landmark(map, rob, sen, lmks, id, y, None if raw.R is None else raw.R[i], opt)
        except MapFull:
            events.append(Event("refused", rob.id, sen.id, id))
            continue
        lmks[id] = lmk
        events.append(Event("initialisation", rob.id, sen.id, id))
    return events


NOTHING = np.zeros(0), np.zeros((0, 0))
"""The prior of what is measured completely."""


def add_landmark(map, rob, sen, lmks, id, y, R, opt):
    """One new landmark in the map, from one measurement: the inverse observation model and `augment`.

    Returns
    -------
    Lmk
        Not yet in `lmks`.

    Raises
    ------
    MapFull
        If there is no room for it.
    TypeError
        If the landmark type cannot be started by this sensor.
    """
    if opt.max_lmks is not None and len(lmks) >= opt.max_lmks:
        raise MapFull(f"the map is full: it has {len(lmks)} landmarks, the most that max_lmks allows")
    kind = sen.lmk_type or opt.lmk_type or EUCLIDEAN[sen.frame_type.dim]
    Rf, Sf = rob.frame(map), sen.frame(map)
    n, N = (opt.n, opt.N) if sen.model.bearing_only else NOTHING
    R = sen.model.R if R is None else R

    if map.compiled and rob.first is None and not opt.first_estimates:
        r = compiled().born(map, Rf, Sf, sen.model, kind, y, n, R, N, rob.r, sen.r)
        if r is not None:
            return _in_a_slot(sen, lmks, Lmk(id, kind, r=r, n=n, N=N))
    l, L_r, L_s, L_y, L_n = retro_project(Rf, Sf, sen.model, kind, y, n)
    if opt.first_estimates:
        check_first_estimates(rob.motion.frame, [kind])
        L_r = L_r if rob.first is None else L_r @ transport(rob.first, Rf.x)
    blocks = (frame_range(rob, Rf), L_r), (sen.r, L_s)
    r = augment(map, l, blocks, L_y.dot(R).dot(L_y.T) + L_n.dot(N).dot(L_n.T))
    return _in_a_slot(sen, lmks, Lmk(id, kind, r=r, n=n, N=N, first=l if opt.first_estimates else None))


def _in_a_slot(sen, lmks, lmk):
    """Give a new landmark the first slot that is free."""
    n, last = len(lmks), next(reversed(lmks.values()), None)
    if last is not None and (last, Lmk.births) == sen.gapless and last.slot == n - 1:  # none has come or gone since
        lmk.slot = n
    else:
        lmk.slot = _free_slot(lmks.values())
    Lmk.births += 1
    sen.gapless = (lmk, Lmk.births) if lmk.slot == n else None
    return lmk


def _free_slot(lmks):
    """The first index that no landmark has."""
    slots = {lmk.slot for lmk in lmks}
    return next(i for i in range(len(slots) + 1) if i not in slots)


def _well_inside(map, sensor, y, margin):
    """Whether a measurement would still be visible if each of its numbers were off by the margin.

    The margin is in the unit of the first number, pixels for a camera; a depth in metres is left alone.
    """
    if map.compiled and not margin and (inside := compiled().inside(sensor, y)) is not None:
        return inside
    if margin:
        units = getattr(sensor, "units", None) or ("",) * len(y)
        off = margin * np.diag([float(unit == units[0]) for unit in units])
        y = np.concatenate([y[None], y + off, y - off])
    return bool(np.all(sensor.visible(y, sensor.retro(y)[0])))
