"""Where a model's words say "up to", "at least" or "above": the number itself, and the next one to it."""

from dataclasses import MISSING, fields

import numpy as np
import pytest

from ekfslam_tutorial.models import landmarks, motion, sensors
from ekfslam_tutorial.models.landmarks import AhmPnt, IdpPnt
from ekfslam_tutorial.models.landmarks.idp_pnt import POLE, py2vec, vec2py
from ekfslam_tutorial.models.landmarks.projective import ahead, linearity
from ekfslam_tutorial.models.observation import check_fit
from ekfslam_tutorial.models.sensors.davison_cam import bend
from ekfslam_tutorial.models.sensors.lens import exact_undistort, inv_distortion

INF, TURN = np.inf, 2 * np.pi
UP, DOWN = INF, -INF
"""Directions for `nextafter`."""

IMAGE = {"k": (320.0, 240.0, 320.0, 320.0), "image_size": (640.0, 480.0), "pixel_std": 1.0, "margin": 0.0}
LENS = IMAGE | {"d": (), "c": None}
VIEW = {"max_range": INF, "fov": TURN}
IMU = {"gyro_noise": 1.7e-4, "acc_noise": 2e-3, "gyro_walk": 2e-5, "acc_walk": 3e-3, "gravity": (0.0, 0.0, -9.81)}
DEFAULTS = {
    sensors.PinHole: LENS,
    sensors.PinHoleDepth: LENS | {"depth_std": 0.1},
    sensors.SegmentCam: LENS | {"min_length": 20.0},
    sensors.StereoPinHole: IMAGE | {"baseline": 0.2, "min_disparity": 1.0},
    sensors.DavisonCam: {
        "k": (162.0, 125.0, 195.0, 195.0), "k1": 9e-6, "image_size": (320.0, 240.0), "pixel_std": 1.0, "margin": 0.0,
    },
    sensors.OmniCam: {"c": None, "image_size": (1280.0, 960.0), "pixel_std": 1.0, "margin": 0.0, "fov": np.pi},
    sensors.Range: {"range_std": 0.1, "bias": 0.0, "max_range": INF, "dim": 2},
    sensors.RangeBearing: VIEW, sensors.BearingOnly2: VIEW, sensors.Doppler: VIEW | {"rate_std": 0.1},
    sensors.RangeBearingElevation: VIEW
    | {"range_std": 0.05, "bearing_std": 0.01, "elevation_std": 0.01, "fov_up": np.pi},
    sensors.RangeRate: {"rate_std": 0.1, "max_range": INF, "dim": 2},
    sensors.PointXY: {"std": 0.1, "max_range": INF}, sensors.PointXYZ: {"std": 0.1, "max_range": INF},
    sensors.Gps: {"std": 1.0, "dim": 2}, sensors.Compass: {"heading_std": 0.02, "declination": 0.0, "dim": 2},
    sensors.WheelSpeed: {"speed_std": 0.02, "scale": 1.0}, sensors.GroundFlow: {"flow_std": 0.05, "height": 1.0},
    motion.Ackermann: {"wheelbase": 2.7},
    motion.Vehicle: {"wheelbase": 2.83, "ahead": 3.78, "left": 0.5, "track": 0.76},
    motion.DifferentialDrive: {"base": 0.4},
    motion.Imu: IMU, motion.ImuClock: IMU,
    landmarks.EucPnt: {"dim": 3}, landmarks.AhmPnt: {"dim": 3}, landmarks.HmgPnt: {"dim": 3},
    landmarks.Beacon: {"dim": 2, "bias_std": 1.0, "scale_std": 0.0},
}  # fmt: skip
EXPORTED = [getattr(module, name) for module in (motion, sensors, landmarks) for name in module.__all__]
by_name = {"ids": lambda kind: kind.__name__}


@pytest.mark.parametrize("kind", EXPORTED, **by_name)
def test_every_default_of_a_model(kind):
    assert {f.name: f.default for f in fields(kind) if f.default is not MISSING} == DEFAULTS.get(kind, {})


