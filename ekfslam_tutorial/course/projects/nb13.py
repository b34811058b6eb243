"""Project 13: one camera, a cloister, and a filter of one's own."""

import numpy as np

from ...geometry import Frame3
from ...models.landmarks import IdpPnt
from ...models.observation import observe
from .. import asks
from ..exercises.nb13_euclid import idp2euc
from ..exercises.nb13_new import new_idp
from ..project import Project

SCENARIO = """
name = "one eye"
seed = 1
time = {dt = 0.1, last = 120}
world = {type = "cloister"}

[[robot]]
motion = "odometry3"
position = [0.0, -5.0, 0.0]
dx = [0.08, 0.0, 0.0]
da_deg = [0.0, 0.0, 0.9]
dx_std = 0.005
da_std_deg = 0.3

[[sensor]]
type = "pin_hole"
position = [0.0, 0.0, 0.6]
orientation_deg = [-90, 0, -90]
pixel_std = 1.0

[landmark]
type = "idp_pnt"
non_obs_mean = 0.25
non_obs_std = 0.125
"""

START = SCENARIO[: SCENARIO.index("[[sensor]]")] + (
    "# Here: a camera that looks ahead, 0.6 m above the robot, with pixels of 1 px noise,\n"
    "# and landmarks of six numbers with the prior of section 2.\n"
)


def change(x, P, r, new, J, Q=0.0):
    """The state in the range r becomes `new`: J is its derivative by what it was, Q the covariance of new noise."""
    x, P = x.copy(), P.copy()
    x[r], P[r] = new, J @ P[r]
    P[:, r] = P[:, r] @ J.T
    P[r, r] += Q
    return x, P


def loop(world):
    """EKF-SLAM with one camera: yield the map after each frame.

    world.x, shape (7,), and world.P, shape (7, 7), are the robot's frame [t, q] before the first frame, and its
    covariance. With `rob = world.robs[0]` and `eye = world.sens[0]`, `rob.motion.move(x, u, dt)` returns the frame
    after a step, X_x and X_u; `eye.model` is the camera, `eye.x` its mounting on the robot, shape (7,).
    `world.options.n` and `world.options.N` are the prior; `world.kinds[6]` and `world.kinds[3]` are the types of
    landmarks with six numbers and with three. `for now in world` goes through the frames: `now.u[1]`, shape (6,),
    `now.U[1]`, shape (6, 6), and `now.dt` are the control; `now.seen[1]` is a list of pairs (id, y): a landmark and
    its pixel.
    Yield x, P, lmks after each frame: the whole map, the robot first, and a dictionary id: slice.
    """
    rob, eye = world.robs[0], world.sens[0]
    camera, mount = eye.model, Frame3(eye.x)
    x, P, lmks = world.x, world.P, {}
    for now in world:
        new, X_x, X_u = rob.motion.move(x[:7], now.u[1], now.dt)
        x, P = change(x, P, slice(0, 7), new, X_x, X_u @ now.U[1] @ X_u.T)
        for id, y in now.seen[1]:
            if id in lmks:
                r = lmks[id]
                e, E_r, _, E_l = observe(Frame3(x[:7]), mount, camera, world.kinds[r.stop - r.start], x[r])
                H = np.zeros((2, len(x)))
                H[:, :7], H[:, r] = E_r, E_l
                Z, z = H @ P @ H.T + camera.R, y - e
                if z @ np.linalg.solve(Z, z) < 9:
                    K = P @ H.T @ np.linalg.inv(Z)
                    x, P = x + K @ z, P - K @ Z @ K.T
            else:
                F, F_r, _ = Frame3(x[:7]).compose(mount)
                prior = camera, y, camera.R, world.options.n, world.options.N
                l, P_ll, _ = new_idp(F, F_r @ P[:7, :7] @ F_r.T, *prior)
                P_lx = new_idp(F, np.eye(7), *prior)[2] @ F_r @ P[:7]  # with P_F = I it returns L_F
                lmks[id] = slice(len(x), len(x) + 6)
                x, P = np.append(x, l), np.block([[P, P_lx.T], [P_lx, P_ll]])
        F, F_x = Frame3(x[:7]).normalized()
        x, P = change(x, P, slice(0, 7), F.x, F_x)
        for id in list(lmks):
            r, place = lmks[id], F.from_frame(mount.t)[0]  # the camera is there
            if r.stop - r.start == 6 and IdpPnt().linearity(x[r], P[r, r], place) < 0.1:
                x, P = idp2euc(x, P, r.start)
                lmks[id] = slice(r.start, r.stop - 3)
                lmks |= {i: slice(s.start - 3, s.stop - 3) for i, s in lmks.items() if s.start > r.start}
        yield x, P, lmks


project = Project(
    "13.project",
    "One eye in the cloister",
    loop,
    scenario=SCENARIO,
    start=START,
    hints=(
        "Four parts in a frame: move (X_x on the rows and columns of the robot, then X_u U X_u'), correct with known landmarks (H has seven columns of the robot and those of one landmark), start new ones, keep the quaternion of length 1. A new landmark needs a covariance with the whole map: L_F F_r P[:7], F_r from `compose`.",
        "Camera frame: F, F_r, _ = Frame3(x[:7]).compose(Frame3(eye.x)); its covariance is F_r P[:7, :7] F_r'. Birth: "
        "l, P_ll, _ = new_idp(F, that, camera, y, camera.R, n, N); called with np.eye(7) in its place, the last result "
        "is L_F itself. Then x = [x, l], P = [[P, P_lx'], [P_lx, P_ll]], lmks[id] = the last six. Expected pixel: "
        "e, E_r, _, E_l = observe(Frame3(x[:7]), mount, camera, IdpPnt(), x[r]); the gate is z' Z^-1 z < 9.",
    ),
    asks=(
        asks.robots("odometry3"),
        asks.sensors("pin_hole"),
        asks.landmarks("idp_pnt"),
        asks.frames(60, 200),
        asks.points(20),
        asks.noise(dx_std=0.002, da_std_deg=0.1, pixels=0.5),
        asks.estimated(),
    ),
    band=(3.0, 15.0),
    landmark_band=3.5,
)
