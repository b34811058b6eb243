"""`ekfslam doctor`: what is installed, what is missing, and a one-line cure for each problem."""

import importlib.metadata
import importlib.util
import json
import os
import shutil
import sys
from pathlib import Path

from .. import __version__
from .files import PACKAGE, scenarios, shipped
from .terminal import say

NEEDED = {"numpy": "1.26", "scipy": "1.11", "matplotlib": "3.8", "ipywidgets": "8.1", "rich": "13"}
LAB = {"jupyterlab": "4.2", "ipykernel": "6", "jupyterlab_widgets": "3"}
NUMBA = "0.61"


def main(options):
    """Run the command: print all findings; 1 if there is a problem."""
    problems = 0
    for name, finding, cure in findings():
        problems += bool(cure)
        say(f"{'PROBLEM' if cure else 'ok':8} {name:18} {finding}", "bold dark_orange" if cure else "")
        if cure:
            say(f"{'':8} {'':18} cure: {cure}")
    say("all is well" if not problems else f"{problems} problem{'s' * (problems > 1)}", "bold")
    return 1 if problems else 0


def findings():
    """All checks: name, what was found, and the cure (empty where there is no problem)."""
    yield python()
    yield "ekfslam_tutorial", f"{__version__} in {PACKAGE}", ""
    for name, least in (NEEDED | LAB).items():
        yield package(name, least, f"python -m pip install '{name}>={least}'")
    yield kernel()
    yield widgets()
    yield files("notebooks", list(shipped("notebooks").glob("*.ipynb")))
    yield files("scenarios", list(scenarios()))
    yield data()
    yield compiled()
    yield "movies", "MP4 (ffmpeg)" if shutil.which("ffmpeg") else "GIF (no ffmpeg: that is enough)", ""
    yield results()


def python():
    """Version and place of the Python that runs."""
    version = ".".join(map(str, sys.version_info[:3]))
    cure = "" if sys.version_info >= (3, 11) else "install Python 3.11 or newer and make the environment anew"
    return "python", f"{version} at {sys.executable}", cure


def package(name, least, cure):
    """Say if a package is there, new enough, and can be imported."""
    try:
        version = importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return name, "missing", cure
    if importlib.util.find_spec(name) is None:
        return name, f"{version}, but it cannot be imported", f"python -m pip install --force-reinstall {name}"
    return (name, f"{version}, older than {least}", cure) if _key(version) < _key(least) else (name, version, "")


def _key(version):
    """The leading numbers of a version, to compare."""
    numbers = []
    for part in version.split("."):
        if not part.isdigit():
            break
        numbers.append(int(part))
    return numbers


def kernel():
    """Say if notebooks run on this Python: where the kernel of this environment points to."""
    spec = Path(sys.prefix, "share", "jupyter", "kernels", "python3", "kernel.json")
    cure = "python -m ipykernel install --sys-prefix"
    try:
        command = json.loads(spec.read_text(encoding="utf-8"))["argv"][0]
    except (OSError, ValueError, KeyError, IndexError, TypeError):
        return "kernel", f"no kernel 'python3' in {sys.prefix}", cure
    if os.path.sep not in command:  # "python": the one that Jupyter itself runs on
        return "kernel", "python3, the Python that starts Jupyter", ""
    if not Path(command).exists() or Path(command).parent.resolve() != Path(sys.executable).parent.resolve():
        return "kernel", f"python3 is {command}, not this Python", cure
    return "kernel", f"python3 is {command}", ""


def widgets():
    """Say if JupyterLab has the browser side of ipywidgets."""
    folder = Path(sys.prefix, "share", "jupyter", "labextensions", "@jupyter-widgets", "jupyterlab-manager")
    if folder.is_dir():
        return "widgets", "the widget manager of JupyterLab is installed", ""
    return "widgets", "JupyterLab has no widget manager", "python -m pip install --force-reinstall jupyterlab_widgets"


def files(name, there):
    """Say if files that come with the package are there."""
    cure = "" if there else "install the package again, or run in a complete clone of the repository"
    return name, f"{len(there)} found", cure


def data():
    """Say if the folder of real logs that the user names exists. Not to have them is no problem."""
    named = os.environ.get("EKFSLAM_DATA", "")
    gone = [p for p in named.split(os.pathsep) if p and not Path(p).expanduser().is_dir()]
    if gone:
        return (
            "data",
            f"EKFSLAM_DATA names {gone[0]}, which does not exist",
            "set EKFSLAM_DATA to the folder of the logs",
        )
    return "data", named or "EKFSLAM_DATA is not set: simulated twins stand in for the real logs", ""


def compiled():
    """Say if steps can be compiled, and where the programs are kept. Not to have numba is no problem."""
    extra = "python -m pip install --upgrade 'ekfslam_tutorial[compiled]'"
    if importlib.util.find_spec("numba") is None:
        return "compiled", f"no numba: `compiled = true` needs it ({extra})", ""
    _, version, cure = package("numba", NUMBA, extra)
    if cure:
        return "compiled", f"numba {version}", cure
    try:
        from ..fast.compiled.program import cache_folder
    except ImportError as error:  # numba and numpy do not fit, or one of them is damaged
        return "compiled", f"numba {version} cannot be imported: {error}", extra
    folder = cache_folder()  # a temporary one if the user's cannot be written
    cure = "" if folder.name == "compiled" else "set EKFSLAM_CACHE to a folder of your own, to compile once only"
    return "compiled", f"numba {version}; programs are kept in {folder}", cure


def results():
    """Say if results can be written here."""
    if os.access(".", os.W_OK):
        return "results", "can be written below this folder", ""
    return "results", f"cannot be written below {Path.cwd()}", "change to a folder of your own, or use --out DIR"
