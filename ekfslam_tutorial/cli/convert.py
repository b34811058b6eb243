"""`ekfslam convert LOG`: a log of any form becomes a recording and a scenario; what was seen in it is said first."""

import argparse
import shlex
from pathlib import Path

from ..analysis.noise_fit import fit_noise
from ..analysis.progress import bar
from ..datasets.foreign import convert
from ..toolbox import parse_override
from ..toolbox.files.writing import written
from ..toolbox.scenario.reading import read_toml
from ..toolbox.scenario.writing import to_toml
from ..toolbox.user_input import errors_at
from . import tune
from .files import file_name, writable_folder


def main(options):
    """Run the command."""
    log = Path(options.log)
    name = options.name or file_name(log.resolve().stem)
    done = convert(log, plan(options), name)
    print("\n".join(done.said))
    if options.look:
        return 0
    out = Path(options.out or Path("results") / f"{name}-log")
    writable_folder(out)
    rings = done.scenario["landmark"].get("hypotheses")
    if rings and not options.guess:
        print("noise: stays as guessed, for with ranges alone each of many runs would carry rings of hypotheses")
    fitted = None if options.guess or rings else fit(done)
    made = fitted or done
    made.recording.save(out / "recording")
    scenario = out / "scenario.toml"
    with written(scenario, text=True) as file:
        file.write(head(options, fitted) + to_toml(made.scenario))
    print(f"written to {out}: recording, scenario.toml")
    if options.tune:
        words = {"log": str(out / "recording"), "models_of": str(scenario), "recording": None, "out": None}
        words |= {"set": [], "seed": None, "models": [], "out": str(out / "tuned.toml")}
        return tune.main(argparse.Namespace(**words))
    again = ["ekfslam", "run", str(scenario), "--recording", str(out / "recording")]
    print(f"next: {shlex.join(again)}", flush=True)
    return 0


def fit(done):
    """Find the noise by the likelihood of the log, and say what it was and is."""
    with bar(0, "runs") as runs:
        runs.tell("runs to find the noise")

        def after_run():
            runs.total += 1
            runs.update()

        fitted = fit_noise(done.scenario, done.recording, after_run, done.told)
    print(fitted)
    return fitted


def plan(options):
    """Words of the user about the columns: the section `[convert]` of a file, then the changes of the command line."""
    table = {}
    if options.plan:
        with errors_at(options.plan):
            table = read_toml(Path(options.plan)).get("convert")
            if not isinstance(table, dict):
                raise ValueError("it has no section [convert]")
    for text in options.set:
        key, value = parse_override(text)
        role, _, meaning = key.partition(".")
        if role == "space" and not meaning:
            table["space"] = value
            continue
        if not meaning and value is not False:
            raise ValueError(f"--set {text}: a column is named by ROLE.NAME=COLUMN, as in scan.range=distance")
        if not meaning:
            table[role] = False
            continue
        if not isinstance(table.get(role), dict):
            table[role] = {}
        table[role][meaning] = value
    return table


def head(options, fitted):
    """Comment at the beginning of the scenario: how it was made."""
    words = ["convert", options.log, *(word for text in options.set for word in ("--set", text))]
    words += ["--plan", options.plan] if options.plan else []
    lines = [f"Written by: ekfslam {shlex.join(words)}", "What the columns mean is in [convert]."]
    lines += str(fitted).splitlines() if fitted else ["Noise is a first guess, by the scatter of the log."]
    return "".join(f"# {line}\n" for line in lines) + "\n"