SIZES = {  # of the state, of its frame, of the control; the states beside the frame
    motion.Odometry2: (3, 3, 3, ()), motion.Odometry3: (7, 7, 6, ()), motion.Unicycle: (3, 3, 2, ()),
    motion.Vehicle: (3, 3, 3, ()), motion.Ackermann: (3, 3, 2, ()), motion.DifferentialDrive: (3, 3, 2, ()),
    motion.ConstantTurn: (5, 3, 2, (1, 1)), motion.ConstantVelocity: (13, 7, 6, (3, 3)),
    motion.Imu: (16, 7, 12, (3, 3, 3)), motion.ImuClock: (17, 7, 18, (3, 3, 3, 1)),
}  # fmt: skip


@pytest.mark.parametrize("name", motion.__all__)
def test_a_motion_model_says_its_sizes(name):
    kind = getattr(motion, name)
    sizes = kind.size, kind.frame.size, sum(kind.control_fields.values()), tuple(kind.state_fields.values())
    assert sizes == SIZES[kind] and sizes[1] + sum(sizes[3]) == sizes[0]


SEES = {  # dimension, bearing only, units
    sensors.RangeBearing: (2, False, "m rad"), sensors.BearingOnly2: (2, True, "rad"),
    sensors.PointXY: (2, False, "m m"), sensors.Range: (2, False, "m"), sensors.RangeRate: (2, False, "m/s"),
    sensors.Doppler: (2, False, "m rad m/s"), sensors.WheelSpeed: (2, False, "m/s"),
    sensors.GroundFlow: (2, False, "rad/s rad/s"), sensors.Gps: (2, False, "m m"), sensors.Compass: (2, False, "rad"),
    sensors.RangeBearingElevation: (3, False, "m rad rad"), sensors.PointXYZ: (3, False, "m m m"),
    sensors.PinHole: (3, True, "px px"), sensors.DavisonCam: (3, True, "px px"), sensors.OmniCam: (3, True, "px px"),
    sensors.PinHoleDepth: (3, False, "px px m"), sensors.StereoPinHole: (3, False, "px px px"),
    sensors.SegmentCam: (3, True, "px px px px"),
}  # fmt: skip
ASKS = {  # its own velocity, no landmarks, what may be a state
    sensors.Doppler: (True, False, ()), sensors.RangeRate: (True, False, ()), sensors.Gps: (False, True, ()),
    sensors.Compass: (False, True, ("declination",)), sensors.WheelSpeed: (True, True, ("scale",)),
    sensors.GroundFlow: (True, True, ("height",)), sensors.OmniCam: (False, False, ("k", "d")),
    sensors.PinHole: (False, False, ("k", "d")), sensors.PinHoleDepth: (False, False, ("k", "d")),
}  # fmt: skip


@pytest.mark.parametrize("name", sensors.__all__)
def test_a_sensor_says_what_it_measures_and_what_it_asks_for(name):
    kind = getattr(sensors, name)
    units = kind().units if name == "Gps" else kind.units
    assert (kind.dim, kind.bearing_only, " ".join(units)) == SEES[kind]
    asks = getattr(kind, "asks_robot", "") == "moving", getattr(kind, "without_lmks", False)
    assert (*asks, getattr(kind, "parameters", ())) == ASKS.get(kind, (False, False, ()))
    assert sensors.Gps(dim=3).units == ("m", "m", "m")


@pytest.mark.parametrize(
    ("kind", "size", "priors"),
    [
        (landmarks.IdpPnt, 6, None), (landmarks.HmgLin, 8, (1, 1)), (landmarks.AhmLin, 11, (1, 1)),
        (landmarks.IdpLin, 9, (1, 1)), (landmarks.PlkLin, 6, (1, 0)), (landmarks.AplLin, 9, (1, 0)),
    ],
)  # fmt: skip
def test_a_landmark_type_says_its_size_and_what_it_leaves_open(kind, size, priors):
    assert (kind().dim, kind().size, getattr(kind, "priors", None)) == (3, size, priors)
    assert landmarks.Beacon(2).size == 4 and landmarks.Beacon.prior == 2
    assert landmarks.Beacon(2, 0.5, 0.1).N.tolist() == [[0.25, 0.0], [0.0, 0.1**2]]


