"""An IMU alone: what white noise, a bias and a tilt cost after one, ten and sixty seconds.

It prints

    noise of a data sheet                     0.001 m after 1 s   0.25 m after 10 s    29.8 m after 60 s
    and a gyro bias of 0.01 deg/s             0.001 m after 1 s   0.38 m after 10 s    68.4 m after 60 s
    and an accelerometer bias of 0.05 m/s2    0.025 m after 1 s   2.51 m after 10 s    94.8 m after 60 s
    and a tilt of 0.1 deg                     0.009 m after 1 s   0.89 m after 10 s    42.8 m after 60 s
"""

import numpy as np

from ekfslam_tutorial.ekf import Map, predict
from ekfslam_tutorial.geometry import v2q
from ekfslam_tutorial.models.motion import Imu

imu, dt = Imu(), 0.01
still = np.concatenate([[0.0, 0.0, 0.0], [0.0, 0.0, 9.81], np.zeros(6)])  # what an IMU at rest measures


def spread(gyro_bias=0.0, acc_bias=0.0, tilt=0.0):
    """1 sigma of the horizontal position after 1, 10 and 60 s, from noise and from a start that is known so well."""
    _, Q_v = v2q(np.zeros(3))
    P = np.zeros((16, 16))
    P[3:7, 3:7] = Q_v @ Q_v.T * tilt**2
    P[10:13, 10:13], P[13:, 13:] = np.eye(3) * gyro_bias**2, np.eye(3) * acc_bias**2
    map, x = Map(), np.zeros(16)
    x[3] = 1.0
    r, U, found = map.add(x, P), imu.noise(dt), []
    for k in range(1, 6001):
        predict(map, r, *imu.move(map.state(r), still, dt), U)
        if k in (100, 1000, 6000):
            found.append(np.sqrt(map.block(r)[0, 0]))
    return found


for name, start in (
    ("noise of a data sheet", {}),
    ("and a gyro bias of 0.01 deg/s", {"gyro_bias": np.radians(0.01)}),
    ("and an accelerometer bias of 0.05 m/s2", {"acc_bias": 0.05}),
    ("and a tilt of 0.1 deg", {"tilt": np.radians(0.1)}),
):
    one, ten, sixty = spread(**start)
    print(f"{name:40} {one:6.3f} m after 1 s {ten:6.2f} m after 10 s {sixty:7.1f} m after 60 s")
