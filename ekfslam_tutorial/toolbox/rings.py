"""Beacons that are born from one range: a ring of hypotheses, which dies out to one.

A range r says that a beacon is somewhere on a circle round the sensor; in space, on a sphere. A Gaussian as wide as a
circle is none, so the circle is cut into H sectors, and each is a *hypothesis*: a Gaussian with the mean and the
covariance of its sector, and a weight, 1/H at first. Each hypothesis has a belief of its own of where the beacon is,
and of where the robot is. Each new range then

1. corrects every hypothesis as if it were the right one;
2. multiplies its weight by the likelihood that it has given to the range: Bayes' rule;
3. takes out those whose weight has become nothing, and joins neighbours, as soon as one Gaussian does for them.

Near by, the circle of a range is smaller: a hypothesis along which it was straight from afar is cut in pieces when the
robot comes near. Where there is no room for the pieces, the ring begins anew with the next range. When one is left, and
the circle of a range is straight along it, from nearer by, too, it becomes a landmark like any other, and the robot
believes what it believed.

All hypotheses of a beacon are one state of the map, H times [x_h, l_h]: a copy of the robot's state, which moves as the
robot does, and the beacon. So whatever else is measured corrects them, too. **The rest of the map is not corrected as
long as there are several**: a range that belongs to one hypothesis must not be used by all. It is taken into account (a
filter of Schmidt and Kalman, "consider" filter): the covariance of each hypothesis with all the rest stays right. The
copy of the robot is what makes the weights right: without it the wandering of the robot would be counted against each
hypothesis again with each range. Two beacons mirrored in a straight path keep both a good part of the weight until the
path turns; no filter can do better.

J.-L. Blanco, J.-A. Fernandez-Madrigal, J. Gonzalez, "Efficient probabilistic range-only SLAM", IROS 2008 (the sum of
Gaussians); J. Djugash, S. Singh, "A robust method of localization and mapping using only range", ISER 2008; S. F.
Schmidt, "Application of state-space methods to navigation problems", 1966.

Everything here is done by the map's own `add`, `put` and `remove`, so both engines do the same.
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..ekf import MapFull, covariance, cross, innovation
from ..geometry import ORIGIN, wrap
from ..models.observation import to_sensor
from ..models.turning import turning
from ..slam import Event, Lmk
from ..slam.projection import correct_invariant
from ..slam.upkeep import free_slot

NOTHING = 1e-7
"""A hypothesis with a weight below this is taken out."""

CERTAIN = 1 - 1e-5
"""A hypothesis with a weight above this is the one that is left."""

STRAIGHT = 0.3
"""A Gaussian is straight if the circle of a range bends away from it by less than this, in sigmas of the range."""

DECIDED = STRAIGHT / 3
"""A beacon is a landmark once its Gaussian bends by less than this: it is straight from a third of the distance, too. A
landmark is corrected to first order only, however near the sensor comes to it."""

BENT = 0.5
"""A hypothesis that bends by more than this, in the same units, is cut: the sensor has come too near for it."""

CROWDED = 1.0
"""A hypothesis that bends by more than this tells a range worse by its bend than the sensor does by its noise."""

PIECES = np.sqrt(2) * np.array([-1, 0, 1]), np.array([1, 4, 1]) / 6, np.ones(3) / 3
"""A standard normal number as a sum of three Gaussians: their means, weights and variances."""

NEIGHBOURS = 16.0
"""Hypotheses are neighbours if their squared distance, in units of the covariance of one, is below this: 4 sigma. At
birth those next to each other are 3.5 sigma apart."""


SURE = 1e-12
"""Variance with which two beliefs of one state are said to be the same: for the digits."""

SMALL = 1e-9
"""A robot that has become surer by less than this share of its variance has learnt nothing."""

TINY = np.finfo(float).tiny


@dataclass(eq=False)
class Ring:
    """The hypotheses of one beacon.

    Attributes
    ----------
    id : int
        Of the beacon.
    type : LmkType
        What each hypothesis is.
    w : ndarray, shape (H,)
        Their weights; the sum is 1.
    rob : int
        Id of the robot that has started it; only its ranges are used.
    m : int
        Length of the copy of the robot's state, 0 where that is known.
    r : slice
        Range in the map: [x_h, l_h] of all hypotheses, one after the other.
    n_used, n_refused : int
        How many ranges have been used, and how many no hypothesis has explained.
    """

    id: int
    type: Any
    w: np.ndarray
    rob: int
    m: int
    r: slice = field(repr=False)
    n_used: int = 1
    n_refused: int = 0

    def states(self, map):
        """State vectors [x_h, l_h] of the hypotheses, shape (H, m + k)."""
        return map.state(self.r).reshape(len(self.w), -1)

    def robots(self, map):
        """Where the robot is as each of them believes, shape (H, m), and the covariances of that, (H, m, m)."""
        return self.states(map)[:, : self.m], diagonal(map.block(self.r), len(self.w))[:, : self.m, : self.m]

    def points(self, map):
        """Where the hypotheses are, and their covariances.

        Returns
        -------
        p : ndarray, shape (H, d)
        P : ndarray, shape (H, d, d)
        """
        p, P_l = self.type.point(self.states(map)[:, self.m :])
        return p, P_l @ diagonal(map.block(self.r), len(self.w))[:, self.m :, self.m :] @ t(P_l)

    def joined(self, map, which=slice(None)):
        """Mean and covariance of some hypotheses together, all if not given, as if they were one Gaussian.

        Returns
        -------
        p : ndarray, shape (d,)
        P : ndarray, shape (d, d)
        """
        p, P = self.points(map)
        w = self.w[which]
        return moments(w / w.sum(), p[which], P[which])


class Rings:
    """All beacons of a run that are not decided yet; the loop asks it for births, corrections and decisions.

    Parameters
    ----------
    n : int
        Most hypotheses of a ring; 0 for no births from a range.
    kind : LmkType
        What each of them is.

    Attributes
    ----------
    live : dict of int to Ring
        By beacon id.
    """

    def __init__(self, n, kind):
        self.n, self.kind, self.live = n, kind, {}

    def starts(self, sensor):
        """Return True if this sensor's landmarks are born as rings."""
        return bool(self.n) and rings_by(sensor)

    def moved(self, map, rob, dt):
        """Context manager around a motion of the robot: its copies in the rings move, too."""
        return _Moved([ring for ring in self.live.values() if ring.rob == rob.id and ring.m], map, rob, dt)

    def carried(self, map, rob, opt):
        """Context manager around a correction by the robot: with the invariant error, the rings are carried along."""
        return _Carried(self.live, map, rob, opt)

    def see(self, map, rob, sen, lmks, raw, opt, n_max=None):
        """Use the ranges of a sensor to beacons that are no landmarks yet.

        Parameters
        ----------
        map : Map
        rob : Rob
        sen : Sen
        lmks : dict of int to Lmk
            Gets the beacons that are decided.
        raw : raw measurements: `ids` (k,), `y` (k, 1), `R` (k, 1, 1) or None
        opt : Options
        n_max : int, optional
            Most rings to start.

        Returns
        -------
        list of Event
            innovation (flag: some hypothesis explains the range), initialisation (the beacon is a landmark now) or
            refused (the map had no room for a ring).
        """
        events, n_born = [], 0
        for i in opt.association(map, [], raw, sen.model).new:
            id, R = int(raw.ids[i]), sen.model.R if raw.R is None else np.asarray(raw.R[i], float)
            y = np.asarray(raw.y[i], float)
            if id in lmks:
                self.forget(map, id)
            elif id in self.live and self.live[id].rob == rob.id:
                events += self._correct(map, rob, sen, lmks, self.live[id], y, R, opt)
            elif id not in self.live and (n_max is None or n_born < n_max):
                n_born += 1
                events += self._start(map, rob, sen, lmks, id, y, R, opt)
        return events

    def forget(self, map, id):
        """Take a ring out of the map: another sensor has started that beacon."""
        if id in self.live:
            map.remove(self.live.pop(id).r)

    def _start(self, map, rob, sen, lmks, id, y, R, opt):
        """Return the events of a birth; a range that is shorter than its noise starts none."""
        if sen.model.distance(y) <= 3 * np.sqrt(R[0, 0]):
            return []
        try:
            if opt.max_lmks is not None and len(lmks) + len(self.live) >= opt.max_lmks:
                raise MapFull
            self.live[id] = ring_of(map, rob, sen, id, sen.lmk_type or self.kind, y, R, self.n)
        except MapFull:
            return [Event("refused", rob.id, sen.id, id)]
        return []

    def _correct(self, map, rob, sen, lmks, ring, y, R, opt):
        std = np.sqrt(R[0, 0])
        cut(map, rob, sen, ring, std, self.n)
        if crowded(map, rob, sen, ring, sen.model.distance(y), std, self.n):
            self.forget(map, ring.id)
            return self._start(map, rob, sen, lmks, ring.id, y, R, opt)
        l = ring.states(map)
        used = correct_ring(map, rob, sen, ring, y, R, opt.md2_threshold)
        if used and ring.m and opt.error == "invariant":
            carry_ring(map, rob, ring, l)
        events = [Event("innovation", rob.id, sen.id, ring.id, used)]
        if used:
            thin_out(map, rob, sen, ring, std)
            h = np.argmax(ring.w)
            p, P = seen(map, rob, sen, ring)
            if ring.w[h] > CERTAIN and bend(p[h], P[h], std) < DECIDED:
                self._decide(map, rob, lmks, ring, int(h), opt)
                events.append(Event("initialisation", rob.id, sen.id, ring.id))
        return events

    def _decide(self, map, rob, lmks, ring, h, opt):
        """Let the robot believe what the hypothesis believes of it, and make the hypothesis a landmark."""
        size = ring.m + ring.type.size
        x, l = (
            slice(ring.r.start + h * size + a, ring.r.start + h * size + b) for a, b in ((0, ring.m), (ring.m, size))
        )
        if ring.m:
            x_h, x_r, T = map.state(x), rob.state(map), np.eye(ring.m)
            if opt.error == "invariant":  # to move the world moves both, and must not look like a difference
                T = carrying(robot_gauge(rob, x_h), robot_gauge(rob, x_r), rob.motion.frame.size)
            blocks = (rob.r, np.eye(ring.m)), (x, -T)  # both are beliefs of one state: their difference is 0
            PHt = cross(map, blocks)
            inn = innovation(difference(rob, x_h, x_r), covariance(PHt, blocks), SURE * np.eye(ring.m))
            with self.carried(map, rob, opt):
                correct_invariant(map, rob, lmks, PHt, inn, opt)
        del self.live[ring.id]
        r, n = map.put(ring.r, map.state(l), map.P[l].copy(), map.block(l)), ring.n_used
        slot = free_slot(lmks.values())
        lmks[ring.id] = Lmk(ring.id, ring.type, r=r, slot=slot, n_search=n, n_match=n, n_inlier=n)


