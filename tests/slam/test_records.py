"""What the records say of themselves, and what they give away: copies of states, places in words, fates."""

import numpy as np
import pytest

from ekfslam_tutorial.ekf import Map
from ekfslam_tutorial.geometry import Frame2, Frame3
from ekfslam_tutorial.models.landmarks import EucPnt, IdpPnt
from ekfslam_tutorial.models.motion import ConstantVelocity, Odometry2
from ekfslam_tutorial.models.sensors import RangeBearing
from ekfslam_tutorial.slam import Event, Lmk, Obs, Rob, Sen, Tim, place
from ekfslam_tutorial.slam.objects import short, states


def test_where_things_are():
    rob, sen = Rob(3, Odometry2(), sensors=[1, 2]), Sen(1, 3, RangeBearing(0.1, 0.1), Frame2, name="laser")
    assert repr(rob) == "Rob(3, Odometry2, not in the map, sensors [1, 2])"
    assert repr(sen) == "Sen(1 'laser', RangeBearing on robot 3, frame not in the map)"
    for thing in (rob, sen, Lmk(4, EucPnt(2))):
        with pytest.raises(
            ValueError, match=rf"{type(thing).__name__} {thing.id} has no state yet: put it into the map"
        ):
            thing.state(Map())
    map = Map()
    place(map, sen, np.zeros(3))
    place(map, rob, np.arange(3.0), np.eye(3))
    assert repr(rob) == "Rob(3, Odometry2, in the map at 0:3, sensors [1, 2])" and repr(sen).endswith("frame known)")
    assert map.robs == [rob]  # robots, not sensors
    assert repr(Lmk(4, IdpPnt(), r=slice(3, 9), n_search=5, n_match=3, n_inlier=2)) == (
        "Lmk(4, IdpPnt, in the map at 3:9, searched 5, matched 3, used 2)"
    )
    assert repr(Lmk(4, EucPnt(2), x=np.zeros(2))) == "Lmk(4, EucPnt, known, searched 1, matched 1, used 1)"


@pytest.mark.parametrize(
    ("flags", "fate"),
    [
        ({"visible": False}, "out of view"),
        ({}, "not seen"),
        ({"matched": True}, "refused"),
        ({"matched": True, "updated": True}, "used"),
    ],
)
def test_the_fate_of_an_observation(flags, fate):
    o = Obs(1, 7, np.array([1.0, 2.0004]), np.eye(2), np.ones(2), (), **flags)
    assert repr(o) == f"Obs(landmark 7 by sensor 1, expected [1. 2.], {fate})"
    assert o.Z is None and o.md2 is None
    o.R, o.z = 3 * np.eye(2), np.array([2.0, 4.0])
    assert np.array_equal(o.Z, 4 * np.eye(2)) and o.md2 == pytest.approx(5.0)


def test_jacobians_by_name():
    o = Obs(1, 7, 0, 0, 0, ((None, "r"), (None, "s"), (None, "l")))
    assert (o.E_r, o.E_s, o.E_l) == ("r", "s", "l")


def test_states_are_copies_and_frames_their_heads():
    map, rob = Map(), Rob(1, ConstantVelocity())
    x = np.concatenate([[1.0, 2, 3], [1, 0, 0, 0], np.arange(6.0)])
    place(map, rob, x, np.eye(13))
    assert rob.frame(map) == Frame3(x[:7])
    rob.state(map)[:] = 0
    map.state(rob.r)[:] = 0
    map.block(rob.r)[:] = 0
    assert np.array_equal(map.x, x) and np.array_equal(map.P, np.eye(13))
    known = Lmk(2, EucPnt(2), x=np.array([5.0, 6.0]))
    known.state(map)[:] = 0
    known.point(map)[0][:] = 0
    assert known.x.tolist() == [5.0, 6.0]
    inside = [Lmk(i, EucPnt(2), r=map.add([i, -i], np.eye(2))) for i in (3, 4)]
    assert states(map, inside).tolist() == [[3, -3], [4, -4]] and states(map, [known]).tolist() == [[5, 6]]


def test_values_in_few_words():
    assert short(slice(2, 5)) == "2:5" and short(Frame2) == "Frame2" and short(None) == "None" and short("a") == "'a'"
    assert short(np.array([1.23456, 2.0])) == "[1.235 2.   ]"
    assert "..." in short(np.zeros(41)) and "..." not in short(np.zeros(40))


def test_events_and_times():
    assert Event("search", 1, 2, 3) == ("search", 1, 2, 3, True)
    assert (Tim(0, 9, 0.1).first, Tim(0, 9, 0.1).last, Tim(0, 9, 0.1).dt) == (0, 9, 0.1)
    assert Lmk(1, None) != Lmk(1, None)  # each is its own
    assert (Lmk(1, None).n, Lmk(1, None).N, Lmk(1, None).x) == (None, None, None)
    assert (Sen(1, 1, None, None).name, Sen(1, 1, None, None).lmk_type, Rob(1, None).u) == ("", None, None)
    assert Rob(1, None).sensors == [] and Rob(1, None).sensors is not Rob(1, None).sensors
