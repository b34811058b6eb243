"""The few things MapFig and SenFig do with matplotlib artists: make them empty, fill them, in 2D and 3D alike."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from matplotlib.collections import PathCollection, PolyCollection
from matplotlib.patheffects import withStroke
from matplotlib.textpath import TextPath
from matplotlib.transforms import Affine2D
from mpl_toolkits.mplot3d import proj3d
from mpl_toolkits.mplot3d.art3d import Poly3DCollection
from mpl_toolkits.mplot3d.axes3d import Axes3D

from .clip import Region, clip_curves, inside
from .ellipses import nan_separated

Array = np.ndarray
MARK = 3.0
"""Half the width of a mark beside which a text stands, points."""
HALO: dict[str, Any] = {"path_effects": [withStroke(linewidth=3, foreground="white")]}
"""A text over paths and marks can be read."""


def dim_of(ax) -> int:
    """Return 3 for 3D axes, else 2."""
    return 3 if isinstance(ax, Axes3D) else 2


def new_line(ax, **style: Any):
    """Return an empty line, whose rows come later by `put`."""
    return ax.plot(*[[]] * dim_of(ax), **style)[0]


def put(line, rows: Array) -> None:
    """Give a line new points, rows (m, d)."""
    rows = np.asarray(rows, dtype=float)
    if hasattr(line, "set_data_3d"):
        line.set_data_3d(*rows.T)
    else:
        line.set_data(*rows.T)


def put_path(line, p: Array, region: Region | None = None) -> None:
    """Give a line the points p (n, d) of a path, as far as they lie in a region.

    A point that is not finite is a gap. A point between two gaps has no line: it is drawn as a dot. (The true poses
    of some logs were measured by hand, a few in an hour.)
    """
    p = np.asarray(p, dtype=float)
    known = np.asarray(np.isfinite(p).all(axis=1))
    before, after = np.append(False, known[:-1]), np.append(known[1:], False)
    lonely = p[known & ~before & ~after & (len(p) > 1)]
    rows = nan_separated(p[None]) if region is None else clip_curves(p[None], region)
    if region is not None:
        lonely = lonely[inside(lonely, region)]
    n = len(rows)
    put(line, np.concatenate([rows, nan_separated(lonely[:, None])]))
    line.set(marker="." if len(lonely) else "None", markersize=7, markevery=list(range(n, n + 2 * len(lonely), 2)))


def new_faces(ax, **style: Any):
    """Return an empty collection of filled faces, whose corners come later by ``set_verts``."""
    if dim_of(ax) == 3:
        return ax.add_collection(Poly3DCollection([np.zeros((3, 3))], **style), autolim=False)
    return ax.add_collection(PolyCollection([np.zeros((3, 2))], **style), autolim=False)


def draw_legend(fig, entries: dict[str, Any]) -> None:
    """Write a legend along the lower edge of the figure."""
    fig.legend(entries.values(), entries.keys(), loc="lower center", ncols=3, frameon=False, fontsize=12)


class Labels(PathCollection):
    """Many short texts as one artist, in 2D and 3D: 70 of them are drawn in the time of two `Text` objects.

    Parameters
    ----------
    ax : axes
    size : float
        Height of the letters, points.
    shift : (2,)
        Where a text begins, from its point to the right and up, points.
    apart : bool
        In the plane: a text that would hide another one or a point moves round its own point; if there is no room
        anywhere, it is left out. The limits of the axes have to be set before `put`. The first keys choose first.
    marks : (n, 2)
        Points besides those of the texts that no text may hide, if they stand apart.
    **style
        As for a matplotlib collection.
    """

    def __init__(self, ax, size: float = 10, shift=(7.0, 5.0), apart: bool = False, marks=(), **style: Any):
        super().__init__([], offsets=np.zeros((0, 2)), offset_transform=ax.transData, linewidth=0, **style)
        self.set_transform(Affine2D().scale(1 / 72) + ax.figure.dpi_scale_trans)
        self.size, self.shift, self.apart = float(size), tuple(shift), apart and dim_of(ax) == 2
        self.marks = np.array(marks, dtype=float)
        self.where: dict[Any, Array] = {}  # point of each text that is shown, by key
        self.names: dict[Any, str] = {}
        ax.add_collection(self, autolim=False)

    def put(self, where: dict[Any, Array], names: dict[Any, str] | None = None) -> None:
        """Show a text at each point, by key; the text is the key unless `names` has it. NaN hides a text."""
        self.where = {key: np.asarray(p, dtype=float) for key, p in where.items() if np.isfinite(p).all()}
        self.names = {key: str(names[key] if names else key) for key in self.where}
        shifts = self._shifts() if self.apart else dict.fromkeys(self.where, self.shift)
        self.where = {key: self.where[key] for key in shifts}
        self.names = {key: self.names[key] for key in shifts}
        self.set_paths([_letters(self.names[key], self.size, shift) for key, shift in shifts.items()])
        if dim_of(self.axes) == 2:
            self.set_offsets(np.array(list(self.where.values())).reshape(-1, 2))
        self.stale = True

    def _shifts(self) -> dict[Any, tuple[float, float]]:
        """Find for each text a place beside its point where it hides nothing; without a key there is none."""
        ax: Any = self.axes
        points = np.array([*self.where.values(), *self.marks]).reshape(-1, 2)
        at = 72 / ax.figure.dpi * ax.transData.transform(points)
        taken = [np.concatenate([at - MARK, at + MARK], axis=1)] if len(at) else []  # boxes: left, below, right, above
        found, (dx, dy) = {}, self.shift
        for key, p in zip(self.where, at, strict=False):
            w, h = _extent(self.names[key], self.size)
            left, below, over = -dx - w, -dy - h, -w / 2
            beside = (dx, dy), (left, dy), (dx, below), (left, below), (over, dy + MARK), (over, below - MARK)
            for shift in beside:
                box = np.concatenate([p + shift, p + shift + (w, h)])
                others = np.concatenate(taken)
                if not ((box[:2] < others[:, 2:]) & (others[:, :2] < box[2:])).all(axis=1).any():
                    taken.append(box[None])
                    found[key] = shift
                    break
        return found

    def do_3d_projection(self) -> float:
        """Move the texts to where 3D axes now show their points; matplotlib calls it before it draws."""
        ax: Any = self.axes
        px, py, pz = np.array(list(self.where.values())).reshape(-1, 3).T
        x, y, z = proj3d.proj_transform(px, py, pz, ax.M)
        self.set_offsets(np.column_stack([x, y]))
        return float(np.min(z, initial=np.inf))


@lru_cache(maxsize=4096)
def _extent(text: str, size: float) -> tuple[float, float]:
    """Width and height of a text, points."""
    width, height = _letters(text, size, (0.0, 0.0)).get_extents().max
    return width, height


@lru_cache(maxsize=4096)
def _letters(text: str, size: float, shift: tuple[float, float]) -> TextPath:
    return TextPath(shift, text, size=size)
