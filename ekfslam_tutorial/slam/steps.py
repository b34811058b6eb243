"""The steps of EKF-SLAM (manual, section 4.2): move, correct known landmarks, initialise new ones.

For every frame, every robot moves; then each of its sensors corrects with the landmarks that it knows and starts the
ones that it does not. The order matters: a measurement that starts a landmark has been used, and must not correct it.
"""

from operator import attrgetter

import numpy as np
import scipy  # which loads scipy.linalg at its first use

from ..ekf import Map, MapFull, augment, check_covariance, covariance, cross, innovation, predict, real
from ..models.observation import observe, retro_project
from .first_estimates import check_first_estimates, note_first_estimates, transport
from .objects import Event, Lmk
from .projection import correct_invariant, frame_range, normalize, project_lmks
from .upkeep import EUCLIDEAN, delete_bad, free_slot, most_uncertain, tidy, tidy_line, well_inside


def new_map(capacity=None):
    """An empty map for these steps, with room for so many numbers; without a capacity it grows as needed."""
    return Map(capacity)


# --- motion ----------------------------------------------------------------------------------------------------------


def move(map, rob, dt):
    """Motion of a robot by its control `rob.u` with covariance `rob.U` (manual: `motion`).

    Parameters
    ----------
    map : Map
    rob : Rob
        With a known state (r is None) only the state moves: the control is taken as true.
    dt : float, or ndarray of shape (k,)
        Duration of the step, s; or of each of k controls, one after the other, `rob.u` (k, nu) and `rob.U` (k, nu, nu).

    Raises
    ------
    ValueError
        If the control or its covariance is not finite or has the wrong shape.
    """
    check_control(rob, dt)
    normalize(map, rob)
    before = rob.state(map)
    x, X_x, X_u, U = travel(rob.motion.move, before, np.asarray(rob.u, float), rob.U, dt)
    if rob.r is None:
        n = rob.motion.frame.size
        rob.x = np.concatenate([rob.motion.frame(x[:n]).normalized()[0].x, x[n:]])
    else:
        if rob.first is not None:
            X_x = X_x @ transport(rob.first, before)
        predict(map, rob.r, x, X_x, X_u, np.asarray(U, float))
        normalize(map, rob)
    if rob.first is not None:
        rob.first = rob.state(map)


def travel(move, x, u, U, dt):
    """One control, or k of them one after the other, which together are one motion.

        x = f(x, u_i),    X = X_x X,    Q = X_x Q X_x' + X_u U_i X_u'

    Parameters
    ----------
    move : callable
        Of a motion model.
    x : ndarray, shape (n,)
    u, U, dt : (nu,), (nu, nu) and float; or (k, nu), (k, nu, nu) and (k,)
        U is not used where it is None.

    Returns
    -------
    x2, X_x, X_u, U
        As `predict` takes them; of k controls X_u = I and U = Q.
    """
    if np.ndim(u) == 1:
        return *move(x, u, dt), U
    X, Q = np.eye(len(x)), np.zeros((len(x), len(x)))
    for i, u_i in enumerate(u):
        x, X_x, X_u = move(x, u_i, float(dt[i]))
        X = X_x @ X
        if U is not None:
            Q = X_x @ Q @ X_x.T + X_u @ U[i] @ X_u.T
    return x, X, np.eye(len(x)), Q


# --- corrections -----------------------------------------------------------------------------------------------------