# --- what is seen -----------------------------------------------------------------------------------------------------


def sees(sensor, p, y=None):
    p = np.asarray(p, float)
    with np.errstate(all="ignore"):
        return bool(sensor.visible(sensor.project(p)[0] if y is None else np.asarray(y, float), p))


@pytest.mark.parametrize(
    "sensor",
    [
        sensors.RangeBearing(0.1, 0.1, max_range=5.0),
        sensors.BearingOnly2(0.1, max_range=5.0),
        sensors.PointXY(max_range=5.0),
        sensors.Range(max_range=5.0),
        sensors.RangeBearingElevation(max_range=5.0),
        sensors.PointXYZ(max_range=5.0),
        sensors.Range(max_range=5.0, dim=3),
        sensors.RangeRate(max_range=5.0),
        sensors.RangeRate(max_range=5.0, dim=3),
        sensors.Doppler(0.1, 0.1, max_range=5.0),
    ],
    ids=lambda sensor: f"{type(sensor).__name__} {sensor.dim}",
)
def test_the_greatest_range_is_seen_and_nothing_beyond(sensor):
    for p in ([3.0, 4.0], [4.0, -3.0], [-5.0, 0.0]):
        p = np.append(p, [0.0] * (sensor.dim - 2))
        v = [9.0] * (6 if sensor.dim == 3 else 3) * hasattr(sensor, "asks_robot")
        assert sees(sensor, [*p, *v]) and not sees(sensor, [*p * (1 + 1e-12), *v])


@pytest.mark.parametrize(
    "sensor",
    [sensors.RangeBearing(0.1, 0.1), sensors.RangeBearingElevation(), sensors.Range(), sensors.RangeRate(dim=3)],
    ids=str,
)
def test_what_is_at_the_sensor_itself_is_not_seen(sensor):
    p = np.zeros(sensor.dim + 6 * hasattr(sensor, "asks_robot"))
    assert not sees(sensor, p) and sees(sensor, p + 1e-9 * np.eye(len(p))[0])


def test_a_place_is_seen_at_the_sensor_itself():
    assert sees(sensors.PointXY(), [0.0, 0.0]) and sees(sensors.PointXYZ(), [0.0, 0.0, 0.0])


def test_the_edges_of_a_view_in_space():
    """Both angles, to both sides; a bearing one turn further is the same one."""
    sensor = sensors.RangeBearingElevation(fov=1.0, fov_up=0.6)
    for j, half in ((1, 0.5), (2, 0.3)):
        for sign in (1, -1):
            for turns in (0, 1) if j == 1 else (0,):
                y = np.array([2.0, 0.0, 0.0])
                y[j] = sign * (half - 1e-9 * turns) + TURN * turns
                assert sees(sensor, np.ones(3), y)
                y[j] = sign * (half + 1e-9) + TURN * turns
                assert not sees(sensor, np.ones(3), y)


CAMERAS = [
    sensors.PinHole(margin=10.0),
    sensors.PinHoleDepth(margin=10.0),
    sensors.DavisonCam(image_size=(640.0, 480.0), margin=10.0),
    sensors.OmniCam((320.0, 240.0, 1.0, 0.0, 0.0), (300.0, -190.0), image_size=(640.0, 480.0), margin=10.0),
    sensors.StereoPinHole(margin=10.0),
]


@pytest.mark.parametrize("sensor", CAMERAS, ids=lambda sensor: type(sensor).__name__)
def test_the_borders_of_an_image_belong_to_it(sensor):
    """Less its margin: on all four sides, and at the next number outside."""
    p, rest = np.array([0.0, 0.0, 3.0]), [2.0] * (len(sensor.units) - 2)  # a depth, or a disparity
    for j, (low, high) in enumerate(((10.0, 630.0), (10.0, 470.0))):
        low += 2.0 * (j == 0 and isinstance(sensor, sensors.StereoPinHole))  # it is in the right image, too
        for edge, out in ((low, DOWN), (high, UP)):
            y = np.array([300.0, 200.0, *rest])
            y[j] = edge
            assert sees(sensor, p, y)
            y[j] = np.nextafter(edge, out)
            assert not sees(sensor, p, y)


