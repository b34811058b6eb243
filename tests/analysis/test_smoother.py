"""The smoother: the filter where models are linear, GTSAM where that is installed, nearer to the truth elsewhere."""

import importlib.util
from dataclasses import replace

import numpy as np
import pytest

from ekfslam_tutorial.analysis.factors import Guess, Motion, Prior, graph_of, innovations
from ekfslam_tutorial.analysis.graph_files import parts_of
from ekfslam_tutorial.analysis.smoother import smooth, smooth_lagged
from ekfslam_tutorial.cli.files import scenarios
from ekfslam_tutorial.geometry import Frame2, numerical_jacobian, wrap
from ekfslam_tutorial.models import observe
from ekfslam_tutorial.models.landmarks import Beacon, EucPnt
from ekfslam_tutorial.models.motion import Odometry2
from ekfslam_tutorial.models.observation import ItsRobot
from ekfslam_tutorial.models.sensors import Gps, PointXY, Range
from ekfslam_tutorial.toolbox import Landmark, Options, Robot, Sensor, Time, UserData, World, universal_slam

from ..toolbox.scenarios import FLAT, SPACE

PLANE = FLAT | {"time": {"dt": 0.5, "last": 20}}
ODOMETRY = PLANE | {
    "robot": [
        {
            "motion": "odometry2",
            "position": [0.0, -4.0],
            "dx": [0.5, 0.0],
            "da_deg": 7.2,
            "dx_std": 0.05,
            "da_std_deg": 1.0,
        }
    ],
}
ROUND = {"time": {"dt": 0.5, "last": 60}}
CAMERA = SPACE | {"time": {"last": 8}}


def linear(last=15):
    """A robot that knows its heading, and a sensor that measures positions relative to it: nothing bends."""
    robot = Robot(motion=Odometry2(), control={"dx": [0.4, 0.1]}, control_std={"dx": 0.1}, position_std=0.2)
    world = World.of(np.array([[1.0, 1.0], [4.0, -1.0], [7.0, 2.0]]))
    options = Options(error="additive", joint=True)
    return UserData(
        robots=[robot],
        sensors=[Sensor(model=PointXY(0.1, max_range=4.0))],
        world=world,
        time=Time(last=last),
        options=options,
    )


def error(graph, x):
    """Root mean square distance of a track from the truth."""
    truth = np.array([graph.truth["robot", 1, k] for k in range(1, len(graph.t))])
    d = truth.shape[1] // 2 if truth.shape[1] == 7 else 2
    return np.sqrt(((x[1:, :d] - truth[:, :d]) ** 2).sum(1).mean())


def test_where_all_is_linear_the_end_is_that_of_the_filter():
    found = smooth(graph_of(linear()))
    (x, P), (y, Q) = found.track(1), found.filtered(1)
    assert found.converged and len(found.steps) <= 3
    np.testing.assert_allclose(x[-1], y[-1], atol=1e-10)
    np.testing.assert_allclose(P[-1], Q[-1], atol=1e-10)
    assert np.abs(x[3] - y[3]).max() > 1e-3  # and before the end it knows more
    assert (np.trace(P, axis1=1, axis2=2)[3:-1] < np.trace(Q, axis1=1, axis2=2)[3:-1]).all()
    for id, (p, P_p) in found.landmarks().items():
        l, P_l = found.graph.filtered["landmark", id]
        np.testing.assert_allclose(p, l, atol=1e-10)
        np.testing.assert_allclose(P_p, P_l, atol=1e-10)


@pytest.mark.parametrize("lag", [1, 4, 100])
def test_where_all_is_linear_every_lag_ends_the_same(lag):
    found = smooth_lagged(graph_of(linear()), lag)
    (x, P), (y, Q) = found.track(1), found.filtered(1)
    np.testing.assert_allclose(x[-1], y[-1], atol=1e-10)
    np.testing.assert_allclose(P[-1], Q[-1], atol=1e-10)
    for k in (6, 9):  # a state knows what was measured until so many frames later
        whole = smooth(graph_of(linear(min(k + lag, 15))))
        np.testing.assert_allclose(x[k], whole.track(1)[0][k], atol=1e-10)
        np.testing.assert_allclose(P[k], whole.track(1)[1][k], atol=1e-10)


