"""EKF-SLAM in the plane, many runs at once: the same scenario with many seeds, for Monte-Carlo figures.

What `universal_slam` does in one frame, all runs do here together: the same models, the same steps in the same order,
one array for all runs. Only the decisions (who sees what, which landmark is corrected first, what passes the gate)
differ from run to run.
"""

from dataclasses import dataclass

import numpy as np

from ..geometry import Frame2, wrap
from ..models.landmarks import EucPnt
from ..models.motion import Odometry2, Unicycle, Vehicle
from ..models.observation import observe, retro_project
from ..models.sensors import RangeBearing
from ..simulation import Streams, draw
from ..slam import KnownIds
from ..slam.first_estimates import transport
from ..toolbox.structures import create_sim_structures, create_slam_structures
from ..toolbox.universal_slam import Run

ROB, POINT = slice(0, 3), EucPnt(2)
FRAMES_AT_A_TIME = 64
"""Noise is drawn for so many frames in one call; the numbers are those that a draw in each frame gives."""


@dataclass
class BatchSnapshot:
    """All runs after one of their frames. `x` and `P` are live, good until the next snapshot is drawn.

    Parameters
    ----------
    k : int
        Frame number.
    x : ndarray, shape (R, n)
        Estimates: the pose, then landmark i at 3 + 2 i : 5 + 2 i; zero where it is not in the map of a run.
    P : ndarray, shape (R, n, n)
        Covariances.
    truth : ndarray, shape (R, 3)
        True poses.
    seen : ndarray of bool, shape (R, N)
        Which landmarks have been seen, in this frame or before, and are in the map.
    ids : ndarray of int, shape (N,)
        Ids of the landmarks.
    points : ndarray, shape (R, N, 2)
        Their true places.
    """

    k: int
    x: np.ndarray
    P: np.ndarray
    truth: np.ndarray
    seen: np.ndarray
    ids: np.ndarray
    points: np.ndarray


def batch_slam(data, seeds):
    """Run a scenario with many seeds at once. Run i is `universal_slam(data, seed=seeds[i])`, to rounding.

    (Landmarks whose expectations are equally uncertain to the last digit may come in another order; that happens where
    nothing is random, and changes a run by the error of linearisation at most.)

    Parameters
    ----------
    data : UserData
        One robot in the plane with one `RangeBearing`, landmarks with known ids; see `why_not_batched`.
    seeds : sequence of int

    Returns
    -------
    Run
        A generator of `BatchSnapshot`, one for each frame, that also knows how many there will be.

    Raises
    ------
    ValueError
        Naming what cannot be batched.
    """
    reason = why_not_batched(data)
    if reason:
        raise ValueError(f"these runs cannot be batched: {reason}")
    if not len(seeds):
        raise ValueError("a batch needs at least one seed")
    *_, tim = create_slam_structures(data)
    n_frames = tim.last - tim.first + 1
    return Run(_frames(data, _Worlds(data, seeds, n_frames), tim.first, n_frames), n_frames, "fast, all runs at once")


ONLY = {
    "engine": "fast",
    "joint": False,
    "reopen_after": None,
    "retry_after": None,
    "n_inits": None,
    "init_margin": 0.0,
}
ONLY |= {"max_lmks": None, "capacity": None, "min_match_ratio": 0.0, "min_inlier_ratio": 0.0}
"""Options that batched runs have no other values of."""


def why_not_batched(data):
    """Say what of a scenario `batch_slam` cannot do; None if it can do it all."""
    if data.data is not None:
        return f"the scenario plays the data set {data.data.name!r}"
    if len(data.robots) != 1 or len(data.sensors) != 1:
        return f"one robot with one sensor is needed, got {len(data.robots)} and {len(data.sensors)}"
    robot, sensor, opt = data.robots[0], data.sensors[0], data.options
    if type(robot.motion) not in (Odometry2, Unicycle, Vehicle):
        return f"the motion model {type(robot.motion).__name__} is none of Odometry2, Unicycle, Vehicle"
    if type(sensor.model) is not RangeBearing:
        return f"the sensor {type(sensor.model).__name__} is no RangeBearing"
    if (sensor.landmark or data.landmark.model) != POINT:
        return f"landmarks of type {type(sensor.landmark or data.landmark.model).__name__} are no EucPnt"
    for what, it, wanted in (
        ("robot", robot, {"in_map": True, "noise_factor": 1.0, "clock_offset": 0.0}),
        ("sensor", sensor, {"frame_in_map": False, "clutter": 0.0, "noise_factor": 1.0, "bias": None, "lasting": 0.0}),
        ("landmark", data.landmark, {"in_map": True, "surveyed": []}),
        ("options", opt, ONLY),
    ):
        for name, value in wanted.items():
            if getattr(it, name) != value:
                return f"{what}.{name} = {getattr(it, name)!r}; it would have to be {value!r}"
    if not isinstance(opt.association, KnownIds):
        return f"the association {type(opt.association).__name__} is not KnownIds"
    return None