@pytest.mark.parametrize("sensor", CAMERAS[:3] + CAMERAS[4:], ids=lambda sensor: type(sensor).__name__)
def test_what_is_in_the_plane_of_the_camera_is_not_seen(sensor):
    y = [320.0, 240.0, 2.0][: len(sensor.units)]
    assert sees(sensor, [0.0, 0.0, 1e-9], y)
    assert not sees(sensor, [0.0, 0.0, 0.0], y) and not sees(sensor, [0.0, 0.0, -1e-9], y)


def test_the_least_disparity_is_seen():
    sensor = sensors.StereoPinHole(min_disparity=2.0)
    assert sees(sensor, [0, 0, 3.0], [320.0, 240.0, 2.0])
    assert not sees(sensor, [0, 0, 3.0], [320.0, 240.0, np.nextafter(2.0, DOWN)])


def test_the_rim_of_an_omnidirectional_view_is_not_seen():
    """A half space: what stands exactly across the axis does not belong to it."""
    sensor = CAMERAS[3]
    y = [320.0, 300.0]
    assert not sees(sensor, [0.0, 1.0, 0.0], y) and sees(sensor, [0.0, 1.0, 1e-9], y)
    narrow = sensors.OmniCam((320.0, 240.0, 1.0, 0.0, 0.0), (300.0, -190.0), fov=np.pi / 2)
    assert sees(narrow, [0.0, 1.0, 1 + 1e-9], y) and not sees(narrow, [0.0, 1.0, 1 - 1e-9], y)


def test_the_axis_of_an_omnidirectional_camera_is_the_centre_of_its_image():
    """There a direction has no side, and the pixel is the centre all the same; and beside it, from all sides."""
    sensor = sensors.OmniCam((320.0, 240.0, 1.1, 0.1, -0.1), (300.0, -300.0 / (np.pi / 2)))
    assert sensor.project(np.array([0.0, 0.0, 3.0]))[0].tolist() == [320.0, 240.0]
    for side in ([1e-9, 0.0, 3.0], [0.0, -1e-9, 3.0]):
        assert np.allclose(sensor.project(np.array(side))[0], [320.0, 240.0], atol=1e-6)
    stack = sensor.project(np.array([[0.0, 0.0, 3.0], [1.0, 0.0, 0.0]]))[0]
    assert np.allclose(stack, [[320.0, 240.0], [620.0, 270.0]], atol=1e-9)


def test_the_fold_of_a_lens():
    """r (1 + d r^2) grows up to r^2 = -1 / (3 d); with two coefficients the first of two such places counts."""
    assert sensors.PinHole().fold == INF == sensors.PinHole(d=(0.3,)).fold == sensors.PinHole(d=(0.0,)).fold
    assert sensors.PinHole(d=(-0.3,)).fold == pytest.approx(np.sqrt(1 / 0.9), rel=1e-12)
    two = sensors.PinHole(d=(-0.3, 0.02))
    slope = lambda r: 1 - 0.9 * r**2 + 0.1 * r**4
    assert slope(two.fold) == pytest.approx(0, abs=1e-12) and two.fold < 1.2
    assert (slope(np.linspace(0, two.fold - 1e-6, 100)) > 0).all()
    y = [320.0, 240.0]
    assert sees(two, [0.6 * two.fold * 0.9999, 0.8 * two.fold * 0.9999, 1.0], y)
    assert not sees(two, [0.6 * two.fold * 1.0001, 0.8 * two.fold * 1.0001, 1.0], y)
    assert not sees(sensors.PinHole(d=(-1 / 3,)), [1.0, 0.0, 1.0], y)  # on the fold itself


# --- what is refused --------------------------------------------------------------------------------------------------

TINY = 1e-300