@pytest.mark.parametrize(
    "table",
    [
        PLANE | ROUND,
        ODOMETRY | ROUND,
        CAMERA,
        PLANE | ROUND | {"options": {"association": "nearest_neighbour", "engine": "fast"}},
    ],
    ids=["unicycle", "odometry", "camera", "unknown ids"],
)
def test_it_converges_and_is_nearer_to_the_truth(table):
    data = UserData.from_dict(table)
    found = smooth(graph_of(data))
    assert found.converged and len(found.steps) < 20
    assert error(found.graph, found.track(1)[0]) < error(found.graph, found.filtered(1)[0])
    for P in found.P.values():
        assert np.linalg.eigvalsh(P)[0] > -1e-9 * max(np.abs(P).max(), 1e-3)


def test_with_a_lag_it_is_between_the_filter_and_all_at_once():
    data = UserData.from_dict(PLANE | ROUND)
    found, lagged = smooth(graph_of(data)), smooth_lagged(graph_of(data), 10, iterations=2)
    ends = found.filtered(1)[0], lagged.track(1)[0], found.track(1)[0]
    filtered, late, all_at_once = (error(found.graph, x) for x in ends)
    assert all_at_once < late < filtered


def test_a_lag_as_long_as_the_run_is_all_at_once():
    """Eight steps at each frame leave less than 1e-6 m of the way to the end."""
    data = UserData.from_dict(ODOMETRY)
    found, lagged = smooth(graph_of(data)), smooth_lagged(graph_of(data), 100, iterations=8)
    np.testing.assert_allclose(lagged.track(1)[0], found.track(1)[0], atol=1e-6)
    keys = [("robot", 1, 20), *(key for key in found.P if key[0] == "landmark")]
    np.testing.assert_allclose(lagged.joint(keys), found.joint(keys), atol=1e-6)
    np.testing.assert_allclose(found.joint(keys)[:3, :3], found.P[keys[0]], atol=1e-12)
    with pytest.raises(ValueError, match="'robot', 1, 3.* is no variable of the last system"):
        smooth_lagged(graph_of(data), 5, iterations=1).joint([("robot", 1, 3)])


def test_over_many_seeds_the_path_is_better():
    """Median over 3 seeds of the smoother's error by the filter's, of a round that closes: 0.4 to 0.95."""
    data = UserData.from_dict(ODOMETRY | ROUND)
    ratios = []
    for seed in range(3):
        found = smooth(graph_of(data, seed=seed))
        ratios.append(error(found.graph, found.track(1)[0]) / error(found.graph, found.filtered(1)[0]))
    assert 0.4 < np.median(ratios) < 0.95


def test_the_normalised_error_of_the_path_is_one():
    """NEES by degree of freedom over all states of 8 seeds; they are correlated: band 0.6 to 1.5."""
    table = ODOMETRY | {"robot": [ODOMETRY["robot"][0] | {"dx_std": 0.02, "da_std_deg": 0.3}]}
    data, nees = UserData.from_dict(table), []
    for seed in range(8):
        found = smooth(graph_of(data, seed=seed))
        x, P = found.track(1)
        for k in range(1, len(x)):
            d = found.graph.difference(("robot", 1), x[k], found.graph.truth["robot", 1, k])
            nees.append(d @ np.linalg.solve(P[k], d) / 3)
    assert 0.6 < np.mean(nees) < 1.5


def test_robots_that_meet_and_mountings_that_are_estimated():
    two = PLANE | {
        "robot": [PLANE["robot"][0], PLANE["robot"][0] | {"id": 2, "position": [0.0, 4.0]}],
        "sensor": [
            PLANE["sensor"][0] | {"frame_in_map": True, "position_std": 0.05},
            PLANE["sensor"][0] | {"id": 2, "robot": 2},
        ],
    }
    found = smooth(graph_of(UserData.from_dict(two)))
    assert found.converged and found.graph.robots == [1, 2] and ("sensor", 1) in found.P
    assert found.P["sensor", 1][0, 0] < 0.05**2


@pytest.mark.parametrize("table", [PLANE, SPACE | {"time": {"last": 12}}], ids=["plane", "space"])
def test_a_recovery_of_the_filter_is_noise_of_the_next_step(table):
    lost = {"md2_threshold": 3.0, "reopen_after": 2, "reopen_std": [0.3, 0.1]}
    found = smooth(graph_of(UserData.from_dict(table | {"options": table.get("options", {}) | lost})))
    assert any(isinstance(f, Motion) and f.loosened is not None for f in found.graph.stiff)
    assert found.converged


