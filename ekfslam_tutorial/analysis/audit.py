"""Is an estimator honest? Errors of one or many runs against the covariances that came with them.

The question is one of statistics, and it has two difficulties. Errors of one run follow each other: 1,000 poses are not
1,000 independent numbers, so a chi-square band for 1,000 poses is much too narrow. And a band that is wide enough is
worth nothing if nobody says what it would have found. So here

* the degrees of freedom of a mean are measured (`effective_dof`), from how alike the errors of different runs are;
* a verdict comes with its power: how many such runs would find covariances that are off by a factor of 1.2.

Y. Bar-Shalom, X. R. Li, T. Kirubarajan, "Estimation with Applications to Tracking and Navigation", Wiley 2001, section
5.4, has the tests for independent numbers. The mean of correlated ones is taken for chi-square with the degrees of
freedom that give it its variance: F. E. Satterthwaite, Biometrics Bulletin 2(6):110-114, 1946.
"""

import math
from dataclasses import dataclass, field

import numpy as np

from ..ekf import chi_square
from .consistency import md2

FACTOR, POWER = 1.2, 0.9
"""The power that is told: to find covariances that are off by this factor, with this probability."""
SEVERAL = 8
"""From so many runs on, correlations in time are measured between runs; with fewer, inside each."""
QUADRUPLES = 3000
"""So many fours of runs are drawn for that."""
LEVELS = 0.5, 0.68, 0.9, 0.95, 0.99
"""Regions whose coverage is told."""


@dataclass(frozen=True)
class RunErrors:
    """Errors of one run and their covariances, in one gauge.

    Parameters
    ----------
    name : str
    t : ndarray, shape (F,)
        s.
    e : ndarray, shape (F, dof)
        Errors of the pose: position (m), then angle or angles (rad).
    P : ndarray, shape (F, dof, dof)
    map_nees : float
        Squared Mahalanobis distance of the map, modulo its gauge; NaN if there is none.
    map_dof : int
    map_u : ndarray, shape (n, d)
        Whitened errors of landmarks of which there is no joint covariance, in the same order in all runs.
    z : ndarray, shape (K, m)
        Whitened innovations L^-1 z with L L' = Z, in the order of time; a row of NaN between two series.
    nis : ndarray, shape (K, 2)
        Normalised innovations squared, and their degrees of freedom.
    """

    name: str
    t: np.ndarray
    e: np.ndarray
    P: np.ndarray
    map_nees: float = math.nan
    map_dof: int = 0
    map_u: np.ndarray = field(default_factory=lambda: np.zeros((0, 0)))
    z: np.ndarray = field(default_factory=lambda: np.zeros((0, 0)))
    nis: np.ndarray = field(default_factory=lambda: np.zeros((0, 2)))

    @property
    def dim(self):
        """Size of a position."""
        return {3: 2, 6: 3}[self.e.shape[1]]

    @property
    def nees(self):
        """NEES of each pose, shape (F,); NaN where there is none."""
        return md2(self.e, self.P)


@dataclass(frozen=True)
class Finding:
    """Verdict on one kind of numbers: its mean over all, per degree of freedom, and the band of an honest estimator.

    Parameters
    ----------
    ratio : float
        Mean over the degrees of freedom: 1 for an honest estimator; c if its covariances are too small by a factor c.
    dof : float
        Degrees of freedom of that mean, as many as independent numbers would have.
    runs : int
    low, high : float
        Band of `ratio`, of the probability `Audit.level`.
    word : str
        'as it should be', 'over-confident', 'too cautious' or 'not known'.
    runs_needed : int or None
        So many such runs find a factor of 1.2 with a probability of 90 %.
    """

    ratio: float
    dof: float
    runs: int
    low: float
    high: float
    word: str
    runs_needed: int | None


