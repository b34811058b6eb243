"""Any sequence of moving, seeing, reparametrising and deleting keeps ids, slots and ranges one to one."""

import numpy as np
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule

from ekfslam_tutorial.geometry import Frame3
from ekfslam_tutorial.models.landmarks import AhmPnt, EucPnt, HmgPnt, IdpPnt
from ekfslam_tutorial.models.sensors import PinHole, PinHoleDepth
from ekfslam_tutorial.slam import correct_known_lmks, init_new_lmks, move

from .scenes import Scene, raw

CAPACITY = 45
POINTS = {i: p for i, p in enumerate(np.random.default_rng(2).uniform([3, -2, -1.5], [9, 2, 1.5], (14, 3)), 1)}
KINDS = (IdpPnt(), AhmPnt(), HmgPnt(), EucPnt())


class SlamMachine(RuleBasedStateMachine):
    """A robot with a camera in front of fourteen points, in a map that has not room for all of them."""

    @initialize(kind=st.sampled_from(KINDS), calibrate=st.booleans())
    def start(self, kind, calibrate):
        options = dict(md2_threshold=9.0, min_match_ratio=0.3, min_inlier_ratio=0.5, min_search=4)
        self.scene = Scene(
            d=3,
            P=np.diag([1e-6] * 3 + [0.0] + [1e-8] * 3),
            sensor=PinHoleDepth() if kind == EucPnt() else PinHole(),
            sensor_P=1e-8 * np.eye(7) if calibrate else None,
            capacity=CAPACITY,
            lmk_type=kind,
            n=0.2,
            N=0.01,
            reparametrize=True,
            lin_test=0.5,
            **options,
        )
        self.rng, self.truth = np.random.default_rng(3), np.eye(7)[3]
        self.refused = 0

    @rule(u=st.lists(st.floats(-0.1, 0.1), min_size=6, max_size=6))
    def go(self, u):
        self.scene.rob.u = np.array(u)
        self.truth = self.scene.rob.motion.move(self.truth, self.scene.rob.u, 0.1)[0]
        self.truth = Frame3(self.truth).normalized()[0].x
        move(self.scene.map, self.scene.rob, 0.1)

    @rule(ids=st.sets(st.sampled_from(sorted(POINTS)), min_size=1), n_max=st.sampled_from([None, 1, 3]))
    def look(self, ids, n_max):
        scene = self.scene
        measurements = scene.see({id: POINTS[id] for id in ids}, 0.5, self.rng, self.truth)
        keep = scene.sen.model.inside(measurements.y) & np.isfinite(measurements.y).all(-1)
        measurements = raw(measurements.ids[keep], measurements.y[keep])
        before = dict(scene.lmks)
        events, new = correct_known_lmks(*scene.all, scene.obs, measurements, scene.opt)
        gone = {e.lmk for e in events if e.kind == "deletion"}
        assert set(scene.lmks) == set(before) - gone
        corrected = dict(scene.lmks)
        events = init_new_lmks(*scene.all, measurements, new, scene.opt, n_max)
        born = {e.lmk for e in events if e.kind == "initialisation"}
        assert set(scene.lmks) == set(corrected) | born and not born & set(corrected)
        assert n_max is None or len(events) <= n_max
        room = CAPACITY - scene.map.n_used
        for e in events:
            if e.kind == "refused":
                self.refused += 1
                assert room < scene.opt.lmk_type.size

    @precondition(lambda self: self.scene.lmks)
    @rule(data=st.data())
    def forget(self, data):
        lmk = self.scene.lmks.pop(data.draw(st.sampled_from(sorted(self.scene.lmks))))
        self.scene.map.remove(lmk.r)

    @invariant()
    def ids_slots_and_ranges_are_one_to_one(self):
        if not hasattr(self, "scene"):
            return
        scene, owner = self.scene, np.zeros(self.scene.map.n, int)
        holders = [scene.rob, *scene.lmks.values()] + ([scene.sen] if scene.sen.r else [])
        for holder in holders:
            owner[holder.r] += 1
        assert np.array_equal(owner, scene.map.used) and scene.map.n_used <= CAPACITY
        assert all(id == lmk.id and lmk.r.stop - lmk.r.start == lmk.type.size for id, lmk in scene.lmks.items())
        slots = [lmk.slot for lmk in scene.lmks.values()]
        assert len(set(slots)) == len(slots)

    @invariant()
    def the_map_is_sound(self):
        if not hasattr(self, "scene"):
            return
        map = self.scene.map
        assert np.isfinite(map.x).all() and np.array_equal(map.P, map.P.T)
        free = ~map.used
        assert not map.x[free].any() and not map.P[free].any() and not map.P[:, free].any()
        std = np.sqrt(np.diag(map.P).clip(1e-30))
        assert (np.diag(map.P) >= -1e-15).all() and (np.abs(map.P) <= np.outer(std, std) * (1 + 1e-6) + 1e-12).all()


TestSlamMachine = SlamMachine.TestCase
TestSlamMachine.settings = settings(max_examples=40, stateful_step_count=20, deadline=None)


def test_the_map_of_the_machine_is_too_small_for_all():
    """So that births are refused: the robot takes 7 states and fourteen inverse-depth points need 84."""
    assert CAPACITY < 7 + 6 * len(POINTS)
