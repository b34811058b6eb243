"""Landmarks in groups: what a sensor remembers of them is always what asking each landmark anew would give."""

import copy
import pickle
from dataclasses import fields, replace

import numpy as np
import pytest

from ekfslam_tutorial.geometry import Frame2
from ekfslam_tutorial.models.landmarks import AhmPnt, EucPnt, HmgPnt, IdpPnt
from ekfslam_tutorial.models.sensors import RangeBearing
from ekfslam_tutorial.slam import Lmk, Sen, project_lmks
from ekfslam_tutorial.slam.groups import groups_of
from ekfslam_tutorial.slam.projection import place

from .scenes import mixed_scene

KINDS = EucPnt(2), EucPnt(3), IdpPnt(), AhmPnt(), HmgPnt()


def sensor(id=1):
    return Sen(id, 1, RangeBearing(0.05, 0.01), Frame2)


def regrouped(lmks):
    """The groups, by asking each landmark: type, whether known, which, ranges, places in the map."""
    groups = []
    for i, lmk in enumerate(lmks):
        known = lmk.r is None
        own = next((g for g in groups if g[0] == lmk.type and g[1] == known), None)
        if own is None:
            groups.append(own := (lmk.type, known, [], [], None if known else []))
        own[2].append(i)
        own[3].append(lmk.r)
        if not known:
            own[4].append(list(range(lmk.r.start, lmk.r.stop)))
    return groups


def remembered(sen, lmks):
    """The same, as the sensor has it."""
    groups = groups_of(sen, lmks)
    return [(g.kind, g.known, list(g.members), list(g.ranges), None if g.known else g.rows.tolist()) for g in groups]