class _Worlds:
    """The true worlds of all runs, and what is measured in them: `toolbox.sources.Simulation` with one more axis."""

    def __init__(self, data, seeds, n_frames):
        robot, self.sensor, self.dt = data.robots[0], data.sensors[0], data.time.dt
        structures = [create_sim_structures(data, Streams(int(seed))) for seed in seeds]
        self.motion, self.controls, self.U = robot.motion, robot.controls(), robot.U()
        self.x = np.array([robs[0].x for robs, *_ in structures])
        self.Sf = Frame2(np.array([sens[0].frame.x for _, sens, *_ in structures])[:, None])
        worlds = [world for _, _, world, _ in structures]
        self.ids = worlds[0].ids
        if len(set(self.ids.tolist())) < len(self.ids) or any(not np.array_equal(w.ids, self.ids) for w in worlds):
            raise ValueError(
                "these runs cannot be batched: every landmark needs an id of its own, the same in all runs"
            )
        self.points = np.array([world.points for world in worlds])
        self.rngs, self.n_frames = [rngs for *_, rngs in structures], n_frames

    def _draw(self, i):
        """Noise of this frame and the next ones, in the order in which one run draws it."""
        n, N = min(FRAMES_AT_A_TIME, self.n_frames - i), len(self.ids)
        each = lambda take: np.array([take(rngs) for rngs in self.rngs])
        rob, sen, p = self.sensor.robot, self.sensor.id, self.sensor.p_detect
        self.control_noise = each(lambda rngs: draw(rngs["motion", rob], self.U, (n,)))
        self.noise = each(lambda rngs: draw(rngs["sensing", sen], self.sensor.model.R, (n, N)))
        self.found = each(lambda rngs: rngs["clutter", sen].random((n, N)) < p if p < 1 else np.ones((n, N), bool))

    def frame(self, i):
        """Move and measure.

        Returns
        -------
        u : ndarray, shape (R, nu)
            Controls as the filter gets them.
        y : ndarray, shape (R, N, 2)
        found : ndarray of bool, shape (R, N)
            Which landmarks are measured.
        dt : float
        """
        if i % FRAMES_AT_A_TIME == 0:
            self._draw(i)
        k, model, u = i % FRAMES_AT_A_TIME, self.sensor.model, self.controls[i % len(self.controls)]
        dt = (i + 1) * self.dt - i * self.dt
        self.x = Frame2(self.motion.move(self.x, np.broadcast_to(u, (len(self.x), len(u))), dt)[0]).normalized()[0].x
        ps = self.Sf.to_frame(Frame2(self.x[:, None]).to_frame(self.points)[0])[0]
        y = model.residual(model.project(ps)[0] + self.noise[:, k], np.zeros(2))
        return u + self.control_noise[:, k], y, self.found[:, k] & model.visible(y, ps), dt


def _frames(data, worlds, first, n_frames):
    """The loop, as in `universal_slam`."""
    runs, N = len(worlds.x), len(worlds.ids)
    x, P = np.zeros((runs, 3 + 2 * N)), np.zeros((runs, 3 + 2 * N, 3 + 2 * N))
    x[:, ROB], P[:, ROB, ROB] = data.robots[0].start()
    from ..fast import Batch  # here: it brings scipy.linalg along, which takes a while

    slam = _Slam(Batch(x, P), data, worlds)
    for i in range(n_frames):
        u, y, found, dt = worlds.frame(i)
        slam.move(u, dt)
        new = found & ~slam.seen
        slam.correct(y, found)
        slam.init(y, new)
        yield BatchSnapshot(first + i, slam.x, slam.batch.P, worlds.x, slam.seen.copy(), worlds.ids, worlds.points)


