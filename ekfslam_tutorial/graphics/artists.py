"""The few things MapFig and SenFig do with matplotlib artists: make them empty, fill them, in 2D and 3D alike."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.collections import PolyCollection
from mpl_toolkits.mplot3d.art3d import Poly3DCollection
from mpl_toolkits.mplot3d.axes3d import Axes3D

Array = np.ndarray


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


def new_faces(ax, **style: Any):
    """Return an empty collection of filled faces, whose corners come later by ``set_verts``."""
    if dim_of(ax) == 3:
        return ax.add_collection3d(Poly3DCollection([np.zeros((3, 3))], **style), autolim=False)
    return ax.add_collection(PolyCollection([np.zeros((3, 2))], **style), autolim=False)


def draw_legend(fig, entries: dict[str, Any]) -> None:
    """Write a legend along the lower edge of the figure."""
    fig.legend(entries.values(), entries.keys(), loc="lower center", ncols=3, frameon=False, fontsize=12)


class Labels:
    """Texts by key, reused from call to call: new keys get a text, keys that have gone lose theirs."""

    def __init__(self, ax, **style: Any):
        self.axes, self.style = ax, style
        self.texts: dict[Any, Any] = {}

    def put(self, where: dict[Any, Array], names: dict[Any, str] | None = None) -> None:
        """Place the text of each key at its point; a point that is not finite hides it."""
        for key in self.texts.keys() - where.keys():
            self.texts.pop(key).remove()
        for key, p in where.items():
            text = self.texts.get(key)
            if text is None:
                text = self.texts[key] = self.axes.text(*np.zeros(len(p)), str(key), **self.style)
            if names is not None and text.get_text() != names[key]:
                text.set_text(names[key])
            visible = bool(np.isfinite(p).all())
            text.set_visible(visible)
            if visible and len(p) == 3:
                text.set_position_3d(p)
            elif visible:
                text.set_position(p)
