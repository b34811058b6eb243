"""The figures of an experiment, while it runs."""

import time

import numpy as np
import pytest

from ekfslam_tutorial.cli.files import find_scenario
from ekfslam_tutorial.course import figures, live
from ekfslam_tutorial.toolbox import UserData, universal_slam

DATA = UserData.from_toml(find_scenario("range_bearing_2d"), {"time.last": 7})


@pytest.fixture
def pictures(monkeypatch):
    """What is drawn, as arrays, in small."""
    drawn = []
    monkeypatch.setattr(live, "SIZE", (4.0, 3.2))
    monkeypatch.setattr(live, "_png", lambda image, dpi: drawn.append(image) or figures.png(live.plt.figure(), 20))
    monkeypatch.setattr(figures, "display", lambda *objects, **options: None)
    return drawn


def shown(every):
    """Run the scenario before a live view that draws after so many seconds, at the earliest."""
    view = live.Watch("a run", every=every)
    for now in universal_slam(DATA):
        view.take(now)
    view.finish("The end.")


def test_the_last_picture_is_the_same_whether_others_are_drawn_before_it_or_not(pictures, monkeypatch):
    shown(every=1e9)
    assert len(pictures) == 1
    monkeypatch.setattr(live, "SHARE", 1.0)
    shown(every=-1e9)
    assert len(pictures) == 1 + len(universal_slam(DATA)) + 1
    assert np.array_equal(pictures[0], pictures[-1]) and not np.array_equal(pictures[0], pictures[1])


def test_pictures_take_no_more_than_their_share_of_the_time(pictures, monkeypatch):
    """On a clock on which a picture takes a second, and a frame half a second."""
    now = [0.0]
    monkeypatch.setattr(time, "perf_counter", lambda: now[0])
    draw = live.Watch.draw
    monkeypatch.setattr(live.Watch, "draw", lambda self, **options: (draw(self, **options), now.append(now.pop() + 1)))
    view = live.Watch("a run", every=0.1)
    for frame in universal_slam(DATA):
        now[0] += 0.5
        view.take(frame)
    assert 1 <= len(pictures) <= live.SHARE * now[0] + 1
