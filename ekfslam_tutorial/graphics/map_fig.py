"""MapFig: the world, the robots, the sensors and the estimated map in one figure (manual, figs. 14 and 15).

All artists are made once. `update` only gives them new points, so a film or a live view draws at its full speed.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import matplotlib.pyplot as plt
import numpy as np

from .artists import HALO, Labels, draw_legend, new_faces, new_line, put, put_path
from .bodies import ground_grid, move_faces, nice_step, outline, robot_body, sensor_body
from .clip import clip_curves, inside
from .ellipses import ellipse_points, ellipsoid_wires, sigma_label
from .states import TruthInMap, is_line, lmk_lines, lmk_points, lmk_states
from .style import BLACK, ESTIMATE, LIGHT_GREY, REJECTED, ROBOTS, TRUTH, UPDATED, line, points
from .views import View, fit_limits

Array = np.ndarray
RING = ROBOTS[2]
UPDATES = ("updated", "rejected")


@dataclass
class BodyArtists:
    """One robot or sensor: its outline, its faces (estimate only) and, for a robot, its path so far."""

    outline: Any
    faces: Any = None
    path: Any = None
    past: dict[int, Array] = field(default_factory=dict)  # frame number -> position


@dataclass
class LmkArtists:
    """The estimated landmarks: one line of all means, one line of ellipses for each state, a label each.

    Of landmarks that are lines, one artist has all the stretches between their ends, which have ellipsoids.
    """

    mean: Any
    stretch: Any
    ellipse: dict[str, Any]
    label: Labels


class MapFig:
    """The map figure.

    Parameters
    ----------
    snapshot : Snapshot
        The first frame. Its robots say whether the world is flat or in space.
    k : float
        Ellipses are drawn at k sigma.
    view : str, optional
        ``perspective``, ``top``, ``side`` or ``self``; see `set_view`.
    limits : (d, 2), optional
        Lower and upper limit of each axis, metres. By default they follow the contents and only ever grow.
    labels : bool
        Write each landmark's id beside it.
    size : float, optional
        Half the length of a robot's body, metres; by default 1/30 of the world.
    title : str
        What the title says before the time.
    align : bool, optional
        Show the truth in the frame of the map, laid on the first pose of the first robot whose truth is known. By
        default so with a recording: its truth has an origin of its own, the map begins where the robot begins.
    legend : bool
        Write the legend under the map. Its entries are in the attribute `legend` in any case.
    figsize : (width, height)
        Inches.

    Attributes
    ----------
    fig, axes, ground
        Figure, axes, and the line that draws the floor.
    sim_rob, sim_sen, est_rob, est_sen : dict
        Artists of each true and estimated robot and sensor, by id.
    sim_lmk
        Line of the true landmarks.
    ring : dict
        Lines of the hypotheses of beacons that are not decided yet: "likely" and "possible".
    est_lmk : LmkArtists
        ``est_lmk.mean``, ``est_lmk.ellipse`` (by state), ``est_lmk.label``.
    """

    def __init__(
        self,
        snapshot,
        k=3,
        view=None,
        limits=None,
        labels=True,
        size=None,
        title="",
        align=None,
        legend=True,
        figsize=(9, 7.2),
    ):
        self.dim, self.k, self.title, self.labels = snapshot.robs[0].motion.frame.dim, k, title, labels
        self._nowhere = np.full(self.dim, np.nan)
        self.fig = plt.figure(figsize=figsize)
        self.view = View(self.fig, self.dim, room=1.2 if legend else 0.0)
        self.axes = self.view.axes
        self._truth = TruthInMap(not snapshot.sim_robs if align is None else align)
        self._fixed = limits is not None
        self.limits = (
            np.array(limits, dtype=float)
            if self._fixed
            else fit_limits(self._contents(snapshot, lmk_points(snapshot, self.dim), self._truth.frames(snapshot)))
        )
        self.size = size or np.ptp(self.limits[:2], axis=1).max() / 30
        self.sens = {sen.id: sen for sen in snapshot.sens}
        self._make(snapshot, figsize)
        self.set_view(view or ("perspective" if self.dim == 3 else "top"))
        self.update(snapshot)
        self.legend = self._legend_entries(snapshot)
        if legend:
            draw_legend(self.fig, self.legend)

    def set_view(self, view: str, sensor=None) -> None:
        """Choose a view; it shows with the next `update`.

        Parameters
        ----------
        view : str
            In space: ``perspective``, ``top``, ``side``, or ``self``, the map as a sensor would see it.
            In the plane: ``top``, the whole map, or ``self``, the map round a sensor.
        sensor : optional
            Id of the sensor for ``self``; by default the first.
        """
        sen = self.sens.get(sensor, None) if sensor is not None else next(iter(self.sens.values()), None)
        if view == "self" and sen is None:
            raise ValueError(f"no sensor {sensor!r} to look from; known ids: {list(self.sens)}")
        self.view.choose(view, sen)

    def orbit(self, angle: float) -> None:
        """Turn the camera round the vertical axis by an angle, radians."""
        self.view.orbit(angle)

    # ------------------------------------------------------------------------------------------- making the artists

    def _make(self, snapshot, figsize) -> None:
        ax = self.axes
        self.heading = self.fig.text(0.5, 0.975, "", ha="center", va="top", fontsize=14 if figsize[0] >= 6 else 12)
        self.ground = new_line(ax, color=LIGHT_GREY, linewidth=0.8, zorder=0)
        self.est_rob: dict[Any, BodyArtists] = {}
        self.est_sen: dict[Any, BodyArtists] = {}
        self.sim_rob: dict[Any, BodyArtists] = {}
        self.sim_sen: dict[Any, BodyArtists] = {}
        wire = dict(linewidth=1.1, zorder=3)
        self.est_lmk = LmkArtists(
            mean=new_line(ax, **points(ESTIMATE, markersize=4.0), zorder=5),
            stretch=new_line(ax, **line(ESTIMATE, linewidth=2.4, zorder=5)),
            ellipse={
                "estimate": new_line(ax, **line(ESTIMATE, **wire)),
                "updated": new_line(ax, **line(UPDATED, linewidth=1.8, zorder=4)),
                "rejected": new_line(ax, **line(REJECTED, linewidth=2.0, zorder=4)),
            },
            label=Labels(ax, size=11, color=BLACK, zorder=8),
        )
        self.ring = {
            "possible": new_line(ax, color=RING, linewidth=0.7, alpha=0.45, zorder=2),
            "likely": new_line(ax, color=RING, linewidth=1.6, zorder=3),
        }
        colors = {rob.id: ROBOTS[i % len(ROBOTS)] for i, rob in enumerate(snapshot.robs)}
        self.rob_ellipse = {id: new_line(ax, **line(ESTIMATE, color=color, **wire)) for id, color in colors.items()}
        self.rob_label = Labels(ax, size=12, shift=(16.0, 13.0), color=list(colors.values()), zorder=9, **HALO)
        self.sim_lmk = new_line(ax, **points(TRUTH, markersize=9.0, markeredgewidth=1.0), zorder=4)
        self.sim_line = new_line(ax, **line(TRUTH, linewidth=1.0, zorder=4))
        for rob in snapshot.robs:
            self.est_rob[rob.id] = self._body(ESTIMATE, path=True, color=colors[rob.id])
        for sen in snapshot.sens:
            self.est_sen[sen.id] = self._body(ESTIMATE, color=colors[sen.robot])
        for rob in snapshot.truth:
            self.sim_rob[rob] = self._body(TRUTH, path=True)
        for sen in snapshot.sim_sens:
            self.sim_sen[sen.id] = self._body(TRUTH)

    def _body(self, style, path=False, color=None) -> BodyArtists:
        ax, estimate = self.axes, style is ESTIMATE
        color = color or style["color"]
        edge = dict(color=color, linewidth=1.0 if estimate else 0.7, zorder=6 if estimate else 7)
        return BodyArtists(
            outline=new_line(ax, **edge),
            faces=new_faces(ax, facecolor=color, alpha=0.6, linewidth=0, zorder=6) if estimate else None,
            path=new_line(ax, **line(style, color=color, linewidth=1.8, zorder=5 if estimate else 6)) if path else None,
        )

    def _legend_entries(self, snapshot) -> dict[str, Any]:
        several = len(self.est_rob) > 1
        said = [rob.name or f"robot {rob.id}" if several else "estimated path and robot" for rob in snapshot.robs]
        entries = {words: body.path for words, body in zip(said, self.est_rob.values(), strict=True)}
        if self.sim_rob:
            entries["true path and robot"] = next(iter(self.sim_rob.values())).path
        world = snapshot.sim_lmk
        edges, corners = (False, False) if world is None else (len(world.segments) > 0, len(world.points) > 0)
        if corners or not edges:
            entries["estimated landmark, id"] = self.est_lmk.mean
        if corners:
            entries["true landmark"] = self.sim_lmk
        if edges or any(is_line(lmk) for lmk in snapshot.lmks.values()):
            entries["estimated line, id"] = self.est_lmk.stretch
        if edges:
            entries["true edge"] = self.sim_line
        entries[sigma_label(self.k, self.dim)] = self.est_lmk.ellipse["estimate"]
        if getattr(snapshot, "rings", {}):
            entries["hypotheses of a beacon, 1 sigma"] = self.ring["likely"]
        entries["... updated in this frame"] = self.est_lmk.ellipse["updated"]
        entries["... rejected in this frame"] = self.est_lmk.ellipse["rejected"]
        return entries

    # ------------------------------------------------------------------------------------------------ every frame

    def follow(self, snapshot) -> None:
        """Take note of a frame that is not shown: how far the world reaches, and where the robots are."""
        self._note(snapshot)

    def update(self, snapshot) -> None:
        """Show another frame in the same artists. The caller decides when to draw the canvas."""
        lmks, robs, true = self._note(snapshot)
        sens = {sen.id: robs[sen.robot].compose(sen.frame(snapshot.map))[0] for sen in snapshot.sens}
        region = self.view.show(self.limits, sens)
        self._update_truth(snapshot, true, region)
        for id, frame in robs.items():
            self._place(self.est_rob[id], self._robot(id), frame, region)
        for id, frame in sens.items():
            self._place(self.est_sen[id], self._sensor(id), frame, region)
        self._update_robot_ellipses(snapshot, region)
        self._update_lmks(snapshot, lmks, region)
        self._update_rings(snapshot, region)
        put(self.ground, np.concatenate([clip_curves(self._ground(), region), self.view.border]))
        n = len(snapshot.lmks)
        self.heading.set_text(
            f"{self.title + ': ' if self.title else ''}frame {snapshot.k}, t = {snapshot.t:.1f} s, "
            f"{n} landmark{'s' * (n != 1)}"
        )

    def _note(self, snapshot) -> tuple:
        """Lengthen the paths and widen the limits; return the landmarks, and the frames of robots and true robots."""
        lmks, true = lmk_points(snapshot, self.dim), self._truth.frames(snapshot)
        robs = {rob.id: rob.frame(snapshot.map) for rob in snapshot.robs}
        if not self._fixed:
            self.limits = fit_limits(self._contents(snapshot, lmks, true), self.limits)
        for bodies, frames in ((self.sim_rob, true), (self.est_rob, robs)):
            for id, body in bodies.items():
                self._went(body, frames.get(id), snapshot.k)
        return lmks, robs, true

    def _went(self, body: BodyArtists, frame, k) -> None:
        """Note where a robot is in frame k."""
        if body.past and k <= next(reversed(body.past)):  # gone back, or drawn twice
            body.past = {j: p for j, p in body.past.items() if j < k}
        body.past[k] = self._nowhere if frame is None else np.array(frame.t)  # a copy: the map lives on

    def _update_truth(self, snapshot, frames, region) -> None:
        for id, body in self.sim_rob.items():
            self._place(body, self._robot(id), frames.get(id), region)
        for sen in snapshot.sim_sens:
            frame = frames[sen.robot].compose(sen.frame)[0]
            self._place(self.sim_sen[sen.id], self._sensor(sen.id), frame, region)
        put(self.sim_lmk, _keep(self._truth.points(snapshot, self.dim), region))
        if self.dim == 3:
            put(self.sim_line, clip_curves(self._truth.segments(snapshot), region))

    def _robot(self, id):
        return robot_body(self.dim, 0 if self._carries_the_eye(id) else self.size)

    def _sensor(self, id):
        return sensor_body(self.dim, 0 if self._carries_the_eye(self.sens[id].robot) else 0.9 * self.size)

    def _carries_the_eye(self, rob) -> bool:
        """Return True if the view is from this robot in space: its own body would only stand in the picture."""
        return self.dim == 3 and self.view.name == "self" and self.view.sensor.robot == rob

    def _place(self, body: BodyArtists, faces, frame, region) -> None:
        """Move a body to its frame, if that is known, and show its path if it has one."""
        faces = [] if frame is None else move_faces(faces, frame)
        put(body.outline, clip_curves(outline(faces), region) if faces else np.zeros((0, self.dim)))
        if body.faces is not None:
            body.faces.set_visible(bool(inside(np.concatenate(faces), region).all()))
            body.faces.set_verts(faces)
        if body.path is not None:
            put_path(body.path, np.array(list(body.past.values())), region)

    def _update_robot_ellipses(self, snapshot, region) -> None:
        d, names, where = self.dim, {}, {}
        uncertain = [rob for rob in snapshot.robs if rob.r is not None]
        for rob in uncertain:
            mean, cov = rob.frame(snapshot.map).t, snapshot.map.P[rob.r, rob.r][:d, :d]
            put(self.rob_ellipse[rob.id], clip_curves(self._ellipses(mean[None], cov[None]), region))
        if len(snapshot.robs) > 1:  # one robot needs no name
            for rob in snapshot.robs:
                names[rob.id] = rob.name or f"robot {rob.id}"
                where[rob.id] = _keep(rob.frame(snapshot.map).t[None], region)[0]
        self.rob_label.put(where, names)

    def _update_lmks(self, snapshot, lmks, region) -> None:
        ids, mean, cov = lmks
        states = lmk_states(snapshot)
        curves = self._ellipses(mean, cov)
        mean = _keep(mean, region)
        put(self.est_lmk.mean, mean)
        drawn_as = np.array([states[id] if states.get(id) in self.est_lmk.ellipse else "estimate" for id in ids])
        for state, artist in self.est_lmk.ellipse.items():
            put(artist, clip_curves(curves[drawn_as == state], region))
        where = dict(zip(ids, mean, strict=True))
        if self.dim == 3:
            where |= self._update_lines(snapshot, states, region)
        if self.labels:
            self.est_lmk.label.put(where)

    def _update_lines(self, snapshot, states, region) -> dict:
        """Show lines between their ends, and how uncertain these are; return where the labels belong."""
        ids, ends, cov = lmk_lines(snapshot)
        put(self.est_lmk.stretch, clip_curves(ends, region))
        drawn_as = np.repeat([states.get(id, "estimate") for id in ids], 2)
        curves = self._ellipses(ends.reshape(-1, 3), cov.reshape(-1, 3, 3)) if ids else np.zeros((0, 1, 3))
        each = len(curves) // max(len(drawn_as), 1)
        for state, artist in self.est_lmk.ellipse.items():
            as_this = np.repeat(drawn_as == state if state != "estimate" else ~np.isin(drawn_as, UPDATES), each)
            rows = clip_curves(curves[as_this], region) if as_this.any() else np.zeros((0, 3))
            put(artist, np.concatenate([np.reshape(artist.get_data_3d(), (3, -1)).T, rows]))
        return dict(zip(ids, _keep(ends.mean(1), region), strict=True))

    def _update_rings(self, snapshot, region) -> None:
        """Show the hypotheses of beacons at 1 sigma; those with half the weight of the heaviest are likely."""
        curves = {"possible": [], "likely": []}
        for ring in getattr(snapshot, "rings", {}).values():
            p, P = ring.points(snapshot.map)
            shape = (ellipse_points if self.dim == 2 else ellipsoid_wires)(p, P, 1)
            likely = np.repeat(ring.w >= ring.w.max() / 2, len(shape) // len(ring.w))
            curves["likely"] += list(shape[likely])
            curves["possible"] += list(shape[~likely])
        for name, rows in curves.items():
            put(self.ring[name], clip_curves(np.array(rows), region) if rows else np.zeros((0, self.dim)))

    def _ellipses(self, mean, cov) -> Array:
        return (ellipse_points if self.dim == 2 else ellipsoid_wires)(mean, cov, self.k)

    def _ground(self) -> Array:
        limits = self.view.shown
        height = np.clip(0.0, *limits[2]) if self.dim == 3 else 0.0
        return ground_grid(limits, nice_step(np.ptp(limits[:2], axis=1).max()), height)

    def _contents(self, snapshot, lmks, true) -> Array:
        """Points that the limits must hold: robots, true landmarks, estimates that know where they are."""
        d = self.dim
        robs = [rob.frame(snapshot.map).t for rob in snapshot.robs]
        _, mean, cov = lmks
        world = np.concatenate([np.array(robs), *(f.t[None] for f in true.values())])
        edges = self._truth.segments(snapshot).reshape(-1, 3) if d == 3 else np.zeros((0, d))
        world = np.concatenate([world, self._truth.points(snapshot, d), edges])
        spread = self.k * np.sqrt(np.trace(cov, axis1=1, axis2=2))
        near = np.linalg.norm(mean - world[0], axis=1)
        return np.concatenate([world, mean[spread < 0.5 * near]])


def _keep(p: Array, region) -> Array:
    """Return the points, those outside the region as NaN."""
    return np.where(inside(p, region)[:, None], p, np.nan)
