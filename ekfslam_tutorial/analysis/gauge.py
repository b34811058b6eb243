"""Errors and covariances in one gauge: what a SLAM filter can know, and what it cannot.

A map that is moved and turned as a whole explains every measurement as well: its place in the world is the *gauge*.
Nobody has measured it. To compare a map with the truth, somebody must lay one on the other, and where they are laid on
each other the error is zero by choice. The covariance must know of that choice. The error in one gauge beside the
covariance in another, say the error after alignment beside a P that is relative to the start, is no test of a filter.

Let e be the errors of all states in the axes of the truth, P their covariance in any gauge, and G = de/dg their
derivative by a small motion g of the whole map. A rule that takes a motion C e away, with C G = I, makes

    e' = S e,    P' = S P S',    S = I - G C.

e' is the same for every gauge that P may have come in, since S G = 0; an honest filter has e' ~ N(0, P'). This is the
S-transformation of W. Baarda, "S-transformations and criterion matrices", Netherlands Geodetic Commission 1973; for
maps of images see K. Kanatani, D. D. Morris, "Gauges and gauge transformations for uncertainty description of geometric
structure with indeterminacy", IEEE Trans. Information Theory 47(5):2017-2028, 2001, eq. 38.

Two rules are in use here:

* *map*: map and truth are laid on each other by the landmarks, each with its weight. C = (G_l' W G_l)^-1 G_l' W, on
  the rows of the landmarks. An instant has its own: pose and landmarks with the P of that instant.
* *start*: the first pose is laid on the true one. What the later poses share with it is no error of theirs.
"""

import numpy as np

from ..geometry import align, hat

PARTNERS = 32
"""A landmark is compared with so many others, spread over the map, to see how well its place among them is known."""


def pose_generator(F):
    """Derivative of `minus`, the error of a pose, by a small motion [t; angle or angles] of the whole world.

    Parameters
    ----------
    F : Frame2 or Frame3
        One pose or many, `x` of shape (..., size).

    Returns
    -------
    ndarray, shape (..., dof, dof)
    """
    d, dof = F.dim, F.dof
    G = np.zeros((*F.x.shape[:-1], dof, dof))
    G[..., :d, :] = point_generator(F.t)
    G[..., d:, d:] = 1.0 if d == 2 else F.Rt  # in space the angles of an error are about the axes of the pose
    return G


def point_generator(p):
    """Derivative of points by a small motion [t; angle or angles] of the whole world.

    Parameters
    ----------
    p : ndarray, shape (..., d)

    Returns
    -------
    ndarray, shape (..., d, 3) in the plane, (..., d, 6) in space
    """
    p = np.asarray(p, float)
    d = p.shape[-1]
    turn = np.stack([-p[..., 1:], p[..., :1]], -2) if d == 2 else -hat(p)
    return np.concatenate([np.broadcast_to(np.eye(d), (*p.shape[:-1], d, d)), turn], -1)


