"""Errors of a run against the truth, as far as that is known: robots, landmarks, dead reckoning, consistency.

`History` looks at every snapshot of a run and keeps what is needed; its `summary()` is what goes into `result.json`.
"""

from typing import Any

import numpy as np

from ..geometry import align
from .consistency import honesty, md2
from .tracks import Track, rmse

SURPRISING = 60.0
"""Squared Mahalanobis distance between the first pose and its truth from which on the two are in different frames."""


class History:
    """Collects the errors of a run.

    Parameters
    ----------
    gauge : str
        'fixed' if the map's frame is that of the truth; or 'free', when the map is to be aligned with the truth
        first; or 'auto', to see whether the robots start where the truth says.

    Examples
    --------
    >>> history = History()
    >>> for snapshot in universal_slam(userdata):
    ...     history.add(snapshot)
    >>> history.summary()["ate_rmse_m"] < 0.2
    True
    """

    def __init__(self, gauge="auto"):
        if gauge not in ("auto", "free", "fixed"):
            raise ValueError(f"unknown gauge {gauge!r}; known: auto, free, fixed")
        self._asked = gauge
        self._rows, self._states, self._frames = {}, {}, {}
        self._starts = False
        self._nis, self._seen = {}, {}
        self.n_landmarks = []
        self.n_refused = self.n_recoveries = 0
        self.last: Any = None

    # --- collecting ---

    def add(self, s):
        """Keep one frame. Call it for every snapshot `s`, in order, before the next one is drawn."""
        if not self.n_landmarks:
            self._starts = self._same_frame(s)
        self.last = s
        for rob in s.robs:
            self._add_robot(s, rob)
        carrier = {id: rob.id for rob in s.robs for id in rob.sensors}
        for o in s.obs.values():
            if o.updated:
                self._nis[carrier[o.sen]].append((s.t, o.md2, len(o.z)))
        for e in s.events:
            if e.kind in ("initialisation", "correction"):
                self._seen[e.rob].add(e.lmk)
        self.n_refused += sum(e.kind == "innovation" and not e.flag for e in s.events)
        self.n_recoveries += sum(e.kind == "recovery" and e.lmk < 0 for e in s.events)
        self.n_landmarks.append(len(s.lmks))

    def state(self):
        """All that has been kept, as plain values, for a file."""
        return {name: value for name, value in vars(self).items() if name not in ("last", "_frames")}

    def restore(self, state, frames):
        """Take up what another history had kept; `frames` are the frame types by robot id."""
        vars(self).update(state)
        self._frames = {id: frames[id] for id in self._rows}

    def watch(self, run):
        """Pass the snapshots of a run on, adding each."""
        for s in run:
            self.add(s)
            yield s

    def _add_robot(self, s, rob):
        n = rob.motion.frame.size
        state = rob.state(s.map)
        if rob.id in self._states:
            self._states[rob.id] = rob.motion.move(self._states[rob.id], rob.u, s.dt)[0]
        else:
            self._states[rob.id], self._frames[rob.id] = np.array(state), rob.motion.frame
            self._rows[rob.id], self._nis[rob.id], self._seen[rob.id] = [], [], set()
        P = np.zeros((n, n)) if rob.r is None else s.map.block(rob.r)[:n, :n]
        truth = np.array(s.truth.get(rob.id, np.full(n, np.nan)), float)
        self._rows[rob.id].append((s.t, np.array(state[:n]), P, truth, self._states[rob.id][:n]))

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
        s = self.last
        if s is None:
            raise ValueError("this history has no frames yet; call add(snapshot) for each snapshot of a run")
        known = [] if s.sim_lmk is None else zip(s.sim_lmk.ids, s.sim_lmk.points, strict=True)
        places = {int(id): p for id, p in known}
        ids = [i for i in s.lmks if i in places]
        d = s.robs[0].motion.frame.dim
        estimates = [s.lmks[i].point(s.map) for i in ids]
        points = np.array([p for p, _ in estimates]).reshape(-1, d)
        covs = np.array([P for _, P in estimates]).reshape(-1, d, d)
        return np.array(ids, int), points, covs, np.array([places[i] for i in ids]).reshape(-1, d)

    def alignment(self):
        """The frame that aligns map and truth, found from the landmarks if they suffice, else from the trajectories.

        Returns
        -------
        F : Frame2 or Frame3, or None
        basis : str
            'landmarks', 'trajectories', or 'none' where there is too little truth.
        """
        _, points, _, truth = self.landmarks()
        tracks = [self.track(i) for i in self.robots]
        trajectories = [np.concatenate([track.positions(name) for track in tracks]) for name in ("x", "truth")]
        for basis, pairs in (("landmarks", (points, truth)), ("trajectories", trajectories)):
            try:
                return align(*pairs), basis
            except ValueError:  # too few of them
                continue
        return None, "none"

    def summary(self):
        """The figures of the run, for `result.json`; None where the truth is not known.

        Returns
        -------
        dict
            frames, n_landmarks, gauge ('fixed' or 'free'), alignment (what map and truth were aligned by, if the
            gauge is free), ate_rmse_m, heading_rmse_deg, landmark_rmse_m, dead_reckoning_ate_m; nees_mean, nis_mean
            with the degrees of freedom nees_dof and nis_dof they should be near to; ate_aligned_m and
            landmark_rmse_aligned_m, after alignment in any case; n_refused innovations, n_recoveries; and `robots`, by
            id: the same for each.

            With a free gauge all errors are those after alignment, and the dead reckoning of each robot is laid on its
            true trajectory as well as it can be. NEES is that of the robots; where all robots are known, as in mapping,
            that of the landmarks.
        """
        F, basis = self.alignment()
        free = self.gauge == "free"
        robots = {str(id): self._figures([id], F, free) for id in self.robots}
        head = {"frames": len(self.n_landmarks), "gauge": self.gauge, "alignment": basis if free else "none"}
        tail = {"n_refused": self.n_refused, "n_recoveries": self.n_recoveries, "robots": robots}
        return head | self._figures(self.robots, F, free) | tail

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

        e, P = _pooled(moved if free else plain)
        e_aligned, _ = _pooled(moved)
        n = md2(e, P)
        nees_dof = e.shape[1]
        if not np.isfinite(n).any():
            R = F.R if free and F is not None else np.eye(d)
            n, nees_dof = md2(lmk_aligned if free else lmk, R @ covs @ R.T), d
        pairs = np.concatenate([self.nis(id) for id in robots])[:, 1:]
        return {
            "n_landmarks": len(seen),
            "ate_rmse_m": _known(rmse(e[:, :d])),
            "ate_aligned_m": _known(rmse(e_aligned[:, :d])),
            "heading_rmse_deg": _known(np.rad2deg(rmse(e[:, d:]))),
            "landmark_rmse_m": _known(rmse(lmk_aligned if free else lmk)),
            "landmark_rmse_aligned_m": _known(rmse(lmk_aligned)),
            "dead_reckoning_ate_m": _known(rmse(np.concatenate([_dead(t, free) for t in plain])[:, :d])),
            "nees_mean": _known(_mean(n)),
            "nees_dof": nees_dof,
            "nis_mean": _known(_mean(pairs[:, 0])),
            "nis_dof": _known(_mean(pairs[:, 1])),
        }

    def honesty(self, confidence=0.999):
        """The honesty meter of the run: see `consistency.Honesty`. Frames of one run hang together, so the NEES band is
        that of one pose only."""
        F, _ = self.alignment()
        tracks = [self.track(id) for id in self.robots]
        tracks = [t.moved(F) for t in tracks] if self.gauge == "free" and F is not None else tracks
        e, P = _pooled(tracks)
        pairs = np.concatenate([self.nis(id) for id in self.robots])[:, 1:]
        return honesty(
            e,
            P,
            nis=pairs[:, 0],
            nis_dof=_mean(pairs[:, 1]) if len(pairs) else 2.0,
            dim=tracks[0].frame.dim,
            map_P=self.last.map.P,
            runs=1,
            confidence=confidence,
        )


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


def _known(value):
    """None instead of NaN, which JSON does not have."""
    return float(value) if np.isfinite(value) else None
