"""What one frame of a run leaves for the next one, and for a run that goes on from there."""

from dataclasses import fields

import numpy as np
import pytest

from ekfslam_tutorial.simulation import SimObs
from ekfslam_tutorial.toolbox import Recording, UserData, universal_slam
from ekfslam_tutorial.toolbox.files import value_file
from ekfslam_tutorial.toolbox.run_state import restore, run_state
from ekfslam_tutorial.toolbox.structures import create_slam_structures

TABLE = {
    "robot": [{"id": 1, "motion": "odometry2", "position": [0.0, 0.0], "dx_std": 0.01, "da_std_deg": 0.1}],
    "sensor": [
        {"id": i, "robot": 1, "type": "range_bearing", "range_std": 0.05, "bearing_std_deg": 1.0} for i in (1, 2)
    ],
    "options": {"md2_threshold": 9.0},
}
POINTS = np.array([[4.0, 1.0], [5.0, -2.0], [3.0, 0.5], [6.0, 2.0], [7.0, -1.0]])
both_engines = pytest.mark.parametrize("engine", ["plain", "fast"])


def seen(sen, ids, shift=0.0):
    p = POINTS[list(ids)] if len(ids) else np.zeros((0, 2))
    y = np.stack([np.hypot(*p.T) + shift, np.arctan2(p[:, 1], p[:, 0])], -1)
    return SimObs(sen, np.array(list(ids), int) + 1, y)


def data(engine, n_sensors=1, **options):
    table = TABLE | {"sensor": TABLE["sensor"][:n_sensors]}
    return UserData.from_dict(table, {"options.engine": engine} | {f"options.{k}": v for k, v in options.items()})


def log(raw, **more):
    """A robot that stands still."""
    n = len(raw[1])
    return Recording("still", 0.1 * np.arange(n), {1: np.zeros((n, 3))}, raw, **more)


@both_engines
@pytest.mark.parametrize("limits", [(3, 1), (1, 2), (0, 1), (2, 0)])
def test_so_many_new_landmarks_in_the_first_frame_and_in_each_later_one(engine, limits):
    raw = {1: [seen(1, range(5))] * 5}
    counts = [
        sum(event.kind == "initialisation" for event in s.events)
        for s in universal_slam(data(engine, n_inits=limits), log(raw))
    ]
    first, later = limits
    left = 5 - first
    wanted = [first]
    for _ in range(4):
        wanted.append(min(later, left))
        left -= wanted[-1]
    assert counts == wanted


@both_engines
def test_a_sensor_that_did_not_look_has_no_observations(engine):
    """Where there is a frame for each event; what it saw before is not what it sees now."""
    nothing = lambda sen: seen(sen, [])
    raw = {
        1: [seen(1, [0, 1]), nothing(1), seen(1, [0, 1]), nothing(1), seen(1, [1])],
        2: [nothing(2), seen(2, [0, 2]), nothing(2), seen(2, [0, 2]), nothing(2)],
    }
    looked = [{1}, {2}, {1}, {2}, {1}]
    run = universal_slam(data(engine, 2), log(raw, by_event=True))
    for s, sensors in zip(run, looked, strict=True):
        assert {sen for sen, _ in s.obs} <= sensors
    assert {sen for sen, _ in s.obs} == {1}
    in_step = universal_slam(data(engine, 2), log(raw))  # they look in every frame, and see nothing
    *_, s = in_step
    assert {sen for sen, _ in s.obs} == {1, 2}


@both_engines
def test_how_often_a_robot_was_refused_is_kept(engine, tmp_path):
    """Else the gate of a robot that is lost opens too late after a stop: on the frame it was to open, it does."""
    good, bad = seen(1, range(5)), seen(1, range(5), shift=1.0)
    raw, lost = {1: [good] * 3 + [bad] * 6}, data(engine, reopen_after=12)
    whole, states = [], []
    for s in universal_slam(lost, log(raw)):
        whole.append((s.robs[0].n_refused, [e.kind for e in s.events], s.robs[0].state(s.map).tobytes()))
        value_file.save(tmp_path / "state.npz", run_state(s, lost))
        states.append(value_file.load(tmp_path / "state.npz"))
    counts = [n for n, *_ in whole]
    assert counts[:6] == [0, 0, 0, 5, 10, 0]  # with the twelfth the gate is open, and all pass
    for k, state in enumerate(states[:-1]):
        map, robs, sens, *_ = create_slam_structures(lost)
        restore(state, lost, map, robs, sens)
        assert robs[0].n_refused == counts[k]
        rest = universal_slam(lost, log(raw), resume=state)
        again = [(s.robs[0].n_refused, [e.kind for e in s.events], s.robs[0].state(s.map).tobytes()) for s in rest]
        assert again == whole[k + 1 :]


NEXT_FRAME = {"u", "U", "dt"}  # a control comes with the frame that it belongs to


@pytest.mark.parametrize(
    "options, counts",
    [({"retry_after": 9}, "n_refused"), ({"lost_after": 9}, "n_missed"), ({"first_estimates": True}, "first")],
)
def test_all_that_a_run_remembers_is_kept(options, counts, tmp_path):
    """Field by field, of robots, sensors and landmarks, in the middle of what is counted."""
    good, bad = seen(1, range(5)), seen(1, range(3), shift=1.0)
    run, remembered = data("plain", **options), []
    for s in universal_slam(run, log({1: [good, good, bad, bad]})):
        value_file.save(tmp_path / "state.npz", run_state(s, run))
        map, robs, sens, *_ = create_slam_structures(run)
        lmks, *_ = restore(value_file.load(tmp_path / "state.npz"), run, map, robs, sens)
        remembered += [getattr(lmk, counts) for lmk in s.lmks.values()]
        for thing, again in zip([*s.robs, *s.sens, *s.lmks.values()], [*robs, *sens, *lmks.values()], strict=True):
            for f in fields(thing):
                one, other = getattr(thing, f.name), getattr(again, f.name)
                assert f.name in NEXT_FRAME or np.array_equal(one, other), (type(thing).__name__, f.name, one, other)
        assert np.array_equal(s.map.x, map.x) and np.array_equal(s.map.P, map.P) and s.map.ranges == map.ranges
    assert any(np.any(value) for value in remembered)
