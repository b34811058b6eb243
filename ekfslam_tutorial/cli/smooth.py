"""`ekfslam smooth RUN`: the filter, and a smoother beside it, of the same models and measurements."""

from pathlib import Path

import numpy as np

from ..analysis.factors import graph_of
from ..analysis.smoother import smooth, smooth_lagged
from ..geometry import align
from ..graphics import use_style
from ..graphics.smoother_picture import smoother_picture
from .files import file_name, save_figure, writable_folder, written
from .run import own_models, read, source, tell_notes, told_by_name
from .terminal import say, table

ELSEWHERE = 5.0
"""So many sigma is the error larger than believed where the truth is in another frame than the map."""


def main(options):
    """Run the command: 0, or 1 where the smoother has found no end."""
    models = [cls for file in options.models for cls in own_models(file)]
    with told_by_name(options.models):
        data, recording = source(options, read(options, models))
        tell_notes(recording.notes if recording else [])
        graph = graph_of(data, recording)
        if not graph.robots:
            raise ValueError("all poses are known: there is nothing to smooth")
        found = smooth(graph) if options.lag is None else smooth_lagged(graph, options.lag)
    out = writable_folder(options.out or Path("results") / f"{file_name(data.name)}-smoothed")
    names = [write(out, found, id) for id in graph.robots]
    names += [_map(out, found), _picture(out, found, data.name)]
    tell(found, data.name, options.lag)
    print(f"written to {out}: {', '.join(names)}", flush=True)
    return 0 if found.converged or options.lag is not None else 1


def tell(found, name, lag):
    """Lines for the terminal: what was smoothed, and both errors of each robot."""
    how = f"{len(found.steps)} steps" if lag is None else f"a lag of {lag} frames"
    end = "" if found.converged or lag is not None else f", not at its end: the last one moved {found.steps[-1]:.1g}"
    say(f"{name}: {len(found.graph.t) - 1} frames, {len(found.landmarks())} landmarks, {how}{end}", "bold")
    rows = []
    for id in found.graph.robots:
        for label, (x, P) in (("filter", found.filtered(id)), ("smoother", found.track(id))):
            d = _dim(found, id)
            truth = truth_of(found, id)[:, :d]
            errors = rmse(x[:, :d], truth), rmse(x[:, :d], aligned(truth, x[:, :d]))
            sigma = np.sqrt(np.trace(P[:, :d, :d], axis1=1, axis2=2))
            said = [
                f"{v:.3f}" if np.isfinite(v) else "-" for v in (*errors, np.sqrt(np.mean(sigma[1:] ** 2)), sigma[-1])
            ]
            rows.append([f"robot {id}, {label}", *said])
    table(rows, ["", "position RMSE m", "aligned m", "its sigma m", "sigma at the end m"])


def rmse(x, truth):
    """Root mean square distance where the truth is known; NaN where it is nowhere."""
    e = np.linalg.norm(x - truth, axis=1)
    return np.sqrt(np.mean(e[np.isfinite(e)] ** 2)) if np.isfinite(e).any() else np.nan


def aligned(truth, x):
    """True positions, shifted and turned to lie on the estimated ones: for a log whose start nobody has surveyed."""
    known = np.isfinite(truth).all(1)
    try:
        return align(truth[known], x[known]).from_frame(truth)[0]
    except ValueError:  # too few, or all in one place
        return truth


def truth_of(found, id):
    """True poses of the start and after each frame, NaN where they are not known."""
    g = found.graph
    nothing = np.full(g.frames["robot", id].size, np.nan)
    return np.array([g.truth.get(("robot", id, k), nothing) for k in range(len(g.t))])


def write(out, found, id):
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
        truth, name = aligned(truth, x), f"{name}, the truth aligned with the smoother"
    known = truth if np.isfinite(truth).any() else None
    return save_figure(smoother_picture(found.graph.t, *tracks, known, mean, title=name), out / "smooth.png")


def _dim(found, id):
    return found.graph.frames["robot", id].dim
