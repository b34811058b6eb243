"""A series of runs that can be stopped and taken up again: what is done, in one file, and nothing counted twice."""

import contextlib
import json
import time
from pathlib import Path

import numpy as np

from ..toolbox import identity
from ..toolbox.files.archives import brief, read_npz
from ..toolbox.files.writing import written

SAVE_EVERY = 5.0
"""Seconds between two savings."""


def run_seeds(seed, runs):
    """The seeds of the runs of a series. Run i has the same seed however many runs there are.

    Parameters
    ----------
    seed : int
        Of the series.
    runs : int

    Returns
    -------
    list of int
        Of 64 bits, from the children of `numpy.random.SeedSequence(seed)`.
    """
    children = np.random.SeedSequence(seed).spawn(runs)
    return [int(child.generate_state(1, np.uint64)[0]) for child in children]


class Series:
    """The runs of a series that are done.

    Parameters
    ----------
    data : UserData
    seeds : list of int
        Of all runs that there are to be.
    path : path, optional
        Where to keep what is done.
    """

    def __init__(self, data, seeds, path=None):
        self.seeds, self.path = seeds, None if path is None else Path(path)
        self.head = {"program": identity.program(), "seed": data.seed, "inputs": identity.of_scenario(data)}
        self.done = np.zeros(len(seeds), bool)
        self.failures, self._scores, self._saved = {}, {}, time.monotonic()

    def take(self, runs, scores, failures):
        """Note the scores of some runs, (len(runs), ...) each. What has been noted before is not noted again."""
        new = ~self.done[runs]
        for name, values in scores.items():
            if name not in self._scores:
                self._scores[name] = np.full((len(self.seeds), *values.shape[1:]), np.nan)
            self._scores[name][runs[new]] = values[new]
        self.done[runs] = True
        number = {self.seeds[run]: int(run) for run in runs}
        self.failures |= {number[seed]: why for seed, why in failures.items()}
        if self.path is not None and time.monotonic() - self._saved > SAVE_EVERY:
            self.save()

    def scores(self):
        """Numbers of the runs that are done, shape (R,), and their scores, (R, ...) each."""
        return np.flatnonzero(self.done), {name: values[self.done] for name, values in self._scores.items()}

    def save(self):
        """Write all that is done, in one step: whoever looks finds the old file or the new one."""
        if self.path is None:
            return
        runs, scores = self.scores()
        head = self.head | {"failures": self.failures, "wanted": len(self.seeds)}
        with written(self.path) as file:
            np.savez_compressed(file, allow_pickle=False, head=json.dumps(head), runs=runs, **scores)
        self._saved = time.monotonic()

    def load(self):
        """Take up what the file holds of this series; runs beyond its end are left out.

        Raises
        ------
        ValueError
            If the file holds another series, or none.
        """
        head, runs, scores = read(self.path)
        for key, what in ("program", "version of the program"), ("seed", "seed"):
            if head.get(key) != self.head[key]:
                raise ValueError(f"{self.path} holds runs of another {what}; give another folder, or do not resume")
        if what := identity.changed(head["inputs"], self.head["inputs"]):
            raise ValueError(
                f"{self.path} holds runs of another scenario, changed is: {what}; give another folder, or do not resume"
            )
        mine = runs < len(self.seeds)
        runs = runs[mine]
        failures = {self.seeds[int(run)]: why for run, why in head["failures"].items() if int(run) < len(self.seeds)}
        self.take(runs, {name: values[mine] for name, values in scores.items()}, failures)


def read(path):
    """Return what a file of a series holds: its head, the numbers of the runs, their scores.

    Raises
    ------
    ValueError
        Naming the file.
    """
    try:
        arrays = read_npz(path)
        head, runs = json.loads(str(arrays.pop("head"))), arrays.pop("runs")
        if not all(len(values) == len(runs) for values in arrays.values()) or "failures" not in head:
            raise KeyError("runs")
        return head, runs, arrays
    except FileNotFoundError:
        raise
    except Exception as error:  # a file of any kind may lie there
        raise ValueError(f"{path} is no file of Monte-Carlo runs, or it is damaged: {brief(error)}") from error


def unfinished(path):
    """Return True if a file is there that holds less runs than were wanted."""
    with contextlib.suppress(FileNotFoundError, ValueError):
        head, runs, _ = read(path)
        return len(runs) < head["wanted"]
    return False
