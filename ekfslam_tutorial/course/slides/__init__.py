"""The lecture cut as slides: one HTML file with everything inside, to be projected without a network or a kernel.

A text cell is a slide. A picture gets a slide of its own, as large as it can be, with its caption. A few words before
a picture stand above it, and the answer to a poll below it. Code is folded; where a cell only prints, code and output
are shown. The Markdown and the coloured code are nbconvert's; formulas are set by MathJax, which is part of the file.
"""

from __future__ import annotations

import html
import importlib.metadata
import itertools
import json
import re
from dataclasses import dataclass, field
from pathlib import Path

from nbconvert.filters import Highlight2HTML, ansi2html, markdown2html_mistune
from pygments.formatters import HtmlFormatter

from ..build import source
from ..figures import stored
from ..lecture import tagged

HERE = Path(__file__).parent
FEW_WORDS = 25  # as many stand above or below a picture
ANSWER = re.compile(r"\*\*\(?\w\)?\*\*|The (answer|truth) ")  # to the poll before the picture
WIDGET = re.compile(r"\(Run this cell")  # stands for the controls in a stored notebook
HEADING = re.compile(r"\n+(?=#+ )")  # each starts a slide
FOLD = re.compile(r"</?details>|<summary>.*?</summary>")  # on slides an answer comes with the next key
MINUTES = re.compile(r" *\(\d+ min\)")  # those of a student
MATHJAX = "sphinx-mathjax-offline", "sphinx-mathjax-offline/static/mathjax/tex-svg.js"

_colour = Highlight2HTML(pygments_lexer="ipython3")


@dataclass
class Slide:
    """One slide: what kind it is, its parts from top to bottom, and the code folded at its foot."""

    kind: str  # "title", "text", "picture", "page" or "code"
    section: str  # the last heading, shown at the top where the slide has none of its own
    parts: list[str] = field(default_factory=list)
    folded: list[str] = field(default_factory=list)
    live: bool = False  # a widget in the notebook

    def html(self) -> str:
        """Return the slide as a section of the page."""
        head = "" if self.kind in ("title", "text") else f"<header>{html.escape(self.section)}</header>"
        live = '<span class="live">live in the notebook</span>' if self.live else ""
        code = f"<details><summary>code</summary>{''.join(self.folded)}</details>" if self.folded else ""
        body = "\n".join(self.parts)
        return f'<section class="{self.kind}">{head}<main>{body}</main><footer>{live}{code}</footer></section>'


def slides(notebook: dict) -> list[Slide]:
    """Return the slides of a notebook, from its stored outputs."""
    cells = tagged(notebook)
    title, *rest = source(cells[0]).split("\n\n")
    found = title_slides(title.lstrip("# "), rest)
    lead = ""
    for cell, following in itertools.pairwise([*cells[1:], {}]):
        if cell["cell_type"] == "markdown":
            *before, last = HEADING.split(MINUTES.sub("", FOLD.sub("", source(cell)).strip()))
            for text in filter(None, before):
                add_text(found, text, None)
            lead = add_text(found, last, following.get("outputs"))
        elif cell["cell_type"] == "code":
            add_code(found, cell, lead)
            lead = ""
    return found


def title_slides(title: str, rest: list[str]) -> list[Slide]:
    """Return the slide with title and question, and one with what else the first cell says of the notation."""
    rest = [text for text in rest if not text.startswith(("About ", "**Afterwards you can**"))]
    question = next((text for text in rest if text.startswith("**The question")), "")
    first = Slide("title", title, [f"<h1>{html.escape(title)}</h1>", markdown(question)])
    tables = "\n\n".join(text for text in rest if text != question)
    return [first, Slide("text", title, [markdown(tables)])] if "|---" in tables else [first]


