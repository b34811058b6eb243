"""Files of the command line: those that come with the package, and those that it writes."""

import contextlib
import os
import re
import shutil
import tempfile
from pathlib import Path

from ..analysis.progress import bar
from ..toolbox.files.locks import only_here
from ..toolbox.files.writing import beside, sweep, to_disk
from ..toolbox.files.writing import replacing as replacing
from ..toolbox.files.writing import written as written
from .terminal import near

MANIFEST = "files.txt"
"""The names of the files of a run, one in a line: these, and no others, go when another run writes into the folder."""

PACKAGE = Path(__file__).resolve().parent.parent


def shipped(folder):
    """A folder that comes with the package, `data` or `notebooks`: inside an installed one, or in the repository."""
    inside = PACKAGE / "_share" / folder
    return inside if inside.is_dir() else PACKAGE.parent / folder


def scenarios():
    """The scenario files that come with the package, by name."""
    return {path.stem: path for path in sorted((shipped("data") / "scenarios").glob("*.toml"))}


def find_scenario(name):
    """The file of a scenario: a path, or the name of one that comes with the package, or the one beginning of a name.

    Raises
    ------
    FileNotFoundError
        Naming the nearest one.
    """
    path, known = Path(name), scenarios()
    if path.is_file():
        return path
    stem = path.stem if path.suffix == ".toml" else path.name
    begun = [name for name in known if name.startswith(f"{stem}_")]
    folder = path.is_dir()  # results/range_bearing_2d is not the scenario of that name
    if (stem in known or len(begun) == 1) and not (folder and len(path.parts) > 1):
        return known[stem if stem in known else begun[0]]
    if folder:
        raise FileNotFoundError(f"{name} is a folder; give the scenario that it was made with, its file or its name")
    raise FileNotFoundError(f"no scenario file {name}; known names: {', '.join(known) or 'none'}{near(stem, known)}")


def told(path):
    """Title that a scenario file gives itself: the beginning of its first line, as far as that is a phrase."""
    line = path.read_text(encoding="utf-8").partition("\n")[0].removeprefix("# ")
    phrase = re.match(r".{20,}?(?=[.:;,] |[.:;,]$)", line)
    return phrase[0] if phrase else line


def file_name(name):
    """A name as the name of a file or folder: letters, digits, points and dashes of any language, never a path."""
    return re.sub(r"[^\w.-]+", "_", name).strip("._") or "unnamed"


def save_figure(fig, path):
    """Write a figure as a picture, close it, and say so to the bar that is shown meanwhile; return the file's name."""
    import matplotlib.pyplot as plt

    with written(path) as file:
        fig.savefig(file, format=path.suffix[1:])
    plt.close(fig)
    if drawing:
        drawing[-1].update()
    return path.name


@contextlib.contextmanager
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


class ResultFolder:
    """A folder that one run at a time writes into, and in which the files of one run stand, of the last.

    Parameters
    ----------
    path : path
        It is made if need be.

    Raises
    ------
    OSError
        If it cannot be written, or another run is at it.
    """

    def __init__(self, path):
        self.path = writable_folder(path)
        self._stack = contextlib.ExitStack()

    def __enter__(self):
        self._stack.enter_context(only_here(self.path))
        sweep(self.path)
        return self

    def __exit__(self, *problem):
        self._stack.close()

    def names(self):
        """The files that a run has written here before: plain names, whatever stands in the list."""
        try:
            lines = (self.path / MANIFEST).read_text(encoding="utf-8").splitlines()
        except (OSError, UnicodeDecodeError):
            return set()
        return {line for line in lines if line and line == Path(line).name and line not in (".", "..", MANIFEST)}

    def announce(self, *names):
        """Note names of files that are going to be written, so that they are known for ours whatever happens."""
        with written(self.path / MANIFEST, text=True) as file:
            file.write("".join(f"{name}\n" for name in sorted({*self.names(), *names})))

    @contextlib.contextmanager
    def results(self):
        """Give a folder elsewhere for the files of a run; at the end they are moved here. `keep` ends the old ones."""
        with tempfile.TemporaryDirectory(prefix="ekfslam-results-") as own:
            yield Path(own)
            files = sorted(Path(own).iterdir())
            with beside(self.path) as new:  # a full disk is met before the first of the old files is touched
                for file in files:
                    shutil.copyfile(file, new / file.name)
                to_disk(*new.iterdir())
                self.announce(*(file.name for file in files))
                for file in files:
                    os.replace(new / file.name, self.path / file.name)
            to_disk(self.path)

    def keep(self, *names):
        """Take away the files of runs before, but for these."""
        for name in self.names() - set(names):
            path = self.path / name
            if path.is_file() or path.is_symlink():
                path.unlink()
        with written(self.path / MANIFEST, text=True) as file:
            file.write("".join(f"{name}\n" for name in sorted(names)))
