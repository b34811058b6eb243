"""What a run leaves behind: result.json, trajectory.csv, map.csv, map.png and a figure of each sensor."""

import csv
import json

import numpy as np

from .. import __version__
from ..analysis.fixes import fix_figures
from .files import replacing
from .tum import write_tum

SPOKEN = {
    "ate_rmse_m": "ATE {:.3g} m",
    "landmark_rmse_m": "landmark RMSE {:.3g} m",
    "gps_rmse_best95_m": "{:.3g} m RMSE to the best 95 % of GPS",
}
"""Figures that are said in one line, where they are known."""
SURPRISED = 10
"""Squared innovations so many times as large as expected are not a question of tuning: something is wrong."""
FEW = 50
"""So many frames may pass without a landmark being measured a second time."""
STATE = {3: ["x", "y", "theta"], 7: ["x", "y", "z", "a", "b", "c", "d"]}
ERROR = {3: ["std_x", "std_y", "std_theta"], 7: ["std_x", "std_y", "std_z", "std_rx", "std_ry", "std_rz"]}


def summary(data, history, recording, run, seconds, interrupted, costs=()):
    """The figures of a run for result.json; None stands for what cannot be known.

    Parameters
    ----------
    data : UserData
    history : History
    recording : Recording or None
    run : Run
        It knows how many frames there were to be, and which engine computed them.
    seconds : float
        Time that the run took.
    interrupted : bool
    costs : sequence of float
        Processor time of each frame, s.
    """
    figures = history.summary()
    figures["n_landmarks"] = len(history.last.lmks)
    if recording and recording.fixes:
        robots = figures.pop("robots")
        figures |= fix_figures((history.track(id) for id in history.robots), recording.fixes) | {"robots": robots}
    head = {"scenario": data.name, "seed": data.seed, "version": __version__}
    opt = data.options
    head |= {"error": "additive, first estimates" if opt.first_estimates else opt.error}
    head |= {"engine": run.engine, "recording": recording.name if recording else None}
    head |= {"complete": not interrupted, "frames_wanted": len(run)}
    tail = {"n_landmarks_refused": len(history.last.refused), "wall_s": round(seconds, 3)}
    tail["cpu_s"] = round(sum(costs), 3) if len(costs) else None
    tail["notes"] = recording.notes if recording else []
    return head | {k: v for k, v in figures.items() if k != "robots"} | tail | {"robots": figures["robots"]}


def sentence(figures):
    """The figures of a run in one line."""
    words = [f"{figures['frames']} frames", f"{figures['n_landmarks']} landmarks"]
    for key, text in SPOKEN.items():
        if figures.get(key) is not None:
            words.append(text.format(figures[key]))
    if figures["n_landmarks_refused"]:
        words.append(f"{figures['n_landmarks_refused']} landmarks not started: the map was full")
    return f"{figures['scenario']}: {', '.join(words)}, {figures['wall_s']:.2f} s"


def doubts(figures, history):
    """Sentences on a run whose measurements do not fit what the filter expects of them."""
    used, refused = sum(len(history.nis(id)) for id in history.robots), figures["n_refused"]
    ask = "are units, signs, mounting, ids and noise right?"
    if not used + refused and figures["frames"] > FEW:
        yield f"no landmark was measured a second time: {ask}"
    if refused > used:
        yield f"of {used + refused} innovations {refused} did not pass the gate: {ask}"
    if (figures["nis_mean"] or 0.0) > SURPRISED * (figures["nis_dof"] or 0.0):
        yield f"the mean NIS is {figures['nis_mean']:.3g}, and {figures['nis_dof']:.3g} is expected: {ask}"


def write(out, figures, history, data, recording=None, costs=None):
    """Write all files; each appears whole or not at all. Returns their names.

    `costs` are the seconds that each frame took.
    """
    from . import views

    with replacing(out / "result.json") as part:
        part.write_text(json.dumps(figures, indent=2, allow_nan=False) + "\n", encoding="utf-8")
    _write_csv(out / "trajectory.csv", *trajectory(history, data.time.first))
    _write_csv(out / "map.csv", *landmarks(history))
    names = ["result.json", "trajectory.csv", "map.csv", *write_tum(out, history)]
    return [*names, *views.write_figures(out, history, data, recording and recording.fixes, costs)]


def write_recording(out, recorder, name, fixes=None):
    """Write recording.npz, which plays the run again."""
    played = recorder.recording(name)
    played.fixes = fixes or {}
    with replacing(out / "recording.npz") as part:
        played.save(part)
    return ["recording.npz"]


def trajectory(history, first):
    """Header and rows of trajectory.csv: one row for each frame and robot, metres and radians, in the map's frame.

    Standard deviations of angles are those of small rotations about the axes of the robot.
    """
    tracks = [history.track(id) for id in history.robots]
    state, error = STATE[tracks[0].frame.size], ERROR[tracks[0].frame.size]
    header = ["frame", "t", "robot", *state, *error, *(f"true_{name}" for name in state)]
    stds = [_stds(track) for track in tracks]
    rows = (
        [first + k, track.t[k], track.id, *track.x[k], *std[k], *_blank(track.truth[k])]
        for k in range(len(tracks[0].t))
        for track, std in zip(tracks, stds, strict=True)
    )
    return header, rows


def _stds(track):
    """Standard deviations of position and angles, shape (F, dof)."""
    F = track.frame(track.x)
    _, E_x = F.minus(F)
    variances = np.einsum("...ij,...jk,...ik->...i", E_x, track.P, E_x)
    return np.sqrt(variances.clip(0))


def landmarks(history):
    """Header and rows of map.csv: Euclidean mean and covariance of each landmark, and the truth where known."""
    s = history.last
    axes = "xyz"[: s.robs[0].motion.frame.dim]
    i, j = np.triu_indices(len(axes))
    names = [f"P_{axes[a]}{axes[b]}" for a, b in zip(i, j, strict=True)]
    counts = ["n_search", "n_match", "n_inlier"]
    header = ["id", "type", *axes, *names, *(f"true_{axis}" for axis in axes), *counts]
    places = {} if s.sim_lmk is None else dict(zip(s.sim_lmk.ids.tolist(), s.sim_lmk.points, strict=True))
    rows = []
    for lmk in s.lmks.values():
        p, P = lmk.point(s.map)
        truth = places.get(lmk.id, np.full(len(axes), np.nan))
        rows.append([lmk.id, type(lmk.type).__name__, *p, *P[i, j], *_blank(truth), *(getattr(lmk, n) for n in counts)])
    return header, rows


def _blank(values):
    """Nothing at all where a value is not known."""
    return [v if np.isfinite(v) else "" for v in values]


def _write_csv(path, header, rows):
    with replacing(path) as part, open(part, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        writer.writerows([v.item() if isinstance(v, np.generic) else v for v in row] for row in rows)
