"""What one sees of the structures: a short line in a terminal, a table and a picture in a notebook."""

import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest

from ekfslam_tutorial.ekf import Map
from ekfslam_tutorial.ekf.html import CELLS
from ekfslam_tutorial.fast import CompressedMap, FastMap
from ekfslam_tutorial.toolbox import UserData, universal_slam

SCENARIO = Path(__file__).resolve().parents[2] / "data" / "scenarios" / "two_robots_four_cameras.toml"


@pytest.fixture(scope="module")
def snapshot():
    run = universal_slam(UserData.from_toml(SCENARIO))
    for _ in range(4):
        snapshot = next(run)
    return snapshot


def parsed(html):
    """The HTML as a tree: it is well formed."""
    return ET.fromstring(f"<div>{html.replace('<br>', '<br/>')}</div>")


def cells(html):
    return [[td.text for td in tr] for tr in parsed(html).iter("tr") if tr[0].tag == "td"]


def shown(snapshot):
    return [snapshot.map, *snapshot.robs, *snapshot.sens, *snapshot.lmks.values(), *snapshot.obs.values()]


def test_every_structure_has_a_line_that_fits_and_html_that_is_well_formed(snapshot):
    for thing in shown(snapshot):
        assert 10 < len(repr(thing)) < 120 and "\n" not in repr(thing)
        assert parsed(thing._repr_html_()).find("b").text == repr(thing)


def test_a_range_is_shown_as_it_is_written(snapshot):
    lmk = next(iter(snapshot.lmks.values()))
    assert ["r", f"{lmk.r.start}:{lmk.r.stop}"] in cells(lmk._repr_html_())


def test_a_robot_says_what_it_is_and_where(snapshot):
    rob = snapshot.robs[0]
    assert f"in the map at {rob.r.start}:{rob.r.stop}" in repr(rob) and type(rob.motion).__name__ in repr(rob)


def test_the_states_of_a_snapshot_are_those_of_the_map(snapshot):
    rows = cells(snapshot._repr_html_())
    assert [f"{r.start}:{r.stop}" for r in snapshot.map.ranges] == sorted(
        (r[1] for r in rows), key=lambda t: int(t.split(":")[0])
    )
    assert rows[0][0] == f"robot {snapshot.robs[0].id}"
    np.testing.assert_allclose([float(v) for v in rows[0][2].split()], snapshot.robs[0].state(snapshot.map), rtol=6e-3)


@pytest.mark.parametrize("kind", [Map, FastMap, CompressedMap])
def test_a_map_knows_its_states_also_after_some_have_gone(kind):
    m = kind()
    a, b, c = (m.add(np.arange(k), np.eye(k)) for k in (3, 2, 2))
    assert m.ranges == [a, b, c]
    m.remove(b)
    assert m.ranges == [a, c]
    assert [row[1] for row in cells(m._repr_html_())] == ["0:3", "5:7"]
    b = m.add([7.0], [[4.0]])
    assert m.ranges == [a, b, c] == [slice(0, 3), slice(3, 4), slice(5, 7)]
    assert cells(m._repr_html_())[1] == ["3:4", "3:4", "7", "2"]
    assert [x for x in kind().ranges] == [] and "0 states" in kind()._repr_html_()


def test_the_picture_shows_the_correlations_and_stays_small():
    m = Map()
    m.add([0.0, 0.0], [[1.0, -0.5], [-0.5, 1.0]])
    picture = parsed(m._repr_html_()).find(".//{*}svg")
    opacity = [(float(r.get("x")), float(r.get("fill-opacity")), r.get("fill")) for r in picture.iter("rect")]
    assert [o[1] for o in opacity] == [1.0, 0.5, 0.5, 1.0] and opacity[1][2] != opacity[0][2]
    for _ in range(500):
        m.add([0.0, 0.0], np.eye(2))
    assert len(list(parsed(m._repr_html_()).find(".//{*}svg").iter("rect"))) <= CELLS * CELLS


def test_names_cannot_smuggle_html_into_a_notebook(snapshot):
    rob = snapshot.robs[0]
    name, rob.name = rob.name, "<script>alert(1)</script>"
    try:
        assert "<script" not in rob._repr_html_()
    finally:
        rob.name = name
