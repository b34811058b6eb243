"""A run as a graph of factors: the states of all frames, and what the models say of them, to be smoothed.

The models are those of the filter, with their Jacobians. The filter has decided which measurement belongs to which
landmark, and which one is used; the graph takes its word. A factor says

    r(x) + A dx = G w,  with noise w of covariance C.

G C G' may be singular: a unicycle cannot slip sideways, and a start may be known. So the system that is solved is not
that of the normal equations, but the one before them, which asks for no inverse. The noise that makes a factor fit is
part of the estimate: a step is linearised at the control as it must have been, not as it was measured.
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.linalg import block_diag

from ..geometry import ORIGIN, Frame2, Frame3, wrap
from ..models.landmarks import EucPnt
from ..models.moving import Moving
from ..models.observation import ItsRobot, expect, retro_project
from ..toolbox import create_slam_structures, universal_slam
from ..toolbox.rings import rings_by
from ..toolbox.sources import Replay
from .partners import named, placed

ITS_ROBOT = -1
"""In the place of a landmark's id, where a sensor has measured its own robot; as events have it."""
NO_LMK = ItsRobot()


@dataclass
class Prior:
    """Prior of some variables: mean and covariance."""

    keys: list
    x: np.ndarray
    P: np.ndarray
    w: Any = 0.0

    def linear(self, graph):
        """Residual, Jacobians by key, G and C."""
        parts = [graph.difference(key, graph.values[key], x) for key, x in self._parts(graph)]
        n, blocks, row = len(self.x), {}, 0
        for key, part in zip(self.keys, parts, strict=True):
            blocks[key] = np.eye(n)[:, row : row + len(part)]
            row += len(part)
        return np.concatenate(parts), blocks, np.eye(n), self.P

    def _parts(self, graph):
        row = 0
        for key in self.keys:
            size = len(graph.values[key])
            yield key, self.x[row : row + size]
            row += size


@dataclass
class Motion:
    """A step of a robot: x2 = move(x, u + w, dt)."""

    motion: Any
    before: tuple
    after: tuple
    u: np.ndarray
    U: np.ndarray
    dt: float
    loosened: np.ndarray | None = None  # covariance that a recovery of the filter has added to the state after it
    w: Any = 0.0  # noise, as estimated

    def linear(self, graph):
        """Residual, Jacobians by key, G and C."""
        ((_, *found),) = _steps(graph, [self])
        return found


def linearised(graph, stiff):
    """Each factor, and its residual, Jacobians by key, G and C; equal steps of a robot are one call of its model."""
    groups = {}
    for factor in stiff:
        alike = (factor.after[1], factor.dt) if isinstance(factor, Motion) else id(factor)
        groups.setdefault(alike, []).append(factor)
    for some in groups.values():
        if isinstance(some[0], Motion):
            yield from _steps(graph, some)
        else:
            yield some[0], *some[0].linear(graph)


def _steps(graph, some):
    """The same of steps of one robot that last equally long."""
    motion, n = some[0].motion, some[0].motion.frame.size
    before = np.array([graph.values[f.before] for f in some])
    after = np.array([graph.values[f.after] for f in some])
    u = np.array([f.u for f in some])
    w = np.array([np.zeros(len(f.u)) + np.atleast_1d(f.w)[: len(f.u)] for f in some])
    x, X_x, X_u = motion.move(before, u + w, some[0].dt)
    F, N_f = motion.frame(x[:, :n]).normalized()
    N = np.tile(np.eye(x.shape[1]), (len(some), 1, 1))
    N[:, :n, :n] = N_f
    G = N @ X_u
    r = graph.difference(some[0].after, after, np.concatenate([F.x, x[:, n:]], 1)) + (G @ w[..., None])[..., 0]
    A = -N @ X_x
    for k, f in enumerate(some):
        g, C = G[k], f.U
        if f.loosened is not None:
            g, C = np.hstack([g, N[k]]), block_diag(C, f.loosened)  # a quaternion has no noise along itself
        yield f, r[k], {f.after: np.eye(len(A[k])), f.before: A[k]}, g, C


