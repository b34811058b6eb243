"""The repository as a whole: versions agree, files are small, nothing names a computer or an index host."""

import importlib.metadata
import json
import re
import shutil
import subprocess
import tomllib
from pathlib import Path

import nbformat
import pytest
import yaml

import ekfslam_tutorial

ROOT = Path(__file__).resolve().parent.parent
FILE_KB, NOTEBOOK_KB, DATA_KB = 800, 600, 200


def tracked_files():
    """Return the files under version control; none where git is not there to ask (an unpacked archive)."""
    if not shutil.which("git") or not (ROOT / ".git").exists():
        return []
    run = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=True)
    return [ROOT / name for name in run.stdout.split("\0") if name and (ROOT / name).is_file()]


TRACKED = tracked_files()
NOTEBOOKS = sorted((ROOT / "notebooks").glob("*.ipynb"))
needs_git = pytest.mark.skipif(not TRACKED, reason="not a git checkout: no list of tracked files")


@needs_git
def test_git_holds_files_only():
    """No symbolic link, such as one to the environment of another copy, and no repository in this one."""
    listed = subprocess.run(
        ["git", "ls-files", "-s", "-z"], cwd=ROOT, capture_output=True, text=True, check=True
    ).stdout
    modes = {entry.partition("\t")[2]: entry[:6] for entry in listed.split("\0") if entry}
    assert set(modes.values()) <= {"100644", "100755"}, {name: m for name, m in modes.items() if m[:3] != "100"}


def text_files():
    for path in TRACKED:
        data = path.read_bytes()
        if b"\0" not in data:
            yield path, data.decode("utf-8")


def lines_that_match(pattern):
    return [
        f"{path.relative_to(ROOT)}:{number}: {line[:100]}"
        for path, text in text_files()
        for number, line in enumerate(text.splitlines(), start=1)
        if re.search(pattern, line)
    ]


# --- versions ---


def test_one_version():
    version = ekfslam_tutorial.__version__
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    released = re.findall(r"^## \[(\d[^\]]*)\]", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), re.MULTILINE)
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))

    assert str(citation["version"]) == version
    assert released[0] == version
    assert importlib.metadata.version("ekfslam_tutorial") == version
    # pyproject.toml states no number of its own: it reads the same line.
    assert "version" in project["project"]["dynamic"]
    assert project["tool"]["hatch"]["version"]["path"] == "ekfslam_tutorial/__init__.py"


# --- the lock ---


def locked():
    """Return the locked packages as {name: text of the entry}, hashes included."""
    text = (ROOT / "requirements.txt").read_text(encoding="utf-8")
    entries = re.split(r"\n(?=[A-Za-z0-9])", text)
    return {re.split(r"[=\s]", entry)[0].lower(): entry for entry in entries if re.match(r"[A-Za-z0-9]", entry)}


def test_every_locked_package_has_an_exact_version_and_hashes():
    bad = [name for name, entry in locked().items() if "==" not in entry or "--hash=sha256:" not in entry]
    assert locked() and bad == []


def test_the_lock_holds_every_package_that_pyproject_asks_for():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    extras = project["project"]["optional-dependencies"]
    asked = project["project"]["dependencies"] + extras["lab"] + extras["test"] + extras["data"] + extras["compiled"]
    asked += project["build-system"]["requires"]
    names = {re.split(r"[<>=!~\[ ;]", item)[0].lower() for item in asked}
    assert names - set(locked()) == set()


# --- what must not stand in a tracked file ---


@needs_git
def test_no_index_host_is_named():
    # In pieces, so that this file does not name them either.
    hosts = ["pypi" + ".org", "python" + "hosted", "npm" + "js", "deb." + "debian", "conda." + "anaconda"]
    assert lines_that_match("|".join(map(re.escape, hosts))) == []


@needs_git
def test_no_path_of_a_computer_stands_in_a_file():
    folders = ["ro" + "ot", "wo" + "rk", "ho" + "me/[a-z]", "Us" + "ers/[a-zA-Z]"]
    assert lines_that_match(r"(?<![\w.\-/}])/(" + "|".join(folders) + r")(/|\b)") == []


@needs_git
def test_files_are_small():
    def limit_kb(path):
        if path.suffix == ".ipynb":
            return NOTEBOOK_KB
        return DATA_KB if path.is_relative_to(ROOT / "data") else FILE_KB

    large = [(path.name, path.stat().st_size) for path in TRACKED if path.stat().st_size > 1000 * limit_kb(path)]
    assert large == []


@needs_git
def test_no_environment_or_build_is_tracked():
    folders = {".venv", "build", "dist", "__pycache__", ".ipynb_checkpoints"}
    assert [path for path in TRACKED if folders & set(path.relative_to(ROOT).parts)] == []


# --- notebooks ---


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda p: p.name)
def test_a_notebook_is_stored_as_the_builder_writes_it(path):
    text = path.read_text(encoding="utf-8")
    nb = nbformat.reads(text, as_version=4)
    nbformat.validate(nb)
    code = [cell for cell in nb.cells if cell.cell_type == "code" and cell.source.strip()]
    number = path.name.split("_")[0]

    assert [cell.execution_count for cell in code] == list(range(1, len(code) + 1))
    assert not [cell.id for cell in nb.cells if not cell.id.startswith(f"{number}-")]
    assert not [cell.id for cell in code for output in cell.outputs if output.output_type == "error"]
    assert "widgets" not in nb.metadata
    assert "version" not in nb.metadata.get("language_info", {})
    kinds = {kind for cell in code for output in cell.outputs for kind in output.get("data", ())}
    assert not kinds & {"image/svg+xml", "application/vnd.jupyter.widget-view+json"}  # an SVG stands in an <img>
    assert text.endswith("\n") and json.loads(text)["nbformat"] == 4


# --- make ---


def make(*arguments):
    run = subprocess.run(["make", *arguments], cwd=ROOT, capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    return run.stdout


needs_make = pytest.mark.skipif(not shutil.which("make"), reason="make is not installed")


@needs_make
def test_help_lists_every_target():
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    targets = re.search(r"^\.PHONY: (.*)$", makefile, re.MULTILINE)
    assert targets
    listed = re.findall(r"^make ([\w-]+) +\S", make("help"), re.MULTILINE)
    assert sorted(listed) == sorted(targets[1].split())


@needs_make
def test_make_lab_keeps_the_token():
    """The recipe starts JupyterLab with its own defaults, on loopback, with a token; see test_lab_command, too."""
    recipe = make("--dry-run", "lab")
    assert "ekfslam_tutorial lab" in recipe
    assert not re.search(r"token|password|--ip|disable_check", recipe)


@needs_make
def test_make_lab_passes_arguments_on():
    assert "--no-browser --port 9999" in make("--dry-run", "lab", "LAB_ARGS=--no-browser --port 9999")