def distance_weights(points, P):
    """Weights of landmarks for an alignment: by how well their distances to the others are known.

    A distance is the same in every gauge, and so is its variance; the variance of a place is not. The weight is one
    over the lower quartile of the variances of the distances to `PARTNERS` others: how well its place is known among
    its best neighbours, whatever the rest is worth. A landmark far away, of which only the direction is known, counts
    next to nothing.

    Parameters
    ----------
    points : ndarray, shape (n, d)
    P : ndarray, shape (n d, n d)
        Their joint covariance, in any gauge.

    Returns
    -------
    ndarray, shape (n,)
        The largest is 1. All are 1 where nothing is uncertain.
    """
    n, d = np.shape(points)
    others = np.arange(0, n, -(-n // PARTNERS))
    u = points[:, None] - points[others]
    u = u / np.linalg.norm(u, axis=-1, keepdims=True).clip(1e-12)
    B = np.asarray(P).reshape(n, d, n, d)
    own = np.einsum("iaib->iab", B)
    cross = B[:, :, others].transpose(0, 2, 1, 3)
    between = own[:, None] + own[others] - cross - np.swapaxes(cross, -1, -2)
    variances = np.einsum("ija,ijab,ijb->ij", u, between, u).clip(0)
    variances[others, np.arange(len(others))] = np.nan  # a landmark and itself
    spread = _lower_quartile(variances) if n > 1 else np.zeros(n)
    spread = spread.clip(1e-12 * spread.max())
    return spread.min() / spread if spread.max() > 0 else np.ones(n)


def _lower_quartile(a):
    """Return that of the numbers in each row; NaN is none. Much quicker than `np.nanquantile`, row by row."""
    a = np.sort(a, axis=1)  # NaN comes last
    at = 0.25 * ((~np.isnan(a)).sum(1) - 1)
    below, above = (np.take_along_axis(a, k(at).astype(int)[:, None], 1)[:, 0] for k in (np.floor, np.ceil))
    return below + (at % 1) * (above - below)


class MapGauge:
    """The gauge in which landmarks lie on their true places as well as weights ask.

    Parameters
    ----------
    points, truth : ndarray, shape (n, d)
        Landmarks of a map, and where they are.
    P : ndarray, shape (n d, n d)
        Joint covariance of `points`, for the weights.

    Attributes
    ----------
    F : Frame2 or Frame3
        The frame of the map, seen from the truth, after alignment.
    weights : ndarray, shape (n,)
    C : ndarray, shape (3 or 6, n d)
        The small motion of the world that the alignment takes away: C times the errors of `points`, in the map's axes.

    Raises
    ------
    ValueError
        Where the landmarks do not fix a frame: see `align`.

    See Also
    --------
    start_gauge : The gauge of a trajectory without landmarks.
    """

    def __init__(self, points, truth, P):
        self.weights = distance_weights(points, P)
        self.F = align(points, truth, self.weights)
        n, d = points.shape
        G = point_generator(self.F.from_frame(points)[0])
        GtW = (self.weights[:, None, None] * G).reshape(n * d, -1).T
        to_truth = np.linalg.solve(GtW @ G.reshape(n * d, -1), GtW)
        self.C = (to_truth.reshape(-1, n, d) @ self.F.R).reshape(-1, n * d)

    def error(self, pose, truth):
        """Error of a pose in this gauge, and its derivatives.

        Parameters
        ----------
        pose, truth : Frame2 or Frame3
            Estimate in the map, and the true pose.

        Returns
        -------
        e : ndarray, shape (dof,)
        E_x : ndarray, shape (dof, size)
            By the estimated pose.
        E_l : ndarray, shape (dof, n d)
            By the landmarks: they move the frame that the error is taken in. The covariance of e is
            [E_x E_l] P [E_x E_l]' with the joint covariance P of pose and landmarks.
        """
        e, E_x, E_g = laid_error(self.F, pose, truth)
        return e, E_x, E_g @ self.C


def laid_error(F, pose, truth):
    """Error of a pose that is laid on the truth by a frame F; many poses have one frame, or each its own.

    Returns
    -------
    e : ndarray, shape (..., dof)
    E_x : ndarray, shape (..., dof, size)
        By the pose.
    E_g : ndarray, shape (..., dof, dof)
        By the small motion of the world that F takes away.
    """
    laid, _, L_x = F.compose(pose)
    e, E_f = laid.minus(truth)
    return e, E_f @ L_x, -pose_generator(laid)


class StartGauge:
    """The gauge in which one pose, the first, lies on its true place.

    Its covariance P_0 is taken for uncertainty of the gauge alone: the same motion of the whole world moves every later
    pose, which makes the part A P_0 A' of its covariance, A = G G_0^-1. The error relative to the start has the rest,
    P - A P_0 A'. That is right where nothing but the prior has told the first pose: a start that is known (P_0 = 0), or
    a prior on it, and then relative measurements only. With one free angle the prior on position and heading must not
    be correlated with the one on the tilt.

    Parameters
    ----------
    x, truth : Frame2 or Frame3
        The first pose as estimated, and the true one.
    P : ndarray, shape (dof, dof)
        Covariance of the error of x as `minus` has it, in the frame of the estimate.
    angles : int, optional
        How many angles of the world are free: in space 3 if not given, or 1, about the vertical, where gravity is
        known.

    Attributes
    ----------
    F : Frame2 or Frame3
        The frame of the estimate, seen from the truth, after alignment.

    See Also
    --------
    MapGauge : The gauge of a map.
    """

    def __init__(self, x, P, truth, angles=None):
        d, dof = x.dim, x.dof
        angles = dof - d if angles is None else angles
        self._free = np.r_[:d, dof - angles : dof]  # the last angle is the one about the vertical
        pick = np.eye(dof)
        if d == 3:
            pick[d:, d:] = x.R  # rotations of the first pose about the axes of the world
        pick = pick[self._free]
        self._pick = np.linalg.solve(pick @ pose_generator(x)[:, self._free], pick)
        self._P = P
        self.F = _laid_on(x, truth, angles)

    def errors(self, x, P, truth):
        """Errors of poses and their covariances, in the axes of the truth.

        Parameters
        ----------
        x, truth : Frame2 or Frame3
            `x` of shape (F, size).
        P : ndarray, shape (F, dof, dof)

        Returns
        -------
        e : ndarray, shape (F, dof)
        P : ndarray, shape (F, dof, dof)
        """
        turn = np.eye(x.dof)
        turn[: x.dim, : x.dim] = self.F.R
        return self.F.compose(x)[0].minus(truth)[0], turn @ self._rest(pose_generator(x), P) @ turn.T

    def point_errors(self, p, P, truth):
        """Return the same for points: p and truth (n, d), P (n, d, d)."""
        P = self._rest(point_generator(p), P)
        return self.F.from_frame(p)[0] - truth, self.F.R @ P @ self.F.R.T

    def _rest(self, G, P):
        A = G[..., self._free] @ self._pick  # by the error of the first pose
        return P - A @ self._P @ np.swapaxes(A, -1, -2)


def start_gauge(x, P, truth, angles=None):
    """Errors of poses relative to the first of them, and their covariances: see `StartGauge`.

    Parameters
    ----------
    x, truth : Frame2 or Frame3
        All poses, `x` of shape (F, size).
    P : ndarray, shape (F, dof, dof)
        Covariances of the errors as `minus` has them, in the frame of the estimate.
    angles : int, optional
        How many angles of the world are free.

    Returns
    -------
    e : ndarray, shape (F, dof)
        In the axes of the truth. Zero in the first frame.
    P : ndarray, shape (F, dof, dof)
    """
    frame = type(x)
    return StartGauge(frame(x.x[0]), P[0], frame(truth.x[0]), angles).errors(x, P, truth)


def map_nees(points, P, truth, free=True):
    """Squared Mahalanobis distance of a whole map from the truth, modulo its gauge.

    The smallest e' P^-1 e over all small motions of the map: the same for every gauge that P may be in.

    Parameters
    ----------
    points, truth : ndarray, shape (n, d)
    P : ndarray, shape (n d, n d)
        Joint covariance.
    free : bool
        False: the map is in the frame of the truth, and nothing is taken away.

    Returns
    -------
    nees : float
        NaN where P is not positive definite.
    dof : int
        n d, less the 3 or 6 of the gauge.
    """
    n, d = points.shape
    if free:
        F = MapGauge(points, truth, P).F
        turn = np.kron(np.eye(n), F.R)
        points, P = F.from_frame(points)[0], turn @ P @ turn.T
    std = np.sqrt(np.diagonal(P))
    if not (np.isfinite(P).all() and (std > 0).all()):
        return float("nan"), n * d
    try:
        L = np.linalg.cholesky(P / np.outer(std, std))
    except np.linalg.LinAlgError:
        return float("nan"), n * d
    G = point_generator(points).reshape(n * d, -1)
    w, W = (np.linalg.solve(L, a / std[:, None]) for a in ((points - truth).reshape(-1, 1), G))
    if free:
        w = w - W @ np.linalg.lstsq(W, w, rcond=None)[0]
    return float((w**2).sum()), n * d - free * G.shape[1]


def _laid_on(pose, truth, angles):
    """The frame F with F.compose(pose) = truth; where one angle only is free, its heading, and the position."""
    if angles == pose.dof - pose.dim:
        return truth.compose(pose.inverse()[0])[0]
    R = truth.R @ pose.Rt
    half = np.arctan2(R[1, 0] - R[0, 1], R[0, 0] + R[1, 1]) / 2  # the turn about z that is nearest to R
    F = type(pose)(np.array([0.0, 0.0, 0.0, np.cos(half), 0.0, 0.0, np.sin(half)]))
    t = truth.t - F.from_frame(pose.t)[0]
    return type(pose)(np.concatenate([t, F.o]))
