"""`ekfslam tune`: noise, mounting, clock and bias from a log alone, written as a scenario that `run` takes."""

import shlex
from pathlib import Path

import numpy as np

from ..analysis.notes import MOUNTING
from ..analysis.progress import bar
from ..analysis.tuning import BLIND, Stopped, tune
from ..toolbox import parse_override
from ..toolbox.scenario.overrides import override
from ..toolbox.scenario.reading import read_toml
from ..toolbox.scenario.writing import to_toml
from .files import file_name, find_scenario, replacing, writable_folder
from .run import own_models, read, source, stopped_by_signal, tell_notes, told_by_name


def main(options):
    """Run the command."""
    log = Path(options.log)
    if log.suffix == ".npz" or (log.is_dir() and (log / "recording.json").exists()):
        if options.recording or not options.models_of:
            raise ValueError(f"{log} is a recording; which models it belongs to says --scenario NAME")
        options.recording, options.scenario = str(log), options.models_of
    else:
        options.scenario = options.log
    models = [cls for file in options.models for cls in own_models(file)]
    with told_by_name(options.models):
        return tune_scenario(options, models)


def tune_scenario(options, models):
    """Read, tune and write; return the exit code."""
    written = read(options, models)
    data, recording = source(options, written)
    name = f"{written.name} tuned"
    out = Path(options.out or Path("results") / f"{file_name(written.name)}-tuned.toml")
    if out.suffix != ".toml":
        raise ValueError(f"--out names the scenario file to write, NAME.toml, got {out}")
    writable_folder(out.parent)
    tell_notes(recording.notes if recording else ["no log: the scenario is simulated, and its simulation is tuned"])

    with stopped_by_signal() as stop, bar(0, "frames") as done:
        found = tune(data, recording, Progress(stop, done))
    print("\n".join(report(found)))
    if not np.isfinite(found.factor):
        return 130 if not found.complete else 0
    changes = parts(found, data)
    with replacing(out) as part:
        part.write_text(head(options, found) + to_toml(scenario(options, name, changes)), encoding="utf-8")
    again = ["ekfslam", "run", str(out), *(["--recording", options.recording] if options.recording else [])]
    again += [word for file in options.models for word in ("--models", file)]
    print(f"written to {out}; next: {shlex.join(again)}", flush=True)
    return 0 if found.complete else 130


class Progress:
    """A bar for all runs; Ctrl-C ends the search after a frame."""

    def __init__(self, stop, done):
        self.stop, self.done = stop, done

    def __call__(self, name, n_frames):
        """Begin a run."""
        self.done.total += n_frames
        self.done.tell(f"frames, {name}")

        def after_frame():
            self.done.update()
            if self.stop.is_set():
                raise Stopped

        return after_frame


def parts(found, data):
    """Changes of the entries of a scenario: {"sensor": {...}, "robot": {...}}."""
    sensor = found.sensor | {"noise_factor": round(found.factor * data.sensors[0].noise_factor, 4)}
    robot = found.robot | {"noise_factor": round(found.factor * data.robots[0].noise_factor, 4)}
    return {"sensor": sensor, "robot": robot}


def scenario(options, name, changes):
    """The scenario's tables with the changes of the command line, and with what was found."""
    table = {"name": name} | read_toml(find_scenario(options.scenario)) | {"name": name}
    for key, value in map(parse_override, options.set):
        override(table, key, value)
    for part, values in changes.items():
        for key, value in values.items():
            override(table, f"{part}.{key}", value)
    return table


def head(options, found):
    """Comment at the beginning of the file: where it comes from, what was found, how sure."""
    words = ["tune", options.log, *(word for text in options.set for word in ("--set", text))]
    return "".join(f"# {line}\n" for line in [f"Written by: ekfslam {shlex.join(words)}", *report(found)]) + "\n"


def report(found):
    """Lines that say what was found, how sure, and what nobody looked at."""
    lines = [str(finding) for finding in found.findings]
    if np.isfinite(found.factor):
        low, high = found.band
        lines.append(f"R and U times {found.factor:.3g} ({low:.2g} to {high:.2g} in 95 %), by {found.by}")
    else:
        lines.append(f"no factor for R and U: {found.by or 'stopped before the first run was over'}")
    if found.before is not None and np.isfinite(found.before.value):
        after = f", now {found.after.value:.2f}" if found.after is not None else ""
        lines.append(f"correction ratio, 1 is right: {found.before.value:.2f} as it was{after}")
    if found.after is not None and found.after.too_large:
        lines.append(f"what was kept does not explain the log, so do not trust it: {MOUNTING}")
    if np.isfinite(found.nis).all() and found.expected:
        lines.append(f"NIS, {found.expected:.2g} is expected: {found.nis[0]:.2f} as it was, now {found.nis[1]:.2f}")
    if not found.complete:
        lines.append("stopped: what was found so far; the same command looks for the rest, from the beginning")
    return [*lines, f"blind to: {'; '.join(BLIND)}"]
