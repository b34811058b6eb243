"""What the methods of notebook 21 cost: numbers that are kept, and the time of a frame."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix, csc_matrix, eye_array
from scipy.sparse.linalg import splu

from ...analysis.fast_filter import CompressedMap, FastMap, update
from ...toolbox.clock import computing_time


def pattern(log) -> csc_matrix:
    """Where the information matrix of all poses and landmarks is not zero: ones, and a large diagonal."""
    K, pairs = log.frames, []
    for k, seen in enumerate(log.seen):
        pose = np.arange(3 * k, 3 * k + 3)
        groups = [np.arange(3 * max(k - 1, 0), 3 * k + 3)]
        groups += [np.r_[pose, 3 * K + 2 * i, 3 * K + 2 * i + 1] for i in seen]
        pairs += [np.stack(np.meshgrid(g, g), -1).reshape(-1, 2) for g in groups]
    rows, cols = np.concatenate(pairs).T
    n = 3 * K + 2 * len(log.points)
    A = coo_matrix((np.ones(len(rows)), (rows, cols)), (n, n)).tocsc()
    A = csc_matrix((np.ones_like(A.data), A.indices, A.indptr), A.shape)
    return A + n * eye_array(n, format="csc")


def numbers_kept(log):
    """How many numbers each method keeps for a log: a dictionary by name."""
    n = len(log.points)
    A, states, n_all = pattern(log), 3 + 2 * n, 3 * log.frames + 2 * n
    factor = splu(A, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    return {
        "filter: P": states**2,
        "one triangle of P": states * (states + 1) // 2,
        "smoother: A": (A.nnz + n_all) // 2,
        "smoother: factor of A": factor.L.nnz,
    }


def price(landmarks=400, seen=8, frames=20):
    """CPU time of a frame, ms, for a map that is full: corrections one by one, all at once, compressed.

    The least of `frames` frames; for the compressed filter the mean of them, with one flush at the end.
    """
    n, rng = 3 + 2 * landmarks, np.random.default_rng(23)
    B = rng.normal(size=(n, 12))
    P, H_r, H_l = B @ B.T / 12 + np.eye(n), rng.normal(size=(seen, 2, 3)), rng.normal(size=(seen, 2, 2))
    S, robot = np.eye(2), slice(0, 3)
    at = [slice(3 + 2 * i, 5 + 2 * i) for i in range(seen)]
    rows = np.array([range(r.start, r.stop) for r in at])

    def one_by_one(map):
        """One correction after the other."""
        for r, h, l in zip(at, H_r, H_l, strict=True):
            update(map, [(robot, h), (r, l)], np.zeros(2), S)

    def at_once(map):
        """One correction with all."""
        update(map, [(robot, H_r), (rows, H_l)], np.zeros((seen, 2)), S)

    def times(kind, work):
        """Seconds of each frame."""
        map = kind()
        map.add(np.zeros(n), P)
        took = []
        for _ in range(frames):
            started = computing_time()
            work(map)
            took.append(1000 * (computing_time() - started))
        started = computing_time()
        getattr(map, "flush", lambda: None)()
        return took, 1000 * (computing_time() - started)

    compressed, flush = times(CompressedMap, one_by_one)
    return {
        "one landmark after the other": min(times(FastMap, one_by_one)[0]),
        "all of a frame at once": min(times(FastMap, at_once)[0]),
        "compressed, with its flush": float(np.mean(compressed[1:])) + flush / frames,
    }
