"""Compare the audit's numbers with those of smfeval, another program that scores poses with covariances.

    python -m pip install smfeval==0.4.0
    python tools/compare_smfeval.py

writes tests/analysis/smfeval.json: some poses in the SQUARE format, their truth, and what smfeval says of them. The
test `tests/analysis/test_estimate_files.py` compares with that, so smfeval is not needed to run it. Both compute the
NEES of the position (the tangent space of SE(3) at the estimate, right perturbation) and the chi-square interval of its
mean. smfeval has no NEES of the whole pose.
"""

import io
import json
from importlib.metadata import version
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation
from smfeval.io.header import parse_header  # pyright: ignore[reportMissingImports]
from smfeval.io.reader import iter_steps  # pyright: ignore[reportMissingImports]
from smfeval.scoring.logscore import (  # pyright: ignore[reportMissingImports]
    anees_consistency,
    gaussian_log_score_components,
)

POSES, TARGET = 40, Path(__file__).resolve().parent.parent / "tests" / "analysis" / "smfeval.json"
HEAD = """#%FORMAT SQUARE/0.3
#%REPRESENTATION gaussian_se3
#%POSE_FRAME map
#%BODY_FRAME base
#%GAUGE fixed
#%TIMESTAMP_UNIT s
#%ALGORITHM none
#%ALGORITHM_VERSION 1
#%TANGENT_CONVENTION right_perturbation
#%TANGENT_ORDER translation_rotation
#%ROTATION_PARAM axis_angle
"""


def poses(rng):
    """Rows of an estimate in the SQUARE format and of a truth in the TUM format, as text."""
    estimate, truth = [HEAD.rstrip()], []
    for k in range(POSES):
        A = rng.normal(size=(6, 6)) * np.array([0.1, 0.1, 0.1, 0.05, 0.05, 0.05])[:, None]
        P = A @ A.T
        R, t = Rotation.from_rotvec(rng.normal(size=3)), rng.normal(size=3) * 5
        e = np.linalg.cholesky(P) @ rng.normal(size=6)
        true_R, true_t = R * Rotation.from_rotvec(e[3:]), t + R.apply(e[:3])
        lower = P[np.tril_indices(6)]
        text = lambda *parts: " ".join(f"{v:.12g}" for part in parts for v in np.atleast_1d(part))
        estimate.append(text(0.1 * k, t, R.as_quat(), lower))
        truth.append(text(0.1 * k, true_t, true_R.as_quat()))
    return "\n".join(estimate) + "\n", "\n".join(truth) + "\n"


def main():
    """Write the file."""
    estimate, truth = poses(np.random.default_rng(1))
    file = io.StringIO(estimate)
    header = parse_header(file)
    steps = list(iter_steps(file, header))
    rows = np.loadtxt(io.StringIO(truth))
    parts = [
        gaussian_log_score_components(step, row[1:4], row[4:8], header.tangent_order).translation
        for step, row in zip(steps, rows, strict=True)
    ]
    nees = [part.nees for part in parts]
    mean = anees_consistency(np.array(nees), 3)
    kept = {"version": version("smfeval"), "estimate": estimate, "truth": truth, "position_nees": nees}
    kept |= {"anees": mean.anees, "low": mean.lo, "high": mean.hi}
    TARGET.write_text(json.dumps(kept, indent=1) + "\n", encoding="utf-8")
    print(f"{TARGET.name}: smfeval {kept['version']}, ANEES {mean.anees:.4f} in [{mean.lo:.4f}, {mean.hi:.4f}]")


if __name__ == "__main__":
    main()
