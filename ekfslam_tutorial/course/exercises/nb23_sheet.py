"""Exercise 23.2: from a data sheet to the noise of one step."""

import numpy as np

from ..table import table


def sheet_noise(arw, density, gyro_walk, acc_walk, dt):
    """Covariance U of one step of an IMU, from the numbers of its data sheet.

    arw: angular random walk of the gyrometer, deg / sqrt(h): by so many degrees the angle is off after an hour (1
    sigma). density: noise density of the accelerometer, micro-g / sqrt(Hz); 1 g is 9.80665 m/s^2. gyro_walk, acc_walk:
    random walks of the biases: by so much they have changed after a second, rad/s and m/s^2 (1 sigma).
    dt: seconds. What an IMU measures in a step is a mean over dt: its variance is n^2 / dt, with n in rad/s / sqrt(Hz)
    or m/s^2 / sqrt(Hz). Note that rad/s / sqrt(Hz) is rad / sqrt(s).
    Return U, shape (12, 12): the covariance of u = [w, a, db_w, db_a], in rad and m and s; db are the steps of the
    biases in dt. All entries are independent, and the three axes alike.
    """
    gyro = np.radians(arw) / 60
    acc = density * 1e-6 * 9.80665
    return np.diag(np.repeat([gyro**2 / dt, acc**2 / dt, gyro_walk**2 * dt, acc_walk**2 * dt], 3))


