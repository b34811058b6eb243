"""`ekfslam convert` in space: twists, steps, poses, IMUs; ranges with two angles, points, pixels; bags of cameras."""

import re
from types import SimpleNamespace

import numpy as np
import pytest

from ekfslam_tutorial.analysis import History
from ekfslam_tutorial.cli import main
from ekfslam_tutorial.datasets.foreign import convert
from ekfslam_tutorial.datasets.foreign.converting import at_times
from ekfslam_tutorial.datasets.foreign.plumb_bob import without_tangential
from ekfslam_tutorial.geometry import Frame3, e2q, q2R, q2v, q_prod, v2q
from ekfslam_tutorial.models.motion import Odometry3
from ekfslam_tutorial.models.sensors import PinHole, PinHoleDepth, RangeBearingElevation, StereoPinHole
from ekfslam_tutorial.toolbox import UserData, universal_slam

DT = 0.05
AHEAD = e2q(np.deg2rad([-90.0, 0, -90]))[0]
K = (320.0, 240.0, 350.0, 350.0)


@pytest.fixture(scope="module")
def flight():
    """15 s on a screw among 30 points: true poses, the steps between them, and the points."""
    rng = np.random.default_rng(1)
    world = np.column_stack([rng.uniform(-8, 8, (30, 2)), rng.uniform(-1, 4, 30)])
    steps = [
        np.array([1.0, 0.1 * np.sin(t), 0.15, 0.1 * np.sin(t), 0.1 * np.cos(t), 0.3]) * DT for t in DT * np.arange(300)
    ]
    x = [np.array([0.0, 0, 0, 1, 0, 0, 0])]
    for u in steps:
        x.append(Odometry3().move(x[-1], u, DT)[0])
    return SimpleNamespace(t=DT * np.arange(301), x=np.array(x), steps=np.array(steps), world=world)


def seen(flight, mount, project, visible, std, every=4):
    """Rows t, id, measurement of what a sensor at `mount` sees."""
    rng, rows = np.random.default_rng(2), []
    for t, x in zip(flight.t[every::every], flight.x[every::every], strict=True):
        p = Frame3(x).compose(Frame3(mount))[0].to_frame(flight.world)[0]
        y = project(p)
        rows += [(t, i + 1, *(y[i] + rng.normal(0, std))) for i in np.flatnonzero(visible(p, y))]
    return np.array(rows)


def write(path, head, rows):
    np.savetxt(path, rows, delimiter=",", header=",".join(head.split()), comments="", fmt="%.12g")


def played(done):
    history = History()
    for _ in history.watch(universal_slam(UserData.from_dict(done.scenario), done.recording)):
        pass
    return history.summary()


def honest(figures, size):
    """NIS within a factor of three of its size (noise is a first guess), nearly nothing refused, the path right."""
    assert size / 3 < figures["nis_mean"] < 3 * size
    assert figures["n_refused"] < 0.02 * figures["n_innovations"]
    assert figures["ate_rmse_m"] < (0.45 if size == 2 else 0.15)  # pixels: the scale is that of 15 m of odometry


NEAR = lambda p, y: np.linalg.norm(p, axis=1) < 7
HERE = np.array([0.0, 0, 0, 1, 0, 0, 0])
CAMERA = np.concatenate([[0.1, 0, 0.2], AHEAD])


def twists(flight, rng):
    speeds = flight.steps / DT  # held velocities: a step over dt, but for the screw
    rows = speeds + rng.normal(0, 1, speeds.shape) * np.repeat([0.03, 0.01], 3)
    return "time vx vy vz wx wy wz", np.column_stack([flight.t[1:], rows])


def steps(flight, rng):
    rows = flight.steps + rng.normal(0, 1, flight.steps.shape) * np.repeat([0.002, 0.001], 3)
    return "stamp dx dy dz dax day daz", np.column_stack([flight.t[1:], rows])


def poses(flight, rng):
    x = [flight.x[0]]
    for u in flight.steps + rng.normal(0, 1, flight.steps.shape) * np.repeat([0.002, 0.001], 3):
        x.append(Odometry3().move(x[-1], u, DT)[0])
    return "t pos_x pos_y pos_z q_w q_x q_y q_z", np.column_stack([flight.t, np.array(x)])


def lidar(flight):
    sonar = RangeBearingElevation()
    return "t id range bearing elevation", seen(flight, HERE, lambda p: sonar.project(p)[0], NEAR, [0.05, 0.01, 0.01])


