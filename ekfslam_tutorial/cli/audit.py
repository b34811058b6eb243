"""`ekfslam audit EST... --truth FILE`: is an estimator honest? A verdict, its power, pictures, JSON."""

import json
import math
from dataclasses import replace
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from ..analysis.audit import audit
from ..analysis.estimate_files import read_estimate, read_innovations, read_map, read_truth, with_truth
from ..analysis.estimates import run_errors
from ..analysis.g2o import read_g2o
from ..analysis.rec_file import read_rec
from ..graphics import use_style
from ..graphics.audit_picture import audit_picture
from .files import replacing, writable_folder

LABELS = {
    "pose": "pose",
    "position": "  position alone",
    "rotation": "  rotation alone",
    "map": "map",
    "innovations": "innovations",
}


def main(options):
    """Run the command: 0 if the estimator is honest or nothing is known, 1 if not."""
    if not 0 < options.confidence < 1:
        raise ValueError(f"--confidence is a probability between 0 and 1, got {options.confidence:g}")
    if not (options.max_dt >= 0 and math.isfinite(options.max_dt)):
        raise ValueError(f"--max-dt is a time of 0 s or more, got {options.max_dt:g}")
    runs = [run_errors(s, options.gauge, 1 if options.gravity else None) for s in estimates(options)]
    found = audit(runs, options.confidence)
    out = writable_folder(options.out or Path("results") / "audit")
    with replacing(out / "audit.json") as part:
        part.write_text(json.dumps(found.summary(), indent=2, allow_nan=False) + "\n", encoding="utf-8")
    use_style(dpi=100)
    fig = audit_picture(found)
    with replacing(out / "audit.png") as part:
        fig.savefig(part)
    plt.close(fig)
    print("\n".join(report(found)))
    print(f"written to {out}: audit.json, audit.png", flush=True)
    return 0 if found.verdict in ("honest", "not known") else 1


def estimates(options):
    """All estimates with their truths, maps and innovations, from files."""
    n = len(options.estimates)
    each = {name: _each(name, getattr(options, name), n) for name in ("truth", "map", "true_map", "innovations")}
    for k, path in enumerate(options.estimates):
        yield _estimate(path, options, {name: files[k] for name, files in each.items()})


def _each(name, files, n):
    """One file for each estimate, or None."""
    if files is None:
        return [None] * n
    if len(files) == 1 and name in ("truth", "true_map"):
        return files * n
    if len(files) != n:
        raise ValueError(
            f"--{name.replace('_', '-')} needs as many files as there are estimates, {n}, got {len(files)}"
        )
    return files


def _estimate(path, options, files):
    if Path(path).is_dir():
        path = str(Path(path) / "estimate.rec")
    if not Path(path).is_file():
        hint = "; `ekfslam run --record` writes it" if path.endswith(".rec") else ""
        raise FileNotFoundError(f"no file {path}{hint}")
    if path.endswith(".rec") and files["truth"] is None:
        return read_rec(path, options.robot)
    if path.endswith(".rec"):
        s = read_rec(path, options.robot, known=False)
    elif path.endswith(".g2o"):
        s = read_g2o(path)
    else:
        s = read_estimate(path, options.axes, options.rotation_first)
    if files["truth"] is not None:
        truth = read_g2o(files["truth"], False) if files["truth"].endswith(".g2o") else read_truth(files["truth"])
        s = _with_true_points(with_truth(s, truth, options.max_dt), truth)
    if s.truth is None:
        raise ValueError(f"{path} comes without true poses: give them by --truth")
    met = len(s.t)
    if met < 2:
        raise ValueError(f"only {met} pose of {path} has a true one; the audit of a run needs 2 or more")
    if files["map"] is not None:
        ids, points, P, places = read_map(files["map"], files["true_map"])
        s = replace(s, ids=ids, points=points, points_P=P, true_points=places)
    if files["innovations"] is not None:
        z, nis = read_innovations(files["innovations"])
        s = replace(s, z=z, nis=nis)
    return s


def _with_true_points(s, truth):
    """Landmarks of a graph beside those of the true one, where both have the same."""
    if s.points is None or truth.points is None or not len(s.points):
        return s
    places = dict(zip(truth.ids, truth.points, strict=True))
    have = [k for k, id in enumerate(s.ids) if id in places]
    if not have or s.points_P is None:
        return s
    d = s.x.dim
    at = (np.array(have)[:, None] * d + np.arange(d)).ravel()
    known = np.array([places[s.ids[k]] for k in have])
    ids = [s.ids[k] for k in have]
    return replace(s, ids=ids, points=s.points[have], points_P=s.points_P[np.ix_(at, at)], true_points=known)


def report(found):
    """Lines for the terminal."""
    s = found.summary()
    frames = sum(s["frames"])
    yield f"{len(found.runs)} run{'s' * (len(found.runs) > 1)}, {frames} poses"
    yield f"{'':<16}{'mean/dof':>10}{f'{100 * found.level:.3g} % band':>16}{'dof':>8}"
    for name, label in LABELS.items():
        part = getattr(found, name)
        if part.word != "not known":
            band = f"{part.low:.2f} to {part.high:.2f}"
            yield f"{label:<16}{part.ratio:>10.3g}{band:>16}{part.dof:>8.0f}  {part.word}"
    wanted = "  ".join(f"{100 * float(p):g} %: {100 * v:.1f}" for p, v in s["coverage"].items() if v is not None)
    if wanted:
        yield f"coverage of regions that should hold {wanted} %"
    value, band = found.whiteness
    if np.isfinite(value):
        word = "white" if found.white else "not white: the model misses something that lasts"
        yield f"innovations that follow each other correlate by {value:+.3f} (95 % band +-{band:.3f}): {word}"
    yield f"verdict ({100 * found.confidence:g} %): {found.sentence}"
    if found.pose.runs_needed is not None:
        needed, factor, power = found.pose.runs_needed, s["factor"], 100 * s["power"]
        yield f"power: by the poses {needed} such runs find a factor of {factor:g} in P with {power:g} %"
