"""The lecture's world: its true landmarks and path, and the path by odometry alone."""

from __future__ import annotations

import numpy as np

from ...datasets import lecture
from ...geometry import Frame2


def truth():
    """True landmarks of the lecture's log, by id."""
    return dict(zip((int(i) for i in lecture.true_landmarks()[0]), lecture.true_landmarks()[1], strict=True))


def true_path():
    """True poses of the lecture's log, shape (50, 3)."""
    return np.array([lecture.get_pose(k) for k in range(1, lecture.n_steps() + 1)])


def odometry_path():
    """The steps of the odometry, added up, shape (50, 3)."""
    F = [Frame2(lecture.get_pose(1))]
    for k in range(2, lecture.n_steps() + 1):
        F.append(F[-1].compose(Frame2(lecture.odometry(k)))[0])
    return np.array([f.x for f in F])
