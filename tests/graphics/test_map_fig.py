"""MapFig: artists made once, points that are those of the map, views, speed."""

from collections import deque
from types import SimpleNamespace

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.colors import to_hex

from ekfslam_tutorial.geometry import Frame2, Frame3
from ekfslam_tutorial.graphics import ESTIMATE, MapFig, ellipse_points, ellipsoid_wires, nan_separated, sigma_label
from ekfslam_tutorial.graphics.artists import Labels
from ekfslam_tutorial.graphics.states import lmk_states, obs_state
from ekfslam_tutorial.graphics.style import ROBOTS
from ekfslam_tutorial.graphics.views import fit_limits, look_from, low_enough
from ekfslam_tutorial.simulation import SimLmk
from ekfslam_tutorial.slam import Lmk
from tests.pace import within

FLAT = pytest.mark.parametrize("flat", [True, False], ids=["2D", "3D"])


def rows(line):
    """Points (m, d) of a line."""
    data = line.get_data_3d() if hasattr(line, "get_data_3d") else line.get_data()
    return np.column_stack(data)


def last(snapshots):
    """The last snapshot of a run."""
    return deque(snapshots, maxlen=1)[0]


def pixels(fig):
    fig.canvas.draw()
    return np.asarray(fig.canvas.buffer_rgba())[..., :3].copy()


@FLAT
def test_artists_are_reused_and_their_points_are_those_of_the_map(run, flat):
    fig = None
    truth, estimate, before = [], [], None
    for s in run(flat):
        if fig is None:
            fig = MapFig(s)
            fig.fig.canvas.draw()
            before = {name: id(a) for name, a in named_artists(fig).items()}
        else:
            fig.update(s)
        truth.append(s.sim_robs[0].frame.t.copy())
        estimate.append(s.robs[0].frame(s.map).t.copy())
    assert {name: id(a) for name, a in named_artists(fig).items()} == before

    def shown(p):
        return p[np.isfinite(p).all(axis=1)]

    np.testing.assert_allclose(shown(rows(fig.est_rob[1].path)), estimate)
    np.testing.assert_allclose(shown(rows(fig.sim_rob[1].path)), truth)
    np.testing.assert_allclose(shown(rows(fig.sim_lmk)), s.sim_lmk.points)
    means = np.array([lmk.point(s.map)[0] for lmk in s.lmks.values()])
    inside = ((means >= fig.limits[:, 0]) & (means <= fig.limits[:, 1])).all(axis=1)
    np.testing.assert_allclose(shown(rows(fig.est_lmk.mean)), means[inside])
    assert sorted(fig.est_lmk.label.where) == sorted(np.array(list(s.lmks))[inside].tolist())


def named_artists(fig):
    """The artists that must stay the same, by name."""
    body = {
        f"{kind}{i}.{part}": getattr(b, part)
        for kind in ("est_rob", "est_sen", "sim_rob", "sim_sen")
        for i, b in getattr(fig, kind).items()
        for part in ("outline", "faces", "path")
    }
    ellipses = {f"ellipse.{state}": artist for state, artist in fig.est_lmk.ellipse.items()}
    others = dict(ground=fig.ground, sim_lmk=fig.sim_lmk, mean=fig.est_lmk.mean, label=fig.est_lmk.label)
    return body | ellipses | others | {"axes": fig.axes, "fig": fig.fig}


@FLAT
def test_no_artist_is_added_from_frame_to_frame(run, flat):
    snapshots = run(flat)
    fig = MapFig(next(snapshots))
    fig.fig.canvas.draw()
    before = len(fig.axes.get_children())
    for s in snapshots:
        fig.update(s)
    fig.fig.canvas.draw()
    assert len(fig.axes.get_children()) == before


