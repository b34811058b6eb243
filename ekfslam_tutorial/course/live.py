"""Map figure and sensor figure side by side, while a loop runs: live in a notebook, the last picture stored."""

from __future__ import annotations

import contextlib
import io
import time

import matplotlib.pyplot as plt
import numpy as np
from IPython.core.getipython import get_ipython
from PIL import Image

from ..ekf import Map
from ..graphics import MapFig, SenFig, grab, side_by_side
from ..slam import Event, Lmk, move
from ..slam.projection import project_lmks
from ..toolbox import Snapshot
from . import figures
from .trial import LANDMARKS

GATE = 9.0  # squared Mahalanobis distance: what is farther off is drawn as rejected
EVERY = 0.7  # seconds between two pictures of a live run
SHARE = 0.2  # of the time goes into pictures, at most: a slow or busy computer makes fewer of them
SIZE = 9.0, 7.2  # of each figure, inches


class Watch:
    """Shows a run while it goes on. Outside of a notebook it only keeps the last frame.

    Parameters
    ----------
    title : str
    sensor : int, optional
        Whose measurement space is shown; the first sensor if not given.
    """

    def __init__(self, title, sensor=None, every=EVERY):
        self.title, self.sensor, self.every = title, sensor, every
        self.figs, self.handle, self.last = [], None, None
        self.live = get_ipython() is not None
        self.due = time.perf_counter() + every

    def __call__(self, world, before, estimate):
        """Take one frame; draw it if the last picture is old enough. An estimate too wrong to be drawn is left out."""
        if self.live:
            with contextlib.suppress(ValueError, ArithmeticError):
                self.take(as_snapshot(world, before, estimate))

    def take(self, snapshot):
        """Take one frame; draw it if the last picture is old enough."""
        self.last = snapshot
        if (began := time.perf_counter()) <= self.due:
            self.follow(snapshot)
        else:
            self.update(snapshot)
            self.draw(dpi=60)
            ended = time.perf_counter()
            self.due = ended + max(self.every, (ended - began) * (1 - SHARE) / SHARE)

    def draw(self, dpi=None, caption=""):
        """Draw the last frame into the output of the cell, in place of the picture before."""
        picture = _png(self.picture(dpi or figures.DPI), dpi or figures.DPI)
        output = figures.bundle(figures.with_palette(picture), caption or self.title)
        options = {"display_id": self.handle, "update": True} if self.handle else {"display_id": True}
        shown = figures.display(output["data"], metadata=output["metadata"], raw=True, **options)
        self.handle = self.handle or getattr(shown, "display_id", None)

    def finish(self, caption):
        """Draw the last frame as it is to be stored, with its caption, and close the figures."""
        if self.figs:
            with contextlib.suppress(ValueError, ArithmeticError):
                self.update(self.last)
            self.draw(caption=caption)
            figures.display({"text/plain": figures.textwrap.fill(caption, 100)}, raw=True)
        else:
            print(figures.textwrap.fill(caption, 100))
        for fig in self.figs:
            plt.close(fig.fig)

    def follow(self, snapshot):
        """Let the figures take note of a frame that is not drawn; they are made with the first one."""
        if not self.figs:
            self.figs: list[MapFig | SenFig] = [MapFig(snapshot, labels=False, figsize=SIZE)]
            if snapshot.sens:
                self.figs.append(SenFig(snapshot, self.sensor, labels=False, figsize=SIZE))
        for fig in self.figs:
            fig.follow(snapshot)

    def update(self, snapshot):
        """Hand a frame that is to be drawn to the figures."""
        self.follow(snapshot)
        for fig in self.figs:
            fig.update(snapshot)

    def picture(self, dpi):
        """The figures side by side, as one image."""
        for fig in self.figs:
            fig.fig.set_dpi(dpi)
        return side_by_side([grab(fig.fig) for fig in self.figs])


