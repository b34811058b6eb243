"""Pages in a real browser, and a JupyterLab to open them in. A page must not ask any other host for anything."""

import json
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path
from urllib.parse import urlsplit

import pytest

ROOT = Path(__file__).resolve().parents[2]
START_S = 60


def visit(chromium, **options):
    """Open a page that writes down what goes wrong in it, and which other hosts it asks."""
    context = chromium.new_context(**options)
    page = context.new_page()
    page.problems, page.strangers = [], []
    page.on("pageerror", lambda error: page.problems.append(str(error)))
    page.on("console", lambda line: page.problems.append(line.text) if line.type == "error" else None)
    page.on("request", lambda request: page.strangers.append(request.url) if foreign(request.url) else None)
    return page


def foreign(url):
    """Whether an address is neither in this page, nor a file, nor on this computer."""
    parts = urlsplit(url)
    return parts.scheme not in ("file", "data", "blob", "about") and parts.hostname not in ("localhost", "127.0.0.1")


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
        server.wait(timeout=30)


def address(server, runtime, log):
    """Wait for the server; return a function that makes the address of a notebook, token included."""
    end = time.monotonic() + START_S
    while time.monotonic() < end and server.poll() is None:
        for path in runtime.glob("jpserver-*.json"):
            info = json.loads(path.read_text() or "{}")
            if info:
                assert info["token"], "JupyterLab must ask for a token"
                assert info["hostname"] in ("localhost", "127.0.0.1"), "JupyterLab must listen on loopback only"
                # A workspace each: else JupyterLab opens the notebooks of the tests before as well.
                return lambda name: f"{info['url']}lab/workspaces/{name[:2]}/tree/{name}?token={info['token']}"
        time.sleep(0.2)
    pytest.fail("JupyterLab did not start:\n" + log.read_text()[-2000:])
