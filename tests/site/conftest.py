"""The course site, built once and served on loopback."""

import contextlib
import functools
import http.server
import shutil
import subprocess
import sys
import threading
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PATIENCE_MS = 200_000  # for what must come in a page; beside eight other programs it may take long


@pytest.fixture(scope="session")
def site(tmp_path_factory):
    """Build the site by `make site`, without the set-up of .venv before it. Returns its folder."""
    if shutil.which("make") is None:
        pytest.skip("no make here, so there is no make site")
    folder = tmp_path_factory.mktemp("site")
    settings = [f"VENV={Path(sys.executable).as_posix()}", f"SITE={(folder / 'html').as_posix()}"]
    run = subprocess.run(["make", "-o", "env", "site", *settings], cwd=ROOT, capture_output=True, text=True)
    assert run.returncode == 0, run.stderr[-4000:]
    return folder / "html"


@pytest.fixture(scope="session")
def address(site):
    """The address of the site."""
    handler = functools.partial(Quiet, directory=site)
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}/"
        server.shutdown()


class Quiet(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *_):
        pass


@pytest.fixture
def visit(chromium, address):
    """Return a function that opens a page of the site: see `visits`."""
    with visits(chromium, address) as visit:
        yield visit


@pytest.fixture(scope="module")
def opened(request, chromium, address):
    """A page of the site, named by the parameter, at 1280 x 720. Tests that ask for it one after the other share it."""
    with visits(chromium, address) as visit:
        yield visit(request.param)


@contextlib.contextmanager
def visits(chromium, address):
    """Give a function that opens a page of the site and waits for its mathematics and pictures.

    At the end no page may have had an error, or have asked another host for anything.
    """
    wrong, contexts = [], []

    def visit(name, width=1280, height=720, wait=True):
        context = chromium.new_context(viewport={"width": width, "height": height})
        context.set_default_timeout(PATIENCE_MS)
        contexts.append(context)
        page = context.new_page()
        page.on("pageerror", lambda error: wrong.append(f"{name}: {error}"))
        page.on("console", lambda line: wrong.append(f"{name}: {line.text}") if line.type == "error" else None)
        page.on("request", lambda r: wrong.append(f"{name} asks {r.url}") if foreign(r.url, address) else None)
        page.goto(address + name, wait_until="load")
        if wait:
            page.evaluate("window.MathJax ? MathJax.startup.promise.then(() => 1) : 0")
        return page

    yield visit
    for context in contexts:
        context.close()
    assert wrong == []


def foreign(url, address):
    return not url.startswith((address, "data:", "blob:", "about:"))
