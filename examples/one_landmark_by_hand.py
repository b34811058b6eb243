"""One landmark by hand: a robot with a known pose sees one landmark three times, and the map corrects itself.

The filter knows blocks only: a range of the state, and the Jacobian of the expectation by it. A range of None is known.

It prints

    after 1: error 0.078 m, 1 sigma 0.132 m
    after 2: error 0.040 m, 1 sigma 0.093 m
    after 3: error 0.054 m, 1 sigma 0.076 m
"""

import numpy as np

from ekfslam_tutorial.ekf import Map, augment, correct, covariance, cross, innovation
from ekfslam_tutorial.geometry import Frame2
from ekfslam_tutorial.models import observe, retro_project
from ekfslam_tutorial.models.landmarks import EucPnt
from ekfslam_tutorial.models.sensors import RangeBearing

robot = Frame2(np.array([1.0, 2.0, 0.3]))  # known
mounting = Frame2(np.zeros(3))
sensor, kind = RangeBearing(range_std=0.1, bearing_std=0.02), EucPnt(2)
truth = np.array([4.0, 5.0])
exact = sensor.project(robot.to_frame(truth)[0])[0]
rng = np.random.default_rng(1)

map = Map()
for k in range(3):
    y = exact + rng.multivariate_normal(np.zeros(2), sensor.R)
    if k == 0:  # birth: the inverse observation model
        l, L_r, L_s, L_y, _ = retro_project(robot, mounting, sensor, kind, y, np.zeros(0))
        r = augment(map, l, ((None, L_r), (None, L_s)), L_y @ sensor.R @ L_y.T)
    else:  # correction: expectation, innovation, update
        e, _, _, E_l = observe(robot, mounting, sensor, kind, map.state(r))
        blocks = ((r, E_l),)
        PHt = cross(map, blocks)
        correct(map, PHt, innovation(sensor.residual(y, e), covariance(PHt, blocks), sensor.R))
    error = np.linalg.norm(map.state(r) - truth)
    print(f"after {k + 1}: error {error:.3f} m, 1 sigma {np.sqrt(np.trace(map.block(r))):.3f} m")
