"""What is published: a wheel and an sdist that work where there is no repository."""

import os
import subprocess
import sys
import sysconfig
import tarfile
import venv
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """A wheel and an sdist of the files that git knows (or would know: what is not ignored)."""
    folder = tmp_path_factory.mktemp("dist")
    subprocess.run(
        [sys.executable, "-m", "hatchling", "build", "-d", folder], cwd=ROOT, check=True, capture_output=True
    )
    (wheel,), (sdist,) = folder.glob("*.whl"), folder.glob("*.tar.gz")
    return wheel, sdist


@pytest.fixture(scope="module")
def installed(built, tmp_path_factory):
    """The wheel in an environment of its own; it sees the dependencies of this one, but not this repository."""
    folder = tmp_path_factory.mktemp("clean") / "env with space"
    venv.create(folder, with_pip=False, symlinks=os.name != "nt")
    python = folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    code = "import sysconfig; print(sysconfig.get_path('purelib'))"
    site = Path(subprocess.run([python, "-c", code], capture_output=True, text=True, check=True).stdout.strip())
    # A folder that a .pth file names is searched, but its own .pth files, the editable install's, are not read.
    (site / "dependencies.pth").write_text(sysconfig.get_path("purelib") + "\n")
    pip = [sys.executable, "-m", "pip", "--python", str(python), "install", "--quiet", "--no-index", "--no-deps"]
    subprocess.run([*pip, "--ignore-installed", str(built[0])], check=True, capture_output=True)
    return python


def run(python, *command, cwd):
    environment = {k: v for k, v in os.environ.items() if not k.startswith(("EKFSLAM_", "PYTHON"))}
    environment["EKFSLAM_PROGRESS"] = str(cwd / "progress.json")
    environment["EKFSLAM_MY_SLAM"] = str(cwd / "my_slam.py")
    done = subprocess.run([python, *command], cwd=cwd, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def names(sdist):
    with tarfile.open(sdist) as archive:
        return {member.name.split("/", 1)[1] for member in archive.getmembers() if member.isfile()}


def test_the_wheel_has_the_code_the_notebooks_and_the_scenarios(built):
    held = zipfile.ZipFile(built[0]).namelist()
    assert "ekfslam_tutorial/py.typed" in held
    for folder, pattern, place in [
        ("ekfslam_tutorial", "**/*.py", "ekfslam_tutorial"),
        ("ekfslam_tutorial/graphics/player", "*.js", "ekfslam_tutorial/graphics/player"),
        ("ekfslam_tutorial/course/slides", "*.*s", "ekfslam_tutorial/course/slides"),
        ("notebooks", "[0-9]*.ipynb", "ekfslam_tutorial/_share/notebooks"),
        ("data/scenarios", "*.toml", "ekfslam_tutorial/_share/data/scenarios"),
    ]:
        files = [p.relative_to(ROOT / folder) for p in (ROOT / folder).glob(pattern)]
        assert files and {f"{place}/{p.as_posix()}" for p in files} <= set(held), folder
    assert not [name for name in held if name.startswith(("tests", "tools", "benchmarks"))]


def test_the_wheel_is_small(built):
    assert built[0].stat().st_size < 12e6  # 25 notebooks with their pictures; a data set would show


def test_the_sdist_builds_the_same_wheel(built, tmp_path):
    wheel, sdist = built
    with tarfile.open(sdist) as archive:
        archive.extractall(tmp_path, filter="data")
    (tree,) = tmp_path.iterdir()
    command = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", tmp_path / "again"]
    subprocess.run(command, cwd=tree, check=True, capture_output=True)
    (again,) = (tmp_path / "again").glob("*.whl")
    contents = [{i.filename: i.CRC for i in zipfile.ZipFile(w).infolist()} for w in (wheel, again)]
    assert contents[0] == contents[1]


def test_the_sdist_can_be_tested(built):
    held = names(built[1])
    assert {"Makefile", "requirements.txt", "tests/conftest.py", "tools/run_tests.py", "LICENSE"} <= held
    assert not [name for name in held if name.startswith((".venv", "build/", ".git/"))]


def test_an_installed_wheel_runs_a_scenario(installed, tmp_path):
    where = run(installed, "-c", "import ekfslam_tutorial as e; print(e.__file__)", cwd=tmp_path)
    assert str(ROOT) not in where and "site-packages" in where
    run(installed, "-m", "ekfslam_tutorial", "run", "lecture_mapping", "--out", "out", cwd=tmp_path)
    assert (tmp_path / "out" / "result.json").stat().st_size > 100


def test_an_installed_wheel_hands_out_its_notebooks(installed, tmp_path):
    run(installed, "-m", "ekfslam_tutorial", "notebooks", "mycourse", cwd=tmp_path)
    copies = sorted(p.name for p in (tmp_path / "mycourse").glob("*.ipynb"))
    assert copies == sorted(p.name for p in (ROOT / "notebooks").glob("*.ipynb"))
    run(installed, "-c", "from ekfslam_tutorial.course import check, explore", cwd=tmp_path)
