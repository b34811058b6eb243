"""Exercise 13.2: a pixel and a prior make an inverse-depth landmark, the anchor included."""

import numpy as np

from ...geometry import Frame3, e2q
from ...models.landmarks import IdpPnt
from ...models.sensors import PinHole
from ..table import table
from .nb04_blocks import random_covariance


def new_idp(F, P_F, camera, y, R, n, N):
    """A new inverse-depth landmark from one pixel, as in the manual's section 5.2.

    F is the frame of the camera in the world, a Frame3, and P_F its covariance, shape (7, 7). y, shape (2,), is the
    pixel with the noise covariance R, shape (2, 2). n, shape (1,), is the prior of the inverse distance, which the
    pixel does not show, and N, shape (1, 1), its covariance.
    `camera.retro(y)` returns v, V_y: the ray in the frame of the camera. `IdpPnt().from_ray(v, n)` returns
    l_c, LC_v, LC_n: the landmark in that frame. `IdpPnt().from_frame(F, l_c)` returns l, L_F, L_lc.
    Return l = [anchor; pitch; yaw; rho], shape (6,), P_ll, shape (6, 6), and P_lF, shape (6, 7): its own covariance,
    and its covariance with the camera frame.
    """
    v, V_y = camera.retro(y)
    l_c, LC_v, LC_n = IdpPnt().from_ray(v, n)
    l, L_F, L_lc = IdpPnt().from_frame(F, l_c)
    L_y, L_n = L_lc @ LC_v @ V_y, L_lc @ LC_n
    P_ll = L_F @ P_F @ L_F.T + L_y @ R @ L_y.T + L_n @ N @ L_n.T
    P_lF = L_F @ P_F
    return l, P_ll, P_lF


LENSES = (
    PinHole(),
    PinHole((300.0, 220.0, 400.0, 380.0), (-0.2, 0.05)),
    PinHole((310.0, 250.0, 250.0, 260.0), pixel_std=2.0),
)
FORWARD = Frame3(np.array([0, 0, 0, *e2q(np.array([-np.pi / 2, 0, -np.pi / 2]))[0]]))  # it looks along x


def case(rng, camera, known=1.0):
    """Arguments: a camera somewhere, a pixel, a prior; noises correlated and of different sizes."""
    angles = rng.uniform([-0.5, -0.5, -3], [0.5, 0.5, 3])
    F = Frame3(np.concatenate([rng.uniform(-3, 3, 3), e2q(angles)[0]])).compose(FORWARD)[0]
    n, N = np.array([rng.uniform(0.05, 0.5)]), np.array([[rng.uniform(0.05, 0.5) ** 2]])
    y, R = rng.uniform([150, 120], [500, 380]), random_covariance(rng, 2, 2.0)
    return F, known * random_covariance(rng, 7, 0.05), camera, y, R, n, N


