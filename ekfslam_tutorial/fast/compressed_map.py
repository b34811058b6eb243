"""The compressed extended Kalman filter: the same estimate, at a cost that does not depend on the size of the map.

A robot sees a few landmarks for a while. Only the *active* states, the robot and these landmarks, need their
covariance now; all others, the *far* states b, need theirs when somebody asks. J. Guivant and E. Nebot, "Optimization
of the simultaneous localization and map-building algorithm for real-time implementation", IEEE T-RA 17(3), 2001.

Whatever a prediction or a correction does to the active states, it does to the far ones only through P_ba, their
covariance with the states a that were active when this began. So the far states are a linear function of *virtual*
states v, as many as a:

    b = b_0 + G v,    G = P_ba L^-T,    with v = 0, P_vv = 0, P_av = L at the beginning, where L L' is about P_aa.

Then P_ba = G P_va and P_bb = P_bb0 + G P_vv G' at any time, and v goes through the filter like an active state, in one
small `FastMap` of a and v: its P_av and P_vv are the matrices phi and -psi of the paper, its mean the vector theta. A
far state that is needed becomes active by the same formulas, with a virtual state of its own (`virtual`). When too much
is active, all is *settled* at once: one product of large matrices, which is what computers do fastest.
"""

from typing import ClassVar

import numpy as np

from .columns import Columns
from .core import map_html
from .extra import check_compiled, compiled
from .fast_map import GROWTH, NOTHING, FastMap
from .notes import Notes
from .storage import nothing, symmetric
from .virtual import VirtualStates, cholesky

AT_ONCE = 256  # states for which the small map has storage at once: half a megabyte
TOGETHER = 8  # entries of the map that become active at once: four landmarks take little longer than one


