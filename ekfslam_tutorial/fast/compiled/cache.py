"""Where machine code is kept: in a folder whose name is a digest of all source text that it is made of.

numba itself looks at the date of the file that a function stands in. Code from other files is in its machine code, too:
functions that it calls, and constants. Whatever of that changes, the name of the folder changes with it, and all is
compiled anew.
"""

import hashlib
import os
import tempfile
from functools import cache
from pathlib import Path

import numba
from numba import njit
from numba.core import config

HERE = Path(__file__).resolve().parent
INLINED = "storage", "smallness", "triangle"
"""Files beside this folder whose functions and constants are in machine code."""


def compiled(function=None, **how):
    """Compile a function when it is called for the first time; the machine code is kept."""
    if function is None:
        return lambda function: compiled(function, **how)
    before, config.CACHE_DIR = config.CACHE_DIR, str(_beside())  # as NUMBA_CACHE_DIR says it for all programs
    try:
        return njit(cache=True, **how)(function)
    finally:
        config.CACHE_DIR = before


@cache
def key():
    """A digest of all source text that is in machine code, and of numba's version."""
    digest = hashlib.sha256(numba.__version__.encode())
    for path in sources():
        digest.update(f"\n{path.name}\n{path.read_text(encoding='utf-8')}".encode())
    return digest.hexdigest()[:20]


def sources():
    """Return the files that machine code is made of."""
    return [*sorted(HERE.glob("*.py")), *(HERE.parent / f"{name}.py" for name in INLINED)]


def cache_folder():
    """The folder for programs: EKFSLAM_CACHE, or the user's own; a temporary one where that cannot be written."""
    home = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    folder = Path(os.environ.get("EKFSLAM_CACHE") or Path(home) / "ekfslam_tutorial") / "compiled"
    return folder if _writable(folder) else Path(_temporary().name)


@cache
def _beside():
    """The folder for kernels: beside their source, as numba has it; else where the programs are."""
    beside = HERE / "__pycache__" / f"kernels-{key()}"
    return beside if _writable(beside) else cache_folder() / f"kernels-{key()}"


def _writable(folder):
    try:
        folder.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=folder).close()
    except OSError:
        return False
    return True


@cache
def _temporary():
    """A folder that goes with this process."""
    return tempfile.TemporaryDirectory(prefix="ekfslam_")