born = table(
    "13.2 A pixel and a prior make a landmark",
    new_idp,
    hints=(
        "Three calls, in the order of the docstring. Then the chain rule: how does l depend on y, on n, on F?",
        "L_y = L_lc LC_v V_y and L_n = L_lc LC_n. Three independent errors: of F, y and n. Covariances add.",
        "P_lF = L_F P_F; P_ll = L_F P_F L_F' + L_y R L_y' + L_n N L_n'.",
    ),
    returns="l, P_ll, P_lF",
    symbols="L_y, L_n = the derivatives of the new landmark by the pixel and by the prior",
    angles={"l": [3, 4]},
    cases={
        "any": lambda rng: [case(rng, camera) for camera in LENSES],
        "known": lambda rng: [case(rng, camera, known=0.0) for camera in LENSES[:2]],
    },
    checks="""
    anchor                     | l[:3]        | any   | The anchor is where the camera is: the position of F.
    rho                        | l[5:]        | any   | The pixel says nothing about the distance: the last number is the prior n, as it is.
    direction                  | l            | any   | `camera.retro` gives the ray in the camera; `from_frame` turns it into the world.
    the prior stays            | P_ll[5:, 5:] | any   | rho has the variance of its prior, N, whatever the pixel and the pose.
    the anchor is the camera   | P_lF[:3]     | any   | The anchor *is* the position of the camera: both have the same error, so the first three rows of P_lF are those of P_F.
    known pose                 | P_ll         | known | With a known pose (P_F = 0) only pixel and prior are left: L_y R L_y' + L_n N L_n'.
    covariance with the camera | P_lF         | any   | Error of the frame in, error of the landmark out: P_lF = L_F P_F.
    own covariance             | P_ll         | any   | Pose, pixel and prior are independent causes of error: P_ll = L_F P_F L_F' + L_y R L_y' + L_n N L_n'.
    """,
    wrong="""
    landmark left in the camera frame | return l, -> return l_c, | That is the landmark as the camera sees it: `from_frame(F, l_c)` brings it into the world.
    distance for inverse distance | return l, -> return np.append(l[:5], 1 / n), | The last number is the *inverse* distance, in 1/m: n, not 1 / n.
    point instead of anchor | return l, -> return np.append(IdpPnt().point(l)[0], l[3:]), | The first three numbers are the anchor, where the camera was, not the point.
    pitch and yaw swapped | return l, -> return l[[0, 1, 2, 4, 3, 5]], | The order is [anchor; pitch; yaw; rho]: first the elevation, then the azimuth.
    prior forgotten | L_y.T + L_n @ N @ L_n.T -> L_y.T | The prior is uncertain, too: its term L_n N L_n' is missing. Without it the filter believes that it knows the distance.
    N as a standard deviation | L_n @ N @ -> L_n @ N**2 @ | N is a covariance already: do not square it.
    N and R swapped by identity | L_n @ N @ -> L_n @ | The term of the prior is L_n N L_n', that of the pixel L_y R L_y': neither covariance is the identity.
    pixel noise forgotten | + L_y @ R @ L_y.T -> + 0 | The pixel is noisy: its term L_y R L_y' is missing.
    pose taken as known | L_F @ P_F @ L_F.T + -> 0 + | That is the formula of mapping. The camera pose is uncertain: L_F P_F L_F' belongs in P_ll, and P_lF = L_F P_F.
        P_lF = L_F @ P_F -> P_lF = 0 * L_F
    anchor not correlated | P_lF = L_F @ P_F -> P_lF = 0 * L_F | An anchor that is not correlated with the camera pose is a second, independent origin: the anchor *is* the camera position. P_lF = L_F P_F.
    pose noise forgotten in P_ll | L_F @ P_F @ L_F.T + -> 0 + | P_lF is there, but P_ll lacks the error of the pose: L_F P_F L_F'.
    L_F instead of P_lF | P_lF = L_F @ P_F -> P_lF = L_F | A Jacobian is not a covariance: P_lF = L_F P_F.
    P_Fl | P_lF = L_F @ P_F -> P_lF = P_F @ L_F.T | P_lF has the landmark in its rows: L_F P_F, shape (6, 7).
    only the variances of R | L_y @ R @ -> L_y @ np.diag(np.diag(R)) @ | The two numbers of a pixel may be correlated: use the whole R.
    R as a standard deviation | L_y @ R @ -> L_y @ R @ R @ | R is a covariance already: do not square it.
    R squared entry by entry | L_y @ R @ -> L_y @ R**2 @ | R is a covariance already: do not square it.
    pixel noise in the frame of the camera | L_lc @ LC_v @ V_y -> LC_v @ V_y | That is how the pixel moves the landmark in the frame of the camera. From there into the world it is one factor more: L_y = L_lc LC_v V_y.
    pixel noise taken for that of the ray | L_lc @ LC_v @ V_y -> L_lc @ LC_v @ np.eye(3)[:, :2] | R is the covariance of the pixel, not of the ray: from the pixel to the ray there is V_y, from `retro`.
    P_lF with a factor too many | P_lF = L_F @ P_F -> P_lF = L_lc @ L_F @ P_F | P_lF is L_F P_F: the frame acts in the second step, after the camera.
    position of the camera alone | L_F @ P_F @ L_F.T -> L_F[:, :3] @ P_F[:3, :3] @ L_F[:, :3].T | A camera that is turned puts the landmark elsewhere, too: all seven numbers of the frame count, L_F P_F L_F'.
    position and orientation independent | L_F @ P_F @ L_F.T -> L_F @ (P_F * np.block([[np.ones((3, 3)), np.zeros((3, 4))], [np.zeros((4, 3)), np.ones((4, 4))]])) @ L_F.T | Position and orientation of the camera are correlated: use the whole P_F.
    P_Fl reshaped | P_lF = L_F @ P_F -> P_lF = (P_F @ L_F.T).reshape(6, 7) | reshape leaves the numbers in their order and mixes them: P_lF is the *transpose* of P_F L_F', which is L_F P_F.
    flat L_n | L_n @ N @ L_n.T -> float((L_n * N).ravel() @ L_n.ravel()) | L_n N L_n' is a matrix, (6, 6). Of a flat vector .T does nothing, and the product is one number, which is added to every entry: L_n must have the shape (6, 1), as L_lc @ LC_n has it.
    """,
)
