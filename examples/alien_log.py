"""A log that nobody has seen: degrees, milliseconds, millimetres, names for landmarks. `convert` says what it sees.

It prints

    w: deg/s: up to 17.9
    range: mm: up to 4.82e+03; length_unit = m says otherwise
    bearing: deg: up to 175
    6 different ids, each 16 to 44 times
    6 landmarks, robot off by 0.15 m
"""

import tempfile
from pathlib import Path

import numpy as np

from ekfslam_tutorial.datasets.foreign import convert
from ekfslam_tutorial.toolbox import UserData, universal_slam

rng, trees = np.random.default_rng(2), np.random.default_rng(3).uniform(-4, 6, (6, 2))
x, lines = np.zeros(3), ["Clock (ms);v;w;tree;dist;angle"]
for k in range(1, 301):
    x = x + 0.1 * np.array([np.cos(x[2]), np.sin(x[2]), 0.3])
    lines.append(f"{100 * k};{1 + rng.normal(0, 0.03):.3f};{np.degrees(0.3) + rng.normal(0, 0.5):.2f};;;")
    for name, way in zip("ABCDEF", trees - x[:2], strict=True):
        r, b = np.hypot(*way), np.degrees(np.arctan2(way[1], way[0]) - x[2])
        if k % 5 == 0 and r < 5:
            r, b = 1000 * r + rng.normal(0, 40), b + rng.normal(0, 0.6)
            lines.append(f"{100 * k};;;{name};{r:.0f};{(b + 180) % 360 - 180:.1f}")

with tempfile.TemporaryDirectory() as folder:
    log = Path(folder) / "orchard.csv"
    log.write_text("\n".join(lines))
    done = convert(log, {"scan": {"id": "tree"}})

print("\n".join(line.strip() for line in done.said if " deg" in line or " mm" in line or "different ids" in line))
for now in universal_slam(UserData.from_dict(done.scenario), done.recording):
    pass
error = np.linalg.norm(now.robs[0].frame(now.map).t - x[:2])
print(f"{len(now.lmks)} landmarks, robot off by {error:.2f} m")
