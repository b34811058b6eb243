"""Errors that last, of known kinds: does the factor of `ekfslam tune` make a filter honest, and which of its parts?

    python tools/lasting_errors.py              # 16 walks, each with eight kinds of errors: half an hour
    python tools/lasting_errors.py --walks 2
    python tools/lasting_errors.py --in-full    # the filter is told all of the error, as if it were white

A robot walks 600 s in eights among landmarks of which it always sees some. To its simulated log, whose noise is white
and as the filter is told, an error is added that lasts. The filter runs on it; its corrections are summed along the
axes of the map and of the robot (`analysis.corrections`), its residuals are followed to its poses
(`analysis.influence`), and its NEES is divided by the factor that each of them gives: what a run with R and U times
that factor has. One is right. "Both" is the factor of `ekfslam tune`: the geometric mean of the larger sums and of the
residuals.
"""

import argparse
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from ekfslam_tutorial.analysis import History
from ekfslam_tutorial.analysis.corrections import SecondSums, correction_ratio
from ekfslam_tutorial.analysis.factors import GraphMaker
from ekfslam_tutorial.analysis.influence import influence
from ekfslam_tutorial.analysis.tuning import factor_of_both
from ekfslam_tutorial.toolbox import RawLog, Recorder, UserData, universal_slam

SCENARIO = Path(__file__).parents[1] / "data" / "scenarios" / "range_bearing_2d.toml"
EIGHT = [14.4] * 50 + [-14.4] * 50
"""Turn rates of an eight, deg/s: 25 s to the left, 25 s to the right, two circles of 4 m."""
WALK = {
    "world": {"type": "random2", "n": 34, "x_min": -7.0, "x_max": 7.0, "y_min": -15.0, "y_max": 7.0},
    "options.md2_threshold": 1e9,  # no gate: an error that lasts is not to be refused
}
BAND = 0.5, 1.7
"""NEES per degree of freedom of a robot that knows how wrong it is, as it is asked of real ones."""


def scenario(eights=12, told=None):
    """The scenario of a walk of so many eights, and what else its filter is told."""
    times = {"time.last": eights * len(EIGHT), "robot.1.w_deg": EIGHT * eights}
    return UserData.from_toml(SCENARIO, WALK | times | (told or {}))


def walk(seed, eights=12):
    """A walk with white noise: the scenario and the recording."""
    data, recorder = scenario(eights), Recorder()
    for s in universal_slam(data, seed=seed):
        recorder.add(s)
    log = recorder.recording(f"walk {seed}")
    return data, replace(log, robots={1: replace(log.robots[1], U=None)})


def lasting(log, rng):
    """The same log with each kind of error: its name, the recording, and the noise in full.

    That noise is what residuals look like to a user who takes them for white: the root of the sum of both squares.
    """
    raw, n = log.raw[1], len(log)
    frame = np.repeat(np.arange(n), np.diff(raw.offsets))
    dt = float(np.median(np.diff(log.t)))

    def last(seconds, *shape):
        """Noise of standard deviation 1 that is correlated over so many seconds, a row for each frame."""
        a, e = np.exp(-dt / seconds), rng.standard_normal((n, *shape))
        for k in range(1, n):
            e[k] = a * e[k - 1] + np.sqrt(1 - a * a) * e[k]
        return e

    def measured(d_range, d_bearing=0.0):
        d = np.stack(np.broadcast_arrays(d_range, d_bearing, raw.ids * 0.0)[:2], axis=1)
        return replace(log, raw={1: RawLog(1, raw.offsets, raw.ids, raw.y + d)})

    def commanded(u):
        return replace(log, robots={1: replace(log.robots[1], u=u)})

    u, each = log.robots[1].u, 1 + raw.ids.max()
    both = lambda noise, error: float(np.hypot(noise, error))
    yield "none: white noise", log, {}
    for seconds in (8, 30):
        error = 0.2 * last(seconds, each)[frame, raw.ids]
        yield f"range of each landmark, 0.2 m, {seconds} s", measured(error), {"sensor.1.range_std": both(0.1, 0.2)}
    yield "all ranges alike, 0.15 m, 30 s", measured(0.15 * last(30)[frame]), {"sensor.1.range_std": both(0.1, 0.15)}
    yield (
        "all bearings alike, 1.5 deg, 30 s",
        measured(0.0, np.deg2rad(1.5) * last(30)[frame]),
        {"sensor.1.bearing_std_deg": both(1.0, 1.5)},
    )
    yield (
        "controls, 0.08 m/s and 1.5 deg/s, 30 s",
        commanded(u + last(30, 2) * [0.08, np.deg2rad(1.5)]),
        {"robot.1.v_std": both(0.1, 0.08), "robot.1.w_std_deg": both(2.0, 1.5)},
    )
    yield "speeds 7 % too large", commanded(u * [1.07, 1.0]), {"robot.1.v_std": both(0.1, 0.07)}
    yield (
        "speeds 10 % and ranges 3 % too large",
        replace(measured(0.03 * raw.y[:, 0]), robots=commanded(u * [1.1, 1]).robots),
        {"robot.1.v_std": both(0.1, 0.1), "sensor.1.range_std": both(0.1, 0.1)},
    )


