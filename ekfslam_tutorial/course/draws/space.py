"""A light 3D scene on flat axes, for drawings that are redrawn often: frames, bodies, paths, ellipsoids.

Orthographic, so that equal lengths stay comparable; ten times as quick as 3D axes.
"""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from ...graphics import ellipsoid_wires, nan_separated
from ...graphics.bodies import ground_grid, move_faces, outline, robot_body
from ...graphics.style import BLUE, GREEN, LIGHT_GREY, VERMILLION

AXES = ((VERMILLION, "x"), (GREEN, "y"), (BLUE, "z"))


class Space:
    """Axes that show space from a direction.

    Parameters
    ----------
    ax : Axes
    limits : sequence of two pairs
        What the picture shows, metres to the right and upwards.
    azim, elev : float
        Where the eye stands, degrees: round the vertical from the x axis, and above the ground.
    title : str
    """

    def __init__(self, ax: Axes, limits, azim=-60.0, elev=25.0, title=""):
        a, e = np.radians([azim, elev])
        right = np.array([-np.sin(a), np.cos(a), 0.0])
        eye = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
        self.ax, self.view = ax, np.array([right, np.cross(eye, right)])
        ax.set(xlim=limits[0], ylim=limits[1], aspect="equal")
        ax.set_title(title, loc="left")
        ax.set_axis_off()

    def xy(self, p):
        """Where points (..., 3) are in the picture, (..., 2)."""
        return np.asarray(p, float) @ self.view.T

    def line(self, p, **style):
        """Draw points (n, 3) as a line, or as markers if the style says so."""
        return self.ax.plot(*self.xy(np.atleast_2d(p)).T, **style)[0]

    def curves(self, p, **style):
        """Draw many curves (..., n, 3) as one line."""
        return self.line(nan_separated(p), **style)

    def ellipsoid(self, mean, cov, k=3, **style):
        """Draw k-sigma ellipsoids, three great circles each."""
        return self.curves(ellipsoid_wires(mean, cov, k, 25), **style)

    def ground(self, half, step=1.0, height=0.0):
        """Draw the floor as a grid around the origin."""
        grid = ground_grid(np.array([[-half, half]] * 3), step, height)
        self.curves(grid, color=LIGHT_GREY, linewidth=0.8, zorder=0)

    def text(self, p, words, **style):
        """Write at a point in space."""
        look = {"xytext": (4, 4), "fontsize": 13, **style}
        u, v = self.xy(p)
        self.ax.annotate(words, (u, v), textcoords="offset points", **look)

    def gizmo(self, frame, size=1.0, name="", **style):
        """Draw the three axes of a frame with their letters."""
        for i, (color, letter) in enumerate(AXES):
            tip = frame.t + size * frame.R[:, i]
            self.line([frame.t, tip], **{"color": color, "linewidth": 2.6, "zorder": 5, **style})
            u, v = self.xy(frame.t + 1.16 * size * frame.R[:, i])
            self.ax.text(u, v, letter, color=style.get("color", color), fontsize=13, ha="center", va="center", zorder=6)
        if name:
            self.name(frame, name)

    def name(self, frame, words, size=14, avoid=(), **style):
        """Write beside the origin of a frame, where none of its axes is, nor a line to one of the points `avoid`."""
        lines = self.xy(np.array([*frame.R.T, *(p - frame.t for p in avoid)]))
        lines = lines[np.linalg.norm(lines, axis=1) > 0.15]  # an axis that comes out of the picture takes no room
        lines = lines / np.linalg.norm(lines, axis=1)[:, None]
        a = np.radians(np.arange(210, 570, 15))  # of several as good as each other, the one most to the lower left
        ways = np.column_stack([np.cos(a), np.sin(a)])
        way = ways[np.argmin(np.max(ways @ lines.T, axis=1, initial=-1.0).round(2))]
        room = (6 + 0.3 * size * len(words), 6 + 0.6 * size) * way
        self.text(frame.t, words, xytext=room, ha="center", va="center", fontsize=size, **style)

    def robot(self, frame, size=0.3, **style):
        """Draw a robot's body as its edges."""
        look = {"color": BLUE, "linewidth": 1.2, "zorder": 6, **style}
        self.line(outline(move_faces(robot_body(3, size), frame)), **look)
