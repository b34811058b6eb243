"""The best path that a filter could have, on the twin of Plaza."""

from pathlib import Path

import numpy as np

from ekfslam_tutorial.analysis.factors import graph_of
from ekfslam_tutorial.analysis.smoother import smooth
from ekfslam_tutorial.cli.files import find_scenario
from ekfslam_tutorial.datasets import plaza
from ekfslam_tutorial.toolbox import UserData


def test_it_knows_nothing_of_what_comes_later(monkeypatch):
    """With all frames it is the smoother; without the later ranges of another log, the same as that log's."""
    monkeypatch.syspath_prepend(str(Path(__file__).parents[2] / "tools"))
    from causal_optimum import causal

    rec, data = plaza.twin(), UserData.from_toml(find_scenario("plaza"), {"time.last": 150})
    graph = smooth(graph_of(data, rec)).graph
    assert sum(key[0] == "landmark" for key in graph.values) == 2
    half, end = causal(graph, [100, 150])
    best = graph.values["robot", 1, 150]
    np.testing.assert_allclose(end, best, atol=1e-3)  # held to 100 m, beacons known to 1 m move by 1e-4 of their errors
    for look in graph.looks:
        look.y = look.y + 5.0 * (look.k > 100)
    np.testing.assert_allclose(causal(graph, [100])[0], half, atol=1e-6)  # steps end at 1e-10