@dataclass
class Birth:
    """The first measurement of a landmark by a sensor that sees directions, and the prior of its distance."""

    k: int
    pose: Any
    mount: Any
    sensor: Any
    type: Any
    lmk: tuple
    y: np.ndarray
    R: np.ndarray
    n: np.ndarray
    N: np.ndarray
    frames: tuple
    w: Any = 0.0

    def linear(self, graph):
        """Residual, Jacobians by key, G and C."""
        Rf, Sf = graph.both(self)
        m = len(self.y)
        w = np.broadcast_to(self.w, (m + len(self.n),))
        l, L_r, L_s, L_y, L_n = retro_project(Rf, Sf, self.sensor, self.type, self.y + w[:m], self.n + w[m:])
        blocks = {self.lmk: np.eye(len(l))} | graph.padded((self.pose, -L_r), (self.mount, -L_s))
        G = np.hstack([L_y, L_n])
        return graph.values[self.lmk] - l + G @ w, blocks, G, block_diag(self.R, self.N)


@dataclass
class Guess:
    """Prior of the last numbers of a landmark, before its first range: bias and scale of a beacon."""

    k: int
    lmk: tuple
    n: np.ndarray
    N: np.ndarray
    w: Any = 0.0

    def linear(self, graph):
        """Residual, Jacobians by key, G and C."""
        l, m = graph.values[self.lmk], len(self.n)
        return l[-m:] - self.n, {self.lmk: np.eye(len(l))[-m:]}, np.eye(m), self.N


@dataclass(frozen=True)
class OnTheMove:
    """Stand-in for a robot's frame, for a sensor that asks for its velocity, too."""

    motion: Any
    u: np.ndarray

    @property
    def size(self):
        """Length of the robot's state."""
        return self.motion.size

    def __call__(self, x):
        """The robot at the state x, as the sensor sees it."""
        return Moving(self.motion, x, self.u)


@dataclass
class Look:
    """Measurements by a sensor of landmarks of one type in frame k: y - h(x), each with its own R.

    A sensor that sees no landmark, as GPS, has measured its own robot, `ItsRobot`: a landmark without a state.
    """

    k: int
    pose: Any
    mount: Any
    sensor: Any
    type: Any
    lmks: list
    y: np.ndarray
    R: np.ndarray
    frames: tuple

    @property
    def alike(self):
        """Key shared by those that are one call of the models; a robot on the move is alone."""
        robot, mount = self.frames[0], self.mount if isinstance(self.mount, tuple) else id(self.mount)
        return self.type, id(self.sensor), mount, robot if robot in PLAIN else id(self)


PLAIN = Frame2, Frame3


def innovations(graph, looks):
    """Innovations z (k, m), their noise R (k, m, m), the Jacobians of each by key, and whose they are: (look, number).

    What a sensor measured of landmarks of one type is one call of the models, whatever the frame.
    """
    groups = {}
    for look in looks:
        groups.setdefault(look.alike, []).append(look)
    for some in groups.values():
        one, rows = some[0], [(look.pose, l) for look in some for l in look.lmks]
        Rf, Sf = graph.both(one)
        if one.frames[0] in PLAIN:
            Rf = one.frames[0](np.array([graph.get(pose)[: Rf.size] for pose, _ in rows]))
        L = np.array([graph.get(l)[: one.type.size] for _, l in rows])
        e, _, E_r, E_s, E_l = expect(Rf, Sf, one.sensor, one.type, L)
        z = one.sensor.residual(np.concatenate([look.y for look in some]), e)
        R = np.concatenate([look.R for look in some])
        blocks = zip(rows, E_r, E_s, E_l, strict=True)
        each = [graph.padded((pose, R_r), (one.mount, R_s), (l, R_l)) for (pose, l), R_r, R_s, R_l in blocks]
        yield z, R, each, [(look, i) for look in some for i in range(len(look.lmks))]


