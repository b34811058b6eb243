"""Search for the parameters of Victoria Park: one at a time, from those that the package has.

    python tools/tune_park.py
    python tools/tune_park.py --only slip sensor.1.range_std

Each line is one setting with its RMSE to the best 95 % of GPS, the same after alignment, and the number of trees.
docs/data_tuning.md says how the settings in use were chosen.
"""

import argparse
from dataclasses import replace
from pathlib import Path

from ekfslam_tutorial.analysis import History
from ekfslam_tutorial.analysis.fixes import fix_figures
from ekfslam_tutorial.datasets import victoria_park
from ekfslam_tutorial.toolbox import UserData, universal_slam

SCENARIO = Path(__file__).resolve().parents[1] / "data" / "scenarios" / "victoria_park.toml"
FACTORS = {
    "noise": {"speed": (0.5, 1.5), "steer": (0.67, 1.67), "slip": (0.67, 1.33)},
    "calibration": {
        "bearing": (0.8, 1.2),
        "per_diameter": (0.0, 1.5),
        "steer_scale": (0.99, 1.01),
        "delay": (0.0, 2.0),
    },
    "scenario": {
        "sensor.1.range_std": (0.1, 0.25),
        "sensor.1.bearing_std_deg": (0.5, 1.0),
        "options.min_match_ratio": (0.15, 0.25),
        "options.min_search": (20,),
        "options.association": ({"type": "jcbb", "confidence": 0.99, "new_confidence": 0.999996},),
    },
}
"""What is tried: factors of the noise and the calibration, values of the scenario."""


def settings(only):
    """The settings to run: (label, calibration, noise, changes of the scenario)."""
    calibration, noise = victoria_park.CALIBRATION, victoria_park.NOISE
    yield "as it is", calibration, noise, {}
    for group, names in FACTORS.items():
        for name, values in names.items():
            if only and name not in only:
                continue
            for value in values:
                changed = lambda of, name=name, value=value: replace(of, **{name: value * getattr(of, name)})
                yield (
                    f"{name} {'' if group == 'scenario' else 'x '}{value}",
                    changed(calibration) if group == "calibration" else calibration,
                    changed(noise) if group == "noise" else noise,
                    {name: value} if group == "scenario" else {},
                )


def main():
    """Run the search and print it."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--only", nargs="+", default=[], help="names of the parameters to vary")
    parser.add_argument("--path", help="the file, or a folder with it; without it, below the folders of EKFSLAM_DATA")
    options = parser.parse_args()
    log = victoria_park.read_log(options.path)
    for label, calibration, noise, changes in settings(options.only):
        recording, history = victoria_park.recording(log, calibration, noise), History()
        for _ in history.watch(universal_slam(UserData.from_toml(SCENARIO, changes), recording)):
            pass
        f = fix_figures([history.track(1)], recording.fixes)
        figures = f"{f['gps_rmse_best95_m']:.3f} m, aligned {f['gps_rmse_best95_aligned_m']:.3f} m"
        print(f"{label[:48]:48} {figures}, {history.n_landmarks[-1]} trees", flush=True)


if __name__ == "__main__":
    main()
