"""Pictures: a log whose measurements are images, and the source of frames that the loop draws from it."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..recordings.logs import ControlLog, RawLog
from ..sources import Frame
from .picture import Picture


@dataclass
class Pictures:
    """A log of one robot with one camera: images, and nothing else to estimate from.

    It stands where a `Recording` stands, and has what others ask a recording for.

    Parameters
    ----------
    name : str
    frames : sequence of images
        With `t`, s, and `period`, s: one of `frames.Folder`, `Video`, `Webcam`, `Images`.
    target : Target, optional
        A rectangle of known size: looked for from the first image on, until it is found.
    forget : int, optional
        In this frame the target is deleted from the map.
    truth : dict of int to ndarray, shape (F, 7)
        True poses by robot id, NaN where not known.
    truth_std : tuple of 2 float
        How well these are known: metres, and radians about each axis.
    corners : ndarray, shape (4, 3), optional
        True places of the corners of the target.
    notes : list of str
    """

    name: str
    frames: Any
    target: Any = None
    forget: int | None = None
    truth: dict = field(default_factory=dict)
    truth_std: tuple = (0.0, 0.0)
    corners: Any = None
    notes: list = field(default_factory=list)

    robot, sensor = 1, 1
    by_event, landmarks, t0 = False, None, None

    def __post_init__(self):
        n = len(self.frames)  # nothing but images is in it
        self.robots = {self.robot: ControlLog(np.zeros((n, 6)))}
        self.raw = {self.sensor: RawLog(self.sensor, np.zeros(n + 1, int), np.zeros(0, int), np.zeros((0, 2)))}
        self.met, self.fixes, self.starts, self.names = {}, {}, {}, {}

    def __len__(self):
        return len(self.frames)

    @property
    def t(self):
        """Seconds since the first image, shape (F,)."""
        return self.frames.t

    def source(self, data):
        """The source of frames for a scenario."""
        return Watching(data, self)


class Watching:
    """Source of frames beside `Simulation` and `Replay`: images of one camera.

    The control of the robot is what the scenario says of a frame of the period of the camera. Over n periods its
    standard deviation is n times as large: an acceleration that is not known, as in MonoSLAM, lasts as long.

    Parameters
    ----------
    data : UserData
    log : Pictures

    Raises
    ------
    ValueError
        If the scenario has not the one robot and the one camera that the log is of.
    """

    sim_robs, sim_sens = (), ()

    def __init__(self, data, log):
        self.sim_lmk, self._log, self._data, self.starts = None, log, data, {}
        if [robot.id for robot in data.robots] != [log.robot] or [s.id for s in data.sensors] != [log.sensor]:
            raise ValueError(f"{log.name} is of one robot with one camera, both with the id 1; so must the scenario be")
        sensor = data.sensors[0]
        if not hasattr(sensor.model, "image_size") or sensor.noise_factor != 1 or np.any(sensor.biases()):
            what = type(sensor.model).__name__
            raise ValueError(
                f"{log.name} has images: sensor 1 must be a camera without noise_factor and bias, got {what}"
            )
        self._robot, self._u = data.robots[0], data.robots[0].controls()
        self._before = 0.0

    def n_frames(self, tim):
        """All images, or as many as the user wants."""
        last = self._data.time.last
        return len(self._log) if last is None else min(len(self._log), tim.last - tim.first + 1)

    def frame(self, i):
        """Image i. They must be asked for in order."""
        log = self._log
        image = log.frames[i]
        width, height = self._data.sensors[0].model.image_size
        if image.shape != (round(height), round(width)):
            raise ValueError(
                f"{log.name}: image {log.frames.numbers[i]} has {image.shape[1]} x {image.shape[0]} pixels, "
                f"but image_size is [{width:g}, {height:g}]"
            )
        t = float(log.t[i])
        dt, self._before = (t - self._before, t) if i else (0.0, t)
        periods = dt / self._data.time.dt
        control = self._u[i % len(self._u)] * periods, self._robot.U() * periods**2, dt
        picture = Picture(log.sensor, image, target=log.target, forget=i == log.forget)
        truth = {id: x[i] for id, x in log.truth.items()}
        return Frame(t, dt, {log.robot: control}, {log.sensor: picture}, truth)
