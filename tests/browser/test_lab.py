"""Every notebook in a real JupyterLab and a real browser, as a student has it: run all, then move a slider."""

import json
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import nbformat
import pytest

NOTEBOOKS = sorted((Path(__file__).resolve().parents[2] / "notebooks").glob("*.ipynb"))
assert NOTEBOOKS, "no notebook found: this file looks for them in the wrong folder"
START_S, RUN_S = 60, 240

pytestmark = [pytest.mark.browser, pytest.mark.timeout(START_S + RUN_S)]


@pytest.fixture(scope="module")
def lab(tmp_path_factory, chromium):
    """JupyterLab on a copy of the notebooks, with no settings of this user. Returns its folder and address.

    It needs the fixture `chromium` so that no server is started where there is no browser.
    """
    home = tmp_path_factory.mktemp("lab")
    folder, runtime = home / "notebooks", home / "runtime"
    shutil.copytree(NOTEBOOKS[0].parent, folder, ignore=shutil.ignore_patterns(".*"))
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


@pytest.fixture
def page(chromium):
    context = chromium.new_context(viewport={"width": 1400, "height": 1000})
    yield context.new_page()
    context.close()


RUN_ALL = """async () => {
    const app = window.jupyterapp, session = app.shell.currentWidget.sessionContext
    await session.ready
    await session.session.kernel.info
    await app.commands.execute('notebook:run-all-cells')
    await app.commands.execute('docmanager:save')
}"""


@pytest.mark.parametrize("name", [path.name for path in NOTEBOOKS])
def test_a_notebook_runs_in_the_browser(lab, page, name):
    folder, url = lab
    problems = []
    page.on("pageerror", lambda error: problems.append(str(error)))
    page.goto(url(name))
    page.wait_for_selector(".jp-Notebook .jp-Cell", timeout=1000 * START_S)
    page.evaluate(RUN_ALL)

    nb = nbformat.read(folder / name, as_version=4)
    code = [cell for cell in nb.cells if cell.cell_type == "code" and cell.source.strip()]
    errors = [output.evalue for cell in code for output in cell.outputs if output.output_type == "error"]
    assert errors == [] and problems == []
    assert [cell.execution_count for cell in code] == list(range(1, len(code) + 1))

    if "application/vnd.jupyter.widget-view+json" in str(nb.cells):
        move_first_slider(page)


def move_first_slider(page):
    """Scroll to the first slider, press an arrow key on it, and wait for another figure below it."""
    page.evaluate(FIND_SLIDER)
    panel = page.locator(".jp-OutputArea-child:has(.widget-slider)").first
    figure, handle = panel.locator("img").first, panel.locator(".widget-slider .noUi-handle").first
    before = figure.get_attribute("src")
    handle.focus()
    handle.press("ArrowRight")
    run = panel.get_by_role("button", name="Run", exact=True)
    if run.count():
        run.click()
    changed = "([panel, src]) => panel.querySelector('img')?.src !== src"
    page.wait_for_function(changed, arg=[panel.element_handle(), before], timeout=20_000)
    assert page.locator("text=Error displaying widget").count() == 0


# JupyterLab draws only the cells in view: go down until a slider is there.
FIND_SLIDER = """async () => {
    const panel = document.querySelector('.jp-WindowedPanel-outer')
    for (let y = 0; y <= panel.scrollHeight; y += 300) {
        panel.scrollTop = y
        await new Promise(done => setTimeout(done, 100))
        if (document.querySelector('.widget-slider .noUi-handle')) return
    }
}"""
