"""SenFig: the measurement space of one sensor (manual, figs. 16 and 17): what it measures and what was expected.

All artists are made once; `update` only gives them new points.
"""

from __future__ import annotations

from typing import Any

import matplotlib.pyplot as plt
import numpy as np

from .artists import Labels, draw_legend, new_line, put
from .ellipses import nan_separated, sigma_label
from .spaces import measurement_space
from .states import STATES, obs_state
from .style import BLACK, ESTIMATE, GREY, MEASUREMENT, PREDICTED, REJECTED, UPDATED, line, points

Array = np.ndarray

STATE_STYLE = {"updated": UPDATED, "rejected": REJECTED, "predicted": PREDICTED}


class SenFig:
    """The figure of one sensor.

    For each landmark in view: the expected measurement with the k-sigma ellipse of the innovation, Z = E + R, in
    the colour and with the marker of its state, its id, and a line from the expectation to the measurement.

    Parameters
    ----------
    snapshot : Snapshot
        The first frame.
    sensor : optional
        Id of the sensor; by default the first.
    k : float
        Ellipses are drawn at k sigma.
    labels : bool
        Write each landmark's id beside its expectation.
    figsize : (width, height)
        Inches.

    Attributes
    ----------
    fig, axes
    raw
        Line of all measurements of this frame.
    measure
        Line of the measurements that were matched to a landmark.
    expected, ellipse : dict
        Lines of expectations and of their ellipses, by state.
    innovation
        Line of all innovations, from expectation to measurement.
    new
        Line of the measurements that began a landmark in this frame.
    label : Labels
    picture : AxesImage or None
        The image behind it, of a sensor that takes pictures.
    """

    def __init__(self, snapshot, sensor=None, k=3, labels=True, figsize=(9, 7.6)):
        sens = {sen.id: sen for sen in snapshot.sens}
        if sensor is not None and sensor not in sens:
            raise ValueError(f"no sensor {sensor!r}; known ids: {list(sens)}")
        self.sen = sens[sensor] if sensor is not None else snapshot.sens[0]
        self.k, self.labels = k, labels
        self.fig = plt.figure(figsize=figsize)
        self.space: Any = measurement_space(self.fig, self.sen.model)
        self.axes = self.space.axes
        self._make()
        self.update(snapshot)

    def _make(self) -> None:
        ax = self.axes
        self.picture = None  # the image that it was measured in, if there is one
        self.raw = new_line(ax, color=GREY, marker="o", markersize=8, fillstyle="none", linestyle="none", zorder=2)
        self.innovation = new_line(ax, **line(MEASUREMENT, linestyle="-", linewidth=1.4), zorder=4)
        self.expected, self.ellipse = {}, {}
        for state, style in STATE_STYLE.items():
            self.ellipse[state] = new_line(ax, **line(style, linewidth=1.6), zorder=3)
            self.expected[state] = new_line(ax, **points(style, markersize=4.5, markeredgewidth=1.2), zorder=5)
        self.measure = new_line(ax, **points(MEASUREMENT, markersize=8, markeredgewidth=1.3), zorder=6)
        self.new = new_line(ax, **points(ESTIMATE, fillstyle="none", markersize=13, marker="o"), zorder=4)
        self.label = Labels(ax, size=11, apart=True, color=BLACK, zorder=7)
        self.heading = self.fig.text(0.5, 0.975, "", ha="center", va="top", fontsize=14)
        self.of_lines = hasattr(self.sen.model, "segments")
        if self.of_lines:
            for artist in (self.raw, *self.expected.values()):
                artist.set(linestyle="-", linewidth=2.0, marker="None")
            self.raw.set(linewidth=3.5, alpha=0.5)
        entries = {
            "raw measurement": self.raw,
            "matched measurement": self.measure,
            "innovation": self.innovation,
            **{f"expected: {state}": artist for state, artist in self.expected.items()},
            "begins a landmark": self.new,
            self._sigmas(): self.ellipse["updated"],
        }
        draw_legend(self.fig, entries)

    def _sigmas(self) -> str:
        """Words for the curves of the innovation's covariance."""
        if self.of_lines:
            return f"{self.k:g}σ band of Z"
        return f"{sigma_label(self.k, 1 if len(self.sen.model.R) == 1 else 2)} of Z"

    def follow(self, snapshot) -> None:
        """Take note of a frame that is not drawn: the axes may grow with all that it shows."""
        self.update(snapshot)

    def update(self, snapshot) -> None:
        """Show another frame in the same artists. The caller decides when to draw the canvas."""
        seen = [obs for (sen, _), obs in snapshot.obs.items() if sen == self.sen.id and obs_state(obs)]
        raw_ids, raw_y = self._raw(snapshot)
        self._show_image(getattr(snapshot.raw.get(self.sen.id), "image", None))
        new = [ev.lmk for ev in snapshot.events if ev.kind == "initialisation" and ev.sen == self.sen.id]
        is_new = np.isin(raw_ids, new)

        p_raw = self.space.points(raw_y, raw_ids)
        put(self.raw, nan_separated(raw_y.reshape(-1, 2, 2)) if self.of_lines else p_raw)
        put(self.new, p_raw[is_new])
        expected = self._update_lines(seen) if self.of_lines else self._update_expected(seen)
        where = expected | dict(zip(raw_ids[is_new].tolist(), p_raw[is_new], strict=True))
        self.space.show(np.concatenate([p_raw, np.array(list(where.values())).reshape(-1, 2)]))
        if self.labels:
            self.label.put(where)
        count = {state: sum(obs_state(obs) == state for obs in seen) for state in STATES}
        words = [f"{n} {state}" for state, n in count.items() if n] + [f"{len(new)} new"] * bool(new)
        self.heading.set_text(
            f"{self.sen.name or f'sensor {self.sen.id}'}, frame {snapshot.k}: {', '.join(words) or 'nothing'}"
        )

    def _show_image(self, image) -> None:
        """Show a grey image behind all else; a pixel's number is that of its middle."""
        if image is None:
            return
        if self.picture is None:
            rows, columns = image.shape
            around = self.axes.get_xlim(), self.axes.get_ylim()
            extent = (-0.5, columns - 0.5, rows - 0.5, -0.5)
            self.picture = self.axes.imshow(image, "gray", vmin=0, vmax=255, extent=extent, zorder=0, alpha=0.85)
            self.axes.set(xlim=around[0], ylim=around[1])
        self.picture.set_data(image)

    def _raw(self, snapshot) -> tuple[Array, Array]:
        raw = snapshot.raw.get(self.sen.id)
        m = len(self.sen.model.R)
        if raw is None:
            return np.zeros(0, dtype=int), np.zeros((0, m))
        return np.asarray(raw.ids), np.asarray(raw.y, dtype=float).reshape(-1, m)

    def _update_expected(self, seen) -> dict:
        """Draw what was expected, by state; return where each landmark's label belongs."""
        m, where = len(self.sen.model.R), {}
        for state in STATES:
            some = [obs for obs in seen if obs_state(obs) == state]
            ids = np.array([obs.lmk for obs in some], dtype=int)
            e = np.array([obs.e for obs in some], dtype=float).reshape(-1, m)
            Z = np.array([self._Z(obs) for obs in some], dtype=float).reshape(-1, m, m)
            p = self.space.points(e, ids)
            put(self.expected[state], p)
            sure = np.isfinite(Z).all((-1, -2))  # far from every measurement it is not computed
            put(self.ellipse[state], nan_separated(self.space.ellipses(e[sure], Z[sure], self.k, ids[sure])))
            where |= dict(zip(ids.tolist(), p, strict=True))
        matched = [obs for obs in seen if obs.y is not None and obs.matched]
        ids = np.array([obs.lmk for obs in matched], dtype=int)
        y = np.array([obs.y for obs in matched], dtype=float).reshape(-1, m)
        # e + z, not y: in a polar plot a bearing of 179 degrees is a neighbour of -179
        z = np.array([self.sen.model.residual(obs.y, obs.e) for obs in matched], dtype=float).reshape(-1, m)
        put(self.measure, self.space.points(y, ids))
        ends = np.stack([self.space.points(y - z, ids), self.space.points(y, ids)], axis=1)
        put(self.innovation, nan_separated(ends))
        return where

    def _update_lines(self, seen) -> dict:
        """Draw the lines that were expected, by state, with the band in which the ends of a segment may fall."""
        gap, where = np.full((1, 2), np.nan), {}
        for state in STATES:
            some = [obs for obs in seen if obs_state(obs) == state]
            drawn = [self.space.expected(obs, self.k) for obs in some]
            put(self.expected[state], np.concatenate([gap, *(p for line, _ in drawn for p in (line, gap))]))
            put(self.ellipse[state], np.concatenate([gap, *(p for _, band in drawn for p in (band, gap))]))
            for obs, (middle, _) in zip(some, drawn, strict=True):
                inside = middle[np.isfinite(middle).all(-1)]
                where[obs.lmk] = inside[len(inside) // 2] if len(inside) else gap[0]
        matched = [obs for obs in seen if obs.y is not None and obs.z is not None]
        ends = np.array([obs.y for obs in matched], dtype=float).reshape(-1, 2)
        feet = [self.space.bent(self.space.feet(obs)) for obs in matched]
        put(self.measure, ends)
        put(self.innovation, nan_separated(np.stack([np.reshape(feet, (-1, 2)), ends], axis=1)))
        return where

    def _Z(self, obs) -> Array:
        """Covariance of the innovation: where a measurement may fall."""
        return obs.E + (self.sen.model.R if obs.R is None else obs.R)
