"""Pages in a real browser, and a JupyterLab to open them in. A page must not ask any other host for anything."""

import contextlib
import functools
import http.server
import json
import os
import shutil
import subprocess
import sys
import threading
import time
from pathlib import Path
from types import SimpleNamespace
from urllib.parse import urlsplit

import pytest

from ekfslam_tutorial.graphics.player import StateLog, write_player_html
from ekfslam_tutorial.toolbox import UserData, universal_slam
from tools import build_lite

ROOT = Path(__file__).resolve().parents[2]
START_S, RUN_S = 200, 600  # for JupyterLab to start, and for a notebook in it: for what hangs, not for what is slow
LONGEST_S = 1800  # of a notebook whose Python runs in the browser, beside eight other programs
PATIENCE_MS = 200_000  # for what must come in a page; beside eight other programs it may take long


def visit(chromium, **options):
    """Open a page that writes down what goes wrong in it, and which other hosts it asks."""
    context = chromium.new_context(**options)
    context.set_default_timeout(PATIENCE_MS)
    page = context.new_page()
    page.problems, page.strangers = [], []
    page.on("pageerror", lambda error: page.problems.append(str(error)))
    page.on("console", lambda line: page.problems.append(line.text) if is_error(line) else None)
    page.on("request", lambda request: page.strangers.append(request.url) if foreign(request.url) else None)
    return page


def is_error(line):
    """Whether a line of the console tells of an error. JupyterLab asks for a picture that is attached to a text cell
    by its name in the notebook, which no browser can load, a moment before it puts the picture there."""
    return line.type == "error" and not line.location["url"].startswith("attachment:")


def foreign(url):
    """Whether an address is neither in this page, nor a file, nor on this computer."""
    parts = urlsplit(url)
    here = ("file", "data", "blob", "about", "attachment")
    return parts.scheme not in here and parts.hostname not in ("localhost", "127.0.0.1")


@pytest.fixture
def page(chromium):
    """A page of 1280 x 720. At its end it must not have asked another host for anything."""
    page = visit(chromium, viewport={"width": 1280, "height": 720})
    yield page
    page.context.close()
    assert page.strangers == []


@pytest.fixture(scope="session")
def lab(tmp_path_factory, chromium):
    """JupyterLab on a copy of the notebooks, with no settings of this user. Returns its folder and address.

    It needs the fixture `chromium` so that no server is started where there is no browser.
    """
    home = tmp_path_factory.mktemp("lab")
    folder, runtime = home / "notebooks", home / "runtime"
    shutil.copytree(ROOT / "notebooks", folder, ignore=shutil.ignore_patterns(".*"))
    environment = {name: value for name, value in os.environ.items() if name != "MPLBACKEND"}
    environment |= {
        "HOME": str(home),
        "JUPYTER_CONFIG_DIR": str(home / "config"),
        "JUPYTER_RUNTIME_DIR": str(runtime),
        "IPYTHONDIR": str(home / "ipython"),
        "EKFSLAM_PROGRESS": str(home / "progress.json"),
        "EKFSLAM_MY_SLAM": str(home / "my_slam.py"),
    }
    command = [sys.executable, "-m", "jupyterlab", "--no-browser", "--port=0", f"--notebook-dir={folder}"]
    command += ["--allow-root", "--LabApp.expose_app_in_browser=True"]
    command += ["--LabApp.check_for_updates_class=jupyterlab.NeverCheckForUpdate"]
    with (home / "log.txt").open("w") as log:
        server = subprocess.Popen(command, env=environment, stdout=log, stderr=subprocess.STDOUT)
    try:
        yield folder, address(server, runtime, home / "log.txt")
    finally:
        server.terminate()
        server.wait()


def address(server, runtime, log):
    """Wait for the server; return a function that makes the address of a notebook, token included."""
    while server.poll() is None:
        for path in runtime.glob("jpserver-*.json"):
            info = json.loads(path.read_text() or "{}")
            if info:
                assert info["token"], "JupyterLab must ask for a token"
                assert info["hostname"] in ("localhost", "127.0.0.1"), "JupyterLab must listen on loopback only"
                # A workspace each: else JupyterLab opens the notebooks of the tests before as well.
                return lambda name: f"{info['url']}lab/workspaces/{name[:2]}/tree/{name}?token={info['token']}"
        time.sleep(0.2)
    pytest.fail("JupyterLab did not start:\n" + log.read_text()[-2000:])


@pytest.fixture(scope="session")
def flat():
    """Range and bearing in the plane; a gate so narrow that it rejects, and landmarks that are missed."""
    return record("range_bearing_2d", 40, {"options.md2_threshold": 4.0, "sensor.1.p_detect": 0.8})


@pytest.fixture(scope="session")
def space():
    """One camera in the cloister."""
    return record("cloister_idp", 25)


@pytest.fixture(scope="session")
def two_robots():
    """Two robots with four cameras."""
    return record("two_robots_four_cameras", 12)


def record(name, n_frames, changes=None):
    data = UserData.from_toml(ROOT / "data" / "scenarios" / f"{name}.toml", {"time.last": n_frames, **(changes or {})})
    log = StateLog(f"test of {name}")
    for s in universal_slam(data):
        log.add(s)
    return log


@pytest.fixture
def open_log(page, tmp_path):
    """Return a function that opens a log in the page, and waits until it is drawn."""

    def open_log(log, to=page):
        to.goto(write_player_html(tmp_path / "player.html", log).as_uri())
        to.wait_for_function("window.player?.drawn > 0")
        return to

    yield open_log
    assert page.problems == []


# ---- the course as a static site ----


@contextlib.contextmanager
def alone(path):
    """Wait until no other process is in here with the same file."""
    path.parent.mkdir(exist_ok=True)
    with path.open("w") as file:
        with contextlib.suppress(ImportError):  # on Windows the tests run in one process
            import fcntl

            fcntl.flock(file, fcntl.LOCK_EX)
        yield


@pytest.fixture(scope="session")
def lite_site():
    """The folder of the site, built anew if it is older than its sources."""
    with alone(build_lite.BUILD / "lite-lock.txt"):
        command = [sys.executable, ROOT / "tools" / "build_lite.py"]
        run = subprocess.run(command, capture_output=True, text=True)
    if run.returncode and any(words in run.stderr for words in ("pip failed", "not to be had")):
        pytest.skip(f"the parts of the site cannot be fetched: {run.stderr.strip()[-300:]}")
    assert run.returncode == 0, run.stderr[-2000:]
    return build_lite.SITE


class CountingServer(http.server.SimpleHTTPRequestHandler):
    """A plain server of files. It notes what it sends: bytes by path."""

    def __init__(self, *args, sent, **options):
        self.sent = sent
        super().__init__(*args, **options)

    def log_message(self, *_):
        pass

    def send_header(self, keyword, value):
        if keyword == "Content-Length":
            self.sent[self.path] = int(value)
        super().send_header(keyword, value)


@pytest.fixture(scope="session")
def lite(lite_site, tmp_path_factory):
    """The site two folders below the root of its host: its `address`, and what was `sent`."""
    root, sent = tmp_path_factory.mktemp("www"), {}
    (root / "some").mkdir()
    (root / "some" / "course").symlink_to(lite_site.resolve(), target_is_directory=True)
    handler = functools.partial(CountingServer, directory=root, sent=sent)
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield SimpleNamespace(address=f"http://127.0.0.1:{server.server_port}/some/course/", sent=sent)
        server.shutdown()
