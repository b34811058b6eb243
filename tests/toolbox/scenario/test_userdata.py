"""User data: what is written is what is meant, in Python and in TOML; and every mistake gets one clear sentence."""

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest

from ekfslam_tutorial.geometry import Frame2, check_jacobians, q2e
from ekfslam_tutorial.models.landmarks import EucPnt, IdpPnt
from ekfslam_tutorial.models.motion import ConstantVelocity, Odometry3, Unicycle
from ekfslam_tutorial.models.sensors import BearingOnly2, PinHole, RangeBearing
from ekfslam_tutorial.slam import Jcbb, KnownIds
from ekfslam_tutorial.slam import Options as SlamOptions
from ekfslam_tutorial.toolbox import (
    Landmark,
    Options,
    Robot,
    Sensor,
    Time,
    UserData,
    World,
    parse_override,
    universal_slam,
)
from ekfslam_tutorial.toolbox.scenario.poses import pose
from tests.models.examples import Beacon
from tests.toolbox.scenarios import FLAT, SPACE

SCENARIOS = Path(__file__).parents[3] / "data" / "scenarios"

NAN, INF = math.nan, math.inf


# --- what is written is what is meant --------------------------------------------------------------------------------


def test_degrees_are_degrees_only_above():
    data = UserData.from_dict(FLAT)
    (robot,), (sensor,) = data.robots, data.sensors
    assert np.allclose(robot.controls(), [[1.0, math.radians(14.4)]])
    assert np.allclose(robot.U(), np.diag([0.05**2, math.radians(1.0) ** 2]))
    assert sensor.model.bearing_std == pytest.approx(math.radians(1.0)) and sensor.model.range_std == 0.1


def test_angles_may_be_given_in_radians():
    degrees = UserData.from_dict(FLAT, {"sensor.fov_deg": 120.0, "robot.orientation_deg": 30.0})
    radians = UserData.from_dict(FLAT, {"sensor.fov": 2 * math.pi / 3, "robot.orientation": math.pi / 6})
    assert degrees.sensors[0].model.fov == pytest.approx(radians.sensors[0].model.fov, rel=1e-15)
    assert np.allclose(degrees.robots[0].start()[0], radians.robots[0].start()[0], rtol=1e-15)


def test_python_and_toml_say_the_same():
    by_hand = UserData(
        name="flat",
        seed=3,
        world=World.of([[3.0, 4.0]]),
        robots=[
            Robot(
                motion=Unicycle(),
                position=[0.0, -4.0],
                control={"v": 1.0, "w_deg": 14.4},
                control_std={"v": 0.05, "w_deg": 1.0},
            )
        ],
        sensors=[Sensor(model=RangeBearing(0.1, math.radians(1.0), max_range=6.0))],
    )
    read = UserData.from_dict(FLAT | {"world": {"type": "points", "points": [[3.0, 4.0]]}, "time": {}})
    assert by_hand.sensors[0].model == read.sensors[0].model and by_hand.landmark == read.landmark
    for a, b in zip(universal_slam(by_hand), universal_slam(read), strict=True):
        assert np.array_equal(a.map.x, b.map.x) and np.array_equal(a.map.P, b.map.P)


def test_landmarks_of_both_dimensions_are_as_the_robots_are():
    assert UserData.from_dict(FLAT).landmark.model == EucPnt(2)
    assert UserData.from_dict(FLAT | {"landmark": {}}).landmark.model == EucPnt(2)
    assert UserData.from_dict(SPACE).landmark.model == IdpPnt()


def test_prior_noise_and_options_reach_the_estimator():
    data = UserData.from_dict(
        SPACE, {"landmark.non_obs_mean": 0.2, "landmark.non_obs_std": 0.3, "options.association": "jcbb"}
    )
    opt = data.slam_options()
    assert opt.lmk_type == IdpPnt() and opt.n == [0.2] and opt.N == pytest.approx(0.09)
    assert opt.association == Jcbb() and opt.n_inits == (10, 1)
    with_parameters = {"options.association": {"type": "jcbb", "confidence": 0.9}}
    assert UserData.from_dict(SPACE, with_parameters).options.association == Jcbb(confidence=0.9)
    assert UserData.from_dict(FLAT).options == Options(association=KnownIds())


