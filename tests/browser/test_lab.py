"""Notebooks in a real JupyterLab and a real browser, as a student has them.

Run all; move a slider; give a wrong and a right answer; play the player; and no other host is asked for anything.
A player in space is also turned, by mouse and by keyboard. `make test` takes notebooks 02 and 05, which have all but
this, and 14, which has it; with EKFSLAM_BROWSER=all every notebook is run so (a few minutes more).
"""

import os
import re

import nbformat
import pytest

from ekfslam_tutorial.course import registry
from ekfslam_tutorial.course.build import exercise_cells

from .conftest import ROOT, RUN_S, START_S
from .pages import resize

ALL = sorted(path.name for path in (ROOT / "notebooks").glob("*.ipynb"))
NOTEBOOKS = ALL if os.environ.get("EKFSLAM_BROWSER") == "all" else [n for n in ALL if n[:2] in ("02", "05", "14")]

# A wrong answer to an exercise: what to change in the solution.
WRONG = {
    "02.2": ("wrap(np.arctan2(dy, dx) - x_r[2])", "wrap(np.arctan2(dy, dx))"),
    "05.2": ("wrap(np.arctan2(dy, dx) - x[2])", "wrap(np.arctan2(dy, dx))"),
}

NOT_PYTHON = "14.1"  # the exercise whose cell ends in a SyntaxError: its check still runs, with the reference

pytestmark = [pytest.mark.browser, pytest.mark.timeout(START_S + RUN_S)]

# The kernel must be there before "Run All"; the promise of the command is fulfilled when the last cell has run.
RUN_ALL = """async () => {
    const app = window.jupyterapp, session = app.shell.currentWidget.sessionContext
    await session.ready
    await session.session.kernel.info
    await app.commands.execute('notebook:run-all-cells')
    await app.commands.execute('docmanager:save')
}"""

# JupyterLab draws only the cells near the window: go to one, and it is there.
GO_TO_CELL = """async i => {
    const notebook = window.jupyterapp.shell.currentWidget.content
    notebook.activeCellIndex = i
    await notebook.scrollToItem(i, 'start')
    await notebook.widgets[i].ready
}"""

TEXT_OF_CELL = "i => window.jupyterapp.shell.currentWidget.content.widgets[i].outputArea.node.innerText"


@pytest.mark.skipif(not NOTEBOOKS, reason="there is no notebook")
@pytest.mark.parametrize("name", NOTEBOOKS)
def test_a_notebook_in_the_browser(lab, page, name):
    folder, url = lab
    resize(page, 1400, 1000)
    page.goto(url(name))
    page.wait_for_selector(".jp-Notebook .jp-Cell")
    page.evaluate(RUN_ALL)

    nb = nbformat.read(folder / name, as_version=4)
    assert_it_ran(nb)
    move_a_slider(page, nb)
    give_answers(page, nb)
    play(page, nb)
    assert page.locator("text=Error displaying widget").count() == 0
    assert page.problems == []


def assert_it_ran(nb):
    """Every cell has run once, in order, without an error."""
    code = [cell for cell in nb.cells if cell.cell_type == "code" and cell.source.strip()]
    errors = [output.evalue for cell in code for output in cell.outputs if output.output_type == "error"]
    assert errors == []
    assert [cell.execution_count for cell in code] == list(range(1, len(code) + 1))


def cells_with(nb, kind):
    """Numbers of the cells that have an output of a MIME type."""
    return [i for i, cell in enumerate(nb.cells) if any(kind in o.get("data", {}) for o in cell.get("outputs", []))]


def move_a_slider(page, nb):
    """Press an arrow key on a slider, and wait for another picture above it: the only one; its labels are whole."""
    for i in cells_with(nb, "application/vnd.jupyter.widget-view+json"):
        page.evaluate(GO_TO_CELL, i)
        panel = page.locator(".jp-mod-active .ekfslam-live:has(.widget-slider)").first
        if panel.count():
            break
    else:
        return
    figure, handle = panel.locator("img").first, panel.locator(".widget-slider .noUi-handle").first
    wait = lambda condition: page.wait_for_function(condition, arg=figure.element_handle())
    wait(ALL_DOTS)
    assert page.locator(".jp-mod-active .jp-OutputArea img:visible").count() == 1  # the poster has made room
    assert figure.get_attribute("title") and panel.evaluate(CUT) == []
    assert figure.bounding_box()["y"] < handle.bounding_box()["y"]
    before = figure.get_attribute("src")
    handle.focus()
    at_its_end = handle.get_attribute("aria-valuenow") == handle.get_attribute("aria-valuemax")
    handle.press("ArrowLeft" if at_its_end else "ArrowRight")
    run = panel.get_by_role("button", name="Run", exact=True)
    if run.count():
        run.click()
    wait(f"figure => figure.src !== '{before}'")
    wait(ALL_DOTS)


# A picture that rests has two dots for each CSS pixel, or it is made of lines.
ALL_DOTS = """async figure => {
    const kind = (await fetch(figure.src).then(answer => answer.blob(), () => null))?.type
    return kind === 'image/svg+xml' || figure.naturalWidth > 1.9 * parseFloat(figure.style.width)
}"""

