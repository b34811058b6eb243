"""Where an IMU starts that lies still: what is down, and the bias of the gyrometer."""

import numpy as np

from ...geometry import R2q, hat, q_prod, v2q


def at_rest(w, a, gravity=(0.0, 0.0, -9.81), gyro_std=1e-3, acc_std=0.05, vel_std=0.02, acc_bias_std=0.1):
    """State of an IMU at rest, from means of what it measures, and the covariance of that.

    At rest the gyrometer measures its bias, and the accelerometer a = s + b_a + n with s = -R' gravity and noise n. The
    length of s is known, its direction is not: a bias across it looks like a tilt. So of b_a the part along s is found,
    and the tilt phi and the part across are correlated, phi = [s]x (b_a + n) / |s|^2. Where the origin is and what is
    yaw is a choice: these four have no variance.

    Parameters
    ----------
    w, a : array_like, shape (3,)
        Means over the rest, rad/s and m/s^2.
    gravity : sequence of 3 floats
        In the world, m/s^2.
    gyro_std, acc_std : float
        Of these means: noise, and what the rest lacks of being one, rad/s and m/s^2.
    vel_std : float
        The same of the velocity, m/s.
    acc_bias_std : float
        What is known of the bias of an accelerometer before, m/s^2.

    Returns
    -------
    x : ndarray, shape (16,)
        As `Imu` has it, [t; q; v; b_w; b_a].
    P : ndarray, shape (16, 16)

    See Also
    --------
    Imu : The motion model.
    """
    w, a, g = (np.asarray(each, float) for each in (w, a, gravity))
    size, length = np.linalg.norm(a), np.linalg.norm(g)
    if not size > 0:
        raise ValueError(f"an accelerometer at rest measures gravity, got {a}")
    s = a * length / size
    up = s / length
    R = _level(up, -g / length)
    q = R2q(R)[0]
    along = np.outer(up, up)
    across = np.eye(3) - along

    X = np.zeros((16, 12))  # by b_a before, n, the velocity, and the noise of w
    turn = q_prod(q, v2q(np.zeros(3))[0])[2] @ v2q(np.zeros(3))[1] @ hat(s) / length**2
    X[3:7, 0:3] = X[3:7, 3:6] = turn
    X[13:, 0:3], X[13:, 3:6] = across, -along
    X[7:10, 6:9] = X[10:13, 9:] = np.eye(3)
    stds = np.repeat([acc_bias_std, acc_std, vel_std, gyro_std], 3)
    return np.concatenate([np.zeros(3), q, np.zeros(3), w, a - s]), (X * stds**2) @ X.T


def _level(up, up_w):
    """Turn R with R up = up_w, of which the axis is level: no yaw, as far as that can be said."""
    v, c = np.cross(up, up_w), up @ up_w
    if c < -0.999999:  # upside down: half a turn, and what is left
        x = np.cross(up, [1.0, 0.0, 0.0] if abs(up[0]) < 0.9 else [0.0, 1.0, 0.0])
        x = x / np.linalg.norm(x)
        half = 2 * np.outer(x, x) - np.eye(3)
        return _level(half @ up, up_w) @ half
    return np.eye(3) + hat(v) + hat(v) @ hat(v) / (1 + c)
