"""What the drawings of notebook 12 compute: walls and boards in a lens, the way back, the error of a calibration."""

from dataclasses import dataclass

import numpy as np

from ...geometry import e2R
from ...models.sensors import PinHole
from ...models.sensors.lens import distort, exact_undistort, inv_distortion, undistort
from ...models.sensors.pin_hole import pin_hole

SIZE = np.array([640.0, 480.0])  # of the image, px
K = np.array([320.0, 240.0, 320.0, 320.0])  # u0, v0, au, av, px
TRUE = np.array([326.0, 236.0, 312.0, 309.0, -0.28, 0.07])  # k and d of the camera that is calibrated
START = np.array([320.0, 240.0, 330.0, 330.0, 0.0, 0.0, 0.0])  # what the data sheet says, and no distortion
START_STD = np.array([15.0, 15.0, 25.0, 25.0, 0.3, 0.2, 0.1])
NAMES = ("u0", "v0", "au", "av", "d2", "d4", "d6")


def corner(k=K):
    """Radius |[x/z, y/z]| of the corner of an ideal image."""
    return float(np.hypot(k[0] / k[2], k[1] / k[3]))


def fold_of(d):
    """Radius at which the lens folds back; infinite if it never does."""
    return float(PinHole(d=tuple(d)).fold)


def wall(half=1.75, step=0.25, n=71):
    """Lines on a wall, 1 m ahead: a list of curves (n, 2) of normalised image points."""
    at, along = np.arange(-half, half + 1e-9, step), np.linspace(-half, half, n)
    columns = [np.column_stack([np.full(n, a), along]) for a in at]
    return columns + [c[:, ::-1] for c in columns]


def in_lens(curve, d, k=K):
    """Pixels of a curve of normalised points; NaN at and beyond the fold."""
    u = k[:2] + k[2:] * distort(curve, d)[0]
    u[np.linalg.norm(curve, axis=1) >= fold_of(d)] = np.nan
    return u


WAYS = ("distort(ud, -d)", "ud / f(ud)", "correction vector c, 1 number", "c, 2 numbers", "c, 4 numbers", "Newton")


def ways_back(d, r):
    """Errors in pixels of the ways back through the lens, for ideal points with the radii r.

    Returns
    -------
    dict of str to ndarray, shape (len(r),)
    """
    d, up = np.asarray(d, float), np.column_stack([r, 0 * r])
    ud = distort(up, d)[0]
    f = 1 + (ud**2).sum(1)[:, None] ** np.arange(1, len(d) + 1) @ d
    back = [distort(ud, -d)[0], ud / f[:, None]]
    back += [undistort(ud, inv_distortion(d, n, K))[0] for n in (1, 2, 4)] + [exact_undistort(ud, d)[0]]
    return {name: K[2] * np.linalg.norm(b - up, axis=1) for name, b in zip(WAYS, back, strict=True)}


def board(rng, part, nx=8, ny=6):
    """Corners of a board in the camera frame, (48, 3), m: tilted at random; it fills `part` of the image."""
    grid = np.stack(np.meshgrid(np.linspace(-1, 1, nx), np.linspace(-0.75, 0.75, ny)), -1).reshape(-1, 2)
    R = e2R(rng.uniform(-1, 1, 3) * np.radians([25, 25, 20]))[0]
    p = np.column_stack([grid, np.zeros(len(grid))]) @ R.T + [0, 0, 2.5]
    ray = p[:, :2] / p[:, 2:]
    ray = ray * part * 1.02 / np.abs(ray).max()  # the zoom that fills the part wanted
    return np.column_stack([ray, np.ones(len(ray))]) * p[:, 2:]


@dataclass
class Calibration:
    """The end of a calibration: mean and covariance of [k; d], pixels and residuals of the last view, all NIS."""

    x: np.ndarray
    P: np.ndarray
    pixels: np.ndarray
    residuals: np.ndarray
    nis: float  # mean of all views, divided by its number of measurements: 1 is honest


def model_error(c, r):
    """Error of the calibrated model along the diagonal of the image, and its standard deviation, px.

    Parameters
    ----------
    c : Calibration
    r : ndarray
        Radii |[x/z, y/z]|.
    """
    a = np.array([0.8, 0.6])
    p = np.column_stack([np.outer(r, a), np.ones(len(r))])
    e, _, U_k, U_d = pin_hole(p, c.x[:4], c.x[4:])
    along = np.concatenate([U_k, U_d], -1).swapaxes(1, 2) @ a
    error = (e - pin_hole(p, TRUE[:4], TRUE[4:])[0]) @ a
    return error, np.sqrt(np.einsum("ni,ij,nj->n", along, c.P, along))
