"""Search for the noise parameters of the MRCLAM family: one at a time, from those that the package has.

    python tools/tune.py --set 7 --robots 1 2 --factors 0.7 1.4

Each line is one setting with its merit, the mean over the runs of ATE plus landmark RMSE after alignment, in metres.
docs/data_tuning.md says how the settings in use were chosen.
"""

import argparse
from dataclasses import fields, replace
from pathlib import Path

import numpy as np

from ekfslam_tutorial.analysis import History
from ekfslam_tutorial.datasets import mrclam
from ekfslam_tutorial.toolbox import UserData, universal_slam

SCENARIO = Path(__file__).resolve().parents[1] / "data" / "scenarios" / "mrclam_single.toml"


def merit(runs, odometry, sighting):
    """Mean of ATE plus landmark RMSE over runs (set, robot), alone, with these noises; metres."""
    sums = []
    for set, robot in runs:
        recording = mrclam.load(set, (robot,), odometry_noise=odometry, sighting_noise=sighting)
        history = History()
        for _ in history.watch(universal_slam(UserData.from_toml(SCENARIO).for_robots([robot]), recording)):
            pass
        figures = history.summary()
        sums.append(figures["ate_aligned_m"] + figures["landmark_rmse_aligned_m"])
    return float(np.mean(sums))


def settings(factors):
    """The settings in use, and each of their numbers times each factor: (label, odometry noise, sighting noise)."""
    noises = mrclam.ODOMETRY_NOISE, mrclam.SIGHTING_NOISE
    yield "as it is", *noises
    for k, noise in enumerate(noises):
        for field in fields(noise):
            for factor in factors:
                changed = list(noises)
                changed[k] = replace(noise, **{field.name: factor * getattr(noise, field.name)})
                yield f"{field.name} x {factor:g}", *changed


def main():
    """Run the search and print it."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--set", type=int, nargs="+", default=[7, 9])
    parser.add_argument("--robots", type=int, nargs="+", default=[1, 2, 3, 4, 5])
    parser.add_argument("--factors", type=float, nargs="+", default=[0.5, 0.7, 1.4, 2.0])
    options = parser.parse_args()
    runs = [(set, robot) for set in options.set for robot in options.robots]
    for label, odometry, sighting in settings(options.factors):
        print(f"{label:24} {merit(runs, odometry, sighting):.4f} m", flush=True)


if __name__ == "__main__":
    main()