FACTORS = "as it is", "map", "robot", "the larger", "residuals", "both"


def judged(data, log):
    """NEES per degree of freedom of a run, divided by the factor that each rule gives, by the order of `FACTORS`."""
    history, maker = History(gauge="free"), GraphMaker(data, log)
    sums = [SecondSums(data.frame, along_robot=along) for along in (False, True)]
    for s in universal_slam(data, log):
        history.add(s)
        maker.add(s)
        for _, _, *poses in s.corrected:
            for each in sums:
                each.add(s.t, *poses)
    ratios = [correction_ratio([each.arrays]) for each in sums]
    by_map, by_robot = (ratio.factor if ratio.sure else 1.0 for ratio in ratios)
    try:
        its = influence(maker.finish())
    except ValueError:  # the smoother does not converge
        its = None
    both = factor_of_both(max(ratios, key=lambda ratio: ratio.value), its)
    factors = [1.0, by_map, by_robot, max(by_map, by_robot), its.factor if its and both > 1 else 1.0, both]
    return history.summary()["nees_per_dof"] / np.array(factors)


def study(seeds, in_full=False):
    """Walk after walk, each with every kind of error: seed, name of the kind, and its NEES by `FACTORS`."""
    for seed in seeds:
        data, log = walk(seed)
        for name, wrong, noise in lasting(log, np.random.default_rng(seed)):
            yield seed, name, judged(scenario(told=noise) if in_full else data, wrong)


def table(found):
    """For each kind the NEES as it is, and with the factor of each rule: lines of text.

    Parameters
    ----------
    found : dict of str to list of ndarray
        NEES of the walks, by name.
    """
    yield f"{'an error that lasts':40s} " + " ".join(f"{name:>14s}" for name in FACTORS) + "   walks"
    for name, rows in found.items():
        nees = np.array(rows)
        inside = np.mean((nees > BAND[0]) & (nees < BAND[1]), axis=0)
        cells = [f"{mean:.2f} ({share:.0%})" for mean, share in zip(nees.mean(0), inside, strict=True)]
        yield f"{name:40s} " + " ".join(f"{cell:>14s}" for cell in cells) + f" {len(rows):7d}"
    off = np.mean([np.abs(np.log(rows)).mean(0) for rows in found.values()], axis=0)
    yield f"{'mean of abs(log NEES) over all':40s} " + " ".join(f"{one:>14.2f}" for one in off)
    yield f"mean NEES per degree of freedom, 1 is right; in brackets the share of walks between {BAND[0]} and {BAND[1]}"


def main():
    """Print what each walk has, and at the end, or when it is interrupted, the table of all so far."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--walks", type=int, default=16)
    parser.add_argument("--in-full", action="store_true", help="tell the filter all of the error, as white noise")
    options = parser.parse_args()
    found = {}
    try:
        for seed, name, nees in study(range(1, options.walks + 1), options.in_full):
            found.setdefault(name, []).append(nees)
            numbers = " ".join(f"{one:.2f}" for one in nees)
            print(f"walk {seed} of {options.walks}, {name}: {numbers}", file=sys.stderr, flush=True)
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
    if found:
        print("\n".join(table(found)))


if __name__ == "__main__":
    main()
