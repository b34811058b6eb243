"""What a sensor should see of many landmarks in one frame, and what it has measured: arrays, an `Obs` is one row."""

from typing import Any

import numpy as np

from .lazy import lazy


class Sightings:
    """Expected observations of K landmarks by one sensor, and what becomes of them.

    Parameters
    ----------
    sen : int
        Id of the sensor.
    lmks : list of Lmk
        Others may come behind them: K counts.
    e, v : ndarray, shape (K, m) and (K, d)
        Expectations; points in the sensor frame, or rays.
    visible : ndarray of bool, shape (K,)
    ranges : tuple (slice or None, slice or None, ndarray of int of shape (K, k) or None)
        Where the robot's frame, the sensor's frame and each landmark are in the map; None for what is known.
    E_r, E_s, E_l : ndarray, shape (K, m, ·), optional
        Jacobians of e.
    J : ndarray, shape (K, m, ·), optional
        Instead of them: all three side by side, as compiled code has written them.
    n : int, optional
        Numbers of a frame: where they part.

    Attributes
    ----------
    group, some : Group, list of int or None
        Where the landmarks are noted, and which of those; None if all.
    r, places : list of slice or None, list of int
        Range of each in the map, and where it stands among all: as they are noted.
    untidy : bool
        True if some of the landmarks have something to tidy up after a correction: see `tidy`.
    has_E : bool
        True if E was computed with the rest, by compiled code.
    y, R, z, index, measured, matched, updated : sequences of length K
        The columns of `Obs` of these names.
    """

    def __init__(self, sen, lmks, e, v, visible, ranges, E_r=None, E_s=None, E_l=None, *, J=None, n=None):
        self.sen, self.lmks, self.e = sen, lmks, e
        self.v, self.visible, self.ranges = v, visible, ranges
        self.J, self.n = J, n
        self.has_E = self.untidy = False
        self.group: Any = None  # these two by who makes a table of what is noted
        self.some: list[int] | None = None
        if J is None:
            vars(self).update(E_r=E_r, E_s=E_s, E_l=E_l)  # not looked up in J, then
        self.K = K = len(e)
        self.measured, self.matched, self.updated, self.index = [False] * K, [False] * K, [False] * K, [None] * K
        self._measured = (), (), None, None, None  # see `measure`

    in_view = lazy(lambda self: self.visible.nonzero()[0].tolist())  # as they are when it is asked for at first
    r = lazy(lambda self: chosen(self.group.ranges, self.some))
    places = lazy(lambda self: chosen(self.group.places, self.some))
    E_r = lazy(lambda self: self.J[..., : self.n])
    E_s = lazy(lambda self: self.J[..., self.n : 2 * self.n])
    E_l = lazy(lambda self: self.J[..., 2 * self.n :])
    H_l = lazy(lambda self: self.E_l)  # that of the blocks, where it is another one

    def blocks(self, some=None):
        """The stack of blocks (range, Jacobian) of all of them, or of some, given by their indices."""
        (r, s, indices), J = self.ranges, (self.E_r, self.E_s, self.H_l)
        if some is not None:
            indices, J = None if indices is None else indices.take(some, 0), [each.take(some, 0) for each in J]
        return (r, J[0]), (s, J[1]), (indices, J[2])

    def keep(self, map, some):
        """Note the covariance of the states that some of them depend on: E follows from it when asked for."""
        if self.has_E:
            return
        every = len(some) == self.K
        blocks = [(r, J) for r, J in self.blocks(None if every else some) if r is not None]
        indices, k = np.empty((len(some), sum(J.shape[-1] for _, J in blocks)), int), 0
        for r, J in blocks:
            indices[:, k : k + J.shape[-1]] = np.arange(r.start, r.stop) if isinstance(r, slice) else r
            k += J.shape[-1]
        self._kept = some, [J for _, J in blocks], map.block(indices)

    def keep_all(self, map):
        """The same for all of them; what has no finite covariance is not visible."""
        self.keep(map, range(self.K))
        self.visible = self.visible & np.isfinite(self.E).all((-1, -2))

    @lazy
    def E(self):
        """Covariance of the expectations, H P H', when `keep` was called, shape (K, m, m); NaN where it was not."""
        E = np.full((*self.e.shape, self.e.shape[-1]), np.nan)
        some, H, P = self._kept
        H = np.concatenate(H, -1) if H else np.zeros((len(some), self.e.shape[-1], 0))
        E[list(some)] = H @ P @ np.swapaxes(H, -1, -2)
        return E

    def match(self, pairs, wanted):
        """Note the measurements of the landmarks that are looked for.

        Parameters
        ----------
        pairs : dict of int to int
            Landmark id to index of its measurement, from an association.
        wanted : list of int
            Which landmarks are looked for.

        Returns
        -------
        list of int
            Which of them are found.
        """
        lmks, measured, matched, index, found = self.lmks, self.measured, self.matched, self.index, []
        for k in wanted:
            measured[k], id = True, lmks[k].id
            if id in pairs:
                matched[k], index[k] = True, pairs[id]
                found.append(k)
        return found

    def measure(self, found, index, y, z, R):
        """Note what was measured of those that are found.

        Parameters
        ----------
        found, index : list of int, shape (k,)
            Which of them, and which measurement each of them has.
        y : ndarray, shape (·, m)
            All measurements.
        z : ndarray, shape (k, m)
            Innovations.
        R : ndarray, shape (m, m) or (k, m, m)
            One for all or one for each.
        """
        self._measured = found, index, y, z, R

    def refuse(self, some, raw, sensor):
        """Note the measurements of those that are found, but must not be used: they come behind the others.

        Parameters
        ----------
        some : list of int
            Which of them.
        raw : raw measurements: `y` (k, m), and `R` (k, m, m) or None
        sensor : SensorModel
        """
        found, index = [*self._measured[0], *some], [*self._measured[1], *(self.index[k] for k in some)]
        y = np.asarray(raw.y, float)
        z = sensor.residual(y.take([self.index[k] for k in some], 0), self.e.take(some, 0))
        if len(found) > len(some):
            z = np.concatenate([np.asarray(self._measured[3]), z])
        self.measure(found, index, y, z, sensor.R if raw.R is None else np.asarray(raw.R, float).take(index, 0))

    def _column(self, value):
        """Column of what `measure` has noted, None for those not found: written out when somebody asks for it."""
        column, (found, index, *noted) = [None] * self.K, self._measured
        for a, (k, i) in enumerate(zip(found, index, strict=True)):
            column[k] = value(a, i, *noted)
        return column

    y = lazy(lambda self: self._column(lambda a, i, y, z, R: y[i]))
    z = lazy(lambda self: self._column(lambda a, i, y, z, R: z[a]))
    R = lazy(lambda self: self._column(lambda a, i, y, z, R: R if R.ndim == 2 else R[a]))


