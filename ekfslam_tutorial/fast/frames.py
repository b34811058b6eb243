"""Frames of robots and sensors: the same object as long as it stays the same."""

from math import pi

import numpy as np

from ..geometry import wrap
from .extra import compiled
from .filter import transform
from .refused import FLOAT
from .straight import oriented


def state_of(map, obj):
    """Return the state of a robot or a sensor, an array of floats, not to be written to."""
    if obj.r is not None:
        return map.state(obj.r)
    return obj.x if type(obj.x) is np.ndarray and obj.x.dtype == FLOAT else np.asarray(obj.state(map), float)


def frame_of(map, obj, kind):
    """Return the frame, of this kind, that the state of a robot or a sensor begins with."""
    noted, x = map.notes.of(obj), state_of(map, obj)
    last = noted.frame
    if len(x) != kind.size:
        x = x[: kind.size] if len(x) > kind.size else kind(x).x  # which refuses it
    if last is None or type(last) is not kind or last.x.tobytes() != x.tobytes():
        noted.frame = last = object.__new__(kind)  # it need not be looked at again
        vars(last)["x"] = x.copy() if obj.r is None else x  # who holds a known state may write to it
    return last


def normal_frame(map, obj, kind):
    """Return the frame in its normal form, as `normalize` left it, unless it has been changed since the last motion.

    A correction by another robot moves it, too. Twice gives other last bits than once, so what was normalised before a
    motion counts no more: a run that is taken up from a file ends as if it had not been stopped.
    """
    F = frame_of(map, obj, kind)
    if obj.r is None or (-pi < F.x.item(2) < pi if kind.dim == 2 else F is map.notes.of(obj).normal):
        return F
    normalize(map, obj, kind)
    return frame_of(map, obj, kind)


def normalize(map, obj, kind):
    """Bring the frame of a robot or sensor in the map to its normal form: unit quaternion, wrapped heading."""
    if obj.r is None:
        return
    if kind.dim == 2:
        theta = map.entry(obj.r.start + 2)
        if not -pi < theta < pi:  # whole turns are added to the heading, which changes no covariance
            map.set_mean(slice(obj.r.start + 2, obj.r.start + 3), wrap([theta]))
        return
    o = slice(obj.r.start + kind.dim, obj.r.start + kind.size)  # the orientation; the position stays as it is
    if not map.compiled or not compiled().normalized(map, obj.r, kind):
        transform(map, o, *oriented(frame_of(map, obj, kind)))
    map.notes.of(obj).normal = frame_of(map, obj, kind)


def frame_range(obj, F):
    """Return the range of the frame in the map; a robot's state may have velocities behind it."""
    r = obj.r
    return r if r is None or r.stop - r.start == F.size else slice(r.start, r.start + F.size)


def camera_position(Rf, Sf):
    """Return where the sensor is in the world."""
    return Rf.R.dot(Sf.t) + Rf.t


def normalized_state(motion, x):
    """Return the state of a robot with its frame in the normal form."""
    n = motion.frame.size
    return np.concatenate([motion.frame(x[:n]).normalized()[0].x, x[n:]])
