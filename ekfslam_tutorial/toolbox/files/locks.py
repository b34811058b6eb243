"""Locks between programs: two that write into one folder, or change one file, know of each other.

The system holds a lock for as long as the program lives that took it: one that is killed leaves none behind.
"""

import contextlib
import os
import time
from pathlib import Path

try:
    from fcntl import LOCK_EX, LOCK_NB, flock
except ImportError:  # Windows; a browser, whose kernel may have an empty module of this name
    flock, LOCK_EX, LOCK_NB = None, 0, 0  # pyright: ignore[reportConstantRedefinition, reportGeneralTypeIssues]

PATIENCE = 10.0
"""Seconds to wait for a program that changes the same small file."""


class Taken(OSError):
    """Another program is at work there."""


def lock_file(handle):
    """Lock an open file for this program, at once or not at all.

    Parameters
    ----------
    handle : int

    Raises
    ------
    Taken
        If another program holds it.
    """
    if flock is None:
        return
    try:
        flock(handle, LOCK_EX | LOCK_NB)
    except BlockingIOError as error:
        raise Taken("another program is at work there") from error
    except OSError:  # a disk that knows no locks
        return


@contextlib.contextmanager
def only_here(folder):
    """Hold a folder: no other program that asks for it gets it meanwhile.

    Raises
    ------
    Taken
        One sentence that names the folder.
    """
    folder = Path(folder)
    try:
        if flock is None:
            handle = _alone(folder / "in_use.lock")
        else:
            handle = os.open(folder, os.O_RDONLY)  # the folder itself is locked: there is no file to be left behind
            try:
                lock_file(handle)
            except Taken:
                os.close(handle)
                raise
    except Taken as error:
        raise Taken(f"another run is writing into the folder {folder}: wait for it, or take another folder") from error
    try:
        yield
    finally:
        if handle is not None:
            os.close(handle)


@contextlib.contextmanager
def one_at_a_time(path):
    """Wait until no other program changes a small file, and keep others out meanwhile; the file may be replaced.

    After `PATIENCE` seconds, or where nothing can be locked, it goes on without: who changes a file here only for
    moments must not wait for ever for a program that hangs.
    """
    path, handle, until = Path(path), None, time.monotonic() + PATIENCE
    while time.monotonic() < until:
        try:
            handle = _alone(path.with_name(path.name + ".lock")) if flock is None else _locked(path)
            break
        except Taken:
            time.sleep(0.02)
        except OSError:  # it cannot be written; who tries to will hear of it
            break
    try:
        yield
    finally:
        if handle is not None:
            if path.exists() and not path.stat().st_size:  # it was made for the lock only
                path.unlink()
            os.close(handle)


def _locked(path):
    """Open a file, made if need be, and lock it, if it is still the one at its path then."""
    handle = os.open(path, os.O_CREAT | os.O_RDWR, 0o666)
    try:
        lock_file(handle)
        if not os.path.samestat(os.fstat(handle), os.stat(path)):
            raise Taken("another program has just replaced it")
    except OSError as error:
        os.close(handle)
        raise error if isinstance(error, Taken) else Taken(str(error)) from error
    return handle


def _alone(path):
    """Make a file that must not be there yet and goes with this program; None where the system has no such files."""
    flag = getattr(os, "O_TEMPORARY", None)
    if flag is None:
        return None
    try:
        return os.open(path, os.O_CREAT | os.O_EXCL | os.O_RDWR | flag)
    except (FileExistsError, PermissionError) as error:
        raise Taken("another program is at work there") from error
