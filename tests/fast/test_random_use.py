"""Fast is plain: whatever is done, in whatever order, and whoever changes things behind the back of the steps.

Two robots, each with a sensor, among points of which some are known; all engines beside each other, see `Scenes`.
"""

import copy
import pickle

import numpy as np
import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, rule

from ekfslam_tutorial.fast import tables
from ekfslam_tutorial.geometry import Frame2
from ekfslam_tutorial.models.landmarks import AhmPnt, EucPnt, HmgPnt
from ekfslam_tutorial.models.motion import Odometry2
from ekfslam_tutorial.models.sensors import BearingOnly2, RangeBearing
from ekfslam_tutorial.slam import (
    Jcbb,
    Lmk,
    NearestNeighbour,
    Rob,
    Sen,
    correct_met_robots,
    place,
    reopen_gate,
)

from .law import near
from .scenes import Scenes, look, raw

POINTS = np.random.default_rng(2).uniform([-6, -6], [6, 6], (12, 2))
FAR = RangeBearing(0.1, 0.02, max_range=6.0, fov=4.0)
EUC = EucPnt(2)
OPTIONS = st.fixed_dictionaries(
    {
        "joint": st.booleans(),
        "error": st.sampled_from(["additive", "invariant"]),  # with this one the compressed maps are lazy: left out
        "reproject": st.booleans(),
        "n_updates": st.sampled_from([None, 3]),
        "md2_threshold": st.sampled_from([np.inf, 6.0]),
        "min_match_ratio": st.sampled_from([0.0, 0.6]),
        "min_search": st.just(3),
        "max_lmks": st.sampled_from([None, None, 6]),
        "reopen_after": st.sampled_from([None, 3]),
        "capacity": st.sampled_from([None, 20]),
    }
)
STEP = st.lists(st.floats(-0.3, 0.3), min_size=3, max_size=3)
SOME = st.sets(st.integers(0, len(POINTS) - 1), min_size=2)
USER = (
    "forget",
    "become_euclidean",
    "become_known",
    "survey",
    "swap",
    "write_into_the_map",
    "estimate_something_else",
    "ask_for_all_of_P",
    "go_on_with_a_copy",
    "make_a_mistake",
)
BAD = "nan", "shape", "ids", "R", "dt", "u", "U"


