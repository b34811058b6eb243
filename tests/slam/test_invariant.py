"""The invariant error: turning the world costs nothing, and nothing is learnt of it; a native filter says the same."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest

from benchmarks import honest
from ekfslam_tutorial import fast, slam
from ekfslam_tutorial.analysis import anees_band
from ekfslam_tutorial.analysis.batch_slam import batch_slam
from ekfslam_tutorial.geometry import ORIGIN, Frame2, Frame3, e2q, numerical_jacobian, v2q, wrap
from ekfslam_tutorial.models import Calibrated, state_class, turning
from ekfslam_tutorial.models.landmarks import AhmPnt, EucPnt, HmgPnt, IdpPnt
from ekfslam_tutorial.models.motion import ConstantTurn, ConstantVelocity, Imu, Odometry2, Odometry3
from ekfslam_tutorial.models.sensors import BearingOnly2, Doppler, Gps, PinHole, RangeBearing, WheelSpeed
from ekfslam_tutorial.simulation import draw
from ekfslam_tutorial.slam import Lmk, Options, Rob, Sen, correct_met_robots, place, reopen_gate, steps
from ekfslam_tutorial.slam.projection import gauge
from ekfslam_tutorial.toolbox import UserData

from .native import Plane, Space
from .scenes import FORWARD, raw

ENGINES = {"plain": (slam, {}), "fast": (fast, {}), "compressed": (fast, {"compressed": True})}


@dataclass(frozen=True)
class Point:
    """A sensor that measures points in space."""

    std: float = 0.1

    dim: ClassVar[int] = 3
    bearing_only: ClassVar[bool] = False
    R = property(lambda self: self.std**2 * np.eye(3))

    def project(self, p):
        return p, np.broadcast_to(np.eye(3), (*p.shape, 3))

    retro = project

    def residual(self, y, e):
        return np.subtract(y, e)

    def visible(self, y, p):
        return p[..., 0] > -1e9


# --- a native filter --------------------------------------------------------------------------------------------------


class Both:
    """A robot of the package, and a native filter that does the same."""

    def __init__(self, d, engine, joint, rng, error="invariant"):
        self.steps, how = ENGINES[engine]
        self.map, self.rng = self.steps.new_map(**how), rng
        frame, motion, model = (
            (Frame2, Odometry2(), RangeBearing(0.2, 0.05)) if d == 2 else (Frame3, Odometry3(), Point())
        )
        self.rob, self.sen = Rob(1, motion, sensors=[1]), Sen(1, 1, model, frame)
        self.rob.U = np.diag([0.05**2] * d + [0.05**2] * (1 if d == 2 else 3))
        x = (
            np.array([1.0, -2.0, 0.5])
            if d == 2
            else np.concatenate([[1.0, -2.0, 0.5], e2q(np.array([0.2, -0.1, 1.0]))[0]])
        )
        O = ORIGIN[d].compose(frame(x))[1]
        P = O @ np.diag([0.2] * len(x)) ** 2 @ O.T if d == 2 else self.tangent(x, 0.2)
        place(self.map, self.rob, x, P)
        place(self.map, self.sen, ORIGIN[d].x)
        self.native, self.true = (Plane if d == 2 else Space)(x, P), frame(x)
        self.lmks, self.obs, self.opt = {}, {}, Options(lmk_type=EucPnt(d), joint=joint, error=error)
        self.points = 6 * rng.normal(size=(12, d))

    @staticmethod
    def tangent(x, std):
        """Covariance of a pose whose quaternion is of unit length."""
        N_f = Frame3(x).normalized()[1]
        return std**2 * N_f @ N_f.T

    def go(self, u, native=True):
        self.true = self.true.compose(
            self.rob.motion.frame(self.rob.motion.move(ORIGIN[len(self.points[0])].x, u, 1.0)[0])
        )[0]
        self.rob.u = u + draw(self.rng, self.rob.U)
        self.steps.move(self.map, self.rob, 1.0)
        if native:
            self.native.move(self.rob.u, self.rob.U)

    def look(self, native=True):
        """At some of the landmarks. The native filter takes them in the order of the package."""
        p = self.true.to_frame(self.points)[0]
        ids = np.flatnonzero(self.rng.random(len(p)) < 0.4)
        y = self.sen.model.project(p[ids])[0] + draw(self.rng, self.sen.model.R, (len(ids),))
        done, new = self.steps.correct_known_lmks(
            self.map, self.rob, self.sen, self.lmks, self.obs, raw(ids, y), self.opt
        )
        self.steps.init_new_lmks(self.map, self.rob, self.sen, self.lmks, raw(ids, y), new, self.opt)
        if not native:
            return
        y = dict(zip(ids.tolist(), y, strict=True))
        used, R = [event.lmk for event in done if event.kind == "correction"], self.sen.model.R
        for some in [used] if self.opt.joint else [[id] for id in used]:
            self.native.look([self.native.see(id, y[id]) for id in some], R)
        for id in sorted(y.keys() - set(used)):
            self.native.born(id, y[id], R)

    def compare(self):
        A, dx = self.native.to_package(), self.map.x - self.native.x
        if len(self.points[0]) == 2:
            dx[2] = wrap(dx[2])
        assert np.allclose(dx, 0, rtol=0, atol=1e-10)
        assert np.allclose(self.map.P, A @ self.native.P @ A.T, rtol=0, atol=1e-10)


@pytest.mark.parametrize("engine", ["plain", "fast"])
@pytest.mark.parametrize("joint", [False, True], ids=["one by one", "joint"])
@pytest.mark.parametrize("d", [2, 3], ids=["plane", "space"])
def test_a_native_filter_says_the_same(d, joint, engine, rng):
    both = Both(d, engine, joint, rng)
    u = np.array([0.4, 0.1, 0.15]) if d == 2 else np.array([0.4, 0.1, 0.05, 0.05, -0.1, 0.15])
    for _ in range(100):
        both.look()
        both.go(u)
        both.compare()
    assert len(both.lmks) == 12


# --- the gauge --------------------------------------------------------------------------------------------------------


class Witness:
    """A robot among landmarks, and a state of the map that says how the whole world is shifted and turned.

    The witness g has the covariance s^2 I, and everything depends on it as it depends on that: by N.
    Whatever the filter learns of them makes P_gg smaller. Nothing else does.

    Parameters
    ----------
    kind, sensor
        Landmark type and sensor model; in the plane or in space.
    engine : str
    motion : MotionModel, optional
    in_map : bool
        The frame of the sensor on the robot is estimated, too.
    params : tuple of str
        So are these parameters of the sensor.
    options : dict
    """

    s = 0.3

    def __init__(self, kind, sensor, engine="plain", motion=None, in_map=False, params=(), **options):
        self.steps, how = ENGINES[engine]
        self.d, self.map, self.rng = kind.dim, self.steps.new_map(**how), np.random.default_rng(3)
        frame = Frame2 if self.d == 2 else Frame3
        motion = motion or (Odometry2() if self.d == 2 else Odometry3())
        seen_as = Calibrated(sensor, params) if params else sensor
        self.rob, self.sen = Rob(1, motion, sensors=[1]), Sen(1, 1, seen_as, state_class(frame, seen_as))
        pose = (
            np.array([0.5, -1.0, 0.4])
            if self.d == 2
            else np.concatenate([[0.5, -1.0, 0.2], e2q(np.array([0.1, 0.2, 0.4]))[0]])
        )
        x = np.concatenate([pose, 0.1 * np.ones(motion.size - len(pose))])
        P = np.zeros((len(x), len(x)))
        P[len(pose) :, len(pose) :] = 1e-4 * np.eye(len(x) - len(pose))
        place(self.map, self.rob, x, P)
        mount = np.zeros(3) if self.d == 2 else FORWARD
        mount = np.concatenate([mount, seen_as.start if params else []])
        place(self.map, self.sen, mount, 1e-4 * np.eye(len(mount)) if in_map or params else None)
        self.lmks, self.obs, self.true = {}, {}, frame(pose)
        prior = {"n": [0.3], "N": [[0.02]]}
        self.opt = Options(**{"lmk_type": kind, "error": "invariant"} | prior | options)
        some = 8 if isinstance(sensor, PinHole) else 2  # a camera does not look behind itself
        self.points = np.concatenate(
            [5 * self.rng.normal(size=(some, self.d)), 6 * np.eye(self.d), -6 * np.eye(self.d)]
        )
        self.add_witness()

    def add_witness(self):
        """g, and what depends on it."""
        N = gauge(self.map, self.rob, {})
        self.map.P[:] += self.s**2 * N @ N.T
        self.g = self.map.add(np.zeros(N.shape[1]), self.s**2 * np.eye(N.shape[1]), self.s**2 * N.T)

    def frame(self):
        """Move, look, correct, start."""
        m = self.rob.motion
        u = 0.1 * self.rng.normal(size=sum(m.control_fields.values()))
        if m.size == m.frame.size:
            self.true = self.true.compose(m.frame(m.move(ORIGIN[self.d].x, u, 0.1)[0]))[0]
        else:  # who knows of an impulse in the axes of the world knows how the world is turned
            u *= 0.0
        if isinstance(m, Imu):  # it stands still, and feels its weight
            u[3:6] = self.true.R.T @ -np.array(m.gravity)
        self.rob.u, self.rob.U = u + 0.02 * self.rng.normal(size=len(u)) * (u != 0), 0.02**2 * np.eye(len(u))
        self.steps.move(self.map, self.rob, 0.1)
        mount = ORIGIN[2] if self.d == 2 else Frame3(FORWARD)
        p = mount.to_frame(self.true.to_frame(self.points)[0])[0]
        if isinstance(self.sen.model, Doppler):  # it stands still
            p = np.concatenate([p, np.zeros((len(p), 3))], 1)
        y = self.sen.model.project(p)[0] + draw(self.rng, self.sen.model.R, (len(p),))
        seen = np.flatnonzero(self.sen.model.visible(y, p) & (self.rng.random(len(p)) < 0.7))
        args, now = (self.map, self.rob, self.sen, self.lmks), raw(seen, y[seen])
        done, new = self.steps.correct_known_lmks(*args, self.obs, now, self.opt)
        self.steps.init_new_lmks(*args, now, new, self.opt)
        return done

    @property
    def left(self):
        """What is left of the variances of the witness: 1 where nothing was learnt."""
        return np.linalg.eigvalsh(self.map.block(self.g)) / self.s**2


KINDS = {
    "points in the plane": (EucPnt(2), RangeBearing(0.1, 0.03)),
    "homogeneous in the plane": (HmgPnt(2), BearingOnly2(0.02)),
    "anchored in the plane": (AhmPnt(2), BearingOnly2(0.02)),
    "points in space": (EucPnt(3), Point(0.1)),
    "inverse depth": (IdpPnt(), PinHole(pixel_std=2.0)),
    "anchored": (AhmPnt(), PinHole(pixel_std=2.0)),
    "homogeneous": (HmgPnt(), PinHole(pixel_std=2.0)),
}


@pytest.mark.parametrize("kind", KINDS)
def test_nothing_is_learnt_of_the_gauge_in_a_thousand_frames(kind):
    ours = Witness(*KINDS[kind], engine="fast", joint=True)
    n = sum(event.kind == "correction" for _ in range(1000) for event in ours.frame())
    assert n > 1300 and abs(ours.left - 1).max() < 1e-8


@pytest.mark.parametrize("joint", [False, True], ids=["one by one", "joint"])
@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("kind", KINDS)
def test_nothing_is_learnt_of_it_whoever_computes(kind, engine, joint):
    """The additive filter learns the turn; and a shift, where points are homogeneous."""
    left = {}
    for error in ("additive", "invariant"):
        ours = Witness(*KINDS[kind], engine=engine, joint=joint, error=error)
        for _ in range(12):
            ours.frame()
        left[error] = ours.left
    assert abs(left["invariant"] - 1).max() < 1e-9 and left["additive"].min() < 0.95


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(
    "case",
    [
        dict(motion=ConstantVelocity()),
        dict(in_map=True),
        dict(joint=True, in_map=True, motion=ConstantVelocity()),
        dict(md2_threshold=3.0, min_match_ratio=0.9, min_inlier_ratio=0.8, min_search=4, reopen_after=2),
    ],
    ids=["velocities", "sensor in the map", "both, joint", "gate, deletion, recovery"],
)
def test_nothing_is_learnt_of_it_with_velocities_sensors_in_the_map_deletions(case, engine):
    ours, kinds = Witness(EucPnt(3), Point(0.1), engine, **case), set()
    for _ in range(25):
        done = ours.frame()
        kinds |= {(e.kind, e.flag) for e in done + reopen_gate(ours.map, ours.rob, done, ours.opt)}
    assert abs(ours.left - 1).max() < 1e-9
    assert "min_search" not in case or {("innovation", False), ("deletion", True), ("recovery", True)} <= kinds


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(
    "kind, sensor, case",
    [
        (AhmPnt(), PinHole(d=(-0.1,), pixel_std=2.0), dict(params=("f", "d"), joint=True)),
        (EucPnt(3), Point(0.1), dict(params=("bias", "delay"), motion=ConstantVelocity())),
        (EucPnt(2), Doppler(0.1, 0.03), dict(motion=ConstantTurn(), in_map=True)),
    ],
    ids=["lens", "bias and delay", "Doppler"],
)
def test_nothing_is_learnt_of_it_by_sensors_with_parameters_or_velocities(kind, sensor, case, engine):
    """A focal length does not turn with the world; a velocity in the world does, one in the robot does not."""
    left = {}
    for error in ("additive", "invariant"):
        ours = Witness(kind, sensor, engine, error=error, **case)
        n = sum(event.kind == "correction" for _ in range(15) for event in ours.frame())
        left[error] = ours.left
        assert n > 15
    assert abs(left["invariant"] - 1).max() < 1e-9 and left["additive"].min() < 0.95


@pytest.mark.parametrize("engine", ENGINES)
def test_nothing_is_learnt_of_it_by_wheels_but_all_by_gps(engine):
    ours = Witness(EucPnt(2), RangeBearing(0.1, 0.03), engine, motion=ConstantTurn())
    wheel, gps = Sen(2, 1, WheelSpeed(), Frame2), Sen(3, 1, Gps(0.01), Frame2)
    for each, x in ((wheel, [0.0, 0.4, 0.1]), (gps, [0.3, 0.0, 0.0])):
        place(ours.map, each, np.array(x))
    look = lambda sen, y: ours.steps.correct_without_lmks(
        ours.map, ours.rob, sen, ours.obs, raw([-1], np.array([y])), ours.opt, ours.lmks
    )
    for _ in range(15):
        ours.frame()
        assert look(wheel, [0.0])[0].flag
    assert abs(ours.left - 1).max() < 1e-9
    look(gps, ours.true.from_frame(np.array([0.3, 0.0]))[0])
    assert ours.left.min() < 0.01


@pytest.mark.parametrize("joint", [False, True], ids=["one by one", "joint"])
@pytest.mark.parametrize("engine", ENGINES)
def test_who_feels_gravity_learns_what_is_upright_and_nothing_else(engine, joint):
    """With an accelerometer the gauge has four directions: three shifts, and the turn about the vertical. To tilt the
    world is none, for its weight tells. The additive filter learns the turn, too."""
    left, upright = {}, np.array([0, 1, 2, 5])
    for error in ("additive", "invariant"):
        ours = Witness(EucPnt(3), Point(0.1), engine, motion=Imu(), error=error, joint=joint)
        n = sum(event.kind == "correction" for _ in range(25) for event in ours.frame())
        left[error] = ours.map.block(ours.g) / ours.s**2
        assert n > 50
    four = left["invariant"][np.ix_(upright, upright)]
    assert abs(four - np.eye(4)).max() < 1e-9
    assert np.diagonal(left["invariant"])[[3, 4]].max() < 0.9
    assert left["additive"][5, 5] < 0.95


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("kind", [IdpPnt(), AhmPnt()], ids=["inverse depth", "anchored"])
def test_nothing_is_learnt_of_it_when_points_become_euclidean(kind, engine):
    ours = Witness(kind, PinHole(pixel_std=2.0), engine, reparametrize=True, lin_test=0.5, joint=engine == "fast")
    for _ in range(60):
        ours.frame()
    types = {type(lmk.type) for lmk in ours.lmks.values()}
    assert EucPnt in types and abs(ours.left - 1).max() < 1e-9


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("d", [2, 3], ids=["plane", "space"])
def test_nothing_is_learnt_of_it_when_robots_meet(d, engine):
    """The second robot stands where the first one knows the world to be; it is seen, and goes about."""
    sensor = RangeBearing(0.1, 0.03) if d == 2 else Point(0.1)
    left = {}
    for error in ("additive", "invariant"):
        ours = Witness(EucPnt(d), sensor, engine, error=error, joint=engine != "plain")
        other = Rob(2, ours.rob.motion, sensors=[])
        x = ours.rob.state(ours.map) + 0.5 * np.eye(len(ours.rob.state(ours.map)))[0]
        place(ours.map, other, x, 1e-4 * np.diag([1.0] * d + [0.0] * (len(x) - d)))
        N = gauge(ours.map, other, {})  # of both robots
        N[ours.g] = np.eye(N.shape[1])
        P_rm = ours.s**2 * N[other.r] @ N.T
        ours.map.put(other.r, x, P_rm, P_rm[:, other.r] + ours.map.block(other.r))
        other.u, other.U = np.zeros(3 if d == 2 else 6), 1e-4 * np.eye(3 if d == 2 else 6)
        robs, met = [ours.rob, other], 0
        for _ in range(25):
            ours.frame()
            ours.steps.move(ours.map, other, 0.1)
            p = ours.true.to_frame(other.frame(ours.map).t)[0] + 0.05 * ours.rng.normal(size=d)
            p = p if d == 2 else ours.sen.frame(ours.map).to_frame(p)[0]
            args = ours.map, ours.rob, ours.sen, robs, raw([2], ours.sen.model.project(p[None])[0]), ours.opt
            meet = getattr(ours.steps, "correct_met_robots", correct_met_robots)
            met += sum(event.flag for event in meet(*args, ours.lmks))
        left[error] = ours.left
        assert met == 25
    assert abs(left["invariant"] - 1).max() < 1e-9 and left["additive"].min() < 0.9


# --- B, and who has none ----------------------------------------------------------------------------------------------


def moved(map, rob, lmks, g):
    """The state with the whole world moved by a frame g: what B is the derivative of."""
    F = type(ORIGIN[rob.motion.frame.dim])
    G, x = F(np.concatenate([g[: F.dim], g[F.dim :] if F.dim == 2 else v2q(g[F.dim :])[0]])), map.x.copy()
    for lmk in lmks.values():
        x[lmk.r] = lmk.type.from_frame(G, x[lmk.r])[0]
    x[rob.r][: F.size] = G.compose(F(x[rob.r][: F.size]))[0].x
    if rob.motion.size > F.size:
        x[rob.r][F.size : F.size + 3] = G.R @ x[rob.r][F.size : F.size + 3]
    return x


@pytest.mark.parametrize("kind", [EucPnt(2), HmgPnt(2), AhmPnt(2), EucPnt(3), HmgPnt(), AhmPnt(), IdpPnt()], ids=str)
def test_the_gauge_is_how_the_state_moves_with_the_world(kind, rng):
    map, d = slam.new_map(), kind.dim
    rob = Rob(1, Odometry2() if d == 2 else ConstantVelocity())
    x = rng.normal(size=rob.motion.size)
    x[3:7] /= np.linalg.norm(x[3:7]) if d == 3 else 1.0
    place(map, rob, x, np.eye(len(x)))
    lmks = {i: Lmk(i, kind, r=map.add(rng.normal(size=kind.size) + 1.0, np.eye(kind.size))) for i in range(3)}
    lmks[9] = Lmk(9, kind, x=np.ones(kind.size))
    known = lmks.pop(9)
    J = numerical_jacobian(lambda g: moved(map, rob, lmks, g), np.zeros(3 if d == 2 else 6))
    assert np.allclose(gauge(map, rob, lmks | {9: known}), J, atol=1e-6)


@dataclass(frozen=True)
class Drifting:
    """A body with a velocity in the world and the bias of its gyro; on its plane, or in space."""

    north: float = 0.0

    frame: ClassVar = Frame2
    size: ClassVar[int] = 6
    control_fields: ClassVar = {"a": 1}
    state_fields: ClassVar = {"vel": 2, "bias": 1}

    def move(self, x, u, dt):
        x2, X_x = x.copy(), np.eye(6)
        x2[:2] += dt * x[3:5]
        x2[2] += dt * x[5] + self.north * np.sin(x[2])
        X_x[:2, 3:5], X_x[2, 5], X_x[2, 2] = dt * np.eye(2), dt, 1 + self.north * np.cos(x[2])
        return x2, X_x, np.eye(6)[:, 5:]


def test_how_velocities_turn_is_found_out():
    class Untold(ConstantVelocity):
        turning: ClassVar = property()  # as if it were not there

    x = np.arange(13.0)
    assert np.array_equal(turning(Untold(), x), turning(ConstantVelocity(), x))
    assert np.array_equal(turning(Drifting(), np.arange(6.0)), [[-4.0], [3.0], [0.0]])
    with pytest.raises(TypeError, match="Drifting: how vel, bias turn with the world is not clear from move: write a "):
        turning(Drifting(north=0.5), np.arange(6.0))


def test_a_known_robot_carries_nothing(rng):
    """It is known how the world lies: the correction is the textbook's, to the last bit."""
    ends = []
    for error in ("additive", "invariant"):
        both = Both(2, "plain", False, np.random.default_rng(2), error)
        both.rob.x, both.rob.r = both.rob.state(both.map), None
        for _ in range(3):
            both.look(native=False)
        ends.append(both.map)
    assert np.array_equal(ends[0].x, ends[1].x) and np.array_equal(ends[0].P, ends[1].P) and ends[0].n


