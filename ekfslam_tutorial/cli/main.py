"""The parser of the command line. The commands themselves are imported when they are called: `--version` is instant."""

import argparse
import importlib
import os
import sys

from .. import __version__

USER_ERRORS = (ValueError, OSError)  # told in one sentence; anything else is a mistake of ours
CHANGE = "change a key of the scenario: time.last=50, data.set=7, options.compiled=true; docs/scenarios.md has all"


def main(arguments=None):
    """Run one command.

    Parameters
    ----------
    arguments : list of str, optional
        Those of the command line if not given.

    Returns
    -------
    int
        Exit code: 0 done, 1 a problem was found, 2 wrong input, 130 stopped by Ctrl-C.
    """
    options = parser().parse_args(arguments)
    command = importlib.import_module(f".{options.module}", __package__)
    try:
        with threads(getattr(options, "threads", 1)):
            return command.main(options)
    except BrokenPipeError:  # the reader of our output has gone, as in `ekfslam data | head`
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except USER_ERRORS as error:
        if os.environ.get("EKFSLAM_TRACEBACK"):
            raise
        print(f"ekfslam {options.command}: {_sentence(error)}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print(f"ekfslam {options.command}: stopped", file=sys.stderr)
        return 130


def threads(n):
    """Linear algebra (BLAS) runs on so many threads inside: for small matrices one is faster than two."""
    from threadpoolctl import threadpool_limits  # it looks for the libraries that are loaded: those of the command

    return threadpool_limits(n, user_api="blas")


def _positive(text):
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"must be a number of threads, 1 or more, got {text!r}")
    return int(text)


def _sentence(error):
    if isinstance(error, OSError) and error.strerror:
        return f"{error.strerror}: {error.filename}" if error.filename else error.strerror
    return str(error)


def parser():
    """The argument parser with all commands."""
    top = argparse.ArgumentParser(
        prog="ekfslam",
        description="EKF mapping and EKF-SLAM: course and toolbox.",
        epilog="Linear algebra (BLAS) is limited to one thread; see `run --threads`.",
    )
    top.add_argument("--version", action="version", version=f"ekfslam {__version__}")
    commands = top.add_subparsers(title="commands", dest="command", required=True, metavar="COMMAND")
    for add in (_run, _tune, _monte_carlo, _data, _notebooks, _progress, _lecture, _nbgrader, _new, _evaluate, _doctor):
        add(commands)
    return top


def _command(commands, name, help, module=None, **more):
    command = commands.add_parser(name, help=help, description=help, **more)
    command.set_defaults(module=module or name)
    return command


def _run(commands):
    run = _command(commands, "run", "Run a scenario and write result.json, trajectory.csv, map.csv and figures.")
    run.add_argument("scenario", help="a TOML file, or the name of a scenario that comes with the package")
    run.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help=CHANGE)
    run.add_argument("--out", metavar="DIR", help="folder for the results; results/NAME if not given")
    run.add_argument("--seed", type=int, metavar="N", help="of everything random, instead of the scenario's")
    run.add_argument("--recording", metavar="PATH", help="play this recording (.npz or CSV folder), do not simulate")
    run.add_argument("--record", action="store_true", help="also write recording.npz, to be played again")
    run.add_argument("--movie", action="store_true", help="also write a movie of the run (MP4 with ffmpeg, else GIF)")
    run.add_argument("--live", action="store_true", help="show the figures while it runs")
    run.add_argument("--models", action="append", default=[], metavar="FILE.py", help="your own models, see `new`")
    run.add_argument(
        "--checkpoint", type=int, metavar="N", help="keep the run every N frames, to be resumed after a crash"
    )
    run.add_argument(
        "--resume",
        action="store_true",
        help="go on from the last checkpoint in the folder, to the same end; kept every N frames as before",
    )
    run.add_argument(
        "--threads", type=_positive, default=1, metavar="N", help="of the linear algebra (BLAS); default 1"
    )


def _tune(commands):
    help = "Find noise, mounting, clock and bias from a log alone; writes a scenario that `run` takes."
    tune = _command(commands, "tune", help)
    tune.add_argument("log", metavar="LOG", help="a scenario, TOML file or name; or a recording (.npz or CSV folder)")
    tune.add_argument(
        "--scenario", dest="models_of", metavar="NAME", help="of a recording: the scenario that it belongs to"
    )
    tune.add_argument("--recording", metavar="PATH", help="tune with this recording, instead of the scenario's data")
    tune.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help=CHANGE)
    tune.add_argument("--seed", type=int, metavar="N", help="of everything random, instead of the scenario's")
    tune.add_argument("--out", metavar="FILE.toml", help="scenario to write; results/NAME-tuned.toml if not given")
    tune.add_argument("--models", action="append", default=[], metavar="FILE.py", help="your own models, see `new`")


