"""A run in a notebook: a film strip and a caption for every reader, and the player for those with a browser."""

from __future__ import annotations

from collections.abc import Sequence

from IPython.display import display

from ..graphics.player import StateLog, log_caption, log_strip, player_frame
from .figures import one_line, show


def replay(log: StateLog, caption: str = "", n: int = 3, at: Sequence[int] = (), strip=None):
    """Show a run: film strip, caption, player.

    Parameters
    ----------
    log : StateLog
        ``log = StateLog("two rounds")``, then ``log.add(snapshot)`` for each snapshot of the run.
    caption : str
        Said before the caption that is computed from the log.
    n : int
        Pictures of the film strip, evenly spaced.
    at : sequence of int, optional
        Numbers of the frames in the strip, instead.
    strip : matplotlib Figure, optional
        A film strip of your own, where the one that is drawn from the log would be too full.

    Notes
    -----
    Strip and caption are plain outputs, which every viewer of notebooks shows. The player is HTML with everything
    inside: it works without a kernel and without a network, wherever a notebook's scripts run (JupyterLab and Notebook
    once the notebook is trusted, that is, run; nbviewer; HTML pages). The tests of the notebooks compare the caption,
    not the numbers inside the player, which may differ in the last digit from computer to computer.
    """
    show(strip or log_strip(log, n, at=at), one_line(f"{caption} {log_caption(log)}"))
    plain = f"Player: {log.title or 'replay'}, {len(log)} frames. It shows where a notebook's scripts run."
    display({"text/html": player_frame(log), "text/plain": plain}, raw=True)
