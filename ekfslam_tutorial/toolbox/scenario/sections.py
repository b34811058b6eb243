"""Sections of the user's data beside robots and sensors: world, time, landmarks, options, figure, data set."""

from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

from ...ekf import check_covariance
from ...models.landmarks import EucPnt
from ...slam import Options as SlamOptions
from ..engines import check_engine
from ..user_input import (
    check_id,
    check_kind,
    check_model,
    errors_at,
    finite_array,
    is_whole,
    short_text,
    sized_vector,
    std_vector,
)


@dataclass(kw_only=True)
class World:
    """World: where the landmarks of the simulation are (manual: World).

    Parameters
    ----------
    build : callable
        rng -> ids (N,), points (N, d). `World.of` makes one of given points.
    type : str
        Its name, for the reader.
    """

    build: Any
    type: str = ""

    @classmethod
    def of(cls, points, ids=None):
        """A world of given points (N, d) in metres, with ids 1, 2, ... unless given."""
        points = finite_array("the points of the world", points, 2)
        if ids is not None:
            finite_array("the ids of the world", ids, 1)
        ids = np.arange(1, len(points) + 1) if ids is None else np.asarray(ids)
        return cls(build=partial(_given, ids, points), type="points")


def _given(ids, points, rng):
    return ids, points


@dataclass(kw_only=True)
class Time:
    """Time (manual: Time).

    Parameters
    ----------
    dt : float
        Sampling period of the simulation, seconds. A recording has its own times.
    first : int
        Number of the first frame.
    last : int or None
        Number of the last frame; None for 100 simulated frames, or the whole recording.
    """

    dt: float = 0.1
    first: int = 1
    last: int | None = None

    def __post_init__(self):
        if not finite_array("dt", self.dt) > 0:
            raise ValueError(f"dt must be a positive number of seconds, got {self.dt}")
        for name, value in (("first", self.first), ("last", self.last)):
            if value is not None and not is_whole(value):
                raise ValueError(f"the number of the {name} frame must be whole, got {short_text(value)}")
        if self.last is not None and self.last < self.first:
            raise ValueError(f"the last frame, {self.last}, comes before the first, {self.first}")


@dataclass(kw_only=True)
class Surveyed:
    """Landmark whose place has been measured before the run: it is in the map from the start.

    Parameters
    ----------
    id : int
    position : sequence
        Metres.
    position_std : float or sequence, optional
        How well it is known: a standard deviation for all coordinates, or one for each, m.
    covariance : array_like, optional
        Instead of `position_std`, m^2.
    """

    id: int
    position: Any
    position_std: Any = None
    covariance: Any = None

    def __post_init__(self):
        check_id("the id of a surveyed landmark", self.id)

    def start(self, kind, dim):
        """Say how the map stores it, and what is known of it.

        Parameters
        ----------
        kind : LmkType
            That of new landmarks. A type with faults of its own, such as `Beacon`, is kept, with what it says of them
            before the first range; all others are Euclidean points, because a place is known, and no ray.
        dim : int
            2 or 3.

        Returns
        -------
        kind : LmkType
        l, P : ndarray, shape (k,) and (k, k)

        Raises
        ------
        ValueError
        """
        with errors_at(f"the surveyed landmark {self.id}"):
            p = sized_vector("position", self.position, dim)
            if (self.position_std is None) == (self.covariance is None):
                raise ValueError("its position_std or its covariance must be given, one of them")
            if self.covariance is None:
                P = np.diag(std_vector("position_std", self.position_std, dim) ** 2)
            else:
                P = finite_array("covariance", self.covariance, 2)
                check_covariance(P, dim, "covariance")
        if not hasattr(kind, "N"):
            return EucPnt(dim), p, P
        l, L_p, _ = kind.from_point(p)
        P_l = L_p @ P @ L_p.T
        P_l[-len(kind.N) :, -len(kind.N) :] += kind.N
        return kind, l, P_l


