"""Masked, complex and other arrays: numpy would drop a part without a word. One sentence, by both engines."""

import numpy as np
import pytest

from ekfslam_tutorial import ekf, fast, slam
from ekfslam_tutorial.fast.extra import check_compiled
from ekfslam_tutorial.geometry import Frame2
from ekfslam_tutorial.models.motion import Unicycle
from ekfslam_tutorial.models.sensors import RangeBearing
from ekfslam_tutorial.simulation import SimObs
from ekfslam_tutorial.slam import Options, Rob, Sen
from ekfslam_tutorial.toolbox import Recording
from ekfslam_tutorial.toolbox.recordings import ControlLog, RawLog

check_compiled(ValueError)
MAPS = {
    "plain": (ekf, slam, ekf.Map),
    "fast": (fast, fast, fast.FastMap),
    "compiled": (fast, fast, lambda: fast.FastMap(compiled=True)),
    "compressed": (fast, fast, fast.CompressedMap),
}
each_map = pytest.mark.parametrize("name", MAPS)
KINDS = {
    "complex": (lambda a: a + 0.5j, "must be real numbers, got complex128"),
    "objects": (lambda a: a.astype(object), "must be real numbers, got object"),
    "texts": (lambda a: a.astype(str), "must be real numbers, got <U32"),
    "truth values": (lambda a: a > 0, "must be real numbers, got bool"),
    "masked": (lambda a: np.ma.masked_equal(a, a.flat[0]), "must not have masked entries: leave out what is not known"),
    "ragged": (lambda a: [[1.0], [2.0, 3.0]], "must be real numbers, got rows of different lengths"),
}
each_kind = pytest.mark.parametrize("kind", KINDS)
U = np.array([[0.1, 0.02], [0.02, 0.2]])


def a_map(name):
    map = MAPS[name][2]()
    return map, map.add(np.zeros(3), np.eye(3)), map.add(np.ones(2), np.eye(2))


def state_of(map):
    return [map.state(r).tobytes() + map.block(r).tobytes() for r in map.ranges]


CALLS = {
    "predict": (lambda f, map, r, l, *a: f.predict(map, r, *a), (np.zeros(3), np.eye(3), np.ones((3, 2)), U)),
    "update": (
        lambda f, map, r, l, J, L, z, R: f.update(map, ((r, J), (l, L)), z, R),
        (np.ones((2, 3)), np.eye(2), np.array([0.1, 0.2]), np.eye(2)),
    ),
    "augment": (
        lambda f, map, r, l, x, L, Q: f.augment(map, x, ((r, L),), Q),
        (np.ones(2), np.ones((2, 3)), np.eye(2)),
    ),
    "add": (lambda f, map, r, l, *a: map.add(*a), (np.ones(3), np.eye(3), np.zeros((3, 5)))),
}


@each_kind
@each_map
@pytest.mark.parametrize("call", CALLS)
def test_the_filter_takes_real_numbers_only(call, name, kind):
    """Each argument in turn; nothing has been changed then."""
    make, words = KINDS[kind]
    f, arguments = CALLS[call]
    for i in range(len(arguments)):
        map, r, l = a_map(name)
        before = state_of(map)
        with pytest.raises(ValueError, match=words) as refused:
            f(MAPS[name][0], map, r, l, *arguments[:i], make(arguments[i]), *arguments[i + 1 :])
        assert "\n" not in str(refused.value) and state_of(map) == before


@each_map
@pytest.mark.parametrize("call", CALLS)
def test_lists_and_whole_numbers_are_numbers(call, name):
    f, arguments = CALLS[call]
    for kind in (list, np.ma.masked_array):
        map, r, l = a_map(name)
        f(MAPS[name][0], map, r, l, *arguments)
        other, r, l = a_map(name)
        taken = [a.tolist() if kind is list else kind(a) for a in arguments]
        f(MAPS[name][0], other, r, l, *taken)
        for one, two in zip(map.ranges, other.ranges, strict=True):
            np.testing.assert_allclose(map.state(one), other.state(two), rtol=1e-13)
            np.testing.assert_allclose(map.block(one), other.block(two), rtol=1e-13, atol=1e-15)


