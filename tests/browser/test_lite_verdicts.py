"""Two Pythons agree: the one that runs these tests, and the browser's, here run by node.

All listed wrong answers of every exercise get the same verdict, link, hint and name of the mistake; the states of three
runs agree to 1e-9. `make test` takes every 40th wrong answer, EKFSLAM_BROWSER=all takes all.
"""

import json
import os
import subprocess
import sys

import numpy as np
import pytest

from tools import build_lite

from .conftest import LONGEST_S, ROOT

SCRIPT = ROOT / "tests" / "course" / "verdicts.py"
PART = "1" if os.environ.get("EKFSLAM_BROWSER") == "all" else "40"
PATIENT = {"EKFSLAM_CHECK_SECONDS": "200"}  # what is asked here is what a check says, not how quickly

pytestmark = pytest.mark.timeout(2 * LONGEST_S)


# What the browser's Python runs, once, for it starts slowly: the verdicts, then answers that do not end.
IN_THE_BROWSER = f"""
import os, runpy
runpy.run_path("/host{SCRIPT.as_posix()}", run_name="__main__")
os.environ["EKFSLAM_CHECK_SECONDS"] = "0.5"
from ekfslam_tutorial.course import check
def wrap(angle):
    while True:
        try:
            pass
        except:
            pass
check("00.1", wrap)
def deep(angle):
    return deep(angle)
check("00.1", deep)
"""


@pytest.fixture(scope="module")
def both(lite_site, tmp_path_factory):
    """What the two say: this Python, the browser's, and what the latter has printed."""
    if build_lite.node() is None:
        pytest.skip("no node here, neither the system's nor that of playwright")
    folder = tmp_path_factory.mktemp("verdicts")
    here, there, script = folder / "here.json", folder / "there.json", folder / "in_the_browser.py"
    own = PATIENT | {"EKFSLAM_PROGRESS": str(folder / "progress.json")}
    subprocess.run([sys.executable, SCRIPT, here, PART], check=True, capture_output=True, env=os.environ | own)
    script.write_text(IN_THE_BROWSER, encoding="utf-8")
    run = build_lite.python_of_the_site(script, f"/host{there.as_posix()}", PART, **PATIENT)
    assert run.returncode == 0, run.stderr[-2000:]
    return *(json.loads(path.read_text(encoding="utf-8")) for path in (here, there)), run.stdout


def test_the_same_verdict_link_and_hint(both):
    here, there = (one["verdicts"] for one in both[:2])
    assert len(here) > 40 and here.keys() == there.keys()
    assert {"passed", "failed"} == {status for status, *_ in here.values()}
    assert {name: (here[name], there[name]) for name in here if here[name] != there[name]} == {}


def test_the_same_states(both):
    here, there = (one["states"] for one in both[:2])
    for scenario, states in here.items():
        for name, values in states.items():
            np.testing.assert_allclose(there[scenario][name], values, rtol=0, atol=1e-9, err_msg=f"{scenario} {name}")


def test_a_loop_without_an_end_is_stopped_there_and_the_message_says_how(both):
    said = " ".join(both[2].split())
    assert "took more than 0.5 s and was stopped, by a look at the clock at each turn of a loop" in said
    assert "Look for a loop that does not end, or has very many turns." in said
    assert "RecursionError" in said and "calls itself without end" in said