class _Slam:
    """The steps of `slam.steps` on all runs."""

    def __init__(self, batch, data, worlds):
        self.batch, self.opt, self.U, self.motion = batch, data.options, worlds.U, worlds.motion
        self.sensor = data.sensors[0].model
        self.Sf = Frame2(data.sensors[0].start(Frame2)[0])
        self.seen = np.zeros((len(batch.x), len(worlds.ids)), bool)
        self.births = np.argsort(worlds.ids, kind="stable")
        self._normalize()
        self.first = self.x.copy() if data.options.first_estimates else None

    @property
    def x(self):
        return self.batch.x

    def _normalize(self):
        turned = np.abs(self.x[:, 2]) >= np.pi
        self.x[turned, 2] = wrap(self.x[turned, 2])

    def move(self, u, dt):
        """Motion of all robots by their controls, shape (R, nu)."""
        before = self.x[:, ROB]
        x, X_x, X_u = self.motion.move(before, u, dt)
        X_x = X_x if self.first is None else X_x @ transport(self.first[:, ROB], before)
        self.batch.predict(ROB, x, X_x, X_u, self.U)
        self._normalize()
        if self.first is not None:
            self.first[:, ROB] = self.x[:, ROB]

    def correct(self, y, found):
        """Landmark after landmark, the most uncertain expectation of each run first."""
        turn = self._turns(found)
        todo = [(turn == k) for k in range(turn.max(initial=-1) + 1)]
        before = None if self.opt.reproject else self.x.copy()
        for some in todo:
            i, active = some.argmax(1), some.any(1)
            self._correct(i, active, y[np.arange(len(y)), i], self.x if before is None else before)
            self._normalize()

    def _turns(self, found):
        """Return when each landmark has its turn, shape (R, N): 0, 1, ...; -1 for those that are not corrected."""
        every = lambda x: (Frame2(x[:, None, ROB]), x[:, 3:].reshape(*found.shape, 2))
        with np.errstate(divide="ignore", invalid="ignore"):
            e, E_r, E_l = self._observe(every, self.x)
            Rf, l = every(self.x)
            v = self.Sf.to_frame(Rf.to_frame(l)[0])[0]
            E = self._expectation(E_r, E_l)
            visible = self.seen & self.sensor.visible(e, v) & np.isfinite(E).all((-1, -2))
        size = np.where(visible, np.linalg.det(np.where(visible[..., None, None], E, 0.0)), -np.inf)
        rank = np.argsort(np.argsort(-size, 1, kind="stable"), 1)
        use = visible & found
        if self.opt.n_updates is not None:
            use &= rank < self.opt.n_updates
        order = np.argsort(np.where(use, rank, found.shape[1]), 1, kind="stable")
        return np.where(use, np.argsort(order, 1), -1)

    def _observe(self, pick, x):
        """Expectations at the states x, shape (R, n), and their Jacobians there, or at the first estimates.

        `pick` takes robot frames and landmarks out of such states.
        """
        at = lambda Rf, l: observe(Rf, self.Sf, self.sensor, POINT, l)
        e, E_r, _, E_l = at(*pick(x))
        if self.first is not None:
            _, E_r, _, E_l = at(*pick(self.first))
        return e, E_r, E_l

    def _expectation(self, E_r, E_l):
        """Covariances H P H' of all expectations, shape (R, N, 2, 2)."""
        P, (runs, N) = self.batch.P, self.seen.shape
        P_rr, P_rl = P[:, None, ROB, ROB], P[:, ROB, 3:].reshape(runs, 3, N, 2).swapaxes(1, 2)
        at = np.arange(N)
        P_ll = np.moveaxis(P[:, 3:, 3:].reshape(runs, N, 2, N, 2)[:, at, :, at], 0, 1)
        E_rt, E_lt = np.swapaxes(E_r, -1, -2), np.swapaxes(E_l, -1, -2)
        cross = E_r @ P_rl @ E_lt
        return E_r @ P_rr @ E_rt + cross + np.swapaxes(cross, -1, -2) + E_l @ P_ll @ E_lt

    def _correct(self, i, active, y, x):
        """One landmark of each run: i (R,), measured as y (R, 2), expected and linearised at the estimate x."""
        rows = 3 + 2 * i[:, None] + np.arange(2)
        with np.errstate(divide="ignore", invalid="ignore"):
            e, E_r, E_l = self._observe(lambda x: (Frame2(x[:, ROB]), np.take_along_axis(x, rows, 1)), x)
            z = self.sensor.residual(y, e)
        E_r, E_l = (np.where(active[:, None, None], J, 0.0) for J in (E_r, E_l))
        z = np.where(active[:, None], z, 0.0)
        PHt, Z = self.batch.innovation(((ROB, E_r), (rows, E_l)), self.sensor.R)
        if np.isfinite(self.opt.md2_threshold):
            md2 = (z * np.linalg.solve(np.moveaxis(Z, -1, 0), z[..., None])[..., 0]).sum(-1)
            refused = ~(md2 < self.opt.md2_threshold)
            PHt[..., refused], z[refused] = 0.0, 0.0
        carried = self.opt.error == "invariant"
        B = self._gauge() if carried else None
        self.batch.update(PHt, Z, z)
        if carried:
            self.batch.carry(ROB, B, self._gauge())

    def _gauge(self):
        """Derivatives of the states of all runs by a motion of the world, shape (R, n, 3); see `slam.gauge`."""
        x, B = self.x, np.zeros((*self.x.shape, 3))
        B[:, 0, 0], B[:, 1, 1], B[:, 2, 2], B[:, 3::2, 0], B[:, 4::2, 1] = 1.0, 1.0, 1.0, 1.0, 1.0
        B[:, 0, 2], B[:, 1, 2], B[:, 3::2, 2], B[:, 4::2, 2] = -x[:, 1], x[:, 0], -x[:, 4::2], x[:, 3::2]
        return B

    def init(self, y, new):
        """New landmarks, by ascending id."""
        for i in self.births:
            runs = np.flatnonzero(new[:, i])
            if not runs.size:
                continue
            Rf = Frame2(self.x[runs, ROB])
            l, L_r, _, L_y, _ = retro_project(Rf, self.Sf, self.sensor, POINT, y[runs, i], np.zeros((len(runs), 0)))
            Q = L_y @ self.sensor.R @ np.swapaxes(L_y, -1, -2)
            r = slice(3 + 2 * i, 5 + 2 * i)
            if self.first is not None:
                L_r = L_r @ transport(self.first[runs, ROB], Rf.x)
                self.first[runs, r] = l
            self.batch.augment(r, runs, l, ((ROB, L_r),), Q)
            self.seen[runs, i] = True
