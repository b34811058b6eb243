"""MRPT, in C++: `mrpt_cpp/mrpt_slam.cpp` is built where MRPT and a compiler are found, and run on the circuit."""

import shutil
import subprocess
from pathlib import Path

import numpy as np

from ..circuit import SHORT
from ..world import R, U

SOURCE = Path(__file__).parent / "mrpt_cpp"
FAR = 1000.0  # m, further than anything


def build(folder):
    """Build the program.

    Returns
    -------
    Path

    Raises
    ------
    RuntimeError
        Saying what is missing.
    """
    for tool in ("cmake", "c++"):
        if not shutil.which(tool):
            raise RuntimeError(f"the program {tool} is not installed")
    for command in (
        ["cmake", "-DCMAKE_BUILD_TYPE=Release", "-S", SOURCE, "-B", folder],
        ["cmake", "--build", folder],
    ):
        run = subprocess.run(command, capture_output=True, text=True)
        if run.returncode:
            lines = run.stderr.strip().splitlines()
            if any("mrpt" in line.lower() and "find" in line.lower() for line in lines):
                raise RuntimeError("its libraries are not installed (Debian, Ubuntu: package libmrpt-slam-dev)")
            raise RuntimeError(f"it could not be built: {lines[-1] if lines else 'no message'}")
    return folder / "mrpt_slam"


def run(program, world, method, folder, told=True, too_slow=120):
    """One circuit.

    Parameters
    ----------
    program : Path
    world : World
    method : str
        `naive`: all measurements of a step at once; `davison`: one after another.
    folder : Path
        For the files that are exchanged.
    told : bool
        Whether it is told how far the sensor sees. Without, it predicts all landmarks and their covariances, always.

    Returns
    -------
    seconds : ndarray
        CPU of each step.
    pose : ndarray, shape (3,)
    """
    steps, answer = folder / "steps.txt", folder / "answer.txt"
    lines = [f"{len(world.steps)} {np.sqrt(R[0, 0])} {np.sqrt(R[1, 1])} {world.max_range if told else FAR}"]
    for step in world.steps:
        lines.append(" ".join(map(repr, [*step.u.tolist(), *U.ravel().tolist(), len(step.ids)])))
        lines += [f"{i} {r!r} {b!r}" for i, (r, b) in zip(step.ids, step.y.tolist(), strict=True)]
    steps.write_text("\n".join(lines) + "\n", encoding="utf-8")
    subprocess.run(
        [program, method, steps, answer, str(int(1e9 * SHORT))], check=True, capture_output=True, timeout=too_slow
    )
    lines = answer.read_text(encoding="utf-8").splitlines()
    n = len(world.steps)
    return 1e-9 * np.array(lines[:n], float), np.array(lines[n].split(), float)