def points(flight):
    return "t tag x y z", seen(flight, HERE, lambda p: p, NEAR, [0.05, 0.05, 0.05])


def through(camera, std):
    return lambda flight: seen(
        flight, CAMERA, lambda p: camera.project(p)[0], lambda p, y: NEAR(p, y) & camera.visible(y, p), std, 2
    )


@pytest.mark.parametrize(
    ("odometry", "scan", "head", "told", "kind", "size"),
    [
        (twists, lidar, None, {}, "range_bearing_elevation", 3),
        (poses, points, None, {}, "point_xyz", 3),
        (steps, through(PinHole(K), [1, 1]), "t id u v", {"k": list(K)}, "pin_hole", 2),
        (poses, through(PinHoleDepth(K), [1, 1, 0.1]), "t id u v depth", {"k": list(K)}, "pin_hole_depth", 3),
        (
            twists,
            through(StereoPinHole(K, 0.3), [1, 0.7, 1.4]),
            "t id u v disparity",
            {"k": list(K), "baseline": 0.3},
            "stereo_pin_hole",
            3,
        ),
    ],
)
def test_columns_in_space(flight, tmp_path, odometry, scan, head, told, kind, size):
    write(tmp_path / "odometry.csv", *odometry(flight, np.random.default_rng(3)))
    rows = scan(flight)
    write(tmp_path / "seen.csv", *((head, rows) if head else rows))
    write(tmp_path / "ground_truth.csv", "t tx ty tz qw qx qy qz", np.column_stack([flight.t, flight.x])[::4])
    write(tmp_path / "survey.csv", "id x y z", np.column_stack([np.arange(1, 31), flight.world]))
    if kind in ("pin_hole", "pin_hole_depth", "stereo_pin_hole"):
        with pytest.raises(ValueError, match=r"pixels need the camera: --set scan.k=\[u0, v0, fu, fv\]"):
            convert(tmp_path)
        told |= {"position": CAMERA[:3].tolist()}
    done = convert(tmp_path, {"scan": told} if told else None)
    assert done.scenario["sensor"][0]["type"] == kind and done.scenario["convert"]["space"]
    honest(played(done), size)


def test_an_imu_and_pixels_of_a_robot_that_begins_at_rest(tmp_path):
    """200 Hz, stamped in ns of the day, accelerations in g; it rests for two seconds."""
    rng, t = np.random.default_rng(3), np.arange(0, 12, 0.005)
    s = np.clip((t - 2) / 3, 0, 1)
    phase = 0.005 * np.cumsum(s**3 * (10 - 15 * s + 6 * s * s)) * 0.6
    p = np.column_stack([2 * np.sin(phase), 2 - 2 * np.cos(phase), 0.2 * np.sin(2 * phase)])
    q = e2q(np.column_stack([0.1 * np.sin(3 * phase), 0.1 * np.sin(2 * phase), phase]))[0]
    dq = q_prod(q[:-1] * [1, -1, -1, -1], q[1:])[0]
    w = np.vstack([q2v(dq * np.sign(dq[:, :1]))[0] / 0.005, np.zeros(3)])
    force = np.gradient(np.gradient(p, 0.005, axis=0), 0.005, axis=0) + [0, 0, 9.81]
    f = np.einsum("nji,nj->ni", q2R(q)[0], force)
    w, f = w + [0.01, -0.02, 0] + rng.normal(0, 0.014, w.shape), f + rng.normal(0, 0.14, f.shape)
    stamps = 1_400_000_000_000_000_000 + np.round(1e9 * t).astype(np.int64)
    lines = [",".join(map(str, (a, *b, *c))) for a, b, c in zip(stamps, w, f / 9.80665, strict=True)]
    (tmp_path / "imu0.csv").write_text("#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],"
                                       "a_RS_S_x [g],a_RS_S_y [g],a_RS_S_z [g]\n" + "\n".join(lines))  # fmt: skip
    world, camera = rng.uniform([-6, -6, -2], [6, 8, 3], (60, 3)), PinHole(K)
    drone = SimpleNamespace(t=t, x=np.hstack([p, q]), world=world)
    rows = seen(drone, CAMERA, lambda p: camera.project(p)[0], lambda p, y: camera.visible(y, p), [1, 1], 20)
    lines = [f"{1_400_000_000_000_000_000 + round(1e9 * row[0])},{row[1]:.0f},{row[2]},{row[3]}" for row in rows]
    (tmp_path / "tracks.csv").write_text("timestamp,id,u,v\n" + "\n".join(lines))
    done = convert(tmp_path, {"scan": {"k": list(K), "position": CAMERA[:3].tolist()}})
    said = "\n".join(done.said)
    for words in ("they are in g; times 9.80665", "200 Hz", "it starts at rest", "wx, wy, wz: rad, by its name"):
        assert words in said
    f = played(done)
    assert 1 < f["nis_mean"] < 3 and f["n_refused"] < 0.02 * f["n_innovations"]
    *_, now = universal_slam(UserData.from_dict(done.scenario), done.recording)
    k = round(done.recording.t[-1] / 0.005) + 20
    way = Frame3(drone.x[20]).to_frame(drone.x[k, :3])[0]
    assert np.linalg.norm(now.robs[0].frame(now.map).t - way) < 0.1


