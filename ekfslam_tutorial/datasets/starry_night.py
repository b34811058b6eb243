"""Starry Night: a stereo camera on a moving head before twenty points, with true poses and true points, as a recording.

The file `dataset3.mat`, whole or a piece of it, of the course AER1513 of the University of Toronto: speed and turn rate
of the vehicle in its own axes, and the pixels of each point in both images.
"""

import numpy as np

from ..geometry import Frame3, v2q
from ..models.motion import Odometry3
from ..models.sensors import StereoPinHole
from ..simulation import SimLmk
from ..toolbox.recordings import ControlLog, RawLog, Recording
from .matlab import read_mat
from .sources import get_file

FILE = "dataset3*.mat"
SIGN = -1.0
"""Of the angular velocity: the file has the opposite of the one that its own poses and its own images show."""

CAMERA = StereoPinHole((321.68, 247.48, 484.5, 484.5), 0.239977, pixel_std=7.0)
BETTER = 0.2
"""The variances of the pixels are about so much of the published ones: see the scenario."""
MOUNT = Frame3(np.array([-0.01847, 0.10738, 0.03039, 0.497014, 0.504205, -0.499217, -0.499537]))
"""The camera on the vehicle: it looks backwards, along the negative x axis."""


def load(path=None, first=0, last=None, sign=SIGN):
    """The log as a recording of robot 1 and its stereo camera, sensor 1.

    Parameters
    ----------
    path : str or Path, optional
        The file, or a folder with it; without it, below the folders of `EKFSLAM_DATA`.
    first, last : int
        Frames to take, from 0, both included; all of them without.
    sign : float
        Of the angular velocity; 1 takes it as it is in the file.

    Returns
    -------
    Recording
        Controls are those of `models.Odometry3`: row k holds from instant k-1 to k. Points have the ids 1 to 20,
        y = [u, v, d]: the left column, the mean of both rows weighted by their noise, and the disparity.

    Raises
    ------
    FileNotFoundError, ValueError
        Naming the file.
    """
    file = get_file("Starry Night", FILE, path)
    m = _read(file)
    frames = _piece(first, last, m["t"].size, file)
    t = m["t"].ravel()[frames]
    rates = np.concatenate([m["v_vk_vk_i"], sign * m["w_vk_vk_i"]]).T[frames]
    truth = np.concatenate([m["r_i_vk_i"].T, v2q(m["theta_vk_i"].T)[0]], 1)[frames]
    variances = np.concatenate([m["v_var"], m["w_var"]]).ravel()

    seen = m["y_k_j"][:, frames].transpose(1, 2, 0)
    notes = [f"the angular velocity of the file times {sign:g}: its sign is wrong"] if sign != 1 else []
    y, R = _stereo(seen, m["y_var"].ravel())
    landmarks = SimLmk(np.arange(1, y.shape[1] + 1), m["rho_i_pj_i"].T)
    return _recording("Starry Night", t - t[0], rates, variances, y, R, truth, landmarks, notes)


def twin(seed=1, n=950):
    """A simulated log of the same form, for those who do not have the file: white noise, of pixels less than is said.

    Parameters
    ----------
    seed : int
        Of everything random.
    n : int
        Number of frames, some 11 a second.

    Returns
    -------
    Recording
    """
    rng = np.random.default_rng(seed)
    t = 0.09 * np.arange(n)
    points = rng.uniform([-3.5, -1.0, -0.8], [-2.0, 1.0, 0.8], (20, 3))
    v = np.stack([0.15 * np.sin(0.5 * t), 0.25 * np.cos(0.4 * t), 0.1 * np.cos(0.7 * t)], -1)
    w = np.stack([0.2 * np.cos(0.9 * t), 0.2 * np.cos(0.6 * t), 0.15 * np.cos(0.4 * t)], -1)
    true, variances = np.concatenate([v, w], 1), np.array([0.0026, 0.0021, 0.0008, 0.01, 0.01, 0.01])
    truth = np.tile(np.eye(7)[3], (n, 1))
    for k in range(1, n):
        truth[k] = Frame3(Odometry3().move(truth[k - 1], true[k - 1] * 0.09, 0.09)[0]).normalized()[0].x
    cameras = Frame3(truth).compose(MOUNT.normalized()[0])[0]
    p = np.einsum("kij,knj->kni", cameras.Rt, points - cameras.t[:, None])
    y = CAMERA.project(p)[0] + rng.multivariate_normal(np.zeros(3), BETTER * CAMERA.R, p.shape[:2])
    y[~CAMERA.visible(y, p)] = np.nan
    rates = true + rng.normal(0, np.sqrt(variances), (n, 6))
    notes = [f"simulated twin of Starry Night, seed {seed}: no real camera was here"]
    landmarks = SimLmk(np.arange(1, 21), points)
    return _recording("twin of Starry Night", t, rates, variances, y, CAMERA.R, truth, landmarks, notes)


def _recording(name, t, rates, variances, y, R, truth, landmarks, notes):
    """Rates at each instant to steps that end at the next one; measurements, NaN where not seen, to rows with ids."""
    dt = np.diff(t)
    u = np.concatenate([np.zeros((1, 6)), rates[:-1] * dt[:, None]])
    U = np.concatenate([np.zeros((1, 6, 6)), np.diag(variances) * (dt**2)[:, None, None]])
    there = np.isfinite(y[..., 0])
    frames, ids = np.nonzero(there)
    offsets = np.searchsorted(frames, np.arange(len(t) + 1))
    raw = RawLog(1, offsets, ids + 1, y[there], np.tile(R, (len(ids), 1, 1)))
    return Recording(name, t, {1: ControlLog(u, U)}, {1: raw}, {1: truth}, landmarks, notes)


def _stereo(pixels, variances):
    """Pixels [u_l, v_l, u_r, v_r] and their variances to [u, v, d] and its covariance; NaN where not seen.

    Both rows measure the same number, so v is their mean, weighted by the inverse variances.
    """
    W = np.diag(1.0 / variances)
    A = np.array([[1.0, 0, 0], [0, 1, 0], [1, 0, -1], [0, 1, 0]])  # pixels = A [u, v, d]
    R = np.linalg.inv(A.T @ W @ A)
    y = pixels @ (R @ A.T @ W).T
    y[(pixels == -1).any(-1)] = np.nan
    return y, R


def _piece(first, last, n, file):
    """The frames from first to last."""
    stop = n if last is None else last + 1
    if not (0 <= first < stop <= n):
        asked = f"{first} to {'the end' if last is None else last}"
        raise ValueError(f"{file}: it has the frames 0 to {n - 1}, asked for are {asked}")
    return slice(first, stop)


def _read(file):
    """The arrays of the file as floats, their shapes checked."""
    shapes = {"t": 1, "theta_vk_i": 3, "r_i_vk_i": 3, "v_vk_vk_i": 3, "w_vk_vk_i": 3}
    wanted = (*shapes, "y_k_j", "rho_i_pj_i", "v_var", "w_var", "y_var")
    m = {k: np.asarray(v, float) for k, v in read_mat(file, wanted).items()}
    missing = [k for k in wanted if k not in m]
    if missing:
        raise ValueError(f"{file} is not the file of Starry Night: it has no array {', '.join(missing)}")
    n = m["t"].size
    want = {k: (rows, n) for k, rows in shapes.items()} | {"y_k_j": (4, n, m["rho_i_pj_i"].shape[-1])}
    wrong = [k for k, shape in want.items() if m[k].shape != shape]
    if wrong:
        raise ValueError(f"{file}: {wrong[0]} has shape {m[wrong[0]].shape}, wanted is {want[wrong[0]]}")
    return m