def add_text(found: list[Slide], text: str, shown_next) -> str:
    """Append a text cell: a slide, or a few words below the picture before it.

    Returns
    -------
    str
        A few words that are to stand above what the next cell shows.
    """
    heading = re.search(r"^#+ +(.*)$", text, re.MULTILINE)
    few = len(text.split()) <= FEW_WORDS and heading is None and "|---" not in text and "$$" not in text
    answer = ANSWER.match(text)
    if few and found[-1].kind == "picture" and (answer or not shown_next) and "Predict before" not in text:
        found[-1].parts.append(f'<div class="words">{markdown(text)}</div>')
    elif few and shown_next and not answer:
        return f'<div class="words">{markdown(text)}</div>'
    else:
        found.append(Slide("text", plain(heading[1]) if heading else found[-1].section, [markdown(text)]))
    return ""


def add_code(found: list[Slide], cell: dict, lead: str):
    """Append a code cell: a slide for each picture or page in its outputs, or one with code and printed lines."""
    text, section = source(cell), found[-1].section
    code = _colour(text)
    made, printed = [], []
    for output in cell.get("outputs", []):
        picture = stored(output)
        data = {kind: "".join(value) for kind, value in output.get("data", {}).items()}
        if output["output_type"] == "stream":
            printed.append(f"<pre class='printed'>{ansi2html(''.join(output['text']))}</pre>")
        elif picture:
            kind, base64, alt = picture
            shown = f'<img alt="{html.escape(alt)}" src="data:{kind};base64,{base64}">'
            made.append(Slide("picture", section, [shown]))
        elif "text/html" in data:
            made.append(Slide("page", section, [f'<div class="page">{data["text/html"]}</div>']))
        elif (
            data.keys() == {"text/plain"}
            and made
            and made[-1].kind == "picture"
            and not WIDGET.match(data["text/plain"])
        ):
            caption = " ".join(data["text/plain"].split())
            made[-1].parts.append(f'<p class="caption">{html.escape(caption)}</p>')
    if made:
        made[0].folded.append(code)
        made[0].live = "explore(" in text
        found += made
        if sum(text.count("\n") for text in printed) > 2:
            found.append(Slide("code", section, printed))
        else:
            made[0].parts += printed
        made[0].parts.insert(0, lead)
    elif printed and not text.startswith(("import ", "from ")):
        found.append(Slide("code", section, [lead, f'<div class="shown">{code}</div>', *printed]))
    else:  # it prepares what comes
        found[-1].folded.append(code + "".join(printed))


def markdown(text: str) -> str:
    """Return Markdown as HTML; formulas stay as they are, for MathJax."""
    return markdown2html_mistune(text)


def plain(heading: str) -> str:
    """Return a heading without its marks."""
    return re.sub(r"[*`$\\]", "", heading)


def page(notebook: dict) -> str:
    """Return the slides of a notebook as one HTML page that needs nothing else.

    Parameters
    ----------
    notebook : dict
        As read from the ``.ipynb`` file, with its outputs.

    Raises
    ------
    ValueError
        If no cell has the tag ``lecture``.
    FileNotFoundError
        If MathJax is not installed, with the command that installs it.
    """
    made = slides(notebook)
    colours = HtmlFormatter(style="default").get_style_defs(".highlight")
    settings = {
        "tex": {"inlineMath": [["$", "$"], ["\\(", "\\)"]]},
        "options": {"enableMenu": False},
        "svg": {"fontCache": "global"},
    }
    return "\n".join(
        [
            '<!DOCTYPE html><html lang="en"><head><meta charset="utf-8">',
            f"<title>{html.escape(made[0].section)}</title>",
            f"<style>{colours}\n{(HERE / 'slides.css').read_text(encoding='utf-8')}</style>",
            f"<script>window.MathJax = {json.dumps(settings)};</script><script>{mathjax()}</script>",
            '</head><body><div id="deck">',
            *(slide.html() for slide in made),
            '</div><nav aria-label="slide number"></nav>',
            f"<script>{(HERE / 'slides.js').read_text(encoding='utf-8')}</script></body></html>\n",
        ]
    )


def mathjax() -> str:
    """Return the program MathJax, from an installed package."""
    package, file = MATHJAX
    try:
        path = Path(str(importlib.metadata.distribution(package).locate_file(file)))
        return path.read_text(encoding="utf-8")
    except (importlib.metadata.PackageNotFoundError, OSError) as error:
        raise FileNotFoundError(f"slides need MathJax on this computer: python -m pip install {package}") from error
