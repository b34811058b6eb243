"""`ekfslam run`: a scenario from its file to figures, with a progress bar, and nothing lost on Ctrl-C."""

import argparse
import importlib.machinery
import inspect
import shlex
import signal
import sys
import threading
import time
import traceback
import types
from contextlib import ExitStack, contextmanager, nullcontext
from dataclasses import dataclass
from pathlib import Path

from .. import datasets
from ..analysis import History
from ..analysis.checkpoint import Checkpoint, resume
from ..analysis.factors import GraphMaker, graph_of
from ..analysis.innovations import Innovations
from ..analysis.notes import notes
from ..analysis.progress import bar
from ..analysis.series import unfinished
from ..toolbox import Recorder, Recording, UserData, parse_override, universal_slam
from ..toolbox.adjusted import is_adjusted
from ..toolbox.clock import computing_time
from . import results, smoothing, views
from .effects import without_effect
from .files import ResultFolder, file_name, find_scenario, scenarios, told
from .terminal import say, table

KEPT = "checkpoint.npz"
"""Where a run is kept on the way."""


class KeptHistory(History):
    """A history that knows every how many frames its run is kept; whoever goes on with it does the same.

    Keeping brings the far states of a compressed map up to date. That moves its last digits, so it is done in the same
    frames.
    """

    every = 200  # where the user does not say


def main(options):
    """Run the command; without a scenario, say which there are."""
    if options.scenario is None:
        table([[name, told(path)] for name, path in scenarios().items()], styles=["bold"], cut=True)
        say("run one: ekfslam run range_bearing_2d; or your own: ekfslam run FILE.toml", "dim")
        return 0
    models = [cls for file in options.models for cls in own_models(file)]
    with told_by_name(options.models):
        return run_scenario(options, models)


def run_scenario(options, models):
    """Read, run and write; return the exit code."""
    data = read(options, models)
    with ResultFolder(options.out or Path("results") / file_name(data.name)) as folder:
        return run_into(folder, options, models, data)


def run_into(folder, options, models, written_data):
    """Run and write; the folder is ours meanwhile."""
    data, recording = source(options, written_data)
    if unfinished(folder.path / "runs.npz"):
        raise ValueError(f"{folder.path} holds an unfinished series of monte-carlo: resume it, or take another folder")
    if data.options.smooth:
        smoothing.check(data)
    said = tell_notes(notes_before(options, models, written_data, data, recording))
    movie = movie_of(options, data, folder.path)
    tell_computing(options, data)
    history = KeptHistory(truth_std=getattr(recording, "truth_std", (0.0, 0.0)))
    state = taken_up(options, folder.path, data, recording, history)
    if options.checkpoint is not None:
        history.every = options.checkpoint
    run = universal_slam(data, recording, resume=state)
    print(f"engine: {run.engine}", file=sys.stderr)
    watchers = Watchers.of(options, folder.path, data, recording, history, len(run), state)
    kept = [KEPT] if watchers.keeper else []
    folder.announce(*kept, *([movie.name] if movie else []))
    with ExitStack() as windows:  # they close last: everything is written while they are still open
        shown = [*watchers, *([windows.enter_context(views.Live(data.figure))] if options.live else [])]
        with views.Film(movie, data.figure) if movie else nullcontext() as film, suspected(options.models):
            first = state["frames"] if state else 0
            seconds, costs, interrupted = consume(run, shown + ([film] if movie else []), first)
        if watchers.keeper and interrupted and history.last is not None:
            watchers.keeper.save(history.last)
            print("ekfslam run: the same command with --resume goes on", file=sys.stderr)
        if history.last is None:
            print("ekfslam run: stopped before the first frame; there is nothing to write", file=sys.stderr)
            return 130
        summary = results.summary(data, history, recording, run, seconds, interrupted, costs)
        written, doubts = write(folder, summary, said, watchers, data, recording, costs)
        written += [movie.name] if movie else []
        folder.keep(*written, *(kept if interrupted else []))  # once all of the result is there
        results.tell(summary)
        tell_notes([*doubts, *(not_compiled() if data.options.compiled else [])])
        if data.options.smooth and not interrupted:
            graph = watchers.maker.finish() if watchers.maker else graph_of(data, recording)
            more, interrupted = smoothed(folder, summary, graph, written)
            written += more
        print(f"written to {folder.path}: {', '.join(written)}", flush=True)
        if data.landmark.hypotheses and not data.options.smooth and not interrupted:
            print(smooth_next(options), flush=True)
    return 130 if interrupted else 0


def smoothed(folder, summary, graph, written):
    """Smooth a run that is written, and write that beside it; Ctrl-C ends the smoothing, and the run stays as it is.

    Returns
    -------
    names : list of str
        Of the files that are new.
    interrupted : bool
    """
    try:
        found = smoothing.smoothed(graph)
        summary["smoothed"] = smoothing.scores(found)
        with folder.results() as new:
            names = smoothing.write(new, found, summary["scenario"])
            results.write_figures(new, summary)
    except KeyboardInterrupt:
        print("ekfslam run: smoothing stopped; the run of the filter is written", file=sys.stderr)
        return [], True
    folder.keep(*written, *names)
    smoothing.tell(found, summary["scenario"], None)
    return names, False


