"""Exercise 17.2: frame by frame, whether the mean NEES of several runs is in its band."""

import numpy as np
from scipy.stats import chi2

from .. import expect
from ..exercise import Exercise


def in_band(nees, dof):
    """In which frames a filter is honest, judged from several runs.

    nees, shape (runs, frames): NEES of the pose. The runs are independent of each other, the frames of a run are not.
    dof: degrees of freedom of one NEES.
    In each frame the mean NEES over the runs should lie between two limits. They are symmetric in probability: of
    honest filters 2.5 % are below the lower one and 2.5 % above the upper one.
    Return True or False for each frame, shape (frames,).
    """
    runs = len(nees)
    low, high = chi2.ppf([0.025, 0.975], runs * dof) / runs
    mean = np.mean(nees, axis=0)
    return (mean >= low) & (mean <= high)


band = Exercise(
    "17.2",
    "ANEES over the frames",
    in_band,
    hints=(
        "First the mean over the *runs*, one number for each frame. Then its two limits, the same for all frames.",
        "The sum of R independent NEES is chi-square with R dof degrees of freedom; divide its limits by R.",
        "low, high = chi2.ppf([0.025, 0.975], R * dof) / R; compare with np.mean(nees, axis=0); join with &.",
    ),
)


def scan(rng, runs, dof, low=0.0, high=2.5, frames=300):
    """NEES whose mean over the runs rises slowly from low to high times dof: it shows where the limits are."""
    mean = np.linspace(low, high, frames) * dof
    spread = rng.uniform(0.2, 1.8, (runs, frames))
    return mean * spread / spread.mean(0)


def _flags(result, frames):
    flags = expect.array(result, frames, "the result")
    expect.true(np.isin(flags, (0, 1)).all(), "the result must be True or False for each frame")
    return flags


def _compare(f, nees, dof, at):
    got, want = _flags(f(nees, dof), nees.shape[1]), in_band(nees, dof)
    if not np.array_equal(got, want):
        k = int(np.argmax(got != want))
        raise expect.Failed(
            f"a mean NEES of {nees[:, k].mean():.3g}, {at}: you say {bool(got[k])}, it should be {bool(want[k])}"
        )


@band.link("one for each frame", "The mean is over the runs, axis 0: one truth value for each frame.")
def _(f, rng):
    for runs, frames in ((20, 7), (5, 30)):
        _flags(f(rng.uniform(1, 20, (runs, frames)), 6), frames)


@band.link("limits", "2.5 % of honest filters are below the lower limit (too cautious), 2.5 % above the upper one.")
def _(f, rng):
    wide = np.concatenate([scan(rng, 25, 6), scan(rng, 25, 6, 2.5, 40)], 1)
    _compare(f, wide, 6, "25 runs, dof 6")


@band.link("other numbers", "The limits depend on the number of runs and on dof.")
def _(f, rng):
    for runs, dof in ((4, 6), (10, 3), (1, 6)):
        _compare(f, scan(rng, runs, dof), dof, f"{runs} runs, dof {dof}")


def _wrong(name, hint, limits=None, mean=None, judge=None):
    """A misconception in the limits(runs, frames, dof), in the mean, or in the judgement(mean, low, high)."""

    @band.wrong(name, hint)
    def _(nees, dof):
        nees = np.asarray(nees)
        runs, frames = nees.shape
        low, high = limits(runs, frames, dof) if limits else chi2.ppf([0.025, 0.975], runs * dof) / runs
        m = mean(nees) if mean else nees.mean(0)
        return judge(m, low, high) if judge else (m >= low) & (m <= high)


# fmt: off
_wrong("limits of one run", "Those are the limits of *one* NEES. The mean of several runs scatters less.",
       lambda R, K, d: chi2.ppf([0.025, 0.975], d))
_wrong("frames counted, too", "The frames of a run hang together: they are not independent. Only the runs count.",
       lambda R, K, d: chi2.ppf([0.025, 0.975], R * K * d) / (R * K))
_wrong("frames instead of runs", "The mean is over the runs: their number counts, not that of the frames.",
       lambda R, K, d: chi2.ppf([0.025, 0.975], K * d) / K)
_wrong("degrees of freedom forgotten", "The sum of R NEES has R times dof degrees of freedom.",
       lambda R, K, d: chi2.ppf([0.025, 0.975], R) / R)
_wrong("limits of the sum", "Those are the limits of the sum. Divide by the number of runs.",
       lambda R, K, d: chi2.ppf([0.025, 0.975], R * d))
_wrong("limits of the mean over dof", "Those are limits around 1. The mean NEES is around dof: divide by the runs.",
       lambda R, K, d: chi2.ppf([0.025, 0.975], R * d) / (R * d))
_wrong("90 per cent", "2.5 % on each side: 0.025 and 0.975.", lambda R, K, d: chi2.ppf([0.05, 0.95], R * d) / R)
_wrong("no lower limit", "Too cautious is not honest either: there is a lower limit.",
       judge=lambda m, low, high: m <= high)
_wrong("no upper limit", "Over-confident is worse: there is an upper limit.", judge=lambda m, low, high: m >= low)
_wrong("where it is dishonest", "That is True where the filter is *not* honest.",
       judge=lambda m, low, high: (m < low) | (m > high))
_wrong("median", "The chi-square limits are those of the *mean* over the runs.", mean=lambda a: np.median(a, axis=0))
# fmt: on


@band.wrong("mean over the frames", "The frames of one run hang together. Take the mean over the runs: axis=0.")
def _(nees, dof):
    runs = len(nees)
    low, high = chi2.ppf([0.025, 0.975], runs * dof) / runs
    mean = np.mean(nees, axis=1)
    return (mean >= low) & (mean <= high)


@band.variant("with the sum")
def _(nees, dof):
    total = np.sum(nees, axis=0)
    p = chi2.cdf(total, len(nees) * dof)
    return np.abs(p - 0.5) <= 0.475


@band.variant("frame by frame")
def _(nees, dof):
    nees = np.asarray(nees)
    R = nees.shape[0]
    low, high = chi2.interval(0.95, R * dof)
    return [bool(low <= R * nees[:, k].mean() <= high) for k in range(nees.shape[1])]
