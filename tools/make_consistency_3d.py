"""Write data/consistency_3d.npz, the Monte Carlo of notebook 17: `python tools/make_consistency_3d.py` (3 minutes).

Six ways to store landmarks, two qualities of odometry, 25 runs each with the seeds 1 to 25. For every second frame:
NEES of the robot's pose, position error (m), numbers in the map. User data and loop are those of the notebook's cells.
A test runs some of them anew and compares.
"""

import numpy as np

from ekfslam_tutorial.course import registry
from ekfslam_tutorial.course.cells import experiment_of
from ekfslam_tutorial.course.draws.nb17 import EVERY, KINDS, ODOMETRY, RUNS, Series, stored_path

LIMIT_KB = 100


def notebook():
    """What the cells of notebook 17 define: `user_data` and `one_run`."""
    return experiment_of("17", pose_nees=registry.get("17.1").reference)


def series(cells, kind, odometry="good", seeds=(1, 2, 3), last=100):
    """Make runs now. Run `seed` is that of the stored series."""
    runs = [cells["one_run"](cells["user_data"](kind, odometry, last), seed) for seed in seeds]
    k, nees, off, states = np.array(runs)[:, :, EVERY - 1 :: EVERY].transpose(1, 0, 2)
    return Series(k[0], nees, off, states)


def main():
    """Make all series and write the file."""
    arrays, cells = {}, notebook()
    for odometry in ODOMETRY:
        for kind in KINDS:
            made = series(cells, kind, odometry, range(1, RUNS + 1))
            arrays["k"] = made.k.astype(np.uint16)
            arrays[f"{kind}_{odometry}_nees"] = made.nees.astype(np.float32)
            arrays[f"{kind}_{odometry}_off"] = made.off.astype(np.float16)
            arrays[f"{kind}_{odometry}_states"] = made.states.astype(np.uint16)
            print(f"{odometry:5} {kind:10} ANEES {made.anees[-1]:7.1f}, off by {made.rms[-1]:.3f} m", flush=True)
    path = stored_path()
    np.savez_compressed(path, **arrays)
    size = path.stat().st_size / 1000
    assert size < LIMIT_KB, f"{path.name} has {size:.0f} kB, more than {LIMIT_KB} kB"
    print(f"{path.name}: {size:.0f} kB")


if __name__ == "__main__":
    main()
