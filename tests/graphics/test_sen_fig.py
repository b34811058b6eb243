"""SenFig: each sensor's own measurement space, states told apart by colour and shape, artists made once."""

from collections import deque
from types import SimpleNamespace

import numpy as np
import pytest

from ekfslam_tutorial.graphics import SenFig, ellipse_points, nan_separated
from ekfslam_tutorial.graphics.sen_fig import STATE_STYLE
from ekfslam_tutorial.graphics.spaces import Picture, Plain, Polar, measurement_space
from ekfslam_tutorial.graphics.states import obs_state


def rows(line):
    return np.column_stack(line.get_data())


def last(snapshots):
    return deque(snapshots, maxlen=1)[0]


def observations(s, sen, state):
    return [obs for (i, _), obs in s.obs.items() if i == sen and obs_state(obs) == state]


def test_artists_are_reused(run):
    snapshots = run(False)
    fig = SenFig(next(snapshots))
    fig.fig.canvas.draw()
    before = [id(a) for a in fig.axes.get_children()]
    for s in snapshots:
        fig.update(s)
    fig.fig.canvas.draw()
    assert [id(a) for a in fig.axes.get_children()] == before


@pytest.mark.parametrize("sensor", [1, 2])
def test_a_camera_shows_pixels_with_v_downwards_and_the_image_border(run, sensor):
    s = last(run(False))
    fig = SenFig(s, sensor)
    model = s.sens[sensor - 1].model
    assert fig.axes.get_ylabel() == "v (px)" and fig.axes.yaxis_inverted() and not fig.axes.xaxis_inverted()
    border = rows(fig.axes.lines[0])
    assert {tuple(p) for p in border} == {(u, v) for u in (0, model.image_size[0]) for v in (0, model.image_size[1])}

    np.testing.assert_allclose(rows(fig.raw), s.raw[sensor].y[:, :2])
    updated = observations(s, sensor, "updated")
    assert updated
    np.testing.assert_allclose(rows(fig.expected["updated"]), [obs.e[:2] for obs in updated])
    Z = np.array([obs.E + model.R for obs in updated])[:, :2, :2]
    e = np.array([obs.e[:2] for obs in updated])
    np.testing.assert_allclose(rows(fig.ellipse["updated"]), nan_separated(ellipse_points(e, Z, 3)))


def test_innovations_join_expectation_and_measurement(run):
    s = last(run(False))
    fig = SenFig(s)
    matched = [obs for (i, _), obs in s.obs.items() if i == 1 and obs.matched]
    order = sorted(range(len(matched)), key=lambda i: matched[i].y[0])
    ends = rows(fig.innovation).reshape(-1, 3, 2)[:, :2]
    ends = ends[np.argsort(ends[:, 1, 0])]
    np.testing.assert_allclose(ends[:, 0], np.array([obs.e for obs in matched])[order])
    np.testing.assert_allclose(ends[:, 1], np.array([obs.y for obs in matched])[order])


def test_a_bearing_near_pi_is_joined_the_short_way(run):
    s = last(run(True))
    s.sens[0] = SimpleNamespace(id=1, name="", robot=1, model=s.sens[0].model)
    obs = next(iter(s.obs.values()))
    obs.e, obs.y = np.array([2.0, np.pi - 0.05]), np.array([2.0, -np.pi + 0.05])
    obs.matched = obs.updated = obs.table.visible[obs.k] = True
    s.obs = {(1, obs.lmk): obs}
    angles = rows(SenFig(s).innovation)[:2, 0]
    assert abs(angles[1] - angles[0]) == pytest.approx(0.1)


def test_range_and_bearing_make_a_polar_figure_that_looks_upwards(run):
    s = last(run(True))
    fig = SenFig(s)
    assert isinstance(fig.space, Polar) and fig.axes.get_theta_offset() == pytest.approx(np.pi / 2)
    assert fig.axes.get_theta_direction() == 1  # positive bearings to the left, as in the plane
    np.testing.assert_allclose(rows(fig.raw), s.raw[1].y[:, ::-1])
    assert fig.axes.get_ylim() == (0, 5.5) and fig.axes.get_thetamax() == pytest.approx(120)


def test_new_landmarks_are_marked_at_the_measurement_that_began_them(run):
    s = next(run(True))
    new = [e.lmk for e in s.events if e.kind == "initialisation"]
    fig = SenFig(s)
    assert new and len(rows(fig.new)) == len(new)
    np.testing.assert_allclose(rows(fig.new), s.raw[1].y[np.isin(s.raw[1].ids, new)][:, ::-1])
    assert set(fig.label.where) == set(new) and f"{len(new)} new" in fig.heading.get_text()