def rings_by(sensor):
    """Return True if a sensor model measures a distance and no more: its landmarks can be born as rings."""
    return hasattr(sensor, "distance") and not hasattr(sensor, "retro")


# --- birth -----------------------------------------------------------------------------------------------------------


def ring_of(map, rob, sen, id, kind, y, R, n):
    """A new ring in the map, from one range: the inverse model of each sector, and `augment` for all of them.

    Returns
    -------
    Ring

    Raises
    ------
    MapFull
        If there is no room for it.
    """
    F, F_r, F_s = rob.frame(map).compose(sen.frame(map))
    n = how_many(sen.model.distance(y), np.sqrt(R[0, 0]), F.dim, n)
    v, V = sectors(sen.model.distance(y), R[0, 0], F.dim, n)
    if hasattr(kind, "from_apparent"):
        ls, LS_v, LS_n = kind.from_apparent(v, np.zeros((n, kind.prior)))
        N = kind.N
    else:
        ls, LS_v, LS_n = kind.from_point(v)
        N = np.zeros((0, 0))
    l, L_f, L_ls = kind.from_frame(F, ls)

    L_v, L_n = L_ls @ LS_v, L_ls @ LS_n
    Q = L_v @ V @ np.swapaxes(L_v, -1, -2) + L_n @ N @ np.swapaxes(L_n, -1, -2)
    L_f, m = np.broadcast_to(L_f, (n, kind.size, F.size)), 0 if rob.r is None else len(rob.state(map))
    x = np.broadcast_to(rob.state(map)[:m], (n, m))
    S_x = np.concatenate([np.broadcast_to(np.eye(m), (n, m, m)), padded(L_f @ F_r, m)], 1)
    S_s = np.concatenate([np.zeros((n, m, F.size)), L_f @ F_s], 1)
    Q = np.pad(Q, ((0, 0), (m, 0), (m, 0)))
    blocks = [(r, S.reshape(n * S.shape[1], -1)) for r, S in ((rob.r, S_x), (sen.r, S_s)) if r is not None]
    P_lm = sum((S @ map.P[r] for r, S in blocks), np.zeros((n * (m + kind.size), map.P.shape[1])))
    P_ll = sum((P_lm[:, r] @ S.T for r, S in blocks), block_diagonal(Q))
    r = map.add(np.concatenate([x, l], 1).ravel(), (P_ll + P_ll.T) / 2, P_lm)
    return Ring(id, kind, np.full(n, 1 / n), rob.id, m, r)


