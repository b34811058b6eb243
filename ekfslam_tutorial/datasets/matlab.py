"""Arrays of numbers from MATLAB files of anybody: what they unpack to is known before anything is unpacked.

scipy's reader is written in C and trusts the type codes that it finds: a wrong byte can end the whole program. So the
few things that are needed are read here. Format: The MathWorks, *MAT-File Format*, level 5.
"""

import itertools
import math
import struct
import zlib
from pathlib import Path

import numpy as np

from ..toolbox.files.archives import DAMAGE, FREE, RATIO, brief

HEAD, MATRIX, COMPRESSED = 128, 14, 15
STORED = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8"}
NUMBERS = range(6, 16)
"""Classes of arrays: double, single, whole numbers of 1 to 8 bytes; not cells, structures, texts, sparse matrices."""

COMPLEX = 0x0800
PIECE = 2**20


def read_mat(path, wanted=None):
    """Some arrays of real numbers of a MATLAB file (version 5 to 7).

    Parameters
    ----------
    path : path
    wanted : iterable of str, optional
        Their names; all arrays of real numbers if not given. Names that are not there are left out.

    Returns
    -------
    dict of str to ndarray
        As they are stored: MATLAB keeps doubles that are whole numbers as such.

    Raises
    ------
    FileNotFoundError
    ValueError
        Naming the file: it is damaged, no MATLAB file, or would unpack to far more than it is.
    """
    data = Path(path).read_bytes()
    try:
        if not data.startswith(b"MATLAB 5.0") or len(data) < HEAD or data[126:128] not in (b"IM", b"MI"):
            raise ValueError("its head is not that of a MATLAB 5.0 file")
        order = "<" if data[126:128] == b"IM" else ">"
        _check_size(data, order)
        arrays = {}
        for kind, part in _elements(data[HEAD:], order):
            if kind == COMPRESSED:
                ((kind, part),) = _elements(zlib.decompress(part), order)
            if kind == MATRIX:
                arrays |= _array(part, order, wanted)
        return arrays
    except DAMAGE as error:
        raise ValueError(f"{path} is damaged or no MATLAB file ({brief(error)}); get it again") from error


def _check_size(data, order):
    """Unpack the compressed parts piece by piece, keeping nothing, to see whether they become too large."""
    limit, total = FREE + RATIO * len(data), 0
    for kind, rest in _elements(data[HEAD:], order):
        stream = zlib.decompressobj()
        while kind == COMPRESSED and rest and not stream.eof:
            total += len(stream.decompress(rest, PIECE))
            rest = stream.unconsumed_tail
            if total > limit:
                raise ValueError(f"it would unpack to more than {limit / 2**20:.0f} MB; this is no honest file")


def _elements(data, order):
    """Kind and content of each element: after a tag of 8 bytes, padded to 8, or up to 4 bytes in the tag itself."""
    at = 0
    while at < len(data):
        kind, size = struct.unpack_from(order + "II", data, at)
        if kind >> 16:
            kind, size, begin, at = kind & 0xFFFF, kind >> 16, at + 4, at + 8
        else:
            begin, at = at + 8, at + 8 + size + (-size % 8 if kind != COMPRESSED else 0)
        if begin + size > len(data):
            raise ValueError(f"it breaks off in an element of {size} bytes")
        yield kind, data[begin : begin + size]


def _array(matrix, order, wanted):
    """{name: array} of a matrix element, or {} if it holds anything but real numbers, or is not wanted."""
    parts = list(itertools.islice(_elements(matrix, order), 4))
    if len(parts) < 3:
        raise ValueError("an array has no name")
    flags, shape, name = (content for _, content in parts[:3])
    kind = struct.unpack(order + "II", flags)[0]
    shape = struct.unpack(f"{order}{len(shape) // 4}i", shape)
    name = name.decode("latin-1")
    if kind & 0xFF not in NUMBERS or kind & COMPLEX or not name or (wanted is not None and name not in wanted):
        return {}
    stored, content = parts[3] if len(parts) > 3 else (0, b"")
    if stored not in STORED:
        raise ValueError(f"{name[:40]} is stored as type {stored}, which is no type of numbers")
    values = np.frombuffer(content, np.dtype(order + STORED[stored]))
    if min(shape) < 0 or math.prod(shape) != len(values):
        raise ValueError(f"{name[:40]} is said to have the shape {shape} and holds {len(values)} numbers")
    return {name: values.astype(values.dtype.newbyteorder("=")).reshape(shape, order="F")}
