"""EKF-SLAM from its steps: a loop of your own round move, correct_known_lmks and init_new_lmks.

Nothing of the toolbox is used, so any log, robot or simulator can feed it.

It prints

    25 landmarks, the worst is off by 0.13 m
    robot off by 0.09 m after 40 m
"""

from types import SimpleNamespace

import numpy as np

from ekfslam_tutorial.geometry import Frame2
from ekfslam_tutorial.models.motion import Unicycle
from ekfslam_tutorial.models.sensors import RangeBearing
from ekfslam_tutorial.slam import Options, Rob, Sen, correct_known_lmks, init_new_lmks, move, new_map

rng = np.random.default_rng(2)
points = rng.uniform(-6, 6, (25, 2))
U, dt = np.diag([0.05, np.radians(2)]) ** 2, 0.2

map, lmks, obs, options = new_map(), {}, {}, Options()
rob = Rob(1, Unicycle(), sensors=[1], r=map.add(np.array([0.0, -4.0, 0.0]), np.zeros((3, 3))))
sen = Sen(1, 1, RangeBearing(0.1, np.radians(1), max_range=5.0), Frame2, x=np.zeros(3))
true = np.array([0.0, -4.0, 0.0])

for _ in range(200):
    u = np.array([1.0, 0.25])
    true = rob.motion.move(true, u, dt)[0]
    rob.u, rob.U = u + rng.multivariate_normal(np.zeros(2), U), U
    y = sen.model.project(Frame2(true).to_frame(points)[0])[0]
    seen = np.flatnonzero(y[:, 0] < sen.model.max_range)
    y = y[seen] + rng.multivariate_normal(np.zeros(2), sen.model.R, len(seen))
    raw = SimpleNamespace(ids=seen, y=y, R=None)  # what a detector would hand over

    move(map, rob, dt)
    _, new = correct_known_lmks(map, rob, sen, lmks, obs, raw, options)
    init_new_lmks(map, rob, sen, lmks, raw, new, options)

worst = max(np.linalg.norm(lmk.point(map)[0] - points[id]) for id, lmk in lmks.items())
print(f"{len(lmks)} landmarks, the worst is off by {worst:.2f} m")
print(f"robot off by {np.linalg.norm(rob.frame(map).t - true[:2]):.2f} m after 40 m")
