"""Measurements with noise of their own, in any order, some refused: each is corrected with its own R, by both engines.

The second author works with full matrices, written out here. Compared are the means: of the covariance there are two
right ones, before and after it is turned with the estimate.
"""

import numpy as np
import pytest

from ekfslam_tutorial.models import observe
from ekfslam_tutorial.models.sensors import RangeBearing
from ekfslam_tutorial.slam import KnownIds, NearestNeighbour

from .scenes import POINTS, Scenes, raw

ORDERS = [0, 1, 2, 3, 4], [3, 0, 4, 2, 1], [2, 4, 1]
GATE = 16.0


def start(**options):
    """All landmarks are in the map; the robot has moved since."""
    scenes = Scenes(RangeBearing(0.05, 0.01), md2_threshold=GATE, **options)
    seen = measured(range(len(POINTS)), 1e-6 * np.eye(2)[None].repeat(len(POINTS), 0), np.zeros((len(POINTS), 2)))
    scenes.each(lambda s: find(s, seen) and None)
    for s in scenes.all:
        s.rob.u, s.rob.U = np.array([0.3, 0.05, 0.02]), np.diag([0.02, 0.02, 0.003])
        s.engine.move(s.map, s.rob, 1.0)
    return scenes


def measured(order, R, errors):
    """Points as they are seen from the origin, with these errors; ids from 1."""
    order = list(order)
    p = POINTS[order] - [0.2, 0.0]
    c, s = np.cos(0.1), np.sin(0.1)
    p = p @ np.array([[c, -s], [s, c]])
    y = np.stack([np.hypot(*p.T), np.arctan2(p[:, 1], p[:, 0])], -1)
    return raw(np.array(order) + 1, y + errors, R)


def find(s, seen):
    events, new = s.engine.correct_known_lmks(s.map, s.rob, s.sen, s.lmks, s.obs, seen, s.opt)
    return events + s.engine.init_new_lmks(s.map, s.rob, s.sen, s.lmks, seen, new, s.opt)


def noises(order, rng):
    """Covariances that differ a thousandfold, with correlation."""
    B = rng.normal(size=(len(order), 2, 2)) * 10 ** rng.uniform(-2.5, -1, (len(order), 1, 1))
    return B @ B.swapaxes(1, 2) + 1e-6 * np.eye(2)


def blocks(s, id, x):
    """Expectation of a landmark, and its derivative by the whole map, at a mean."""
    lmk = s.lmks[id]
    F, S = s.rob.motion.frame(x[s.rob.r]), s.sen.frame(s.map)
    e, E_r, _, E_l = observe(F, S, s.sen.model, lmk.type, x[lmk.r])
    H = np.zeros((2, len(x)))
    H[:, s.rob.r], H[:, lmk.r] = E_r, E_l
    return e, H


def jointly(s, seen):
    """The mean after one correction by all that pass the gate, and who passes."""
    x, P = s.map.x.copy(), s.map.P.copy()
    z, H, R, used = [], [], [], []
    for id, y, R_i in zip(seen.ids.tolist(), seen.y, seen.R, strict=True):
        e, H_i = blocks(s, id, x)
        z_i = s.sen.model.residual(y, e)
        if z_i @ np.linalg.solve(H_i @ P @ H_i.T + R_i, z_i) < GATE:
            z.append(z_i), H.append(H_i), R.append(R_i), used.append(id)
    z, H = np.concatenate(z), np.concatenate(H)
    Z = H @ P @ H.T
    for i, R_i in enumerate(R):
        Z[2 * i : 2 * i + 2, 2 * i : 2 * i + 2] += R_i
    return x + P @ H.T @ np.linalg.solve(Z, z), sorted(used)


@pytest.mark.parametrize(
    ("association", "refused"),
    [(KnownIds(), None), (KnownIds(), 0), (KnownIds(), 1), (KnownIds(), 2), (NearestNeighbour(), None)],
)
@pytest.mark.parametrize("order", ORDERS, ids=str)
def test_each_has_its_own_noise_in_a_joint_correction(order, association, refused, rng):
    """In another order than the landmarks are in, with one in front, in the middle, or at the end refused."""
    scenes = start(joint=True, association=association)
    errors = 0.01 * rng.normal(size=(len(order), 2))
    if refused is not None:
        errors[refused] += [0.0, 0.9]
    seen = measured(order, noises(order, rng), errors)
    wanted, used = jointly(scenes.plain, seen)
    assert len(used) == len(order) - (refused is not None)
    for s in scenes.all:
        find(s, seen)
        after = s.map.x if s is scenes.plain else np.concatenate([s.map.state(r) for r in s.map.ranges])
        np.testing.assert_allclose(after[: len(wanted)], wanted, rtol=1e-9, atol=1e-10)
        assert sorted(id for (_, id), o in s.obs.items() if o.updated) == used


@pytest.mark.parametrize("large", [[0, 3], [1, 2, 4], [2]], ids=str)
def test_each_is_gated_by_its_own_noise(large):
    """All are 3 m wrong: those that are told to be a metre uncertain pass, the others do not, whoever is the first."""
    scenes = start(joint=True)
    stds = np.where(np.isin(range(5), large), 1.0, 0.01)
    seen = measured(range(5), stds[:, None, None] ** 2 * np.eye(2), np.tile([3.0, 0.0], (5, 1)))
    wanted, used = jointly(scenes.plain, seen)
    assert used == [i + 1 for i in large]
    for s in scenes.all:
        find(s, seen)
        assert sorted(id for (_, id), o in s.obs.items() if o.updated) == used
        after = s.map.x if s is scenes.plain else np.concatenate([s.map.state(r) for r in s.map.ranges])
        np.testing.assert_allclose(after[: len(wanted)], wanted, rtol=1e-9, atol=1e-10)


@pytest.mark.parametrize("order", ORDERS, ids=str)
@pytest.mark.parametrize("reproject", [False, True])
def test_each_has_its_own_noise_one_by_one(order, reproject, rng):
    """The first correction of a frame, by the landmark that is least certain: the mean is that of its own R."""
    scenes = start(reproject=reproject, n_updates=1)
    seen = measured(order, noises(order, rng), 0.01 * rng.normal(size=(len(order), 2)))
    means = {
        id: jointly(scenes.plain, raw([id], seen.y[[i]], seen.R[[i]]))[0] for i, id in enumerate(seen.ids.tolist())
    }
    for s in scenes.all:
        find(s, seen)
        [id] = [id for (_, id), o in s.obs.items() if o.updated]
        after = np.concatenate([s.map.state(r) for r in s.map.ranges])
        np.testing.assert_allclose(after, means[id], rtol=1e-9, atol=1e-10)
