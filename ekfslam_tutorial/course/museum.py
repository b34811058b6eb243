"""The bug museum: EKF-SLAM filters with errors that were published, each re-created as a mutant of one function.

The filter is that of notebook 05, cut into five functions. An exhibit replaces one of them; nothing else differs. No
code was copied: a thread told what was wrong, and the mutant does the same to our formulas. All functions take leading
axes: `x` (..., n) and `P` (..., n, n), so that many runs are filtered at once.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from ..geometry import Frame2, wrap
from ..models.motion import Odometry2
from ..models.sensors.range_bearing import polar

ODOMETRY = Odometry2()


def T(A):
    """Return the transposes."""
    return np.swapaxes(A, -1, -2)


# ---- the filter as it should be ------------------------------------------------------------------------------------


def propagate(P, X_x, N):
    """Covariance after a motion: P_rr = X_x P_rr X_x' + N, P_rm = X_x P_rm; the map stands still."""
    P = P.copy()
    P[..., :3, :] = X_x @ P[..., :3, :]
    P[..., :, :3] = P[..., :, :3] @ T(X_x)
    P[..., :3, :3] += N
    return P


def predict(x, P, u, U):
    """One step u, covariance U, of the robot in the joint state: the new x and P."""
    pose, X_x, X_u = ODOMETRY.move(x[..., :3], u, 1.0)
    return join(pose, x), propagate(P, X_x, X_u @ U @ T(X_u))


def join(pose, x):
    """The state with another pose."""
    return np.concatenate([pose, x[..., 3:]], -1)


def observe(x, r):
    """Expected range and bearing of the landmark in range r, and the Jacobian H of shape (..., 2, n)."""
    p, P_f, P_l = Frame2(x[..., :3]).to_frame(x[..., r])
    e, E_p = polar(p)
    H = np.zeros((*x.shape[:-1], 2, x.shape[-1]))
    H[..., :3], H[..., r] = E_p @ P_f, E_p @ P_l
    return e, H


def innovation(y, e):
    """Measured minus expected; the bearing is wrapped."""
    z = y - e
    return np.stack([z[..., 0], wrap(z[..., 1])], -1)


def correct(x, P, z, Z, H):
    """The state corrected by an innovation z with the covariance Z = H P H' + R."""
    K = T(np.linalg.solve(Z, H @ P))
    return x + (K @ z[..., None])[..., 0], P - K @ Z @ T(K)


def start(x, y):
    """Where a new landmark is, and its Jacobians by the pose and by the measurement."""
    r, c, s = y[..., 0], np.cos(y[..., 1]), np.sin(y[..., 1])
    P_y = np.stack([np.stack([c, -r * s], -1), np.stack([s, r * c], -1)], -2)
    l, L_r, L_p = Frame2(x[..., :3]).from_frame(np.stack([r * c, r * s], -1))
    return l, L_r, L_p @ P_y


def enlarge(x, P, l, P_lx, P_ll):
    """The state with a new landmark at its end."""
    top, below = np.concatenate([P, T(P_lx)], -1), np.concatenate([P_lx, P_ll], -1)
    return np.concatenate([x, l], -1), np.concatenate([top, below], -2)


def augment(x, P, y, R):
    """The state with a new landmark, started by the measurement y with the covariance R."""
    l, L_r, L_y = start(x, y)
    P_lx = L_r @ P[..., :3, :]
    return enlarge(x, P, l, P_lx, P_lx[..., :3] @ T(L_r) + L_y @ R @ T(L_y))


# ---- the mutants: what each thread says was done; G is the name it has for F_x, the Jacobian of the motion ----------


def predict_late(x, P, u, U):
    """The Jacobians are taken at the pose after the step."""
    pose = ODOMETRY.move(x[..., :3], u, 1.0)[0]
    _, X_x, X_u = ODOMETRY.move(pose, u, 1.0)
    return join(pose, x), propagate(P, X_x, X_u @ U @ T(X_u))


def predict_elementwise(x, P, u, U):
    """P_rr is multiplied entry by entry, G' * P_rr * G, instead of as matrices."""
    x2, P2 = predict(x, P, u, U)
    _, X_x, X_u = ODOMETRY.move(x[..., :3], u, 1.0)
    P2[..., :3, :3] = T(X_x) * P[..., :3, :3] * X_x + X_u @ U @ T(X_u)
    return x2, P2


def predict_transposed(x, P, u, U):
    """G' P G instead of G P G'."""
    pose, X_x, X_u = ODOMETRY.move(x[..., :3], u, 1.0)
    return join(pose, x), propagate(P, T(X_x), X_u @ U @ T(X_u))


def predict_pose_only(x, P, u, U):
    """P_rr is propagated; the covariance of the pose with the map, P_rm, is left as it was."""
    x2, P2 = predict(x, P, u, U)
    P2[..., :3, 3:], P2[..., 3:, :3] = P[..., :3, 3:], P[..., 3:, :3]
    return x2, P2


def predict_swapped(x, P, u, U):
    """Sine and cosine are swapped in the column of the heading: (-d cos, d sin) instead of (-d sin, d cos)."""
    pose, X_x, X_u = ODOMETRY.move(x[..., :3], u, 1.0)
    X_x = X_x.copy()
    X_x[..., :2, 2] = X_x[..., 1::-1, 2] * [-1, -1]
    return join(pose, x), propagate(P, X_x, X_u @ U @ T(X_u))