def test_a_start_in_space_has_the_angles_and_the_covariance_asked_for():
    robot = Robot(
        motion=ConstantVelocity(),
        position=[1, 2, 3],
        orientation_deg=[10, 20, 30],
        position_std=[0.1, 0.2, 0.3],
        orientation_std_deg=2.0,
        state={"vel": [1, 0, 0], "ang_vel_deg": [0, 0, 90]},
        state_std={"ang_vel_deg": 1.0},
    )
    x, P = robot.start()
    assert np.allclose(np.degrees(q2e(x[3:7])[0]), [10, 20, 30]) and x[7:] == pytest.approx(
        [1, 0, 0, 0, 0, math.pi / 2]
    )
    E_q = q2e(x[3:7])[1]
    assert np.allclose(P[:3, :3], np.diag([0.01, 0.04, 0.09]))
    assert np.allclose(E_q @ P[3:7, 3:7] @ E_q.T, math.radians(2) ** 2 * np.eye(3))
    assert np.allclose(np.diag(P)[7:], [0, 0, 0, *[math.radians(1) ** 2] * 3])


def test_draws_around_a_start_have_its_spread():
    robot = Robot(motion=Odometry3(), orientation_deg=[0, 0, 40], position_std=0.5, orientation_std_deg=[1, 2, 3])
    rng = np.random.default_rng(0)
    x = np.array([robot.start(rng.standard_normal(robot.dof))[0] for _ in range(4000)])
    e = np.degrees(q2e(x[:, 3:7])[0]) - [0, 0, 40]
    # standard deviations of 4000 draws, bands of 4 standard errors (1.1 % each)
    assert np.allclose(x[:, :3].std(0), 0.5, rtol=0.045) and np.allclose(e.std(0), [1, 2, 3], rtol=0.045)
    assert np.allclose(np.linalg.norm(x[:, 3:7], axis=1), 1)


def test_jacobian_of_the_start_pose():
    frame = Odometry3().frame
    for seed in range(5):
        check_jacobians(lambda e: pose(frame, e), np.random.default_rng(seed).normal(size=6))


def test_controls_may_be_a_row_for_each_frame():
    robot = Robot(motion=Odometry3(), control={"dx": [[1, 0, 0], [2, 0, 0]], "da_deg": [0, 0, 90]})
    assert np.allclose(robot.controls(), [[1, 0, 0, 0, 0, math.pi / 2], [2, 0, 0, 0, 0, math.pi / 2]])
    assert Robot(motion=Unicycle(), control={"v": [1, 2, 3]}).controls()[:, 0].tolist() == [1, 2, 3]
    with pytest.raises(ValueError, match=r"one row, or as many as each other, got \[2, 3\]"):
        Robot(motion=Unicycle(), control={"v": [1, 2, 3], "w_deg": [1, 2]})


def test_full_control_covariance():
    cov = [[0.04, 0.01], [0.01, 0.09]]
    assert Robot(motion=Unicycle(), control_cov=cov).U().tolist() == cov


def test_other_robots_of_the_same_kind():
    data = UserData.from_dict(FLAT).for_robots([4, 7])
    assert [(r.id, r.name) for r in data.robots] == [(4, "robot 4"), (7, "robot 7")]
    assert [(s.id, s.robot) for s in data.sensors] == [(4, 4), (7, 7)]
    two = UserData.from_dict(FLAT | {"sensor": [FLAT["sensor"][0] | {"id": i} for i in (1, 2)]})
    assert [s.id for s in two.for_robots([3]).sensors] == [31, 32]


