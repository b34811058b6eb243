"""How the robot of a log moves: its motion model, its controls and their noise, in the plane and in space."""

import numpy as np

from ...geometry import Frame2, Frame3, e2q, q2v, wrap
from ...models.motion import Imu
from ...models.motion.odometry3 import screw
from ...toolbox.messages import Control
from ..euroc_v101 import WINDOW, controls_between, start
from ..odometry import OdometryNoise
from . import looks
from .heading import Compass
from .meaning import PLANE, SPACE
from .scans import scatter

STEP_NOISE = OdometryNoise(along=0.05, across=0.02, turn=0.05, drift=0.01)
"""Of an odometry that gives steps or poses; speeds have a noise of their own in the scenario."""
SHARE = 0.1
"""Speeds are taken for wrong by this share of their usual size, at least: wheels slip, all the same way."""
LEAST = {"v": 0.02, "w": 0.01}
"""No noise is taken for smaller than this: m/s, rad/s."""
SHAKEN = {"gyro_noise": 5e-4, "acc_noise": 1e-2}
"""No density of an IMU on a robot is taken for smaller: rad/s and m/s^2 per sqrt(Hz)."""
NOT_DOWN = 0.5
"""An accelerometer at rest whose size is off by more than this does not measure gravity alone, m/s^2."""


def way_of(log):
    """The columns by which the odometry says what the robot did.

    Raises
    ------
    ValueError
        It does not say so.
    """
    odo = set(log.parts["odometry"])
    ways = SPACE if log.space else PLANE
    for way in ways["odometry"]:
        if way <= odo:
            return way
    raise ValueError(
        f"odometry: {', '.join(sorted(odo - {'t'})) or 'the time'} alone does not say how the robot moves; v and w, "
        "v and steer (with wheelbase, m), v and theta, dx and dtheta, x, y and theta, or left and right (with base, m) "
        "are needed" + "; in space twists, steps, poses or an IMU will do, too" * log.space
    )


def speeds(log):
    """Speed forward and turn rate of a robot in the plane, m/s and rad/s."""
    odo = log.parts["odometry"]
    if "w" in odo:
        return odo["v"], odo["w"]
    if "steer" in odo:  # of the middle of the rear axle
        length = _told(
            log, "wheelbase", "an angle of steering needs wheelbase, from the rear axle to the front one in m"
        )
        ratio = log.plan["odometry"].get("steering_ratio", 1.0)
        if not isinstance(ratio, int | float) or not 1 <= ratio < np.inf:
            raise ValueError(
                f"odometry: steering_ratio, turns of the steering wheel to one of the road wheels, must be "
                f"a number from 1, got {ratio!r}"
            )
        return odo["v"], odo["v"] * np.tan(odo["steer"] / ratio) / length
    if "v" in odo:  # and a heading: its turn since the row before
        return odo["v"], np.append(0.0, wrap(np.diff(odo["theta"])) / np.diff(odo["t"]))
    base = _told(log, "base", "speeds of wheels need base, how far they are apart in m")
    left, right = odo["left"], odo["right"]
    if "radius" in log.plan["odometry"] or looks.turning(log.plan["odometry"]):
        radius = _told(log, "radius", "wheels that tell how fast they turn need their radius in m")
        left, right = radius * left, radius * right
    return (left + right) / 2, (right - left) / base


def _told(log, key, words):
    """A length of the robot that the user says."""
    value = log.plan["odometry"].get(key)
    if not isinstance(value, int | float) or not 0 < value < np.inf:
        got = "" if value is None else f", got {value!r}"
        raise ValueError(f"odometry: {words}: --set odometry.{key}=...{got}")
    return value


def speed_noise(a, kind):
    """Standard deviation of a speed of the log: its scatter, and a share of its usual size."""
    return max(SHARE * float(np.quantile(np.abs(a), 0.9)), np.nan_to_num(scatter(a)), LEAST[kind])