exercise = table(
    "23.2 From the data sheet to U",
    sheet_noise,
    hints=(
        "Two conversions first. deg / sqrt(h): degrees to radians, and the root of an hour to the root of a second. Micro-g: a millionth of 9.80665 m/s^2.",
        "sqrt(h) = sqrt(3600 s) = 60 sqrt(s). White noise: a longer mean is better, variance n^2 / dt. A random walk: longer steps are larger, variance walk^2 dt.",
        "U = np.diag(np.repeat([gyro**2 / dt, acc**2 / dt, gyro_walk**2 * dt, acc_walk**2 * dt], 3)).",
    ),
    returns="U",
    cases={
        "any": lambda rng: [
            tuple(float(v) for v in (rng.uniform(0.05, 3), rng.uniform(50, 900), *rng.uniform(1e-3, 4e-2, 2), dt))
            for dt in (0.005, 0.01, 0.3)
        ],
        "one second": lambda rng: [(0.6, 200.0, 0.002, 0.03, 1.0)],
        "one of them": lambda rng: [
            tuple(v if j == i else 0.0 for j, v in enumerate((0.6, 200.0, 0.002, 0.03))) + (0.01,) for i in range(4)
        ],
    },
    checks="""
    gyrometer in one second     | U[:3, :3]   | one second  | The three variances of w come first in U, in rad and s. With deg / sqrt(h): degrees to radians, and sqrt(h) = 60 sqrt(s). A variance is a square.
    accelerometer in one second | U[3:6, 3:6] | one second  | The three variances of a. Micro-g: 1e-6 times 9.80665 m/s^2. A variance is a square.
    walks in one second         | U[6:, 6:]   | one second  | The walks are given in SI units already, for one second: their squares are the variances, three for db_w, then three for db_a.
    each has its place          | U           | one of them | One noise at a time, the others are zero, and dt = 0.01. u = [w, a, db_w, db_a]: three variances each, in this order, n^2 / dt for w and a, walk^2 dt for db_w and db_a.
    any dt                      | U           | any         | White noise of a mean: n^2 / dt. A random walk: walk^2 dt.
    """,
    wrong="""
    3600 for 60 | np.radians(arw) / 60 -> np.radians(arw) / 3600 | sqrt(h), not h: the root of 3600 s is 60 sqrt(s).
    hours forgotten | np.radians(arw) / 60 -> np.radians(arw) | Per root of an *hour*: sqrt(h) = 60 sqrt(s).
    times 60 | np.radians(arw) / 60 -> np.radians(arw) * 60 | In a second an angle walks less than in an hour: divide by 60.
    degrees | np.radians(arw) / 60 -> arw / 60 | U is in radians: np.radians(arw).
    micro forgotten | density * 1e-6 * 9.80665 -> density * 9.80665 | A micro-g is a millionth of g: 1e-6.
    milli for micro | density * 1e-6 -> density * 1e-3 | Micro is 1e-6, and it is squared with the rest: (density * 1e-6 * 9.80665)^2. Yours comes out as with 1e-3, milli, or with 1e-6 outside of the square.
    g forgotten | density * 1e-6 * 9.80665 -> density * 1e-6 | In units of g: times 9.80665 m/s^2.
    the same in each step | gyro**2 / dt, acc**2 / dt -> gyro**2, acc**2 | A mean over a longer time is better: white noise has the variance n^2 / dt.
    white noise times dt | gyro**2 / dt, acc**2 / dt -> gyro**2 * dt, acc**2 * dt | A mean over a *shorter* time is noisier: n^2 / dt, not times dt.
    std of a mean | gyro**2 / dt, acc**2 / dt -> gyro**2 / dt**2, acc**2 / dt**2 | The standard deviation goes with 1 / sqrt(dt), the variance with 1 / dt.
    walks divided by dt | gyro_walk**2 * dt, acc_walk**2 * dt -> gyro_walk**2 / dt, acc_walk**2 / dt | A random walk grows with time: walk^2 dt.
    walks not squared | gyro_walk**2 * dt, acc_walk**2 * dt -> gyro_walk * dt, acc_walk * dt | The walks are standard deviations: a covariance holds their squares, walk^2 dt.
    walks without dt | gyro_walk**2 * dt, acc_walk**2 * dt -> gyro_walk**2, acc_walk**2 | A walk is given for a second: in dt its variance is walk^2 dt.
    walks with dt squared | gyro_walk**2 * dt, acc_walk**2 * dt -> (gyro_walk * dt)**2, (acc_walk * dt)**2 | Independent steps add their *variances*: walk^2 dt, not (walk dt)^2.
    roots of the variances | np.diag(np.repeat([gyro**2 / dt, acc**2 / dt, gyro_walk**2 * dt, acc_walk**2 * dt], 3)) -> np.sqrt(np.diag(np.repeat([gyro**2 / dt, acc**2 / dt, gyro_walk**2 * dt, acc_walk**2 * dt], 3))) | A covariance holds variances, not standard deviations.
    gyrometer and accelerometer exchanged | [gyro**2 / dt, acc**2 / dt, -> [acc**2 / dt, gyro**2 / dt, | u = [w, a, ...]: the gyrometer comes first.
    alternating axes | np.diag(np.repeat([gyro**2 / dt, acc**2 / dt, gyro_walk**2 * dt, acc_walk**2 * dt], 3)) -> np.diag(np.tile([gyro**2 / dt, acc**2 / dt, gyro_walk**2 * dt, acc_walk**2 * dt], 3)) | First three of w, then three of a, and so on: np.repeat, not np.tile.
    half of the white noise | gyro**2 / dt, acc**2 / dt -> gyro**2 / (2 * dt), acc**2 / (2 * dt) | A mean over dt has the variance n^2 / dt: without a half.
    shared among the axes: Each axis has the whole of a variance: it is not shared among the three.
        np.diag(np.repeat([gyro**2 / dt, acc**2 / dt, gyro_walk**2 * dt, acc_walk**2 * dt], 3)) -> np.diag(np.repeat([gyro**2 / dt, acc**2 / dt, gyro_walk**2 * dt, acc_walk**2 * dt], 3)) / 3
    the same for all axes | np.diag(np.repeat([gyro**2 / dt, acc**2 / dt, gyro_walk**2 * dt, acc_walk**2 * dt], 3)) -> np.kron(np.diag([gyro**2 / dt, acc**2 / dt, gyro_walk**2 * dt, acc_walk**2 * dt]), np.ones((3, 3))) | The three axes are independent: the blocks are diagonal, not full of ones.
    gyro_walk in degrees | gyro_walk**2 * dt, -> np.radians(gyro_walk) ** 2 * dt, | gyro_walk is in rad/s already: no conversion.
    """,
)