class Machine(RuleBasedStateMachine):
    """What may happen."""

    @initialize(
        options=OPTIONS,
        kind=st.sampled_from([(FAR, EUC), (FAR, AhmPnt(2)), (BearingOnly2(0.02), AhmPnt(2)), (FAR, HmgPnt(2))]),
        by=st.sampled_from(["name", "name", "nearest", "jointly"]),
        active=st.sampled_from([5, 15]),
        first_estimates=st.sampled_from([False, False, False, True]),
        many=st.sampled_from([100, 2]),
    )
    def start(self, options, kind, by, active, first_estimates, many):
        sensor, lmk_type = kind
        if first_estimates:
            sensor, lmk_type, options = FAR, EUC, options | {"first_estimates": True, "error": "additive"}
        if by != "name":
            options = options | {"association": NearestNeighbour() if by == "nearest" else Jcbb()}
        self.patch = pytest.MonkeyPatch()
        self.patch.setattr(tables, "MANY", many)
        self.scenes = Scenes(sensor, active=active, lmk_type=lmk_type, n=[0.2], N=[[0.01]], **options)
        self.rng, self.by_name, self.first, self.last_id = np.random.default_rng(3), by == "name", first_estimates, 100
        self.scenes.each(self._second_robot)

    def teardown(self):
        if hasattr(self, "scenes"):
            self.scenes.compare(whole=True)
            self.patch.undo()

    @staticmethod
    def _second_robot(scene):
        """Its sensor's frame is in the map, if there is room."""
        other = Rob(2, Odometry2(), U=2e-4 * np.eye(3), sensors=[2], u=np.zeros(3))
        place(scene.map, other, np.array([1.0, 1.0, 0.5]), np.diag([0.01, 0.01, 0.001]))
        sen = Sen(2, 2, FAR, Frame2, lmk_type=EUC)
        place(scene.map, sen, np.array([0.1, 0.0, -0.1]), 1e-4 * np.eye(3))
        scene.robs, scene.sens = [scene.rob, other], [scene.sen, sen]

    # --- what a run does ---

    @rule(u=STEP, big=st.booleans())
    def go(self, u, big):
        self.scenes.move(np.array(u) + (np.array([0.0, 0.0, 3.0]) if big else 0.0))

    @rule(u=STEP)
    def the_other_goes(self, u):
        def go(scene):
            scene.robs[1].u = np.array(u)
            scene.engine.move(scene.map, scene.robs[1], 0.1)

        self.scenes.each(go)

    @rule(u=STEP, ids=SOME, own=st.booleans())
    def frame(self, u, ids, own):
        """A step and a look."""
        self.go(u, False)
        self.look(ids, None, own)

    @rule(ids=SOME, n_max=st.sampled_from([None, 2]), own=st.booleans())
    def look(self, ids, n_max, own):
        """No two landmarks are equally uncertain where the most uncertain comes first: rounding would decide."""
        ids, opt, R = sorted(ids), self.scenes.plain.opt, self.scenes.plain.sen.model.R
        y = self.scenes.measured(self.rng, POINTS[ids])
        own = own or not opt.joint or opt.n_updates is not None
        self._look(raw(ids, y, self.rng.uniform(1, 2, (len(ids), 1, 1)) * R if own else None), n_max)

    def _look(self, measurements, n_max=None):
        def frame(scene):
            events = look(scene, measurements, n_max)
            return events + reopen_gate(scene.map, scene.rob, events, scene.opt, scene.lmks)

        self.scenes.each(frame)

    @rule(ids=SOME, noise=st.floats(0.5, 2.0))
    def the_other_looks(self, ids, noise):
        """From where it believes to be."""
        ids = sorted(ids)
        rob, sen, map = self.scenes.plain.robs[1], self.scenes.plain.sens[1], self.scenes.plain.map
        y = FAR.project(sen.frame(map).to_frame(rob.frame(map).to_frame(POINTS[ids])[0])[0])[0]
        y = y + noise * 0.02 * self.rng.normal(size=y.shape)
        R = self.rng.uniform(1, 2, (len(ids), 1, 1)) * FAR.R

        def frame(scene):
            args = scene.map, scene.robs[1], scene.sens[1], scene.lmks
            events, new = scene.engine.correct_known_lmks(*args, scene.obs, raw(ids, y, R), scene.opt)
            return events + scene.engine.init_new_lmks(*args, raw(ids, y, R), new, scene.opt)

        self.scenes.each(frame)

    @rule()
    def meet(self):
        """The steps of the core work on all maps."""
        rob, other, sen = *self.scenes.plain.robs, self.scenes.plain.sens[1]
        map = self.scenes.plain.map
        y = FAR.project(sen.frame(map).to_frame(other.frame(map).to_frame(rob.frame(map).t)[0])[0])[0]
        met = raw([1], y[None] + 0.01)
        self.scenes.each(
            lambda scene: correct_met_robots(scene.map, scene.robs[1], scene.sens[1], scene.robs, met, scene.opt)
        )

    # --- what a user does in between ---

    @rule(what=st.sampled_from(USER), data=st.data())
    def user(self, what, data):
        """Something of what follows."""
        getattr(self, what)(data)

    def _any(self, data, where=lambda lmk: True):
        ids = [id for id, lmk in self.scenes.plain.lmks.items() if where(lmk)]
        return data.draw(st.sampled_from(ids)) if ids else None

    def forget(self, data):
        if (id := self._any(data)) is None:
            return

        def remove(scene):
            lmk = scene.lmks.pop(id)
            scene.obs.clear()
            if lmk.r is not None:
                scene.map.remove(lmk.r)

        self.scenes.each(remove)

    def become_euclidean(self, data):
        """The type and the range are changed, by the public means of a map."""
        id = self._any(data, lambda lmk: lmk.r is not None and lmk.type != EUC)
        if id is None:
            return

        def change(scene):
            lmk = scene.lmks[id]
            p, P_l = lmk.type.point(lmk.state(scene.map))
            P_pm = P_l @ scene.map.P[lmk.r]
            lmk.type, lmk.r = EUC, scene.map.put(lmk.r, p, P_pm, P_pm[:, lmk.r] @ P_l.T)
            scene.obs.clear()

        self.scenes.each(change)

    def become_known(self, data):
        """Elsewhere; its old place in the map is free then."""
        dx = data.draw(st.floats(-1.0, 1.0))
        id = self._any(data, lambda lmk: lmk.r is not None)
        if id is None or self.first:
            return
        x = self.scenes.plain.lmks[id].state(self.scenes.plain.map)

        def change(scene):
            lmk = scene.lmks[id]
            scene.map.remove(lmk.r)
            lmk.x, lmk.r = x + dx, None
            scene.obs.clear()

        self.scenes.each(change)

    def survey(self, data):
        """A landmark that nobody has measured; each time of another type object."""
        p, known = data.draw(st.tuples(st.floats(-5, 5), st.floats(-5, 5))), data.draw(st.booleans())
        self.last_id += 1

        def add(scene):
            slot = max((lmk.slot for lmk in scene.lmks.values()), default=-1) + 2  # with a gap before it
            lmk = Lmk(self.last_id, EucPnt(2), slot=slot)
            if known:
                lmk.x = np.array(p)
            else:
                lmk.r = scene.map.add(p, 0.04 * np.eye(2))
            scene.lmks[lmk.id] = lmk

        if known or self.scenes.plain.map.capacity is None:
            self.scenes.each(add)

    def swap(self, data):
        """Two landmarks change places: in the dict, or in the map."""
        a, b = self._any(data), self._any(data)
        if a is None or self.first:
            return
        in_map = data.draw(st.booleans())

        def change(scene):
            one, other = scene.lmks[a], scene.lmks[b]
            if in_map and one.r and other.r and one.type == other.type:
                one.r, other.r = other.r, one.r
            elif not in_map:
                scene.lmks = dict(reversed(scene.lmks.items()))
            scene.obs.clear()

        self.scenes.each(change)

    def write_into_the_map(self, data):
        """x and P are the map's own: who writes into them changes it."""
        dx = data.draw(STEP)

        def write(scene):
            scene.map.x[scene.rob.r] += dx
            scene.map.P[scene.rob.r, scene.rob.r] += 1e-4 * np.eye(3)

        self.scenes.each(write)

    def estimate_something_else(self, data):
        """Many of them make the map long."""
        size = data.draw(st.integers(1, 40))
        if self.scenes.plain.map.capacity is None:
            self.scenes.each(lambda scene: scene.map.add(np.ones(size), 0.1 * np.eye(size)))

    def ask_for_all_of_P(self, data):
        """Which makes a map of one triangle one of both, and settles a compressed one."""
        self.scenes.compare(whole=True)

    def go_on_with_a_copy(self, data):
        how = data.draw(st.sampled_from(["copy", "pickle"]))

        def change(scene):
            names = "map", "rob", "sen", "lmks", "robs", "sens"
            held = {name: getattr(scene, name) for name in names}
            old = scene.map
            held = copy.deepcopy(held) if how == "copy" else pickle.loads(pickle.dumps(held))
            vars(scene).update(held, obs={})
            old.x[:], old.P[:] = 1e3, 1e3  # nobody may look at it any more

        self.scenes.each(change)

    def make_a_mistake(self, data):
        """The same sentence, and nothing has been changed."""
        what = data.draw(st.sampled_from(BAD))
        y = self.scenes.measured(self.rng, POINTS[:2])
        R, ids = None, [0, 1]
        if what in ("dt", "u", "U"):
            bad = data.draw(st.sampled_from([np.nan, -1.0 if what != "u" else np.inf]))

            def do(scene):
                u, U = scene.rob.u, scene.rob.U
                try:
                    scene.rob.u = np.full(3, bad) if what == "u" else np.zeros(3)
                    scene.rob.U = np.diag([bad, 1.0, 1.0]) if what == "U" else U
                    scene.engine.move(scene.map, scene.rob, bad if what == "dt" else 0.1)
                finally:
                    scene.rob.u, scene.rob.U = u, U

            assert isinstance(self.scenes.each(do), tuple)
            return
        if what == "nan":
            y[1, 0] = np.nan
        elif what == "shape":
            y = y[:1]
        elif what == "R":
            R = np.array([np.eye(y.shape[1]), -np.eye(y.shape[1])])
        measurements = raw(ids, y, R)
        if what == "ids":
            measurements.ids = np.array([0.5, 1.5])
        assert isinstance(self.scenes.each(lambda scene: look(scene, measurements)), tuple)


TestMachine = pytest.mark.usefixtures("interpreted")(Machine.TestCase)
TestMachine.settings = settings(max_examples=60, stateful_step_count=20, deadline=None)


def test_the_comparison_sees_a_difference():
    """A law that nothing can break would be none."""
    assert near(np.ones(3), np.ones(3) + 1e-12) and not near(np.ones(3), np.ones(3) + 1e-6)