def test_entries_without_id_are_numbered():
    data = UserData.from_dict(FLAT | {"robot": FLAT["robot"] * 2, "sensor": FLAT["sensor"] * 2})
    assert [r.id for r in data.robots] == [1, 2] and [s.id for s in data.sensors] == [1, 2]


@dataclass(frozen=True)
class HalfBlind:
    """A sensor of the reader's own."""

    std: float
    tilt: float = 0.1
    angles: ClassVar = ("tilt",)
    dim: ClassVar[int] = 2
    bearing_only: ClassVar[bool] = False

    R: ClassVar = np.eye(1)

    def project(self, p): ...

    def retro(self, y, n): ...

    def residual(self, y, e): ...

    def visible(self, y, p): ...


def test_own_classes_can_be_named_in_a_file():
    own = {"type": "half_blind", "std": 0.5, "tilt_deg": 90.0}
    data = UserData.from_dict(FLAT | {"sensor": [own]}, models=[HalfBlind])
    assert data.sensors[0].model == HalfBlind(0.5, math.pi / 2)
    with pytest.raises(ValueError, match="unknown sensor type 'half_blind'"):
        UserData.from_dict(FLAT | {"sensor": [own]})


class NoMove:
    frame, size, control_fields, state_fields = Frame2, 3, {"v": 1}, {}


class NoFields:
    frame, size = Frame2, 3

    def move(self, x, u, dt): ...


class NoFrame:
    control_fields = state_fields = {}

    def move(self, x, u, dt): ...


class Deaf:
    def project(self, p): ...


class Flat:
    size = 2

    def from_frame(self, F, l): ...


@pytest.mark.parametrize(
    "section, entry, said",
    [
        ("robot", {"motion": "no_move"}, "robot 1: NoMove has no method move, so it is no motion model; known: acker"),
        ("robot", {"motion": "no_fields"}, "robot 1: NoFields has no control_fields, no state_fields; a motion has"),
        ("robot", {"motion": "no_frame"}, "robot 1: NoFrame has no frame, no size; a motion has frame, size, control"),
        ("robot", {"motion": "flat"}, "robot 1: Flat has no method move, so it is no motion model"),
        ("robot", {"motion": "no_mov"}, "unknown motion model 'no_mov'; known: "),
        ("sensor", {"type": "no_move"}, "sensor 1: NoMove has no method project, so it is no sensor type"),
        ("sensor", {"type": "deaf"}, "Deaf has no R, no bearing_only, no method residual, no method visible; a sensor"),
        ("landmark", {"type": "flat"}, "Flat has no method to_frame, no method point, no method ray; a landmark has"),
        ("landmark", {"type": "deaf"}, "Deaf has no method from_frame, so it is no landmark type; known: "),
    ],
)
def test_what_a_class_of_ones_own_lacks_is_named(section, entry, said):
    table = FLAT | {section: entry if section == "landmark" else [entry]}
    with pytest.raises((ValueError, TypeError), match=said):
        UserData.from_dict(table, models=[NoMove, NoFields, NoFrame, Deaf, Flat])


def test_given_tables_are_left_as_they_were():
    table = FLAT | {"robot": [dict(FLAT["robot"][0])]}
    UserData.from_dict(table, {"robot.v": 9.0, "time.last": 3})
    assert table["robot"][0] == FLAT["robot"][0] and table["time"] == FLAT["time"]


# --- changes from the command line -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("data.set=7", ("data.set", 7)),
        ("data.robots = [1, 2]", ("data.robots", [1, 2])),
        ("robot.1.in_map=false", ("robot.1.in_map", False)),
        ("landmark.type=ahm_pnt", ("landmark.type", "ahm_pnt")),
        ('landmark.type="ahm_pnt"', ("landmark.type", "ahm_pnt")),
        ("scan.from=/cones", ("scan.from", "/cones")),
        ("data.path=../logs/set-7", ("data.path", "../logs/set-7")),
        ("a.b=x=1", None),
        ("a.b", None),
        ("=3", None),
        ("a..b=3", None),
        ("a=[1,", None),
        ("a=1\nb=2", None),
    ],
)
def test_overrides_are_parsed_like_toml(text, expected):
    if expected:
        assert parse_override(text) == expected
    else:
        with pytest.raises(ValueError, match="--set"):
            parse_override(text)


