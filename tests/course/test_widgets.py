"""Widgets: every drawing at the ends of its controls, and what happens when a control is moved."""

import ast
import asyncio
import html
import io
import json
import re
import time

import ipywidgets
import matplotlib.pyplot as plt
import pytest
from matplotlib.figure import Figure
from PIL import Image

from ekfslam_tutorial.course import Choice, Float, Int, Toggle, build, draws, explorable, explore, show, sweep, widgets
from ekfslam_tutorial.course.figures import Places

from .running import shorter_logs

DRAWINGS = draws.everything()
NOTEBOOKS = sorted(build.notebooks_folder().glob("*.ipynb"))


@pytest.fixture(autouse=True)
def close_figures():
    yield
    plt.close("all")


@pytest.fixture
def displayed(monkeypatch):
    """What a cell would show, in order."""
    shown = []

    def display(*objects, **options):
        shown.extend((o, options) for o in objects)

    monkeypatch.setattr(widgets, "display", display)
    monkeypatch.setattr("ekfslam_tutorial.course.figures.display", display)
    return shown


@explorable(
    n=Int(3, 1, 8, label="points", play=300),
    scale=Float(0.5, 0.1, 2.0, 0.1, "scale", "m"),
    kind=Choice("line", {"a line": "line", "dots": "dots"}),
    on=Toggle(True),
    ranges={"n": (1, 8)},
)
def example(n, scale, kind, on):
    fig, ax = plt.subplots(figsize=(3, 2))
    ax.plot([scale * k for k in range(n)], "-" if kind == "line" else ".", visible=on)
    return fig, {"n": n, "caption": f"A picture of {n} points, {scale:.1f} m apart."}


def panel(draw=example, run=False):
    fig, facts = draw(**{name: c.value for name, c in draw.controls.items()})
    return widgets.Panel(draw, draw.controls, run, widgets.png(fig), facts)


def caption(panel):
    (said,) = re.findall(r"<div[^>]*>(.*)</div>", panel.caption.value)
    return html.unescape(said)


def dots(panel):
    """Width of the live picture in dots."""
    return Image.open(io.BytesIO(panel.picture.value)).width


# --- every drawing of every notebook ---


@pytest.mark.parametrize("draw", DRAWINGS, ids=lambda d: f"{d.__module__.rsplit('.')[-1]}.{d.__name__}")
def test_sweep(draw, handed, monkeypatch):
    """The ends of each control alone, two corners of them together, and one setting in between, the same each time.

    Of a drawing with a run button, which takes seconds, less of them: the first and the last choice.
    """
    shorter_logs(monkeypatch)
    more = {"corners": 0, "together": 1} if draw.run else {"corners": 1, "together": 2}
    if draw.run:
        every = Choice.corners
        monkeypatch.setattr(Choice, "corners", lambda choice: [every(choice)[0], every(choice)[-1]])
    assert sweep(draw, **more, given=handed(draw)) >= min(6, len({tuple(c.corners()) for c in draw.controls.values()}))


def _plain_figure():
    fig, ax = plt.subplots(figsize=(6, 4))
    ax.plot(range(50))
    ax.set(xlabel="x (m)", ylabel="y (m)")
    return fig


def _cpu_seconds(figure, places, pictures):
    """Processor time of a redraw while a control is dragged: a figure drawn and encoded. `pictures` gets it."""
    began = time.process_time()
    pictures.append(widgets.png(figure(), widgets.SCREEN, places=places, quick=True))
    return time.process_time() - began


FOLLOWS, MOST = 6, 9
"""Plain figures (15 to 17 ms each): of a drawing that follows a control that is dragged, 100 ms; and of any, 150 ms."""


@pytest.fixture(scope="module")
def cost():
    """How many plain figures each drawing costs, as far as they have been measured."""
    return {}


@pytest.mark.parametrize("draw", [d for d in DRAWINGS if not d.run], ids=lambda d: d.__name__)
def test_a_drawing_is_pure_and_quick_or_has_a_run_button(draw, handed, cost):
    """The same picture and caption each time. Its time is measured in plain figures, and so on busy machines too.

    The best of both counts: they are drawn by turns, until it is quick enough or has had many chances.
    """
    start, places, plain = {name: c.value for name, c in draw.controls.items()}, Places(), Places()
    mine, its, captions, pictures = [], [], [], []

    def figure():
        fig, facts = draw(*handed(draw), **start)
        captions.append(facts["caption"])
        return fig

    for tries in range(20):
        mine.append(_cpu_seconds(figure, places, pictures))
        its.append(_cpu_seconds(_plain_figure, plain, []))
        if tries > 0 and min(mine) < FOLLOWS * min(its):
            break
    assert len(set(captions)) == 1 and len(set(pictures)) == 1
    cost[draw] = min(mine) / min(its)
    assert cost[draw] < MOST, f"{draw.__name__} takes {cost[draw]:.1f} plain figures"


