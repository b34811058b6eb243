"""What is fuzzed: for each kind of file, valid examples, how bytes become a file, and the function that reads it.

The input of a target is a pair (member, bytes): the bytes take the place of one member of a valid file (a file of a
folder, an array of an npz), or of the whole file when the member is None. So the checksums of a zip do not hide what
lies behind them; the checksum of a checkpoint is made anew, as somebody who means harm would do.
"""

import io
import json
import os
import tempfile
import zipfile
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ekfslam_tutorial.analysis import series
from ekfslam_tutorial.datasets.mrclam_log import read_set
from ekfslam_tutorial.datasets.victoria_park import read_log
from ekfslam_tutorial.simulation import SimLmk
from ekfslam_tutorial.toolbox import (
    ControlLog,
    RawLog,
    Recording,
    UserData,
    parse_override,
)
from ekfslam_tutorial.toolbox.files import value_file

SCENARIO = """name = "flat"
[time]
dt = 0.5
last = 50
[world]
type = "ring"
n = 12
[[robot]]
motion = "unicycle"
position = [0, -4.0]
v = 1.0
w_deg = 14.4
v_std = 0.05
[[sensor]]
type = "range_bearing"
range_std = 0.1
bearing_std_deg = 1.0
max_range = 6.0
[landmark]
type = "euc_pnt"
[options]
n_inits = [10, 1]
md2_threshold = 9.0
"""
REFUSALS = {
    "npz": (ValueError,),
    "csv": (ValueError, FileNotFoundError),
    "toml": (ValueError, TypeError),
    "mrclam": (ValueError, FileNotFoundError),
    "override": (ValueError,),
}


@dataclass
class Target:
    """One kind of file.

    Parameters
    ----------
    read : callable
        (member, bytes) -> whatever the reader returns.
    seeds : list of (member, bytes)
        Members of a valid file.
    refusals : tuple of exceptions
        What its documentation says it raises.
    share : int
        Of the inputs of a run.
    words : list of bytes
        What else to put in the place of a number.
    head : int
        Length of the head of a member; every other input leaves it as it is, to come to what lies behind it.
    """

    read: Callable
    seeds: list
    refusals: tuple
    share: int = 1
    words: list = field(default_factory=list)
    head: int = 0


def targets(folder):
    """All targets by name. Files are written below `folder`."""
    folder, example = Path(folder), recording()
    example.save(folder / "seed.npz")
    value_file.save(
        folder / "values.npz", {"x": np.arange(100.0), "list": [1, 2.5, None], "rows": [(1.0, 2.0), (3.0, 4.0)]}
    )
    return {
        "recording npz": npz_target(folder / "seed.npz", Recording.load, 3),
        "recording CSV": folder_target(example.save(folder / "csv"), 3),
        "scenario TOML": scenario_target(folder),
        "override": Target(
            lambda _, data: parse_override(data.decode(errors="replace")),
            [(None, text) for text in (b"data.set=7", b"robot.1.dx_std=[0.01, 0, 0]", b'name = "x"', b"a.b={c = 1}")],
            REFUSALS["override"],
        ),
        "MRCLAM text": mrclam_target(),
        "checkpoint": npz_target(folder / "values.npz", value_file.load, 2, resign),
        "Monte-Carlo npz": npz_target(series_file(folder), series.read, 1),
        "Victoria Park npz": npz_target(park_file(folder), read_log, 1),
    }


def recording():
    """A small recording with all there can be in one."""
    eye, ids = np.tile(np.eye(2), (3, 1, 1)), np.array([4, -1, 7])
    raw = RawLog(1, np.array([0, 1, 1, 3]), ids, np.ones((3, 2)), eye)
    met = RawLog(1, np.array([0, 0, 1, 1]), np.array([2]), np.ones((1, 2)))
    truth = np.array([[0, 0, 0], [np.nan] * 3, [1, 2, 3.0]])
    fixes = np.array([[0.5, 1, 2.0]])
    points = SimLmk(np.array([4, 7]), np.array([[1, 2.0], [3, 4]]))
    robots = {1: ControlLog(np.ones((3, 2)), eye)}
    t = np.array([0.1, 0.2, 0.3])
    return Recording("seed", t, robots, {1: raw}, {1: truth}, points, ["a note"], {1: met}, False, {1: fixes})


