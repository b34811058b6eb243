"""The stochastic map and the few operations that an extended Kalman filter does on it.

Lives here: a mean, a covariance, ranges in them, and matrices.
May not: know what a range stands for. No frames, sensors, robots or landmarks here.
"""

from .covariances import check_covariance, real
from .filter import (
    Innovation,
    augment,
    carry,
    correct,
    covariance,
    cross,
    innovation,
    predict,
    transform,
    update,
)
from .stochastic_map import Map, MapFull

__all__ = [
    "Innovation",
    "Map",
    "MapFull",
    "augment",
    "carry",
    "check_covariance",
    "correct",
    "covariance",
    "cross",
    "innovation",
    "predict",
    "real",
    "transform",
    "update",
]
