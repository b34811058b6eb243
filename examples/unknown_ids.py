"""Unknown ids: nobody says which landmark a measurement belongs to. Two rules for it, and what they cost.

It prints

    KnownIds         34 landmarks in the map, 35 in the world, robot off by 0.04 m
    NearestNeighbour 33 landmarks in the map, 35 in the world, robot off by 0.05 m
    Jcbb             33 landmarks in the map, 35 in the world, robot off by 0.04 m
"""

import numpy as np

from ekfslam_tutorial.models.motion import Unicycle
from ekfslam_tutorial.models.sensors import RangeBearing
from ekfslam_tutorial.slam import Jcbb, KnownIds, NearestNeighbour
from ekfslam_tutorial.toolbox import Options, Robot, Sensor, Time, UserData, World, universal_slam

points = np.random.default_rng(9).uniform(-6, 6, (35, 2))
robot = Robot(
    motion=Unicycle(),
    position=[0, -4],
    control={"v": 1.0, "w_deg": 14.4},
    control_std={"v": 0.15, "w_deg": 4.0},
)
for association in (KnownIds(), NearestNeighbour(), Jcbb()):
    data = UserData(
        robots=[robot],
        sensors=[Sensor(model=RangeBearing(0.15, np.radians(2), max_range=4.0))],
        world=World.of(points),
        time=Time(dt=0.5, last=100),
        options=Options(association=association),
    )
    for now in universal_slam(data, seed=9):
        pass
    error = np.linalg.norm(now.robs[0].frame(now.map).t - now.truth[1][:2])
    name = type(association).__name__
    print(f"{name:16} {len(now.lmks)} landmarks in the map, {len(points)} in the world, robot off by {error:.2f} m")
