"""The replay player: state logs of runs, and a small JavaScript module that plays them, in a notebook or on a page.

`StateLog` takes snapshots and gives JSON; `player_frame` and `write_player_html` put the log and the player into one
piece of HTML that needs no kernel and no network; `LivePlayer` shows a run while it goes on (it needs anywidget).
In a notebook, ``course.replay`` shows film strip, caption and player.
"""

from typing import TYPE_CHECKING

from .page import player_frame, player_html, player_module, player_options, write_player_html
from .state_log import StateLog
from .strip import log_caption, log_strip

if TYPE_CHECKING:
    from .live import LivePlayer

__all__ = [
    "LivePlayer",
    "StateLog",
    "log_caption",
    "log_strip",
    "player_frame",
    "player_html",
    "player_module",
    "player_options",
    "write_player_html",
]


def __getattr__(name: str):
    """Import `LivePlayer` only when it is asked for: anywidget need not be there for the rest."""
    if name == "LivePlayer":
        from .live import LivePlayer

        return LivePlayer
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
