"""The true world in motion: robots that move, sensors that measure, with the models of the filter and no filter.

None of this is needed with the data of a real robot (manual, section 3.2): there a recording takes its place.
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..models import Moving, to_sensor
from ..models.landmarks import EucPnt
from ..models.observation import ItsRobot
from .streams import draw

MOST_CLUTTER = 10_000
"""False measurements in a frame, in the mean: more would fill the memory."""


@dataclass
class SimRob:
    """A robot as it really is.

    Parameters
    ----------
    id, name, type
        As in the user's file; `type` is the body to draw.
    motion : MotionModel
    x : ndarray, shape (motion.size,)
        True state.
    u : ndarray
        True control of the present frame.
    sensors : list of int
        Ids of the sensors it carries.
    """

    id: int
    name: str
    motion: Any
    x: np.ndarray
    u: np.ndarray
    sensors: list = field(default_factory=list)
    type: str = ""

    @property
    def frame(self):
        """True pose in the world."""
        return self.motion.frame(self.x[: self.motion.frame.size])


@dataclass(frozen=True)
class SimSen:
    """A sensor as it really is.

    Parameters
    ----------
    id, name, robot
        As in the user's file.
    frame : Frame2 or Frame3
        True pose in the robot's frame.
    model : SensorModel
    p_detect : float
        Probability that a visible landmark is measured.
    clutter : float
        Mean number of false measurements in a frame.
    """

    id: int
    name: str
    robot: int
    frame: Any
    model: Any
    p_detect: float = 1.0
    clutter: float = 0.0


@dataclass(frozen=True)
class SimLmk:
    """The true landmarks: points and, in space, straight edges.

    Parameters
    ----------
    ids : ndarray, shape (N,)
    points : ndarray, shape (N, 2) or (N, 3)
        Metres.
    segment_ids : ndarray, shape (M,)
        None of them is the id of a point.
    segments : ndarray, shape (M, 6)
        Both ends of each edge, [p1; p2].
    """

    ids: np.ndarray
    points: np.ndarray
    segment_ids: np.ndarray = field(default_factory=lambda: np.zeros(0, int))
    segments: np.ndarray = field(default_factory=lambda: np.zeros((0, 6)))

    @property
    def lims(self):
        """Smallest and largest coordinate on each axis, shape (d, 2)."""
        ends = self.segments.reshape(-1, 3) if len(self.segments) else self.points[:0]
        all = np.concatenate([self.points, ends])
        return np.stack([all.min(0), all.max(0)], -1)

    def seen_by(self, sensor):
        """Return ids and coordinates of what a sensor model can measure: its points, segments, or its robot (-1)."""
        if hasattr(sensor, "without_lmks"):
            return np.array([-1]), np.zeros((1, 0))
        return (self.segment_ids, self.segments) if hasattr(sensor, "segments") else (self.ids, self.points)

    @property
    def dims(self):
        """Length of the world on each axis."""
        return np.diff(self.lims)[:, 0]

    @property
    def center(self):
        """Middle of the world."""
        return self.lims.mean(-1)


@dataclass(frozen=True)
class SimObs:
    """Raw data of one sensor in one frame: what a real sensor would hand over.

    Parameters
    ----------
    sen : int
        Sensor id.
    ids : ndarray of int, shape (k,)
        Whose measurement it is; -1 where that is not known.
    y : ndarray, shape (k, m)
        Measurements.
    R : ndarray, shape (k, m, m), optional
        Noise covariance of each, where it differs from the sensor's.
    d : ndarray, shape (k, n), optional
        Descriptor of each: what it looks like.
    """

    sen: int
    ids: np.ndarray
    y: np.ndarray
    R: np.ndarray | None = None
    d: np.ndarray | None = None

    def __len__(self):
        return len(self.ids)


def sim_motion(rob, dt):
    """Move a robot by its true control: one step of `dt` seconds, no noise."""
    x = rob.motion.move(rob.x, rob.u, dt)[0]
    n = rob.motion.frame.size
    rob.x = np.concatenate([rob.motion.frame(x[:n]).normalized()[0].x, x[n:]])


def sim_observation(rob, sen, lmk, rng, clutter_rng=None):
    """Measure all visible landmarks with one sensor.

    Noise is drawn for every landmark of the world, seen or not: what a landmark's noise is does not depend on which
    others are in view, so that two runs that differ in one thing can be compared (common random numbers).

    Parameters
    ----------
    rob : SimRob
    sen : SimSen
    lmk : SimLmk
    rng : numpy.random.Generator
        Measurement noise.
    clutter_rng : numpy.random.Generator, optional
        Missed and false measurements; needed if the sensor has any.

    Returns
    -------
    SimObs
        By ascending position in `lmk`; false measurements come last, with id -1.
    """
    ids, points = lmk.seen_by(sen.model)
    y, seen = _measure(rob, sen, points, rng)
    n, ids, y = len(ids), ids[seen], y[seen]
    if clutter_rng is None:
        if sen.p_detect < 1 or sen.clutter > 0:
            raise ValueError(f"sensor {sen.id} misses measurements or makes false ones: a clutter_rng is needed")
        return SimObs(sen.id, ids, y)
    if sen.p_detect < 1:
        hit = clutter_rng.random(n)[seen] < sen.p_detect
        ids, y = ids[hit], y[hit]
    if sen.clutter > 0:
        false = _false_measurements(rob, sen, lmk, clutter_rng)
        ids, y = np.concatenate([ids, np.full(len(false), -1)]), np.concatenate([y, false])
    return SimObs(sen.id, ids, y)


def _measure(rob, sen, points, rng):
    """Noisy measurements of all points, and which of them the sensor can make."""
    if hasattr(sen.model, "segments"):
        return _measure_segments(rob, sen, points, rng)
    ps = _seen(rob, sen, points)
    with np.errstate(all="ignore"):  # a point in the plane of a camera has no image; it is not visible either
        y = sen.model.project(ps)[0]
        y = y + draw(rng, sen.model.R, (len(points),))
        y = sen.model.residual(y, np.zeros(y.shape[-1:]))  # the noise may have carried an angle beyond pi
        seen = np.asarray(sen.model.visible(y, ps), bool)
        return y, np.broadcast_to(seen, (len(points),))  # True alone: of all


def _seen(rob, sen, points):
    """Points in the frame of the sensor, and behind them what else it asks for; of each point a row."""
    if not hasattr(sen.model, "asks_robot") and not hasattr(sen.model, "without_lmks") and not hasattr(sen.frame, "a"):
        return sen.frame.to_frame(rob.frame.to_frame(points)[0])[0]
    Rf = Moving(rob.motion, rob.x, rob.u) if hasattr(sen.model, "asks_robot") else rob.frame
    kind = ItsRobot() if hasattr(sen.model, "without_lmks") else EucPnt(rob.frame.dim)
    return to_sensor(Rf, sen.frame, sen.model, kind, points)[0]


def _measure_segments(rob, sen, segments, rng):
    """The same of all segments [p1; p2]: of each, the part that the sensor sees."""
    pr = rob.frame.to_frame(segments.reshape(-1, 3))[0]
    y, seen = sen.model.segments(sen.frame.to_frame(pr)[0].reshape(-1, 6))
    return y + draw(rng, sen.model.R, (len(segments),)), seen


def _false_measurements(rob, sen, lmk, rng):
    """Measurements of things that are not there: points at random in the box of the world that the sensor could see.

    For a sensor of segments, edges between two of them. Of many random ones those in view are taken, up to a Poisson
    number with the mean `sen.clutter`.
    """
    if sen.clutter > MOST_CLUTTER:
        raise ValueError(f"sensor {sen.id}: clutter must be {MOST_CLUTTER} a frame at most, got {sen.clutter:g}")
    low, high = lmk.lims.T
    wanted = rng.poisson(sen.clutter)
    if hasattr(sen.model, "segments"):
        low, high = np.tile(low, 2), np.tile(high, 2)
    y, seen = _measure(rob, sen, rng.uniform(low, high, (50 * wanted + 50, len(low))), rng)
    return y[seen][:wanted]
