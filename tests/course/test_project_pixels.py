"""Project 24: a right run on a film passes, wrong ones are told what is wrong; each is judged by one film here."""

import copy

import numpy as np
import pytest

from ekfslam_tutorial.course.logs import nb24 as films
from ekfslam_tutorial.course.projects import nb24
from ekfslam_tutorial.geometry import Frame3

from .test_projects import edited

S = "H_l @ P @ H_l.T + camera.R"
WRONG = {  # edits of the loop, of the scenario; the link, and a word of the hint
    "all matches": ([("agreeing(z, E, camera.R, 1.5)", "np.ones(len(z))")], (), "wrong matches", "agreeing"),
    "no births": ([("else min(12 - good, 3)", "else 0")], (), "the map", "turns away"),
    "too sure": ((), [("pixel_std = 0.5", "pixel_std = 0.1")], "honest", "pixel_std 0.5"),
    "S = R": ([(S, "camera.R")], (), "the share found", "H P H'"),
    "nothing told": ([("now.seen[1] += list(", "_ = list(")], (), "the matches", "now.seen"),
}


def verdict(loop=(), scenario=()):
    """The verdict on one film of the reference with edits."""
    project, text = copy.copy(nb24.project), nb24.SCENARIO
    project.seeds = ()
    for old, new in scenario:
        assert text.count(old) == 1
        text = text.replace(old, new)
    return project.judge(project.run(text, edited(project, *loop)))


def test_a_right_run_passes_and_a_stub_is_no_attempt():
    found = verdict()
    assert found.passed and "mean NEES" in found.note, f"{found.link}: {found.message}"

    def loop(world):
        raise NotImplementedError

    assert nb24.project.judge(nb24.project.run(nb24.SCENARIO, loop)).status == "not attempted"


@pytest.mark.parametrize(("loop", "scenario", "link", "word"), WRONG.values(), ids=WRONG)
def test_a_wrong_run_is_told_what_is_wrong(loop, scenario, link, word):
    found = verdict(loop, scenario)
    assert found.status == "failed" and found.link == link, f"{found.link}: {found.message}"
    assert word in found.hint


def test_the_start_is_the_scenario_with_gaps():
    assert "Here: dv_std" in nb24.START and "pixel_std = " not in nb24.START and "[landmark]" not in nb24.START


def test_the_truth_of_a_pixel_is_where_the_next_image_shows_it():
    """A corner of the rectangle, by its pixel in image 0; where it projects to in image 12, black meets white."""
    log = films.film(1)
    pixel = films.CAMERA.project(log.corners[0])[0]
    p, stays = log.truths(0, pixel)
    np.testing.assert_allclose(p[0], log.corners[0], atol=1e-6)
    assert stays[0] and not log.truths(25, [[50.0, 55.0]])[1][0]  # the book is there by then
    there = films.CAMERA.project(Frame3(log.truth[1][12]).to_frame(p)[0])[0][0]
    u, v = np.rint(there).astype(int)
    around = log.frames[12][v - 3 : v + 4, u - 3 : u + 4]
    assert around[-1, -1] < 40 and around[0, 0] > 180
