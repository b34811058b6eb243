"""The player as a live view in a notebook, through anywidget: it shows each snapshot as it comes."""

from __future__ import annotations

import uuid
from typing import Any

try:
    import anywidget
    import traitlets
except ImportError as error:
    raise ImportError(
        "LivePlayer needs the package anywidget: install it with `pip install anywidget`, start the kernel anew and "
        "reload the page. `replay(log)` shows a run without it, once the run is over"
    ) from error

from .page import HEIGHT, player_module, player_options
from .state_log import StateLog


class LivePlayer(anywidget.AnyWidget):
    """A player that is fed while the run goes on.

    Parameters
    ----------
    title : str
        What the run is.
    k : float
        Ellipses are drawn at k sigma.
    height : str
        Of the player, in CSS.
    **log_options
        ``period`` and ``align`` of `StateLog`.

    Attributes
    ----------
    state_log : StateLog
        What was shown; ``replay(player.state_log)`` keeps it in the stored notebook, where widgets do not run.

    Notes
    -----
    Every frame is sent complete, so that a frame that comes before the page is ready is lost without harm. When the
    run is over the page asks for what it has missed, and everything can be played again.

    Examples
    --------
    >>> live = LivePlayer("two rounds")
    >>> display(live)
    >>> for snapshot in universal_slam(userdata):
    ...     live.add(snapshot)
    """

    _esm = player_module()
    key = traitlets.Unicode().tag(sync=True)
    head = traitlets.Dict(allow_none=True, default_value=None).tag(sync=True)
    options = traitlets.Dict().tag(sync=True)
    height = traitlets.Unicode().tag(sync=True)

    def __init__(self, title: str = "", k: float = 3, height: str = HEIGHT, **log_options: Any):
        self.state_log = StateLog(title, k, **log_options)
        super().__init__(key=uuid.uuid4().hex, height=height)
        self.on_msg(lambda *_: self._send_all())

    def add(self, snapshot) -> None:
        """Show a snapshot and keep it in the log."""
        if self.state_log.add(snapshot) is None:
            return
        if self.head is None:
            self._begin()
        self.send({"frames": [self.state_log.whole(snapshot)], "total": len(self.state_log)})

    def _begin(self) -> None:
        head = self.state_log.to_dict(frames=False)
        self.options = player_options(head["dim"], self.state_log.k)
        self.head = head

    def _send_all(self) -> None:
        """Answer a page that has missed something."""
        self.send({"frames": self.state_log.records, "total": len(self.state_log), "whole": True})
