"""Files that are written whole or not at all: first beside, then to the disk, then into their place in one step.

What a program leaves that is killed in between has a name of its own, ``.ekfslam-...``; `sweep` takes it away.
"""

import contextlib
import errno
import os
import shutil
import sys
import tempfile
from pathlib import Path
from typing import Any

from .locks import lock_file, only_here

PREFIX = ".ekfslam-"
"""Of the names of files that are not whole yet."""
CANNOT = errno.EBADF, errno.EINVAL, errno.EROFS
"""What `fsync` says of things that it is not for."""


@contextlib.contextmanager
def replacing(path):
    """Give a temporary path; what is written there takes the place of the file in one step, or not at all.

    Who can write to an open file takes `written`: of that not even a kill leaves a trace.

    Examples
    --------
    >>> with replacing("result.json") as part:
    ...     n_letters = part.write_text("{}")
    """
    path, part, handle = Path(path), None, None
    if sys.platform == "emscripten":
        with _in_a_browser(path) as part:
            yield part
        return
    try:
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=f"{PREFIX}{path.stem}-", suffix=path.suffix)
        part = Path(name)
        lock_file(handle)  # for `sweep`: it is still being written
        yield part
        part.chmod(0o666 & ~_umask() | 0o600)
        to_disk(part)
        os.close(handle)
        handle = None
        os.replace(part, path)
        to_disk(path.parent)
    except OSError as error:  # nobody knows the temporary file: the message names the one that was to be written
        _name(error, path, part)
        raise
    finally:
        if handle is not None:
            os.close(handle)
        if part:
            part.unlink(missing_ok=True)


@contextlib.contextmanager
def written(path, text=False):
    """Give an open file; what is written to it takes the place of the file at the path in one step, or not at all.

    Parameters
    ----------
    path : path
    text : bool
        A file of text in UTF-8, whose lines end as they are written; otherwise one of bytes.

    Examples
    --------
    >>> with written("result.json", text=True) as file:
    ...     n_letters = file.write("{}")
    """
    path = Path(path)
    try:
        handle = os.open(path.parent, os.O_TMPFILE | os.O_RDWR, 0o666)  # it has no name: when killed, it is gone
    except (OSError, AttributeError):  # not every system, and not every disk, has such files
        with replacing(path) as part, _opened(part, text) as file:
            yield file
        return
    part = path.parent / f"{PREFIX}{path.name}-{os.getpid()}"
    try:
        with _opened(handle, text) as file:
            yield file
            file.flush()
            os.fsync(handle)
            part.unlink(missing_ok=True)
            os.link(f"/proc/self/fd/{handle}", part, src_dir_fd=handle)  # a folder is asked for; the path is absolute
            os.replace(part, path)
        to_disk(path.parent)
    except OSError as error:
        _name(error, path, part)
        raise
    finally:
        part.unlink(missing_ok=True)


@contextlib.contextmanager
def beside(folder):
    """Give a temporary folder in a folder, for files that are to be moved into it when all of them are whole.

    It goes at the end, with what is still in it.
    """
    own = Path(tempfile.mkdtemp(dir=folder, prefix=PREFIX))
    try:
        with only_here(own):
            yield own
    finally:
        shutil.rmtree(own, ignore_errors=True)


def to_disk(*paths):
    """Wait until files, or the names in folders, are on the disk, where the system can do so."""
    for path in paths:
        with contextlib.suppress(PermissionError):  # Windows opens no folders
            handle = os.open(path, os.O_RDONLY)
            try:
                os.fsync(handle)
            except OSError as error:
                if error.errno not in CANNOT:
                    raise
            finally:
                os.close(handle)


def sweep(folder):
    """Take away what programs that were killed have left in a folder; files that are being written stay."""
    for part in Path(folder).glob(f"{PREFIX}*"):
        with contextlib.suppress(OSError):  # in use by another program
            handle = os.open(part, os.O_RDONLY)
            try:
                lock_file(handle)
            finally:
                os.close(handle)
            shutil.rmtree(part) if part.is_dir() else part.unlink()


@contextlib.contextmanager
def _in_a_browser(path):
    """Give a path outside of the page's storage; what is written there comes into the storage as a new file.

    The storage stops the kernel for ever when it is handed a file of JSON that is empty or half written; it is so
    already when one that is there is opened to be written anew.
    """
    with tempfile.TemporaryDirectory() as folder:
        part = Path(folder) / path.name
        yield part
        path.unlink(missing_ok=True)
        path.write_bytes(part.read_bytes())


def _opened(file, text) -> Any:
    return open(file, "w", newline="", encoding="utf-8") if text else open(file, "wb")


def _name(error, path, part):
    """Let an error name the file that was to be written."""
    named = [str(n) for n in (error.filename, error.filename2) if n is not None]
    if error.errno is not None and (part is None or not named or str(part) in named):
        error.filename, error.filename2 = str(path), None


def _umask():
    """The permissions that new files do not get (mkstemp gives fewer)."""
    mask = os.umask(0o022)
    os.umask(mask)
    return mask
