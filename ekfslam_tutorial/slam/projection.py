"""Where things are according to the map, and what a sensor should see of it."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..ekf import transform
from ..models.observation import sight, to_sensor
from .first_estimates import first_jacobians
from .objects import Obs

MANY = 40
"""Of more landmarks than this, those in view are found first; Jacobians are for them only."""


def place(map, obj, x, P=None):
    """Put a robot or a sensor where it starts: into the map with covariance P, or known if there is none.

    Parameters
    ----------
    map : Map
    obj : Rob or Sen
    x : ndarray, shape (k,)
    P : ndarray, shape (k, k), optional

    Raises
    ------
    ValueError
        If the state is not finite or has the wrong length, or P is not a covariance.
    """
    size = obj.motion.size if hasattr(obj, "motion") else obj.frame_type.size
    if np.shape(x) != (size,) or not np.isfinite(x).all():
        raise ValueError(f"{type(obj).__name__} {obj.id}: the state must be {size} finite numbers, got {x}")
    if P is None:
        obj.x, obj.r = np.array(x, float), None
    else:
        obj.x, obj.r = None, map.add(x, P)


def normalize(map, obj):
    """Bring the frame of a robot or sensor in the map to its normal form: unit quaternion, wrapped heading."""
    if obj.r is None:
        return
    F = obj.frame(map)
    if not F.is_normal:
        N, N_f = F.normalized()
        transform(map, frame_range(obj, N), N.x, N_f)


def frame_range(obj, F):
    """Range of the frame in the map; a robot's state may have velocities behind it."""
    return None if obj.r is None else slice(obj.r.start, obj.r.start + F.size)


@dataclass(frozen=True, slots=True)
class Stack:
    """Expected observations of K landmarks of one type by one sensor, as arrays.

    Parameters
    ----------
    lmks : list of Lmk
    e, v : ndarray, shape (K, m) and (K, d)
        Expectations; points in the sensor frame, or rays.
    blocks : tuple of (range, ndarray of shape (K, m, k))
        (rob.r, E_r), (sen.r, E_s), (rows, E_l); rows of shape (K, k), or None where the landmarks are known.
    visible : ndarray of bool, shape (K,)
    """

    lmks: list
    e: np.ndarray
    v: np.ndarray
    blocks: tuple
    visible: np.ndarray

    def take(self, some):
        """The same of some of the landmarks, given by their indices."""
        (rr, E_r), (rs, E_s), (rows, E_l) = self.blocks
        blocks = (rr, E_r[some]), (rs, E_s[some]), (None if rows is None else rows[some], E_l[some])
        return Stack([self.lmks[i] for i in some], self.e[some], self.v[some], blocks, self.visible[some])

    def padded(self, size):
        """The same with landmarks of this size: what is too much has the derivative zero, and stands anywhere."""
        r, s, (rows, E_l) = self.blocks
        more = ((0, 0), (0, size - E_l.shape[-1]))
        rows = np.zeros((len(self.lmks), size), int) if rows is None else np.pad(rows, more)
        E_l = np.zeros((*E_l.shape[:2], size)) if self.blocks[2][0] is None else np.pad(E_l, ((0, 0), *more))
        return Stack(self.lmks, self.e, self.v, (r, s, (rows, E_l)), self.visible)

    def covariances(self, map):
        """Covariance H P H' of each expectation, shape (K, m, m)."""
        K, H, rows = len(self.lmks), [], []
        for r, J in self.blocks:
            if r is not None:
                H.append(J)
                rows.append(
                    np.broadcast_to(np.arange(r.start, r.stop), (K, J.shape[-1])) if isinstance(r, slice) else r
                )
        if not H:
            return np.zeros((K, self.e.shape[-1], self.e.shape[-1]))
        H, rows = np.concatenate(H, -1), np.concatenate(rows, -1)
        return H @ map.block(rows) @ np.swapaxes(H, -1, -2)

    def obs(self, sen, E):
        """One record for each landmark; E are the covariances, or None."""
        (rr, E_r), (rs, E_s), (_, E_l) = self.blocks
        E = [None] * len(self.lmks) if E is None else E
        every = zip(self.lmks, self.e, E, E_r, E_s, E_l, self.v, self.visible.tolist(), strict=True)
        return [
            Obs(sen.id, lmk.id, e, E_k, ((rr, J_r), (rs, J_s), (lmk.r, J_l)), v, seen)
            for lmk, e, E_k, J_r, J_s, J_l, v, seen in every
        ]