def how_many(r, std, dim, most):
    """How many sectors a ring needs for each of them to be straight, between 8 and the most there may be.

    The wider the ring, and the better its range is known, the more. A sector of the angle a has the variance
    (r a)^2 / 12 along it, a cap of the half angle a (r a)^2 / 4; see `bend`.
    """
    wanted = STRAIGHT * np.sqrt(2) * std / r
    n = 2 * np.pi / np.sqrt(12 * wanted) if dim == 2 else 4 / (4 * wanted)
    return int(min(max(np.ceil(n), 8), most))


def sectors(r, var, dim, n):
    """Mean and covariance of each sector of the ring of a range: those of a beacon that may be anywhere in it.

    Parameters
    ----------
    r, var : float
        The range, m, and its variance.
    dim, n : int
        In the plane n arcs of the width 2 pi / n; in space n caps, each 1/n of the sphere.

    Returns
    -------
    v : ndarray, shape (n, dim)
        In the frame of the sensor.
    V : ndarray, shape (n, dim, dim)
    """
    u = directions(dim, n)
    if dim == 2:
        a = np.pi / n
        mean, along = np.sin(a) / a, 0.5 + np.sin(2 * a) / (4 * a)  # of cos, and of cos^2, over the arc
    else:
        c = 1 - 2 / n
        mean, along = (1 + c) / 2, (1 + c + c * c) / 3  # the same over the cap
    across = (1 - along) / (dim - 1)
    uu = u[:, :, None] * u[:, None, :]
    V = (r * r * (along - mean**2) + var) * uu + r * r * across * (np.eye(dim) - uu)
    return r * mean * u, V