@dataclass
class Watchers:
    """Receivers of each frame: what becomes the result, and what was asked for besides; None if it was not."""

    history: KeptHistory
    replay: views.Replay
    richest: views.Richest
    recorder: Recorder | None = None
    innovations: Innovations | None = None
    keeper: Checkpoint | None = None
    maker: GraphMaker | None = None

    @classmethod
    def of(cls, options, out, data, recording, history, frames, state):
        """Those that the options ask for."""
        watchers = cls(history, views.Replay(data.name, frames, data.figure.k), views.Richest())
        if options.record:
            watchers.recorder, watchers.innovations = Recorder(), Innovations()
        if options.resume or options.checkpoint is not None:
            watchers.keeper = Checkpoint(out / KEPT, data, recording, history, history.every, frames)
        if data.options.smooth and state is None:  # who goes on with a run has not seen its beginning
            watchers.maker = GraphMaker(data, recording)
        return watchers

    def __iter__(self):
        return (watcher for watcher in vars(self).values() if watcher is not None)


def movie_of(options, data, out):
    """Refuse what cannot be had; return where the film goes, if one is asked for."""
    if options.record and is_adjusted(data):
        raise ValueError(
            "--record writes what the filter was told: with noise_factor, bias or clock_offset it would be "
            "changed twice when it is played again; record without them"
        )
    if options.camera is not None and options.camera.isdecimal() and views.has_display():
        options.live = True  # a webcam is watched while it runs
    if options.live:
        views.check_display()
    return views.movie_path(out) if options.movie else None


def tell_computing(options, data):
    """Print what computes."""
    print(f"linear algebra on {options.threads} thread{'s' * (options.threads > 1)} (--threads)", file=sys.stderr)
    if data.options.compiled:
        print("steps compiled: the first run of a model on a machine takes some seconds more", file=sys.stderr)


def write(folder, summary, said, watchers, data, recording, costs):
    """Write the result; return the names of its files, and the notes that it gives rise to."""
    doubts = notes(summary, data, recording)
    summary["notes"] = said + doubts
    history, kept = watchers.history, watchers.richest.kept
    with folder.results() as new:
        written = results.write(new, summary, history, data, recording, costs if recording else None, kept)
        written.append(watchers.replay.write(new))
        if watchers.recorder:
            written += results.write_recording(new, watchers.recorder, data.name, recording)
            written += results.write_record(new, history, watchers.innovations)
    return written, doubts


def smooth_next(options):
    """A sentence on the command that gives the path by all ranges: the filter's is what it knew as it went."""
    words = ["ekfslam", "smooth", options.scenario]
    for name in ("set", "models"):
        words += [word for value in getattr(options, name) for word in (f"--{name}", value)]
    for name in ("seed", "recording"):
        words += [f"--{name}", str(getattr(options, name))] if getattr(options, name) is not None else []
    return f"next: `{shlex.join(words)}` finds all poses by all ranges, the later ones too"


def notes_before(options, models, written, data, recording):
    """Remarks to be made before the run: of the recording, of what is not used of it, of settings without effect.

    `written` is the scenario as it was read; `data` has the robots of the recording.
    """
    again = lambda texts: read(argparse.Namespace(**vars(options) | {"set": texts}), models)
    return [
        *(recording.notes if recording else []),
        *(left_out(data, recording) if recording else []),
        *without_effect(options, again, written, recording),
    ]


def tell_notes(notes):
    """Print notes, a line each; return them."""
    for note in notes:
        print(f"note: {note}", file=sys.stderr)
    return notes


def not_compiled():
    """A sentence for what the run has computed without compiling."""
    from ..fast.compiled import left_out  # numba takes its time: not for every command

    return [f"not compiled, computed by numpy: {', '.join(left_out())}"] if left_out() else []


def read(options, models):
    """The scenario with the changes of the command line."""
    overrides = dict(parse_override(text) for text in options.set)
    if options.seed is not None:
        overrides["seed"] = options.seed
    if getattr(options, "camera", None) is not None:
        number = options.camera.isdecimal()
        overrides["data.camera" if number else "data.path"] = int(options.camera) if number else options.camera
    try:
        return UserData.from_toml(find_scenario(options.scenario), overrides, models)
    except TypeError as error:  # a sensor and a landmark type that do not go together
        raise ValueError(str(error)) from error


def source(options, data):
    """The recording to play: one that was named, or that of the scenario's data set; None for a simulation.

    Returns
    -------
    data : UserData
        With the robots of the data set.
    recording : Recording or None
    """
    if options.recording:
        return data, Recording.load(options.recording)
    return datasets.prepare(data)