def correct_known_lmks(map, rob, sen, lmks, obs, raw, opt):
    """Correct the map with the landmarks that are in it (manual: `correctKnownLmks`).

    Active search: all landmarks are projected; the visible ones are matched; those with the most uncertain
    expectation come first, at most `opt.n_updates` of them. Then either each corrects the map on its own, projected
    again from the map as corrected so far, or, with `opt.joint`, all of them together, as they were projected. (Who
    comes first does not matter then: without a limit the order is that of `lmks`.)

    Parameters
    ----------
    map : Map
    rob : Rob
    sen : Sen
    lmks : dict of int to Lmk
        Landmarks may be reparametrised, and deleted.
    obs : dict of (int, int) to Obs
        Gets this sensor's observations of this frame, by (sensor id, landmark id); with `opt.joint` those of the
        visible landmarks only.
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
    check_raw(raw, sen)
    normalize(map, rob, sen)
    if opt.first_estimates:
        note_first_estimates(map, rob, lmks)
    for key in [key for key in obs if key[0] == sen.id]:
        del obs[key]

    order = lmks.values() if opt.joint else sorted(lmks.values(), key=attrgetter("slot"))  # of equally uncertain ones
    expected = project_lmks(map, rob, sen, order)
    seen = [o for o in expected if o.visible]
    obs.update({(sen.id, o.lmk): o for o in (seen if opt.joint else expected)})
    matches = opt.association(map, expected, raw, sen.model)
    wanted = seen if opt.joint and opt.n_updates is None else most_uncertain(seen, opt.n_updates)
    for o in wanted:
        match(o, matches.pairs.get(o.lmk), raw, sen)

    if opt.joint:
        _correct_jointly(map, rob, sen, lmks, [o for o in seen if o.matched], opt, matches.refused)
    else:
        _correct_one_by_one(map, rob, sen, lmks, [o for o in wanted if o.matched], opt, matches.refused)
    events = [event for o in wanted for event in _count(rob, sen, lmks[o.lmk], o)]
    return events + delete_bad(map, rob, sen, lmks, seen, opt), matches.new


def match(o, index, raw, sen):
    """Note the measurement of a landmark that is looked for, if there is one."""
    o.measured, o.matched, o.index = True, index is not None, index
    if o.matched:
        o.y, o.R = np.asarray(raw.y[index], float), sen.model.R if raw.R is None else np.asarray(raw.R[index], float)


def _correct_one_by_one(map, rob, sen, lmks, found, opt, refused):
    """Correct by each that was found: project it again if the map has been corrected since, gate, correct."""
    stale = False
    for o in found:
        if stale and opt.reproject:
            _project_again(map, rob, sen, lmks[o.lmk], o)
        if hasattr(sen.model, "innovation"):
            _to_innovation(sen.model, o)
        PHt = cross(map, o.blocks)
        o.z, o.E = sen.model.residual(o.y, o.e), covariance(PHt, o.blocks)
        inn = innovation(o.z, o.E, o.R)
        if inn.md2 < opt.md2_threshold and o.lmk not in refused:
            o.updated, stale, camera = True, True, rob.frame(map).compose(sen.frame(map))[0].t
            correct_invariant(map, rob, lmks, PHt, inn, opt)
            _after(map, rob, sen, lmks, [o], camera, opt)


def _correct_jointly(map, rob, sen, lmks, found, opt, refused):
    """Gate each that was found on its own; correct once, by all that pass: z, P H' and R side by side."""
    for o in found:
        if hasattr(sen.model, "innovation"):
            _to_innovation(sen.model, o)
        o.z = sen.model.residual(o.y, o.e)
        o.updated = innovation(o.z, o.E, o.R).md2 < opt.md2_threshold and o.lmk not in refused
    used = [o for o in found if o.updated]
    if used:
        PHt, z, R = zip(*[(cross(map, o.blocks), o.z, o.R) for o in used], strict=True)
        PHt = np.hstack(PHt)
        E = np.vstack([covariance(PHt, o.blocks) for o in used])
        camera = rob.frame(map).compose(sen.frame(map))[0].t
        correct_invariant(map, rob, lmks, PHt, innovation(np.concatenate(z), E, scipy.linalg.block_diag(*R)), opt)
        _after(map, rob, sen, lmks, used, camera, opt)


def _to_innovation(sensor, o):
    """Carry an observation to a sensor's own innovation z(y, e), where that is not y - e: its blocks, E and R."""
    _, Z_y, Z_e = sensor.innovation(o.y, o.e)
    o.blocks = tuple((r, -Z_e @ E) for r, E in o.blocks)
    o.E, o.R = Z_e @ o.E @ Z_e.T, Z_y @ o.R @ Z_y.T


def _after(map, rob, sen, lmks, used, camera, opt):
    """Bring frames, and the landmarks that have corrected the map, to their normal form; `camera` saw them."""
    normalize(map, rob, sen)
    for o in used:
        tidy(map, lmks[o.lmk], camera, opt)
        if lmks[o.lmk].par is not None:
            tidy_line(map, rob, sen, lmks[o.lmk], o.y, opt)


def _project_again(map, rob, sen, lmk, o):
    """Expectation of a landmark from the map as corrected so far; first estimates keep their Jacobians."""
    Rf, Sf = getattr(rob, getattr(sen.model, "asks_robot", "frame"))(map), sen.frame(map)
    o.e, E_r, E_s, E_l = observe(Rf, Sf, sen.model, lmk.type, lmk.state(map))
    if rob.first is None:
        o.blocks = (frame_range(rob, Rf), E_r), (sen.r, E_s), (lmk.r, E_l)


