"""How many robots of real logs would be honest if the filter were? Copies of the logs whose noise is as it is told.

    python tools/honest_copies.py                     # MRCLAM 7 and 9, each robot alone, 20 copies: ten minutes
    python tools/honest_copies.py --copies 5 --sets 9

The filter runs on a real log. Its path and its landmarks are the truth of the copies: controls, and measurements of the
same landmarks at the same instants, are simulated with white noise of the covariances that the filter is told. It
runs on each copy, with the truth known where it is known of the real robot, and not elsewhere. What it is told is
true, so its NEES differs from 1 only by chance, by what its equations leave out, and by how few true poses there are.
"""

import argparse
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from ekfslam_tutorial.analysis import History
from ekfslam_tutorial.datasets import prepare
from ekfslam_tutorial.geometry import Frame2, wrap
from ekfslam_tutorial.models import observe
from ekfslam_tutorial.models.landmarks import EucPnt
from ekfslam_tutorial.simulation import SimLmk
from ekfslam_tutorial.toolbox import RawLog, UserData, universal_slam

BAND = 0.5, 1.7
"""NEES per degree of freedom of a robot, as it is asked of real ones."""
SCENARIO = Path(__file__).parents[1] / "data" / "scenarios" / "mrclam_single.toml"


def real(number, robot):
    """The scenario of one robot of a set, and its log."""
    changes = {"data.set": number, "data.robots": [robot], "options.error": "invariant"}
    return prepare(UserData.from_toml(SCENARIO, changes))


def judged(data, log):
    """NEES per degree of freedom of a run; its poses; its landmarks at the end, by id."""
    history, poses, s = History(gauge="free"), [], None
    for s in universal_slam(data, log):
        history.add(s)
        poses.append(s.robs[0].state(s.map))
    lmks = {} if s is None else {id: s.map.state(lmk.r) for id, lmk in s.lmks.items()}
    return history.summary()["nees_per_dof"], np.array(poses), lmks


def copies(data, log, poses, points, n, rng):
    """Logs of the same path among the same landmarks, with other noise: white, and as large as the filter is told."""
    (robot,), (sensor,) = log.robots, log.raw
    controls, raw, model = log.robots[robot], log.raw[sensor], data.sensors[0].model
    steps = np.array([controls.u[0], *(seen_from(a, b) for a, b in pairwise(poses))])
    frame, known = np.repeat(np.arange(len(log)), np.diff(raw.offsets)), np.isin(raw.ids, list(points))
    offsets = np.concatenate([[0], np.cumsum(np.bincount(frame[known], minlength=len(log)))])
    ids, R, frame = raw.ids[known], raw.R[known], frame[known]
    e = np.array([expected(poses[k], points[id], model) for k, id in zip(frame, ids.tolist(), strict=True)])
    truth = np.where(np.isnan(log.truth[robot]), np.nan, poses)
    landmarks = SimLmk(np.array(sorted(points)), np.array([points[id] for id in sorted(points)]))
    for _ in range(n):
        u, y = steps + white(controls.U, rng), e + white(R, rng)
        y[:, 1] = wrap(y[:, 1])
        yield replace(
            log,
            robots={robot: replace(controls, u=u)},
            raw={sensor: RawLog(sensor, offsets, ids, y, R)},
            truth={robot: truth},
            landmarks=landmarks,
        )


def seen_from(a, b):
    """Pose b as it is seen from pose a."""
    step = Frame2(a).to_frame(b[:2])[0]
    return np.array([*step, wrap(b[2] - a[2])])


def expected(pose, point, model):
    """Range and bearing of a landmark; the camera stands where the robot does."""
    return observe(Frame2(pose), Frame2(np.zeros(3)), model, EucPnt(2), point)[0]


def white(covariances, rng):
    """Noise of these covariances, (n, m, m), which may be singular: shape (n, m)."""
    w, V = np.linalg.eigh(covariances)
    return np.einsum("nij,nj->ni", V, np.sqrt(np.maximum(w, 0)) * rng.standard_normal(w.shape))


def study(number, robot, n, seed=1):
    """NEES per degree of freedom of the real log, how many poses of it are known, and the NEES of n copies, (n,)."""
    data, log = real(number, robot)
    assert log is not None, "the scenario has no log"
    nees, poses, points = judged(data, log)
    known = int(np.isfinite(log.truth[robot][:, 0]).sum())
    rng = np.random.default_rng([seed, number, robot])
    return nees, known, np.array([judged(data, copy)[0] for copy in copies(data, log, poses, points, n, rng)])


def in_band(nees):
    """Return True for each NEES that is in the band."""
    return (nees > BAND[0]) & (nees < BAND[1])


def how_many(shares):
    """Chance that 0, 1, 2, ... of some independent things happen, of each of which the chance is given."""
    chance = np.ones(1)
    for share in shares:
        chance = np.convolve(chance, [1 - share, share])
    return chance


def main():
    """Print a row for each robot, and how often so many of all robots of one round of copies are in the band."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--copies", type=int, default=20)
    parser.add_argument("--sets", type=int, nargs="+", default=[7, 9])
    options = parser.parse_args()
    everyone = [(number, robot) for number in options.sets for robot in range(1, 6)]
    print(f"{'set':>4s} {'robot':>6s} {'true poses':>11s} {'real log':>9s}   copies: mean, share in the band")
    shares = []
    for number, robot in everyone:
        nees, known, of_copies = study(number, robot, options.copies)
        shares.append(in_band(of_copies).mean())
        print(f"{number:4d} {robot:6d} {known:11d} {nees:9.2f}   {of_copies.mean():.2f}, {shares[-1]:.0%}", flush=True)
    print(
        f"of {len(shares)} robots that are honest {sum(shares):.1f} have a NEES in {BAND[0]} to {BAND[1]}, by chance:"
    )
    chance = how_many(shares)
    for least in range(len(shares) - 2, len(shares) + 1):
        print(f"at least {least}: {chance[least:].sum():.0%}")


if __name__ == "__main__":
    main()
