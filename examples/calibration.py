"""Calibration: how a camera is mounted is put into the map, and gets known while the robot drives.

It prints

    frame   1: the camera's orientation is off by 2.41 deg
    frame  50: the camera's orientation is off by 0.56 deg
    frame 200: the camera's orientation is off by 0.42 deg
"""

import numpy as np

from ekfslam_tutorial.toolbox import UserData, universal_slam

SCENARIO = """
name = "a camera that was knocked"
seed = 8

[time]
last = 200

[world]
type = "cloister"

[[robot]]
motion = "odometry3"
position = [0, -5, 0]
dx = [0.08, 0, 0]
dx_std = 0.005
da_deg = [0, 0, 0.9]
da_std_deg = 0.05

[[sensor]]
type = "pin_hole_depth"
position = [0, 0, 0.6]
orientation_deg = [-90, 0, -90]
frame_in_map = true
orientation_std_deg = 5.0

[landmark]
type = "euc_pnt"
"""

for now in universal_slam(UserData.from_text(SCENARIO)):
    if now.k in (1, 50, 200):
        sen, true = now.sens[0], now.sim_sens[0].frame
        off = sen.frame(now.map).minus(true)[0][3:]
        print(f"frame {now.k:3}: the camera's orientation is off by {np.degrees(np.linalg.norm(off)):.2f} deg")
