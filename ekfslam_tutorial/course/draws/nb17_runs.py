"""Runs of notebook 17: a camera in the cloister, six ways to store what it sees; the stored series and live ones."""

from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from ... import __file__ as package_file
from ...analysis import nees
from ...geometry import unit
from ...models.landmarks import EucPnt
from ...models.landmarks.projective import scalar
from ...toolbox import UserData, universal_slam

FRAMES, RUNS = 100, 25  # of the stored series
EVERY = 2  # frames that are stored: each second one
ODOMETRY = {"good": (0.003, 0.03), "poor": (0.01, 0.1)}  # sigma of a step (m) and of each angle (degrees), per frame
KINDS = {
    "euc_depth": "eucPnt, depth guessed",
    "hmg": "hmgPnt",
    "ahm": "ahmPnt",
    "idp": "idpPnt",
    "idp_euc": "idpPnt, later eucPnt",
    "euc_camera": "eucPnt, depth camera",
}
TYPES = {
    "euc_depth": "depth_pnt",
    "hmg": "hmg_pnt",
    "ahm": "ahm_pnt",
    "idp": "idp_pnt",
    "idp_euc": "idp_pnt",
    "euc_camera": "euc_pnt",
}
SIZE = {"euc_depth": 3, "hmg": 4, "ahm": 7, "idp": 6, "idp_euc": 6, "euc_camera": 3}  # numbers at birth


@dataclass(frozen=True)
class DepthPnt(EucPnt):
    """A Euclidean point that a single ray may start, at the distance 1 / n of the prior: what notebook 13 warns of."""

    def from_ray(self, v, n):
        """l = m / n with the direction m of the ray and the prior n (1/m). Returns l, L_v, L_n."""
        m, M_v = unit(v)
        d = 1 / scalar(n, m)
        return d * m, d[..., None] * M_v, -(d * d * m)[..., None]


def scenario(kind, odometry="good", frames=FRAMES):
    """User data of a run: a robot in the cloister with one camera that looks ahead.

    Parameters
    ----------
    kind : str
        One of KINDS: how landmarks are stored.
    odometry : str
        "good" or "poor", see ODOMETRY.
    frames : int
    """
    step, angle = ODOMETRY[odometry]
    robot = {
        "motion": "odometry3",
        "position": [0, -5, 0],
        "dx": [0.08, 0, 0],
        "da_deg": [0, 0, 0.9],
        "dx_std": step,
        "da_std_deg": angle,
    }
    camera = {"type": "pin_hole", "position": [0, 0, 0.6], "orientation_deg": [-90, 0, -90], "pixel_std": 1.0}
    if kind == "euc_camera":
        camera |= {"type": "pin_hole_depth", "depth_std": 0.1}
    options = {"n_inits": [10, 1], "init_margin": 25.6, "n_updates": 10, "reparametrize": kind == "idp_euc"}
    table = {
        "name": f"{kind}, {odometry} odometry",
        "time": {"dt": 0.1, "last": frames},
        "world": {"type": "cloister"},
        "robot": [robot],
        "sensor": [camera],
        "landmark": {"type": TYPES[kind], "non_obs_mean": 0.2, "non_obs_std": 0.1},
        "options": options,
    }
    return UserData.from_dict(table, models=[DepthPnt])


@dataclass(frozen=True)
class Series:
    """Runs of one kind: NEES of the robot's pose (6 dof), position error (m), numbers in the map.

    Each has the shape (runs, frames); `k` are the numbers of the frames.
    """

    k: np.ndarray
    nees: np.ndarray
    off: np.ndarray
    states: np.ndarray

    @property
    def anees(self):
        """Mean NEES over the runs, for each frame."""
        return self.nees.mean(0)

    @property
    def rms(self):
        """Root of the mean squared position error over the runs, m, for each frame."""
        return np.sqrt((self.off**2).mean(0))


def live(kind, odometry="good", seeds=range(1, 4), frames=FRAMES, every=EVERY):
    """Make runs now. Run `seed` is that of the stored series.

    Returns
    -------
    Series
    """
    rows = [_run(scenario(kind, odometry, frames), seed, every) for seed in seeds]
    k, *parts = (np.array([row[i] for row in rows]) for i in range(4))
    return Series(k[0], *parts)


def _run(data, seed, every):
    rows = []
    for now in universal_slam(data, seed=seed):
        if now.k % every == 0:
            rob = now.robs[0]
            F, truth = rob.frame(now.map), rob.motion.frame(now.truth[rob.id])
            n = nees(F, now.map.P[rob.r, rob.r], truth)
            rows.append((now.k, float(n), np.linalg.norm(F.t - truth.t), now.map.n_used))
    return np.array(rows).T


def final_nees(data, seeds):
    """NEES of the robot's pose in the last frame of a run, for each seed."""
    return np.array([_run(data, seed, data.time.last)[1, -1] for seed in seeds])


def stored_path():
    """The file of the stored series, in an installed package or in the repository."""
    package = Path(package_file).resolve().parent
    folders = package / "_share" / "data", package.parent / "data"
    return next(folder for folder in folders if folder.is_dir()) / "consistency_3d.npz"


@cache
def stored(kind, odometry="good"):
    """A series of 25 runs from the file that `tools/make_consistency_3d.py` writes.

    Returns
    -------
    Series
    """
    with np.load(stored_path(), allow_pickle=False) as file:
        parts = [file[f"{kind}_{odometry}_{name}"].astype(float) for name in ("nees", "off", "states")]
        return Series(file["k"].astype(int), *parts)
