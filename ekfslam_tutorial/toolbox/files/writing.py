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
    path, part = Path(path), None
    try:
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.stem}-", suffix=path.suffix)
        os.close(handle)
        part = Path(name)
        yield part
        part.chmod(0o666 & ~_umask() | 0o600)  # Python in a browser has a umask that leaves the owner nothing
        os.replace(part, path)
    except OSError as error:  # nobody knows the temporary file: the message names the one that was to be written
        named = [str(n) for n in (error.filename, error.filename2) if n is not None]
        if error.errno is not None and (part is None or not named or str(part) in named):
            error.filename, error.filename2 = str(path), None
        raise
    finally:
        if part:
            part.unlink(missing_ok=True)


def _umask():
    """The permissions that new files do not get (mkstemp gives fewer)."""
    mask = os.umask(0o022)
    os.umask(mask)
    return mask
