"""Small scenes for the tests of the steps: a robot with a sensor in the plane, a robot with a camera in space."""

from types import SimpleNamespace

import numpy as np

from ekfslam_tutorial.ekf import Map
from ekfslam_tutorial.geometry import Frame2, Frame3, e2q
from ekfslam_tutorial.models.landmarks import AhmPnt, EucPnt, IdpPnt
from ekfslam_tutorial.models.motion import Odometry2, Odometry3
from ekfslam_tutorial.models.sensors import PinHole, RangeBearing
from ekfslam_tutorial.slam import Lmk, Options, Rob, Sen, place

FORWARD = np.concatenate([[0.0, 0.0, 0.0], e2q(np.radians([-90, 0, -90]))[0]])  # a camera that looks ahead
SMALL7 = np.diag([1e-4] * 3 + [0.0] + [1e-5] * 3)


def raw(ids, y, R=None):
    """Raw measurements, as a sensor hands them over."""
    ids, y = np.asarray(ids, int), np.asarray(y, float)
    return SimpleNamespace(ids=ids, y=y, R=R)


class Scene:
    """A map, one robot, one sensor, landmarks.

    Parameters
    ----------
    d : int
        2 or 3.
    pose, P : ndarray
        Of the robot; P None if it is known.
    sensor : SensorModel
    sensor_P : ndarray, optional
        Covariance of the sensor's frame, for self-calibration.
    capacity : int, optional
    options : dict
        For `Options`.
    """

    def __init__(self, d=2, pose=None, P=None, sensor=None, sensor_P=None, capacity=None, **options):
        frame, motion = (Frame2, Odometry2()) if d == 2 else (Frame3, Odometry3())
        self.map = Map(capacity)
        self.rob = Rob(1, motion, U=1e-6 * np.eye(frame.dof), sensors=[1])
        self.sen = Sen(1, 1, sensor or (RangeBearing(0.05, 0.01) if d == 2 else PinHole()), frame)
        pose = np.eye(7)[3] if pose is None and d == 3 else np.zeros(3) if pose is None else np.asarray(pose, float)
        place(self.map, self.rob, pose, P)
        place(self.map, self.sen, np.zeros(3) if d == 2 else FORWARD, sensor_P)
        self.lmks, self.obs = {}, {}
        self.opt = Options(**{"lmk_type": EucPnt(d)} | options)

    def add(self, id, p, P=None, kind=None):
        """A landmark at p: known, or in the map with covariance P."""
        kind, slot = kind or self.opt.lmk_type, len(self.lmks)
        if P is None:
            self.lmks[id] = Lmk(id, kind, x=np.asarray(p, float), slot=slot)
        else:
            self.lmks[id] = Lmk(id, kind, r=self.map.add(p, P), slot=slot)
        return self.lmks[id]

    def see(self, points, noise=0.0, rng=None, pose=None):
        """Raw measurements of points by id, from the robot's pose (the estimated one, unless another is given)."""
        F = self.rob.frame(self.map) if pose is None else self.rob.motion.frame(np.asarray(pose, float))
        p = self.sen.frame(self.map).to_frame(F.to_frame(np.array(list(points.values())))[0])[0]
        y = self.sen.model.project(p)[0]
        if rng is not None:
            y = y + noise * rng.normal(size=y.shape) @ np.sqrt(self.sen.model.R)
        return raw(list(points), self.sen.model.residual(y, np.zeros(y.shape[-1])))

    @property
    def all(self):
        """Arguments that most steps begin with."""
        return self.map, self.rob, self.sen, self.lmks


def mixed_scene(rng, **options):
    """A camera and landmarks of three types, some estimated and some known."""
    scene = Scene(d=3, P=SMALL7, sensor=PinHole(d=(-0.3, 0.1)), **options)
    for id in range(1, 13):
        p = rng.uniform([4, -1, -1], [8, 1, 1])
        kind = (EucPnt(), IdpPnt(), AhmPnt())[id % 3]
        l = kind.from_point(p)[0]
        B = 0.01 * rng.normal(size=(len(l), len(l)))
        scene.add(id, l, None if id % 4 == 0 else B @ B.T, kind)
    return scene


def kinds(events):
    """Events in short: (kind, landmark)."""
    return [(event.kind, event.lmk) for event in events]
