"""`ekfslam evaluate RESULT...`: the figures of several runs in one table."""

import csv
import json
import math
import sys
from pathlib import Path

from ..toolbox.user_input import short_text
from . import terminal

COLUMNS = {
    "frames": "frames",
    "n_landmarks": "landmarks",
    "n_left_over": "without a true one",
    "ate_aligned_m": "ATE aligned m",
    "heading_rmse_deg": "heading deg",
    "landmark_rmse_aligned_m": "map aligned m",
    "dead_reckoning_ate_m": "dead reckoning m",
    "gps_rmse_best95_m": "best 95 % of GPS m",
    "nees_mean": "NEES",
    "nis_mean": "NIS",
    "wall_s": "time s",
}
"""Keys of result.json and the heads of their columns. Errors are those after alignment with the truth, so that runs can
be compared whatever their gauge; `run` says those of a fixed gauge as they are."""


def main(options):
    """Run the command."""
    runs = [read(path) for path in options.results]
    rows = [row for run in runs for row in table(*run, options.robots)]
    if options.csv:
        writer = csv.writer(sys.stdout, lineterminator="\n")
        writer.writerows([["run", *COLUMNS], *([name, *values] for name, values in rows)])
        return 0
    terminal.table([[name, *map(shown, values)] for name, values in rows], ["run", *COLUMNS.values()])
    return 0


def read(path):
    """Name and figures of a run: its folder, or its result.json.

    Raises
    ------
    FileNotFoundError, ValueError
        Naming the file.
    """
    file = Path(path) / "result.json" if Path(path).is_dir() else Path(path)
    if not file.is_file():
        raise FileNotFoundError(f"no result {file}; give folders that `ekfslam run` has written, or their result.json")
    try:
        figures = json.loads(file.read_text(encoding="utf-8"))
    except (json.JSONDecodeError, UnicodeDecodeError) as error:
        raise ValueError(f"{file} is not JSON: {error}") from error
    if not isinstance(figures, dict) or "frames" not in figures or not isinstance(figures.get("robots"), dict):
        raise ValueError(f"{file} is not the result of a run: it has no frames and robots")
    for part in ("the whole", figures), *((f"robot {id}", each) for id, each in figures["robots"].items()):
        check(file, *part)
    return file.parent.name or str(file), figures


def check(file, part, figures):
    """Refuse figures of a run, or of one of its robots, that are no table of numbers."""
    if not isinstance(figures, dict):
        raise ValueError(f"{file} is not the result of a run: {part} must be a table, got {short_text(figures)}")
    for key in COLUMNS:
        value = figures.get(key)
        if value is not None and (isinstance(value, bool) or not isinstance(value, int | float)):
            raise ValueError(f"{file}: {key} of {part} must be a number or null, got {short_text(value)}")


def table(name, figures, robots):
    """Rows of one run: the whole, and each robot if wanted; values that are not known are None."""
    parts = [(name, figures)]
    if robots:
        parts += [(f"  robot {id}", each) for id, each in figures["robots"].items()]
    return [(label, [part.get(key) for key in COLUMNS]) for label, part in parts]


def shown(value):
    """A number with three digits that count, or - where it is not known."""
    if value is None or (isinstance(value, float) and not math.isfinite(value)):
        return "-"
    return str(value) if isinstance(value, int) else f"{value:.3g}"
