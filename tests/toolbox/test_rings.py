"""Beacons that are born from one range: births, weights, honesty, and the same numbers by both engines."""

from copy import deepcopy
from dataclasses import replace

import numpy as np
import pytest

from ekfslam_tutorial.ekf import Map, covariance, cross, innovation
from ekfslam_tutorial.geometry import Frame2
from ekfslam_tutorial.models.landmarks import Beacon, EucPnt
from ekfslam_tutorial.models.motion import Odometry2, Odometry3
from ekfslam_tutorial.models.sensors import Range, RangeBearing
from ekfslam_tutorial.slam import Lmk, NearestNeighbour, Rob, Sen
from ekfslam_tutorial.slam.projection import correct_invariant
from ekfslam_tutorial.toolbox import Landmark, Options, Robot, Sensor, Time, UserData, World, rings, universal_slam
from ekfslam_tutorial.toolbox.recordings import Recorder
from ekfslam_tutorial.toolbox.run_state import run_state


def scenario(points, last=60, turn=3.0, kind=None, std=0.1, noise=(0.01, 0.005), options=None, most=64, mount=0.0):
    """A robot in the plane that hears beacons and nothing else."""
    control = {"dx": [0.5, 0], "da_deg": turn}
    robot = Robot(motion=Odometry2(), position=[0, -4], control=control, control_std={"dx": list(noise), "da_deg": 0.1})
    return UserData(
        robots=[robot],
        sensors=[Sensor(model=Range(range_std=std), orientation_deg=mount)],
        world=World.of(points),
        time=Time(last=last),
        landmark=Landmark(model=kind, hypotheses=most),
        options=Options(**options or {}),
    )


def scattered(seed, n=3, size=15.0):
    return np.random.default_rng(seed).uniform(-size, size, (n, 2))


def the_right_one(now, id, p):
    """Squared Mahalanobis distance of the truth from the landmark, or from the nearest hypothesis."""
    if id in now.lmks:
        m, P = (a[None] for a in now.lmks[id].point(now.map))
    else:
        m, P = now.rings[id].points(now.map)
    d = m - p
    return np.einsum("hi,hi->h", d, np.linalg.solve(P, d[..., None])[..., 0]).min()


# --- a ring ---


@pytest.mark.parametrize("dim, n", [(2, 12), (3, 40)])
def test_sectors_together_are_the_ring(dim, n):
    """Mean and covariance of all of them: those of a circle or sphere, with the noise of the range along the rays."""
    r, std = 10.0, 0.5
    v, V = rings.sectors(r, std**2, dim, n)
    mean, P = rings.moments(np.full(n, 1 / n), v, V)
    assert np.allclose(mean, 0, atol=0.02 * r * (dim - 2) + 1e-9)
    assert np.allclose(P, (r**2 + std**2) / dim * np.eye(dim), rtol=0, atol=0.01 * r**2 * (dim - 2) + 1e-9)


def test_a_sector_has_the_moments_of_its_points():
    rng = np.random.default_rng(1)
    v, V = rings.sectors(10.0, 0.25, 2, 9)
    a = np.pi / 9 * (1 + rng.uniform(-1, 1, 200_000))  # the first sector begins at the x axis
    p = (10 + rng.normal(0, 0.5, len(a)))[:, None] * np.stack([np.cos(a), np.sin(a)], -1)
    assert np.allclose(v[0], p.mean(0), atol=0.03)
    assert np.allclose(V[0], np.cov(p.T), atol=0.06)


def test_wide_rings_and_good_ranges_need_more_hypotheses():
    few, many = rings.how_many(5.0, 0.5, 2, 64), rings.how_many(50.0, 0.1, 2, 999)
    assert 8 <= few < many and rings.how_many(50.0, 0.1, 2, 64) <= 64
    p, V = rings.sectors(50.0, 0.01, 2, many)
    assert rings.bend(p[0], V[0], 0.1) < 1.02 * rings.STRAIGHT