def test_an_error_that_there_is_not_is_named():
    with pytest.raises(ValueError, match="^error must be 'invariant' or 'additive', got 'local'$"):
        Options(error="local")


# --- what it is good for ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("joint", [False, True], ids=["one by one", "joint"])
@pytest.mark.parametrize("d", [2, 3], ids=["plane", "space"])
def test_a_robot_that_stands_still_keeps_its_30_degrees(d, joint, engine, rng):
    """Julier and Uhlmann, ICRA 2001: the classical counter-example. Landmarks come in later, too, after corrections."""
    sigma, left = np.radians(30.0), {}
    points = np.concatenate([4 * np.eye(d), -3 * np.eye(d)])
    for error in ("additive", "invariant"):
        steps, how = ENGINES[engine]
        map, model = steps.new_map(**how), RangeBearing(0.1, 0.02) if d == 2 else Point(0.1)
        rob = Rob(1, Odometry2() if d == 2 else Odometry3())
        sen, O = Sen(1, 1, model, type(ORIGIN[d])), ORIGIN[d]
        place(map, rob, O.x, sigma**2 * O.X_step[:, d:] @ O.X_step[:, d:].T)
        place(map, sen, O.x)
        lmks, obs, opt = {}, {}, Options(lmk_type=EucPnt(d), error=error, joint=joint)
        for k in range(30):
            some = points[: 1 + k // 6]
            now = raw(range(len(some)), model.project(some)[0] + draw(rng, model.R, (len(some),)))
            done, new = steps.correct_known_lmks(map, rob, sen, lmks, obs, now, opt)
            steps.init_new_lmks(map, rob, sen, lmks, now, new, opt)
        E = np.linalg.pinv(gauge(map, rob, lmks)[rob.r])[d:]
        left[error] = np.degrees(np.sqrt(np.linalg.eigvalsh(E @ map.block(rob.r) @ E.T)))
    assert left["invariant"] == pytest.approx(30.0, abs=1e-7) and left["additive"].min() < 28.0


def test_the_order_of_the_corrections_hardly_matters(monkeypatch):
    """Six runs of the same measurements, each with its own order in every frame."""
    spread = {}
    for error in ("additive", "invariant"):
        ends = []
        for seed in range(6):
            order = np.random.default_rng(seed)
            monkeypatch.setattr(steps, "most_uncertain", lambda seen, n, order=order: list(order.permutation(seen)))
            both = Both(3, "plain", False, np.random.default_rng(5), error)
            for _ in range(25):
                both.look(native=False)
                both.go(np.array([0.4, 0.1, 0.05, 0.05, -0.1, 0.15]), native=False)
            ends.append(both.rob.frame(both.map).t)
        spread[error] = np.std(ends, 0).max()
    assert spread["invariant"] < 0.5 * spread["additive"], spread


RUNS = 200
LOOP = {
    "time": {"dt": 0.5, "last": 60},
    "world": {"type": "lecture"},
    "robot": [{"motion": "unicycle", "position": [0, -4], "v": 1.0, "w_deg": 14.4, "v_std": 0.1, "w_std_deg": 6.0}],
    "sensor": [{"type": "range_bearing", "range_std": 0.1, "bearing_std_deg": 1.0, "max_range": 5.0}],
}


def test_two_hundred_runs_in_the_plane_are_honest():
    """Mean NEES of the pose, in the second round: in its 99.9 % band, where the additive error is above it."""
    mean = {}
    for error in ("additive", "invariant"):
        *_, now = batch_slam(UserData.from_dict(LOOP | {"options": {"error": error}}), range(RUNS))
        e = Frame2(now.x[:, :3]).minus(Frame2(now.truth))[0]
        mean[error] = (e * np.linalg.solve(now.P[:, :3, :3], e[..., None])[..., 0]).sum(-1).mean()
    low, high = anees_band(3, RUNS, 0.999)
    assert low < mean["invariant"] < high < mean["additive"], mean


@pytest.mark.parametrize("joint", [False, True], ids=["one by one", "joint"])
def test_two_hundred_runs_in_space_are_honest(joint):
    """The same with a stereo camera in space, before the round is closed."""
    sensor, U = honest.Stereo(), np.diag([0.02**2] * 3 + [np.radians(0.5) ** 2] * 3)
    world = honest.World(10, 51, sensor, radius=3.0)
    run = lambda error, seeds: honest.run(world, sensor, error, seeds, U, joint)
    mean = {error: run(error, range(RUNS))[0][0][-1].mean() for error in ("additive", "invariant")}
    low, high = anees_band(6, RUNS, 0.999)
    assert low < mean["invariant"] < high < mean["additive"], mean


class Wide(honest.Stereo):
    """It looks for all landmarks that may be measured."""

    def visible(self, y, p):
        return p[..., 2] > 0.0


def test_those_runs_are_those_of_the_engine():
    """One of them again, with the steps of the package."""
    sensor, U = honest.Stereo(), np.diag([0.02**2] * 3 + [np.radians(0.5) ** 2] * 3)
    world, rng = honest.World(10, 20, sensor, radius=3.0), np.random.default_rng(4)
    controls = world.u + rng.normal(size=world.u.shape) * np.sqrt(np.diag(U))
    y = world.y + sensor.std * rng.normal(size=world.y.shape)
    _, batch = honest.run(world, sensor, "invariant", [4], U)

    map, rob, sen = slam.new_map(), Rob(1, Odometry3(), U=U), Sen(1, 1, Wide(), Frame3)
    place(map, rob, world.poses[0].x, np.zeros((7, 7)))
    place(map, sen, honest.MOUNT.x)
    lmks, obs, opt = {}, {}, Options(lmk_type=EucPnt(3), error="invariant", joint=True)
    for k, seen in enumerate(world.seen):
        rob.u = controls[k]
        if k:
            slam.move(map, rob, 1.0)
        now = raw(np.flatnonzero(seen), y[k][seen])
        _, new = slam.correct_known_lmks(map, rob, sen, lmks, obs, now, opt)
        slam.init_new_lmks(map, rob, sen, lmks, now, new, opt)
    at = np.r_[(slice(0, 7), *(honest.lmk(i) for i in lmks))]
    here = np.r_[(rob.r, *(lmk.r for lmk in lmks.values()))]
    assert np.allclose(map.x[here], batch.x[0][at], rtol=0, atol=1e-9)
    assert np.allclose(map.P[np.ix_(here, here)], batch.P[0][np.ix_(at, at)], rtol=0, atol=1e-9)
