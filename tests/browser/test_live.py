"""The player in notebooks: the live view fed by a kernel, and a stored notebook turned into a static page."""

import subprocess
import sys
from urllib.parse import urlsplit

import nbformat
import pytest

from .conftest import ROOT, RUN_S, START_S, foreign
from .pages import resize
from .test_lab import RUN_ALL

pytestmark = [pytest.mark.browser, pytest.mark.timeout(START_S + RUN_S)]
FRAMES_PER_SECOND = 20  # at least, with 70 landmarks; of processor time, as other programs do not count

# All 70 landmarks are seen, mapped and measured in every frame.
SCENARIO = dict(
    seed=3,
    time=dict(dt=0.1, last=60),
    world=dict(type="random2", n=70),
    robot=[dict(motion="odometry2", position=[0, -4], dx=[0.1, 0], da_deg=1.4, dx_std=0.01, da_std_deg=0.2)],
    sensor=[dict(robot=1, type="range_bearing", range_std=0.1, bearing_std_deg=1, max_range=100)],
    options=dict(n_updates=10),
)

CELLS = [
    "from ekfslam_tutorial.graphics.player import LivePlayer\n"
    "from ekfslam_tutorial.toolbox import UserData, universal_slam\n"
    f"data = UserData.from_dict({SCENARIO!r})\n"
    "live = LivePlayer('live')\nlive",
    "for snapshot in universal_slam(data):\n    live.add(snapshot)\nprint(len(live.state_log), len(snapshot.lmks))",
    # the last snapshot again and again: what a frame costs the kernel, whatever the filter needs
    "import time\nstart = time.process_time()\nfor _ in range(100):\n    live.add(snapshot)\n"
    "print(f'{100 / (time.process_time() - start):.0f}')",
]


def notebook(cells):
    nb = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(text) for text in cells])
    nb.metadata.kernelspec = {"display_name": "Python 3 (ipykernel)", "language": "python", "name": "python3"}
    return nb


def test_the_live_view_shows_the_run_as_it_goes(lab, page, capsys):
    pytest.importorskip("anywidget", reason="the package anywidget is not installed")
    folder, url = lab
    resize(page, 1400, 1000)
    nbformat.write(notebook(CELLS), folder / "live.ipynb")
    page.goto(url("live.ipynb"))
    page.wait_for_selector(".jp-Notebook .jp-Cell")
    page.evaluate(f"() => {{ window.done = ({RUN_ALL})() }}")
    page.evaluate(SEE_STATES)
    page.evaluate("() => window.done")

    host = page.locator("[data-lm-suppress-shortcuts]")
    status = host.get_by_role("status")
    status.get_by_text("70 landmarks").wait_for()
    page.wait_for_function(f"() => ({VIEW})().querySelector('input').max === '159'")  # the whole log has come
    assert page.evaluate("window.states.length") > 20  # it was seen while it was running

    # It can be played again, by keyboard; JupyterLab's own keys do not act.
    slider = host.get_by_role("slider", name="Frame")
    slider.press("Home")
    status.get_by_text("frame 1,").wait_for()
    host.get_by_role("application").press("ArrowRight")
    status.get_by_text("frame 2,").wait_for()
    active = page.evaluate("window.jupyterapp.shell.currentWidget.content.activeCellIndex")
    host.get_by_role("application").press("ArrowDown")
    host.get_by_text("heading").wait_for()
    assert page.evaluate("window.jupyterapp.shell.currentWidget.content.activeCellIndex") == active
    host.get_by_role("button", name="Play").press("Space")
    page.wait_for_function("count => window.states.length > count", arg=page.evaluate("window.states.length") + 5)

    nb = nbformat.read(folder / "live.ipynb", as_version=4)
    assert nb.cells[1].outputs[0].text.split() == ["60", "70"]
    shown, sent = best_second(page.evaluate("window.states")), int(nb.cells[2].outputs[0].text)
    with capsys.disabled():
        print(f" live, 70 landmarks: {shown} frames in the best second; {sent} a second of processor sent", end=" ")
    assert sent >= FRAMES_PER_SECOND  # how quickly the page draws them: test_player_screens
    assert page.problems == []


VIEW = "() => document.querySelector('[data-lm-suppress-shortcuts]')?.shadowRoot"

# Look at the view before each repaint of the page, and write down when it shows another frame.
SEE_STATES = f"""() => {{
    window.states = []
    let last = null
    const look = now => {{
        const at = ({VIEW})()?.querySelector('input').value
        if (at && at !== last) window.states.push(now)
        last = at
        requestAnimationFrame(look)
    }}
    requestAnimationFrame(look)
}}"""


def best_second(times):
    """The most events in a second, of times in milliseconds."""
    return max(sum(start <= t < start + 1000 for t in times) for start in times)


def test_a_stored_notebook_as_a_static_page(page, tmp_path):
    """`jupyter nbconvert --to html` of a notebook as it is stored: no kernel, no server, no network, and it plays."""
    command = [sys.executable, "-m", "nbconvert", "--to", "html", "--log-level=ERROR", f"--output-dir={tmp_path}"]
    subprocess.run([*command, str(ROOT / "notebooks" / "05_range_bearing_ekf_slam.ipynb")], check=True)

    from_player = []
    page.on("request", lambda r: from_player.append(r.url) if r.frame.parent_frame and foreign(r.url) else None)
    page.context.set_offline(True)
    page.goto((tmp_path / "05_range_bearing_ekf_slam.html").as_uri(), wait_until="domcontentloaded")
    inside = page.frame_locator("iframe[srcdoc]")
    inside.get_by_role("slider", name="Frame").press("End")
    inside.get_by_role("status").get_by_text("frame 100,").wait_for()
    inside.get_by_role("button", name="Play").press("Space")
    page.frames[-1].wait_for_function("player.playing && player.at >= 2")
    assert from_player == []
    # nbconvert's own page asks for MathJax, and for nothing that the player needs.
    assert {urlsplit(url).hostname for url in page.strangers} <= {"cdnjs.cloudflare.com"}
    page.strangers.clear()
