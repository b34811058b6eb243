"""Project 15: two robots, three cameras, one of them calibrated on the way."""

import numpy as np

from ...geometry import Frame3
from ...models.observation import observe, retro_project
from .. import asks
from ..exercises.nb15_blocks import correct_blocks
from ..project import SYMPTOMS, Project, Symptom
from .nb13 import change

SCENARIO = """
name = "two robots, three cameras"
seed = 2
time = {dt = 0.1, last = 60}
world = {type = "cloister", n = 5}
landmark = {type = "idp_pnt", non_obs_mean = 0.25, non_obs_std = 0.125}

[[robot]]
motion = "odometry3"
position = [0.0, -5.0, 0.0]
dx = [0.08, 0.0, 0.0]
da_deg = [0.0, 0.0, 0.9]
dx_std = 0.005
da_std_deg = 0.3

[[sensor]]
robot = 1
type = "pin_hole"
position = [0.0, -0.25, 0.6]
orientation_deg = [-90, 0, -90]
orientation_std_deg = 2.0
frame_in_map = true

[[sensor]]
robot = 1
type = "pin_hole"
position = [0.0, 0.0, 0.6]
orientation_deg = [-90, 0, -90]

[[robot]]
motion = "odometry3"
position = [0.0, 5.0, 0.0]
orientation_deg = [0, 0, 180]
dx = [0.06, 0.0, 0.0]
da_deg = [0.0, 0.0, 0.7]
dx_std = 0.005
da_std_deg = 0.3

[[sensor]]
robot = 2
type = "pin_hole_depth"
landmark = "euc_pnt"
depth_std = 0.1
position = [0.0, 0.0, 0.6]
orientation_deg = [-90, 0, -90]
"""

_first, _second = SCENARIO.index("[[sensor]]"), SCENARIO.index("[[sensor]]", SCENARIO.index("[[sensor]]") + 1)
START = (
    SCENARIO[:_first]
    + "# Here: another camera on robot 1, 0.25 m to the right of the one below. Screws hold it to 2 degrees about each\n"
    + "# axis: its mounting belongs in the map. It is the first of all, so that it starts landmarks, too.\n\n"
    + SCENARIO[_second:]
)


def loop(world):
    """EKF-SLAM of two robots with three cameras in one map, one mounting estimated: yield the map after each frame.

    As in project 14, but without a limit of the room: new landmarks go to the end of x. `sen.r` is the range of a
    mounting that is estimated, None of one that is known; its frame is then `sen.x`. The ranges of robots and mountings
    are the beginning of world.x and world.P.
    Yield x, P, lmks after each frame: the whole map, robots and mounting first, and a dictionary id: slice.
    """
    x, P, lmks = world.x, world.P, {}
    for now in world:
        for rob in world.robs:
            new, X_x, X_u = rob.motion.move(x[rob.r], now.u[rob.id], now.dt)
            x, P = change(x, P, rob.r, new, X_x, X_u @ now.U[rob.id] @ X_u.T)
        for sen in world.sens:
            rob, N = world.robs[sen.robot - 1], world.options.N if sen.model.bearing_only else np.zeros((0, 0))
            for id, y in now.seen[sen.id]:
                F, S = Frame3(x[rob.r]), Frame3(sen.x if sen.r is None else x[sen.r])
                if id in lmks:
                    r = lmks[id]
                    e, E_r, E_s, E_l = observe(F, S, sen.model, world.kinds[r.stop - r.start], x[r])
                    z, blocks = sen.model.residual(y, e), [(rob.r, E_r), (sen.r, E_s), (r, E_l)]
                    x, P = correct_blocks(x, P, blocks, z, sen.model.R)
                else:
                    kind = sen.lmk_type or world.options.lmk_type
                    l, L_r, L_s, L_y, L_n = retro_project(F, S, sen.model, kind, y, world.options.n[: len(N)])
                    P_lx = L_r @ P[rob.r] + (0 if sen.r is None else L_s @ P[sen.r])
                    P_ll = P_lx[:, rob.r] @ L_r.T + (0 if sen.r is None else P_lx[:, sen.r] @ L_s.T)
                    P_ll = P_ll + L_y @ sen.model.R @ L_y.T + L_n @ N @ L_n.T
                    lmks[id] = slice(len(x), len(x) + kind.size)
                    x, P = np.append(x, l), np.block([[P, P_lx.T], [P_lx, P_ll]])
        for r in [*(rob.r for rob in world.robs), *(sen.r for sen in world.sens if sen.r)]:
            F, F_x = Frame3(x[r]).normalized()
            x, P = change(x, P, r, F.x, F_x)
        yield x, P, lmks


_HONEST = [symptom.name for symptom in SYMPTOMS].index("honest")


def _first_starts(data):
    if data.sensors[0].frame_in_map:
        return None
    return (
        "the camera whose mounting is estimated is not the first sensor: the other one starts all landmarks of the two"
    )


project = Project(
    "15.project",
    "Two robots, three cameras",
    loop,
    scenario=SCENARIO,
    start=START,
    hints=(
        "The loop of project 14 with three changes: move all robots first; go through world.sens; a correction has up to three blocks, (rob.r, E_r), (sen.r, E_s), (r, E_l), and correct_blocks takes them as they are (sen.r may be None). At a birth the mounting is one more parent: P_lx = L_r P[rob.r] + L_s P[sen.r].",
        "e, E_r, E_s, E_l = observe(F, S, sen.model, kind, x[r]) with F = Frame3(x[rob.r]), S = Frame3(sen.x if sen.r "
        "is None else x[sen.r]). Birth: l, L_r, L_s, L_y, L_n = retro_project(F, S, sen.model, kind, y, n), n empty "
        "if the sensor sees the depth; P_ll = P_lx[:, rob.r] L_r' + P_lx[:, sen.r] L_s' + L_y R L_y' + L_n N L_n'. At "
        "the end of a frame bring all quaternions to length 1: F, F_x = Frame3(x[r]).normalized(), then change.",
    ),
    asks=(
        asks.robots("odometry3", "odometry3"),
        asks.sensors("pin_hole", "pin_hole", "pin_hole_depth"),
        asks.places(SCENARIO),
        asks.landmarks("idp_pnt"),
        asks.frames(50, 200),
        asks.points(20),
        asks.noise(dx_std=0.002, da_std_deg=0.1, pixels=0.5),
        asks.estimated(mountings=1, angles=(0.5, 5.0)),
        _first_starts,
    ),
    band=(3.0, 12.0),
    before=(
        Symptom(
            "the mounting",
            lambda s, p: s.mounting_sigma > 0.5,
            "the sigma of the mounting is {s.mounting_sigma:.2f} times what it was at the start",
            "The mounting is not learnt: is (sen.r, E_s) among the blocks of a correction? Does a new landmark of this camera get its covariance with the mounting, L_s P[sen.r]?",
        ),
    ),
    symptoms=(
        *SYMPTOMS[:_HONEST],
        Symptom(
            "the mounting is honest",
            lambda s, p: s.mounting_nees > 9.0,
            "the mean NEES of the angles of the mounting is {s.mounting_nees:.1f} (honest 3, at most 9), that of the robots {s.nees:.1f} (honest 6)",
            "Look first at the block E_s in the corrections, and at L_s in the births: P_lx and P_ll both need it. Then at what makes the robots too sure: X_u U X_u', R, another Jacobian, the control of another robot.",
        ),
        *SYMPTOMS[_HONEST:],
    ),
    seeds=(101, 102, 103, 104),
    sensor=1,
)
