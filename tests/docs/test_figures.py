"""The measured figures that docs/differences.md states are those that the comparison with the recorded runs gives."""

import re
from pathlib import Path

from ..golden.measured import measured

ROOT = Path(__file__).parents[2]
ROW = re.compile(r"^\| `(\w+)`: .* \| ([\d.]+) % \| ([\d.]+) % \| ([\d.]+) mm \| ([\d.]+) deg \|$", re.MULTILINE)


def agrees(stated, measured):
    """Return True if a number is the measured one, rounded to the digits that the page gives."""
    digits = len(stated.partition(".")[2])
    return abs(float(stated) - measured) <= 0.51 * 10**-digits


def test_the_table_of_recorded_runs_is_what_is_measured(golden_dir):
    page = (ROOT / "docs" / "differences.md").read_text(encoding="utf-8")
    stated = {name: figures for name, *figures in ROW.findall(page)}
    lines = [line for name in stated for line in measured(golden_dir, name)]

    recorded = {m["run"]: m for m in lines if m.get("against") == "recorded"}
    assert len(stated) == 7 and set(stated) == set(recorded)
    for name, figures in stated.items():
        m = recorded[name]
        got = [100 * m["in_order"], 100 * m["per_frame"], m["pose_mm"], m["pose_deg"]]
        assert all(map(agrees, figures, got)), f"{name}: the page says {figures}, measured is {got}"
    assert all(m["in_order"] == 1 and m["pose_mm"] < 1e-9 for m in lines if m.get("against") == "exact")


def test_the_check_itself_sees_a_wrong_figure():
    assert agrees("7.6", 7.63) and agrees("100", 100.0) and not agrees("7.6", 7.7)
