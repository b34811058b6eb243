"""Arrays as they come: read-only, as parts of others, column by column, of integers; and a map with nothing in it."""

import copy
import pickle

import numpy as np
import pytest

from ekfslam_tutorial.ekf.covariances import check_covariance
from ekfslam_tutorial.fast import FastMap
from ekfslam_tutorial.fast.compiled import program, step
from ekfslam_tutorial.fast.refused import clearly_covariance
from ekfslam_tutorial.geometry import Frame2, Frame3
from ekfslam_tutorial.models.landmarks import AhmPnt, EucPnt
from ekfslam_tutorial.models.observation import expect
from ekfslam_tutorial.models.sensors import BearingOnly2, PinHole, RangeBearing
from ekfslam_tutorial.slam import Lmk, Options, Rob, Sen, correct_known_lmks

from .interpreter import build
from .scenes import POINTS, Scenes, raw

SENSOR = RangeBearing(0.1, 0.02)


def read_only(a):
    a = np.array(a)
    a.flags.writeable = False
    return a


def apart(a):
    """The same numbers, with others in between."""
    wide = np.full([2 * n for n in np.shape(a)], 77.0)
    part = wide[tuple(slice(None, None, 2) for _ in np.shape(a))]
    part[...] = a
    return part


AS = {
    "read-only": read_only,
    "apart": apart,
    "backwards": lambda a: np.array(a)[..., ::-1].copy()[..., ::-1],
    "column by column": np.asfortranarray,
    "short floats": lambda a: np.asarray(a, np.float32),
    "integers": lambda a: np.rint(a).astype(int),
    "broadcast": lambda a: np.broadcast_to(a, np.shape(a)),
}


@pytest.mark.parametrize("joint", [False, True], ids=["sequential", "joint"])
@pytest.mark.parametrize("noise", [False, True], ids=["R of the sensor", "R for each"])
@pytest.mark.parametrize("form", AS)
def test_controls_and_measurements(form, noise, joint, interpreted, rng):
    pair, given = Scenes(SENSOR, joint=joint), AS[form]
    for _ in range(3):
        pair.move(given(np.array([1.0, 0.02, 0.05])), given(np.eye(3) + 1e-3))
        R = given(np.array([np.eye(2)] * 5)) if noise else None
        events = pair.look(raw(range(5), given(pair.measured(rng)), R))
    assert len(events) >= 5 and any(o.updated for o in pair.compiled.obs.values())


@pytest.mark.parametrize("form", AS)
def test_parameters_of_sensors(form, interpreted):
    if form == "short floats":
        return  # the parameters are other numbers then
    given = AS[form]
    lens = PinHole(k=given([320.0, 240.0, 300.0, 300.0]), d=given([1.0, 2.0]), c=given([0.0, 1.0]))
    F, p = Frame3(np.eye(7)[3]), np.array([[0.1, -0.2, 2.0]])
    e, v, visible, *_ = step.expected(FastMap(), F, F, lens, EucPnt(3), p, None, None, None, True)
    want = expect(F, F, lens, EucPnt(3), p)
    assert np.allclose(e, want[0], rtol=1e-12) and visible == lens.visible(e, v)


@pytest.mark.parametrize("form", AS)
def test_priors_of_a_landmark(form, interpreted, rng):
    given = AS[form]
    pair = Scenes(BearingOnly2(0.02), lmk_type=AhmPnt(2), n=given([1.0]), N=given([[1.0]]))
    for _ in range(2):
        pair.move(np.array([0.1, 0.3, 0.05]))
        pair.look(raw(range(5), pair.measured(rng)))
    assert len(pair.compiled.lmks) == 5


@pytest.mark.parametrize("joint", [False, True], ids=["sequential", "joint"])
@pytest.mark.parametrize("form", AS)
def test_known_states(form, joint, interpreted, rng):
    """Nothing is estimated, or the sensor's frame only: known robots and landmarks are whatever the user gave."""
    given = AS[form]
    for calibrate in (False, True):
        pair = Scenes(SENSOR, joint=joint)
        for scene in pair.all:
            scene.map.remove(scene.rob.r)
            scene.rob = Rob(1, scene.rob.motion, x=given(np.zeros(3)))
            scene.sen = Sen(1, 1, SENSOR, Frame2, x=given(np.zeros(3)))
            if calibrate:
                scene.sen.x, scene.sen.r = None, scene.map.add([0.2, 0.0, 0.1], 0.01 * np.eye(3))
            scene.lmks = {i: Lmk(i, EucPnt(2), x=given(p), slot=i) for i, p in enumerate(np.rint(POINTS))}
        events = pair.look(raw(range(5), pair.measured(rng)))
        assert len(events) >= 5