def test_a_rejected_measurement_is_shown_as_such(run):
    s = last(run(True))
    obs = observations(s, 1, "updated")[0]
    obs.updated = False
    fig = SenFig(s)
    np.testing.assert_allclose(rows(fig.expected["rejected"]), [obs.e[::-1]])
    assert "1 rejected" in fig.heading.get_text()


def test_states_differ_in_colour_marker_and_line():
    for key in ("color", "marker", "linestyle"):
        values = [style[key] for style in STATE_STYLE.values()]
        assert len(set(values)) == len(values)


def test_legend_explains_all_marks_and_states_k(run):
    fig = SenFig(next(run(True)), k=2)
    texts = [t.get_text() for t in fig.fig.legends[0].get_texts()]
    assert "2σ ellipse (86.5 %) of Z" in texts and "matched measurement" in texts
    assert {f"expected: {state}" for state in STATE_STYLE} <= set(texts)


def test_an_unknown_sensor_is_refused(run):
    with pytest.raises(ValueError, match=r"no sensor 7; known ids: \[1\]"):
        SenFig(next(run(True)), 7)


def test_a_sensor_without_measurements_shows_an_empty_figure(run):
    s = last(run(True))
    s.obs, s.raw, s.events = {}, {}, []
    fig = SenFig(s)
    fig.fig.canvas.draw()
    assert len(rows(fig.raw)) == 0 and fig.heading.get_text().endswith("nothing")


# Sensors of a reader's own: the units of the measurement are all that the figure asks for.


def model(*units, **more):
    m = max(len(units), 1)
    return SimpleNamespace(units=units, R=0.01 * np.eye(m), residual=lambda y, e: y - e, **more)


@pytest.mark.parametrize(
    "sensor, space",
    [
        (model("px", "px", image_size=(640, 480)), Picture),
        (model("px", "px", "m", image_size=(640, 480)), Picture),
        (model("m", "rad"), Polar),
        (model("rad", "m"), Polar),
        (model("rad"), Polar),
        (model("m"), Plain),
        (model("m", "m", "m"), Plain),
        (SimpleNamespace(R=np.eye(2)), Plain),
    ],
)
def test_every_sensor_has_a_space_that_draws(run, sensor, space):
    s = last(run(True))
    m = len(sensor.R)
    sensor.residual = lambda y, e: y - e
    rng = np.random.default_rng(1)
    s.sens = [SimpleNamespace(id=1, name="own", robot=1, model=sensor)]
    s.obs = {}
    for i in range(4):
        e = rng.uniform(0.2, 1.0, m)
        s.obs[1, i] = SimpleNamespace(
            lmk=i, e=e, E=0.02 * np.eye(m), R=None, y=e + 0.1, visible=True, matched=i > 0, updated=i > 1
        )
    s.raw = {1: SimpleNamespace(ids=np.arange(4), y=np.array([obs.y for obs in s.obs.values()]))}
    s.events = []
    fig = SenFig(s)
    assert isinstance(measurement_space(fig.fig, sensor), space) and isinstance(fig.space, space)
    fig.fig.canvas.draw()
    assert [len(rows(fig.expected[state])) for state in ("updated", "rejected", "predicted")] == [2, 1, 1]
    curves = rows(fig.ellipse["updated"])
    assert np.isnan(curves[:, 0]).sum() == 2 and np.isfinite(curves).any()
    if space is Plain:
        low, high = np.array([fig.axes.get_xlim(), fig.axes.get_ylim()]).T
        shown = rows(fig.raw)
        assert ((shown > low) & (shown < high)).all()
    if space is Plain and m == 1:  # over the landmarks' ids, which are whole numbers
        assert fig.axes.get_xlabel() == "measurement (m)"
        assert (fig.axes.get_yticks() % 1 == 0).all()


def test_a_bearing_alone_is_a_sector_of_three_sigma(run):
    s = last(run(True))
    s.sens = [SimpleNamespace(id=1, name="", robot=1, model=model("rad"))]
    s.obs = {
        (1, 5): SimpleNamespace(
            lmk=5, e=np.array([0.5]), E=np.array([[0.03]]), R=None, y=None, visible=True, matched=False, updated=False
        )
    }
    s.raw, s.events = {}, []
    angles = rows(SenFig(s).ellipse["predicted"])[:-1, 0]
    assert (angles.min(), angles.max()) == pytest.approx((0.5 - 3 * 0.2, 0.5 + 3 * 0.2))
