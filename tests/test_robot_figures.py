"""The pictures of each robot: which ones are written, and what is in their panels."""

from dataclasses import replace

import numpy as np
import pytest

from ekfslam_tutorial.analysis import History
from ekfslam_tutorial.cli import main, robot_views, views
from ekfslam_tutorial.graphics import SenFig, map_picture
from ekfslam_tutorial.graphics.style import ROBOTS
from ekfslam_tutorial.toolbox import UserData, universal_slam

ROBOT = {"motion": "odometry2", "dx": [0.25, 0.0], "da_deg": 7.2, "dx_std": [0.01, 0.004], "da_std_deg": 0.2}
SENSOR = {"type": "range_bearing", "range_std": 0.05, "bearing_std_deg": 0.5, "max_range": 6.0}


@pytest.fixture(scope="module")
def run():
    data = UserData.from_dict(
        {
            "world": {"type": "ring", "n": 8, "radius": 4.0},
            "time": {"last": 20},
            "robot": [{"id": i, "position": [0, -2 * i]} | ROBOT for i in (1, 2)],
            "sensor": [{"id": i, "robot": i} | SENSOR for i in (1, 2)],
        }
    )
    history = History()
    for _ in history.watch(universal_slam(data)):
        pass
    return data, history


def test_each_robot_has_its_pictures(run, tmp_path):
    data, history = run
    names = views.write_figures(tmp_path, history, data)
    wanted = {f"{kind}-{i}.png" for kind in ("map", "errors", "consistency", "sensor") for i in (1, 2)} | {"map.png"}
    assert set(names) == wanted == {path.name for path in tmp_path.iterdir()}


def test_a_recording_with_gps_shows_it_and_what_frames_cost(run, tmp_path, request):
    data, history = run
    track = history.track(1)
    fixes = np.column_stack([track.t, track.x[:, :2] + 0.3])
    names = views.write_figures(tmp_path, history, data, {1: fixes}, [1e-3] * 20)
    assert "cost.png" in names and (tmp_path / "cost.png").stat().st_size > 5000
    request.getfixturevalue("undrawn")
    plain = views.write_figures(tmp_path, history, data)
    assert set(plain) == set(names) - {"cost.png"}


def test_without_truth_only_nis_is_shown(run):
    _, history = run
    track = replace(history.track(1), truth=np.full_like(history.track(1).truth, np.nan))
    fig = robot_views._consistency(track, np.zeros(0), history.nis(1))
    assert [ax.get_ylabel() for ax in fig.axes] == ["NIS (-)"] and "not known" in fig.get_suptitle()


def test_both_panels_of_consistency_show_the_whole_run(run):
    """Also where measurements are used late: those of a beacon that is born after a while."""
    _, history = run
    track, (e, P) = history.track(1), history.errors(1)
    late = history.nis(1)[5:]
    fig = robot_views._consistency(track, robot_views.md2(e, P), late)
    assert late[0, 0] > track.t[0] and len(fig.axes) == 2
    assert all(ax.get_xlim() == (track.t[0], track.t[-1]) for ax in fig.axes)


def test_errors_are_those_of_the_history_in_metres_and_degrees(run):
    _, history = run
    track, (e, P) = history.track(2), history.errors(2)
    fig = robot_views._errors(track, e, P, 3)
    for i, (ax, scale) in enumerate(zip(fig.axes, (1, 1, 180 / np.pi), strict=True)):
        drawn = next(l for l in ax.lines if l.get_label() == "estimate - truth")
        np.testing.assert_allclose(drawn.get_ydata(), scale * e[:, i])
        np.testing.assert_allclose(ax.lines[0].get_ydata(), 3 * scale * np.sqrt(P[:, i, i]))
        assert ax.get_ylabel().endswith("(m)" if scale == 1 else "(deg)")


def test_a_robot_has_the_same_colour_in_all_maps(run, monkeypatch):
    data, history = run
    drawn = {}
    real = robot_views.map_picture

    def spy(path, **more):
        axes, words = real(path, **more)
        drawn[more["title"]] = [l.get_color() for l in axes.lines if l.get_label() == "estimated path"]
        return axes, words

    monkeypatch.setattr(robot_views, "map_picture", spy)
    lmks = {"mean": np.zeros((0, 2)), "cov": np.zeros((0, 2, 2))}
    for id, color in zip((1, 2), ROBOTS, strict=False):
        robot_views._path(history.track(id), lmks, data, None, color)
        assert drawn[f"{data.name}: robot {id}"] == [color]
    axes, _ = map_picture({f"r{id}": history.track(id).x[:, :2] for id in (1, 2)}, **lmks)
    assert [l.get_color() for l in axes.lines if l.get_label() in ("r1", "r2")] == list(ROBOTS[:2])


def test_the_panels_of_errors_share_one_legend(run):
    fig = robot_views._errors(run[1].track(1), *run[1].errors(1), 3)
    assert len(fig.legends) == 1 and all(ax.get_legend() is None for ax in fig.axes)
    assert all(any("outside: " in text.get_text() for text in ax.texts) for ax in fig.axes)


def test_a_sensor_shows_the_frame_in_which_it_saw_most(run):
    data, _ = run
    richest, seen = views.Richest(), []
    for snapshot in universal_slam(data):
        richest.add(snapshot)
        seen.append((snapshot.k, sum(obs.matched for (sen, _), obs in snapshot.obs.items() if sen == 2)))
    kept = richest.kept[2]
    assert dict(seen)[kept.k] == max(n for _, n in seen) == sum(obs.matched for obs in kept.obs.values())
    title = SenFig(kept, 2).heading.get_text()
    assert f"frame {kept.k}:" in title and "nothing" not in title


def test_nis_is_kept_with_its_time_and_averaged_in_groups(run):
    _, history = run
    nis = history.nis(1)
    assert nis.shape[1] == 3 and (np.diff(nis[:, 0]) >= 0).all() and set(nis[:, 2]) == {2.0}
    mean = np.concatenate([history.nis(i) for i in history.robots])[:, 1].mean()
    assert history.summary()["nis_mean"] == pytest.approx(mean)
    many = np.column_stack([np.arange(4001.0), np.arange(4001.0), np.full(4001, 2.0)])
    t, value, dof, n = robot_views._averaged(many)
    assert set(n[:-1]) == {34} and n.sum() == 4001 and value[:2].tolist() == [16.5, 50.5] and set(dof) == {2.0}
    assert len(t) == 118 and n[-1] == 23


def test_groups_of_nis_end_at_gaps_in_time():
    t = np.concatenate([np.arange(2000.0), 5000.0 + np.arange(2500.0)])
    nis = np.column_stack([t, np.where(t < 4000, 1.0, 7.0), np.full(4500, 2.0)])
    t, value, _, n = robot_views._averaged(nis)
    assert set(value) == {1.0, 7.0} and n.sum() == 4500 and n.max() == 38
    assert not ((t > 2000) & (t < 5000)).any()


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("frames", [1, 2])
@pytest.mark.parametrize("name", ["range_bearing_2d", "localisation_2d"])
def test_the_shortest_runs_have_pictures_too(name, frames, tmp_path, capsys):
    """In the first frame the pose may be exact, which has no NEES, and nothing is measured a second time."""
    assert main(["run", name, "--set", f"time.last={frames}", "--out", str(tmp_path)]) == 0, capsys.readouterr().err
