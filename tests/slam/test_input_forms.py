"""Input that has another form than it should, or changes its numbers while it stays the same object."""

import numpy as np
import pytest

from ekfslam_tutorial.slam import correct_known_lmks, move

from .scenes import Scene, raw
from .test_bad_input import P3, assert_unchanged, snapshot


@pytest.mark.parametrize("ids, shape", [([[5]], r"\(1, 1\)"), (5, r"\(\)")], ids=["table", "number"])
def test_ids_that_are_no_list(ids, shape):
    scene = Scene(P=P3)
    with pytest.raises(ValueError, match=f"sensor 1: ids must be a list of integers, got shape {shape}"):
        correct_known_lmks(*scene.all, scene.obs, raw(ids, [[3.0, 0.1]]), scene.opt)


def test_no_control_noise():
    scene = Scene(P=P3)
    scene.rob.u, scene.rob.U = np.zeros(3), None
    before = snapshot(scene)
    with pytest.raises(ValueError, match="robot 1: the control covariance must be real numbers, got None"):
        move(scene.map, scene.rob, 0.1)
    assert_unchanged(scene, before)


@pytest.mark.parametrize(
    "bad, said", [(-1.0, "must be positive semi-definite"), (np.nan, "must be finite")], ids=["negative", "NaN"]
)
def test_control_noise_that_is_changed_in_place(bad, said):
    """What was found to be a covariance need not be one still; nor are its numbers, in another shape."""
    scene = Scene(P=P3)
    scene.rob.u, scene.rob.U = np.zeros(3), 0.01 * np.eye(3)
    move(scene.map, scene.rob, 0.1)
    before = snapshot(scene)
    scene.rob.U[1, 1] = bad
    with pytest.raises(ValueError, match=f"robot 1: the control covariance {said}"):
        move(scene.map, scene.rob, 0.1)
    scene.rob.U = 0.01 * np.eye(3).ravel()
    with pytest.raises(ValueError, match=r"robot 1: the control covariance must have shape \(3, 3\), got \(9,\)"):
        move(scene.map, scene.rob, 0.1)
    assert_unchanged(scene, before)
