"""Who belongs to whom: known ids, nearest neighbour, joint compatibility."""

import itertools

import numpy as np
import pytest
from scipy.stats import chi2

from ekfslam_tutorial.ekf import covariance, cross
from ekfslam_tutorial.models.sensors import RangeBearing
from ekfslam_tutorial.slam import (
    Jcbb,
    KnownIds,
    NearestNeighbour,
    correct_known_lmks,
    init_new_lmks,
    project_lmks,
)
from ekfslam_tutorial.slam.association import distances, gate

from .scenes import Scene, kinds, raw

BOTH = pytest.mark.parametrize("association", [NearestNeighbour(), Jcbb()])


def matched(scene, association, measurements):
    obs = project_lmks(scene.map, scene.rob, scene.sen, scene.lmks.values())
    return association(scene.map, obs, measurements, scene.sen.model)


# --- known ids -------------------------------------------------------------------------------------------------------


def test_known_ids():
    scene = Scene()
    for id in (4, 7, 9):
        scene.add(id, [id, 1.0])
    found = matched(scene, KnownIds(), raw([9, 30, 4, -1, 12], np.ones((5, 2))))
    assert found.pairs == {9: 0, 4: 2}  # 7 was not measured
    assert found.new == [2, 0, 4, 1]  # by ascending id; what is of unknown origin starts nothing


def test_the_measurement_of_a_landmark_that_this_frame_deletes_starts_it_anew():
    """As in the toolbox of the manual: what is deleted is free again when the new landmarks are started."""
    scene = Scene(P=1e-4 * np.eye(3), md2_threshold=9.0, min_search=2, min_inlier_ratio=0.9)
    scene.add(4, [3.0, 0.0], 1e-4 * np.eye(2))
    scene.add(5, [0.0, 3.0], 1e-4 * np.eye(2))
    measurements = raw([4, 5], [[5.0, 0.0], [3.0, np.pi / 2]])  # two metres off, and right
    events, new = correct_known_lmks(*scene.all, scene.obs, measurements, scene.opt)
    assert ("deletion", 4) in kinds(events) and list(scene.lmks) == [5]
    assert kinds(init_new_lmks(*scene.all, measurements, new, scene.opt)) == [("initialisation", 4)]
    assert np.allclose(scene.lmks[4].state(scene.map), [5.0, 0.0], atol=0.01) and len(scene.lmks) == 2


def test_of_two_measurements_with_one_id_the_first_counts():
    scene = Scene()
    scene.add(4, [4.0, 1.0])
    assert matched(scene, KnownIds(), raw([4, 4], np.ones((2, 2)))).pairs == {4: 0}


def test_an_id_in_use_starts_nothing():
    measurements = raw([4, 5], np.ones((2, 2)))
    assert KnownIds().birth_id(measurements, 0, {4: None}) is None
    assert KnownIds().birth_id(measurements, 1, {4: None}) == 5


# --- distances -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("own_R", [False, True])
def test_distances_are_those_of_innovations(own_R, rng):
    scene = Scene(P=0.01 * np.eye(3))
    points = {i: rng.uniform(-5, 5, 2) for i in range(1, 5)}
    for id, p in points.items():
        scene.add(id, p, 0.02 * np.eye(2))
    measurements = scene.see(points, 3.0, rng)
    if own_R:
        measurements.R = np.stack([k * scene.sen.model.R for k in (1, 2, 3, 4)])
    obs = project_lmks(scene.map, scene.rob, scene.sen, scene.lmks.values())
    D = distances(obs, measurements, scene.sen.model)
    for i, j in np.ndindex(4, 4):
        z = scene.sen.model.residual(measurements.y[i], obs[j].e)
        R = scene.sen.model.R if not own_R else measurements.R[i]
        assert D[i, j] == pytest.approx(z @ np.linalg.solve(obs[j].E + R, z))


@BOTH
def test_across_the_seam(association):
    """Straight behind the robot a bearing of pi and one of -pi are the same direction."""
    scene = Scene(P=1e-6 * np.eye(3))
    scene.add(1, [-4.0, 0.001], 1e-4 * np.eye(2))  # bearing just below pi
    found = matched(scene, association, raw([-1], [[4.0, -np.pi + 0.002]]))
    assert found.pairs == {1: 0} and found.new == []