# The labels that do not fit.
CUT = """panel => [...panel.querySelectorAll('.widget-label, .widget-readout')]
    .filter(label => label.scrollWidth > label.clientWidth + 1).map(label => label.innerText)"""


def give_answers(page, nb):
    """Type a wrong answer and read its hint; type the right one and read that it has passed."""
    for cell, id, _ in exercise_cells(nb):
        i = nb.cells.index(cell)
        if id in WRONG:
            exercise = registry.get(id)
            right, wrong = exercise.source(), exercise.source().replace(*WRONG[id])
            assert wrong != right
            verdict = answer(page, i, wrong)
            hints = [m.hint for m in exercise.misconceptions if " ".join(m.hint.split()) in verdict]
            assert f"[{id}]" in verdict and "passed" not in verdict and hints, verdict
            assert f"[{id}] not judged" in check_again(page, i + 1)
            verdict = answer(page, i, right)
            assert f"[{id}] passed" in verdict, verdict
            assert f"[{id}] passed" in check_again(page, i + 1)  # it is the student's own
        elif id == NOT_PYTHON:
            write(page, i, "def this is not Python")
            page.wait_for_function(f"i => ({TEXT_OF_CELL})(i).includes('SyntaxError')", arg=i)
            assert f"[{id}] not judged" in check_again(page, i + 1)


def check_again(page, i):
    """Run the check cell alone, once more, and return what it says."""
    page.evaluate(GO_TO_CELL, i)
    before = page.evaluate(COUNT_OF_CELL, i)
    page.keyboard.press("Shift+Enter")
    page.wait_for_function(
        f"([i, before]) => ({COUNT_OF_CELL})(i) > before && ({TEXT_OF_CELL})(i).includes(']')", arg=[i, before]
    )
    return " ".join(page.evaluate(TEXT_OF_CELL, i).split())


def answer(page, i, text):
    """Type the text into cell i, run it and the check cell below it, and return what the check says."""
    before = page.evaluate(COUNT_OF_CELL, i + 1)
    write(page, i, text)
    page.keyboard.press("Shift+Enter")
    done = f"([i, before]) => ({COUNT_OF_CELL})(i) > before && ({TEXT_OF_CELL})(i).includes(']')"
    page.wait_for_function(done, arg=[i + 1, before])
    return " ".join(page.evaluate(TEXT_OF_CELL, i + 1).split())


def write(page, i, text):
    """Type the text into cell i and run it."""
    page.evaluate(GO_TO_CELL, i)
    page.locator(".jp-mod-active .cm-content").click()
    page.keyboard.press("Control+a")
    page.keyboard.insert_text(text)
    page.keyboard.press("Shift+Enter")


COUNT_OF_CELL = "i => window.jupyterapp.shell.currentWidget.content.widgets[i].model.executionCount ?? -1"


def play(page, nb):
    """Press Play in the player, by keyboard, and see the frames go by and the picture change."""
    for i in cells_with(nb, "text/html"):
        if "<iframe title=" not in str(nb.cells[i].outputs):
            continue
        page.evaluate(GO_TO_CELL, i)
        frame = page.locator(".jp-mod-active iframe[srcdoc]")
        frame.scroll_into_view_if_needed()  # below a tall film strip it is out of sight, and a browser does not draw it
        inside = frame.content_frame
        button, status = inside.get_by_role("button", name="Play"), inside.get_by_role("status")
        button.scroll_into_view_if_needed()
        first = status.inner_text()
        picture = "canvas => canvas.toDataURL()"
        before = inside.get_by_role("application").evaluate(picture)
        button.press("Space")
        status.get_by_text(", t = ").wait_for()
        inside.get_by_role("button", name="Pause").press("ArrowRight")  # steps, and so stops
        inside.get_by_role("slider", name="Frame").press("End")
        inside.get_by_role("application").press("ArrowDown")
        inside.get_by_text(re.compile("half-axes|known")).first.wait_for()  # in 02 the robot is known
        assert status.inner_text() != first
        assert inside.get_by_role("application").evaluate(picture) != before
        if inside.get_by_role("application").evaluate("() => player.log.d === 3"):
            turn(page, inside.get_by_role("application"))


# Azimuth and elevation (rad) of the view, and its picture as a text, after the next drawing.
VIEW = """() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => {
    const { azimuth, elevation } = player.scene.camera
    done([azimuth, elevation, player.canvas.toDataURL()])
})))"""


def turn(page, canvas):
    """Orbit the picture with the mouse, then with the keyboard; each time the camera goes round and draws anew."""
    canvas.scroll_into_view_if_needed()
    views = [canvas.evaluate(VIEW)]
    box = canvas.bounding_box()
    x, y = box["x"] + 20, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 120, y + 40, steps=4)
    page.mouse.up()
    views.append(canvas.evaluate(VIEW))
    canvas.press("Shift+ArrowLeft")
    canvas.press("Shift+ArrowDown")
    views.append(canvas.evaluate(VIEW))
    for now, before in zip(views[1:], views, strict=False):
        assert all(abs(a - b) > 0.05 for a, b in zip(now[:2], before[:2], strict=True)), (now[:2], before[:2])
    assert len({picture for _, _, picture in views}) == 3
