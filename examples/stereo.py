"""A stereo camera in space: the disparity gives the depth, so landmarks start as points.

It prints

    at  1.0 m a point is known to 0.02 m in depth
    at  4.0 m a point is known to 0.35 m in depth
    at 10.0 m a point is known to 2.21 m in depth
    36 landmarks, robot off by 1.8 cm
"""

import numpy as np

from ekfslam_tutorial.models.sensors import StereoPinHole
from ekfslam_tutorial.toolbox import UserData, universal_slam

SCENARIO = """
name = "stereo"
seed = 12

[time]
last = 120

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
type = "stereo_pin_hole"
position = [0, 0.1, 0.6]
orientation_deg = [-90, 0, -90]
baseline = 0.2
"""

camera = StereoPinHole(baseline=0.2)
for z in (1.0, 4.0, 10.0):
    V_y = camera.retro(camera.project(np.array([0.0, 0.0, z]))[0])[1]
    print(f"at {z:4.1f} m a point is known to {np.sqrt((V_y @ camera.R @ V_y.T)[2, 2]):.2f} m in depth")

for now in universal_slam(UserData.from_text(SCENARIO)):
    pass
error = np.linalg.norm(now.robs[0].frame(now.map).t - now.truth[1][:3])
print(f"{len(now.lmks)} landmarks, robot off by {100 * error:.1f} cm")
