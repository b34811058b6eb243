"""Landmarks that are recognised by what they look like: measurements carry a vector, landmarks remember theirs."""

from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

from ..simulation import SimObs
from ..slam import Matches
from ..slam.association import check_confidences, distances, far, fresh_id, gate

MEMORY = 20
"""What a landmark looks like is the mean of its first so many measurements; then the old ones fade."""


@dataclass(frozen=True)
class Described(SimObs):
    """Measurements with descriptors, beside the landmarks that they may belong to: what `Descriptors` looks at.

    Parameters
    ----------
    lmks : dict of int to Lmk
    born : dict of int to int
        Which measurement each new landmark comes from.
    """

    d: Any = None
    lmks: Any = None
    born: dict = field(default_factory=dict)


def described(raw, lmks):
    """Put the landmarks beside measurements that have descriptors; others pass as they are."""
    if getattr(raw, "d", None) is None:
        return raw
    return Described(raw.sen, raw.ids, raw.y, raw.R, raw.d, lmks)


def remember(sen, lmks, obs, raw):
    """Let landmarks remember what they look like: new ones, and those that have corrected the map.

    `Lmk.appearance` is {"d": the mean of the descriptors, "n": of how many}.

    Parameters
    ----------
    sen : Sen
    lmks, obs, raw
        As in `correct_known_lmks`, after it.
    """
    if not isinstance(raw, Described):
        return
    for id, i in raw.born.items():
        if id in lmks:
            lmks[id].appearance = {"d": np.array(raw.d[i], float), "n": 1}
    for (sensor, id), o in obs.items():
        look = lmks[id].appearance if sensor == sen.id and o.updated and id in lmks else None
        if look is not None:
            n = min(look["n"] + 1, MEMORY)
            lmks[id].appearance = {"d": look["d"] + (raw.d[o.index] - look["d"]) / n, "n": n}


@dataclass(frozen=True)
class Descriptors:
    """Gate and look together: a measurement belongs to the landmark that is where it should be and looks like it.

        z' Z^-1 z + |d_y - d_l|^2 / (std^2 (1 + 1/n))

    is chi-square with the degrees of freedom of both, if the pair is right: m of the measurement, and as many as the
    descriptor has numbers; n is how often the landmark was seen. A pair is accepted if each is the other's nearest by
    it and it passes the gate; and the place alone must pass its own. A measurement that fits no landmark, in place and
    look together, may start a new one. What lies between the two gates is not used.

    Parameters
    ----------
    std : float
        Noise of each number of a descriptor: how much two pictures of one thing differ, over sqrt(2).
    confidence : float
        A right match passes the gate with this probability.
    new_confidence : float
        A measurement starts a landmark only if it is further from all others than this quantile.
    """

    std: float = 0.2
    confidence: float = 0.999
    new_confidence: float = 1 - 1e-6

    by_id: ClassVar[bool] = False

    def __post_init__(self):
        check_confidences(self)
        if not 0 < self.std < np.inf:
            raise ValueError(f"Descriptors: std must be a positive number, got {self.std!r}")

    def __call__(self, map, obs, raw, sensor):
        """Match by place and look. Returns Matches."""
        if not isinstance(raw, Described):
            raise ValueError(
                f"the association descriptors needs what measurements look like, but those of sensor {raw.sen} have no "
                "descriptors: record them as d1, d2, ..., or take nearest_neighbour"
            )
        D, m, n = distances(obs, raw, sensor), np.shape(raw.y)[-1], raw.d.shape[1]
        J = D + self._unlike(obs, raw)
        good = np.where(D <= gate(self.confidence, m), J, np.inf)
        good[:, [not o.visible for o in obs]] = np.inf
        pairs = {}
        if good.size:
            nearest, best = good.argmin(1), good.argmin(0)
            i = np.arange(len(good))
            mutual = np.flatnonzero((best[nearest] == i) & (good[i, nearest] <= gate(self.confidence, m + n)))
            pairs = {obs[j].lmk: k for k, j in zip(mutual.tolist(), nearest[mutual].tolist(), strict=True)}
        return Matches(pairs, far(J, gate(self.new_confidence, m + n)))

    def _unlike(self, obs, raw):
        """Difference in looks of measurements from landmarks, squared, in units of its noise, shape (k, len(obs))."""
        S = np.full((len(raw.y), len(obs)), float(raw.d.shape[1]))  # of one that nobody has seen, what is expected
        for j, o in enumerate(obs):
            look = raw.lmks[o.lmk].appearance
            if look is not None:
                S[:, j] = np.sum((raw.d - look["d"]) ** 2, -1) / (self.std**2 * (1 + 1 / look["n"]))
        return S

    def birth_id(self, raw, i, lmks):
        """Id for a landmark started by measurement i."""
        id = fresh_id(lmks)
        raw.born[id] = i
        return id