def test_overrides_reach_one_entry_or_all():
    two = FLAT | {"robot": [FLAT["robot"][0] | {"id": i} for i in (5, 9)]}
    one = UserData.from_dict(two, {"robot.9.v": 3.0, "sensor.robot": 5})
    assert [r.controls()[0, 0] for r in one.robots] == [1.0, 3.0]
    assert [r.controls()[0, 0] for r in UserData.from_dict(two, {"robot.v": 3.0, "sensor.robot": 5}).robots] == [3, 3]


# --- mistakes --------------------------------------------------------------------------------------------------------

MISTAKES = [
    (FLAT, "robot.motion", "unicicle", "robot 1: unknown motion model 'unicicle'; known: .*did you mean 'unicycle'"),
    (FLAT, "robot.motion", 3, "robot 1: the motion model is given by its name, got 3; known: ackermann"),
    (FLAT, "sensor.type", "range_bering", "sensor 1: unknown sensor type .*; did you mean 'range_bearing'"),
    (FLAT, "landmark.type", "euc_pt", r"\[landmark\]: unknown landmark type 'euc_pt'; .*did you mean 'euc_pnt'"),
    (FLAT, "world.type", "rng", r"\[world\]: unknown world 'rng'; known: cloister, .*did you mean 'ring'"),
    (FLAT, "options.association", "known", "unknown association 'known'; known: jcbb, known_ids, nearest_neighbour"),
    (FLAT, "sensor.max_rnge", 3, "sensor 1: unknown key 'max_rnge'; possible: .*; did you mean 'max_range'"),
    (FLAT, "robot.positon", [0, 0], "robot 1: unknown key 'positon'; .*did you mean 'position'"),
    (FLAT, "wrld.n", 3, "unknown key 'wrld'; possible: .*; did you mean 'world'"),
    (FLAT, "options.md2_threshod", 3, "did you mean 'md2_threshold'"),
    (FLAT, "options.lmk_type", "idp_pnt", "unknown key 'lmk_type'"),
    (FLAT, "robot.da_deg", 3, "robot 1: unknown key 'da_deg'; .*did you mean 'w_deg'"),
    (FLAT, "sensor.fov", 270.0, "fov = 270.0 is in radians and beyond 2 pi; write fov_deg = 270.0 for degrees"),
    (FLAT, "robot.orientation", 90, "orientation = 90 is in radians and beyond 2 pi; write orientation_deg = 90"),
    (SPACE, "sensor.orientation", [-90, 0, -90], "in radians and beyond 2 pi; write orientation_deg"),
    (SPACE, "robot.da_std", 2.0, "robot 1: da_std = 2.0 is in radians and beyond 1; write da_std_deg = 2.0"),
    (SPACE, "robot.orientation_std", [0, 0, 2], "in radians and beyond 1; write orientation_std_deg"),
    (SPACE, "robot.da", [0, 0, 9.0], "robot 1: da = .* is in radians and beyond 2 pi; write da_deg"),
    (FLAT, "robot.w", 0.2, "robot 1: w is given twice, in degrees and in radians"),
    (FLAT, "sensor.bearing_std", 0.1, "sensor 1: bearing_std is given twice"),
    (FLAT, "sensor.robot", 2, "sensor 1 is on robot 2, which does not exist; robots: 1"),
    (FLAT, "robot.position", [0, 0, 0], r"robot 1: position must be 2 numbers, got \[0, 0, 0\]"),
    (SPACE, "sensor.orientation_deg", 90, "orientation_deg must be 3 numbers, got 90"),
    (SPACE, "robot.dx", [0.1, 0], "robot 1: dx must be 3 numbers, or rows of them, got"),
    (FLAT, "robot.v", NAN, "robot 1: v must be finite, got nan"),
    (FLAT, "robot.position", [0, INF], "position must be finite"),
    (FLAT, "robot.position", ["0", "1"], "position must be numbers"),
    (FLAT, "robot.v_std", -0.1, "v_std is a standard deviation and must not be negative, got -0.1"),
    (FLAT, "robot.orientation_std_deg", -1, "orientation_std_deg is a standard deviation and must not be negative"),
    (SPACE, "robot.da_std_deg", [1, 2], "da_std_deg must be one number or 3"),
    (FLAT, "sensor.range_std", -1, "sensor 1: RangeBearing: range_std must be a positive number, got -1"),
    (FLAT, "sensor.range_std", INF, "range_std must be finite, got inf"),
    (FLAT, "sensor.range_std", 2**2000, "range_std must be numbers"),
    (FLAT, "sensor.range_std", "big", "range_std must be a number, got 'big'"),
    (FLAT, "sensor.range_std", True, "range_std must be a number, got True"),
    (FLAT, "sensor.range_std", 1e200, "sensor 1: the noise covariance R of RangeBearing must be finite"),
    (FLAT, "robot.v_std", 1e200, "robot 1: the squared standard deviations of the control must be finite"),
    (SPACE, "sensor.image_size", [640], "image_size must be 2 finite numbers"),
    (SPACE, "sensor.image_size", [0, 480], "image_size must be two positive numbers"),
    (SPACE, "sensor.image_size", 640, "image_size must be a list of numbers, got 640"),
    (SPACE, "sensor.k", [320, 240, 0, 320], r"k = \[u0, v0, au, av\] is singular"),
    (SPACE, "sensor.k", [320, 240], "k must be 4 finite numbers"),
    (SPACE, "sensor.d", [NAN], "d must be finite"),
    (FLAT, "landmark.type", "idp_pnt", r"robot 1 \(Unicycle\) is 2D and landmark type IdpPnt is 3D"),
    (SPACE, "landmark.type", "euc_pnt", "sensor 1: EucPnt landmarks cannot be started by a PinHole"),
    (SPACE, "sensor.landmark", "euc_pnt", "sensor 1: EucPnt landmarks cannot be started by a PinHole"),
    (SPACE, "landmark.non_obs_std", -1, "non_obs_std is a standard deviation and must not be negative"),
    (FLAT, "time.last", 0, r"\[time\]: the last frame, 0, comes before the first, 1"),
    (FLAT, "time.dt", 0, "dt must be a positive number of seconds, got 0"),
    (FLAT, "time.dt", "a", "dt must be a number, got 'a'"),
    (FLAT, "seed", -1, "seed must be a whole number, 0 or more, got -1"),
    (FLAT, "seed", 1.5, "seed must be a whole number, got 1.5"),
    (FLAT, "name", 4, "name must be a text in quotes, got 4"),
    (FLAT, "options.n_inits", 3, "n_inits must be a list of numbers, got 3"),
    (FLAT, "options.n_inits", [1, 2, 3], "n_inits must be two whole numbers"),
    (FLAT, "options.n_inits", [1.5, 2], r"n_inits must be two whole numbers of 0 or more, or None, got \(1.5, 2\)"),
    (FLAT, "options.capacity", -3, r"\[options\]: capacity must be a whole number of 0 or more, or None, got -3"),
    (FLAT, "options.capacity", 2, r"options: capacity 2 is less than the 3 states of robots and sensors"),
    (SPACE, "options.capacity", 6, r"options: capacity 6 is less than the 7 states of robots and sensors"),
    (FLAT, "options.reopen_after", 0, "reopen_after must be a whole number of 1 or more, or None, got 0"),
    (FLAT, "options.reopen_std", [1], r"reopen_std must be two finite numbers of 0 or more, got \(1,\)"),
    (FLAT, "options.reopen_std", [0.1, -0.2], r"reopen_std must be two finite numbers of 0 or more, got \(0.1, -0.2\)"),
    (FLAT, "options.min_rho", -5.0, "min_rho must be a positive number, got -5"),
    (FLAT, "options.init_margin", -1000.0, "init_margin must be a number of 0 or more, got -1000"),
    (FLAT, "options.min_match_ratio", 3, "min_match_ratio must be between 0 and 1, got 3"),
    (FLAT, "options.md2_threshold", -4.0, "md2_threshold must be a positive number, got -4"),
    (FLAT, "options.association", {"type": "jcbb", "gate": 3}, "association: unknown key 'gate'; possible: confidence"),
    (FLAT, "world.n", "many", r"\[world\]: n must be a whole number, got 'many'"),
    (FLAT, "world.radius", NAN, "radius must be finite, got nan"),
    (FLAT, "world", {"type": "lecture", "n": 5}, r"\[world\]: unknown key 'n'; possible: none"),
    (
        FLAT,
        "world",
        {"type": "points", "points": [[1, 2], [3]]},
        r"\[world\]: points must be numbers, in rows of equal",
    ),
    (
        FLAT,
        "world",
        {"type": "points", "points": [[1, 2]], "ids": [[1], [1, 2]]},
        r"\[world\]: ids must be numbers, in",
    ),
    (FLAT, "world", 7, r"\[world\]: this must be one table, written \[world\], got 7"),
    (FLAT, "robot", 7, r"robot must be tables, each written \[\[robot\]\], got 7"),
    (FLAT, "robot", [], "there is no robot"),
    (FLAT, "robot.in_map", "yes", "in_map must be true or false, got 'yes'"),
    (FLAT, "robot.id", -4, "id must be a whole number, 0 or more, got -4"),
    (FLAT, "robot.7.v", 1, "--set robot.7.v: there is no entry with the id 7; ids: 1"),
    (FLAT, "robot.v.x", 1, "--set robot.v.x: this names a part of the scenario that takes no value as a whole"),
    (FLAT, "robot.1", 1, "--set robot.1: this names a part"),
    (FLAT, "robot.control_cov", [[1, 0], [0, 1]], "control_cov is given as well as standard deviations"),
    (FLAT, "sensor.p_detect", 1.5, "p_detect is a probability above 0, got 1.5"),
    (FLAT, "sensor.clutter", -1, "clutter is a mean number and must not be negative"),
    (FLAT, "figure.view", "bird", "unknown view 'bird'; known: perspective, top, side, self"),
    (FLAT, "figure.limits", [[1, 0], [0, 1]], "limits must be a lower and an upper limit for each axis"),
    (FLAT, "data.set", 9, r"\[data\]: missing: name"),
]


