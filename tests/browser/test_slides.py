"""The slides of every notebook in a real browser, at 1280 x 720: nothing is cut off, and letters can be read."""

import json

import pytest

from ekfslam_tutorial.course import build, slides

from .pages import resize

PATHS = sorted(build.notebooks_folder().glob("*.ipynb"))
LETTERS_PX = 20  # of running text, on 720 lines; code is smaller
PICTURE_PX = 380  # height; of a stage of 720

pytestmark = pytest.mark.browser

MEASURE = """() => [...document.querySelectorAll('section')].map((slide, i) => {
    const main = slide.querySelector('main'), img = slide.querySelector('img')
    const text = slide.querySelector('p, li')
    return {
        slide: i + 1,
        high: main.scrollHeight - main.clientHeight,
        wide: main.scrollWidth - main.clientWidth,
        letters: text ? parseFloat(getComputedStyle(text).fontSize) : 99,
        picture: img ? img.getBoundingClientRect().height : 999,
    }
})"""


@pytest.mark.parametrize("path", PATHS, ids=lambda p: p.name)
def test_slides_fit_and_can_be_read(path, page, tmp_path):
    file = tmp_path / "talk.html"
    file.write_text(slides.page(json.loads(path.read_text(encoding="utf-8"))), encoding="utf-8")
    page.goto(file.as_uri())
    page.wait_for_selector("body[data-ready]")
    assert page.problems == []
    assert page.locator("mjx-merror").count() == 0, "a formula that MathJax does not understand"
    for m in page.evaluate(MEASURE):
        assert m["high"] <= 2 and m["wide"] <= 2, f"slide {m['slide']} is cut off: {m}"  # 2 px: rounding
        assert m["letters"] >= LETTERS_PX and m["picture"] >= PICTURE_PX, f"slide {m['slide']}: {m}"


def test_keys_and_the_folded_code(page, tmp_path):
    (path,) = (p for p in PATHS if p.name.startswith("02"))
    file = tmp_path / "talk.html"
    file.write_text(slides.page(json.loads(path.read_text(encoding="utf-8"))), encoding="utf-8")
    page.goto(file.as_uri())
    page.wait_for_selector("body[data-ready]")
    number = page.locator("nav")
    last = page.locator("section").count()
    for key, at in (
        ("ArrowRight", 2),
        ("PageDown", 3),
        ("ArrowLeft", 2),
        ("End", last),
        ("ArrowRight", last),
        ("Home", 1),
    ):
        page.keyboard.press(key)
        assert number.inner_text() == f"{at} / {last}"
    while page.locator("section.now details").count() == 0 or page.locator("section.now.picture").count() == 0:
        page.keyboard.press("ArrowRight")
    code = page.locator("section.now details .highlight").first
    assert not code.is_visible()
    page.locator("section.now summary").click()
    assert code.is_visible()
    resize(page, 1920, 1200)
    assert page.locator("#deck").bounding_box()["width"] == pytest.approx(1920, abs=1)
