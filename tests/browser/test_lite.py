"""The course as a static site: notebooks in Chromium, with Python in the browser, served from below a host's root.

Run all; move a slider; give a wrong and a right answer; play the player; take the work home and up again; no other host
is asked, no error is in the console. `make test-browser` takes three notebooks (EKFSLAM_BROWSER=lite), all of them with
EKFSLAM_BROWSER=all; `make test` leaves it out.
"""

import json
import os
import zipfile

import nbformat
import pytest
from axe_playwright_python.sync_playwright import Axe

from .conftest import LONGEST_S, visit
from .test_lab import ALL, RUN_ALL, assert_it_ran, give_answers, move_a_slider, play, write

ASKED = os.environ.get("EKFSLAM_BROWSER")
NOTEBOOKS = ALL if ASKED == "all" else [name for name in ALL if name[:2] in ("02", "05", "13")]
SITE_MB, FIRST_PAGE_MB = 150, 5

pytestmark = [pytest.mark.browser, pytest.mark.timeout(LONGEST_S)]
if ASKED not in ("lite", "all"):  # the site is fetched and built for it, which takes minutes
    pytestmark.append(pytest.mark.skip(reason="asked for by make test-browser, or by EKFSLAM_BROWSER=all"))

NOTEBOOK = "() => window.jupyterapp.shell.currentWidget.content.model.toJSON()"


def patient(chromium):
    """A page that may take long: its Python is busy beside other programs."""
    page = visit(chromium, viewport={"width": 1400, "height": 1000})
    page.context.set_default_timeout(1000 * LONGEST_S)
    return page


@pytest.fixture
def page(chromium):
    """A page of a browser that has nothing of the course in its storage; at its end there must be no complaint."""
    page = patient(chromium)
    yield page
    page.context.close()
    assert page.strangers == []
    assert page.problems == []


def opened(page, lite, name):
    """Open a notebook, and wait until its cells are there: all, for at first it has one, which is empty."""
    page.goto(f"{lite.address}lab/index.html?path={name}")
    return ready(page)


def ready(page):
    """Wait until a notebook stands in the page."""
    page.wait_for_selector(".jp-Notebook .jp-Cell")
    page.evaluate("async () => { await window.jupyterapp.shell.currentWidget.context.ready }")
    return page


def notebook(page):
    """The notebook as it is in the page."""
    return nbformat.from_dict(page.evaluate(NOTEBOOK))


def run_all(page):
    """Run all cells; stop at once where the page complains, as a kernel that did not start would never answer."""
    page.evaluate(f"() => {{ window.ran = ({RUN_ALL})().then(() => 'yes', String) }}")
    while True:
        ran = page.evaluate("() => Promise.race([window.ran, new Promise(soon => setTimeout(soon, 500))])")
        assert page.problems == [] and ran in ("yes", None)
        if ran:
            return


@pytest.mark.parametrize("name", NOTEBOOKS)
def test_a_notebook_runs_in_the_browser(page, lite, name):
    opened(page, lite, name)
    run_all(page)
    nb = notebook(page)
    assert_it_ran(nb)
    move_a_slider(page, nb)
    give_answers(page, nb)
    play(page, nb)
    assert page.locator("text=Error displaying widget").count() == 0