def test_a_camera_in_the_hand(flight, tmp_path):
    rows = through(PinHoleDepth(K), [1, 1, 0.1])(flight)
    write(tmp_path / "rgbd.csv", "t id u v depth", rows)
    told = {"scan": {"k": list(K), "position": CAMERA[:3].tolist()}}
    with pytest.raises(ValueError, match=r"\(or odometry=false: a hand-held camera\)"):
        convert(tmp_path, told)
    out = tmp_path / "out"
    words = ["odometry=false", f"scan.k={list(K)}", f"scan.position={CAMERA[:3].tolist()}"]
    sets = [word for text in words for word in ("--set", text)]
    assert main(["convert", str(tmp_path / "rgbd.csv"), "--guess", "--out", str(out), *sets]) == 0
    data = UserData.from_toml(out / "scenario.toml")
    assert type(data.robots[0].motion).__name__ == "ConstantVelocity"


def test_without_elevation_space_asks_for_it(tmp_path):
    (tmp_path / "odo.csv").write_text("t,vx,vy,vz,wx,wy,wz\n0,1,0,0,0,0,0\n1,1,0,0,0,0,0\n")
    (tmp_path / "laser.csv").write_text("t,id,range,bearing\n0,1,3,0\n1,1,2,0\n")
    assert convert(tmp_path).scenario["robot"][0]["motion"] == "unicycle"  # nothing is out of the plane
    with pytest.raises(
        ValueError, match="alone starts no landmarks in space; needed are range, bearing, elevation; or"
    ):
        convert(tmp_path, {"space": True})


@pytest.mark.parametrize("gap", [0.0, 1.0])
def test_an_imu_that_is_too_short_or_has_a_gap(tmp_path, gap):
    t = np.arange(0, 4, 0.005)
    t = t[(t < 1.5) | (t > 1.5 + gap)]
    (tmp_path / "seen.csv").write_text(
        "t,id,x,y,z\n" + "\n".join(f"{a},{i},3,{i},{i}" for a in t[::10] for i in range(3))
    )
    rows = [f"{a},0,0,0,0,0,9.81" for a in t]
    (tmp_path / "imu.csv").write_text("t,gx,gy,gz,ax,ay,az\n" + "\n".join(rows))
    assert ("1 gap" in "\n".join(convert(tmp_path).said)) == bool(gap)
    (tmp_path / "imu.csv").write_text("t,gx,gy,gz,ax,ay,az\n" + "\n".join(rows[:40]))
    with pytest.raises(ValueError, match=r"the IMU lasts 0.2 s; 0.5 s are the least"):
        convert(tmp_path)


def test_true_poses_in_space_are_interpolated_the_shorter_way_round():
    q = v2q(np.array([[0, 0, 0], [0, 0, 0.4]]))[0] * [[1.0], [-1.0]]
    at = at_times(np.array([0.5]), np.array([0, 1.0]), np.hstack([[[0, 0, 0], [2, 0, 0]], q]))
    np.testing.assert_allclose(at, [[1, 0, 0, *v2q(np.array([0, 0, 0.2]))[0]]], atol=1e-12)


