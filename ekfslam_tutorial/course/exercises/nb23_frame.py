"""Exercise 23.5: many controls from one frame of the camera to the next."""

import numpy as np

from ...models.motion import Imu
from ..table import table
from .nb04_blocks import random_covariance
from .nb23_step import case as state

MODEL = Imu()


def imu(r, u, dt):
    """Move the state of an IMU: what the exercise calls `move`."""
    return MODEL.move(r, u, dt)


def move_frame(x, P, move, us, U, dt):
    """Move the IMU from one frame of the camera to the next: many controls, and a map that waits.

    x, shape (16 + m,): the state of the IMU, 16 numbers, then the landmarks; P, shape (16 + m, 16 + m), its covariance.
    us, shape (n, 12): the controls of this frame, in order; each holds for dt (s), each has the covariance U, shape
    (12, 12), and their noises are independent. `move(r, u, dt)` takes the state r of the IMU, shape (16,), and one
    control; it returns the new state and its derivatives by r and by u: r2, R_r, R_u.
    Return the new x and P. The landmarks stand still, but they are correlated with the IMU. Do not change the inputs.
    """
    x, P = x.copy(), P.copy()
    X, Q = np.eye(16), np.zeros((16, 16))
    for u in us:
        x[:16], R_r, R_u = move(x[:16], u, dt)
        X = R_r @ X
        Q = R_r @ Q @ R_r.T + R_u @ U @ R_u.T
    P[:16] = X @ P[:16]
    P[:, :16] = P[:, :16] @ X.T
    P[:16, :16] += Q
    return x, P


def case(rng, n=4, m=6, noise=1.0, before=1.0):
    """Return a map, and the controls of a frame."""
    x, _, dt = state(rng, dt=0.1)
    us = np.concatenate([rng.uniform(-1, 1, (n, 3)), rng.uniform(-5, 9, (n, 3)), rng.uniform(-0.1, 0.1, (n, 6))], 1)
    x = np.concatenate([x, rng.uniform(-3, 3, m)])
    return x, before * random_covariance(rng, 16 + m), imu, us, noise * random_covariance(rng, 12, 0.1), dt


