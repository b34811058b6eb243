"""Any sequence of moving, seeing, adding and removing leaves a plain and a compiled map alike."""

import numpy as np
import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, precondition, rule

from ekfslam_tutorial.models.landmarks import AhmPnt, EucPnt, HmgPnt
from ekfslam_tutorial.models.sensors import BearingOnly2, RangeBearing
from ekfslam_tutorial.slam import NearestNeighbour

from .scenes import Pair, raw
from .side_by_side import assert_same_maps

pytestmark = pytest.mark.usefixtures("interpreted")

POINTS = np.random.default_rng(2).uniform([-6, -6], [6, 6], (12, 2))
FAR = RangeBearing(0.1, 0.02, max_range=6.0, fov=4.0)
OPTIONS = st.fixed_dictionaries(
    {
        "joint": st.booleans(),
        "reproject": st.booleans(),
        "n_updates": st.sampled_from([None, 3]),
        "md2_threshold": st.sampled_from([np.inf, 6.0]),
        "min_match_ratio": st.sampled_from([0.0, 0.6]),
        "min_search": st.just(3),
        "capacity": st.sampled_from([None, 20]),
    }
)


class Machine(RuleBasedStateMachine):
    """Both robots among twelve points: see `Pair`, which compares them after each of these."""

    @initialize(
        options=OPTIONS,
        kind=st.sampled_from([(FAR, EucPnt(2)), (FAR, AhmPnt(2)), (BearingOnly2(0.02), AhmPnt(2)), (FAR, HmgPnt(2))]),
        by_name=st.booleans(),
        active=st.sampled_from([None, None, 5, 15]),
    )
    def begin(self, options, kind, by_name, active):
        sensor, lmk_type = kind
        extra = {} if by_name else {"association": NearestNeighbour()}
        self.pair = Pair(sensor, lmk_type=lmk_type, n=[0.2], N=[[0.01]], active=active, **options, **extra)
        self.rng = np.random.default_rng(3)

    @rule(u=st.lists(st.floats(-0.3, 0.3), min_size=3, max_size=3), big=st.booleans())
    def go(self, u, big):
        self.pair.move(np.array(u) + (np.array([0.0, 0.0, 3.0]) if big else 0.0))

    @rule(ids=st.sets(st.integers(0, len(POINTS) - 1), min_size=1), n_max=st.sampled_from([None, 2]), own=st.booleans())
    def look(self, ids, n_max, own):
        """No two landmarks are equally uncertain where the most uncertain comes first: rounding would decide."""
        ids, opt, R = sorted(ids), self.pair.plain.opt, self.pair.plain.sen.model.R
        y = self.pair.measured(self.rng, POINTS[ids])
        own = own or not opt.joint or opt.n_updates is not None
        self.pair.look(raw(ids, y, self.rng.uniform(1, 2, (len(ids), 1, 1)) * R if own else None), n_max)

    @precondition(lambda self: self.pair.plain.lmks)
    @rule(data=st.data())
    def forget(self, data):
        id = data.draw(st.sampled_from(sorted(self.pair.plain.lmks)))

        def remove(scene):
            scene.map.remove(scene.lmks.pop(id).r)
            scene.obs.clear()

        self.pair.both(remove)

    @precondition(lambda self: self.pair.plain.map.capacity is None)
    @rule(size=st.integers(1, 40))
    def add(self, size):
        """Something else that is estimated; many of them make the map long."""
        self.pair.both(lambda scene: scene.map.add(np.ones(size), 0.1 * np.eye(size)))

    @rule()
    def ask_for_all_of_P(self):
        """Which makes a map of one triangle one of both."""
        self.pair.both(lambda scene: float(scene.map.P.trace() > 0))

    def teardown(self):
        if hasattr(self, "pair"):
            assert_same_maps(self.pair.plain.map, self.pair.compiled.map)


TestMachine = Machine.TestCase
TestMachine.settings = settings(max_examples=60, stateful_step_count=12, deadline=None)