def test_weights_are_those_of_bayes():
    """With known poses, against a fine grid round the ring, which needs no hypothesis."""
    rng, beacon, std = np.random.default_rng(4), np.array([6.0, 8.0]), 0.3
    path = np.array([[0.4 * k, 0.3 * np.sin(0.5 * k)] for k in range(12)])
    y = np.linalg.norm(path - beacon, axis=1) + rng.normal(0, std, len(path))
    map, sen = Map(), Sen(1, 1, Range(std), Frame2, x=np.zeros(3))
    rob = Rob(1, Odometry2(), x=np.zeros(3))
    ring = rings.ring_of(map, rob, sen, 1, EucPnt(2), y[:1], sen.model.R, 64)
    for p, y_k in zip(path[1:], y[1:], strict=True):
        rob.x = np.append(p, 0.0)
        assert rings.correct_ring(map, rob, sen, ring, np.array([y_k]), sen.model.R)

    r, a = np.meshgrid(np.linspace(8, 12, 161), np.linspace(-np.pi, np.pi, 1441)[:-1])
    grid = np.stack([r * np.cos(a), r * np.sin(a)], -1)
    log = -(((np.linalg.norm(grid[..., None, :] - path, axis=-1) - y) / std) ** 2).sum(-1) / 2
    w = np.exp(log - log.max())  # flat in bearing and range
    w /= w.sum()
    above = w[grid[..., 1] > 0].sum()
    assert 0.05 < above < 0.95 or above > 0.5
    assert ring.w[ring.points(map)[0][:, 1] > 0].sum() == pytest.approx(above, abs=0.08)
    mean = (w[..., None] * grid).sum((0, 1))
    assert np.linalg.norm(ring.joined(map)[0] - mean) < 0.5


# --- births ---


def test_the_right_hypothesis_is_kept_and_the_map_is_honest():
    """18 births: the mean of 18 NEES, per degree of freedom, is below 2.0 in 99.9 % of all honest filters."""
    found, decided = [], 0
    for seed in range(6):
        points = scattered(seed)
        *_, now = universal_slam(scenario(points, last=35), seed=seed)
        decided += len(now.lmks)
        found += [the_right_one(now, i, p) for i, p in enumerate(points, 1)]
    assert decided >= 14
    assert max(found) < 25.0
    assert 0.3 < np.mean(found) / 2 < 2.0


def test_a_straight_path_leaves_two_and_a_turn_decides():
    points = np.array([[12.0, 5.0], [20.0, -14.0]])
    straight = scenario(points, last=50, turn=0.0, mount=4.0)
    *_, now = universal_slam(straight)
    assert not now.lmks
    for id, (_, y) in enumerate(points, 1):
        ring = now.rings[id]
        p, _ = ring.points(now.map)
        mirrored = ring.w[p[:, 1] > -4].sum()  # the path is at y = -4
        assert 0.02 < mirrored < 0.98
        assert np.abs(p[:, 1] + 4).min() > 0.5 * abs(y + 4)
    *_, now = universal_slam(scenario(points, last=50, turn=2.0, mount=4.0))
    assert len(now.lmks) == 2 and not now.rings


def test_in_space():
    """A sphere of hypotheses; the path is a screw, so it has no mirror."""
    point = np.array([[4.0, 3.0, 2.5]])
    control = {"dx": [0.3, 0, 0.1], "da_deg": [3, 0, 9]}
    robot = Robot(motion=Odometry3(), position=[0, 0, 0], control=control, control_std={"dx": 0.005, "da_deg": 0.05})
    data = UserData(
        robots=[robot],
        sensors=[Sensor(model=Range(range_std=0.1, dim=3))],
        world=World.of(point),
        time=Time(last=70),
        landmark=Landmark(hypotheses=60),
    )
    sizes = []
    for now in universal_slam(data):
        sizes += [len(ring.w) for ring in now.rings.values()]
    assert sizes[0] == 60 and the_right_one(now, 1, point[0]) < 16.0
    assert np.linalg.norm((now.lmks[1].point(now.map)[0] if now.lmks else now.rings[1].joined(now.map)[0]) - point) < 1