@pytest.mark.parametrize(("table", "key", "value", "message"), MISTAKES, ids=lambda v: v if isinstance(v, str) else "")
def test_each_mistake_gets_its_own_sentence(table, key, value, message):
    with pytest.raises((ValueError, TypeError), match=message) as caught:
        UserData.from_dict(table, {key: value})
    assert "\n" not in str(caught.value)


ROBOTS = [Robot()]
PYTHON = [
    (Time, dict(last=1.5), "the number of the last frame must be whole, got 1.5"),
    (Time, dict(first=0.5), "the number of the first frame must be whole, got 0.5"),
    (Options, dict(capacity=9.5), "capacity must be a whole number of 0 or more, or None, got 9.5"),
    (Robot, dict(motion=Unicycle), r"motion must be a model, got a class; write Unicycle\(...\)"),
    (Robot, dict(motion="unicycle"), "motion must be a model, with the method move, got 'unicycle'"),
    (Sensor, dict(model=RangeBearing), r"model must be a model, got a class; write RangeBearing\(...\)"),
    (Sensor, dict(model=RangeBearing(0.1, 0.1), landmark="euc_pnt"), "landmark must be a model, with the method"),
    (Landmark, dict(model=EucPnt), r"the landmark model must be a model, got a class; write EucPnt\(...\)"),
    (UserData, dict(robots=ROBOTS, options=SlamOptions()), "options must be a toolbox.Options, got"),
    (UserData, dict(robots=ROBOTS, world=[[1.0, 2.0]]), r"world must be a toolbox.World, got \[\[1.0, 2.0\]\]"),
    (UserData, dict(robots=ROBOTS, time=30), "time must be a toolbox.Time, got 30"),
    (UserData, dict(robots=ROBOTS, sensors=[RangeBearing(0.1, 0.1)]), "each of sensors must be a toolbox.Sensor"),
]


