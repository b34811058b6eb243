"""What all tests share. The two settings must stand before the first import of numpy and matplotlib."""

import gc
import os
import shutil
import signal
import subprocess
import sys

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("MPLBACKEND", "Agg")

from pathlib import Path

import numpy as np
import psutil
import pytest
from hypothesis import settings

# The same examples each time: to look for new ones is the work of tools/fuzz.py. No limit in seconds for any of them.
settings.register_profile("the same each time", derandomize=True, deadline=None)
settings.load_profile("the same each time")

# What a shell starts in the background ignores Ctrl-C, and so do its children: the tests of Ctrl-C could not work.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


# Fifteen thousand tests are gathered before the first begins, and none of them is garbage: nobody need look at them.
gc.disable()


def pytest_collection_finish():
    """From now on garbage is collected, but not looked for among the tests themselves."""
    gc.freeze()
    gc.enable()


def _folder(variable, what):
    """Return the folder that the environment variable names, or skip the test and say why."""
    name = os.environ.get(variable)
    if not name:
        pytest.skip(f"{what}: {variable} is not set")
    folder = Path(name)
    if not folder.is_dir():
        pytest.fail(f"{variable} names {name}, which is not a folder")
    return folder


@pytest.fixture(scope="session", autouse=True)
def cache_dir(tmp_path_factory):
    """Tests leave the user's cache alone and do not live on what is in it.

    Processes that test side by side share one, made by tools/run_tests.py: a program is compiled once for all of them.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("EKFSLAM_CACHE", os.environ.get("EKFSLAM_TEST_CACHE") or str(tmp_path_factory.mktemp("cache")))
        patch.setenv("EKFSLAM_MY_SLAM", str(tmp_path_factory.mktemp("kept") / "my_slam.py"))
        yield


@pytest.fixture(scope="module", autouse=True)
def environment_is_left_as_it_was():
    """A variable that the tests of a file lose, or leave behind, would decide what later files test."""
    before = {name: value for name, value in os.environ.items() if name.startswith("EKFSLAM_")}
    yield
    assert {name: value for name, value in os.environ.items() if name.startswith("EKFSLAM_")} == before


@pytest.fixture(scope="session")
def data_dir():
    """Folder of the real logs as their publishers give them (EKFSLAM_DATA)."""
    return _folder("EKFSLAM_DATA", "the real logs are not here")


@pytest.fixture(scope="session")
def golden_dir():
    """Folder of the numbers recorded from other programs (EKFSLAM_GOLDEN)."""
    return _folder("EKFSLAM_GOLDEN", "the recorded reference numbers are not here")


@pytest.fixture(scope="session")
def chromium():
    """A running Chromium, driven by playwright: the system's own, for playwright's download may not be there."""
    program = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
    if program is None:
        pytest.skip("no Chromium here: on Debian, apt install chromium")
    playwright = pytest.importorskip("playwright.sync_api", reason="the package playwright is not installed")
    # No sandbox: it does not start as root, and it shows our own pages only. The last one gives it WebGL without a
    # graphics card, the others keep it from calling home.
    quiet = ["--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking"]
    quiet += ["--disable-component-update", "--disable-sync", "--enable-unsafe-swiftshader"]
    with playwright.sync_playwright() as p:
        browser = p.chromium.launch(executable_path=program, args=quiet)
        yield browser
        browser.close()


@pytest.fixture
def rng():
    """A random generator that starts anew, with the same seed, in each test."""
    return np.random.default_rng(20260401)


@pytest.fixture
def undrawn(monkeypatch):
    """The pictures of a run in this process are made, but not drawn: that takes half of the time of a short run."""
    from ekfslam_tutorial.cli import robot_views, views

    for module in (views, robot_views):
        monkeypatch.setattr(module, "save_figure", made_only)


def made_only(fig, path):
    """In the place of `save_figure`: close the figure and leave an empty file."""
    sys.modules["matplotlib.pyplot"].close(fig)
    path.touch()
    return path.name


@pytest.fixture
def ekfslam_process():
    """Return a function that starts `ekfslam` with these words in a process of its own, its output in pipes.

    What still runs at the end of the test is killed, with all that it started.
    """
    processes = []

    def start(*words, **environment):
        command = [sys.executable, "-m", "ekfslam_tutorial", *map(str, words)]
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
        processes.append(subprocess.Popen(command, **pipes, text=True, env=os.environ | environment))
        return processes[-1]

    yield start
    for process in processes:
        if process.poll() is None:
            for one in [*psutil.Process(process.pid).children(recursive=True), process]:
                one.kill()
        process.communicate()


LONG_FIRST = (
    "course/test_notebooks.py",
    "course/test_own_filter.py",
    "course/test_widgets.py",
    "datasets/test_mrclam_real.py",
    "course/test_projects",
    "course/test_own_filter_real.py",
    "course/test_bent_answers.py",
    "course/test_exercises.py",
    "course/test_nbgrader.py",
    "test_cli.py",
    "golden/",
    "fast/",
    "analysis/",
    "browser/test_lab.py",
    "site/",
)
"""What takes longest, half a minute or more: workers begin with it, so that none waits for another at the end."""


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """Put the longest files first; else the order stays."""

    def place(item):
        return next((i for i, name in enumerate(LONG_FIRST) if f"tests/{name}" in item.nodeid), len(LONG_FIRST))

    items.sort(key=place)
