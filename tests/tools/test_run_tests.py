"""`make test`: its summary counts what pytest reports, and nothing bad gets lost."""

import subprocess
import sys

import psutil
import pytest

from tools import run_tests

REPORT = """<?xml version="1.0"?><testsuites><testsuite name="pytest" errors="1" failures="2" skipped="3" tests="10"/>
</testsuites>"""


def record(**changes):
    return {"name": "tests", "ok": True, "passed": 5, "failed": 0, "skipped": 1, "s": 1.0, **changes}


def test_count_reads_the_report(tmp_path):
    (tmp_path / "report.xml").write_text(REPORT)
    assert run_tests.count(tmp_path / "report.xml") == {"passed": 4, "failed": 3, "skipped": 3}


def test_a_run_without_a_report_has_failed(tmp_path):
    assert run_tests.count(tmp_path / "report.xml")["failed"] == 1


def test_summary_of_good_runs(capsys):
    assert run_tests.summary([record(), record(passed=7)]) == 0
    assert capsys.readouterr().out.endswith("12 passed, 0 failed, 2 skipped\n")


@pytest.mark.parametrize("bad", [record(ok=False, failed=2), record(ok=False, passed=0)])
def test_one_bad_run_fails_the_whole(capsys, bad):
    assert run_tests.summary([record(), bad, record()]) == 1
    assert f"{max(bad['failed'], 1)} failed" in capsys.readouterr().out


def test_a_notebook_is_read_without_a_grammar_of_addresses(tmp_path, monkeypatch):
    monkeypatch.setattr(run_tests.os, "environ", dict(run_tests.os.environ))
    run_tests.leave_out("rfc3987_syntax", str(tmp_path))
    script = "import nbformat, sys; nbformat.validate(nbformat.v4.new_notebook()); print('lark' in sys.modules)"
    ran = subprocess.run(
        [sys.executable, "-c", script], env=run_tests.os.environ, capture_output=True, text=True, check=True
    )
    assert ran.stdout == "False\n"


def test_a_run_of_pytest_is_counted(tmp_path, monkeypatch):
    (tmp_path / "test_trial.py").write_text("def test_good(): pass\ndef test_bad(): assert False\n")
    monkeypatch.chdir(tmp_path)
    result = run_tests.run("trial", str(tmp_path), "-p", "no:cacheprovider")
    assert (result["ok"], result["passed"], result["failed"]) == (False, 1, 1)


@pytest.mark.parametrize(
    "words, runs", [(["-x"], ["tests", "notebooks", "images"]), (["--browser"], ["tests in a browser"])]
)
def test_what_is_run(words, runs, monkeypatch):
    """Pages are tested by `make test-browser`, all else by `make test`: between them no folder is forgotten."""
    seen = {}
    monkeypatch.setattr(run_tests, "run", lambda name, *arguments: seen.update({name: arguments}) or record(name=name))
    monkeypatch.setattr(run_tests.os, "environ", dict(run_tests.os.environ))
    assert run_tests.main(words) == 0
    assert list(seen) == runs
    left_out = {a.removeprefix("--ignore=") for a in seen.get("tests", ()) if a.startswith("--ignore=")}
    assert left_out <= {*run_tests.IN_BROWSER, run_tests.IMAGES}
    assert all((run_tests.ROOT / folder).is_dir() for folder in (*run_tests.IN_BROWSER, run_tests.IMAGES))


def test_a_run_that_finds_no_test_is_bad(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert not run_tests.run("trial", str(tmp_path), "-p", "no:cacheprovider")["ok"]


def test_a_run_that_hangs_is_stopped_with_all_that_it_started(tmp_path, monkeypatch, capsys):
    """A worker that does not answer, not even to the timeout of its own test, as after a crash of the interpreter."""
    hang = "import time; time.sleep(600)"
    script = f"import subprocess, sys; p = subprocess.Popen([sys.executable, '-c', {hang!r}]); print(p.pid, flush=True)"
    run = subprocess.Popen([sys.executable, "-c", f"{script}; p.wait()"], stdout=subprocess.PIPE, text=True)
    worker = int(run.stdout.readline())
    assert runs(worker)
    monkeypatch.setenv("EKFSLAM_TEST_LIMIT_S", "0.5")
    assert run_tests.wait(run) != 0 and "Not ended after 0.5 s" in capsys.readouterr().out
    assert not runs(worker)


def runs(pid):
    """Whether a process still does something: one that was killed may wait for its parent to ask for its exit code."""
    try:
        return psutil.Process(pid).status() != psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return False
