"""The benchmark runs, agrees with its oracle, names what is missing, keeps what it has; no time is tested."""

import json
from pathlib import Path

import numpy as np
import pytest

from benchmarks import __main__ as bench
from benchmarks import agreement, clock, grid, machine, ours, ways, world
from benchmarks.oracle import Oracle
from benchmarks.peers import registry
from benchmarks.report import number, write
from benchmarks.results import Results
from benchmarks.targets import targets

HERE = Path(bench.__file__).parent
SECTIONS = {"calibration", "agreement", "grid", "circuit", "overhead", "monte_carlo", "mono", "scenario", "startup"}


@pytest.fixture(scope="module")
def smoke(tmp_path_factory, interpreted):
    """The smallest run: a folder with its three files.

    Nothing is built for it, and programs are interpreted, as in the tests of `fast`: to compile ten of them takes a
    minute. `test_scenarios.py` there holds machine code to the plain steps, `make bench` each of its own programs.
    """
    folder = tmp_path_factory.mktemp("smoke")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(registry, "_find_mrpt", lambda peers: peers.missing.update(MRPT="not built by this test"))
        bench.main(["--plan", "smoke", "--out", str(folder)])
    return folder


@pytest.fixture(scope="module")
def interpreted():
    """Programs are plain Python."""
    if not ours.COMPILED:
        yield
        return
    from ekfslam_tutorial.fast.compiled import step
    from tests.fast.interpreter import build, forget

    forget()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(step, "build", build)
        yield
    forget()


def test_a_run_fills_every_section(smoke):
    data = json.loads((smoke / "results.json").read_text(encoding="utf-8"))
    assert {key for key in SECTIONS if data[key]} == SECTIONS
    assert data["complete"] is True and data["failed"] == {}
    assert [row for row in data["grid"] if "failed" in row] == []
    assert (smoke / "speed.png").read_bytes().startswith(b"\x89PNG")


def test_every_variant_agrees_with_the_oracle(smoke):
    rows = Results.load(smoke / "results.json").rows("agreement")
    assert len(rows) >= 11
    assert [row for row in rows if not row.get("ok")] == []
    compressed = [row["deviation"] for row in rows if row["variant"] == "filter, joint, compressed"]
    assert compressed and max(compressed) <= 1e-12  # it is exact: only rounding errors are left


def test_each_peer_stands_in_its_better_way(smoke):
    results = Results.load(smoke / "results.json")
    rows, here = results.rows("fair"), set(results.variants("grid"))
    assert {"filterpy", "numba loops", "textbook numpy"} <= {row["peer"] for row in rows}
    assert set(ways.WAYS["filterpy"]) <= here and set(ways.TOTALS["filterpy"]) <= set(results.variants("circuit"))
    for row in rows:
        n, m, kind = row["n_lmks"], row["m"], row["kind"]
        us = {way: results.us(n, m, way) for way in ways.WAYS[row["peer"]] if results.us(n, m, way)}
        assert row["way"] == min(us, key=us.get)
        best = {"compiled": ways.ours(results, n, m, kind), "numpy": ways.ours(results, n, m, kind, compiled=False)}
        for key, its in best.items():
            assert row[key] == pytest.approx(us[row["way"]] / its, rel=1e-3)
    (row,) = results.rows("fair", kind="step", m=10, peer="filterpy")
    report = (smoke / "RESULTS.md").read_text(encoding="utf-8")
    assert report.index("## Times faster than each peer in its better way") < report.index("## Asked for, and measured")
    assert f"| step, m = 10: filterpy | {number(row['numpy'])}; {number(row['compiled'])} |" in report


def test_the_quickest_way_of_a_peer_counts():
    slow, quick = ({"cpu_us": {"median": us}} for us in (346.0, 90.0))
    cell = {"n_lmks": 10, "m": 10}
    grid = [cell | {"variant": "filterpy"} | slow, cell | {"variant": "filterpy, joint"} | quick]
    results = Results({"grid": [*grid, cell | {"variant": "step, joint"} | slow]})
    assert ways.quickest(results, 10, 10, "filterpy") == (90.0, "filterpy, joint")
    assert ways.quickest(results, 10, 10, "Stone Soup") == (None, None)
    asked = {t.what: t for t in targets(results)}
    assert asked["step, N = 10, m = 10: faster than filterpy, one by one"].value == 1.0
    assert asked["step, N = 10, m = 10: faster than filterpy in its better way"].met is False  # 90 us are less than 346


def test_a_missing_peer_is_named(smoke):
    report = (smoke / "RESULTS.md").read_text(encoding="utf-8")
    assert "**Missing: MRPT**: not built by this test" in report
    assert "not measured" in report  # the targets that needed it


