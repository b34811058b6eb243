"""PythonRobotics' SLAM/EKFSLAM/ekf_slam.py, from a checkout: it is no package, and its code is not part of this one.

`as is` searches the landmark of each measurement among all; `known ids` is told it, as a user would change it. It has
no joint correction; `joint` is one by a user who stacks what its own functions give for each measurement. Only its
correction can be compared with the oracle: its motion is another one, and (in the version that was measured) predicts
the robot's own block of P and leaves the cross-covariances as they are.
"""

import importlib.util
import math

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


class Joint(PythonRobotics):
    """Its prediction, innovations and Jacobians; all measurements of a step in one correction."""

    def __init__(self, world, path):
        super().__init__(world, path, known_ids=True)
        self.module.ekf_slam = self.ekf_slam
        self.noise = np.kron(np.eye(world.m), self.module.Cx[:2, :2])

    def ekf_slam(self, x, P, u, z):
        """As its function of this name, with one correction."""
        its = self.module
        G, Fx = its.jacob_motion(x[:3], u)
        x[:3] = its.motion_model(x[:3], u)
        P[:3, :3] = G.T @ P[:3, :3] @ G + Fx.T @ its.Cx @ Fx
        y, H = np.zeros((2 * len(z), 1)), np.zeros((2 * len(z), len(x)))
        for k, i in enumerate(self.queue):
            delta = its.get_landmark_position_from_state(x, i) - x[:2]
            q, rows = (delta.T @ delta)[0, 0], slice(2 * k, 2 * k + 2)
            bearing = its.pi_2_pi(math.atan2(delta[1, 0], delta[0, 0]) - x[2, 0])
            y[rows, 0] = z[k, 0] - math.sqrt(q), its.pi_2_pi(z[k, 1] - bearing)
            H[rows] = its.jacob_h(q, delta, x, i + 1)
        HP = H @ P
        K = (P @ H.T) @ np.linalg.inv(HP @ H.T + self.noise)
        x = x + K @ y
        P = P - K @ HP
        x[2] = its.pi_2_pi(x[2])
        return x, P
