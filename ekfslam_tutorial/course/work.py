"""A student's work in a browser: download it, take it up again on another computer or in another browser.

take_home()      # a button: my_work.zip, with the changed notebooks, my_slam.py and the progress
take_up()        # a button: choose my_work.zip

On a computer of one's own `take_home("my_work.zip")` writes the file and `take_up("my_work.zip")` reads it: what was
begun in a browser goes on there.
"""

from __future__ import annotations

import base64
import io
import zipfile
from pathlib import Path, PurePosixPath

from IPython.display import HTML, display

from . import logbook
from .deadline import NO_THREADS as IN_BROWSER
from .keep import path as my_slam

FILE = "my_work.zip"
PROGRESS = "progress.json"
DRIVE = Path("/drive")  # where the browser's storage is, if the page may use it

BUTTON = (
    '<button type="button" class="jp-Button jp-mod-styled" '
    "onclick=\"window.jupyterapp.commands.execute('{command}')\">{label}</button>"
)


def take_home(path: str | Path | None = None):
    """Show a button that downloads your work; outside of a browser, write it to a file.

    Parameters
    ----------
    path : path, optional
        The file that is written outside of a browser: a zip file with ``my_slam.py`` and the progress. Without it, a
        line says what can be packed.
    """
    if IN_BROWSER and DRIVE.is_dir():
        display(HTML(BUTTON.format(command="ekfslam:take-home", label="Download my work")))
    elif IN_BROWSER:
        packed = base64.b64encode(_packed()).decode()
        display(HTML(f'<a download="{FILE}" href="data:application/zip;base64,{packed}">Download my work</a>'))
        print("This page may not use the browser's storage: save the notebook itself by File, Download.")
    elif path is None:
        print(f'Your work is on this computer; take_home("{FILE}") packs {my_slam().name} and your progress.')
    else:
        Path(path).write_bytes(_packed())
        print(f"written: {path}, with {my_slam().name} and your progress")


def take_up(path: str | Path = FILE):
    """Show a button that takes up what was downloaded; outside of a browser, read ``my_work.zip``.

    Parameters
    ----------
    path : path, optional
        The file that is read outside of a browser. Its notebooks and ``my_slam.py`` come into this folder, in place of
        what is there; an exercise that has passed stays passed.

    Raises
    ------
    ValueError
        If it is not such a file.
    """
    if IN_BROWSER:
        display(HTML(BUTTON.format(command="ekfslam:take-up", label="Take up my work …")))
        return
    files = _unpacked(Path(path))
    for name, data in files.items():
        if name == PROGRESS:
            logbook.merge(data.decode("utf-8"))
        else:
            target = my_slam() if name == "my_slam.py" else Path(name)
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(data)
    print(f"taken up from {path}: {', '.join(files) or 'nothing'}")


def _packed() -> bytes:
    """A zip file with the student's own functions and the progress, as far as they are there."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as file:
        for name, path in (("my_slam.py", my_slam()), (PROGRESS, logbook.path())):
            if path.is_file():
                file.writestr(name, path.read_bytes())
    return buffer.getvalue()


def _unpacked(path: Path) -> dict[str, bytes]:
    """Name to content of all files of a zip file."""
    try:
        with zipfile.ZipFile(path) as file:
            names = [name for name in file.namelist() if not name.endswith("/")]
            bad = [n for n in names if PurePosixPath(n).is_absolute() or ".." in PurePosixPath(n).parts or "\\" in n]
            if bad:
                raise ValueError(f"{path} has a name that leads out of this folder: {bad[0]}")
            return {name: file.read(name) for name in names}
    except FileNotFoundError:
        raise ValueError(f"there is no {path} here; download it in the browser: File, Download my work") from None
    except zipfile.BadZipFile:
        raise ValueError(f"{path} is not a zip file") from None