def whitened(e, P):
    """L^-1 e with L L' = P: independent numbers of variance 1, if P is right.

    Parameters
    ----------
    e : ndarray, shape (..., n)
    P : ndarray, shape (..., n, n)

    Returns
    -------
    ndarray, shape (..., n)
        NaN where P is not positive definite.

    See Also
    --------
    md2 : Its squared length.
    """
    usable = np.isfinite(md2(e, P))
    std = np.sqrt(np.diagonal(P, axis1=-2, axis2=-1), where=usable[..., None], out=np.ones(e.shape))
    C = np.where(usable[..., None, None], P / (std[..., :, None] * std[..., None, :]), np.eye(e.shape[-1]))
    u = np.linalg.solve(np.linalg.cholesky(C), (e / std)[..., None])[..., 0]
    return np.where(usable[..., None], u, np.nan)


def effective_dof(u, rng=None):
    """Degrees of freedom per run of the mean of squared errors that follow each other.

    Let S be the sum of |u_t|^2 over a run, u_t white in its components but not in time, C_st = E u_s u_t'. Then S has
    the variance 2 sum |C_st|^2, and is nearly chi-square, scaled, with (E S)^2 / sum |C_st|^2 degrees of freedom.

    With many runs of the same length, for four of them A, B, C, D the number ((u_A - u_B) . (u_C - u_D))^2 / 4 has the
    mean sum |C_st|^2: no matter how the errors are correlated, and whatever bias all runs have in common. With few
    runs the correlation is taken to be the same all over a run, and summed up to the first lag at which it is noise.

    Parameters
    ----------
    u : sequence of ndarray, shape (F, dof)
        Whitened errors of each run, NaN where not known.
    rng : numpy.random.Generator, optional
        Draws the fours.

    Returns
    -------
    float
    """
    u = [a[np.isfinite(a).all(-1)] for a in u]
    size, squares = np.mean([a.size for a in u]), np.mean([(a**2).sum() for a in u])
    if not squares > 0:
        return math.nan
    if len(u) >= SEVERAL and len({len(a) for a in u}) == 1:
        flat = np.array([a.ravel() for a in u])
        G = flat @ flat.T
        rng = rng or np.random.default_rng(0)
        a, b, c, d = np.argpartition(rng.random((QUADRUPLES, len(u))), 4, axis=1)[:, :4].T
        spread = np.mean((G[a, c] - G[a, d] - G[b, c] + G[b, d]) ** 2) / 4
    else:
        spread = np.mean([_spread(a) for a in u])
    return float(np.clip(squares**2 / spread, 1.0, size))


def _spread(u):
    """Estimate of sum |C_st|^2 from one run, component by component, as if its correlation were the same all along."""
    n = len(u)
    total = 0.0
    for column in u.T:
        f = np.fft.rfft(column, 2 * n)
        c = np.fft.irfft(f * f.conj())[:n] / n  # sums over fewer pairs at larger lags: damped, as they should be
        noise = c[0] * 2 / math.sqrt(n)
        last = int(np.argmax(np.abs(c) < noise)) if (np.abs(c) < noise).any() else n
        k = np.arange(1, last)
        total += n * c[0] ** 2 + 2 * ((n - k) * c[1:last] ** 2).sum()
    return total


def judge(ratio, dof, runs, confidence=0.95):
    """Compare a mean with the band of an honest estimator, and say what such a comparison can find.

    Parameters
    ----------
    ratio : float
        Mean per degree of freedom.
    dof : float
        Degrees of freedom per run.
    runs : int
    confidence : float
        Of the band.

    Returns
    -------
    Finding
    """
    if not runs or not (math.isfinite(ratio) and math.isfinite(dof)):
        return Finding(math.nan, math.nan, 0, math.nan, math.nan, "not known", None)
    low, high = _band(runs * dof, confidence)
    word = "over-confident" if ratio > high else "too cautious" if ratio < low else "as it should be"
    return Finding(float(ratio), float(runs * dof), runs, low, high, word, runs_needed(dof, confidence))


def _band(dof, confidence):
    tail = (1 - confidence) / 2
    low, high = chi_square.quantile(np.array([tail, 1 - tail]), dof) / dof
    return float(low), float(high)


def power(dof, factor=FACTOR, confidence=0.95):
    """Probability that covariances too small by a factor are found, by a mean with so many degrees of freedom."""
    low, high = _band(dof, confidence)
    found = chi_square.cdf(dof * low / factor, dof) + 1 - chi_square.cdf(dof * high / factor, dof)
    return float(found)


