"""Exercise 17.2: frame by frame, whether the mean NEES of several runs is in its band."""

import numpy as np
from scipy.stats import chi2

from .. import expect
from ..table import table


def in_band(nees, dof):
    """In which frames a filter is honest, judged from several runs.

    nees, shape (runs, frames): NEES of the pose. The runs are independent of each other, the frames of a run are not.
    dof: degrees of freedom of one NEES.
    In each frame the mean NEES over the runs should lie between two limits. They are symmetric in probability: of
    honest filters 2.5 % are below the lower one and 2.5 % above the upper one.
    Return True or False for each frame, shape (frames,).
    """
    runs, frames = nees.shape
    low, high = chi2.ppf([0.025, 0.975], runs * dof) / runs
    mean = np.mean(nees, axis=0)
    return (mean >= low) & (mean <= high)


def scan(rng, runs, dof, low=0.0, high=2.5, frames=300):
    """NEES whose mean over the runs rises slowly from low to high times dof: it shows where the limits are."""
    mean = np.linspace(low, high, frames) * dof
    spread = rng.uniform(0.2, 1.8, (runs, frames))
    return mean * spread / spread.mean(0), dof


band = table(
    "17.2 ANEES over the frames",
    in_band,
    hints=(
        "First the mean over the *runs*, one number for each frame. Then its two limits, the same for all frames.",
        "The sum of R independent NEES is chi-square with R dof degrees of freedom; divide its limits by R.",
        "low, high = chi2.ppf([0.025, 0.975], R * dof) / R; compare with np.mean(nees, axis=0); join with &.",
    ),
    returns="honest",
    symbols="R = the number of runs",
    form="The mean is over the runs, axis 0: one truth value for each frame.",
    cases={
        "any": lambda rng: [(rng.uniform(1, 20, (runs, n)), 6) for runs, n in ((20, 7), (5, 30))],
        "rising": lambda rng: [  # each mistake shows in other frames
            scan(rng, runs, dof, frames=100) for runs, dof in ((25, 6), (12, 3), (4, 6), (10, 3), (2, 2), (1, 6))
        ],
    },
    checks="",
    wrong="""
    limits of one run | runs * dof) / runs -> dof) | Those are the limits of *one* NEES. The mean of several runs scatters less.
    frames counted, too | runs * dof) / runs -> runs * frames * dof) / (runs * frames) | The frames of a run are correlated: they are not independent. Only the runs count.
    frames instead of runs | runs * dof) / runs -> frames * dof) / frames | The mean is over the runs: their number counts, not that of the frames.
    degrees of freedom forgotten | runs * dof) / runs -> runs) / runs | The sum of R NEES has R times dof degrees of freedom.
    limits of the sum | runs * dof) / runs -> runs * dof) | Those are the limits of the sum. Divide by the number of runs.
    limits of the mean over dof | runs * dof) / runs -> runs * dof) / (runs * dof) | Those are limits around 1. The mean NEES is around dof: divide by the runs.
    90 per cent | [0.025, 0.975] -> [0.05, 0.95] | 2.5 % on each side: 0.025 and 0.975.
    no lower limit | (mean >= low) & (mean <= high) -> mean <= high | Too cautious is not honest either: there is a lower limit.
    no upper limit | (mean >= low) & (mean <= high) -> mean >= low | Over-confident is worse: there is an upper limit.
    where it is dishonest | (mean >= low) & (mean <= high) -> (mean < low) | (mean > high) | That is True where the filter is *not* honest.
    mean of all frames | np.mean(nees, axis=0) -> np.full(frames, np.mean(nees)) | Each frame has its own mean, over the runs: np.mean(nees, axis=0). Yours is one mean of all frames.
    sum for the mean | np.mean( -> np.sum( | These are the limits of the *mean* over the runs: divide the sum by their number.
    median | np.mean( -> np.median( | The chi-square limits are those of the *mean* over the runs.
    mean over the frames | axis=0 -> axis=1 | The frames of one run are correlated. Take the mean over the runs: axis=0.
    degrees of freedom less one | runs * dof) / runs -> max(runs - 1, 1) * dof) / max(runs - 1, 1) | Nothing was estimated from the runs: R dof degrees of freedom, not (R - 1) dof.
    dof always 6 | runs * dof) / runs -> runs * 6) / runs | The degrees of freedom of one NEES are the argument dof: 6 is one case only.
    mean divided by dof | np.mean(nees, axis=0) -> np.mean(nees, axis=0) / dof | The mean NEES of honest filters is around dof, and so are the two limits: all three are taken as they are, or all three divided by dof.
    only an upper limit, of 95 per cent: Too cautious is not honest either: 2.5 % on each side, a lower and an upper limit.
        [0.025, 0.975] -> [0.0, 0.95]
        (mean >= low) & (mean <= high) -> mean <= high
    one run lost | runs * dof) / runs -> (runs - 1) * dof) / runs | Nothing is estimated from the runs: all of them count, runs times dof degrees of freedom.
    share of the runs in the band of one: The mean over the runs is asked for, and its band is narrower. Yours counts how many of them are in the band of one NEES.
        return (mean >= low) & (mean <= high) -> one = chi2.ppf([0.025, 0.975], dof); return np.mean((nees >= one[0]) & (nees <= one[1]), axis=0) >= 0.95
    mean over the frames so far | mean = np.mean(nees, axis=0) -> mean = np.cumsum(np.mean(nees, axis=0)) / np.arange(1, frames + 1) | Each frame is judged alone: the frames before it are correlated with it, and no mean over them is taken.
    limits of one run, drawn together | low, high = chi2.ppf([0.025, 0.975], runs * dof) / runs -> low, high = dof + (chi2.ppf([0.025, 0.975], dof) - dof) / np.sqrt(runs) | The mean of several runs is no NEES drawn together: its sum is chi-square with runs times dof degrees of freedom.
    runs and degrees of freedom added | runs * dof -> (runs + dof) | Each of the runs brings dof degrees of freedom: runs *times* dof.
    normal for chi-square | chi2.ppf([0.025, 0.975], runs * dof) / runs -> dof + np.array([-1.96, 1.96]) * np.sqrt(2 * dof / runs) | dof +- 1.96 sqrt(2 dof / runs) is good for many runs only: chi-square is not symmetric. Take chi2.ppf.
    """,
)


def _compare(f, nees, dof):
    got, want = expect.array(f(nees, dof), nees.shape[1], "honest"), in_band(nees, dof)
    expect.true(np.isin(got, (0, 1)).all(), "the result must be True or False for each frame")
    if not np.array_equal(got, want):
        k = int(np.argmax(got != want))
        at = f"a mean NEES of {nees[:, k].mean():.3g}, {len(nees)} runs, dof {dof}"
        raise expect.Failed(f"{at}: you say {bool(got[k])}, it should be {bool(want[k])}")


@band.link(
    "limits",
    "2.5 % of honest filters are below the lower limit (too cautious), 2.5 % above the upper one. The sum over the runs is chi-square with runs times dof degrees of freedom; the mean is that divided by runs.",
)
def _(f, rng):
    for limits in ((0, 2.5), (2.5, 40)):
        _compare(f, *scan(rng, 25, 6, *limits))


@band.link(
    "other numbers",
    "The runs are 1, 2, 4 or 10, and dof is 2, 3 or 6. Both limits follow from these two numbers: chi-square with runs times dof degrees of freedom, divided by runs.",
)
def _(f, rng):
    for runs, dof in ((4, 6), (10, 3), (2, 2), (1, 6)):
        _compare(f, *scan(rng, runs, dof))
