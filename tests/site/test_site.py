"""The course site as a reader without a network meets it."""

import html
import importlib.util
import re
import sys
from html.parser import HTMLParser
from urllib.parse import unquote, urlsplit

import pytest
from axe_playwright_python.sync_playwright import Axe
from bs4 import BeautifulSoup

from .conftest import ROOT

SPEC = importlib.util.spec_from_file_location("front", ROOT / "docs" / "front.py")
front = importlib.util.module_from_spec(SPEC)
sys.modules["front"] = front  # a dataclass looks its module up
SPEC.loader.exec_module(front)

PAGES = ["README.html", "notebooks/05_range_bearing_ekf_slam.html", "docs/rosetta.html", "docs/api/core/geometry.html"]
PAGES += ["docs/gallery.html"]
SERIOUS = ("serious", "critical")


def parse(path):
    return BeautifulSoup(path.read_text(encoding="utf-8"), "html.parser")


def test_every_notebook_and_page_of_the_docs_is_in_the_site(site):
    sources = [*ROOT.glob("notebooks/*.ipynb"), *ROOT.glob("docs/**/*.md"), ROOT / "README.md"]
    assert len(sources) > 20
    for source in sources:
        assert (site / source.relative_to(ROOT)).with_suffix(".html").exists(), source


@pytest.fixture(scope="module")
def tags(site):
    """The tags of every page: name and attributes, in their order."""
    return {path: tags_of(path.read_text(encoding="utf-8")) for path in site.rglob("*.html")}


def tags_of(text):
    """Return the tags of a page; a tree of them, which nobody needs here, would take five times as long."""
    found, parser = [], HTMLParser()
    parser.handle_starttag = lambda name, attributes: found.append((name, dict(attributes)))
    parser.feed(text)
    return found


def test_every_link_inside_the_site_leads_somewhere(site, tags):
    tags = {path: found for path, found in tags.items() if "_static" not in path.parts}
    anchors = {path: {attributes.get("id") for _, attributes in found} for path, found in tags.items()}
    wanted = {"a": "href", "img": "src", "script": "src", "link": "href", "iframe": "src"}
    broken, n = [], 0
    for path, found in tags.items():
        for address in (attributes.get(wanted.get(name)) for name, attributes in found):
            parts = urlsplit(address or "")
            if address is None or parts.scheme:
                continue
            n += 1
            goal = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            anchor = unquote(parts.fragment)
            if not goal.exists() or (anchor and goal in anchors and anchor not in anchors[goal]):
                broken.append(f"{path.relative_to(site)}: {address}")
    assert n > 1000
    assert broken == []


def test_nothing_is_fetched_from_another_host(site, tags):
    """Links may lead away; scripts, styles, pictures and frames may not come from there."""
    wanted = {"script": "src", "link": "href", "img": "src", "iframe": "src"}
    strangers = []
    for path, found in tags.items():
        for name, attributes in found:
            address = attributes.get(wanted.get(name)) or ""
            if urlsplit(address).netloc and attributes.get("rel") != "canonical":
                strangers.append(f"{path.relative_to(site)}: {address}")
    assert strangers == []


each_page = pytest.mark.parametrize("opened", PAGES, indirect=True)


@pytest.mark.browser
@each_page
def test_a_page_has_rendered_equations_and_no_errors(opened):
    page = opened
    equations = page.locator(".math").count()
    assert equations > 0 or "/notebooks/" not in page.url
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


def test_a_page_of_names_is_of_one_module(site):
    pages = list((site / "docs" / "api").rglob("*.html"))
    modules = [re.findall(r'id="module-([\w.]+)"', path.read_text(encoding="utf-8")) for path in pages]
    assert max(map(len, modules)) == 1 and sum(map(len, modules)) > 12


def test_each_scene_is_shown_with_the_command_that_makes_it(site):
    text = (ROOT / "docs" / "gallery.md").read_text(encoding="utf-8")
    parts = re.split(r"<!-- scene: (\w+) -->", text)[1:]
    assert set(parts[::2]) == set(front.SCENES)
    for name, below in zip(parts[::2], parts[1::2], strict=True):
        assert f"\n    {front.SCENES[name].command}\n" in below
        page = (site / "_static" / "scenes" / f"{name}.html").read_text(encoding="utf-8")
        assert f"<title>{html.escape(front.SCENES[name].title, quote=False)}</title>" in page
        assert 50_000 < len(page) < 1_000_000


def test_notebooks_are_cards_with_pictures(site):
    for name in "README.html", "docs/notebooks.html":
        cards = parse(site / name).select(".sd-card.notebook")
        assert len(cards) == len(list((ROOT / "notebooks").glob("[0-9][0-9]_*.ipynb")))
        assert all(card.select_one("img.sd-card-img-top") and card.select_one("a[href$=html]") for card in cards)


@pytest.mark.browser
def test_the_scenes_play(visit):
    page = visit("docs/gallery.html")
    for i, scene in enumerate(front.SCENES.values()):
        frame = page.locator("iframe.scene").nth(i)
        assert frame.get_attribute("title") == scene.title
        frame.scroll_into_view_if_needed()
        inside = frame.element_handle().content_frame()
        inside.wait_for_function("window.player?.at > 0")
        assert inside.evaluate("player.log.d === 2 || player.scene.stage.gl !== undefined")


@pytest.mark.browser
def test_heads_of_tables_and_captions_are_whole(visit):
    """No head of a table is broken into letters, no caption is cut at the right, on a narrow screen."""
    page = visit("docs/performance.html", width=390, height=844)
    heads = page.evaluate(
        "[...document.querySelectorAll('.bd-article th')]"
        ".map(th => th.offsetHeight / parseFloat(getComputedStyle(th).lineHeight))"
    )
    assert heads and max(heads) < 3  # one line and its margins
    page = visit("notebooks/05_range_bearing_ekf_slam.html", width=390, height=844)
    cut = page.evaluate(
        "[...document.querySelectorAll('.output.text_plain pre')].filter(p => p.scrollWidth > p.clientWidth + 1).length"
    )
    assert cut == 0


@pytest.mark.browser
@each_page
def test_a_page_has_no_serious_violation_of_accessibility(opened):
    found = Axe().run(opened, options={"preload": False, "resultTypes": ["violations"]}).response["violations"]
    serious = [f"{v['id']}: {v['help']}: {v['nodes'][0]['html'][:200]}" for v in found if v["impact"] in SERIOUS]
    assert serious == []


@pytest.mark.browser
@each_page
def test_a_page_fits_a_phone(opened):
    opened.set_viewport_size({"width": 390, "height": 844})
    opened.wait_for_function("innerWidth === 390")
    assert opened.evaluate("document.documentElement.scrollWidth") <= 390
    ends = "[...document.querySelectorAll('.prev-next-area *')].map(part => part.getBoundingClientRect().right)"
    assert max(opened.evaluate(ends), default=0) <= 390  # the name of the next page is whole


@pytest.mark.browser
def test_the_search_finds_a_word_of_a_notebook(visit):
    page = visit("search.html?q=odometry")
    page.locator("#search-results li").first.wait_for()
