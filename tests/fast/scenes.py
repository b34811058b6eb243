"""Robots in the plane that do and see the same: one with the plain engine, one with each kind of fast map."""

from types import SimpleNamespace

import numpy as np

from ekfslam_tutorial.fast import FastMap
from ekfslam_tutorial.geometry import Frame2
from ekfslam_tutorial.models.landmarks import EucPnt
from ekfslam_tutorial.models.motion import Odometry2
from ekfslam_tutorial.slam import Options, Rob, Sen, place

from .law import PLAIN, assert_same_lmks, assert_same_maps, assert_same_obs, exact, fast_engines

POINTS = np.array([[4.0, 1.0], [5.0, -2.0], [3.0, 0.5], [6.0, 2.0], [7.0, -1.0]])


def raw(ids, y, R=None):
    """Raw measurements."""
    return SimpleNamespace(ids=np.asarray(ids, int), y=y, R=R)


def scene(engine, sensor, capacity=None, **options):
    """A robot at the origin with a sensor."""
    map = engine.new_map(capacity)
    rob, sen = Rob(1, Odometry2(), U=1e-4 * np.eye(3), sensors=[1]), Sen(1, 1, sensor, Frame2)
    place(map, rob, np.zeros(3), np.diag([0.01, 0.01, 0.001]))
    place(map, sen, np.array([0.2, 0.0, 0.1]))
    opt = Options(**{"lmk_type": EucPnt(2), "error": "additive"} | options)
    return SimpleNamespace(engine=engine, map=map, rob=rob, sen=sen, lmks={}, obs={}, opt=opt)


class Scenes:
    """All of them: `plain`, and `quick` by the kind of fast map."""

    def __init__(self, sensor, capacity=None, active=8, **options):
        self.plain = scene(PLAIN, sensor, capacity, **options)
        error = self.plain.opt.error
        engines = {name: engine for name, engine in fast_engines(active).items() if exact(name, error)}
        self.quick = {name: scene(engine, sensor, capacity, **options) for name, engine in engines.items()}
        self.truth, self.times = Frame2(np.zeros(3)), 0

    @property
    def all(self):
        """The plain one first."""
        return [self.plain, *self.quick.values()]

    @property
    def compiled(self):
        """That with the compiled map."""
        return self.quick["compiled"]

    def each(self, do):
        """Do something with all of them; what comes out, or is said to be wrong, must be the same."""
        outs = [outcome(do, scene) for scene in self.all]
        for name, out in zip(self.quick, outs[1:], strict=True):
            assert out == outs[0], (name, out, outs[0])
        self.compare()
        return outs[0]

    def compare(self, whole=False):
        """Landmarks and observations; and maps, the compressed ones now and then: who is asked tidies up."""
        self.times += 1
        for scene in self.quick.values():
            if whole or isinstance(scene.map, FastMap) or self.times % 5 == 0:
                assert_same_maps(self.plain.map, scene.map, whole)
            assert_same_lmks(self.plain.lmks, scene.lmks)
            assert_same_obs(self.plain.obs, scene.obs)

    def change(self, do):
        """Change the model of all, which may be one and the same."""
        for model in {id(scene.sen.model): scene.sen.model for scene in self.all}.values():
            do(model)

    def move(self, u, U=None):
        """A step."""
        self.truth = self.truth.compose(Frame2(np.asarray(u, float)))[0]
        for scene in self.all:
            scene.rob.u, scene.rob.U = u, scene.rob.U if U is None else U
        return self.each(lambda scene: scene.engine.move(scene.map, scene.rob, 0.1))

    def measured(self, rng, points=POINTS, noise=0.3):
        """What the sensor measures of points."""
        model, F = self.plain.sen.model, self.truth.compose(Frame2([0.2, 0.0, 0.1]))[0]
        y = model.project(F.to_frame(points)[0])[0]
        return y + noise * rng.normal(size=y.shape) @ np.sqrt(model.R)

    def look(self, measurements, n_max=None):
        """Correct, and start what is new. Returns the events."""
        return self.each(lambda scene: look(scene, measurements, n_max))

    def go(self, rng):
        """A step and a look."""
        self.move(np.array([0.1, 0.02, 0.05]))
        return self.look(raw(range(len(POINTS)), self.measured(rng)))


def look(scene, measurements, n_max=None):
    """One frame of one of them. Returns the events."""
    args = scene.map, scene.rob, scene.sen, scene.lmks
    events, new = scene.engine.correct_known_lmks(*args, scene.obs, measurements, scene.opt)
    return events + scene.engine.init_new_lmks(*args, measurements, new, scene.opt, n_max)


def outcome(do, scene):
    """What comes out, or the sentence of the error, up to the numbers in it."""
    try:
        with np.errstate(all="ignore"):
            return do(scene)
    except (ValueError, TypeError) as error:
        return type(error), str(error).split(", got")[0]