@pytest.mark.parametrize(("kind", "given", "message"), PYTHON, ids=[m[:40] for _, _, m in PYTHON])
def test_mistakes_in_python_are_told_as_early(kind, given, message):
    with pytest.raises((ValueError, TypeError), match=message) as caught:
        kind(**given)
    assert "\n" not in str(caught.value)


PLACES = [[1.0, 2.0], [2.0, 2.0]]


@pytest.mark.parametrize(
    ("points", "ids", "message"),
    [
        ([], None, "landmark points must have 2 axes, got shape \\(0,\\)"),
        (PLACES, [1], "landmarks need N whole ids and N points"),
        (PLACES, [1.5, 2], "landmarks need N whole ids and N points"),
        (PLACES, [1, 1], "landmark ids must differ from each other, but 1 stands twice"),
        (PLACES, [-1, 1], "landmark ids must be 0 or more, got -1"),
    ],
)
def test_landmarks_of_a_world_have_ids_of_their_own(points, ids, message):
    """The same for worlds of a file and of Python; else two landmarks would become one, or none."""
    world = {"type": "points", "points": points} | ({} if ids is None else {"ids": ids})
    with pytest.raises(ValueError, match=f"the world 'points': {message}"):
        universal_slam(UserData.from_dict(FLAT | {"world": world}))
    if points:
        with pytest.raises(ValueError, match=f"the world 'points': {message}"):
            universal_slam(replace(UserData.from_dict(FLAT), world=World.of(points, ids)))


