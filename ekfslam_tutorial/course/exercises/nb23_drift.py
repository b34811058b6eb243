"""Exercise 23.3: how far an IMU is off that nobody corrects."""

import numpy as np

from ..table import table


def drift(t, b_w, b_a, n_w, n_a):
    """By how much the position is off along one horizontal axis, after t seconds by an IMU alone.

    It lies level and still, and its pose is known at t = 0. Four causes, each alone: b_w (rad/s), a bias of the
    gyrometer about the other horizontal axis, that nobody knows; b_a (m/s^2), a bias of the accelerometer along the
    axis; n_w (rad / sqrt(s)) and n_a (m/s^2 / sqrt(Hz)), white noise of the two. A tilt by a small angle makes
    gravity look like an acceleration of 9.81 m/s^2 times the angle.
    What is integrated k times becomes: a constant c: c t^k / k!; white noise of density n: a random error with the
    standard deviation n t^(k - 1/2) / ((k - 1)! sqrt(2 k - 1)).
    Return the four errors, shape (4,), in metres: for b_w and b_a the error, for n_w and n_a its standard deviation.
    """
    by_gyro = 9.81 * np.array([b_w * t**3 / 6, n_w * t**2.5 / (2 * np.sqrt(5))])
    by_acc = np.array([b_a * t**2 / 2, n_a * t**1.5 / np.sqrt(3)])
    return np.array([by_gyro[0], by_acc[0], by_gyro[1], by_acc[1]])


