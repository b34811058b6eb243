"""`ekfslam lab`: JupyterLab on the student's own copy of the notebooks, opened at the first one.

The copy is made at the first visit. Later visits bring what is new in the package into it, cell by cell, and never
touch a cell that the student has changed: see `notebooks.bring_up_to_date`.
"""

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

from .files import shipped, writable_folder
from .notebooks import bring_up_to_date

NOT_OURS = ["@jupyter/nbgrader", "jupyterlab-jupytext"]
"""Extensions that bring tiles and side bars of their own, if they are installed for the tests."""
SETTINGS = {
    "@jupyterlab/apputils-extension:notification": {"fetchNews": "false", "checkForUpdates": False},
    "@jupyterlab/extensionmanager-extension:plugin": {"enabled": False},
}
"""Nothing asks another host, and no question stands before the first cell."""


def main(options):
    """Run the command."""
    folder = writable_folder(options.folder)
    done = bring_up_to_date(shipped("notebooks"), folder)
    print(f"your notebooks: {folder}" + (f" ({len(done.copied)} new)" if done.copied else ""))
    for path in done.updated:
        print(f"  updated: {path.name}; the cells that you changed are as they were")
    first = min(path.name for path in folder.glob("[0-9]*.ipynb"))
    with tempfile.TemporaryDirectory(prefix="ekfslam-lab-") as config:
        command = lab_command(folder, f"/lab/tree/{first}", options.lab)
        return subprocess.run(command, env=os.environ | alone(config), check=False).returncode


def lab_command(folder, address, arguments):
    """The command that starts JupyterLab in a folder and opens an address of it."""
    root = ["--allow-root"] if hasattr(os, "geteuid") and os.geteuid() == 0 else []
    places = [f"--notebook-dir={folder}", f"--LabApp.default_url={address}"]
    return [sys.executable, "-m", "jupyterlab", *places, *root, *arguments]


def alone(folder):
    """Write the configuration of a JupyterLab without other tools; return the environment that points to it.

    It comes before the user's own configuration, and leaves all else of it as it is.
    """
    config = Path(folder, "labconfig")
    config.mkdir(parents=True)
    page = {"disabledExtensions": dict.fromkeys(NOT_OURS, True)}
    for name, content in ("page_config", page), ("default_setting_overrides", SETTINGS):
        Path(config, f"{name}.json").write_text(json.dumps(content), encoding="utf-8")
    before = os.environ.get("JUPYTER_CONFIG_PATH")
    return {"JUPYTER_CONFIG_PATH": os.pathsep.join([str(folder), *([before] if before else [])])}
