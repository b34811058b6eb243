"""The graph of a run for other programs: as text for g2o, or as a program for GTSAM.

Both know poses and points only: a step of a robot becomes an edge between two poses, a measurement an edge from a pose
to a point in its frame. So a measurement in polar coordinates is linearised where it was made, and what cannot be said
so is refused: a sensor that measures directions only, a state with velocities.
"""

from typing import NamedTuple

import numpy as np

from ..geometry import Frame2
from .factors import Motion, Prior

FORMATS = "g2o", "gtsam"
LEAST = 1e-9
"""Variance of an edge where the models have none, m^2 or rad^2: neither program takes a singular covariance."""
APART = 1_000_000
"""Between the numbers of the vertices of two robots: pose k of robot r is r - 1 times that, plus k; landmark i is 1000
times that, plus i."""


class Parts(NamedTuple):
    """Content that both formats can hold: poses and points by number, those that are known, and edges.

    Parameters
    ----------
    frame : type
        Frame2 or Frame3.
    poses, points : dict of int to ndarray
    fixed : list of int
    steps : list of (int, int, ndarray, ndarray)
        From, to, relative pose, covariance of its error in its own axes; angles as rotation vectors.
    looks : list of (int, int, ndarray, ndarray)
        Pose, point, point in the frame of the robot, covariance.
    """

    frame: type
    poses: dict
    points: dict
    fixed: list
    steps: list
    looks: list


def parts_of(graph):
    """The poses, points and edges of a graph.

    Raises
    ------
    ValueError
        For what has no edge.
    """
    frame = next(iter(graph.frames.values()))
    parts = Parts(frame, {}, {}, [], [], [])
    for key, x in graph.values.items():
        if key[0] == "robot":
            if len(x) != frame.size:
                raise ValueError(
                    f"robot {key[1]} has velocities in its state: a graph of poses cannot say how it moves"
                )
            parts.poses[_number(key)] = x
        elif key[0] == "landmark":
            parts.points[_number(key)] = graph.types[key[1]].point(x)[0]
    for factor in graph.stiff:
        if isinstance(factor, Prior) and factor.keys[0][0] == "robot":
            parts.fixed.append(_number(factor.keys[0]))
        elif isinstance(factor, Motion):
            parts.steps.append((_number(factor.before), _number(factor.after), *_step(graph, factor)))
        elif isinstance(factor, Prior) and factor.keys[0][0] == "landmark":
            raise ValueError(f"landmark {factor.keys[0][1]} is surveyed: there is no edge for that")
        elif not isinstance(factor, Prior):
            raise ValueError(f"{type(factor.sensor).__name__} measures directions only: there is no edge for it")
    for n, look in enumerate(graph.looks):
        _look(graph, look, parts, n)
    return parts


def _number(key):
    if key[0] == "landmark":
        return 1000 * APART + key[1]
    return (key[1] - 1) * APART + key[2]


def _step(graph, factor):
    """Relative pose of a step, and the covariance of its error, position and rotation vector."""
    frame = factor.motion.frame
    x = graph.values[factor.before]
    after, _, X_u = factor.motion.move(x, factor.u, factor.dt)
    I = frame(x).inverse()[0]
    Z, _, Z_a = I.compose(frame(after))
    Z, N = Z.normalized()
    E_z = Z.inverse()[0].compose(Z)[2]  # the error in the axes of the step itself
    rows = slice(None) if frame is Frame2 else [0, 1, 2, 4, 5, 6]
    J = (E_z @ N @ Z_a @ X_u)[rows]
    if frame is not Frame2:
        J[3:] *= 2  # a rotation vector is twice the vector part of a small quaternion
    return Z.x, J @ factor.U @ J.T + LEAST * np.eye(len(J))


def _look(graph, look, parts, n):
    """Edges of what one sensor saw in one frame."""
    sensor, Sf = look.sensor, list(graph.both(look))[1]
    if sensor.bearing_only or not hasattr(sensor, "retro"):
        what = "directions only" if sensor.bearing_only else "no places"
        raise ValueError(f"{type(sensor).__name__} measures {what}: there is no edge for it")
    pose = _number(look.pose) if isinstance(look.pose, tuple) else 900 * APART + n
    if not isinstance(look.pose, tuple):
        parts.poses[pose] = look.pose
        parts.fixed.append(pose)
    for lmk, y, R in zip(look.lmks, look.y, look.R, strict=True):
        if isinstance(lmk, tuple) and lmk[0] == "robot":
            raise ValueError("robots that see each other: a graph of poses and points has no edge for it")
        v, V_y = sensor.retro(np.concatenate([y, getattr(Sf, "a", ())]))  # with parameters, as estimated
        p, _, P_v = Sf.from_frame(v)
        J = P_v @ V_y[:, : len(y)]
        point = _number(lmk) if isinstance(lmk, tuple) else _known(lmk, parts)
        parts.looks.append((pose, point, p, J @ R @ J.T + LEAST * np.eye(len(p))))


def _known(place, parts):
    """The number of a known landmark, which is held."""
    there = next((i for i, p in parts.points.items() if i >= 2000 * APART and (p == place).all()), None)
    number = 2000 * APART + len(parts.points) if there is None else there
    if there is None:
        parts.points[number] = place
        parts.fixed.append(number)
    return number