exercise = table(
    "23.3 How an IMU drifts",
    drift,
    hints=(
        "Count the integrals from what is measured to the position. An acceleration: velocity, position, so k = 2. A turn rate: angle first, and the angle times 9.81 is an acceleration. So k = 3.",
        "A bias is a constant: c t^k / k!. White noise: n t^(k - 1/2) / ((k - 1)! sqrt(2k - 1)). Those of the gyrometer times 9.81 m/s^2.",
        "b_w: 9.81 b_w t^3 / 6; b_a: b_a t^2 / 2; n_w: 9.81 n_w t^2.5 / (2 sqrt(5)); n_a: n_a t^1.5 / sqrt(3).",
    ),
    returns="off",
    cases={
        "any": lambda rng: [
            (float(t), *(float(v) for v in rng.uniform(1e-3, 0.05, 4))) for t in (0.5, 3.0, 20.0, 60.0)
        ],
        "one second": lambda rng: [(1.0, *(float(v) for v in rng.uniform(1e-3, 0.05, 4))) for _ in range(2)],
        "one of them": lambda rng: [
            (7.0, *(v if j == i else 0.0 for j, v in enumerate((0.002, 0.02, 5e-4, 0.01)))) for i in range(4)
        ],
    },
    checks="""
    after one second       | off    | one second  | Each of the four causes alone, in the order of the arguments. With t = 1 the factors count, by k, the number of integrals from what is measured to the position: 1 / k! for a bias, 1 / ((k - 1)! sqrt(2k - 1)) for white noise; and 9.81 for the gyrometer.
    each has its place     | off    | one of them | One cause at a time, the others are zero, and t = 7: each makes the error in its own place, in the order b_w, b_a, n_w, n_a, and with its own power of t: t^k for a bias, t^(k - 1/2) for white noise.
    bias of the gyrometer  | off[0] | any         | Turn rate, angle, velocity, position: three integrals, and gravity.
    bias of the accelerometer | off[1] | any      | Acceleration, velocity, position: two integrals.
    noise of the gyrometer | off[2] | any         | White noise integrated three times: t^(k - 1/2) with k = 3.
    noise of the accelerometer | off[3] | any     | White noise integrated twice: t^(k - 1/2) with k = 2.
    """,
    wrong="""
    gyro bias integrated twice | b_w * t**3 / 6 -> b_w * t**2 / 2 | Turn rate, angle, velocity, position: three integrals.
    gyro bias integrated once | 9.81 * np.array([b_w * t**3 / 6, -> 9.81 * np.array([b_w * t, | That is the angle (times gravity). It has to be integrated twice more.
    gravity forgotten | by_gyro = 9.81 * -> by_gyro = | A tilt makes gravity look like an acceleration: 9.81 m/s^2 times the angle.
    gravity forgotten with the bias | by_gyro = 9.81 * np.array([ -> by_gyro = np.array([1.0, 9.81]) * np.array([ | b_w tilts: gravity then looks like an acceleration of 9.81 m/s^2 times the angle.
    gravity forgotten with the noise | by_gyro = 9.81 * np.array([ -> by_gyro = np.array([9.81, 1.0]) * np.array([ | n_w tilts, too: gravity then looks like an acceleration of 9.81 m/s^2 times the angle.
    gyro noise integrated twice | n_w * t**2.5 / (2 * np.sqrt(5)) -> n_w * t**1.5 / np.sqrt(3) | n_w is noise of a turn rate: angle, velocity, position are three integrals, k = 3.
    acc noise integrated three times | n_a * t**1.5 / np.sqrt(3) -> n_a * t**2.5 / (2 * np.sqrt(5)) | n_a is noise of an acceleration: velocity, position are two integrals only, k = 2.
    acc noise integrated once | n_a * t**1.5 / np.sqrt(3) -> n_a * t**0.5 | n_a is noise of an acceleration: velocity, position are two integrals, k = 2.
    t^3 / 3 | b_w * t**3 / 6 -> b_w * t**3 / 3 | Each integral divides: t, t^2 / 2, t^3 / 6.
    no factor with t^3 | b_w * t**3 / 6 -> b_w * t**3 | Each integral divides: t, t^2 / 2, t^3 / 6.
    no half | b_a * t**2 / 2 -> b_a * t**2 | A constant acceleration: c t^2 / 2.
    acc bias integrated once | b_a * t**2 / 2 -> b_a * t | That is the velocity. The position takes another integral.
    acc bias integrated three times | b_a * t**2 / 2 -> b_a * t**3 / 6 | An acceleration needs two integrals only to be a position.
    noise like a bias: White noise is partly averaged away: t^(k - 1/2), not t^k.
        n_w * t**2.5 / (2 * np.sqrt(5)) -> n_w * t**3 / 6
        n_a * t**1.5 / np.sqrt(3) -> n_a * t**2 / 2
    noise integrated once less: From a turn rate to a position there are three integrals, from an acceleration two.
        n_w * t**2.5 / (2 * np.sqrt(5)) -> n_w * t**1.5 / np.sqrt(3)
        n_a * t**1.5 / np.sqrt(3) -> n_a * t**0.5
    variances of the noise: The standard deviation is asked for, not its square.
        n_w * t**2.5 / (2 * np.sqrt(5)) -> 9.81 * n_w**2 * t**5 / 20
        n_a * t**1.5 / np.sqrt(3) -> n_a**2 * t**3 / 3
    noise without its factor: Do not forget 1 / ((k - 1)! sqrt(2k - 1)): for k = 3 it is 1 / (2 sqrt(5)), for k = 2 it is 1 / sqrt(3).
        n_w * t**2.5 / (2 * np.sqrt(5)) -> n_w * t**2.5
        n_a * t**1.5 / np.sqrt(3) -> n_a * t**1.5
    factorial forgotten | (2 * np.sqrt(5)) -> np.sqrt(5) | For k = 3 the factor has (k - 1)! = 2 in it.
    root forgotten in both: White noise has the factor 1 / ((k - 1)! sqrt(2k - 1)): the root is missing, sqrt(5) for k = 3 and sqrt(3) for k = 2.
        (2 * np.sqrt(5)) -> 2
        n_a * t**1.5 / np.sqrt(3) -> n_a * t**1.5
    2 k + 1 for 2 k - 1: White noise has the factor 1 / ((k - 1)! sqrt(2k - 1)): minus 1 under the root.
        (2 * np.sqrt(5)) -> (2 * np.sqrt(7))
        t**1.5 / np.sqrt(3) -> t**1.5 / np.sqrt(5)
    factorial of k in the noise: The factor of white noise has (k - 1)! in it, not k!: 2 for k = 3, and 1 for k = 2.
        (2 * np.sqrt(5)) -> (6 * np.sqrt(5))
        t**1.5 / np.sqrt(3) -> t**1.5 / (2 * np.sqrt(3))
    order of the noises: In the order of the arguments: b_w, b_a, n_w, n_a.
        by_gyro[1], by_acc[1]]) -> by_acc[1], by_gyro[1]])
    noise of the accelerometer like its bias | n_a * t**1.5 -> n_a * t**2 | White noise is partly averaged away: t^(k - 1/2), not t^k.
    noise of the gyrometer like its bias | n_w * t**2.5 -> n_w * t**3 | White noise is partly averaged away: t^(k - 1/2), not t^k.
    noises like biases, with their own factors: White noise is partly averaged away: t^(k - 1/2), not t^k.
        n_w * t**2.5 -> n_w * t**3
        n_a * t**1.5 -> n_a * t**2
    half of t^3 | b_w * t**3 / 6 -> b_w * t**3 / 2 | Each integral divides: t, t^2 / 2, t^3 / 6.
    gravity with the accelerometer, too: Gravity comes in where the gyrometer tilts the orientation. An acceleration is one already.
        b_a * t**2 / 2 -> 9.81 * b_a * t**2 / 2
        n_a * t**1.5 / np.sqrt(3) -> 9.81 * n_a * t**1.5 / np.sqrt(3)
    biases without their factors: Each integral divides: t, t^2 / 2, t^3 / 6.
        b_w * t**3 / 6 -> b_w * t**3
        b_a * t**2 / 2 -> b_a * t**2
    no root of 2 k - 1: White noise has the factor 1 / ((k - 1)! sqrt(2k - 1)): the root of 2k - 1, sqrt(5) for k = 3 and sqrt(3) for k = 2.
        (2 * np.sqrt(5)) -> (2 * 5)
        t**1.5 / np.sqrt(3) -> t**1.5 / 3
    gyrometer converted: b_w and n_w are in radians already: no conversion.
        by_gyro = 9.81 * -> by_gyro = np.radians(9.81) *
    order by the instruments: In the order of the arguments: b_w, b_a, n_w, n_a. First both biases, then both noises.
        [by_gyro[0], by_acc[0], by_gyro[1], by_acc[1]] -> [by_gyro[0], by_gyro[1], by_acc[0], by_acc[1]]
    root forgotten with the gyrometer | (2 * np.sqrt(5)) -> 2 | White noise has the factor 1 / ((k - 1)! sqrt(2k - 1)): for k = 3 the root, sqrt(5), is missing.
    root forgotten with the accelerometer | t**1.5 / np.sqrt(3) -> t**1.5 | White noise has the factor 1 / ((k - 1)! sqrt(2k - 1)): for k = 2 the root, sqrt(3), is missing.
    noise like one constant: White noise is a new random number at each moment, not one for the whole time: its factor is 1 / ((k - 1)! sqrt(2k - 1)), not 1 / k!.
        (2 * np.sqrt(5)) -> 6
        t**1.5 / np.sqrt(3) -> t**1.5 / 2
    noise integrated once more: k is the number of integrals, 3 and 2, as for the biases: t^2.5 and t^1.5.
        t**2.5 / (2 * np.sqrt(5)) -> t**3.5 / (6 * np.sqrt(7))
        t**1.5 / np.sqrt(3) -> t**2.5 / (2 * np.sqrt(5))
    """,
)
