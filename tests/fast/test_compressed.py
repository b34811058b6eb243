"""The compressed filter beside the plain one: the same numbers, whatever is done and whoever asks in between."""

import copy
import pickle

import numpy as np
import pytest

from ekfslam_tutorial.cli.files import find_scenario
from ekfslam_tutorial.ekf import MapFull
from ekfslam_tutorial.fast import (
    CompressedMap,
    FastMap,
    augment,
    correct,
    covariance,
    cross,
    innovation,
    predict,
    transform,
    update,
)
from ekfslam_tutorial.toolbox import UserData, universal_slam

EXACT = 1e-12  # of the largest entry; the rounding errors of the long runs below are 1e-14


def relative(a, b):
    return np.abs(a - b).max() / np.abs(b).max()


def same(maps, tolerance=EXACT):
    """Return True if a compressed and a plain map are one and the same estimate."""
    a, b = maps
    near = relative(np.asarray(a.x), b.x) < tolerance and relative(a.P, b.P) < tolerance
    return near and np.array_equal(a.used, b.used)


class Both:
    """A compressed and a plain map, to which the same things happen."""

    def __init__(self, rng, active=12, robot=5):
        self.rng, self.maps, self.lmks = rng, (CompressedMap(active=active), FastMap()), []
        self.robot = self.each(lambda map: map.add(np.zeros(robot), 0.1 * np.eye(robot)))

    def each(self, do):
        """Do something with both; what comes out must be the same."""
        a, b = (do(map) for map in self.maps)
        assert a == b if isinstance(a, slice) else relative(np.asarray(a), np.asarray(b)) < EXACT
        return b

    def far(self):
        """The ranges of the landmarks that are far."""
        return [r for r in self.lmks if self.maps[0]._spot_of[r.start] < 0]

    # --- what may happen ---

    def move(self):
        k = self.robot.stop
        X_x, X_u = np.eye(k) + 0.1 * self.rng.normal(size=(k, k)), self.rng.normal(size=(k, 2))
        for map in self.maps:
            predict(map, self.robot, map.state(self.robot) + X_u[:, 0], X_x, X_u, 0.01 * np.eye(2))

    def blocks(self, some):
        """Of the head of the robot (its frame; there are velocities behind it) and one or more landmarks."""
        head, K = slice(0, 3), len(some)
        E_r, E_l = self.rng.normal(size=(K, 2, 3)), self.rng.normal(size=(K, 2, 2))
        if K == 1:
            return (head, E_r[0]), (None, np.ones((2, 4))), (some[0], E_l[0])
        return (head, E_r), (None, np.ones((K, 2, 4))), (np.array([range(r.start, r.stop) for r in some]), E_l)

    def correct(self, K):
        if len(self.lmks) < K:
            return
        some = [self.lmks[i] for i in self.rng.choice(len(self.lmks), K, replace=False)]
        blocks, z = self.blocks(some), self.rng.normal(size=(K, 2) if K > 1 else 2)
        for map in self.maps:
            PHt = cross(map, blocks)
            correct(map, PHt, innovation(z, covariance(PHt, blocks), 0.1 * np.eye(2)))

    def birth(self, k=2):
        L, l = self.rng.normal(size=(k, 3)), self.rng.normal(size=k)
        blocks = [(slice(0, 3), L), (None, np.ones((k, 1)))]
        r = self.each(lambda map: augment(map, l, blocks, 0.1 * np.eye(k)))
        if k == 2:
            self.lmks.append(r)
        else:  # a long state becomes a short one: an inverse-depth point turns Euclidean
            J = self.rng.normal(size=(2, k))
            self.lmks.append(self.each(lambda map: transform(map, r, J @ map.state(r), J)))

    def death(self):
        if len(self.lmks) > 2:
            r = self.lmks.pop(self.rng.integers(len(self.lmks)))
            for map in self.maps:
                map.remove(r)

    def look(self):
        """Means and covariances of one, of all, and of mixed ranges, in a random order of asking."""
        if not self.lmks:
            return
        rows = np.array([[0, 1, 2, r.start, r.start + 1] for r in self.lmks])
        r = self.lmks[self.rng.integers(len(self.lmks))]
        looks = [
            lambda map: map.state(r),
            lambda map: [map.entry(i) for i in (0, r.start, r.stop - 1)],
            lambda map: map.block(r),
            lambda map: map.block(rows),
            lambda map: map.state(rows),
            lambda map: np.asarray(cross(map, self.blocks_of_all)),
        ]
        self.blocks_of_all = self.blocks(self.lmks if len(self.lmks) > 1 else [r])
        for i in self.rng.permutation(len(looks)):
            self.each(looks[i])

    def write(self):
        """The views are the map: who writes into them changes it."""
        if self.lmks:
            r = self.lmks[self.rng.integers(len(self.lmks))]
            for map in self.maps:
                map.x[r] += 0.5
                map.P[r, r] += 0.1 * np.eye(2)
                map.set_mean(self.robot, 0.5 * map.state(self.robot))