def test_a_world_without_landmarks_is_none():
    with pytest.raises(ValueError, match="the world 'points': there is no landmark in it"):
        universal_slam(replace(UserData.from_dict(FLAT), world=World.of(np.zeros((0, 2)))))
    with pytest.raises(ValueError, match="the ids of the world must be numbers, in rows of equal length"):
        World.of(PLACES, [[1], [1, 2]])


def test_missing_keys_are_named():
    for kind, gone, message in (
        ("robot", "motion", "robot 1: motion is missing; known: ackermann"),
        ("sensor", "type", "sensor 1: type is missing; known: bearing_only2"),
        ("sensor", "range_std", "sensor 1: missing: range_std"),
        ("sensor", "bearing_std_deg", "sensor 1: missing: bearing_std_deg"),
    ):
        entry = {k: v for k, v in FLAT[kind][0].items() if k != gone}
        with pytest.raises(ValueError, match=message):
            UserData.from_dict(FLAT | {kind: [entry]})


def test_twice_the_same_id():
    entry = [FLAT["sensor"][0] | {"id": 6}] * 2
    with pytest.raises(ValueError, match="two sensors have the id 6; every sensor needs its own"):
        UserData.from_dict(FLAT | {"sensor": entry})


@pytest.mark.parametrize(
    ("cov", "message"),
    [
        ([[1.0, 0.5], [0.0, 1.0]], "control_cov must be symmetric"),
        ([[1.0, 2.0], [2.0, 1.0]], "control_cov must be positive semi-definite"),
        ([[1.0]], "control_cov must be 2 x 2 matrices"),
        ([[1.0, NAN], [NAN, 1.0]], "control_cov must be finite"),
    ],
)
def test_a_control_covariance_must_be_one(cov, message):
    with pytest.raises(ValueError, match=message):
        Robot(motion=Unicycle(), control_cov=cov)


