"""Figures of a run: pictures at its end, a movie, and a live view."""

import shutil
from collections import Counter
from copy import deepcopy
from pathlib import Path
from types import SimpleNamespace

import matplotlib.pyplot as plt
import numpy as np

from ..graphics import (
    MapFig,
    Movie,
    SenFig,
    StateLog,
    check_movie_path,
    cost_panel,
    grab,
    map_picture,
    side_by_side,
    use_style,
    write_player_html,
)
from ..graphics.states import lmk_lines
from .files import replacing, save_figure
from .robot_views import write_robot_figures

FEW = 2
"""The dead reckoning of more robots than this would hide everything else."""


def write_figures(out, history, data, fixes=None, costs=None, richest=None):
    """Write map.png, sensor-N.png and the pictures of each robot; return their names.

    With `fixes`, positions by a satellite receiver by robot id, these are in the maps; with `costs`, the seconds that
    each frame took, there is a cost.png; with `richest`, as `Richest` keeps them, the figure of a sensor shows that
    frame and not the last one.
    """
    use_style(dpi=100)
    fixes = fixes or {}
    align = history.alignment()[0] if history.gauge == "free" else None
    tracks = {id: history.track(id) for id in history.robots}
    if align is not None:
        tracks = {id: _laid(track.moved(align)) for id, track in tracks.items()}
        fixes = {}  # they are in the frame of the map, not of the truth
    fixes = {id: table[table[:, 0] <= history.last.t, 1:] for id, table in fixes.items()}
    lmks = _landmarks(history, align)
    with plt.rc_context({"figure.max_open_warning": 0}):
        names = [_map(out, history.last, tracks, lmks, data, align, fixes)]
        seen = richest or {}
        names += [_sensor(out, seen.get(sen.id, history.last), sen.id, data.figure) for sen in lookers(history.last)]
        names += write_robot_figures(out, history, tracks, lmks, data, fixes)
        return names + ([_costs(out, history, costs)] if costs is not None and len(costs) > 1 else [])


def how_many(history, data, costs=None):
    """Say how many pictures there will be, or one or two more."""
    each = 3 if len(history.robots) > 1 else 2
    return 1 + len(data.sensors) + each * len(history.robots) + (costs is not None)


def _costs(out, history, costs):
    """Draw what each frame has cost, and the size of the map."""
    t = next(history.track(id).t for id in history.robots)
    ax = cost_panel(t[-len(costs) :], np.array(costs), np.array(history.n_landmarks[-len(costs) :]))
    return save_figure(ax.figure, out / "cost.png")


def _landmarks(history, align):
    """The landmarks of the map and the true ones, as `map_picture` takes them: partners have the same id."""
    s = history.last
    dim = s.robs[0].motion.frame.dim
    lmks = [lmk for lmk in s.lmks.values() if lmk.par is None]
    points = [lmk.point(s.map) for lmk in lmks]
    mean = np.array([p for p, _ in points]).reshape(-1, dim)
    cov = np.array([P for _, P in points]).reshape(-1, dim, dim)
    if align is not None and len(mean):
        mean, cov = align.from_frame(mean)[0], align.R @ cov @ align.R.T
    finite = np.flatnonzero(np.isfinite(np.concatenate([mean, cov.reshape(-1, dim * dim)], 1)).all(1))
    return {
        "mean": mean[finite],
        "cov": cov[finite],
        "ids": np.array([lmk.id for lmk in lmks], int)[finite].tolist(),
        "true_points": None if s.sim_lmk is None else s.sim_lmk.points,
        "true_ids": None if s.sim_lmk is None else _ids_of_partners(history),
    } | _lines(s, align)


def _lines(s, align):
    """The lines of the map and the true edges, as `map_picture` takes them; nothing where there are none."""
    ids, ends, cov = lmk_lines(s)
    edges = None if s.sim_lmk is None else s.sim_lmk.segments.reshape(-1, 2, 3)
    if not ids and (edges is None or not len(edges)):
        return {}
    if align is not None and ids:
        ends, cov = align.from_frame(ends)[0], align.R @ cov @ align.R.T
    good = np.isfinite(cov).all((1, 2, 3))
    return {"lines": (np.array(ids, int)[good].tolist(), ends[good], cov[good]), "true_edges": edges}


def _ids_of_partners(history):
    """For each true landmark the id of the one in the map that is meant; below 0 where there is none."""
    ids = -1 - np.arange(len(history.last.sim_lmk.ids))
    for id, row in history.partners().items():
        ids[row] = id
    return ids


def _map(out, s, tracks, lmks, data, align, fixes):
    """The whole run in one picture: laid on the truth, if the map has a frame of its own."""
    dim = s.robs[0].motion.frame.dim
    named = {f"robot {id}": track for id, track in tracks.items()}
    known = {name: track for name, track in named.items() if track.known.any()}
    few = len(tracks) <= FEW
    axes, _ = map_picture(
        {name: track.x[:, :dim] for name, track in named.items()},
        **lmks,
        true_path={name: track.truth[:, :dim] for name, track in known.items()} or None,
        dead_reckoning={name: track.dead[:, :dim] for name, track in named.items()} if few and not fixes else None,
        fixes={f"robot {id}": p for id, p in fixes.items()} or None,
        k=data.figure.k,
        title=f"{data.name}: {s.k - data.time.first + 1} frames" + ", map laid on the truth" * (align is not None),
    )
    return save_figure(axes.figure, out / "map.png")


