"""Run every test, among them every notebook with its exercises solved, then every notebook as a student gets it.

``make test`` runs this file: four runs of pytest. The tests and the notebooks, one run after the other, take two
processor cores where there are two. The tests in a browser, which often wait for a page, run beside the others; what
they print comes at their end. A file stays with one process, above all a notebook: its cells share one kernel. What
takes longest begins first, so that no core waits at the end (tests/conftest.py knows what that is). A failure does not
stop the later runs; the last lines say what passed where.
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
# Playwright keeps an event loop running in the process that uses it, where other tests want their own: what needs a
# browser runs by itself.
IN_BROWSER = ["tests/browser", "tests/site"]
IMAGES = "tests/images"  # by themselves, too: only they see OpenCV
TOGETHER = ["-n", str(min(2, os.cpu_count() or 1)), "--dist", "loadfile", "--no-loadscope-reorder"]


LONG = ("03", "04", "09", "10", "16", "18", "19")  # notebooks that take 6 s or more


def main(arguments):
    os.chdir(ROOT)
    os.environ["OPENBLAS_NUM_THREADS"] = "1"
    # Some hundred processes are started: none shall compile the whole package anew.
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    with tempfile.TemporaryDirectory() as cache, tempfile.TemporaryFile("w+") as text:
        # one for all runs: what is compiled and what is read from logs is made once, and the user's own stays as it is
        os.environ["EKFSLAM_TEST_CACHE"] = os.environ["EKFSLAM_CACHE"] = cache
        return summary(every_run(text, arguments))


def every_run(text, arguments):
    """Run all there is and return what was counted; `text` is a file for what the run beside the others prints."""
    with Run("tests in a browser", *IN_BROWSER, text=text) as in_browser:
        return [
            run("tests", *TOGETHER, "tests", *(f"--ignore={folder}" for folder in (*IN_BROWSER, IMAGES)), *arguments),
            run("notebooks", *TOGETHER, "--nbval", *NBVAL, "--nbval-sanitize-with", "tests/nbval.cfg", *notebooks()),
            images(),
            in_browser.end(),
        ]


def images():
    """Run the tests of images with the OpenCV of `requirements-images.txt`; without it most skip, a note says why."""
    fetched = subprocess.run([sys.executable, "tools/fetch_opencv.py"], capture_output=True, text=True)
    told = fetched.stderr.strip().splitlines()[-1:] if fetched.returncode else []
    where = ["-o", "pythonpath=build/images", IMAGES, "tests/docs/test_code_blocks.py", "-k", "images"]
    return run("images", *where) | {"note": " ".join(told)}


def notebooks():
    """Return the notebooks, those first that take longest."""
    paths = sorted(Path("notebooks").glob("*.ipynb"))
    return [str(path) for path in sorted(paths, key=lambda path: path.name[:2] not in LONG)]


def run(name, *arguments):
    """Run pytest once and return what it counted."""
    with Run(name, *arguments) as started:
        return started.end()


class Run:
    """A run of pytest: it begins at once, what it prints is kept in the file `text` if there is one, until its end."""

    def __init__(self, name, *arguments, text=None):
        self.name, self.text, self.began = name, text, time.monotonic()
        self.folder = tempfile.TemporaryDirectory()
        environment = dict(os.environ)
        if "--nbval" in arguments:
            environment.pop("MPLBACKEND", None)  # the kernel chooses its own: inline
            environment["EKFSLAM_CHECK_SECONDS"] = "200"
        else:
            arguments = ["-p", "no:nbval", *arguments]  # to import it takes longer than to import the package
        environment["EKFSLAM_PROGRESS"] = str(self.file("progress.json"))  # the user's own stays as it is
        environment["EKFSLAM_MY_SLAM"] = str(self.file("my_slam.py"))  # so does what is kept
        self.report = self.file("report.xml")
        if text is None:
            self.head()
        command = [sys.executable, "-m", "pytest", "-q", f"--junitxml={self.report}", *arguments]
        self.process = subprocess.Popen(command, env=environment, stdout=text, stderr=text)

    def __enter__(self):
        return self

    def __exit__(self, *error):
        """Let what still runs come to its own end, as after Ctrl-C, which it has got, too."""
        with self.folder:
            self.process.wait()

    def file(self, name):
        """Return the path of a file that lives as long as the run."""
        return Path(self.folder.name, name)

    def head(self):
        """Print the line that the run begins with."""
        print(f"\n== {self.name} ==", flush=True)

    def end(self):
        """Wait for the end and return what was counted."""
        code = wait(self.process)
        if self.text is not None:
            self.head()
            self.text.seek(0)
            print(self.text.read(), end="", flush=True)
        if code == 2:
            sys.exit("Stopped.")
        return {"name": self.name, "ok": code == 0, "s": time.monotonic() - self.began, **count(self.report)}


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
