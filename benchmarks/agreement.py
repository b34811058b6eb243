"""Before any timing: every variant gives what the textbook gives."""

from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from .given import given
from .oracle import GivenOracle, Oracle
from .ours import FILTERS, STEPS
from .world import circuit, lap

TOLERANCE = 1e-9  # relative to the largest entry; rounding errors of a few dozen steps are 1e-13
GIVEN = "textbook, given blocks"
FLOAT32 = 1e-6  # MRPT keeps the noise of its sensor in single precision


def check(peers, n_lmks=12, m=5, n_steps=25):
    """Compare all variants with the oracle.

    Returns
    -------
    list of dict
        variant, against, deviation (largest of mean and covariance, relative), tolerance, ok; or variant and failed.
    """
    world, new, rows = lap(n_lmks, m), circuit(n_lmks, m), []
    sequential, joint = (run(Oracle(world, j), n_steps) for j in (False, True))
    ordered = run(Oracle(world, False, uncertain_first=True), n_steps)
    given_one, given_all = (run(GivenOracle(world, given(world), j), n_steps) for j in (False, True))

    def add(name, make, reference, against="textbook", n_steps=n_steps):
        rows.append(compared(name, lambda: run(make(), n_steps), reference, against))

    for name, make in FILTERS.items():
        add(name, lambda make=make: make(world), given_all if "joint" in name else given_one, GIVEN)
    for name, make in STEPS.items():
        add(name, lambda make=make: make(world), joint if "joint" in name else ordered)
    for name, make in STEPS.items():
        oracle = Oracle(new, "joint" in name, uncertain_first=True)
        reference = by_id(oracle, run(oracle, len(new.steps)))
        add(f"{name}, from an empty map", lambda make=make: make(new), reference, n_steps=len(new.steps))

    if "filterpy_peer" in peers:
        add("filterpy", lambda: peers.filterpy_peer.FilterPy(world), sequential)
        module = peers.filterpy_peer
        add("filterpy, blocks given", lambda: module.FilterPyGiven(world, given), given_one, GIVEN)
        for name, by_hand in ("filterpy, joint", False), ("filterpy, joint, motion by hand", True):
            add(name, lambda by_hand=by_hand: module.FilterPyJoint(world, by_hand), joint)
            oracle = Oracle(new, joint=True)
            reference = run(oracle, len(new.steps))
            empty = lambda by_hand=by_hand: module.FilterPyJoint(new, by_hand)
            add(f"{name}, from an empty map", empty, reference, n_steps=len(new.steps))
        given_joint = lambda: module.FilterPyJointGiven(world, given)
        add("filterpy, joint, motion by hand, blocks given", given_joint, given_all, GIVEN)
    if "stone_soup" in peers:
        add("Stone Soup updater", lambda: peers.stone_soup.StoneSoup(world), joint)
        add("Stone Soup updater, tuned", lambda: peers.stone_soup.Tuned(world), joint)
    if "robotics_toolbox" in peers:
        make, one = peers.robotics_toolbox.RoboticsToolbox, lap(n_lmks, 1)
        quick = lambda: make(one, joseph=False)
        add("Robotics Toolbox, joseph=False", quick, run(make(one), n_steps), "Robotics Toolbox")
    if "compiled" in peers:
        add("numba loops", lambda: peers.compiled.Compiled(world), sequential)
        add("numba loops, joint", lambda: peers.compiled.CompiledJoint(world), joint)
    if "python_robotics" in peers:
        module, path = peers.modules["python_robotics"], peers.python_robotics
        for name, make, joined in (
            ("PythonRobotics, known ids", lambda: module.PythonRobotics(world, path, known_ids=True), False),
            ("PythonRobotics, joint", lambda: module.Joint(world, path), True),
        ):
            state = lambda make=make: _python_robotics(make(), world)
            rows.append(compared(name, state, _corrected(world, joined), "textbook, one correction"))
    if peers.mrpt:
        rows.append(_mrpt(peers, new))
    return rows


def run(filter, n_steps):
    """State after so many steps."""
    for k in range(n_steps):
        filter.step(k)
    return filter.state() if hasattr(filter, "state") else (filter.x, filter.P)


def by_id(oracle, state):
    """The oracle's state, its landmarks in the order of their ids."""
    order = np.concatenate([np.arange(3), *(np.arange(r.start, r.stop) for _, r in sorted(oracle.at.items()))])
    return state[0][order], state[1][np.ix_(order, order)]


def compared(name, state, reference, against, tolerance=TOLERANCE):
    """One row."""
    try:
        x, P = state()
    except Exception as error:
        return {"variant": name, "against": against, "failed": f"{type(error).__name__}: {error}"}
    deviation = max(relative(x, reference[0]), relative(P, reference[1]))
    return {
        "variant": name,
        "against": against,
        "deviation": deviation,
        "tolerance": tolerance,
        "ok": bool(deviation <= tolerance),
    }


def relative(a, b):
    """Largest difference over the largest entry."""
    return float(np.abs(a - b).max() / np.abs(b).max())


def _corrected(world, joint):
    oracle, step = Oracle(world, joint), world.steps[0]
    seen = list(zip(step.ids, step.y, strict=True))
    for some in [seen] if joint else [[one] for one in seen]:
        oracle.correct(some)
    return oracle.x, oracle.P


def _python_robotics(peer, world):
    peer.correct(world.steps[0])
    return peer.state()


def _mrpt(peers, world):
    """It takes the first step as the start: no motion, no uncertainty of the pose."""
    world = replace(world, P0=np.zeros((3, 3)))
    oracle = Oracle(world, joint=True)
    for i, y in zip(world.steps[0].ids, world.steps[0].y, strict=True):
        oracle.start(i, y)
    for k in range(1, len(world.steps)):
        oracle.step(k)

    def state():
        with TemporaryDirectory() as folder:
            _, pose = peers.modules["mrpt_peer"].run(peers.mrpt, world, "naive", Path(folder))
        return pose, oracle.P[:3, :3]

    return compared("MRPT, joint (pose)", state, (oracle.x[:3], oracle.P[:3, :3]), "textbook", FLOAT32)
