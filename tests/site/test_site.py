"""The course site as a reader without a network meets it."""

from urllib.parse import unquote, urlsplit

import pytest
from axe_playwright_python.sync_playwright import Axe
from bs4 import BeautifulSoup

PAGES = ["README.html", "notebooks/05_range_bearing_ekf_slam.html", "docs/rosetta.html", "docs/api/core.html"]
SERIOUS = ("serious", "critical")


def parse(path):
    return BeautifulSoup(path.read_text(encoding="utf-8"), "html.parser")


def test_every_notebook_and_page_of_the_docs_is_in_the_site(site):
    from .conftest import ROOT

    sources = [*ROOT.glob("notebooks/*.ipynb"), *ROOT.glob("docs/**/*.md"), ROOT / "README.md"]
    assert len(sources) > 20
    for source in sources:
        assert (site / source.relative_to(ROOT)).with_suffix(".html").exists(), source


def test_every_link_inside_the_site_leads_somewhere(site):
    pages = {path: parse(path) for path in site.rglob("*.html") if "_static" not in path.parts}
    anchors = {path: {tag["id"] for tag in page.find_all(id=True)} for path, page in pages.items()}
    broken, n = [], 0
    for path, page in pages.items():
        for tag, attribute in (("a", "href"), ("img", "src"), ("script", "src"), ("link", "href")):
            for element in page.find_all(tag, **{attribute: True}):
                parts = urlsplit(element[attribute])
                if parts.scheme:
                    continue
                n += 1
                goal = (path.parent / unquote(parts.path)).resolve() if parts.path else path
                anchor = unquote(parts.fragment)
                if not goal.exists() or (anchor and goal in anchors and anchor not in anchors[goal]):
                    broken.append(f"{path.relative_to(site)}: {element[attribute]}")
    assert n > 1000
    assert broken == []


def test_nothing_is_fetched_from_another_host(site):
    """Links may lead away; scripts, styles, pictures and frames may not come from there."""
    strangers = []
    for path in site.rglob("*.html"):
        page = parse(path)
        for tag, attribute in (("script", "src"), ("link", "href"), ("img", "src"), ("iframe", "src")):
            for element in page.find_all(tag, **{attribute: True}):
                if urlsplit(element[attribute]).netloc and element.get("rel") != ["canonical"]:
                    strangers.append(f"{path.relative_to(site)}: {element[attribute]}")
    assert strangers == []


@pytest.mark.browser
@pytest.mark.parametrize("name", PAGES)
def test_a_page_has_rendered_equations_and_no_errors(visit, name):
    page = visit(name)
    equations = page.locator(".math").count()
    assert equations > 0 or not name.startswith("notebooks/")
    assert page.locator(".math:has(mjx-container)").count() == equations
    assert page.locator("mjx-merror").count() == 0
    assert page.locator("body").inner_text().count("$$") == 0
    broken = page.evaluate("[...document.images].filter(i => i.complete && !i.naturalWidth).map(i => i.src)")
    assert broken == []


@pytest.mark.browser
def test_the_first_page_leads_to_the_readme(visit):
    page = visit("", wait=False)
    page.wait_for_url("**/README.html")
    assert "a course and a toolbox" in page.title()


@pytest.mark.browser
def test_the_player_plays_on_a_page(visit):
    page = visit("notebooks/05_range_bearing_ekf_slam.html")
    frame = page.locator("iframe").first
    frame.scroll_into_view_if_needed()
    inside = frame.element_handle().content_frame()
    inside.wait_for_function("window.player?.drawn > 0")
    before = inside.evaluate("player.at")
    inside.get_by_role("application").focus()
    inside.get_by_role("application").press("ArrowRight")
    inside.wait_for_function("before => player.at !== before", arg=before)


@pytest.mark.browser
@pytest.mark.parametrize("name", PAGES)
def test_a_page_fits_a_phone(visit, name):
    page = visit(name, width=390, height=844)
    assert page.evaluate("document.documentElement.scrollWidth") <= 390


@pytest.mark.browser
@pytest.mark.parametrize("name", PAGES)
def test_a_page_has_no_serious_violation_of_accessibility(visit, name):
    found = Axe().run(visit(name), options={"preload": False}).response["violations"]
    serious = [f"{v['id']}: {v['help']}: {v['nodes'][0]['html'][:200]}" for v in found if v["impact"] in SERIOUS]
    assert serious == []


@pytest.mark.browser
def test_the_search_finds_a_word_of_a_notebook(visit):
    page = visit("search.html?q=odometry")
    page.locator("#search-results li").first.wait_for()