class History:
    """Landmarks to which anything may happen. Their ranges need no map: each new one lies behind all others."""

    def __init__(self, rng):
        self.rng, self.lmks, self.end, self.id = rng, {}, 0, 0

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

    def lists(self):
        """Lists in which a sensor may be asked about them."""
        all = list(self.lmks.values())
        return all, all, all, sorted(all, key=lambda lmk: lmk.id), all[::-1], all[: len(all) // 2], all[1::2]


RARE = "death", "reparametrisation", "change_of_place", "becoming_known", "change_of_type", "second_life"


@pytest.mark.parametrize("seed", range(4))
def test_whatever_happens_the_groups_are_those_of_asking_each_landmark(seed):
    """Two sensors share the landmarks. Births are frequent, as in a run: groups must outgrow their first storage."""
    rng = np.random.default_rng(seed)
    history, sens, handed, largest = History(rng), (sensor(1), sensor(2)), [], 0
    kept = 0  # how often a sensor went on with what it had
    for _ in range(500):
        name = "birth" if not history.lmks or rng.random() < 0.6 else RARE[rng.integers(len(RARE))]
        getattr(history, name)()
        for sen in sens:
            if rng.random() < 0.7:
                lists, before = history.lists(), sen.groups
                lmks = list(lists[rng.integers(len(lists))])
                assert remembered(sen, lmks) == regrouped(lmks), name
                kept += sen.groups is before
                handed += [(g.rows, g.rows.copy()) for g in sen.groups.all if not g.known]
                largest = max(largest, *(len(g.members) for g in sen.groups.all), 0) if lmks else largest
    assert all(np.array_equal(view, then) for view, then in handed)
    assert largest > 16 and kept > 50


def test_what_was_handed_out_stays_right_while_the_group_grows():
    sen, lmks, handed = sensor(), [], []
    for i in range(100):
        lmks.append(Lmk(i, EucPnt(2), r=slice(3 + 2 * i, 5 + 2 * i)))
        (group,) = groups_of(sen, list(lmks))
        handed.append(group.rows)
        assert groups_of(sen, list(lmks))[0] is group  # nothing was done anew
    for n, rows in enumerate(handed, 1):
        assert np.array_equal(rows, 3 + np.arange(2 * n).reshape(n, 2))


def test_a_list_may_grow_in_place():
    sen, lmks = sensor(), []
    for i in range(5):
        lmks.append(Lmk(i, EucPnt(2), r=slice(2 * i, 2 * i + 2)))
        assert remembered(sen, lmks) == regrouped(lmks)
    lmks[2] = Lmk(9, EucPnt(3), r=slice(20, 23))
    assert remembered(sen, lmks) == regrouped(lmks)


def test_a_landmark_that_is_refused_leaves_nothing_behind():
    """A range of another length than the type says; without that landmark all is as if it had never been there."""
    sen, good = sensor(), [Lmk(i, EucPnt(2), r=slice(2 * i, 2 * i + 2)) for i in range(3)]
    bad = Lmk(7, EucPnt(2), r=slice(10, 13))
    for first in 0, 2:
        groups_of(sen, good[:first])
        with pytest.raises(ValueError):
            groups_of(sen, [*good, bad])
        assert remembered(sen, good) == regrouped(good)
    with pytest.raises(ValueError):
        groups_of(sen, [*good, bad])
    bad.r = slice(10, 12)
    assert remembered(sen, [*good, bad]) == regrouped([*good, bad])


def test_expectations_follow_the_landmarks(rng):
    """The sensor that remembers beside one that has never been asked, after each thing that happens."""
    scene = mixed_scene(rng)

    def beside():
        new = replace(scene.sen, groups=None, gapless=None)
        pairs = zip(
            *(project_lmks(scene.map, scene.rob, s, scene.lmks.values()) for s in (scene.sen, new)), strict=True
        )
        for o, other in pairs:
            assert o.lmk == other.lmk and np.array_equal(o.e, other.e) and np.array_equal(o.E, other.E)
            assert [r for r, _ in o.blocks] == [r for r, _ in other.blocks] and o.E_l.shape == other.E_l.shape

    beside()
    scene.add(20, [5.0, 0.0, 0.0], 0.01 * np.eye(3), EucPnt())
    beside()
    lmk = next(lmk for lmk in scene.lmks.values() if lmk.type == AhmPnt() and lmk.r is not None)
    p, _ = lmk.point(scene.map)
    scene.map.remove(lmk.r)
    lmk.type, lmk.r = EucPnt(), scene.map.add(p, 0.02 * np.eye(3))
    beside()
    scene.map.remove(scene.lmks.pop(20).r)
    beside()
    scene.add(20, [6.0, 1.0, 0.0], 0.03 * np.eye(3), EucPnt())
    beside()
    known = next(lmk for lmk in scene.lmks.values() if lmk.r is None)
    known.x = known.x + 0.1  # no change of type or range: what is known is read anew each time
    beside()
    place(scene.map, scene.sen, scene.sen.state(scene.map), 1e-6 * np.eye(7))
    beside()


# --- counting, and copies --------------------------------------------------------------------------------------------


def test_changes_of_type_and_range_are_counted_and_nothing_else():
    before = Lmk.changes
    lmk, other = Lmk(1, EucPnt(2), r=slice(0, 2)), Lmk(2, EucPnt(2), x=np.zeros(2))
    replace(lmk, r=slice(4, 6))  # a birth
    copy.copy(lmk), copy.deepcopy(lmk), pickle.loads(pickle.dumps(lmk))
    lmk.n_search, lmk.slot, lmk.first, other.x = 5, 3, np.zeros(2), np.ones(2)
    assert Lmk.changes == before
    lmk.r = slice(2, 4)
    assert Lmk.changes == before + 1
    other.type = EucPnt(2)
    assert Lmk.changes == before + 2
    copy.deepcopy(lmk).r = None
    assert Lmk.changes == before + 3 and lmk.r == slice(2, 4)
    lmk.type, lmk.r = EucPnt(3), slice(2, 5)
    assert Lmk.changes == before + 5


def test_landmarks_are_told_apart_by_identity():
    """Two that hold the same are two. Arrays in them are not compared, which could not be done with `==`."""
    a, b = (Lmk(1, EucPnt(2), x=np.zeros(2)) for _ in range(2))
    assert a == a and a != b and len({a, b}) == 2
    assert [a, b].index(b) == 1 and b not in [a]


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda thing: pickle.loads(pickle.dumps(thing))])
def test_copies_hold_the_same_and_are_independent(copied):
    lmk = Lmk(3, IdpPnt(), r=slice(6, 12), slot=2, n=np.array([0.1]), N=np.array([[0.2]]), n_search=7)
    twin = copied(lmk)
    assert repr(twin) == repr(lmk) and all(hasattr(twin, field.name) for field in fields(lmk))
    assert (twin.id, twin.type, twin.r, twin.slot, twin.n_search) == (3, IdpPnt(), slice(6, 12), 2, 7)
    twin.type, twin.r, twin.n[0] = EucPnt(), slice(6, 9), 9.0
    assert lmk.type == IdpPnt() and lmk.r == slice(6, 12) and lmk.n[0] == 0.1


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda thing: pickle.loads(pickle.dumps(thing))])
def test_a_copied_sensor_is_right_about_copied_landmarks(copied, monkeypatch):
    """In another process the changes may be as many as when the notes were made, though some came in between."""
    sen, lmks = sensor(), [Lmk(i, EucPnt(2), r=slice(2 * i, 2 * i + 2)) for i in range(4)]
    groups_of(sen, lmks)
    noted = Lmk.changes
    lmks[1].r = slice(20, 22)
    twin, twins = copied((sen, lmks))
    monkeypatch.setattr(Lmk, "changes", noted)
    assert remembered(twin, twins) == regrouped(twins)
    twins[2].r = slice(30, 32)
    assert remembered(twin, twins) == regrouped(twins)
    assert remembered(twin, lmks) == regrouped(lmks)
