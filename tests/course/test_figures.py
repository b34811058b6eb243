"""Pictures in notebooks: few bytes, the same on each build, with nothing of this computer."""

import base64
import io
import os
import re
import shutil
import subprocess
import sys
import xml.etree.ElementTree as ET

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.colors import to_rgb
from PIL import Image

from ekfslam_tutorial.course import figures
from ekfslam_tutorial.course.draws import nb10
from ekfslam_tutorial.graphics import covariance_panel, style, use_style


@pytest.fixture(autouse=True)
def look():
    with plt.rc_context():
        use_style()
        yield
    plt.close("all")


def few_lines():
    """A scene in space: a grid and some arrows."""
    return nb10.gizmos(**{name: control.value for name, control in nb10.gizmos.controls.items()})[0]


def many_dots():
    fig, ax = plt.subplots(figsize=(6, 4))
    ax.plot(*np.random.default_rng(1).normal(size=(2, 5000)), ".")
    return fig


def correlations():
    A = np.random.default_rng(2).normal(size=(12, 12))
    return covariance_panel(A @ A.T, {"x": 6, "l": 6}).figure


@pytest.mark.parametrize("draw", [few_lines, many_dots, correlations])
def test_a_picture_is_the_same_on_each_build(draw):
    before = plt.get_fignums()
    assert figures.picture(draw()) == figures.picture(draw())
    assert plt.get_fignums() == before


def test_lines_are_svg_where_that_is_smaller_and_dots_are_png():
    assert figures.picture(few_lines()).startswith(b"<svg")
    assert figures.picture(many_dots()).startswith(b"\x89PNG")
    fig = many_dots()
    figures.png(fig, close=False)
    assert len(figures.svg(fig)) > 10 * len(figures.picture(many_dots()))


def test_a_picture_for_a_look_only_is_the_first_one_that_is_drawn(monkeypatch):
    monkeypatch.setattr(figures, "LOOK_ONLY", True)
    before = figures.picture(few_lines())
    assert before.startswith(b"\x89PNG") and figures.with_palette(before) is before


def drawn_lines():
    fig = few_lines()
    figures.png(fig, close=False)
    return figures.svg(fig)


def test_an_svg_has_no_date_no_font_and_no_address():
    text = drawn_lines().decode()
    ET.fromstring(text)
    assert not re.search(r"<text|font-family|20\d\d-\d\d|matplotlib|[Hh]ome", text)
    addresses = set(re.findall(r"https?://[^\"]*", text))
    assert addresses <= {"http://www.w3.org/1999/xlink", "http://www.w3.org/2000/svg"}  # names, nothing is loaded


def test_an_svg_of_another_process_is_the_same():
    code = "from tests.course.test_figures import *\nuse_style()\nsys.stdout.write(drawn_lines().decode())"
    run = [sys.executable, "-c", code]
    other = subprocess.run(run, capture_output=True, text=True, check=True, env=os.environ | {"PYTHONHASHSEED": "7"})
    assert other.stdout.encode() == drawn_lines()


def test_lines_and_dots_have_the_same_size_on_the_screen():
    fig = few_lines()
    dots = figures.png(fig, close=False)
    assert figures.size(dots) == figures.size(figures.svg(fig)) == (1008, 557)  # 10.5 x 5.8 inches
    assert Image.open(io.BytesIO(dots)).size == (1260, 696)  # 120 dots an inch


def test_few_colours_keep_paper_white_and_lines_where_they_are():
    before = figures.png(few_lines())
    after = figures.with_palette(before)
    a, b = (np.asarray(Image.open(io.BytesIO(p)).convert("RGB"), int) for p in (before, after))
    assert len(after) < 0.7 * len(before)
    assert (b[0, -1] == 255).all() and np.mean((a == 255).all(-1) & ~(b == 255).all(-1)) == 0
    assert figures.changed(Image.fromarray(a.astype(np.uint8)), Image.open(io.BytesIO(after))) < 0.002
    assert figures.size(after) == figures.size(before)


def test_a_mark_keeps_its_colour_however_small_it_is():
    fig, ax = plt.subplots(figsize=(10.5, 5.8))
    ax.plot(np.linspace(0, 1, 500), np.sin(np.linspace(0, 60, 500)), color=style.BLUE, linewidth=3)
    colours = (style.GREEN, style.VERMILLION, style.ORANGE, style.PURPLE)
    for x, colour in zip((0.2, 0.4, 0.6, 0.8), colours, strict=True):
        ax.plot(x, 1.2, "s", color=colour, markersize=3)
    few = Image.open(io.BytesIO(figures.with_palette(figures.png(fig)))).convert("RGB")
    kept = {tuple(c) for c in np.reshape(np.asarray(few), (-1, 3)).tolist()}
    assert {tuple(round(255 * v) for v in to_rgb(colour)) for colour in colours} <= kept


def test_a_colour_map_keeps_its_shades():
    few, many = (len(Image.open(io.BytesIO(figures.picture(f()))).getcolors()) for f in (many_dots, correlations))
    assert few <= 64 < 128 < many


@pytest.mark.parametrize("draw", [few_lines, many_dots])
def test_a_stored_picture_is_found_again_with_its_caption(draw):
    picture = figures.picture(draw())
    output = figures.bundle(picture, 'A "point" < 1 m & more.')
    kind, code, alt = figures.stored(output)
    assert base64.b64decode(code) == picture and alt == 'A "point" < 1 m & more.'
    assert kind == ("image/svg+xml" if draw is few_lines else "image/png")
    assert "width" in str(output)
    assert figures.stored({"data": {"text/html": "<table></table>", "text/plain": "1"}}) is None
    assert figures.stored({"output_type": "stream", "text": "1"}) is None


@pytest.mark.skipif(not shutil.which("chromium"), reason="needs a browser")
def test_a_browser_shows_the_svg_as_it_shows_the_png(tmp_path):
    """Within the image of a page, where no script, style or font of the page can help it."""
    shots = []
    fig = few_lines()
    for picture in (figures.png(fig, close=False), figures.svg(fig)):
        data = figures.bundle(picture, "seen")["data"]
        tag = data.get("text/html") or f'<img width="1008" src="data:image/png;base64,{data["image/png"]}">'
        (tmp_path / "page.html").write_text(f"<body style='margin:0'>{tag}</body>")
        shot = tmp_path / f"{len(shots)}.png"
        options = ["--headless", "--no-sandbox", "--disable-gpu", "--window-size=1100,640", f"--screenshot={shot}"]
        subprocess.run(["chromium", *options, f"file://{tmp_path}/page.html"], check=True, capture_output=True)
        shots.append(np.asarray(Image.open(shot).convert("L").resize((275, 160)), float))
    assert shots[0].std() > 5, "an empty page"
    assert np.abs(shots[0] - shots[1]).mean() < 1.5
