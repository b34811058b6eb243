"""Records of function calls: reading one, comparing one.

A record is a dict: `fn`, `args` and `outs`, each a list of {"name", "type", "shape", "value" or "fields"} in the order
of the recorded program's calls. Vectors are columns there and 1-D arrays here.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ekfslam_tutorial.geometry import Frame3

RTOL = 1e-9  # relative to the largest entry of each output
ATOL = 1e-12  # for outputs that are zero but for rounding errors
SINGULAR = 1e12  # an output this large comes from a singular input: its digits mean nothing

DEGENERATE = "degenerate: singular input"
APPROXIMATE = "the recorded Jacobian is documented as approximate"
NOT_HERE = "not part of this package"


@dataclass
class Tangent:
    """A Jacobian that is compared in the tangent space of the unit sphere.

    `at` lists pairs (first column, quaternion): off the sphere a derivative with respect to a unit quaternion is a
    matter of taste, so its four columns are compared only along directions that keep the norm.
    """

    J: Any
    at: list

    def of(self, J):
        """J with those columns projected."""
        J = np.array(J, float)
        for first, q in self.at:
            J[:, first : first + 4] -= np.outer(J[:, first : first + 4] @ q, q) / (q @ q)
        return J


@dataclass
class EitherSign:
    """A quaternion that another branch of the same formula gives with the other sign: q and -q turn alike."""

    q: Any


@dataclass
class Masked:
    """An output of which some rows are not compared, and why."""

    J: Any
    rows: list
    reason: str


class Graph(tuple):
    """Outputs to compare with `outs_graph`: of two recorded versions the one that is exact."""


@dataclass
class Skip:
    """An output, or a whole record, that is not compared, and why."""

    reason: str


def number(x):
    """A recorded number: null is NaN, "Inf" and "-Inf" are infinite."""
    return np.nan if x is None else float(x)


def argument(a):
    """A recorded argument as this package takes it: a frame, a string, a float, a vector or a matrix."""
    if a["type"] == "frame":
        return Frame3(matrix(a)[:, 0])
    if a["type"] == "string":
        return a["value"]
    if a["type"] == "struct":
        return {name: argument(field) for name, field in a["fields"].items()}
    m = matrix(a)
    if m.shape == (1, 1):
        return float(m[0, 0])
    return m[:, 0] if m.shape[1] == 1 else m.ravel() if 0 in m.shape else m


def matrix(a):
    """A recorded matrix as an array of its recorded shape."""
    flat = [number(x) for row in a["value"] for x in row]
    return np.array(flat, float).reshape(a["shape"])


def singular(outs):
    """Whether an output says that the input was singular: not a number, in the value itself, or beyond SINGULAR."""
    value, *rest = [out for out in outs if out["type"] == "matrix"] or [None]
    if value is not None and not np.isfinite(matrix(value)).all():
        return True
    return any(np.nanmax(np.abs(matrix(out)), initial=0) > SINGULAR for out in [value, *rest] if out is not None)


def difference(ours, out):
    """Largest difference of one output over its tolerance (at most 1 passes), or a Skip."""
    if isinstance(ours, Skip):
        return ours
    if out["type"] == "frame":
        return max(difference(getattr(ours, name), field) for name, field in out["fields"].items())
    want = matrix(out)
    if want.size == 0:
        return 0.0
    if not np.isfinite(want).all():
        return Skip(DEGENERATE)
    if isinstance(ours, EitherSign):
        return min(error(ours.q, want), error(-ours.q, want))
    if isinstance(ours, Masked):
        keep = [i for i in range(len(want)) if i not in ours.rows]
        return error(np.asarray(ours.J)[keep], want[keep])
    if isinstance(ours, Tangent):
        return error(ours.of(ours.J), ours.of(want))
    return error(ours, want)


def error(ours, want):
    """Largest difference over the tolerance; infinite for a wrong shape or a number that is not one."""
    ours = np.asarray(ours, float)
    if ours.size != want.size:
        return np.inf
    worst = np.abs(ours.reshape(want.shape) - want).max() / (RTOL * np.abs(want).max() + ATOL)
    return float(worst) if np.isfinite(worst) else np.inf


def compare(record, adapters):
    """Compare one record with this package.

    Parameters
    ----------
    record : dict
    adapters : dict of str to callable
        Recorded function name to a function of (arguments, record) that gives the outputs here.

    Returns
    -------
    dict
        Either `skip`, a reason, or `worst`, the largest difference over its tolerance; and `skipped_outputs`.
    """
    adapter = adapters.get(record["fn"])
    if adapter is None:
        return {"skip": NOT_HERE}
    if record["branch"] == "none" or not record.get("outs"):
        return {"skip": "the recorded program cannot run it"}
    if record.get("degenerate") and singular(record["outs"]):
        return {"skip": DEGENERATE}
    with np.errstate(all="ignore"):
        ours = adapter(record, *[argument(a) for a in record["args"]])
    if isinstance(ours, Skip):
        return {"skip": ours.reason}
    outs = record["outs_graph" if isinstance(ours, Graph) else "outs"]
    if len(ours) < len(outs):
        return {"worst": np.inf, "skipped_outputs": [], "why": f"{len(ours)} outputs for {len(outs)}"}
    results = {out["name"]: difference(o, out) for o, out in zip(ours, outs, strict=False)}
    skipped = [d.reason for d in results.values() if isinstance(d, Skip)]
    skipped += [o.reason for o in ours if isinstance(o, Masked)]
    errors = {name: d for name, d in results.items() if not isinstance(d, Skip)}
    if not errors:
        return {"skip": skipped[0]}
    name = max(errors, key=lambda n: errors[n])
    return {"worst": errors[name], "skipped_outputs": skipped, "why": name}
