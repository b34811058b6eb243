"""ekfslam_tutorial on the benchmark's world: the filter with given blocks, and whole steps as a user writes them."""

from importlib.util import find_spec
from types import SimpleNamespace

import numpy as np

from ekfslam_tutorial import ekf, fast, slam
from ekfslam_tutorial.geometry import Frame2
from ekfslam_tutorial.models.landmarks import EucPnt
from ekfslam_tutorial.models.motion import Odometry2
from ekfslam_tutorial.models.sensors import RangeBearing
from ekfslam_tutorial.slam import Lmk, Options, Rob, Sen, place

from .given import given
from .world import R, U

# What is measured: the quick steps, and the readable ones. Their names stand here and nowhere else in this folder.
FAST = fast
PLAIN = SimpleNamespace(
    new_map=slam.new_map,
    move=slam.move,
    correct_known_lmks=slam.correct_known_lmks,
    init_new_lmks=slam.init_new_lmks,
    predict=ekf.predict,
    update=ekf.update,
)


def filled(map, world):
    """Put the world's prior into a map: the robot's range and those of the landmarks."""
    P = world.P0
    rob = map.add(world.x0[:3], P[:3, :3])
    lmks = []
    for i in range(3, len(world.x0), 2):
        r = slice(i, i + 2)
        lmks.append(map.add(world.x0[r], P[r, r], P[r, :i]))
    return rob, lmks


class Filter:
    """Predict and correct with given blocks, one observation after another."""

    def __init__(self, world, map, house=FAST):
        self.house, self.map = house, map
        self.rob, self.lmks = filled(self.map, world)
        self.given = given(world)

    def step(self, k):
        """One step."""
        g = self.given[k % len(self.given)]
        self.house.predict(self.map, self.rob, g.x, g.X_x, g.X_u, U)
        for i, H_r, H_l, z in zip(g.ids, g.H_r, g.H_l, g.z, strict=True):
            self.house.update(self.map, ((self.rob, H_r), (self.lmks[i], H_l)), z, R)

    def state(self):
        """Mean and covariance."""
        return np.array(self.map.x), np.array(self.map.P)


class JointFilter(Filter):
    """All observations of a step in one correction: a stack, as only the quick `update` takes it."""

    def __init__(self, world, map):
        super().__init__(world, map)
        self.rows = [np.array([range(self.lmks[i].start, self.lmks[i].stop) for i in g.ids]) for g in self.given]

    def step(self, k):
        """One step."""
        k %= len(self.given)
        g = self.given[k]
        self.house.predict(self.map, self.rob, g.x, g.X_x, g.X_u, U)
        self.house.update(self.map, ((self.rob, g.H_r), (self.rows[k], g.H_l)), g.z, R)


class Step:
    """A whole step: move, correct what is in the map, start what is not."""

    def __init__(self, world, map, joint, house=FAST):
        self.house, self.map, self.world = house, map, world
        self.rob = Rob(1, Odometry2(), U=U, sensors=[1])
        self.sen = Sen(1, 1, RangeBearing(*np.sqrt(np.diag(R)), max_range=world.max_range), Frame2)
        self.lmks, self.obs = {}, {}
        self.opt = Options(lmk_type=EucPnt(2), joint=joint, error="additive")  # as the peers and the oracle
        place(map, self.sen, np.zeros(3))
        if len(world.x0) == 3:
            place(map, self.rob, world.x0, world.P0)
        else:
            self.rob.r, ranges = filled(map, world)
            self.lmks = {i: Lmk(i, EucPnt(2), r=r, slot=i) for i, r in enumerate(ranges)}
        self.raw = [SimpleNamespace(ids=step.ids, y=step.y, R=None) for step in world.steps]

    def step(self, k):
        """One step."""
        k %= len(self.raw)
        raw, house = self.raw[k], self.house
        self.rob.u = self.world.steps[k].u
        house.move(self.map, self.rob, 1.0)
        _, new = house.correct_known_lmks(self.map, self.rob, self.sen, self.lmks, self.obs, raw, self.opt)
        house.init_new_lmks(self.map, self.rob, self.sen, self.lmks, raw, new, self.opt)

    def state(self):
        """Mean and covariance, the landmarks in the order of their ids."""
        order = np.r_[0:3, np.concatenate([np.arange(*self.lmks[i].r.indices(10**9)) for i in sorted(self.lmks)])]
        return np.array(self.map.x)[order], np.array(self.map.P)[np.ix_(order, order)]


def warm(make):
    """The same maker; what is compiled at the first steps has been compiled before."""

    def made(*world):
        trial = make(*world)
        trial.step(0)
        trial.step(1)
        return make(*world)

    return made


new = FAST.new_map
FILTERS = {
    "filter, sequential": lambda world: Filter(world, new()),
    "filter, joint": lambda world: JointFilter(world, new()),
    "filter, joint, compressed": lambda world: JointFilter(world, new(compressed=True)),
    "filter, sequential, plain": lambda world: Filter(world, PLAIN.new_map(), PLAIN),
}
STEPS = {
    "step, sequential": lambda world: Step(world, new(), joint=False),
    "step, joint": lambda world: Step(world, new(), joint=True),
    "step, joint, compressed": lambda world: Step(world, new(compressed=True), joint=True),
    "step, sequential, plain": lambda world: Step(world, PLAIN.new_map(), False, PLAIN),
    "step, joint, plain": lambda world: Step(world, PLAIN.new_map(), True, PLAIN),
}
COMPILED = find_spec("numba") is not None  # if it is not, the report names it among what is missing
if COMPILED:
    FILTERS["filter, sequential, compiled"] = warm(lambda world: Filter(world, new(compiled=True)))
    FILTERS["filter, joint, compiled"] = warm(lambda world: JointFilter(world, new(compiled=True)))
    STEPS["step, joint, compiled"] = warm(lambda world: Step(world, new(compiled=True), joint=True))
    STEPS["step, joint, compressed, compiled"] = warm(
        lambda world: Step(world, new(compiled=True, compressed=True), joint=True)
    )