def test_bias_and_scale_of_a_beacon_are_states():
    """Each beacon has a fault of its own, which no single number of the sensor could take away."""
    points = scattered(3)
    data = scenario(points, last=95, kind=Beacon(bias_std=1.0, scale_std=0.1), turn=4.0)
    faults = {1: (0.8, 0.05), 2: (-0.6, 0.0), 3: (0.3, -0.08)}
    recorder = Recorder()
    for now in universal_slam(replace(data, landmark=replace(data.landmark, hypotheses=3))):
        recorder.add(now)
    log = recorder.recording("faults")
    raw = log.raw[1]
    wrong = np.array([faults[i] for i in raw.ids.tolist()])
    raw = replace(raw, y=(1 + wrong[:, 1:]) * raw.y + wrong[:, :1])
    *_, now = universal_slam(data, replace(log, raw={1: raw}))
    assert len(now.lmks) >= 2
    for id, lmk in now.lmks.items():
        fault = faults[id]
        l, P = lmk.state(now.map), now.map.block(lmk.r)
        d = l - [*points[id - 1], *fault]
        assert d @ np.linalg.solve(P, d) < 25.0
        assert np.sqrt(P[2, 2]) < 0.8  # something has been learnt


# --- a sensor that comes near ---


def test_a_hypothesis_that_bends_is_cut_and_the_sum_keeps_its_moments():
    now, _ = one_ring(Beacon(bias_std=0.5, scale_std=0.05))
    map, rob, sen, ring = now.map, now.robs[0], now.sens[0], now.rings[1]

    def whole():
        return rings.moments(ring.w, ring.states(map), rings.diagonal(map.block(ring.r), len(ring.w)))

    (m, P), n, x, std = whole(), len(ring.w), rob.state(map), 0.08
    rings.cut(map, rob, sen, ring, std, 400)
    assert n < len(ring.w) < 400 and ring.w.sum() == pytest.approx(1)
    assert max(rings.bend(p, C, std) for p, C in zip(*rings.seen(map, rob, sen, ring), strict=True)) <= rings.BENT
    np.testing.assert_allclose(whole()[0], m, atol=1e-9)
    np.testing.assert_allclose(whole()[1], P, atol=1e-9)
    assert (rob.state(map) == x).all() and np.linalg.eigvalsh(map.P).min() > -1e-9
    n = len(ring.w)
    rings.cut(map, rob, sen, ring, std / 10, n + 3)
    assert len(ring.w) == n + 2  # there is room for one cut
    (m, P), map.capacity = (map.x.copy(), map.P.copy()), map.n_used + 1
    rings.cut(map, rob, sen, ring, std / 10, 4 * n)  # and no room in the map
    assert len(ring.w) == n + 2 and (map.x == m).all() and (map.P == P).all()


