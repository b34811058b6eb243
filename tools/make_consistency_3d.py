"""Write data/consistency_3d.npz, the Monte Carlo of notebook 17: `python tools/make_consistency_3d.py` (3 minutes).

Six ways to store landmarks, two qualities of odometry, 25 runs each with the seeds 1 to 25. For every second frame:
NEES of the robot's pose, position error (m), numbers in the map. A test runs some of them anew and compares.
"""

import numpy as np

from ekfslam_tutorial.course.draws.nb17_runs import KINDS, ODOMETRY, RUNS, live, stored_path

LIMIT_KB = 100


def main():
    """Make all series and write the file."""
    arrays = {}
    for odometry in ODOMETRY:
        for kind in KINDS:
            series = live(kind, odometry, range(1, RUNS + 1))
            arrays["k"] = series.k.astype(np.uint16)
            arrays[f"{kind}_{odometry}_nees"] = series.nees.astype(np.float32)
            arrays[f"{kind}_{odometry}_off"] = series.off.astype(np.float16)
            arrays[f"{kind}_{odometry}_states"] = series.states.astype(np.uint16)
            print(f"{odometry:5} {kind:10} ANEES {series.anees[-1]:7.1f}, off by {series.rms[-1]:.3f} m", flush=True)
    path = stored_path()
    np.savez_compressed(path, **arrays)
    size = path.stat().st_size / 1000
    assert size < LIMIT_KB, f"{path.name} has {size:.0f} kB, more than {LIMIT_KB} kB"
    print(f"{path.name}: {size:.0f} kB")


if __name__ == "__main__":
    main()
