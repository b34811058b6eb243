"""Monte Carlo: the same scenario with many seeds, over as many processes or computers as there are."""

import pickle
from concurrent.futures import BrokenExecutor, Executor, as_completed, wait
from dataclasses import replace
from pathlib import Path

import numpy as np

from ..simulation import Streams
from ..toolbox import UserData
from ..toolbox.structures import create_sim_structures
from ..toolbox.universal_slam import universal_slam
from ..toolbox.user_input import check_id
from .batch_slam import why_not_batched
from .monte_carlo_result import MonteCarlo
from .progress import bar
from .run_scores import score_block
from .series import Series, run_seeds, unfinished

RUNS, BYTES = 250, 64e6
"""A block of runs that are made at once has so many runs at most, and covariances of so many bytes."""


def monte_carlo(scenario, runs, executor=None, *, seed=None, path=None, resume=False, progress=False):
    """Run a scenario with many seeds.

    Runs in the plane with one range-bearing sensor and known ids are made in blocks, all runs of a block at once (see
    `batch_slam`); others one by one. The numbers are the same, to the last bit, for any executor and any number of
    workers, and for a series that was stopped and taken up again.

    Parameters
    ----------
    scenario : UserData, or path of a scenario file
        A simulation. Its seed is that of the series; run i has the i-th seed of `run_seeds`, and is
        `universal_slam(data, seed=result.seeds[i])`.
    runs : int
    executor : concurrent.futures.Executor, optional
        Where to run them: a `ProcessPoolExecutor`, or `client.get_executor()` of Dask. Here, one after the other, if
        not given.
    seed : int, optional
        Instead of the scenario's.
    path : path, optional
        File (.npz) to keep what is done in, every few seconds and at the end.
    resume : bool
        Take up what the file holds.
    progress : bool
        Show a progress bar.

    Returns
    -------
    MonteCarlo
        After Ctrl-C it holds the runs that are done, and `complete` is False.

    Raises
    ------
    ValueError
        If the scenario plays a recording, cannot be run, or cannot be sent to other processes; if the file holds
        another series, or an unfinished one and `resume` is not given.
    ChildProcessError
        If a worker died and its executor cannot replace it. What was done is in the file.
    KeyboardInterrupt
        If Ctrl-C comes before the first run is done.
    """
    data = scenario if isinstance(scenario, UserData) else UserData.from_toml(scenario)
    data = data if seed is None else replace(data, seed=seed)
    _check(data, runs, executor)
    series = Series(data, run_seeds(data.seed, runs), path)
    if path is not None and not Path(path).parent.is_dir():
        raise FileNotFoundError(f"no folder {Path(path).parent} to keep the runs in")
    if resume and path is not None and Path(path).exists():
        series.load()
    elif path is not None and unfinished(path):
        raise ValueError(f"{path} holds an unfinished series: resume it, or take another place")

    with bar(runs, "runs", int(series.done.sum()), shown=progress) as done:
        try:
            _compute(data, series, executor, done)
        except KeyboardInterrupt:
            if not series.done.any():
                raise
        except BrokenExecutor as error:
            raise ChildProcessError(
                f"a worker process has died; {series.done.sum()} of {runs} runs are done"
                + (f" and kept in {path}: resume" if path else "")
            ) from error
        finally:
            if series.done.any():
                series.save()
    return _result(data, series)


def _check(data, runs, executor):
    """Refuse what cannot be run, before anything is."""
    check_id("runs", runs)
    if runs < 1:
        raise ValueError(f"runs must be a number of 1 or more, got {runs}")
    if executor is not None and not isinstance(executor, Executor):
        raise ValueError(
            f"the executor must be one of concurrent.futures, or client.get_executor() of Dask, got {executor!r}"
        )
    if data.data is not None:
        raise ValueError(f"the scenario plays the data set {data.data.name!r}: there is no chance in it, only one run")
    if type(executor).__name__ == "ProcessPoolExecutor":  # not imported for this: Python in a browser has no processes
        try:
            pickle.dumps(data)
        except Exception as error:
            raise ValueError(f"the scenario cannot be sent to other processes: {error}") from error
    next(universal_slam(data, seed=0))  # mistakes show up here, in one sentence, not in every worker


def _compute(data, series, executor, done):
    """All blocks that are not done yet."""
    together = why_not_batched(data) is None
    blocks = [b[~series.done[b]] for b in _blocks(data, len(series.seeds), together)]
    blocks = [b for b in blocks if len(b)]
    ask = lambda block: (data, [series.seeds[run] for run in block], together)

    def take(block, answer):
        series.take(block, *answer)
        done.update(len(block))

    if executor is None:
        for block in blocks:
            take(block, score_block(*ask(block)))
        return
    waiting = {executor.submit(score_block, *ask(block)): block for block in blocks}
    try:
        for future in as_completed(list(waiting)):
            take(waiting.pop(future), future.result())
    except BrokenExecutor:
        wait(waiting)  # all become broken, one after the other; cancelling one meanwhile stops the thread that does it
        raise
    finally:
        for future, block in waiting.items():
            if future.done() and not future.cancelled() and future.exception() is None:
                take(block, future.result())
            future.cancel()


def n_tasks(data, runs):
    """Count of the tasks that a series is divided into: more workers than that have nothing to do."""
    return 1 if data.data is not None else len(_blocks(data, runs, why_not_batched(data) is None))


def _blocks(data, runs, together):
    """Numbers of the runs that are made in one go, as arrays."""
    size = 1
    if together:
        n = 3 + 2 * len(create_sim_structures(data, Streams(0))[2].ids)
        size = int(np.clip(BYTES / (8 * n * n), 1, RUNS))
    return np.split(np.arange(runs), range(size, runs, size))


def _result(data, series):
    runs, scores = series.scores()
    return MonteCarlo(
        name=data.name,
        seed=data.seed,
        wanted=len(series.seeds),
        runs=runs,
        seeds=np.array([series.seeds[run] for run in runs], np.uint64),
        failures=dict(sorted(series.failures.items())),
        robots=[robot.id for robot in data.robots],
        dim=data.frame.dim,
        dof=data.frame.dof,
        t=data.time.dt * np.arange(1, scores["nees"].shape[1] + 1),
        **scores,
    )
