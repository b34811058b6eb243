"""Which landmark of a map is which one of the world: by its id, or by its place where ids are the filter's own.

With known ids a landmark has the number of the true one. `nearest_neighbour` and `jcbb` number landmarks as they come:
then their numbers say nothing, and to compare by them is to compare a tree with another one. So the map is laid on the
world, and each landmark gets the true one in whose place it is: one to one, the sum of the squared distances least
(`scipy.optimize.linear_sum_assignment`), none beyond a gate. What is left over on both sides is counted.
"""

import itertools

import numpy as np

from ..ekf import chi_square
from ..geometry import Frame2, Frame3, align

SURE = 0.999
"""A landmark may be as far from its true place as its covariance allows with this probability,"""
USUAL = 5.0
"""or so many times as far as half of all landmarks are, if that is more: the filter may be too sure."""
ROUNDS = 20
"""Alignments after each of which the pairs are found again."""
BASES, TRIES = 30, 2000
"""Tuples of landmarks, and places of them in the world, that a map without any hint is tried on."""


def named(s):
    """Row of `s.sim_lmk` of each landmark that has the id of a true one, by id."""
    rows = {} if s.sim_lmk is None else {int(id): row for row, id in enumerate(s.sim_lmk.ids)}
    return {id: rows[id] for id in s.lmks if id in rows}


def placed(s, F=None):
    """Row of `s.sim_lmk` of each landmark that is in the place of a true one, by id.

    Parameters
    ----------
    s : Snapshot
    F : Frame2 or Frame3, optional
        About how the map lies in the world. Without it the shape of the map must tell.

    Returns
    -------
    rows : dict of int to int
    F : Frame2 or Frame3, or None
        The frame of the map, seen from the world, that the pairs were found with.
    """
    found = {id: lmk.point(s.map) for id, lmk in s.lmks.items() if lmk.par is None}
    found = {id: (p, P) for id, (p, P) in found.items() if np.isfinite(p).all() and np.isfinite(P).all()}
    if not found or s.sim_lmk is None:
        return {}, F
    points, P = (np.array(column) for column in zip(*found.values(), strict=True))
    truth, ids = np.asarray(s.sim_lmk.points, float), list(found)
    F = laid_by_shape(points, truth) if F is None else F
    if F is None:
        return {}, None
    i, j, F = pairs_by_place(points, P, truth, F)
    return {ids[a]: int(b) for a, b in zip(i, j, strict=True)}, F


def pairs_by_place(points, P, truth, F):
    """Pair landmarks with true ones by place, after alignment, one to one.

    Parameters
    ----------
    points : ndarray, shape (n, d)
    P : ndarray, shape (n, d, d)
        Their covariances.
    truth : ndarray, shape (m, d)
    F : Frame2 or Frame3
        About how the map lies in the world.

    Returns
    -------
    i, j : ndarray of int, shape (k,)
        Landmarks, and the true one of each: apart by less than half the usual distance of neighbours in the world, and
        by no more than their covariance allows, or than five times what half of the pairs are.
    F : Frame2 or Frame3
        Laid on the world by these pairs.
    """
    from scipy.optimize import linear_sum_assignment  # here and below: few runs need it, and all would wait for it

    far, d = half_way(truth), points.shape[1]
    allowed = np.sqrt(chi_square.quantile(SURE, d) * np.linalg.eigvalsh(P)[:, -1].clip(0))
    i, j = before = np.zeros((2, 0), int)
    for _ in range(ROUNDS):
        apart = np.linalg.norm(F.from_frame(points)[0][:, None] - truth, axis=-1)
        i, j = linear_sum_assignment(np.minimum(apart, far) ** 2)
        i, j = np.array([i, j])[:, apart[i, j] < far]
        usual = USUAL * np.median(apart[i, j]) if len(i) else 0.0
        i, j = np.array([i, j])[:, apart[i, j] <= np.maximum(allowed[i], usual)]
        if np.array_equal((i, j), before):
            break
        before = i, j
        F = align(points[i], truth[j]) if len(i) > d and spans(points[i]) else F
    return i, j, F


def half_way(truth):
    """Half the distance to the next landmark of the world, its median: from there on another one may be meant, m."""
    from scipy.spatial import KDTree

    if len(truth) < 2:
        return np.inf
    return 0.5 * float(np.median(KDTree(truth).query(truth, 2)[0][:, 1]))


def spans(points):
    """True if points fix a rotation: in the plane two of them, in space three that are not on a line."""
    s = np.linalg.svd(points - points.mean(0), compute_uv=False)
    return bool(s[points.shape[1] - 2] > 1e-6 * max(s[0], 1e-12))


def laid_by_shape(points, truth):
    """Lay a map on the world by its shape alone.

    Some of its landmarks, as many as the space has dimensions, are put where true ones are as far from each other. What
    brings most of the others into a place is kept.

    Parameters
    ----------
    points, truth : ndarray, shape (n, d), (m, d)

    Returns
    -------
    Frame2 or Frame3, or None
        None where less than d + 2 landmarks, or less than half of them, find a place.
    """
    from scipy.spatial import KDTree

    n, d = points.shape
    if min(n, len(truth)) < d + 2:
        return None
    rng, tree, far = np.random.default_rng(0), KDTree(truth), half_way(truth)
    best, most = None, (max(d + 1, (n - 1) // 2), 0.0)
    for _ in range(BASES):
        base = points[rng.choice(n, d, replace=False)]
        for there in itertools.islice(as_far_apart(base, truth, far / 2), TRIES // BASES):
            try:
                F = align(base, truth[list(there)])
            except ValueError:  # on a line, or on top of each other
                continue
            apart = tree.query(F.from_frame(points)[0])[0]
            score = int((apart < far).sum()), -float(np.minimum(apart, far).sum())
            if score[0] > most[0] or (best is not None and score > most):
                best, most = F, score
    return best


def as_far_apart(base, truth, tolerance):
    """Rows of true landmarks that are as far from each other as those of `base`, tuple by tuple."""
    between = np.linalg.norm(truth[:, None] - truth, axis=-1)

    def longer(rows):
        """Tuples that begin with these rows."""
        k = len(rows)
        if k == len(base):
            yield rows
            return
        fits = np.ones(len(truth), bool)
        for a, row in enumerate(rows):
            fits &= np.abs(between[row] - np.linalg.norm(base[k] - base[a])) < tolerance
            fits[row] = False
        for row in np.flatnonzero(fits):
            yield from longer([*rows, int(row)])

    return longer([])


def pose_on_truth(s):
    """The frame of the map, seen from the world, by a robot whose true pose is known in this frame; None without."""
    for rob in s.robs:
        truth = np.asarray(s.truth.get(rob.id, np.full(rob.motion.frame.size, np.nan)), float)
        if np.isfinite(truth).all():
            return rob.motion.frame(truth).compose(rob.frame(s.map).inverse()[0])[0]
    return None


def identity(dim):
    """The frame of a map that is in that of the world."""
    return Frame2(np.zeros(3)) if dim == 2 else Frame3(np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]))