def test_four_of_five_drawings_follow_a_control_that_is_dragged(cost):
    """The others are drawn when it is let go, and say so; which, is found on the computer where it happens."""
    if len(cost) < 10:
        pytest.skip("the drawings were not measured before this test")
    follow = [draw for draw, plain in cost.items() if plain < FOLLOWS]
    assert len(follow) >= 0.8 * len(cost), {d.__name__: round(n, 1) for d, n in cost.items() if n >= FOLLOWS}


@pytest.mark.parametrize("draw", [d for d in DRAWINGS if d.run], ids=lambda d: d.__name__)
def test_a_drawing_with_a_run_button_is_pure(draw, handed):
    start, given = {name: c.value for name, c in draw.controls.items()}, handed(draw)
    places = Places()
    first, facts = draw(*given, **start)
    again, facts_again = draw(*given, **start)
    assert facts["caption"] == facts_again["caption"]
    assert widgets.png(first, places=places) == widgets.png(again, places=places)


@pytest.mark.parametrize("draw", DRAWINGS, ids=lambda d: d.__name__)
def test_controls_say_what_they_are(draw):
    for control in draw.controls.values():
        assert 3 <= len(control.label) < (60 if isinstance(control, Toggle) else 40)


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda p: p.name)
def test_the_widgets_of_a_notebook_are_among_those_that_are_swept(path):
    """Those of the drawings are swept above; those that a notebook makes itself, by test_own_filter."""
    known = {f"{d.__module__.rsplit('.')[-1]}.{d.__name__}" for d in DRAWINGS}
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    known |= {m for c in cells for m in re.findall(r"^@explorable\((?:.*\n)*?\)\ndef (\w+)\(", build.source(c), re.M)}
    for cell in cells:
        if cell["cell_type"] != "code" or "explore(" not in build.source(cell):
            continue
        calls = [n for n in ast.walk(ast.parse(build.source(cell))) if isinstance(n, ast.Call)]
        for call in calls:
            if ast.unparse(call.func) == "explore":
                assert ast.unparse(call.args[0]) in known and not call.keywords
        assert "nbval-ignore-output" in cell["metadata"].get("tags", [])


# --- the machinery ---


def test_axes_stay_where_they_are_until_they_need_other_room():
    def drawn(label, height):
        fig, ax = plt.subplots(figsize=(3, 2), layout="constrained")
        ax.plot([0, height])
        ax.set(ylim=(0, 10), ylabel=label)
        widgets.png(fig, places=places)
        return fig.get_layout_engine(), ax.get_position().bounds

    places = Places()
    (_, start), (kept, same), (anew, narrower) = drawn("y", 1), drawn("y", 5), drawn("two\nlines", 5)
    assert same == start and type(kept).__name__ != "ConstrainedLayoutEngine"
    assert narrower[0] > start[0] and type(anew).__name__ == "ConstrainedLayoutEngine"


def test_what_a_title_or_a_legend_inside_says_needs_no_other_room():
    def layout(title, label):
        fig, ax = plt.subplots(figsize=(3, 2), layout="constrained")
        ax.plot([0, 1], label=label)
        ax.set_title(title)
        ax.legend(loc="upper left")
        widgets.png(fig, places=places)
        return type(fig.get_layout_engine()).__name__

    places = Places()
    engines = [layout("one", "a"), layout("two", "b"), layout("two\nlines", "b")]
    assert [name == "ConstrainedLayoutEngine" for name in engines] == [True, False, True]


def test_a_settled_figure_is_drawn_once(monkeypatch):
    """matplotlib's savefig draws a figure with a layout engine twice, even one that has nothing left to lay out."""
    drawn, places = [], Places()
    draw = Figure.draw
    monkeypatch.setattr(Figure, "draw", lambda self, *args: (drawn.append(self), draw(self, *args)))
    for figure in (plt.subplots(layout="constrained")[0] for _ in range(3)):
        widgets.png(figure, places=places)
    assert len(drawn) == 2 + 1 + 1


def test_explore_shows_poster_caption_and_widget(displayed):
    explore(example)
    poster, text, box = (o for o, _ in displayed)
    assert poster["image/png"] and displayed[0][1]["metadata"]["image/png"]["alt"] == text["text/plain"]
    assert text["text/plain"] == "A picture of 3 points, 0.5 m apart."
    assert isinstance(box, ipywidgets.VBox)
    assert not plt.get_fignums()


