"""What the site shows beyond the pages of the repository: live scenes, and cards where GitHub shows tables.

A scene is the ``view.html`` that an ``ekfslam run`` writes. The site builds each from its command, with no data but the
simulated twins, and keeps it as long as the package and the scenarios stay as they are.
"""

import contextlib
import hashlib
import html
import io
import os
import re
import shlex
import shutil
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


@dataclass(frozen=True)
class Scene:
    """A run that can be played: its name in addresses, its title, the command that makes it."""

    name: str
    title: str
    command: str


SCENES = {
    scene.name: scene
    for scene in (
        Scene("two_robots", "Two robots with four cameras", "ekfslam run two_robots_four_cameras"),
        Scene("lecture", "The lecture's round", "ekfslam run range_bearing_2d"),
        Scene(
            "five_robots",
            "Five robots in one filter",
            """ekfslam run mrclam_joint --set 'data={name="mrclam_twin", robots=[1, 2, 3, 4, 5], duration=120}'""",
        ),
        Scene("park", "The park", """ekfslam run victoria_park --set 'data.name="victoria_park_twin"'"""),
    )
}
MARK = re.compile(r"<!-- scene: (\w+) -->")
PICTURES = re.compile(r"<!-- pictures -->.*?<!-- end of pictures -->", re.DOTALL)
NOTEBOOK = re.compile(r"^\| \[(\d\d) ([^\]]+)\]\((\S+)\) \| (.+) \| (\d+) \| (.+) \|$", re.MULTILINE)
LISTED = re.compile(
    r"^\| !\[(.*?)\]\((\S+)\) \| \*\*\[(.+?)\]\((\S+)\)\*\* <br> (.+?) <br> (.+?) \| (\d+) \| (.+) \|$", re.MULTILINE
)


# --- building the scenes ---


def build(app):
    """Make the scenes that are missing or old; for Sphinx's event `builder-inited`."""
    folder = Path(app.doctreedir) / "scenes"
    folder.mkdir(parents=True, exist_ok=True)
    if app.builder.format != "html":
        return
    for scene in SCENES.values():
        page, key = folder / f"{scene.name}.html", folder / f"{scene.name}.key"
        now = fingerprint(scene)
        if not (page.exists() and key.exists() and key.read_text() == now):
            play(scene, page)
            key.write_text(now)


def fingerprint(scene):
    """Return a text that changes with the command, the package or the scenarios."""
    digest = hashlib.sha256(scene.command.encode())
    for path in sorted([*(ROOT / "ekfslam_tutorial").rglob("*.*"), *(ROOT / "data" / "scenarios").glob("*.toml")]):
        if path.suffix in (".py", ".js", ".css", ".toml"):
            digest.update(path.read_bytes())
    return digest.hexdigest()


def play(scene, page):
    """Run the command of a scene as `ekfslam` would, and write its page."""
    from ekfslam_tutorial.cli import run, views
    from ekfslam_tutorial.cli.main import parser
    from ekfslam_tutorial.toolbox import universal_slam

    options = parser().parse_args(shlex.split(scene.command)[1:])
    with contextlib.redirect_stderr(io.StringIO()):
        data, recording = run.source(options, run.read(options, []))
        frames = universal_slam(data, recording)
        replay = views.Replay(scene.title, len(frames), data.figure.k)
        for snapshot in frames:
            replay.add(snapshot)
    os.replace(page.parent / replay.write(page.parent), page)


def copy(app, problem):
    """Put the scenes into the site; for Sphinx's event `build-finished`."""
    if problem is None and app.builder.format == "html":
        goal = Path(app.outdir) / "_static" / "scenes"
        goal.mkdir(parents=True, exist_ok=True)
        for name in SCENES:
            shutil.copy(Path(app.doctreedir) / "scenes" / f"{name}.html", goal)


# --- pages ---


def page(name, text):
    """Return the source of a page as the site shows it."""
    up = "../" * name.count("/")
    text = MARK.sub(lambda match: frame(SCENES[match[1]], up), text)
    if name == "README":
        text = NOTEBOOK.sub(course_card, PICTURES.sub(lambda _: opening(), text))
        text = text.replace("| notebook | question | minutes | open in |\n|---|---|---|---|\n", "")
    if name == "docs/notebooks":
        text = LISTED.sub(listed_card, text).replace("| | notebook | minutes | you need |\n|---|---|---|---|\n", "")
    return grids(text)


def frame(scene, up):
    """Return a scene as HTML: it is loaded when it comes into view, and plays."""
    address, title = f"{up}_static/scenes/{scene.name}.html", html.escape(scene.title)
    return (
        f'<iframe class="scene" src="{address}#play" title="{title}" loading="lazy" allow="fullscreen"></iframe>\n'
        f'<p class="alone"><a href="{address}">{title}: as a page of its own</a></p>'
    )


def opening():
    """Return what the first page opens with: a live scene, and the ways in."""
    ways = [
        ("The course", "docs/notebooks", "25 notebooks, from a lecture on mapping to five robots in one filter."),
        ("Gallery", "docs/gallery", "Four runs to play and to walk around, each with its command."),
        ("The toolbox", "docs/scenarios", "A run is a file: robots, sensors, landmarks, noise, filter."),
        ("For lecturers", "docs/teaching", "Slides, marks, checks of your own, plans for a term."),
    ]
    cards = [f":::{{grid-item-card}} {t}\n:link: {to}\n:link-type: doc\n\n{text}\n:::" for t, to, text in ways]
    scene = SCENES["two_robots"]
    return "\n\n".join(
        [frame(scene, ""), f"Made by `{scene.command}`. Point at a landmark to read its covariance.", *cards]
    )


def course_card(row):
    """Return a row of the README's table of notebooks as a card."""
    number, title, address, question, minutes, ways = row.groups()
    picture, foot = f"docs/images/notebooks/{number}.png", f"{minutes} minutes. Open in: {ways}"
    return card(f"{number} {title}", address, picture, question, foot)


def listed_card(row):
    """Return a row of the table in docs/notebooks.md as a card."""
    alt, picture, title, address, question, objectives, minutes, needs = row.groups()
    return card(title, address, picture, f"{question}\n\n{objectives}", f"{minutes} minutes. You need: {needs}", alt)


def card(title, address, picture, text, foot, alt=""):
    """Return a card with a picture; the notebook is linked."""
    head = f":::{{grid-item-card}} [{title}]({address})\n:img-top: {picture}\n:img-alt: {alt}\n:class-card: notebook"
    return f"{head}\n\n{text}\n\n<small>{foot}</small>\n:::"


def grids(text):
    """Put cards that follow each other into a grid."""
    cards = re.compile(r"(?:^:::\{grid-item-card\}.*?^:::\n*)+", re.MULTILINE | re.DOTALL)
    return cards.sub(lambda found: f"::::{{grid}} 1 2 2 2\n:gutter: 3\n\n{found[0].rstrip()}\n::::\n\n", text)
