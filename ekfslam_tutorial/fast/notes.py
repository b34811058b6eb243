"""What the wing remembers of a run from one step to the next. It lives with the map; records know nothing of it.

Users change records, maps and dicts of landmarks as they like. So whatever is noted is compared with what is there
before it is used, by identity or by its bytes; where they differ it is noted anew. Of landmarks, those that a sensor
should see are compared, and how many there are, and the last one; the others count as they were until a state is added
to the map, becomes shorter or goes. (To look at each of a thousand landmarks in each step, even at its identity only,
takes some per cent of it.) Where some are known, and so no change of the map tells of them, all are compared.
Copies and files begin without notes.
"""

from itertools import islice

import numpy as np

MANY = 64  # robots and sensors, or dicts of landmarks: so many are never used together, so some are of the past


class Noted:
    """Notes of a robot or a sensor.

    Attributes
    ----------
    obj : Rob or Sen
        Held here, so that its id stays its own.
    frame : Frame2, Frame3 or None
        The frame that was last asked for.
    normal : Frame2, Frame3 or None
        The frame as it was last normalised, since the last motion of any robot.
    control : tuple
        Motion model, shape of the control, and shape and bytes of its covariance, that were last found to be good.
    """

    __slots__ = ("control", "frame", "normal", "obj")

    def __init__(self, obj):
        self.obj, self.frame, self.normal, self.control = obj, None, None, (None, None, None)


class Notes:
    """Notes of robots, sensors, and landmarks in groups.

    Attributes
    ----------
    changes : int
        How often the map has been changed by a state that was added, became shorter or was removed.
    """

    def __init__(self):
        self._of, self._groups, self.changes = {}, {}, 0

    def of(self, obj):
        """Return what is noted of a robot or a sensor."""
        noted = self._of.get(id(obj))
        if noted is None:
            if len(self._of) >= MANY:
                self._of.clear()
            self._of[id(obj)] = noted = Noted(obj)
        return noted

    def forget_normal(self):
        """A robot moves: no frame counts as normalised."""
        for noted in self._of.values():
            noted.normal = None

    def groups(self, lmks):
        """Return the groups of the landmarks of this dict, up to date."""
        groups = self._groups_of(lmks)
        groups.follow(lmks, self.changes)
        return groups

    def started(self, lmks):
        """Return the landmark of this dict that was started last, and how many there were then: see `Groups`."""
        return self._groups_of(lmks).started

    def _groups_of(self, lmks):
        noted = self._groups.get(id(lmks))
        if noted is None:
            if len(self._groups) >= MANY:
                self._groups.clear()
            self._groups[id(lmks)] = noted = lmks, Groups()
        return noted[1]


_numbers = np.arange(1000)


def indices_of(r):
    """Return the indices of a range: a part of an array that grows, which takes less time than to make one."""
    global _numbers
    if r.stop > len(_numbers):
        _numbers = np.arange(2 * r.stop)
    return _numbers[r]


class Group:
    """Landmarks of one type, all in the map or all known: what is needed of them to compute in stacks.

    Parameters
    ----------
    kind : LmkType
    known : bool

    Attributes
    ----------
    lmks : list of Lmk
    keys : list of int
        Under which each stands in its dict.
    ranges : list of slice or None
        Range of each in the map.
    places : list of int
        Where each stands among the landmarks of all types.
    kinds : list of LmkType
        Type of each: equal, but not always the same object.
    """

    def __init__(self, kind, known):
        self.kind, self.known = kind, known
        self.lmks, self.keys, self.ranges, self.places, self.kinds = [], [], [], [], []
        self._indices = np.zeros((8, kind.size), int)

    def add(self, key, lmk, place):
        """One more."""
        n = len(self.lmks)
        if n == len(self._indices):
            self._indices = np.concatenate([self._indices, np.zeros_like(self._indices)])  # a view of the old stays
        if not self.known:
            self._indices[n] = indices_of(lmk.r)  # if the length is wrong, nothing has been added
        self.lmks.append(lmk)
        self.keys.append(key)
        self.ranges.append(lmk.r)
        self.places.append(place)
        self.kinds.append(lmk.type)

    @property
    def indices(self):
        """Indices of them in the map, shape (K, k); None if they are known."""
        return None if self.known else self._indices[: len(self.lmks)]


class Groups:
    """Landmarks by type. New ones are added; if anything else is not as it was, all is done anew.

    Attributes
    ----------
    all : list of Group
    lmks : list of Lmk
        All of them, in the order in which they came.
    started : list of [Lmk or None, int]
        The landmark that was started last and how many there were then, if their slots were 0, 1, 2, ... without a gap.
    """

    def __init__(self):
        self._changes = 0
        self.forget()

    def follow(self, lmks, changes):
        """Take these landmarks: most often those of the last time, and some behind them.

        Parameters
        ----------
        lmks : dict of int to Lmk
        changes : int
            Of the map. After more of them than the last time, all landmarks are looked at.
        """
        n = len(self.lmks)
        new = list(islice(reversed(lmks.items()), max(len(lmks) - n, 0) + 1))  # and before them the last that is noted
        if changes != self._changes or not self._begins(lmks, n, new[-1:]):
            self._changes, new = changes, list(reversed(lmks.items()))
            self.forget()
        elif n:
            new.pop()
        try:
            for key, lmk in reversed(new):
                self._of(lmk.type, lmk.r is None).add(key, lmk, len(self.lmks))
                self.lmks.append(lmk)
        except BaseException:
            self.forget()  # half of them would be wrong
            raise

    def _begins(self, lmks, n, last):
        """Return True if a dict begins with the n landmarks that are noted: the last one of them is where it was."""
        if self._known or len(lmks) < n:
            return self.lmks == list(islice(lmks.values(), n))
        return n == 0 or last[0][1] is self.lmks[-1]

    def forget(self):
        """Begin anew: a landmark is not what it was."""
        self.all, self.lmks, self.started, self._known = [], [], [None, 0], False

    def _of(self, kind, known):
        """Return the group for a landmark of this type."""
        for group in self.all:
            if group.known == known and (group.kind is kind or group.kind == kind):
                return group
        self.all.append(Group(kind, known))
        self._known = self._known or known
        return self.all[-1]
