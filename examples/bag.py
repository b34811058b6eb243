"""A ROS 2 bag without ROS: written and read by the package rosbags, `pip install ekfslam_tutorial[bags]`.

It prints

    odometry: from = /odom, t = t, v = twist.linear.x, w = twist.angular.z
    scan: from = /cones, t = t, x = poses.position.x, y = poses.position.y
    5 landmarks, robot off by 0.09 m
"""

import tempfile
from pathlib import Path

import numpy as np
from rosbags.rosbag2 import Writer
from rosbags.typesys import Stores, get_typestore

from ekfslam_tutorial.datasets.foreign import convert
from ekfslam_tutorial.toolbox import UserData, universal_slam

store = get_typestore(Stores.ROS2_HUMBLE)
make = lambda kind, *values: store.types[kind](*values)
rng, cones = np.random.default_rng(2), np.array([[3.0, 3], [-3, 4], [0, 7], [4, 6], [-4, 1]])


def header(t):
    stamp = make("builtin_interfaces/msg/Time", int(t), round(t % 1 * 1e9))
    return make("std_msgs/msg/Header", stamp, "base_link")


def speed(t, v, w):
    forward, turn = (make("geometry_msgs/msg/Vector3", *a) for a in ((v, 0.0, 0.0), (0.0, 0.0, w)))
    return make("geometry_msgs/msg/TwistStamped", header(t), make("geometry_msgs/msg/Twist", forward, turn))


def seen(t, points):
    upright = make("geometry_msgs/msg/Quaternion", 0.0, 0.0, 0.0, 1.0)
    places = [make("geometry_msgs/msg/Point", *p, 0.0) for p in points]
    poses = [make("geometry_msgs/msg/Pose", p, upright) for p in places]
    return make("geometry_msgs/msg/PoseArray", header(t), poses)


with tempfile.TemporaryDirectory() as folder:
    path = Path(folder) / "drive"
    with Writer(path, version=9) as bag:
        odom = bag.add_connection("/odom", "geometry_msgs/msg/TwistStamped", typestore=store)
        looks = bag.add_connection("/cones", "geometry_msgs/msg/PoseArray", typestore=store)
        x = np.zeros(3)
        for k in range(1, 201):
            t, x = 0.1 * k, x + 0.1 * np.array([np.cos(x[2]), np.sin(x[2]), 0.3])
            messages = [(odom, speed(t, 1 + rng.normal(0, 0.03), 0.3 + rng.normal(0, 0.01)))]
            if k % 5 == 0:
                c, s = np.cos(x[2]), np.sin(x[2])
                points = (cones - x[:2]) @ np.array([[c, -s], [s, c]]) + rng.normal(0, 0.03, (5, 2))
                messages.append((looks, seen(t, points)))
            for topic, message in messages:
                bag.write(topic, round(1e9 * t), store.serialize_cdr(message, message.__msgtype__))
    done = convert(path)

for role, entry in done.scenario["convert"].items():
    print(f"{role}: {', '.join(f'{name} = {column}' for name, column in entry.items())}")
for now in universal_slam(UserData.from_dict(done.scenario), done.recording):
    pass
error = np.linalg.norm(now.robs[0].frame(now.map).t - x[:2])
print(f"{len(now.lmks)} landmarks, robot off by {error:.2f} m")
