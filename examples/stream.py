"""A stream of messages: speeds at 20 Hz, a laser at 6 Hz, a fifth of the messages late, and the filter keeps time.

It prints

    arrived in order:     [ 5.62 -0.03] m, 1 sigma 0.02 m, 182 messages
    a fifth of them late: [ 5.62 -0.03] m, 1 sigma 0.02 m, 182 messages
    half a second on:     [ 5.99 -0.03] m, 1 sigma 0.03 m, and the filter has not moved
    sensor 1: a message of 2 s came when the newest was of 7 s; the horizon is 0.5 s
"""

import numpy as np

from ekfslam_tutorial.models.motion import Unicycle
from ekfslam_tutorial.models.sensors import RangeBearing
from ekfslam_tutorial.toolbox import Control, Measurement, OnlineSlam, Robot, Sensor, UserData

robot = Robot(motion=Unicycle(), position=[0, 0], control_std={"v": 0.1, "w_deg": 2.0})
data = UserData(robots=[robot], sensors=[Sensor(model=RangeBearing(0.05, 0.01))])

# What a robot would send: a control says what it did from the one before until its stamp.
rng, posts = np.random.default_rng(28), np.array([[3.0, 2.0], [6.0, -1.5], [9.0, 1.0]])
messages = [Control(t, [0.8, 0.0] + rng.normal(0, [0.05, 0.02])) for t in np.arange(0.05, 7.001, 0.05)]
for t in np.arange(0.1, 7, 1 / 6):
    d = posts - [0.8 * t, 0.0]
    y = np.column_stack([np.hypot(*d.T), np.arctan2(d[:, 1], d[:, 0])]) + rng.normal(0, [0.05, 0.01], (3, 2))
    messages.append(Measurement(t, ids=[1, 2, 3], y=y))
stamps = np.array([m.t for m in messages])
late = np.where(rng.random(len(messages)) < 0.2, rng.uniform(0, 0.5, len(messages)), 0.0)

for name, arrival in ("arrived in order:", stamps), ("a fifth of them late:", stamps + late):
    slam = OnlineSlam(data, horizon=0.5)
    for i in np.argsort(arrival, kind="stable"):
        slam.add(messages[i])
        slam.update()  # or leave it until somebody asks
    x, P = slam.state()
    print(f"{name:21} {x[:2].round(2)} m, 1 sigma {np.sqrt(P[0, 0]):.2f} m, {len(messages)} messages")

x, P = slam.state(slam.t + 0.5)
print(f"half a second on:     {x[:2].round(2)} m, 1 sigma {np.sqrt(P[0, 0]):.2f} m, and the filter has not moved")
print(slam.add(Measurement(2.0, ids=[1], y=[[1.5, 0.3]])))  # too late: said, and counted in slam.dropped
