"""Records of our own runs, for an audit: poses with covariances and truth, errors in one gauge, map, innovations."""

import numpy as np

from ..geometry import Frame2, Frame3
from ..toolbox.files import value_file
from .estimates import Estimate

FORMAT = "ekfslam record 1"


def write_rec(path, history, innovations=None):
    """Write a record of a run.

    Parameters
    ----------
    path : path
        Its name should end in .rec.
    history : History
    innovations : Innovations, optional
    """
    robots = {}
    for id in history.robots:
        track = history.track(id)
        rows = track.known
        e, P = history.errors(id)
        x = track.frame(track.x)
        _, E_x = x.minus(x)
        robots[str(id)] = {
            "t": track.t[rows],
            "x": track.x[rows],
            "P": (E_x @ track.P @ np.swapaxes(E_x, -1, -2))[rows],
            "truth": track.truth[rows],
            "e": e,
            "P_gauge": P,
            "nis": history.nis(id)[:, 1:],
            "z": np.zeros((0, 0)) if innovations is None else innovations.of(id),
        }
    ids, points, P, places = history.joint_map()
    land = {"ids": np.array(ids, float), "points": points, "P": P, "truth": places}
    value_file.save(path, {"format": FORMAT, "free": history.gauge == "free", "robots": robots, "map": land})


def read_rec(path, robot=None):
    """Read a record of a run.

    Parameters
    ----------
    path : path
    robot : int, optional
        Which one; needed where there are several, as their errors are not independent.

    Returns
    -------
    Estimate

    Raises
    ------
    ValueError
        If the file is none, or does not know the robot or any true pose of it.
    """
    kept = value_file.load(path)
    if not isinstance(kept, dict) or kept.get("format") != FORMAT:
        raise ValueError(f"{path} is no record of a run: `ekfslam run --record` writes estimate.rec")
    robots = kept["robots"]
    if robot is None and len(robots) > 1:
        raise ValueError(f"{path} has the robots {', '.join(robots)}: choose one with --robot")
    id = next(iter(robots)) if robot is None else str(robot)
    if id not in robots:
        raise ValueError(f"{path} has no robot {id}; it has {', '.join(robots)}")
    a, land = robots[id], kept["map"]
    if not len(a["t"]):
        raise ValueError(f"{path}: no true pose of robot {id} is known")
    frame = Frame2 if a["x"].shape[1] == 3 else Frame3
    return Estimate(
        str(path),
        frame(a["x"]),
        a["t"],
        a["P"],
        truth=frame(a["truth"]),
        ids=[int(id) for id in land["ids"]],
        points=land["points"],
        points_P=land["P"],
        true_points=land["truth"],
        z=a["z"],
        nis=a["nis"],
        errors=(a["e"], a["P_gauge"], kept["free"]),
    )