@pytest.mark.parametrize(
    ("make", "good", "bad"),
    [
        (motion.Ackermann, [TINY, 1e300], [0.0, -1.0, INF, np.nan]),
        (motion.DifferentialDrive, [TINY, 1e300], [0.0, -1.0, INF, np.nan]),
        (motion.Vehicle, [TINY, 1e300], [0.0, -1.0, INF, np.nan]),
        (lambda v: motion.Vehicle(ahead=v), [0.0, -1.0], [INF, np.nan]),
        (lambda v: motion.Vehicle(left=v), [0.0, -1.0], [INF, np.nan]),
        (lambda v: motion.Vehicle(track=v), [0.0, -1.0], [INF, np.nan]),
        *((lambda v, name=name: motion.Imu(**{name: v}), [0.0, 1e300], [-TINY, INF, np.nan])
          for name in ("gyro_noise", "acc_noise", "gyro_walk", "acc_walk")),
        (lambda v: motion.Imu(gravity=v), [(0, 0, 0), [1, 2, 3]], [(0, 0), 9.81, (0, 0, np.nan), (0, 0, INF)]),
        (lambda v: sensors.Range(bias=v), [0.0, -1.0], [INF, -INF, np.nan]),
        (lambda v: sensors.Range(range_std=v), [TINY], [0.0, INF, np.nan, "a"]),
        (lambda v: sensors.Range(dim=v), [2, 3], [1, 4]),
        (lambda v: sensors.PointXY(std=v), [TINY], [0.0, INF, np.nan, None]),
        (lambda v: sensors.PinHole(pixel_std=v), [TINY], [0.0, INF, np.nan]),
        (lambda v: sensors.PinHoleDepth(depth_std=v), [TINY], [0.0, INF, np.nan]),
        (lambda v: sensors.PinHole(image_size=v), [(TINY, 1), [3, 4]], [(0, 1), (1, 0), (1, -1), (1,), (1, INF)]),
        (lambda v: sensors.PinHole(margin=v), [-1e9, 0.0, np.nextafter(240, 0)], [-np.inf, 240.0, np.nan]),
        (sensors.PinHole, [(0, 0, -1, 1), (0, 0, 1, TINY)], [(0, 0, 0, 1), (0, 0, 1, 0), (0, 0, 1), (0, 0, 1, INF)]),
        (lambda v: sensors.PinHole(d=v), [(), (0.1,), [0.1, 2]], [((0.1,),), (np.nan,), 0.1]),
        (lambda v: sensors.PinHole(c=v), [None, (), (0.1,)], [((0.1,),), (np.nan,), 0.1]),
        (lambda v: sensors.StereoPinHole(baseline=v), [TINY], [0.0, INF, np.nan]),
        (lambda v: sensors.StereoPinHole(min_disparity=v), [TINY], [0.0, INF, np.nan]),
        (lambda v: sensors.StereoPinHole(v), [(0, 0, TINY, 1)], [(0, 0, 0, 1), (0, 0, 1, 0), (0, 0, 1, -1)]),
        (lambda v: sensors.DavisonCam(k1=v), [0.0, -1e-6], [INF, np.nan]),
        (lambda v: sensors.DavisonCam(v), [(0, 0, -1, 1)], [(0, 0, 0, 1), (0, 0, 1, 0)]),
        (lambda v: sensors.OmniCam(v, (1.0,)), [(0, 0, 1, 0, 0), (0, 0, 1, 1, 2)], [(0, 0, 1, 1, 1), (0, 0, 1)]),
        (lambda v: sensors.OmniCam((0, 0, 1, 0, 0), v), [(1.0,)], [(), (np.nan,), 1.0]),
        (lambda v: sensors.OmniCam((0, 0, 1, 0, 0), (1.0,), c=v), [None, (1.0,)], [(np.nan,), 1.0]),
        (lambda v: sensors.OmniCam((0, 0, 1, 0, 0), (1.0,), fov=v), [TINY, TURN], [0.0, 6.3, INF, np.nan]),
        # what is inherited is asked for as well
        (lambda v: sensors.PinHoleDepth(pixel_std=v), [TINY], [0.0, INF]),
        (lambda v: sensors.PinHoleDepth(margin=v), [0.0], [240.0]),
        (lambda v: sensors.PinHoleDepth(v), [(0, 0, -1, 1)], [(0, 0, 0, 1)]),
        (lambda v: sensors.StereoPinHole(pixel_std=v), [TINY], [0.0, INF]),
        (lambda v: sensors.DavisonCam(pixel_std=v), [TINY], [0.0, INF]),
        (lambda v: sensors.OmniCam((0, 0, 1, 0, 0), (1.0,), pixel_std=v), [TINY], [0.0, INF]),
        (lambda v: sensors.Doppler(v, 0.1), [TINY], [0.0, INF]),
        (lambda v: sensors.Doppler(0.1, v), [TINY, np.pi], [0.0, 3.2]),
        (lambda v: sensors.Doppler(0.1, 0.1, rate_std=v), [TINY], [0.0, INF, np.nan]),
        (lambda v: sensors.SegmentCam(v), [(0, 0, -1, 1)], [(0, 0, 0, 1)]),
        (lambda v: sensors.SegmentCam(pixel_std=v), [TINY], [0.0, INF]),
        (lambda v: sensors.SegmentCam(min_length=v), [TINY], [0.0, INF]),
        (lambda v: sensors.RangeRate(v), [TINY], [0.0, INF, np.nan]),
        (lambda v: sensors.RangeRate(max_range=v), [TINY, INF], [0.0, np.nan]),
        (lambda v: sensors.RangeRate(dim=v), [2, 3], [1, 4]),
        (lambda v: sensors.Gps(v), [TINY], [0.0, INF, np.nan]),
        (lambda v: sensors.Gps(dim=v), [2, 3], [1, 4]),
        (lambda v: sensors.Compass(v), [TINY, np.pi], [0.0, 3.2, INF, np.nan]),
        (lambda v: sensors.Compass(declination=v), [0.0, -1.0, TURN], [6.3]),
        (lambda v: sensors.Compass(dim=v), [2, 3], [1, 4]),
        (lambda v: sensors.WheelSpeed(v), [TINY], [0.0, INF, np.nan]),
        (lambda v: sensors.WheelSpeed(scale=v), [TINY], [0.0, -1.0, INF, np.nan]),
        (lambda v: sensors.GroundFlow(v), [TINY], [0.0, INF, np.nan]),
        (lambda v: sensors.GroundFlow(height=v), [TINY], [0.0, -1.0, INF, np.nan]),
        (lambda v: landmarks.Beacon(v), [2, 3], [1, 4]),
        (lambda v: landmarks.Beacon(bias_std=v), [0.0, 1e300], [-TINY, INF, np.nan]),
        (lambda v: landmarks.Beacon(scale_std=v), [0.0, 1e300], [-TINY, INF, np.nan]),
    ],
)  # fmt: skip
def test_the_last_parameter_that_makes_a_model_and_the_first_that_makes_none(make, good, bad):
    for value in good:
        make(value)
    for value in bad:
        with pytest.raises(ValueError, match="must|needs|singular|at most"):
            make(value)