def test_work_is_kept_taken_home_and_taken_up_again(page, chromium, lite, tmp_path):
    """A function that passes is in my_slam.py, and with the progress and the notebook in the zip file."""
    lite.sent.clear()
    opened(page, lite, "00_start_here.ipynb")
    cells = notebook(page).cells
    exercise = next(i for i, cell in enumerate(cells) if "exercise" in cell.metadata.get("tags", []))
    begin = next(i for i, cell in enumerate(cells) if cell.cell_type == "code")
    page.evaluate("async () => { await window.jupyterapp.shell.currentWidget.sessionContext.ready }")
    page.evaluate("async () => { await window.jupyterapp.shell.currentWidget.sessionContext.session.kernel.info }")
    in_order = [path.rsplit("/")[-1] for path in lite.sent]
    images = [at for at, name in enumerate(in_order) if name.startswith("course-")]
    assert len(images) > 1 and in_order.index("pyodide.asm.js") < min(images)  # else both may wait for ever: start.js
    assert [worker.url.rsplit("/")[-1] for worker in page.workers] == ["ahead.js"]  # the kernel took what had begun
    write(page, begin, cells[begin].source)
    write(page, exercise, "def wrap(angle):\n    return (angle + np.pi) % (2 * np.pi) - np.pi")
    write(page, exercise + 1, 'wrap = check("00.1", wrap)\nkeep("00.1")\nprint("kept" + "!")')
    page.wait_for_function("() => document.body.innerText.includes('kept!')")

    with page.expect_download() as download:
        page.evaluate("() => window.jupyterapp.commands.execute('ekfslam:take-home')")
    work = tmp_path / "my_work.zip"
    download.value.save_as(work)
    with zipfile.ZipFile(work) as file:
        assert file.testzip() is None
        assert set(file.namelist()) == {"00_start_here.ipynb", "my_slam.py", "progress.json"}
        assert "def wrap_00(angle)" in file.read("my_slam.py").decode()
        assert json.loads(file.read("progress.json"))["00.1"]["passed"]

    # another computer: nothing is there, then everything
    other = patient(chromium)
    opened(other, lite, "00_start_here.ipynb")
    with other.expect_file_chooser() as chooser:
        other.evaluate("() => { window.taken = window.jupyterapp.commands.execute('ekfslam:take-up') }")
    chooser.value.set_files(work)
    assert sorted(other.evaluate("() => window.taken")) == ["00_start_here.ipynb", "my_slam.py", "progress.json"]
    assert "% (2 * np.pi) - np.pi" in notebook(other).cells[exercise].source
    text = "async () => (await window.jupyterapp.serviceManager.contents.get('my_slam.py', {content: true})).content"
    assert "def wrap_00(angle)" in other.evaluate(text)
    other.wait_for_function("() => location.search.includes('path=00_start_here.ipynb')")
    other.reload()  # it is in the storage, not only on the page, and the page knows what was open
    ready(other)
    assert "% (2 * np.pi) - np.pi" in notebook(other).cells[exercise].source
    assert other.strangers == []
    other.context.close()


def test_on_a_phone_a_notebook_has_room_and_the_file_menu_both_entries(page, lite):
    page.set_viewport_size({"width": 390, "height": 844})
    opened(page, lite, "00_start_here.ipynb")
    page.wait_for_function("() => document.querySelector('.jp-RenderedMarkdown').clientWidth > 0.65 * innerWidth")
    page.get_by_role("menuitem", name="File", exact=True).click()
    page.get_by_text("Download my work").wait_for()
    page.get_by_text("Take up my work…").wait_for()


def test_nothing_serious_is_in_the_way_of_a_reader_of_the_screen(page, lite):
    """Axe finds nothing serious: on the front page, and in JupyterLab with a notebook, on a phone."""
    page.set_viewport_size({"width": 390, "height": 844})
    page.goto(lite.address)
    assert serious(page) == []
    opened(page, lite, "02_mapping_with_known_poses.ipynb")
    page.wait_for_function(
        "() => document.querySelector('.cm-content[aria-label]') && !document.querySelector('[role=feed]')"
    )
    # Equations are set while one reads, and what they make too wide is named half a second later.
    found = next((found for found in each_second(page, serious) if not found), None)
    assert found == [], serious(page)


def each_second(page, look, most=60):
    """Yield what a function finds in the page, once a second."""
    for _ in range(most):
        yield look(page)
        page.wait_for_timeout(1000)


def serious(page):
    """What axe calls serious or critical."""
    found = Axe().run(page, options={"preload": False, "resultTypes": ["violations"]}).response["violations"]
    return [f"{v['id']}: {v['nodes'][0]['html'][:200]}" for v in found if v["impact"] in ("serious", "critical")]


def test_the_front_page_lists_the_notebooks_and_the_first_page_is_small(page, lite):
    lite.sent.clear()
    page.goto(lite.address)
    links = page.locator("main a")
    assert links.count() == len(ALL)
    assert sum(lite.sent.values()) < 1e6 * FIRST_PAGE_MB
    links.nth(2).click()
    page.wait_for_selector(".jp-Notebook .jp-Cell")
    before_python = {path: size for path, size in lite.sent.items() if "/pyodide/" not in path}
    largest = sorted(before_python, key=before_python.get)[-10:]
    assert 1e6 < sum(before_python.values()) < 1e6 * FIRST_PAGE_MB, f"perhaps for tools/lite/page.txt: {largest}"


def test_the_site_is_small(lite_site):
    size = sum(path.stat().st_size for path in lite_site.rglob("*") if path.is_file())
    assert size < 1e6 * SITE_MB
