"""Drawings of notebook 14: the structures of the manual as live objects, and a builder of scenarios."""

from collections import deque

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.patches import Rectangle

from ...graphics import ESTIMATE, MEASUREMENT, TRUTH, line, plot_ellipse, points
from ...graphics.artists import HALO, Labels
from ...graphics.style import BLACK, BLUE, GREEN, ORANGE, PURPLE, ROBOTS
from ...toolbox import UserData, universal_slam
from ..controls import Choice, Int, Toggle
from ..widgets import explorable
from .parts import robot

FORWARD = [-90.0, 0.0, -90.0]  # a camera that looks ahead, degrees
SIZES = {"euc_pnt": 3, "hmg_pnt": 4, "idp_pnt": 6, "ahm_pnt": 7}


def scenario(robots=1, side=False, depth=False, landmark="idp_pnt", calibrate=False, frames=30):
    """User data of a run in the cloister: robots on their rounds, each with one camera or more.

    Parameters
    ----------
    robots : int
        1 or 2; the second one carries a depth camera.
    side : bool
        Robot 1 has a second camera.
    depth : bool
        The camera of robot 1 sees the depth as well.
    landmark : str
        Type of new landmarks where only a direction is measured.
    calibrate : bool
        The mounting of the first camera is estimated.
    frames : int
    """
    bodies = [
        dict(
            id=i + 1,
            motion="odometry3",
            position=[0.0, y, 0.0],
            orientation_deg=[0, 0, turn],
            dx=[0.08, 0, 0],
            da_deg=[0, 0, 0.9],
            dx_std=0.005,
            da_std_deg=0.05,
        )
        for i, (y, turn) in enumerate(((-5.0, 0.0), (5.0, 180.0)))
    ]
    pixels = dict(orientation_deg=FORWARD, pixel_std=1.0)
    range_camera = dict(type="pin_hole_depth", depth_std=0.1, landmark="euc_pnt", **pixels)
    first = dict(range_camera) if depth else dict(type="pin_hole", **pixels)
    if calibrate:
        first |= dict(frame_in_map=True, orientation_std_deg=1.0)
    eyes = [dict(first, id=1, robot=1, position=[0, 0, 0.6])]
    if side:
        eyes.append(dict(pixels, type="pin_hole", id=2, robot=1, position=[0, -0.25, 0.6]))
    if robots == 2:
        eyes.append(dict(range_camera, id=3, robot=2, position=[0, 0, 0.6]))
    options = dict(n_inits=[10, 1], init_margin=25.6, n_updates=10, md2_threshold=9.0, reparametrize=True)
    return UserData.from_dict(
        {
            "name": "builder",
            "seed": 8,
            "time": {"dt": 0.1, "last": frames},
            "world": {"type": "cloister"},
            "robot": bodies[:robots],
            "sensor": eyes,
            "landmark": {"type": landmark},
            "options": options,
        }
    )


def end_of(data):
    """The last snapshot of a run."""
    return deque(universal_slam(data), maxlen=1)[0]