@dataclass
class Graph:
    """Variables and factors of a run.

    Parameters
    ----------
    values : dict of tuple to ndarray
        The estimate, by key: ("robot", id, k) after frame k, with k = 0 the start; ("sensor", id) where the filter
        estimates its mounting or parameters; ("landmark", id).
    frames : dict
        Frame2 or Frame3 of a robot or of a sensor, by ("robot", id) and ("sensor", id).
    stiff : list of Prior, Motion, Birth
        Factors whose covariance may be singular.
    looks : list of Look
    t : list of float
        s, of the start and after each frame.
    types : dict
        Landmark type by id.
    filtered : dict
        What the filter knew after each frame: (x, P) by ("robot", id, k), and at the end by ("landmark", id) and
        ("sensor", id).
    truth : dict
        True poses by ("robot", id, k), and true places by ("landmark", id), where they are known.
    """

    values: dict = field(default_factory=dict)
    frames: dict = field(default_factory=dict)
    stiff: list = field(default_factory=list)
    looks: list = field(default_factory=list)
    t: list = field(default_factory=lambda: [0.0])
    types: dict = field(default_factory=dict)
    filtered: dict = field(default_factory=dict)
    truth: dict = field(default_factory=dict)

    def get(self, where):
        """The value of a variable; or the one that is known and no variable."""
        return self.values[where] if isinstance(where, tuple) else where

    def both(self, factor):
        """Frames of the robot, or what the sensor asks for instead, and of the sensor of a factor."""
        places = zip(factor.frames, (factor.pose, factor.mount), strict=True)
        return (frame(self.get(x)[: frame.size]) for frame, x in places)

    def padded(self, *blocks):
        """Jacobians by key, with zeros for what of a state they do not depend on; what is known drops out."""
        found = {}
        for key, J in blocks:
            if isinstance(key, tuple):
                J = np.hstack([J, np.zeros((len(J), len(self.values[key]) - J.shape[1]))])
                found[key] = found[key] + J if key in found else J
        return found

    def difference(self, key, x, y):
        """x - y, a heading wrapped; of quaternions what is across y, as their length says nothing. Stacks will do."""
        d, frame = x - y, self.frames.get(key[:2])
        frame = getattr(frame, "plain", frame)  # parameters may stand behind it
        if frame is Frame2:
            d[..., 2] = wrap(d[..., 2])
        if frame is Frame3:
            q, p = y[..., 3:7], x[..., 3:7]
            along = lambda p, q: (p * q).sum(-1, keepdims=True)
            p = np.where(along(p, q) > 0, p, -p)
            d[..., 3:7] = p - along(p, q) * q
        return d

    def move(self, d):
        """Add steps to the values, by key; frames come back to their normal form."""
        for key, step in d.items():
            x = self.values[key] + step
            frame = self.frames.get(key[:2])
            if frame is not None:
                x[: frame.size] = frame(x[: frame.size]).normalized()[0].x
            self.values[key] = x

    @property
    def robots(self):
        """Ids of the robots that are estimated."""
        return sorted({key[1] for key in self.values if key[0] == "robot"})


def graph_of(data, recording=None, seed=None):
    """Run the filter and note what it has used: the graph of a run, at the filter's estimate.

    Parameters
    ----------
    data : UserData
    recording : Recording, optional
    seed : int, optional
        As of `universal_slam`.

    Returns
    -------
    Graph

    See Also
    --------
    smooth : Finds the best values of all variables.
    """
    maker = GraphMaker(data, recording)
    for now in universal_slam(data, recording, seed):
        maker.add(now)
    return maker.finish()


