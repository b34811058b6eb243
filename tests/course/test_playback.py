"""The films of the notebooks: their strips can be read."""

import matplotlib.pyplot as plt
import pytest

from ekfslam_tutorial.course import registry, replay
from ekfslam_tutorial.course.cells import experiment_of
from ekfslam_tutorial.course.draws import nb18
from ekfslam_tutorial.course.logs.nb18 import ROBOTS, TWIN
from ekfslam_tutorial.toolbox import universal_slam


@pytest.fixture(scope="module")
def five_robots():
    cells = experiment_of("18", meet=registry.get("18.1").solution)
    return nb18.film(TWIN, universal_slam(*cells["part"](TWIN)))


def test_a_strip_of_ones_own_takes_the_place_of_the_usual_one(five_robots, monkeypatch):
    shown = []
    monkeypatch.setattr("ekfslam_tutorial.course.playback.show", lambda fig, caption: shown.append(fig))
    monkeypatch.setattr("ekfslam_tutorial.course.playback.display", lambda data, **_: None)
    own = plt.figure()
    replay(five_robots, strip=own)
    replay(five_robots, n=2)
    assert shown[0] is own and len(shown[1].axes) == 2
    plt.close("all")


def test_five_robots_have_five_looks(five_robots):
    fig = nb18.film_strip(five_robots)
    for ax in fig.axes:
        paths = [line for line in ax.lines if str(line.get_label()).startswith("robot")]
        assert len({(line.get_color(), line.get_linestyle()) for line in paths}) == len(paths) == len(ROBOTS)
    assert [text.get_text() for text in fig.legends[0].texts][-len(ROBOTS) :] == [f"robot {r}" for r in ROBOTS]
    plt.close(fig)
