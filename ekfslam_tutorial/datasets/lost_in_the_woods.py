"""Lost in the Woods: one robot among 17 tubes with dense ground truth, as a recording.

The file `dataset2.mat` of the course AER1513 of the University of Toronto: speed and turn rate of the robot, range and
bearing of each tube from a laser `d` metres ahead of its centre, at 10 Hz for 21 minutes.
"""

from pathlib import Path

import numpy as np
from scipy.io import loadmat

from ..simulation import SimLmk
from ..toolbox.recording import DAMAGE, ControlLog, RawLog, Recording
from .sources import ENVIRONMENT, data_folders

FILE = "dataset2.mat"
ARRAYS = {"t": 1, "v": 1, "om": 1, "r": 17, "b": 17, "x_true": 1, "y_true": 1, "th_true": 1, "true_valid": 1}
MAX_RANGE = 3.0
"""Sightings further than this are left out, m: a tube far away is a few beams wide, and the next one is near."""

INFLATION = 4.0
"""Of the publisher's noise covariance R: his residuals are taken as white, and they are not."""


def find_file(path=None):
    """The data file: `path` itself, or in the folder `path`, or below those of `EKFSLAM_DATA`; None if nowhere."""
    if path is not None and Path(path).is_file():
        return Path(path)
    folders = data_folders() if path is None else [Path(path)]
    found = [p for f in folders for pattern in (FILE, f"*/{FILE}") for p in sorted(f.glob(pattern))]
    return found[0] if found else None


def load(path=None, max_range=MAX_RANGE, inflation=INFLATION):
    """The log as a recording of robot 1 and its laser, sensor 1.

    Parameters
    ----------
    path : str or Path, optional
        See `find_file`.
    max_range : float
        m.
    inflation : float
        Factor of the publisher's R.

    Returns
    -------
    Recording
        Controls are those of `models.Unicycle`: row k holds from instant k-1 to instant k. Tubes have the ids 1 to 17.

    Raises
    ------
    FileNotFoundError, ValueError
        Naming the file.
    """
    file = find_file(path)
    if file is None:
        place = path or ", ".join(map(str, data_folders())) or f"{ENVIRONMENT}, which is not set"
        raise FileNotFoundError(f"Lost in the Woods: no {FILE} in {place}")
    m = _read(file)
    t, v, om = (m[k].ravel() for k in ("t", "v", "om"))
    u = np.column_stack([v, om])
    u = np.vstack([np.zeros((1, 2)), u[:-1]])
    U = np.tile(np.diag([m["v_var"].item(), m["om_var"].item()]), (len(t), 1, 1))

    seen = (m["r"] > 0) & (m["r"] <= max_range)
    frames, tubes = np.nonzero(seen)
    y = np.column_stack([m["r"][seen], m["b"][seen]])
    R = inflation * np.diag([m["r_var"].item(), m["b_var"].item()])
    offsets = np.searchsorted(frames, np.arange(len(t) + 1))
    raw = RawLog(1, offsets, tubes + 1, y, np.tile(R, (len(y), 1, 1)))

    truth = np.column_stack([m[k].ravel() for k in ("x_true", "y_true", "th_true")])
    truth[m["true_valid"].ravel() == 0] = np.nan
    far = int(((m["r"] > 0) & ~seen).sum())
    notes = [f"{far} sightings beyond {max_range:g} m left out", f"R of the publisher times {inflation:g}"]
    landmarks = SimLmk(np.arange(1, 18), m["l"])
    return Recording("Lost in the Woods", t - t[0], {1: ControlLog(u, U)}, {1: raw}, {1: truth}, landmarks, notes)


def _read(file):
    """The arrays of the file as floats, their shapes checked."""
    try:
        m = {k: np.asarray(v, float) for k, v in loadmat(file).items() if not k.startswith("__")}
    except DAMAGE as error:
        raise ValueError(f"{file} is damaged or no MATLAB file ({type(error).__name__}); get it again") from error
    missing = [k for k in (*ARRAYS, "l", "d", "r_var", "b_var", "v_var", "om_var") if k not in m]
    if missing:
        raise ValueError(f"{file} is not the file of Lost in the Woods: it has no array {', '.join(missing)}")
    n = m["t"].size
    wrong = [k for k, columns in ARRAYS.items() if m[k].shape != (n, columns)]
    if wrong:
        raise ValueError(f"{file}: {wrong[0]} has shape {m[wrong[0]].shape}, wanted is {(n, ARRAYS[wrong[0]])}")
    return m
