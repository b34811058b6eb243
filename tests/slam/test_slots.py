"""A new landmark gets the first slot that is free, whoever has been born and deleted before."""

from dataclasses import replace

import numpy as np
import pytest

from ekfslam_tutorial.models.landmarks import EucPnt
from ekfslam_tutorial.slam import Lmk, init_new_lmks
from ekfslam_tutorial.slam.steps import add_landmark

from .scenes import Scene, raw

Y = np.array([2.0, 0.3])


def first_free(lmks):
    """By looking at every landmark."""
    return min(set(range(len(lmks) + 1)) - {lmk.slot for lmk in lmks.values()})


def start(scene, sen, id):
    """A new landmark; it must have the first slot that is free."""
    wanted = first_free(scene.lmks)
    lmk = add_landmark(scene.map, scene.rob, sen, scene.lmks, id, Y, None, scene.opt)
    assert lmk.slot == wanted, f"the slots were {[other.slot for other in scene.lmks.values()]}"
    return lmk


def delete(scene, id):
    lmk = scene.lmks.pop(id)
    if lmk.r is not None:
        scene.map.remove(lmk.r)
    return lmk


def known(slots):
    """Known landmarks that have these slots, in this order."""
    return {100 + slot: Lmk(100 + slot, EucPnt(2), x=np.zeros(2), slot=slot) for slot in slots}


@pytest.mark.parametrize("n_sensors", [1, 2])
@pytest.mark.parametrize("slots", [(), (5, 1), (0, 1, 2), (2, 1, 0), (7,)], ids=str)
@pytest.mark.parametrize("seed", range(3))
def test_the_first_free_slot_in_any_history(n_sensors, slots, seed):
    """Births, some of which come to nothing; deletions of any landmark, and of the last; some are put back again."""
    rng = np.random.default_rng(seed)
    scene = Scene(P=1e-4 * np.eye(3))
    sens = [replace(scene.sen, id=i) for i in range(1, n_sensors + 1)]
    scene.lmks |= known(slots)
    gaps, in_a_row = 0, 0
    for id in range(1000, 1300):
        what, sen, lmks = rng.random(), sens[rng.integers(n_sensors)], scene.lmks
        if not lmks or what < 0.6:
            lmk = start(scene, sen, id)
            gaps, in_a_row = gaps + (lmk.slot < len(lmks)), in_a_row + (lmk.slot == len(lmks))
            if rng.random() < 0.9:
                lmks[id] = lmk
            else:
                scene.map.remove(lmk.r)
        elif what < 0.8:
            delete(scene, list(lmks)[rng.integers(len(lmks))])
        elif what < 0.9:
            delete(scene, next(reversed(lmks)))
        else:  # at the end now, with the slot that it had
            lmk = lmks.pop(list(lmks)[rng.integers(len(lmks))])
            lmks[lmk.id] = lmk
    assert gaps > 20 and in_a_row > 5  # both ways of finding a slot


def test_slots_5_and_1_left_over_in_this_order():
    scene = Scene()
    scene.lmks |= known((5, 1))
    for id, slot in enumerate((0, 2, 3, 4, 6, 7)):
        scene.lmks[id] = start(scene, scene.sen, id)
        assert scene.lmks[id].slot == slot


def test_left_over_after_deletions():
    """Six are born without a gap, four of them go; of the others the last has slot 1."""
    scene = Scene()
    for id in range(6):
        scene.lmks[id] = start(scene, scene.sen, id)
    for id in (0, 2, 3, 4):
        delete(scene, id)
    scene.lmks[1] = scene.lmks.pop(1)
    assert [lmk.slot for lmk in scene.lmks.values()] == [5, 1]
    for id, slot in enumerate((0, 2, 3, 4, 6), 10):
        scene.lmks[id] = start(scene, scene.sen, id)
        assert scene.lmks[id].slot == slot


def test_two_sensors_take_turns():
    """Neither may go by what it remembers when the other has deleted, or has started, a landmark in between."""
    scene = Scene()
    a, b = scene.sen, replace(scene.sen, id=2)
    for id, sen in enumerate((a, a, b, a, b, b)):
        scene.lmks[id] = start(scene, sen, id)
    delete(scene, 3)
    delete(scene, 5)
    scene.lmks[6] = start(scene, a, 6)
    assert scene.lmks[6].slot == 3
    scene.lmks[7] = start(scene, b, 7)
    assert scene.lmks[7].slot == 5
    delete(scene, 0)
    scene.lmks[8] = start(scene, b, 8)
    assert scene.lmks[8].slot == 0
    scene.lmks[9] = start(scene, a, 9)
    assert scene.lmks[9].slot == 6


def test_a_whole_step_gives_the_slots_in_the_order_of_the_measurements():
    scene = Scene(P=1e-4 * np.eye(3))
    for frame in range(3):
        ids = [10 * frame + i for i in range(4)]
        init_new_lmks(*scene.all, raw(ids, np.tile(Y, (4, 1))), list(range(4)), scene.opt)
        assert sorted(lmk.slot for lmk in scene.lmks.values()) == list(range(len(scene.lmks)))
        delete(scene, 10 * frame + 1)
    assert [lmk.slot for lmk in scene.lmks.values()] == [0, 2, 3, 1, 5, 6, 4, 8, 9]