@pytest.mark.parametrize("bias, side", [(-0.5, 0.7), (0.4, -0.5), (-0.7, 0.8)])
def test_near_a_beacon_both_sides_of_the_path_are_kept(bias, side):
    """With known poses, against the sum over a fine grid, where bias and scale are integrated out exactly.

    Ranges from one bow tell little about the side, and a bias makes the beacon look nearer or further away.
    """
    rng, kind, std = np.random.default_rng(11), Beacon(bias_std=0.5, scale_std=0.05), 0.1
    a = np.arange(22) * 0.05
    path = 10 * np.stack([np.sin(a), 1 - np.cos(a)], -1)  # a bow
    beacon = path[15] + side * np.array([-np.sin(a[15]), np.cos(a[15])])
    y = np.linalg.norm(path - beacon, axis=1) + bias + rng.normal(0, std, len(path))
    assert y.min() > 0
    map, sen = Map(), Sen(1, 1, Range(std), Frame2, x=np.zeros(3))
    rob = Rob(1, Odometry2(), x=np.zeros(3))
    ring = rings.ring_of(map, rob, sen, 1, kind, y[:1], sen.model.R, 64)
    for p, y_k in zip(path[1:], y[1:], strict=True):
        rob.x = np.append(p, 0.0)
        rings.cut(map, rob, sen, ring, std, 64)
        assert rings.correct_ring(map, rob, sen, ring, np.array([y_k]), sen.model.R)
        rings.thin_out(map, rob, sen, ring, std)

    grid = beacon + np.stack(np.meshgrid(*[np.linspace(-2, 2, 101)] * 2), -1)
    d = np.linalg.norm(grid[..., None, :] - path, axis=-1)
    N = np.broadcast_to(std**2 * np.eye(len(path)) + 0.5**2, (*d.shape, len(path)))
    N = N + 0.05**2 * d[..., :, None] * d[..., None, :]
    z = y - d
    log = -(np.einsum("...i,...i", z, np.linalg.solve(N, z[..., None])[..., 0]) + np.linalg.slogdet(N)[1]) / 2
    w = np.exp(log - log.max()) / d[..., 0]  # flat in bearing and range from where it was born
    w /= w.sum()

    def inside(p):
        """Of the bow."""
        return np.linalg.norm(p - [0, 10], axis=-1) < 10

    among, here = w[inside(grid)].sum(), inside(ring.points(map)[0])
    assert 0.1 < among < 0.9
    assert ring.w[here].sum() == pytest.approx(among, abs=0.15)  # off by up to 0.13: pieces are Gaussians still
    for which, part in (here, inside(grid)), (~here, ~inside(grid)):
        mean, (p, P) = (w[part, None] * grid[part]).sum(0) / w[part].sum(), ring.joined(map, which)
        assert (p - mean) @ np.linalg.solve(P, p - mean) < 4


# --- the map around ---


def one_ring(kind=None):
    """A map with a robot, a landmark and a ring after some frames."""
    data = scenario([[7.0, 3.0]], last=4, kind=kind, options={"engine": "plain"}, most=12)
    *_, now = universal_slam(data)
    return now, data.slam_options()


def test_several_hypotheses_correct_nothing_but_themselves():
    now, opt = one_ring()
    rob, ring = now.robs[0], now.rings[1]
    x, P, w = rob.state(now.map), now.map.block(rob.r), ring.w.copy()
    y = np.linalg.norm(ring.joined(now.map, [3])[0] - x[:2], keepdims=True)
    assert rings.correct_ring(now.map, rob, now.sens[0], ring, y, now.sens[0].model.R)
    assert (rob.state(now.map) == x).all() and (now.map.block(rob.r) == P).all()
    assert np.abs(ring.w - w).max() > 0.01 and ring.w.sum() == pytest.approx(1)
    assert np.linalg.eigvalsh(now.map.P).min() > -1e-9


def test_a_range_that_nobody_explains_is_refused():
    now, _ = one_ring()
    ring = now.rings[1]
    before = ring.states(now.map)
    used = rings.correct_ring(now.map, now.robs[0], now.sens[0], ring, np.array([99.0]), now.sens[0].model.R, 13.8)
    assert not used and ring.n_refused == 1 and (ring.states(now.map) == before).all()


def test_one_reflection_does_not_decide():
    """A wrong hypothesis explains it by chance. Others lose what a range at the gate takes, and keep their belief."""
    now, _ = one_ring()
    rob, sen, ring, gate = now.robs[0], now.sens[0], now.rings[1], 13.8
    p, x = ring.points(now.map)[0][0], rob.state(now.map)
    at = ring.r.start + ring.m
    now.map.x[at : at + 2] += 3 * (p - x[:2]) / np.linalg.norm(p - x[:2])  # 3 m too far, like the reflection
    before, w = ring.states(now.map), ring.w.copy()
    y = np.linalg.norm(ring.points(now.map)[0][:1] - x[:2], axis=1)
    assert rings.correct_ring(now.map, rob, sen, ring, y, sen.model.R, gate)
    lost = (ring.w[0] / w[0]) / (ring.w[1:] / w[1:])
    assert (lost > 10).all() and (lost <= np.exp(gate / 2)).all()
    assert (ring.states(now.map)[1:] == before[1:]).all() and ring.w[1:].min() > rings.NOTHING


