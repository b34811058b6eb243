"""Build the benchmark's own environment, `build/bench-env`, and fetch the peers. Standard library only.

What cannot be had is said and left out; `python -m benchmarks` names it in its report. Nothing is installed twice.
"""

import os
import re
import shutil
import subprocess
import sys
import venv
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
ENV = ROOT / "build" / "bench-env"
PYTHON = ENV / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
CHECKOUTS = ROOT / "build" / "bench-peers"
PYTHON_ROBOTICS = "https://github.com/AtsushiSakai/PythonRobotics"
NEEDED = ("numpy", "scipy", "matplotlib", "rich", "threadpoolctl", "ipywidgets")


def main():
    """Whatever is not there yet."""
    stamp = ENV / "complete.txt"
    wanted = [sys.base_prefix, *locked(), *peers()]
    there = stamp.read_text(encoding="utf-8").splitlines() if stamp.exists() else []
    if not PYTHON.exists() or there[:1] != wanted[:1]:
        print(f"Building build/bench-env with {sys.executable}: about a minute, 1 GB of disk", flush=True)
        venv.create(ENV, clear=True, with_pip=True)
        there = []
    if wanted != there:
        if not pip(locked()):
            sys.exit("The benchmark's environment cannot be built: what the package itself needs is not to be had.")
        done = locked() + [name for name in peers() if pip([name]) or print(f"{name}: not to be had, left out")]
        stamp.write_text("\n".join([sys.base_prefix, *done]), encoding="utf-8")
    if "PYTHON_ROBOTICS" not in os.environ and not (CHECKOUTS / "PythonRobotics").exists():
        python_robotics()
    mrpt()


def locked():
    """Requirements of the package with the versions of the main lock."""
    lock = (ROOT / "requirements.txt").read_text(encoding="utf-8")
    return [re.search(rf"^{name}==[^\s;]+", lock, re.MULTILINE)[0] for name in NEEDED]


def peers():
    """Requirements of the peers."""
    lines = (ROOT / "benchmarks" / "requirements.txt").read_text(encoding="utf-8").splitlines()
    return [line for line in lines if line and not line.startswith("#")]


def pip(requirements):
    """Install; whether it worked."""
    command = [PYTHON, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", *requirements]
    return subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL).returncode == 0


def python_robotics():
    """It is no package: a checkout, if there is a network."""
    command = ["git", "clone", "--quiet", "--depth", "1", PYTHON_ROBOTICS, CHECKOUTS / "PythonRobotics"]
    environment = os.environ | {"GIT_TERMINAL_PROMPT": "0"}
    try:
        if subprocess.run(command, env=environment, capture_output=True, timeout=120).returncode == 0:
            return
    except (OSError, subprocess.TimeoutExpired):
        pass
    print("PythonRobotics: its repository cannot be reached, left out (PYTHON_ROBOTICS=FOLDER names a checkout)")


def mrpt():
    """A C++ library of the system. It is installed where one is root, as in a container; else nothing is changed."""
    if Path("/usr/include/mrpt").exists() or not shutil.which("apt-get") or not hasattr(os, "getuid") or os.getuid():
        return
    print("Installing MRPT from the system's packages: libmrpt-slam-dev", flush=True)
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    environment = os.environ | {"DEBIAN_FRONTEND": "noninteractive"}
    install = ["apt-get", "install", "-y", "-qq", "--no-install-recommends", "libmrpt-slam-dev", "cmake", "g++"]
    for command in (["apt-get", "update", "-qq"], install):
        if subprocess.run(command, env=environment, **quiet).returncode:
            print("MRPT: it cannot be installed, left out")
            return


if __name__ == "__main__":
    main()
