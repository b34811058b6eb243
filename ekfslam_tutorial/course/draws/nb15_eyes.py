"""What the drawings of notebook 15 compute about cameras: the mounting of one, and what a second one brings."""

from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from ...geometry import Frame3
from ...models.landmarks import IdpPnt
from ...models.observation import observe, retro_project
from ...models.sensors import PinHole
from ...toolbox import universal_slam
from ...toolbox.recordings import Recorder
from .. import fleet
from . import nb14

MOUNT = np.array([0, 0, 0.6, 0.5, -0.5, 0.5, -0.5])  # the camera as it should be: 0.6 m above the robot, looks ahead


# ---- the mounting of a camera ---------------------------------------------------------------------------------------


@dataclass
class Mounting:
    """Calibration of a camera's mounting: angles about the robot's axes, degrees; NEES and error of the robot."""

    error: np.ndarray  # (frames, 3), roll, pitch, yaw of the camera on the robot
    std: np.ndarray
    nees: np.ndarray  # of the robot's pose, (frames,), 6 degrees of freedom
    robot: np.ndarray  # its position error, (frames,), m


@cache
def mounting(turn=0.9, std=2.0, seed=1, frames=40, calibrate=True):
    """A robot with a depth camera whose mounting is off by some degrees; it drives at 0.8 m/s.

    Parameters
    ----------
    turn : float
        Degrees of turn in each frame of 0.1 s.
    std : float
        The mounting is off by an angle of this standard deviation about each axis, degrees.
    seed, frames : int
    calibrate : bool
        The mounting is in the map. If not, the filter takes what the drawing of the robot says, as if it were exact.
        Robot, noise and measurements are the same in both cases.
    """
    data = nb14.scenario(robots=1, depth=True, calibrate=True, frames=frames)
    robot = replace(data.robots[0], control=dict(dx=[0.08, 0, 0], da_deg=[0, 0, turn]))
    eye = replace(data.sensors[0], orientation_std_deg=std)
    options = replace(data.options, n_updates=6, max_lmks=30)
    data = replace(data, seed=seed, robots=[robot], sensors=[eye], options=options)
    recorder, log, truth = Recorder(), [], Frame3(MOUNT)
    for now in universal_slam(data):
        recorder.add(now)
        truth = now.sim_sens[0].frame
        log.append(_reading(now, truth))
    if not calibrate:
        wrong = replace(data, sensors=[replace(eye, frame_in_map=False, orientation_std_deg=0.0)])
        log = [_reading(now, truth) for now in universal_slam(wrong, recorder.recording("the same drive"))]
    return Mounting(*(np.array(column) for column in zip(*log, strict=True)))


def _reading(now, truth):
    """Errors and standard deviations of the mounting about the robot's axes; NEES and error of the robot."""
    sen, rob = now.sens[0], now.robs[0]
    e, E_f = sen.frame(now.map).minus(truth)[:2]
    std = np.zeros(3)
    if sen.r is not None:
        C = truth.R @ (E_f @ now.map.P[sen.r, sen.r] @ E_f.T)[3:, 3:] @ truth.R.T
        std = np.sqrt(np.diag(C))
    d, D_f = rob.frame(now.map).minus(Frame3(now.truth[rob.id]))[:2]
    C = D_f @ now.map.P[rob.r, rob.r] @ D_f.T
    return np.degrees(truth.R @ e[3:]), np.degrees(std), d @ np.linalg.solve(C, d), np.linalg.norm(d[:3])


# ---- a second camera ------------------------------------------------------------------------------------------------

DEPTHS = np.array([2.0, 3, 4, 6, 8, 12, 16, 24, 32, 48])
RHO, RHO_STD = 0.25, 0.125  # prior of the inverse distance, 1/m, as in notebook 13


def depth_sigmas(baseline, frames=1, step=0.0, pixel_std=1.0):
    """Standard deviation of the depth of points, as a part of the depth, with known poses and inverse-depth landmarks.

    Parameters
    ----------
    baseline : float
        Metres from the first camera to the second one, to the right; 0: there is one camera only.
    frames : int
    step : float
        Metres that the robot drives ahead between two frames.
    pixel_std : float

    Returns
    -------
    ndarray, shape (10,)
        For points at `DEPTHS`, a quarter of the depth to the left.
    """
    camera, lmk = PinHole(pixel_std=pixel_std), IdpPnt()
    eyes = [Frame3(MOUNT)]
    if baseline:
        eyes.append(Frame3(np.concatenate([[0, -baseline, 0.6], MOUNT[3:]])))
    points = np.column_stack([DEPTHS, DEPTHS / 4, 0.6 + 0 * DEPTHS])
    here = Frame3(np.eye(7)[3])
    eye = eyes[0].to_frame(points)[0]
    y = camera.project(eye)[0]
    rho = 1 / np.linalg.norm(eye, axis=1)[:, None]
    l, _, _, L_y, L_n = retro_project(here, eyes[0], camera, lmk, y, rho)  # linearised at the truth
    T = fleet.T
    P = L_y @ camera.R @ T(L_y) + RHO_STD**2 * L_n @ T(L_n) + 1e-12 * np.eye(6)
    for k in range(frames):
        F = Frame3(np.array([k * step, 0, 0, 1, 0, 0, 0]))
        for i, each in enumerate(eyes):
            p = each.to_frame(F.to_frame(points)[0])[0]
            s = np.flatnonzero(p[:, 2] > 0.5)  # the robot may have passed the others
            s = s[camera.visible(camera.project(p[s])[0], p[s])]
            if len(s) and (k or i):  # the first picture has made the landmarks
                H = observe(F, each, camera, lmk, l[s])[3]
                PHt = P[s] @ T(H)
                P[s] -= PHt @ np.linalg.solve(H @ PHt + camera.R, T(PHt))
    return np.sqrt(P[:, 5, 5]) / rho[:, 0]