def test_flat_and_spatial_parts_do_not_mix():
    with pytest.raises(ValueError, match=r"robot 1 \(Unicycle\) is 2D and sensor 1 \(PinHole\) is 3D"):
        UserData(robots=[Robot(motion=Unicycle())], sensors=[Sensor(model=PinHole())])
    with pytest.raises(ValueError, match="world 'cloister' is 3D and robot 1 is 2D"):
        universal_slam(UserData.from_dict(FLAT | {"world": {"type": "cloister"}}))


def test_a_camera_may_go_with_points_that_another_sensor_starts():
    eye = Sensor(id=2, model=BearingOnly2(0.02))
    UserData(robots=[Robot()], sensors=[Sensor(model=RangeBearing(0.1, 0.02)), eye])
    with pytest.raises(TypeError, match="sensor 2: EucPnt landmarks cannot be started by a BearingOnly2"):
        UserData(robots=[Robot()], sensors=[eye])
    UserData(robots=[Robot()], sensors=[eye], landmark=Landmark(in_map=False))  # nothing to start: localisation


def test_a_sensor_without_retro_corrects_what_another_one_starts():
    near, far = Sensor(id=1, model=RangeBearing(0.1, 0.02, max_range=3)), Sensor(id=2, model=Beacon())
    world = World.of([[2.0, 1.0], [9.0, 1.0]])
    *_, now = universal_slam(UserData(robots=[Robot()], sensors=[near, far], world=world, time=Time(last=5)))
    assert set(now.lmks) == {1} and now.obs[2, 1].updated
    with pytest.raises(TypeError, match="cannot be started by a Beacon, it has no method retro"):
        UserData(robots=[Robot()], sensors=[far])


# --- files -----------------------------------------------------------------------------------------------------------


def test_file_errors_begin_with_the_files_name(tmp_path):
    path = tmp_path / "mine.toml"
    for text, message in (
        ("[world]\ntype = ring\n", r"^mine\.toml: this is not TOML: .*line 2"),
        ("[[robot]]\nmotion = 'odometry2'\nspeed = 3\n", r"^mine\.toml: robot 1: unknown key 'speed'"),
        ("a = " + "[" * 5000, r"^mine\.toml: this is "),
        ("x = 1\nx = 2\n", r"^mine\.toml: this is not TOML: .*line 2"),
    ):
        path.write_text(text)
        with pytest.raises(ValueError, match=message):
            UserData.from_toml(path)
    path.write_bytes(b"name = '\xff\xfe'")
    with pytest.raises(ValueError, match=r"^mine\.toml: this is not a text in UTF-8"):
        UserData.from_toml(path)
    with pytest.raises(FileNotFoundError, match=r"no scenario file .*other\.toml"):
        UserData.from_toml(tmp_path / "other.toml")


def test_a_file_is_named_after_itself(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text("[[robot]]\nmotion = 'odometry2'\n")
    assert UserData.from_toml(path).name == "mine"
    path.write_text("name = 'yours'\n[[robot]]\nmotion = 'odometry2'\n")
    assert UserData.from_toml(path).name == "yours"


@pytest.mark.parametrize(
    ("scenario", "changes", "message"),
    [
        ("range_bearing_2d", {"figure.view": "side"}, "a 2D scenario has the views top, self, got 'side'"),
        ("range_bearing_2d", {"figure.orbit_deg": 2.0}, "orbit_deg needs a 3D view from outside"),
        ("cloister_idp", {"figure.view": "self", "figure.orbit_deg": 2.0}, "got the 3D view 'self'"),
    ],
)
def test_view_that_the_map_figure_does_not_have(scenario, changes, message):
    with pytest.raises(ValueError, match=message):
        UserData.from_toml(SCENARIOS / f"{scenario}.toml", changes)
