"""Low-level functions against the values recorded from another program."""

import json
from pathlib import Path

import numpy as np
import pytest

from .functions import ADAPTERS, check_file, main
from .records import NOT_HERE, compare

KEPT = Path(__file__).parent / "data" / "functions"
MEASURED = ("points", "frames", "rotations", "motion", "camera")  # of these at least 95 % must be comparable
REASONS = {
    NOT_HERE,
    "degenerate: singular input",
    "the recorded Jacobian is documented as approximate",
    "the recorded program cannot run it",
}


def check(folder):
    """All that is compared must pass. Returns the lines by file."""
    lines = {}
    for path in sorted(folder.glob("*.json")):
        line, failures = check_file(path)
        assert failures == []
        assert line["compared"] == line["passed"]
        assert line["records"] == line["compared"] + sum(line["skipped"].values())
        assert set(line["skipped"]) | set(line["skipped_outputs"]) <= REASONS
        lines[line["file"]] = line
    return lines


def test_kept_records():
    lines = check(KEPT)
    assert all(lines[name]["compared"] >= 5 for name in MEASURED)


def test_all_records(golden_dir):
    lines = check(golden_dir / "functions")
    for name in MEASURED:
        assert lines[name]["compared"] >= 0.95 * lines[name]["records"], lines[name]


def test_one_line_per_file(capsys):
    assert main([str(KEPT)]) == 0
    lines = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert [line["file"] for line in lines] == sorted(path.stem for path in KEPT.glob("*.json"))
    assert {"records", "compared", "passed", "skipped"} <= set(lines[0])


def test_a_folder_without_records_is_named(tmp_path, capsys):
    with pytest.raises(SystemExit):
        main([str(tmp_path)])
    assert str(tmp_path) in capsys.readouterr().err


def numbers(out):
    """Where the numbers of an output are: (row, index) pairs into recorded lists."""
    if "fields" in out:
        return [place for field in out["fields"].values() for place in numbers(field)]
    return [(row, i) for row in out["value"] for i, x in enumerate(row) if isinstance(x, (int, float))]


@pytest.mark.parametrize("name", MEASURED)
def test_the_comparison_sees_a_wrong_digit(name):
    """Each record must fail when its largest number is changed in the seventh digit: no comparison is empty."""
    seen = 0
    for record in json.loads((KEPT / f"{name}.json").read_text(encoding="utf-8")):
        result = compare(record, ADAPTERS)
        if "skip" in result:
            continue
        key = "outs_graph" if "outs_graph" in record else "outs"
        places = numbers(record[key][0])
        row, i = max(places, key=lambda place: abs(place[0][place[1]]))
        row[i] += 1e-7 * max(1, abs(row[i]))
        assert compare(record, ADAPTERS)["worst"] > 1, (record["index"], record["fn"])
        seen += 1
    assert seen >= 5


def test_the_comparison_sees_a_wrong_jacobian_in_the_tangent_space_only():
    """A derivative along the quaternion itself is free; one across it is not."""
    records = json.loads((KEPT / "rotations.json").read_text(encoding="utf-8"))
    record = next(r for r in records if r["fn"] == "q2R")
    q = np.ravel(record["args"][0]["value"])
    J = np.array(record["outs"][1]["value"])
    across = np.array([-q[1], q[0], -q[3], q[2]])
    for direction, passes in ((q, True), (across, False)):
        record["outs"][1]["value"] = (J + 0.1 * np.outer(np.ones(9), direction)).tolist()
        assert (compare(record, ADAPTERS)["worst"] <= 1) == passes
