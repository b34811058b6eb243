"""Limits of time in seconds of the computer that they were measured on: a busy or a slow one gets more of its own.

The processor's time alone does not help enough: beside programs that use the same core and the same memory, the same
work takes up to twice as much of it.
"""

import time

import numpy as np

QUIET = 0.032
"""Processor seconds of `work` on two quiet cores of the computer on which the limits in the tests were measured."""


def work():
    """A bit of all that this package does: small matrices, numbers one by one, and memory far beyond the caches."""
    A, seen, far = np.eye(6) + 0.1, {}, np.ones(2_000_000)
    for i in range(6000):
        B = A @ A.T
        A = B / B.max()
        seen[i % 50] = seen.get(i % 50, 0.0) + float(A[0, 1]) * sum(range(20))
    for _ in range(6):
        far = far + far[::-1]
    return far, seen


def seconds_of(call):
    """Return what `call` returns, and the seconds of the processor that it took."""
    start = time.process_time()
    result = call()
    return result, time.process_time() - start


def slowness():
    """Return how many times longer this computer takes at present than when it was quiet, at least 1."""
    return max(1.0, seconds_of(work)[1] / QUIET)


class Watch:
    """What is done inside `with` took so many `seconds` of the processor of a quiet computer."""

    def __enter__(self):
        self.slow, self.start = [slowness()], time.process_time()
        return self

    def __exit__(self, *error):
        took = time.process_time() - self.start
        self.slow.append(slowness())
        self.seconds = took / np.mean(self.slow)


def within(limit, call, goes=3):
    """Return what `call` returns; fail if it never takes at most so many seconds of a quiet computer in a few goes."""
    took = []
    for _ in range(goes):
        result, seconds = seconds_of(call)
        if seconds <= limit or seconds <= limit * slowness():
            return result
        took.append(f"{seconds:.2f}")
    raise AssertionError(f"it took {' and '.join(took)} s of the processor, allowed are {limit} s")
