"""Errors and covariances in one gauge: the algebra, and honest filters that stay in their bands."""

from dataclasses import replace

import numpy as np
import pytest

from ekfslam_tutorial.analysis import History, anees_band, batch_slam, md2
from ekfslam_tutorial.analysis.gauge import (
    MapGauge,
    _lower_quartile,
    distance_weights,
    point_generator,
    pose_generator,
    start_gauge,
)
from ekfslam_tutorial.cli.files import find_scenario
from ekfslam_tutorial.geometry import Frame2, Frame3, v2q
from ekfslam_tutorial.models.landmarks import EucPnt
from ekfslam_tutorial.models.motion import Odometry2
from ekfslam_tutorial.models.sensors import RangeBearing
from ekfslam_tutorial.simulation import worlds
from ekfslam_tutorial.toolbox import Landmark, Options, Recorder, Robot, Sensor, Time, UserData, World, universal_slam

RUNS, FRAMES = 500, (8, 20, 40)


def small_motion(g):
    """A motion [t; angle or angles] of the world, as a frame."""
    return Frame2(g) if len(g) == 3 else Frame3(np.concatenate([g[:3], v2q(g[3:])[0]]))


def some_pose(rng, d):
    if d == 2:
        return Frame2(rng.normal(size=3))
    q = rng.normal(size=4)
    return Frame3(np.concatenate([rng.normal(size=3), q / np.linalg.norm(q)]))


def covariance(rng, n, scale=1e-3):
    A = rng.normal(size=(n, n))
    return scale**2 * (A @ A.T + 0.1 * np.eye(n))


@pytest.mark.parametrize("d", [2, 3])
def test_generators_are_derivatives_by_a_motion_of_the_world(rng, d):
    F, p, h = some_pose(rng, d), rng.normal(size=(4, d)), 1e-6
    for k in range(F.dof):
        g = h * np.eye(F.dof)[k]
        plus, minus = small_motion(g), small_motion(-g)
        change = plus.compose(F)[0].minus(minus.compose(F)[0])[0] / (2 * h)
        np.testing.assert_allclose(pose_generator(F)[:, k], change, atol=1e-8)
        change = (plus.from_frame(p)[0] - minus.from_frame(p)[0]) / (2 * h)
        np.testing.assert_allclose(point_generator(p)[..., k], change, atol=1e-8)


@pytest.mark.parametrize("d", [2, 3])
def test_the_derivatives_of_the_error_are_right(rng, d):
    """Move one number of the estimate: the error moves as E_x and E_l say. The weights are held."""
    pose, true_points, P = some_pose(rng, d), rng.normal(size=(6, d)), covariance(rng, 6 * d)
    points = true_points + 1e-4 * rng.normal(size=true_points.shape)
    truth = Frame2(pose.x + 1e-4) if d == 2 else Frame3(pose.x + 1e-4).normalized()[0]
    gauge = MapGauge(points, true_points, P)
    _, E_x, E_l = gauge.error(pose, truth)
    h = 1e-5
    for k in range(pose.size):
        dx = h * np.eye(pose.size)[k]
        ends = [gauge.error(type(pose)(pose.x + s * dx), truth)[0] for s in (1, -1)]
        np.testing.assert_allclose(E_x[:, k], (ends[0] - ends[1]) / (2 * h), atol=1e-3)
    for k in range(points.size):
        dp = h * np.eye(points.size)[k].reshape(points.shape)
        ends = [MapGauge(points + s * dp, true_points, P).error(pose, truth)[0] for s in (1, -1)]
        np.testing.assert_allclose(E_l[:, k], (ends[0] - ends[1]) / (2 * h), atol=1e-3)