def _monte_carlo(commands):
    many = _command(
        commands, "monte-carlo", "Run a scenario with many seeds: errors, NEES and their bands.", "monte_carlo"
    )
    many.add_argument("scenario", help="a TOML file, or the name of a scenario that comes with the package")
    many.add_argument("--runs", type=int, required=True, metavar="N", help="how many runs")
    many.add_argument(
        "--workers", type=int, metavar="W", help="so many processes; as many as there are cores if not given"
    )
    many.add_argument("--dask", metavar="ADDRESS", help="run on the Dask cluster of this scheduler: tcp://HOST:8786")
    many.add_argument("--out", metavar="DIR", help="folder for the results; results/NAME-monte-carlo if not given")
    many.add_argument("--resume", action="store_true", help="go on with the series in that folder")
    many.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help=CHANGE)
    many.add_argument("--seed", type=int, metavar="N", help="of the whole series, instead of the scenario's")
    many.add_argument("--models", action="append", default=[], metavar="FILE.py", help="your own models, see `new`")


def _data(commands):
    help = "Say which data sets are here and verify them; or fetch, or import one."
    data = _command(commands, "data", help, usage="ekfslam data [-h] [--quick] [ACTION ...]")
    data.add_argument("--quick", action="store_true", help="do not read them to the end, only look for them")
    data.set_defaults(action=None)
    actions = data.add_subparsers(dest="action", metavar="ACTION", title="actions", prog="ekfslam data")
    fetch = actions.add_parser("fetch", help="Download a data set from its publisher; goes on where it broke off.")
    fetch.add_argument("name", metavar="NAME", help="as `ekfslam data` lists it: mrclam")
    fetch.add_argument(
        "--set", action="append", type=int, metavar="N", help="of mrclam: only this set; may be repeated"
    )
    bring = actions.add_parser("import", help="Check a data set that you got elsewhere and copy it to its place.")
    bring.add_argument("path", metavar="PATH", help="a zip, a folder or a file; it is recognised by its content")
    bring.add_argument("--force", action="store_true", help="replace what is there")
    for action in (fetch, bring):
        action.add_argument("--to", metavar="DIR", help="where to put it; the folder of EKFSLAM_DATA if not given")


def _notebooks(commands):
    notebooks = _command(commands, "notebooks", "Copy the notebooks, without outputs, to a folder of your own.")
    notebooks.add_argument("destination", metavar="DEST")


def _progress(commands):
    progress = _command(commands, "progress", "Say which exercises are done.")
    progress.add_argument("notebook", nargs="?", metavar="NN", help="only those of this notebook: 02")


def _lecture(commands):
    lecture = _command(commands, "lecture", "Open the lecture cut of a notebook in JupyterLab, or write it as slides.")
    lecture.add_argument("notebook", metavar="NN", help="its number: 02")
    lecture.add_argument("--slides", metavar="FILE.html", help="write slides that need no network and no Python")
    lecture.add_argument("--run", action="store_true", help="run the notebook anew for them: sharper pictures")
    lecture.add_argument(
        "--lab", nargs=argparse.REMAINDER, default=[], metavar="ARG", help="options of JupyterLab; last"
    )


def _nbgrader(commands):
    grade = _command(commands, "nbgrader", "Write a notebook as an assignment of an nbgrader course, checks included.")
    grade.add_argument("notebook", metavar="NN", help="its number: 02")
    grade.add_argument("course", metavar="COURSE", help="folder of the nbgrader course; written to source/ in it")


def _new(commands):
    new = _command(commands, "new", "Write a model of your own that works from the first minute, with its test.")
    new.add_argument("kind", choices=("sensor", "landmark", "motion"))
    new.add_argument("name", help="its name in small letters: my_sonar")
    new.add_argument("--dir", default=".", metavar="DIR", help="where to write it; here if not given")
    new.add_argument("--bare", action="store_true", help="methods without bodies: it stops where your code is needed")


def _evaluate(commands):
    evaluate = _command(
        commands, "evaluate", "Compare runs: their figures in one table, errors after alignment with the truth."
    )
    evaluate.add_argument("results", nargs="+", metavar="RESULT", help="a folder that `run` wrote, or its result.json")
    evaluate.add_argument("--robots", action="store_true", help="a line for each robot, too")
    evaluate.add_argument("--csv", action="store_true", help="all digits, separated by commas")


def _doctor(commands):
    _command(commands, "doctor", "Check the installation; a one-line cure for each problem.")
