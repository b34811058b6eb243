"""What is a number, what a covariance: how much rounding explains, and what is more than that."""

import numpy as np
import pytest

from ekfslam_tutorial.ekf import check_covariance, real
from ekfslam_tutorial.ekf.covariances import TINY, faults


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_rounding_is_measured_by_the_largest_number(scale):
    """Asymmetry, and an eigenvalue below zero, of 1e-8 of it: just within, and just beyond."""
    assert TINY == 1e-8
    for share, wrong in ((0.99e-8, False), (1.01e-8, True)):
        skew = scale * np.array([[1.0, share], [0.0, 0.5]])
        negative = scale * np.diag([1.0, 0.5, -share])
        assert [bool(f) for f in faults(skew)] == [wrong, False]
        assert [bool(f) for f in faults(negative)] == [False, wrong]
        for P, said in (
            (skew, "must be symmetric, got"),
            (negative, "positive semi-definite, its smallest eigenvalue"),
        ):
            if wrong:
                with pytest.raises(ValueError, match=f"this one .*{said}"):
                    check_covariance(P, len(P), "this one")
            else:
                check_covariance(P, len(P))


def test_each_of_many_is_judged_by_itself():
    """A large one beside it is no excuse."""
    P = np.stack([1e9 * np.eye(2), np.array([[1.0, 1e-3], [0.0, 1.0]]), np.diag([1.0, -1e-3]), np.zeros((2, 2))])
    skew, negative = faults(P)
    assert skew.tolist() == [False, True, False, False] and negative.tolist() == [False, False, True, False]
    assert faults(np.zeros((3, 0, 0)))[0].tolist() == [False] * 3
    check_covariance(np.zeros((0, 0)), 0)


@pytest.mark.parametrize(
    ("a", "said"),
    [
        (np.ma.array([1.0, 2.0], mask=[False, True]), "not have masked entries: leave out what is not known"),
        ([[1.0], [1.0, 2.0]], "rows of different lengths"),
        (None, "got None"),
        (np.array([1.0, 2.0], object), "got object"),
        ([1.0 + 0j], "got complex128"),
        ([True], "got bool"),
        (["1"], "got <U1"),
    ],
)
def test_what_is_no_real_number_is_said(a, said):
    with pytest.raises(ValueError, match=f"this one must .*{said}"):
        real("this one", a)


def test_what_is_a_real_number_stays_what_it_is():
    a = np.array([1.0, 2.0])
    assert real("a", a) is a  # no copy
    for b in (np.array([1, 2], np.uint8), [1, 2], (1.0, 2), np.float32([1, 2]), np.ma.array([1.0, 2.0])):
        assert real("b", b).dtype == float and real("b", b).tolist() == [1.0, 2.0]
    with pytest.raises(ValueError, match=r"P must have shape \(2, 2\), got \(2,\)"):
        check_covariance(a, 2)
    with pytest.raises(ValueError, match="P must be finite, got"):
        check_covariance(np.diag([1.0, np.inf]), 2)
