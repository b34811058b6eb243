"""Widgets that work live, read well without a kernel, and can be tested.

A widget is a pure function ``draw(**params) -> (fig, facts)`` and the controls of its parameters. `fig` is a
matplotlib figure, `facts` a dictionary of the numbers it shows, with the sentence ``facts["caption"]``.

    @explorable(sigma=Float(0.1, 0.0, 1.0, 0.05, "range noise", "m"))
    def cloud(sigma):
        ...
        return fig, {"spread_m": spread, "caption": f"The cloud is {spread:.2f} m wide."}

    explore(cloud)         # in a notebook
    sweep(cloud)           # in a test

A drawing of an experiment does not run it: what runs stands in the notebook and is handed over. Parameters without a
control are for that, and come first::

    @explorable(told=Float(1.0, 0.5, 2.0, 0.1, "noise told / true noise"))
    def errors(localise, told):
        e = localise(told)
        ...

    explore(errors, localise)
"""

from __future__ import annotations

import asyncio
import html
import inspect
import itertools
import time
import traceback
from collections import deque
from collections.abc import Callable
from functools import partial

import ipywidgets as w
import matplotlib.pyplot as plt
import numpy as np
from IPython.display import display
from traitlets import Unicode

from .controls import Choice, Control, Float, Int, Toggle
from .figures import DPI, SCREEN, Places, one_line, picture, png, publish, show, size

QUICK = 0.1  # seconds of the processor: a picture that takes longer does not follow a control that is dragged
REST = 0.3  # seconds without a change: then the picture is drawn with all its dots
SHARP = max(2 * SCREEN, DPI)  # dots of an inch, for a screen with two dots to each CSS pixel
COARSE = 40  # dots of an inch: enough to see that a picture can be drawn
LIVE = "ekfslam-live"
SAID = '<div aria-live="polite" style="line-height: 1.4">{}</div>'
HIDE = """<style>
.jp-OutputArea-child:has(+ .jp-OutputArea-child .ekfslam-live),
.jp-OutputArea-child:has(+ .jp-OutputArea-child + .jp-OutputArea-child .ekfslam-live) { display: none }
</style>"""  # poster and caption, the two outputs above the live widget, where there is one: JupyterLab, JupyterLite


def explorable(*, run: bool = False, ranges: dict | None = None, **controls: Control):
    """Decorator: attach the controls to a draw function, for `explore` and `sweep`.

    Parameters
    ----------
    run : bool
        The drawing is slow: it waits for a press of the button "Run".
    ranges : dict, optional
        ``{fact: (low, high)}``: what `sweep` requires of the facts.
    **controls
        One control per parameter.
    """

    def attach(draw):
        draw.controls, draw.run, draw.ranges = controls, run, ranges or {}
        return draw

    return attach


def explore(draw: Callable, *given, run: bool | None = None, **controls: Control):
    """Show the poster of a drawing and its caption; where widgets run, the live widget in their place.

    The poster is a plain picture: it stays in the stored notebook, where widgets do not run. A mistake in
    `draw` is raised here, in the cell; one that comes later, while a control is moved, is shown under it.

    Parameters
    ----------
    draw : callable
        Pure function of its parameters that returns ``(fig, facts)``.
    *given
        What the drawing draws, results of the notebook or a function that computes them: one for each parameter
        without a control, in their order.
    run : bool, optional
        Draw only when "Run" is pressed. Without it, what `explorable` says.
    **controls
        One `Float`, `Int`, `Choice` or `Toggle` per parameter; without any, those of `explorable`.
    """
    controls = controls or getattr(draw, "controls", {})
    run = getattr(draw, "run", False) if run is None else run
    draw = handed(draw, controls, given)
    start = {name: control.value for name, control in controls.items()}
    began = time.process_time()
    fig, facts = draw(**start)
    seconds = time.process_time() - began
    poster = picture(fig)
    publish(poster, one_line(facts["caption"]))
    panel = Panel(draw, controls, run, poster, facts, seconds)
    if panel.picture.format == "png":
        panel.sharpen_later(fig)
    display(panel.box)


def wanted(draw: Callable, controls: dict[str, Control]) -> list[str]:
    """Return the names of the parameters without a control: what the notebook hands over."""
    return [name for name in inspect.signature(draw).parameters if name not in controls]


def handed(draw: Callable, controls: dict[str, Control], given: tuple) -> Callable:
    """Return the drawing as a function of its controls alone.

    Raises
    ------
    TypeError
        If something is missing or too much.
    """
    names = wanted(draw, controls) if given or hasattr(draw, "controls") else []
    if len(names) != len(given):
        call = ", ".join([f"explore({draw.__name__}", *names])
        raise TypeError(f"this drawing wants {len(names)} things to draw, got {len(given)}: {call})")
    return partial(draw, *given) if given else draw


