"""Estimates of other programs: poses with covariances, as they come, and their errors in one gauge."""

from dataclasses import dataclass, field, replace

import numpy as np

from ..geometry import Frame2, Frame3, hat, q2v
from .audit import RunErrors, whitened
from .consistency import md2
from .gauge import StartGauge, map_nees

AXES = ("mixed", "body", "map")
"""What the covariance of a pose is about. mixed: position along the axes of the map, rotation about those of the robot,
as ours and OpenVINS have it. body: the tangent space of SE(2) or SE(3) at the estimate, T Exp(e), as GTSAM has it. map:
position and rotation along and about the axes of the map, as ROS has it."""
GAUGES = ("auto", "fixed", "start")
SURPRISING = 60.0
"""Squared Mahalanobis distance between the first pose and its truth from which on the two are in different frames."""


@dataclass(frozen=True)
class Estimate:
    """Poses of one run with their covariances, and what else there is of it.

    Parameters
    ----------
    name : str
    x : Frame2 or Frame3
        Poses, `x` of shape (F, size).
    t : ndarray, shape (F,)
        s.
    P : ndarray or None, shape (F, dof, dof)
        Covariances: position first, then angle or angles. None in a truth.
    axes : str
        What they are about, one of `AXES`.
    truth : Frame2 or Frame3 or None
        True poses of the same stamps, where the file has them.
    ids : list
        Of the landmarks.
    points : ndarray, shape (n, d)
    points_P : ndarray or None, shape (n d, n d) or (n, d, d)
        Their joint covariance, or one of each.
    true_points : ndarray or None, shape (n, d)
    z, nis : ndarray, shape (K, m) and (K, 2)
        Innovations, as `RunErrors` has them.
    errors : tuple, optional
        Errors and covariances that are in one gauge already, and if that is free, as our own records have them.
    """

    name: str
    x: Frame2 | Frame3
    t: np.ndarray
    P: np.ndarray | None = None
    axes: str = "mixed"
    truth: Frame2 | Frame3 | None = None
    ids: list = field(default_factory=list)
    points: np.ndarray | None = None
    points_P: np.ndarray | None = None
    true_points: np.ndarray | None = None
    z: np.ndarray = field(default_factory=lambda: np.zeros((0, 0)))
    nis: np.ndarray = field(default_factory=lambda: np.zeros((0, 2)))
    errors: tuple | None = None

    def part(self, rows):
        """The same with some of its poses."""
        cut = lambda a: None if a is None else a[rows]
        frame = lambda F: None if F is None else type(F)(F.x[rows])
        return replace(self, x=frame(self.x), t=self.t[rows], P=cut(self.P), truth=frame(self.truth))


def to_mixed(x, axes):
    """Derivative of the error in mixed axes by that in others, shape (F, dof, dof), where both are small."""
    d, T = x.dim, np.broadcast_to(np.eye(x.dof), (*x.x.shape[:-1], x.dof, x.dof)).copy()
    if axes == "body":
        T[..., :d, :d] = x.R
    if axes == "map" and d == 3:
        T[..., d:, d:] = x.Rt
    return T


def tangent_error(x, truth, axes):
    """Error of poses in the axes of their covariance, whole, not linearised.

    Parameters
    ----------
    x, truth : Frame2 or Frame3
    axes : str

    Returns
    -------
    ndarray, shape (F, dof)
        body: -Log(x^-1 truth), J. Solà, J. Deray, D. Atchuthan, "A micro Lie theory for state estimation in robotics",
        arXiv:1812.01537, eqs. 158 and 174. Others: x.minus(truth), with the angles about the axes wanted.
    """
    d = x.dim
    if axes != "body":
        e, _ = x.minus(truth)
        if axes == "map" and d == 3:
            e[..., d:] = (truth.R @ e[..., d:, None])[..., 0]
        return e
    between = x.inverse()[0].compose(truth)[0]
    if d == 2:
        angle = between.normalized()[0].theta[..., None]
        V = _left_jacobian_inverse_2(angle[..., 0])
    else:
        q = between.q * np.where(between.q[..., :1] < 0, -1.0, 1.0)
        angle = q2v(q)[0]
        V = _left_jacobian_inverse_3(angle)
    return -np.concatenate([(V @ between.t[..., None])[..., 0], angle], -1)


def _left_jacobian_inverse_2(angle):
    half = angle / 2
    a = np.where(np.abs(half) < 1e-6, 1 - half**2 / 3, half / np.tan(np.where(half == 0, 1.0, half)))
    return np.stack([np.stack([a, half], -1), np.stack([-half, a], -1)], -2)


def _left_jacobian_inverse_3(v):
    n = np.linalg.norm(v, axis=-1)[..., None, None]
    safe, H = np.where(n < 1e-4, 1.0, n), hat(v)
    b = np.where(n < 1e-4, 1 / 12 + n**2 / 720, (1 - safe / 2 / np.tan(safe / 2)) / safe**2)
    return np.eye(3) - H / 2 + b * (H @ H)


def run_errors(estimate, gauge="auto", angles=None):
    """Errors of an estimate against its truth in one gauge.

    Parameters
    ----------
    estimate : Estimate
        With `truth`.
    gauge : str
        'fixed': the estimate is in the frame of the truth. 'start': the first poses are laid on each other, see
        `StartGauge`. 'auto': fixed, if the first pose is where the truth says.
    angles : int, optional
        How many angles of the world are free, for 'start'.

    Returns
    -------
    RunErrors

    Raises
    ------
    ValueError
        If the gauge is not known.
    """
    if gauge not in GAUGES:
        raise ValueError(f"unknown gauge {gauge!r}; known: {', '.join(GAUGES)}")
    e, P, start = _pose_errors(estimate, gauge, angles)
    nees, dof, u = _map_errors(estimate, start)
    return RunErrors(estimate.name, estimate.t, e, P, nees, dof, u, estimate.z, estimate.nis)


def _pose_errors(s, gauge, angles):
    """Errors, covariances, and the gauge of the start, None for a fixed one."""
    if s.errors is not None:
        e, P, free = s.errors
        return e, P, "map" if free else None
    T = to_mixed(s.x, s.axes)
    mixed = T @ s.P @ np.swapaxes(T, -1, -2)
    frame = type(s.x)
    e0, _ = frame(s.x.x[0]).minus(frame(s.truth.x[0]))
    here = gauge == "fixed" or (gauge == "auto" and md2(e0, mixed[0] + 1e-6 * np.eye(len(e0))) <= SURPRISING)
    if here:
        return tangent_error(s.x, s.truth, s.axes), s.P, None
    start = StartGauge(frame(s.x.x[0]), mixed[0], frame(s.truth.x[0]), angles)
    laid = start.F.compose(s.x)[0]
    _, P = start.errors(s.x, mixed, s.truth)
    back = np.linalg.inv(to_mixed(laid, s.axes))
    return tangent_error(laid, s.truth, s.axes), back @ P @ np.swapaxes(back, -1, -2), start


def _map_errors(s, start):
    """NEES of the map and its degrees of freedom, or whitened errors of each landmark where there is no joint P."""
    none = np.zeros((0, s.x.dim))
    if s.points is None or s.points_P is None or s.true_points is None or not len(s.points):
        return float("nan"), 0, none
    if np.ndim(s.points_P) == 2:
        return *map_nees(s.points, s.points_P, s.true_points, start is not None), none
    e, P = s.points - s.true_points, s.points_P
    if start is not None:
        e, P = start.point_errors(s.points, P, s.true_points)
    return float("nan"), 0, whitened(e, P)
