"""Errors of a run against the truth, as far as that is known: robots, landmarks, dead reckoning, consistency.

`History` looks at every snapshot of a run and keeps what is needed; its `summary()` is what goes into `result.json`.
NEES needs the error and the covariance in one gauge: `gauge.py` says what that is.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from ..geometry import align
from ..slam.steps import travel
from ..toolbox.points import points_of
from .consistency import honesty, md2
from .corrections import GROSS, SecondSums, correction_ratio
from .gauge import MapGauge, distance_weights, laid_error, start_gauge
from .inertial import motion_errors, rotation_rmse, upright
from .partners import identity, named, placed, pose_on_truth
from .tracks import Track, rmse

SURPRISING = 60.0
"""Squared Mahalanobis distance between the first pose and its truth from which on the two are in different frames."""

TURNED = 0.5
"""A map that does not tell an angle of the robot to this standard deviation, rad, is no gauge: errors are not linear.

Landmarks that are as near to each other as they are uncertain have a direction by chance, to 1 rad or so."""

NIS_OF = "innovations that passed the gate"


class History:
    """Collects the errors of a run.

    Parameters
    ----------
    gauge : str
        'fixed' if the map's frame is that of the truth; or 'free', when the map is to be aligned with the truth
        first; or 'auto', to see whether the robots start where the truth says.
    truth_std : tuple of 2 float
        How well the true poses are known themselves, where they are estimates: metres, and radians about each axis.

    Examples
    --------
    >>> history = History()
    >>> for snapshot in universal_slam(userdata):
    ...     history.add(snapshot)
    >>> history.summary()["ate_rmse_m"] < 0.2
    True
    """

    def __init__(self, gauge="auto", truth_std=(0.0, 0.0)):
        if gauge not in ("auto", "free", "fixed"):
            raise ValueError(f"unknown gauge {gauge!r}; known: auto, free, fixed")
        self._asked, self._truth_std = gauge, truth_std
        self._rows, self._states, self._frames = {}, {}, {}
        self._velocities = {}  # of robots that know what is down: velocity, and the covariance of position and velocity
        self._in_map_gauge = {}
        self._starts = False
        self._nis, self._seen, self._sums = {}, {}, {}
        self.n_landmarks = []
        self.n_refused = self.n_recoveries = 0
        self.last: Any = None
        self._laid: Any = None  # the landmarks of the last frame, and the gauge by them: see `_gauge_of`
        self._lies: Any = None  # how the map lies in the world, a frame's vector, where landmarks are told by place
        self._last_rows: Any = None  # the last frame, and its landmarks' rows in the world

    # --- collecting ---

    def add(self, s):
        """Keep one frame. Call it for every snapshot `s`, in order, before the next one is drawn."""
        if not self.n_landmarks:
            self._starts = self._same_frame(s)
        self.last = s
        for rob in s.robs:
            self._add_robot(s, rob)
        if self.gauge == "free":
            needed = _told(s) or not s.named  # without names, places are followed from frame to frame
            gauge = self._gauge_of(s) if needed else None
            for rob in s.robs:
                self._in_map_gauge.setdefault(rob.id, []).append(_beside_gauge(rob, gauge))
        carrier = {id: rob.id for rob in s.robs for id in rob.sensors}
        for o in s.obs.values():
            if o.updated:
                self._nis[carrier[o.sen]].append((s.t, o.md2, len(o.z)))
        for id, _, *poses in s.corrected:
            self._sums[id].add(s.t, *poses)
        for e in s.events:
            if e.kind in ("initialisation", "correction"):
                self._seen[e.rob].add(e.lmk)
        self.n_refused += sum(e.kind == "innovation" and not e.flag for e in s.events)
        self.n_recoveries += sum(e.kind == "recovery" and e.lmk < 0 for e in s.events)
        self.n_landmarks.append(len(s.lmks))

    def state(self):
        """All that has been kept, as plain values, for a file."""
        kept = {
            name: value for name, value in vars(self).items() if name not in ("last", "_frames", "_laid", "_last_rows")
        }
        return kept | {"_sums": {id: sums.rows for id, sums in self._sums.items()}}

    def restore(self, state, frames):
        """Take up what another history had kept; `frames` are the frame types by robot id."""
        vars(self).update(state)
        self._frames = {id: frames[id] for id in self._rows}
        self._sums = {id: SecondSums(frames[id], rows) for id, rows in self._sums.items()}

    def watch(self, run):
        """Pass the snapshots of a run on, adding each."""
        for s in run:
            self.add(s)
            yield s

    def _add_robot(self, s, rob):
        n = rob.motion.frame.size
        state = rob.state(s.map)
        if rob.id in self._states:
            dt = s.dt if rob.dt is None else rob.dt
            self._states[rob.id] = travel(rob.motion.move, self._states[rob.id], rob.u, None, dt)[0]
        else:
            self._states[rob.id], self._frames[rob.id] = np.array(state), rob.motion.frame
            self._rows[rob.id], self._nis[rob.id], self._seen[rob.id] = [], [], set()
            self._sums[rob.id] = SecondSums(rob.motion.frame)
        P = np.zeros((len(state), len(state))) if rob.r is None else s.map.block(rob.r)
        if hasattr(rob.motion, "gravity") and "vel" in rob.motion.state_fields:
            at = np.r_[:3, 7:10]  # [t; q; v; ...]
            self._velocities.setdefault(rob.id, []).append((state[7:10].copy(), P[np.ix_(at, at)]))
        P = P[:n, :n].copy()
        truth = np.array(s.truth.get(rob.id, np.full(n, np.nan)), float)
        self._rows[rob.id].append((s.t, np.array(state[:n]), P, truth, self._states[rob.id][:n]))

    def partners(self, s=None):
        """Row in `sim_lmk` of each landmark of a frame that has a true one, by id; of the last frame if not given.

        By id where ids are those of the world (`Snapshot.named`), or else by place.
        """
        s = self.last if s is None else s
        if s is None:
            raise ValueError("this history has no frames yet; call add(snapshot) for each snapshot of a run")
        if s.named or s.sim_lmk is None:
            return named(s)
        if self._last_rows is None or self._last_rows[0] is not s:
            self._last_rows = s, self._by_place(s)
        return self._last_rows[1]

    def _by_place(self, s):
        frame = s.robs[0].motion.frame
        if self.gauge == "fixed":
            return placed(s, identity(frame.dim))[0]
        before = pose_on_truth(s) if self._lies is None else frame(self._lies)
        if before is None and s is not self.last:
            return {}
        rows, F = placed(s, before)
        self._lies = None if F is None or not rows else F.x
        return rows

    def _surveyed(self):
        """Landmarks of the last frame with their true places: ids, points, true places."""
        return _with_places(self.last, self.partners())[:3]

    def joint_map(self):
        """Landmarks of the last frame whose true places are known: see `joint_map`."""
        return joint_map(self.last, self.partners())

    def _gauge_of(self, s):
        """The gauge of the map of this frame, None where the landmarks do not fix it.

        Found anew if the landmarks have changed. The vector of its frame; the small motion that it takes away, by the
        states of the landmarks, and its covariance; and the rows of P that belong to these states.
        """
        rows = self.partners(s)
        lmks = [s.lmks[id] for id in rows]
        if len(lmks) < s.robs[0].motion.frame.dim:
            return None
        P, these = _covariance(s.map), [(row, lmk.type, lmk.r) for row, lmk in zip(rows.values(), lmks, strict=True)]
        at = self._laid[1] if self._laid is not None and these == self._laid[0] else _indices(lmks)
        states, P_lmk = np.concatenate([lmk.state(s.map) for lmk in lmks]), P[at]
        laid = these, at, states, P_lmk[:, at]
        if self._laid is None or these != self._laid[0] or not all(map(np.array_equal, laid[2:], self._laid[2:4])):
            _, points, truth, B = _with_places(s, rows)
            B = B[:, at]
            try:
                gauge = MapGauge(points, truth, B @ laid[3] @ B.T)
            except ValueError:  # they are on a line, or on top of each other
                return None
            C = gauge.C @ B
            self._laid = *laid, (gauge.F.x, C, C @ laid[3] @ C.T)
        return *self._laid[4], P_lmk

    @staticmethod
    def _same_frame(s):
        """True if the first map is in the frame of the truth: known landmarks, or robots that start where they are."""
        if any(lmk.r is None for lmk in s.lmks.values()):
            return True
        for rob in s.robs:
            F, n = rob.frame(s.map), rob.motion.frame.size
            if rob.r is None:
                continue
            if rob.id not in s.truth or not np.isfinite(s.truth[rob.id]).all():
                return False
            e, E_x = F.minus(rob.motion.frame(s.truth[rob.id]))
            spread = E_x @ s.map.block(rob.r)[:n, :n] @ E_x.T + 1e-6 * np.eye(len(e))
            if md2(e, spread) > SURPRISING:
                return False
        return True

    # --- results ---

    @property
    def robots(self):
        """Ids of the robots."""
        return list(self._rows)

    def track(self, id):
        """The `Track` of a robot, in the frame of the map."""
        return Track(id, self._frames[id], *map(np.array, zip(*self._rows[id], strict=True)))

    def nis(self, id):
        """Innovations of a robot that were used, shape (K, 3): time, s; squared Mahalanobis distance; its dof."""
        return np.array(self._nis[id], float).reshape(-1, 3)

    def correction_ratio(self, robots=None):
        """Ratio of the sums of corrections to what was expected, of some robots or of all: a `CorrectionRatio`."""
        return correction_ratio([self._sums[id].arrays for id in (self.robots if robots is None else robots)])

    @property
    def gauge(self):
        """'fixed' if the map is in the frame of the truth, else 'free'."""
        return self._asked if self._asked != "auto" else "fixed" if self._starts else "free"

    def landmarks(self):
        """Landmarks at the end whose true place is known.

        Returns
        -------
        ids : ndarray, shape (N,)
        points : ndarray, shape (N, d)
            Estimates, in the frame of the map.
        covs : ndarray, shape (N, d, d)
        truth : ndarray, shape (N, d)
        """
        ids, points, truth = self._surveyed()
        d = points.shape[1]
        covs = [self.last.lmks[i].point(self.last.map)[1] for i in ids]
        return np.array(ids, int), points, np.array(covs).reshape(-1, d, d), truth

    def alignment(self):
        """The frame that aligns map and truth, found from the landmarks if they suffice, else from the trajectories.

        Returns
        -------
        F : Frame2 or Frame3, or None
        basis : str
            'landmarks', 'trajectories', or 'none' where there is too little truth.
        """
        ids, points, P, truth = self.joint_map()
        weights = distance_weights(points, P) if ids else None
        tracks = [self.track(i) for i in self.robots]
        trajectories = [np.concatenate([track.positions(name) for track in tracks]) for name in ("x", "truth")]
        lay = upright if self._velocities else align  # an IMU knows what is down
        for basis, fit, pairs in (("landmarks", align, (points, truth, weights)), ("trajectories", lay, trajectories)):
            try:
                return fit(*pairs), basis
            except ValueError:  # too few of them
                continue
        return None, "none"

    def errors(self, id):
        """Errors of a robot and their covariances in one gauge, where its true pose is known.

        With a fixed gauge that is the frame of the truth. With a free gauge it is the map's, frame by frame: pose and
        landmarks of that instant, with their joint covariance, after the alignment of these landmarks with their true
        places. Where no landmark has a true place it is the start's: poses relative to the first one; of a robot with
        an IMU, instead of a pose, position and velocity, with the yaw that fits best (`inertial.motion_errors`).

        Returns
        -------
        e : ndarray, shape (K, 3) or (K, 6)
            As `Track.errors` has them. NaN where there is no gauge: too few landmarks so far, or known too badly to
            tell how the robot is turned (`TURNED`), or the true start not known.
        P : ndarray, shape (K, 3, 3) or (K, 6, 6)
            With the covariance of the true poses, where they are estimates themselves.

        See Also
        --------
        MapGauge : The gauge of the map.
        start_gauge : The gauge of the start.
        """
        e, P = self._errors(id)
        if self.error_of(id) == "pose":
            d = self._frames[id].dim
            P = P + np.diag(np.repeat(np.square(self._truth_std), [d, e.shape[1] - d]))
        return e, P

    def _errors(self, id):
        track = self.track(id)
        if self.gauge == "fixed":
            return track.errors()
        if len(self._surveyed()[0]):
            return self._map_errors(track)
        if self.error_of(id) != "pose":
            v, P = map(np.array, zip(*self._velocities[id], strict=True))
            return motion_errors(track.t, track.x[:, :3], v, P, track.truth[:, :3])
        k = track.known
        x, truth = track.frame(track.x[k]), track.frame(track.truth[k])
        _, E_x = x.minus(x)
        e, P = start_gauge(x, E_x @ track.P[k] @ np.swapaxes(E_x, -1, -2), truth) if k.any() else track.errors()
        return (e, P) if np.asarray(k)[:1].all() else (e * np.nan, P * np.nan)

    def _map_errors(self, track):
        """Errors of a robot, each in the gauge of the map of its frame, and their covariances: S P S' of `gauge`."""
        k, frame, turned = track.known, track.frame, lambda J: np.swapaxes(J, -1, -2)
        F, P_xg, P_g = (np.array(a)[k] for a in zip(*self._in_map_gauge[track.id], strict=True))
        fixed = np.isfinite(F).all(1)
        e, P = np.full((len(F), frame.dof), np.nan), np.full((len(F), frame.dof, frame.dof), np.nan)
        F, P_xg, P_g, x, truth, P_x = (a[fixed] for a in (F, P_xg, P_g, track.x[k], track.truth[k], track.P[k]))
        e[fixed], E_x, E_g = laid_error(frame(F), frame(x), frame(truth))
        both = E_x @ P_xg @ turned(E_g)
        P[fixed] = E_x @ P_x @ turned(E_x) + both + turned(both) + E_g @ P_g @ turned(E_g)
        vague = (np.diagonal(P, axis1=1, axis2=2)[:, frame.dim :] > TURNED**2).any(1)
        e[vague], P[vague] = np.nan, np.nan
        return e, P

    def error_of(self, id):
        """Kind of the `errors`: "pose"; "position and velocity", of a robot with an IMU in a gauge of its own."""
        own = self.gauge == "free" and id in self._velocities and not len(self._surveyed()[0])
        return "position and velocity" if own else "pose"

    def summary(self):
        """The figures of the run, for `result.json`; None where the truth is not known.

        Returns
        -------
        dict
            frames, n_landmarks, gauge ('fixed' or 'free'), alignment (what map and truth were aligned by, if the
            gauge is free), ate_rmse_m, heading_rmse_deg, rotation_rmse_deg (after one constant rotation of each robot
            has been taken away), landmark_rmse_m, and landmark_median_m, below which half of them are: one that is
            far, and known to be, makes the first large; dead_reckoning_ate_m; nees_mean, nis_mean with the degrees of
            freedom nees_dof and nis_dof they should be near to, nees_per_dof, and nees_of, what it is the NEES of: the
            pose, of a robot with an IMU position and velocity, of a known robot the landmarks; ate_aligned_m and
            landmark_rmse_aligned_m, after alignment in any case; correction_ratio (see `analysis.corrections`: 1 is
            right), the length of the blocks that it was found with, correction_ratio_s, and what an honest filter stays
            below, correction_ratio_limit; n_innovations, of which n_refused did not pass the gate, which nis_mean does
            not count, as nis_of says; n_recoveries; landmarks_by, 'id' or 'place': how landmarks and true ones were
            paired, with n_left_over landmarks and n_not_found true ones that have no partner; and `robots`, by id: the
            same for each.

            With a free gauge all errors are those after one alignment, of the final map, in which a landmark weighs
            what is known of its place; and the dead reckoning of each robot is laid on its true trajectory as well as
            it can be. NEES is that of the robots, of the errors and covariances in one gauge (`errors`); where all
            robots are known, as in mapping, that of the landmarks.
        """
        F, basis = self.alignment()
        free = self.gauge == "free"
        robots = {str(id): self._figures([id], F, free) for id in self.robots}
        head = {"frames": len(self.n_landmarks), "gauge": self.gauge, "alignment": basis if free else "none"}
        n_innovations = self.n_refused + sum(map(len, self._nis.values()))
        tail = {"n_innovations": n_innovations, "n_refused": self.n_refused, "nis_of": NIS_OF}
        tail |= {"n_recoveries": self.n_recoveries} | self._left_over() | {"robots": robots}
        return head | self._figures(self.robots, F, free) | tail

    def _left_over(self):
        """Say how landmarks and true ones were paired, and how many of both have no partner."""
        s = self.last
        if s.sim_lmk is None:
            return {"landmarks_by": None, "n_left_over": None, "n_not_found": None}
        n = len(self.partners())
        counts = {"n_left_over": len(s.lmks) - n, "n_not_found": len(s.sim_lmk.ids) - n}
        return {"landmarks_by": "id" if s.named else "place"} | counts

    def _figures(self, robots, F, free):
        """Figures of some of the robots together, and of the landmarks that they have seen."""
        plain = [self.track(id) for id in robots]
        moved = [track.moved(F) for track in plain] if F is not None else []
        ids, points, covs, truth = self.landmarks()
        seen = set().union(*(self._seen[id] for id in robots)) & set(self.last.lmks)
        mine = np.isin(ids, list(seen))
        points, covs, truth = points[mine], covs[mine], truth[mine]
        d = plain[0].frame.dim
        lmk = points - truth
        lmk_aligned = F.from_frame(points)[0] - truth if F is not None and len(points) else np.zeros((0, d))

        e, _ = _pooled(moved if free else plain)
        e_aligned, _ = _pooled(moved)
        n = np.concatenate([md2(*self.errors(id)) for id in robots])
        nees_dof, nees_of = e.shape[1], self.error_of(robots[0]) if len(robots) else "pose"
        if not np.isfinite(n).any():
            R = F.R if free and F is not None else np.eye(d)
            n, nees_dof, nees_of = md2(lmk_aligned if free else lmk, R @ covs @ R.T), d, "landmarks"
        turned = [rotation_rmse(t.x[t.known], t.truth[t.known]) ** 2 for t in (moved or plain) if t.known.any()]
        pairs = np.concatenate([self.nis(id) for id in robots])[:, 1:]
        ratio = self.correction_ratio(robots)
        return {
            "n_landmarks": len(seen),
            "ate_rmse_m": _known(rmse(e[:, :d])),
            "ate_aligned_m": _known(rmse(e_aligned[:, :d])),
            "heading_rmse_deg": _known(np.rad2deg(rmse(e[:, d:]))),
            "rotation_rmse_deg": _known(np.rad2deg(np.sqrt(np.mean(turned)))) if turned else None,
            "landmark_rmse_m": _known(rmse(lmk_aligned if free else lmk)),
            "landmark_median_m": _known(_median(np.linalg.norm(lmk_aligned if free else lmk, axis=1))),
            "landmark_rmse_aligned_m": _known(rmse(lmk_aligned)),
            "dead_reckoning_ate_m": _known(rmse(np.concatenate([_dead(t, free) for t in plain])[:, :d])),
            "nees_mean": _known(_mean(n)),
            "nees_of": nees_of,
            "nees_dof": nees_dof,
            "nees_per_dof": _known(_mean(n) / nees_dof),
            "nis_mean": _known(_mean(pairs[:, 0])),
            "nis_dof": _known(_mean(pairs[:, 1])),
            "correction_ratio": _known(ratio.value),
            "correction_ratio_s": ratio.seconds or None,
            "correction_ratio_limit": _known(max(ratio.limit, GROSS)),
        }

    def honesty(self, confidence=0.999):
        """The honesty meter of the run: see `consistency.Honesty`. Frames of one run are correlated: the NEES band is
        that of one pose only."""
        F, _ = self.alignment()
        tracks = [self.track(id) for id in self.robots]
        moved = [t.moved(F) for t in tracks] if self.gauge == "free" and F is not None else tracks
        pairs = np.concatenate([self.nis(id) for id in self.robots])[:, 1:]
        meter = honesty(
            *map(np.concatenate, zip(*(self.errors(id) for id in self.robots), strict=True)),
            nis=pairs[:, 0],
            nis_dof=_mean(pairs[:, 1]) if len(pairs) else 2.0,
            dim=tracks[0].frame.dim,
            map_P=self.last.map.P,
            runs=1,
            confidence=confidence,
        )
        return replace(meter, rmse=rmse(_pooled(moved)[0][:, : tracks[0].frame.dim]))


