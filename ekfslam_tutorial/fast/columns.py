"""What `cross` returns for a compressed map: P H' without the rows of the far states, unless somebody asks for them."""

import numpy as np

from .filter import cross


class Columns:
    """P H' of the active states, as `cross` returns it for a `CompressedMap`. As an array it is that of all states."""

    def __init__(self, map, HP, blocks, spots):
        self._map, self._HP, self._blocks, self._spots, self._layout = map, HP, blocks, spots, map.layout

    @property
    def T(self):
        """H P of the active states; computed again if others are active now."""
        if self._layout != self._map.layout:
            again = cross(self._map, self._blocks)
            self._HP, self._spots, self._layout = again._HP, again._spots, self._map.layout
        return self._HP

    def __getitem__(self, r):
        """The rows of the state in range r."""
        if self._layout == self._map.layout:
            for known, spot in self._spots:
                if known is r:
                    return self._HP.T[spot]
        spot = self._map.spot(r)
        return self.T.T[spot]

    @property
    def shape(self):
        """Shape of P H', for all states."""
        return self._map.n, len(self._HP)

    def __array__(self, dtype=None, copy=None):
        """Return P H' of all states."""
        T = self._map._by_active(np.arange(self._map.n))
        return np.asarray(T @ self.T.T, dtype)
