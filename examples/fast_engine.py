"""Two engines, one estimate: the core as it is written, and the same steps made quick.

It prints

    the engine 'fast': 1187 events, 139 numbers in the map
    the engine 'plain': 1187 events, 139 numbers in the map
    the largest difference is below 1e-9: True
"""

import numpy as np

from ekfslam_tutorial.cli.files import find_scenario
from ekfslam_tutorial.toolbox import UserData, universal_slam

data = UserData.from_toml(find_scenario("cloister_idp"), {"time.last": 40})
ends = {}
for engine in ("fast", "plain"):
    run = universal_slam(data, engine=engine)
    events = 0
    for now in run:
        events += len(now.events)
    ends[engine] = now.map.x[now.map.used].copy()
    print(f"the engine {run.engine!r}: {events} events, {now.map.n} numbers in the map")

largest = np.abs(ends["fast"] - ends["plain"]).max()
print(f"the largest difference is below 1e-9: {largest < 1e-9}")
