"""Files of the command line: those that come with the package, and those that it writes."""

import re
import tempfile
from contextlib import contextmanager
from pathlib import Path

from ..analysis.progress import bar
from ..toolbox.files.writing import replacing as replacing
from .terminal import near

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
    raise FileNotFoundError(f"no scenario file {name}; known names: {', '.join(known) or 'none'}{near(stem, known)}")


def told(path):
    """What a scenario file says of itself: the beginning of its first line, as far as that is a phrase."""
    line = path.read_text(encoding="utf-8").partition("\n")[0].removeprefix("# ")
    phrase = re.match(r".{20,}?(?=[.:;,] |[.:;,]$)", line)
    return phrase[0] if phrase else line


def file_name(name):
    """A name as the name of a file or folder: letters, digits, points and dashes of any language, never a path."""
    return re.sub(r"[^\w.-]+", "_", name).strip("._") or "unnamed"


def save_figure(fig, path):
    """Write a figure as a picture, close it, and say so to the bar that is shown meanwhile; return the file's name."""
    import matplotlib.pyplot as plt

    with replacing(path) as part:
        fig.savefig(part)
    plt.close(fig)
    if drawing:
        drawing[-1].update()
    return path.name


@contextmanager
def pictures(total):
    """Show a bar while so many figures are saved."""
    with bar(total, "pictures") as done:
        drawing.append(done)
        try:
            yield
        finally:
            drawing.pop()
            done.total = done.n


drawing = []
"""The bar of the pictures that are being drawn, if there is one."""


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
