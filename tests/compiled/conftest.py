"""What the tests of compiled maps share; without numba there is nothing to test."""

from functools import cache

import pytest

pytest.importorskip("numba", reason="numba, the extra `compiled`, is not installed")

from numba.core.sigutils import normalize_signature

from ekfslam_tutorial.compiled import filter, program

from .interpreter import forget, interpreted, looked_at

__all__ = ["interpreted"]


@pytest.fixture(scope="package", autouse=True)
def looked_after():
    """Machine code takes what it is given; here somebody looks whether that is what it was compiled for."""
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