def merged(stacks):
    """One stack of landmarks of several types."""
    if len(stacks) == 1:
        return stacks[0]
    size = max(stack.blocks[2][1].shape[-1] for stack in stacks)
    stacks = [stack.padded(size) for stack in stacks]
    together = lambda *arrays: np.concatenate(arrays)
    ranges = (stacks[0].blocks[0][0], stacks[0].blocks[1][0], together(*(s.blocks[2][0] for s in stacks)))
    J = (together(*(s.blocks[i][1] for s in stacks)) for i in range(3))
    e, v, visible = (together(*(getattr(s, name) for s in stacks)) for name in ("e", "v", "visible"))
    return Stack([lmk for s in stacks for lmk in s.lmks], e, v, tuple(zip(ranges, J, strict=True)), visible)


@np.errstate(divide="ignore", invalid="ignore", over="ignore")
def project_lmks(map, rob, sen, lmks):
    """Expected observations of landmarks by one sensor: all landmarks of a type in one call.

    A landmark at the lens, or in the plane of a camera, has no finite expectation; it is not visible.

    Parameters
    ----------
    map : Map
    rob : Rob
    sen : Sen
    lmks : iterable of Lmk

    Returns
    -------
    list of Obs
        In the order of `lmks`: expectation e, its covariance E = H P H', Jacobian blocks, visibility.
    """
    lmks = list(lmks)
    obs: list[Any] = [None] * len(lmks)
    Rf, Sf = rob.frame(map), sen.frame(map)
    for members in _by_type(lmks):
        stack = _stack(map, rob, sen, Rf, Sf, [lmks[i] for i in members])
        E = stack.covariances(map)
        stack.visible[:] &= np.isfinite(E).all((-1, -2))
        for i, o in zip(members, stack.obs(sen, E), strict=True):
            obs[i] = o
    return obs


@np.errstate(divide="ignore", invalid="ignore", over="ignore")
def stacks_in_view(map, rob, sen, lmks):
    """Expected observations of the visible landmarks only, as one `Stack` for each type of landmark."""
    lmks, stacks = list(lmks), []
    Rf, Sf = rob.frame(map), sen.frame(map)
    for members in _by_type(lmks):
        some = lmks if len(members) == len(lmks) else [lmks[i] for i in members]
        if len(some) > MANY:
            e, v = sight(Rf.compose(Sf)[0], sen.model, some[0].type, _states(map, some)[0])
            some = [some[i] for i in np.flatnonzero(sen.model.visible(e, v)).tolist()]
        if some:
            stack = _stack(map, rob, sen, Rf, Sf, some)
            finite = stack.visible & np.isfinite(stack.blocks[2][1].sum((-1, -2)))
            stacks.append(stack if finite.all() else stack.take(np.flatnonzero(finite)))
    return [stack for stack in stacks if stack.lmks]


def _stack(map, rob, sen, Rf, Sf, lmks):
    """Expected observations of landmarks of one type, visible or not."""
    l, rows = _states(map, lmks)
    v, V_r, V_s, V_l = to_sensor(Rf, Sf, sen.model, lmks[0].type, l)
    e, E_v = sen.model.project(v)
    E_r, E_s, E_l = E_v @ V_r, E_v @ V_s, E_v @ V_l
    if rob.first is not None:
        E_r, E_s, E_l = first_jacobians(rob, sen, Sf, lmks)
    blocks = (frame_range(rob, Rf), E_r), (sen.r, E_s), (rows, E_l)
    return Stack(lmks, e, v, blocks, sen.model.visible(e, v))


def _states(map, lmks):
    """States of landmarks of one type, shape (K, k), and where they are in the map: shape (K, k), or None."""
    if lmks[0].r is None:
        return np.array([lmk.x for lmk in lmks]), None
    rows = np.array([lmk.r.start for lmk in lmks])[:, None] + np.arange(lmks[0].type.size)
    return map.state(rows), rows


def _by_type(lmks):
    """Indices of the landmarks of each type, those in the map and the known ones apart."""
    groups, seen = {}, {}
    for i, lmk in enumerate(lmks):
        group = seen.get((id(lmk.type), lmk.r is None))  # most are of one and the same object: no need to compare
        if group is None:
            group = seen[id(lmk.type), lmk.r is None] = groups.setdefault((lmk.type, lmk.r is None), [])
        group.append(i)
    return groups.values()
