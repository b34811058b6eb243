"""Numbers at the ends of what makes sense: a finite answer that is right, or one clear sentence."""

import numpy as np
import pytest

from ekfslam_tutorial.ekf import Map, correct, covariance, cross, innovation
from ekfslam_tutorial.geometry import Frame3
from ekfslam_tutorial.models.sensors import PinHole, RangeBearing
from ekfslam_tutorial.toolbox import UserData, universal_slam
from tests.numerics.test_precision import Dense, Ours, drive, start
from tests.toolbox.scenarios import FLAT, SPACE


@pytest.mark.parametrize("scale", [1e-6, 1e-3, 1e3, 1e6])
def test_the_unit_of_length_does_not_matter(scale):
    """The same world a millionth and a million times as large, beside the filter of more digits.

    1e-6 of a sigma: the heading's variance and those of the positions are then up to 1e12 apart.
    """
    x, P = start(scale)
    assert drive(Dense(x, P, np.longdouble), Ours(x, P), scale=scale) < 1e-6


@pytest.mark.parametrize(("range_std", "tolerance"), [(1e-6, 1e-2), (1e9, 1e-6)])
def test_noise_of_a_millionth_and_of_a_billion(range_std, tolerance):
    """A range that is nearly perfect, and a worthless one.

    For the first, P loses a factor of 1e10 in one correction: 1e-16 of rounding are 1e-6 of what is left, and the
    tolerance is a hundredth of a sigma.
    """
    x, P = start()
    ours, theirs = Ours(x, P), Dense(x, P, np.longdouble)
    assert drive(theirs, ours, range_std=range_std) < tolerance
    assert np.linalg.eigvalsh(ours.P)[0] > -1e-9 * np.linalg.eigvalsh(ours.P)[-1]


def test_noise_below_what_doubles_can_hold_is_refused():
    """1e-9 m beside a map of 0.3 m: the variances are 1e17 apart, more than a double has digits. A sentence, no NaN."""
    x, P = start()
    with pytest.raises(ValueError, match="innovation covariance must be positive definite"):
        drive(Dense(x, P, np.longdouble), Ours(x, P), range_std=1e-9)


def run(table, **changes):
    """The last snapshot of a run; every number in it finite."""
    for s in universal_slam(UserData.from_dict(table, {k.replace("__", "."): v for k, v in changes.items()})):
        assert np.isfinite(s.map.x).all() and np.isfinite(s.map.P).all()
    return s


def test_without_noise_of_motion_the_pose_is_exact():
    s = run(FLAT, robot__v_std=0.0, robot__w_std_deg=0.0, time__last=20)
    np.testing.assert_allclose(s.robs[0].state(s.map)[:2], s.truth[1][:2], atol=1e-12)
    assert not s.map.block(s.robs[0].r).any()


@pytest.mark.parametrize("key", ["range_std", "bearing_std_deg"])
def test_a_sensor_without_noise_is_refused(key):
    with pytest.raises(ValueError, match="must be a positive number, got 0.0"):
        run(FLAT, **{f"sensor__{key}": 0.0})


def test_a_measurement_without_noise_is_taken_at_its_word():
    """R = 0 with an uncertain state: the innovation is invertible, and the state hits the measurement."""
    m = Map()
    m.add([1.0, 2.0], np.diag([4.0, 9.0]))
    blocks = ((slice(0, 2), np.array([[1.0, 0.0]])),)
    PHt = cross(m, blocks)
    correct(m, PHt, innovation(np.array([0.5]), covariance(PHt, blocks), np.zeros((1, 1))))
    np.testing.assert_allclose(m.x, [1.5, 2.0])
    np.testing.assert_allclose(m.P, np.diag([0.0, 9.0]), atol=1e-15)


def test_what_is_certain_cannot_be_measured_without_noise():
    m = Map()
    m.add([1.0], [[0.0]])
    blocks = ((slice(0, 1), np.eye(1)),)
    PHt = cross(m, blocks)
    with pytest.raises(ValueError, match="definite"):
        correct(m, PHt, innovation(np.array([0.5]), covariance(PHt, blocks), np.zeros((1, 1))))
    assert m.x == [1.0] and m.P == [[0.0]]  # nothing has been touched


def test_two_landmarks_at_the_same_place_stay_two():
    world = {"type": "points", "points": [[2.0, 1.0], [2.0, 1.0], [3.0, -1.0]]}
    s = run(FLAT | {"world": world}, time__last=30)
    assert len(s.lmks) == 3
    a, b = (s.lmks[i].point(s.map)[0] for i in sorted(s.lmks)[:2])
    assert np.linalg.norm(a - b) < 0.5


def test_a_landmark_in_the_place_of_the_sensor_has_no_bearing():
    """Zero range: the bearing and its derivatives do not exist; a sentence or no sight, never NaN."""
    model = RangeBearing(0.1, 0.01)
    try:
        y, Y_p = model.project(np.zeros(2))[:2]
    except (ValueError, ZeroDivisionError, FloatingPointError) as error:
        assert "range" in str(error) or "sensor" in str(error)
    else:
        assert np.isfinite(y).all() and np.isfinite(Y_p).all() or not model.visible(y, np.zeros(2)).all()
    s = run(FLAT | {"world": {"type": "points", "points": [[0.0, 0.0], [2.0, 1.0]]}}, time__last=5)
    assert s.lmks


@pytest.mark.parametrize("depth", [0.0, -1.0, 1e-300, 1e300])
def test_a_point_in_or_behind_the_lens_is_not_seen(depth):
    camera = PinHole((320.0, 240.0, 320.0, 320.0), image_size=(640, 480), pixel_std=1.0)
    p = np.array([[0.1, 0.1, depth]])
    with np.errstate(all="ignore"):
        y = camera.project(p)[0]
        seen = np.asarray(camera.visible(y, p))
    assert not seen.any() or (np.isfinite(y).all() and depth > 0)


@pytest.mark.parametrize("pitch", [90.0, -90.0, 89.9999999, 180.0])
def test_gimbal_directions_are_directions_like_others(pitch):
    """A robot that looks straight up drives and maps as any other: quaternions have no gimbal lock."""
    s = run(SPACE, robot__orientation_deg=[0.0, pitch, 0.0], time__last=10)
    assert abs(np.linalg.norm(s.robs[0].state(s.map)[3:7]) - 1) < 1e-12


def test_half_a_turn_has_a_rotation_vector():
    F, G = Frame3([0, 0, 0, 1.0, 0, 0, 0]), Frame3([0, 0, 0, 0.0, 0, 0, 1.0])
    e, E_x = G.minus(F)
    assert abs(np.linalg.norm(e[3:]) - np.pi) < 1e-12 and np.isfinite(E_x).all()


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_what_is_not_finite_is_refused_by_name(bad):
    m = Map()
    with pytest.raises(ValueError, match="finite"):
        m.add([bad], [[1.0]])
    with pytest.raises(ValueError, match="finite"):
        m.add([0.0], [[bad]])
    assert m.n_used == 0
