"""The scores of many runs, and what they say together."""

from dataclasses import dataclass

import numpy as np

from .consistency import anees_band


@dataclass(frozen=True, eq=False)
class MonteCarlo:
    """Scores of many runs. Errors are lengths; NaN stands for what is not known or not estimated.

    Parameters
    ----------
    name, seed : str, int
        Of the scenario, and of the series.
    wanted : int
        Number of runs that there were to be.
    runs : ndarray of int, shape (R,)
        Numbers of those that are done, from 0.
    seeds : ndarray of uint64, shape (R,)
    failures : dict of int to str
        Runs that could not be finished, and why. Their scores are NaN.
    robots : list of int
        Ids of the K robots.
    dim, dof : int
        Of a position, and of a pose.
    t : ndarray, shape (F,)
        Time of each frame, s.
    position, heading : ndarray, shape (R, F, K)
        Errors of position (m) and orientation (rad).
    position_std, heading_std : ndarray, shape (R, F, K)
        What the filter takes for their root mean square.
    nees : ndarray, shape (R, F, K)
        Of the pose.
    landmark_rmse, landmark_nees, n_landmarks, n_left_over : ndarray, shape (R,)
        Of the map at the end: m, mean over the landmarks, number, and how many of them have no true one (`partners`).
    """

    name: str
    seed: int
    wanted: int
    runs: np.ndarray
    seeds: np.ndarray
    failures: dict
    robots: list
    dim: int
    dof: int
    t: np.ndarray
    position: np.ndarray
    heading: np.ndarray
    position_std: np.ndarray
    heading_std: np.ndarray
    nees: np.ndarray
    landmark_rmse: np.ndarray
    landmark_nees: np.ndarray
    n_landmarks: np.ndarray
    n_left_over: np.ndarray

    @property
    def complete(self):
        """True if all runs are done."""
        return len(self.runs) == self.wanted

    def over_time(self, name):
        """A score of the poses in each frame, over all runs: mean of nees, root of the mean square of others.

        Returns
        -------
        ndarray, shape (F, K)
        """
        values = getattr(self, name)
        return _mean(values, 0) if name == "nees" else np.sqrt(_mean(values**2, 0))

    def band(self, confidence=0.95):
        """Band in which the NEES of an honest filter, a mean over the finished runs, is with this probability."""
        return anees_band(self.dof, max(len(self.runs) - len(self.failures), 1), confidence)

    def per_run(self):
        """Figures of each run, as a list of dictionaries: run, seed, rmse_m, heading_rmse_deg, nees_mean, ..."""
        rows = zip(
            self.runs.tolist(),
            self.seeds.tolist(),
            np.sqrt(_mean(self.position**2, (1, 2))),
            np.rad2deg(np.sqrt(_mean(self.heading**2, (1, 2)))),
            _mean(self.nees, (1, 2)),
            self.landmark_rmse,
            self.landmark_nees,
            *([None if np.isnan(n) else int(n) for n in counts] for counts in (self.n_landmarks, self.n_left_over)),
            strict=True,
        )
        names = "run", "seed", "rmse_m", "heading_rmse_deg", "nees_mean", "landmark_rmse_m", "landmark_nees_mean"
        return [dict(zip((*names, "n_landmarks", "n_left_over"), map(_known, row), strict=True)) for row in rows]

    def summary(self, confidence=0.95):
        """Figures of all runs together.

        Returns
        -------
        dict
            rmse_m, heading_rmse_deg, landmark_rmse_m and landmark_rmse_median_m, which one landmark far away does not
            spoil; nees_mean with nees_dof, the mean of an honest filter;
            nees_band, where the mean over the runs should be in one frame; nees_in_band, the share of frames in which
            it is (frames follow each other and are not independent); nees_last, in the last frame, and its verdict;
            landmark_nees_mean with landmark_nees_dof; n_left_over_mean, landmarks without a true one; and `robots`,
            by id, for each robot.
        """
        low, high = self.band(confidence)
        anees = self.over_time("nees")
        share = (
            np.mean((anees >= low) & (anees <= high), where=np.isfinite(anees)) if np.isfinite(anees).any() else None
        )
        last = _known(_mean(anees[-1], 0))
        words = {True: "over-confident", False: "as it should be"}
        verdict = "not known" if last is None else "too cautious" if last < low else words[last > high]
        head = {"scenario": self.name, "seed": self.seed, "runs": len(self.runs), "runs_wanted": self.wanted}
        head |= {"complete": self.complete, "failed": len(self.failures), "frames": len(self.t)}
        poses = {str(id): self._poses(k) for k, id in enumerate(self.robots)}
        return (
            head
            | self._poses(slice(None))
            | {
                "nees_dof": self.dof,
                "nees_band": [low, high],
                "nees_confidence": confidence,
                "nees_in_band": _known(share),
                "nees_last": last,
                "nees_last_verdict": verdict,
                "landmark_rmse_m": _known(np.sqrt(_mean(self.landmark_rmse**2, 0))),
                "landmark_rmse_median_m": _known(_median(self.landmark_rmse)),
                "landmark_nees_mean": _known(_mean(self.landmark_nees, 0)),
                "landmark_nees_dof": self.dim,
                "n_left_over_mean": _known(_mean(self.n_left_over, 0)),
                "failures": {str(run): why for run, why in self.failures.items()},
                "robots": poses,
            }
        )

    def _poses(self, k):
        return {
            "rmse_m": _known(np.sqrt(_mean(self.position[..., k] ** 2, None))),
            "heading_rmse_deg": _known(np.rad2deg(np.sqrt(_mean(self.heading[..., k] ** 2, None)))),
            "nees_mean": _known(_mean(self.nees[..., k], None)),
            "nees_median": _known(_median(self.nees[..., k])),
        }


def _mean(a, axis):
    """Mean of what is known; NaN where nothing is."""
    known = np.isfinite(a)
    n = known.sum(axis)
    return np.where(n > 0, np.where(known, a, 0.0).sum(axis) / np.maximum(n, 1), np.nan)


def _median(a):
    return np.median(a[np.isfinite(a)]) if np.isfinite(a).any() else np.nan


def _known(value):
    """None instead of NaN, which JSON does not have; whole numbers as they are."""
    if value is None or isinstance(value, int):
        return value
    return float(value) if np.isfinite(value) else None
