"""The compressed extended Kalman filter: the same estimate, at a cost that does not depend on the size of the map.

A robot sees a few landmarks for a while. Only the states *at hand*, the robot and these landmarks, need their
covariance now; all others, the *far* states b, need theirs when somebody asks. J. Guivant and E. Nebot, "Optimization
of the simultaneous localization and map-building algorithm for real-time implementation", IEEE T-RA 17(3), 2001.

Whatever a prediction or a correction does to the states at hand, it does to the far ones only through P_ba, their
covariance with the states a that were at hand when this began. So the far states are a linear function of *virtual*
states v, as many as a:

    b = b_0 + G v,    G = P_ba L^-T,    with v = 0, P_vv = 0, P_av = L at the beginning, where L L' is about P_aa.

Then P_ba = G P_va and P_bb = P_bb0 + G P_vv G' at any time, and v goes through the filter like a state at hand, in one
small ordinary `Map` of a and v: its P_av and P_vv are the matrices phi and -psi of the paper, its mean the vector
theta. A far state that is needed comes to hand by the same formulas, with a virtual state of its own (`virtual`). When
too much is at hand, all is put back at once: one product of large matrices, which is what computers do fastest.
"""

import numpy as np

from .columns import Columns
from .extra import check_compiled, compiled
from .html import map_html
from .stochastic_map import GROWTH, Map, nothing, symmetric
from .virtual import VirtualStates, cholesky

TOGETHER = 8  # entries of the map that come to hand at once: four landmarks take little longer than one


