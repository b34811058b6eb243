"""What a run leaves behind: result.json, trajectory.csv, map.csv, map.png and a figure of each sensor."""

import csv
import json

import numpy as np

from .. import __version__
from ..analysis.fixes import fix_figures
from ..analysis.pictures import picture_figures
from ..analysis.rec_file import write_rec
from ..models import Calibrated
from .files import pictures, replacing, written
from .terminal import say, table
from .trajectories import write_tum

TOLD = [
    ("position error (ATE)", "ate_rmse_m", "{:.3g} m", "dead reckoning: {dead_reckoning_ate_m:.3g} m"),
    ("heading error", "heading_rmse_deg", "{:.3g} deg", ""),
    ("landmark error", "landmark_rmse_m", "{:.3g} m", "half of them below: {landmark_median_m:.3g} m"),
    ("RMSE to the best 95 % of GPS", "gps_rmse_best95_m", "{:.3g} m", "aligned: {gps_rmse_best95_aligned_m:.3g} m"),
    ("NEES of the {nees_of}", "nees_mean", "{:.3g}", "expected: {nees_dof:.3g}"),
    ("NIS", "nis_mean", "{:.3g}", "expected: {nis_dof:.3g}"),
    ("correction ratio", "correction_ratio", "{:.2f}", "honest below: {correction_ratio_limit:.2f}"),
]
"""Figures that are told where they are known, each on a line: what it is, its value, and what to hold it against."""
WARM = 10
"""In the first frames models are read and written down as programs: they do not count for `frames_per_s`."""
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
    head |= {"t0": recording.t0} if recording and recording.t0 else {}
    head |= {"complete": not interrupted, "frames_wanted": len(run)}
    own = [lmk for lmk in history.last.lmks.values() if lmk.r is not None]  # known ones need not be seen at all
    tail = {
        "n_seen_once": sum(lmk.n_match == 1 for lmk in own),
        "n_rings": len(history.last.rings),
        "n_landmarks_refused": len(history.last.refused),
        "wall_s": round(seconds, 3),
    }
    tail["cpu_s"] = round(sum(costs), 3) if len(costs) else None
    tail["frames_per_s"] = round(1 / np.mean(costs[WARM:]), 1) if len(costs) > WARM and np.mean(costs[WARM:]) else None
    tail |= {"parameters": found} if (found := parameters(history)) else {}
    tail |= picture_figures(history, recording) if hasattr(recording, "truth_std") else {}
    tail["notes"] = recording.notes if recording else []  # `run` adds what it has to say
    return head | {k: v for k, v in figures.items() if k != "robots"} | tail | {"robots": figures["robots"]}


def tell(figures):
    """Print what has come out: how much there was, and a line for each figure with what was expected beside it."""
    words = [f"{figures['frames']} frames", f"{figures['n_landmarks']} landmarks"]
    if figures["n_landmarks_refused"]:
        words.append(f"{figures['n_landmarks_refused']} landmarks not started: the map was full")
    if figures.get("landmarks_by") == "place" and figures["n_left_over"]:
        words.append(f"{figures['n_left_over']} of them where no true one is")
    say(f"{figures['scenario']}: {', '.join(words)}, {figures['wall_s']:.2f} s", "bold")
    known = {"nees_of": "pose"} | {key: value for key, value in figures.items() if value is not None}
    rows = [
        [f"  {what.format_map(known)}", text.format(known[key]), beside(text_of, known)]
        for what, key, text, text_of in TOLD
        if key in known
    ]
    for number, names in figures.get("parameters", {}).items():
        for name, p in names.items():
            true = f"true: {_few(p['true'])}" if "true" in p else ""
            rows.append([f"  {name} of sensor {number}", f"{_few(p['value'])} ± {_few(p['std'])}", true])
    table(rows, styles=["", "bold", "dim"])


def _few(numbers):
    return ", ".join(f"{x:.4g}" for x in numbers)


def parameters(history):
    """Estimated parameters of sensors: value, standard deviation, and the true value where it is known.

    Parameters of their models by name, and of their mounting the `position`, m, where it was not known.

    Returns
    -------
    dict
        By sensor id, as a text, and name.
    """
    s, found = history.last, {}
    truth = {sen.id: sen.frame.x for sen in s.sim_sens}
    for sen in (sen for sen in s.sens if sen.r is not None):
        x, std = sen.state(s.map), np.sqrt(np.diag(s.map.block(sen.r)).clip(0))
        values = {"value": x, "std": std} | ({"true": truth[sen.id]} if sen.id in truth else {})
        at = {"position": slice(0, sen.frame_type.dim)} if std[: sen.frame_type.dim].any() else {}
        if isinstance(sen.model, Calibrated):
            first = len(x) - len(sen.model.start)
            at |= {n: slice(first + r.start, first + r.stop) for n, r in sen.model.slices().items()}
        if at:
            found[str(sen.id)] = {n: {key: v[r].tolist() for key, v in values.items()} for n, r in at.items()}
    return found


