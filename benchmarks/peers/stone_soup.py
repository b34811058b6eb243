"""Stone Soup: its ExtendedKalmanUpdater with one stacked measurement model; angles are its `Bearing`, as in its models.

It has no predictor for a map that stands still, so the two blocks that a motion changes are written by hand.

Its better way (`Tuned`): the model computes all landmarks at once; bearings are plain numbers, wrapped beforehand,
since with one `Bearing` in it K z is a product of Python objects; and the cache of its updater, which holds the last
128 predictions with their covariances, is emptied, so that their memory can be used again.
"""

import numpy as np
from stonesoup.base import Property
from stonesoup.models.base import GaussianModel
from stonesoup.models.measurement.nonlinear import NonLinearGaussianMeasurement
from stonesoup.types.angle import Bearing
from stonesoup.types.array import StateVector
from stonesoup.types.detection import Detection
from stonesoup.types.hypothesis import SingleHypothesis
from stonesoup.types.prediction import GaussianStatePrediction
from stonesoup.updater.kalman import ExtendedKalmanUpdater

from ..oracle import odometry, range_bearing
from ..world import R, U, wrap
from . import models


class SeenLandmarks(NonLinearGaussianMeasurement, GaussianModel):
    """Ranges and bearings of several landmarks, stacked."""

    ids: np.ndarray = Property(doc="Which landmarks")

    @property
    def ndim_meas(self):
        """Numbers in a measurement."""
        return 2 * len(self.ids)

    def function(self, state, noise=False, **kwargs):
        """Expected measurement."""
        x = np.asarray(state.state_vector, float)[:, 0]
        e = [range_bearing(x[:3], x[3 + 2 * i : 5 + 2 * i])[0] for i in self.ids]
        return measurement(e)

    def jacobian(self, state, **kwargs):
        """Its dense Jacobian."""
        x = np.asarray(state.state_vector, float)[:, 0]
        H = np.zeros((2 * len(self.ids), len(x)))
        for k, i in enumerate(self.ids):
            r = slice(3 + 2 * i, 5 + 2 * i)
            _, H[2 * k : 2 * k + 2, :3], H[2 * k : 2 * k + 2, r] = range_bearing(x[:3], x[r])
        return H


class StackedLandmarks(NonLinearGaussianMeasurement, GaussianModel):
    """The same without loops, in plain numbers; `at` is where each landmark begins in the state."""

    at: np.ndarray = Property(doc="Where the landmarks begin")

    @property
    def ndim_meas(self):
        """Numbers in a measurement."""
        return 2 * len(self.at)

    def function(self, state, noise=False, **kwargs):
        """Expected measurement."""
        return StateVector(models.expected(state.state_vector.view(np.ndarray)[:, 0], self.at))

    def jacobian(self, state, **kwargs):
        """Its dense Jacobian."""
        return models.jacobian(state.state_vector.view(np.ndarray)[:, 0], self.at)


def measurement(y):
    """Pairs [range, bearing] as a StateVector whose bearings are Bearings."""
    return StateVector([[v] for r, b in y for v in (r, Bearing(b))])


class StoneSoup:
    """The updater in a loop."""

    def __init__(self, world):
        self.world, self.n = world, len(world.x0)
        self.x, self.P = world.x0.copy(), world.P0.copy()
        self.updater = ExtendedKalmanUpdater(measurement_model=None)

    def step(self, k):
        """One step."""
        step = self.world.steps[k % len(self.world.steps)]
        x, P = self.moved(step.u)
        model = SeenLandmarks(
            ndim_state=self.n,
            mapping=np.arange(self.n),
            noise_covar=np.kron(np.eye(len(step.ids)), R),
            ids=step.ids,
        )
        prediction = GaussianStatePrediction(StateVector(x), P)
        detection = Detection(measurement(step.y), measurement_model=model)
        posterior = self.updater.update(SingleHypothesis(prediction, detection))
        self.x = np.asarray(posterior.state_vector, float)[:, 0]
        self.x[2] = wrap(self.x[2])
        self.P = np.array(posterior.covar)

    def moved(self, u):
        """State after the motion, written in place."""
        x, P = self.x, self.P
        x[:3], F, G = odometry(x[:3], u)
        P[:3] = F @ P[:3]
        P[:, :3] = P[:, :3] @ F.T
        P[:3, :3] += G @ U @ G.T
        return x, P

    def state(self):
        """Mean and covariance."""
        return self.x.copy(), self.P.copy()


class Tuned(StoneSoup):
    """The same updater by a user who has looked for what it spends."""

    def __init__(self, world):
        super().__init__(world)
        self.mapping = np.arange(self.n)

    def step(self, k):
        """One step."""
        step = self.world.steps[k % len(self.world.steps)]
        x, P = self.moved(step.u)
        at = 3 + 2 * step.ids
        noise = models.noise(len(at))
        model = StackedLandmarks(ndim_state=self.n, mapping=self.mapping, noise_covar=noise, at=at)
        e = models.expected(x, at)
        y = e + models.residual(step.y.ravel(), e)  # the turn that is nearest to what is expected
        prediction = GaussianStatePrediction(StateVector(x), P)
        detection = Detection(StateVector(y), measurement_model=model)
        posterior = self.updater.update(SingleHypothesis(prediction, detection))
        ExtendedKalmanUpdater.predict_measurement.cache_clear()
        self.x, self.P = posterior.state_vector.view(np.ndarray)[:, 0], posterior.covar.view(np.ndarray)
        self.x[2] = wrap(self.x[2])
