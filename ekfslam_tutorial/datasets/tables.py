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
        of a number or has no data at all.
    """
    text = source.read(name).decode("ascii", errors="replace")
    where = f"{source.path}: {name}"
    if not any(_tokens(line, separator) for line in text.splitlines()):
        raise ValueError(f"{where} has no line of data: is it cut off?")
    _check_end(text, where)
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


def _check_end(text, where):
    """These files write every number with the same decimals: a last line without an end and with fewer was cut off."""
    if text.endswith("\n"):
        return
    *_, before, last = ["", *text.splitlines()]
    decimals = [len(line.rstrip().rpartition(".")[2]) for line in (before, last)]
    if not before.lstrip().startswith("#") and "." in before and decimals[1] < decimals[0]:
        number = len(text.splitlines())
        raise ValueError(f"{where}, line {number}: the file ends in the middle of a number: {last.strip()!r}")
