"""Run code that may hang or flood the screen: with a deadline, its prints caught, on every operating system."""

from __future__ import annotations

import contextlib
import ctypes
import io
import itertools
import sys
import threading
import time
import warnings
from typing import Any

import numpy as np

NO_THREADS = sys.platform == "emscripten"  # Python in a browser
SLOWER = 5 if NO_THREADS else 1  # so much longer it may take there


class TookTooLong(Exception):
    """The deadline passed."""


class Stopped(SystemExit):
    """Put into a thread that must end. (Of all exceptions, Python lets a thread end silently by SystemExit only.)"""


def run(job, seconds):
    """Call `job` in a thread of its own and wait for at most `seconds`.

    On a busy computer these are seconds of the processor, for the thread may have to wait for it: up to four times as
    long (`BUSY`). A thread that sleeps is not waited for.

    Returns
    -------
    value
        What `job` returned.
    printed : str
        What it printed, cut at 2000 characters.

    Raises
    ------
    TookTooLong
        The thread is told to stop, on every operating system, by an exception inside it. A thread that
        cannot be stopped is a daemon: it does not keep Python from ending. Where there are no threads, in a
        browser, `job` is called here and looks at the clock itself (`HOW` says so to the student).
    Exception
        What `job` raised.
    """
    box: dict[str, Any] = {}

    def work(job=job):
        box["clock"] = _clock()
        try:
            with np.errstate(all="ignore"):
                box["value"] = job()
        except Stopped:
            pass
        except BaseException as error:
            box["error"] = error
        _finish(box)

    sink, began = _Sink(), time.monotonic()
    with _captured(sink), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        thread = threading.Thread(target=work, daemon=True)
        try:
            thread.start()
        except RuntimeError:  # Python in a browser has no threads
            work(lambda: _with_a_look_at_the_clock(job, seconds))
        else:
            thread.join(seconds)
            while thread.is_alive() and _kept_waiting(box.get("clock"), seconds, time.monotonic() - began):
                thread.join(seconds / 5)
            if thread.is_alive():
                _stop(thread, box)
                raise TookTooLong
    if "error" in box:
        raise box["error"]
    if "value" not in box:
        raise TookTooLong
    return box["value"], sink.getvalue()


BUSY = 4  # so many times as long a job may take where others have the processor, and more than 1 / 10 of it is its own


def _kept_waiting(clock, seconds, passed) -> bool:
    """Return True if a thread is at work, but has not had the processor for `seconds` of those that passed."""
    return passed < BUSY * seconds and passed / 10 < _at_work(clock) < seconds


def _clock():
    """The clock that counts how long the processor works for this thread; None where there is none, as on Windows."""
    try:
        return None if NO_THREADS else time.pthread_getcpuclockid(threading.get_ident())
    except (AttributeError, OSError):
        return None


def _at_work(clock) -> float:
    """Return for how long the processor has worked for a thread (s); of the whole of Python where it is not told."""
    try:
        return time.process_time() if clock is None else time.clock_gettime(clock)
    except OSError:  # the thread has just ended
        return time.process_time()


HOW = ", by a look at the clock at each turn of a loop: there are no threads here" if NO_THREADS else ""

_TOOL, _LOOKS = 4, 64  # a number that is free for tools like this one; events between two looks


def _with_a_look_at_the_clock(job, seconds):
    """Call `job`; after so many seconds, raise `Stopped` in it wherever a loop turns or a function of Python begins.

    One call of numpy that never ends cannot be stopped so. Python has this from 3.12 on.
    """
    watch = getattr(sys, "monitoring", None)
    if watch is None or watch.get_tool(_TOOL):  # or the job of another deadline, which goes on
        return job()
    end, count = time.monotonic() + seconds, itertools.count(1)

    def look(*_):
        if not next(count) % _LOOKS and time.monotonic() > end:
            raise Stopped

    events = watch.events.JUMP, watch.events.PY_START
    watch.use_tool_id(_TOOL, __name__)
    try:
        for event in events:
            watch.register_callback(_TOOL, event, look)
        watch.set_events(_TOOL, sum(events))
        return job()
    finally:
        watch.set_events(_TOOL, 0)
        for event in events:
            watch.register_callback(_TOOL, event, None)
        watch.free_tool_id(_TOOL)


_lock = threading.Lock()


def _finish(box):
    """Say that the thread needs no stopping any more, and swallow a `Stopped` that is under way."""
    while True:
        try:
            with _lock:
                box["finished"] = True
            for _ in range(100):  # Python looks for exceptions from outside when it jumps back in a loop
                pass
            return
        except Stopped:
            pass


def _stop(thread, box, patience=0.3):
    """Raise `Stopped` in the thread until it ends.

    Once is enough for most. A bare ``except:`` catches it; then again and again and fast, as sooner or later one is
    raised outside the `try`.
    """
    began = time.monotonic()
    interval = sys.getswitchinterval()
    while thread.is_alive() and time.monotonic() - began < patience:
        with _lock:
            if "finished" not in box:
                ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(thread.ident), ctypes.py_object(Stopped))
        if time.monotonic() - began < patience / 3:
            thread.join(0.02)
        else:
            sys.setswitchinterval(1e-5)
            time.sleep(0)
    sys.setswitchinterval(interval)
    if thread.is_alive():
        _survivors.add(thread)


_survivors: set[threading.Thread] = set()  # threads that could not be stopped: they stay silent
_streams: list[Any] = []  # what a survivor may be writing to: `print` crashes if that is freed meanwhile


@contextlib.contextmanager
def _captured(sink):
    """Send what is printed to `sink`; afterwards drop what surviving threads print."""
    before = sys.stdout, sys.stderr
    sys.stdout = sys.stderr = sink
    try:
        yield
    finally:
        sys.stdout, sys.stderr = map(_filtered, before)
        if isinstance(sys.stdout, _Muted):
            _streams.append(sink)


def _filtered(stream):
    """The stream, with a filter in front of it as long as a survivor lives."""
    stream = stream._stream if isinstance(stream, _Muted) else stream
    if not any(thread.is_alive() for thread in _survivors):
        return stream
    _streams.append(_Muted(stream))
    return _streams[-1]


class _Muted:
    """A stream that drops what surviving threads print and passes on everything else."""

    def __init__(self, stream):
        self._stream = stream

    def write(self, s):
        return len(s) if threading.current_thread() in _survivors else self._stream.write(s)

    def __getattr__(self, name):
        return getattr(self._stream, name)


class _Sink(io.StringIO):
    """Keeps the first 2000 characters that are printed and drops the rest."""

    def write(self, s):
        room = 2000 - self.tell()
        if room > 0 and threading.current_thread() not in _survivors:
            super().write(s[:room])
        return len(s)
