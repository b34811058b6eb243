"""Very long runs: does the covariance stay a covariance, and the estimate honest, after a million steps?

    .venv/bin/python tools/long_run.py plane 1000000
    .venv/bin/python tools/long_run.py space 100000

Prints one JSON line; the tests run the same with fewer frames.
"""

import argparse
import json
import sys
import time
from pathlib import Path

import numpy as np

from ekfslam_tutorial.analysis.consistency import md2
from ekfslam_tutorial.analysis.progress import bar
from ekfslam_tutorial.toolbox import UserData
from ekfslam_tutorial.toolbox.universal_slam import universal_slam

SCENARIOS = Path(__file__).resolve().parent.parent / "data" / "scenarios"
WORLDS = {
    # Two rounds are 100 frames; here the robot goes round for days. Few landmarks: the steps are what counts.
    "plane": ("range_bearing_2d", {"sensor.max_range": 3.5}),
    "space": ("depth_camera", {"options.n_updates": 4, "options.max_lmks": 24, "options.capacity": 79}),
}


def counted(run, frames, shown):
    """Pass the snapshots of a run on, and show a bar meanwhile."""
    with bar(frames, "frames", shown=shown) as done:
        for s in run:
            yield s
            done.update()


def long_run(world, frames, looks=200, progress=False):
    """Drive round and round; look at the covariance now and then.

    Parameters
    ----------
    world : str
        'plane' or 'space'.
    frames : int
    looks : int
        How often to look at the whole covariance; each look is an eigenvalue decomposition.
    progress : bool

    Returns
    -------
    dict
        asymmetry, the largest |P - P'|; smallest_eigenvalue, in units of the largest; norm_error, the largest
        deviation of a quaternion from length 1; position_error_m and its largest sigma_m, and the pose's nees, of the
        last look; seconds of processor time.
    """
    scenario, changes = WORLDS[world]
    data = UserData.from_toml(SCENARIOS / f"{scenario}.toml", {**changes, "time.last": frames})
    worst = {"asymmetry": 0.0, "smallest_eigenvalue": 0.0, "norm_error": 0.0}
    run, every, began, last = universal_slam(data), max(1, frames // looks), time.process_time(), {}
    for k, s in enumerate(counted(run, frames, progress), 1):
        if k % every and k != frames:
            continue
        P, rob = s.map.P, s.robs[0]
        eigenvalues = np.linalg.eigvalsh(P)
        worst["asymmetry"] = max(worst["asymmetry"], float(np.abs(P - P.T).max()))
        worst["smallest_eigenvalue"] = min(worst["smallest_eigenvalue"], float(eigenvalues[0] / eigenvalues[-1]))
        F, T = rob.frame(s.map), rob.motion.frame(s.truth[rob.id])
        if F.dim == 3:
            worst["norm_error"] = max(worst["norm_error"], abs(float(np.linalg.norm(F.x[3:])) - 1.0))
        e, E_x = F.minus(T)
        C = E_x @ s.map.block(rob.r) @ E_x.T
        sigma = float(np.sqrt(np.linalg.eigvalsh(C[: F.dim, : F.dim])[-1]))
        error = float(np.linalg.norm(e[: F.dim]))
        last = {"position_error_m": error, "sigma_m": sigma, "nees": float(md2(e, C)), "landmarks": len(s.lmks)}
    return {"world": world, "frames": frames, **worst, **last, "seconds": time.process_time() - began}


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Run the filter for very long and look at its covariance.")
    parser.add_argument("world", choices=WORLDS)
    parser.add_argument("frames", type=int)
    given = parser.parse_args()
    print(json.dumps(long_run(given.world, given.frames, progress=sys.stderr.isatty())))
