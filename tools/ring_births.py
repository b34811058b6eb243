"""Births from one range, many of them: is the right hypothesis kept?

    python tools/ring_births.py              # 1,000 births
    python tools/ring_births.py --rounds 2   # 50

Of the 25 births of a round 20 are in the plane, four in the plane with a bias and a scale drawn from what the filter is
told of them, and one is in space. Places, paths and noise are drawn anew for each. A birth is right if the truth is
within 5 sigma (squared Mahalanobis distance below 25) of the landmark that the ring has become, or, where it is not
decided yet, of one of the hypotheses that are left. Of 1,000 honest Gaussians in the plane none is further away, with
a probability of 99.6 %.
"""

import argparse
from dataclasses import replace

import numpy as np

from ekfslam_tutorial.models.landmarks import Beacon
from ekfslam_tutorial.models.motion import Odometry2, Odometry3
from ekfslam_tutorial.models.sensors import Range
from ekfslam_tutorial.toolbox import Landmark, Robot, Sensor, Time, UserData, World, universal_slam
from ekfslam_tutorial.toolbox.recordings import Recorder

RIGHT = 25.0
"""Squared Mahalanobis distance from the truth up to which a birth is right."""

FAULTS = Beacon(bias_std=0.5, scale_std=0.05)


def plane(rng, kind=None):
    """A robot in the plane that drives in a bow, and a beacon."""
    turn = rng.choice([-1, 1]) * rng.uniform(2.0, 6.0)
    control, noise = {"dx": [0.5, 0.0], "da_deg": turn}, {"dx": [0.01, 0.005], "da_deg": 0.1}
    return UserData(
        robots=[Robot(motion=Odometry2(), position=[0, -4], control=control, control_std=noise)],
        sensors=[Sensor(model=Range(range_std=0.1))],
        world=World.of(rng.uniform(-15.0, 15.0, (1, 2))),
        time=Time(last=50),
        landmark=Landmark(model=kind, hypotheses=64),
    )


def space(rng):
    """A robot in space on a screw, which has no mirror, and a beacon."""
    control = {"dx": [0.3, 0, 0.1], "da_deg": [3, 0, 9]}
    robot = Robot(motion=Odometry3(), position=[0, 0, 0], control=control, control_std={"dx": 0.005, "da_deg": 0.05})
    return UserData(
        robots=[robot],
        sensors=[Sensor(model=Range(range_std=0.1, dim=3))],
        world=World.of(rng.uniform(-5.0, 5.0, (1, 3))),
        time=Time(last=60),
        landmark=Landmark(hypotheses=60),
    )


def with_faults(rng, data, seed):
    """The recording of a run with one beacon, whose ranges are wrong by a bias and a scale.

    From so near that the bias would make the range negative, nothing is measured.
    """
    recorder = Recorder()
    for now in universal_slam(data, seed=seed):
        recorder.add(now)
    log = recorder.recording("faults")
    raw, bias, scale = log.raw[1], *rng.normal(0, [FAULTS.bias_std, FAULTS.scale_std])
    y = (1 + scale) * raw.y + bias
    seen = y[:, 0] > 0
    offsets = np.concatenate([[0], np.cumsum(seen)])[raw.offsets]
    return replace(log, raw={1: replace(raw, offsets=offsets, ids=raw.ids[seen], y=y[seen])})


def births(round):
    """The 25 births of a round.

    Parameters
    ----------
    round : int
        Seeds places, paths and noise.

    Returns
    -------
    list of tuple of str, float, bool
        Kind, squared Mahalanobis distance of the truth, and whether the ring is decided.
    """
    rng, found = np.random.default_rng(round), []
    for kind in ["plane"] * 20 + ["faults"] * 4 + ["space"]:
        data, seed = space(rng) if kind == "space" else plane(rng, FAULTS if kind == "faults" else None), len(found)
        log = with_faults(rng, data, (round, seed)) if kind == "faults" else None
        *_, now = universal_slam(data, log, seed=(round, seed))
        found.append((kind, *distance(now, 1, now.sim_lmk.points[0])))
    return found


def distance(now, id, p):
    """Squared Mahalanobis distance from the landmark, or from the nearest hypothesis; and whether it is decided."""
    m, P = (a[None] for a in now.lmks[id].point(now.map)) if id in now.lmks else now.rings[id].points(now.map)
    d = m - p
    return np.einsum("hi,hi->h", d, np.linalg.solve(P, d[..., None])[..., 0]).min(), id in now.lmks


def main():
    """Run as many rounds as asked for and say how many births were right."""
    parser = argparse.ArgumentParser(description="Births from one range: is the right hypothesis kept?")
    parser.add_argument("--rounds", type=int, default=40, help="rounds of 25 births")
    found = []
    for round in range(parser.parse_args().rounds):
        found += births(round)
        for kind in ("plane", "faults", "space"):
            d2, done = np.array([(d, done) for name, d, done in found if name == kind]).T
            said = f"{kind} {(d2 < RIGHT).sum()} of {len(d2)}, decided {int(done.sum())}, d2 mean {d2.mean():.2f}"
            print(f"{said} max {d2.max():.1f}", end="; ")
        print(f"right: {sum(d < RIGHT for _, d, _ in found)} of {len(found)}", flush=True)


if __name__ == "__main__":
    main()