def g2o_text(graph):
    """The graph as text for g2o: VERTEX_SE2 and VERTEX_XY, or VERTEX_SE3:QUAT and VERTEX_TRACKXYZ, and their edges.

    Parameters
    ----------
    graph : Graph
        The values are its present estimate; the start of each robot is held (FIX).

    Returns
    -------
    str

    Raises
    ------
    ValueError
        For what has no edge.

    See Also
    --------
    read_g2o : Reads it, and what g2o has made of it.
    """
    parts = parts_of(graph)
    flat = parts.frame is Frame2
    pose, point = ("VERTEX_SE2", "VERTEX_XY") if flat else ("VERTEX_SE3:QUAT", "VERTEX_TRACKXYZ")
    step, look = ("EDGE_SE2", "EDGE_SE2_XY") if flat else ("EDGE_SE3:QUAT", "EDGE_SE3_TRACKXYZ")
    order = slice(None) if flat else [0, 1, 2, 4, 5, 6, 3]  # the scalar of a quaternion comes last
    half = np.ones(3) if flat else np.array([1, 1, 1, 2, 2, 2])  # errors of g2o are vector parts of quaternions
    lines = [] if flat else ["PARAMS_SE3OFFSET 0 0 0 0 0 0 0 1"]
    lines += [f"{pose} {i} {_row(x[order])}" for i, x in sorted(parts.poses.items())]
    lines += [f"{point} {i} {_row(p)}" for i, p in sorted(parts.points.items())]
    for a, b, z, P in parts.steps:
        lines.append(f"{step} {a} {b} {_row(z[order])} {_upper(half[:, None] * np.linalg.inv(P) * half)}")
    extra = "" if flat else "0 "
    lines += [f"{look} {a} {b} {extra}{_row(p)} {_upper(np.linalg.inv(P))}" for a, b, p, P in parts.looks]
    lines += [f"FIX {i}" for i in parts.fixed]  # the last lines: GTSAM reads no farther than the first of them
    return "\n".join(lines) + "\n"


def _row(values):
    return " ".join(f"{v:.17g}" for v in values)


def _upper(A):
    return _row(A[np.triu_indices(len(A))])


SCRIPT = '''"""The graph of a run for GTSAM: `graph` and `initial`. Run by itself it optimises and prints the last pose.

Written by `ekfslam graph RUN --to gtsam`. Needs gtsam 4.2 or newer.
"""

import gtsam
import numpy as np

{tables}

graph, initial = gtsam.NonlinearFactorGraph(), gtsam.Values()
gaussian = gtsam.noiseModel.Gaussian.Covariance
{body}

if __name__ == "__main__":
    found = gtsam.LevenbergMarquardtOptimizer(graph, initial).optimize()
    print("error", graph.error(initial), "->", graph.error(found))
    print(found.at{pose}(max(POSES)))
'''
PLANE = """

def seen(place):
    # error of a point as the robot sees it, and its derivatives
    def error(factor, values, H):
        pose, point = values.atPose2(factor.keys()[0]), values.atPoint2(factor.keys()[1])
        J = np.zeros(({dim}, {pose_dof}), order="F"), np.zeros(({dim}, {dim}), order="F")
        e = pose.transformTo(point, *J) - place
        for k in range(0 if H is None else 2):
            H[k] = J[k]
        return e

    return error


for i, x in POSES.items():
    initial.insert(i, gtsam.Pose2(*x))
for i, p in POINTS.items():
    initial.insert(i, np.array(p))
for i in FIXED:
    known = gtsam.noiseModel.Isotropic.Sigma({pose_dof} if i in POSES else {dim}, 1e-6)
    if i in POSES:
        graph.add(gtsam.PriorFactorPose2(i, initial.atPose2(i), known))
    else:
        graph.add(gtsam.PriorFactorPoint2(i, initial.atPoint2(i), known))
for a, b, z, P in STEPS:
    graph.add(gtsam.BetweenFactorPose2(a, b, gtsam.Pose2(*z), gaussian(np.array(P))))
for a, b, p, P in LOOKS:
    graph.add(gtsam.CustomFactor(gaussian(np.array(P)), [a, b], seen(np.array(p))))
"""


def gtsam_script(graph):
    """The graph as a Python program that makes it for GTSAM.

    Parameters
    ----------
    graph : Graph

    Returns
    -------
    str

    Raises
    ------
    ValueError
        For what has no edge.
    """
    parts = parts_of(graph)
    flat = parts.frame is Frame2
    swap = np.arange(3) if flat else np.array([3, 4, 5, 0, 1, 2])  # GTSAM has the rotation first
    steps = [(a, b, z.tolist(), P[np.ix_(swap, swap)].tolist()) for a, b, z, P in parts.steps]
    tables = {
        "POSES": {i: x.tolist() for i, x in sorted(parts.poses.items())},
        "POINTS": {i: p.tolist() for i, p in sorted(parts.points.items())},
        "FIXED": parts.fixed,
        "STEPS": steps,
        "LOOKS": [(a, b, p.tolist(), P.tolist()) for a, b, p, P in parts.looks],
    }
    body = PLANE.format(pose_dof=parts.frame.dof, dim=parts.frame.dim)
    if not flat:
        pose = "gtsam.Pose3(gtsam.Rot3.Quaternion(*{0}[3:]), np.array({0}[:3]))"
        for x in "xz":
            body = body.replace(f"gtsam.Pose2(*{x})", pose.format(x))
        body = body.replace("Pose2", "Pose3").replace("Point2", "Point3")
    lines = "\n".join(f"{name} = {_table(value)}" for name, value in tables.items())
    return SCRIPT.format(tables=lines, body=body.strip("\n"), pose="Pose2" if flat else "Pose3")


def _table(value):
    """A table as Python text, a line for each entry."""
    entries = [f"{k}: {v!r}" for k, v in value.items()] if isinstance(value, dict) else map(repr, value)
    inside = [f"    {entry},\n" for entry in entries]
    opening, closing = "{}" if isinstance(value, dict) else "[]"
    return f"{opening}\n{''.join(inside)}{closing}" if inside else opening + closing
