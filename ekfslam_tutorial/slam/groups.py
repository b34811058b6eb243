"""What a sensor remembers of landmarks from one frame to the next: of which types they are, and where in the map."""

import numpy as np

from .objects import Lmk


class Group:
    """Landmarks of one type, all in the map or all known: what is needed of them to compute in stacks.

    Parameters
    ----------
    kind : LmkType
    known : bool

    Attributes
    ----------
    members : list of int
        Which landmarks.
    ranges : list of slice or None
        Range of each in the map.
    """

    def __init__(self, kind, known):
        self.kind, self.known, self.members, self.ranges = kind, known, [], []
        self._rows = np.zeros((8, kind.size), int)

    def add(self, i, r):
        """One more."""
        n = len(self.members)
        if n == len(self._rows):
            self._rows = np.concatenate([self._rows, np.zeros_like(self._rows)])  # who has a view of the old keeps it
        if not self.known:
            self._rows[n] = np.arange(r.start, r.stop)  # if the length is wrong, nothing has been added
        self.members.append(i)
        self.ranges.append(r)

    @property
    def rows(self):
        """Where they are in the map, shape (K, k); None if they are known."""
        return None if self.known else self._rows[: len(self.members)]


class Groups:
    """Landmarks by type. It stays true as long as no landmark's type or range is changed; new landmarks are added."""

    def __init__(self):
        self.all, self._lmks, self._changes = [], [], Lmk.changes

    def __reduce__(self):
        """Copies and files begin anew: another process counts other changes."""
        return Groups, ()

    def hold(self, lmks):
        """Whether these landmarks begin with those that are known here already, unchanged."""
        n = len(self._lmks)
        return self._changes == Lmk.changes and (self._lmks == lmks or self._lmks == lmks[:n])

    def grow(self, lmks):
        """Take in the landmarks that have come after those that are known here already."""
        for i in range(len(self._lmks), len(lmks)):
            r = lmks[i].r
            self._of(lmks[i].type, r is None).add(i, r)
            self._lmks.append(lmks[i])

    def _of(self, kind, known):
        """The group for a landmark of this type."""
        for group in self.all:
            if group.known == known and (group.kind is kind or group.kind == kind):
                return group
        self.all.append(Group(kind, known))
        return self.all[-1]


def groups_of(sen, lmks):
    """Groups of these landmarks, of which the sensor remembers most from the last time: a list of `Group`."""
    if sen.groups is None or not sen.groups.hold(lmks):
        sen.groups = Groups()
    sen.groups.grow(lmks)
    return sen.groups.all
