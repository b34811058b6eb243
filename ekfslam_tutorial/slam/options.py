"""What the user may decide about the estimation (manual: `Opt`)."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..ekf import check_covariance, real
from .association import KnownIds

ERRORS = "invariant", "additive"
ENDS = "extend", "keep"
LEAST = {"n_updates": 0, "max_lmks": 0, "reopen_after": 1, "retry_after": 1, "lost_after": 1}


@dataclass(frozen=True, eq=False)
class Options:
    """Options of the estimation.

    Parameters
    ----------
    lmk_type : LmkType or None
        How new landmarks are stored; None for Euclidean points of the sensor's world.
    n, N : array_like, shape (k,) and (k, k)
        Prior of what a bearing-only sensor does not measure, mean and covariance: an inverse distance, 1/m
        (manual: nonObsMean, nonObsStd). Used where the sensor leaves something open. A line leaves two
        numbers open: one that is given here stands for both.
    association : callable
        `KnownIds()`, `NearestNeighbour(...)` or `Jcbb(...)`.
    n_updates : int or None
        At most so many corrections per sensor and frame, the most uncertain expectations first; None for no limit.
    joint : bool
        Correct with all landmarks of a frame at once: much faster in large maps. Otherwise one after the other, each
        projected again from what the others have corrected: a little better where the models are far from linear.
    md2_threshold : float
        Innovation gate: a measurement with a squared Mahalanobis distance of this or more is not used
        (manual: MD2th).
    reopen_after : int or None
        A robot is lost when so many innovations in a row have failed the gate: its pose is then made more uncertain,
        which opens the gate again; None for never.
    reopen_std : tuple of 2 float
        By how much: standard deviations of position (m) and of each angle (rad).
    retry_after : int or None
        A landmark is locked out when so many of its own innovations in a row have failed the gate: it is then made more
        uncertain by the first of `reopen_std` (m); None for never.
    reproject : bool
        Unless `joint`: compute each expectation again from the corrected map before its own correction.
    reparametrize : bool
        Turn a landmark into a Euclidean point when it has become linear enough.
    lin_test : float
        Threshold of that linearity test (manual: linTestIdp).
    n_inits : tuple of 2 int, or None
        At most so many new landmarks per sensor: in the first frame, and in each later one; None for no limit.
    init_margin : float
        A new landmark must be seen at least so far inside the sensor's measurement space (pixels, for a camera).
    max_lmks : int or None
        Most landmarks in the map.
    min_search : int
        Landmarks looked for at least so often may be deleted.
    min_match_ratio, min_inlier_ratio : float
        They are, if found in less than this share of the searches, or used in less than this share of the matches.
    ends : str
        What is done with the ends of a line when it has corrected the map. "extend": the stretch that is remembered
        grows by what was seen, or is replaced by it as long as the line is vague. "keep": it stays what it was at birth
        (manual: extPolicy).
    lost_after : int or None
        A landmark that was not found so many times in a row is lost and leaves the map: tracks in images come and go;
        None for never.
    keep_lost : int
        At most so many of the lost ones stay in the map, those that were used most often.
    wander : float
        Landmarks do not stand still, they are tracks that creep over what they are on: process noise of a random walk
        of each that was found last time, m/sqrt(s).
    min_rho : float
        An inverse distance that a correction turned negative is set to this (1/m).
    error : str or None
        "invariant": after each correction the covariance is carried along with the estimate, so that the filter does
        not become certain of its heading by mistake (see `correct_invariant`). "additive": the textbook's filter.
        None becomes "invariant"; or "additive" with `first_estimates`.
    first_estimates : bool
        Take all Jacobians at first estimates, another cure of the same illness (see `slam.first_estimates`), for the
        additive error. For robots in the plane and Euclidean landmarks.
    """

    lmk_type: Any = None
    n: Any = (0.01,)
    N: Any = ((0.25,),)
    association: Any = field(default_factory=KnownIds)
    n_updates: int | None = None
    md2_threshold: float = np.inf
    reopen_after: int | None = None
    reopen_std: tuple = (0.3, 0.5)
    retry_after: int | None = None
    reproject: bool = True
    reparametrize: bool = False
    lin_test: float = 0.1
    n_inits: tuple | None = None
    init_margin: float = 0.0
    max_lmks: int | None = None
    min_search: int = 10
    min_match_ratio: float = 0.0
    min_inlier_ratio: float = 0.0
    ends: str = "extend"
    lost_after: int | None = None
    keep_lost: int = 0
    wander: float = 0.0
    min_rho: float = 1e-3
    joint: bool = False
    error: str | None = None
    first_estimates: bool = False

    def __post_init__(self):
        object.__setattr__(self, "n", np.atleast_1d(real("the mean n of the prior", self.n)).copy())
        object.__setattr__(self, "N", np.atleast_2d(real("the covariance N of the prior", self.N)).copy())
        check_covariance(self.N, len(self.n), "the covariance N of the prior")
        self._settle_error()
        self._check()
        object.__setattr__(self, "md2_threshold", float(self.md2_threshold))  # whatever type, flags are plain bools

    def prior(self, kind):
        """Prior n, N for a landmark type; a single number for each of its `priors`, times that."""
        k = np.array(getattr(kind, "priors", self.n))
        if len(k) == len(self.n):
            return self.n, self.N
        return self.n[0] * k, self.N[0, 0] * np.eye(len(k))

    def _settle_error(self):
        """Say which error there is, where the user has not."""
        if self.error is None:
            object.__setattr__(self, "error", "additive" if self.first_estimates else "invariant")

    def _check(self):
        """Refuse what no run can begin with, or what would stop one on the way."""
        for name, least in LEAST.items():
            value = getattr(self, name)
            self._need(name, value is None or _whole(value, least), f"a whole number of {least} or more, or None")
        two = self.n_inits is None or _two(self.n_inits, _whole)
        self._need("n_inits", two, "two whole numbers of 0 or more, or None")
        two = _two(self.reopen_std, _number) and max(self.reopen_std) < np.inf
        self._need("reopen_std", two, "two finite numbers of 0 or more")
        for name in ("min_search", "keep_lost"):
            self._need(name, _whole(getattr(self, name)), "a whole number of 0 or more")
        for name in ("init_margin", "wander"):
            self._need(name, _number(getattr(self, name)) and getattr(self, name) < np.inf, "a number of 0 or more")
        for name in ("md2_threshold", "lin_test", "min_rho"):
            self._need(name, _number(getattr(self, name)) and getattr(self, name) > 0, "a positive number")
        for name in ("min_match_ratio", "min_inlier_ratio"):
            self._need(name, _number(getattr(self, name)) and getattr(self, name) <= 1, "between 0 and 1")
        made = callable(self.association) and not isinstance(self.association, type)
        self._need("association", made, "an object to call, such as KnownIds()")
        self._need("error", self.error in ERRORS, " or ".join(map(repr, ERRORS)))
        self._need("ends", self.ends in ENDS, " or ".join(map(repr, ENDS)))
        cured = "'additive' with first_estimates (both cure the same illness: take one of them)"
        self._need("error", not self.first_estimates or self.error == "additive", cured)

    def _need(self, name, ok, what):
        if not ok:
            raise ValueError(f"{name} must be {what}, got {getattr(self, name)!r}")


def _number(value, least=0):
    return isinstance(value, int | float | np.integer | np.floating) and not isinstance(value, bool) and value >= least


def _whole(value, least=0):
    return isinstance(value, int | np.integer) and _number(value, least)


def _two(values, is_it):
    return isinstance(values, tuple | list | np.ndarray) and len(values) == 2 and all(map(is_it, values))