class Panel:
    """The live part: one picture, the controls under it, Reset (and Run), and the caption.

    The picture follows a control while it is dragged, drawn with a dot for each of the screen; as soon as the control
    rests it is drawn once more, with all dots that a sharp screen has. A drawing that takes longer than `QUICK` on this
    computer waits until the control is let go, and a line under the controls says so.

    Attributes
    ----------
    box : ipywidgets.VBox
    picture : Picture
    knobs : dict of str to ipywidgets widget
    reset, go : ipywidgets.Button
        `go` is None if the drawing follows the controls.
    note : ipywidgets.HTML
        Empty, or why the picture waits.
    caption : ipywidgets.HTML
        Under the controls, so that they stay where they are whatever it says.
    error : ipywidgets.Output
        What went wrong in the last drawing.
    """

    def __init__(self, draw, controls, run, poster, facts, seconds=0.0):
        self.draw, self.controls = draw, controls
        self.knobs = {name: knob(control, name) for name, control in controls.items()}
        self.picture = Picture(poster, facts["caption"])
        self.caption, self.note, self.error = w.HTML(), w.HTML(), w.Output()
        self.reset = w.Button(description="Reset", tooltip="All controls back to their first values")
        self.go = w.Button(description="Run", button_style="primary", tooltip="Draw with these values") if run else None
        self.places = Places()
        self.busy, self.waiting = False, None
        self.seconds = deque([seconds], maxlen=3)
        self._say(facts)
        self._follow_or_wait()

        self.reset.on_click(lambda _: self.set(**{name: c.value for name, c in controls.items()}))
        if self.go is not None:
            self.go.on_click(lambda _: self.redraw())
        else:
            for widget in self.knobs.values():
                widget.observe(lambda _: self.redraw(), "value")
        buttons = [self.reset] if self.go is None else [self.go, self.reset]
        rows = w.Box([self._row(name) for name in controls], layout=w.Layout(flex_flow="row wrap"))
        last = w.HBox([*buttons, self.note], layout=w.Layout(flex_flow="row wrap"))
        self.box = w.VBox(
            [self.picture, rows, last, self.caption, self.error, w.HTML(HIDE, layout={"display": "none"})]
        )
        self.box.add_class(LIVE)

    def set(self, **values):
        """Set several controls and draw once."""
        self.busy = True
        try:
            for name, value in values.items():
                self.knobs[name].value = value
        finally:
            self.busy = False
        self.redraw()

    def redraw(self):
        """Draw with the present values. An error is shown to the student, and raised for the tests."""
        if self.busy:
            return
        began = time.process_time()
        try:
            fig, facts = self.draw(**{name: widget.value for name, widget in self.knobs.items()})
            moving = self.sharpen_later(fig)
            dots = png(fig, SCREEN if moving else SHARP, places=self.places, quick=moving)
        except Exception as error:
            plt.close("all")
            lines = traceback.format_exception(error)
            self.error.outputs = (
                {"output_type": "error", "ename": type(error).__name__, "evalue": str(error), "traceback": lines},
            )
            raise
        self.error.outputs = ()
        self.picture.show(dots, facts["caption"])
        self._say(facts)
        self.seconds.append(time.process_time() - began)
        self._follow_or_wait()

    def sharpen_later(self, fig):
        """Draw the figure with all its dots as soon as nothing has moved for a moment; return False if that is now."""
        if self.waiting is not None:
            self.waiting.cancel()
        try:
            loop = asyncio.get_running_loop()  # a kernel's, in a browser too; a test has none
        except RuntimeError:
            self.waiting = None
        else:
            self.waiting = loop.call_later(REST, self.sharpen, fig)
        return self.waiting is not None

    def sharpen(self, fig):
        """Put the same figure with all its dots in place of the picture."""
        self.waiting = None
        self.picture.show(png(fig, SHARP, places=self.places, quick=True), self.picture.tooltip)

    def _say(self, facts):
        self.caption.value = SAID.format(html.escape(one_line(facts["caption"])))

    def _follow_or_wait(self):
        """A control that is dragged redraws at once, if the last pictures were quick enough for it."""
        slow = min(self.seconds) > QUICK
        for widget in self.knobs.values():
            if isinstance(widget, w.IntSlider | w.FloatSlider):
                widget.continuous_update = not slow and self.go is None
        drawn_when = f"A picture takes {min(self.seconds):.1f} s here: it is drawn when you let the control go."
        self.note.value = drawn_when if slow and self.go is None else ""

    def _row(self, name):
        control, widget = self.controls[name], self.knobs[name]
        if not (isinstance(control, Int) and control.play):
            return widget
        play = w.Play(min=control.low, max=control.high, step=control.step, value=control.value, interval=control.play)
        w.jslink((play, "value"), (widget, "value"))
        width = room(widget.description, 130)  # pyright: ignore[reportAttributeAccessIssue]
        return w.HBox([widget, play], layout=w.Layout(flex=width, max_width="700px"))


