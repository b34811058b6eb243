"""Notebooks that run quickly: only the cells that matter, over shorter logs and smaller fleets."""

import ast
import inspect
from functools import cache, wraps

import matplotlib.pyplot as plt

from ekfslam_tutorial.course import build, figures, widgets
from ekfslam_tutorial.course.draws import nb09, nb09_runs, nb10, nb10_runs
from ekfslam_tutorial.course.logs import nb18, nb19
from ekfslam_tutorial.datasets import euroc_twin


@cache
def blank():
    """A picture with nothing on it."""
    return figures.png(plt.figure(figsize=(1, 1)), 40, quick=True)


def without_dots(monkeypatch):
    """Figures are laid out and drawn to the end, but without dots: those are made where nbval runs the notebook."""

    def picture(fig, dpi=0):
        fig.draw_without_rendering()
        plt.close(fig)
        return blank()

    for module in figures, widgets:
        monkeypatch.setattr(module, "picture", picture)


def tags(cell):
    return cell["metadata"].get("tags", [])


def needed(cells, chosen):
    """Return the cells with the numbers `chosen` and those that make what they use, in their order."""
    chosen, wanted = set(chosen), set()
    for k in reversed(range(len(cells))):
        made, used = uses(cells[k])
        if "check" in tags(cells[k]):
            used |= made  # the function that is checked
        if k in chosen or made & wanted:
            chosen.add(k)
            wanted |= used
    return [cells[k] for k in sorted(chosen)]


def uses(cell):
    """Return the names that a cell makes or changes, and those that it uses."""
    made, used = set(), set()
    for node in ast.walk(ast.parse(build.source(cell))):
        if isinstance(node, ast.Name):
            (used if isinstance(node.ctx, ast.Load) else made).add(node.id)
        elif isinstance(node, (ast.FunctionDef, ast.ClassDef)):
            made.add(node.name)
        elif isinstance(node, (ast.Import, ast.ImportFrom)):
            made |= {(name.asname or name.name).split(".")[0] for name in node.names}
        elif isinstance(node, (ast.Attribute, ast.Subscript)) and isinstance(node.ctx, ast.Store):
            made |= {inner.id for inner in ast.walk(node.value) if isinstance(inner, ast.Name)}
    return made, used


def shorter_logs(monkeypatch):
    """Runs over a twin end sooner: robots that must meet after a quarter. The twin stays whole: other tests keep it."""
    nb18.recording(nb18.TWIN)
    monkeypatch.setitem(nb18.SECONDS, nb18.TWIN, nb18.SECONDS[nb18.TWIN] / 4)
    frames, least = nb18.frames, nb18.SECONDS[nb18.TWIN]  # a cell that says how many seconds gets no more either
    monkeypatch.setattr(
        nb18, "frames", lambda which=nb18.TWIN, seconds=least: frames(which, min(seconds or least, least))
    )
    monkeypatch.setattr(nb09_runs, "SECONDS", 60.0)
    monkeypatch.setitem(nb19.SHORT, nb19.TWIN, nb19.SHORT[nb19.TWIN] // 6)
    monkeypatch.setattr(euroc_twin, "twin", four_seconds(euroc_twin.twin))
    monkeypatch.setattr(nb10_runs, "RUNS", 10)  # so many are drawn one by one; the others are for the mean
    for home, user, name in ((nb09_runs, nb09, "files"), (nb10_runs, nb10, "judged")):
        short = cache(getattr(home, name).__wrapped__)  # other tests keep the long ones, by either name
        for module in (home, user):
            monkeypatch.setattr(module, name, short)


def four_seconds(twin):
    """The twin of a flight, but only its take-off."""
    return lambda seed=1, n=601, *args, **more: twin(seed, min(n, 81), *args, **more)


FEW = 3  # runs: enough for a mean, a median and a band to be drawn


def few_runs(run):
    """A small fleet instead of a large one; the run that it keeps whole is one of these."""

    def few(scenario, formulas, runs=20, *args, kept_run=0, **more):
        return run(scenario, formulas, min(runs, FEW), *args, kept_run=min(kept_run, FEW - 1), **more)

    return few


def few_seeds(space):
    """Give the functions that a notebook has made, and that run with many seeds or many times, the first of them."""
    for name, f in list(space.items()):
        if not inspect.isfunction(f) or f.__module__ != space["__name__"]:
            continue
        if f.__defaults__:
            names = list(inspect.signature(f).parameters)[: f.__code__.co_argcount][-len(f.__defaults__) :]
            f.__defaults__ = tuple(map(_few, names, f.__defaults__))
        if f.__code__.co_varnames[: f.__code__.co_argcount][:1] == ("runs",):
            space[name] = _of_few_runs(f)


def _of_few_runs(f):
    """The same function, asked for no more than a few runs."""

    @wraps(f)
    def few(runs=1, *args, **more):
        return f(min(runs, FEW), *args, **more)

    return few


def _few(name, default):
    return default[:FEW] if isinstance(default, range) else min(default, FEW) if name == "runs" else default
