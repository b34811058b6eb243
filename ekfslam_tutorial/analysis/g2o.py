"""Graphs of g2o, and the marginal covariances of what is in them.

A file that g2o has optimised and written holds the estimate, the measurements and their information, but not the
covariances. They are the blocks of the inverse of the Hessian H = sum J' Omega J at the estimate, with one pose held
(that of a FIX line, else the first): what `computeMarginals` of g2o returns. R. Kuemmerle, G. Grisetti, H. Strasdat,
K. Konolige, W. Burgard, "g2o: A general framework for graph optimization", ICRA 2011, eqs. 9 to 11.
"""

from pathlib import Path

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.linalg import splu

from ..geometry import Frame2, Frame3, v2q
from .estimates import Estimate

VERTICES = {"VERTEX_SE2": 3, "VERTEX_SE3:QUAT": 7, "VERTEX_XY": 2, "VERTEX_TRACKXYZ": 3}
EDGES = {"EDGE_SE2": (3, 3), "EDGE_SE3:QUAT": (7, 6), "EDGE_SE2_XY": (2, 2), "EDGE_SE3_TRACKXYZ": (3, 3)}
"""Numbers of a measurement, and of its error."""
POSES = "VERTEX_SE2", "VERTEX_SE3:QUAT"
STEP = 1e-6
COLUMNS = 256
"""So many columns of the inverse are computed at a time."""


def read_g2o(path, marginals=True):
    """Read an optimised graph: poses in the order of their ids, which are their stamps, and landmarks.

    Parameters
    ----------
    path : path
    marginals : bool
        Compute the covariances; without, the file is a truth and needs no edges.

    Returns
    -------
    Estimate
        Poses in mixed axes, landmarks with their joint covariance.

    Raises
    ------
    ValueError
        If a line cannot be read, a vertex is missing, or the edges do not fix all vertices.
    """
    vertices, edges, fixed = _read(path)
    poses = sorted(id for id, (kind, _) in vertices.items() if kind in POSES)
    points = sorted(id for id, (kind, _) in vertices.items() if kind not in POSES)
    if not poses:
        raise ValueError(f"{path} has no poses: no line {' or '.join(POSES)}")
    frame = Frame2 if vertices[poses[0]][0] == "VERTEX_SE2" else Frame3
    x = frame(np.array([vertices[id][1] for id in poses]))
    places = np.array([vertices[id][1] for id in points]).reshape(-1, frame.dim)
    if not marginals:
        return Estimate(Path(path).name, x, np.array(poses, float), ids=points, points=places)
    if not edges:
        raise ValueError(f"{path} has no edges: covariances cannot be computed without measurements")
    P, joint = _marginals(path, vertices, edges, fixed or [poses[0]], poses, points, frame)
    return Estimate(Path(path).name, x, np.array(poses, float), P, ids=points, points=places, points_P=joint)


def _read(path):
    vertices, edges, fixed = {}, [], []
    for k, line in enumerate(Path(path).read_text(encoding="utf-8").splitlines(), 1):
        words = line.split()
        if not words or words[0].startswith("#") or words[0].startswith("PARAMS"):
            continue
        try:
            if words[0] in VERTICES:
                vertices[int(words[1])] = words[0], _state(words[0], [float(w) for w in words[2:]])
            elif words[0] in EDGES:
                edges.append(_edge(words))
            elif words[0] == "FIX":
                fixed += [int(w) for w in words[1:]]
            else:
                raise ValueError(f"{words[0]} is not known; known: {', '.join([*VERTICES, *EDGES, 'FIX'])}")
        except (ValueError, IndexError) as error:
            raise ValueError(f"{path}, line {k}: {error}") from error
    lost = {id for _, ids, _, _ in edges for id in ids} - set(vertices)
    if lost:
        raise ValueError(f"{path}: edges to vertices that are not there: {', '.join(map(str, sorted(lost)[:5]))}")
    return vertices, edges, fixed


def _state(kind, numbers):
    if len(numbers) != VERTICES[kind] or not np.isfinite(numbers).all():
        raise ValueError(f"{kind} needs {VERTICES[kind]} finite numbers, got {len(numbers)}")
    x = np.array(numbers)
    if kind == "VERTEX_SE3:QUAT":
        if abs(np.linalg.norm(x[3:]) - 1) > 1e-3:
            raise ValueError(f"the quaternion has the length {np.linalg.norm(x[3:]):.4g}, not 1")
        x[3:] = np.r_[x[6], x[3:6]] / np.linalg.norm(x[3:])
    return x


def _edge(words):
    kind = words[0]
    size, dof = EDGES[kind]
    numbers = [float(w) for w in words[3:]]
    extra = kind == "EDGE_SE3_TRACKXYZ" and len(numbers) == 1 + size + dof * (dof + 1) // 2  # the number of a parameter
    numbers = numbers[1:] if extra else numbers
    if len(numbers) != size + dof * (dof + 1) // 2 or not np.isfinite(numbers).all():
        raise ValueError(f"{kind} needs {size} numbers and {dof * (dof + 1) // 2} of its information, all finite")
    Omega = np.empty((dof, dof))
    i, j = np.triu_indices(dof)
    Omega[i, j] = Omega[j, i] = numbers[size:]
    z = np.array(numbers[:size])
    if kind == "EDGE_SE3:QUAT":
        z[3:] = np.r_[z[6], z[3:6]] / np.linalg.norm(z[3:])
    return kind, (int(words[1]), int(words[2])), z, Omega