def directions(dim, n):
    """Unit vectors evenly all round, shape (n, dim): on the circle, or on the spiral of Fibonacci round the sphere."""
    i = np.arange(n) + 0.5
    if dim == 2:
        return np.stack([np.cos(2 * np.pi * i / n), np.sin(2 * np.pi * i / n)], -1)
    z, turn = 1 - 2 * i / n, np.pi * (1 + np.sqrt(5)) * i
    h = np.sqrt(1 - z * z)
    return np.stack([h * np.cos(turn), h * np.sin(turn), z], -1)


# --- correction ------------------------------------------------------------------------------------------------------


def correct_ring(map, rob, sen, ring, y, R, md2_threshold=np.inf):
    """Correct each hypothesis by a range, as if it were the right one, and weigh it by how well it has foretold it.

    The measurement model is curved: across the line of sight a hypothesis is a piece of a circle. So expectation and
    covariance have their terms of second order, with C the covariance of the point p in the frame of the sensor:

        M = (I - u u') / |p|,    e = |p| + tr(M C) / 2,    Z = u' C u + tr(M C M C) / 2 + R

    A beacon with a bias is measured where it is not; the circle bends as its own distance tells, so in the terms of
    second order M and C are those of its place.

    The bend is the same in the next range, it is no white noise: many ranges must not average it away. So a range may
    say of e no more than leaves tr(M C M C) / 2 of its variance; the hypothesis has to become shorter first.

    A range may be a reflection, and a wrong hypothesis explains that by chance. So there is a gate g for each of them:
    those that do not explain the range keep their belief. For them it comes from nowhere, with one density for all:

        w = w max(N(z; 0, Z), N(0; 0, R) exp(-g / 2))

    So one range cannot take all the weight of the right one (a max-mixture: E. Olson, P. Agarwal, "Inference on
    networks of mixtures for robust robot mapping", IJRR 32(7), 2013).

    The gain is that of the hypothesis alone; nothing else in the map is changed.

    Parameters
    ----------
    map, rob, sen, ring
    y : ndarray, shape (1,)
    R : ndarray, shape (1, 1)
    md2_threshold : float
        The gate g. If no hypothesis has a smaller squared Mahalanobis distance, the range is refused.

    Returns
    -------
    bool
        Whether it has been used.
    """
    H, l = len(ring.w), ring.states(map)
    n, size, frame = ring.m, l.shape[1], rob.motion.frame
    Rf = frame(l[:, : frame.size]) if n else rob.frame(map)
    v, V_r, V_s, V_l = to_sensor(Rf, sen.frame(map), sen.model, ring.type, l[:, n:])
    V = np.concatenate([padded(V_r, n), np.broadcast_to(V_l, (*v.shape, size - n))], -1)
    G = V @ map.P[ring.r].reshape(H, size, -1)  # cov(v, map)
    if sen.r is not None:
        G = G + V_s @ map.P[sen.r]
    G_l = G[:, :, ring.r].reshape(*v.shape, H, size)  # cov(v, each hypothesis)
    C = np.stack([G_l[h, :, h] for h in range(H)]) @ t(V)
    if sen.r is not None:
        C = C + G[:, :, sen.r] @ t(V_s)

    (e, E_v), (p, B), r = sen.model.project(v), seen(map, rob, sen, ring), np.sqrt((v * v).sum(-1))
    side = np.where((v * p).sum(-1) < 0, -1.0, 1.0)  # -1: the bias makes the range negative
    e, E_v = e + ((side - 1) * r)[:, None], E_v * side[:, None, None]
    MC = (np.eye(v.shape[-1]) - t(E_v) @ E_v) @ B / np.sqrt((p * p).sum(-1))[:, None, None]
    second = np.einsum("hij,hji->h", MC, MC) / 2
    z = sen.model.residual(y, e)[:, 0] - np.einsum("hii->h", MC) / 2
    E, var, R = (E_v @ C @ t(E_v))[:, 0, 0], R[0, 0], R[0, 0] + second
    Z, explains = E + R, z * z < md2_threshold * (E + R)
    if not explains.any():
        ring.n_refused += 1
        return False

    g = (E_v @ G)[:, 0]  # cov(e, map)
    gl = (E_v[:, 0, :, None, None] * G_l).sum(1)  # cov(e_h, l_j)
    said = np.clip(1 / np.maximum(second, TINY) - 1 / np.maximum(E, TINY), 0, 1 / R) * explains  # information on e
    K = np.stack([gl[h, h] for h in range(H)]) * (said / (1 + said * E))[:, None]
    R = np.where(said > 0, 1 / np.maximum(said, TINY), 0.0)
    S = np.einsum("hjk,jk->hj", gl, (E_v @ V)[:, 0]) + np.sqrt(R[:, None] * R)  # cov(z_h, z_j)
    if sen.r is not None:
        S = S + g[:, sen.r] @ (E_v @ V_s)[:, 0].T
    P_lm = map.P[ring.r] - (K[:, :, None] * g[:, None, :]).reshape(-1, g.shape[-1])
    Kg = K[:, :, None, None] * gl[:, None]
    KSK = K[:, :, None, None] * (S[:, :, None] * K[None])[:, None]
    P_ll = map.block(ring.r) + (KSK - Kg).reshape(P_lm.shape[0], -1) - Kg.reshape(P_lm.shape[0], -1).T
    ring.r = map.put(ring.r, (l + K * z[:, None]).ravel(), P_lm, P_ll)
    loss = np.minimum(z * z / Z + np.log(Z / var), md2_threshold)
    ring.w, ring.n_used = weigh(ring.w, loss), ring.n_used + 1
    return True


