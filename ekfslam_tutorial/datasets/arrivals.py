"""Data sets that the user got elsewhere: recognised by what is in them, checked, and put where the loaders look."""

import hashlib
import os
import re
import shutil
import tempfile
import zipfile
from pathlib import Path, PurePosixPath

from ..toolbox.files.archives import brief, check_regular, check_zip, read_member, read_npz
from ..toolbox.files.writing import replacing
from ..toolbox.user_input import errors_at
from . import euroc_v101, lost_in_the_woods, plaza, victoria_park
from . import victoria_park_raw as raw
from .matlab import read_mat
from .mrclam_log import ROBOTS, read_set
from .sources import Source

ARRAYS = {
    victoria_park.FILE: set(victoria_park.ARRAYS),
    raw.SCANS: {"LASER", "TLsr"},
    raw.ODOMETRY: {"time", "speed", "steering"},
    raw.GPS: {"timeGps", "Lo_m", "La_m"},
    lost_in_the_woods.FILE: {"l", "d", *lost_in_the_woods.ARRAYS},
    **{file: {"DRp", *plaza.COLUMNS} for file in plaza.FILES.values()},
}
"""File -> the arrays that only this file has."""

SET = re.compile(r"MR[CS]LAM[ _-]?(?:Data)?(?:set)?[ _-]?([1-9])", re.IGNORECASE)
LARGEST = 2**31
"""Bytes of a file that is looked into."""


def bring(path, folder, force=False):
    """Copy the data sets in a zip, a folder or a file to where the loaders find them.

    Parameters
    ----------
    path : path
        Whatever its name is; only the number of an MRCLAM set is taken from the names, of it or in it.
    folder : path
        Where to put them.
    force : bool
        Replace what is there.

    Returns
    -------
    list of str
        What was put there, a line for each part.

    Raises
    ------
    FileNotFoundError
    FileExistsError
        If something would be overwritten.
    ValueError
        One sentence: it is no data set that is known, or it is damaged.
    """
    path, folder = Path(path), Path(folder)
    if not path.exists():
        raise FileNotFoundError(f"there is no {path}")
    if not path.is_dir():
        with errors_at(path):
            check_regular(path)
    folder.mkdir(parents=True, exist_ok=True)
    if path.is_dir() and (path / "Barcodes.dat").is_file():
        return [_put_folder(path, folder / f"MRCLAM_Dataset{_number(path.name)}", force)]
    if path.is_dir():
        return _bring_all(path, folder, force)
    return _bring_file(path, folder, force)


def whole(path, part):
    """Read a part of a data set to its end.

    Parameters
    ----------
    path : Path
    part : str
        `MRCLAM_DatasetN`, or the name of a file.

    Raises
    ------
    ValueError
        If it is damaged or something else.
    """
    try:
        if part.startswith("MRCLAM"):
            read_set(Source(path), ROBOTS)
        elif part == lost_in_the_woods.FILE:
            lost_in_the_woods.load(path)
        elif part == euroc_v101.PART:
            euroc_v101.load(path)
        elif part in plaza.FILES.values():
            plaza.load(path=path)
        elif part == victoria_park.FILE:
            victoria_park.read_log(path)
        elif part == raw.SCANS:
            raw.read_scans(path)
        elif not ARRAYS[part] <= _names_of_arrays(path):
            raise ValueError(f"{path} is no {part}")
    except FileNotFoundError as error:  # of a file in a zip
        raise ValueError(str(error)) from error


def recognise(path):
    """The part that a file is, by the arrays in it; None if it is no part of a data set.

    Both sets of Plaza have the same arrays: they are told apart by the name, else by the checksum.
    """
    if _is_euroc(path):
        return euroc_v101.PART
    names = _names_of_arrays(path)
    parts = [part for part, wanted in ARRAYS.items() if wanted <= names]
    if len(parts) > 1 and path.name not in parts:
        digest = hashlib.sha256(path.read_bytes()).hexdigest()
        parts = [part for part in parts if plaza.SHA256[part] == digest]
    return path.name if path.name in parts else next(iter(parts), None)