def predict_no_heading(x, P, u, U):
    """The third row of the Jacobian is 0 0 0 instead of 0 0 1."""
    pose, X_x, X_u = ODOMETRY.move(x[..., :3], u, 1.0)
    X_x = X_x.copy()
    X_x[..., 2, :] = 0
    return join(pose, x), propagate(P, X_x, X_u @ U @ T(X_u))


def observe_over_q(x, r):
    """The derivative of the bearing by the heading is -1/q, q the squared range, instead of -1."""
    e, H = observe(x, r)
    H[..., 1, 2] = -1 / e[..., 0] ** 2
    return e, H


def innovation_not_wrapped(y, e):
    """Bearings are subtracted as if they were numbers on a line."""
    return y - e


def augment_identity(x, P, y, R):
    """A new landmark gets the identity as covariance, and zeros beside it."""
    l = start(x, y)[0]
    P_ll = np.broadcast_to(np.eye(2), (*x.shape[:-1], 2, 2))
    return enlarge(x, P, l, np.zeros((*x.shape[:-1], 2, x.shape[-1])), P_ll)


def augment_mapping(x, P, y, R):
    """The formula of mapping with known poses, L_y R L_y' and zeros, used in SLAM."""
    l, _, L_y = start(x, y)
    return enlarge(x, P, l, np.zeros((*x.shape[:-1], 2, x.shape[-1])), L_y @ R @ T(L_y))


# ---- the exhibits --------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Filter:
    """The functions a filter is made of; what is not named is as it should be."""

    predict: Callable = predict
    observe: Callable = observe
    innovation: Callable = innovation
    augment: Callable = augment
    told: Callable = field(default=lambda U: U)  # covariance of the odometry that the filter is told
    again: bool = False  # a landmark is corrected with the measurement that has started it


@dataclass(frozen=True)
class Exhibit:
    """A bug: its name, what is wrong, where it was reported, and the mutant.

    `thread` is "owner/repository#number" of the public report, or empty where the bug is known from lectures only.
    """

    key: str
    name: str
    label: str
    thread: str
    year: int
    filter: Filter

    @property
    def url(self) -> str:
        """Address of the thread."""
        return f"https://github.com/{self.thread.replace('#', '/issues/')}" if self.thread else ""

    @property
    def source(self) -> str:
        """The thread in Markdown; the filter without a bug, and the lecture's trap, have none."""
        return f"[{self.thread}]({self.url})" if self.thread else "notebook 02"


RIGHT = Exhibit("right", "no bug", "the filter of notebook 05", "", 0, Filter())
EXHIBITS = (
    Exhibit(
        "over_q", "-1/q", "d bearing / d heading is -1/q, not -1", "AtsushiSakai/PythonRobotics#255", 2019,
        Filter(observe=observe_over_q),
    ),
    Exhibit(
        "elementwise", "entry by entry", "`*` where `@` was meant, in the prediction",
        "AtsushiSakai/PythonRobotics#258", 2019, Filter(predict=predict_elementwise),
    ),
    Exhibit(
        "transposed", "G' P G", "the transpose on the wrong side (it is still there after the repair)",
        "AtsushiSakai/PythonRobotics#258", 2019, Filter(predict=predict_transposed),
    ),
    Exhibit(
        "late", "late Jacobian", "the Jacobian of the motion taken after the motion",
        "AtsushiSakai/PythonRobotics#305", 2020, Filter(predict=predict_late),
    ),
    Exhibit(
        "pose_only", "P_rm not moved", "the prediction changes P_rr only", "AtsushiSakai/PythonRobotics#972", 2024,
        Filter(predict=predict_pose_only),
    ),
    Exhibit(
        "swapped", "sin and cos swapped", "in the motion Jacobian", "conorhennessy/SLAM-Course-Solutions#5", 2023,
        Filter(predict=predict_swapped),
    ),
    Exhibit(
        "no_heading", "0 0 0 for 0 0 1", "the last row of the motion Jacobian", "snmnmin12/ekf-slam#1", 2019,
        Filter(predict=predict_no_heading),
    ),
    Exhibit(
        "not_wrapped", "no wrap", "landmarks behind the robot do not fit", "MRPT/mrpt#909", 2019,
        Filter(innovation=innovation_not_wrapped),
    ),
    Exhibit(
        "not_squared", "std for variance", "noise of the control not squared", "PX4/PX4-ECL#83", 2016,
        Filter(told=np.sqrt),
    ),
    Exhibit(
        "identity", "new: identity", "a new landmark gets I and no cross-covariance",
        "WaterlooRobotics/mobilerobotics#37", 2016, Filter(augment=augment_identity),
    ),
    Exhibit(
        "mapping", "new: pose as if known", "the mapping formula, used in SLAM", "", 0,
        Filter(augment=augment_mapping),
    ),
    Exhibit("twice", "used twice", "start a landmark, then correct it with the same measurement", "", 0,
            Filter(again=True)),
)  # fmt: skip
BY_KEY = {exhibit.key: exhibit for exhibit in (RIGHT, *EXHIBITS)}


def mutant(key, **changes) -> Filter:
    """The filter of an exhibit; `changes` replace more of its functions."""
    if key not in BY_KEY:
        raise ValueError(f"no exhibit {key!r} in the museum; there are: {', '.join(BY_KEY)}")
    return replace(BY_KEY[key].filter, **changes)