def weigh(w, loss):
    """Weights, each times the likelihood of its innovation (Bayes' rule), told by z' Z^-1 z + log det Z."""
    with np.errstate(divide="ignore"):
        log = np.log(w) - loss / 2
    w = np.exp(log - log.max())
    return w / w.sum()


def agree(w, rob, x, P, before, after, back):
    """Weights of hypotheses after something else has corrected the robot: Bayes' rule once more.

    The correction of the robot tells all that has to be known of the measurement behind it, in units of its own noise:

        P- - P+ = W W',    H = W' P-^-1,    z = W^-1 (x+ - x-),    Z = 1

    A hypothesis that believes the robot at x_h with the covariance P_h has foretold it with the innovation z_h:

        z_h = z - H (x_h - x-),    Z_h = 1 - H (P- - P_h) H'

    Without that, what is measured of other beacons would tell a ring nothing: a hypothesis that shifts the beacon and
    its copy of the robot together explains all ranges of its own.

    Parameters
    ----------
    w : ndarray, shape (H,)
    rob : Rob
    x, P : ndarray, shape (H, m) and (H, m, m)
        What the hypotheses believed of the robot before the correction.
    before, after : tuple of ndarray
        State of the robot and its covariance, (m,) and (m, m).
    back : ndarray, shape (m, m)
        T^-1: what takes the covariance after the correction back to the world before.

    Returns
    -------
    ndarray, shape (H,)
    """
    (x0, P0), (x1, P1) = before, after
    s = np.sqrt(np.diag(P0).clip(TINY))  # metres and radians get one size
    D, V = np.linalg.eigh((P0 - back @ P1 @ back.T) / s / s[:, None])
    W = V[:, D > SMALL] * np.sqrt(D[D > SMALL])
    H = W.T @ np.linalg.pinv(P0 / s / s[:, None], SMALL, hermitian=True) / s
    z = np.linalg.pinv(W) @ (difference(rob, x1, x0) / s)
    z = z - np.array([difference(rob, each, x0) for each in x]) @ H.T
    Z = np.eye(len(H)) - H @ (P0 - P) @ H.T
    md2 = (z * np.linalg.solve(Z, z[..., None])[..., 0]).sum(-1)
    return weigh(w, md2 + np.linalg.slogdet(Z)[1])


def thin_out(map, rob, sen, ring, std):
    """Take out hypotheses without weight, and join neighbours as soon as one Gaussian is straight along all of them.

    What the ranges leave of a ring is an arc, and later a spot: not one of the hypotheses, but several next to each
    other. Mean and covariance of those together make the Gaussian that the landmark can be.

    Parameters
    ----------
    map, rob, sen, ring
    std : float
        Of the ranges, m.
    """
    w, l, P = ring.w, ring.states(map), map.block(ring.r)
    D, b = diagonal(P, len(w)), slice(ring.m, None)  # the beacons
    d = l[:, None, b] - l[:, b]
    near = (d * (d @ np.linalg.pinv(D[:, b, b], hermitian=True))).sum(-1) < NEIGHBOURS

    p, C = seen(map, rob, sen, ring)

    def straight(which):
        """Return True if one Gaussian is straight along these hypotheses."""
        return bend(*moments(w[which] / w[which].sum(), p[which], C[which]), std) < STRAIGHT

    groups = []
    for h in [h for h in np.argsort(-w).tolist() if w[h] >= NOTHING]:
        for group in groups:
            if (near[h, group] | near[group, h]).any() and straight([*group, h]):
                group.append(h)
                break
        else:
            groups.append([h])
    if len(groups) == len(w):
        return
    A = np.zeros((len(groups), len(w)))
    for g, group in enumerate(groups):
        A[g, group] = w[group] / w[group].sum()
    J = np.kron(A, np.eye(l.shape[1]))
    P_lm, P_ll = J @ map.P[ring.r], J @ P @ J.T
    wanted = np.stack([moments(A[g], l, D)[1] for g in range(len(groups))])
    P_ll += block_diagonal(wanted - diagonal(P_ll, len(groups)))
    ring.w = np.array([w[group].sum() for group in groups])
    ring.w /= ring.w.sum()
    ring.r = map.put(ring.r, (A @ l).ravel(), P_lm, P_ll)