def test_the_live_widget_is_one_picture_with_the_controls_under_it(displayed):
    """The browser hides the two outputs above it, poster and caption: see tests/browser/test_lab.py."""
    explore(example)
    picture, rows, last, said, error, style = displayed[2][0].children
    assert isinstance(picture, ipywidgets.Image) and picture.tooltip == displayed[1][0]["text/plain"]
    assert picture.layout.width == "288px" and picture.layout.max_height  # 3 inches; and never higher than the window
    assert len(rows.children) == len(example.controls) and error.outputs == () and "display: none" in style.value
    assert [button.description for button in last.children[:-1]] == ["Reset"]


def test_show_puts_the_caption_below_and_into_the_alternative_text(displayed):
    fig, facts = example(2, 1.0, "line", True)
    show(fig, "Two   points,\n one metre apart.")
    (picture, options), (text, _) = displayed
    assert text == {"text/plain": "Two points, one metre apart."}
    assert options["metadata"]["image/png"]["alt"] == "Two points, one metre apart."
    assert not plt.get_fignums()


def test_explore_with_own_controls(displayed):
    explore(
        example.__wrapped__ if hasattr(example, "__wrapped__") else example,
        n=Int(2, 1, 3),
        scale=Float(1, 0, 2, 1),
        kind=Choice("dots", ["line", "dots"]),
        on=Toggle(False),
    )
    assert "2 points" in displayed[1][0]["text/plain"]


@explorable(n=Int(2, 1, 3))
def handed_over(compute, points, n):
    fig, ax = plt.subplots(figsize=(3, 2))
    ax.plot(points[:n])
    return fig, {"caption": f"The result of the notebook's own function is {compute(n)}."}


def test_explore_hands_over_what_the_notebook_computes(displayed):
    explore(handed_over, lambda n: 10 * n, [1, 2, 3])
    _, (text, _), (box, _) = displayed
    assert text["text/plain"] == "The result of the notebook's own function is 20."
    assert sweep(handed_over, 2, given=(lambda n: 10 * n, [1, 2, 3])) == 3
    assert isinstance(box, ipywidgets.VBox)


@pytest.mark.parametrize("given", [(), (abs,), (abs, [1], 3)])
def test_explore_says_what_it_wants(given):
    with pytest.raises(TypeError, match=rf"wants 2 things to draw, got {len(given)}: explore\(handed_over, compute"):
        explore(handed_over, *given)


def test_a_moved_control_redraws():
    p = panel()
    before = p.picture.value
    p.knobs["n"].value = 5
    assert "5 points" in caption(p) and p.picture.value != before
    assert p.picture.tooltip == caption(p)
    assert not plt.get_fignums()


def test_a_picture_that_rests_has_all_dots(monkeypatch):
    """288 CSS pixels: a dot for each while a control moves, two when it rests; only the last picture is sharpened."""
    sharpened, sharpen = [], widgets.Panel.sharpen
    monkeypatch.setattr(widgets.Panel, "sharpen", lambda self, fig: (sharpened.append(fig), sharpen(self, fig)))
    monkeypatch.setattr(widgets, "REST", 0.0)

    async def drag():
        p = panel()
        for n in 4, 5, 6:
            p.knobs["n"].value = n
        moving = dots(p)
        while p.waiting is not None:
            await asyncio.sleep(0)
        return moving, dots(p), p

    moving, resting, p = asyncio.run(drag())
    assert (moving, resting, len(sharpened)) == (288, 576, 1)
    assert "6 points" in caption(p) and caption(p) == p.picture.tooltip and not plt.get_fignums()


def test_a_picture_is_sharp_at_once_where_nothing_can_wait():
    p = panel()
    p.knobs["n"].value = 4
    assert dots(p) == 576 and p.waiting is None


def test_controls_have_labels_that_are_not_cut():
    p = panel()
    assert p.knobs["scale"].description == "scale [m]"
    assert all(k.description and k.tooltip and k.style.description_width == "max-content" for k in p.knobs.values())
    assert any(
        isinstance(w, ipywidgets.Play) for row in p.box.children[1].children for w in getattr(row, "children", ())
    )


def test_a_quick_drawing_follows_and_a_slow_one_waits_and_says_so(monkeypatch):
    clock = iter([0.0, 0.3, 1.0, 1.3, 2.0, 2.02])
    p = panel()
    monkeypatch.setattr(widgets.time, "process_time", lambda: next(clock))
    p.seconds.clear()  # it has just been opened, and was slow: 0.3 s
    p.knobs["n"].value = 4
    assert p.knobs["n"].continuous_update is False and "0.3 s here: it is drawn when you let" in p.note.value
    p.knobs["n"].value = 5
    assert p.knobs["n"].continuous_update is False
    p.knobs["n"].value = 6  # what it needed is computed now: 0.02 s
    assert p.knobs["n"].continuous_update is True and p.note.value == ""


def test_controls_of_a_drawing_with_a_run_button_say_nothing_of_waiting():
    fig, facts = example(3, 0.5, "line", True)
    p = widgets.Panel(example, example.controls, True, widgets.png(fig), facts, seconds=9.0)
    assert p.note.value == "" and p.knobs["n"].continuous_update is False