exercise = table(
    "23.5 Many controls, one frame",
    move_frame,
    hints=(
        "Step by step it is the prediction of EKF-SLAM, n times: the mean moves, P_rr becomes R_r P_rr R_r' + R_u U R_u', and P_rm becomes R_r P_rm.",
        "Where the map is large, gather first: X = the product of all R_r, the new one on the left; Q = R_r Q R_r' + R_u U R_u'. Touch the covariance of the map once, at the end.",
        "At the end P[:16] = X @ P[:16]; P[:, :16] = P[:, :16] @ X.T; P[:16, :16] += Q.",
    ),
    returns="x, P",
    symbols="X = the product of all R_r; P_rm = P[:16, 16:]; P_mr = P[16:, :16]; P_rr = P[:16, :16]; "
    "Q = the noise so far; R_1, R_2, R_3 = the R_r of three controls, in their order",
    shown=lambda x, P, move, us, U, dt: f"{len(us)} controls, {len(x) - 16} numbers of landmarks",
    cases={
        "any": lambda rng: [case(rng, 3), case(rng, 2, 3)],
        "one control": lambda rng: [case(rng, n=1)],
        "no landmarks": lambda rng: [case(rng, 2, m=0)],
        "U = 0": lambda rng: [case(rng, 3, noise=0.0)],
        "P = 0": lambda rng: [case(rng, 3, before=0.0)],
    },
    checks="""
    state            | x             | any          | Each control moves the state of the IMU, x[:16], on for dt, in order: the next one starts where the last one has ended. The landmarks stay where they are.
    one control      | P             | one control  | One control: P_rr becomes R_r P_rr R_r' + R_u U R_u', P_rm becomes R_r P_rm, P_mr is its transpose, and the part of the landmarks stays.
    no landmarks     | P             | no landmarks | Without landmarks it is the prediction of an EKF, P becomes R_r P R_r' + R_u U R_u', once for each control, in order. Each has its own R_r and R_u, at the state where it begins.
    no noise         | P[:16, :16]   | U = 0        | With U = 0 the covariance is X P X', where X is the product of all R_r, the last one on the left.
    noise            | P[:16, :16]   | P = 0        | Each control adds its noise, and the steps after it move that noise on: Q = R_r Q R_r' + R_u U R_u'.
    landmarks        | P[16:, 16:]   | any          | The landmarks stand still: their part of P does not change.
    correlations     | P[:16, 16:]   | any          | What the IMU and the landmarks have in common moves with the IMU: X P_rm.
    symmetric        | P             | any          | P stays symmetric: P_mr is the transpose of P_rm.
    """,
    wrong="""
    correlations not moved: P_rm becomes X P_rm: the IMU and the landmarks stay correlated, but by the moved IMU.
        P[:16] = X @ P[:16] -> P[:16, :16] = X @ P[:16, :16]
        P[:, :16] = P[:, :16] @ X.T -> P[:16, :16] = P[:16, :16] @ X.T
    only one side of the correlations | P[:, :16] = P[:, :16] @ X.T -> P[:16, :16] = P[:16, :16] @ X.T | P has P_mr, too: its columns move as its rows do.
    correlations forgotten | P[:16, :16] += Q -> P[:16, :16] += Q; P[:16, 16:] = 0; P[16:, :16] = 0 | The IMU and the landmarks are correlated, and stay so: P_rm becomes X P_rm.
    order of the product | X = R_r @ X -> X = X @ R_r | The later derivative stands on the left: R_3 R_2 R_1.
    last derivative only | X = R_r @ X -> X = R_r | The whole frame has the product of all derivatives: X = R_r X.
    noise not moved on | Q = R_r @ Q @ R_r.T + R_u @ U @ R_u.T -> Q = Q + R_u @ U @ R_u.T | The noise of a control is moved by the steps after it: Q = R_r Q R_r' + ...
    last noise only | Q = R_r @ Q @ R_r.T + R_u @ U @ R_u.T -> Q = R_u @ U @ R_u.T | Each control has noise, and the steps after it move it on: Q = R_r Q R_r' + R_u U R_u' with each control.
    noise forgotten | P[:16, :16] += Q -> pass | Each control adds its noise: + R_u U R_u'.
    noise moved with the whole X | Q = R_r @ Q @ R_r.T -> Q = X @ Q @ X.T | What has been gathered is moved by this step only: R_r, not X.
    U not by R_u | R_u @ U @ R_u.T -> np.pad(U, (0, 4)) | U belongs to the twelve numbers of a control: R_u brings it into the state.
    noise a second time | P[:16, :16] += Q -> P[:16, :16] += 2 * Q | Each control adds its noise once.
    always from the start: Each control starts where the last one has ended: move(x[:16], u, dt).
        move(x[:16], u, dt) -> move(x_0, u, dt)
        x, P = x.copy(), P.copy() -> x_0, x, P = x[:16].copy(), x.copy(), P.copy()
    derivatives at the start: R_r and R_u belong to the state before *this* control: yours are all taken at the start of the frame.
        x[:16], R_r, R_u = move(x[:16], u, dt) -> x[:16], (R_r, R_u) = move(x[:16], u, dt)[0], move(x_0, u, dt)[1:]
        x, P = x.copy(), P.copy() -> x_0, x, P = x[:16].copy(), x.copy(), P.copy()
    derivatives at the end: R_r and R_u belong to the state *before* the control: yours are taken where it has ended. Take all three results from one call of move.
        move(x[:16], u, dt) -> move(x[:16], u, dt); _, R_r, R_u = move(x[:16], u, dt)
    U shared by the controls | R_u @ U @ R_u.T -> R_u @ U @ R_u.T / len(us) | Each control has the whole covariance U: do not divide it by their number.
    first control only | for u in us: -> for u in us[:1]: | A frame has n controls.
    last control forgotten | for u in us: -> for u in us[:-1]: | A frame has n controls, the last one, too.
    backwards | for u in us: -> for u in us[::-1]: | The controls are in order: the first one comes first.
    mean control: Turns do not commute, and each step starts elsewhere: one step by the mean control, n dt long, is another motion.
        for u in us: -> for u in [us.mean(0)]:
        move(x[:16], u, dt) -> move(x[:16], u, dt * len(us))
    dt of the frame | move(x[:16], u, dt) -> move(x[:16], u, dt * len(us)) | dt is the time of one control, not of the frame.
    landmarks moved, too | P[:16, :16] += Q -> P[:16, :16] += Q; P[16:, 16:] += np.trace(U) * np.eye(len(x) - 16) | The landmarks stand still: nothing is added to their block of P.
    transposed: It is R_r P R_r', not R_r' P R_r: the transposed one stands behind.
        X = R_r @ X -> X = R_r.T @ X
        Q = R_r @ Q @ R_r.T -> Q = R_r.T @ Q @ R_r
    correlations by the last derivative only: What the IMU and the landmarks have in common moves with each control: R_r P_rm, once for each of them.
        P[:16] = X @ P[:16] -> P[:16, :16], P[:16, 16:] = X @ P[:16, :16], R_r @ P[:16, 16:]
        P[:, :16] = P[:, :16] @ X.T -> P[:16, :16], P[16:, :16] = P[:16, :16] @ X.T, P[16:, :16] @ R_r.T
    correlations by the transposed one: P_rm becomes X P_rm, and the R_r stand in X as they are: yours are transposed.
        X, Q = np.eye(16), np.zeros((16, 16)) -> X, Q, A = np.eye(16), np.zeros((16, 16)), np.eye(16)
        X = R_r @ X -> X = R_r @ X; A = R_r.T @ A
        P[:16] = X @ P[:16] -> P[:16, :16], P[:16, 16:] = X @ P[:16, :16], A @ P[:16, 16:]
        P[:, :16] = P[:, :16] @ X.T -> P[:16, :16], P[16:, :16] = P[:16, :16] @ X.T, P[16:, :16] @ A.T
    U by dt | R_u @ U @ R_u.T -> R_u @ U @ R_u.T * dt | U is the covariance of one control already: no dt.
    correlations by the product in the wrong order: The later derivative stands on the left, R_3 R_2 R_1: in the product for P_rm, too.
        X, Q = np.eye(16), np.zeros((16, 16)) -> X, Q, A = np.eye(16), np.zeros((16, 16)), np.eye(16)
        X = R_r @ X -> X = R_r @ X; A = A @ R_r
        P[:16] = X @ P[:16] -> P[:16, :16], P[:16, 16:] = X @ P[:16, :16], A @ P[:16, 16:]
        P[:, :16] = P[:, :16] @ X.T -> P[:16, :16], P[16:, :16] = P[:16, :16] @ X.T, P[16:, :16] @ A.T
    dt shared among the controls | move(x[:16], u, dt) -> move(x[:16], u, dt / len(us)) | Each control holds for dt: it is not shared among them.
    one noise for all: The noises of the controls are independent: the covariances R_u U R_u' add up, one after the other. Yours is the result for one noise that is the same in all controls.
        X, Q = np.eye(16), np.zeros((16, 16)) -> X, Q, G = np.eye(16), np.zeros((16, 16)), np.zeros((16, len(U)))
        Q = R_r @ Q @ R_r.T + R_u @ U @ R_u.T -> G = R_r @ G + R_u; Q = G @ U @ G.T
    noise before the step | Q = R_r @ Q @ R_r.T + R_u @ U @ R_u.T -> Q = R_r @ (Q + R_u @ U @ R_u.T) @ R_r.T | R_u is the derivative of the state behind the control: its noise does not go through the R_r of its own step.
    cross-covariance half moved | P[:, :16] = P[:, :16] @ X.T -> P[:16, :16] = P[:16, :16] @ X.T; P = (P + P.T) / 2 | P_mr is the transpose of the new P_rm. Made symmetric by (P + P') / 2 it is half of the old and half of the new one.
    """,
)