@pytest.mark.usefixtures("triangles")
@pytest.mark.parametrize("seed", range(4))
def test_whatever_happens_both_are_the_same(seed):
    rng = np.random.default_rng(seed)
    both = Both(rng, active=int(rng.integers(6, 24)))
    acts = [
        (both.move, 6),
        (lambda: both.correct(1), 4),
        (lambda: both.correct(3), 4),
        (both.birth, 2),
        (lambda: both.birth(6), 1),
        (both.death, 1),
        (both.look, 1),
        (both.write, 0.3),
        (lambda: both.maps[0].flush(), 0.3),
    ]
    share = np.array([share for _, share in acts])
    came_back, off = 0, []
    for i in rng.choice(len(acts), 250, p=share / share.sum()):
        acts[i][0]()
        came_back += bool(both.far())
        off.append(_off(*both.maps))
    assert same(both.maps) and len(both.lmks) > 5
    assert came_back > 100  # otherwise nothing was far, and this has tested nothing
    assert sum(o > 0.01 for o in off) > 10  # and no mean would have been behind


def _off(map, exact):
    """Return how far the means of `roughly` are off at most, as a share of what they may be off; exact ones are."""
    x, std, moved = map.roughly()
    error, most = np.abs(x[: map.n] - exact.x), np.linalg.norm(moved) * std[: map.n]
    slack = EXACT * max(np.abs(exact.x).max(), 1e-3)
    assert (error <= most + slack)[map.used].all() and not most[map._active_states].any()
    return (error[map.used] / np.maximum(most, slack)[map.used]).max()


def test_a_robot_that_comes_round_again_and_again(rng):
    """60 landmarks, four active at a time, three rounds: no far landmark is touched, each is needed again."""
    both = Both(rng, active=20, robot=3)
    for _ in range(60):
        both.birth()
    flushes = _counted(both.maps[0], "_settle")
    for k in range(180):
        both.move()
        some = [both.lmks[(k + i) % 60] for i in range(4)]
        blocks, z = both.blocks(some), rng.normal(size=(4, 2))
        for map in both.maps:
            PHt = cross(map, blocks)
            correct(map, PHt, innovation(z, covariance(PHt, blocks), 0.1 * np.eye(2)))
    assert len(flushes) <= 180 / 3  # five new active landmarks, of two states each, before all is settled
    assert same(both.maps)


def _counted(object, name):
    calls, method = [], getattr(object, name)
    setattr(object, name, lambda *a: calls.append(1) or method(*a))
    return calls


