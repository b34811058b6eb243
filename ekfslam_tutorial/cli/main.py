"""The parser of the command line. The commands themselves are imported when they are called: `--version` is instant."""

import argparse
import contextlib
import importlib
import os
import re
import signal
import sys
import threading
from pathlib import Path

from .. import __version__
from .terminal import near

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
        Exit code: 0 done, 1 a problem was found, 2 wrong input, 130 stopped by Ctrl-C or SIGTERM.
    """
    top = parser()
    if "_ARGCOMPLETE" in os.environ:  # the shell asks what may come next; see `ekfslam completion`
        import argcomplete

        argcomplete.autocomplete(top)
    options = top.parse_args(arguments)
    if options.command is None:
        top.print_help()
        return 0
    command = importlib.import_module(f".{options.module}", __package__)
    try:
        with terminated_like_ctrl_c(), threads(getattr(options, "threads", 1)):
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


@contextlib.contextmanager
def terminated_like_ctrl_c():
    """SIGTERM, as of a batch system whose time is over, keeps what Ctrl-C keeps."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


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


class Parser(argparse.ArgumentParser):
    """One that names the nearest word for a command or an option that it does not know."""

    def error(self, message):
        """Say what is wrong in a line or two, and stop."""
        choice = re.search(r"invalid choice: '([^']*)' \(choose from (.*)\)", message)
        strange = re.search(r"unrecognized arguments: (--[\w-]+)", message)
        if choice:
            message += near(choice[1], [word.strip(" '") for word in choice[2].split(",")])
        elif strange:
            message += near(strange[1], self.all_options())
        self.exit(2, f"{self.prog}: {message}\n{self.prog} --help says what is possible\n")

    def all_options(self):
        """The options of this parser and of all its commands."""
        words = {word for action in self._actions for word in action.option_strings}
        for action in self._actions:
            if isinstance(action, argparse._SubParsersAction):
                words.update(*(command.all_options() for command in action.choices.values()))
        return words


def _scenario(command, **more):
    """The argument that names a scenario; the shell completes its name, or that of a file."""
    action = command.add_argument("scenario", help="a TOML file, or the name of one in the package", **more)
    action.completer = _scenarios


def _scenarios(prefix, **_):
    from .files import scenarios

    return [*scenarios(), *map(str, Path().glob(f"{prefix}*"))]


def parser():
    """The argument parser with all commands."""
    top = Parser(
        prog="ekfslam",
        description="EKF mapping and EKF-SLAM: course and toolbox.",
        epilog="Linear algebra (BLAS) is limited to one thread; see `run --threads`.",
    )
    top.add_argument("--version", action="version", version=f"ekfslam {__version__}")
    commands = top.add_subparsers(title="commands", dest="command", metavar="COMMAND")
    course = _lab, _notebooks, _progress, _lecture, _nbgrader
    for add in (
        _run,
        _convert,
        _tune,
        _smooth,
        _graph,
        _export,
        _monte_carlo,
        _data,
        *course,
        _new,
        _evaluate,
        _audit,
        _doctor,
        _completion,
    ):
        add(commands)
    return top


def _command(commands, name, help, module=None, **more):
    command = commands.add_parser(name, help=help, description=help, **more)
    command.set_defaults(module=module or name)
    return command


def _run(commands):
    run = _command(commands, "run", "Run a scenario and write result.json, trajectory.csv, map.csv and figures.")
    _scenario(run, nargs="?")
    run.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help=CHANGE)
    run.add_argument("--out", metavar="DIR", help="folder for the results; results/NAME if not given")
    run.add_argument("--seed", type=int, metavar="N", help="of everything random, instead of the scenario's")
    run.add_argument("--recording", metavar="PATH", help="play this recording (.npz or CSV folder), do not simulate")
    run.add_argument("--record", action="store_true", help="also write recording.npz, to be played again, estimate.rec")
    run.add_argument("--movie", action="store_true", help="also write a movie of the run (MP4 with ffmpeg, else GIF)")
    run.add_argument("--live", action="store_true", help="show the figures while it runs")
    run.add_argument("--camera", metavar="N", help="live: watch camera N of this computer, 0, 1, ...; or a video file")
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