@pytest.mark.parametrize("d", [2, 3])
def test_the_gauge_of_the_covariance_does_not_matter(rng, d):
    """Uncertainty of where the world lies, put into P, does not come through; and the frame of the truth is free."""
    n, pose = 7, some_pose(rng, d)
    points = rng.normal(size=(n, d))
    P = covariance(rng, pose.dof + n * d)
    to_error = np.linalg.pinv(pose.minus(pose)[1])  # P is that of the error: by the state vector in space, 7 numbers
    G = np.concatenate([pose_generator(pose), point_generator(points).reshape(n * d, -1)])
    free = P + G @ covariance(rng, pose.dof, 0.1) @ G.T
    world, found = some_pose(rng, d), []
    for Q, F in ((P, small_motion(np.zeros(pose.dof))), (free, world)):
        gauge = MapGauge(points, F.from_frame(points)[0], P[pose.dof :, pose.dof :])
        e, E_x, E_l = gauge.error(pose, F.compose(pose)[0])
        E = np.concatenate([E_x @ to_error, E_l], 1)
        np.testing.assert_allclose(e, 0, atol=1e-9)
        turn = np.eye(pose.dof)
        turn[:d, :d] = F.Rt
        found.append(turn @ E @ Q @ E.T @ turn.T)
    np.testing.assert_allclose(found[0], found[1], rtol=1e-6, atol=1e-12)


def test_a_landmark_far_away_and_ill_known_weighs_nothing(rng):
    points = np.concatenate([rng.normal(size=(8, 2)), [[500.0, 0.0]]])
    P = np.kron(np.diag([*np.full(8, 1e-4), 1e4]), np.eye(2))
    weights = distance_weights(points, P)
    assert weights[:8].min() > 0.5 and weights[8] < 1e-6
    truth = points.copy()
    truth[8] += [0.0, 90.0]
    assert np.abs(MapGauge(points, truth, P).F.x).max() < 1e-3


@pytest.mark.parametrize("n", [2, 3, 5, 9])
def test_the_lower_quartile_is_that_of_numpy(rng, n):
    a = rng.random((7, n))
    a[np.arange(7), np.arange(7) % n] = np.nan
    a[0, : n - 1] = np.nan
    a[0, -1] = 0.5
    np.testing.assert_allclose(_lower_quartile(a), np.nanquantile(a, 0.25, axis=1), rtol=1e-14)


def test_weights_do_not_depend_on_the_gauge(rng):
    points, P = rng.normal(size=(9, 3)), covariance(rng, 27)
    G = point_generator(points).reshape(27, 6)
    free = P + G @ covariance(rng, 6, 10.0) @ G.T
    np.testing.assert_allclose(distance_weights(points, free), distance_weights(points, P), rtol=1e-4)
    assert distance_weights(points, np.zeros((27, 27))).tolist() == [1.0] * 9


def scenario(frames=FRAMES[-1]):
    """A robot on a circle in a ring of landmarks, with noise so small that the filter is as good as linear."""
    robot = Robot(
        id=1,
        motion=Odometry2(),
        position=[1, -2],
        orientation_deg=20,
        control={"dx": [0.15, 0], "da_deg": 4.0},
        control_std={"dx": 1e-3, "da_deg": 0.05},
    )
    return UserData(
        robots=[robot],
        sensors=[Sensor(id=1, robot=1, model=RangeBearing(range_std=5e-3, bearing_std=2e-3))],
        landmark=Landmark(model=EucPnt(2)),
        world=World(build=lambda rng: worlds.ring(n=6, radius=4.0), type="ring"),
        time=Time(last=frames),
        options=Options(),
    )


@pytest.fixture(scope="module")
def many():
    """NEES of 500 runs in some frames: in the gauge of the map, of the start, and the two taken for each other."""
    found = {}
    for k, now in enumerate(batch_slam(scenario(), range(RUNS)), 1):
        if k == 1:
            first = now.x[:, :3].copy(), now.P[:, :3, :3].copy(), np.array(now.truth)
        if k not in FRAMES:
            continue
        for r in range(RUNS):
            truth, pose, P = Frame2(now.truth[r]), Frame2(now.x[r, :3]), now.P[r]
            gauge = MapGauge(now.x[r, 3:].reshape(-1, 2), now.points[r], P[3:, 3:])
            e, E_x, E_l = gauge.error(pose, truth)
            E = np.concatenate([E_x, E_l], 1)
            two = [Frame2(np.array([a[r], b])) for a, b in ((first[0], now.x[r, :3]), (first[2], now.truth[r]))]
            d, D = start_gauge(two[0], np.array([first[1][r], P[:3, :3]]), two[1])
            for name, value in (
                ("map", md2(e, E @ P @ E.T)),
                ("start", md2(d[1], D[1])),
                ("mixed", md2(e, E_x @ P[:3, :3] @ E_x.T)),
            ):
                found.setdefault((name, k), []).append(value)
    return {key: np.array(values) for key, values in found.items()}