def test_the_large_covariance_is_left_alone_between_two_flushes(rng):
    both = Both(rng, active=1000)
    for _ in range(30):
        both.birth()
    map = both.maps[0]
    map.P  # noqa: B018 -- nothing is active now
    before = map._whole._P.copy()
    for _ in range(20):
        both.move()
        both.correct(3)
        both.look()
    assert np.array_equal(map._whole._P, before)
    map.flush()
    assert not np.array_equal(map._whole._P, before)
    assert same(both.maps)


def test_expectations_of_far_landmarks_do_not_disturb_each_other(rng):
    """As joint compatibility needs them: P H' of each, then their covariances in pairs, H_i P H_j'."""
    both = Both(rng, active=8)
    for _ in range(12):
        both.birth()
    both.maps[0].flush()
    both.move()
    blocks = [both.blocks([r]) for r in both.lmks]

    def pairs(map):
        PHt = [cross(map, b) for b in blocks]
        return [[covariance(p, b) for p in PHt] for b in blocks]

    both.each(pairs)
    PHt = [[cross(map, b) for b in blocks] for map in both.maps]
    for map in both.maps:
        map.P  # noqa: B018 -- another layout, while P H' waits
    for map, p in zip(both.maps, PHt, strict=True):
        correct(map, p[3], innovation(np.ones(2), covariance(p[3], blocks[3]), np.eye(2)))
    assert same(both.maps)


def test_what_is_known_has_no_covariance_with_anything():
    maps = CompressedMap(), FastMap()
    for map in maps:
        blocks = [(None, np.ones((2, 3))), (None, np.ones((2, 3)))]
        ranges = [augment(map, np.full(2, i), blocks, np.eye(2)) for i in range(50)]
        PHt = cross(map, [(None, np.ones((2, 3))), (ranges[7], np.eye(2))])
        assert PHt.shape == (100, 2)
        correct(map, PHt, innovation(np.ones(2), covariance(PHt, [(ranges[7], np.eye(2))]), np.eye(2)))
    assert same(maps)


def test_a_range_over_several_states_is_one_range(rng):
    """Its states may have become active in another order."""
    both = Both(rng, active=200)
    for _ in range(8):
        both.birth()
    both.maps[0].P  # noqa: B018 -- nothing is active now
    both.each(lambda map: map.rows(both.lmks[5]) if isinstance(map, FastMap) else np.asarray(map.P[both.lmks[5]]))
    both.maps[0].fetch([(both.lmks[5], None)])
    r = slice(both.lmks[3].start, both.lmks[6].stop)
    J, U = np.eye(8) + 0.1 * rng.normal(size=(8, 8)), np.eye(8)
    for map in both.maps:
        predict(map, r, np.arange(8.0), J, np.eye(8), U)
    assert same(both.maps)


def test_a_state_with_its_covariances_comes_in(rng):
    both = Both(rng)
    for _ in range(10):
        both.birth()
        both.correct(1)
    P_xm = 0.1 * both.maps[1].P[both.lmks[0]]
    r = both.each(lambda map: map.add(np.ones(2), np.eye(2), P_xm))
    both.lmks.append(r)
    both.correct(3)
    assert same(both.maps)


def test_a_full_map_is_full_and_nothing_has_changed(rng):
    maps = CompressedMap(5, active=3), FastMap(5)
    for map in maps:
        r = map.add(np.zeros(3), np.eye(3))
        augment(map, np.ones(2), [(r, np.ones((2, 3)))], np.eye(2))
        with pytest.raises(MapFull, match="5 of 5 states"):
            augment(map, np.ones(2), [(r, np.ones((2, 3)))], np.eye(2))
        assert map.n == map.n_used == map.capacity == 5
    assert same(maps)


def test_a_copy_is_a_map_of_its_own(rng):
    both = Both(rng)
    for _ in range(12):
        both.birth()
    both.correct(3)
    others = [copy.deepcopy(both.maps[0]), pickle.loads(pickle.dumps(both.maps[0]))]
    P = both.maps[1].P.copy()
    for other in others:
        blocks = both.blocks([both.lmks[0]])
        PHt = cross(other, blocks)
        correct(other, PHt, innovation(np.ones(2), covariance(PHt, blocks), np.eye(2)))
        assert relative(other.P, P) > 1e-3
    assert same(both.maps)


