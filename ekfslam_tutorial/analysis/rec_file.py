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
        e, P = history.errors(id)
        x = track.frame(track.x)
        _, E_x = x.minus(x)
        robots[str(id)] = {
            "t": track.t,
            "x": track.x,
            "P": (E_x @ track.P @ np.swapaxes(E_x, -1, -2)),
            "truth": track.truth,
            "e": e,
            "P_gauge": P,
            "nis": history.nis(id)[:, 1:],
            "z": np.zeros((0, 0)) if innovations is None else innovations.of(id),
        }
    ids, points, P, places = history.joint_map()
    land = {"ids": np.array(ids, float), "points": points, "P": P, "truth": places}
    value_file.save(path, {"format": FORMAT, "free": history.gauge == "free", "robots": robots, "map": land})


def read_rec(path, robot=None, known=True):
    """Read a record of a run.

    Parameters
    ----------
    path : path
    robot : int, optional
        Which one; needed where there are several, as their errors are not independent.
    known : bool
        Its poses that have a true one in the file, with it. False: all of its poses, without truth, for another one;
        the map stays out then, for the file does not know its places in the frame of that.

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
    frame = Frame2 if a["x"].shape[1] == 3 else Frame3
    if not known:
        return Estimate(str(path), frame(a["x"]), a["t"], a["P"], z=a["z"], nis=a["nis"])
    rows = np.isfinite(a["truth"]).all(1)
    if not rows.any():
        raise ValueError(f"{path}: no true pose of robot {id} is known: give them by --truth")
    return Estimate(
        str(path),
        frame(a["x"][rows]),
        a["t"][rows],
        a["P"][rows],
        truth=frame(a["truth"][rows]),
        ids=[int(id) for id in land["ids"]],
        points=land["points"],
        points_P=land["P"],
        true_points=land["truth"],
        z=a["z"],
        nis=a["nis"],
        errors=(a["e"], a["P_gauge"], kept["free"]),
    )
