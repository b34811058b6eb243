"""Data association: which raw measurement belongs to which landmark, and which may start a new one.

An association is called with the map, the expectations of all landmarks, the raw measurements of one sensor in one
frame, and the sensor model. Only visible landmarks are matched; but a measurement near a landmark that should be just
out of view starts no new one. Distances are squared Mahalanobis distances of innovations: what is near is decided in
the measurement space, in units of sigma, and angles are wrapped by the sensor's own residual.
"""

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from ..ekf import chi_square, covariance, cross


@dataclass
class Matches:
    """Result of an association.

    Attributes
    ----------
    pairs : dict of int to int
        Landmark id to index of its raw measurement.
    new : list of int
        Indices of the raw measurements that may start a landmark, in the order in which they should.
    refused : set of int
        Ids of those landmarks among the pairs whose measurement must not be used, because it does not fit the others:
        they count as found, and as not fitting, whatever the gate says.
    """

    pairs: dict = field(default_factory=dict)
    new: list = field(default_factory=list)
    refused: set = field(default_factory=set)


def gate(confidence, dof):
    """Chi-square quantile: a right match passes the gate with this probability."""
    return float(chi_square.quantile(confidence, dof))


def check_confidences(association):
    """Refuse probabilities that are none.

    Raises
    ------
    ValueError
    """
    for name in ("confidence", "new_confidence"):
        value = getattr(association, name)
        if not isinstance(value, (int, float)) or not 0 < value < 1:
            raise ValueError(f"{type(association).__name__}: {name} must be between 0 and 1, got {value!r}")


def fresh_id(lmks):
    """An id that no landmark has."""
    return max(lmks, default=0) + 1


@dataclass(frozen=True)
class KnownIds:
    """Every measurement carries the id of its landmark: a simulator, or barcodes.

    Of several measurements with the same id in one frame the first is used.
    """

    by_id: ClassVar[bool] = True  # without ids nothing can be matched

    def __call__(self, map, obs, raw, sensor):
        """Match by id. Returns Matches.

        Every measurement with an id may start a landmark, if that id is not in use when its turn comes: also that of
        a landmark which this frame has deleted.
        """
        ids = np.asarray(raw.ids).tolist()
        index = {id: i for i, id in reversed(list(enumerate(ids))) if id >= 0}
        return Matches({o.lmk: index[o.lmk] for o in obs if o.lmk in index}, [index[id] for id in sorted(index)])

    def birth_id(self, raw, i, lmks):
        """Id for a landmark started by measurement i; None if there is one already."""
        id = int(raw.ids[i])
        return None if id in lmks else id


def distances(obs, raw, sensor):
    """Squared Mahalanobis distance of each measurement to each expectation, each pair on its own.

    Parameters
    ----------
    obs : list of Obs
    raw : raw measurements: `y` (k, m), and `R` (k, m, m) or None
    sensor : SensorModel

    Returns
    -------
    ndarray, shape (k, len(obs))
    """
    if not obs or not len(raw.y):
        return np.empty((len(raw.y), len(obs)))
    e, E = np.stack([o.e for o in obs]), np.stack([o.E for o in obs])
    y = np.asarray(raw.y, float)[:, None, :]
    R = sensor.R if raw.R is None else np.asarray(raw.R)[:, None]
    z = sensor.residual(np.broadcast_to(y, (len(y), *e.shape)), e[None])
    Z = np.broadcast_to(E[None] + R, (*z.shape, z.shape[-1]))
    return (z * np.linalg.solve(Z, z[..., None])[..., 0]).sum(-1)


@dataclass(frozen=True)
class NearestNeighbour:
    """Mutual nearest neighbour within a gate.

    A pair is accepted if each is the other's nearest and the distance passes the gate. A measurement that is far from
    every landmark may start a new one. What lies between the two gates is ambiguous and not used at all.

    Parameters
    ----------
    confidence : float
        A right match passes the gate with this probability.
    new_confidence : float
        A measurement starts a landmark only if it is further from all others than this quantile.
    """

    confidence: float = 0.99
    new_confidence: float = 1 - 1e-6

    def __post_init__(self):
        check_confidences(self)

    def __call__(self, map, obs, raw, sensor):
        """Match by distance. Returns Matches."""
        D, dof = distances(obs, raw, sensor), np.shape(raw.y)[-1]
        visible = [j for j, o in enumerate(obs) if o.visible]
        pairs = self._mutual(D[:, visible], [obs[j] for j in visible], gate(self.confidence, dof))
        return Matches(pairs, far(D, gate(self.new_confidence, dof)))

    @staticmethod
    def _mutual(D, obs, threshold):
        if not D.size:
            return {}
        nearest_lmk, nearest_y = D.argmin(1), D.argmin(0)
        i = np.arange(len(D))
        mutual = np.flatnonzero((nearest_y[nearest_lmk] == i) & (D[i, nearest_lmk] <= threshold))
        return {obs[j].lmk: i for i, j in zip(mutual.tolist(), nearest_lmk[mutual].tolist(), strict=True)}

    def birth_id(self, raw, i, lmks):
        """Id for a landmark started by measurement i."""
        return fresh_id(lmks)


