"""Worlds: numbers, places, and the reference's own cloister where its recorded numbers are at hand."""

import json

import numpy as np
import pytest

from ekfslam_tutorial.simulation import worlds
from ekfslam_tutorial.toolbox.scenario.keys import functions

RNG = np.random.default_rng(3)


def make(function):
    """Call a world with nothing but what it cannot do without."""
    given = {"points": {"points": [[0.0, 1.0], [2.0, 3.0]]}}.get(function.__name__, {})
    return function(RNG, **given) if function.__name__.startswith("random") else function(**given)


@pytest.mark.parametrize("function", functions(worlds).values(), ids=lambda f: f.__name__)
def test_every_world_has_distinct_ids_and_finite_points(function):
    ids, points, *edges = make(function)
    assert ids.shape == points.shape[:1] and points.shape[1] in (2, 3)
    if edges:
        assert edges[1].shape == (len(edges[0]), 6) and np.isfinite(edges[1]).all()
        ids = np.concatenate([ids, edges[0]])
    assert len(set(ids.tolist())) == len(ids) and (ids > 0).all() and ids.dtype.kind == "i"
    assert np.isfinite(points).all() and len(np.unique(points, axis=0)) == len(points)


def test_default_cloister_is_the_manuals_72_points():
    ids, points = worlds.cloister()
    assert ids.tolist() == list(range(1, 73))
    assert points[:9].tolist() == [[x, 6, 0] for x in (-4, -2, 0, 2, 4)] + [[x, 4, 0] for x in (-4, -2, 0, 2)]
    assert np.array_equal(points[36:] - points[:36], np.tile([0.0, 0.0, 1.0], (36, 1)))


def test_cloister_has_the_symmetry_of_its_walls():
    plan = {tuple(p) for p in worlds.cloister(-3, 3, -3, 3, 7, None)[1].tolist()}
    turned = {(-y, x) for x, y in plan}
    assert len(plan) == 4 * (2 * 7 - 5) and plan == turned


def test_cloister_follows_a_rectangle():
    _, points = worlds.cloister(0, 10, 0, 4, 5, None)
    assert points.min(0).tolist() == [0, 0] and points.max(0).tolist() == [10, 4]
    assert not {(0, 0), (10, 0), (0, 4), (10, 4)} & {tuple(p) for p in points.tolist()}


def test_cloister_needs_an_inner_row():
    with pytest.raises(ValueError, match="at least 4 columns.*got n = 3"):
        worlds.cloister(n=3)


def test_random_worlds_follow_their_generator_and_limits():
    a, b = (worlds.random3(np.random.default_rng(5), n=200, z_min=1, z_max=2)[1] for _ in range(2))
    assert np.array_equal(a, b)
    assert (a[:, 2] >= 1).all() and (a[:, 2] <= 2).all() and a[:, :2].min() < -5 and a[:, :2].max() > 5


@pytest.mark.parametrize(
    ("function", "given", "message"),
    [
        (worlds.random2, dict(x_min=7.0), r"x_min must not be above x_max, got 7.0 and 6.0"),
        (worlds.random2, dict(y_max=-7.0), r"y_min must not be above y_max, got -6.0 and -7.0"),
        (worlds.random3, dict(z_min=3.0), r"z_min must not be above z_max, got 3.0 and 2.0"),
        (worlds.random3, dict(n=-1), "needs 1 landmark or more, got n = -1"),
        (worlds.ring, dict(n=-1), "needs 1 landmark or more, got n = -1"),
    ],
)
def test_limits_and_numbers_that_cannot_be_are_named(function, given, message):
    with pytest.raises(ValueError, match=message):
        function(RNG, **given) if function is not worlds.ring else function(**given)


def test_cloisters_agree_with_recorded_numbers(golden_dir):
    records = json.loads((golden_dir / "functions" / "worlds.json").read_text())
    compared = 0
    for record in records:
        if record["fn"] not in ("cloister", "thickCloister"):
            continue
        *limits, last = (a["value"][0][0] for a in record["args"])
        x, X, y, Y, h, n = (*limits, None, last) if record["fn"] == "cloister" else (*limits, last)
        expected = np.array(record["outs"][0]["value"]).T
        assert np.array_equal(worlds.cloister(x, X, y, Y, int(n), h)[1], expected)
        compared += 1
    assert compared