@pytest.mark.parametrize("gauge", ["map", "start"])
@pytest.mark.parametrize("k", FRAMES)
def test_an_honest_filter_is_honest_in_each_gauge(many, gauge, k):
    """500 runs: the mean in its 99 % band (2.73 to 3.29), and the runs where the quantiles say that they are.

    At most 13 of 500 above the 99 % quantile, where 5 are expected, and 12 to 41 above that of 95 %: bands of 99.9 %.
    """
    values = many[gauge, k]
    low, high = anees_band(3, RUNS, 0.99)
    assert low < values.mean() < high
    assert (values > 11.345).sum() <= 13 and 12 <= (values > 7.815).sum() <= 41


def test_an_error_in_one_gauge_beside_the_covariance_in_another_is_no_test(many):
    """The error after alignment is smaller than P relative to the start says, so a filter seems too cautious."""
    low, _ = anees_band(3, RUNS, 0.9999)
    assert all(many["mixed", k].mean() < 0.8 * low for k in FRAMES[1:])


@pytest.mark.parametrize("angles", [3, 1])
def test_the_start_gauge_in_space(rng, angles):
    """400 honest trajectories of a robot with a prior on its start, six numbers uncertain: NEES 6 in its 99 % band.

    A true motion of the world is hidden in the estimate, by all angles that are free.
    """
    runs, turn = 400, [0.4, 0.3, 2.0] if angles == 3 else [0.0, 0.0, 2.0]
    world, step = (
        small_motion(np.array([3.0, -2.0, 1.0, *turn])),
        small_motion(np.array([0.5, 0.1, 0.2, 0.1, -0.2, 0.3])),
    )
    truth = some_pose(rng, 3)
    P, Q = covariance(rng, 6, 2e-3), covariance(rng, 6, 5e-4)
    if angles == 1:  # tilt is known apart from the rest; here about the axes of the world, below about the robot's
        P[3:5, [0, 1, 2, 5]] = P[[0, 1, 2, 5], 3:5] = 0
        to_world = np.eye(6)
        to_world[3:, 3:] = truth.R
        P = to_world.T @ P @ to_world
    first = _shifted(truth, rng.multivariate_normal(np.zeros(6), P, runs))
    P_0, start, x = P, truth, first
    for _ in range(5):
        A = _by_error(truth, step)
        P, truth = A @ P @ A.T + Q, truth.compose(step)[0]
        x = _shifted(x.compose(step)[0], rng.multivariate_normal(np.zeros(6), Q, runs))
    ends = world.compose(Frame3(np.array([start.x, truth.x])))[0]
    found = []
    for a, b in zip(first.x, x.x, strict=True):
        e, D = start_gauge(Frame3(np.array([a, b])), np.array([P_0, P]), ends, angles)
        np.testing.assert_allclose(e[0][: 6 if angles == 3 else 3], 0, atol=1e-12)
        found.append(md2(e[1], D[1]))
    low, high = anees_band(6, runs, 0.99)
    assert low < np.mean(found) < high
    assert np.mean(md2(world.compose(x)[0].minus(world.compose(truth)[0])[0], D[1])) > 1.2 * high, "P_0 is in it"


def _shifted(F, e):
    """The poses that differ from F by the errors e, as `minus` has them."""
    q = F.compose(Frame3(np.concatenate([0 * e[..., :3], v2q(e[..., 3:])[0]], -1)))[0].q
    return Frame3(np.concatenate([F.t + e[..., :3], q], -1))