@FLAT
def test_ellipses_are_k_sigma_ellipses_by_state(run, flat):
    s = last(run(flat))
    d = 2 if flat else 3
    fig = MapFig(s, k=2, limits=[[-1e9, 1e9]] * d)  # so wide that nothing is cut
    states = lmk_states(s)
    expected = {"updated": [], "rejected": [], "estimate": []}
    for id, lmk in s.lmks.items():
        state = states.get(id)
        expected[state if state in ("updated", "rejected") else "estimate"].append(lmk.point(s.map))
    assert expected["updated"] and expected["estimate"]
    for state, points in expected.items():
        curve = ellipse_points if flat else ellipsoid_wires
        drawn = rows(fig.est_lmk.ellipse[state])
        p, P = (np.array([x[i] for x in points]).reshape(-1, *(d,) * (i + 1)) for i in range(2))
        np.testing.assert_allclose(drawn, nan_separated(curve(p, P, 2)))


@FLAT
def test_landmarks_that_leave_the_map_leave_the_figure(run, flat):
    s = last(run(flat))
    fig = MapFig(s)
    gone = next(iter(fig.est_lmk.label.where))
    n = np.isfinite(rows(fig.est_lmk.mean)[:, 0]).sum()
    del s.lmks[gone]
    fig.update(s)
    assert gone not in fig.est_lmk.label.where
    assert np.isfinite(rows(fig.est_lmk.mean)[:, 0]).sum() == n - 1
    s.lmks.clear()
    fig.update(s)
    fig.fig.canvas.draw()
    assert len(rows(fig.est_lmk.mean)) == 0 and not fig.est_lmk.label.where


@FLAT
def test_singular_and_infinite_landmarks_do_no_harm(run, flat):
    s = last(run(flat))
    d = 2 if flat else 3
    s.lmks[901] = Lmk(901, SimpleNamespace(point=lambda l: (l, np.eye(d))), x=np.full(d, 0.5))  # known: P = 0
    s.lmks[902] = SimpleNamespace(id=902, point=lambda map: (np.full(d, np.inf), np.full((d, d), np.nan)))
    fig = MapFig(s)
    assert pixels(fig.fig).std() > 0
    assert 901 in fig.est_lmk.label.where and 902 not in fig.est_lmk.label.where
    assert np.isfinite(fig.limits).all()


@FLAT
def test_the_same_frame_twice_is_the_same_picture(run, flat):
    s = last(run(flat))
    fig = MapFig(s)
    first = pixels(fig.fig)
    fig.update(s)
    np.testing.assert_array_equal(pixels(fig.fig), first)


def test_going_back_shortens_the_path(run):
    snapshots = list(run(True, **{"time.last": 5}))
    fig = MapFig(snapshots[0])
    for s in snapshots[1:]:
        fig.update(s)
    assert len(fig.est_rob[1].past) == 5
    fig.update(snapshots[1])
    assert list(fig.est_rob[1].past) == [1, 2]


@FLAT
def test_limits_grow_and_never_shrink(run, flat):
    snapshots = run(flat)
    s = next(snapshots)
    s.sim_lmk = None  # as with the log of a robot whose world nobody measured
    fig = MapFig(s)
    before = fig.limits
    for s in snapshots:
        s.sim_lmk = None
        fig.update(s)
        assert (fig.limits[:, 0] <= before[:, 0]).all() and (fig.limits[:, 1] >= before[:, 1]).all()
        before = fig.limits
        t = s.robs[0].frame(s.map).t
        assert ((t >= before[:, 0]) & (t <= before[:, 1])).all()


def test_fit_limits():
    old = fit_limits(np.array([[0.0, 0.0], [10.0, 10.0]]))
    assert fit_limits(np.array([[5.0, 5.0]]), old) is old
    assert (fit_limits(np.array([[50.0, 5.0]]), old)[0] > old[0]).any()
    assert np.isfinite(fit_limits(np.full((1, 2), np.nan))).all()
    assert (np.ptp(fit_limits(np.zeros((1, 3))), axis=1) > 0).all()  # a point needs room too


