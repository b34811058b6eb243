"""What the tests of the wing share. Without numba, the extra `compiled`, maps in numpy are tested."""

from functools import cache
from importlib.util import find_spec

import pytest

NUMBA = find_spec("numba") is not None
OF_NUMBA = "cache", "compiled_maps", "errors", "fallback", "inputs", "kernels", "left_out", "symbols"
collect_ignore = [] if NUMBA else [f"test_{name}.py" for name in OF_NUMBA]


@pytest.fixture(scope="package", autouse=True)
def looked_after():
    """Machine code takes what it is given; here somebody looks whether that is what it was compiled for."""
    if not NUMBA:
        yield
        return
    from numba.core.sigutils import normalize_signature

    from ekfslam_tutorial.fast.compiled import filter, program

    from .interpreter import forget, looked_at

    entry, machine_code = program.entry, filter.machine_code

    @cache
    def program_looked_at(run):
        return looked_at(entry(run), run.signatures[0])

    @cache
    def kernel_looked_at(kernel, types):
        return looked_at(machine_code(kernel, types), normalize_signature(types)[0])

    with pytest.MonkeyPatch.context() as patch:
        forget()
        patch.setattr(program, "entry", program_looked_at)
        patch.setattr(filter, "machine_code", kernel_looked_at)
        yield
    forget()


@pytest.fixture
def interpreted(monkeypatch):
    """Programs are interpreted, not compiled: that would take seconds for each model."""
    if not NUMBA:
        yield
        return
    from ekfslam_tutorial.fast.compiled import step

    from .interpreter import build, forget

    forget()
    monkeypatch.setattr(step, "build", build)
    yield
    forget()


@pytest.fixture(params=["both-triangles", "one-triangle"])
def triangles(request, monkeypatch):
    """A map keeps one triangle from so many states on."""
    from ekfslam_tutorial.fast import fast_map

    monkeypatch.setattr(fast_map, "ONE_TRIANGLE", 400 if request.param == "both-triangles" else 0)