@pytest.mark.parametrize(
    ("kind", "first"),
    [
        (sensors.PinHole, ((320.0, 240.0, 320.0, 320.0), ())),
        (sensors.PinHoleDepth, ((320.0, 240.0, 320.0, 320.0), ())),
        (sensors.SegmentCam, ((320.0, 240.0, 320.0, 320.0), ())),
        (sensors.OmniCam, ((320.0, 240.0, 1.0, 0.0, 0.0), (300.0, -190.0))),
    ],
)
def test_only_k_and_d_of_a_camera_go_without_their_names(kind, first):
    """What comes third would be taken for the correction, the image or the noise: nobody could tell."""
    kind(*first)
    with pytest.raises(TypeError, match="positional argument"):
        kind(*first, None)
    named = {f.name for f in fields(kind) if f.kw_only}
    assert named == {f.name for f in fields(kind)} - {"k", "d"}


# --- landmarks --------------------------------------------------------------------------------------------------------


def test_an_inverse_distance_of_zero_is_ahead():
    """Only what a correction has turned negative is mended."""
    for rho, mended in ((0.5, 0.5), (0.0, 0.0), (-1e-300, 0.001), (-2.0, 0.001)):
        assert ahead(np.array([1.0, 2.0, rho]), 0.001).tolist() == [1.0, 2.0, mended]
    for kind in (IdpPnt(), AhmPnt(), AhmPnt(2)):
        l = np.arange(1.0, kind.size + 1)
        assert kind.ahead(l, 0.1).tolist() == l.tolist()
        assert kind.ahead(np.append(l[:-1], -1.0), 0.1).tolist() == [*l[:-1], 0.1]