def test_what_it_says_of_itself_and_what_it_refuses():
    map = CompressedMap(10)
    r = map.add(np.zeros(3), np.eye(3))
    assert repr(map) == "CompressedMap(3 of 10 states in use, 0 active)"
    map.rows(r)
    assert repr(map) == "CompressedMap(3 of 10 states in use, 3 active)"
    map.remove(r)
    with pytest.raises(ValueError, match=r"states \[0, 1, 2\] are not in use in this map of 3 states"):
        map.rows(r)
    with pytest.raises(ValueError, match="range 0:3 is not in use"):
        map.remove(r)
    with pytest.raises(ValueError, match="active must be a positive number of states, got 0"):
        CompressedMap(active=0)
    with pytest.raises(ValueError, match="capacity of a map must be a positive number"):
        CompressedMap(-1)


@pytest.mark.parametrize("shared", [50.0, 1e3])
def test_a_large_error_that_all_share_costs_no_digits(shared, rng):
    """As in a long loop: the map is known to 0.05 m in itself, and to `shared` in the world."""
    n = 3 + 2 * 40
    maps = CompressedMap(active=20), FastMap()
    for map in maps:
        map.add(np.zeros(n), np.eye(n))
        map.P[:] = shared**2 + 0.05**2 * np.eye(n)
    robot, given = slice(0, 3), np.random.default_rng(7)
    for k in range(80):
        E_r, E_l = given.normal(size=(2, 3)), given.normal(size=(2, 2))
        E_l[:, 0] -= E_r.sum(1) + E_l.sum(1)  # only differences of places are measured
        l = slice(3 + 2 * (k % 40), 5 + 2 * (k % 40))
        for map in maps:
            predict(map, robot, map.state(robot), np.eye(3), np.eye(3), 0.01 * np.eye(3))
            blocks = (robot, E_r), (l, E_l)
            PHt = cross(map, blocks)
            correct(map, PHt, innovation(np.ones(2), covariance(PHt, blocks), 0.01 * np.eye(2)))
    assert relative(maps[0].P, maps[1].P) < EXACT
    lost = 1e2 * np.finfo(float).eps * (shared / 0.05) ** 2  # by both: H P H' is a small difference of large numbers
    assert relative(maps[0].x, maps[1].x) < lost < 1e-4


def test_states_that_are_functions_of_others(rng):
    """Two landmarks at one and the same place, and one that is known exactly: P is singular."""
    maps = CompressedMap(active=6), FastMap()
    for map in maps:
        ranges = [map.add(np.zeros(2), np.eye(2)) for _ in range(8)]
        A = np.random.default_rng(5).normal(size=(16, 20))
        A[2:4], A[6:8] = A[0:2], 0.0
        map.P[:] = A @ A.T
        given = np.random.default_rng(6)
        for k in range(40):
            blocks = (ranges[k % 8], given.normal(size=(2, 2))), (ranges[(k + 1) % 8], given.normal(size=(2, 2)))
            PHt = cross(map, blocks)
            correct(map, PHt, innovation(np.ones(2), covariance(PHt, blocks), np.eye(2)))
    assert same(maps)
    assert np.allclose(maps[0].x[0:2], maps[0].x[2:4], rtol=0, atol=1e-12)


