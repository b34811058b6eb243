"""Two robots in the plane that do and see the same, one with a plain map and one with a compiled one."""

from types import SimpleNamespace

import numpy as np

from ekfslam_tutorial.ekf import CompressedMap, Map
from ekfslam_tutorial.geometry import Frame2
from ekfslam_tutorial.models.landmarks import EucPnt
from ekfslam_tutorial.models.motion import Odometry2
from ekfslam_tutorial.slam import Options, Rob, Sen, correct_known_lmks, init_new_lmks, move, place

from .side_by_side import assert_same_maps, assert_same_obs

POINTS = np.array([[4.0, 1.0], [5.0, -2.0], [3.0, 0.5], [6.0, 2.0], [7.0, -1.0]])


def raw(ids, y, R=None):
    """Raw measurements."""
    return SimpleNamespace(ids=np.asarray(ids, int), y=y, R=R)


def scene(sensor, compiled, capacity=None, active=None, **options):
    """A robot at the origin with a sensor; its map is compressed, if it is said how many states are at hand."""
    map = Map(capacity, compiled=compiled) if active is None else CompressedMap(capacity, active, compiled=compiled)
    rob, sen = Rob(1, Odometry2(), U=1e-4 * np.eye(3), sensors=[1]), Sen(1, 1, sensor, Frame2)
    place(map, rob, np.zeros(3), np.diag([0.01, 0.01, 0.001]))
    place(map, sen, np.array([0.2, 0.0, 0.1]))
    return SimpleNamespace(map=map, rob=rob, sen=sen, lmks={}, obs={}, opt=Options(**{"lmk_type": EucPnt(2)} | options))


class Pair:
    """Both of them."""

    def __init__(self, sensor, **options):
        self.plain, self.compiled = (scene(sensor, compiled, **options) for compiled in (False, True))
        self.truth = Frame2(np.zeros(3))

    def both(self, do):
        """Do something with both; what comes out must be the same."""
        outs = [do(scene) for scene in (self.plain, self.compiled)]
        assert outs[0] == outs[1]
        self.compare()
        return outs[0]

    def compare(self):
        """Maps, landmarks and observations. Asking a compressed map for P would put all back: not while it is used."""
        if isinstance(self.plain.map, Map):
            assert_same_maps(self.plain.map, self.compiled.map)
        assert self.plain.lmks.keys() == self.compiled.lmks.keys() and self.plain.obs.keys() == self.compiled.obs.keys()
        for id, lmk in self.plain.lmks.items():
            assert repr(lmk) == repr(self.compiled.lmks[id]) and lmk.r == self.compiled.lmks[id].r
        for key, o in self.plain.obs.items():
            assert_same_obs(o, self.compiled.obs[key])

    def change(self, do):
        """Change the model of both, which may be one and the same."""
        for model in {id(scene.sen.model): scene.sen.model for scene in (self.plain, self.compiled)}.values():
            do(model)

    def move(self, u, U=None):
        """A step."""
        self.truth = self.truth.compose(Frame2(np.asarray(u, float)))[0]
        for scene in (self.plain, self.compiled):
            scene.rob.u, scene.rob.U = u, scene.rob.U if U is None else U
        self.both(lambda scene: move(scene.map, scene.rob, 0.1))

    def measured(self, rng, points=POINTS, noise=0.3):
        """What the sensor measures of points."""
        model, F = self.plain.sen.model, self.truth.compose(Frame2([0.2, 0.0, 0.1]))[0]
        y = model.project(F.to_frame(points)[0])[0]
        return y + noise * rng.normal(size=y.shape) @ np.sqrt(model.R)

    def look(self, measurements, n_max=None):
        """Correct, and start what is new. Returns the events."""

        def do(scene):
            args = scene.map, scene.rob, scene.sen, scene.lmks
            events, new = correct_known_lmks(*args, scene.obs, measurements, scene.opt)
            return events + init_new_lmks(*args, measurements, new, scene.opt, n_max)

        return self.both(do)

    def go(self, rng):
        """A step and a look."""
        self.move(np.array([0.1, 0.02, 0.05]))
        return self.look(raw(range(len(POINTS)), self.measured(rng)))
