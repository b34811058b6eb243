"""A scenario in Python: robots, sensors and world are objects, and a run is a loop over its frames.

It prints

    12.5 s: 13 landmarks, robot off by 0.59 m
    25.0 s: 16 landmarks, robot off by 0.02 m
    37.5 s: 16 landmarks, robot off by 0.31 m
    50.0 s: 16 landmarks, robot off by 0.08 m
"""

import numpy as np

from ekfslam_tutorial.models.motion import Unicycle
from ekfslam_tutorial.models.sensors import RangeBearing
from ekfslam_tutorial.simulation import worlds
from ekfslam_tutorial.toolbox import Robot, Sensor, Time, UserData, World, universal_slam

robot = Robot(
    motion=Unicycle(),
    position=[0, -4],
    control={"v": 1.0, "w_deg": 14.4},
    control_std={"v": 0.1, "w_deg": 2.0},
)
data = UserData(
    name="a round in a ring",
    robots=[robot],
    sensors=[Sensor(model=RangeBearing(0.1, np.radians(1), max_range=5.0))],
    world=World.of(worlds.ring(n=16, radius=6.0)[1]),
    time=Time(dt=0.5, last=100),
)
for now in universal_slam(data, seed=3):
    if now.k % 25 == 0:
        error = np.linalg.norm(now.robs[0].frame(now.map).t - now.truth[1][:2])
        print(f"{now.t:4.1f} s: {len(now.lmks):2} landmarks, robot off by {error:.2f} m")
