"""The picture of a map, number for number: where its squares are, how dark, in which colour."""

import re

import numpy as np

from ekfslam_tutorial.ekf import Map
from ekfslam_tutorial.ekf.html import CELLS, SIDE, map_html, table_html


def squares(text):
    """(x, y, width, colour, opacity) of each square."""
    found = re.findall(
        r'<rect x="([\d.]+)" y="([\d.]+)" width="([\d.]+)" height="\3" fill="rgb(.*?)" fill-op.*?="(.*?)"', text
    )
    return [(float(x), float(y), float(w), colour, float(o)) for x, y, w, colour, o in found]


def test_two_states_with_a_gap_between_them():
    """sigma 2, 1 and 1; correlations 0.5, -1 and 0.004, which is too little to be seen."""
    map = Map()
    for k in (1, 1, 2):
        map.add(np.arange(k) + 1.0, np.eye(k))
    map.remove(slice(1, 2))
    used = np.ix_([0, 2, 3], [0, 2, 3])
    map.P[used] = [[4.0, 1.0, 0.008], [1.0, 1.0, -1.0], [0.008, -1.0, 1.0]]
    orange, blue = "(213, 94, 0)", "(0, 114, 178)"
    assert squares(map_html(map)) == [
        (0, 0, 100, orange, 1.0), (100, 0, 100, orange, 0.5),
        (0, 100, 100, orange, 0.5), (100, 100, 100, orange, 1.0), (200, 100, 100, blue, 1.0),
        (100, 200, 100, blue, 1.0), (200, 200, 100, orange, 1.0),
    ]  # fmt: skip
    assert re.findall(r'd="M([\d.]+) 0V300M0 \1H300"', map_html(map)) == ["0.0", "100.0"]
    rows = re.findall("<td>(.*?)</td>", map_html(map))
    assert rows == ["0:1", "0:1", "1", "2", "2:4", "2:4", "1 2", "1 1"]
    assert re.findall("<td>(.*?)</td>", map_html(map, {"<me>": slice(2, 4)})) == ["&lt;me&gt;", "2:4", "1 2", "1 1"]
    assert "between the 3 states of the map" in map_html(map)


def test_a_large_map_is_drawn_with_every_second_state():
    assert (CELLS, SIDE) == (60, 300)
    for n, shown in ((60, 60), (61, 31), (120, 60), (121, 41)):
        map = Map()
        for _ in range(n):
            map.add([0.0], [[1.0]])
        found = squares(map_html(map))
        assert len(found) == shown and max(x for x, *_ in found) < 300 <= max(x + w for x, _, w, *_ in found) + 0.1
        assert map_html(map).count("<path") == (n if n <= 60 else 0)


def test_a_state_without_variance_has_no_correlation_and_no_picture_of_nothing():
    map = Map()
    assert "svg" not in map_html(map)
    map.add([1.0, 2.0], np.diag([0.0, 1.0]))
    assert [s[:2] for s in squares(map_html(map))] == [(150, 150)]
    map.P[1, 1] = -1e-20  # rounding
    assert squares(map_html(map)) == [] and ">0 0<" in map_html(map)


def test_every_cell_is_text():
    assert table_html(("a", "<"), [(1, "&")]) == (
        "<table><thead><tr><th>a</th><th>&lt;</th></tr></thead><tbody><tr><td>1</td><td>&amp;</td></tr></tbody></table>"
    )
