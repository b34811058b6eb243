"""From a model to a program: trace it, write its operations down as source, compile that with numba.

The source is kept in the user's cache folder, one file for each different text, and numba keeps the machine code beside
it. So each model is compiled once on a machine: a second or two; after that loading it takes some milliseconds.
"""

import hashlib
import os
import sys
import threading
from importlib.machinery import SourceFileLoader
from types import ModuleType

from .cache import cache_folder, key

HEAD = '''"""Written by ekfslam_tutorial from its models; it can be deleted at any time."""

import math
from math import isfinite

import numpy as np
from numba import njit

from ekfslam_tutorial.fast.compiled.kernels import (
    columns_of,
    covariance_of,
    covariances,
    follow,
    gated,
    heading,
    join,
    near,
    own,
    propagate,
    put,
    sandwich,
)


@njit("{signature}", error_model="numpy", cache=True, nogil=True)
def run({arguments}):
'''


_one_at_a_time = threading.Lock()


def build(signature, arguments, lines):
    """The compiled function with this body.

    Parameters
    ----------
    signature : str
        Types of the arguments, as numba writes them.
    arguments : str
        Their names, with commas.
    lines : list of str
        Body of the function, four spaces less.

    Returns
    -------
    callable
    """
    head = HEAD.format(signature=signature, arguments=arguments)
    text = head + "".join(f"    {line}\n" for line in lines)
    name = "program_" + hashlib.sha256((text + key()).encode()).hexdigest()[:20]
    with _one_at_a_time:
        if name not in sys.modules:
            path = cache_folder() / f"{name}.py"
            if not path.exists() or path.read_bytes() != text.encode():
                _write(path, text)
            try:
                _load(name, path)
            except Exception:
                stored = list(path.parent.glob(f"__pycache__/{name}.*"))
                if not stored:
                    raise
                for file in stored:  # may be damaged
                    file.unlink(missing_ok=True)
                _load(name, path)
    return entry(sys.modules[name].run)


def entry(run):
    """The machine code of a program, called as it is: to look at the types of 15 arguments takes numba 0.8 us.

    So who calls it answers for types and order: what has others is misread, and nobody says so. The tests look.
    """
    return run.get_overload(run.signatures[0])


def _load(name, path):
    """Run a program's file: it compiles itself, or takes the machine code that is stored beside it."""
    module = sys.modules[name] = ModuleType(name)  # before it runs: stored machine code asks for it by this name
    module.__file__ = str(path)
    try:
        SourceFileLoader(name, str(path)).exec_module(module)
    except BaseException:
        del sys.modules[name]
        raise


def _write(path, text):
    """All of a file or nothing of it, also where several programs write the same one."""
    part = path.with_suffix(f".{os.getpid()}.part")
    part.write_bytes(text.encode())
    part.replace(path)
