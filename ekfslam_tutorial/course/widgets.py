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

import html
import inspect
import itertools
import traceback
from collections.abc import Callable
from functools import partial

import ipywidgets as w
import matplotlib.pyplot as plt
import numpy as np
from IPython.display import display

from .controls import Choice, Control, Float, Int, Toggle
from .figures import Places, bundle, one_line, picture, png, publish, show, size


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
    """Show the poster of a drawing, its caption, and below them the live widget.

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
    marked = draw.func if isinstance(draw, partial) else draw  # a drawing with some things handed over already
    controls = controls or getattr(marked, "controls", {})
    run = getattr(marked, "run", False) if run is None else run
    draw = handed(draw, controls, given)
    start = {name: control.value for name, control in controls.items()}
    fig, facts = draw(**start)
    poster = picture(fig)
    publish(poster, one_line(facts["caption"]))
    display(Panel(draw, controls, run, poster, facts).box)


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
    """The live part: controls, Reset (and Run), and one output of fixed height.

    Attributes
    ----------
    box : ipywidgets.VBox
    knobs : dict of str to ipywidgets widget
    reset, go : ipywidgets.Button
        `go` is None if the drawing follows the controls.
    output : ipywidgets.Output
        Its content is replaced as a whole: no flicker, no jump.
    """

    def __init__(self, draw, controls, run, picture, facts):
        self.draw, self.controls = draw, controls
        self.knobs = {name: knob(control, name) for name, control in controls.items()}
        self.output = w.Output(layout=w.Layout(height=f"{size(picture)[1] + 70}px", overflow="auto"))
        self.reset = w.Button(description="Reset", tooltip="All controls back to their first values")
        self.go = w.Button(description="Run", button_style="primary", tooltip="Draw with these values") if run else None
        self.places = Places()
        self.busy = False
        self._put(picture, facts)

        self.reset.on_click(lambda _: self.set(**{name: c.value for name, c in controls.items()}))
        if self.go is not None:
            self.go.on_click(lambda _: self.redraw())
        else:
            for widget in self.knobs.values():
                widget.observe(lambda _: self.redraw(), "value")
        buttons = [self.reset] if self.go is None else [self.go, self.reset]
        rows = [self._row(name) for name in controls]
        self.box = w.VBox([w.VBox(rows), w.HBox(buttons), self.output])

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
        try:
            fig, facts = self.draw(**{name: widget.value for name, widget in self.knobs.items()})
            self._put(png(fig, places=self.places), facts)
        except Exception as error:
            plt.close("all")
            lines = traceback.format_exception(error)
            self.output.outputs = (
                {"output_type": "error", "ename": type(error).__name__, "evalue": str(error), "traceback": lines},
            )
            raise

    def _put(self, picture, facts):
        caption = one_line(facts["caption"])
        self.output.outputs = (
            {"output_type": "display_data", **bundle(picture, caption)},
            {
                "output_type": "display_data",
                "data": {"text/plain": caption, "text/html": html.escape(caption)},
                "metadata": {},
            },
        )

    def _row(self, name):
        control, widget = self.controls[name], self.knobs[name]
        if not (isinstance(control, Int) and control.play):
            return widget
        play = w.Play(min=control.low, max=control.high, step=control.step, value=control.value, interval=control.play)
        w.jslink((play, "value"), (widget, "value"))
        return w.HBox([widget, play])


def knob(control: Control, name: str) -> w.ValueWidget:
    """Return the ipywidgets control: labelled, usable by keyboard, drawn only when it is let go."""
    label = control.label or name
    common = {
        "description": label,
        "tooltip": control.tip or label,
        "style": {"description_width": "190px"},
        "layout": w.Layout(width="520px"),
    }
    if isinstance(control, Toggle):
        return w.Checkbox(value=control.value, indent=False, **common)
    if isinstance(control, Choice):
        options = control.options.items() if isinstance(control.options, dict) else control.options
        return w.Dropdown(options=list(options), value=control.value, **common)
    if control.unit:
        common["description"] = f"{label} [{control.unit}]"
    slider = w.IntSlider if isinstance(control, Int) else w.FloatSlider
    return slider(
        value=control.value,
        min=control.low,
        max=control.high,
        step=control.step,
        continuous_update=False,
        **common,
    )


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
    tried = []
    for setting in settings:
        if setting not in tried:
            _try(draw, setting, given)
            tried.append(setting)
    return len(tried)


def _try(draw, setting, given=()):
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
        assert len(png(fig)) > 1000, f"{at}: the picture is empty"
    finally:
        plt.close("all")
    assert len(one_line(facts.get("caption", ""))) > 20, f"{at}: facts has no caption"
    for name, value in facts.items():
        if isinstance(value, (int, float, np.number)):
            low, high = draw.ranges.get(name, (-np.inf, np.inf))
            assert np.isfinite(value), f"{at}: {name} = {value}"
            assert low <= value <= high, f"{at}: {name} = {value}, outside [{low}, {high}]"


__all__ = ["Choice", "Float", "Int", "Panel", "Toggle", "explorable", "explore", "show", "sweep"]