@each_kind
@each_map
def test_a_start(name, kind):
    make, words = KINDS[kind]
    rob = Rob(1, Unicycle())
    for P in (None, np.eye(3)):
        with pytest.raises(ValueError, match=f"Rob 1: the state {words}"):
            slam.place(MAPS[name][2](), rob, make(np.array([1.0, 2.0, 0.5])), P)


# --- the steps -------------------------------------------------------------------------------------------------------


def a_robot(name):
    map = MAPS[name][2]()
    rob = Rob(1, Unicycle(), x=np.zeros(3), r=map.add(np.zeros(3), 0.1 * np.eye(3)), u=np.array([1.0, 0.1]), U=U)
    return map, rob, Sen(1, 1, RangeBearing(0.1, 0.02), Frame2, x=np.zeros(3))


@each_kind
@each_map
@pytest.mark.parametrize("what", ["u", "U"])
def test_a_control(what, name, kind):
    map, rob, _ = a_robot(name)
    make, words = KINDS[kind]
    setattr(rob, what, make(getattr(rob, what)))
    with pytest.raises(ValueError, match=f"robot 1: the control.* {words}"):
        MAPS[name][1].move(map, rob, 0.1)


@each_map
def test_a_control_in_lists(name):
    (map, rob, _), (other, listed, _) = a_robot(name), a_robot(name)
    listed.u, listed.U = rob.u.tolist(), U.tolist()
    MAPS[name][1].move(map, rob, 0.1)
    MAPS[name][1].move(other, listed, 0.1)
    assert state_of(map) == state_of(other)


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != "ragged"])
@each_map
@pytest.mark.parametrize("what", ["y", "R"])
def test_a_measurement(what, name, kind):
    map, rob, sen = a_robot(name)
    make, words = KINDS[kind]
    raw = {"y": np.array([[3.0, 0.2], [2.0, 0.1]]), "R": np.tile(0.01 * np.eye(2), (2, 1, 1))}
    raw[what] = make(raw[what])
    with pytest.raises(ValueError, match=words):
        opt = Options(association=slam.KnownIds())
        MAPS[name][1].correct_known_lmks(map, rob, sen, {}, {}, SimObs(1, np.array([1, 2]), **raw), opt)


# --- recordings ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["complex", "objects", "texts", "masked"])
def test_a_recording(kind):
    """A mask is not dropped: what it hides would come back as a measurement."""
    make, t = KINDS[kind][0], np.array([0.1, 0.2])
    u, y, x, ids = np.ones((2, 2)), np.ones((2, 2)), np.zeros((2, 3)), np.arange(2)
    offsets = np.array([0, 1, 2])
    for refused in (
        lambda: ControlLog(make(u)),
        lambda: ControlLog(u, make(np.tile(U, (2, 1, 1)))),
        lambda: RawLog(1, offsets, ids, make(y)),
        lambda: RawLog(1, offsets, ids, y, make(np.tile(U, (2, 1, 1)))),
        lambda: Recording("log", make(t), {1: u}, {}),
        lambda: Recording("log", t, {1: u}, {}, truth={1: make(x)}),
        lambda: Recording("log", t, {1: u}, {}, fixes={1: make(x)}),
        lambda: Recording("log", t, {1: u}, {}, landmarks=(ids, make(y))),
    ):
        with pytest.raises(ValueError, match="must be (real )?numbers|must not have masked entries"):
            refused()


def test_masked_ids():
    ids, offsets = np.ma.masked_equal([1, 2], 2), np.array([0, 1, 2])
    with pytest.raises(ValueError, match="ids must not have masked entries"):
        RawLog(1, offsets, ids, np.ones((2, 2)))
    for name in MAPS:
        map, rob, sen = a_robot(name)
        with pytest.raises(ValueError, match="sensor 1: ids must not have masked entries"):
            opt = Options(association=slam.KnownIds())
            MAPS[name][1].correct_known_lmks(map, rob, sen, {}, {}, SimObs(1, ids, np.ones((2, 2))), opt)
