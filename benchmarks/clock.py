"""Timing: variants take turns, so that whatever else the machine does hits all of them alike.

Each variant gets short bursts, one after another, several rounds. The first step of a burst is not counted: it finds
the caches full of another variant's numbers. Counted are the seconds of CPU of this thread, and of the wall clock;
quick steps in batches, so that reading the clocks does not count either. The garbage collector rests meanwhile.
"""

import gc
import time
from contextlib import contextmanager
from dataclasses import dataclass, field

import numpy as np

BATCH_S = 3e-4  # steps are timed in batches of at least this duration


@dataclass
class Times:
    """Seconds for each step, CPU and wall; `weight` is how many steps each of the numbers is the mean of."""

    cpu: list = field(default_factory=list)
    wall: list = field(default_factory=list)
    weight: int = 1

    def add(self, run, n):
        """Time n calls of run()."""
        c, w = time.thread_time_ns(), time.perf_counter_ns()
        for _ in range(n):
            run()
        w, c = time.perf_counter_ns() - w, time.thread_time_ns() - c
        self.cpu.append(c * 1e-9 / n)
        self.wall.append(w * 1e-9 / n)

    def summary(self):
        """{cpu_us: {median, p10, mean, max}, wall_us: ..., steps}."""
        return {"cpu_us": statistics(self.cpu), "wall_us": statistics(self.wall), "steps": len(self.cpu) * self.weight}


def statistics(seconds):
    """Median, 10 % quantile, mean and maximum in microseconds."""
    us = 1e6 * np.asarray(seconds)
    return {
        "median": float(np.median(us)),
        "p10": float(np.quantile(us, 0.1)),
        "mean": float(us.mean()),
        "max": float(us.max()),
    }


@contextmanager
def quiet():
    """No garbage collection inside."""
    gc.collect()
    gc.disable()
    try:
        yield
    finally:
        gc.enable()


@dataclass
class Variant:
    """Something to time.

    Parameters
    ----------
    name : str
    make : callable
        Returns `step(k)`, a step of its own fresh filter. What it raises makes the variant a failed one.
    singly : bool
        Time each step alone, for steps that differ (a flush now and then).
    info : dict
        Goes into the result.
    """

    name: str
    make: object
    singly: bool = False
    info: dict = field(default_factory=dict)


class Stepper:
    """A variant's filter, and which step is the next."""

    def __init__(self, variant):
        self.variant, self._step, self.k = variant, variant.make(), 0
        self.times, self.first = Times(), 0.0

    def __call__(self):
        self._step(self.k)
        self.k += 1

    def once(self):
        """Seconds of one step that is not counted."""
        start = time.perf_counter()
        self()
        return time.perf_counter() - start

    def burst(self, seconds):
        """Steps for so long; one, if it takes longer than that."""
        if self.first > seconds:
            if len(self.times.cpu) < 3:
                self.times.add(self, 1)
            return
        end = time.perf_counter() + seconds
        self()
        while True:
            self.times.add(self, self.times.weight)
            if time.perf_counter() >= end:
                return


def compare(variants, budget, rounds=5, too_slow=3.0, expect=None):
    """Time variants side by side.

    Parameters
    ----------
    variants : list of Variant
    budget : float
        Seconds for each of them.
    rounds : int
    too_slow : float
        A variant that is expected to need more seconds for a step is not run.
    expect : callable, optional
        Variant name to seconds.

    Returns
    -------
    dict of str to dict
        Summary of each variant; {"skipped": reason} or {"failed": reason} instead.
    """
    results, running = {}, []
    with quiet():
        for variant in variants:
            seconds = expect(variant.name) if expect else 0.0
            if seconds > too_slow:
                results[variant.name] = {"skipped": f"about {seconds:.0f} s a step expected"} | variant.info
                continue
            try:
                stepper = Stepper(variant)
                stepper.first = stepper.once()
                if stepper.first < 0.02:
                    stepper.first = min(stepper.once() for _ in range(3))
                stepper.times.weight = 1 if variant.singly else max(1, int(BATCH_S / stepper.first))
                running.append(stepper)
            except Exception as error:
                results[variant.name] = {"failed": f"{type(error).__name__}: {error}"} | variant.info
        for _ in range(rounds):
            for stepper in running:
                stepper.burst(budget / rounds)
    for stepper in running:
        results[stepper.variant.name] = stepper.times.summary() | stepper.variant.info
    return {variant.name: results[variant.name] for variant in variants}