def test_the_tangential_part_of_a_lens_is_taken_off():
    """Points through the whole lens, and through the radial part of it alone; OpenCV says the same."""
    rng, d = np.random.default_rng(2), [-0.28, 0.07, 1.2e-3, -8e-4, 0.01]
    up = rng.uniform(-0.6, 0.6, (200, 2))
    (x, y), (k1, k2, p1, p2, k3) = up.T, d
    r2 = x * x + y * y
    radial = 1 + k1 * r2 + k2 * r2**2 + k3 * r2**3
    both = [x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x), y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y]
    pixels = np.array(K[:2]) + np.array(K[2:]) * np.transpose(both)
    alone = PinHole(K, (k1, k2, k3)).project(np.column_stack([up, np.ones(200)]))[0]
    np.testing.assert_allclose(without_tangential(pixels, K, d), alone, atol=1e-8)
    assert np.abs(pixels - alone).max() > 0.5  # it matters
    assert np.isnan(without_tangential(np.full((1, 2), 1e5), K, d)).all()  # beyond the fold
    cv2 = pytest.importorskip("cv2", reason="OpenCV: pip install ekfslam_tutorial[images]")
    camera = np.array([[K[2], 0, K[0]], [0, K[3], K[1]], [0, 0, 1]], float)
    theirs = cv2.projectPoints(np.column_stack([up, np.ones(200)]), np.zeros(3), np.zeros(3), camera, np.array(d))[0]
    np.testing.assert_allclose(pixels, theirs[:, 0], atol=1e-9)


# --- bags ---

DETECTIONS = {  # as vision_msgs and apriltag_ros have them, as far as they are needed
    "vision_msgs/msg/Point2D": "float64 x\nfloat64 y",
    "vision_msgs/msg/Pose2D": "vision_msgs/Point2D position\nfloat64 theta",
    "vision_msgs/msg/BoundingBox2D": "vision_msgs/Pose2D center\nfloat64 size_x\nfloat64 size_y",
    "vision_msgs/msg/ObjectHypothesis": "string class_id\nfloat64 score",
    "vision_msgs/msg/ObjectHypothesisWithPose": "vision_msgs/ObjectHypothesis hypothesis\n"
    "geometry_msgs/PoseWithCovariance pose",
    "vision_msgs/msg/Detection2D": "std_msgs/Header header\nvision_msgs/ObjectHypothesisWithPose[] results\n"
    "vision_msgs/BoundingBox2D bbox\nstring id",
    "vision_msgs/msg/Detection2DArray": "std_msgs/Header header\nvision_msgs/Detection2D[] detections",
    "apriltag_ros/msg/AprilTagDetection": "int32[] id\nfloat64[] size\ngeometry_msgs/PoseWithCovarianceStamped pose",
    "apriltag_ros/msg/AprilTagDetectionArray": "std_msgs/Header header\napriltag_ros/AprilTagDetection[] detections",
}


class Bag:
    """Writes a ROS 2 bag; messages are made from nested tuples of values."""

    def __init__(self, path, plugin):
        from rosbags import rosbag2
        from rosbags.typesys import Stores, get_types_from_msg, get_typestore

        self.store = get_typestore(Stores.ROS2_HUMBLE)
        for name, text in DETECTIONS.items():
            self.store.register(get_types_from_msg(text, name))
        self.writer = rosbag2.Writer(path, version=9, storage_plugin=rosbag2.StoragePlugin[plugin])
        self.topics = {}

    def make(self, kind, *values):
        package, _, name = kind.partition("/")
        return self.store.types[f"{package}/msg/{name}"](*values)

    def header(self, t, frame):
        return self.make("std_msgs/Header", self.make("builtin_interfaces/Time", int(t), round(t % 1 * 1e9)), frame)

    def pose(self, x):
        point = self.make("geometry_msgs/Point", *map(float, x[:3]))
        return self.make(
            "geometry_msgs/Pose", point, self.make("geometry_msgs/Quaternion", *map(float, [*x[4:], x[3]]))
        )

    def write(self, t, topic, message):
        if topic not in self.topics:
            self.topics[topic] = self.writer.add_connection(topic, message.__msgtype__, typestore=self.store)
        self.writer.write(self.topics[topic], round(1e9 * t), self.store.serialize_cdr(message, message.__msgtype__))

    def odometry(self, t, x):
        zero = self.make("geometry_msgs/Vector3", 0.0, 0.0, 0.0)
        pose = self.make("geometry_msgs/PoseWithCovariance", self.pose(x), np.zeros(36))
        twist = self.make(
            "geometry_msgs/TwistWithCovariance", self.make("geometry_msgs/Twist", zero, zero), np.zeros(36)
        )
        self.write(t, "/vio", self.make("nav_msgs/Odometry", self.header(t, "odom"), "base_link", pose, twist))

    def camera(self, t, d):
        roi = self.make("sensor_msgs/RegionOfInterest", 0, 0, 0, 0, False)
        matrix = np.array([K[2], 0, K[0], 0, K[3], K[1], 0, 0, 1.0])
        info = self.make("sensor_msgs/CameraInfo", self.header(t, "camera_optical"), 480, 640, "plumb_bob", np.array(d),
                         matrix, np.eye(3).ravel(), np.zeros(12), 0, 0, roi)  # fmt: skip
        self.write(t, "/camera/camera_info", info)

    def mounted(self, t, frame, x):
        place, turn = self.make("geometry_msgs/Vector3", *x[:3]), self.pose(x).orientation
        transform = self.make("geometry_msgs/Transform", place, turn)
        tf = self.make("geometry_msgs/TransformStamped", self.header(t, "base_link"), frame, transform)
        self.write(t, "/tf_static", self.make("tf2_msgs/TFMessage", [tf]))

    def boxes(self, t, rows):
        things = []
        for _, id, *y in rows:
            centre = self.make("vision_msgs/Pose2D", self.make("vision_msgs/Point2D", *y), 0.0)
            box = self.make("vision_msgs/BoundingBox2D", centre, 20.0, 20.0)
            things.append(self.make("vision_msgs/Detection2D", self.header(t, "camera_optical"), [], box, f"cone {id}"))
        self.write(t, "/yolo", self.make("vision_msgs/Detection2DArray", self.header(t, "camera_optical"), things))

    def tags(self, t, rows):
        things = []
        for _, id, *p in rows:
            pose = self.make("geometry_msgs/PoseWithCovariance", self.pose([*p, 1, 0, 0, 0]), np.zeros(36))
            stamped = self.make("geometry_msgs/PoseWithCovarianceStamped", self.header(t, "camera_optical"), pose)
            things.append(
                self.make("apriltag_ros/AprilTagDetection", np.array([id], np.int32), np.array([0.1]), stamped)
            )
        header = self.header(t, "camera_optical")
        self.write(t, "/tag_detections", self.make("apriltag_ros/AprilTagDetectionArray", header, things))


