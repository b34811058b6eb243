"""A bar for long work: how much is done, how quickly it goes, and how long it will still take."""

from __future__ import annotations

import sys
import time
from contextlib import contextmanager

EVERY = 0.1  # seconds between two drawings of a bar


class Bar:
    """Progress of some work. `shown` draws it; without, it only counts."""

    def __init__(self, total: int, what: str, n: int = 0, shown=None):
        self.total, self.what, self.n, self._shown, self._drawn = total, what, n, shown, 0.0

    def tell(self, what: str):
        """Say what is being done now."""
        self.what = what
        self.update(0)

    def update(self, n: int = 1):
        """Say that n more are done."""
        self.n += n
        if self._shown is not None and (time.monotonic() - self._drawn > EVERY or self.n >= self.total):
            self._shown(self)
            self._drawn = time.monotonic()


@contextmanager
def bar(total: int, what: str, done: int = 0, shown: bool = True):
    """Show a bar on the terminal while the block runs; where nobody watches, in a pipe, one plain line at its end.

    Parameters
    ----------
    total : int
        How many there are to do; it may be corrected on the way.
    what : str
        Of what: "frames".
    done : int
        How many were done before.
    shown : bool
        False counts and shows nothing.

    Yields
    ------
    Bar
    """
    if not shown:
        yield Bar(total, what, done)
        return
    from rich.console import Console  # a tenth of a second: not for those who need no bar

    console = Console(stderr=True, force_jupyter=False)
    if not console.is_terminal:
        plain = Bar(total, what, done)
        try:
            yield plain
        finally:
            print(f"{plain.what}: {plain.n}/{plain.total}", file=sys.stderr)
        return
    with columns(console) as progress:
        task = progress.add_task(what, total=total, completed=done)

        def draw(bar):
            progress.update(task, description=bar.what, completed=bar.n, total=bar.total, refresh=True)

        drawn = Bar(total, what, done, draw)
        draw(drawn)
        try:
            yield drawn
        finally:
            draw(drawn)


def columns(console):
    """Return what rich shows of a bar, on one line of 80 columns. No thread draws it: long work is not disturbed."""
    from rich import progress as p

    words = p.TextColumn("{task.description:9}"), p.BarColumn(24), p.MofNCompleteColumn(), speed()
    return p.Progress(*words, p.TimeRemainingColumn(compact=True), console=console, auto_refresh=False)


def speed():
    """Return the column that says how many are done in a second."""
    from rich.progress import ProgressColumn
    from rich.text import Text

    class Speed(ProgressColumn):
        """Count of what is done in a second."""

        def render(self, task):
            """Return the speed, once it is known."""
            known = task.finished_speed or task.speed
            return Text(f"{known:,.0f} /s" if known else "", style="progress.data.speed")

    return Speed()
