"""One row of a table of sightings, which quacks like an `Obs` of `slam`: made when somebody looks."""

import html

import numpy as np

from .core import short, table_html


def _column(name, doc):
    """Return an attribute of `Obs` that stands in a column of its table."""

    def read(o):
        return getattr(o.table, name)[o.k]

    def write(o, value):
        getattr(o.table, name)[o.k] = value

    return property(read, write, doc=doc)


class Obs:
    """The observation of one landmark by one sensor in this frame: all that `slam.Obs` has.

    Parameters
    ----------
    table : Sightings
    k : int
        Which row.

    Attributes
    ----------
    lmk : int
        Id of the landmark.
    """

    __slots__ = ("k", "lmk", "table")

    def __init__(self, table, k):
        self.table = table
        self.k = k
        self.lmk = table.lmks[k].id

    e = _column("e", "Expectation, shape (m,).")
    E = _column("E", "Covariance of the expectation, shape (m, m).")
    v = _column("v", "Point in the sensor frame, or ray towards it.")
    E_r = _column("E_r", "Jacobian of the expectation by the robot's frame.")
    E_s = _column("E_s", "Jacobian of the expectation by the sensor's frame.")
    y = _column("y", "Measurement, once matched, or None.")
    R = _column("R", "Covariance of the measurement, once matched, or None.")
    z = _column("z", "Innovation, or None.")
    index = _column("index", "Which of this frame's raw measurements it is, or None.")
    measured = _column("measured", "True if a measurement was looked for.")
    matched = _column("matched", "True if one was found.")
    updated = _column("updated", "True if it was used for a correction.")

    @property
    def sen(self):
        """Id of the sensor."""
        return self.table.sen

    @property
    def visible(self):
        """True if the sensor should see it."""
        return bool(self.table.visible[self.k])

    @property
    def E_l(self):
        """Jacobian of the expectation by the landmark."""
        r, lmk, E_l = self.table.r[self.k], self.table.lmks[self.k], self.table.E_l[self.k]
        return E_l[:, : len(lmk.x) if r is None else r.stop - r.start]

    @property
    def blocks(self):
        """(rob.r, E_r), (sen.r, E_s), (lmk.r, E_l): Jacobians of the expectation and the states they belong to."""
        r, s, _ = self.table.ranges
        return (r, self.E_r), (s, self.E_s), (self.table.r[self.k], self.E_l)

    @blocks.setter
    def blocks(self, blocks):
        """Jacobians by the same states, computed anew."""
        (_, self.E_r), (_, self.E_s), (_, self.E_l[:]) = blocks

    @property
    def Z(self):
        """Covariance of the innovation, E + R; None without a measurement."""
        return None if self.R is None else self.E + self.R

    @property
    def md2(self):
        """Squared Mahalanobis distance of the innovation; None without a measurement."""
        return None if self.z is None else float(self.z @ np.linalg.solve(self.E + self.R, self.z))

    def __repr__(self):
        fate = "used" if self.updated else "refused" if self.matched else "not seen" if self.visible else "out of view"
        return f"Obs(landmark {self.lmk} by sensor {self.sen}, expected {short(self.e)}, {fate})"

    def _repr_html_(self):
        rows = [(name, short(getattr(self, name))) for name in ("e", "E", "y", "R", "z", "Z", "md2")]
        return f"<b>{html.escape(repr(self))}</b>{table_html(('attribute', 'value'), rows)}"
