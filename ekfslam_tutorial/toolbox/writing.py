"""Files that are written whole or not at all."""

import contextlib
import os
import tempfile
from pathlib import Path


@contextlib.contextmanager
def replacing(path):
    """Give a temporary path; what is written there takes the place of the file in one step, or not at all.

    Examples
    --------
    >>> with replacing("result.json") as part:
    ...     n_letters = part.write_text("{}")
    """
    path = Path(path)
    handle, part = tempfile.mkstemp(dir=path.parent, prefix=f".{path.stem}-", suffix=path.suffix)
    os.close(handle)
    part = Path(part)
    try:
        yield part
        part.chmod(0o666 & ~_umask())
        os.replace(part, path)
    finally:
        part.unlink(missing_ok=True)


def _umask():
    """The permissions that new files do not get (mkstemp gives fewer)."""
    mask = os.umask(0o022)
    os.umask(mask)
    return mask
