"""Landmarks in groups: what is noted of them is always what asking each landmark anew would give."""

from dataclasses import replace
from itertools import islice
from types import SimpleNamespace

import numpy as np
import pytest

from ekfslam_tutorial import fast, slam
from ekfslam_tutorial.fast.notes import Groups
from ekfslam_tutorial.geometry import Frame2
from ekfslam_tutorial.models.landmarks import AhmPnt, EucPnt, HmgPnt, IdpPnt
from ekfslam_tutorial.models.motion import Odometry2
from ekfslam_tutorial.models.sensors import RangeBearing
from ekfslam_tutorial.slam import Lmk, Options, Rob, Sen

KINDS = EucPnt(2), EucPnt(3), IdpPnt(), AhmPnt(), HmgPnt()


def regrouped(lmks):
    """The groups, by asking each landmark: type, whether known, which, ranges, places in the map."""
    groups = []
    for i, lmk in enumerate(lmks.values()):
        known = lmk.r is None
        own = next((g for g in groups if g[0] == lmk.type and g[1] == known), None)
        if own is None:
            groups.append(own := (lmk.type, known, [], [], None if known else []))
        own[2].append(i)
        own[3].append(lmk.r)
        if not known:
            own[4].append(list(range(lmk.r.start, lmk.r.stop)))
    return groups


def remembered(groups, lmks, changes=0):
    """The same, as it is noted."""
    groups.follow(lmks, changes)
    assert all(
        g.keys == [id for id, lmk in lmks.items() if lmk.type == g.kind and (lmk.r is None) == g.known]
        for g in groups.all
    )
    return [(g.kind, g.known, g.places, g.ranges, None if g.known else g.indices.tolist()) for g in groups.all]


class History:
    """Landmarks to which anything may happen. Their ranges need no map: each new one lies behind all others."""

    def __init__(self, rng):
        self.rng, self.lmks, self.end, self.id, self.changes = rng, {}, 0, 0, 0

    def kind(self):
        """A type: one of those that are there, or an equal one that is another object."""
        kind = KINDS[self.rng.integers(len(KINDS))]
        return kind if self.rng.random() < 0.5 else replace(kind)

    def range(self, kind):
        self.end += kind.size + int(self.rng.integers(3))
        return slice(self.end - kind.size, self.end)

    def new(self, id):
        kind = self.kind()
        known = self.rng.random() < 0.3
        return Lmk(id, kind, x=np.zeros(kind.size)) if known else Lmk(id, kind, r=self.range(kind))

    def any(self):
        return list(self.lmks)[self.rng.integers(len(self.lmks))]

    # --- what may happen ---

    def birth(self):
        self.id += 1
        self.lmks[self.id] = self.new(self.id)

    def death(self):
        del self.lmks[self.any()]

    def reparametrisation(self):
        """As `tidy` does it: another type, and the head of the range."""
        lmk = self.lmks[self.any()]
        if lmk.r is not None and lmk.type.size > 2:
            lmk.type, lmk.r = KINDS[0], slice(lmk.r.start, lmk.r.start + 2)

    def change_of_place(self):
        lmk = self.lmks[self.any()]
        lmk.r = self.range(lmk.type)  # one that was known is in the map from now on

    def becoming_known(self):
        lmk = self.lmks[self.any()]
        lmk.x, lmk.r = np.zeros(lmk.type.size), None

    def change_of_type(self):
        """An equal one, or another one of the same length."""
        lmk = self.lmks[self.any()]
        lmk.type = HmgPnt() if lmk.type.size == HmgPnt().size else replace(lmk.type)

    def second_life(self):
        """Under the same id, in the same place of the dict or at its end."""
        id = self.any()
        if self.rng.random() < 0.5:
            del self.lmks[id]
        self.lmks[id] = self.new(id)


RARE = "death", "reparametrisation", "change_of_place", "becoming_known", "change_of_type", "second_life"