@pytest.mark.parametrize("dof", [1, 2, 3])
def test_the_gate_is_a_quantile(dof, rng):
    x = (rng.normal(size=(100_000, dof)) ** 2).sum(-1)
    share = (x <= gate(0.99, dof)).mean()
    assert abs(share - 0.99) < 4 * np.sqrt(0.99 * 0.01 / 1e5)  # 4 standard deviations of a share


# --- nearest neighbour -----------------------------------------------------------------------------------------------


def line(*xs, P=0.01):
    """Landmarks on the x axis, in front of a robot whose pose is known."""
    scene = Scene()
    for id, x in enumerate(xs, 1):
        scene.add(id, [x, 0.0], P * np.eye(2))
    return scene


def at(*xs):
    """Measurements of points on the x axis."""
    return raw([-1] * len(xs), [[x, 0.0] for x in xs])


SIGMA = np.sqrt(0.01 + 0.05**2)  # of the innovation of a range


@BOTH
def test_the_near_one_is_taken_and_the_far_one_is_new(association):
    found = matched(line(3.0, 6.0), association, at(6.05, 12.0, 2.9))
    assert found.pairs == {2: 0, 1: 2} and found.new == [1]


@BOTH
def test_what_is_neither_near_nor_far_is_left_alone(association):
    """Between the gates (3.0 and 5.3 sigma) it is used for nothing: it may be the landmark, or may not."""
    for k, pairs, new in ((2.9, {1: 0}, []), (4.0, {}, []), (5.5, {}, [0])):
        found = matched(line(3.0), association, at(3.0 + k * SIGMA))
        assert (found.pairs, found.new) == (pairs, new)


@BOTH
@pytest.mark.parametrize(("hidden", "pairs"), [(0, {2: 2}), (1, {1: 0})])
def test_what_should_be_out_of_view_is_not_matched_and_starts_nothing(association, hidden, pairs):
    """A measurement near it is not a new landmark either; whatever its place among the others is."""
    scene = line(3.0, 6.0)
    obs = project_lmks(scene.map, scene.rob, scene.sen, scene.lmks.values())
    obs[hidden].visible = False
    found = association(scene.map, obs, at(3.01, 9.0, 6.01), scene.sen.model)
    assert (found.pairs, found.new) == (pairs, [1])


def test_nearest_neighbours_are_mutual():
    """Two measurements of one landmark: the nearer one is taken, the other has no right to the next landmark."""
    found = matched(line(3.0, 3.5), NearestNeighbour(), at(3.05, 3.2))
    assert found.pairs == {1: 0} and found.new == []


def test_two_landmarks_one_measurement():
    found = matched(line(3.0, 3.2), NearestNeighbour(), at(3.12))
    assert found.pairs == {2: 0}


@BOTH
def test_nothing_to_match(association):
    none = raw([], np.zeros((0, 2)))
    assert matched(Scene(), association, none).pairs == {} and matched(line(3.0), association, none).new == []
    found = matched(Scene(), association, at(1.0, 2.0))  # an empty map: everything is new
    assert found.pairs == {} and found.new == [0, 1]


@BOTH
def test_new_landmarks_get_a_number_that_nobody_has(association):
    assert association.birth_id(None, 0, {}) == 1
    assert association.birth_id(None, 0, {3: None, 8: None}) == 9


@pytest.mark.parametrize("cls", [NearestNeighbour, Jcbb])
@pytest.mark.parametrize("name, value", [("confidence", 1.0), ("confidence", 99), ("new_confidence", 0.0)])
def test_a_confidence_is_a_probability(cls, name, value):
    with pytest.raises(ValueError, match=f"{cls.__name__}: {name} must be between 0 and 1, got {value}"):
        cls(**{name: value})


# --- joint compatibility ---------------------------------------------------------------------------------------------


def turned(error):
    """Three posts on an arc, 7 degrees apart, and a robot that is turned by `error` against its estimate.

    Its heading is uncertain (3 degrees), the posts and the sensor are exact to centimetres. Turned by more than half
    the spacing of the posts, a measurement is nearest to the wrong post.
    """
    scene = Scene(P=np.diag([1e-6, 1e-6, np.radians(3) ** 2]), sensor=RangeBearing(0.02, 0.002))
    posts = {id: 8.0 * np.array([np.cos(a), np.sin(a)]) for id, a in enumerate(np.radians([-7, 0, 7]), 1)}
    for id, p in posts.items():
        scene.add(id, p, 1e-4 * np.eye(2))
    return scene, scene.see(posts, pose=[0.0, 0.0, error])


