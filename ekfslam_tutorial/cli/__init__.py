"""The command line: `ekfslam ...`.

Lives here: one module for each command, and what they share: shipped files, output folders, safe writing.
May not: mathematics; every command is a consumer of the floors above.
"""

from .main import main

__all__ = ["main"]
