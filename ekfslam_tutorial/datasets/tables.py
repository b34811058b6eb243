"""Tables of numbers in text files, read fast; when one is damaged the message names the file and the line."""

import io

import numpy as np


def read_table(source, name, columns, separator=None):
    """Read a text table of finite numbers; `#` starts a comment.

    Parameters
    ----------
    source : datasets.sources.Source
        Folder or zip.
    name : str
        Base name of the file.
    columns : sequence of str
        What the columns are, for example ("t [s]", "v [m/s]").
    separator : str, optional
        Between the columns; white space when not given.

    Returns
    -------
    ndarray, shape (n, len(columns))
        float64; n >= 1.

    Raises
    ------
    FileNotFoundError
        The file is missing.
    ValueError
        A line has the wrong number of columns or something that is not a finite number, or the file ends in the middle
        of a line or has no data at all.
    """
    text = source.read(name).decode("ascii", errors="replace")
    where = f"{source.path}: {name}"
    if not any(_tokens(line, separator) for line in text.splitlines()):
        raise ValueError(f"{where} has no line of data: is it cut off?")
    _check_end(text, where, separator)
    try:
        table = np.loadtxt(io.StringIO(text), delimiter=separator, ndmin=2)
    except ValueError as error:
        _check_lines(text, where, columns, separator)
        raise ValueError(f"{where}: {error}") from error
    if table.shape[1] != len(columns) or not np.isfinite(table).all():
        _check_lines(text, where, columns, separator)
    return table


def _tokens(line, separator):
    line = line.partition("#")[0].strip()
    return [w.strip() for w in line.split(separator)] if line else []


def _check_lines(text, where, columns, separator):
    """Find the first line that is wrong and say what is wrong with it."""
    for number, line in enumerate(text.splitlines(), start=1):
        words = _tokens(line, separator)
        if not words:
            continue
        if len(words) != len(columns):
            raise ValueError(
                f"{where}, line {number}: {len(columns)} columns wanted ({', '.join(columns)}), "
                f"{len(words)} found: {line.strip()[:80]!r}"
            )
        for word, column in zip(words, columns, strict=True):
            if not _is_finite(word):
                raise ValueError(f"{where}, line {number}: {column} is not a finite number: {word[:40]!r}")


def _is_finite(word):
    try:
        return bool(np.isfinite(float(word)))
    except ValueError:
        return False


def _check_end(text, where, separator):
    """A last line without an end was cut off if its last number has fewer decimals than the one above it.

    Whole numbers have no decimals; if all lines above have the same width, a shorter last line was cut off.
    """
    lines = text.splitlines()
    *above, last = [line.rstrip() for line in lines if _tokens(line, separator)]
    if text.endswith("\n") or not above:
        return
    decimals = [len(_tokens(line, separator)[-1].partition(".")[2]) for line in (above[-1], last)]
    fixed_width = not any(decimals) and len(above) > 2 and len({len(line) for line in above}) == 1
    if decimals[1] < decimals[0] or (fixed_width and len(last) < len(above[-1])):
        raise ValueError(
            f"{where}, line {len(lines)}: the file ends in the middle of a line: {last.strip()[:80]!r}; is it cut off?"
        )