def test_reset_brings_the_first_values_back_and_draws_once():
    drawn = []

    @explorable(**example.controls)
    def counted(**params):
        drawn.append(params)
        return example(**params)

    p = panel(counted)
    p.knobs["n"].value, p.knobs["on"].value = 7, False
    drawn.clear()
    p.reset.click()
    assert drawn == [{name: c.value for name, c in example.controls.items()}]
    assert "3 points" in caption(p)


def test_a_slow_drawing_waits_for_run():
    p = panel(run=True)
    p.knobs["n"].value = 6
    assert "3 points" in caption(p)
    p.go.click()
    assert "6 points" in caption(p)


def test_an_error_is_shown_and_raised():
    @explorable(n=Int(1, 0, 3))
    def fails(n):
        fig = plt.figure()
        if n == 0:
            raise ZeroDivisionError("n must not be 0")
        return fig, {"caption": "fine, nothing wrong here at all"}

    p = panel(fails)
    with pytest.raises(ZeroDivisionError):
        p.knobs["n"].value = 0
    (output,) = p.error.outputs
    assert output["output_type"] == "error" and output["evalue"] == "n must not be 0"
    assert not plt.get_fignums()
    p.knobs["n"].value = 2
    assert caption(p) == "fine, nothing wrong here at all" and p.error.outputs == ()


def test_an_error_at_the_first_values_is_an_error_of_the_cell(displayed):
    @explorable(n=Int(1, 0, 3))
    def fails(n):
        raise ValueError("no picture")

    with pytest.raises(ValueError, match="no picture"):
        explore(fails)


# --- the sweep finds what is wrong ---


def broken(make, **controls):
    @explorable(**(controls or {"n": Int(1, 0, 3)}), ranges={"fact": (0, 1)})
    def draw(n):
        return make(n)

    return draw


def picture(limits=(0, 1)):
    fig, ax = plt.subplots(figsize=(3, 2))
    ax.plot([0, 1], limits)
    return fig


def labelled(text):
    fig = picture()
    fig.axes[0].set_xlabel(text)
    return fig


GOOD = "A caption that is long enough."


@pytest.mark.parametrize(
    "make, message",
    [
        (lambda n: (picture((0, 1 / n)), {"caption": GOOD}), "ZeroDivisionError"),
        (lambda n: (picture(), {"caption": "short"}), "no caption"),
        (lambda n: (picture(), {}), "no caption"),
        (lambda n: (picture(), {"caption": GOOD, "fact": float("nan")}), "fact = nan"),
        (lambda n: (picture(), {"caption": GOOD, "fact": 1.5}), "outside"),
        (lambda n: ("no figure", {"caption": GOOD}), "not a figure"),
        (lambda n: (picture() if n == 1 else plt.subplots(figsize=(3, 2))[0], {"caption": GOOD}), "is empty"),
        (lambda n: (picture() if n == 1 else labelled("$\\frac$"), {"caption": GOOD}), "cannot be drawn, ValueError"),
    ],
)
def test_sweep_names_the_setting(make, message):
    with pytest.raises(AssertionError, match=message) as error:
        sweep(broken(make))
    assert "draw(n=" in str(error.value)


def test_sweep_tries_ends_and_corners():
    seen = []

    @explorable(a=Int(5, 0, 9), b=Float(0.5, 0.0, 1.0, 0.25), c=Toggle(False), d=Choice("x", ["x", "y", "z"]))
    def draw(a, b, c, d):
        seen.append((a, b, c, d))
        return picture(), {"caption": GOOD}

    assert sweep(draw) == len(set(seen)) == len(seen)
    for i, ends in enumerate([(0, 9), (0.0, 1.0), (False, True), ("x", "y", "z")]):
        assert set(ends) <= {s[i] for s in seen}
    assert (9, 1.0, True, "z") in seen and (0, 0.0, False, "x") in seen


@pytest.mark.parametrize("wrong", [lambda: Int(5, 6, 9), lambda: Float(1, 0, 2, 0), lambda: Choice("q", ["a"])])
def test_a_control_must_make_sense(wrong):
    with pytest.raises(ValueError):
        wrong()


def test_a_drawing_takes_a_function_of_the_notebook(displayed):
    """`explore(draw, *given)`: the controls are those of the drawing, the run is the student's."""

    @explorable(n=Int(3, 1, 8))
    def picture(count, n):
        fig, _ = plt.subplots(figsize=(3, 2))
        return fig, {"caption": f"The run says {count('x' * n)} for a number of {n}."}

    explore(picture, lambda text: 10 * len(text))
    assert displayed[1][0]["text/plain"] == "The run says 30 for a number of 3."
    _, knobs, *_ = displayed[2][0].children
    assert len(knobs.children) == 1
