"""The files of one MRCLAM set, read once and kept as a small npz file: 600,000 rows of text then load in 0.2 s.

Nothing is lost but ground truth that is denser than anybody can use (`mrclam_log.TRUTH_STEP`). Decimal numbers are kept
as whole numbers, and those as differences, which compress well and come back to the last bit.
"""

import contextlib
import hashlib
import os
import sys
from pathlib import Path

import numpy as np

from ..toolbox.files.archives import read_npz
from ..toolbox.files.writing import written
from .calibration import OdometryCalibration
from .mrclam_log import RobotLog, SetLog, Sightings, read_set

ENVIRONMENT = "EKFSLAM_CACHE"
READER = np.__version__
"""With another one, what is read may have other last digits."""


def cache_folder():
    """Return where kept files go: the folder that `EKFSLAM_CACHE` names, else the user's folder for caches."""
    if os.environ.get(ENVIRONMENT):
        return Path(os.environ[ENVIRONMENT]).expanduser()
    if sys.platform == "win32":
        base = os.environ.get("LOCALAPPDATA") or "~/AppData/Local"
    elif sys.platform == "darwin":
        base = "~/Library/Caches"
    else:
        base = os.environ.get("XDG_CACHE_HOME") or "~/.cache"
    return Path(base).expanduser() / "ekfslam_tutorial"


def read_cached(source, robots, calibrate):
    """The logs of a set and their calibration, from the cache if it has them; else from the files, and kept.

    Parameters
    ----------
    source : datasets.sources.Source
        Folder or zip.
    robots : sequence of int
        Which robots.
    calibrate : callable
        RobotLog -> OdometryCalibration. The calibration is kept with the log.

    Returns
    -------
    log : SetLog
    fits : dict of int to OdometryCalibration

    Raises
    ------
    FileNotFoundError, ValueError
        As `mrclam_log.read_set`. A cache that cannot be read or written is no error: the files are read then.
    """
    of = f"mrclam-{_place(source, robots)}-"  # the same set, robots and place
    path = cache_folder() / f"{of}{_fingerprint(source, robots)}.npz"
    with contextlib.suppress(Exception):  # whatever is wrong with it: it is only a copy
        return _from_arrays(read_npz(path))
    log = read_set(source, robots)
    fits = {r: calibrate(robot) for r, robot in log.robots.items()}
    with contextlib.suppress(OSError):
        _keep(path, _to_arrays(log, fits))
        for older in set(path.parent.glob(f"{of}*.npz")) - {path}:
            older.unlink()
    return log, fits


def _place(source, robots):
    """Place of the set, and the robots of it that are read: one copy of these is enough."""
    return hashlib.sha256(f"{source.path.resolve()} {list(robots)}".encode()).hexdigest()[:8]


def _fingerprint(source, robots):
    """Changes when a byte of the set does, or the robots, or the text of this program that reads it."""
    digest = hashlib.sha256(repr((READER, list(robots))).encode())
    files = [source.path] if source.path.is_file() else [source.path / name for name in source.names().values()]
    for path in [*sorted(Path(__file__).parent.glob("*.py")), *sorted(files)]:
        with open(path, "rb") as file:
            digest.update(f"{path.resolve()} ".encode() + hashlib.file_digest(file, "sha256").digest())
    return digest.hexdigest()[:24]


def _keep(path, arrays):
    """Write the file in one step, so that nobody ever reads half of it."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with written(path) as file:
        np.savez_compressed(file, allow_pickle=False, **arrays)


def _to_arrays(log, fits):
    arrays = {"name": log.name, "notes": np.array(log.notes, dtype=str), "ids": log.ids, "points": log.points}
    arrays["robots"] = np.array(list(log.robots))
    for r, robot in log.robots.items():
        tables = {"odometry": robot.odometry, "truth": robot.truth}
        for kind, s in (("landmarks", robot.landmarks), ("met", robot.robots)):
            tables |= {f"{kind}_t": s.t, f"{kind}_ids": s.ids, f"{kind}_y": s.y}
        for name, table in tables.items():
            arrays |= _packed(f"{name}{r}", table)
        f = fits[r]
        arrays |= {f"dense{r}": robot.dense, f"fit{r}": np.array([f.left, f.right, f.spin, f.delay])}
        arrays[f"source{r}"] = f.source
    return arrays


def _from_arrays(a):
    robots, fits = {}, {}
    for r in a["robots"].tolist():
        get = lambda name, r=r: _unpacked(a, f"{name}{r}")
        seen = lambda k, get=get: Sightings(get(f"{k}_t"), get(f"{k}_ids").astype(int), get(f"{k}_y"))
        dense, (left, right, spin, delay) = bool(a[f"dense{r}"]), a[f"fit{r}"].tolist()
        robots[r] = RobotLog(r, get("odometry"), seen("landmarks"), seen("met"), get("truth"), dense)
        fits[r] = OdometryCalibration(left, right, spin, delay, str(a[f"source{r}"]))
    return SetLog(str(a["name"]), robots, a["ids"], a["points"], a["notes"].tolist()), fits


def _packed(name, table):
    """A table of decimal numbers as differences of whole numbers, where that is exact; else as it is."""
    for digits in (0, 3, 6):
        whole = np.round(table * 10.0**digits)
        if len(table) and abs(whole).max() < 2**53 and np.array_equal(whole / 10.0**digits, table):
            steps = np.diff(whole.astype(np.int64), axis=0, prepend=0)
            return {name: _narrow(steps[1:]), f"{name}_first": steps[:1], f"{name}_digits": digits}
    return {name: table}


def _narrow(a):
    """Whole numbers in the smallest type that holds them."""
    top = abs(a).max(initial=0)
    return a.astype(next(kind for kind in (np.int8, np.int16, np.int32, np.int64) if top <= np.iinfo(kind).max))


def _unpacked(a, name):
    if f"{name}_digits" not in a:
        return a[name]
    steps = np.concatenate([a[f"{name}_first"], a[name].astype(np.int64)])
    return np.cumsum(steps, axis=0) / 10.0 ** int(a[f"{name}_digits"])
