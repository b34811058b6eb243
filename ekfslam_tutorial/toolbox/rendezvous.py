"""Where robots start when nobody has measured it: several robots relative to each other, or on a known map.

Each robot begins a map of its own. As soon as the maps have enough landmarks in common, they are laid on each other,
and that says where the robots started.
"""

from dataclasses import replace

import numpy as np

from ..geometry import align, q2e
from .universal_slam import universal_slam

COMMON = 4
"""So many landmarks link two maps; two would do if none were wrong."""

SEEN = 5
"""A landmark counts when it has been used so often, in both maps."""

MISFIT = 0.3
"""A link that leaves a larger root mean square distance between the landmarks is not believed, m, unless told."""

CHECK_EVERY = 100
"""Frames between two tries."""

START_STD = 0.5, 20.0
"""What the starts are worth to the filter, m and degrees: a place to linearise at, and little more."""


def find_starts(data, recording, misfit=MISFIT):
    """Tell where robots start, from landmarks that they have in common: with the first robot, or with a known map.

    The log is used twice: for the starts, and then for the run. So that nothing counts twice, the starts come with
    standard deviations (`START_STD`) several times larger than the error of the alignment: they give the filter a place
    to linearise at, and their weight is that of a guess. The true poses are not looked at.

    Parameters
    ----------
    data : UserData
        The first robot keeps its start: it fixes the frame of the map. Where the landmarks are known, they do, and
        robots that have no start get one. Ids of landmarks hold for all robots.
    recording : Recording
    misfit : float
        A link that leaves a larger root mean square distance between the landmarks is not believed, m.

    Returns
    -------
    data : UserData
        The same with `position`, `orientation_deg` and their standard deviations for the robots that were placed.
    note : str
        What was done, for the notes of the recording.

    Raises
    ------
    ValueError
        If a robot has too few landmarks in common with the others, or they do not lie alike.
    """
    known_map = not data.landmark.in_map
    first = [] if known_map else [data.robots[0].id]
    wanted = [robot.id for robot in data.robots if robot.id not in first]
    starts, t = _linked(data, recording, wanted, misfit)
    robots = [replace(r, **_start(starts[r.id])) if r.id in wanted else r for r in data.robots]
    note = (
        f"starts of robots {wanted} {'on the known map' if known_map else f'relative to robot {first[0]}'} found from "
        f"landmarks that their own maps of the first {t:.0f} s have in common with it; to the filter they are guesses, "
        f"good to {START_STD[0]:g} m and {START_STD[1]:g} degrees"
    )
    return replace(data, robots=robots), note


def _start(F):
    """Return what a user would write down for a robot that starts at F, known as well as a guess."""
    angles = F.x[2] if F.dim == 2 else q2e(F.q)[0]
    place = {"position": F.t.tolist(), "orientation_deg": np.rad2deg(angles).tolist()}
    return place | dict(zip(("position_std", "orientation_std_deg"), START_STD, strict=True))


def _linked(data, recording, wanted, misfit):
    """Frames of the own maps of some robots, and how long it took until all were linked."""
    runs = [universal_slam(_alone(data, robot, robot.id in wanted), recording) for robot in data.robots]
    known = [] if data.landmark.in_map else [("known", _surveyed(recording))]
    frames, t = {}, 0.0
    for k, snapshots in enumerate(zip(*runs, strict=True), 1):
        if k % CHECK_EVERY == 0 or k == len(runs[0]):
            t = snapshots[0].t
            maps = dict(known + [(s.robs[0].id, _places(s)) for s in snapshots])
            frames = chain(maps, misfit)
            if len(frames) == len(wanted):
                return frames, t
    why = "; ".join(_unlinked(maps, id, t) for id in wanted if id not in frames)
    raise ValueError(f"{why}; so the log does not tell where they start; give each robot its position and orientation")


def _unlinked(maps, robot, t):
    """Words on a robot that could not be placed: what it has seen with the others is too little, or does not fit."""
    others = {i for other, places in maps.items() if other != robot for i in places}
    n = len(maps[robot].keys() & others)
    if n < COMMON:
        return (
            f"the map of robot {robot} has {n} landmarks in common with those of the others after {t:.0f} s, "
            f"and {COMMON} are needed"
        )
    return (
        f"the map of robot {robot} has {n} landmarks in common with those of the others, but no placing of it fits "
        "them: are mounting, sign of y and bearings, and ids right?"
    )


def _alone(data, robot, at_origin):
    """The scenario with one robot that makes a map of its own, from its start or from the origin."""
    origin = {"position": [0.0] * data.frame.dim, "orientation_deg": None}
    origin |= {"position_std": 0.0, "orientation_std_deg": 0.0}
    return replace(
        data,
        robots=[replace(robot, **origin) if at_origin else robot],
        sensors=[s for s in data.sensors if s.robot == robot.id],
        landmark=replace(data.landmark, in_map=True, surveyed=[]),
        time=replace(data.time, last=None),  # the starts need as much of the log as they need, however short the run
    )


def _surveyed(recording):
    """The known map: id -> point."""
    if recording.landmarks is None:
        raise ValueError(f"the recording {recording.name!r} has no landmarks, so nothing can be localised on them")
    return dict(zip(recording.landmarks.ids.tolist(), recording.landmarks.points, strict=True))


def _places(snapshot):
    """Landmarks of a map that have been used often: id -> point."""
    return {i: lmk.point(snapshot.map)[0] for i, lmk in snapshot.lmks.items() if lmk.n_inlier >= SEEN}


def chain(maps, misfit=MISFIT):
    """Lay maps on the first one, one after the other; each time the one that has most in common with those laid.

    Parameters
    ----------
    maps : dict of int to (dict of int to ndarray)
        For each robot, its landmarks: id -> point in its own frame, metres.
    misfit : float
        See `find_starts`.

    Returns
    -------
    dict of int to Frame2 or Frame3
        The frames of the other maps, seen from the first one; those that cannot be linked are missing.
    """
    (_, laid), *others = maps.items()
    waiting, frames = dict(others), {}
    while waiting:
        robot = max(waiting, key=lambda i: len(waiting[i].keys() & laid.keys()))
        places = waiting.pop(robot)
        F = _link(places, laid, misfit)
        if F is not None:
            frames[robot] = F
            laid = {i: F.from_frame(p)[0] for i, p in places.items()} | laid
            waiting |= {i: p for i, p in others if i not in frames and i != robot}  # for these there is more now
    return frames


def _link(places, laid, misfit):
    """The frame that lays one map on another by their common landmarks; the worst ones are left out. None: no link."""
    common = sorted(places.keys() & laid.keys())
    while len(common) >= COMMON:
        a, b = (np.array([m[i] for i in common]) for m in (places, laid))
        try:
            F = align(a, b)
        except ValueError:  # all in one place
            return None
        apart = np.linalg.norm(F.from_frame(a)[0] - b, axis=1)
        if np.sqrt((apart**2).mean()) <= misfit:
            return F
        common.pop(int(apart.argmax()))
    return None