@pytest.mark.parametrize("compiled", [False, True])
def test_rounding_errors_of_what_depends_on_others_do_not_grow(compiled):
    """Landmarks with an anchor, as inverse-depth points have: a copy of the robot. All is settled every few updates.

    If the small rest of such a state, given the others, counts as noise of its own, it doubles each time; if it is what
    others are divided by, it grows faster still.
    """
    given, anchored = np.random.default_rng(0), np.vstack([np.eye(3), [[0.1, 0.2, 0.3]]])
    maps, lmks = (CompressedMap(active=10, compiled=compiled), FastMap()), ([], [])
    robots = [map.add(np.zeros(3), np.zeros((3, 3))) for map in maps]
    for k in range(60):
        seen = [(k // 6 + i) % 30 for i in range(8)]
        H, z = given.normal(size=(8, 2, 7)), 0.01 * given.normal(size=(8, 2))
        for map, r, ls in zip(maps, robots, lmks, strict=True):
            predict(map, r, map.state(r), np.eye(3), np.eye(3), 1e-4 * np.eye(3))
            while len(ls) <= max(seen):
                ls.append(augment(map, np.zeros(4), ((r, anchored),), np.diag([0, 0, 0, 0.25])))
            for i, J, z_i in zip(seen, H, z, strict=True):
                update(map, ((r, J[:, :3]), (ls[i], J[:, 3:])), z_i, 1e-4 * np.eye(2))
    assert same(maps)


@pytest.mark.parametrize("compiled", [False, True])
@pytest.mark.parametrize(
    "name, joint", [("cloister_hmg", True), ("cloister_idp", True), ("cloister_idp", False), ("cloister_ahm", True)]
)
def test_a_camera_that_uses_all_it_sees(name, joint, compiled, request):
    """Many more states in a frame than may be active; quaternions and anchors make P singular, but for rounding.

    One type of landmark is compiled by numba for it, the programs of the others are interpreted.
    """
    if name != "cloister_ahm":
        request.getfixturevalue("interpreted")
    few = {
        "options.n_updates": 100,
        "options.n_inits": [100, 100],
        "options.joint": joint,
        "options.error": "additive",
        "options.compiled": compiled,
        "world.n": 9,
        "time.last": 30,
    }
    runs = []
    for compressed in False, True:
        scenario = UserData.from_toml(find_scenario(name), few | {"options.compressed": compressed})
        *_, last = universal_slam(scenario)
        runs.append(last)
    used = runs[0].map.used
    (x, P), (x_c, P_c) = ((run.map.x[used], run.map.P[np.ix_(used, used)]) for run in runs)
    s = np.sqrt(P.diagonal())
    assert runs[1].map.n > runs[1].map.active  # so all was settled, and became active again
    assert (np.abs(P - P_c) < 1e-8 * np.outer(s, s)).all()  # 1e-10 in homogeneous points, where P is nearly singular
    assert np.abs(x - x_c).max() < 1e-10


def test_neighbours_become_active_together(rng):
    """Whole states that begin in the same eight entries of the map, those of a state that was taken out excepted."""
    map = CompressedMap(active=4)
    ranges = [map.add(np.zeros(k), np.eye(k)) for k in (3, 2, 2, 2, 2, 5, 2, 2)]
    map.P, map.remove(ranges[3])
    map.spots(ranges[2])
    assert map._active_states.tolist() == [0, 1, 2, 3, 4, 5, 6]  # 7:9 is not in use any more
    map.spots(slice(16, 18))  # not the whole of a state: what was asked for, and the states that begin beside it
    assert map._active_states.tolist() == [0, 1, 2, 3, 4, 5, 6, 16, 17, 18, 19]
    twin = pickle.loads(pickle.dumps(map))
    twin.spots(ranges[5])
    assert twin._active_states.tolist() == [9, 10, 11, 12, 13, 14, 15]


def test_variances_are_there_when_nothing_is_active():
    map = CompressedMap(active=10)
    r = map.add([1.0, 2.0], np.diag([3.0, 4.0]))
    assert np.array_equal(map.variances(r), [3.0, 4.0])
    map.fetch([(r, np.eye(2))])
    assert np.array_equal(map.P.diagonal(), [3.0, 4.0]) and np.array_equal(map.variances(r), [3.0, 4.0])