def _convert(commands):
    help = "Make a recording and a scenario of a log of any form: CSV, .mat, ROS bags, MCAP. Says first what it sees."
    convert = _command(commands, "convert", help)
    convert.add_argument("log", metavar="LOG", help="a file, a folder of files, or a bag")
    convert.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="ROLE.NAME=COLUMN",
        help="what a column means: odometry.v=speed, scan.range=dist, scan.angle_unit=deg; docs/your_log.md has all",
    )
    convert.add_argument("--plan", metavar="FILE.toml", help="the same, from the section [convert] of a file")
    convert.add_argument("--look", action="store_true", help="only say what is in the log; write nothing")
    convert.add_argument("--guess", action="store_true", help="leave the noise as it is guessed; it is found otherwise")
    convert.add_argument(
        "--tune", action="store_true", help="also find clock, mounting, bias, one factor: see `tune`; writes tuned.toml"
    )
    convert.add_argument("--name", metavar="NAME", help="of the scenario; that of the log if not given")
    convert.add_argument("--out", metavar="DIR", help="folder to write into; results/NAME-log if not given")


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


def _played(command):
    """Arguments of a command that runs a scenario and does something with the run."""
    _scenario(command)
    command.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help=CHANGE)
    command.add_argument("--seed", type=int, metavar="N", help="of everything random, instead of the scenario's")
    command.add_argument("--recording", metavar="PATH", help="play this recording (.npz or CSV folder)")
    command.add_argument("--models", action="append", default=[], metavar="FILE.py", help="your own models, see `new`")


def _smooth(commands):
    smooth = _command(commands, "smooth", "Smooth a run: all poses by all measurements, beside what the filter knew.")
    _played(smooth)
    smooth.add_argument("--lag", type=int, metavar="N", help="each pose by the measurements of N more frames only")
    smooth.add_argument("--out", metavar="DIR", help="folder for the results; results/NAME-smoothed if not given")


def _graph(commands):
    graph = _command(commands, "graph", "Write a run as a graph of poses and points, for g2o or GTSAM.")
    _played(graph)
    graph.add_argument("--to", choices=("g2o", "gtsam"), default="g2o", help="g2o if not given")
    graph.add_argument("--out", metavar="FILE", help="results/NAME.g2o, or results/NAME_gtsam.py, if not given")


def _export(commands):
    export = _command(commands, "export", "Write paths and map of a run for other programs: evo, Rerun, Foxglove.")
    _played(export)
    export.add_argument(
        "--to", choices=("tum", "kitti", "euroc", "rerun", "mcap"), default="tum", help="tum if not given"
    )
    export.add_argument(
        "--out", metavar="DIR", help="folder to write into; results/NAME-tum (or kitti, ...) if not given"
    )


def _monte_carlo(commands):
    many = _command(
        commands, "monte-carlo", "Run a scenario with many seeds: errors, NEES and their bands.", "monte_carlo"
    )
    _scenario(many)
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


def _lab(commands):
    lab = _command(commands, "lab", "Open JupyterLab on a copy of the notebooks of your own, at the first one.")
    lab.add_argument("folder", nargs="?", default="my_notebooks", metavar="DIR", help="my_notebooks if not given")
    lab.add_argument("--lab", nargs=argparse.REMAINDER, default=[], metavar="ARG", help="options of JupyterLab; last")


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


def _audit(commands):
    audit = _command(
        commands, "audit", "Is an estimator honest? Compare errors and covariances of any program with a truth."
    )
    add = audit.add_argument
    add("estimates", nargs="+", metavar="EST", help="poses with covariances: TUM, CSV, OpenVINS, .g2o, .rec of ours")
    add("--truth", nargs="+", metavar="FILE", help="true poses: one file for all, or one for each EST")
    add("--map", nargs="+", metavar="FILE", help="landmarks with covariances, for each EST: a CSV such as our map.csv")
    add("--true-map", nargs="+", metavar="FILE", help="their true places: id, x, y (z); one for all or for each")
    add("--innovations", nargs="+", metavar="FILE", help="columns t, z, upper triangle of Z; for each EST")
    add(
        "--axes",
        choices=("mixed", "body", "map"),
        default="mixed",
        help="what P is about; docs/audit.md",
    )
    add("--rotation-first", action="store_true", help="P begins with the angles, as in GTSAM's Pose3")
    add("--gauge", choices=("auto", "fixed", "start"), default="auto", help="is EST in the frame of the truth?")
    add("--gravity", action="store_true", help="of the angles of a free gauge only the heading is free")
    add("--robot", type=int, metavar="N", help="of a record with several")
    add("--max-dt", type=float, default=0.01, metavar="S", help="two stamps meet within so many seconds; default 0.01")
    add("--confidence", type=float, default=0.95, metavar="P", help="of the verdict; default 0.95")
    add("--out", metavar="DIR", help="folder for audit.json and audit.png; results/audit if not given")


def _doctor(commands):
    _command(commands, "doctor", "Check the installation; a one-line cure for each problem.")


def _completion(commands):
    shells = _command(commands, "completion", "Print what lets the Tab key of a shell complete words.")
    shells.add_argument("shell", choices=("bash", "zsh", "fish", "powershell"), nargs="?", default="bash")