class InPlane:
    """A robot in the plane.

    Parameters
    ----------
    log : Log
    """

    by_imu = False

    def __init__(self, log):
        self.log, self.way, odo = log, way_of(log), log.parts["odometry"]
        north = log.plan["odometry"].get("compass") and "theta" in odo and "x" not in self.way
        self.compass = Compass(odo, log.parts["scan"]["t"]) if north else None

    def robot(self):
        """Table of the robot, with its noise."""
        if not self.way & {"v", "left"}:
            return {"motion": "odometry2"}
        v, w = (speed_noise(a, kind) for a, kind in zip(speeds(self.log), "vw", strict=True))
        if self.compass and self.told:
            w = self.compass.turn_rate_std
        return {"motion": "unicycle", "v_std": round(v, 3), "w_std_deg": round(float(np.rad2deg(w)), 2)}

    @property
    def told(self):
        """Keys of the noise that the log tells by itself, and no fit should move."""
        return ["w_std_deg"] if self.compass and self.way == {"v", "theta"} else []

    def controls(self, robot=1):
        """Controls, each until its time."""
        t, first = np.unique(self.log.parts["odometry"]["t"], return_index=True)
        if self.way & {"v", "left"}:
            return [Control(a, u, robot) for a, u in zip(t, np.column_stack(speeds(self.log))[first], strict=True)]
        odo = {m: a[first] for m, a in self.log.parts["odometry"].items()}
        if "dx" in self.way:
            steps = np.column_stack([odo["dx"], odo.get("dy", 0 * t), odo["dtheta"]])
        else:
            poses = np.column_stack([odo["x"], odo["y"], odo["theta"]])
            way = Frame2(poses[:-1]).to_frame(poses[1:, :2])[0] if len(t) > 1 else np.zeros((0, 2))
            steps = np.vstack([np.zeros(3), np.column_stack([way, wrap(np.diff(poses[:, 2]))])])
        dt = np.diff(t, prepend=self.log.t0)
        far, turn = np.linalg.norm(steps[:, :2], axis=1), np.abs(steps[:, 2])
        q = STEP_NOISE
        var = np.column_stack([q.along**2 * far, q.across**2 * far, q.turn**2 * turn + q.drift**2 * dt]) + 1e-10
        return [Control(a, u, robot, np.diag(v)) for a, u, v in zip(t, steps, var, strict=True)]