def series_file(folder):
    """A file of a series of Monte-Carlo runs."""
    path = folder / "series.npz"
    head = {"program": "1", "inputs": {}, "seed": 1, "failures": {"3": "why"}, "wanted": 5}
    np.savez(path, head=json.dumps(head), runs=np.arange(3), ate=np.ones(3), nees=np.ones((3, 2)))
    return path


def park_file(folder):
    """A log of Victoria Park with three scans."""
    path = folder / "park.npz"
    three = {k: np.arange(3.0) for k in ("odo_t_ms", "speed", "steering", "gps_t_ms", "gps_x", "gps_y", "scan_t_ms")}
    trees = {k: np.ones(2) for k in ("det_range", "det_bearing", "det_diameter")}
    arrays: dict[str, Any] = three | trees | {"det_per_scan": np.array([1, 0, 1])}
    np.savez(path, **arrays)
    return path


def npz_target(path, load, share, finish=lambda members: members):
    """Arrays of an npz file, or the file as it is."""
    with zipfile.ZipFile(path) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    broken = path.with_name(f"fuzzed-{path.name}")

    def read(member, data):
        if member is not None:
            file = io.BytesIO()
            with zipfile.ZipFile(file, "w") as archive:
                for name, content in finish(members | {member: data}).items():
                    archive.writestr(name, content)
            data = file.getvalue()
        broken.write_bytes(data)
        return load(broken)

    return Target(read, [(None, path.read_bytes()), *members.items()], REFUSALS["npz"], share, head=128)


def resign(members):
    """The members of a checkpoint with a checksum that is right, as far as numpy can read them."""
    try:
        arrays = {k.removesuffix(".npy"): np.load(io.BytesIO(v), allow_pickle=False) for k, v in members.items()}
        checksum = io.BytesIO()
        np.save(
            checksum, value_file._checksum(str(arrays.pop("tree")), {k: arrays[k] for k in arrays if k != "checksum"})
        )
        return members | {"checksum.npy": checksum.getvalue()}
    except Exception:  # then it keeps the wrong one
        return members


def folder_target(folder, share):
    """Files of a folder, each restored after its turn."""
    members = {path.name: path.read_bytes() for path in folder.iterdir()}

    def read(member, data):
        try:
            (folder / member).write_bytes(data)
            return Recording.load(folder)
        finally:
            (folder / member).write_bytes(members[member])

    return Target(read, list(members.items()), REFUSALS["csv"], share)


def scenario_target(folder):
    """Scenario files."""
    path = folder / "scenario.toml"

    def read(_, data):
        path.write_bytes(data)
        return UserData.from_toml(path)

    words = [b"inf", b"nan", b"1e999", b"true", b'"camera"', b"[[sensor]]", b"[data]", b"type", b"9" * 30]
    return Target(read, [(None, SCENARIO.encode())], REFUSALS["toml"], 2, words)


class Files:
    """The text files of an MRCLAM set in memory, in place of `datasets.sources.Source`."""

    path = Path("MRCLAM_Dataset1")

    def __init__(self, files):
        self.files = files

    def names(self):
        """As of a `Source`."""
        return {name: name for name in self.files}

    def read(self, name):
        """As of a `Source`."""
        return self.files[name]


def mrclam_target():
    """The files of a small set of MRCLAM."""
    rows = lambda *lines: ("# header\n" + "\n".join(lines) + "\n").encode()
    t = 1248272272.841
    files = {
        "Barcodes.dat": rows("1 5", "2 14", "6 72", "7 27"),
        "Landmark_Groundtruth.dat": rows("6 1.8 -5.5 0.0001 0.0002", "7 0.4 -4.4 0.0006 0.0001"),
        "Robot1_Odometry.dat": rows(*(f"{t + 0.1 * k:.3f} 0.{k} -0.0{k}" for k in range(6))),
        "Robot1_Measurement.dat": rows(*(f"{t + 0.1 * k:.3f} {b} 2.{k} 0.1" for k, b in enumerate((72, 27, 14, 99)))),
        "Robot1_Groundtruth.dat": rows(*(f"{t + 0.1 * k:.3f} 1.0 -2.{k} 0.3" for k in range(5))),
    }
    read = lambda member, data: read_set(Files(files | {member: data}), (1,))
    return Target(
        read, list(files.items()), REFUSALS["mrclam"], 3, [b"nan", b"1e308", b"-9e18", b"99999999999999999999"]
    )


def scratch():
    """A folder that goes away at the end, in memory where there is such a place."""
    return tempfile.TemporaryDirectory(prefix="fuzz-", dir="/dev/shm" if os.path.isdir("/dev/shm") else None)
