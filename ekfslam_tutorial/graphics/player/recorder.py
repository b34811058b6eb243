"""From a snapshot to the record of a frame: what is said, and what need not be said again."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..states import TruthInMap, is_line, lmk_lines, lmk_points
from ..views import picture_half
from .coding import METRE, RADIAN, hundredths, lower_factor, pack, pack_factor, short

Array = np.ndarray

MOVED, GROWN, FINE = 0.2, 0.2, 0.01
"""A mean is written again when it has moved by so many sigmas, a covariance when a variance has changed by so much;
a standard deviation below FINE (m) counts as FINE."""


@dataclass
class Told:
    """State of what a viewer was told of a landmark: mean and covariance, and the mean as it was rounded."""

    mean: Array
    cov: Array
    x: list[int]


@dataclass
class Memory:
    """Memory of what a viewer knows already: landmarks and sensor poses by id, and the true landmarks.

    Of lines it has both ends, by (id, 0) and (id, 1).
    """

    lmks: dict[int, Told] = field(default_factory=dict)
    lines: dict[tuple[int, int], Told] = field(default_factory=dict)
    sens: dict[int, list[int]] = field(default_factory=dict)
    world: list = field(default_factory=list)
    edges: list = field(default_factory=list)


def header(snapshot) -> dict[str, Any]:
    """Return what is said once: dimension, robots, sensors."""
    return {
        "dim": int(snapshot.robs[0].motion.frame.dim),
        "robots": [{"id": int(rob.id), "name": rob.name or f"robot {rob.id}"} for rob in snapshot.robs],
        "sensors": [_sensor(sen) for sen in snapshot.sens],
    }


def _sensor(sen) -> dict[str, Any]:
    units = getattr(sen.model, "units", None) or [""] * len(sen.model.R)
    units = units[:2] if hasattr(sen.model, "segments") else units  # of the innovation, two distances
    about = {"id": int(sen.id), "robot": int(sen.robot), "name": sen.name or f"sensor {sen.id}"}
    about |= {"units": list(units), "point": not sen.model.bearing_only}
    field_of_view = {"fov": getattr(sen.model, "fov", None), "reach": getattr(sen.model, "max_range", None)}
    about |= {name: round(float(v), 4) for name, v in field_of_view.items() if v is not None and np.isfinite(v)}
    half = picture_half(sen.model)
    return about if half is None else about | {"view": [round(float(v), 4) for v in half]}


def frame_record(snapshot, events, truth: TruthInMap, memory: Memory) -> dict[str, Any]:
    """Return the record of a frame, and remember what it said.

    Parameters
    ----------
    snapshot : Snapshot
    events : list of Event
        Of this frame, and of those that were left out before it.
    truth : TruthInMap
    memory : Memory
        It is changed.
    """
    dim = snapshot.robs[0].motion.frame.dim
    frames = {rob.id: rob.frame(snapshot.map) for rob in snapshot.robs}
    true = truth.frames(snapshot)
    record = {
        "k": int(snapshot.k),
        "t": round(float(snapshot.t), 3),
        "rob": [_robot(snapshot.map, rob, frames[rob.id]) for rob in snapshot.robs],
        "true": [[int(id), *x] for id, F in true.items() if (x := pack(F.x, dim))],
        "sen": _sensors(snapshot, memory, dim),
        **_landmarks(snapshot, events, memory, dim),
        **(_lines(snapshot, truth, memory) if dim == 3 else {}),
        **_observations(snapshot, frames, dim),
        "world": _world(snapshot, truth, memory, dim),
        "note": [[e.kind, int(e.lmk)] for e in events if e.kind in ("refused", "recovery")],
    }
    return {key: value for key, value in record.items() if key in ("k", "t") or value}


def _robot(map, rob, frame) -> list[int]:
    """Return the pose and the covariance of the position; in the plane also the std of the heading."""
    d, x = frame.dim, pack(frame.x, frame.dim)
    if rob.r is None or not x:
        return [int(rob.id), *x]
    P = map.P[rob.r, rob.r]  # of a compressed map all is settled at once, for all landmarks are asked for next
    factor = pack_factor(lower_factor(P[:d, :d]))
    if d == 2 and factor:
        turn = np.sqrt(max(P[2, 2], 0.0))
        factor += pack(np.array([turn * METRE / RADIAN]), 1) or [0]
    return [int(rob.id), *x, *factor]


def _sensors(snapshot, memory, dim) -> list[list[int]]:
    """Return the poses of the sensors on their robots, where they are not what they were."""
    frames = {int(sen.id): sen.frame(snapshot.map) for sen in snapshot.sens}
    now = {id: pack(np.concatenate([F.t, F.o]), dim) for id, F in frames.items()}  # parameters are not drawn
    moved = [[id, *x] for id, x in now.items() if x and memory.sens.get(id) != x]
    memory.sens |= now
    return moved


def _landmarks(snapshot, events, memory, dim) -> dict[str, list]:
    """Return the landmarks that have changed, were deleted, and were started."""
    ids, mean, cov = lmk_points(snapshot, dim)
    ids = [int(id) for id in ids]
    lines = [int(id) for id, lmk in snapshot.lmks.items() if is_line(lmk)]
    started = {int(e.lmk) for e in events if e.kind == "initialisation"}
    deleted = {int(e.lmk) for e in events if e.kind == "deletion"}
    known = [*memory.lmks, *(id for id, end in memory.lines if not end)]
    gone = [id for id in known if id not in {*ids, *lines} or id in deleted & started]
    told = {id: memory.lmks[id] for id in ids if id in memory.lmks and id not in gone}
    moved, grown = changed(ids, mean, cov, told)
    memory.lmks, rows = {}, []
    for id, m, P, L, moves, grows in zip(ids, mean, cov, lower_factor(cov), moved, grown, strict=True):
        if moves or grows:
            x, before = pack(m, dim), told[id].x if id in told else []
            step = [a - b for a, b in zip(x, before or [0] * dim, strict=True)] if x else []
            rows.append([id, *step, *((pack_factor(L) or [None]) if x and (grows or not before) else [])])
            told[id] = Told(m, P if grows else told[id].cov, x)
        memory.lmks[id] = told[id]
    return {"lmk": rows, "gone": gone, "new": [id for id in [*ids, *lines] if id in started]}


def _lines(snapshot, truth, memory) -> dict[str, list]:
    """Return the lines of which an end has changed, both ends and their covariances; and the true edges, once."""
    ids, ends, cov = lmk_lines(snapshot)
    keys = [(int(id), i) for id in ids for i in (0, 1)]
    mean, cov, told = (
        ends.reshape(-1, 3),
        cov.reshape(-1, 3, 3),
        {k: memory.lines[k] for k in keys if k in memory.lines},
    )
    differ = np.logical_or(*changed(keys, mean, cov, told)).reshape(-1, 2).any(1)
    memory.lines, rows = told, []
    for n in np.flatnonzero(differ).tolist():
        both = slice(2 * n, 2 * n + 2)
        x, L = [pack(p, 3) for p in mean[both]], [pack_factor(L) for L in lower_factor(cov[both])]
        if all(x) and all(L):
            rows.append([keys[2 * n][0], *x[0], *x[1], *L[0], *L[1]])
            told |= {key: Told(p, P, []) for key, p, P in zip(keys[both], mean[both], cov[both], strict=True)}
    edges = [] if memory.edges else truth.segments(snapshot)
    known = [[int(id), *pack(p[0], 3), *pack(p[1], 3)] for id, p in zip(_edge_ids(snapshot), edges, strict=False)]
    memory.edges += known
    return {"lin": rows, "edge": known}


def _edge_ids(snapshot):
    return [] if snapshot.sim_lmk is None else snapshot.sim_lmk.segment_ids


def changed(ids: list, mean: Array, cov: Array, told: dict[Any, Told]) -> tuple[Array, Array]:
    """Return which means and which covariances are not what the viewer was told, up to MOVED and GROWN.

    With P0 the covariance that was told, widened by FINE, and W W' = inv(P0): the move is |W' (m - m0)|, in sigmas,
    and the growth is the spectral norm of W' (P - P0) W, relative in the variance, both the worst over all directions.
    """
    before = [told.get(id, Told(m, P, [])) for id, m, P in zip(ids, mean, cov, strict=True)]
    m0 = np.array([t.mean for t in before]).reshape(mean.shape)
    P0 = np.array([t.cov for t in before]).reshape(cov.shape)
    fresh = np.array([id not in told for id in ids], dtype=bool)
    same = np.isfinite(mean).all(-1) == np.isfinite(m0).all(-1)
    alike = np.isfinite(cov).all((-1, -2)) == np.isfinite(P0).all((-1, -2))
    with np.errstate(all="ignore"):
        D, V = np.linalg.eigh(np.where(np.isfinite(P0), (P0 + np.swapaxes(P0, -1, -2)) / 2, 0.0))
        W = V / np.sqrt(np.maximum(D, 0.0) + FINE**2)[:, None, :]
        Wt = np.swapaxes(W, -1, -2)
        move = np.linalg.norm((Wt @ (mean - m0)[..., None])[..., 0], axis=-1)
        change = Wt @ (cov - P0) @ W
        growth = np.linalg.norm(np.where(np.isfinite(change), change, 0.0), axis=(-2, -1), ord=2)
    return fresh | ~same | (move > MOVED), fresh | ~alike | (growth > GROWN)


def _observations(snapshot, frames, dim) -> dict[str, dict]:
    """Return the innovations that were used, those that were rejected, and the missed landmarks, by sensor."""
    sens, found = {sen.id: sen for sen in snapshot.sens}, {"used": {}, "rejected": {}, "missed": {}}
    for (id, lmk), obs in snapshot.obs.items():
        if lmk < 0:  # the robot's own state, no landmark
            continue
        if obs.matched and obs.z is not None:
            sen, kind = sens[id], "used" if obs.updated else "rejected"
            row = [int(lmk), hundredths(obs.md2), *_innovation(obs)]
            row += _measured(frames[sen.robot], sen, obs.y, snapshot.map, dim)
            found[kind].setdefault(str(id), []).append(row)
        elif obs.measured:
            found["missed"].setdefault(str(id), []).append(int(lmk))
    return found


def _innovation(obs) -> list[float | int | None]:
    """Return the innovation in hundredths of its standard deviations, then these."""
    std = [short(v) for v in np.sqrt(np.maximum(np.diag(obs.Z), 0.0))]
    return [*(hundredths(z / s) if s else None for z, s in zip(obs.z, std, strict=True)), *std]


def _measured(rob, sen, y, map, dim) -> list[int]:
    """Return the point that was measured, as the corrected robot sees it; nothing for a direction, or a range."""
    if sen.model.bearing_only or not hasattr(sen.model, "retro"):
        return []
    v, *_ = sen.model.retro(y)
    return pack(rob.from_frame(sen.frame(map).from_frame(v)[0])[0], dim)


def _world(snapshot, truth, memory, dim) -> list[list[int]]:
    """Return the true landmarks, if they are known and have not been told."""
    if snapshot.sim_lmk is None or memory.world:
        return []
    points = truth.points(snapshot, dim)
    memory.world = [[int(id), *pack(p, dim)] for id, p in zip(snapshot.sim_lmk.ids, points, strict=False)]
    return memory.world
