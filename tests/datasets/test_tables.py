"""Text tables: what is read, and what is said about a file that is damaged."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ekfslam_tutorial.datasets.sources import Source
from ekfslam_tutorial.datasets.tables import read_table

COLUMNS = ("t [s]", "v [m/s]", "w [rad/s]")


class Text:
    """A source of one file, in memory."""

    path = "folder"

    def __init__(self, text):
        self.text = text if isinstance(text, bytes) else text.encode()

    def read(self, name):
        return self.text


def read(text, columns=COLUMNS, separator=None):
    return read_table(Text(text), "a.dat", columns, separator)


def test_comments_blank_lines_and_any_white_space():
    table = read("# head\n\n1.0 \t 2.0   3.0\r\n  -4 5e-1 6 # the end\n")
    np.testing.assert_array_equal(table, [[1, 2, 3], [-4, 0.5, 6]])


def test_separator():
    np.testing.assert_array_equal(read("# t,v,w\n1,2, 3\n4,5,6", separator=","), [[1, 2, 3], [4, 5, 6]])


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("# head\n1 2 3\n4 5\n7 8 9\n", 3, ["3 columns wanted", "t [s], v [m/s], w [rad/s]", "2 found", "'4 5'"]),
        ("1 2 3\n4 5 6 7\n", 2, ["4 found"]),
        ("1 2\n3 4\n", 1, ["2 found"]),
        ("1 2 3 4\n5 6 7 8\n", 1, ["4 found"]),
        ("1 2\n3\n4 5 6\n", 1, ["2 found"]),
        ("1 2 3\n4 five 6\n", 2, ["v [m/s] is not a finite number", "'five'"]),
        ("1 2 3\n\n4 5 nan\n", 3, ["w [rad/s] is not a finite number", "'nan'"]),
        ("inf 2 3\n", 1, ["t [s] is not a finite number"]),
        ("1 2 3\n4 \x00\x01 6\n", 2, ["v [m/s] is not a finite number"]),
        ("1.000 2.000 3.000\n4.000 5.000 6.0", 2, ["ends in the middle of a line", "'4.000 5.000 6.0'"]),
        ("1.000 2.000 13.000\n4.000 5.000 1", 2, ["ends in the middle of a line"]),
        (b"1 2 3\n4 5 \xff\xfe\n", 2, ["w [rad/s] is not a finite number"]),
    ],
)
def test_a_damaged_line_is_named(text, line, words):
    with pytest.raises(ValueError) as error:
        read(text)
    message = str(error.value)
    assert message.startswith(f"folder: a.dat, line {line}: ")
    assert "\n" not in message
    for word in words:
        assert word in message


@pytest.mark.parametrize("text", ["", "\n\n", "# only\n# comments\n"])
def test_a_file_without_data(text):
    with pytest.raises(ValueError, match=r"folder: a\.dat has no line of data: is it cut off\?"):
        read(text)


def test_integers_that_are_cut_off():
    rows = "  6 \t  63\n  7 \t   8\n 10 \t  45\n 11 \t  2"
    with pytest.raises(ValueError, match="line 4: the file ends in the middle of a line"):
        read(rows, ("subject", "barcode"))
    assert read(rows + "7", ("subject", "barcode"))[-1].tolist() == [11, 27]
    assert len(read("100 2\n3 4\n5 6\n7 8", ("subject", "barcode"))) == 4, "no fixed width: nothing was cut off"


finite = st.floats(allow_nan=False, allow_infinity=False, width=64)


@given(st.lists(st.tuples(finite, finite, finite), min_size=1, max_size=20))
def test_every_bit_is_read(rows):
    text = "".join(" ".join(map(repr, row)) + "\n" for row in rows)
    np.testing.assert_array_equal(read(text), rows)


@given(st.lists(st.tuples(*[st.floats(-1e6, 1e6)] * 3), min_size=2, max_size=6), st.data())
def test_a_file_cut_anywhere_is_refused_or_gives_its_first_rows(rows, data):
    """Numbers with fixed decimals, as the published files have them: no cut gives a number that was not there."""
    text = "# head\n" + "".join(f"{a:.3f} \t {b:7.3f} \t {c:7.3f}\n" for a, b, c in rows)
    whole = read(text)
    # a cut inside the first line leaves nothing to compare its decimals with
    first = text.index("\n", text.index("\n") + 1) + 1
    cut = data.draw(st.integers(first, len(text)))
    try:
        table = read(text[:cut])
    except ValueError as error:
        assert "line" in str(error)
    else:
        np.testing.assert_array_equal(table, whole[: len(table)])
        assert len(table) >= text[:cut].count("\n") - 1


def test_a_missing_file_says_what_there_is(tmp_path):
    (tmp_path / "b.dat").write_text("1 2 3\n")
    with pytest.raises(FileNotFoundError, match=r"no file a\.dat; there is: b\.dat"):
        read_table(Source(tmp_path), "a.dat", COLUMNS)
