"""Robotics Toolbox for Python: its EKF drives its own simulator, included here, and sees one landmark a step.

Its better way is `joseph=False`: P - K S K' instead of Joseph's form. It has no joint one.
Filling the map by driving would take longer than the whole benchmark, so the prior is written into its two fields.
"""

import numpy as np
from roboticstoolbox.mobile import EKF, LandmarkMap, RangeBearingSensor, Unicycle

from ..world import R


class RoboticsToolbox:
    """Its EKF for SLAM on the benchmark's landmarks, going round the benchmark's circle."""

    def __init__(self, world, joseph=True):
        V = np.diag([0.02, 0.005]) ** 2
        pose, after = world.steps[-1].pose, world.steps[0].pose
        speed, turn = np.hypot(*(after - pose)[:2]), 2 * np.pi / len(world.steps)
        robot = Unicycle(covar=V, x0=pose, dt=1.0, control=(speed, turn))
        sensor = RangeBearingSensor(
            robot, LandmarkMap(world.lmks.T, workspace=4 * np.abs(world.lmks).max()), covar=R, range=world.max_range
        )
        how = {"history": False, "joseph": joseph}
        self.ekf = EKF(robot=(robot, V), P0=world.P0[:3, :3], x0=pose, sensor=(sensor, R), **how)
        self.ekf.init()
        self.ekf._x_est, self.ekf._P_est = world.x0.copy(), world.P0.copy()
        self.ekf._landmarks = {i: [i, 1] for i in range(world.n_lmks)}

    def step(self, k):
        """One step."""
        self.ekf.step()

    def state(self):
        """Mean and covariance."""
        return self.ekf.x_est.copy(), self.ekf.P_est.copy()
