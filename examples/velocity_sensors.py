"""A robot that only hears how fast it goes: range rates of known beacons, and the picture of the ground below.

The motion model has the speeds among its states, the sensors ask for them. Neither measures where the robot is, or how
far the beacons are; both together still keep the path, because a range rate depends on where the beacon is.

It prints

    GroundFlow: position off by 9.29 m, sigma 12.22 m; speed 1.17 m/s
    GroundFlow and RangeRate: position off by 0.12 m, sigma 0.05 m; speed 1.17 m/s
"""

import numpy as np

from ekfslam_tutorial.models.motion import ConstantTurn
from ekfslam_tutorial.models.sensors import GroundFlow, RangeRate
from ekfslam_tutorial.toolbox import Landmark, Robot, Sensor, Time, UserData, World, universal_slam

robot = Robot(
    motion=ConstantTurn(),
    position=[0, -4],
    state={"speed": 1.0, "turn_rate_deg": 14.3},
    state_std={"speed": 0.3, "turn_rate_deg": 3.0},
    control_std={"dv": 0.02, "dw_deg": 0.3},
)
radar = Sensor(id=1, model=RangeRate(rate_std=0.05, max_range=20.0))
flow = Sensor(id=2, model=GroundFlow(flow_std=0.05, height=0.3))  # a camera 30 cm above the ground
beacons = World.of([[8.0, 0.0], [-4.0, 7.0], [-4.0, -7.0]])

for sensors in [flow], [flow, radar]:
    data = UserData(
        name="speeds",
        robots=[robot],
        sensors=sensors,
        world=beacons,
        landmark=Landmark(in_map=False),  # they are known
        time=Time(dt=0.1, last=250),
    )
    for now in universal_slam(data):
        pass
    rob = now.robs[0]
    off = np.linalg.norm(rob.frame(now.map).t - now.truth[1][:2])
    std = np.sqrt(np.trace(now.map.block(rob.r)[:2, :2]))
    names = " and ".join(type(sensor.model).__name__ for sensor in sensors)
    print(f"{names}: position off by {off:.2f} m, sigma {std:.2f} m; speed {rob.state(now.map)[3]:.2f} m/s")