def test_landmarks_that_the_filter_has_deleted_are_not_in_the_graph():
    options = {"association": "nearest_neighbour", "min_match_ratio": 0.8, "min_search": 3}
    sensor = PLANE["sensor"][0] | {"p_detect": 0.7, "clutter": 0.5}
    data = UserData.from_dict(PLANE | {"options": options, "sensor": [sensor]})
    deleted = {e.lmk for now in universal_slam(data) for e in now.events if e.kind == "deletion"}
    found = smooth(graph_of(data))
    assert deleted and found.converged and set(found.landmarks()) == set(found.graph.types)


def test_what_nothing_fixes_is_refused():
    graph = graph_of(linear())
    graph.stiff = [factor for factor in graph.stiff if not isinstance(factor, Motion) or factor.after[2] != 15]
    graph.looks = [look for look in graph.looks if look.k != 15]
    with pytest.raises(ValueError, match="the factors do not fix all variables"):
        smooth(graph)
    with pytest.raises(ValueError, match="the lag is a number of frames, 1 or more, got 0"):
        smooth_lagged(graph_of(linear()), 0)


@pytest.mark.parametrize("kind", [EucPnt(2), Beacon(bias_std=0.5)], ids=["points", "beacons"])
def test_beacons_that_were_born_as_rings(kind):
    """All their ranges are smoothed, those of the ring, too; and what was guessed of their faults counts once."""
    points = np.array([[2.0, 3.0], [-6.0, 1.0]])
    robot = Robot(
        motion=Odometry2(), position=[0, -4], control={"dx": [0.5, 0.0], "da_deg": 6.0}, control_std={"dx": 0.02}
    )
    data = UserData(
        robots=[robot],
        sensors=[Sensor(model=Range(range_std=0.1))],
        world=World.of(points),
        time=Time(last=60),
        landmark=Landmark(model=kind, hypotheses=64),
    )
    found = smooth(graph_of(data))
    assert found.converged and set(found.landmarks()) == {1, 2}
    assert sum(len(look.lmks) for look in found.graph.looks) == 2 * 60
    assert sum(isinstance(f, Guess) for f in found.graph.stiff) == (2 if isinstance(kind, Beacon) else 0)
    for id, (p, P) in found.landmarks().items():
        d = p - points[id - 1]
        assert d @ np.linalg.solve(P, d) < 13.8  # 99.9 % of honest ones


# --- sensors that see no landmark, measure velocities, or have parameters that are states ---


def with_gps():
    """The linear run, with a GPS that is always off by the same, and tells a position in most frames."""
    data = linear()
    gps = Sensor(id=2, model=Gps(0.3), params_in_map=["bias"], params_std={"bias": [0.5, 0.5]}, p_detect=0.7)
    return replace(data, sensors=[*data.sensors, gps])


@pytest.mark.parametrize("how", [smooth, lambda graph: smooth_lagged(graph, 4)], ids=["all at once", "lag"])
def test_gps_and_its_bias_where_all_is_linear(how):
    found = how(graph_of(with_gps()))
    graph = found.graph
    assert sum(isinstance(look.type, ItsRobot) for look in graph.looks) > 5
    for key in ("robot", 1, len(graph.t) - 1), ("sensor", 2):
        np.testing.assert_allclose(graph.values[key], graph.filtered[key][0], atol=1e-10)
        np.testing.assert_allclose(found.P[key], graph.filtered[key][1], atol=1e-10)


def scenario(name, last, **overrides):
    return UserData.from_toml(scenarios()[name], {"time.last": last} | overrides)


DELAY = {"sensor.1.params_in_map": ["delay", "bias"], "sensor.1.delay_std": 0.05, "sensor.1.bias_std": 0.05}


@pytest.mark.parametrize(
    "data",
    [scenario("doppler", 4, **DELAY), scenario("ground_flow", 4), scenario("gps_compass", 4)],
    ids=["doppler, late", "flow and range rates", "gps and compass"],
)
def test_the_derivatives_of_what_such_sensors_say(data):
    graph = graph_of(data)
    for look in graph.looks:
        ((z, _, each, _),) = innovations(graph, [look])
        for key in {key for blocks in each for key in blocks}:
            x = graph.values[key].copy()

            def moved(v, look=look, key=key):
                graph.values[key] = v
                return next(innovations(graph, [look]))[0].ravel()

            J = numerical_jacobian(moved, x)
            graph.values[key] = x
            want = np.concatenate([blocks.get(key, np.zeros((z.shape[1], len(x)))) for blocks in each])
            np.testing.assert_allclose(want, -J, atol=1e-5)  # of y - h, by differences of 1e-6 or so


