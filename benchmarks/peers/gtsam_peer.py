"""GTSAM on the circuit: iSAM2 step by step, and one batch optimisation at the end. It smooths, without covariances."""

import gtsam
import numpy as np
from gtsam.symbol_shorthand import L, X

from ..oracle import inverse_range_bearing, odometry
from ..world import R, U

ODOMETRY = gtsam.noiseModel.Gaussian.Covariance(U)
SIGHT = gtsam.noiseModel.Diagonal.Sigmas(np.sqrt(np.diag(R))[::-1].copy())  # bearing, then range
START = gtsam.noiseModel.Isotropic.Sigma(3, 1e-4)


class Graph:
    """Factors and first guesses of each step, as both need them."""

    def __init__(self, world):
        self.world, self.known = world, set()
        self.pose, self.k = world.x0.copy(), 0

    def first(self):
        """Factors and guesses of the start."""
        factors, guess = gtsam.NonlinearFactorGraph(), gtsam.Values()
        factors.add(gtsam.PriorFactorPose2(X(0), gtsam.Pose2(*self.pose), START))
        guess.insert(X(0), gtsam.Pose2(*self.pose))
        return factors, guess

    def grow(self, step, factors, guess):
        """Add what one step brings; the guess of the pose is the last estimate and the odometry."""
        k = self.k = self.k + 1
        self.pose = odometry(self.pose, step.u)[0]
        factors.add(gtsam.BetweenFactorPose2(X(k - 1), X(k), gtsam.Pose2(*step.u), ODOMETRY))
        guess.insert(X(k), gtsam.Pose2(*self.pose))
        for i, y in zip(step.ids.tolist(), step.y, strict=True):
            factors.add(gtsam.BearingRangeFactor2D(X(k), L(i), gtsam.Rot2(y[1]), y[0], SIGHT))
            if i not in self.known:
                guess.insert(L(i), inverse_range_bearing(self.pose, y)[0])
                self.known.add(i)


class Isam2:
    """One update a step, and the estimate of the newest pose.

    Parameters
    ----------
    world : World
    partial : bool
        Its option `enablePartialRelinearizationCheck`: not the whole tree is looked through for what has moved. That is
        quicker in some sizes. Its other options were not, and its thresholds would change the estimate.
    """

    def __init__(self, world, partial=False):
        options = gtsam.ISAM2Params()
        options.enablePartialRelinearizationCheck = partial
        self.graph, self.isam = Graph(world), gtsam.ISAM2(options)
        self.isam.update(*self.graph.first())

    def step(self, k):
        """One step."""
        factors, guess = gtsam.NonlinearFactorGraph(), gtsam.Values()
        self.graph.grow(self.graph.world.steps[k], factors, guess)
        self.isam.update(factors, guess)
        pose = self.isam.calculateEstimatePose2(X(self.graph.k))
        self.graph.pose = np.array([pose.x(), pose.y(), pose.theta()])

    def pose(self):
        """Newest pose."""
        return self.graph.pose


class Batch:
    """All factors first, then one Levenberg-Marquardt optimisation in the last step."""

    optimizer = gtsam.LevenbergMarquardtOptimizer

    def __init__(self, world):
        self.graph = Graph(world)
        self.factors, self.guess = self.graph.first()

    def step(self, k):
        """One step."""
        steps = self.graph.world.steps
        self.graph.grow(steps[k], self.factors, self.guess)
        if k == len(steps) - 1:
            self.result = self.optimizer(self.factors, self.guess).optimize()

    def pose(self):
        """Newest pose."""
        pose = self.result.atPose2(X(self.graph.k))
        return np.array([pose.x(), pose.y(), pose.theta()])


class GaussNewton(Batch):
    """The same without damping: a tenth quicker, to the same estimate."""

    optimizer = gtsam.GaussNewtonOptimizer
