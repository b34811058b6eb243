"""Run every test, among them every notebook with its exercises solved, then every notebook as a student gets it.

``make test`` runs this file: three runs of pytest, one after the other, on two processor cores where there are two. A
file stays with one process, above all a notebook: its cells share one kernel. What takes longest begins first, so that
no core waits at the end (tests/conftest.py knows what that is). A failure does not stop the later runs; the last lines
say what passed where. ``make test-browser`` gives the word ``--browser``: then the pages are tested, in a real browser,
and nothing else.
Arguments are passed to pytest for the first run: ``make test TEST_ARGS="-k jacobian -x"``.
Where EKFSLAM_TEST_LIMIT_S is set, a run that takes more seconds has failed and is stopped, as CI needs it.
"""

import contextlib
import os
import subprocess
import sys
import tempfile
import time
import xml.etree.ElementTree as ET
from pathlib import Path

import psutil

ROOT = Path(__file__).resolve().parent.parent
# For a cell that hangs: the longest takes 10 s on a quiet computer, and a busy one must not reach the limit.
NBVAL = ["--nbval-current-env", "--nbval-cell-timeout=600"]
# Playwright keeps an event loop running in the process that uses it, where other tests want their own, and pages wait
# much: what needs a browser runs by itself.
IN_BROWSER = ["tests/browser", "tests/site"]
IMAGES = "tests/images"  # by themselves, too: only they see OpenCV
TOGETHER = ["-n", str(min(2, os.cpu_count() or 1)), "--dist", "loadfile", "--no-loadscope-reorder"]


LONG = ("18", "19", "21", "23", "09", "20", "24", "04", "16")  # notebooks that take longest, in this order


def main(arguments):
    os.chdir(ROOT)
    os.environ["OPENBLAS_NUM_THREADS"] = "1"
    # Some hundred processes are started: none shall compile the whole package anew.
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    with tempfile.TemporaryDirectory() as cache, tempfile.TemporaryDirectory() as in_their_place:
        # one for all runs: what is compiled and what is read from logs is made once, and the user's own stays as it is
        os.environ["EKFSLAM_TEST_CACHE"] = os.environ["EKFSLAM_CACHE"] = cache
        leave_out("rfc3987_syntax", in_their_place)
        if arguments[:1] == ["--browser"]:
            return summary([run("tests in a browser", *IN_BROWSER, *arguments[1:])])
        return summary([tests(arguments), notebooks(), images()])


def leave_out(package, folder):
    """Let every process do without a package that others import where it is there.

    This one compiles a grammar of web addresses, in seconds, for each process that reads a notebook: jsonschema imports
    it, and nobody asks it for addresses.
    """
    Path(folder, f"{package}.py").write_text("raise ImportError\n", encoding="utf-8")
    os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, (folder, os.environ.get("PYTHONPATH"))))


def tests(arguments):
    """Run all tests but those of notebooks, images and pages."""
    apart = (f"--ignore={folder}" for folder in (*IN_BROWSER, IMAGES))
    return run("tests", *TOGETHER, "tests", *apart, *arguments)


def notebooks():
    """Run the notebooks, those first that take longest."""
    place = {number: place for place, number in enumerate(LONG)}
    paths = sorted(Path("notebooks").glob("*.ipynb"), key=lambda path: (place.get(path.name[:2], len(LONG)), path.name))
    how = ["--nbval", *NBVAL, "--nbval-sanitize-with", "tests/nbval.cfg", "-p", "tests.nbval_pictures"]
    return run("notebooks", *TOGETHER, *how, *map(str, paths))


def images():
    """Run the tests of images with the OpenCV of `requirements-images.txt`; without it most skip, a note says why."""
    fetched = subprocess.run([sys.executable, "tools/fetch_opencv.py"], capture_output=True, text=True)
    told = fetched.stderr.strip().splitlines()[-1:] if fetched.returncode else []
    where = ["-o", "pythonpath=build/images", IMAGES, "tests/docs/test_code_blocks.py", "-k", "images"]
    return run("images", *where) | {"note": " ".join(told)}


def run(name, *arguments):
    """Run pytest once and return what it counted."""
    print(f"\n== {name} ==", flush=True)
    began = time.monotonic()
    environment = dict(os.environ)
    if "--nbval" in arguments:
        environment.pop("MPLBACKEND", None)  # the kernel chooses its own: inline
        environment["EKFSLAM_CHECK_SECONDS"] = "200"
        environment["EKFSLAM_DPI"] = "48"  # nbval skips pictures: few dots, and no search for the fewest bytes
    else:
        arguments = ("-p", "no:nbval", *arguments)  # to import it takes longer than to import the package
    with tempfile.TemporaryDirectory() as folder:
        report = Path(folder, "report.xml")
        environment["EKFSLAM_PROGRESS"] = str(Path(folder, "progress.json"))  # the user's own stays as it is
        environment["EKFSLAM_MY_SLAM"] = str(Path(folder, "my_slam.py"))  # so does what is kept
        command = [sys.executable, "-m", "pytest", "-q", f"--junitxml={report}", *arguments]
        with subprocess.Popen(command, env=environment) as process:  # after Ctrl-C it comes to its own end
            code = wait(process)
        if code == 2:
            sys.exit("Stopped.")
        return {"name": name, "ok": code == 0, "s": time.monotonic() - began, **count(report)}


def wait(process):
    """Wait for a run and return its exit code, or stop it, with all that it started, when its time is over."""
    limit = os.environ.get("EKFSLAM_TEST_LIMIT_S")
    try:
        return process.wait(limit and float(limit))
    except subprocess.TimeoutExpired:
        print(f"\nNot ended after {limit} s (EKFSLAM_TEST_LIMIT_S): stopped.", flush=True)
        started = psutil.Process(process.pid).children(recursive=True)
        process.kill()  # first, or it would start new workers for those that die
        for child in started:
            with contextlib.suppress(psutil.NoSuchProcess):
                child.kill()
        psutil.wait_procs(started, timeout=10)
        return process.wait()


def count(report):
    """Return how many tests passed, failed and were skipped, from pytest's JUnit report."""
    if not report.exists():
        return {"passed": 0, "failed": 1, "skipped": 0}
    suites = list(ET.parse(report).getroot().iter("testsuite"))
    total, bad, skipped = (
        sum(int(suite.get(key, 0)) for suite in suites for key in keys)
        for keys in (("tests",), ("failures", "errors"), ("skipped",))
    )
    return {"passed": total - bad - skipped, "failed": bad, "skipped": skipped}


def summary(runs):
    """Print one line per run and one for all; return the exit code."""
    print("\n== summary ==")
    for r in runs:
        word = "ok" if r["ok"] else "FAILED"
        counts = f"{r['passed']:5} passed {r['failed']:4} failed {r['skipped']:4} skipped"
        print(f"{r['name']:18} {counts} {r['s']:7.0f} s  {word}  {r.get('note', '')}".rstrip())
    # A run that pytest calls bad without naming a bad test (nothing collected, for example) is one failure.
    failed = sum(r["failed"] or (not r["ok"]) for r in runs)
    passed, skipped = (sum(r[key] for r in runs) for key in ("passed", "skipped"))
    print(f"{passed} passed, {failed} failed, {skipped} skipped")
    return 1 if failed else 0


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1:]))
    except KeyboardInterrupt:
        sys.exit("\nStopped.")
