"""How long a user waits before anything happens: what an import brings along, and a generous bound on its time."""

import subprocess
import sys

import pytest

from tests.pace import slowness

SLOW = {"scipy.stats", "scipy.optimize", "scipy.interpolate", "scipy.io", "scipy.ndimage", "pandas", "dask", "h5py"}
SLOW |= {"scipy.linalg", "scipy.special", "scipy.sparse", "scipy.spatial"}
"""Each takes between 0.1 and 2 s, in a browser five times as long; who needs one imports it where it is needed."""

NOTEBOOK = """
from ekfslam_tutorial import analysis, datasets, ekf, geometry, graphics, models, simulation, slam, toolbox
from ekfslam_tutorial.course import check, explore, hint, progress, replay, reveal, show
from ekfslam_tutorial.course.draws import films, parts, nb01, nb02, nb05, nb10, nb13
"""


def loaded(code):
    """The modules that are there after this code, in a fresh interpreter."""
    code += "\nimport sys; print(*sys.modules)"
    return set(subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split())


def test_the_package_itself_imports_nothing():
    brought = loaded("import ekfslam_tutorial") - loaded("")
    assert brought == {"ekfslam_tutorial"}


def test_the_package_is_there_at_once():
    """It takes 1 ms here; asked are 0.3 s, of the processor: other programs do not count."""
    clock = "import time; t = time.process_time(); import ekfslam_tutorial; print(time.process_time() - t)"
    run = subprocess.run([sys.executable, "-c", clock], capture_output=True, text=True, check=True)
    assert float(run.stdout) < 0.3 * slowness()


def test_the_version_is_told_at_once():
    """The command imports nothing heavy before it knows what is asked."""
    code = "import sys; sys.argv = ['ekfslam', '--version']\nfrom ekfslam_tutorial.cli import main\n"
    brought = loaded(f"{code}try: main()\nexcept SystemExit: pass")
    assert "ekfslam_tutorial.cli.main" in brought and brought & {"numpy", "scipy", "matplotlib", "IPython"} == set()


@pytest.mark.parametrize("code", ["from ekfslam_tutorial import slam, toolbox", NOTEBOOK], ids=["core", "notebook"])
def test_nothing_slow_comes_along(code):
    assert loaded(code) & SLOW == set()
