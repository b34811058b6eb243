"""Short runs of the real main loop for the figures to show."""

import copy

import matplotlib.pyplot as plt
import pytest

from ekfslam_tutorial.toolbox import UserData, universal_slam

RANGE_BEARING = dict(
    seed=2,
    time=dict(dt=0.5, last=40),
    world=dict(type="lecture"),
    robot=[dict(motion="odometry2", position=[0, -4], dx=[0.25, 0], da_deg=3.4, dx_std=0.02, da_std_deg=0.5)],
    sensor=[dict(robot=1, type="range_bearing", range_std=0.1, bearing_std_deg=1.5, max_range=5, fov_deg=240)],
    options=dict(md2_threshold=9.2),
)

_DOWN_FORWARD = [-90, 0, -90]  # camera axes on a robot: z forward, y down

CAMERAS = dict(
    seed=1,
    time=dict(dt=0.1, last=12),
    world=dict(type="cloister"),
    robot=[
        dict(id=1, name="ann", motion="odometry3", position=[0, -5, 0], dx=[0.08, 0, 0], da_deg=[0, 0, 0.9]),
        dict(id=2, name="bob", motion="odometry3", position=[3, -5, 0], dx=[0.08, 0, 0], da_deg=[0, 0, 0.9]),
    ],
    sensor=[
        dict(id=1, robot=1, type="pin_hole", position=[0, 0, 0.6], orientation_deg=_DOWN_FORWARD),
        dict(id=2, robot=2, type="pin_hole_depth", position=[0, 0, 0.6], orientation_deg=_DOWN_FORWARD),
    ],
    landmark=dict(type="idp_pnt"),
    options=dict(n_inits=[10, 2], n_updates=8, md2_threshold=9.0),
)
for robot in CAMERAS["robot"]:
    robot.update(dx_std=0.005, da_std_deg=0.05)


@pytest.fixture
def run():
    """Return a function that starts a run: `run(flat=True, robot_1_key=...)`."""

    def start(flat, **changes):
        table = copy.deepcopy(RANGE_BEARING if flat else CAMERAS)
        return universal_slam(UserData.from_dict(table, changes))

    return start


@pytest.fixture(autouse=True)
def close_figures():
    yield
    plt.close("all")