def runs_needed(dof, confidence=0.95, factor=FACTOR, wanted=POWER):
    """Return the smallest number of runs, each with so many degrees of freedom, that find a factor.

    Parameters
    ----------
    dof : float
        Per run.
    confidence : float
        Of the band.
    factor : float
        Covariances are too small by it.
    wanted : float
        Probability to find it.

    Returns
    -------
    int

    Examples
    --------
    >>> runs_needed(3), runs_needed(60)
    (209, 11)
    """
    low, high = 0, 1
    while power(high * dof, factor, confidence) < wanted:
        low, high = high, 2 * high
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if power(middle * dof, factor, confidence) >= wanted else (middle, high)
    return high


@dataclass(frozen=True)
class Audit:
    """All findings on an estimator.

    Parameters
    ----------
    runs : list of RunErrors
    pose, position, rotation, map, innovations : Finding
        `pose` is all numbers of a pose together.
    coverage : dict of float to float
        Share of all poses inside the region that should hold this share.
    last : dict of float to float
        The same of the last pose of each run alone: these are independent of each other.
    per_axis : ndarray, shape (dof,)
        Mean square of each error over what P says it is.
    bias : ndarray, shape (dof,)
        Mean of the whitened errors in all runs: near 0.
    whiteness : tuple of float
        Correlation of whitened innovations that follow each other, and the band +-b of 95 % for white ones.
    confidence : float
        Of the verdict.
    level : float
        Of each band: with k parts it leaves out a k-th of what the verdict does, so that an honest estimator is called
        so with the confidence asked for.
    """

    runs: list
    pose: Finding
    position: Finding
    rotation: Finding
    map: Finding
    innovations: Finding
    coverage: dict
    last: dict
    per_axis: np.ndarray
    bias: np.ndarray
    whiteness: tuple
    confidence: float
    level: float

    @property
    def parts(self):
        """Findings that count for the verdict, by name: pose, map, innovations, as far as there are any."""
        named = {"pose": self.pose, "map": self.map, "innovations": self.innovations}
        return {name: part for name, part in named.items() if part.word != "not known"}

    @property
    def white(self):
        """True if the innovations are white, or not known."""
        value, band = self.whiteness
        return not abs(value) > band

    @property
    def verdict(self):
        """'honest', 'over-confident', 'too cautious', 'not honest' if parts disagree, or 'not known'.

        Whiteness is told beside it: it says that the model is wrong, not which way.
        """
        if not self.parts:
            return "not known"
        words = {part.word for part in self.parts.values()} - {"as it should be"}
        return "honest" if not words else words.pop() if len(words) == 1 else "not honest"

    @property
    def sentence(self):
        """The verdict in words that do not promise more than the runs can tell."""
        needed, n = self.pose.runs_needed, len(self.runs)
        halves = {"position": self.position, "rotation": self.rotation}
        usual = "as it should be", "not known", self.verdict
        others = [
            f"{name} is {part.word} ({part.ratio:.2f})" for name, part in halves.items() if part.word not in usual
        ]
        but = "".join(f"; but {words}" for words in others)
        if self.verdict == "honest" and needed and n < needed:
            sure = f"honest, as far as {n} run{'s' * (n > 1)} can tell ({needed} would find a factor of {FACTOR:g})"
            return sure + but
        return self.verdict + but

    def summary(self):
        """All figures as a dictionary for JSON, None where one is not known."""
        known = lambda v: None if v is None or not np.isfinite(v) else float(v)
        part = lambda f: {k: v if isinstance(v, str | int) else known(v) for k, v in vars(f).items()}
        names = "pose", "position", "rotation", "map", "innovations"
        return {
            "verdict": self.verdict,
            "sentence": self.sentence,
            "confidence": self.confidence,
            "level": self.level,
            "runs": len(self.runs),
            "frames": [len(run.t) for run in self.runs],
            "factor": FACTOR,
            "power": POWER,
            **{name: part(getattr(self, name)) for name in names},
            "coverage": {f"{p:g}": known(v) for p, v in self.coverage.items()},
            "coverage_last": {f"{p:g}": known(v) for p, v in self.last.items()},
            "per_axis": [known(v) for v in self.per_axis],
            "bias": [known(v) for v in self.bias],
            "whiteness": {"correlation": known(self.whiteness[0]), "band": known(self.whiteness[1])},
            "per_run": [
                {"name": run.name, "nees_mean": known(_mean(run.nees)), "map_nees": known(run.map_nees)}
                for run in self.runs
            ],
        }


