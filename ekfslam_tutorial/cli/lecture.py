"""`ekfslam lecture NN`: the lecture cut of a notebook, live in JupyterLab, or as slides in one HTML file."""

import json
import os
import subprocess
import tempfile
from pathlib import Path

from ..course import lecture
from ..course.nbgrader import find
from .files import replacing
from .lab import alone, lab_command

DPI = 150  # of pictures that are drawn for a projector: more than the notebook's
FONTS = {"code-font-size": "17px", "content-font-size1": "21px", "ui-font-size1": "14px"}  # for the last row
HIDDEN = {"collapsed": True, "visible": False, "widgets": [], "widgetStates": {}}
LAYOUT = {"main": {}, "left": HIDDEN, "right": HIDDEN, "relativeSizes": [0, 1, 0], "top": {"simpleVisibility": False}}
NO_SIDE_BARS = {"data": {"layout-restorer:data": LAYOUT}, "metadata": {"id": "default"}}


def main(options):
    """Run the command."""
    path = find(options.notebook)
    notebook = json.loads(path.read_text(encoding="utf-8"))
    if options.slides is None:
        return live(notebook, path.stem, options.lab)
    from ..course import slides  # needs nbconvert

    target = Path(options.slides)
    if not target.parent.is_dir():
        raise FileNotFoundError(f"there is no folder {target.parent} to write {target.name} into")
    if target.is_dir():
        raise IsADirectoryError(f"{target} is a folder: name a file in it, {target / 'slides.html'}")
    if options.run:
        notebook = run(notebook, path.parent)
    text = slides.page(notebook)
    with replacing(target) as part:
        part.write_text(text, encoding="utf-8")
    print(f"written: {target}, {text.count('<section')} slides, {len(text.encode()) / 1e6:.1f} MB, complete in itself")
    print("keys: arrows, Home, End; in the browser F11 fills the screen, and printing makes a PDF")
    return 0


def run(notebook, folder):
    """The notebook with fresh outputs and sharp pictures."""
    import nbformat
    from nbclient import NotebookClient

    nb = nbformat.reads(json.dumps(notebook), as_version=4)
    quiet = ["--IPKernelApp.log_level=CRITICAL"]  # an error in a cell comes from nbclient
    at = {"metadata": {"path": str(folder)}}
    client = NotebookClient(nb, timeout=600, kernel_name="python3", extra_arguments=quiet, resources=at)
    with tempfile.TemporaryDirectory() as private:
        own = {"EKFSLAM_PROGRESS": "progress.json", "EKFSLAM_MY_SLAM": "my_slam.py"}  # the lecturer's stay as they are
        own = {variable: os.path.join(private, name) for variable, name in own.items()}
        try:
            client.execute(env=os.environ | {"EKFSLAM_DPI": str(DPI)} | own)
        except BaseException as error:
            if getattr(client, "_async_cleanup_kernel_future", None) is None:
                raise
            raise KeyboardInterrupt from error  # at Ctrl-C nbclient ends the kernel, and then misses it in many ways
    return json.loads(nbformat.writes(nb))


def live(notebook, name, arguments):
    """Open the cut in JupyterLab, with large letters; it is a copy that is gone afterwards."""
    with tempfile.TemporaryDirectory(prefix="ekfslam-lecture-") as folder:
        file = Path(folder, f"{name}.ipynb")
        file.write_text(json.dumps(lecture.cut(notebook), indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
        command = lab_command(folder, f"/doc/tree/{file.name}", arguments)
        return subprocess.run(command, env=os.environ | for_a_projector(folder), check=False).returncode


def for_a_projector(folder):
    """Write settings with large letters and without side bars; return the environment that points to them."""
    from jupyterlab_server.workspaces_handler import WorkspacesManager

    config, settings, workspaces = (Path(folder, name) for name in (".config", ".settings", ".workspaces"))
    theme = settings / "@jupyterlab" / "apputils-extension" / "themes.jupyterlab-settings"
    theme.parent.mkdir(parents=True)
    theme.write_text(json.dumps({"overrides": FONTS}), encoding="utf-8")
    workspaces.mkdir()
    WorkspacesManager(str(workspaces)).save("default", json.dumps(NO_SIDE_BARS))
    places = {"JUPYTERLAB_SETTINGS_DIR": str(settings), "JUPYTERLAB_WORKSPACES_DIR": str(workspaces)}
    return alone(config) | places | {"EKFSLAM_DPI": str(DPI)}