class Picture(w.Image):
    """A picture that is replaced without a flicker, as wide as its figure says, and never taller than the window."""

    description = Unicode("").tag(sync=True)  # none; but without it the browser's part stumbles over the tooltip

    def __init__(self, poster, caption):
        low = w.Layout(
            max_width="100%", max_height="max(56vh, 300px)", object_fit="contain", object_position="left top"
        )
        super().__init__(layout=low)
        self.show(poster, caption)

    def show(self, picture, caption):
        """Take another picture; the caption is for those who do not see it."""
        with self.hold_sync():
            self.format = "svg+xml" if picture.startswith(b"<svg") else "png"
            self.layout.width = f"{size(picture)[0]}px"
            self.value, self.tooltip = picture, one_line(caption)


def knob(control: Control, name: str) -> w.ValueWidget:
    """Return the ipywidgets control: labelled, usable by keyboard."""
    label = control.label or name
    unit = getattr(control, "unit", "")
    text = f"{label} [{unit}]" if unit else label
    common = {
        "description": text,
        "tooltip": control.tip or label,
        "style": {"description_width": "max-content"},
        "layout": w.Layout(width="auto", height="auto", flex=room(text), max_width="560px", flex_flow="row wrap"),
    }  # on a telephone the track stands under its label
    if isinstance(control, Toggle):
        return w.Checkbox(value=control.value, indent=False, **common)
    if isinstance(control, Choice):
        options = control.options.items() if isinstance(control.options, dict) else control.options
        return w.Dropdown(options=list(options), value=control.value, **common)
    slider = w.IntSlider if isinstance(control, Int) else w.FloatSlider
    return slider(value=control.value, min=control.low, max=control.high, step=control.step, **common)


def room(label: str, more: int = 0) -> str:
    """Return how wide a control wants to be: two stand side by side where there is room for label, track and number."""
    return f"1 1 {240 + 7 * len(label) + more}px"


def sweep(draw: Callable, corners: int = 20, seed: int = 0, together: int = 16, given: tuple = ()) -> int:
    """Try a drawing at the least, first and greatest value of every control and at random corners.

    Parameters
    ----------
    draw : callable
        A function marked with `explorable`.
    corners : int
        Number of random settings.
    seed : int
    together : int
        How many of the settings with every control at one of its ends.
    given : tuple
        What a notebook hands over with `explore`.

    Returns
    -------
    int
        How many settings were tried.

    Raises
    ------
    AssertionError
        Naming the setting: no figure, an axis that is not finite, a fact out of its range, no caption.
    """
    controls = draw.controls
    start = {name: control.value for name, control in controls.items()}
    rng = np.random.default_rng(seed)
    settings = [start]
    settings += [{**start, name: value} for name, c in controls.items() for value in c.corners()]
    settings += [{name: c.draw(rng) for name, c in controls.items()} for _ in range(corners)]
    extremes = [(c.corners()[0], c.corners()[-1]) for c in controls.values()]
    settings += [
        dict(zip(controls, values, strict=True)) for values in itertools.islice(itertools.product(*extremes), together)
    ]
    tried, places = [], Places()
    for setting in settings:
        if setting not in tried:
            _try(draw, setting, given, places, first=not tried)
            tried.append(setting)
    return len(tried)


def _draw(fig, places, first):
    """Draw a figure to the end; the dots, at which nobody looks, of the first one only."""
    if first:
        png(fig, COARSE, places, quick=True)
        return
    places.apply(fig)
    fig.draw_without_rendering()
    places.remember(fig)


def _try(draw, setting, given, places, first):
    at = f"{draw.__name__}({', '.join(f'{k}={v!r}' for k, v in setting.items())})"
    try:
        fig, facts = draw(*given, **setting)
    except Exception as error:
        raise AssertionError(f"{at} raised {type(error).__name__}: {error}") from error
    try:
        assert hasattr(fig, "savefig"), f"{at}: the first result is {type(fig).__name__}, not a figure"
        for ax in fig.axes:
            limits = [*ax.get_xlim(), *ax.get_ylim()]
            assert np.isfinite(limits).all(), f"{at}: an axis has the limits {limits}"
        assert any(ax.has_data() or ax.texts for ax in fig.axes), f"{at}: the picture is empty"
        try:
            _draw(fig, places, first)
        except Exception as error:
            raise AssertionError(f"{at} cannot be drawn, {type(error).__name__}: {error}") from error
    finally:
        plt.close("all")
    assert len(one_line(facts.get("caption", ""))) > 20, f"{at}: facts has no caption"
    for name, value in facts.items():
        if isinstance(value, (int, float, np.number)):
            low, high = draw.ranges.get(name, (-np.inf, np.inf))
            assert np.isfinite(value), f"{at}: {name} = {value}"
            assert low <= value <= high, f"{at}: {name} = {value}, outside [{low}, {high}]"


__all__ = ["Choice", "Float", "Int", "Panel", "Toggle", "explorable", "explore", "show", "sweep"]