def left_out(data, recording):
    """A sentence for the robots, and for the sensors, that a recording has and the scenario does not."""
    for kind, there, used in (("robot", recording.robots, data.robots), ("sensor", recording.raw, data.sensors)):
        ids = sorted(set(there) - {entry.id for entry in used})
        if ids:
            yield f"the recording has more {kind}s than the scenario; not used: {', '.join(map(str, ids))}"


def taken_up(options, out, data, recording, history):
    """The state to go on from, if the user wants to go on and something was kept."""
    if (options.resume or options.checkpoint is not None) and (options.movie or options.record or options.live):
        raise ValueError("a run that is kept on the way cannot also write --movie or --record, or be --live")
    if not options.resume:
        if options.checkpoint is not None and (out / KEPT).exists():
            kept = f"{out / KEPT} of an earlier run is written over"
            print(f"note: {kept}; --resume would go on with it", file=sys.stderr)
        return None
    if not (out / KEPT).exists():
        print(f"ekfslam run: no {out / KEPT}: from the beginning", file=sys.stderr)
        return None
    state = resume(out / KEPT, data, recording, history)
    print(f"ekfslam run: goes on after frame {state['frames']}", file=sys.stderr)
    return state


def consume(run, watchers, first=0):
    """Draw all snapshots and show them to the watchers; `first` of them were done before.

    Returns
    -------
    seconds : float
        Spent on the run itself, without the watchers.
    costs : list of float
        The same for each frame, but of this thread's processor: other programs do not count.
    interrupted : bool
        By Ctrl-C or SIGTERM; then the frames so far are complete.
    """
    seconds, costs, frames = 0.0, [], iter(run)
    with stopped_by_signal() as stop, bar(len(run), "frames", first) as done:
        while not stop.is_set():
            start, used = time.perf_counter(), computing_time()
            snapshot = next(frames, None)
            seconds += time.perf_counter() - start
            if snapshot is None:
                break
            costs.append(computing_time() - used)
            for watcher in watchers:
                watcher.add(snapshot)
            done.update()
        interrupted = stop.is_set() and done.n < len(run)
    if interrupted:
        print(f"ekfslam run: stopped after {done.n} of {len(run)} frames; these are written", file=sys.stderr)
    return seconds, costs, interrupted


ASK = "does each model of your own pass its test? EKFSLAM_TRACEBACK=1 shows where"


@contextmanager
def told_by_name(files):
    """Turn whatever is raised inside a model of one of these files into one sentence with its name.

    Everything else goes on as it is: a mistake of the package must show its traceback.
    """
    try:
        yield
    except Exception as error:
        method = method_of(error, files)
        if method is None:
            if files and not isinstance(error, ValueError | OSError):
                error.add_note("models of your own are in use: does each pass its test?")
            raise
        raise ValueError(f"{method} stops with {type(error).__name__}: {str(error).strip()}; {ASK}") from error


def method_of(error, files):
    """The method in one of these files, "MySonar.project", that the package called and that an error came out of."""
    paths = {str(Path(file)) for file in files}
    for frame, _ in traceback.walk_tb(error.__traceback__):
        if frame.f_code.co_filename in paths:
            model = frame.f_locals.get("self")
            return f"{type(model).__name__}.{frame.f_code.co_name}" if model is not None else frame.f_code.co_qualname
    return None


@contextmanager
def suspected(files):
    """Blame models of the user's own, where such are in use, for what goes wrong in a run: it is most likely theirs."""
    try:
        yield
    except ValueError as error:
        if not files or method_of(error, files):
            raise
        raise ValueError(f"{str(error).strip()}; {ASK}") from error


@contextmanager
def stopped_by_signal():
    """An event that Ctrl-C and SIGTERM set, so that a frame is finished first. The second one stops at once."""
    stop = threading.Event()
    if threading.current_thread() is not threading.main_thread():
        yield stop
        return

    def on_signal(*_):
        """Stop after this frame; at the second signal at once."""
        if stop.is_set():
            raise KeyboardInterrupt
        stop.set()

    before = {number: signal.signal(number, on_signal) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield stop
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def own_models(file):
    """The classes that a Python file of the user's defines. The file is executed: it is the user's own."""
    path = Path(file)
    if not path.is_file() or path.suffix != ".py":
        raise FileNotFoundError(f"no Python file {file}; `ekfslam new sensor NAME` writes one")
    loader = importlib.machinery.SourceFileLoader(path.stem, str(path))
    module = types.ModuleType(path.stem)
    module.__file__ = str(path)
    sys.modules[path.stem] = module  # dataclasses look their module up there
    try:
        loader.exec_module(module)
    except Exception as error:
        raise ValueError(f"{file} cannot be loaded: {type(error).__name__}: {error}") from error
    return [c for _, c in inspect.getmembers(module, inspect.isclass) if c.__module__ == path.stem]
