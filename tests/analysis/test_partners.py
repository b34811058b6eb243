"""Where ids are the filter's own, landmarks and truth are matched by place, one to one; the rest is counted."""

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from ekfslam_tutorial.analysis import History, monte_carlo
from ekfslam_tutorial.analysis.partners import laid_by_shape, pairs_by_place, placed
from ekfslam_tutorial.cli import main, views
from ekfslam_tutorial.cli.files import find_scenario
from ekfslam_tutorial.geometry import Frame2, Frame3
from ekfslam_tutorial.simulation import SimLmk
from ekfslam_tutorial.slam import Jcbb, KnownIds, NearestNeighbour
from ekfslam_tutorial.toolbox import Recorder, UserData, universal_slam

F2, F3 = Frame2(np.array([3.0, -2.0, 0.7])), Frame3(np.array([1.0, 2.0, 0.5, 0.8, 0.0, 0.0, 0.6]))


def scattered(n, d, seed=1):
    return np.random.default_rng(seed).uniform(-10, 10, (n, d))


@pytest.mark.parametrize("F", [F2, F3])
def test_a_map_is_laid_on_the_world_and_what_is_left_over_is_left(F):
    """12 true landmarks, 10 of them in the map in another order, beside one that is nowhere."""
    truth, rng = scattered(12, F.dim), np.random.default_rng(2)
    order = rng.permutation(12)[:10]
    world = np.vstack([truth[order] + rng.normal(0, 0.05, (10, F.dim)), np.full(F.dim, 40.0)])
    points, P = F.to_frame(world)[0], np.tile(0.05**2 * np.eye(F.dim), (11, 1, 1))
    for start in laid_by_shape(points, truth), F:
        i, j, found = pairs_by_place(points, P, truth, start)
        assert dict(zip(i.tolist(), j.tolist(), strict=True)) == dict(enumerate(order.tolist()))
        np.testing.assert_allclose(found.x, F.x, atol=0.1)


def test_no_two_landmarks_have_the_same_true_one():
    truth = np.array([[0.0, 0.0], [4.0, 0.0], [0.0, 5.0], [6.0, 6.0]])
    points = np.vstack([truth, [0.02, 0.3]])  # a landmark that was started twice
    i, j, _ = pairs_by_place(points, np.tile(0.01 * np.eye(2), (5, 1, 1)), truth, Frame2(np.zeros(3)))
    assert sorted(i.tolist()) == [0, 1, 2, 3] and sorted(j.tolist()) == [0, 1, 2, 3]


def test_what_is_near_a_true_one_but_not_there_is_left_over():
    """The others are right to a centimetre and the covariance says so: one metre off is not there."""
    truth = scattered(8, 2)
    points = truth + np.random.default_rng(3).normal(0, 0.01, (8, 2))
    points[5] += [0.7, 0.7]
    i, _, _ = pairs_by_place(points, np.tile(1e-4 * np.eye(2), (8, 1, 1)), truth, Frame2(np.zeros(3)))
    assert sorted(i.tolist()) == [0, 1, 2, 3, 4, 6, 7]


def test_a_shape_that_is_not_in_the_world_is_laid_nowhere():
    assert laid_by_shape(scattered(10, 2, 5), 100 * scattered(10, 2, 6)) is None
    few = scattered(3, 2)
    assert laid_by_shape(few, few) is None


def scenario(association):
    data = UserData.from_toml(find_scenario("range_bearing_2d"))
    options = replace(data.options, association=association)
    return replace(data, options=options, time=replace(data.time, last=60), seed=1)


@pytest.fixture(scope="module")
def recording():
    """A walk in the lecture's world whose ids nobody knows, and whose truth has other numbers."""
    recorder = Recorder()
    for s in universal_slam(scenario(NearestNeighbour())):
        recorder.add(s)
    rec = recorder.recording("walk")
    rec.raw[1].ids[:] = -1
    rec.landmarks = SimLmk(1000 - rec.landmarks.ids, rec.landmarks.points)
    return rec


def run(recording, association, gauge="auto"):
    history = History(gauge)
    for _ in history.watch(universal_slam(scenario(association), recording)):
        pass
    return history


@pytest.mark.parametrize("gauge", ["fixed", "free"])
@pytest.mark.parametrize("association", [NearestNeighbour(), Jcbb()], ids=["nearest", "jcbb"])
def test_a_log_without_ids_has_errors_as_one_with_ids(recording, association, gauge):
    f = run(recording, association, gauge).summary()
    assert f["landmarks_by"] == "place" and f["n_left_over"] == 0
    assert f["n_landmarks"] + f["n_not_found"] == len(recording.landmarks.ids)
    assert f["landmark_rmse_m"] < 0.3 and f["landmark_rmse_aligned_m"] < 0.15 and f["nees_mean"] < 10
    json.dumps(f, allow_nan=False)


def test_without_a_true_path_the_shape_of_the_map_tells(recording):
    unseen = replace(recording, truth={})
    f = run(unseen, NearestNeighbour()).summary()
    assert f["gauge"] == "free" and f["landmarks_by"] == "place"
    assert f["n_left_over"] == 0 and f["landmark_rmse_m"] < 0.15


def test_known_ids_are_numbers_as_ever():
    history = History()
    data = scenario(KnownIds())
    for _ in history.watch(universal_slam(data)):
        pass
    f = history.summary()
    assert f["landmarks_by"] == "id" and f["n_left_over"] == 0
    assert history.landmarks()[0].tolist() == list(history.last.lmks)


def test_many_runs_count_what_is_left_over():
    result = monte_carlo(scenario(NearestNeighbour()), 2)
    assert (result.landmark_rmse < 0.5).all() and (result.landmark_nees < 20).all()
    assert result.summary()["n_left_over_mean"] == 0.0 and result.per_run()[0]["n_left_over"] == 0


def test_a_map_without_truth_or_landmarks_has_no_partners():
    s = SimpleNamespace(lmks={}, sim_lmk=None)
    assert placed(s) == ({}, None)


def test_run_says_it_on_the_screen_and_in_its_files(recording, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(views, "write_figures", lambda *arguments: [])
    more = replace(recording, landmarks=SimLmk(recording.landmarks.ids[1:], recording.landmarks.points[1:]))
    path = more.save(tmp_path / "log.npz")
    words = ["run", "range_bearing_2d", "--recording", str(path), "--out", str(tmp_path / "out")]
    assert main([*words, "--set", "options.association=nearest_neighbour"]) == 0
    assert "1 of them where no true one is" in capsys.readouterr().out
    header, *rows = (line.split(",") for line in (tmp_path / "out/map.csv").read_text().splitlines())
    assert header[-1] == "true_id" and sorted(row[-1] for row in rows).count("") == 1
    assert main(["evaluate", str(tmp_path / "out")]) == 0
    assert "without a true one" in " ".join(capsys.readouterr().out.split())
