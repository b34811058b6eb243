"""Arrays of numbers from MATLAB files of anybody: what they unpack to is known before anything is unpacked."""

import math
import struct
import zlib
from pathlib import Path

from ..toolbox.archives import DAMAGE, FREE, RATIO, brief

KINDS = {"double", "single", "logical", *(f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64))}
HEAD, COMPRESSED = 128, 15
PIECE = 2**20


def read_mat(path, wanted=None):
    """Some arrays of numbers of a MATLAB file (version 5 to 7).

    Parameters
    ----------
    path : path
    wanted : iterable of str, optional
        Their names; all arrays of numbers if not given. Names that are not there are left out.

    Returns
    -------
    dict of str to ndarray

    Raises
    ------
    ValueError
        Naming the file: it is damaged, no MATLAB file, or would unpack to far more than it is.
    """
    from scipy.io import loadmat, whosmat  # a while to import, and seldom needed
    from scipy.io.matlab import MatReadError

    try:
        limit = _check_size(Path(path))
        there = {name: shape for name, shape, kind in whosmat(path) if kind in KINDS}
        names = [name for name in there if wanted is None or name in wanted]
        for name in names:
            if 8 * math.prod(there[name]) > limit:
                raise ValueError(f"{name[:40]} is said to have the shape {there[name]}")
        arrays = loadmat(path, variable_names=names) if names else {}
    except FileNotFoundError:
        raise
    except (*DAMAGE, MatReadError, KeyError, IndexError, ArithmeticError) as error:  # what scipy raises at cut files
        raise ValueError(f"{path} is damaged or no MATLAB file ({brief(error)}); get it again") from error
    return {name: arrays[name] for name in names if name in arrays}


def _check_size(path):
    """What the file may unpack to, bytes. Its compressed parts are unpacked piece by piece to see whether they do."""
    data = path.read_bytes()
    if not data.startswith(b"MATLAB 5.0") or len(data) < HEAD or data[126:128] not in (b"IM", b"MI"):
        raise ValueError("its head is not that of a MATLAB 5.0 file")
    limit, total, at = FREE + RATIO * len(data), 0, HEAD
    order = "<II" if data[126:128] == b"IM" else ">II"
    while at + 8 <= len(data):
        kind, size = struct.unpack_from(order, data, at)
        if kind == COMPRESSED:
            stream, rest = zlib.decompressobj(), data[at + 8 : at + 8 + size]
            while rest and not stream.eof:
                total += len(stream.decompress(rest, PIECE))
                rest = stream.unconsumed_tail
                if total > limit:
                    raise ValueError(f"it would unpack to more than {limit / 2**20:.0f} MB; this is no honest file")
        at += 8 + size
    return limit