def audit(runs, confidence=0.95):
    """Audit an estimator.

    Parameters
    ----------
    runs : sequence of RunErrors
        Independent of each other.
    confidence : float
        Of the verdict.

    Returns
    -------
    Audit

    Raises
    ------
    ValueError
        If there are no runs, or some are in the plane and others in space.
    """
    runs = list(runs)
    if not runs:
        raise ValueError("an audit needs at least one run")
    if len({run.e.shape[1] for run in runs}) > 1:
        raise ValueError("some runs are in the plane and others in space: audit them one kind at a time")
    d, dof = runs[0].dim, runs[0].e.shape[1]
    e, P = (np.concatenate([getattr(run, name) for run in runs]) for name in ("e", "P"))
    ends = np.cumsum([len(run.t) for run in runs])[:-1]
    u = whitened(e, P)
    known, nees = np.isfinite(u).all(1), np.split((u**2).sum(1), ends)
    variances = np.diagonal(P, axis1=1, axis2=2)[known]
    part = lambda s: _poses(np.split(whitened(e[:, s], P[:, s, s]), ends))
    means = {
        "pose": _poses(np.split(u, ends)),
        "position": part(slice(0, d)),
        "rotation": part(slice(d, None)),
        "map": _maps(runs),
        "innovations": _innovations(runs),
    }
    counted = sum(means[name] != NOTHING for name in ("pose", "map", "innovations"))
    level = 1 - (1 - confidence) / max(counted, 1)
    return Audit(
        runs,
        **{name: judge(mean[0], mean[1], mean[2], level) for name, mean in means.items()},
        coverage=_coverage(np.concatenate(nees), dof),
        last=_coverage(np.array([n[np.isfinite(n)][-1] for n in nees if np.isfinite(n).any()]), dof),
        per_axis=(e[known] ** 2 / variances).mean(0) if known.any() else np.full(dof, np.nan),
        bias=u[known].mean(0) if known.any() else np.full(dof, np.nan),
        whiteness=_whiteness(runs),
        confidence=confidence,
        level=level,
    )


NOTHING = None, None, 0


def _poses(u):
    """Mean per degree of freedom, degrees of freedom per run, runs."""
    u = [a for a in u if np.isfinite(a).all(-1).any()]
    if not u:
        return NOTHING
    return np.mean([(a[np.isfinite(a).all(-1)] ** 2).mean() for a in u]), effective_dof(u), len(u)


def _maps(runs):
    values = [(run.map_nees, run.map_dof) for run in runs if np.isfinite(run.map_nees) and run.map_dof]
    return _of_sums(values) if values else _poses([run.map_u for run in runs if len(run.map_u)])


def _innovations(runs):
    values = [run.nis.sum(0) for run in runs if len(run.nis)]
    return _of_sums(values) if values else NOTHING


def _of_sums(values):
    squares, dof = np.array(values, float).T
    return squares.sum() / dof.sum(), dof.mean(), len(values)


def _coverage(nees, dof):
    nees = nees[np.isfinite(nees)]
    return {p: float((nees <= chi_square.quantile(p, dof)).mean()) if len(nees) else math.nan for p in LEVELS}


def _whiteness(runs):
    """Mean product of whitened innovations and those before them, and its 95 % band."""
    finite = lambda a: a[np.isfinite(a)]
    products = [finite((run.z[1:] * run.z[:-1]).ravel()) for run in runs if len(run.z) > 1]
    squares = [finite((run.z**2).ravel()) for run in runs if len(run.z) > 1]
    n = sum(map(len, products))
    if not n:
        return math.nan, math.nan
    return float(np.concatenate(products).mean() / np.concatenate(squares).mean()), 1.96 / math.sqrt(n)


def _mean(a):
    a = a[np.isfinite(a)]
    return a.mean() if len(a) else math.nan