def test_given_limits_are_kept(run):
    limits = np.array([[-20.0, 20.0], [-15.0, 15.0]])
    snapshots = run(True)
    fig = MapFig(next(snapshots), limits=limits)
    for s in snapshots:
        fig.update(s)
    np.testing.assert_array_equal([fig.axes.get_xlim(), fig.axes.get_ylim()], limits)


# ------------------------------------------------------------------------------------------------------------ views


@pytest.mark.parametrize(
    "flat, view", [(True, "top"), (True, "self")] + [(False, v) for v in ("perspective", "top", "side", "self")]
)
def test_views_differ_and_are_not_empty(run, flat, view):
    s = last(run(flat))
    fig = MapFig(s)
    usual = pixels(fig.fig)
    fig.set_view(view)
    fig.update(s)
    image = pixels(fig.fig)
    assert (image < 250).any(axis=2).mean() > 0.005
    assert (np.array_equal(image, usual)) == (view == ("top" if flat else "perspective"))


@pytest.mark.parametrize("flat, names", [(True, "top, self"), (False, "perspective, top, side, self")])
def test_an_unknown_view_is_refused_by_name(run, flat, names):
    fig = MapFig(next(run(flat)))
    with pytest.raises(ValueError, match=f"{names}; got 'bottom'"):
        fig.set_view("bottom")
    with pytest.raises(ValueError, match="no sensor 9"):
        fig.set_view("self", 9)


def test_top_and_side_look_along_the_axes(run):
    """Seen from above, points that differ in z only fall together; from the side, points that differ in y only."""
    fig = MapFig(next(run(False)))
    for view, axis in [("top", 2), ("side", 1)]:
        fig.set_view(view)
        fig.fig.canvas.draw()
        p = np.array([[1.0, 2.0, 0.5, 1.0], [1.0, 2.0, 0.5, 1.0]])
        p[1, axis] += 0.7
        x = p @ fig.axes.get_proj().T
        np.testing.assert_allclose(x[0, :2] / x[0, 3], x[1, :2] / x[1, 3], atol=1e-6)


def test_the_sensor_view_is_the_picture_of_the_camera(run):
    """Where the figure draws a landmark is where the camera model projects it, up to scale."""
    s = last(run(False))
    fig = MapFig(s)
    fig.set_view("self", 1)
    fig.update(s)
    sen = s.sens[0]
    frame = s.robs[0].frame(s.map).compose(sen.frame(s.map))[0]
    camera = frame.to_frame(s.sim_lmk.points)[0]
    u = sen.model.project(camera)[0]
    seen = (camera[:, 2] > 0.3) & (u >= 0).all(axis=1) & (u <= sen.model.image_size).all(axis=1)
    assert seen.sum() > 5
    h = np.column_stack([s.sim_lmk.points, np.ones(len(u))])[seen] @ fig.axes.get_proj().T
    xy = h[:, :2] / h[:, 3:]
    scale = (xy[:, 0] - xy[0, 0]) @ (u[seen, 0] - u[seen][0, 0]) / np.sum((u[seen, 0] - u[seen][0, 0]) ** 2)
    np.testing.assert_allclose(xy[:, 0], scale * (u[seen, 0] - 320), atol=1e-9)
    np.testing.assert_allclose(xy[:, 1], -scale * (u[seen, 1] - 240), atol=1e-9)  # v is downwards
    shown = np.isfinite(rows(fig.sim_lmk)[:, 0])
    np.testing.assert_array_equal(shown, seen)


def test_look_from_is_invertible():
    """matplotlib inverts the matrix at every drawing."""
    M = look_from(Frame3([1, 2, 3, 0.5, -0.5, 0.5, -0.5]), np.array([1.0, 0.75]))
    np.testing.assert_allclose(np.linalg.inv(M) @ M, np.eye(4), atol=1e-9)


def test_orbit_turns_the_camera_by_radians(run):
    fig = MapFig(next(run(False)))
    before = fig.axes.azim
    fig.orbit(np.pi / 4)
    assert fig.axes.azim == pytest.approx(before + 45)
    with pytest.raises(ValueError, match="2D view 'top'"):
        MapFig(next(run(True))).orbit(0.1)


