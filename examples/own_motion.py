"""A motion of your own: a boat that drifts with a current, which is a part of the state and gets known.

It prints

     0.2 s: current +0.00 +0.00 m/s, 1 sigma 0.300; true -0.23 -0.18
    10.0 s: current -0.24 -0.18 m/s, 1 sigma 0.003; true -0.23 -0.18
    40.0 s: current -0.23 -0.18 m/s, 1 sigma 0.001; true -0.23 -0.18
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ekfslam_tutorial.geometry import Frame2
from ekfslam_tutorial.models import check_motion
from ekfslam_tutorial.models.motion import Unicycle
from ekfslam_tutorial.models.sensors import RangeBearing
from ekfslam_tutorial.toolbox import Robot, Sensor, Time, UserData, World, universal_slam


@dataclass(frozen=True)
class Boat:
    """Robot state [x, y, theta, cx, cy]: a unicycle in water that flows with [cx, cy] (m/s) over the ground."""

    frame: ClassVar = Frame2
    size: ClassVar[int] = 5
    control_fields: ClassVar = {"v": 1, "w_deg": 1}
    state_fields: ClassVar = {"current": 2}

    def move(self, x, u, dt):
        pose, X_x, X_u = Unicycle().move(x[..., :3], u, dt)
        current = x[..., 3:]
        x2 = np.concatenate([pose[..., :2] + current * dt, pose[..., 2:], current], -1)
        B_x = np.zeros_like(x2, shape=(*x2.shape, 5))
        B_x[...] = np.eye(5)
        B_x[..., :3, :3] = X_x
        B_x[..., :2, 3:] = dt * np.eye(2)
        B_u = np.zeros_like(x2, shape=(*x2.shape, 2))
        B_u[..., :3, :] = X_u
        return x2, B_x, B_u


check_motion(Boat())

boat = Robot(
    motion=Boat(),
    position=[0, -5],
    state={"current": [0, 0]},
    state_std={"current": 0.3},  # the true current is drawn with it
    control={"v": 1.0, "w_deg": 12.0},
    control_std={"v": 0.05, "w_deg": 1.0},
)
buoys = np.random.default_rng(6).uniform(-15, 15, (60, 2))
sonar = Sensor(model=RangeBearing(0.2, np.radians(1), max_range=10.0))
data = UserData(robots=[boat], sensors=[sonar], world=World.of(buoys), time=Time(dt=0.2, last=200))
for now in universal_slam(data, seed=6):
    if now.k in (1, 50, 200):
        x, P = now.map.state(now.robs[0].r), now.map.block(now.robs[0].r)
        true = now.sim_robs[0].x[3:]
        print(f"{now.t:4.1f} s: current {x[3]:+.2f} {x[4]:+.2f} m/s, 1 sigma {np.sqrt(P[3, 3]):.3f}", end="; ")
        print(f"true {true[0]:+.2f} {true[1]:+.2f}")
