"""How far do errors that last move the estimate? The residuals of the whole run tell, without a truth.

Sums of corrections (`corrections`) tell that errors last, and not what they do to the pose: what the controls do wrong
adds up in them, though the filter takes it away at the next landmark. Here each error is followed to the pose. The
estimate is nearly linear in the noise, and the smoother knows the gain of each number that was measured,

    e_k = sum over i of K_ki n_i,    P_k = sum over i of K_ki N_i K_ki'      if the noise is as it is told.

The noise has sources: one is what a robot measures of one landmark, another are its controls. Errors of different
sources have nothing to do with each other; those of one source may last as long as they like. So the covariance of
e_k is a sum over the sources, and each says by its own residuals r how large its part is:

    C_k = sum over s of (q_s q_s' + D_s),    q_s = sum over i of s of K_ki r_i,    c_k = tr(P_k^-1 C_k) / dof

D_s is what the residuals do not show because the estimate has gone with the noise, K_s (N_s - cov r_s) K_s' if the
noise is as it is told: then E C_k = P_k, and c_k is 1 on average. The estimate is that of the instant k, of all that
was measured until then; the residuals are those of the whole run.

That is the sandwich covariance of H. White, "A heteroskedasticity-consistent covariance matrix estimator and a direct
test for heteroskedasticity", Econometrica 48(4), 1980, over groups (K.-Y. Liang, S. L. Zeger, "Longitudinal data
analysis using generalized linear models", Biometrika 73(1), 1986), with residuals brought up to the size of the noise
(R. M. Bell, D. F. McCaffrey, "Bias reduction in standard errors for linear regression with multi-stage samples",
Survey Methodology 28(2), 2002).

An error that all sources share is in no residual. One of them is seen all the same: controls and ranges may disagree
about how large the world is. How much, says a fit; which of the two is wrong, the log does not say. So there are two
numbers: c if the controls are wrong, and c if the ranges are. Their geometric mean is the one from which the logarithm
of the right one differs least.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import block_diag

from .factors import Motion, Prior
from .gauge import MapGauge
from .smoother import System, smooth

POSES = 12
"""So many poses of a run are looked at: of one robot at twelve instants, of three at four."""
FEWEST_INSTANTS = 4
"""At least at so many, however many robots there are."""
FEWEST = 3
"""So many landmarks must be in the map of an instant."""
SURE = 3.0
"""Controls and ranges disagree if their fit is so many standard deviations from nothing."""
MOVED = 1e-6
"""A last step of the smoother that moves more than this has not converged."""
SINGULAR = 1e-10
"""A pose whose covariance has a smaller eigenvalue, as correlation, is known exactly in some direction: left out."""
COLUMNS = 60
"""So many right sides are solved at a time."""
AS_TOLD = -1
"""Label of noise that is taken as it is told: priors, and what starts a landmark."""


@dataclass(frozen=True)
class Influence:
    """What errors that last do to the pose, in terms of its covariance.

    Parameters
    ----------
    by_controls, by_ranges : float
        What P has to be multiplied by if the controls are wrong about the size of the world, or if the ranges are: the
        median over instants and robots. The same if they agree. NaN if the run has no instant to tell.
    scale, scale_std : float
        By how much controls are longer than ranges say, as a share: 0.05 is 5 %; and its standard deviation, by noise
        as it is told. NaN if no sensor measures a range.
    """

    by_controls: float
    by_ranges: float
    scale: float
    scale_std: float

    @property
    def disagree(self):
        """True if controls and ranges surely disagree about the size of the world."""
        return bool(abs(self.scale) > SURE * self.scale_std)

    @property
    def factor(self):
        """What P has to be multiplied by, of which the logarithm is in the middle between both; at least 1."""
        middle = float(np.sqrt(self.by_controls * self.by_ranges))
        return max(1.0, middle) if np.isfinite(middle) else 1.0


def influence(graph, after_step=lambda: None):
    """Follow the residuals of a run to its poses.

    Parameters
    ----------
    graph : Graph
        From `graph_of`; it is smoothed.
    after_step : callable
        Called after each step of the smoother, and after each instant.

    Returns
    -------
    Influence

    Raises
    ------
    ValueError
        If the run cannot be smoothed.

    See Also
    --------
    correction_ratio : Whether errors last at all.
    """
    smoothed = smooth(graph, after_step=after_step, enough=MOVED)
    if smoothed.steps[-1] > MOVED:
        raise ValueError(f"the smoother has not converged: its last step moves by {smoothed.steps[-1]:.1e}")
    run = _Run(graph, smoothed.system)
    last, found, robots = len(graph.t) - 1, [], {key[1] for key in graph.values if key[0] == "robot"}
    instants = max(FEWEST_INSTANTS, POSES // max(1, len(robots)))
    for k in sorted({-(-last * i // instants) for i in range(1, instants + 1)}):
        found += run.at(k)
        after_step()
    by_controls, by_ranges = np.median(found, axis=0) if found else (np.nan, np.nan)
    return Influence(float(by_controls), float(by_ranges), *run.scale)


@dataclass(frozen=True)
class _Noise:
    """Numbers for each row of a system, of the stiff factors (A) and of what was seen (J): noise, or its gain."""

    stiff: np.ndarray
    seen: np.ndarray

    def __sub__(self, other):
        return _Noise(self.stiff - other.stiff, self.seen - other.seen)

    def __rmul__(self, b):
        return _Noise(b * self.stiff, b * self.seen)

    def of(self, source, number):
        """The same of one source, and zero in all other rows."""
        cut = lambda a, s: np.where((s == number)[:, None], a, 0.0)
        return _Noise(cut(self.stiff, source.stiff), cut(self.seen, source.seen))


class _Run:
    """The whole run, smoothed: its residuals, their sources, and the ways in which it may be wrong.

    Attributes
    ----------
    source : _Noise
        Number of the source of each row.
    scale : (float, float)
        By how much controls are longer than ranges say, and its standard deviation.
    ways : list of (_Noise, _Noise)
        Controls are wrong about the size of the world, or ranges are: the residuals that are left then, and the error.
    """

    def __init__(self, graph, system):
        self.graph, self.system = graph, system
        self.place = {id(factor): rows for factor, _, rows in system.noise}
        self.place |= {(id(look), i): rows for look, i, _, rows in system.seen}
        self.source, self.n_sources = self.sources()
        self.known = any(isinstance(f, Prior) and f.keys[0][0] == "landmark" for f in graph.stiff)
        self.known |= any(not isinstance(lmk, tuple) for look in graph.looks for lmk in look.lmks)
        self.scale, self.ways = self.size_of_the_world()

    def sources(self):
        """All that a robot measures of a landmark is one, and so are its controls."""
        numbers, system = {}, self.system
        number = lambda *source: numbers.setdefault(source, len(numbers))
        stiff, seen = np.full(len(system.r), AS_TOLD), np.full(len(system.z), AS_TOLD)
        for factor, _, rows in system.noise:
            if isinstance(factor, Motion):
                stiff[rows] = number("controls of", factor.after[1])
        for look, i, _, rows in system.seen:
            lmk, whose = look.lmks[i], look.pose[1] if isinstance(look.pose, tuple) else id(look.sensor)
            seen[rows] = number(whose, lmk[:2] if isinstance(lmk, tuple) else tuple(lmk))
        return _Noise(stiff, seen), len(numbers)

    # --- how large is the world? ---

    def size_of_the_world(self):
        """Fit controls, or ranges, that are too long: their scale, and both ways to be wrong."""
        system, fits = self.system, []
        residuals, nothing = _Noise(system.r, system.z), _Noise(0 * system.r, 0 * system.z)
        multipliers = system.factorised.solve(system.b)[: -system.n]
        for error in self.too_long():
            v, left = self.left_of(error)
            information = float(error.stiff @ v + error.seen @ left.seen)
            if not information > 0:
                return (float("nan"), float("nan")), [(residuals, nothing)] * 2
            score = float(error.stiff @ multipliers + error.seen @ system.z)
            fits.append((score / information, information**-0.5, error, left))
        b, std = fits[0][:2]
        if not abs(b) > SURE * std:
            return (b, std), [(residuals, nothing)] * 2
        return (b, std), [(residuals - b * left, b * error) for b, _, error, left in fits]

    def too_long(self):
        """What controls that are twice as long as they should be leave in the rows; and such ranges."""
        system = self.system
        stiff, seen = np.zeros(len(system.r)), np.zeros(len(system.z))
        for factor, _, rows in system.noise:
            if isinstance(factor, Motion):
                d = factor.motion.frame.dim
                step = self.graph.values[factor.after][:d] - self.graph.values[factor.before][:d]
                stiff[rows][:d] = -step  # the state is behind where the control leads
        for look, i, W, rows in system.seen:
            in_metres = np.array([unit == "m" for unit in getattr(look.sensor, "units", ())])
            if in_metres.any() and not hasattr(look.sensor, "without_lmks"):  # where GPS is, is no range
                expected = look.y[i] - np.linalg.solve(W, system.z[rows])  # not what was measured: that has the noise
                seen[rows] = W @ np.where(in_metres, expected, 0.0)
        return _Noise(stiff, 0 * seen), _Noise(0 * stiff, seen)

    def left_of(self, noise):
        """What the estimate of the whole run leaves of some noise: multipliers, and residuals."""
        s = self.system
        found = s.factorised.solve(np.concatenate([-noise.stiff, s.J.T @ noise.seen]))
        v, dx = found[: -s.n], found[-s.n :]
        return v, _Noise(noise.stiff + s.A @ dx, noise.seen - s.J @ dx)

    # --- an instant ---

    def at(self, k):
        """c of each robot at instant k, if the controls are wrong and if the ranges are: a list of pairs."""
        shape, found = (len(self.system.r), len(self.system.z)), []
        for P, gain in _gains(self.graph, k, self.known, self.place, shape):
            D = self.hidden(gain)
            found.append([self.ratio(P, D, gain, *way) for way in self.ways])
        return found

    def ratio(self, P, D, gain, residuals, error):
        """c = tr(P^-1 C) / dof."""
        q = np.zeros((self.n_sources, len(P)))
        for source, r, K in (
            (self.source.stiff, residuals.stiff, gain.stiff),
            (self.source.seen, residuals.seen, gain.seen),
        ):
            own = source != AS_TOLD
            np.add.at(q, source[own], r[own, None] * K[own])
        e = error.stiff @ gain.stiff + error.seen @ gain.seen
        return float(np.trace(np.linalg.solve(P, q.T @ q + np.outer(e, e) + D))) / len(P)

    def hidden(self, gain):
        """What the residuals do not show of the noise, if it is as it is told: the sum of D_s, shape (dof, dof)."""
        s, at_once = self.system, max(1, COLUMNS // gain.stiff.shape[1])
        told = gain.of(self.source, AS_TOLD)
        D = told.stiff.T @ (s.Q @ told.stiff)
        for first in range(0, self.n_sources, at_once):
            parts = [gain.of(self.source, i) for i in range(first, min(first + at_once, self.n_sources))]
            right = np.array([np.concatenate([s.Q @ K.stiff, s.J.T @ K.seen]) for K in parts])
            found = s.factorised.solve(np.concatenate(right, axis=1))
            for K, b, x in zip(parts, right, np.split(found, len(right), axis=1), strict=True):
                D += K.stiff.T @ b[: -s.n] + b.T @ x
        return D


def _gains(graph, k, known, place, shape):
    """Pose of each robot at instant k, in the gauge of its map, as it was estimated then.

    Yields
    ------
    P : ndarray, shape (dof, dof)
    gain : _Noise
        How the noise of each row of the whole system moves it, shapes (rows, dof).
    """
    try:
        system = System(graph, *_until(graph, k))
        poses = {key: at for key, at in system.at.items() if key[0] == "robot" and key[2] == k}
        lmks = [key for key in system.at if key[0] == "landmark"]
        points = [graph.types[id].point(graph.values[key]) for key in lmks for id in key[1:]]
        if not known and len(lmks) < FEWEST:
            return
        pick = np.concatenate([system.at[key] for key in [*poses, *lmks]])
        right = np.zeros((len(system.b), len(pick)))
        right[len(system.b) - system.n + pick, np.arange(len(pick))] = 1.0
        found = system.factorised.solve(right)
        P = found[-system.n :][pick]
        L: Any = block_diag(*(P_l for _, P_l in points))
        n, p = len(pick) - L.shape[1], np.array([p for p, _ in points])
        gauge = None if known else MapGauge(p, p, L @ P[n:, n:] @ L.T)
    except ValueError:  # what was measured until then does not fix all that is in the map, or its place
        return
    row = 0
    for key, at in poses.items():
        frame = graph.frames[key[:2]]
        F = frame(graph.values[key][: frame.size])
        T = np.zeros((F.dof, len(pick)))
        T[:, row : row + frame.size] = F.minus(F)[1]
        if gauge is not None:
            _, T[:, row : row + frame.size], E_l = gauge.error(F, F)
            T[:, n:] = E_l @ L
        row += len(at)
        P_T = T @ P @ T.T
        std = np.sqrt(np.diagonal(P_T).clip(0))
        if not (std > 0).all() or np.linalg.eigvalsh(P_T / np.outer(std, std))[0] < SINGULAR:
            continue
        K = found @ T.T
        gain = _Noise(*(np.zeros((rows, F.dof)) for rows in shape))
        for factor, _, rows in system.noise:
            gain.stiff[place[id(factor)]] = -K[rows]
        K_seen = system.J @ K[-system.n :]
        for look, i, _, rows in system.seen:
            gain.seen[place[id(look), i]] = K_seen[rows]
        yield P_T, gain


def _until(graph, k):
    """Variables and factors of a run until instant k."""
    looks = [look for look in graph.looks if look.k <= k]
    stiff, told = [], {key for look in looks for key in look.lmks if isinstance(key, tuple)}
    for factor in graph.stiff:
        if isinstance(factor, Motion):
            begins, keys = factor.after[2], []
        elif isinstance(factor, Prior):
            begins, keys = 0, factor.keys
        else:
            begins, keys = factor.k, [factor.lmk]
        if begins <= k:
            stiff.append(factor)
            told.update(keys)
    there = lambda key: key in told or key[0] == "sensor" or (key[0] == "robot" and key[2] <= k)
    return [key for key in graph.values if there(key)], stiff, looks
