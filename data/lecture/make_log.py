"""Make the log of this folder anew: ``python data/lecture/make_log.py``.

One robot drives a little more than one round among the 16 landmarks of the lecture. It is measured by its own odometry
and measures ranges and bearings, both with the noise that is written down in `ekfslam_tutorial.datasets.lecture`.
"""

import numpy as np

from ekfslam_tutorial.datasets import lecture
from ekfslam_tutorial.geometry import Frame2
from ekfslam_tutorial.models.motion import Odometry2
from ekfslam_tutorial.simulation import (
    SimLmk,
    SimObs,
    SimRob,
    SimSen,
    Streams,
    draw,
    sim_motion,
    sim_observation,
    worlds,
)
from ekfslam_tutorial.toolbox import Recording

SEED = 19
STEPS = 50
START = [0.0, -3.7, 0.0]
STEP = 0.5  # m
RADIUS = 3.65  # m, of the round on the average
DIGITS = 6  # a micrometre: the files stay readable and are the same on every computer


def make():
    """Simulate the run and return it as a recording."""
    streams = Streams(SEED)
    motion, sensing = streams.motion(lecture.ROBOT), streams.sensing(lecture.SENSOR_ID)
    robot = SimRob(lecture.ROBOT, "robot", Odometry2(), np.array(START), np.zeros(3), [lecture.SENSOR_ID])
    sensor = SimSen(lecture.SENSOR_ID, "range_bearing", robot.id, Frame2(np.zeros(3)), lecture.SENSOR)
    landmarks = SimLmk(*worlds.lecture())

    poses, odometry, scans = [], [], []
    for k in range(STEPS):
        turn = STEP / RADIUS * (1 + 0.35 * np.cos(4 * np.pi * k * STEP / (2 * np.pi * RADIUS)))
        robot.u = np.array([STEP, 0.0, turn]) if k > 0 else np.zeros(3)
        sim_motion(robot, 1.0)
        noise = draw(motion, np.diag(lecture.ODOMETRY_STD**2))
        poses.append(robot.x.copy())
        odometry.append(robot.u + noise if k > 0 else robot.u)
        scans.append(in_sight(robot, sim_observation(robot, sensor, landmarks, sensing), landmarks))
    return Recording(
        name="The mapping lecture: 50 steps among 16 landmarks",
        t=np.arange(STEPS, dtype=float),
        robots={robot.id: np.round(odometry, DIGITS)},
        raw={sensor.id: scans},
        truth={robot.id: np.round(poses, DIGITS)},
        landmarks=landmarks,
        notes=[f"simulated by make_log.py with seed {SEED}; the columns and their units are in README.md"],
    )


def in_sight(robot, scan, landmarks):
    """The measurements of the landmarks that are near. A cut by the *measured* range would drop the large errors."""
    near = np.hypot(*(landmarks.points - robot.x[:2]).T) < lecture.SIGHT
    return SimObs(scan.sen, scan.ids[near], scan.y[near].round(DIGITS))


if __name__ == "__main__":
    make().save(lecture.folder())
