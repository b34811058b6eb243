"""Which peers are here. One that is not is named, with the reason."""

import importlib
import os
import subprocess
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
CHECKOUTS = ROOT / "build" / "bench-peers"
PYTHON_ROBOTICS = "SLAM/EKFSLAM/ekf_slam.py"


@dataclass
class Peers:
    """Modules of this folder that could be imported, by name; and what is missing: name to reason.

    `versions` is of those that are no packages. `python_robotics` and `mrpt` are paths: of the file ekf_slam.py, and of
    the program that was built.
    """

    modules: dict = field(default_factory=dict)
    missing: dict = field(default_factory=dict)
    versions: dict = field(default_factory=dict)
    python_robotics: Path | None = None
    mrpt: Path | None = None

    def __getattr__(self, name):
        if name in self.__dict__.get("modules", {}):
            return self.modules[name]
        raise AttributeError(name)

    def __contains__(self, name):
        return name in self.modules


IMPORTS = {
    "filterpy_peer": "filterpy",
    "robotics_toolbox": "Robotics Toolbox",
    "stone_soup": "Stone Soup",
    "gtsam_peer": "GTSAM",
    "compiled": "numba",
}


def find():
    """Look for all peers, and build what must be built."""
    peers = Peers()
    for module, name in IMPORTS.items():
        try:
            peers.modules[module] = importlib.import_module(f".{module}", __package__)
        except Exception as error:
            peers.missing[name] = f"{type(error).__name__}: {error}"
    _find_python_robotics(peers)
    _find_mrpt(peers)
    return peers


def _find_python_robotics(peers):
    folder = Path(os.environ.get("PYTHON_ROBOTICS", CHECKOUTS / "PythonRobotics"))
    path = folder if folder.suffix == ".py" else folder / PYTHON_ROBOTICS
    if not path.is_file():
        peers.missing["PythonRobotics"] = (
            "it is no package; let the environment variable PYTHON_ROBOTICS name a checkout of it"
        )
        return
    try:
        peers.modules["python_robotics"] = importlib.import_module(".python_robotics", __package__)
        peers.python_robotics = path
        peers.python_robotics_load = peers.modules["python_robotics"].load(path)
        peers.versions["PythonRobotics"] = commit(folder)
    except Exception as error:
        peers.modules.pop("python_robotics", None)
        peers.missing["PythonRobotics"] = f"{type(error).__name__}: {error}"


def commit(folder):
    """The commit of a checkout, in short."""
    if not (folder / ".git").exists():
        return "(no checkout, version unknown)"
    run = subprocess.run(["git", "-C", folder, "rev-parse", "--short", "HEAD"], capture_output=True, text=True)
    return run.stdout.strip() or "(version unknown)"


def _find_mrpt(peers):
    module = importlib.import_module(".mrpt", __package__)
    try:
        peers.mrpt = module.build(CHECKOUTS / "mrpt")
        peers.modules["mrpt_peer"] = module
    except Exception as error:
        peers.missing["MRPT"] = str(error)