@pytest.mark.parametrize(("kind", "of"), [(landmarks.IdpLin(), (5, 8)), (landmarks.AhmLin(), (6, 10))])
def test_a_line_with_an_inverse_distance_of_zero_is_ahead(kind, of):
    """If one of its two is negative, both are mended, and nothing else."""
    l = np.arange(1.0, kind.size + 1)
    for values in ((0.5, 0.2), (0.0, 0.0), (0.0, 1.0), (-1e-300, 0.3), (0.3, -2.0), (-1.0, -1.0)):
        l[list(of)] = values
        wanted = l.copy()
        wanted[list(of)] = (0.001, 0.001) if min(values) < 0 else values
        before = l.copy()
        assert np.array_equal(kind.ahead(l, 0.001), wanted) and np.array_equal(l, before)


@pytest.mark.parametrize(
    ("sensor", "lmk", "said"),
    [
        (
            sensors.RangeBearing(0.1, 0.1),
            landmarks.EucPnt(3),
            "RangeBearing measures in 2 dimensions, and EucPnt is a landmark in 3",
        ),
        (sensors.PinHole(), AhmPnt(2), "PinHole measures in 3 dimensions, and AhmPnt is a landmark in 2"),
        (sensors.Range(dim=3), landmarks.Beacon(2), "Range measures in 3 dimensions, and Beacon is a landmark in 2"),
    ],
)
def test_a_sensor_and_a_landmark_of_different_worlds(sensor, lmk, said):
    for needed in (None, "point", "from_point"):
        with pytest.raises(TypeError, match=f"^{said}$"):
            check_fit(sensor, lmk, needed)
    check_fit(sensor, type(lmk)(sensor.dim))

    class Anywhere:
        point = ray = None  # it does not say in which world

    check_fit(sensor, Anywhere())


def test_the_linearity_is_the_published_one(rng):
    """L = 4 sigma_d / d |cos a|: the angle between the two rays by its cosine, in degrees that can be drawn."""
    t, rho, sigma = np.array([0.0, 0.0, 0.0]), 0.25, 0.01
    m = np.array([0.0, 0.0, 2.0])  # of any length: the point is m / rho, 8 m ahead
    camera = np.array([6.0, 0.0, 0.0])  # sees it in 10 m, 36.87 degrees to the side: cos a = 0.8
    assert linearity(t, m, rho, sigma**2, camera) == pytest.approx(4 * (sigma / rho**2) / 10.0 * 0.8, rel=1e-12)
    behind = np.array([0.0, 0.0, 18.0])  # looks back at it: the angle counts without its sign
    assert linearity(t, m, rho, sigma**2, behind) == pytest.approx(4 * (sigma / rho**2) / 10.0, rel=1e-12)
    p = rng.normal(size=3) + 3.0
    l, P = IdpPnt().from_point(p)[0], np.diag([0, 0, 0, 0, 0, 0.04**2])
    far = l[5] ** 2 * np.linalg.norm(p)
    assert IdpPnt().linearity(l, P, np.zeros(3)) == pytest.approx(4 * 0.04 / far, rel=1e-12)
    l = AhmPnt().from_point(p)[0]
    assert AhmPnt().linearity(l, np.diag([0] * 6 + [0.04**2]), np.zeros(3)) == pytest.approx(4 * 0.04 / far, rel=1e-12)


def test_a_direction_along_the_pole_is_moved_off_it_and_no_other():
    """By 1e-8 rad, to the side of x; its yaw is finite and its derivative, too."""
    for z in (2.0, -2.0):
        py, PY_v = vec2py(np.array([0.0, 0.0, z]))
        assert py[0] == pytest.approx(np.sign(z) * (np.pi / 2 - POLE), abs=1e-12) and py[1] == 0.0
        assert np.isfinite(PY_v).all() and POLE == 1e-8
    near = 1.01 * POLE * 2.0
    assert vec2py(np.array([0.0, near, 2.0]))[0][1] == pytest.approx(np.pi / 2, abs=1e-15)
    assert vec2py(np.array([0.0, 0.99 * POLE * 2.0, 2.0]))[0][1] < 0.8
    assert np.allclose(
        py2vec(np.array([0.3, -2.0]))[0], [np.cos(0.3) * np.cos(2), -np.cos(0.3) * np.sin(2), np.sin(0.3)]
    )