def test_a_peer_without_a_checkout_has_no_version(tmp_path):
    """Nor is it the commit of this repository, in which the folder may be."""
    assert registry.commit(tmp_path) == "(no checkout, version unknown)"
    assert registry.commit(HERE) == "(no checkout, version unknown)"


def test_the_check_finds_a_wrong_filter():
    a = agreement.run(Oracle(world.lap(10, 3), joint=True), 5)
    wrong = a[0], a[1] * (1 + 1e-8)
    assert agreement.compared("wrong", lambda: wrong, a, "textbook")["ok"] is False
    assert agreement.compared("right", lambda: a, a, "textbook")["ok"] is True
    assert "ZeroDivisionError" in agreement.compared("broken", lambda: 1 / 0, a, "textbook")["failed"]


def test_the_oracle_is_honest():
    """Its own errors fit its own covariance: chi-square with 203 degrees of freedom, 99.9 % of it below 272."""
    lap = world.lap(100, 10)
    x, P = agreement.run(Oracle(lap, joint=True), 60)
    error = x - np.concatenate([lap.steps[59].pose, lap.lmks.ravel()])
    error[2] = world.wrap(error[2])
    assert error @ np.linalg.solve(P, error) < 272


def test_what_is_interrupted_is_kept(tmp_path, monkeypatch):
    cells = []

    def cell(n, m, *rest):
        if cells:
            raise KeyboardInterrupt
        cells.append((n, m))
        return [{"n_lmks": n, "n": 2 * n + 3, "m": m, "variant": "filter, joint", "kind": "filter"}]

    monkeypatch.setattr(grid, "cell", cell)
    monkeypatch.setattr(bench, "find", registry.Peers)
    monkeypatch.setattr(bench.agreement, "check", lambda peers: [])
    monkeypatch.setattr(bench.mono, "check", lambda: [])
    bench.main(["--plan", "smoke", "--out", str(tmp_path)])
    results = Results.load(tmp_path / "results.json")
    assert results.data["complete"] is False
    assert len(results.rows("grid")) == 1
    assert "stopped early" in (tmp_path / "RESULTS.md").read_text(encoding="utf-8")


def test_variants_take_turns_and_a_slow_one_is_left_out():
    calls = []
    variants = [clock.Variant(name, lambda name=name: lambda k: calls.append(name)) for name in ("a", "b", "slow")]
    broken = clock.Variant("broken", lambda: 1 / 0)
    found = clock.compare([*variants, broken], 0.003, rounds=3, expect=lambda name: 9.0 * (name == "slow"))

    turns = [name for i, name in enumerate(calls) if i == 0 or calls[i - 1] != name]
    assert turns.count("a") >= 3 and turns.count("b") >= 3
    assert "slow" not in calls and "9 s" in found["slow"]["skipped"]
    assert "ZeroDivisionError" in found["broken"]["failed"]
    assert found["a"]["cpu_us"]["p10"] <= found["a"]["cpu_us"]["median"] <= found["a"]["cpu_us"]["max"]


@pytest.mark.parametrize(("rank", "us"), [(2, 256.0), (20, 1600.0)])
def test_the_limit_is_bytes_or_operations(rank, us):
    """n = 2000: one triangle is 16 MB, read and written at 125 GB/s in 256 us; n^2 rank operations at 50 GFLOP/s."""
    assert machine.limit_us(2000, rank, 1, gflops=50.0, gb_per_s=125.0) == pytest.approx(us)


def test_results_of_another_schema_are_refused(tmp_path):
    path = tmp_path / "results.json"
    path.write_text('{"schema": 99}', encoding="utf-8")
    with pytest.raises(ValueError, match="schema 99"):
        Results.load(path)


@pytest.mark.skipif(not (HERE / "results.json").exists(), reason="no full run has been stored yet")
def test_the_stored_report_is_the_one_of_the_stored_numbers(tmp_path):
    results = Results.load(HERE / "results.json")
    write(results, tmp_path / "RESULTS.md")
    assert (tmp_path / "RESULTS.md").read_text(encoding="utf-8") == (HERE / "RESULTS.md").read_text(encoding="utf-8")
    for stored, row in zip(results.rows("fair"), ways.fair(results), strict=True):
        assert stored == row | {key: pytest.approx(row[key], rel=1e-3) for key in ("compiled", "numpy")}
    assert [t.what for t in targets(results)] == [row["what"] for row in results.rows("targets")]
    assert results.data["plan"] == "full" and results.data["complete"] is True
