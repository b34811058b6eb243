"""Logs of anybody: files of any columns, and bags, become recordings.

Read from below: `tables.py` and `bags.py` read files as named columns, `meaning.py` says what the columns are,
`looks.py` says what is in them, `log.py` has their columns in SI units; `driving.py`, `heading.py` and `scans.py` make
controls and measurements of them, `fleet.py` and `members.py` part several robots, `converting.py` makes a recording
and a scenario.
"""

from .converting import Converted, convert

__all__ = ["Converted", "convert"]