@pytest.mark.parametrize(("plugin", "what"), [("SQLITE3", "boxes"), ("MCAP", "tags")])
def test_bags_of_cameras(flight, tmp_path, plugin, what):
    """Poses of an odometry whose twist nobody filled in; boxes in the image with a CameraInfo, and poses of tags."""
    pytest.importorskip("rosbags", reason="bags need rosbags: pip install ekfslam_tutorial[bags]")
    camera, bag = PinHole(K, (-0.1, 0.02)), Bag(tmp_path / "bag", plugin)
    see = camera if what == "boxes" else None
    project = (lambda p: camera.project(p)[0]) if see else (lambda p: p)
    visible = lambda p, y: NEAR(p, y) & camera.visible(camera.project(p)[0], p)
    rows = seen(flight, CAMERA, project, visible, [1, 1] if see else [0.03] * 3, 2)
    _, odometry = poses(flight, np.random.default_rng(3))
    with bag.writer:
        bag.camera(0.0, [-0.1, 0.02, 1e-4, 0.0, 0.0])
        bag.mounted(0.0, "camera_optical", CAMERA)
        for t, *x in odometry:
            bag.odometry(t, x)
            if (mine := rows[np.isclose(rows[:, 0], t)]).size:
                getattr(bag, what)(t, mine.astype(object))
    done = convert(tmp_path / "bag")
    said, plan, sensor = "\n".join(done.said), done.scenario["convert"], done.scenario["sensor"][0]
    assert plan["odometry"]["x"] == "pose.pose.position.x" and plan["space"]
    assert "mounted by /tf_static: position = [0.1, 0.0, 0.2], orientation_deg = [-90.0, 0.0, -90.0]" in said
    if see:
        assert sensor["type"] == "pin_hole" and sensor["k"] == list(K) and sensor["d"] == [-0.1, 0.02]
        off = re.search(r"the tangential part is taken off, up to (\S+) pixels", said)
        assert 0.01 < float(off[1]) < 0.2
        assert "detections.id holds words: " in said
    else:
        assert sensor["type"] == "point_xyz" and plan["scan"]["id"] == "detections.id"
    f = played(done)
    assert f["n_refused"] < 0.02 * f["n_innovations"]
    *_, now = universal_slam(UserData.from_dict(done.scenario), done.recording)
    assert np.linalg.norm(now.robs[0].frame(now.map).t - flight.x[-1, :3]) < (0.45 if see else 0.15)
