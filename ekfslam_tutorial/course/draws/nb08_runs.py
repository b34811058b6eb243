"""The filters of notebook 08: a robot that stands still, one that drives, and a covariance in single precision."""

from dataclasses import dataclass, field
from functools import cache

import numpy as np

from ...geometry import Frame2, wrap
from ...models.sensors.range_bearing import polar
from ..exercises.nb08_fej import correct_fej, observe

R = np.diag([0.1, np.radians(1.0)]) ** 2  # of range and bearing: m^2, rad^2
LANDMARK = np.array([8.0, 0.2])  # true range (m) and bearing (rad) of the landmark of the robot that stands still
LANDMARKS = np.array([[6.0, 4.0], [-3.0, 7.0], [2.0, -5.0], [-6.0, -2.0]])
EKF, FEJ, TRUTH = "EKF", "FEJ", "truth"
TURN = np.array([[0.0, -1.0], [1.0, 0.0]])  # derivative of a rotation by its angle, at zero


def measurements(n, seed=0):
    """Noisy sights of the one landmark by a robot that stands still, shape (n, 2)."""
    return LANDMARK + np.random.default_rng([8, seed]).normal(size=(n, 2)) * np.sqrt(np.diag(R))


def first_sight(y, theta, std):
    """Joint state after the first sight y: the position is the origin, exactly; the heading is theta, std (rad)."""
    c, s = np.cos(theta + y[1]), np.sin(theta + y[1])
    L_r, L_y = np.array([[1, 0, -y[0] * s], [0, 1, y[0] * c]]), np.array([[c, -y[0] * s], [s, y[0] * c]])
    P = np.diag([0, 0, std**2])
    P = np.block([[P, P @ L_r.T], [L_r @ P, L_r @ P @ L_r.T + L_y @ R @ L_y.T]])
    return np.array([0, 0, theta, y[0] * c, y[0] * s]), P


@cache
def standing(std_deg, jacobians=EKF, n=100, seed=0):
    """Heading error and heading sigma (rad) after each of n sights, arrays of shape (n + 1,); and the last x, P."""
    std, y = np.radians(std_deg), measurements(n + 1, seed)
    x, P = first_sight(y[0], std * np.random.default_rng([9, seed]).normal(), std)
    x_first, error, sigma = x.copy(), [x[2]], [std]
    for y_k in y[1:]:
        x, P = correct_fej(x, P, y_k, 0, x_first if jacobians == FEJ else x, R)
        error.append(wrap(x[2]))
        sigma.append(np.sqrt(max(P[2, 2], 0)))
    return np.array(error), np.array(sigma), x, P


# ---- a robot that drives -------------------------------------------------------------------------------------------


@dataclass
class Drive:
    """Jacobians that a filter has used, H (K+1 matrices) and F (K matrices), and the NEES of its heading."""

    H: list = field(default_factory=list)
    F: list = field(default_factory=list)
    heading_nees: float = np.nan


@cache
def drive(kind=EKF, steps=10, seed=0, std_deg=0.0):
    """SLAM on a round of 3 m radius among four landmarks, all seen from the start.

    `kind` says where the Jacobians are taken: at the present estimates (EKF), at the first ones (FEJ), at the truth.
    The heading at the start has the standard deviation `std_deg`; the position is the origin of the map.
    """
    rng, run, U = np.random.default_rng([10, seed]), Drive(), np.diag([0.05, 0.02, np.radians(2)]) ** 2
    truth, u, std = np.array([3.0, 0.0, np.pi / 2]), np.array([0.6, 0.0, 0.2]), np.radians(std_deg)
    x = truth + [0, 0, std * rng.normal()]
    P = np.diag([0, 0, std**2])
    for y in _sights(truth, rng):
        x, P = _add(x, P, y)
    x_true = np.concatenate([truth, LANDMARKS.ravel()])
    l_first, pose_first = x[3:].copy(), x[:3].copy()
    for k in range(steps + 1):
        if k:
            at = {EKF: x[:3], FEJ: pose_first, TRUTH: x_true[:3]}[kind]
            x, X_u = _moved(x, u + rng.normal(size=3) * np.sqrt(np.diag(U)))
            x_true = _moved(x_true, u)[0]
            pose_first = x[:3].copy()
            F = np.eye(len(x))
            F[:2, 2] = TURN @ ((x_true if kind == TRUTH else x)[:2] - at[:2])
            P = F @ P @ F.T
            P[:3, :3] += X_u @ U @ X_u.T
            run.F.append(F)
        lin = {EKF: x, FEJ: np.concatenate([pose_first, l_first]), TRUTH: x_true}[kind].copy()
        run.H.append(np.vstack([observe(lin, i)[1] for i in range(len(LANDMARKS))]))
        for i, y in enumerate(_sights(x_true[:3], rng)):
            x, P = correct_fej(x, P, y, i, x if kind == EKF else lin, R)
    run.heading_nees = float(wrap(x[2] - x_true[2]) ** 2 / P[2, 2])
    return run


