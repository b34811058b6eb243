"""Project 14: the universal loop, in a map with room for 150 numbers."""

import numpy as np

from ...geometry import Frame3
from ...models.observation import observe, retro_project
from .. import asks
from ..exercises.nb14_frame import known_then_new
from ..exercises.nb14_range import find_range
from ..project import Project, Symptom
from .nb13 import change

ROOM = 150

SCENARIO = """
name = "two robots, two cameras"
seed = 1
time = {dt = 0.1, last = 100}
world = {type = "cloister"}
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

START = SCENARIO[: SCENARIO.rindex("[[robot]]")] + (
    "# Here: robot 2, which starts 5 m to the left of the origin and looks back (180 degrees), with smaller steps, 0.06 m\n"
    "# and 0.7 degrees; on it, as on robot 1, a camera, but one that sees the depth to 0.1 m: its landmarks are euc_pnt.\n"
)


def loop(world):
    """EKF-SLAM with any number of robots and sensors, in a map of 150 numbers: yield the map after each frame.

    As in project 13, but for all: `for rob in world.robs`, `rob.r` is its range in world.x and world.P; `rob.sensors`
    are the ids of its sensors, `sen = world.sens[id - 1]` is one of them, with `sen.model` and `sen.x`. It starts
    landmarks of the type `sen.lmk_type or world.options.lmk_type`. Landmarks not needed any more go, and leave room.
    Yield x, P, lmks after each frame: x, shape (150,), P, shape (150, 150), zero where nobody lives; id: slice.
    """
    n, room = len(world.x), 150
    x, P, used = np.zeros(room), np.zeros((room, room)), np.arange(room) < n
    x[:n], P[:n, :n] = world.x, world.P
    lmks, last = {}, {}
    for now in world:
        for rob in world.robs:
            new, X_x, X_u = rob.motion.move(x[rob.r], now.u[rob.id], now.dt)
            x, P = change(x, P, rob.r, new, X_x, X_u @ now.U[rob.id] @ X_u.T)
            for sen in (world.sens[id - 1] for id in rob.sensors):
                seen, mount, R = now.seen[sen.id], Frame3(sen.x), sen.model.R
                last |= {id: now.k for id, _ in seen}
                old, new = known_then_new(np.array([id for id, _ in seen], int), np.array(list(lmks), int), 10)
                for id, y in (seen[int(i)] for i in old):
                    r = lmks[id]
                    e, E_r, _, E_l = observe(Frame3(x[rob.r]), mount, sen.model, world.kinds[r.stop - r.start], x[r])
                    H, z = np.zeros((len(y), room)), sen.model.residual(y, e)
                    H[:, rob.r], H[:, r] = E_r, E_l
                    Z = H @ P @ H.T + R
                    if z @ np.linalg.solve(Z, z) < 9:
                        K = P @ H.T @ np.linalg.inv(Z)
                        x, P = x + K @ z, P - K @ Z @ K.T
                for id, y in (seen[int(i)] for i in new):
                    kind = sen.lmk_type or world.options.lmk_type
                    start, stop = (int(i) for i in find_range(used, kind.size))
                    if stop <= room:
                        r, N = slice(start, stop), world.options.N if sen.model.bearing_only else np.zeros((0, 0))
                        l, L_r, _, L_y, L_n = retro_project(
                            Frame3(x[rob.r]), mount, sen.model, kind, y, world.options.n[: len(N)]
                        )
                        x[r], P[r], lmks[id], used[r] = l, L_r @ P[rob.r], r, True
                        P[:, r] = P[r].T
                        P[r, r] = L_r @ P[rob.r, rob.r] @ L_r.T + L_y @ R @ L_y.T + L_n @ N @ L_n.T
            F, F_x = Frame3(x[rob.r]).normalized()
            x, P = change(x, P, rob.r, F.x, F_x)
        for id in [id for id in lmks if last[id] < now.k - 5]:
            r = lmks.pop(id)
            used[r], P[r], P[:, r] = False, 0, 0
        yield x, P, lmks


project = Project(
    "14.project",
    "A loop for all robots, in a small map",
    loop,
    scenario=SCENARIO,
    start=START,
    hints=(
        "Make x and P of 150 numbers once, and note in an array of bool which are used. Per robot: move; per sensor: "
        "known_then_new says which measurements correct and which start a landmark; find_range says where. At the end "
        "of a frame drop the landmarks that were not seen for some frames: their range is free, and their rows and "
        "columns of P are zero.",
        "Correction: e, E_r, _, E_l = observe(Frame3(x[rob.r]), Frame3(sen.x), sen.model, world.kinds[r.stop - "
        "r.start], x[r]); H is zero but for H[:, rob.r] = E_r and H[:, r] = E_l; z = sen.model.residual(y, e). Birth: "
        "l, L_r, _, L_y, L_n = retro_project(Frame3(x[rob.r]), Frame3(sen.x), sen.model, kind, y, n), with n and N "
        "empty if the sensor sees the depth; P[r] = L_r P[rob.r], P[:, r] = P[r]', and then the block P[r, r].",
    ),
    asks=(
        asks.robots("odometry3", "odometry3"),
        asks.sensors("pin_hole", "pin_hole_depth"),
        asks.places(SCENARIO),
        asks.landmarks("idp_pnt"),
        asks.frames(60, 200),
        asks.points(20),
        asks.noise(dx_std=0.002, da_std_deg=0.1, pixels=0.5),
        asks.estimated(),
    ),
    band=(3.0, 12.0),
    least=0.3,
    claims=(0.92, 1.8, 2.5),  # points that inverse depths become claim more; a landmark that comes again is new
    before=(
        Symptom(
            "the room",
            lambda s, p: s.size > ROOM,
            "x has up to {s.size} numbers, the task allows 150",
            "Landmarks that have not been seen for some frames must go, and leave their range to others: find_range finds the gap. If there is none, the landmark is not started.",
        ),
        Symptom(
            "who leaves",
            lambda s, p: s.share >= p.least and s.lately < 0.4,
            "only {s.lately:.0%} of the landmarks that were seen in the last ten frames are in the map at the end",
            "The map is full of landmarks that nobody sees any more, and the new ones find no room: the robots drive on by "
            "their odometry alone. Note when each landmark was seen last. If that is some frames ago it leaves `lmks`, and its "
            "range is free again.",
        ),
    ),
)
