"""Lost in the Woods: one robot among 17 tubes with dense ground truth, as a recording.

The file `dataset2.mat` of the course AER1513 of the University of Toronto: speed and turn rate of the robot, range and
bearing of each tube from a laser `d` metres ahead of its centre, at 10 Hz for 21 minutes.

The heading of the file's truth is that of the laser: the bearings fit it to 0.2 deg, and the true positions move
4.6 deg to the right of it. The heading of a `Unicycle` is the direction in which it drives. So the truth is turned by
what its own positions say; no measurement is asked.
"""

import numpy as np

from ..geometry import Frame2, wrap
from ..models.motion import Unicycle
from ..models.sensors.range_bearing import polar
from ..simulation import SimLmk
from ..toolbox.recordings import ControlLog, RawLog, Recording
from .matlab import read_mat
from .sources import get_file

FILE = "dataset2.mat"
ARRAYS = {"t": 1, "v": 1, "om": 1, "r": 17, "b": 17, "x_true": 1, "y_true": 1, "th_true": 1, "true_valid": 1}
MAX_RANGE = 3.0
"""Sightings further than this are left out, m: a tube far away is a few beams wide, and the next one is near."""

INFLATION = 4.0
"""Of the publisher's noise covariance R: his residuals are taken as white, and they are not."""

CHORD = 1.0
"""The direction of driving is that from a true position to the one so much later, s."""
LEAST_MOVE, MOST_TURN = 0.05, 0.1
"""Such a chord is as long as this, m, and the robot has turned by less, rad."""
FEWEST_CHORDS = 100
"""With fewer of them, the truth does not tell."""


def load(path=None, max_range=MAX_RANGE, inflation=INFLATION):
    """The log as a recording of robot 1 and its laser, sensor 1.

    Parameters
    ----------
    path : str or Path, optional
        The file, or a folder with it; without it, below the folders of `EKFSLAM_DATA`.
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
    file = get_file("Lost in the Woods", FILE, path)
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
    turned = drives_beside(t, truth)
    truth[:, 2] = wrap(truth[:, 2] + turned)
    far = int(((m["r"] > 0) & ~seen).sum())
    notes = [f"{far} sightings beyond {max_range:g} m left out", f"R of the publisher times {inflation:g}"]
    if turned:
        notes.append(f"heading of the truth turned by {np.rad2deg(turned):.1f} deg: that way its own positions move")
    landmarks = SimLmk(np.arange(1, 18), m["l"])
    return Recording("Lost in the Woods", t - t[0], {1: ControlLog(u, U)}, {1: raw}, {1: truth}, landmarks, notes)


def drives_beside(t, truth):
    """Angle from the heading of true poses to the direction in which their positions move.

    The median over the chords of a second on which the robot hardly turns: the chord of an arc has the direction of the
    heading half-way.

    Parameters
    ----------
    t : ndarray, shape (K,)
        Times at even steps, s.
    truth : ndarray, shape (K, 3)
        x, y, m; heading, rad. NaN where it is not known.

    Returns
    -------
    float
        rad; positive if the robot drives to the left of its heading, 0 if the truth does not tell.
    """
    half = max(1, round(CHORD / 2 / np.median(np.diff(t)))) if len(t) > 1 else 1
    if len(t) <= 2 * half:
        return 0.0
    before, middle, after = truth[: -2 * half], truth[half:-half], truth[2 * half :]
    way = (after - before)[:, :2]
    with np.errstate(invalid="ignore"):  # NaN is in no chord
        straight = np.abs(wrap(after[:, 2] - before[:, 2])) < MOST_TURN
        asked = straight & (np.hypot(*way.T) > LEAST_MOVE) & np.isfinite(middle[:, 2])
    beside = wrap(np.arctan2(way[asked, 1], way[asked, 0]) - middle[asked, 2])
    beside = beside[np.abs(beside) < np.pi / 2]  # the others are driven backwards
    return float(np.median(beside)) if len(beside) >= FEWEST_CHORDS else 0.0


def twin(seed=1, n=3000):
    """A simulated log of the same form, for those who do not have the file: white noise of the publisher's size.

    Parameters
    ----------
    seed : int
        Of everything random.
    n : int
        Number of frames, 10 a second.

    Returns
    -------
    Recording
    """
    rng, laser = np.random.default_rng(seed), Frame2(np.array([0.219, 0.0, 0.0]))
    tubes = rng.uniform([-2, -5], [10, 5], (17, 2))
    Q, R = np.diag([0.0044, 0.0082]), np.diag([0.0009, 0.00067])
    true_u = np.column_stack([np.full(n, 0.2), 0.1 * np.sin(0.02 * np.arange(n)) + 0.1])
    truth, rows = np.zeros((n, 3)), []
    for k in range(n):
        if k:
            truth[k] = Unicycle().move(truth[k - 1], true_u[k], 0.1)[0]
        seen = Frame2(truth[k]).compose(laser)[0].to_frame(tubes)[0]
        y = polar(seen)[0]
        rows.append([np.concatenate([[i], y[i]]) for i in np.flatnonzero(y[:, 0] < MAX_RANGE)])
    truth[:, 2] = wrap(truth[:, 2])
    table = np.array([row for frame in rows for row in frame]).reshape(-1, 3)
    y = table[:, 1:] + rng.multivariate_normal(np.zeros(2), R, len(table))
    u = true_u + rng.multivariate_normal(np.zeros(2), Q, n)
    raw = RawLog(1, np.cumsum([0, *map(len, rows)]), table[:, 0].astype(int) + 1, y, np.tile(R, (len(y), 1, 1)))
    notes = [f"simulated twin of Lost in the Woods, seed {seed}: no real robot was here"]
    log = ControlLog(u, np.tile(Q, (n, 1, 1)))
    return Recording("twin of Lost in the Woods", 0.1 * np.arange(n), {1: log}, {1: raw}, {1: truth},
                     SimLmk(np.arange(1, 18), tubes), notes)  # fmt: skip


def _read(file):
    """The arrays of the file as floats, their shapes checked."""
    wanted = (*ARRAYS, "l", "d", "r_var", "b_var", "v_var", "om_var")
    m = {k: np.asarray(v, float) for k, v in read_mat(file, wanted).items()}
    missing = [k for k in wanted if k not in m]
    if missing:
        raise ValueError(f"{file} is not the file of Lost in the Woods: it has no array {', '.join(missing)}")
    n = m["t"].size
    wrong = [k for k, columns in ARRAYS.items() if m[k].shape != (n, columns)]
    if wrong:
        raise ValueError(f"{file}: {wrong[0]} has shape {m[wrong[0]].shape}, wanted is {(n, ARRAYS[wrong[0]])}")
    return m
