"""The time that a step takes, where the system can tell it and where it cannot."""

import time

from ekfslam_tutorial.toolbox.clock import computing_time


def test_sleeping_is_not_computing():
    began = computing_time()
    time.sleep(0.2)
    assert computing_time() - began < 0.1


def test_a_python_that_cannot_tell_takes_the_clock(monkeypatch):
    monkeypatch.delattr(time, "thread_time")
    before, now, after = time.perf_counter(), computing_time(), time.perf_counter()
    assert before <= now <= after