def _laid(track):
    """The track with its dead reckoning laid on the truth, where there is enough of that."""
    try:
        return track.aligned_dead()
    except ValueError:
        return track


def lookers(snapshot):
    """The sensors that have a figure: those that see landmarks."""
    return [sen for sen in snapshot.sens if not hasattr(sen.model, "without_lmks")]


def _sensor(out, snapshot, sensor, figure):
    fig = SenFig(snapshot, sensor, k=figure.k, labels=figure.labels).fig
    return save_figure(fig, out / f"sensor-{sensor}.png")


def movie_path(out):
    """Return where the movie goes: MP4 where ffmpeg is, else GIF. Asked before the run."""
    return check_movie_path(Path(out) / ("movie.mp4" if shutil.which("ffmpeg") else "movie.gif"))


def check_display():
    """Refuse a live view where no window can be shown.

    Raises
    ------
    ValueError
        With what to do instead.
    """
    from matplotlib.backends.registry import BackendFilter, backend_registry  # not in matplotlib 3.8, a browser's

    interactive = backend_registry.list_builtin(BackendFilter.INTERACTIVE)
    if plt.get_backend().lower() not in (name.lower() for name in interactive):
        raise ValueError("--live needs a display, and there is none here; take --movie and watch it afterwards")


def has_display():
    """Return True if a live view can be shown."""
    try:
        check_display()
    except ValueError:
        return False
    return True


class Richest:
    """Keeps, for each sensor, the frame in which it measured most landmarks: in the last of all there may be none.

    Attributes
    ----------
    kept : dict of int to namespace
        By sensor id: what `SenFig` reads of a snapshot.
    """

    PATIENCE = 20  # frames, before one that is as rich takes the place

    def __init__(self):
        self.kept, self._most = {}, Counter()

    def add(self, snapshot):
        """Take a snapshot."""
        for id, n in Counter(sen for (sen, _), obs in snapshot.obs.items() if obs.matched).items():
            if n < self._most[id] or (n == self._most[id] and snapshot.k < self.kept[id].k + self.PATIENCE):
                continue
            self._most[id] = n
            raw = {id: snapshot.raw[id]} if id in snapshot.raw else {}
            obs = {key: obs for key, obs in snapshot.obs.items() if key[0] == id}
            events = [event for event in snapshot.events if event.sen == id]
            raw, obs, events = deepcopy((raw, obs, events))  # the run goes on with its own
            self.kept[id] = SimpleNamespace(k=snapshot.k, sens=snapshot.sens, raw=raw, obs=obs, events=events)


class Replay:
    """A page that plays the run, `view.html`: the plane as a plan, space as bodies that can be walked around.

    Parameters
    ----------
    title : str
    frames : int
        Of the run. The page plays at most `MOST_FRAMES` of them, so that it stays small, and of a camera's images it
        shows at most `MOST_IMAGES`: 2 MB.
    k : float
        Ellipses are drawn at k sigma.
    """

    MOST_FRAMES, MOST_IMAGES = 300, 150

    def __init__(self, title, frames, k):
        period = max(1, -(-frames // self.MOST_FRAMES))
        self.log = StateLog(title, k, period=period, images=-(-frames // (period * self.MOST_IMAGES)))

    def add(self, snapshot):
        """Take a snapshot."""
        self.log.add(snapshot)

    def write(self, out):
        """Write the page; return its name."""
        with replacing(out / "view.html") as part:
            write_player_html(part, self.log)
        return "view.html"


class _Figures:
    """Map figure and sensor figures, made with the first snapshot and updated with every `period`-th one."""

    def __init__(self, options):
        self._options, self._count, self.figures = options, 0, []

    def add(self, snapshot):
        """Take a snapshot; draw it if it is one of those to be drawn."""
        due, self._count = self._count % self._options.period == 0, self._count + 1
        if not due:
            return
        if not self.figures:
            self._make(snapshot)
        elif self._options.orbit_deg and self.figures[0].dim == 3:
            self.figures[0].orbit(np.deg2rad(self._options.orbit_deg * self._options.period))
        for figure in self.figures:
            figure.update(snapshot)
        self.show()

    def _make(self, snapshot):
        o = self._options
        world = MapFig(snapshot, k=o.k, view=o.view or None, limits=o.limits, labels=o.labels)
        self.figures = [world, *(SenFig(snapshot, sen.id, k=o.k, labels=o.labels) for sen in lookers(snapshot))]

    def show(self):
        """Do with the figures what they are for."""
        raise NotImplementedError

    def __enter__(self):
        use_style(dpi=75)
        return self

    def __exit__(self, *problem):
        for figure in self.figures:
            plt.close(figure.fig)


class Film(_Figures):
    """A movie: the map, and what the first sensor sees beside it."""

    def __init__(self, path, options):
        super().__init__(options)
        self._movie = Movie(path, options.fps)

    def show(self):
        """Append the figures to the movie."""
        self._movie.add(side_by_side(grab(figure.fig) for figure in self.figures[:2]))

    def __exit__(self, *problem):
        super().__exit__(*problem)
        self._movie.__exit__(*problem)


class Live(_Figures):
    """Windows that follow the run; they stay open at its end until they are closed."""

    def show(self):
        """Let the windows draw."""
        for figure in self.figures:
            figure.fig.canvas.draw_idle()
        plt.pause(0.001)

    def __exit__(self, *problem):
        if problem[0] is None and self.figures:
            plt.show(block=True)
        super().__exit__(*problem)
