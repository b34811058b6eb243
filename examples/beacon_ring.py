"""Where is a beacon that tells its range and nothing else? A ring of hypotheses, which dies out to one.

On a straight way the beacon and its mirror image explain each range alike, so both stay.

It prints

    straight:
      frame 1: 29 hypotheses, 3% at (10.8, 1.1), 3% at (10.3, 3.3)
      frame 4: 9 hypotheses, 23% at (9.4, 5.4), 22% at (9.4, -5.4)
      frame 40: 2 hypotheses, 52% at (9.1, -6.0), 48% at (9.0, 6.0)
    curved:
      frame 1: 29 hypotheses, 3% at (10.8, 1.5), 3% at (10.2, 3.7)
      frame 4: 9 hypotheses, 23% at (9.3, 5.6), 16% at (10.3, 3.8)
      frame 40: a landmark, 0.04 m off, sigma [0.06 0.05] m
"""

import numpy as np

from ekfslam_tutorial.models.sensors import Range
from ekfslam_tutorial.toolbox import Landmark, Robot, Sensor, Time, UserData, World, universal_slam

BEACON = np.array([9.0, 6.0])


def scenario(turn_deg):
    """Twenty metres along the x axis, or along a curve."""
    control = {"dx": [0.5, 0], "da_deg": turn_deg}
    return UserData(
        robots=[Robot(position=[0, 0], control=control, control_std={"dx": [0.01, 0.005], "da_deg": 0.1})],
        sensors=[Sensor(model=Range(range_std=0.1))],
        world=World.of([BEACON]),
        time=Time(last=40),
        landmark=Landmark(hypotheses=64),
    )


for way, turn_deg in (("straight", 0.0), ("curved", 2.0)):
    print(f"{way}:")
    for now in universal_slam(scenario(turn_deg), seed=2):
        if now.k in (1, 4, 40):
            ring = now.rings.get(1)
            if ring is not None:
                p, _ = ring.points(now.map)
                best = np.argsort(-ring.w)[:2]
                places = ", ".join(f"{ring.w[h]:.0%} at ({p[h, 0]:.1f}, {p[h, 1]:.1f})" for h in best)
                print(f"  frame {now.k}: {len(ring.w)} hypotheses, {places}")
            else:
                p, P = now.lmks[1].point(now.map)
                off = np.linalg.norm(p - BEACON)
                print(f"  frame {now.k}: a landmark, {off:.2f} m off, sigma {np.sqrt(np.diag(P)).round(2)} m")
