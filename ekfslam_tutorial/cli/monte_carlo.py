"""`ekfslam monte-carlo`: a scenario with many seeds, on all cores or on a cluster, stopped and taken up again."""

import csv
import json
import os
import signal
import sys
import time
from contextlib import contextmanager
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from ..analysis import monte_carlo
from ..analysis.monte_carlo import n_tasks
from ..graphics import monte_carlo_picture, use_style
from .files import ResultFolder, file_name, written
from .run import KEPT, own_models, read, told_by_name


def main(options):
    """Run the command."""
    if options.runs < 1:
        raise ValueError(f"--runs must be 1 or more, got {options.runs}")
    if options.workers is not None and options.workers < 1:
        raise ValueError(f"--workers must be 1 or more, got {options.workers}")
    if options.dask and (options.workers is not None or options.models):
        other = "--models: its workers do not have your file" if options.models else "--workers: it has its own"
        raise ValueError(f"--dask does not go with {other}")
    models = [cls for file in options.models for cls in own_models(file)]
    with told_by_name(options.models):
        return run_many(options, models)


def run_many(options, models):
    """Read, run all and write; return the exit code."""
    data = read(options, models)
    with ResultFolder(options.out or Path("results") / f"{file_name(data.name)}-monte-carlo") as folder:
        return run_into(folder, options, data)


def run_into(folder, options, data):
    """Run all and write; the folder is ours meanwhile."""
    out, start = folder.path, time.perf_counter()
    if (out / KEPT).exists():
        raise ValueError(f"{out} holds a run that was kept on the way: resume it, or take another folder")
    folder.announce("runs.npz")
    with _executor(options, data) as executor:
        path = out / "runs.npz"
        result = monte_carlo(data, options.runs, executor, path=path, resume=options.resume, progress=True)
    summary, seconds = result.summary(), time.perf_counter() - start
    if not result.complete:
        print(
            f"ekfslam monte-carlo: stopped after {len(result.runs)} of {result.wanted} runs; --resume goes on",
            file=sys.stderr,
        )
    with folder.results() as new:
        names = [*write(new, result, summary), "runs.npz"]
    folder.keep(*names)
    print(f"{sentence(summary)}, {seconds:.1f} s")
    print(f"written to {out}: {', '.join(names)}", flush=True)
    return 0 if result.complete else 130


@contextmanager
def _executor(options, data):
    """Return where to run: on a cluster, in processes of our own, or here (None) for one worker or one task."""
    if options.dask:
        with _dask(options.dask) as client:
            yield client.get_executor(pure=False)
        return
    workers = min(options.workers or _cores(), n_tasks(data, options.runs))
    if workers == 1 or sys.platform == "emscripten":  # Python in a browser: there is no process but this one
        yield None
        return
    from concurrent.futures import ProcessPoolExecutor

    from .workers import Workers

    context = Workers()
    try:
        with ProcessPoolExecutor(workers, context, initializer=_begin, initargs=(options.models,)) as pool:
            try:
                yield pool
            except ChildProcessError:
                context.end()  # leaving the pool would wait for ever for a worker that began when another one died
                raise
    finally:
        context.end()  # a worker that dies while the pool is left takes the pool's thread with it, not the others


def _begin(models):
    """A worker begins: Ctrl-C is for the parent, also on Windows; the user's own models are known here, too."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    for file in models:
        own_models(file)


def _cores():
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _dask(address):
    try:
        from distributed import Client
    except ImportError as error:
        raise ValueError(
            "--dask needs the package distributed: python -m pip install 'ekfslam_tutorial[cluster]'"
        ) from error
    try:
        return Client(address, timeout="10s")
    except OSError as error:
        raise OSError(f"no Dask scheduler answers at {address}") from error


def write(out, result, summary):
    """Write all files; each appears whole or not at all. Returns their names."""
    with written(out / "monte_carlo.json", text=True) as file:
        file.write(json.dumps(summary, indent=2, allow_nan=False) + "\n")
    rows = result.per_run()
    _csv(out / "runs.csv", list(rows[0]), [["" if v is None else v for v in row.values()] for row in rows])
    _csv(out / "over_time.csv", *over_time(result))
    use_style(dpi=100)
    several = len(result.robots) > 1
    pictures = {id: f"monte_carlo-{id}.png" if several else "monte_carlo.png" for id in result.robots}
    for id, name in pictures.items():
        fig = monte_carlo_picture(result, id)
        with written(out / name) as file:
            fig.savefig(file, format="png")
        plt.close(fig)
    return ["monte_carlo.json", "runs.csv", "over_time.csv", *pictures.values()]


def over_time(result):
    """Header and rows of over_time.csv: one row for each frame and robot; m, rad."""
    low, high = result.band()
    names = ("position", "position_std", "heading", "heading_std", "nees")
    columns = [result.over_time(name) for name in names]
    header = [
        "t",
        "robot",
        "rmse_m",
        "sigma_m",
        "heading_rmse_rad",
        "heading_sigma_rad",
        "nees",
        "band_low",
        "band_high",
    ]
    blank = lambda v: float(v) if np.isfinite(v) else ""
    rows = (
        [float(t), id, *(blank(column[i, k]) for column in columns), low, high]
        for i, t in enumerate(result.t)
        for k, id in enumerate(result.robots)
    )
    return header, rows


def _csv(path, header, rows):
    with written(path, text=True) as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        writer.writerows(rows)


def sentence(s):
    """The figures of all runs in one line."""
    words = [
        f"{s['runs']} runs of {s['frames']} frames",
        f"RMSE {s['rmse_m']:.3g} m" if s["rmse_m"] is not None else "",
    ]
    if s["landmark_rmse_m"] is not None:
        words.append(f"landmark RMSE {s['landmark_rmse_m']:.3g} m")
    if s["nees_mean"] is not None:
        low, high = s["nees_band"]
        words.append(
            f"NEES {s['nees_mean']:.2f} ({s['nees_dof']} wanted; in its {100 * s['nees_confidence']:g} % band, "
            f"{low:.2f} to {high:.2f}, in {100 * s['nees_in_band']:.0f} % of the frames)"
        )
    if s["failed"]:
        words.append(f"{s['failed']} runs failed")
    return f"{s['scenario']}: {', '.join(word for word in words if word)}"