def far(D, threshold):
    """Indices of the measurements that are further than the threshold from every expectation, visible or not."""
    return np.flatnonzero(~(D <= threshold).any(1)).tolist()  # NaN, of an expectation that is not finite, is not near


@dataclass(frozen=True)
class Jcbb:
    """Joint compatibility branch and bound: the largest set of pairs that are plausible *together*.

    J. Neira, J. D. Tardós, "Data association in stochastic mapping using the joint compatibility test", IEEE T-RA
    17(6), 2001. Expectations share the error of the robot's pose; a set of pairs that all lean the same way is
    plausible, one that leans in different ways is not, although each pair alone passes the gate.

    Parameters
    ----------
    confidence : float
        Of the gate on single pairs and on the joint distance.
    new_confidence : float
        As in `NearestNeighbour`.
    max_nodes : int
        Most hypotheses looked at; the best one so far counts then.
    """

    confidence: float = 0.99
    new_confidence: float = 1 - 1e-6
    max_nodes: int = 20_000

    def __post_init__(self):
        check_confidences(self)

    def __call__(self, map, obs, raw, sensor):
        """Match jointly. Returns Matches."""
        D, dof = distances(obs, raw, sensor), np.shape(raw.y)[-1]
        visible = [j for j, o in enumerate(obs) if o.visible]
        new, D, seen = far(D, gate(self.new_confidence, dof)), D[:, visible], [obs[j] for j in visible]
        candidates = [np.flatnonzero(row <= gate(self.confidence, dof)) for row in D]
        candidates = [js[np.argsort(row[js])] for js, row in zip(candidates, D, strict=True)]
        best = _Search(self, map, seen, raw, sensor, candidates).best
        pairs = {seen[j].lmk: i for i, j in enumerate(best) if j is not None}
        return Matches(pairs, new)

    def birth_id(self, raw, i, lmks):
        """Id for a landmark started by measurement i."""
        return fresh_id(lmks)


class _Search:
    """The branch and bound: measurement after measurement takes a landmark or none."""

    def __init__(self, jcbb, map, obs, raw, sensor, candidates):
        self.jcbb, self.candidates, self.nodes = jcbb, candidates, 0
        self.m = np.shape(raw.y)[1]
        used = sorted({int(j) for js in candidates for j in js})
        self.column = {j: k for k, j in enumerate(used)}
        PHt = [cross(map, obs[j].blocks) for j in used]
        self.HPHt = [[covariance(P, obs[i].blocks) for P in PHt] for i in used]  # H_i P H_j'
        self.z = {(i, int(j)): sensor.residual(raw.y[i], obs[j].e) for i, js in enumerate(candidates) for j in js}
        self.R = [sensor.R if raw.R is None else raw.R[i] for i in range(len(candidates))]
        self.best, self.best_key = [None] * len(candidates), (0, 0.0)
        self._branch([])

    def _branch(self, chosen):
        """Extend a partial hypothesis; cut it off where it cannot beat the best one."""
        self.nodes += 1
        n_paired = sum(j is not None for j in chosen)
        if len(chosen) == len(self.candidates):
            key = (n_paired, -self._distance(chosen))
            if key > self.best_key or (n_paired and self.best_key[0] == 0):
                self.best, self.best_key = list(chosen), key
            return
        if n_paired + len(self.candidates) - len(chosen) < self.best_key[0] or self.nodes > self.jcbb.max_nodes:
            return
        for j in self.candidates[len(chosen)].tolist():
            if j not in chosen:
                extended = [*chosen, j]
                if self._distance(extended) <= gate(self.jcbb.confidence, self.m * (n_paired + 1)):
                    self._branch(extended)
        self._branch([*chosen, None])

    def _distance(self, chosen):
        """Squared Mahalanobis distance of the stacked innovations of a hypothesis."""
        pairs = [(i, j) for i, j in enumerate(chosen) if j is not None]
        if not pairs:
            return 0.0
        z = np.concatenate([self.z[p] for p in pairs])
        columns = [self.column[j] for _, j in pairs]
        Z = np.block([[self.HPHt[a][b] for b in columns] for a in columns])
        for k, (i, _) in enumerate(pairs):
            Z[k * self.m : (k + 1) * self.m, k * self.m : (k + 1) * self.m] += self.R[i]
        return float(z @ np.linalg.solve(Z, z))
