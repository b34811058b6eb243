"""The same runs by three authors: this package's blocks, a dense textbook filter, and filterpy.

Robot poses, landmarks and the whole covariance must agree to 1e-10: the numbers are metres and radians near one, and
some hundred corrections add up a rounding error of 1e-16 each.
"""

from types import SimpleNamespace

import numpy as np
import pytest
from filterpy.kalman import ExtendedKalmanFilter

from ekfslam_tutorial.ekf import Map, correct, covariance, cross, innovation
from ekfslam_tutorial.geometry import Frame2, Frame3, e2q
from ekfslam_tutorial.models import observe, retro_project
from ekfslam_tutorial.models.landmarks import AhmPnt, EucPnt, IdpPnt
from ekfslam_tutorial.models.motion import Odometry2
from ekfslam_tutorial.models.sensors import PinHole, RangeBearing
from ekfslam_tutorial.slam import Lmk, Options, Rob, Sen, correct_known_lmks, init_new_lmks, move, place

from .textbook import Slam2, Textbook, odometry, range_bearing

TOLERANCE = 1e-10


class Filterpy:
    """The same dense filter through filterpy; a new state needs a new, larger filter there."""

    def __init__(self, x, P):
        self.f = self._filter(np.array(x, float), np.array(P, float))

    @staticmethod
    def _filter(x, P):
        f = ExtendedKalmanFilter(dim_x=max(len(x), 1), dim_z=2)
        f.x, f.P, f._I = x, P, np.eye(len(x))
        return f

    @property
    def x(self):
        return self.f.x

    @property
    def P(self):
        return self.f.P

    def predict(self, x, F, Q):
        self.f.F, self.f.Q = F, Q
        self.f.predict_x = lambda u: setattr(self.f, "x", x)
        self.f.predict()

    def correct(self, z, H, R):
        # The innovation is handed over with its angle wrapped: without a residual filterpy would just subtract.
        self.f.update(z, lambda x: H, lambda x: np.zeros(2), R=R, residual=lambda z, _: z)

    def augment(self, l, G, Q):
        big = Textbook(self.x, self.P)
        big.augment(l, G, Q)
        self.f = self._filter(big.x, big.P)


# --- whole runs in the plane -----------------------------------------------------------------------------------------

POINTS = {i: p for i, p in enumerate(np.random.default_rng(5).uniform(-5, 5, (9, 2)), 1)}
U = np.diag([0.02, 0.01, 0.02]) ** 2
SENSOR = RangeBearing(0.05, 0.02, max_range=6.0)
FRAMES = 25


def world(seed=1):
    """Noisy controls and measurements of a robot on a round; some bearings cross the seam."""
    rng = np.random.default_rng(seed)
    pose = np.array([0.0, -3.0, 0.3])
    for _ in range(FRAMES):
        u = np.array([0.4, 0.0, 0.14])
        pose = odometry(pose, u)[0]
        seen = {id: range_bearing(pose, p)[0] for id, p in POINTS.items() if np.linalg.norm(p - pose[:2]) < 6}
        ids = np.array(list(seen))
        y = np.array(list(seen.values())) + rng.normal(size=(len(ids), 2)) * [0.05, 0.02]
        y[:, 1] = (y[:, 1] + np.pi) % (2 * np.pi) - np.pi
        yield pose, u + rng.normal(size=3) @ np.sqrt(U), SimpleNamespace(ids=ids, y=y, R=None)


def ours(use):
    """Run the package; every step is told to the listeners as well.

    Parameters
    ----------
    use : str
        mapping (the pose is known), localisation (the landmarks are known) or slam.

    Yields
    ------
    map, and the step just done as (name, arguments)
    """
    map, rob, sen = Map(), Rob(1, Odometry2(), U=U), Sen(1, 1, SENSOR, Frame2)
    place(map, rob, np.array([0.0, -3.0, 0.3]), None if use == "mapping" else np.zeros((3, 3)))
    place(map, sen, np.zeros(3))
    lmks = {i: Lmk(i, EucPnt(2), x=p, slot=i) for i, p in POINTS.items()} if use == "localisation" else {}
    opt, obs = Options(lmk_type=EucPnt(2), error="additive"), {}
    for pose, u, raw in world():
        if use == "mapping":
            rob.x = pose
            yield map, ("pose", pose)
        else:
            rob.u = u
            move(map, rob, 0.1)
            yield map, ("move", u, U)
        events, new = correct_known_lmks(map, rob, sen, lmks, obs, raw, opt)
        events += init_new_lmks(map, rob, sen, lmks, raw, new, opt)
        y = dict(zip(raw.ids.tolist(), raw.y, strict=True))
        for event in events:
            if event.kind in ("correction", "initialisation"):
                step = "correct" if event.kind == "correction" else "start"
                yield None, (step, event.lmk, y[event.lmk], SENSOR.R)
        yield map, ("end",)


