"""The filters that notebook 03 judges: localisation, mapping and SLAM, each run many times at once with fresh noise.

All arrays carry the run as an axis. What a filter does wrong is an argument; the noise does not depend on it.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np

from ...analysis.consistency import md2
from ...datasets import lecture
from ...geometry import Frame2, wrap
from ...models.landmarks import EucPnt
from ...models.motion import Odometry2
from ...models.observation import observe, retro_project
from ...models.sensors import RangeBearing
from ...simulation import draw
from .. import fleet

POINT, AT_ROBOT = EucPnt(2), Frame2(np.zeros(3))
U = np.diag(lecture.ODOMETRY_STD**2)
T = fleet.T


def _poses():
    return np.array([lecture.get_pose(k) for k in range(1, lecture.n_steps() + 1)])


def _streams(seed):
    """One stream of noise for the motion and one for the sensor: common random numbers."""
    return [np.random.default_rng(s) for s in np.random.SeedSequence(seed).spawn(2)]


def _steps(poses):
    """True odometry between the poses."""
    return Frame2(poses[:-1]).inverse()[0].compose(Frame2(poses[1:]))[0].x


def _measure(rng, pose, points, runs):
    """Return which landmarks are in sight, and noisy measurements of all, shape (runs, N, 2)."""
    y = lecture.SENSOR.project(Frame2(pose).to_frame(points)[0])[0]
    return np.flatnonzero(y[:, 0] < lecture.SIGHT), y + draw(rng, lecture.SENSOR.R, (runs, len(points)))


# ---- localisation --------------------------------------------------------------------------------------------------


@cache
def localisation(runs=20, told=1.0, seed=3):
    """EKF localisation on the lecture's round: errors (50, runs, 3) and covariances (50, runs, 3, 3).

    `told` is the factor on all noise variances that the filter is told.
    """
    motion, sensing = _streams(seed)
    poses, points = _poses(), lecture.true_landmarks()[1]
    sensor, R = lecture.SENSOR, told * lecture.SENSOR.R
    x, P = poses[0] + draw(motion, U, (runs,)), np.tile(told * U, (runs, 1, 1))
    errors, covariances = [], []
    for k, pose in enumerate(poses):
        if k:
            u = _steps(poses[k - 1 : k + 1])[0] + draw(motion, U, (runs,))
            x, X_x, X_u = Odometry2().move(x, u, 1.0)
            P = X_x @ P @ T(X_x) + X_u @ (told * U) @ T(X_u)
        seen, y = _measure(sensing, pose, points, runs)
        for i in seen:
            e, H, _, _ = observe(Frame2(x), AT_ROBOT, sensor, POINT, points[i])
            K = P @ T(H) @ np.linalg.inv(H @ P @ T(H) + R)
            x = x + (K @ sensor.residual(y[:, i], e)[..., None])[..., 0]
            P = P - K @ H @ P
            P = (P + T(P)) / 2
        e = x - pose
        e[..., 2] = wrap(e[..., 2])
        errors.append(e)
        covariances.append(P)
    return np.array(errors), np.array(covariances)


# ---- mapping with known poses --------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Mapped:
    """Maps of N landmarks from R runs.

    Attributes
    ----------
    l, P : ndarray, shape (R, N, 2) and (R, N, 2, 2)
        Estimates and their covariances, in metres; with known poses the landmarks are independent.
    e : ndarray, shape (R, 2N)
        Error of the whole map.
    cov : ndarray, shape (R, 2N, 2N)
    nis, likelihood : ndarray
        Of all innovations; mean log-likelihood.
    """

    l: np.ndarray
    P: np.ndarray
    e: np.ndarray
    cov: np.ndarray
    nis: np.ndarray
    likelihood: float


@cache
def mapping(range_factor=1.0, bearing_factor=1.0, times=1, odometry=False, runs=20, seed=4):
    """Map the lecture's world from poses that are known, in many runs.

    Parameters
    ----------
    range_factor, bearing_factor : float
        What the filter is told of the noise, as a factor on the true standard deviations.
    times : int
        How often each measurement is used; 1 is right.
    odometry : bool
        The poses are those of the odometry alone, but the filter takes them for the truth.
    """
    motion, sensing = _streams(seed)
    poses, points, sensor = _poses(), lecture.true_landmarks()[1], lecture.SENSOR
    R = np.diag([range_factor, bearing_factor]) ** 2 * sensor.R
    steps, x_r = _steps(poses), np.tile(poses[0], (runs, 1))
    l, P, started = np.zeros((runs, len(points), 2)), np.zeros((runs, len(points), 2, 2)), set()
    nis, likelihood = [], []
    for k, pose in enumerate(poses):
        if k:
            x_r = Odometry2().move(x_r, steps[k - 1] + draw(motion, U, (runs,)), 1.0)[0]
        F = Frame2(x_r if odometry else np.tile(pose, (runs, 1)))
        seen, y = _measure(sensing, pose, points, runs)
        for i in seen.tolist():
            if i not in started:
                l[:, i], _, _, L_y, _ = retro_project(F, AT_ROBOT, sensor, POINT, y[:, i], np.zeros((runs, 0)))
                P[:, i] = L_y @ R @ T(L_y)
                started.add(i)
                continue
            for _ in range(times):
                e, _, _, H = observe(F, AT_ROBOT, sensor, POINT, l[:, i])
                z, Z = sensor.residual(y[:, i], e), H @ P[:, i] @ T(H) + R
                K = P[:, i] @ T(H) @ np.linalg.inv(Z)
                l[:, i] += (K @ z[..., None])[..., 0]
                P[:, i] -= K @ Z @ T(K)
                nis.append(md2(z, Z))
                likelihood.append(-0.5 * (nis[-1] + np.log(np.linalg.det(2 * np.pi * Z))))
    n = 2 * len(points)  # all of them were seen
    cov = np.zeros((runs, n, n))
    for j in range(len(points)):
        cov[:, 2 * j : 2 * j + 2, 2 * j : 2 * j + 2] = P[:, j]
    return Mapped(l, P, (l - points).reshape(runs, n), cov, np.array(nis), float(np.mean(likelihood)))


# ---- SLAM, right and wrong -----------------------------------------------------------------------------------------


class NotWrapped(RangeBearing):
    """A sensor model that subtracts bearings as if they were numbers on a line."""

    def residual(self, y, e):
        """Innovation without the wrap."""
        return np.subtract(y, e)


@dataclass(frozen=True)
class Slam:
    """SLAM runs: position error in m and NEES of the pose (F, R); NIS (M, R), its frames (M,); runs with P < 0."""

    error: np.ndarray
    nees: np.ndarray
    nis: np.ndarray
    nis_frame: np.ndarray
    broken: int

    @property
    def rmse(self):
        """Root mean square of the position error, m."""
        return float(np.sqrt(np.mean(self.error**2)))


BUGS = ("correct", "formula of mapping", "P_rm not moved", "bearing not wrapped", "std taken for variance")


@cache
def slam(bug="correct", runs=10, seed=5):
    """Two rounds on a circle, 16 landmarks, landmark identities known; one bug."""
    world = fleet.round_trip(loops=2, n=16, radius=8.0, max_range=4.0)
    motion, sensing = _streams(seed)
    sensor, used = world.sensor, _used_sensor(world.sensor, bug)
    truth, x, P = world.start, np.tile(world.start, (runs, 1)), np.zeros((runs, 3, 3))
    error, nees, nis, frames, ranges, broken = [], [], [], [], {}, np.zeros(runs, bool)
    new = _of_mapping if bug == "formula of mapping" else _right
    for k in range(world.frames):
        truth = Odometry2().move(truth, world.step, world.dt)[0]
        x[:, :3], X_x, X_u = Odometry2().move(x[:, :3], world.step + draw(motion, world.U, (runs,)), world.dt)
        P_rr, P_rm = X_x @ P[:, :3, :3] @ T(X_x) + X_u @ world.U @ T(X_u), P[:, :3, 3:]
        P[:, :3, :3] = P_rr
        if bug != "P_rm not moved":
            P[:, :3, 3:] = X_x @ P_rm
            P[:, 3:, :3] = T(P[:, :3, 3:])
        y = sensor.project(Frame2(truth).to_frame(world.points)[0])[0]
        seen = np.flatnonzero(y[:, 0] <= sensor.max_range).tolist()
        y = y + draw(sensing, sensor.R, (runs, len(y)))
        y[..., 1] = wrap(y[..., 1])
        for i in seen:
            if i in ranges:
                nis.append(md2(*fleet.correct(x, P, ranges[i], used, y[:, i])))
                frames.append(k)
            else:
                x, P, ranges[i] = fleet.augment(x, P, used, y[:, i], new)
        e = x[:, :3] - truth
        e[:, 2] = wrap(e[:, 2])
        error.append(np.hypot(e[:, 0], e[:, 1]))
        nees.append(md2(e, P[:, :3, :3]))
        if k % 20 == 0:
            w = np.linalg.eigvalsh(P)
            broken |= w[:, 0] < -1e-9 * w[:, -1]
    return Slam(np.array(error), np.array(nees), np.array(nis), np.array(frames), int(broken.sum()))


def _used_sensor(sensor, bug):
    """The sensor model that the filter uses."""
    if bug == "std taken for variance":
        return RangeBearing(np.sqrt(sensor.range_std), np.sqrt(sensor.bearing_std))
    return (NotWrapped if bug == "bearing not wrapped" else RangeBearing)(sensor.range_std, sensor.bearing_std)


def _right(P, L_r, L_y, R):
    return L_r @ P[:3], L_r @ P[:3, :3] @ L_r.T + L_y @ R @ L_y.T


def _of_mapping(P, L_r, L_y, R):
    return 0 * (L_r @ P[:3]), L_y @ R @ L_y.T