def _bring_all(path, folder, force):
    """All that is known in a folder, and in the folders right inside it; links are not followed."""
    inside = [p for pattern in ("*", "*/*") for p in sorted(path.glob(pattern)) if not p.is_symlink()]
    sets = [p for p in inside if p.is_dir() and (p / "Barcodes.dat").is_file()]
    lines = [_put_folder(p, folder / f"MRCLAM_Dataset{_number(p.name)}", force) for p in sets]
    files = [p for p in inside if p.is_file() and p.parent not in sets]
    for file in files:
        if file.suffix in (".zip", ".whl", ".mat", ".npz") or (file.suffix == ".csv" and _is_euroc(file)):
            lines += _bring_file(file, folder, force)
    if not lines:
        raise ValueError(f"{path} holds no data set that is known; see `ekfslam data`")
    return lines


def _bring_file(path, folder, force):
    if path.stat().st_size > LARGEST:
        raise ValueError(f"{path} is larger than any file of these data sets")
    part = recognise(path)
    if part is not None:
        return [_put(path, folder / part, part, force)]
    if not zipfile.is_zipfile(path):
        raise ValueError(f"{path} is no file of a data set that is known, or it is damaged; see `ekfslam data`")
    return _bring_zip(path, folder, force)


def _bring_zip(path, folder, force):
    """A set of MRCLAM stays packed; files of other data sets are unpacked, by their last name only."""
    try:
        with zipfile.ZipFile(path) as archive:
            check_zip(archive, path.stat().st_size)
            members = {PurePosixPath(m.filename.replace("\\", "/")).name: m for m in archive.infolist()}
            if "Barcodes.dat" in members:
                part = f"MRCLAM_Dataset{_number(members['Barcodes.dat'].filename, path.name)}"
                return [_put(path, folder / f"{part}.zip", part, force)]
            lines = []
            for name in sorted(set(members) & {*ARRAYS, euroc_v101.PART}):
                with tempfile.TemporaryDirectory(dir=folder) as own:
                    file = Path(own, name)
                    file.write_bytes(read_member(archive, members[name]))
                    lines.append(_put(file, folder / name, name, force))
    except (zipfile.BadZipFile, NotImplementedError, RuntimeError, EOFError) as error:
        raise ValueError(f"{path} is a damaged zip: {brief(error)}") from error
    except ValueError as error:
        raise ValueError(f"{path}: {brief(error)}") from error
    if not lines:
        raise ValueError(f"{path} holds no file of a data set that is known; see `ekfslam data`")
    return lines


def _put(path, target, part, force):
    """Check a file and copy it, whole or not at all."""
    _refuse_overwriting(target, force)
    with replacing(target) as copy:
        shutil.copyfile(path, copy)
        whole(copy, part)
    return f"{target.name}: checked and copied to {target.parent}"


def _put_folder(path, target, force):
    """The same for the unpacked files of an MRCLAM set."""
    _refuse_overwriting(target, force)
    files = [p for p in sorted(path.iterdir()) if p.suffix in (".dat", ".csv") and p.is_file() and not p.is_symlink()]
    if sum(p.stat().st_size for p in files) > LARGEST:
        raise ValueError(f"{path} is larger than any set of MRCLAM")
    with tempfile.TemporaryDirectory(dir=target.parent) as own:
        new, old = Path(own, "new"), Path(own, "old")
        new.mkdir()
        for file in files:
            shutil.copyfile(file, new / file.name)
        whole(new, "MRCLAM")
        if target.exists():
            os.replace(target, old)
        os.replace(new, target)
    return f"{target.name}: {len(files)} files checked and copied to {target.parent}"


def _refuse_overwriting(target, force):
    if target.exists() and not force:
        raise FileExistsError(f"{target} is there already; --force replaces it")


def _number(*names):
    for name in names:
        found = SET.search(name)
        if found:
            return found[1]
    raise ValueError(f"this is a set of MRCLAM, but which one? Let its name end in its number, as in MRCLAM_Dataset{7}")


def _is_euroc(path):
    """True of a table whose columns are those of EuRoC V1_01."""
    with open(path, "rb") as file:
        return file.readline(200).startswith(b"row_type,t_abs,t_rel,seq,frame_idx,landmark_id")


def _names_of_arrays(path):
    """The names of the arrays in an npz or MATLAB file; nothing for other files."""
    with open(path, "rb") as file:
        start = file.read(128)
    try:
        if start.startswith(b"PK"):
            return set(read_npz(path))
        if start.startswith(b"MATLAB"):
            return set(read_mat(path))
    except ValueError:
        return set()
    return set()
