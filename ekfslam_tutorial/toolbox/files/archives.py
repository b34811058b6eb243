"""Zip and npz files from anywhere: what they would unpack to is known before anything is unpacked.

A zip of a few kilobytes can hold gigabytes, and 128 bytes at the head of an array can ask for all the memory there is.
Both are refused by what the file itself says, so that time and memory stay in proportion to the size of the file.
"""

import io
import math
import re
import struct
import sys
import zipfile
import zlib
from pathlib import Path

import numpy as np

from ..user_input import short_text

FREE, RATIO = 64 * 2**20, 100
"""A file may unpack to FREE bytes, and RATIO times its own size. Deflate alone would allow 1032 times."""

# What zipfile raises at files that are cut off, overwritten, or no zips at all.
DAMAGE = (ValueError, EOFError, OSError, AttributeError, NotImplementedError, RuntimeError, MemoryError)
DAMAGE += (TypeError, zipfile.BadZipFile, zlib.error, struct.error)

MAX_MEMBERS = 10_000
HEADER = re.compile(
    rb"\x93NUMPY(?:\x01\x00..|\x02\x00....)"
    rb"\{'descr': '([<>|=]?[biufUS]\d{1,8})', 'fortran_order': (True|False), "
    rb"'shape': \(((?:\d{1,15},? ?){0,32})\),? ?\} {0,100}\n",
    re.DOTALL,
)
"""The head of an array of truth values, numbers or texts, as numpy writes it. Objects, which would be pickles, and
structures are left out. numpy itself gives the head to Python's parser, which a hostile text can keep busy."""

MAX_ROWS = 10**6
"""Rows of an array without numbers in it, (rows, 0): such a shape costs nothing in the file."""


def check_regular(path):
    """Refuse what is there and is no file: a pipe, that may never end or never begin, or a device.

    Parameters
    ----------
    path : path

    Raises
    ------
    ValueError
    """
    if Path(path).exists() and not Path(path).is_file():
        raise ValueError("it is no regular file, but a folder, a pipe or a device")


def check_zip(archive, size):
    """Refuse a zip that unpacks to far more than it is.

    Parameters
    ----------
    archive : zipfile.ZipFile
    size : int
        Of the file, bytes.

    Raises
    ------
    ValueError
        Telling how large it would become, by what the zip says; `read_member` holds it to that.
    """
    members = archive.infolist()
    if len(members) > MAX_MEMBERS:
        raise ValueError(f"it holds {len(members)} files; at most {MAX_MEMBERS} are read")
    total = sum(member.file_size for member in members)
    if total > FREE + RATIO * size:
        raise ValueError(
            f"it would unpack to {total / 2**20:.0f} MB from {size / 2**20:.2g} MB; this is no honest file"
        )


def read_member(archive, member):
    """The bytes of one member of a zip: no more than the zip says, whatever they unpack to.

    Parameters
    ----------
    archive : zipfile.ZipFile
    member : zipfile.ZipInfo
        `archive.read(member)` would unpack all of it before it looks at the size.

    Returns
    -------
    bytes
        Its checksum was right.
    """
    with archive.open(member) as file:
        return file.read(member.file_size)


def read_npz(path):
    """All arrays of an npz file, as `np.load(path, allow_pickle=False)` gives them, but with bounded time and memory.

    Parameters
    ----------
    path : path

    Returns
    -------
    dict of str to ndarray

    Raises
    ------
    ValueError
        One sentence: no npz file, damaged, too large when unpacked, or arrays of anything but numbers and texts.
    FileNotFoundError
    """
    check_regular(path)
    with open(path, "rb") as file:
        size = file.seek(0, io.SEEK_END)
        file.seek(0)
        if file.read(4) not in (b"PK\x03\x04", b"PK\x05\x06"):
            raise ValueError("it is no npz file, or its beginning is damaged")
        try:
            with zipfile.ZipFile(file) as archive:
                check_zip(archive, size)
                return {
                    m.filename.removesuffix(".npy"): _array(m.filename, read_member(archive, m))
                    for m in archive.infolist()
                }
        except DAMAGE as error:
            raise ValueError(brief(error)) from error


def brief(error):
    """The message of an exception as one line of bounded length, whatever was in the file."""
    return " ".join(str(error).split())[:200] or type(error).__name__


def _array(name, data):
    """One member of an npz file. Its shape must be that of the bytes that follow."""
    head = HEADER.match(data)
    if head is None:
        raise ValueError(f"{short_text(name)} is no array of numbers or texts, or its beginning is damaged")
    dtype, shape = np.dtype(head[1].decode()), tuple(int(n) for n in re.findall(rb"\d+", head[3]))
    count, rest = math.prod(shape), len(data) - head.end()
    if count * dtype.itemsize != rest or (not rest and math.prod(n or 1 for n in shape) > MAX_ROWS):
        raise ValueError(
            f"{short_text(name)} says that it has the shape {short_text(shape)}, but there are {rest} bytes"
        )
    if (
        dtype.kind == "U"
        and np.frombuffer(data, dtype.str[0] + "u4", offset=head.end()).max(initial=0) > sys.maxunicode
    ):
        raise ValueError(f"{short_text(name)} is a text with letters that do not exist")
    return np.ndarray(shape, dtype, data, head.end(), order="F" if head[2] == b"True" else "C").copy("K")
