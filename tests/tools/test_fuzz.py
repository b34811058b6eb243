"""The fuzzer itself, and a short run of it. Long runs: docs/recordings.md."""

import sys
from pathlib import Path

import numpy as np
import pytest

if sys.platform == "win32":
    pytest.skip("the fuzzer needs the timers of a Unix", allow_module_level=True)

TOOLS = Path(__file__).parents[2] / "tools"


@pytest.fixture
def fuzz(monkeypatch):
    monkeypatch.syspath_prepend(str(TOOLS))
    import fuzz

    return fuzz


def test_2000_inputs_are_accepted_or_refused_as_documented(fuzz, tmp_path):
    report = fuzz.run(2000, seed=20261121, keep=tmp_path)
    assert report["inputs"] == 2000 and report["findings"] == {}
    assert not list(tmp_path.iterdir())
    for name, count in report["targets"].items():
        assert count["accepted"] and count["refused"], f"{name}: all inputs meet the same fate, so little is tested"


def test_faults_are_found(fuzz, tmp_path, capsys):
    """Readers with a fault each: none is overlooked."""
    from fuzz_targets import Target

    def wrong_kind(_, data):
        raise KeyError("of ours")

    def many_lines(_, data):
        raise ValueError("one\ntwo")

    def silent(_, data):
        raise ValueError

    def endless(_, data):
        while True:
            pass

    fuzz.CPU_LIMIT = 0.2
    judge = fuzz.Judge(tmp_path)
    for read in wrong_kind, many_lines, silent, endless:
        assert not judge.judge(read.__name__, Target(read, [], (ValueError,)), None, b"bytes")
    assert judge.judge("refuses", Target(lambda m, d: int("x"), [], (ValueError,)), None, b"")
    assert judge.judge("accepts", Target(lambda m, d: 1, [], (ValueError,)), None, b"")
    kinds = " ".join(judge.findings)
    assert len(judge.findings) == 4 and all(word in kinds for word in ("KeyError", "ValueError", "TooSlow"))
    assert [p.read_bytes() for p in tmp_path.iterdir()] == [b"bytes"]
    assert capsys.readouterr().out.count("FINDING") == 4


def test_the_same_seed_gives_the_same_inputs(fuzz):
    draw = lambda seed: [fuzz.mutate(np.random.default_rng([seed, k]), b"t,x\n1,2.5\n", [b"abc"]) for k in range(50)]
    assert draw(1) == draw(1) != draw(2)
    assert len(set(draw(1))) > 25