@dataclass(kw_only=True)
class Landmark:
    """Landmarks as they are stored (manual: Landmark, and Opt.init).

    Parameters
    ----------
    model : LmkType, optional
        Type of new landmarks; Euclidean points if not given.
    in_map : bool
        False: the landmarks are known; the run is localisation.
    non_obs_mean, non_obs_std : float or sequence
        Prior of what a bearing does not measure: the inverse distance, 1/m.
    hypotheses : int
        A sensor that measures a range and no more, such as `Range`, starts its landmarks as a ring of so many
        hypotheses at most, as many as it needs (see `toolbox.rings`); 0: it starts none. In the plane 64 are enough for
        a ring 50 m wide and 0.1 m of noise; in space take 200.
    surveyed : list of Surveyed
        Landmarks that are in the map from the start, with what is known of their places.
    """

    model: Any = None
    in_map: bool = True
    non_obs_mean: Any = 0.01
    non_obs_std: Any = 0.5
    hypotheses: int = 0
    surveyed: list = field(default_factory=list)

    def __post_init__(self):
        for entry in self.surveyed:
            check_kind("each of surveyed", entry, Surveyed)
        ids = [entry.id for entry in self.surveyed]
        if twice := [i for i in ids if ids.count(i) > 1]:
            raise ValueError(f"two surveyed landmarks have the id {twice[0]}")
        if ids and not self.in_map:
            raise ValueError("surveyed landmarks are in the map: with in_map = false all are known exactly")
        if not is_whole(self.hypotheses) or not (self.hypotheses == 0 or self.hypotheses >= 3):
            wanted = "a whole number, 3 or more, or 0 for no births from a range"
            raise ValueError(f"hypotheses must be {wanted}, got {self.hypotheses!r}")
        if self.model is not None:
            check_model("the landmark model", self.model, "landmark")
        self.prior()

    def prior(self):
        """Mean n and covariance N of the prior."""
        n = np.atleast_1d(finite_array("non_obs_mean", self.non_obs_mean))
        return n, np.diag(std_vector("non_obs_std", self.non_obs_std, len(n)) ** 2)


@dataclass(frozen=True, kw_only=True)
class Options(SlamOptions):
    """Options of the estimation (manual: Opt): those of `slam.Options`, the size of the map, and who computes.

    Landmark type and prior are not said here but in `Landmark`.

    Parameters
    ----------
    capacity : int or None
        Most states in the map (manual: numLmks times lmkSize, and the robots); None lets it grow.
    engine : str
        "fast", or "plain" for the steps as they are written in `slam`: the same estimate, to rounding.
    compressed : bool
        Of the fast engine: keep the landmarks that are seen now apart from the others. Much faster in large maps with
        `joint`. With the invariant error the estimate differs from the plain one by an effect of the second order.
    compiled : bool
        Of the fast engine: let numba compile the arithmetic of the steps. Several times faster in small maps. Needs the
        extra `compiled`.
    smooth : bool
        `ekfslam run` ends with the smoothed path: all poses by all that was measured, beside what the filter knew.
    """

    capacity: int | None = None
    engine: str = "fast"
    compressed: bool = False
    compiled: bool = False
    smooth: bool = False

    def __post_init__(self):
        self._settle_error()
        self._check()
        whole = self.capacity is None or (is_whole(self.capacity) and self.capacity >= 0)
        self._need("capacity", whole, "a whole number of 0 or more, or None")
        self._need("smooth", isinstance(self.smooth, bool), "True or False")
        check_engine(self)


VIEWS = ("", "perspective", "top", "side", "self")


@dataclass(kw_only=True)
class FigureOptions:
    """Options of the figures: what they show (manual: FigureOptions).

    Parameters
    ----------
    view : str
        'perspective', 'top', 'side', or 'self', out of the first sensor; empty for the usual one.
    orbit_deg : float
        The camera turns so much each frame.
    k : float
        Ellipses are drawn at k sigma.
    labels : bool
        Landmark ids beside the landmarks.
    limits : sequence of pairs, optional
        Lower and upper limit of each axis, metres.
    period : int
        A movie or a live view shows one frame in so many.
    fps : float
        Frames a second of a movie.
    """

    view: str = ""
    orbit_deg: float = 0.0
    k: float = 3.0
    labels: bool = True
    limits: Any = None
    period: int = 1
    fps: float = 10.0

    def __post_init__(self):
        if self.view not in VIEWS:
            raise ValueError(f"unknown view {self.view!r}; known: {', '.join(VIEWS[1:])}")
        for name in ("k", "period", "fps"):
            if not finite_array(name, getattr(self, name)) > 0:
                raise ValueError(f"{name} must be positive, got {getattr(self, name)}")
        if self.limits is not None:
            limits = finite_array("limits", self.limits, 2)
            if limits.shape not in ((2, 2), (3, 2)) or (limits[:, 0] >= limits[:, 1]).any():
                raise ValueError(
                    f"limits must be a lower and an upper limit for each axis, got {short_text(self.limits)}"
                )


@dataclass(kw_only=True)
class Data:
    """Real log to use instead of the simulator: the name of a data set, and what its loader needs to know."""

    name: str
    params: dict = field(default_factory=dict)
