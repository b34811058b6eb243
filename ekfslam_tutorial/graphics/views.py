"""From where a map figure is seen: the axes, their cameras, and limits that follow the contents."""

from __future__ import annotations

from typing import Any

import numpy as np
from mpl_toolkits.mplot3d.axes3d import Axes3D

from .bodies import nice_step, ticks
from .clip import Region, box, pyramid

Array = np.ndarray

# Camera directions: elevation and azimuth, radians. The eye looks at the middle of the world.
ANGLES = {"perspective": (0.5, -1.05), "top": (np.pi / 2, -np.pi / 2), "side": (0.0, -np.pi / 2)}


class WorldAxes(Axes3D):
    """3D axes whose camera may be put anywhere, not only on a sphere round the world."""

    camera: Array | None = None  # (4, 4) from the world to the picture, or None for matplotlib's own

    def get_proj(self):
        """Return the projection matrix that draws this figure."""
        return super().get_proj() if self.camera is None else self.camera


class View:
    """The axes of a map figure and the camera in use.

    Parameters
    ----------
    fig : matplotlib Figure
    dim : int
        2 gives plain axes with equal scales, 3 gives 3D axes.
    room : float
        What to leave free under the axes for a legend, inches.
    """

    def __init__(self, fig, dim: int, room: float = 1.2):
        self.dim, self.name, self.shown = dim, "top", np.zeros((dim, 2))
        self.sensor: Any = None
        self.axes: Any
        self.names = (*ANGLES, "self") if dim == 3 else ("top", "self")
        if dim == 3:
            # 3D axes are a square; this one is as large as the figure, so that nothing is cut at its sides
            w, h = fig.get_size_inches()
            side, middle = max(w, h), (room + h - 0.4) / 2
            rect = (0.465 - side / w / 2, (middle - side / 2) / h, side / w, side / h)
            self.axes = WorldAxes(fig, rect=rect, computed_zorder=False)
            fig.add_axes(self.axes)
            for axis in (self.axes.xaxis, self.axes.yaxis, self.axes.zaxis):
                axis.set_pane_color((1, 1, 1, 0))
        else:
            w, h = fig.get_size_inches()
            self.axes = fig.add_axes((0.85 / w, (room + 0.65) / h, 1 - 1.1 / w, 1 - (room + 1.1) / h))
            self.axes.set_aspect("equal")
        self.axes.set(xlabel="x (m)", ylabel="y (m)")
        self.axes.grid(False)

    def choose(self, name: str, sen=None) -> None:
        """Take a view by its name; ``self`` looks out of the sensor `sen`."""
        if name not in self.names:
            raise ValueError(f"a {self.dim}D map figure has the views {', '.join(self.names)}; got {name!r}")
        self.name, self.sensor = name, sen
        if self.dim == 3:
            self.axes.camera = None
            self.axes.set_proj_type("ortho" if name in ("top", "side") else "persp")
            self.axes.set_axis_off() if name == "self" else self.axes.set_axis_on()
            self.shown = np.zeros((3, 2))  # ticks and zoom depend on the view
            if name in ANGLES:
                elev, azim = np.degrees(ANGLES[name])
                self.axes.view_init(elev=elev, azim=azim)

    def orbit(self, angle: float) -> None:
        """Turn the camera round the vertical axis by an angle, radians."""
        if self.dim == 2 or self.name == "self":
            raise ValueError(f"the camera can orbit in a 3D map figure, not in the {self.dim}D view {self.name!r}")
        self.axes.view_init(elev=self.axes.elev, azim=self.axes.azim + np.degrees(angle))

    def show(self, limits: Array, frames: dict) -> Region:
        """Set axes and camera for the world's limits and the sensors' frames; return the region to draw in.

        `shown` then holds the limits of the part of the world that the axes show, and `border` the frame of the
        picture if the view is that of a camera.
        """
        before, self.shown, self.border = self.shown, limits, np.zeros((0, self.dim))
        if self.name == "self":
            frame = frames[self.sensor.id]
            if self.dim == 3:
                half = half_view(self.sensor.model)
                self.axes.camera = look_from(frame, half)
                self.border = picture_border(frame, half)
                return pyramid(frame, half, near=0.01 * np.ptp(limits, axis=1).max())
            self.shown = frame.t[:, None] + np.ptp(limits, axis=1).max() / 5 * np.array([-1, 1])
        if not np.array_equal(self.shown, before):
            self._set_limits(self.shown)
        return box(self.shown)

    def _set_limits(self, limits: Array) -> None:
        ax = self.axes
        step = nice_step(np.ptp(limits[:2], axis=1).max())
        ax.set(xlim=limits[0], ylim=limits[1], xticks=ticks(limits[0], step), yticks=ticks(limits[1], step))
        if self.dim == 3:
            ax.set(zlim=limits[2], zticks=ticks(limits[2], nice_step(np.ptp(limits[2]), 3)), zlabel="z (m)")
            ax.set(ylabel="y (m)")
            ax.xaxis.labelpad = ax.yaxis.labelpad = 50.0 if self.name == "side" else 10.0
            if self.name == "top":  # an axis seen from its end is a blot
                ax.set(zticks=[], zlabel="")
            if self.name == "side":
                ax.set(yticks=[], ylabel="")
            extent = np.ptp(limits, axis=1)
            ax.set_box_aspect(extent, zoom={"top": 0.8, "side": 1.05}.get(self.name) or 0.88 * low_enough(extent))