def _by_error(F, step):
    """Derivative of the error of F.compose(step) by that of F, by central differences."""
    moved = lambda e: _shifted(F, e).compose(step)[0]
    return np.array([moved(1e-6 * e).minus(moved(-1e-6 * e))[0] / 2e-6 for e in np.eye(6)]).T


def test_history_has_the_errors_of_the_gauge_of_the_map():
    history = History("free")
    for _ in history.watch(universal_slam(scenario(12), seed=3)):
        pass
    s, (e, P) = history.last, history.errors(1)
    rob, r = s.robs[0], [s.lmks[i].r for i in s.lmks]
    at = np.concatenate([np.arange(3) + rob.r.start, *(np.arange(q.start, q.stop) for q in r)])
    joint, places = s.map.P[np.ix_(at, at)], dict(zip(s.sim_lmk.ids.tolist(), s.sim_lmk.points, strict=True))
    gauge = MapGauge(np.array([s.map.x[q] for q in r]), np.array([places[i] for i in s.lmks]), joint[3:, 3:])
    value, E_x, E_l = gauge.error(rob.frame(s.map), Frame2(s.truth[1]))
    E = np.concatenate([E_x, E_l], 1)
    np.testing.assert_allclose(e[-1], value, atol=1e-12)
    np.testing.assert_allclose(P[-1], E @ joint @ E.T, atol=1e-15)
    assert history.summary()["nees_mean"] == pytest.approx(np.nanmean(md2(e, P)))
    assert history.honesty().nees == pytest.approx(np.nanmean(md2(e, P)))


@pytest.mark.parametrize(("radius", "is_one"), [(5e-4, False), (1.0, True)])
def test_a_map_that_does_not_tell_how_a_robot_is_turned_is_no_gauge(radius, is_one):
    """Two landmarks that are measured to some millimetres: a millimetre apart they have a direction by chance only."""
    history, two = History("free"), worlds.ring(n=2, radius=radius, centre=(3.0, 0.0))
    for _ in history.watch(
        universal_slam(replace(scenario(5), world=World(build=lambda rng: two, type="ring")), seed=3)
    ):
        pass
    e, P = history.errors(1)
    known = np.isfinite(e).all(1)
    assert (known == np.isfinite(P).all((1, 2))).all()
    assert (known.mean() > 0.5) == is_one  # by chance they may seem further apart in a frame


def test_without_surveyed_landmarks_it_is_the_gauge_of_the_start():
    history = History("free")
    for s in history.watch(universal_slam(scenario(12), seed=3)):
        s.sim_lmk = None
    e, P = history.errors(1)
    track = history.track(1)
    np.testing.assert_allclose(e[0], 0, atol=1e-12)
    assert np.isfinite(md2(e, P)[2:]).all() and P.shape == track.P.shape


def test_a_far_landmark_does_not_spoil_the_alignment():
    """A camera alone, 72 inverse-depth points, some never seen well: aligned by all alike, the ATE was 4.06 m."""
    data = UserData.from_toml(find_scenario("constant_velocity"))
    history = History()
    for _ in history.watch(universal_slam(data)):
        pass
    f = history.summary()
    assert f["ate_rmse_m"] == pytest.approx(0.209, abs=0.001)
    assert f["ate_aligned_m"] < 1.2 * f["ate_rmse_m"]


def test_looking_on_does_not_change_a_compressed_run():
    """Errors in the gauge of the map are taken in each frame: the run is the same without them, to the last bit."""
    recorder = Recorder()
    for s in universal_slam(scenario(25), seed=4):
        recorder.add(s)
    recording = recorder.recording("run")
    ends = []
    for watched in (True, False):
        data = scenario(25)
        data = replace(data, options=replace(data.options, compressed=True))
        history = History("free")
        for s in universal_slam(data, recording, seed=4):
            if watched:
                history.add(s)
        ends.append((np.array(s.map.x), np.array(s.map.P)))
    for a, b in zip(*ends, strict=True):
        np.testing.assert_array_equal(a, b)
