"""Files of the command line: those that come with the package, and those that it writes."""

import difflib
import re
import tempfile
from pathlib import Path

from ..toolbox.files.writing import replacing as replacing

PACKAGE = Path(__file__).resolve().parent.parent


def shipped(folder):
    """A folder that comes with the package, `data` or `notebooks`: inside an installed one, or in the repository."""
    inside = PACKAGE / "_share" / folder
    return inside if inside.is_dir() else PACKAGE.parent / folder


def scenarios():
    """The scenario files that come with the package, by name."""
    return {path.stem: path for path in sorted((shipped("data") / "scenarios").glob("*.toml"))}


def find_scenario(name):
    """The file of a scenario: a path, or the name of one that comes with the package.

    Raises
    ------
    FileNotFoundError
        Naming the nearest one.
    """
    path, known = Path(name), scenarios()
    if path.is_file():
        return path
    stem = path.stem if path.suffix == ".toml" else path.name
    if stem in known:
        return known[stem]
    close = difflib.get_close_matches(stem, known, n=1, cutoff=0.5)
    hint = f"; did you mean {close[0]}?" if close else ""
    raise FileNotFoundError(f"no scenario file {name}; known names: {', '.join(known) or 'none'}{hint}")


def file_name(name):
    """A name as the name of a file or folder: letters, digits, points and dashes of any language, never a path."""
    return re.sub(r"[^\w.-]+", "_", name).strip("._") or "unnamed"


def writable_folder(path):
    """Make a folder if need be and see that files can be written there.

    Raises
    ------
    OSError
        One sentence that says why not.
    """
    path = Path(path)
    try:
        path.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=path):
            return path
    except OSError as error:
        raise OSError(f"cannot write into the folder {path}: {error.strerror or error}") from error