def low_enough(extent: Array) -> float:
    """Return the scale, at most 1, at which a box in perspective leaves room for the numbers of its axes below it.

    matplotlib draws each box with a diagonal of the same length, so that one with a great height needs more room.
    """
    elev, azim = ANGLES["perspective"]
    depth = abs(np.sin(azim)) * extent[1] + abs(np.cos(azim)) * extent[0]
    height = (np.cos(elev) * extent[2] + np.sin(elev) * depth) / np.linalg.norm(extent)
    return min(1.0, 0.7 / height)


def picture_half(model) -> Array | None:
    """Return half the width and half the height of a pin-hole camera's picture at distance 1; None for other sensors.

    Its principal point is in the middle of that picture, so the picture is a little larger than the camera's.
    """
    k, size = getattr(model, "k", None), getattr(model, "image_size", None)
    if k is None or size is None or len(k) != 4:
        return None
    centre, focal = np.array(k[:2]), np.array(k[2:])
    return np.maximum(centre, np.array(size) - centre) / focal


def half_view(model) -> Array:
    """Return `picture_half`, or 1 and 3/4 for a sensor that has no picture."""
    half = picture_half(model)
    return np.array([1.0, 0.75]) if half is None else half


def picture_border(frame, half: Array) -> Array:
    """Return the frame of the picture as a closed line (5, 3) in the world."""
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1], [-1, -1]]) * half
    return np.column_stack([corners, np.ones(5)]) @ frame.R.T + frame.t


def look_from(frame, half: Array) -> Array:
    """Return the matrix that draws the world as a camera sees it: x / z to the right, y / z downwards."""
    f = 0.07 / max(half)  # matplotlib's 3D axes show about -0.09 to 0.09 of the projected plane
    lens = np.array([[f, 0, 0, 0], [0, -f, 0, 0], [0, 0, 0, -1], [0, 0, 1, 0]])
    to_camera = np.eye(4)
    to_camera[:3, :3], to_camera[:3, 3] = frame.R.T, -frame.R.T @ frame.t
    return lens @ to_camera


def fit_limits(p: Array, old: Array | None = None, margin: float = 0.08) -> Array:
    """Return limits (d, 2) that hold the finite points p (n, d) with a margin, and never less than the old ones.

    A limit moves when a point comes close to it or passes it, and then far enough to stay for some time.
    """
    p = p[np.isfinite(p).all(axis=-1)]
    if not len(p):
        return np.tile([-1.0, 1.0], (p.shape[1], 1)) if old is None else old
    low, high = p.min(axis=0), p.max(axis=0)
    if old is not None:
        low, high = np.minimum(low, old[:, 0]), np.maximum(high, old[:, 1])
    extent = max((high - low)[:2].max(), 1e-3)
    gap = margin * extent
    if old is None:
        wide = np.maximum(high - low, 0.25 * extent)  # never a sheet without thickness
        middle = (low + high) / 2
        return np.stack([middle - wide / 2 - gap, middle + wide / 2 + gap], axis=1)
    near = 0.3 * gap
    low = np.where(p.min(axis=0) < old[:, 0] + near, p.min(axis=0) - gap, old[:, 0])
    high = np.where(p.max(axis=0) > old[:, 1] - near, p.max(axis=0) + gap, old[:, 1])
    limits = np.stack([np.minimum(low, old[:, 0]), np.maximum(high, old[:, 1])], axis=1)
    return old if np.array_equal(limits, old) else limits
