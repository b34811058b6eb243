"""Links in the pages of docs/ and in the README lead somewhere: files exist, and headings too."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
LINK = re.compile(r"\[[^\]]*\]\(([^)\s]+)\)")


def prose(text):
    """A page without its fenced blocks and code spans: brackets in code are not links."""
    return re.sub(r"`[^`\n]*`", "", re.sub(r"^```.*?^```", "", text, flags=re.MULTILINE | re.DOTALL))


def anchors(text):
    """Headings as GitHub names them: small letters, no punctuation, hyphens for blanks."""
    headings = re.findall(r"^#+ (.+)$", re.sub(r"^```.*?^```", "", text, flags=re.MULTILINE | re.DOTALL), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", h.replace("`", "").lower()).replace(" ", "-") for h in headings}


def broken(page, text):
    """The relative links of a page that lead nowhere."""
    bad = []
    for target in LINK.findall(prose(text)):
        if re.match(r"[a-z]+:", target):
            continue
        name, _, heading = target.partition("#")
        file = (page.parent / name).resolve() if name else page
        if not file.exists() or (heading and heading not in anchors(text if file == page else file.read_text("utf-8"))):
            bad.append(target)
    return bad


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.name)
def test_links_lead_somewhere(page):
    assert broken(page, page.read_text(encoding="utf-8")) == []


def test_every_page_can_be_reached_from_the_index():
    index = (ROOT / "docs" / "README.md").read_text(encoding="utf-8")
    assert {p.name for p in (ROOT / "docs").glob("*.md")} - {"README.md"} - set(LINK.findall(prose(index))) == set()


def test_the_check_itself_sees_a_broken_link():
    page = ROOT / "docs" / "README.md"
    text = "# Two words\n[a](nowhere.md) [b](#two-words) [c](#three) [d](../README.md#start) `x[0](y)` [e](https://a.b)"
    assert broken(page, text) == ["nowhere.md", "#three"]