def overview(now):
    """Robots, sensors, landmarks and observations of a snapshot, and who owns which part of the map."""
    fig = plt.figure(figsize=(10.5, 8.2))
    ax, strip = fig.add_axes((0.07, 0.26, 0.62, 0.72)), fig.add_axes((0.07, 0.08, 0.9, 0.09))
    ax.plot(*now.sim_lmk.points[:, :2].T, **points(TRUTH, markersize=8, markeredgewidth=1.0), label="SimLmk: truth")
    for lmk in now.lmks.values():
        p, P = lmk.point(now.map)
        plot_ellipse(ax, p[:2], P[:2, :2], 3, **line(ESTIMATE, linewidth=1.2))
        ax.plot(*p[:2], **points(ESTIMATE, markersize=4))
    ax.plot([], [], **{**ESTIMATE, "markersize": 4}, label="Lmk: estimate,\n3σ ellipse (98.9 %)")
    frames = {rob.id: rob.frame(now.map) for rob in now.robs}
    used = [o for o in now.obs.values() if o.updated and o.lmk in now.lmks]
    for o in used:
        rob = next(rob for rob in now.robs if o.sen in rob.sensors)
        eye = frames[rob.id].from_frame(next(s for s in now.sens if s.id == o.sen).frame(now.map).t)[0]
        ax.plot(*np.transpose([eye[:2], now.lmks[o.lmk].point(now.map)[0][:2]]), **line(MEASUREMENT, linewidth=1.2))
    ax.plot([], [], **line(MEASUREMENT), label="Obs: used in\nthis frame")
    for rob, hue in zip(now.robs, ROBOTS, strict=False):
        F = frames[rob.id]
        ahead = F.R[:, 0]
        robot(ax, [*F.t[:2], np.arctan2(ahead[1], ahead[0])], size=0.45, facecolor=hue, edgecolor=BLACK)
    ax.set(xlim=(-8, 8), ylim=(-7.5, 7.5), xlabel="x (m)", ylabel="y (m)", aspect="equal")
    names = {rob.id: f"Rob {rob.id}: Sen {', '.join(str(i) for i in rob.sensors)}" for rob in now.robs}
    letters = Labels(ax, 14, (16, 13), apart=True, marks=now.sim_lmk.points[:, :2], color=BLACK, zorder=9, **HALO)
    letters.put({id: F.t[:2] for id, F in frames.items()}, names)
    ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
    _wagons(strip, now)
    text = f"{_count(len(now.robs), 'robot')}, {_count(len(now.sens), 'sensor')}, {_count(len(now.lmks), 'landmark')}"
    return fig, f"Frame {now.k}: {text}, {len(used)} observations used. The map has {now.map.n_used} numbers."


def _count(n, word):
    return f"{n} {word}{'s' * (n != 1)}"


def _wagons(ax, now):
    """Draw the state vector: one box for each range, with its owner."""
    groups = (("Rob", now.robs, BLACK, ""), ("Sen", now.sens, PURPLE, "xx"), ("Lmk", now.lmks.values(), BLUE, ""))
    for name, things, color, hatch in groups:
        for thing in things:
            if thing.r is not None:
                width = thing.r.stop - thing.r.start
                c = (ORANGE if width > 3 else GREEN) if name == "Lmk" else color
                hatch = "//" if name == "Lmk" and width > 3 else hatch if name != "Lmk" else ""
                ax.add_patch(
                    Rectangle((thing.r.start, 0), width, 1, facecolor=c, alpha=0.6, edgecolor="w", hatch=hatch)
                )
                if name != "Lmk":
                    middle = (thing.r.start + thing.r.stop) / 2
                    ax.text(middle, 1.1, f"{name[0]}{thing.id}", fontsize=12, ha="center")
    ax.set(xlim=(0, max(now.map.n, 1)), ylim=(0, 1.6), yticks=[])
    ax.set_xlabel("place in Map.x. R Rob, S Sen; then Lmk: hatched with more than 3 numbers, plain with 3; white: free")
    ax.grid(False)


@explorable(
    two=Toggle(False, label="second robot, with a depth camera"),
    side=Toggle(False, label="second camera on robot 1"),
    depth=Toggle(False, label="first camera sees the depth, too"),
    calibrate=Toggle(False, label="first camera calibrates its mounting"),
    landmark=Choice("idp_pnt", list(SIZES), label="type of new landmarks"),
    frames=Int(30, 1, 60, label="frames"),
    run=True,
    ranges={"states": (7, 600), "landmarks": (1, 72)},
)
def builder(two, side, depth, calibrate, landmark, frames):
    """A scenario from ticks: what is in the map, and what each structure holds at the end."""
    note = ""
    if landmark == "euc_pnt" and (side or not depth):
        landmark, note = "idp_pnt", " (A camera without depth cannot start euc_pnt: idp_pnt taken.)"
    now = end_of(scenario(1 + two, side, depth, landmark, calibrate, frames))
    fig, caption = overview(now)
    return fig, {"states": now.map.n_used, "landmarks": len(now.lmks), "caption": caption + note}
