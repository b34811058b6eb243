"""What a step costs: seconds of the processor, so that other programs do not count."""

import time


def computing_time() -> float:
    """Return the seconds that this thread has computed; only differences mean something.

    Python in a browser cannot know that: there it is the time on the clock.
    """
    return time.thread_time() if hasattr(time, "thread_time") else time.perf_counter()