def _count(rob, sen, lmk, o):
    """Count what has happened to a landmark that was looked for. Returns it as events."""
    lmk.n_search, lmk.n_match, lmk.n_inlier = lmk.n_search + 1, lmk.n_match + o.matched, lmk.n_inlier + o.updated
    done = [("search", o.matched)] + [("innovation", o.updated)] * o.matched + [("correction", True)] * o.updated
    return [Event(kind, rob.id, sen.id, lmk.id, flag) for kind, flag in done]


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
        if id is None or not well_inside(sen.model, y, opt.init_margin):
            continue
        try:
            lmks[id] = add_landmark(map, rob, sen, lmks, id, y, None if raw.R is None else raw.R[i], opt)
            events.append(Event("initialisation", rob.id, sen.id, id))
        except MapFull:
            events.append(Event("refused", rob.id, sen.id, id))
    return events


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
    Rf, Sf = getattr(rob, getattr(sen.model, "asks_robot", "frame"))(map), sen.frame(map)
    R = sen.model.R if R is None else np.asarray(R, float)
    n, N = opt.prior(kind) if sen.model.bearing_only else (np.zeros(0), np.zeros((0, 0)))

    l, L_r, L_s, L_y, L_n = retro_project(Rf, Sf, sen.model, kind, y, n)
    if opt.first_estimates:
        check_first_estimates(rob.motion.frame, [kind])
        L_r = L_r if rob.first is None else L_r @ transport(rob.first, Rf.x)
    blocks = (frame_range(rob, Rf), L_r), (sen.r, L_s)
    r = augment(map, l, blocks, L_y @ R @ L_y.T + L_n @ N @ L_n.T)
    lmk = Lmk(id, kind, r=r, slot=free_slot(lmks.values()), n=n, N=N, first=l if opt.first_estimates else None)
    if hasattr(kind, "normal"):
        tidy_line(map, rob, sen, lmk, y, opt)
    return lmk


# --- what is refused, before anything has been changed --------------------------------------------------------------


def check_control(rob, dt):
    """Refuse a control, a control covariance or a duration that no robot can move by.

    Parameters
    ----------
    rob : Rob
    dt : float, or ndarray of shape (k,) for k controls

    Raises
    ------
    ValueError
    """
    m, u = sum(rob.motion.control_fields.values()), real(f"robot {rob.id}: the control", rob.u)
    many = u.shape[:-1] if u.ndim == 2 else ()  # controls one after the other
    if u.shape != (*many, m) or not np.isfinite(u).all():
        fields = ", ".join(rob.motion.control_fields).replace("_deg", "")
        raise ValueError(f"robot {rob.id}: the control must be {m} finite numbers [{fields}], got {rob.u}")
    h = real(f"robot {rob.id}: the duration of a step", dt)
    if h.shape != many or not (np.all(h >= 0) and np.all(h < np.inf)):
        each = f", one for each of {many[0]} controls" if many else ""
        raise ValueError(f"robot {rob.id}: the duration of a step must be a number of seconds{each}, got {dt}")
    if rob.r is not None:
        what = f"robot {rob.id}: the control covariance"
        if many and np.shape(rob.U) != (*many, m, m):
            raise ValueError(f"{what} of {many[0]} controls must have the shape {(*many, m, m)}, got {np.shape(rob.U)}")
        for U in rob.U if many else [rob.U]:
            check_covariance(U, m, what)


def check_raw(raw, sen):
    """Refuse raw measurements that are none of this sensor.

    Parameters
    ----------
    raw : raw measurements: `ids` (k,), `y` (k, m), `R` (k, m, m) or None
    sen : Sen

    Raises
    ------
    ValueError
    """
    m, ids, y = len(sen.model.R), np.asarray(raw.ids), np.asarray(raw.y)
    if ids.ndim != 1 or np.ma.is_masked(raw.ids) or (ids.size and ids.dtype.kind not in "iu"):
        _refuse_ids(raw.ids, sen)
    if np.ma.is_masked(raw.y) or y.dtype.kind not in "iuf":
        real(f"sensor {sen.id}: measurements", raw.y)
    if raw.R is not None:
        if np.shape(raw.R) != (len(ids), m, m):
            raise ValueError(
                f"sensor {sen.id}: noise covariances must have shape {(len(ids), m, m)}, got {np.shape(raw.R)}"
            )
        for id, R in zip(ids, raw.R, strict=True):
            check_covariance(R, m, f"sensor {sen.id}: the noise covariance of landmark {id}")
    if y.shape != (len(ids), m):
        raise ValueError(
            f"sensor {sen.id}: measurements must have shape {(len(ids), m)}, one row per id, got {y.shape}"
        )
    for i in np.flatnonzero(~np.isfinite(y).all(-1))[:1]:
        raise ValueError(f"sensor {sen.id}: measurement {i} of landmark {ids[i]} must be finite, got {y[i].tolist()}")


def _refuse_ids(ids, sen):
    if np.ma.is_masked(ids):
        raise ValueError(f"sensor {sen.id}: ids must not have masked entries: -1 stands for an id that is not known")
    if np.ndim(ids) != 1:
        raise ValueError(f"sensor {sen.id}: ids must be a list of integers, got shape {np.shape(ids)}")
    ids = np.asarray(ids)
    raise ValueError(f"sensor {sen.id}: ids must be integers, got {ids.tolist()} ({ids.dtype})")
