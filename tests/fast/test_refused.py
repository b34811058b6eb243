"""What an association refuses counts as found and as not fitting, and corrects nothing: in both engines, either way."""

import numpy as np
import pytest

from ekfslam_tutorial.slam import KnownIds, Matches

from .scenes import raw
from .test_own_noise import find, measured, start


class Doubting:
    """Known ids, some of which are refused."""

    def __init__(self, *refused):
        self.known, self.refused = KnownIds(), set(refused)

    def __call__(self, map, obs, raw, sensor):
        """Match by id."""
        matches = self.known(map, obs, raw, sensor)
        return Matches(matches.pairs, matches.new, self.refused)

    def birth_id(self, raw, i, lmks):
        """Return the id."""
        return self.known.birth_id(raw, i, lmks)


@pytest.mark.parametrize("own_noise", [False, True])
@pytest.mark.parametrize("joint", [False, True])
@pytest.mark.parametrize("refused", [(2,), (1, 5), (1, 2, 3, 4, 5)], ids=str)
def test_refused_is_found_and_not_used(refused, joint, own_noise):
    n = 5
    scenes = start(joint=joint, association=Doubting(*refused))
    seen = measured(range(n), np.tile(np.diag([0.0025, 1e-4]), (n, 1, 1)), np.full((n, 2), 0.003))
    if not own_noise:
        seen = raw(seen.ids, seen.y)
    events = scenes.each(lambda s: find(s, seen))
    used = set(range(1, n + 1)) - set(refused)
    assert {e.lmk for e in events if e.kind == "search" and e.flag} == set(range(1, n + 1))
    assert {e.lmk for e in events if e.kind == "innovation" and not e.flag} == set(refused)
    assert {e.lmk for e in events if e.kind == "correction"} == used
    for s in scenes.all:
        counts = {id: (lmk.n_search, lmk.n_match, lmk.n_inlier) for id, lmk in s.lmks.items()}
        assert counts == {id: (2, 2, 1 + (id in used)) for id in range(1, n + 1)}
        assert all(o.z is not None and o.matched and o.updated == (o.lmk in used) for o in s.obs.values())
