"""Logs of anybody: files of any columns, and bags, become recordings.

Read from below: `tables.py` and `bags.py` read files as named columns, `meaning.py` says what the columns are,
`looks.py` says what is in them, `converting.py` makes a recording and a scenario of them.
"""

from .converting import Converted, convert

__all__ = ["Converted", "convert"]