# --- lenses -----------------------------------------------------------------------------------------------------------


def test_a_lens_is_inverted_up_to_its_fold_and_not_beyond():
    """With d = -1/3 the largest radius is 2/3, of r = 1; there the derivative has no inverse."""
    d = np.array([-1 / 3])
    for r in (0.0, 0.3, 0.99):
        up, UP = exact_undistort(np.array([r * (1 - r**2 / 3), 0.0]), d)
        assert up[0] == pytest.approx(r, abs=1e-9) and up[1] == 0.0
        assert np.diagonal(UP) == pytest.approx([1 / (1 - r**2), 1 / (1 - r**2 / 3)], rel=1e-6)
    assert np.isnan(exact_undistort(np.array([0.7, 0.0]), d)[0]).all()
    u = np.array([0.3, 0.4])
    assert exact_undistort(u, np.zeros(0))[0] is u


def test_a_correction_vector_reaches_a_little_further_than_the_image():
    """The least-squares fit over 101 radii from 0 to 1.1 times the corner, by the normal equations."""
    d, k = np.array([-0.3, 0.1]), (320.0, 240.0, 320.0, 300.0)
    r = np.linspace(0, 1.1 * np.hypot(1.0, 0.8), 101)
    rd = r - 0.3 * r**3 + 0.1 * r**5
    A = np.stack([rd**3, rd**5, rd**7], -1)
    assert np.allclose(inv_distortion(d, 3, k), np.linalg.lstsq(A, r - rd, rcond=None)[0], rtol=1e-6)
    assert inv_distortion([], 3, k).size == 0


def test_no_ray_comes_from_beyond_the_axis():
    """A forward polynomial that rises again on the other side of the axis: 1 pixel is 0.0118 rad on this side."""
    rise = np.polynomial.Polynomial([0.0, 83.0, 140.0, -359.0, 205.0])
    sensor = sensors.OmniCam((0, 0, 1, 0, 0), tuple(rise(np.polynomial.Polynomial([np.pi / 2, -1.0])).coef))
    off = 0.011826  # from the axis, rad
    assert rise(off) == pytest.approx(1.0, abs=1e-3) and rise(-0.315) == pytest.approx(1.0, abs=2e-2)
    v = sensor.retro(np.array([1.0, 0.0]))[0]
    assert np.arctan2(v[0], v[2]) == pytest.approx(off, abs=1e-4)
    assert np.allclose(sensor.project(v)[0], [1.0, 0.0], atol=1e-9)


def test_no_ray_comes_from_far_outside_of_the_view():
    """A view of 90 degrees whose polynomial is flat on the way: a step that overshoots ends at twice the view."""
    rise = np.polynomial.Polynomial([0.0, 28.0, -124.0, 238.0, -87.0])
    d = tuple(rise(np.polynomial.Polynomial([np.pi / 2, -1.0])).coef)
    sensor = sensors.OmniCam((0, 0, 1, 0, 0), d, fov=np.pi / 2)
    for off in (0.7774, 0.77, 0.76, 0.6, 0.3, 0.1):
        v = sensor.retro(np.array([0.0, rise(off)]))[0]
        assert np.arctan2(v[1], v[2]) == pytest.approx(off, abs=1e-9) and v[0] == 0.0


def test_where_davisons_lens_ends():
    """At 1 + 2 k1 |u|^2 = 0 itself there is no number, just before it there is."""
    assert np.isnan(bend(np.array([1.0, 0.0]), -0.5)[0]).all() and np.isnan(bend(np.array([1.0, 0.0]), -0.5)[1]).all()
    assert bend(np.array([1 - 1e-6, 0.0]), -0.5)[0][0] == pytest.approx(1 / np.sqrt(2e-6), rel=1e-5)
