"""Measurement spaces: how the numbers of one sensor become points of a figure.

A space makes its axes, and maps measurements and covariances to axis coordinates. Which space a sensor gets follows
from the units of its measurement: pixels make a picture, an angle makes a polar plot, anything else plain axes. A new
sensor therefore has a figure without a line here.
"""

from __future__ import annotations

import numpy as np
from matplotlib.ticker import MaxNLocator

from ..models.sensors.pin_hole import depixellise, pixellise
from .ellipses import ellipse_points, half_axes
from .style import GREY

Array = np.ndarray


class Picture:
    """Pixels: u to the right, v downwards, the borders of the image drawn."""

    def __init__(self, fig, model):
        w, h = np.asarray(getattr(model, "image_size", (640, 480)), dtype=float)
        m = 0.04 * w
        self.axes = fig.add_axes(room(fig))
        self.axes.set(xlim=(-m, w + m), ylim=(h + m, -m), xlabel="u (px)", ylabel="v (px)", aspect="equal")
        self.axes.plot([0, w, w, 0, 0], [0, 0, h, h, 0], color=GREY, linewidth=1.5, zorder=1)
        self.axes.grid(False)

    def points(self, y: Array, ids: Array) -> Array:
        """Return the pixels; a depth, if there is one, has no place in a picture."""
        return y[:, :2]

    def ellipses(self, e: Array, Z: Array, k: float, ids: Array) -> Array:
        """Return the k-sigma curves (n, points, 2)."""
        return ellipse_points(e[:, :2], Z[:, :2, :2], k)

    def show(self, p: Array) -> None:
        """Make room for points: the picture has its size."""


class Segments(Picture):
    """A picture of segments, whose measurement is both their ends. Expected lines are bent, if the lens bends them."""

    def __init__(self, fig, model):
        super().__init__(fig, model)
        self.model = model

    def points(self, y: Array, ids: Array) -> Array:
        """Return the middles of segments."""
        return y.reshape(-1, 2, 2).mean(1)

    def bent(self, q: Array) -> Array:
        """Return the pixels of curves (n, m, 2) in the ideal image; NaN where the lens does not show them."""
        rays = np.concatenate([depixellise(q, self.model.k)[0], np.ones((*q.shape[:-1], 1))], -1)
        u = self.model.camera.project(rays)[0]
        return np.where(self.model.camera.visible(u, rays)[..., None], u, np.nan)

    def expected(self, obs, k: float) -> tuple[Array, Array]:
        """Return an expected line (m, 2), and the band round it (m, 2) in which its ends are measured, k sigma wide.

        The band is known where there is a measurement. Without one the line goes through the whole image.
        """
        normal, c = obs.e[:2], obs.e[2]
        if obs.y is None or obs.z is None:
            centre = np.array(self.model.image_size) / 2
            foot = centre - (normal @ centre + c) * normal
            way = np.linspace(-2, 2, 161)[:, None] * np.hypot(*self.model.image_size)
            return self.bent(foot + way * np.array([-normal[1], normal[0]])), np.full((1, 2), np.nan)
        foot, std = self.feet(obs), np.sqrt(np.diag(obs.Z))[:, None]
        s = np.linspace(0, 1, 25)[:, None]
        along = lambda ends: ends[0] + s * (ends[1] - ends[0])
        upper, lower = foot + k * std * normal, foot - k * std * normal
        return self.bent(along(foot)), self.bent(np.concatenate([along(upper), along(lower)[::-1], upper[:1]]))

    def feet(self, obs) -> Array:
        """Return the points of an expected line that are nearest to the measured ends, (2, 2), in the ideal image."""
        rays = self.model.retro(obs.y)[0].reshape(2, 3)
        return pixellise(rays[:, :2], self.model.k)[0] - obs.z[:, None] * obs.e[:2]