def test_an_empty_map_with_numba():
    """A map in which nothing is, ever was, or is left."""
    assert step.build is not build
    for states in (0, 1, 2):
        pair = Scenes(SENSOR)
        scene = pair.compiled
        scene.map.remove(scene.rob.r)
        scene.map = type(scene.map)(compiled=True) if states == 0 else scene.map
        scene.rob, scene.opt = Rob(1, scene.rob.motion, x=np.zeros(3)), Options(joint=states == 2)
        lmks = {1: Lmk(1, EucPnt(2), x=np.array([3, 1]))}
        y = np.array([[3.1, 0.3]])
        events, _ = correct_known_lmks(scene.map, scene.rob, scene.sen, lmks, scene.obs, raw([1], y), scene.opt)
        assert [e.kind for e in events] == ["search", "innovation", "correction"] and scene.map.n_used == 0


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda map: pickle.loads(pickle.dumps(map))], ids=["copy", "pickle"])
def test_copies_of_a_map_go_on_alone(copied, interpreted, rng):
    pair = Scenes(SENSOR)
    pair.go(rng), pair.go(rng)
    old = pair.compiled.map
    x, P = old.x.copy(), old.P.copy()
    pair.compiled.map = copied(old)
    for _ in range(3):
        pair.go(rng)
    assert pair.compiled.map.compiled and not np.array_equal(pair.compiled.map.P, P)
    assert np.array_equal(old.x, x) and np.array_equal(old.P, P)


@pytest.mark.parametrize("wrong", [np.ones(3, int), np.ones((2, 3), order="F"), np.ones((2, 6))[:, ::2], np.ones(3)])
def test_what_would_be_misread_is_seen_here(wrong):
    """Machine code does not look at its arguments; in these tests somebody does."""
    total = program.build("f8(f8[:, ::1])", "a", ["return np.sum(a)"])
    assert total(read_only(np.ones((2, 3)))) == 6.0
    with pytest.raises(TypeError, match="is not array"):
        total(wrong)


def test_what_is_clearly_a_covariance():
    """The quick test says yes to nothing that the core refuses, and yes to what is well within, singular or rounded."""
    rng, sure = np.random.default_rng(5), 0
    for _ in range(2000):
        n = rng.integers(1, 5)
        A = rng.normal(size=(n, n)) * 10.0 ** rng.choice([-150, -4, 0, 3, 150], (n, 1))
        U = A @ np.diag(rng.choice([1.0, 1.0, 1.0, 0.0, -1e-9, -1.0], n)) @ A.T
        U = (U + U.T) / 2
        if rng.random() < 0.2:
            U[tuple(rng.integers(0, n, 2))] += rng.choice([np.nan, np.inf, -np.inf, 1e-12, 1e-3])
        if clearly_covariance(U, (n,)):
            sure += 1
            check_covariance(U, n)
    assert sure > 300
    for n in range(1, 5):
        A = rng.normal(size=(n, n))
        U, on_the_spot = A @ A.T + 0.1 * np.eye(n), np.diag([0.0] * (n - 1) + [1e-4])
        rounded = U * (1 + 1e-15 * np.tri(n, k=-1))
        for yes in U, rounded, on_the_spot, np.zeros((n, n)):
            assert clearly_covariance(yes, (n,))
    skew, negative = np.array([[1.0, 1e-9], [0.0, 1.0]]), np.diag([1.0, -1e-9])
    no = ([[1.0]], (1,)), (np.eye(2), (3,)), (np.eye(2), (3, 2)), (skew, (2,)), (negative, (2,)), (-np.eye(2), (2,))
    assert not any(clearly_covariance(U, shape) for U, shape in (*no, (np.eye(2, dtype=int), (2,))))
