"""Frames of robots and sensors: the same object as long as it stays the same."""

from math import pi

import numpy as np

from .extra import compiled
from .filter import transform
from .straight import oriented


def frame_of(map, obj, kind):
    """Return the frame, of this kind, that the state of a robot or a sensor begins with."""
    noted, x = map.notes.of(obj), np.asarray(obj.state(map), float) if obj.r is None else map.state(obj.r)
    if len(x) != kind.size:
        x = x[: kind.size]
    last = noted.frame
    if last is None or type(last) is not kind or last.x.tobytes() != x.tobytes():
        noted.frame = last = object.__new__(kind)  # it need not be looked at again
        vars(last)["x"] = x
    return last


def normal_frame(map, obj, kind):
    """Return the frame in its normal form, as `normalize` left it, unless it has been changed since the last motion.

    A correction by another robot moves it, too. Twice gives other last bits than once, so what was normalised before a
    motion counts no more: a run that is taken up from a file ends as if it had not been stopped.
    """
    F = frame_of(map, obj, kind)
    return F if F is map.notes.of(obj).normal else normalize(map, obj, kind)


def normalize(map, obj, kind):
    """Bring the frame of a robot or sensor in the map to its normal form: unit quaternion, wrapped heading.

    Returns
    -------
    Frame2 or Frame3
        The frame.
    """
    F = frame_of(map, obj, kind)
    if obj.r is None or (F.dim == 2 and -pi < F.x.item(2) < pi):
        return F
    o = slice(obj.r.start + F.dim, obj.r.start + F.size)  # the orientation; the position stays as it is
    if F.dim == 2:  # whole turns are added to the heading, which changes no covariance
        map.set_mean(o, F.normalized()[0].x[F.dim :])
    elif not map.compiled or not compiled().normalized(map, obj.r, type(F)):
        transform(map, o, *oriented(F))
    map.notes.of(obj).normal = F = frame_of(map, obj, kind)
    return F


def frame_range(obj, F):
    """Return the range of the frame in the map; a robot's state may have velocities behind it."""
    return None if obj.r is None else slice(obj.r.start, obj.r.start + F.size)


def camera_position(Rf, Sf):
    """Return where the sensor is in the world."""
    return Rf.R.dot(Sf.t) + Rf.t


def normalized_state(motion, x):
    """Return the state of a robot with its frame in the normal form."""
    n = motion.frame.size
    return np.concatenate([motion.frame(x[:n]).normalized()[0].x, x[n:]])