def _marginals(path, vertices, edges, fixed, poses, points, frame):
    """Covariances of the poses (F, dof, dof), zero for a held one, and the joint one of the points."""
    size = {id: frame.dof if kind in POSES else frame.dim for id, (kind, _) in vertices.items()}
    free = [id for id in [*poses, *points] if id not in fixed]
    start = dict(zip(free, np.cumsum([0, *(size[id] for id in free)]), strict=False))
    n = sum(size[id] for id in free)
    H = _hessian(vertices, edges, start, size, n, frame)
    try:
        solve = splu(H.tocsc()).solve
    except RuntimeError as error:
        raise ValueError(f"{path}: the edges do not fix all vertices: the Hessian is singular") from error
    P = np.zeros((len(poses), frame.dof, frame.dof))
    at = {id: k for k, id in enumerate(poses)}
    first = start[next((id for id in points if id in start), None)] if any(id in start for id in points) else n
    joint = np.zeros((frame.dim * len(points),) * 2)
    for a in range(0, n, COLUMNS):
        some = np.arange(a, min(a + COLUMNS, n))
        E = np.zeros((n, len(some)))
        E[some, some - a] = 1.0
        C = solve(E)
        for id in poses:
            s = start.get(id)
            if s is not None:
                inside = (some >= s) & (some < s + frame.dof)
                P[at[id], :, some[inside] - s] = C[s : s + frame.dof, inside].T
        if some[-1] >= first and len(joint) == n - first:
            joint[:, some[some >= first] - first] = C[first:, some >= first]
    if not np.isfinite(P).all() or (np.linalg.eigvalsh(P)[:, 0] < -1e-6 * np.abs(P).max()).any():
        raise ValueError(f"{path}: the edges do not fix all vertices: the Hessian is singular")
    return P, joint if len(points) and len(joint) == n - first else None


def _hessian(vertices, edges, start, size, n, frame):
    """H = sum J' Omega J, sparse, of all edges of a kind at once."""
    rows, columns, values = [], [], []
    for kind in {edge[0] for edge in edges}:
        some = [edge for edge in edges if edge[0] == kind]
        J = [_jacobian(kind, side, vertices, some, frame) for side in (0, 1)]
        Omega = np.array([edge[3] for edge in some])
        for a in (0, 1):
            for b in (0, 1):
                blocks = np.swapaxes(J[a], 1, 2) @ Omega @ J[b]
                for edge, block in zip(some, blocks, strict=True):
                    i, j = start.get(edge[1][a]), start.get(edge[1][b])
                    if i is not None and j is not None:
                        r, c = np.indices(block.shape)
                        rows.append((i + r).ravel())
                        columns.append((j + c).ravel())
                        values.append(block.ravel())
    shape = rows and (np.concatenate(rows), np.concatenate(columns))
    return coo_array((np.concatenate(values), shape), shape=(n, n))


def _jacobian(kind, side, vertices, edges, frame):
    """Derivative of the errors of edges by one of their two vertices: in mixed axes; by central differences."""
    x = [np.array([vertices[edge[1][k]][1] for edge in edges]) for k in (0, 1)]
    z = np.array([edge[2] for edge in edges])
    point = side == 1 and kind.endswith("XY") or side == 1 and kind.endswith("XYZ")
    dof = frame.dim if point else frame.dof
    columns = []
    for k in range(dof):
        ends = []
        for sign in (STEP, -STEP):
            moved = list(x)
            step = sign * np.eye(dof)[k]
            moved[side] = x[side] + step if point or frame is Frame2 else _turned(x[side], step)
            ends.append(_error(kind, moved[0], moved[1], z, frame))
        columns.append((ends[0] - ends[1]) / (2 * STEP))
    return np.stack(columns, -1)


def _turned(x, step):
    q = Frame3(x).compose(Frame3(np.broadcast_to(np.r_[0, 0, 0, v2q(step[3:])[0]], x.shape)))[0].q
    return np.concatenate([x[:, :3] + step[:3], q], 1)


def _error(kind, a, b, z, frame):
    """Errors of edges as g2o defines them, up to a constant: in space with the vector part of the quaternion."""
    A = frame(a)
    if kind in ("EDGE_SE2_XY", "EDGE_SE3_TRACKXYZ"):
        return A.to_frame(b)[0] - z
    between = A.inverse()[0].compose(frame(b))[0]
    e = frame(z).inverse()[0].compose(between)[0]
    if frame is Frame2:
        return e.normalized()[0].x
    return e.x[:, [0, 1, 2, 4, 5, 6]] * np.where(e.x[:, 3:4] < 0, [1, 1, 1, -1, -1, -1], 1.0)
