"""Whether the filter knows how wrong it is: errors against their covariance, over many runs with small noise.

The sum of N squared Mahalanobis distances of dof numbers is chi-square with N dof degrees of freedom if the filter is
honest. The noise is small, because an extended Kalman filter is honest only where its models are nearly linear.
"""

from functools import cache

import numpy as np
import pytest
from scipy.stats import chi2

from ekfslam_tutorial.geometry import Frame2, Frame3, v2q
from ekfslam_tutorial.models.landmarks import AhmPnt, IdpPnt
from ekfslam_tutorial.models.sensors import PinHole, RangeBearing
from ekfslam_tutorial.simulation import worlds
from ekfslam_tutorial.slam import correct_known_lmks, init_new_lmks, move

from .scenes import Scene


def assert_honest(nees, dof, confidence):
    """The mean of independent NEES stays in the band that holds it with this probability."""
    nees, n = np.asarray(nees), np.size(nees)
    low, high = chi2.ppf([(1 - confidence) / 2, (1 + confidence) / 2], n * dof) / (n * dof)
    mean = nees.sum() / (n * dof)
    assert low < mean < high, f"NEES/dof is {mean:.3f} over {n} numbers; the band is {low:.3f} to {high:.3f}"


def md2(e, P):
    return float(e @ np.linalg.solve(P, e))


# --- in the plane ----------------------------------------------------------------------------------------------------

SEEDS_2D, FRAMES_2D = 50, 25
POSTS = dict(zip(*worlds.ring(8, 4.0), strict=True))
START = np.array([0.0, -2.0, 0.0])
STD_U = np.array([0.002, 0.002, np.radians(0.02)])
SENSOR_2D = RangeBearing(0.01, np.radians(0.1), max_range=5.0)


@cache
def run_2d(seed, use, forget=False):
    """One run of mapping, localisation or slam, made once. Returns the scene, the true pose and the true posts.

    With `forget` the correlations between robot and landmarks are set to zero after each frame.
    """
    rng = np.random.default_rng(seed)
    scene = Scene(pose=START, P=None if use == "mapping" else np.zeros((3, 3)), sensor=SENSOR_2D)
    posts = {int(id): p for id, p in POSTS.items()}
    if use == "localisation":
        for id, p in posts.items():
            scene.add(id, p)
    scene.rob.U, true = np.diag(STD_U**2), Frame2(START)
    for _ in range(FRAMES_2D):
        u = np.array([0.25, 0.0, 2 * np.pi / 50])
        true = true.compose(Frame2(u))[0]
        scene.rob.u = u + STD_U * rng.normal(size=3)
        if use == "mapping":
            scene.rob.x = true.x
        else:
            move(scene.map, scene.rob, 0.1)
        near = {id: p for id, p in posts.items() if np.linalg.norm(p - true.t) < SENSOR_2D.max_range}
        measurements = scene.see(near, 1.0, rng, true.x)
        _, new = correct_known_lmks(*scene.all, scene.obs, measurements, scene.opt)
        init_new_lmks(*scene.all, measurements, new, scene.opt)
        if forget:
            scene.map.P[:3, 3:], scene.map.P[3:, :3] = 0, 0
    return scene, true, posts


def test_mapping_is_honest():
    """With known poses the landmarks are independent: all of all runs count."""
    nees = []
    for seed in range(SEEDS_2D):
        scene, _, posts = run_2d(seed, "mapping")
        assert len(scene.lmks) == len(posts)
        for id, lmk in scene.lmks.items():
            p, P = lmk.point(scene.map)
            nees.append(md2(p - posts[id], P))
    assert_honest(nees, 2, 0.999)


@pytest.mark.parametrize("use", ["localisation", "slam"])
def test_poses_are_honest(use):
    nees = []
    for seed in range(SEEDS_2D):
        scene, true, _ = run_2d(seed, use)
        e, E_f = scene.rob.frame(scene.map).minus(true)
        nees.append(md2(e, E_f @ scene.map.P[:3, :3] @ E_f.T))
    assert_honest(nees, 3, 0.999)


def test_a_slam_map_is_honest_as_a_whole():
    """All landmarks together with their correlations: one number a run."""
    nees = []
    for seed in range(SEEDS_2D):
        scene, _, posts = run_2d(seed, "slam")
        truth = np.concatenate([START] + [posts[id] for id in scene.lmks])
        assert scene.map.n == len(truth) == 3 + 2 * len(posts)
        nees.append(md2(scene.map.x[3:] - truth[3:], scene.map.P[3:, 3:]))
    assert_honest(nees, 2 * len(POSTS), 0.999)


def test_a_filter_that_forgets_the_correlations_is_caught():
    """Robot and landmarks treated as independent after every frame: the covariances become too small."""
    nees = []
    for seed in range(SEEDS_2D):
        scene, true, _ = run_2d(seed, "slam", forget=True)
        nees.append(md2(scene.rob.frame(scene.map).minus(true)[0], scene.map.P[:3, :3]))
    with pytest.raises(AssertionError, match="NEES/dof is"):
        assert_honest(nees, 3, 0.999)


# --- in space --------------------------------------------------------------------------------------------------------

SEEDS_3D, FRAMES_3D = 25, 30
CAMERA = PinHole(pixel_std=0.3)
STD_U3 = np.array([0.002] * 3 + [np.radians(0.02)] * 3)


def run_3d(seed, kind, **options):
    """A camera on a robot that goes round in the cloister, landmarks of some kind. Returns the scene and the truth."""
    rng = np.random.default_rng(1000 + seed)
    pose = np.array([0.0, -5.0, 0.3, 1, 0, 0, 0])
    scene = Scene(
        d=3, pose=pose, P=np.zeros((7, 7)), sensor=CAMERA, lmk_type=kind, n=0.2, N=0.15**2, n_updates=10, **options
    )
    points = {int(id): p for id, p in zip(*worlds.cloister(), strict=True)}
    scene.rob.U, true = np.diag(STD_U3**2), Frame3(pose)
    for _ in range(FRAMES_3D):
        u = np.array([0.08, 0, 0, 0, 0, np.radians(0.9)])
        true = true.compose(Frame3(np.concatenate([u[:3], v2q(u[3:])[0]])))[0].normalized()[0]
        scene.rob.u = u + STD_U3 * rng.normal(size=6)
        move(scene.map, scene.rob, 0.1)
        measurements = scene.see(points, 1.0, rng, true.x)
        p = scene.sen.frame(scene.map).to_frame(true.to_frame(np.array(list(points.values())))[0])[0]
        seen = CAMERA.visible(measurements.y, p)
        measurements.ids, measurements.y = measurements.ids[seen], measurements.y[seen]
        _, new = correct_known_lmks(*scene.all, scene.obs, measurements, scene.opt)
        init_new_lmks(*scene.all, measurements, new, scene.opt, 4)
    return scene, true


@pytest.mark.parametrize("kind, joint", [(IdpPnt(), False), (AhmPnt(), True)], ids=["inverse-depth", "anchored"])
def test_poses_in_space_are_honest(kind, joint):
    """Six degrees of freedom, in the tangent space: the 7 x 7 covariance is singular along the quaternion.

    The landmarks of one kind correct one by one, those of the other jointly.
    """
    nees = []
    for seed in range(SEEDS_3D):
        scene, true = run_3d(seed, kind, joint=joint)
        assert len(scene.lmks) > 15
        e, E_f = scene.rob.frame(scene.map).minus(true)
        nees.append(md2(e, E_f @ scene.map.P[:7, :7] @ E_f.T))
    assert_honest(nees, 6, 0.99)