def chosen(each, some):
    """Return some of a list, given by their indices; all of it if some is None."""
    return each if some is None else [each[i] for i in some]


def merged(parts):
    """Landmarks of several types in one table: Jacobians of the smaller ones get columns of zeros.

    Parameters
    ----------
    parts : list of Sightings
        At least one, all of the same sensor; `places` says where each landmark stands among all.

    Returns
    -------
    Sightings
        In the order of the places.
    """
    if len(parts) == 1:
        return parts[0]
    order = np.argsort(np.concatenate([part.places[: part.K] for part in parts]))
    every = lambda name: [getattr(part, name) for part in parts]
    e, v, visible, E_r, E_s = (np.concatenate(every(name)) for name in ("e", "v", "visible", "E_r", "E_s"))
    in_map = [part.ranges[2] for part in parts if part.ranges[2] is not None]
    size, k = max(part.E_l.shape[-1] for part in parts), 0
    indices = np.full((len(e), size), in_map[0][0, 0] if in_map else -1)  # some state: its derivative is zero
    E_l, H_l = np.zeros((*e.shape, size)), np.zeros((*e.shape, size))
    for part in parts:
        span, width = slice(k, k + part.K), part.E_l.shape[-1]
        E_l[span, :, :width], k = part.E_l, span.stop
        if part.ranges[2] is not None:  # by what is known there is no derivative
            indices[span, :width], H_l[span, :, :width] = part.ranges[2], part.E_l
            indices[span, width:] = part.ranges[2][:, -1:]
    e, v, visible, E_r, E_s, E_l, H_l = (a.take(order, 0) for a in (e, v, visible, E_r, E_s, E_l, H_l))
    ranges = (*parts[0].ranges[:2], indices.take(order, 0) if in_map else None)
    seen = parts[0].sen, _in_order(order, [part.lmks[: part.K] for part in parts]), e, v, visible, ranges
    if any(part.J is None for part in parts):
        whole = Sightings(*seen, E_r, E_s, E_l)
    else:
        whole = Sightings(*seen, J=np.concatenate([E_r, E_s, H_l], -1), n=E_r.shape[-1])
        H_l = whole.E_l
    whole.E_l, whole.H_l, whole.untidy = E_l, H_l, any(every("untidy"))
    whole.r = _in_order(order, [part.r[: part.K] for part in parts])
    if all(every("has_E")):
        whole.E, whole.has_E = np.concatenate(every("E")).take(order, 0), True
    return whole


def _in_order(order, lists):
    """Return the members of some lists as one list, in this order."""
    joined = sum(lists, [])
    return [joined[i] for i in order.tolist()]