# ----------------------------------------------------------------------------------------------- robots and truth


def test_two_robots_have_names_bodies_and_sensors(run):
    s = last(run(False))
    fig = MapFig(s)
    assert set(fig.est_rob) == set(fig.sim_rob) == set(fig.est_sen) == set(fig.sim_sen) == {1, 2}
    assert fig.rob_label.names == {1: "ann", 2: "bob"}
    colors = [fig.est_rob[id].path.get_color() for id in (1, 2)]
    assert colors == list(ROBOTS[:2]) == [fig.rob_ellipse[id].get_color() for id in (1, 2)]
    assert [to_hex(c).upper() for c in fig.rob_label.get_facecolors()] == colors
    for id, rob in fig.est_rob.items():
        corners = rows(rob.outline)
        corners = corners[np.isfinite(corners[:, 0])]
        t = s.robs[id - 1].frame(s.map).t
        assert np.linalg.norm(corners - t, axis=1).max() < 1.3 * fig.size


def test_a_robot_points_where_it_looks(run):
    s = last(run(True))
    fig = MapFig(s)
    frame = s.robs[0].frame(s.map)
    corners = rows(fig.est_rob[1].outline)
    ahead = frame.to_frame(corners[np.isfinite(corners[:, 0])])[0][:, 0]
    assert ahead.max() == pytest.approx(fig.size) and ahead.min() > -0.8 * fig.size


def test_without_truth_there_is_none_to_see(run):
    s = last(run(True))
    s.truth, s.sim_robs, s.sim_sens, s.sim_lmk = {}, (), (), None
    fig = MapFig(s)
    assert not fig.sim_rob and not any("true" in name for name in fig.legend)


def played_back(snapshots, known, origin):
    """The snapshots as those of a recording whose truth has another origin and is known in some frames only."""
    for s in snapshots:
        x = origin.compose(s.sim_robs[0].frame)[0].x
        s.truth = {1: x if s.k in known else np.full(3, np.nan)}
        s.sim_lmk = SimLmk(s.sim_lmk.ids, origin.from_frame(s.sim_lmk.points)[0])
        s.sim_robs, s.sim_sens = (), ()
        yield s


def test_the_truth_of_a_recording_is_shown_in_the_frame_of_the_map_where_it_is_known(run):
    known = [3, 4, 5, 9, 20, 21]
    origin = Frame2([30.0, -20.0, 2.0])
    points, snapshots = None, played_back(run(True), known, origin)
    for s in snapshots:
        if points is None:
            points = origin.to_frame(s.sim_lmk.points)[0]
            fig = MapFig(s)
            assert len(rows(fig.sim_lmk)) == 0  # where the truth lies in the map is not known yet
        fig.update(s)
        shown = np.isfinite(rows(fig.sim_rob[1].outline)).all(axis=1)
        assert shown.any() == (s.k in known)
    # The truth is laid on one estimated pose, which is wrong by some centimetres and tenths of a degree.
    np.testing.assert_allclose(rows(fig.sim_lmk), points, atol=0.5)
    path = fig.sim_rob[1].path
    p = rows(path)
    assert len(path.get_markevery()) == 1  # frame 9 stands alone: a dot
    dot = p[path.get_markevery()[0]]
    np.testing.assert_allclose(dot, fig.sim_rob[1].past[9])
    whole = np.split(p, np.flatnonzero(np.isnan(p[:, 0])))
    assert sorted(int(np.isfinite(piece[:, 0]).sum()) for piece in whole if np.isfinite(piece).any())[-1] >= 2
    drawn = p[np.isfinite(p[:, 0])]
    for k in known:
        assert np.isclose(drawn, fig.sim_rob[1].past[k]).all(axis=1).any()


