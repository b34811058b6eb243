"""Monte Carlo: two hundred runs at once, errors and what the filter expects of them.

It prints

     5.0 s: position RMSE 11.1 cm, expected 10.9 cm
    15.0 s: position RMSE 18.9 cm, expected 18.1 cm
    25.0 s: position RMSE  6.3 cm, expected  6.5 cm
    the worst run has the seed 3917292508507395841
"""

from ekfslam_tutorial.analysis import monte_carlo
from ekfslam_tutorial.cli.files import find_scenario
from ekfslam_tutorial.toolbox import UserData

data = UserData.from_toml(find_scenario("range_bearing_2d"), {"time.last": 50})
result = monte_carlo(data, 200)
rmse, expected = result.over_time("position")[:, 0], result.over_time("position_std")[:, 0]
for k in (9, 29, 49):
    print(f"{result.t[k]:4.1f} s: position RMSE {100 * rmse[k]:4.1f} cm, expected {100 * expected[k]:4.1f} cm")
print(f"the worst run has the seed {result.seeds[result.position[:, -1, 0].argmax()]}")
