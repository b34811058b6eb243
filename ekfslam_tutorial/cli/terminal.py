"""What the command line shows: colour and tables on a terminal; in a pipe, or with NO_COLOR, the same as plain text."""

import difflib
import sys

WIDE = 10_000  # columns of a pipe: nothing is broken there
GAP = 2  # columns between two of a table


def console(stderr=False):
    """A console of rich on the standard output, or on that of errors."""
    from rich.console import Console  # here, not above: `--version` and completion wait for nothing

    made = Console(stderr=stderr, highlight=False, force_jupyter=False)
    if not made.is_terminal:
        made.width = WIDE
    return made


def say(text, style=""):
    """Print a line in a style: "bold", "green", "dim"."""
    console().print(text, style=style, markup=False, soft_wrap=True)


def table(rows, head=(), styles=(), cut=False):
    """Print rows in columns: the first to the left, and under a head the others, numbers, to the right.

    Where they do not fit on the terminal, columns become rows.

    Parameters
    ----------
    rows : list of list of str
    head : list of str
        It may be broken between words; a cell is never broken.
    styles : sequence of str
        Of the columns.
    cut : bool
        The last column is text whose end is cut where there is no room.
    """
    from rich import box
    from rich.table import Table
    from rich.text import Text

    to = console()
    columns = list(zip(*([head] if head else []), *rows, strict=True))
    if head and sum(map(least, columns)) + GAP * len(columns) > to.width:
        head, *rows = columns  # one column for each row of before
        columns = list(zip(head, *rows, strict=True))
    drawn = Table(box=box.SIMPLE_HEAD if to.is_terminal and head else None, pad_edge=False, show_header=bool(head))
    for k, cells in enumerate(columns):
        wide = None if cut and k == len(columns) - 1 else least(cells) if head else max(map(len, cells))
        side = {"justify": "right" if head and k else "left", "style": styles[k] if k < len(styles) else None}
        drawn.add_column(head[k] if head else "", min_width=wide, no_wrap=cut, overflow="ellipsis", **side)
    for row in rows:
        drawn.add_row(*map(Text, row))
    with to.capture() as captured:
        to.print(drawn)
    lines = captured.get().splitlines()
    sys.stdout.write("".join(f"{line.rstrip()}\n" for line in lines if line.strip()))


def least(cells):
    """The width that a column needs: that of its widest cell, or of the longest word of its head."""
    head, *cells = cells
    return max(map(len, [*head.split(), *cells]), default=0)


def near(word, known):
    """'; did you mean ...?' if one of the known words is near, else nothing."""
    close = difflib.get_close_matches(word, list(known), n=1, cutoff=0.5)
    return f"; did you mean {close[0]}?" if close else ""
