"""The user's robots and sensors: what one can say about them, and the same in SI units and radians."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ...models import Calibrated
from ...models.motion import Odometry2
from ...simulation import MOST_CLUTTER
from ..user_input import (
    check_id,
    check_model,
    covariance_stack,
    finite_array,
    is_whole,
    short_text,
    sized_vector,
    std_vector,
)
from .poses import n_angles, pose

MOST_NUMBERS = 4096
"""Of a descriptor."""


def _si(name, value):
    return np.deg2rad(value) if name.endswith("_deg") else value


def check_factor(value):
    """Refuse a factor of a covariance that is no positive number."""
    if finite_array("noise_factor", value).ndim or not value > 0:
        raise ValueError(f"noise_factor must be a positive number, got {short_text(value)}")


@dataclass(kw_only=True)
class Robot:
    """A robot (manual: Robot{}).

    Parameters
    ----------
    id, name, type : int, str, str
        The type is the body to draw and a word for the reader.
    motion : MotionModel
    in_map : bool
        False: its pose is known, at every instant; the run is mapping, as in the lecture.
    position : sequence of float, optional
        Start, metres. Not given: the first true pose of a recording, or the origin.
    orientation_deg : float or sequence of 3 float, optional
        Heading; in space roll, pitch and yaw.
    position_std, orientation_std_deg : float or sequence
        How well the start is known. The simulator draws the true start with them.
    state, state_std : dict
        Start of what the motion model has beyond the pose, by its `state_fields`: {"vel": [1, 0, 0]}.
    control : dict
        By the model's `control_fields`: {"dx": [0.08, 0, 0], "da_deg": [0, 0, 0.9]}; a list of rows instead of one row
        is one row for each frame, from the beginning again when it is through.
    control_std : dict
        Standard deviation of its noise: {"dx": 0.005, "da_deg": 0.05}.
    control_cov : sequence of sequences, optional
        Covariance of the whole control in SI units and radians, instead of `control_std`.
    noise_factor : float
        The filter is told the control's covariance U times this, be it the scenario's or a recording's. The simulator
        draws with U.
    clock_offset : float
        Of a recording: its controls take effect so many seconds later than they are stamped.
    """

    id: int = 1
    name: str = ""
    type: str = ""
    motion: Any = field(default_factory=Odometry2)
    in_map: bool = True
    position: Any = None
    orientation_deg: Any = None
    position_std: Any = 0.0
    orientation_std_deg: Any = 0.0
    state: dict = field(default_factory=dict)
    state_std: dict = field(default_factory=dict)
    control: dict = field(default_factory=dict)
    control_std: dict = field(default_factory=dict)
    control_cov: Any = None
    noise_factor: float = 1.0
    clock_offset: float = 0.0

    def __post_init__(self):
        check_id("id", self.id)
        check_factor(self.noise_factor)
        if finite_array("clock_offset", self.clock_offset).ndim:
            raise ValueError(f"clock_offset must be a number of seconds, got {short_text(self.clock_offset)}")
        check_model("motion", self.motion, "motion")
        self.start()
        self.controls()
        self.U()

    @property
    def frame(self):
        """Frame2 or Frame3."""
        return self.motion.frame

    def _fields(self, group, fields, read):
        """The values of some fields of the motion model, each as `read` reads it, in SI units: a list of arrays."""
        table = getattr(self, group)
        for name in table:
            if name not in fields:
                possible = ", ".join(fields) or "none"
                raise ValueError(f"{group} has no {name!r}; {type(self.motion).__name__} has: {possible}")
        key = std_key if group.endswith("_std") else str
        return [_si(name, read(key(name), table.get(name), n)) for name, n in fields.items()]

    def start(self, noise=None):
        """State at the start and its covariance.

        Parameters
        ----------
        noise : ndarray, optional
            White noise, one number for each degree of freedom: the state is then a draw around the start.

        Returns
        -------
        x : ndarray, shape (motion.size,)
        P : ndarray, shape (motion.size, motion.size)
        """
        extra = _joined(self._fields("state", self.motion.state_fields, _zeros_or_vector))
        std = _joined(self._fields("state_std", self.motion.state_fields, std_vector))
        x, P = _start_pose(self, self.frame, None if noise is None else noise[: self.frame.dof])
        if noise is not None:
            extra = extra + std * noise[self.frame.dof :]
        n = self.frame.size
        P_xx = np.zeros((self.motion.size, self.motion.size))
        P_xx[:n, :n], P_xx[n:, n:] = P, np.diag(std**2)
        return np.concatenate([x, extra]), P_xx

    @property
    def dof(self):
        """Degrees of freedom of the state."""
        return self.frame.dof + self.motion.size - self.frame.size

    def controls(self):
        """The control of each frame in SI units, shape (rows, nu): row k mod rows is that of frame k."""
        columns = self._fields("control", self.motion.control_fields, _control_rows)
        lengths = {len(rows) for rows in columns} - {1}
        if len(lengths) > 1:
            raise ValueError(
                f"the lists of controls must have one row, or as many as each other, got {sorted(lengths)}"
            )
        length = max(lengths, default=1)
        return np.concatenate([np.broadcast_to(rows, (length, rows.shape[1])) for rows in columns], axis=1)

    def U(self, dt=None):
        """Covariance of the control noise in SI units, shape (nu, nu).

        Where the user says nothing of it, and the motion model has a `noise` of its own, it is that over `dt` seconds.
        """
        if dt is not None and self.control_cov is None and not self.control_std and hasattr(self.motion, "noise"):
            return self.motion.noise(dt) if dt > 0 else 0 * self.motion.noise(1.0)
        std = _joined(self._fields("control_std", self.motion.control_fields, std_vector))
        if self.control_cov is None:
            with np.errstate(over="ignore"):
                return covariance_stack("the squared standard deviations of the control", [np.diag(std**2)], len(std))[
                    0
                ]
        if self.control_std:
            raise ValueError("control_cov is given as well as standard deviations of the control; give one of them")
        return covariance_stack("control_cov", [self.control_cov], len(std))[0]


def std_key(name):
    """The key of a standard deviation: dx -> dx_std, da_deg -> da_std_deg."""
    return f"{name.removesuffix('_deg')}_std_deg" if name.endswith("_deg") else f"{name}_std"


def _joined(parts):
    return np.concatenate([np.zeros(0), *parts])


def _zeros_or_vector(what, value, size):
    return sized_vector(what, value, size, np.zeros(size))


def _control_rows(name, value, size):
    """Control values of one field: one row for all frames, or a row for each; shape (rows, size)."""
    a = finite_array(name, np.zeros(size) if value is None else value)
    rows = a.reshape(-1, 1) if size == 1 else np.atleast_2d(a)
    if a.ndim > 2 or rows.shape[1] != size or not len(rows) or (size == 1 and a.ndim == 2 and a.shape[1] != 1):
        raise ValueError(f"{name} must be {size} number{'s' * (size > 1)}, or rows of them, got {short_text(value)}")
    return rows


def _start_pose(entry, frame, noise=None):
    """Pose of a robot or sensor at the start, or a draw around it, and the covariance of its state vector."""
    p, a = sized_vector("position", entry.position, frame.dim, np.zeros(frame.dim)), n_angles(frame)
    angles = np.deg2rad(sized_vector("orientation_deg", entry.orientation_deg, a, np.zeros(a)))
    std = np.concatenate(
        [
            std_vector("position_std", entry.position_std, frame.dim),
            np.deg2rad(std_vector("orientation_std_deg", entry.orientation_std_deg, a)),
        ]
    )
    e = np.concatenate([p, angles])
    x, X_e = pose(frame, e if noise is None else e + std * noise)
    return x, (X_e * std**2) @ X_e.T


@dataclass(kw_only=True)
class Sensor:
    """A sensor on a robot (manual: Sensor{}).

    Parameters
    ----------
    id, name : int, str
    robot : int
        Id of the robot that carries it.
    model : SensorModel
        With its parameters (manual: `par`).
    position, orientation_deg : sequence of float, optional
        Where it is mounted, in the robot's frame: metres; heading, or roll, pitch and yaw.
    position_std, orientation_std_deg : float or sequence
        How well that is known. The simulator draws the true mounting with them.
    landmark : LmkType, optional
        Type of the landmarks that this sensor starts, if not the scenario's.
    frame_in_map : bool
        True: the filter estimates its mounting (self-calibration; manual: frameInMap).
    orientation_walk_deg : float
        With that: the mounting gives way, a random walk of each of its angles, deg/sqrt(s).
    params_in_map : sequence of str
        Parameters that the filter estimates: those that the model lists in `parameters` (the lens `k` and `d` of a
        camera), the `bias` of any measurement, and, on a robot with a velocity, the `delay` of its stamps in seconds.
        Where the mounting is not estimated, it stands before them in the map, known.
    params_std : dict
        How well they are known: {"k": [0, 0, 30, 30]}; zero, if not said. The simulator draws the true ones with it.
    params_walk : dict
        Random walks that they make, each in its unit per sqrt(s); zero, if not said.
    p_detect : float
        Simulation: probability that a visible landmark is measured.
    clutter : float
        Simulation: mean number of false measurements in a frame.
    descriptor_size : int
        Simulation: so many numbers tell what each measurement looks like; 0: none do. Landmarks look like white noise.
    descriptor_std : float
        Simulation: noise of each of them.
    noise_factor : float
        The filter is told the noise covariance R times this, be it the sensor's or a recording's own. The simulator
        draws with R.
    bias : sequence of float, optional
        Of a recording: its measurements are so much too large; SI units and radians.
    lasting : float
        Of a recording: the share of the noise's variance that does not change while the robot stands still, 0 to 1.
        Of n sightings of a landmark from one place each has R times 1 + (n - 1) lasting: with 1 they count as one.
    """

    id: int = 1
    robot: int = 1
    name: str = ""
    model: Any
    position: Any = None
    orientation_deg: Any = None
    position_std: Any = 0.0
    orientation_std_deg: Any = 0.0
    landmark: Any = None
    frame_in_map: bool = False
    orientation_walk_deg: float = 0.0
    params_in_map: Any = ()
    params_std: dict = field(default_factory=dict)
    params_walk: dict = field(default_factory=dict)
    p_detect: float = 1.0
    clutter: float = 0.0
    descriptor_size: int = 0
    descriptor_std: float = 0.2
    noise_factor: float = 1.0
    bias: Any = None
    lasting: float = 0.0

    def __post_init__(self):
        check_id("id", self.id)
        check_id("robot", self.robot)
        check_model("model", self.model, "sensor")
        if self.landmark is not None:
            check_model("landmark", self.landmark, "landmark")
        if not 0 < finite_array("p_detect", self.p_detect) <= 1:
            raise ValueError(f"p_detect is a probability above 0, got {self.p_detect}")
        if not finite_array("clutter", self.clutter) >= 0:
            raise ValueError(f"clutter is a mean number and must not be negative, got {self.clutter}")
        if self.clutter > MOST_CLUTTER:
            raise ValueError(f"clutter is a mean number in a frame, {MOST_CLUTTER} at most, got {self.clutter:g}")
        name = f"the noise covariance R of {type(self.model).__name__}"
        try:
            covariance_stack(name, [self.model.R], len(self.model.R))
        except OverflowError:
            raise ValueError(f"{name} must be finite") from None
        check_factor(self.noise_factor)
        if finite_array("lasting", self.lasting).ndim or not 0 <= self.lasting <= 1:
            raise ValueError(f"lasting is a share, from 0 to 1, got {short_text(self.lasting)}")
        walk = self.orientation_walk_deg
        if finite_array("orientation_walk_deg", walk).ndim or not walk >= 0:
            raise ValueError(f"orientation_walk_deg must be 0 or more degrees, got {short_text(walk)}")
        if walk and not self.frame_in_map:
            raise ValueError("orientation_walk_deg is of a mounting that is estimated: write frame_in_map = true")
        self.biases()
        self._check_params()
        if not is_whole(self.descriptor_size) or not 0 <= self.descriptor_size <= MOST_NUMBERS:
            got = short_text(self.descriptor_size)
            raise ValueError(f"descriptor_size must be a whole number, 0 to {MOST_NUMBERS}, got {got}")
        if finite_array("descriptor_std", self.descriptor_std).ndim or not self.descriptor_std >= 0:
            raise ValueError(f"descriptor_std must be 0 or more, got {short_text(self.descriptor_std)}")

    def _check_params(self):
        """Refuse parameters that cannot be estimated, and what is said of others."""
        names = self.params_in_map
        if not isinstance(names, list | tuple) or not all(isinstance(name, str) for name in names):
            raise ValueError(f"params_in_map must be a list of names, got {short_text(names)}")
        for name in (name for group in (self.params_std, self.params_walk) for name in group):
            if name not in names:
                raise ValueError(f"{name} is no state, so nothing can be said of it: write params_in_map = [{name!r}]")
        self.params()
        if self.clutter and hasattr(self.model, "without_lmks"):
            raise ValueError(f"clutter: {type(self.model).__name__} sees no landmarks, so it takes nothing for one")

    @property
    def in_map(self):
        """True if something of it is estimated: its mounting, or parameters."""
        return self.frame_in_map or bool(self.params_in_map)

    @property
    def seen_as(self):
        """The model as the filter has it: with the parameters that are states."""
        return Calibrated(self.model, tuple(self.params_in_map)) if self.params_in_map else self.model

    def params(self):
        """Values of the parameters that are states, standard deviations and random walks, each shape (k,)."""
        if not self.params_in_map:
            return (np.zeros(0),) * 3
        a, given = self.seen_as.start, []
        for group, ending in ((self.params_std, "std"), (self.params_walk, "walk")):
            parts = [
                std_vector(f"{n}_{ending}", group.get(n, 0.0), at.stop - at.start)
                for n, at in self.seen_as.slices().items()
            ]
            given.append(np.concatenate(parts))
        return a, *given

    def biases(self):
        """The bias of each number that it measures, shape (m,)."""
        m = len(self.model.R)
        return sized_vector("bias", self.bias, m, np.zeros(m))

    def start(self, frame, noise=None):
        """State on a robot whose frames are of class `frame`, and its covariance; or a draw around it.

        The frame, and parameters that are states behind it. What is known and not estimated has no covariance.
        """
        x, P = _start_pose(self, frame, None if noise is None else noise[: frame.dof])
        if not self.params_in_map:
            return x, P
        (a, std, _), n = self.params(), frame.size
        whole = np.zeros((n + len(a),) * 2)
        whole[:n, :n], whole[n:, n:] = P * self.frame_in_map, np.diag(std**2)
        return np.concatenate([x, a if noise is None else a + std * noise[frame.dof :]]), whole
