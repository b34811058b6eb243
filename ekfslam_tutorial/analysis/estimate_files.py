"""Files of poses with covariances, of any program: text in columns, with or without names.

One row for each pose, numbers between spaces or commas, a line that begins with # is a remark. Without names in the
first line the number of columns tells what they are; angles in radians, quaternions with the scalar last.

    4   t x y theta                                           a truth in the plane
    8   t x y z qx qy qz qw                                   TUM: a truth in space
   10   t x y theta, then the upper triangle of P             6 numbers by rows
   13   t x y theta, then P                                   9 numbers
   20   t x y z qx qy qz qw, P of rotation, P of position     OpenVINS: 6 numbers each, upper triangles
   29   t x y z qx qy qz qw, then the upper triangle of P     21 numbers; SQUARE, with its #% head: the lower one
   44   t x y z qx qy qz qw, then P                           36 numbers, as in ROS
   12   KITTI: [R t] by rows; times in NAME-times.txt         a truth in space

Files of EuRoC are known by their first line, #timestamp: nanoseconds, position, quaternion with the scalar first; what
comes behind is left out. Where a file has no covariances, NAME-cov.txt beside it may have them: in each row an upper
triangle, of 6 or 21 numbers, as `ekfslam export` writes it.
"""

import re
from pathlib import Path

import numpy as np

from ..geometry import Frame2, Frame3, R2q
from .estimates import Estimate

AXES_2, AXES_3 = ["x", "y", "theta"], ["x", "y", "z", "rx", "ry", "rz"]
POSE_2, POSE_3 = ["t", "x", "y", "theta"], ["t", "x", "y", "z", "qx", "qy", "qz", "qw"]
EUROC = ["t", "x", "y", "z", "qw", "qx", "qy", "qz"]
FLAT = 1e-6
"""Variance of height, roll and pitch of a pose in the plane that is written as one in space."""
OTHER_NAMES = {
    **dict.fromkeys(["time", "timestamp", "stamp", "time_s", "#t"], "t"),
    **dict.fromkeys(["yaw", "heading", "th"], "theta"),
    **dict.fromkeys(["tx", "px"], "x"),
    **dict.fromkeys(["ty", "py"], "y"),
    **dict.fromkeys(["tz", "pz"], "z"),
    **dict(zip("abcd", ["qw", "qx", "qy", "qz"], strict=True)),
}
UNIT, SYMMETRIC = 1e-3, 1e-6
"""A quaternion may be as long as 1 +- this, and P as asymmetric, relative to its largest entry."""


def read_estimate(path, axes="mixed", rotation_first=False):
    """Read poses with covariances.

    Parameters
    ----------
    path : path
    axes : str
        What the covariances are about: see `estimates.AXES`.
    rotation_first : bool
        Rows and columns of P begin with the angles, as GTSAM has them in space.

    Returns
    -------
    Estimate

    Raises
    ------
    ValueError, OSError
        One sentence that names the file, and what is wrong with it.
    """
    names, rows, square = _named_table(path)
    x = _poses(path, names, rows)
    P = _covariances(path, names, rows, AXES_2 if x.dim == 2 else AXES_3)
    P = _beside(path, len(rows), x) if P is None else P
    if P is None:
        raise ValueError(f"{path} has no covariances: {_columns(names)}; a NEES needs all of P")
    if rotation_first or square == "rotation_translation":
        order = np.r_[x.dof - x.dim : x.dof, : x.dof - x.dim]
        P = P[:, order][:, :, order]
    P = _checked(path, P)
    return Estimate(
        Path(path).name, x, _column(names, rows, "t"), P, "body" if square else axes, _truth_beside(path, names, rows)
    )


def read_truth(path):
    """Read true poses: an `Estimate` without covariances. Raises as `read_estimate`."""
    names, rows, _ = _named_table(path)
    return Estimate(Path(path).name, _poses(path, names, rows), _column(names, rows, "t"))


def with_truth(estimate, truth, most=0.01):
    """Return the poses of an estimate that have a true one at the same time, with it.

    Parameters
    ----------
    estimate, truth : Estimate
    most : float
        The stamps may differ by so many seconds.

    Raises
    ------
    ValueError
        If none do, or one is in the plane and the other in space.
    """
    if estimate.x.dim != truth.x.dim:
        raise ValueError(f"{estimate.name} and its truth {truth.name} are not both in the plane, or both in space")
    after = np.searchsorted(truth.t, estimate.t)
    left, right = (np.clip(k, 0, len(truth.t) - 1) for k in (after - 1, after))
    at = np.where(np.abs(truth.t[left] - estimate.t) <= np.abs(truth.t[right] - estimate.t), left, right)
    rows = np.flatnonzero(np.abs(truth.t[at] - estimate.t) <= most)
    if not len(rows):
        spans = [f"{a.t[0]:.3f} to {a.t[-1]:.3f} s" for a in (estimate, truth)]
        raise ValueError(
            f"no stamp of {estimate.name} ({spans[0]}) is within {most:g} s of one of {truth.name} ({spans[1]})"
        )
    met = estimate.part(rows)
    return Estimate(**{**vars(met), "truth": type(truth.x)(truth.x.x[at[rows]])})


