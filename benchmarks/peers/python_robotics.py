"""PythonRobotics' SLAM/EKFSLAM/ekf_slam.py, from a checkout: it is no package, and its code is not part of this one.

`as is` searches the landmark of each measurement among all; `known ids` is told it, as a user would change it. Only its
correction can be compared with the oracle: its motion is another one, and (in the version that was measured) predicts
the robot's own block of P and leaves the cross-covariances as they are.
"""

import importlib.util

import numpy as np

from ..world import R, U


def load(path):
    """The file as a module."""
    spec = importlib.util.spec_from_file_location("ekf_slam", path)
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    module.Cx = np.diag([R[0, 0], R[1, 1], U[2, 2]])
    try:
        module.jacob_motion(np.zeros((3, 1)), np.zeros((2, 1)))
    except ValueError:  # written for an older numpy, which took an array of one number for a number
        jacob_motion = module.jacob_motion
        module.jacob_motion = lambda x, u: jacob_motion(x, u[:, 0])
    return module


class PythonRobotics:
    """Its function `ekf_slam` on the benchmark's measurements."""

    def __init__(self, world, path, known_ids):
        self.module, self.world = load(path), world
        self.x, self.P = world.x0[:, None].copy(), world.P0.copy()
        self.module.M_DIST_TH = np.inf  # all landmarks are in the map: the nearest is the one, and none is new
        self.queue = []
        if known_ids:
            self.module.search_correspond_landmark_id = lambda x, P, z: self.queue.pop(0)

    def step(self, k):
        """One step: its velocities are those of a step of DT seconds."""
        step = self.world.steps[k % len(self.world.steps)]
        self.queue[:] = step.ids.tolist()
        u = np.array([[np.hypot(*step.u[:2])], [step.u[2]]]) / self.module.DT
        z = np.column_stack([step.y, step.ids])
        self.x, self.P = self.module.ekf_slam(self.x, self.P, u, z)

    def correct(self, step):
        """Its correction alone: a control of zero and no noise in the prediction."""
        noise, motion = self.module.Cx, self.module.jacob_motion
        self.queue[:] = step.ids.tolist()
        self.module.jacob_motion = lambda x, u: (np.eye(len(x)), np.zeros((3, len(x))))
        z = np.column_stack([step.y, step.ids])
        self.x, self.P = self.module.ekf_slam(self.x, self.P, np.zeros((2, 1)), z)
        self.module.Cx, self.module.jacob_motion = noise, motion

    def state(self):
        """Mean and covariance."""
        return self.x[:, 0].copy(), self.P.copy()