def _with_places(s, rows):
    """Landmarks of a map with the rows of their true places: ids, points, true places; and the derivative of the points
    by the whole map, shape (n d, N)."""
    d = s.robs[0].motion.frame.dim
    lmks = [s.lmks[id] for id in rows]
    points, P_l = points_of(s.map, lmks)
    B = np.zeros((len(lmks), d, s.map.n))
    for row, lmk, J in zip(B, lmks, P_l, strict=True):
        if lmk.r is not None:
            row[:, lmk.r] = J
    truth = s.sim_lmk.points[list(rows.values())] if rows else points
    return list(rows), points.reshape(-1, d), truth.reshape(-1, d), B.reshape(-1, s.map.n)


def joint_map(s, rows=None):
    """Landmarks of a snapshot whose true places are known.

    Parameters
    ----------
    s : Snapshot
    rows : dict of int to int, optional
        Row of the true landmark in `s.sim_lmk`, by id; by the same id if not given.

    Returns
    -------
    ids : list of int
    points : ndarray, shape (n, d)
    P : ndarray, shape (n d, n d)
        Their joint covariance.
    truth : ndarray, shape (n, d)
    """
    ids, points, truth, B = _with_places(s, named(s) if rows is None else rows)
    return ids, points, B @ _covariance(s.map) @ B.T, truth