def read_map(path, truth=None):
    """Read landmarks with covariances.

    Parameters
    ----------
    path : path
        Columns id, x, y (and z), P_xx, P_xy, P_yy ..., and true_x, true_y where known: as `ekfslam run` writes map.csv.
    truth : path, optional
        Another file with the true places: id, x, y (and z).

    Returns
    -------
    ids, points (n, d), covariances (n, d, d), true places (n, d)
        Those whose true place is known, by id.
    """
    ids, points, P, places = _landmarks(path)
    if P is None:
        raise ValueError(f"{path} has no covariances P_xx, P_xy ... of its landmarks")
    known = dict(zip(ids, places, strict=True)) if places is not None else {}
    if truth is not None:
        known = dict(zip(*_landmarks(truth)[:2], strict=True))
    have = [k for k, id in enumerate(ids) if id in known and np.isfinite(known[id]).all()]
    if not have:
        raise ValueError(
            f"no landmark of {path} has a true place" + (f" in {truth}" if truth else ": no true_x, true_y")
        )
    have.sort(key=lambda k: ids[k])
    return [ids[k] for k in have], points[have], P[have], np.array([known[ids[k]] for k in have])


def read_innovations(path):
    """Read innovations: columns t, z (m numbers), then Z, the upper triangle of their covariance.

    Returns
    -------
    z : ndarray, shape (K, m)
        Whitened.
    nis : ndarray, shape (K, 2)
        Squared, and their degrees of freedom.
    """
    names, rows, _ = _table(path)
    sizes = {1 + m + m * (m + 1) // 2: m for m in range(1, 7)}
    if rows.shape[1] not in sizes:
        raise ValueError(f"{path}: innovations have {', '.join(map(str, sizes))} columns, got {rows.shape[1]}")
    m = sizes[rows.shape[1]]
    Z = _checked(path, _triangle(rows[:, 1 + m :], m))
    L = np.linalg.cholesky(Z)
    z = np.linalg.solve(L, rows[:, 1 : 1 + m, None])[..., 0]
    return z, np.column_stack([(z**2).sum(1), np.full(len(z), m)])


# --- text ---


def _table(path):
    """Names of the columns or None, the numbers, and the order of a SQUARE file or None."""
    try:
        text = Path(path).read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise ValueError(f"{path} is not text") from error
    square = None
    if re.search(r"^#%\s*FORMAT\s+SQUARE", text, re.M):
        head = dict(re.findall(r"^#%\s*(\w+)\s+(\S+)", text, re.M))
        if head.get("REPRESENTATION") != "gaussian_se3" or head.get("TANGENT_CONVENTION") != "right_perturbation":
            raise ValueError(f"{path}: of SQUARE files only gaussian_se3 with right_perturbation can be read")
        square = head.get("TANGENT_ORDER", "translation_rotation")
    lines = [(k, line) for k, line in enumerate(text.splitlines(), 1) if line.strip() and not line.startswith("#")]
    if not lines:
        raise ValueError(f"{path} has no rows")
    comma = "," if "," in lines[0][1] else None
    split = lambda line: [cell.strip() for cell in line.split(comma)]
    names = None
    if not _is_number(split(lines[0][1])[0]):
        names = [OTHER_NAMES.get(name.lower(), name.lower()) for name in split(lines[0][1])]
        lines = lines[1:]
        twice = sorted({str(name) for name in names if names.count(name) > 1})
        if twice:
            raise ValueError(f"{path} has two columns of the same name: {', '.join(twice)}")
    if not lines:
        raise ValueError(f"{path} has no rows")
    wanted = len(names) if names else len(split(lines[0][1]))
    rows = np.empty((len(lines), wanted))
    for row, (k, line) in zip(rows, lines, strict=True):
        cells = split(line)
        if len(cells) != wanted:
            raise ValueError(f"{path}, line {k}: {len(cells)} columns, and {wanted} before")
        for i, cell in enumerate(cells):
            blank = cell == "" and names is not None and str(names[i]).startswith("true_")
            word = names is not None and not _is_number(cell) and names[i] in ("type", "robot", "name", "id")
            if not (blank or word or _is_number(cell)):
                raise ValueError(f"{path}, line {k}: {cell!r} is no number")
            row[i] = np.nan if blank or word else float(cell)
            if not (blank or word or np.isfinite(row[i])):
                raise ValueError(
                    f"{path}, line {k}: {cell} in column {names[i] if names else i + 1}; all must be finite"
                )
    return names, rows, square


def _named_table(path):
    """The same with names in any case, and files of EuRoC and KITTI in the form of the others."""
    names, rows, square = _table(path)
    if names is not None:
        return names, rows, square
    with open(path, encoding="utf-8") as file:
        first = file.readline()
    if re.match(r"#\s*timestamp", first) and rows.shape[1] >= 8:
        return EUROC, np.column_stack([1e-9 * rows[:, 0], rows[:, 1:8]]), None
    if rows.shape[1] == 12:
        return POSE_3, _kitti(path, rows.reshape(-1, 3, 4)), None
    return _names(path, rows.shape[1], square), rows, square


def _kitti(path, poses):
    """Rows t x y z qx qy qz qw of matrices [R t], with the times of the file beside."""
    times = Path(path).with_name(f"{Path(path).stem}-times.txt")
    if not times.is_file():
        raise ValueError(f"{path} has 12 columns, as KITTI, which has no stamps: {times.name} beside it must have them")
    t = np.loadtxt(times, ndmin=1)
    if t.shape != (len(poses),):
        raise ValueError(f"{times} has {t.size} numbers for the {len(poses)} poses of {path}")
    R = poses[:, :, :3]
    if np.abs(R @ np.swapaxes(R, 1, 2) - np.eye(3)).max() > UNIT:
        raise ValueError(f"{path}: the matrices of KITTI must be rotations")
    q = np.array([R2q(R_k)[0] for R_k in R])
    return np.column_stack([t, poses[:, :, 3], q[:, 1:], q[:, 0]])


def _beside(path, n, x):
    """Covariances of the file beside, or None where there is none."""
    beside = Path(path).with_name(f"{Path(path).stem}-cov.txt")
    if not beside.is_file():
        return None
    names, rows, _ = _table(beside)
    if names is not None or len(rows) != n or rows.shape[1] not in (6, 21):
        raise ValueError(f"{beside} must have a row of 6 or 21 numbers for each of the {n} poses of {path}")
    if rows.shape[1] == 21:
        return _triangle(rows, 6)
    P, at = np.tile(np.diag([0.0, 0, FLAT, FLAT, FLAT, 0]), (n, 1, 1)), np.array([0, 1, 5])
    P[:, at[:, None], at] = _triangle(rows, 3)
    return P if x.dim == 3 else P[:, at[:, None], at]


def _is_number(cell):
    try:
        float(cell)
    except ValueError:
        return False
    return True


def _names(path, n, square):
    """Names of n columns that have none."""
    full = lambda axes: [f"p_{a}{b}" for a in axes for b in axes]
    upper = lambda axes: [f"p_{a}{b}" for i, a in enumerate(axes) for b in axes[i:]]
    lower = lambda axes: [f"p_{b}{a}" for i, a in enumerate(axes) for b in axes[: i + 1]]
    known = {
        4: POSE_2,
        8: POSE_3,
        10: POSE_2 + upper(AXES_2),
        13: POSE_2 + full(AXES_2),
        20: POSE_3 + upper(AXES_3[3:]) + upper(AXES_3[:3]),
        29: POSE_3 + (lower if square else upper)(AXES_3),
        44: POSE_3 + full(AXES_3),
    }
    if n not in known:
        raise ValueError(f"{path} has {n} columns without names; known: {', '.join(map(str, known))}")
    return known[n]


def _column(names, rows, name):
    return rows[:, names.index(name)]


def _columns(names):
    return "columns " + " ".join(names[:12]) + (" ..." if len(names) > 12 else "")


def _poses(path, names, rows, before=""):
    """Frames of all rows, in the plane or in space."""
    space = before + "qw" in names or before + "qx" in names
    wanted = POSE_3 if space else POSE_2
    missing = [name for name in ["t", *(before + name for name in wanted[1:])] if name not in names]
    if missing:
        raise ValueError(f"{path} has no column {', '.join(missing)}; it has {_columns(names)}")
    t = _column(names, rows, "t")
    if (np.diff(t) <= 0).any():
        k = int(np.argmax(np.diff(t) <= 0)) + 2
        raise ValueError(
            f"{path}: stamps must rise, and that of pose {k} does not: {t[k - 1]:g} s after {t[k - 2]:g} s"
        )
    pick = [before + name for name in (["x", "y", "z", "qw", "qx", "qy", "qz"] if space else wanted[1:])]
    x = np.column_stack([_column(names, rows, name) for name in pick])
    if not space:
        return Frame2(x)
    length = np.linalg.norm(x[:, 3:], axis=1)
    if (np.abs(length - 1) > UNIT).any():
        k = int(np.argmax(np.abs(length - 1) > UNIT))
        raise ValueError(f"{path}: the quaternion of pose {k + 1} has the length {length[k]:.4g}, not 1")
    return Frame3(np.column_stack([x[:, :3], x[:, 3:] / length[:, None]]))


def _truth_beside(path, names, rows):
    """True poses in columns true_x ...; None where there are none."""
    others = [OTHER_NAMES.get(name[5:], name[5:]) if name.startswith("true_") else name for name in names]
    renamed = [f"true_{o}" if n.startswith("true_") else n for n, o in zip(names, others, strict=True)]
    if "true_x" not in renamed or not np.isfinite(rows).all():
        return None
    return _poses(path, renamed, rows, "true_")


def _covariances(path, names, rows, axes):
    """P of all rows, or None where no column is of a covariance."""
    plain = {re.sub(r"[^a-z]", "", re.sub(r"^(p|cov|c)_", "", name)): k for k, name in enumerate(names) if "_" in name}
    if not any(a + b in plain and names[plain[a + b]][0] in "pc" for a in axes for b in axes):
        return None
    P, missing = np.empty((len(rows), len(axes), len(axes))), []
    for i, a in enumerate(axes):
        for j, b in enumerate(axes):
            both = [key for key in (a + b, b + a) if key in plain and names[plain[key]][0] in "pc"]
            if not both and not _apart(names, a, b):
                missing.append(f"P_{a}{b}")
            P[:, i, j] = rows[:, plain[both[0]]] if both else 0.0
    if missing:
        upper = [name for k, name in enumerate(missing) if k < 6]
        raise ValueError(f"{path} has no column {', '.join(upper)}{' ...' * (len(missing) > 6)}")
    return P


def _apart(names, a, b):
    """True for position and rotation in the form of OpenVINS, which does not have what they have in common."""
    return len(names) == 20 and (a in AXES_3[:3]) != (b in AXES_3[:3])


def _triangle(entries, m):
    P = np.empty((len(entries), m, m))
    i, j = np.triu_indices(m)
    P[:, i, j] = P[:, j, i] = entries
    return P


def _checked(path, P):
    """P, symmetric to the last digit; refuse what is no covariance."""
    largest = np.abs(P).max((1, 2)).clip(1e-300)
    off = np.abs(P - np.swapaxes(P, 1, 2)).max((1, 2)) / largest
    if (off > SYMMETRIC).any():
        k = int(np.argmax(off > SYMMETRIC))
        raise ValueError(f"{path}: P of row {k + 1} is not symmetric, by {off[k]:.1g} of its largest entry")
    P = (P + np.swapaxes(P, 1, 2)) / 2
    if (np.diagonal(P, axis1=1, axis2=2) < 0).any() or (np.linalg.eigvalsh(P)[:, 0] < -1e-9 * largest).any():
        bad = (np.linalg.eigvalsh(P)[:, 0] < -1e-9 * largest) | (np.diagonal(P, axis1=1, axis2=2) < 0).any(1)
        raise ValueError(f"{path}: P of row {int(np.argmax(bad)) + 1} is no covariance: it has a negative eigenvalue")
    return P


def _landmarks(path):
    """Ids, points, covariances or None, and true places or None, of a file of landmarks."""
    names, rows, _ = _table(path)
    if names is None:
        names = {3: ["id", "x", "y"], 4: ["id", "x", "y", "z"]}.get(rows.shape[1])
    if names is None or not {"id", "x", "y"} <= set(names):
        raise ValueError(f"{path}: landmarks need the columns id, x, y, and z in space")
    axes = list("xyz") if "z" in names else list("xy")
    true = [f"true_{a}" for a in axes]
    places = np.column_stack([_column(names, rows, name) for name in true]) if set(true) <= set(names) else None
    P = _covariances(path, names, rows, axes)
    points = np.column_stack([_column(names, rows, a) for a in axes])
    ids = [int(id) for id in _column(names, rows, "id")]
    return ids, points, None if P is None else _checked(path, P), places