def _sights(pose, rng):
    return polar(Frame2(pose).to_frame(LANDMARKS)[0])[0] + rng.normal(size=(len(LANDMARKS), 2)) * np.sqrt(np.diag(R))


def _add(x, P, y):
    a = x[2] + y[1]
    c, s = np.cos(a), np.sin(a)
    L_r, L_y = np.array([[1, 0, -y[0] * s], [0, 1, y[0] * c]]), np.array([[c, -y[0] * s], [s, y[0] * c]])
    P_lx = L_r @ P[:3]
    P_ll = P_lx[:, :3] @ L_r.T + L_y @ R @ L_y.T
    return np.concatenate([x, x[:2] + y[0] * np.array([c, s])]), np.block([[P, P_lx.T], [P_lx, P_ll]])


def _moved(x, u):
    c, s = np.cos(x[2]), np.sin(x[2])
    X_u = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    return np.concatenate([x[:3] + X_u @ u, x[3:]]), X_u


def all_at_once(bearing_only=False, poses=4):
    """Jacobian of the measurements of all landmarks from several poses, nothing known of the motion between them."""
    rng = np.random.default_rng(11)
    x_r = np.column_stack([rng.uniform(-3, 3, (poses, 2)), rng.uniform(-3, 3, poses)])
    rows = []
    for k, pose in enumerate(x_r):
        for i in range(len(LANDMARKS)):
            H = observe(np.concatenate([pose, LANDMARKS.ravel()]), i)[1][bearing_only:]
            row = np.zeros((len(H), 3 * poses + LANDMARKS.size))
            row[:, 3 * k : 3 * k + 3], row[:, 3 * poses :] = H[:, :3], H[:, 3:]
            rows.append(row)
    return np.vstack(rows)


# ---- single precision ----------------------------------------------------------------------------------------------


SHORT, JOSEPH, TIDY = "short", "Joseph", "Joseph, symmetric"


@cache
def repeated(form, noise=0.01, gain=1.0, double=False, prior=10.0, updates=15, seed=0):
    """Smallest eigenvalue of P, relative to the largest, after each of some updates of three numbers.

    Parameters
    ----------
    form : str
        (I - K H) P is "short"; "Joseph, symmetric" is the Joseph form, then (P + P') / 2.
    noise, prior : float
        Standard deviations of each measurement and of the state before, m.
    gain : float
        Factor on the best gain.
    double : bool
        Reckon in float64 instead of float32.
    """
    rng, f = np.random.default_rng(seed), np.float64 if double else np.float32
    P, noise2, I = np.eye(3, dtype=f) * f(prior**2), np.array([[noise**2]], f), np.eye(3, dtype=f)
    low = []
    for _ in range(updates):
        H = rng.normal(size=(1, 3)).astype(f)
        K = f(gain) * (P @ H.T / (H @ P @ H.T + noise2))
        A = I - K @ H
        P = A @ P if form == SHORT else A @ P @ A.T + K @ noise2 @ K.T
        P = (P + P.T) / 2 if form == TIDY else P
        w = np.linalg.eigvalsh((P + P.T).astype(float) / 2)
        low.append(w[0] / np.abs(w).max())
    return np.array(low)


def failures(form, runs=100, **case):
    """How many of `runs` sequences of measurements give a P with a negative eigenvalue."""
    return sum(bool((repeated(form, seed=s, **case) < 0).any()) for s in range(runs))
