"""What residuals do to the pose: gains by differences, the mean of c by drawn noise, and errors that were put in."""

from dataclasses import replace

import numpy as np
import pytest

from ekfslam_tutorial.analysis.factors import Motion, graph_of
from ekfslam_tutorial.analysis.influence import _gains, _Noise, _Run, influence
from ekfslam_tutorial.analysis.smoother import smooth
from ekfslam_tutorial.toolbox import RawLog

from .test_tuning import log_of, scenario


def run_of(graph):
    return _Run(graph, smooth(graph).system)


def gains(run, k):
    return list(_gains(run.graph, k, run.known, run.place, (len(run.system.r), len(run.system.z))))


@pytest.mark.parametrize("name, last", [("range_bearing_2d", 25), ("localisation_2d", 25), ("depth_camera", 8)])
def test_gains_are_those_of_the_smoother(name, last):
    """A measurement, or a control, that is a little larger moves the pose at the end by its gain times that much.

    To 5 % of the move: the smoother's Jacobians change with the pose, which Gauss and Newton's gain leaves out.
    """
    graph = graph_of(scenario(name, time__last=last))
    run = run_of(graph)
    run.known = True  # no gauge to take away: the smoother's own poses are compared
    k = len(graph.t) - 1
    ((P, gain),) = gains(run, k)
    key = next(key for key in graph.values if key[0] == "robot" and key[2] == k)
    frame = graph.frames[key[:2]]
    before = frame(graph.values[key][: frame.size])
    np.testing.assert_allclose(P, _tangent(before, smooth(graph).P[key][: frame.size, : frame.size]), rtol=1e-6)

    look, i, W, rows = run.system.seen[len(run.system.seen) // 2]
    step = 1e-4 * np.sqrt(np.diagonal(look.R[i]))
    old = look.y[i].copy()
    look.y[i] = old + step
    smooth(graph)
    moved = frame(graph.values[key][: frame.size]).minus(before)[0]
    assert np.linalg.norm(moved - (W @ step) @ gain.seen[rows]) < 0.05 * np.linalg.norm(moved)
    look.y[i] = old

    factor, _, rows = next(one for one in run.system.noise if isinstance(one[0], Motion) and one[0].after[2] == k // 2)
    _, _, G, _ = factor.linear(graph)
    step = 1e-4 * np.sqrt(np.diagonal(factor.U))
    smooth(graph)
    factor.u = factor.u + step
    factor.w = factor.w - step  # the control as it must have been is the same: the noise is less
    smooth(graph)
    moved = frame(graph.values[key][: frame.size]).minus(before)[0]
    assert np.linalg.norm(moved + (G @ step) @ gain.stiff[rows]) < 0.05 * np.linalg.norm(moved)


def _tangent(F, P):
    _, E = F.minus(F)
    return E @ P @ E.T


def test_of_noise_as_it_is_told_c_is_one_on_average():
    """Noise is drawn for all rows, and the smoother leaves its residuals: 300 times, and the mean is in a 99 % band."""
    run = run_of(graph_of(scenario(time__last=60)))
    s, rng = run.system, np.random.default_rng(1)
    ((P, gain),) = gains(run, len(run.graph.t) - 1)
    D, nothing, c = run.hidden(gain), _Noise(0 * s.r, 0 * s.z), []
    for _ in range(300):
        stiff = np.zeros(len(s.r))
        for factor, _, rows in s.noise:
            _, _, G, C = factor.linear(run.graph)
            w, V = np.linalg.eigh(C)
            stiff[rows] = G @ V @ (np.sqrt(w.clip(0)) * rng.standard_normal(len(w)))
        left = run.left_of(_Noise(stiff, rng.standard_normal(len(s.z))))[1]
        c.append(run.ratio(P, D, gain, left, nothing))
    assert abs(np.mean(c) - 1) < 2.58 * np.std(c) / np.sqrt(len(c)) < 0.1
    assert 0.2 < np.std(c) < 1  # few sources tell: one run is a rough guess


HONEST = """cloister_ahm cloister_hmg cloister_idp constant_velocity depth_camera descriptors doppler focal_length
gps_compass ground_flow lever_arm lidar_in_space localisation_2d range_bearing_2d steered_car two_robots_four_cameras"""


@pytest.mark.parametrize("name", HONEST.split())
def test_honest_runs_of_all_kinds_need_no_factor(name):
    """0.87 to 1.22 with the scenarios' own seeds; a wrong gain, gauge or source is off by far more than this band."""
    found = influence(graph_of(scenario(name, time__last=15)))
    assert 0.6 < found.by_controls < 1.7 and found.by_controls == found.by_ranges and not found.disagree


def test_errors_that_were_put_in():
    """Speeds 7 % too large hurt the pose little if the controls are wrong, and much if the ranges were.

    A range error of each landmark that lasts hurts it; noise as it is told does not.
    """
    log = log_of(scenario(time__last=200), 5)
    raw, data = log.raw[1], scenario(options__md2_threshold=1e9)
    honest = influence(graph_of(data, log))
    assert honest.factor < 1.5 and not honest.disagree and honest.by_controls == honest.by_ranges

    fast = replace(log, robots={1: replace(log.robots[1], u=log.robots[1].u * [1.07, 1.0])})
    wrong = influence(graph_of(data, fast))
    assert wrong.disagree and 0.03 < wrong.scale < 0.08
    assert wrong.by_controls < 2.5 and wrong.by_ranges > 2 * wrong.by_controls
    assert wrong.factor == pytest.approx(np.sqrt(wrong.by_controls * wrong.by_ranges))

    rng = np.random.default_rng(3)
    frame = np.repeat(np.arange(len(log)), np.diff(raw.offsets))
    error = 0.4 * rng.standard_normal((1 + raw.ids.max(), 1 + len(log) // 60))[raw.ids, frame // 60]
    lasting = replace(log, raw={1: RawLog(1, raw.offsets, raw.ids, raw.y + error[:, None] * [1, 0])})
    assert influence(graph_of(data, lasting)).factor > 2 * honest.factor


def test_where_nothing_measures_a_range_there_is_no_scale():
    found = influence(graph_of(scenario("cloister_idp", time__last=30)))
    assert np.isnan(found.scale) and not found.disagree and found.by_controls == found.by_ranges


def test_two_robots_are_told_each():
    graph = graph_of(scenario("two_robots_four_cameras", time__last=12))
    run = run_of(graph)
    assert len(gains(run, len(graph.t) - 1)) == len(graph.robots) == 2
    assert 0.3 < np.median(run.at(len(graph.t) - 1)) < 3  # an honest run; a single one is a rough guess