def test_joint_compatibility_beats_the_nearest_neighbour():
    scene, measurements = turned(np.radians(5.0))
    truth = {1: 0, 2: 1, 3: 2}
    assert matched(scene, Jcbb(), measurements).pairs == truth
    greedy = matched(scene, NearestNeighbour(), measurements).pairs
    assert greedy and all(truth[lmk] != i for lmk, i in greedy.items())  # every pair that it makes is wrong


def test_where_nothing_is_ambiguous_both_agree():
    scene, measurements = turned(np.radians(0.3))
    assert matched(scene, Jcbb(), measurements).pairs == matched(scene, NearestNeighbour(), measurements).pairs


def joint_distance(scene, obs, measurements, pairs):
    """Stacked innovation of some pairs, over its full covariance: written with one big H."""
    z, H = [], []
    for i, j in pairs:
        row = np.zeros((2, scene.map.n))
        for r, J in obs[j].blocks:
            if r is not None:
                row[:, r] = J
        z.append(scene.sen.model.residual(measurements.y[i], obs[j].e))
        H.append(row)
    z, H = np.concatenate(z), np.concatenate(H)
    Z = H @ scene.map.P @ H.T + np.kron(np.eye(len(pairs)), scene.sen.model.R)
    return z @ np.linalg.solve(Z, z)


def every_hypothesis(n, m):
    """All ways to give each of n measurements one of m landmarks or none, no landmark twice."""
    for js in itertools.product([None, *range(m)], repeat=n):
        used = [j for j in js if j is not None]
        if len(used) == len(set(used)):
            yield [(i, j) for i, j in enumerate(js) if j is not None]


@pytest.mark.parametrize("seed", range(25))
def test_the_search_finds_what_trying_all_would_find(seed):
    """The most pairs that are jointly compatible in every order of adding them, and of those the nearest."""
    rng = np.random.default_rng(seed)
    scene = Scene(P=np.diag([0.02, 0.02, 0.003]), sensor=RangeBearing(0.05, 0.01))
    posts = {i: rng.uniform([3, -1.5], [6, 1.5]) for i in range(1, 5)}
    for id, p in posts.items():
        scene.add(id, p, 4e-4 * np.eye(2))
    measurements = scene.see(posts, 1.6, rng, pose=rng.multivariate_normal(np.zeros(3), scene.map.P[:3, :3]))
    measurements = raw(measurements.ids[1:], measurements.y[1:])  # one post is hidden

    obs = project_lmks(scene.map, scene.rob, scene.sen, scene.lmks.values())

    def compatible(pairs):
        single = all(joint_distance(scene, obs, measurements, [p]) <= chi2.ppf(0.99, 2) for p in pairs)
        joint = (joint_distance(scene, obs, measurements, pairs[: k + 1]) for k in range(len(pairs)))
        return single and all(d <= chi2.ppf(0.99, 2 * (k + 1)) for k, d in enumerate(joint))

    allowed = [pairs for pairs in every_hypothesis(3, 4) if compatible(pairs)]
    best = max(allowed, key=lambda p: (len(p), -joint_distance(scene, obs, measurements, p) if p else 0))
    assert matched(scene, Jcbb(), measurements).pairs == {obs[j].lmk: i for i, j in best}


def test_a_search_that_is_cut_short_still_answers():
    scene, measurements = turned(np.radians(5.0))
    pairs = matched(scene, Jcbb(max_nodes=5), measurements).pairs
    assert len(set(pairs.values())) == len(pairs) <= 3


def test_the_joint_covariance_needs_the_cross_terms():
    """Two expectations share the robot's error: treated as independent, the true pairing would look implausible."""
    scene, measurements = turned(np.radians(5.0))
    obs = project_lmks(scene.map, scene.rob, scene.sen, scene.lmks.values())
    together = joint_distance(scene, obs, measurements, [(0, 0), (1, 1), (2, 2)])
    apart = sum(joint_distance(scene, obs, measurements, [(i, i)]) for i in range(3))
    assert together < 0.5 * apart
    PHt = cross(scene.map, obs[0].blocks)
    assert abs(covariance(PHt, obs[1].blocks)[1, 1]) > 0.9 * obs[0].E[1, 1]
