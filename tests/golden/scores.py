"""How near one run is to another."""

from collections import Counter

import numpy as np

from ekfslam_tutorial.geometry import q2qc, q_prod


def score(run, reference):
    """Compare a run with a reference.

    Returns
    -------
    dict
        `events` : number of events of the reference.
        `in_order` : share of events that are the same, position by position.
        `per_frame` : share of events that are the same when each frame's are taken as a set.
        `births_deaths` : the same for initialisations and deletions alone, in order.
        `pose_mm`, `pose_deg` : largest difference of a robot's pose in any frame.
        `landmark_sigma`, `landmark_sigma_median` : difference of each Euclidean landmark at the end from that of the
        reference, over the reference's sigma: the largest of its coordinates; infinite if another set is left,
        None where the reference does not hold them.
    """
    life = [events[np.isin(events[:, 0], (3, 4))] for events in (run.events, reference.events)]
    sigmas = None if reference.points is None else landmark_sigmas(run, reference)
    return {
        "events": len(reference.events),
        "in_order": share_in_order(run.events, reference.events),
        "per_frame": share_per_frame(run.events, reference.events),
        "births_deaths": share_in_order(*life),
        "pose_mm": 1e3 * float(np.linalg.norm(run.poses[..., :3] - reference.poses[..., :3], axis=-1).max()),
        "pose_deg": float(np.degrees(angles(run.poses[..., 3:], reference.poses[..., 3:]).max())),
        "landmark_sigma": None if sigmas is None else float(np.max(sigmas, initial=0.0)),
        "landmark_sigma_median": None if sigmas is None else float(np.median(sigmas)) if len(sigmas) else 0.0,
    }


def share_in_order(a, b):
    """Share of rows that are equal, position by position; 1 if there are none."""
    k, n = min(len(a), len(b)), max(len(a), len(b))
    return float((a[:k] == b[:k]).all(-1).sum() / n) if n else 1.0


def share_per_frame(a, b):
    """Share of rows that both have, whatever their order within the frame."""
    n = max(len(a), len(b))
    both = Counter(map(tuple, a.tolist())) & Counter(map(tuple, b.tolist()))
    return both.total() / n if n else 1.0


def angles(q1, q2):
    """Angle between orientations, radians, without the loss of digits of an arc cosine near zero."""
    dq = q_prod(q2qc(q1)[0], q2)[0]
    return 2 * np.arctan2(np.linalg.norm(dq[..., 1:], axis=-1), np.abs(dq[..., 0]))


def landmark_sigmas(run, reference):
    """Differences of the landmarks over the reference's sigmas; infinite if one run has others than the other."""
    if run.points.keys() != reference.points.keys():
        return np.array([np.inf])
    return np.array([sigmas(run.points[id] - p, reference.covariances[id]) for id, p in reference.points.items()])


def sigmas(d, P):
    """Largest coordinate of a difference, each over its own sigma; zero over zero is zero."""
    sigma = np.sqrt(np.diag(P))
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(d == 0, 0.0, np.abs(d) / sigma).max()
