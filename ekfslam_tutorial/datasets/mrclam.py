"""The UTIAS Multi-Robot Cooperative Localization and Mapping data sets (MRCLAM) as recordings.

Five robots drive among 15 landmarks and each other, watch barcodes with a camera (range and bearing), and log their
commanded speeds. Nine sets. K. Y. K. Leung, Y. Halpern, T. D. Barfoot, H. H. T. Liu, "The UTIAS Multi-Robot
Cooperative Localization and Mapping Dataset", Int. J. Robotics Research 30(8):969-974, 2011.

`mrclam_log` reads the files; here their rows become frames. The noise parameters are those of the whole family of
sets; `docs/data_tuning.md` says how they were found.
"""

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..simulation import SimLmk
from ..toolbox.recordings import ControlLog, RawLog, Recording
from .calibration import OdometryCalibration, self_calibration
from .mrclam_cache import read_cached
from .mrclam_log import truth_at
from .odometry import OdometryNoise, steps
from .sources import ENVIRONMENT, Source, data_folders, find

NAME = r"mr[cs]lam[ _-]?(?:data)?(?:set)?[ _-]?"


@dataclass(frozen=True)
class SightingNoise:
    """Standard deviations of one sighting: range sqrt(range_std^2 + (range_growth r)^2) m, bearing bearing_std rad."""

    range_std: float
    range_growth: float
    bearing_std: float

    def covariance(self, y):
        """Covariances R (m, 2, 2) of sightings y (m, 2)."""
        R = np.zeros((len(y), 2, 2))
        R[:, 0, 0] = self.range_std**2 + (self.range_growth * y[:, 0]) ** 2
        R[:, 1, 1] = self.bearing_std**2
        return R


ODOMETRY_NOISE = OdometryNoise(along=0.06, across=0.04, turn=0.15, drift=0.03)
SIGHTING_NOISE = SightingNoise(range_std=0.2, range_growth=0.1, bearing_std=0.025)
FAMILY = OdometryCalibration(left=0.94, right=0.94, spin=0.94, delay=0.2, source="typical")
HOLD = 2.0
"""Frames later than this after the last command are left out, s."""


def find_set(set, path=None):
    """Return where one set is.

    Parameters
    ----------
    set : int
        1 to 9.
    path : str or Path, optional
        The set itself (folder or zip), or a folder to look in; the folders of `EKFSLAM_DATA` when not given.

    Returns
    -------
    Source or None
    """
    if path is None:
        found = find(f"{NAME}{set}")
        return found[0] if found else None
    path = Path(path)
    if path.is_file() or (path / "Barcodes.dat").is_file() or re.fullmatch(f"{NAME}{set}", path.name, re.IGNORECASE):
        return Source(path) if path.exists() else None
    found = find(f"{NAME}{set}", [path])
    return found[0] if found else None


def load(
    set=9,
    robots=(3,),
    path=None,
    calibration=None,
    odometry_noise=ODOMETRY_NOISE,
    sighting_noise=SIGHTING_NOISE,
):
    """One set as a recording: a frame whenever one of the robots sees something.

    Parameters
    ----------
    set : int
        Which set, 1 to 9.
    robots : sequence of int
        Which robots, 1 to 5. Robot r has the sensor r.
    path : str or Path, optional
        See `find_set`.
    calibration : OdometryCalibration, optional
        The same for all robots; without it every log calibrates itself (see `calibration`).
    odometry_noise : OdometryNoise
    sighting_noise : SightingNoise

    Returns
    -------
    Recording
        Controls are steps of `models.Odometry2` with their covariances; measurements are range and bearing of
        landmarks with known ids; `met` has the sightings of those robots that were asked for.

    Raises
    ------
    FileNotFoundError
        The set, or one of its files, is not there.
    ValueError
        A file is damaged: the message names file and line.
    """
    source = find_set(set, path)
    if source is None:
        places = str(path) if path else ", ".join(map(str, data_folders())) or f"{ENVIRONMENT}, which is not set"
        raise FileNotFoundError(
            f"MRCLAM set {set} is not found in {places}; wanted is MRCLAM_Dataset{set}.zip or its unpacked folder"
        )
    log, fits = read_cached(source, robots, calibrate)
    return recording(log, calibration or fits, odometry_noise, sighting_noise)


def calibrate(robot):
    """Return what the log of one robot (RobotLog) says about its odometry; see `calibration`."""
    s = robot.landmarks
    return self_calibration(robot.odometry, s.t, s.ids, s.y, FAMILY)


def recording(log, calibration=None, odometry_noise=ODOMETRY_NOISE, sighting_noise=SIGHTING_NOISE):
    """Frames of the logs of a set; parameters as in `load`. The calibration may also be a dict, one for each robot."""
    fits = calibration if isinstance(calibration, dict) else dict.fromkeys(log.robots, calibration)
    notes = list(log.notes)
    times = _frames(log, notes)
    controls, raw, met, truth = {}, {}, {}, {}
    for r, robot in log.robots.items():
        fit = fits[r] or calibrate(robot)
        notes.append(f"robot {r}: odometry {fit}")
        t, v, w = robot.odometry.T
        controls[r] = ControlLog(*steps(t + fit.delay, v, fit.turn_rate(v, w), times, odometry_noise))
        raw[r] = _by_frame(r, robot.landmarks, times, sighting_noise)
        met[r] = _by_frame(r, robot.robots.where(np.isin(robot.robots.ids, list(log.robots))), times, sighting_noise)
        truth[r] = truth_at(robot, times)
    landmarks = SimLmk(log.ids, log.points)
    return Recording(log.name, times - times[0], controls, raw, truth, landmarks, notes, met, by_event=True)


def _by_frame(robot, sightings, times, noise):
    """Sightings by a robot, in the frames at their times."""
    offsets = np.searchsorted(sightings.t, np.append(times, np.nextafter(times[-1], np.inf)))
    s = sightings.where(slice(offsets[0], offsets[-1]))
    return RawLog(robot, offsets - offsets[0], s.ids, s.y, noise.covariance(s.y))


def _frames(log, notes):
    """Times at which a robot sees something, or a sparse ground truth knows its pose, as long as there are commands."""
    robots = log.robots.values()
    times = np.unique(np.concatenate([s.t for r in robots for s in (r.landmarks, r.robots)]))
    if not len(times):
        raise ValueError(f"{log.name}: robots {list(log.robots)} have not seen anything")
    instants = np.concatenate([r.truth[:, 0] for r in robots if not r.dense] or [times[:0]])
    times = np.union1d(times, instants[(instants > times[0]) & (instants < times[-1])])
    end = max(r.odometry[-1, 0] for r in robots) + HOLD
    late = times > end
    if late.any():
        early = times[-1] - end + HOLD
        notes.append(f"odometry ends {early:.0f} s before the last sighting: {late.sum()} frames left out")
    if late.all():
        raise ValueError(f"{log.name}: the odometry of robots {list(log.robots)} ends before they see anything")
    return times[~late]
