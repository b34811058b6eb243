"""A compressed map with the invariant error: far states are carried along before they are used, and not at once.

Nothing is learnt of the gauge in it either: `tests/slam/test_invariant.py` has it among its engines. Here it is held to
the others as far as an effect of the second order goes.
"""

import copy
import pickle

import numpy as np
import pytest

from ekfslam_tutorial.toolbox import universal_slam

from .test_scenarios import scenario

BAND = 0.1  # standard deviations, of means and in the covariance; 0.04 was measured


@pytest.mark.usefixtures("interpreted")
@pytest.mark.parametrize("joint", [False, True], ids=["one by one", "joint"])
@pytest.mark.parametrize("name", ["range_bearing_2d", "cloister_idp"])
def test_a_lazy_map_is_near_the_others(name, joint):
    """The events are the same, and it would be out of the band, without being carried along: see the additive error."""
    off, worst = {"engine": "fast", "joint": joint, "compiled": False, "compressed": False}, {}
    how = {
        "whole": {"error": "invariant"},
        "lazy": {"error": "invariant", "compressed": True},
        "additive": {"error": "additive"},
    }
    runs = [universal_slam(scenario(name, 40, **off | options)) for options in how.values()]
    for whole, *others in zip(*runs, strict=True):
        std = np.sqrt(np.diag(whole.map.P).clip(0)) + 1e-7
        for key, other in zip(("lazy", "additive"), others, strict=True):
            if whole.map.ranges == other.map.ranges:
                P = np.array([other.map.block(r)[0, 0] - whole.map.P[r.start, r.start] for r in whole.map.ranges])
                at = [r.start for r in whole.map.ranges]
                far = max(np.abs((whole.map.x - other.map.x) / std)[at].max(), np.abs(P / std[at] ** 2).max())
                worst[key] = max(worst.get(key, 0.0), far)
        assert whole.events == others[0].events
    assert 1e-6 < worst["lazy"] < BAND, worst


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda map: pickle.loads(pickle.dumps(map))], ids=["copy", "pickle"])
def test_a_copy_of_a_lazy_map_goes_on_like_it(copied):
    """It knows to which estimate each of its states refers."""
    run = universal_slam(scenario("range_bearing_2d", 30, joint=True, error="invariant", compressed=True))
    now = [next(run) for _ in range(20)][-1]
    other = copied(now.map)
    assert np.array_equal(other.referred()[: other.n], now.map.referred()[: now.map.n])
    assert (np.abs(other.referred()[: other.n] - other.x) > 1e-6).any() and len(other.robs) == 1


@pytest.mark.parametrize("how", [{}, {"compressed": True}], ids=["whole", "compressed"])
def test_a_run_with_the_invariant_error_can_be_taken_up(how):
    from ekfslam_tutorial.toolbox.run_state import run_state

    data = scenario("range_bearing_2d", 30, error="invariant", joint=True, **how)
    *_, whole = universal_slam(data)
    run = universal_slam(data)
    half = [next(run) for _ in range(15)][-1]
    *_, end = universal_slam(data, resume=run_state(half, data))
    assert np.allclose(end.map.x, whole.map.x, rtol=0, atol=1e-10)
    assert np.allclose(end.map.P, whole.map.P, rtol=0, atol=1e-10)