class Polar:
    """Range and bearing, or bearing alone: the sensor in the middle, looking upwards, bearings to the left."""

    def __init__(self, fig, model):
        self.axes = fig.add_axes(room(fig, 0.35), projection="polar")
        self.axes.set_theta_zero_location("N")
        self.angle = list(model.units).index("rad")
        self.has_range = len(model.units) > 1
        half = getattr(model, "fov", 2 * np.pi) / 2
        if half < 0.75 * np.pi:
            self.axes.set(thetamin=-np.degrees(half), thetamax=np.degrees(half))
        else:
            signed = lambda angle, _: f"{np.degrees(angle) - 360 * (angle > np.pi + 1e-9):.0f}°"
            self.axes.set_xticks(np.radians(np.arange(0, 360, 45)))
            self.axes.xaxis.set_major_formatter(signed)
        self.reach = getattr(model, "max_range", np.inf) if self.has_range else 1.05
        self.fixed = bool(np.isfinite(self.reach))
        self.axes.set_ylim(0, 1.1 * self.reach if self.fixed else 1.0)
        self.axes.set_rlabel_position(202.5 if half >= 0.75 * np.pi else np.degrees(half))
        if self.has_range:
            self.axes.yaxis.set_major_locator(MaxNLocator(4))
            self.axes.yaxis.set_major_formatter(lambda r, _: f"{r:g} m" if r > 0 else "")
            self.axes.tick_params(axis="y", labelcolor=GREY)
        else:
            self.axes.set_yticks([])

    def points(self, y: Array, ids: Array) -> Array:
        """Return (bearing, range); a bearing without range is at 1."""
        r = y[:, 1 - self.angle] if self.has_range else np.ones(len(y))
        return np.stack([y[:, self.angle], r], axis=-1)

    def ellipses(self, e: Array, Z: Array, k: float, ids: Array) -> Array:
        """Return the k-sigma curves: ellipses in bearing and range, or sectors of +- k sigma."""
        if self.has_range:
            order = [self.angle, 1 - self.angle]
            return ellipse_points(e[:, order], Z[:, order][:, :, order], k)
        a = e + k * half_axes(Z)[:, :, 0] * np.linspace(-1, 1, 21)
        arc = np.stack([a, np.ones_like(a)], axis=-1)
        return np.concatenate([arc[:, :1] * [1, 0], arc, arc[:, -1:] * [1, 0]], axis=1)

    def show(self, p: Array) -> None:
        """Make room for points, if the sensor has no greatest range."""
        reach = np.nanmax(p[:, 1], initial=0.0)
        if not self.fixed and reach > self.axes.get_ylim()[1]:
            self.axes.set_ylim(0, 1.15 * reach)


class Plain:
    """Any other measurement: its first two numbers, or one number over the landmark's id."""

    def __init__(self, fig, model):
        units = list(getattr(model, "units", ()))
        self.axes = fig.add_axes(room(fig))
        names = [f"y{i} ({unit})" for i, unit in enumerate(units)] or ["y0", "y1"]
        self.flat = len(np.asarray(model.R)) == 1
        if self.flat:
            self.axes.set(xlabel=f"measurement{f' ({units[0]})' if units else ''}", ylabel="landmark id")
            self.axes.yaxis.set_major_locator(MaxNLocator(integer=True))
        else:
            self.axes.set(xlabel=names[0], ylabel=names[1])
        self.low, self.high = np.full(2, np.inf), np.full(2, -np.inf)

    def points(self, y: Array, ids: Array) -> Array:
        """Return the first two numbers, or (number, id)."""
        return np.stack([y[:, 0], ids], axis=-1) if self.flat else y[:, :2]

    def ellipses(self, e: Array, Z: Array, k: float, ids: Array) -> Array:
        """Return the k-sigma ellipses, or intervals."""
        if not self.flat:
            return ellipse_points(e[:, :2], Z[:, :2, :2], k)
        width = k * half_axes(Z)[:, :, 0] * np.array([-1.0, 1.0])
        return np.stack([e + width, np.broadcast_to(ids[:, None], width.shape)], axis=-1)

    def show(self, p: Array) -> None:
        """Make room for points; the axes only grow."""
        p = p[np.isfinite(p).all(axis=-1)]
        low, high = (
            np.minimum(self.low, p.min(axis=0, initial=np.inf)),
            np.maximum(self.high, p.max(axis=0, initial=-np.inf)),
        )
        if (low < self.low).any() or (high > self.high).any():
            self.low, self.high = low, high
            margin = 0.2 * np.maximum(high - low, 1e-3)
            self.axes.set(
                xlim=(low[0] - margin[0], high[0] + margin[0]), ylim=(low[1] - margin[1], high[1] + margin[1])
            )


def room(fig, margin: float = 0.0) -> tuple[float, float, float, float]:
    """Return where the axes may be: between the heading and the legend, with room for the axes' own words."""
    w, h = fig.get_size_inches()
    left, bottom, right, top = 0.8, 1.6 + margin, 0.3, 0.5 + margin
    return left / w, bottom / h, 1 - (left + right) / w, 1 - (bottom + top) / h


def measurement_space(fig, model):
    """Return the space for a sensor model, by the units of its measurement."""
    units = tuple(getattr(model, "units", ()))
    if hasattr(model, "segments"):
        return Segments(fig, model)
    if units[:2] == ("px", "px"):
        return Picture(fig, model)
    polar = units[:2] in (("rad",), ("m", "rad"), ("rad", "m")) and "rad" not in units[2:]
    return Polar(fig, model) if polar else Plain(fig, model)