@pytest.mark.parametrize("seed", range(4))
def test_whatever_happens_the_groups_are_those_of_asking_each_landmark(seed):
    """Two notes of them, asked now and then. Births are frequent, as in a run: groups must outgrow their storage."""
    rng = np.random.default_rng(seed)
    history, notes, handed, largest = History(rng), (Groups(), Groups()), [], 0
    kept = 0  # how often one went on with what it had
    for _ in range(500):
        name = "birth" if not history.lmks or rng.random() < 0.6 else RARE[rng.integers(len(RARE))]
        getattr(history, name)()
        history.changes += name != "birth"  # of a map: it counts what comes and goes
        for groups in notes:
            if rng.random() < 0.7:
                before = groups.all
                assert remembered(groups, history.lmks, history.changes) == regrouped(history.lmks), name
                kept += groups.all is before
                handed += [(g.indices, g.indices.copy()) for g in groups.all if not g.known]
                largest = max([largest, *(len(g.lmks) for g in groups.all)])
    assert all(np.array_equal(view, then) for view, then in handed)
    assert largest > 16 and kept > 50


def test_what_was_handed_out_stays_right_while_the_group_grows():
    groups, lmks, handed = Groups(), {}, []
    for i in range(100):
        lmks[i] = Lmk(i, EucPnt(2), r=slice(3 + 2 * i, 5 + 2 * i))
        groups.follow(lmks, 0)
        (group,) = groups.all
        handed.append(group.indices)
        groups.follow(lmks, 0)
        assert groups.all == [group]  # nothing was done anew
    for n, rows in enumerate(handed, 1):
        assert np.array_equal(rows, 3 + np.arange(2 * n).reshape(n, 2))


def test_what_no_change_of_the_map_tells_of():
    """Another last one; fewer of them, and as many again; and any of them where one is known."""
    at = lambda id, i: Lmk(id, EucPnt(2), r=slice(2 * i, 2 * i + 2))
    groups, lmks = Groups(), {i: at(i, i) for i in range(5)}
    assert remembered(groups, lmks) == regrouped(lmks)
    lmks[4] = at(4, 9)
    assert remembered(groups, lmks) == regrouped(lmks)
    del lmks[2]
    lmks[2] = at(2, 2)
    assert remembered(groups, lmks) == regrouped(lmks)
    lmks[7] = Lmk(7, EucPnt(2), x=np.zeros(2))
    assert remembered(groups, lmks) == regrouped(lmks)
    lmks[0] = at(0, 8)
    assert remembered(groups, lmks) == regrouped(lmks)


def test_a_landmark_that_is_refused_leaves_nothing_behind():
    """A range of another length than the type says; without that landmark all is as if it had never been there."""
    groups, good = Groups(), {i: Lmk(i, EucPnt(2), r=slice(2 * i, 2 * i + 2)) for i in range(3)}
    bad = Lmk(7, EucPnt(2), r=slice(10, 13))
    for first in 0, 2:
        groups.follow(dict(islice(good.items(), first)), 0)
        with pytest.raises(ValueError):
            groups.follow(good | {7: bad}, 0)
        assert remembered(groups, good) == regrouped(good)
    with pytest.raises(ValueError):
        groups.follow(good | {7: bad}, 0)
    bad.r = slice(10, 12)
    assert remembered(groups, good | {7: bad}) == regrouped(good | {7: bad})


def test_a_landmark_in_view_is_that_of_the_dict():
    """Two of them change places, of which the map knows nothing: both engines go on alike."""
    ends = []
    for house in slam, fast:
        map, rob, sen = house.new_map(), Rob(1, Odometry2()), Sen(1, 1, RangeBearing(0.1, 0.02, max_range=9.0), Frame2)
        slam.place(map, rob, np.zeros(3), 0.01 * np.eye(3))
        slam.place(map, sen, np.zeros(3))
        lmks, obs, opt = {}, {}, Options(lmk_type=EucPnt(2), joint=True)
        raw = SimpleNamespace(ids=np.arange(4), y=np.array([[2.0, 0.1], [3.0, 0.5], [4.0, -0.4], [5.0, 0.2]]), R=None)
        house.init_new_lmks(map, rob, sen, lmks, raw, [0, 1, 2, 3], opt)
        house.correct_known_lmks(map, rob, sen, lmks, obs, raw, opt)
        lmks[0], lmks[1] = replace(lmks[0], r=lmks[1].r), replace(lmks[1], r=lmks[0].r)
        house.correct_known_lmks(map, rob, sen, lmks, obs, raw, opt)
        ends.append((np.array(map.x), np.array(map.P), [(lmk.r, lmk.n_inlier) for lmk in lmks.values()]))
    assert np.allclose(ends[0][0], ends[1][0], atol=1e-12) and np.allclose(ends[0][1], ends[1][1], atol=1e-12)
    assert ends[0][2] == ends[1][2]
