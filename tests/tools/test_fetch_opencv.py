"""OpenCV for the tests of images: it is fetched once for each lock, and one sentence says why it cannot be."""

import hashlib
import subprocess
import sys
import zipfile
from pathlib import Path

from tools import run_tests

TOOL = Path(run_tests.__file__).with_name("fetch_opencv.py")
INFO = "trial-1.0.dist-info"


def fetch(folder, lock, monkeypatch):
    """Run the tool where there is no package index."""
    monkeypatch.setenv("PIP_NO_INDEX", "1")
    return subprocess.run([sys.executable, TOOL, folder, lock], capture_output=True, text=True)


def test_a_lock_is_fetched_once(tmp_path, monkeypatch):
    wheel, lock, folder = tmp_path / "trial-1.0-py3-none-any.whl", tmp_path / "lock.txt", tmp_path / "images"
    with zipfile.ZipFile(wheel, "w") as file:
        file.writestr("trial.py", "here = True\n")
        file.writestr(f"{INFO}/METADATA", "Metadata-Version: 2.1\nName: trial\nVersion: 1.0\n")
        file.writestr(f"{INFO}/WHEEL", "Wheel-Version: 1.0\nRoot-Is-Purelib: true\nTag: py3-none-any\n")
        file.writestr(f"{INFO}/RECORD", "".join(f"{name},,\n" for name in ("trial.py", f"{INFO}/RECORD")))
    lock.write_text(f"{wheel.as_uri()} --hash=sha256:{hashlib.sha256(wheel.read_bytes()).hexdigest()}\n")
    assert fetch(folder, lock, monkeypatch).returncode == 0
    made = (folder / "trial.py").stat().st_mtime_ns
    wheel.unlink()  # what is not asked for is not missed
    assert fetch(folder, lock, monkeypatch).returncode == 0 and (folder / "trial.py").stat().st_mtime_ns == made
    lock.write_text("trial==2.0 --hash=sha256:" + 64 * "0")
    assert fetch(folder, lock, monkeypatch).returncode == 1, "another lock, but nothing was fetched"


def test_why_it_cannot_be_fetched(tmp_path, monkeypatch):
    (tmp_path / "lock.txt").write_text("trial==2.0 --hash=sha256:" + 64 * "0")
    run = fetch(tmp_path / "images", tmp_path / "lock.txt", monkeypatch)
    assert run.returncode == 1 and run.stderr.startswith("OpenCV cannot be fetched: ") and run.stderr.count("\n") == 1
    assert "offers no file of a locked package" in run.stderr


def test_the_summary_says_why(capsys):
    note = "OpenCV cannot be fetched: the disk is full"
    run = {"name": "images", "ok": True, "passed": 3, "failed": 0, "skipped": 14, "s": 1.0, "note": note}
    assert run_tests.summary([run]) == 0
    assert f"ok  {note}" in capsys.readouterr().out
