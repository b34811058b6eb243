"""Tracks come and go: landmarks that creep, landmarks that are lost, and a robot with many controls a frame."""

import numpy as np
import pytest

from ekfslam_tutorial.geometry import Frame3
from ekfslam_tutorial.models.landmarks import AhmPnt, EucPnt, HmgPnt, IdpPnt
from ekfslam_tutorial.models.motion import Imu, ImuClock, Unicycle
from ekfslam_tutorial.slam import Event, Options, Rob, let_go, move, new_map, place, travel, wander

from .scenes import Scene


def scene(kind=None, ids=(7,), **options):
    kind = kind or EucPnt(2)
    scene = Scene(kind.dim, P=None if kind.dim == 3 else 1e-4 * np.eye(3), lmk_type=kind, **options)
    for id in ids:
        l = kind.from_point(np.array([3.0, id, 2.0][: kind.dim]))[0]
        scene.add(id, l, 1e-4 * np.eye(len(l)))
    return scene


@pytest.mark.parametrize("kind", [EucPnt(2), EucPnt(3), IdpPnt(), AhmPnt(), HmgPnt()], ids=str)
def test_a_landmark_creeps_by_as_much_in_all_directions_whatever_its_type(kind):
    ours = scene(kind, ids=(7, 8), wander=0.05)
    ours.lmks[8].n_missed = 1
    x, P = ours.map.x.copy(), ours.map.P.copy()
    before = {id: lmk.point(ours.map)[1] for id, lmk in ours.lmks.items()}
    wander(ours.map, ours.lmks, 0.2, ours.opt)
    grown = {id: lmk.point(ours.map)[1] - before[id] for id, lmk in ours.lmks.items()}
    assert np.allclose(grown[7], 0.05**2 * 0.2 * np.eye(kind.dim), rtol=0, atol=1e-15)
    assert not grown[8].any(), "who is not in view is not followed by anybody"
    added = ours.map.P - P
    added[ours.lmks[7].r, ours.lmks[7].r] = 0.0
    assert np.array_equal(ours.map.x, x) and not added.any()


def found(*ids):
    return [Event("search", 1, 1, id, True) for id in ids]


def test_the_lost_leave_and_those_that_were_used_most_stay():
    ours = scene(ids=(1, 2, 3, 4, 5), lost_after=2, keep_lost=1)
    for id, n in ((1, 5), (2, 9), (3, 7)):
        ours.lmks[id].n_inlier = n
    step = lambda *events: let_go(ours.map, ours.rob, ours.sen, ours.lmks, list(events), ours.opt)
    missed = Event("search", 1, 1, 3, False)
    assert step(*found(3, 4), Event("initialisation", 1, 1, 5)) == [] and ours.lmks[1].n_missed == 1
    assert step(missed, *found(4, 5)) == [Event("deletion", 1, 1, 1)]  # 1 and 2 are lost, 2 was used more often
    n = ours.map.n_used
    assert step(*found(4, 5)) == [Event("deletion", 1, 1, 3)] and list(ours.lmks) == [2, 4, 5]
    assert ours.map.n_used == n - 2
    assert step(*found(2, 4, 5)) == [] and ours.lmks[2].n_missed == 0


def test_without_the_options_nothing_is_counted():
    ours = scene()
    P = ours.map.P.copy()
    wander(ours.map, ours.lmks, 0.2, ours.opt)
    assert let_go(ours.map, ours.rob, ours.sen, ours.lmks, [], ours.opt) == [] and ours.lmks[7].n_missed == 0
    assert np.array_equal(ours.map.P, P)


@pytest.mark.parametrize("name, value", [("wander", -1), ("wander", np.inf), ("lost_after", 0), ("keep_lost", 1.5)])
def test_options_that_mean_nothing_are_refused(name, value):
    with pytest.raises(ValueError, match=f"{name} must be a"):
        Options(**{name: value})


@pytest.mark.parametrize("model", [Unicycle(), Imu(), ImuClock()], ids=lambda m: type(m).__name__)
def test_many_controls_are_one_motion(model, rng):
    """Those one after the other, with another state in the map, which is correlated with the robot."""
    m, n, k = sum(model.control_fields.values()), model.size, 4
    u, h = rng.normal(size=(k, m)), rng.uniform(0.01, 0.1, k)
    A = rng.normal(size=(k, m, m)) * 0.05
    U = A @ A.swapaxes(1, 2)
    x = np.concatenate([rng.normal(size=n)])
    x = np.concatenate([model.frame(x[: model.frame.size]).normalized()[0].x, x[model.frame.size :]])
    B = 0.1 * rng.normal(size=(n + 2, n + 2))
    maps = []
    for many in (True, False):
        map, rob = new_map(), Rob(1, model)
        place(map, rob, x, (B @ B.T)[:n, :n])
        map.add([1.0, 2.0], (B @ B.T)[n:, n:], (B @ B.T)[n:, :n])
        if many:
            rob.u, rob.U = u, U
            move(map, rob, h)
        else:
            for rob.u, rob.U, dt in zip(u, U, h.tolist(), strict=True):
                move(map, rob, dt)
        maps.append(map)
    assert np.allclose(maps[0].x, maps[1].x, rtol=0, atol=1e-12)
    assert np.allclose(maps[0].P, maps[1].P, rtol=0, atol=1e-12)


def test_no_control_at_all_is_no_motion():
    x = np.arange(3.0)
    x2, X_x, X_u, Q = travel(Unicycle().move, x, np.zeros((0, 2)), np.zeros((0, 2, 2)), np.zeros(0))
    assert np.array_equal(x2, x) and np.array_equal(X_x, np.eye(3)) and not (X_u @ Q @ X_u.T).any()


@pytest.mark.parametrize(
    "u, U, dt, message",
    [
        (np.zeros((3, 2)), np.zeros((3, 2, 2)), 0.1, "a number of seconds, one for each of 3 controls"),
        (np.zeros((3, 2)), np.zeros((2, 2)), np.ones(3), "the control covariance"),
        (np.zeros((3, 2)), np.zeros((2, 2, 2)), np.ones(3), r"shape \(3, 2, 2\), got \(2, 2, 2\)"),
        *((np.zeros((3, 2)), np.zeros((3, 2, 2)), np.array([1.0, bad, 1.0]), "a number of seconds")
          for bad in (-1e-9, np.inf, np.nan)),
        (np.zeros(2), np.zeros((2, 2)), np.ones(1), "a number of seconds, got"),
        (np.diag([1.0, np.nan]), np.zeros((2, 2, 2)), np.ones(2), "the control must be 2 finite numbers"),
        (np.zeros((2, 2)), np.stack([np.eye(2), -np.eye(2)]), np.ones(2), "the control covariance must be positive"),
        (np.zeros((3, 4)), np.zeros((3, 2, 2)), np.ones(3), "the control must be 2 finite numbers"),
    ],
)  # fmt: skip
def test_bad_controls_are_refused_before_anything_has_changed(u, U, dt, message):
    map, rob = new_map(), Rob(1, Unicycle())
    place(map, rob, np.zeros(3), np.eye(3))
    rob.u, rob.U = u, U
    with pytest.raises(ValueError, match=message):
        move(map, rob, dt)
    assert np.array_equal(map.P, np.eye(3))


def test_the_pose_turns_with_the_world(rng):
    """The clock does not."""
    x = rng.normal(size=17)
    assert np.array_equal(ImuClock().turning(x)[:9], Imu().turning(x[:16])) and not ImuClock().turning(x)[9].any()
    assert Frame3.dim == 3
