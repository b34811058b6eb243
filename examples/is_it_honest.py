"""Is it honest? The mean NEES of twenty runs, in its chi-square band: noise as it is, and noise told too small.

It prints

    honest          mean NEES  3.5, in the 95 % band 2.02 to 4.16
    over-confident  mean NEES  8.2, outside the 95 % band 2.02 to 4.16
"""

import numpy as np

from ekfslam_tutorial.analysis import anees_band, monte_carlo
from ekfslam_tutorial.models.motion import Unicycle
from ekfslam_tutorial.models.sensors import RangeBearing
from ekfslam_tutorial.simulation import worlds
from ekfslam_tutorial.toolbox import Robot, Sensor, Time, UserData, World, universal_slam
from ekfslam_tutorial.toolbox.recordings import Recorder

robot = Robot(
    motion=Unicycle(),
    position=[0, -4],
    control={"v": 0.5, "w_deg": 7.2},
    control_std={"v": 0.02, "w_deg": 0.5},
)
data = UserData(
    robots=[robot],
    sensors=[Sensor(model=RangeBearing(0.05, np.radians(0.5), max_range=5.0))],
    world=World.of(worlds.ring(n=16, radius=6.0)[1]),
    time=Time(dt=0.5, last=60),
)
runs = 20
low, high = anees_band(3, runs)
honest = monte_carlo(data, runs).nees[:, -1, 0]

lying = []
for seed in range(runs):  # the same world, but the filter is told a quarter of the noise
    recorder = Recorder()
    for now in universal_slam(data, seed=seed):
        recorder.add(now)
    told = RangeBearing(0.025, np.radians(0.25), max_range=5.0)
    recording = recorder.recording("a log")
    believer = UserData(robots=data.robots, sensors=[Sensor(model=told)], world=data.world, time=data.time)
    for now in universal_slam(believer, recording):
        pass
    e, E = now.robs[0].frame(now.map).minus(type(now.robs[0].frame(now.map))(now.truth[1]))[:2]
    lying.append(e @ np.linalg.solve(E @ now.map.block(now.robs[0].r) @ E.T, e))

for name, nees in (("honest", honest), ("over-confident", np.array(lying))):
    verdict = "in" if low < nees.mean() < high else "outside"
    print(f"{name:15} mean NEES {nees.mean():4.1f}, {verdict} the 95 % band {low:.2f} to {high:.2f}")