def watch(snapshots, sensor=None, title=""):
    """Pass the snapshots of a run on, and show them meanwhile: map figure and sensor figure, side by side.

    Parameters
    ----------
    snapshots : iterable of Snapshot
        ``universal_slam(data)``, or any other run.
    sensor : int, optional
        Whose measurement space is shown; the first sensor if not given.
    title : str
        Said before the caption that is computed from the last frame.

    Yields
    ------
    Snapshot
    """
    view, now = Watch(title, sensor), None
    for now in snapshots:
        if view.live:
            view.take(now)
        yield now
    if now is not None:
        view.finish(figures.one_line(f"{title} {caption(now, sensor)}"))


def caption(now, sensor=None) -> str:
    """Say in a sentence what map and sensor figure show of a snapshot."""
    sen = next(s for s in now.sens if sensor in (None, s.id))
    sizes = [lmk.type.size for lmk in now.lmks.values()]
    many = ", ".join(f"{sizes.count(n)} with {n} numbers" for n in sorted(set(sizes), reverse=True))
    mine = [o for o in now.obs.values() if o.sen == sen.id]
    used, refused = sum(o.updated for o in mine), sum(o.matched and not o.updated for o in mine)
    off = [np.linalg.norm(rob.frame(now.map).t - now.truth[rob.id][: rob.motion.frame.dim]) for rob in now.robs]
    return (
        f"Frame {now.k}: {len(sizes)} landmarks in the map ({many}). {sen.name or f'Sensor {sen.id}'}: {used} "
        f"measurements used, {refused} refused. {'Robots' if len(off) > 1 else 'The robot'} off by "
        f"{' and '.join(f'{d:.2f}' for d in off)} m."
    )


def _png(image, dpi):
    buffer = io.BytesIO()
    Image.fromarray(image).save(buffer, format="png", dpi=(dpi, dpi))
    return buffer.getvalue()


def as_snapshot(world, before, estimate) -> Snapshot:
    """The estimate of a loop as the figures want it, with what was expected from the estimate of the frame before.

    The expectations are made by the package, from the student's estimate: a pixel outside its ellipse shows that the
    estimate, or its covariance, is wrong.
    """
    now, dim = world._now, world.robs[0].motion.frame.dim
    map, lmks = _map(estimate, dim)
    past, old = _map(before, dim)
    obs = {}
    for rob in world.robs:
        rob.u, rob.U, _ = now.controls[rob.id]
        move(past, rob, now.dt)
        for sen in (s for s in world.sens if s.robot == rob.id):
            raw = now.raw[sen.id]
            index = {int(id): i for i, id in enumerate(raw.ids)}
            for o in project_lmks(past, rob, sen, old.values()) if old else []:
                if o.lmk in index and np.isfinite(o.E).all():
                    o.index, o.measured, o.matched = index[o.lmk], True, True
                    o.y, o.R = np.asarray(raw.y[o.index], float), sen.model.R if raw.R is None else raw.R[o.index]
                    o.z = sen.model.residual(o.y, o.e)
                    o.updated = bool(o.md2 < GATE)
                obs[sen.id, o.lmk] = o
    born = [Event("initialisation", s.robot, s.id, int(i)) for s in world.sens for i in now.raw[s.id].ids
            if int(i) in lmks and int(i) not in old]  # fmt: skip
    source = world._source
    return Snapshot(
        k=world.k, t=now.t, dt=now.dt, map=map, robs=world.robs, sens=world.sens, lmks=lmks, obs=obs, raw=now.raw,
        met=now.met, events=born, refused=set(), truth=now.truth, sim_robs=source.sim_robs, sim_sens=source.sim_sens,
        sim_lmk=source.sim_lmk,
    )  # fmt: skip


def _map(estimate, dim):
    """The package's map and landmarks with the numbers of an estimate."""
    map = Map()
    map.x, map.P, map.ranges = estimate.x.copy(), estimate.P.copy(), [slice(0, len(estimate.x))]
    types = LANDMARKS[dim]
    return map, {id: Lmk(id, types[r.stop - r.start], r=r, slot=i) for i, (id, r) in enumerate(estimate.lmks.items())}