@pytest.mark.parametrize("author", [Textbook, Filterpy])
@pytest.mark.parametrize("use", ["mapping", "localisation", "slam"])
def test_whole_runs(use, author):
    P0 = None if use == "mapping" else np.zeros((3, 3))
    theirs = Slam2(author, [0.0, -3.0, 0.3], P0, POINTS if use == "localisation" else None)
    counts = dict(correct=0, start=0, end=0)
    for map, (step, *args) in ours(use):
        if step == "pose":
            theirs.pose = args[0]
        elif step != "end":
            getattr(theirs, step)(*args)
        counts[step] = counts.get(step, 0) + 1
        if step == "end":
            assert map.n == len(theirs.filter.x)
            assert np.allclose(map.x, theirs.filter.x, rtol=0, atol=TOLERANCE)
            assert np.allclose(map.P, theirs.filter.P, rtol=0, atol=TOLERANCE)
    assert counts["correct"] > 90 and counts["end"] == FRAMES
    assert counts["start"] == (0 if use == "localisation" else len(POINTS))


# --- one monocular correction in space -------------------------------------------------------------------------------


def camera_scene(kind, calibrate, rng):
    """A map with a robot, maybe its sensor, and two landmarks just born; and what the camera expects of one."""
    camera, map = PinHole((320.0, 240.0, 320.0, 320.0), (-0.3, 0.1)), Map()
    pose = lambda: np.concatenate([rng.normal(size=3) * 0.1, e2q(rng.normal(size=3) * 0.1)[0]])
    tilt = Frame3(np.concatenate([np.zeros(3), e2q(np.radians([-90, 0, -90]))[0]]))
    Rf, Sf = Frame3(pose()), Frame3(pose()).compose(tilt)[0]
    r = map.add(Rf.x, spread(7, 0.02, rng))
    s = map.add(Sf.x, spread(7, 0.01, rng)) if calibrate else None
    states = []
    for y in np.array([[300.0, 200.0], [400.0, 260.0]]):
        l, L_r, L_s, L_y, L_n = retro_project(Rf, Sf, camera, kind, y, np.array([0.2]))
        blocks = [(rng_, J) for rng_, J in ((r, L_r), (s, L_s)) if rng_ is not None]
        PLt = cross(map, blocks)
        Q = L_y @ camera.R @ L_y.T + L_n @ L_n.T * 0.04
        states.append(map.add(l, covariance(PLt, blocks) + Q, PLt.T))
    y = np.array([305.0, 207.0])
    e, E_r, E_s, E_l = observe(Rf, Sf, camera, kind, map.x[states[0]])
    return camera, map, y, e, ((r, E_r), (s, E_s), (states[0], E_l))


def spread(n, std, rng):
    """A random covariance of this size."""
    A = std * rng.normal(size=(n, n))
    return A @ A.T


@pytest.mark.parametrize("calibrate", [False, True], ids=["known-sensor", "self-calibration"])
@pytest.mark.parametrize("kind", [IdpPnt(), AhmPnt()])
@pytest.mark.parametrize("author", [Textbook, Filterpy])
def test_a_monocular_correction(author, kind, calibrate, rng):
    camera, map, y, e, blocks = camera_scene(kind, calibrate, rng)
    theirs, H = author(map.x.copy(), map.P.copy()), np.zeros((2, map.n))
    for r, J in blocks:
        if r is not None:
            H[:, r] = J
    PHt = cross(map, blocks)
    correct(map, PHt, innovation(camera.residual(y, e), covariance(PHt, blocks), camera.R))
    theirs.correct(y - e, H, camera.R)
    assert np.allclose(map.x, theirs.x, rtol=0, atol=TOLERANCE)
    assert np.allclose(map.P, theirs.P, rtol=0, atol=TOLERANCE)
    assert np.abs(map.x - theirs.x).max() < 1e-3 * np.abs(y - e).max()
