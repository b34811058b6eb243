"""What one step consists of where the arithmetic is nothing: N = 10.

Each piece is timed by itself, on a filter of its own. Beside its time stands how many calls it makes, of Python
functions and of compiled ones: at this size a step is its calls.
"""

import sys

import numpy as np

from ekfslam_tutorial.fast import FastMap as Map
from ekfslam_tutorial.fast import (
    correct,
    correct_known_lmks,
    covariance,
    cross,
    init_new_lmks,
    innovation,
    move,
    predict,
)

from .clock import Variant, compare
from .ours import COMPILED, JointFilter, Step
from .world import R, U, lap

LMKS = 10


def pieces(m):
    """Names and functions of a step; each on its own filter."""
    world = lap(LMKS, m)

    def compiled(work):
        return lambda: work(ready(Step(world, Map(compiled=True), joint=True)))

    def plain(work):
        return lambda: work(ready(Step(world, Map(), joint=True)))

    def model():
        s = ready(Step(world, Map(), joint=True))
        x = s.rob.state(s.map)
        return lambda k: s.rob.motion.move(x, s.rob.u, 1.0)

    def predicted():
        f = JointFilter(world, Map())
        g = f.given[0]
        return lambda k: predict(f.map, f.rob, g.x, g.X_x, g.X_u, U)

    def equations():
        f = JointFilter(world, Map())
        g, blocks = f.given[0], ((f.rob, f.given[0].H_r), (f.rows[0], f.given[0].H_l))

        def run(k):
            PHt = cross(f.map, blocks)
            correct(f.map, PHt, innovation(g.z, covariance(PHt, blocks), R))

        return run

    def started():
        s = ready(Step(world, Map(), joint=True))
        new = list(range(m))
        return lambda k: init_new_lmks(s.map, s.rob, s.sen, s.lmks, s.raw[0], new, s.opt)

    def product():
        A = np.eye(3)
        return lambda k: A.dot(A)

    return {
        "whole step": plain(WORK["whole step"]),
        "1. move": plain(WORK["1. move"]),
        "of it: motion model with Jacobians": model,
        "of it: predict": predicted,
        "2. correct_known_lmks": plain(WORK["2. correct_known_lmks"]),
        "of it: cross, covariance, innovation, correct": equations,
        "3. init_new_lmks, nothing to start": started,
        **({f"{name}, compiled": compiled(work) for name, work in WORK.items()} if COMPILED else {}),
        "for comparison: one product of two 3 x 3 matrices": product,
    }


WORK = {
    "whole step": lambda s: s.step,
    "1. move": lambda s: lambda k: move(s.map, s.rob, 1.0),
    "2. correct_known_lmks": lambda s: (
        lambda k: correct_known_lmks(s.map, s.rob, s.sen, s.lmks, s.obs, s.raw[0], s.opt)
    ),
}


def ready(step):
    """A step that has been done once: the control is set, the landmarks are known."""
    step.step(0)
    return step


def calls(run):
    """How many calls run(1) makes: of Python functions, of compiled ones."""
    counts = {"call": 0, "c_call": 0}

    def count(frame, event, arg):
        if event in counts:
            counts[event] += 1

    run(0)
    sys.setprofile(count)
    try:
        run(1)
    finally:
        sys.setprofile(None)
    return max(counts["call"] - 1, 0), counts["c_call"] - 1  # without run itself, and without this setprofile


def run(budget):
    """Rows: m, piece, us (median), p10_us, calls, c_calls."""
    rows = []
    for m in (1, 10):
        makers = pieces(m)
        results = compare([Variant(name, make) for name, make in makers.items()], budget)
        for name, result in results.items():
            if "failed" in result:
                raise RuntimeError(f"{name}: {result['failed']}")
            python, compiled = calls(makers[name]())
            us = result["cpu_us"]
            rows.append(
                {"m": m, "piece": name, "us": us["median"], "p10_us": us["p10"], "calls": python, "c_calls": compiled}
            )
    return rows