def beside(text, figures):
    """The text with its figure put in; nothing if that is not known."""
    try:
        return text.format_map(figures)
    except KeyError:
        return ""


def write(out, figures, history, data, recording=None, costs=None, richest=None):
    """Write all files; each appears whole or not at all. Returns their names.

    `costs` are the seconds that each frame took, `richest` the frames that the sensors' figures show (`views.Richest`).
    """
    from . import views

    write_figures(out, figures)
    _write_csv(out / "trajectory.csv", *trajectory(history, data.time.first))
    _write_csv(out / "map.csv", *landmarks(history, recording.names if recording else {}))
    names = ["result.json", "trajectory.csv", "map.csv", *write_tum(out, history)]
    if any(lmk.par is not None for lmk in history.last.lmks.values()):
        _write_csv(out / "lines.csv", *lines(history))
        names.append("lines.csv")
    with pictures(views.how_many(history, data, costs)):
        return [*names, *views.write_figures(out, history, data, recording and recording.fixes, costs, richest)]


def write_figures(out, figures):
    """Write result.json."""
    with written(out / "result.json", text=True) as file:
        file.write(json.dumps(figures, indent=2, allow_nan=False) + "\n")


def write_recording(out, recorder, name, recording=None):
    """Write recording.npz, which plays the run again; `recording` is what was played, if it was one."""
    played = recorder.recording(name)
    if recording is not None:
        for kept in ("fixes", "starts", "names", "t0"):
            setattr(played, kept, getattr(recording, kept))
    played.save(out / "recording.npz")
    return ["recording.npz"]


def write_record(out, history, innovations):
    """Write estimate.rec, which `ekfslam audit` reads."""
    with replacing(out / "estimate.rec") as part:
        write_rec(part, history, innovations)
    return ["estimate.rec"]


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


def lines(history):
    """Header and rows of lines.csv: both ends of each line as far as it was seen, and the true edge where known."""
    s = history.last
    ends = [f"{axis}{i}" for i in (1, 2) for axis in "xyz"]
    counts = ["n_search", "n_match", "n_inlier"]
    header = ["id", "type", *ends, *(f"true_{name}" for name in ends), *counts]
    edges = {} if s.sim_lmk is None else dict(zip(s.sim_lmk.segment_ids.tolist(), s.sim_lmk.segments, strict=True))
    rows = []
    for lmk in (lmk for lmk in s.lmks.values() if lmk.par is not None):
        p, truth = lmk.ends(s.map)[0].ravel(), edges.get(lmk.id, np.full(6, np.nan))
        rows.append([lmk.id, type(lmk.type).__name__, *p, *_blank(truth), *(getattr(lmk, n) for n in counts)])
    return header, rows


def landmarks(history, called=None):
    """Header and rows of map.csv: Euclidean mean and covariance of each point, and the truth where known.

    Where ids are the filter's own, the last column says which true landmark is in its place; where the log has words
    for ids, `called` by id, it is the word.
    """
    s = history.last
    axes = "xyz"[: s.robs[0].motion.frame.dim]
    i, j = np.triu_indices(len(axes))
    names = [f"P_{axes[a]}{axes[b]}" for a, b in zip(i, j, strict=True)]
    counts = ["n_search", "n_match", "n_inlier"]
    header = ["id", "type", *axes, *names, *(f"true_{axis}" for axis in axes), *counts]
    partners, rows = history.partners(), []
    for lmk in (lmk for lmk in s.lmks.values() if lmk.par is None):
        p, P = lmk.point(s.map)
        truth = s.sim_lmk.points[partners[lmk.id]] if lmk.id in partners else np.full(len(axes), np.nan)
        rows.append([lmk.id, type(lmk.type).__name__, *p, *P[i, j], *_blank(truth), *(getattr(lmk, n) for n in counts)])
    if not s.named:  # the ids above are the filter's own
        header.append("true_id")
        for row in rows:
            row.append(int(s.sim_lmk.ids[partners[row[0]]]) if row[0] in partners else "")
    elif called:
        header.append("name")
        for row in rows:
            row.append(called.get(row[0], ""))
    return header, rows


def _blank(values):
    """Nothing at all where a value is not known."""
    return [v if np.isfinite(v) else "" for v in values]


def _write_csv(path, header, rows):
    with written(path, text=True) as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        writer.writerows([v.item() if isinstance(v, np.generic) else v for v in row] for row in rows)