class CompressedMap:
    """A map for long runs with many landmarks, of which few are seen at a time. Its estimate is that of `FastMap`.

    The operations of the filter take it like a `FastMap`, and it has the public interface of `ekf.Map`. Asking for `P`
    costs as much as a correction of the whole map: use `block` and `state` in a loop.

    Parameters
    ----------
    capacity : int, optional
        Most states that may be in use at a time. Without it the map grows as needed.
    active : int
        Most active states. After the correction that takes more, all is settled, and only those used last stay
        active. About four times what is used in one step is best.
    compiled : bool
        As in `FastMap`.
    """

    all_active: ClassVar[bool] = False

    def __init__(self, capacity=None, active=100, *, compiled=False):
        if not isinstance(active, (int, np.integer)) or active < 1:
            raise ValueError(f"active must be a positive number of states, got {active!r}")
        if compiled:
            check_compiled(ImportError)
        self._whole, self.active, self.compiled = FastMap(capacity, compiled=compiled), active, compiled
        self._spot_of = np.zeros(0, int)  # where each state of the map stands in the small one; -1: far
        self._last_use = np.zeros(0, int)  # when it was used last
        self._start_of = np.zeros(0, int)  # where the state begins that it belongs to
        self._state_at = np.zeros(0, int)  # which state stands where in the small map; -1: virtual
        self._std = np.zeros(0)  # of far states at least their standard deviation, of active ones 0: `roughly`
        self._refers = np.zeros(0)  # the estimate that each state's covariance refers to, for the invariant error
        self._small, self._virtual = FastMap(compiled=compiled), VirtualStates(0, compiled)
        self._small.reserve(min(2 * active, AT_ONCE))  # as many virtual states
        self._now, self.layout, self._std_known = 0, 0, False
        self._room = slice(0)  # in the whole map: `free` there
        self.notes = Notes()
        self._start_anew()

    def __repr__(self):
        return repr(self._whole).replace("Fast", "Compressed").replace("in use", f"in use, {self.n_active} active")

    def _repr_html_(self):
        return map_html(self)

    def __getstate__(self):
        """Return what copies and files keep. All is settled for it: the estimate stays the same, but for rounding."""
        self.P  # noqa: B018
        return {
            "whole": self._whole.__getstate__(),
            "active": self.active,
            "compiled": self.compiled,
            "last_use": self._last_use.copy(),
            "now": self._now,
            "refers": self._refers.copy(),
        }

    def __setstate__(self, state):
        robs = self.robs if "_whole" in vars(self) else []
        self.__init__(active=state["active"], compiled=state.get("compiled", False))
        self._whole.robs = robs  # unless there are others in what is put in
        self._whole.__setstate__(state["whole"])
        self._last_use, self._now, self._refers = np.array(state["last_use"]), state["now"], np.array(state["refers"])
        self._spot_of, self._start_of = np.full(len(self._last_use), -1), np.zeros(len(self._last_use), int)
        for r in self._whole.ranges:
            self._start_of[r] = r.start
        self._std, self._std_known = np.zeros(len(self._spot_of)), False
        self._virtual.extend(len(self._spot_of))
        self._start_anew()

    @property
    def ranges(self):
        """Ranges of the states in use, in the order of the map: a list of slices."""
        return self._whole.ranges

    @property
    def capacity(self):
        """Most states that may be in use at a time, or None."""
        return self._whole.capacity

    @property
    def n(self):
        """Extent: one past the last used entry there ever was."""
        return self._whole.n

    @property
    def n_used(self):
        """Number of states in use."""
        return self._whole.n_used

    @property
    def used(self):
        """Mask of the states that are in use, shape (n,), bool."""
        return self._whole.used

    @property
    def robs(self):
        """The robots that have been put into it, as in `ekf.Map`: a list."""
        return self._whole.robs

    @property
    def x(self):
        """Mean of all states, shape (n,). A view: writing into it changes the map."""
        self._settle_means()
        return self._whole.x

    @x.setter
    def x(self, x):
        """Write all of it: `map.x += dx` does that."""
        self.x[:] = x

    @property
    def P(self):
        """Covariance of all states, shape (n, n). A view, too, good until the next operation on the map."""
        if self.n_active:
            self._settle()
            self._start_anew()
        self._std_known = False  # who gets it may write to it
        return self._whole.P

    @P.setter
    def P(self, P):
        """Write all of it. It refers to the present estimate then."""
        self.P[:] = P
        self._refers[: self.n] = self.x

    def flush(self):
        """Settle all that is active; what was used last stays active."""
        if self.n_active:
            self._flush(*self._used_last())

    def _flush(self, keep, active):
        """Settle all that is active; some of it stays active."""
        rows = self._settle(active)[1]
        self._start_anew()
        self._activate(keep, rows[np.searchsorted(active, keep)])

    @property
    def _active_states(self):
        """The states that are active, in the order of the map."""
        return np.flatnonzero(self._spot_of >= 0)

    @property
    def n_active(self):
        """Count of the active states."""
        return self._small.n_used - len(self._v)

    def _used_last(self):
        """The active states that were used last: a fifth of `active`, and what was used together with it; and all."""
        active = self._active_states
        last = self._last_use[active]
        n = min(len(last), 1 + self.active // 5)
        return active[last >= np.partition(last, -n)[-n]], active

    def add(self, x, P_xx, P_xm=None):
        """Put a state into the map: see `FastMap.add`."""
        if P_xm is not None:
            self.P  # noqa: B018 -- nothing is active now
        r = self._whole.add(x, P_xx, P_xm)
        self.notes.changes += 1
        self._std_known = False
        self._make_room(self.n)
        self._start_of[r], self._refers[r] = r.start, x
        return r

    def put(self, r, x, P_rm, P_rr):
        """Replace the state in range r: see `FastMap.put`. P_rm is its covariance with the whole map."""
        self.P  # noqa: B018 -- nothing is active now
        head, tail = slice(r.start, r.start + len(x)), slice(r.start + len(x), r.stop)
        self._whole.replace(head, x, P_rm, P_rr)
        self._refers[head] = x
        if tail.start < tail.stop:
            self.notes.changes += 1
            self.vacate(tail)
        return head

    def remove(self, r):
        """Take the state of range r out of the map: see `FastMap.remove`."""
        self._whole.check_range(r)
        self.notes.changes += 1
        self.vacate(r)

    def state(self, r):
        """Mean of the state in range r: a copy, shape (k,); of K states given by indices (K, k), shape (K, k)."""
        if self._far_behind and not (isinstance(r, slice) and (r.start, r.stop) in self._spots):
            if self._spot_of[r].min(initial=0) < 0:
                self._settle_means()
        return self._whole.state(r)

    def entry(self, i):
        """Mean of the entry at index i: see `FastMap.entry`."""
        if self._far_behind and self._spot_of.item(i) < 0:
            self._settle_means()
        return self._whole.entry(i)

    def block(self, r):
        """Covariance of the state in range r: a copy, shape (k, k); of K states by indices (K, k), (K, k, k)."""
        i = np.arange(r.start, r.stop) if isinstance(r, slice) else r
        spot = self._spot_of[i]
        n_far = np.count_nonzero(spot < 0)
        if i.ndim == 2 and 0 < n_far <= self.active // 4:  # so few are those just come into view: needed in a moment
            spot, n_far = self._spots_of(i.ravel())[i], 0
        if not n_far:
            return self._small.block(np.atleast_2d(spot)).reshape(*spot.shape, spot.shape[-1])
        T, far = self._by_active(i), spot < 0
        P_0 = np.where(far[..., :, None] & far[..., None, :], self._whole.block(r), 0.0)
        P = P_0 + T @ self._small.P @ np.swapaxes(T, -1, -2)
        return 0.5 * (P + np.swapaxes(P, -1, -2))

    # --- for the operations of the filter: see `FastMap` --------------------------------------------------------------

    def variances(self, r):
        """Return what `FastMap.variances` does; those of far states may be too large: as they were last settled.

        What has happened since then has only made them smaller: far states do not move.
        """
        spot, far = self._spot_of[r], self._whole.variances(r)
        return np.where(spot >= 0, self._small.variances(spot), far) if self.n_active else far

    def fetch(self, blocks):
        """Return rows as `FastMap.fetch`, of all that is active. The states of the blocks become active."""
        inside = [block for block in blocks if block[0] is not None]
        self._used_spots = [(r, self.spot(r)) for r, _ in inside]
        self._now += 1
        for r, _ in inside:
            self._last_use[r] = self._now
        rows = [(J, self._small.rows(spot)) for (_, J), (_, spot) in zip(inside, self._used_spots, strict=True)]
        return rows or [nothing(blocks, self._small.n)]

    def rows(self, r):
        """Covariance of the state in range r with all that is active, shape (k, ·) or (K, k, ·)."""
        return self._small.rows(self.spot(r))

    def spot(self, r):
        """Return where the state in range r, or those given by indices, stand in `rows`. They become active."""
        if not isinstance(r, slice):
            spot = self._spot_of[r]
            return self._spots_of(r.ravel())[r] if spot.min() < 0 else spot
        if (spot := self._spots.get((r.start, r.stop))) is None:
            spot = self._spots_of(np.arange(r.start, r.stop))[r]
            if len(spot) and (np.diff(spot) == 1).all():
                spot = slice(int(spot[0]), int(spot[-1]) + 1)
            self._spots[r.start, r.stop] = spot
        return spot

    @property
    def storage(self):
        """`FastMap.storage` of what is active; x is how far it has moved, until `relieve` has seen to it."""
        small = self._small
        return small._x, small._P, small.n, small._lower

    @property
    def means(self):
        """Means of all states, of which those of the active ones are up to date: a view."""
        return self._whole._xn

    @property
    def bookkeeping(self):
        """For compiled code: where each state stands in `storage`, when it was used last, now; the means, and whose."""
        return self._spot_of, self._last_use, self._now, self._whole._xn, self._state_at

    def spots(self, r, s=None, indices=None, some=None):
        """Return where these states stand in `storage`; they become active. Of the indices, (K, k), only some."""
        self._now += 1
        if r is not None:
            self._last_use[r], r = self._now, self.spot(r)
        if s is not None:
            self._last_use[s], s = self._now, self.spot(s)
        if indices is not None:
            found = compiled().spots(self._spot_of, self._last_use, self._now, indices, some) if self.compiled else None
            if found is None:
                used = indices[some]
                self._last_use[used] = self._now
                found = self._spots_of(used.ravel())[indices]
            indices = found
        return r, s, indices

    def _spots_of(self, i):
        """Make these states active, with their neighbours. Returns where each state stands."""
        wanted = i[self._spot_of[i] < 0]
        if len(wanted):
            self._activate(self._with_neighbours(wanted))
        return self._spot_of

    def _with_neighbours(self, wanted):
        """These far states, and whole states that stand beside them: what was started together is seen together."""
        n, block = self.n, np.zeros(-(-self.n // TOGETHER), bool)
        block[wanted // TOGETHER] = True
        chosen = block[self._start_of[:n] // TOGETHER] & (self._spot_of[:n] < 0) & self.used
        chosen[wanted] = True
        return np.flatnonzero(chosen)

    def columns(self, HP, blocks):
        """P H' from H P: of the active states; that of the far ones follows if somebody asks."""
        return Columns(self, HP, blocks, self._used_spots)

    def replace(self, r, x, P_rm, P_rr):
        """Replace the state in range r by one of the same length; P_rm is its covariance with all that is active."""
        spot = self.spot(r)
        if isinstance(spot, slice):
            self._small.replace(spot, 0.0, P_rm, P_rr)
        else:
            P = self._small.P
            P[spot], P[:, spot], P[np.ix_(spot, spot)], self._small.x[spot] = P_rm, P_rm.T, symmetric(P_rr), 0.0
        self._whole.set_mean(r, x)
        self._refers[r] = x

    def set_mean(self, r, x):
        """Set the mean of the state in range r, and leave its covariance as it is."""
        if self._far_behind and (r.start, r.stop) not in self._spots:
            self._settle_means()
        self._whole.set_mean(r, x)
        self._refers[r] = x

    def roughly(self, settled=False):
        """Return the means of all states, where the far ones are as they were last settled, and how far off they are.

        In b = b_0 + G v no row of G is longer than the standard deviation that its state had then, so each is off by

            |b - b_0| <= |v| std

        at most; of all `moved`, only v is not zero.

        Parameters
        ----------
        settled : bool
            Settle the means first: then they are exact.

        Returns
        -------
        x, std : ndarray, shape (n,) or longer
            Not to be written to; std is 0 for the active states, whose means are exact.
        moved : ndarray, shape (m,)
            What the small map has moved by since then; empty if no mean is behind.
        """
        if settled:
            self._settle_means()
        if not self._far_behind:
            return self._whole.x, self._std, NOTHING
        if not self._std_known:
            n, self._std_known = self.n, True
            self._std[:n] = _roots(np.where(self._spot_of[:n] < 0, self._whole.variances(slice(0, n)), 0.0))
        return self._whole._xn, self._std, self._small._xn

    def referred(self):
        """Return the estimate that each state's covariance refers to; not a copy: `carry` keeps it up to date."""
        return self._refers

    def carry(self, at, D, r, E):
        """Do as `FastMap.carry`, of states that are active, or become so; the others will have to catch up."""
        spot = self._spots_of(at)[at]
        self._small.carry(spot, D, self.spot(r), E)
        self._refers[at] = self._whole.x[at]

    def shift(self, dx):
        """x = x + dx, of all that is active; see `storage`."""
        self._small.shift(dx)

    def subtract(self, Wt):
        """P = P - W W', of all that is active."""
        self._small.subtract(Wt)
        self.relieve()

    def keep_one_triangle(self):
        """Do as `FastMap.keep_one_triangle`, of what is active."""
        return self._small.keep_one_triangle()

    def relieve(self, followed=False):
        """Settle all, after a correction, when too much is active; the means of the active states may have followed."""
        if followed:
            self._far_behind = True
        else:
            self._follow()
        if self.n_active > self.active:
            keep, active = self._used_last()
            if len(active) > 2 * len(keep):  # it would be of no use if all were needed again
                self._flush(keep, active)

    def insert(self, x, P_xx, P_xm):
        """Put in a new state, an active one; P_xm is its covariance with all that is active. Returns its range."""
        r = self._whole.free(len(x))  # or the map is full
        spot = self._small.insert(np.zeros(len(x)), P_xx, P_xm)
        self._make_room(r.stop, spot.stop)
        self._now += 1
        self._start_of[r], self._refers[r] = r.start, x
        self._note_active(np.arange(r.start, r.stop), spot)
        self._spots[r.start, r.stop] = spot
        return self._whole.occupy(r, x)

    def free(self, k):
        """Return where a new state of k entries can be put in `storage`: see `FastMap.free`."""
        self._room = self._whole.free(k)  # or the map is full
        spot = self._small.free(k)
        self._make_room(self._room.stop, spot.stop)
        return spot

    def ledger(self, spot):
        """Return what `FastMap.ledger` does."""
        each = self._start_of, self._refers, self._spot_of, self._last_use, self._std, self._state_at
        return self._room.start, self._now + 1, *self._whole.entries, self._small.entries[1], *each

    def take(self, spot):
        """A new state, an active one, where it is `free` in `storage`: see `FastMap.take`. Returns its range."""
        r = self._room
        self._small.take(spot)
        self._now += 1
        self._spots[r.start, r.stop] = spot
        self.layout += 1
        return self._whole.take(r)

    def vacate(self, r):
        """Free the entries of range r, a state or a part of one: see `FastMap.vacate`."""
        self._settle_means()
        self._whole.vacate(r)
        for spot in self._spot_of[r].tolist():
            if spot >= 0:
                self._small.vacate(slice(spot, spot + 1))
                self._state_at[spot] = -1
        self._spot_of[r] = -1
        self._virtual.forget(r)
        self._spots, self.layout = {}, self.layout + 1

    # --- between the far states and the active ones ------------------------------------------------------------------

    def _start_anew(self):
        """Nothing is active."""
        self._small.clear()
        self._virtual.clear()
        self._v = np.zeros(0, int)
        self._spot_of[:], self._state_at[:], self._spots, self._far_behind = -1, -1, {}, False
        self.layout += 1

    def _note_active(self, i, spot):
        """Note that these states, given by their indices, stand at these spots now."""
        self._state_at[spot], self._spot_of[i], self._last_use[i] = i, np.arange(spot.start, spot.stop), self._now
        self._std[i] = 0.0
        self.layout += 1

    def _make_room(self, n, n_small=0):
        """Let the arrays reach over both maps, as large as they are, or will be."""
        if n_small > len(self._state_at):
            self._state_at = np.concatenate([self._state_at, np.full(n_small, -1)])
        if n > len(self._spot_of):
            more = int(GROWTH * n) - len(self._spot_of)
            self._spot_of = np.concatenate([self._spot_of, np.full(more, -1)])
            self._last_use = np.concatenate([self._last_use, np.zeros(more, int)])
            self._start_of = np.concatenate([self._start_of, np.zeros(more, int)])
            self._std = np.concatenate([self._std, np.zeros(more)])
            self._refers = np.concatenate([self._refers, np.zeros(more)])
            self._virtual.extend(len(self._spot_of))

    def _activate(self, i, P_i=None):
        """Bring far states to active, and with them virtual states. P_i are their rows of P_0, if they are known."""
        if not all(self.used[i].tolist()):
            raise ValueError(f"states {i.tolist()} are not in use in this map of {self.n} states")
        self._settle_means()
        P_i = self._whole.rows(i[None])[0] if P_i is None else P_i
        P_ii = P_i.take(i, 1)
        G_i = self._virtual.add(i, P_i, P_ii)
        r = compiled().joined(self._small, self._v, G_i, P_ii) if self.compiled else self._joined(G_i, P_ii)
        k = len(i)
        self._v = np.concatenate([self._v, np.arange(r.start + k, r.stop)])
        self._make_room(self.n, self._small.n)
        self._note_active(i, slice(r.start, r.start + k))

    def _joined(self, G_i, P_ii):
        """Put states that depend on the virtual ones by G_i, and those of these that are new, into the small map."""
        small, v = self._small, self._v
        old, new = G_i[:, : len(v)], G_i[:, len(v) :]
        k, m = len(G_i), len(G_i) + new.shape[1]
        P_xm, P_xx = np.zeros((m, small.n)), np.zeros((m, m))
        P_xm[:k] = old.dot(small.rows(v))
        P_xx[:k, :k] = P_ii + P_xm[:k, v].dot(old.T)
        P_xx[:k, k:], P_xx[k:, :k] = new, new.T
        P_xm[:k, v] += old
        return small.insert(np.zeros(m), symmetric(P_xx), P_xm)

    def _by_active(self, i):
        """T with P = P_0 + T P_small T': an active state is itself, a far one follows the virtual ones by G."""
        spot = self._spot_of[i.ravel()]
        T, active, far = np.zeros((i.size, self._small.n)), np.flatnonzero(spot >= 0), np.flatnonzero(spot < 0)
        T[active, spot[active]] = 1.0
        T[np.ix_(far, self._v)] = self._virtual.of(i.ravel()[far])
        return T.reshape(*i.shape, -1)

    def _follow(self):
        """Bring the means of the active states up to date: those of the far ones are behind now."""
        x, moved, self._far_behind = self._whole.x, self._small.x, True
        if self.compiled:
            compiled().follow(x, moved, self._state_at)
            return
        spot = np.flatnonzero(self._state_at[: len(moved)] >= 0)
        x[self._state_at[spot]] += moved[spot]
        moved[spot] = 0.0

    def _settle_means(self):
        """Bring the means of all states up to date: b = b_0 + G v."""
        if not self._far_behind:
            return
        self._far_behind, moved = False, self._small.x
        if self.compiled:
            compiled().settle(self._whole.x, moved, self._virtual, self._v, self._state_at)
            return
        dx = self._virtual.times(moved[self._v], self.n)
        dx[self._active_states] = 0.0
        self._whole.shift(dx)
        moved[:] = 0.0

    def _settle(self, active=None):
        """Bring the large covariance up to date. Returns which states were active, and their rows of it."""
        self._settle_means()
        active = self._active_states if active is None else active
        if self.compiled:
            rows = compiled().settled(
                self._whole, self._small, self._virtual, active, self._spot_of, self._v, self._std
            )
            if rows is not None:
                return active, rows
        P, v, spot = self._small.between, self._v, self._spot_of[active]
        both = self._virtual.through(np.concatenate([P(spot, v), cholesky(-P(v, v))[0].T]), self.n)
        rows, Wt = both[: len(active)], both[len(active) :]
        rows[:, active] = P_aa = P(spot, spot)
        self._std[active] = _roots(P_aa.diagonal())  # those of the far states have only become smaller
        if len(v):
            far = np.flatnonzero(self._spot_of[: self.n] < 0)  # the others get their rows
            self._whole.subtract(Wt[:, : 1 + far.max(initial=-1)])
        self._whole.overwrite(active, rows)
        return active, rows


def _roots(variances):
    return np.sqrt(np.maximum(variances, 0.0))
