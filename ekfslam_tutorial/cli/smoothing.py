"""What the smoother makes of a run: its figures and its files, for `ekfslam smooth` and for a run with `smooth`."""

import json

import numpy as np

from ..analysis.factors import GraphMaker
from ..analysis.progress import bar
from ..analysis.smoother import smooth, smooth_lagged
from ..geometry import align
from ..graphics import use_style
from ..graphics.smoother_picture import smoother_picture
from .files import save_figure, written
from .terminal import say, table
from .trajectories import tum_rows, write_text

COLUMNS = {
    "position_rmse_m": "position RMSE m",
    "position_aligned_rmse_m": "aligned m",
    "sigma_m": "its sigma m",
    "sigma_end_m": "sigma at the end m",
    "landmark_rmse_m": "landmarks RMSE m",
    "landmark_aligned_rmse_m": "aligned m",
}
"""What is told of filter and smoother, and its head."""

ELSEWHERE = 5.0
"""So many sigma is the error larger than believed where the truth is in another frame than the map."""


def check(data):
    """Refuse a scenario that cannot be smoothed, before it is run."""
    GraphMaker(data)
    if not any(robot.in_map for robot in data.robots):
        raise ValueError("all poses are known: there is nothing to smooth")


def smoothed(graph, lag=None):
    """Smooth a graph, with a fixed lag if one is given; a bar shows the steps, of which nobody knows how many come."""
    if lag is not None:
        return smooth_lagged(graph, lag)
    with bar(1, "smoothing") as done:

        def after_step():
            """One more is done, and one more may come."""
            done.total = done.n + 2
            done.update()

        found = smooth(graph, after_step=after_step)
        done.total = done.n
    return found


def write(out, found, name):
    """Write all files; return their names."""
    names = [file for id in found.graph.robots for file in (_track(out, found, id), _path(out, found, id))]
    return [*names, _map(out, found), _scores(out, found), _picture(out, found, name)]


def tell(found, name, lag):
    """Lines for the terminal: what was smoothed, and both errors of each robot."""
    how = f"{len(found.steps)} steps" if lag is None else f"a lag of {lag} frames"
    end = "" if found.converged or lag is not None else f", not at its end: the last one moved {found.steps[-1]:.1g}"
    say(f"{name}: {len(found.graph.t) - 1} frames, {len(found.landmarks())} landmarks, {how}{end}", "bold")
    shown = lambda v: "-" if v is None else f"{v:.3f}"
    rows = [[f"robot {s['robot']}, {s['of']}", *(shown(s[name]) for name in COLUMNS)] for s in scores(found)]
    table(rows, ["", *COLUMNS.values()])


def scores(found):
    """Errors of filter and smoother, of each robot: the path, and the landmarks at the end.

    Aligned is with the true path laid on the estimated one, and the true landmarks moved with it.

    Returns
    -------
    list of dict
        `COLUMNS` in metres, None where there is no truth; `landmark_errors_m`, aligned, by id.
    """
    g, rows = found.graph, []
    true = {key[1]: p for key, p in g.truth.items() if key[0] == "landmark" and key in g.values}
    places = {
        "filter": {id: g.types[id].point(g.filtered["landmark", id][0])[0] for id in true},
        "smoother": {id: p for id, (p, _) in found.landmarks().items() if id in true},
    }
    for id in g.robots:
        for label, (x, P) in (("filter", found.filtered(id)), ("smoother", found.track(id))):
            d = _dim(found, id)
            truth, p = truth_of(found, id)[:, :d], np.array([places[label][i] for i in true]).reshape(-1, d)
            q, lay = np.array(list(true.values())).reshape(-1, d), laid_on(truth, x[:, :d])
            sigma = np.sqrt(np.trace(P[:, :d, :d], axis1=1, axis2=2))
            row = rmse(x[:, :d], truth), rmse(x[:, :d], lay(truth)), np.sqrt(np.mean(sigma[1:] ** 2)), sigma[-1]
            row = [float(v) if np.isfinite(v) else None for v in (*row, rmse(p, q), rmse(p, lay(q)))]
            each = np.linalg.norm(p - lay(q), axis=1).tolist()
            rows.append({"robot": id, "of": label} | dict(zip(COLUMNS, row, strict=True)))
            rows[-1]["landmark_errors_m"] = dict(zip(true, each, strict=True))
    return rows