def test_truth_of_a_simulation_is_not_moved(run):
    s = last(run(True))
    np.testing.assert_array_equal(rows(MapFig(s).sim_lmk), s.sim_lmk.points)
    moved = rows(MapFig(s, align=True).sim_lmk)
    assert not np.allclose(moved, s.sim_lmk.points)


# ---------------------------------------------------------------------------------------------------------- words


@FLAT
def test_legend_says_k_and_the_probability_and_tells_truth_from_estimate(run, flat):
    snapshot = next(run(flat))
    fig = MapFig(snapshot, k=2)
    texts = [t.get_text() for t in fig.fig.legends[0].get_texts()]
    assert sigma_label(2, 2 if flat else 3) in texts
    names = [rob.name or f"robot {rob.id}" for rob in snapshot.robs]
    paths = names if len(names) > 1 else ["estimated path and robot"]
    assert {"true path and robot", *paths, "true landmark", "estimated landmark, id"} <= set(texts)
    assert fig.sim_lmk.get_marker() != fig.est_lmk.mean.get_marker()
    assert fig.sim_lmk.get_fillstyle() == "none" and fig.est_lmk.mean.get_fillstyle() == "full"
    assert fig.est_rob[1].path.get_linestyle() != fig.sim_rob[1].path.get_linestyle()
    assert fig.est_rob[1].path.get_color() == ESTIMATE["color"]
    assert fig.axes.get_xlabel() == "x (m)" and fig.axes.get_ylabel() == "y (m)"


def test_labels_reuse_and_hide():
    fig, ax = plt.subplots()
    labels = Labels(ax)
    labels.put({1: np.zeros(2), 2: np.full(2, np.nan), "c": np.ones(2)}, {1: "one", 2: "two", "c": "three"})
    assert labels.names == {1: "one", "c": "three"} and len(labels.get_paths()) == 2
    np.testing.assert_array_equal(labels.get_offsets(), [[0, 0], [1, 1]])
    labels.put({})
    fig.canvas.draw()
    assert len(labels.get_paths()) == 0


def test_states_of_observations(run):
    seen = set()
    for s in run(False):
        for (sen, id), obs in s.obs.items():
            state = obs_state(obs)
            seen.add(state)
            done = [e.kind for e in s.events if e.sen == sen and e.lmk == id]
            assert (state == "updated") == ("correction" in done)
            assert (state is None) == (not obs.visible)
        for id, state in lmk_states(s).items():
            all_states = [obs_state(obs) for (_, lmk), obs in s.obs.items() if lmk == id]
            order = ["updated", "rejected", "predicted"]
            assert state == min((x for x in all_states if x), key=order.index)
    assert {"updated", "predicted", None} <= seen


# ---------------------------------------------------------------------------------------------------------- speed


def test_seventy_ellipsoids_ten_times_a_second(run):
    """Update and drawing, processor time of the best of 8 frames: other work on the machine must not count."""
    s = last(run(False))
    rng = np.random.default_rng(0)
    type = SimpleNamespace(point=lambda l: (l, np.eye(3)))
    s.lmks.clear()
    for i in range(70):
        A = 0.2 * rng.normal(size=(3, 3))
        p, P = rng.uniform([-6, -6, 0], [6, 6, 2]), A @ A.T
        s.lmks[i] = SimpleNamespace(id=i, type=type, point=lambda map, p=p, P=P: (p, P))
    fig = MapFig(s)
    fig.fig.canvas.draw()

    def frame():
        fig.update(s)
        fig.orbit(0.05)
        fig.fig.canvas.draw()

    within(0.1, frame, goes=8)
    assert len(fig.est_lmk.label.where) == 70


def test_a_high_box_is_drawn_smaller_so_that_its_numbers_have_room():
    assert low_enough(np.array([14.0, 14.0, 4.0])) == 1  # a cloister
    assert low_enough(np.array([2.0, 3.2, 2.6])) < 0.85  # a room
    assert low_enough(np.array([1.0, 1.0, 4.0])) < low_enough(np.array([1.0, 1.0, 1.0])) < 1