class CompressedMap:
    """A map for long runs with many landmarks, of which few are seen at a time. Its estimate is that of `Map`.

    The operations of the filter take it like a `Map`. Asking for `P` costs as much as a correction of the whole map:
    use `block` and `state` in a loop.

    Parameters
    ----------
    capacity : int, optional
        Most states that may be in use at a time. Without it the map grows as needed.
    active : int
        Most states at hand. After the correction that takes more, all is put back, and only those used last stay at
        hand. About four times what is used in one step is best.
    compiled : bool
        As in `Map`.
    """

    def __init__(self, capacity=None, active=100, *, compiled=False):
        if not isinstance(active, (int, np.integer)) or active < 1:
            raise ValueError(f"active must be a positive number of states, got {active!r}")
        if compiled:
            check_compiled(ImportError)
        self._far, self.active, self.compiled = Map(capacity, compiled=compiled), active, compiled
        self._at = np.zeros(0, int)  # where each state of the map is at hand; -1 for the far ones
        self._used_at = np.zeros(0, int)  # when it was used last
        self._first = np.zeros(0, int)  # where the state begins that it belongs to
        self._of = np.zeros(0, int)  # which state of the map stands where in the near map; -1 for the virtual ones
        self._near, self._virtual = Map(compiled=compiled), VirtualStates(0, compiled)
        self._now = self.layout = 0
        self._place = slice(0)  # of the far map: `free` there
        self._begin()

    def __repr__(self):
        return f"Compressed{self._far!r}".replace("states in use", f"states in use, {self._n_hand} at hand")

    def _repr_html_(self):
        return map_html(self)

    def __getstate__(self):
        """For copies and files. All is put back for it: the estimate stays the same, but for rounding."""
        self.P  # noqa: B018
        return {
            "far": self._far.__getstate__(),
            "active": self.active,
            "compiled": self.compiled,
            "used_at": self._used_at.copy(),
            "now": self._now,
        }

    def __setstate__(self, state):
        self.__init__(active=state["active"], compiled=state.get("compiled", False))
        self._far.__setstate__(state["far"])
        self._used_at, self._now = np.array(state["used_at"]), state["now"]
        self._at, self._first = np.full(len(self._used_at), -1), np.zeros(len(self._used_at), int)
        for r in self._far.ranges:
            self._first[r] = r.start
        self._virtual.reach(len(self._at))
        self._begin()

    @property
    def ranges(self):
        """Ranges of the states in use, in the order of the map: a list of slices."""
        return self._far.ranges

    @property
    def capacity(self):
        """Most states that may be in use at a time, or None."""
        return self._far.capacity

    @property
    def n(self):
        """Extent: one past the last used entry there ever was."""
        return self._far.n

    @property
    def n_used(self):
        """Number of states in use."""
        return self._far.n_used

    @property
    def used(self):
        """Which states are in use, shape (n,), bool."""
        return self._far.used

    @property
    def x(self):
        """Mean of all states, shape (n,). A view: writing into it changes the map."""
        self._settle()
        return self._far.x

    @property
    def P(self):
        """Covariance of all states, shape (n, n). A view, too, good until the next operation on the map."""
        if self._n_hand:
            self._put_back()
            self._begin()
        return self._far.P

    def flush(self):
        """Put all that is at hand back into the large covariance; what was used last stays at hand."""
        if not self._n_hand:
            return
        keep = self._used_last()
        hand, rows = self._put_back()
        self._begin()
        self._load(keep, rows[np.searchsorted(hand, keep)])

    @property
    def _hand(self):
        """The states that are at hand, in the order of the map."""
        return np.flatnonzero(self._at >= 0)

    @property
    def _n_hand(self):
        """How many states are at hand."""
        return self._near.n_used - len(self._v)

    def _used_last(self):
        """The states at hand that were used last: a fifth of `active`, and what was used together with it."""
        hand = self._hand
        last = self._used_at[hand]
        n = min(len(last), 1 + self.active // 5)
        return hand[last >= np.partition(last, -n)[-n]]

    def add(self, x, P_xx, P_xm=None):
        """Put a state into the map: see `Map.add`."""
        if P_xm is not None:
            self.P  # noqa: B018 -- nothing is at hand now
        r = self._far.add(x, P_xx, P_xm)
        self._make_room()
        self._first[r] = r.start
        return r

    # --- what the operations of the filter are made of: see `Map` ----------------------------------------------------

    def state(self, r):
        """Mean of the state in range r: a copy, shape (k,); of K states given by their rows (K, k), shape (K, k)."""
        if self._behind and not (isinstance(r, slice) and (r.start, r.stop) in self._here):
            self._settle()
        return self._far.state(r)

    def block(self, r):
        """Covariance of the state in range r: a copy, shape (k, k); of K states by their rows (K, k), (K, k, k)."""
        i = np.arange(r.start, r.stop) if isinstance(r, slice) else r
        here = self._at[i]
        n_far = np.count_nonzero(here < 0)
        if i.ndim == 2 and 0 < n_far <= self.active // 4:  # so few are those just come into view: needed in a moment
            here, n_far = self._bring(i.ravel())[i], 0
        if not n_far:
            return self._near.block(np.atleast_2d(here)).reshape(*here.shape, here.shape[-1])
        T, far = self._by_those_at_hand(i), here < 0
        P_0 = np.where(far[..., :, None] & far[..., None, :], self._far.block(r), 0.0)
        P = P_0 + T @ self._near.P @ np.swapaxes(T, -1, -2)
        return 0.5 * (P + np.swapaxes(P, -1, -2))

    def variances(self, r):
        """As `Map.variances`, but those of the far states may be larger than they are: as they were last put back.

        What has happened since then has only made them smaller: far states do not move.
        """
        here, far = self._at[r], self._far.variances(r)
        return np.where(here >= 0, self._near.variances(here), far) if self._n_hand else far

    def fetch(self, blocks):
        """As `Map.fetch`, of all that is at hand. The states of the blocks are brought there."""
        blocks_in = [block for block in blocks if block[0] is not None]
        self._places = [(r, self.here(r)) for r, _ in blocks_in]
        self._now += 1
        for r, _ in blocks_in:
            self._used_at[r] = self._now
        rows = [(J, self._near.rows(here)) for (_, J), (_, here) in zip(blocks_in, self._places, strict=True)]
        return rows or [nothing(blocks, self._near.n)]

    def rows(self, r):
        """Covariance of the state in range r with all that is at hand, shape (k, ·) or (K, k, ·)."""
        return self._near.rows(self.here(r))

    def here(self, r):
        """Where the state in range r, or those of K ranges, stand in what `rows` returns. They are at hand then."""
        if not isinstance(r, slice):
            here = self._at[r]
            return self._bring(r.ravel())[r] if here.min() < 0 else here
        here = self._here.get((r.start, r.stop))
        if here is None:
            here = self._bring(np.arange(r.start, r.stop))[r]
            if len(here) and (np.diff(here) == 1).all():
                here = slice(int(here[0]), int(here[-1]) + 1)
            self._here[r.start, r.stop] = here
        return here

    @property
    def storage(self):
        """As `Map.storage`, of what is at hand; x is how far it has moved, until `relieve` has seen to it."""
        return self._near.storage

    def at_hand(self, r, s=None, rows=None, some=None):
        """Where these states stand in `storage`; they are brought there to be used. Of the rows, (K, k), only some."""
        self._now += 1
        if r is not None:
            self._used_at[r], r = self._now, self.here(r)
        if s is not None:
            self._used_at[s], s = self._now, self.here(s)
        if rows is not None:
            here = compiled().here(self._at, self._used_at, self._now, rows, some) if self.compiled else None
            if here is None:
                used = rows[some]
                self._used_at[used] = self._now
                here = self._bring(used.ravel())[rows]
            rows = here
        return r, s, rows

    def _bring(self, i):
        """Bring those of these states to hand that are not, with their neighbours. Returns where each state is."""
        wanted = i[self._at[i] < 0]
        if len(wanted):
            self._load(self._with_neighbours(wanted))
        return self._at

    def _with_neighbours(self, wanted):
        """These far states, and whole states that stand beside them: what was started together is seen together."""
        n, block = self.n, np.zeros(-(-self.n // TOGETHER), bool)
        block[wanted // TOGETHER] = True
        chosen = block[self._first[:n] // TOGETHER] & (self._at[:n] < 0) & self.used
        chosen[wanted] = True
        return np.flatnonzero(chosen)

    def columns(self, HP, blocks):
        """P H' from H P: of the states at hand; those of the far ones follow if somebody asks."""
        return Columns(self, HP, blocks, self._places)

    def put(self, r, x, P_xm, P_xx):
        """Replace the state in range r; P_xm is its covariance with all that is at hand."""
        here = self.here(r)
        if isinstance(here, slice):
            self._near.put(here, 0.0, P_xm, P_xx)
        else:
            P = self._near.P
            P[here], P[:, here], P[np.ix_(here, here)], self._near.x[here] = P_xm, P_xm.T, symmetric(P_xx), 0.0
        self._far.move(r, x)

    def move(self, r, x):
        """Set the mean of the state in range r, and leave its covariance as it is."""
        if self._behind and (r.start, r.stop) not in self._here:
            self._settle()
        self._far.move(r, x)

    def shift(self, dx):
        """x = x + dx, of all that is at hand; see `storage`."""
        self._near.shift(dx)

    def subtract(self, Wt):
        """P = P - W W', of all that is at hand."""
        self._near.subtract(Wt)
        self.relieve()

    def keep_one_triangle(self):
        """As `Map.keep_one_triangle`, of what is at hand."""
        return self._near.keep_one_triangle()

    def relieve(self):
        """After a correction: put all back when too much has come to hand."""
        self._follow()
        if self._n_hand > self.active and self._n_hand > 2 * len(self._used_last()):
            self.flush()  # it would be of no use if all were needed again

    def insert(self, x, P_xx, P_xm):
        """A new state, at hand; P_xm is its covariance with all that is at hand. Returns its range."""
        self._place = self._far.free(len(x))  # or the map is full
        return self._own(self._near.insert(np.zeros(len(x)), P_xx, P_xm), x)

    def free(self, k):
        """Where a new state of k entries can be put in `storage`: see `Map.free`."""
        self._place = self._far.free(k)  # or the map is full
        return self._near.free(k)

    def occupy(self, here, x):
        """A new state, at hand where it is `free`. Returns its range in the map."""
        return self._own(self._near.occupy(here, 0.0), x)

    def _own(self, here, x):
        """A new state of the map, which is at hand here."""
        r = self._far.occupy(self._place, x)
        self._make_room()
        self._first[r] = r.start
        self._now += 1
        self._take(range(r.start, r.stop), here)
        self._here[r.start, r.stop] = here
        return r

    def remove(self, r):
        """Take the state of range r out of the map: see `Map.remove`."""
        self._far.check_range(r)
        self.vacate(r)

    def vacate(self, r):
        """Free the entries of range r, a state or a part of one: see `Map.vacate`."""
        self._settle()
        self._far.vacate(r)
        for here in self._at[r].tolist():
            if here >= 0:
                self._near.vacate(slice(here, here + 1))
                self._of[here] = -1
        self._at[r] = -1
        self._virtual.forget(r)
        self._here, self.layout = {}, self.layout + 1

    # --- between the far states and those at hand --------------------------------------------------------------------

    def _begin(self):
        """Nothing is at hand."""
        self._near.clear()
        self._virtual.clear()
        self._v = np.zeros(0, int)
        self._at[:], self._of[:], self._here, self._behind = -1, -1, {}, False
        self.layout += 1

    def _take(self, i, here):
        """Note that these states are at hand now, here."""
        if self._near.n > len(self._of):
            self._of = np.concatenate([self._of, np.full(self._near.n, -1)])
        for state, place in zip(i, range(here.start, here.stop), strict=True):
            self._of[place], self._at[state], self._used_at[state] = state, place, self._now
        self.layout += 1

    def _make_room(self):
        """Let the arrays reach over the whole map."""
        if self.n > len(self._at):
            more = int(GROWTH * self.n) - len(self._at)
            self._at = np.concatenate([self._at, np.full(more, -1)])
            self._used_at = np.concatenate([self._used_at, np.zeros(more, int)])
            self._first = np.concatenate([self._first, np.zeros(more, int)])
            self._virtual.reach(len(self._at))

    def _load(self, i, P_i=None):
        """Bring far states to hand, and with them virtual states. P_i are their rows of P_0, if they are known."""
        if not all(self.used[i].tolist()):
            raise ValueError(f"states {i.tolist()} are not in use in this map of {self.n} states")
        self._settle()
        P_i = self._far.rows(i[None])[0] if P_i is None else P_i
        P_ii = P_i.take(i, 1)
        G_i = self._virtual.take(i, P_i, P_ii)
        r = compiled().joined(self._near, self._v, G_i, P_ii) if self.compiled else self._joined(G_i, P_ii)
        k = len(i)
        self._v = np.concatenate([self._v, np.arange(r.start + k, r.stop)])
        self._take(i.tolist(), slice(r.start, r.start + k))

    def _joined(self, G_i, P_ii):
        """Put states that depend on the virtual ones by G_i, and those of these that are new, into the near map."""
        near, v = self._near, self._v
        old, new = G_i[:, : len(v)], G_i[:, len(v) :]
        k, m = len(G_i), len(G_i) + new.shape[1]
        P_xm, P_xx = np.zeros((m, near.n)), np.zeros((m, m))
        P_xm[:k] = old.dot(near.rows(v))
        P_xx[:k, :k] = P_ii + P_xm[:k, v].dot(old.T)
        P_xx[:k, k:], P_xx[k:, :k] = new, new.T
        P_xm[:k, v] += old
        return near.insert(np.zeros(m), symmetric(P_xx), P_xm)

    def _by_those_at_hand(self, i):
        """T with P = P_0 + T P_near T': a state at hand is itself, a far one follows the virtual ones by G."""
        here = self._at[i.ravel()]
        T, near, far = np.zeros((i.size, self._near.n)), np.flatnonzero(here >= 0), np.flatnonzero(here < 0)
        T[near, here[near]] = 1.0
        T[np.ix_(far, self._v)] = self._virtual.of(i.ravel()[far])
        return T.reshape(*i.shape, -1)

    def _follow(self):
        """Bring the means of the states at hand up to date: those of the far ones are behind now."""
        x, near, self._behind = self._far.x, self._near.x, True
        if self.compiled:
            compiled().follow(x, near, self._of)
            return
        here = np.flatnonzero(self._of[: len(near)] >= 0)
        x[self._of[here]] += near[here]
        near[here] = 0.0

    def _settle(self):
        """Bring the means of all states up to date: b = b_0 + G v."""
        if not self._behind:
            return
        self._behind, near = False, self._near.x
        if self.compiled:
            compiled().settle(self._far.x, near, self._virtual, self._v, self._of)
            return
        dx = self._virtual.times(near[self._v], self.n)
        dx[self._hand] = 0.0
        self._far.shift(dx)
        near[:] = 0.0

    def _put_back(self):
        """Bring the large covariance up to date. Returns which states were at hand, and their rows of it."""
        self._settle()
        hand, v, P = self._hand, self._v, self._near.between
        here, C = self._at[hand], (compiled().cholesky if self.compiled else cholesky)(-P(v, v))[0]
        both = self._virtual.through(np.concatenate([P(here, v), C.T]), self.n)
        rows, Wt = both[: len(hand)], both[len(hand) :]
        rows[:, hand] = P(here, here)
        if len(v):
            end = 1 + np.flatnonzero(self._at[: self.n] < 0).max(initial=-1)  # of the far states: others get their rows
            self._far.subtract(Wt[:, :end])
        self._far.overwrite(hand, rows)
        return hand, rows
