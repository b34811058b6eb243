"""What `check` says, so that pass and fail are told at a glance: by colour, by shape, and in words.

A notebook shows a bar and a mark beside the words; blue or vermillion, whole or broken, so that nobody needs to see
colours. The words alone are what is left in a pipe, and what viewers without styles show.
"""

from __future__ import annotations

import html
import os
import sys

from IPython.core.getipython import get_ipython
from IPython.display import display

from ..graphics.style import BLUE, VERMILLION

LOOK = {True: ("✓", BLUE, "solid", "34"), False: ("✗", VERMILLION, "dashed", "33")}
"""By the verdict: mark, colour and line in a notebook; colour of a terminal, by its ANSI number."""
PAGE = (
    '<div style="border-left: 6px {line} {colour}; padding: 2px 0 2px 10px">'
    '<pre style="white-space: pre-wrap; margin: 0"><b style="color: {colour}; font-size: 1.3em">{mark}</b> {text}</pre>'
    "</div>"
)


def tell(passed: bool, text: str):
    """Show a verdict as a notebook, a terminal or a pipe can show it.

    Parameters
    ----------
    passed : bool
    text : str
        All that is to be said, in lines.
    """
    shell = get_ipython()
    if shell is not None and type(shell).__name__ != "TerminalInteractiveShell":
        display({"text/plain": text, "text/html": page(passed, text)}, raw=True)
    else:
        print(coloured(passed, text) if colours() else text)


def page(passed: bool, text: str) -> str:
    """Return the verdict as HTML."""
    mark, colour, line, _ = LOOK[passed]
    return PAGE.format(mark=mark, colour=colour, line=line, text=html.escape(text))


def coloured(passed: bool, text: str) -> str:
    """Return the verdict for a terminal: its first line coloured, and a mark before it."""
    mark, _, _, number = LOOK[passed]
    first, *more = text.split("\n")
    return "\n".join([f"\x1b[1;{number}m{mark} {first}\x1b[0m", *more])


def colours() -> bool:
    """Return True if the output is a terminal with colours and with letters beyond ASCII; NO_COLOR forbids them."""
    encoding = getattr(sys.stdout, "encoding", None) or "ascii"
    return sys.stdout.isatty() and not os.environ.get("NO_COLOR") and encoding.lower().startswith("utf")
