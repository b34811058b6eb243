"""Where data sets are: folders and zips below `EKFSLAM_DATA`."""

import os
import re
import zipfile
import zlib
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from ..toolbox.files.archives import brief, check_regular, check_zip, read_member
from ..toolbox.user_input import errors_at

ENVIRONMENT = "EKFSLAM_DATA"


def data_folders():
    """The folders named by the environment variable `EKFSLAM_DATA`, which may hold several, separated like PATH.

    Raises
    ------
    FileNotFoundError
        When a named folder does not exist.
    """
    folders = [Path(p).expanduser() for p in os.environ.get(ENVIRONMENT, "").split(os.pathsep) if p]
    for folder in folders:
        if not folder.is_dir():
            raise FileNotFoundError(f"{ENVIRONMENT} names the folder {folder}, which does not exist")
    return folders


def find_file(name, path=None):
    """The file `name`: `path` itself, or in the folder `path`, or below those of `EKFSLAM_DATA`; None if nowhere."""
    if path is not None and not Path(path).is_dir():
        with errors_at(path):
            check_regular(path)
        return Path(path) if Path(path).exists() else None
    folders = data_folders() if path is None else [Path(path)]
    found = [p for f in folders for pattern in (name, f"*/{name}") for p in sorted(f.glob(pattern))]
    return next(filter(Path.is_file, found), None)


def get_file(what, name, path=None):
    """`find_file`, or a FileNotFoundError that says which data set misses which file, and where it was looked for."""
    file = find_file(name, path)
    if file is None:
        place = path or ", ".join(map(str, data_folders())) or f"{ENVIRONMENT}, which is not set"
        raise FileNotFoundError(f"{what}: no {name} in {place}")
    return file


@dataclass(frozen=True)
class Source:
    """The files of one data set: a folder, or a zip as the publisher hands it out.

    Parameters
    ----------
    path : Path
        Folder or zip. Files are looked for in it and in the folders right inside it.
    """

    path: Path

    def names(self):
        """Base name -> where that file is inside `path`."""
        if self.path.is_dir():
            files = sorted(p for pattern in ("*", "*/*") for p in self.path.glob(pattern) if p.is_file())
            return {p.name: p.relative_to(self.path).as_posix() for p in reversed(files)}
        with self._zip() as archive:
            return {PurePosixPath(n).name: n for n in archive.namelist() if not n.endswith("/")}

    def read(self, name):
        """The bytes of the file with base name `name`.

        Raises
        ------
        FileNotFoundError
            No such file; the message lists what there is.
        ValueError
            The zip is damaged or cut off.
        """
        names = self.names()
        if name not in names:
            there = ", ".join(sorted(names)[:12]) + (", ..." if len(names) > 12 else "")
            raise FileNotFoundError(f"{self.path}: no file {name}; there is: {there or 'nothing'}")
        if self.path.is_dir():
            return (self.path / names[name]).read_bytes()
        with self._zip() as archive:
            try:
                check_zip(archive, self.path.stat().st_size)
                return read_member(archive, archive.getinfo(names[name]))
            except (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError) as error:
                raise ValueError(f"{self.path}: {names[name]} in this zip is damaged ({brief(error)})") from error

    def _zip(self):
        try:
            return zipfile.ZipFile(self.path)
        except zipfile.BadZipFile as error:
            raise ValueError(f"{self.path} is not a complete zip file ({brief(error)}); download it again") from error


def find(pattern, folders=None):
    """Folders and zips whose name matches `pattern`: the folders themselves, what is in them, and one level deeper.

    Parameters
    ----------
    pattern : str
        Regular expression for the whole name, any case, without `.zip`.
    folders : iterable of Path, optional
        Where to look; `data_folders()` when not given.

    Returns
    -------
    list of Source
        Unpacked folders first, then zips, each in alphabetical order.
    """
    folders = data_folders() if folders is None else [Path(f) for f in folders]
    matches = re.compile(pattern, re.IGNORECASE).fullmatch
    found = {p for f in folders for p in (f, *f.glob("*"), *f.glob("*/*")) if matches(p.name.removesuffix(".zip"))}
    usable = [p for p in found if p.is_dir() or p.suffix == ".zip"]
    return [Source(p) for p in sorted(usable, key=lambda p: (not p.is_dir(), str(p)))]