def test_a_ring_without_room_begins_anew():
    """Poor odometry, good ranges from afar: so much would its hypotheses bend that their weights meant nothing."""
    data = scenario([[40.0, 10.0]], last=40, std=0.1, most=40)
    noise = {"dx": [0.02, 0.01], "da_deg": 1.5}
    n_used = [0]
    for now in universal_slam(replace(data, robots=[replace(data.robots[0], control_std=noise)])):
        n_used.append(now.rings[1].n_used)  # so it is not decided
    assert min(np.diff(n_used)) < 0


def test_a_ring_is_carried_along_as_landmarks_are():
    """The invariant error: the covariance of a hypothesis follows a correction as that of a landmark in its place."""
    now, opt = one_ring()
    map, rob, ring = now.map, now.robs[0], now.rings[1]
    size, k = ring.states(map).shape[1], ring.type.size
    h = slice(ring.r.start + 2 * size + ring.m, ring.r.start + 3 * size)
    twin = map.add(map.state(h), map.block(h), map.P[h].copy())
    lmk, H = Lmk(9, ring.type, r=twin), np.eye(3)[:1]
    blocks = ((rob.r, H),)
    PHt = cross(map, blocks)
    inn = innovation(np.array([0.5]), covariance(PHt, blocks), np.array([[0.01]]))
    alive = rings.Rings(12, ring.type)
    alive.live = now.rings
    with alive.carried(map, rob, opt):
        correct_invariant(map, rob, {9: lmk}, PHt, inn, opt)
    assert k == 2 and np.allclose(map.P[h][:, rob.r], map.P[twin][:, rob.r], rtol=0, atol=1e-12)
    assert np.allclose(map.block(h), map.block(twin), rtol=0, atol=1e-12)


def derivative(f, x, h=1e-6):
    """Central differences of f at x, a column for each number of x."""
    return np.stack([(f(x + d) - f(x - d)) / (2 * h) for d in h * np.eye(len(x))], -1)


def test_hypotheses_as_the_sensor_sees_them():
    """Their covariance there is that of the joint belief of robot and beacon, by differences."""
    now, _ = one_ring(Beacon(bias_std=0.5, scale_std=0.05))
    rob, sen, ring = now.robs[0], now.sens[0], now.rings[1]
    p, C = rings.seen(now.map, rob, sen, ring)

    def seen(l):
        return Frame2(l[:3]).compose(sen.frame(now.map))[0].to_frame(l[3:5])[0]

    for h, l in enumerate(ring.states(now.map)):
        J, P = derivative(seen, l), rings.diagonal(now.map.block(ring.r), len(ring.w))[h]
        np.testing.assert_allclose(p[h], seen(l), atol=1e-12)
        np.testing.assert_allclose(C[h], J @ P @ J.T, atol=1e-6)


def test_how_hypotheses_change_if_the_world_is_moved():
    now, _ = one_ring(Beacon(bias_std=0.5, scale_std=0.05))
    rob, ring = now.robs[0], now.rings[1]
    l = ring.states(now.map)
    B = rings.ring_gauge(rob, ring, l)

    def moved(g, l):
        F = Frame2(g)
        return np.concatenate([F.compose(Frame2(l[:3]))[0].x, F.from_frame(l[3:5])[0], l[5:]])

    for h in range(len(l)):
        np.testing.assert_allclose(B[h], derivative(lambda g, h=h: moved(g, l[h]), np.zeros(3)), atol=1e-7)
    T = rings.carrying(B, B[::-1], 3)
    np.testing.assert_allclose(T @ B, B[::-1], atol=1e-10)