class InSpace:
    """A robot in space: its controls are steps [dx; da], by twists, steps or poses, or what an IMU measures.

    Parameters
    ----------
    log : Log
    """

    def __init__(self, log):
        self.log, self.compass, self.told = log, None, []
        self.way: set = way_of(log) if "odometry" in log.parts else set()
        self.by_imu = "ax" in self.way

    def robot(self):
        """Table of the robot, with its noise."""
        if not self.way:
            self.log.said.append("no odometry: constant velocity; dv_std and dw_std_deg say how quickly it changes")
            stds = {"dv_std": 0.1, "dw_std_deg": 6.0, "vel_std": 0.5, "ang_vel_std_deg": 20.0}
            return {"motion": "constant_velocity"} | stds
        if not self.by_imu:
            return {"motion": "odometry3"}
        odo = self.log.parts["odometry"]
        step = float(np.median(np.diff(np.unique(np.asarray(odo["t"], float)))))
        of = {"gyro_noise": ("wx", "wy", "wz"), "acc_noise": ("ax", "ay", "az")}
        white = {key: max(np.nan_to_num(scatter(odo[m])) for m in columns) for key, columns in of.items()}
        noise = {key: round(max(std * np.sqrt(step), SHAKEN[key]), 6) for key, std in white.items()}
        return {"motion": "imu"} | noise

    def controls(self, robot=1):
        """Controls, each until its time; none of an IMU, which has many a frame, and without odometry."""
        if not self.way or self.by_imu:
            return []
        t, first = np.unique(self.log.parts["odometry"]["t"], return_index=True)
        dt = np.diff(t, prepend=self.log.t0)
        odo = {m: a[first] for m, a in self.log.parts["odometry"].items()}
        if self.way & {"v", "left", "vx"}:
            steps, var = self._by_speeds(odo, dt, first)
        else:
            steps = self._steps(odo)
            far, turn = np.linalg.norm(steps[:, :3], axis=1), np.linalg.norm(steps[:, 3:], axis=1)
            q = STEP_NOISE
            var = np.repeat([q.along**2 * far, q.turn**2 * turn + q.drift**2 * dt], 3, axis=0).T
        return [Control(a, u, robot, np.diag(v)) for a, u, v in zip(t, steps, var + 1e-10, strict=True)]

    def _by_speeds(self, odo, dt, first):
        """Steps of speeds that are held, and their variances."""
        nothing = np.zeros(len(dt))
        if "vx" in self.way:
            v, w = ([odo.get(f"{kind}{a}", nothing) for a in "xyz"] for kind in "vw")
        else:
            ahead, turn = (a[first] for a in speeds(self.log))
            v, w = [ahead, nothing, nothing], [nothing, nothing, turn]
        stds = np.array([speed_noise(a, kind) for kind, three in (("v", v), ("w", w)) for a in three])
        v, w = np.column_stack(v) * dt[:, None], np.column_stack(w) * dt[:, None]
        dx = np.array([screw(b) @ a for a, b in zip(v, w, strict=True)]).reshape(-1, 3)
        return np.hstack([dx, w]), (stds * dt[:, None]) ** 2

    def _steps(self, odo):
        if "dax" in self.way:
            return np.column_stack([odo[m] for m in ("dx", "dy", "dz", "dax", "day", "daz")])
        nothing = np.zeros(len(odo["t"]))
        if "dtheta" in self.way:
            turns = [nothing, nothing, odo["dtheta"]]
            return np.column_stack([odo["dx"], odo.get("dy", nothing), nothing, *turns])
        F = Frame3(poses(odo))
        before = Frame3(F.x[:-1]).inverse()[0]
        step, *_ = before.compose(Frame3(F.x[1:]))
        t, q = step.x[:, :3], step.x[:, 3:]
        q = q * np.where(q[:, :1] < 0, -1.0, 1.0)  # the shorter way round
        return np.vstack([np.zeros(6), np.column_stack([t, q2v(q)[0]])])

    def imu(self, times):
        """Controls of an IMU between frames, and the start: its state and covariance; words on it."""
        odo = self.log.parts["odometry"]
        rows = np.column_stack([odo[m] for m in ("t", "wx", "wy", "wz", "ax", "ay", "az")])
        rows = rows[np.unique(rows[:, 0], return_index=True)[1]]
        if rows[-1, 0] - rows[0, 0] < 2 * WINDOW:
            raise ValueError(
                f"odometry: the IMU lasts {rows[-1, 0] - rows[0, 0]:.2g} s; {2 * WINDOW:g} s are the least"
            )
        begun, words = start(rows, times[0] - rows[0, 0])
        gravity = np.linalg.norm(Imu().gravity)
        size = float(np.linalg.norm(rows[: max(1, len(rows) // 20), 4:].mean(0)))
        self.log.said.append(f"the IMU: {words}")
        if abs(size - gravity) > NOT_DOWN:
            self.log.said.append(
                f"  at the beginning it measures {size:.3g} m/s^2 and not {gravity:.3g}: it does not lie still, or "
                "gravity has been taken off; begin where it lies still"
            )
        return controls_between(rows, times), begun


def poses(part):
    """Frame vectors of poses in space, shape (n, 7): by quaternions, by roll, pitch and yaw, or by yaw alone."""
    nothing = np.zeros(len(part["x"]))
    t = np.column_stack([part["x"], part["y"], part.get("z", nothing)])
    if "qw" in part:
        q = np.column_stack([part[m] for m in ("qw", "qx", "qy", "qz")])
    else:
        q = e2q(np.column_stack([part.get(m, nothing) for m in ("roll", "pitch", "theta")]))[0]
    length = np.linalg.norm(q, axis=1, keepdims=True)
    if not (length > 0.5).all():
        raise ValueError(f"row {int(np.argmin(length)) + 1} has a quaternion of the length {length.min():.2g}, not 1")
    return np.hstack([t, q / length])