def cut(map, rob, sen, ring, std, most):
    """Cut hypotheses that were straight from afar, and no longer are since the sensor has come near.

    The opposite of `thin_out`. With e the longest axis of a hypothesis as the sensor sees it, of the variance c, and J
    the derivative of what is seen by its state, it is told along that axis by a standard normal number t:

        t = a' (l - l_h),    a = J' e / sqrt(c),    s = P a

    Three Gaussians, see `PIECES`, have the moments of t until the fifth: those of the Gauss-Hermite rule. Each piece
    has the mean l_h + t s and the covariance P - (1 - V) s s'. The rest of the map keeps its mean. Where the map has no
    room for the pieces, nothing is cut.

    Parameters
    ----------
    map, rob, sen, ring
    std : float
        Of the ranges, m.
    most : int
        So many hypotheses there may be; the heaviest are cut first.
    """
    l, P, (p, J) = ring.states(map), map.block(ring.r), sighted(map, rob, sen, ring)
    H, size = l.shape
    D = diagonal(P, H)
    C = J @ D @ t(J)
    heavy = [h for h in np.argsort(-ring.w).tolist() if ring.w[h] >= NOTHING and bend(p[h], C[h], std) > BENT]
    bent = np.isin(np.arange(H), heavy[: max(most - H, 0) // 2])
    if not bent.any():
        return
    c, e = np.linalg.eigh(C)
    a = (t(J) @ e[..., -1:])[..., 0] / np.sqrt(c[:, -1:])
    s = (D @ a[..., None])[..., 0]

    of = np.repeat(np.arange(H), np.where(bent, 3, 1))  # whom each piece is of
    T, W, V = np.zeros(len(of)), np.ones(len(of)), np.ones(len(of))
    T[bent[of]], W[bent[of]], V[bent[of]] = (np.tile(each, bent.sum()) for each in PIECES)
    A = np.zeros((len(of), size, H, size))
    A[np.arange(len(of)), :, of] = np.eye(size) - ((1 - V)[:, None] * s[of])[:, :, None] * a[of, None]
    A = A.reshape(-1, l.size)
    Q = block_diagonal((V - V * V)[:, None, None] * s[of, :, None] * s[of, None])
    P_lm, P_ll, old = A @ map.P[ring.r], A @ P @ A.T + Q, (map.state(ring.r), P, map.P[ring.r].copy())
    for rows in P_lm, old[2]:
        rows[:, ring.r] = 0  # their place may become another one
    map.remove(ring.r)
    try:
        ring.r = map.add((l[of] + T[:, None] * s[of]).ravel(), (P_ll + P_ll.T) / 2, P_lm)
    except MapFull:
        ring.r = map.add(*old)
        return
    ring.w = ring.w[of] * W
    cut(map, rob, sen, ring, std, most)


def crowded(map, rob, sen, ring, r, std, most):
    """Return True if a ring has no room for the cuts that it needs, and a new one round the sensor would be better.

    The more the odometry has drifted since the birth, the longer is the arc on which each hypothesis has the beacon, as
    the sensor sees it. The terms of second order say how wrong a Gaussian is there, and not which way. So the weights
    of such a ring go wrong little by little, and one day it is decided in the wrong place. It is crowded if those that
    bend by more than `CROWDED`, and twice as much as new ones, have more than half of the weight. To begin anew loses
    what has been learnt of the place, and claims nothing.

    Parameters
    ----------
    map, rob, sen, ring
    r : float
        The range, m.
    std : float
        Its noise, m.
    most : int
        So many hypotheses there may be.
    """
    p, P = seen(map, rob, sen, ring)
    bends = bend(p, P, std)
    if ring.w @ (bends > CROWDED) <= 0.5:
        return False
    v, V = sectors(r, std**2, p.shape[1], how_many(r, std, p.shape[1], most))
    return bool(ring.w @ (bends > max(CROWDED, 2 * bend(v[0], V[0], std))) > 0.5)


def seen(map, rob, sen, ring):
    """Where the hypotheses are, as seen from the sensor, and their covariances there, shape (H, d) and (H, d, d).

    How well the whole scene is known to lie in the world does not matter to a range: each hypothesis is seen from its
    own copy of the robot.
    """
    p, J = sighted(map, rob, sen, ring)
    return p, J @ diagonal(map.block(ring.r), len(p)) @ t(J)


def sighted(map, rob, sen, ring):
    """Where the hypotheses are, as seen from the sensor, shape (H, d), and the derivatives by their states."""
    l, m, n = ring.states(map), ring.m, rob.motion.frame.size
    Rf = rob.motion.frame(l[:, :n]) if m else rob.frame(map)
    F, F_r, _ = Rf.compose(sen.frame(map))
    ls, LS_f, LS_l = ring.type.to_frame(F, l[:, m:])
    p, P_ls = ring.type.point(ls)
    P_x, P_l = P_ls @ LS_f @ F_r, np.broadcast_to(P_ls @ LS_l, (*p.shape, ring.type.size))
    return p, np.concatenate([padded(P_x, m), P_l], -1)


def bend(p, P, std):
    """How far the circle of a range bends away from a Gaussian within a sigma of its longest axis, in sigmas of ranges.

    Whichever way the axis lies: the sensor may see the beacon from another side later.

    Parameters
    ----------
    p, P : ndarray, shape (..., d) and (..., d, d)
        In the frame of the sensor.
    std : float
        Of the ranges, m.
    """
    return np.linalg.eigvalsh(P)[..., -1] / (np.sqrt(2) * np.maximum(np.linalg.norm(p, axis=-1), std) * std)


# --- moved and carried along -----------------------------------------------------------------------------------------


class _Moved:
    """The copies of a robot in its rings move by the same control; the noise of it is the same, too."""

    def __init__(self, rings, map, rob, dt):
        self.rings, self.map, self.rob, self.dt = rings, map, rob, dt

    def __enter__(self):
        if self.rings:
            X_u = self._move(self.rob.state(self.map))[2]
            self.noise = np.zeros((len(self.map.x), X_u.shape[-1]))  # what the noise has done, row for row of the map
            self.noise[self.rob.r] = X_u

    def __exit__(self, kind, *_):
        for ring in self.rings if kind is None else []:
            self._follow(ring)

    def _follow(self, ring):
        map, m, U, l = self.map, ring.m, np.asarray(self.rob.U, float), ring.states(self.map)
        H, size = l.shape
        x, X_x, X_u = self._move(l[:, :m])
        A = np.tile(np.eye(size), (H, 1, 1))
        A[:, :m, :m] = X_x
        G = np.zeros((H, size, U.shape[0]))
        G[:, :m] = X_u
        G = G.reshape(H * size, -1)
        P_lm = (A @ map.P[ring.r].reshape(H, size, -1)).reshape(H * size, -1)
        P_ll = (A @ t(P_lm[:, ring.r]).reshape(H, size, -1)).reshape(H * size, -1) + G @ U @ G.T
        P_lm += G @ U @ self.noise.T
        self.noise[ring.r] = G
        map.put(ring.r, np.concatenate([x, l[:, m:]], 1).ravel(), P_lm, P_ll)

    def _move(self, x):
        """The motion of one state or of a stack, quaternions brought to length one; headings are not wrapped."""
        n, motion = self.rob.motion.frame.size, self.rob.motion
        if np.ndim(self.rob.u) == 2:
            raise ValueError(f"robot {self.rob.id}: rings take one control a frame, this log has many")
        x, X_x, X_u = motion.move(x, np.asarray(self.rob.u, float), self.dt)
        if motion.frame.dim == 3:
            F, N_f = motion.frame(x[..., :n]).normalized()
            N = np.broadcast_to(np.eye(x.shape[-1]), (*x.shape, x.shape[-1])).copy()
            N[..., :n, :n] = N_f
            x, X_x, X_u = np.concatenate([F.x, x[..., n:]], -1), N @ X_x, N @ X_u
        return x, X_x, X_u


class _Carried:
    """What a correction of the robot by others says of the rings.

    Each hypothesis believes something of the robot, so each foretells in its own way what has corrected the robot:
    `agree` weighs them by that. And with the invariant error, see `slam.correct_invariant`, P = T P T' for their rows
    and columns.
    """

    def __init__(self, live, map, rob, opt):
        self.rings, self.map, self.rob = list(live.values()) if rob.r is not None else [], map, rob
        self.invariant = opt.error == "invariant"

    def __enter__(self):
        if self.rings:
            self.before = [(ring.states(self.map), ring.robots(self.map)[1]) for ring in self.rings]
            self.robot = self._robot()

    def __exit__(self, kind, *_):
        if kind is not None or not self.rings or np.array_equal(self.robot[0], self._robot()[0]):
            return
        for ring, (l0, P0) in zip(self.rings, self.before, strict=True):
            if ring.m and ring.rob == self.rob.id:
                ring.w = agree(ring.w, self.rob, l0[:, : ring.m], P0, self.robot, self._robot(), self._back())
            if self.invariant:
                self._carry(ring, l0, ring.states(self.map))

    def _robot(self):
        return self.rob.state(self.map), self.map.block(self.rob.r)

    def _back(self):
        """T^-1 of the state of the robot: what the invariant error has turned its covariance by."""
        x0, x1 = self.robot[0], self._robot()[0]
        if not self.invariant:
            return np.eye(len(x0))
        return carrying(robot_gauge(self.rob, x1), robot_gauge(self.rob, x0), self.rob.motion.frame.size)

    def _carry(self, ring, l0, l):
        """Let a ring follow: the g of `gauge` is read from the pose of the robot."""
        if np.array_equal(l, l0):
            return
        map, F = self.map, self.rob.frame(self.map)
        at, O = slice(self.rob.r.start, self.rob.r.start + F.size), ORIGIN[F.dim]
        Q, U = np.linalg.qr(O.compose(F)[1] @ O.X_step)
        D = ring_gauge(self.rob, ring, l) - ring_gauge(self.rob, ring, l0)
        D = D.reshape(l.size, -1) @ np.linalg.solve(U, Q.T)
        P_lm = map.P[ring.r] + D @ map.P[at]
        P_ll = P_lm[:, ring.r] + P_lm[:, at] @ D.T
        map.put(ring.r, l.ravel(), P_lm, P_ll)


def carry_ring(map, rob, ring, l0):
    """Carry each hypothesis along after its own correction, as `slam.correct_invariant` does the map: P = T P T'.

    The ranges of a hypothesis tell it as little of where the world lies as those of a landmark tell the robot. What it
    would take for that by its linearisation, it would hand on to the robot when it is decided. Here g is read from its
    own copy of the robot.

    Parameters
    ----------
    map, rob, ring
    l0 : ndarray, shape (H, m + k)
        Its states before the correction.
    """
    l, n = ring.states(map), rob.motion.frame.size
    T = carrying(ring_gauge(rob, ring, l0), ring_gauge(rob, ring, l), n)
    P_lm = (T @ map.P[ring.r].reshape(*l.shape, -1)).reshape(l.size, -1)
    P_ll = (T @ t(P_lm[:, ring.r]).reshape(*l.shape, -1)).reshape(l.size, -1)
    map.put(ring.r, l.ravel(), P_lm, P_ll)


def carrying(B0, B1, n):
    """T with T B0 = B1, from the pose at the head of a state: I + (B1 - B0) E with E B0 = I, as in `ekf.carry`.

    Parameters
    ----------
    B0, B1 : ndarray, shape (..., m, dof)
        The gauge of a state before and after.
    n : int
        Length of the pose.

    Returns
    -------
    ndarray, shape (..., m, m)
    """
    Q, U = np.linalg.qr(B0[..., :n, :])
    T = np.zeros((*B0.shape[:-1], B0.shape[-2])) + np.eye(B0.shape[-2])
    T[..., :n] += (B1 - B0) @ np.linalg.solve(U, t(Q))
    return T


def robot_gauge(rob, x):
    """How a robot changes if the world is moved: its rows of `slam.gauge`, shape (m, dof)."""
    O = ORIGIN[rob.motion.frame.dim]
    B = np.zeros((len(x), O.dof))
    B[: O.size] = O.compose(rob.motion.frame(x[: O.size]))[1] @ O.X_step
    if len(x) > O.size:
        B[O.size :, O.dim :] = turning(rob.motion, x)
    return B


def ring_gauge(rob, ring, l):
    """How hypotheses change if the world is moved: the rows of `slam.gauge`, shape (H, m + k, dof)."""
    O, m = ORIGIN[rob.motion.frame.dim], ring.m
    B = np.zeros((*l.shape, O.dof))
    B[:, m:] = -ring.type.to_frame(O, l[:, m:])[1] @ O.X_step
    if m:
        B[:, :m] = [robot_gauge(rob, x) for x in l[:, :m]]
    return B


# --- small things ----------------------------------------------------------------------------------------------------


def difference(rob, x, x0):
    """x - x0 of two states of a robot: headings wrapped, quaternions of the same sign."""
    n, dim = rob.motion.frame.size, rob.motion.frame.dim
    x = x.copy()
    if dim == 3 and x[dim:n] @ x0[dim:n] < 0:
        x[dim:n] *= -1
    d = x - x0
    if dim == 2:
        d[2] = wrap(d[2])
    return d


def padded(J, m):
    """Derivatives by a frame as derivatives by the whole state of the robot, m numbers: none if it is known."""
    return np.pad(J, ((0, 0), (0, 0), (0, m - J.shape[-1]))) if m else J[..., :0]


def t(A):
    """Transpose of each matrix of a stack."""
    return np.swapaxes(A, -1, -2)


def diagonal(P, n):
    """The n blocks on the diagonal of a covariance, shape (n, k, k)."""
    k = len(P) // n
    return P.reshape(n, k, n, k)[np.arange(n), :, np.arange(n)]


def block_diagonal(Q):
    """A matrix with these blocks (n, k, k) on its diagonal."""
    n, k, _ = Q.shape
    P = np.zeros((n, k, n, k))
    P[np.arange(n), :, np.arange(n)] = Q
    return P.reshape(n * k, n * k)


def moments(w, m, P):
    """Mean and covariance of a sum of Gaussians with weights w, shape (H,); those of weight 0 do not count."""
    mean = w @ m
    d = m - mean
    return mean, np.einsum("h,hij->ij", w, P) + np.einsum("h,hi,hj->ij", w, d, d)
