"""Programs are kept: compiled once on a machine, whatever happens to the files, and however many write them."""

import ast
import os
import shutil
import subprocess
import sys
import tempfile
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from ekfslam_tutorial.analysis import monte_carlo
from ekfslam_tutorial.cli.files import find_scenario
from ekfslam_tutorial.fast import traces
from ekfslam_tutorial.fast.compiled import cache as kept
from ekfslam_tutorial.fast.compiled import program
from ekfslam_tutorial.toolbox import UserData

STEP = """
import numpy as np
from numba.core import event
compilations = []
class Watch(event.Listener):
    def on_start(self, event): compilations.append(event)
    def on_end(self, event): pass
watch = event.install_listener("numba:compile", Watch())
with watch:
    from ekfslam_tutorial.fast.compiled import step
    from ekfslam_tutorial.fast import FastMap
    from ekfslam_tutorial.geometry import Frame3
    map = FastMap(compiled=True)
    r = map.add([0.0, 0, 0, 2, 0, 0, 0], np.eye(7))
    done = step.normalized(map, r, Frame3)
print(done, map.x[3], len(compilations))
"""
"""The shortest program: one quaternion is normalised."""


def start(cache, code=STEP, **environment):
    """A process of its own."""
    environment = {"EKFSLAM_CACHE": str(cache), "OPENBLAS_NUM_THREADS": "1"} | environment
    return subprocess.Popen(
        [sys.executable, "-c", code],
        env=os.environ | environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def result(process):
    """Say if it was compiled code, and how much had to be compiled for it."""
    out, err = process.communicate()
    assert process.returncode == 0, err
    done, one, compilations = out.split()
    assert done == "True" and float(one) == 1.0
    return int(compilations)


def files(cache):
    """All there is, and when it was written."""
    return {path: path.stat().st_mtime_ns for path in Path(cache).rglob("*") if path.is_file()}


@pytest.fixture(scope="module")
def cache(tmp_path_factory):
    """A folder in which two processes have just put the same program, at the same time."""
    folder = tmp_path_factory.mktemp("programs")
    both = start(folder), start(folder)
    for process in both:
        result(process)
    return folder


def test_two_processes_write_the_same_program_and_the_next_ones_load_it(cache):
    (source,) = cache.glob("compiled/program_*.py")
    result(start(cache))  # of two that wrote at once, one may have dated the other's machine code
    before = files(cache)
    assert {path.suffix for path in before} >= {".py", ".nbi", ".nbc"}
    assert not list(cache.rglob("*.part")) and source in before
    assert result(start(cache)) == 0
    assert files(cache) == before


@pytest.mark.parametrize("suffix", [".py", ".nbi", ".nbc"])
@pytest.mark.parametrize("content", [b"", b"raise SystemExit('not ours')", b"\xff\xfe\x00\x80"], ids=repr)
def test_files_that_are_not_ours_are_replaced(content, suffix, tmp_path, cache, monkeypatch):
    """One process for all kinds of damage: `build` does not know which program it loads."""
    monkeypatch.setenv("EKFSLAM_CACHE", str(tmp_path))
    lines = [f"return {ord(suffix[-1])} + x + {len(content)}"]  # so that each test has a program of its own
    before = program.build("f8(f8)", "x", lines)
    (source,) = tmp_path.glob("compiled/program_*.py")
    text = source.read_text(encoding="utf-8")
    damaged = [path for path in files(tmp_path) if path.suffix == suffix]
    assert damaged
    for path in damaged:
        path.write_bytes(content)
    sys.modules.pop(source.stem)  # as in the next process
    again = program.build("f8(f8)", "x", lines)
    assert again is not before and again(2.0) == before(2.0)
    assert source.read_text(encoding="utf-8") == text


def test_a_cache_that_cannot_be_written_does_no_harm(tmp_path, monkeypatch):
    """Neither one that cannot be made nor one in which nothing can be put. Root may write everywhere: it is played."""
    (tmp_path / "file").write_text("in the way")
    monkeypatch.setenv("EKFSLAM_CACHE", str(tmp_path / "file"))
    assert program.build("f8(f8)", "x", ["return 3.0 * x"])(2.0) == 6.0

    def refuse(dir=None, **_):
        raise PermissionError(dir)

    own = SimpleNamespace(TemporaryFile=refuse, TemporaryDirectory=tempfile.TemporaryDirectory)
    monkeypatch.setattr(kept, "tempfile", own)
    monkeypatch.setenv("EKFSLAM_CACHE", str(tmp_path))
    assert program.build("f8(f8)", "x", ["return 4.0 * x"])(2.0) == 8.0
    assert program.cache_folder() == program.cache_folder() and not list((tmp_path / "compiled").glob("*.py"))


def test_where_programs_are_kept(tmp_path, monkeypatch):
    monkeypatch.setenv("EKFSLAM_CACHE", str(tmp_path / "named"))
    assert program.cache_folder() == tmp_path / "named" / "compiled"
    monkeypatch.delenv("EKFSLAM_CACHE")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "users"))
    assert program.cache_folder() == tmp_path / "users" / "ekfslam_tutorial" / "compiled"
    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.setattr(Path, "home", lambda: tmp_path / "home")
    assert program.cache_folder() == tmp_path / "home" / ".cache" / "ekfslam_tutorial" / "compiled"