def _covariance(map):
    """Covariance of all states: a copy. (To ask a compressed map for its P would bring it up to date: who only looks on
    must not change the last digits of a run.)"""
    return map.block(slice(0, map.n))


def _told(s):
    """Robots of the map whose true pose is known in this frame."""
    return [rob for rob in s.robs if rob.r is not None and np.isfinite(s.truth.get(rob.id, np.nan)).all()]


def _beside_gauge(rob, gauge):
    """What the errors of a robot in the gauge of a map are made of, later and at once: the vector of the gauge's frame,
    the covariance of the pose with the small motion that is taken away, and that of the motion; NaN where none is."""
    size, dof = rob.motion.frame.size, rob.motion.frame.dof
    if gauge is None or rob.r is None:
        return np.full(size, np.nan), np.full((size, dof), np.nan), np.full((dof, dof), np.nan)
    F, C, P_g, P_lmk = gauge
    pose = slice(rob.r.start, rob.r.start + size)
    return F, P_lmk[:, pose].T @ C.T, P_g


def _indices(lmks):
    """Indices of the states of landmarks in the map."""
    return np.concatenate([np.zeros(0, int), *(np.arange(l.r.start, l.r.stop) for l in lmks if l.r is not None)])


def _pooled(tracks):
    """Errors and covariances of several tracks in one array each."""
    if not tracks:
        return np.zeros((0, 3)), np.zeros((0, 3, 3))
    parts = [track.errors() for track in tracks]
    return tuple(np.concatenate(arrays) for arrays in zip(*parts, strict=True))


def _dead(track, free):
    """Errors of dead reckoning; without a frame of its own it gets the best one there is."""
    try:
        return (track.aligned_dead() if free else track).errors("dead")[0]
    except ValueError:  # too little truth to align
        return np.zeros((0, track.frame.dof))


def _mean(a):
    a = a[np.isfinite(a)]
    return float(a.mean()) if a.size else float("nan")


def _median(a):
    return float(np.median(a)) if a.size else float("nan")


def _known(value):
    """None instead of NaN, which JSON does not have."""
    return float(value) if np.isfinite(value) else None