def rmse(x, truth):
    """Root mean square distance where the truth is known; NaN where it is nowhere."""
    e = np.linalg.norm(x - truth, axis=1)
    return np.sqrt(np.mean(e[np.isfinite(e)] ** 2)) if np.isfinite(e).any() else np.nan


def laid_on(truth, x):
    """Shift and turn that lay true positions on the estimated ones: for a log whose start nobody has surveyed."""
    known = np.isfinite(truth).all(1)
    try:
        F = align(truth[known], x[known])
    except ValueError:  # too few, or all in one place
        return lambda p: p
    return lambda p: F.from_frame(p)[0]


def truth_of(found, id):
    """True poses of the start and after each frame, NaN where they are not known."""
    g = found.graph
    nothing = np.full(g.frames["robot", id].size, np.nan)
    return np.array([g.truth.get(("robot", id, k), nothing) for k in range(len(g.t))])


def _track(out, found, id):
    """Write smoothed-N.csv: time, state, standard deviations of it, and the state of the filter."""
    (x, P), (y, _) = found.track(id), found.filtered(id)
    std = np.sqrt(np.diagonal(P, axis1=1, axis2=2).clip(0))
    n = range(x.shape[1])
    frame = found.graph.frames["robot", id]
    pose = ["x", "y", "theta"] if frame.dim == 2 else [*"xyz", *"abcd"]
    state = [*pose, *(f"v{i}" for i in range(len(n) - len(pose)))]
    header = ["t", *state, *(f"std_{name}" for name in state), *(f"filter_{name}" for name in state)]
    rows = np.column_stack([found.graph.t, x, std, y])
    with written(out / f"smoothed-{id}.csv", text=True) as file:
        np.savetxt(file, rows, delimiter=",", header=",".join(header), comments="", fmt="%.9g")
    return f"smoothed-{id}.csv"


def _path(out, found, id):
    """Write smoothed-N.tum, as `run` writes trajectory-N.tum, for `evo` and others."""
    x, _ = found.track(id)
    return write_text(out / f"smoothed-{id}.tum", tum_rows(found.graph.t, x[:, : found.graph.frames["robot", id].size]))


def _map(out, found):
    """Write smoothed-map.csv, as `run` writes map.csv: id, mean, upper triangle of the covariance."""
    places = found.landmarks()
    axes = "xyz"[: next(iter(found.graph.frames.values())).dim]
    i, j = np.triu_indices(len(axes))
    header = ["id", *axes, *(f"P_{axes[a]}{axes[b]}" for a, b in zip(i, j, strict=True))]
    with written(out / "smoothed-map.csv", text=True) as file:
        file.write(",".join(header) + "\n")
        for id, (p, P) in places.items():
            file.write(",".join([str(id), *(f"{v:.9g}" for v in [*p, *P[i, j]])]) + "\n")
    return "smoothed-map.csv"


def _scores(out, found):
    """Write smoothed.json: the `scores`."""
    with written(out / "smoothed.json", text=True) as file:
        file.write(json.dumps(scores(found), indent=2, allow_nan=False) + "\n")
    return "smoothed.json"


def _picture(out, found, name):
    """Write smooth.png, of the first robot."""
    id = found.graph.robots[0]
    d = _dim(found, id)
    truth = truth_of(found, id)[:, :d]
    cut = lambda track: (track[0][:, :d], track[1][:, :d, :d])
    mean = np.array([p for p, _ in found.landmarks().values()]).reshape(-1, d)
    use_style(dpi=100)
    tracks = cut(found.filtered(id)), cut(found.track(id))
    x, P = tracks[1]
    if rmse(x, truth) > ELSEWHERE * np.sqrt(np.mean(np.trace(P, axis1=1, axis2=2))):
        truth, name = laid_on(truth, x)(truth), f"{name}, the truth aligned with the smoother"
    known = truth if np.isfinite(truth).any() else None
    return save_figure(smoother_picture(found.graph.t, *tracks, known, mean, title=name), out / "smooth.png")


def _dim(found, id):
    return found.graph.frames["robot", id].dim
