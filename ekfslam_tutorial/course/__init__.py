"""What only the notebooks need: exercises that are checked, widgets, figures with captions.

A notebook calls `check`, `hint`, `reveal`, `progress`, `keep`, `own`, `explore`, `show`, `replay` and `source`;
`take_home` and `take_up` carry a student's work from a browser to another computer. No estimation lives here: what a
notebook teaches is in the floors above.
"""

from .checks import check, hint, progress, reveal
from .controls import Choice, Float, Int, Toggle
from .experiment import experiment
from .figures import show
from .keep import keep, own
from .live import watch
from .playback import replay
from .source import source
from .widgets import explorable, explore, sweep
from .work import take_home, take_up

__all__ = [
    "Choice",
    "Float",
    "Int",
    "Toggle",
    "check",
    "experiment",
    "explorable",
    "explore",
    "hint",
    "keep",
    "own",
    "progress",
    "replay",
    "reveal",
    "show",
    "source",
    "sweep",
    "take_home",
    "take_up",
    "watch",
]
