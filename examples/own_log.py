"""A log of your own: arrays of controls and measurements become a recording, which is saved, loaded and played.

It prints

    frames.csv, recording.json, robot-1-controls.csv, sensor-1.csv
    post 1 at [2.99 1.99] m, 1 sigma 0.01 m
    post 2 at [ 5.99 -1.5 ] m, 1 sigma 0.02 m
"""

import tempfile
from pathlib import Path

import numpy as np

from ekfslam_tutorial.models.motion import Unicycle
from ekfslam_tutorial.models.sensors import RangeBearing
from ekfslam_tutorial.toolbox import ControlLog, RawLog, Recording, Robot, Sensor, UserData, universal_slam

# Ten seconds, ten frames a second: a robot drives ahead at 0.5 m/s, and its laser sees two posts.
rng, n = np.random.default_rng(10), 100
t = 0.1 * np.arange(n)
controls = np.column_stack([np.full(n, 0.5), np.zeros(n)]) + rng.normal(0, [0.02, 0.01], (n, 2))
posts = np.array([[3.0, 2.0], [6.0, -1.5]])
rows = []
for k in range(n):
    d = posts - [0.05 * k, 0]
    rows += [[k, i + 1, np.hypot(*d[i]), np.arctan2(*d[i][::-1])] for i in range(2)]
table = np.array(rows)
y = table[:, 2:] + rng.normal(0, [0.05, 0.01], (len(table), 2))

recording = Recording(
    name="a corridor",
    t=t,
    robots={1: ControlLog(controls)},
    raw={1: RawLog(1, np.searchsorted(table[:, 0], np.arange(n + 1)), table[:, 1].astype(int), y, None)},
)
with tempfile.TemporaryDirectory() as folder:
    recording.save(Path(folder, "corridor"))  # a folder of CSV files; a name that ends in .npz is one file
    files = sorted(p.name for p in Path(folder, "corridor").iterdir())
    recording = Recording.load(Path(folder, "corridor"))
print(", ".join(files))

robot = Robot(motion=Unicycle(), position=[0, 0], control_std={"v": 0.02, "w_deg": 0.6})
data = UserData(robots=[robot], sensors=[Sensor(model=RangeBearing(0.05, 0.01))])
for now in universal_slam(data, recording):
    pass
for id, lmk in now.lmks.items():
    p, P = lmk.point(now.map)
    print(f"post {id} at {p.round(2)} m, 1 sigma {np.sqrt(np.trace(P)):.2f} m")