@pytest.mark.parametrize("error", ["invariant", "additive"])
def test_ranges_do_not_tell_how_the_world_is_turned(error):
    """Rings and landmarks leave the heading as unsure as it was at the start; the additive error does not."""
    data = scenario(scattered(0), last=35, options={"error": error})
    robot = replace(data.robots[0], orientation_std_deg=3.0)
    *_, now = universal_slam(replace(data, robots=[robot]))
    std = np.degrees(np.sqrt(now.map.block(now.robs[0].r)[2, 2]))
    assert len(now.lmks) == 3
    assert std > 3.0 - 1e-6 if error == "invariant" else std < 2.9


@pytest.mark.parametrize("options", [{}, {"joint": True}, {"joint": True, "compressed": True}], ids=str)
def test_fast_is_plain(options):
    """Whatever the engine: rings, decisions and landmarks."""
    points = np.vstack([scattered(5), [4.4, -2.2]])  # the path passes the last one at 0.8 m: it is cut
    plain = {name: value for name, value in options.items() if name != "compressed"}
    kind = Beacon(bias_std=0.1, scale_std=0.01)
    one, other = (
        universal_slam(scenario(points, last=40, kind=kind, options={"engine": engine, **more}))
        for engine, more in (("plain", plain), ("fast", options))
    )
    sizes = []
    for a, b in zip(one, other, strict=True):
        sizes += [len(ring.w) for id, ring in a.rings.items() if id == len(points)]
        assert a.events == b.events and a.rings.keys() == b.rings.keys() and a.lmks.keys() == b.lmks.keys()
        for id, ring in a.rings.items():
            assert np.allclose(ring.w, b.rings[id].w, atol=1e-9)
            assert np.allclose(ring.states(a.map), b.rings[id].states(b.map), atol=1e-8)
        assert np.allclose(a.robs[0].state(a.map), b.robs[0].state(b.map), atol=1e-9)
    for id, lmk in a.lmks.items():
        assert np.allclose(a.map.block(lmk.r), b.map.block(b.lmks[id].r), atol=1e-9)
    assert a.lmks and max(np.diff(sizes)) > 0


def test_a_run_goes_on_from_where_it_was_kept():
    data = scenario(scattered(2), last=24)
    for now in universal_slam(data):
        if now.k == 9:
            kept = deepcopy(run_state(now, data))  # the map lives on
            assert now.rings
    *_, again = universal_slam(data, resume=kept)
    assert (again.map.x == now.map.x).all() and again.rings.keys() == now.rings.keys()
    assert all((again.rings[i].w == ring.w).all() for i, ring in now.rings.items())


def test_another_sensor_may_know_better():
    """A beacon that a laser starts is no ring any more."""
    data = scenario([[4.0, 1.0]], last=3)
    laser = Sensor(id=2, model=RangeBearing(range_std=0.1, bearing_std=0.02, max_range=9.0))
    *_, now = universal_slam(replace(data, sensors=[*data.sensors, laser]))
    assert list(now.lmks) == [1] and not now.rings and now.map.n_used == 5


# --- what is refused ---


def test_a_full_map_refuses_a_ring_and_the_run_goes_on():
    data = scenario([[4.0, 1.0]], last=3, options={"capacity": 20})
    for now in universal_slam(data):
        assert not now.rings and now.refused == {1}


@pytest.mark.parametrize(
    "change, message",
    [
        ({"most": 2}, "hypotheses must be a whole number, 3 or more, or 0 for no births from a range, got 2"),
        ({"most": 0}, "a range tells no direction; take hypotheses = 64 of them all round"),
        ({"options": "nearest"}, "hypotheses need association = 'known_ids', got NearestNeighbour"),
    ],
    ids=str,
)
def test_what_cannot_be_is_one_sentence(change, message):
    if change.get("options"):
        change = {"options": {"association": NearestNeighbour()}}
    with pytest.raises((ValueError, TypeError), match=message.replace("(", r"\(")):
        scenario([[1.0, 2.0]], **change)