class GraphMaker:
    """Makes the graph of a run while it goes on: `add` each snapshot, from the first one on, then `finish`.

    Parameters
    ----------
    data : UserData
    recording : Recording, optional

    Raises
    ------
    ValueError
        If this scenario cannot be smoothed.
    """

    def __init__(self, data, recording=None):
        for sensor in data.sensors:
            if hasattr(sensor.model, "innovation"):
                raise ValueError(f"sensor {sensor.id} measures lines; the smoother knows points only")
            if any(np.any(walk) for walk in sensor.params_walk.values()):
                raise ValueError(f"sensor {sensor.id} has parameters that walk; the smoother knows constant ones only")
        self.data, self.recording = data, recording
        self.last: Any = None  # snapshot

    def _begin(self, now):
        """Note what is known before the first frame: starts, mountings and surveyed landmarks."""
        data, self.graph, self.k = self.data, Graph(), 0
        starts = {} if self.recording is None else Replay(data, self.recording).starts
        map, robs, sens, lmks, _ = create_slam_structures(data, now.sim_lmk, starts)
        self.opt, self.sightings, self.births, self.types = data.slam_options(), [], {}, {}
        self.graph.frames |= {("robot", rob.id): rob.motion.frame for rob in robs}
        self.graph.frames |= {("sensor", sen.id): sen.frame_type for sen in sens}
        for kind, things in (("robot", robs), ("sensor", sens), ("landmark", lmks.values())):
            for thing in things:
                if thing.r is not None:
                    key = (kind, thing.id, 0) if kind == "robot" else (kind, thing.id)
                    self._note(key, thing.state(map), map.block(thing.r))
                    self.graph.stiff.append(Prior([key], thing.state(map), map.block(thing.r)))
        self.loosened, self.heard, self.steps = {}, {}, {}

    def _note(self, key, x, P):
        self.graph.values[key], self.graph.filtered[key] = x.copy(), (x, P)

    def add(self, now):
        """One frame."""
        if self.last is None:
            self._begin(now)
        self.k += 1
        self.graph.t.append(now.t)
        raw_of = dict(now.raw)
        for rob in now.robs:
            self._moved(now, rob)
        self.place = {rob.id: rob for rob in now.robs}
        self.mount = {sen.id: sen for sen in now.sens}
        for sen in now.sens:
            for (id, lmk), o in now.obs.items():
                if id == sen.id and o.updated and lmk != ITS_ROBOT:
                    self._saw(sen, lmk, o.y, o.R)
            if hasattr(sen.model, "without_lmks") and sen.id in raw_of:
                passed = [e.flag for e in now.events if e.kind == "innovation" and e.sen == sen.id]
                for i in np.flatnonzero(passed):
                    self._saw(sen, ITS_ROBOT, raw_of[sen.id].y[i], _noise(sen, raw_of[sen.id], i))
        for event in now.events:
            sen = self.mount[event.sen]
            if event.kind == "initialisation" and rings_by(sen.model):
                self._decided(now.lmks[event.lmk])
            elif event.kind == "initialisation":
                self._born(now, sen, event.lmk, raw_of[event.sen])
            elif event.kind == "innovation" and event.flag and event.lmk in self.heard:
                self.heard[event.lmk].append(self._range(sen, event.lmk, raw_of))
            elif event.kind == "deletion":
                self.sightings = [s for s in self.sightings if s[3] != event.lmk or s[4]]
                self.births.pop(event.lmk, None)
                self._forget_survey(event.lmk)
            elif event.kind == "recovery" and event.lmk == -1:
                self._loosen(now.map, event.rob)
            elif event.kind == "meeting" and event.flag:
                for i in np.flatnonzero(np.asarray(now.met[sen.id].ids) == event.lmk):
                    y, R = now.met[sen.id].y[i], _noise(sen, now.met[sen.id], i)
                    self.sightings.append((self.k, sen.robot, sen.id, event.lmk, True, np.array(y), np.array(R)))
        self.heard = {id: self.heard.get(id) or self._first_range(ring, raw_of) for id, ring in now.rings.items()}
        self.last = now

    def _forget_survey(self, id):
        """A landmark has left the map: what was known of it before the run goes with it."""
        key = "landmark", id
        self.graph.stiff = [f for f in self.graph.stiff if not (isinstance(f, Prior) and f.keys == [key])]
        self.graph.values.pop(key, None)
        self.graph.filtered.pop(key, None)

    def _moved(self, now, rob):
        """The step of a robot, and where it leads."""
        key = ("robot", rob.id, self.k)
        if rob.id in now.truth and np.isfinite(now.truth[rob.id]).all():
            self.graph.truth[key] = now.truth[rob.id].copy()
        if rob.r is None:
            return
        self._note(key, rob.state(now.map), now.map.block(rob.r))
        if np.ndim(rob.u) == 2:
            raise ValueError(f"robot {rob.id}: a graph takes one control a frame, this log has many")
        before = ("robot", rob.id, self.k - 1)
        step = Motion(rob.motion, before, key, np.array(rob.u, float), np.array(rob.U, float), now.dt)
        step.loosened = self.loosened.pop(rob.id, None)
        self.graph.stiff.append(step)
        self.steps[rob.id, self.k] = step

    def _first_range(self, ring, raw_of):
        """The range that has started a ring, in this frame."""
        able = [sen for sen in self.mount.values() if sen.robot == ring.rob and rings_by(sen.model)]
        return [self._range(next(s for s in able if ring.id in raw_of[s.id].ids), ring.id, raw_of)]

    def _range(self, sen, id, raw_of):
        """A range to a beacon that is no landmark yet: as `_saw` notes it."""
        raw = raw_of[sen.id]
        i = list(raw.ids).index(id)
        return self.k, sen.robot, sen.id, id, False, np.array(raw.y[i], float), np.array(_noise(sen, raw, i), float)

    def _decided(self, lmk):
        """A ring has become a landmark: all ranges that it has used are its own, and its faults were guessed once."""
        ranges = self.heard.pop(lmk.id)
        self.sightings += ranges
        if hasattr(lmk.type, "N"):
            key = "landmark", lmk.id
            self.graph.stiff.append(Guess(ranges[0][0], key, np.zeros(len(lmk.type.N)), lmk.type.N))

    def _saw(self, sen, lmk, y, R):
        self.sightings.append((self.k, sen.robot, sen.id, lmk, False, np.array(y, float), np.array(R, float)))

    def _born(self, now, sen, id, raw):
        """The measurement that has started a landmark: by its id, or the one that leads to where the landmark is."""
        used = {o.index for (s, _), o in now.obs.items() if s == sen.id and o.updated}
        rows = [i for i in range(len(raw.ids)) if i not in used]
        if id in np.asarray(raw.ids)[rows]:
            rows = [i for i in rows if raw.ids[i] == id]
        lmk = now.lmks[id]
        Rf, Sf, n = self.place[sen.robot].frame(now.map), sen.frame(now.map), lmk.n
        ends = [retro_project(Rf, Sf, sen.model, lmk.type, np.asarray(raw.y[i], float), n)[0] for i in rows]
        i = rows[int(np.argmin([np.linalg.norm(l - lmk.state(now.map)) for l in ends]))]
        R = _noise(sen, raw, i)
        if sen.model.bearing_only:
            self.births[id] = self.k, sen.robot, sen.id, lmk.type, np.array(raw.y[i]), np.array(R), lmk.n, lmk.N
        else:
            self._saw(sen, id, raw.y[i], R)

    def _loosen(self, map, robot):
        """A recovery: the noise that the filter has added to the pose, for the next step."""
        rob = self.place[robot]
        F, P = rob.motion.frame, np.zeros((rob.motion.size,) * 2)
        position, angle = self.opt.reopen_std
        X = rob.frame(map).compose(ORIGIN[F.dim])[2] @ ORIGIN[F.dim].X_step  # turned about its own axes
        P[: F.size, : F.size] = X @ np.diag([position**2] * F.dim + [angle**2] * (F.dof - F.dim)) @ X.T
        self.loosened[robot] = P

    def finish(self):
        """The graph: with landmarks, and what was seen of them, in groups of one frame, sensor and type."""
        if self.last is None:
            raise ValueError("the run has no frames, so there is nothing to smooth")
        g, map = self.graph, self.last.map
        rows = named(self.last) if self.last.named else placed(self.last)[0]
        g.truth |= {("landmark", id): np.array(self.last.sim_lmk.points[row], float) for id, row in rows.items()}
        for id, lmk in self.last.lmks.items():
            g.types[id] = lmk.type
            if lmk.r is not None:
                self._note(("landmark", id), lmk.state(map), map.block(lmk.r))
        for id, sen in self.mount.items():
            if sen.r is not None:
                self._note(("sensor", id), sen.state(map), map.block(sen.r))
        for id, (k, robot, sensor, kind, y, R, n, N) in self.births.items():
            where = self._where(k, robot, sensor)
            if id in g.types and g.types[id] == kind:
                g.stiff.append(Birth(k, *where, kind, ("landmark", id), y, R, n, N, self._frames(k, robot, sensor)))
            elif id in g.types:  # it has become a Euclidean point; what was guessed of its distance is forgotten
                self.sightings.append((k, robot, sensor, id, False, y, R))
        groups = {}
        for k, robot, sensor, id, met, y, R in self.sightings:
            if met or id in g.types or id == ITS_ROBOT:
                kind = EucPnt(self.place[id].motion.frame.dim) if met else g.types.get(id, NO_LMK)
                groups.setdefault((k, robot, sensor, met), []).append((kind, self._lmk(k, id, met), y, R))
        for (k, robot, sensor, _), rows in groups.items():
            for kind in {row[0] for row in rows}:
                lmks, y, R = zip(*[row[1:] for row in rows if row[0] == kind], strict=True)
                where = self._where(k, robot, sensor)
                frames = self._frames(k, robot, sensor)
                g.looks.append(Look(k, *where, kind, list(lmks), np.array(y), np.array(R), frames))
        return g

    def _frames(self, k, robot, sensor):
        frame, mount = self.graph.frames["robot", robot], self.graph.frames["sensor", sensor]
        if hasattr(self.mount[sensor].model, "asks_robot"):
            step = self.steps[robot, k]
            frame = OnTheMove(step.motion, step.u)
        return frame, mount

    def _where(self, k, robot, sensor):
        """Pose and mounting, as keys or as what is known; and the model of the sensor."""
        rob, sen = self.place[robot], self.mount[sensor]
        pose = self.graph.truth["robot", robot, k] if rob.r is None else ("robot", robot, k)
        return pose, sen.x if sen.r is None else ("sensor", sensor), sen.model

    def _lmk(self, k, id, met):
        if id == ITS_ROBOT:
            return np.zeros(0)
        if met:
            return self.graph.truth["robot", id, k] if self.place[id].r is None else ("robot", id, k)
        return self.last.lmks[id].x if self.last.lmks[id].r is None else ("landmark", id)


def _noise(sen, raw, i):
    """Noise covariance of raw measurement i."""
    return sen.model.R if raw.R is None else raw.R[i]