@pytest.mark.parametrize("name, last", [("doppler", 15), ("lever_arm", 20), ("focal_length", 10)])
def test_what_is_estimated_of_a_sensor_is_that_of_the_filter_at_its_end(name, last):
    """Both have seen the same; they differ by where they linearise: by less than 1.5 of their standard deviations."""
    found = smooth(graph_of(scenario(name, last)))
    assert found.converged
    for key, x in found.graph.values.items():
        if key[0] == "sensor":
            std = np.sqrt(np.diag(found.P[key]).clip(1e-12))
            assert (np.abs(x - found.graph.filtered[key][0]) < 1.5 * std).all()
            assert std.max() > 1e-3


def test_an_edge_for_other_programs_has_the_bias_taken_off():
    sensor = Sensor(model=PointXY(0.1), params_in_map=["bias"], params_std={"bias": [0.2, 0.2]})
    graph = graph_of(replace(linear(3), sensors=[sensor]))
    graph.values["sensor", 1][3:] = bias = np.array([0.1, -0.2])  # nothing shows it in this run: as if it were found
    measured = np.concatenate([look.y for look in graph.looks])
    np.testing.assert_allclose([edge[2] for edge in parts_of(graph).looks], measured - bias, atol=1e-12)


def test_parameters_that_walk_are_refused():
    with pytest.raises(ValueError, match="sensor 2 has parameters that walk; the smoother knows constant ones only"):
        graph_of(scenario("doppler", 3, **{"sensor.2.scale_walk": 0.01}))


# --- GTSAM, where it is installed ---


@pytest.mark.skipif(importlib.util.find_spec("gtsam") is None, reason="GTSAM is not installed: pip install gtsam")
def test_gtsam_finds_the_same():
    import gtsam

    robot = ODOMETRY["robot"][0] | {"position_std": 0.05, "orientation_std_deg": 1.0}
    found = smooth(graph_of(UserData.from_dict(ODOMETRY | {"robot": [robot]})))
    g, factors, values = found.graph, gtsam.NonlinearFactorGraph(), gtsam.Values()
    name = {key: gtsam.symbol(key[0][0], key[2] if key[0] == "robot" else key[1]) for key in g.values}

    def add(C, keys, f):
        """A factor of GTSAM: the error f of some vectors, with its Jacobians."""

        def error(this, values, H):
            e, *J = f(*(values.atVector(key) for key in this.keys()))
            for k in range(0 if H is None else len(J)):
                H[k] = J[k]
            return e

        names = [name[key] for key in keys]
        factors.add(gtsam.CustomFactor(gtsam.noiseModel.Gaussian.Covariance(C), names, error))

    def step(u, a, b):
        I, I_a = Frame2(a).inverse()
        B, B_i, B_b = I.compose(Frame2(b))
        e = B.x - u
        e[2] = wrap(e[2])
        return e, B_i @ I_a, B_b

    for key, x in g.values.items():
        values.insert(name[key], x + 0.01)  # it has to find its own way
    for f in g.stiff:
        if isinstance(f, Prior):
            add(f.P, f.keys, lambda x, f=f: (x - f.x, np.eye(3)))
        else:
            add(f.U, [f.before, f.after], lambda a, b, f=f: step(f.u, a, b))
    for look in g.looks:
        for l, y, R in zip(look.lmks, look.y, look.R, strict=True):
            h = lambda x, p, look=look: observe(Frame2(x), Frame2(look.mount), look.sensor, EucPnt(2), p)

            def seen(x, p, h=h, y=y, look=look):
                e, E_r, _, E_l = h(x, p)
                return look.sensor.residual(e, y), E_r, E_l

            add(R, [look.pose, l], seen)
    for _ in range(20):
        values = values.retract(factors.linearize(values).optimize())
    marginals = gtsam.Marginals(factors, values)
    for key, x in g.values.items():
        np.testing.assert_allclose(values.atVector(name[key]), x, atol=1e-8)
        np.testing.assert_allclose(marginals.marginalCovariance(name[key]), found.P[key], atol=1e-8)