KERNEL = """
import numpy as np
from numba.core import event
compilations = []
class Watch(event.Listener):
    def on_start(self, event): compilations.append(event)
    def on_end(self, event): pass
from ekfslam_tutorial.fast import FastMap
map = FastMap(compiled=True)
map.add([0.0, 0.0], np.diag([5.0, 7.0]))
with event.install_listener("numba:compile", Watch()):
    from ekfslam_tutorial.fast.compiled import maps
    print(maps.rows(map, [1])[0, 1], len(compilations) > 0)
"""


def test_a_changed_kernel_is_compiled_anew(tmp_path):
    """numba looks at the date of one file; `rows` stands in one, and what it calls in another. Without dates here."""
    package, copy = Path(program.__file__).parents[2], tmp_path / "ekfslam_tutorial"
    shutil.copytree(package, copy, ignore=shutil.ignore_patterns("__pycache__", "course", "notebooks"))
    said = lambda: (
        start(tmp_path / "cache", KERNEL, PYTHONPATH=str(tmp_path), PYTHONSAFEPATH="1").communicate()[0].split()
    )
    assert said() == ["7.0", "True"]
    assert said() == ["7.0", "False"]  # kept
    kernels = copy / "fast" / "compiled" / "kernels.py"
    text, date = kernels.read_text(), kernels.stat().st_mtime
    assert (new := text.replace("        copy(P[begin:n, i], out", "        copy(1000 + P[begin:n, i], out")) != text
    kernels.write_text(new)
    os.utime(kernels, (date + 1, date + 1))  # Python has caches of its own, by second and size
    assert said() == ["1007.0", "True"]


def test_the_name_of_the_folder_knows_all_that_machine_code_is_made_of():
    """Whatever a compiled function takes from another file of ours stands in one that the digest is of."""
    known, taken = {path.stem for path in kept.sources()}, set()
    for path in kept.HERE.glob("*.py"):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        home = {
            alias.asname or alias.name: (node.module or alias.name).split(".")[0]
            for node in ast.walk(tree)
            if isinstance(node, ast.ImportFrom) and node.level
            for alias in node.names
        }
        for node in tree.body:
            marks = [ast.unparse(mark) for mark in getattr(node, "decorator_list", [])]
            if "compiled" in marks or path.name in ("kernels.py", "tile.py"):
                names = (n.id for n in ast.walk(node) if isinstance(n, ast.Name))
                taken |= {home[name] for name in names if name in home}
    assert taken >= {"storage", "smallness", "triangle", "tile", "kernels"} and taken <= known


@pytest.mark.parametrize("name", ["kernels.py", "tile.py", "maps.py", "storage.py", "smallness.py", "triangle.py"])
def test_one_byte_of_a_source_is_another_folder(name, monkeypatch, tmp_path):
    files = []
    for path in kept.sources():
        files.append(Path(shutil.copy(path, tmp_path / path.name)))
    monkeypatch.setattr(kept, "sources", lambda: files)
    try:
        kept.key.cache_clear()
        before, file = kept.key(), tmp_path / name
        file.write_text(file.read_text().replace("e", "f", 1))
        kept.key.cache_clear()
        assert kept.key() != before
    finally:
        kept.key.cache_clear()


def test_threads_share_a_program(tmp_path, monkeypatch):
    monkeypatch.setenv("EKFSLAM_CACHE", str(tmp_path))
    with ThreadPoolExecutor(4) as threads:
        runs = [threads.submit(program.build, "f8(f8)", "x", ["return 5.0 * x"]) for _ in range(4)]
    assert len({id(run.result()) for run in runs}) == 1 and runs[0].result()(2.0) == 10.0


@pytest.mark.parametrize("value", [np.inf, -np.inf, np.nan, -0.0, 1e-320, 0.1 + 0.2, True])
def test_numbers_of_a_model_are_written_to_the_last_bit(value):
    got = eval(traces.name_of(value))
    assert np.float64(got).tobytes() == np.float64(value).tobytes() or np.isnan(value) and np.isnan(got)


def test_numba_comes_only_when_it_is_asked_for(tmp_path):
    code = """
import sys
from ekfslam_tutorial import analysis, ekf, slam, toolbox
from ekfslam_tutorial.fast import FastMap
FastMap()
print("numba" in sys.modules)
FastMap(compiled=True)
print("numba" in sys.modules)
"""
    out, err = start(tmp_path, code).communicate()
    assert out.split() == ["False", "False"], err  # the first step imports it


def test_runs_of_another_process_are_those_of_this_one():
    changes = {"options.joint": True, "options.compiled": True, "time.last": 6}
    data = UserData.from_toml(find_scenario("range_bearing_2d"), changes)
    here = monte_carlo(data, 3)
    with ProcessPoolExecutor(1, get_context("spawn")) as workers:
        there = monte_carlo(data, 3, workers)
    plain = monte_carlo(replace(data, options=replace(data.options, compiled=False)), 3)
    assert here.nees.size and np.array_equal(here.nees, there.nees, equal_nan=True)
    assert np.allclose(here.nees, plain.nees, rtol=1e-9, equal_nan=True)  # other orders of sums, as in whole runs
