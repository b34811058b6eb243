"""The checker of Jacobians must find what is wrong, or every test that uses it is worth nothing."""

import numpy as np
import pytest

from ekfslam_tutorial.geometry import Frame2, Frame3, check_jacobians, numerical_jacobian

A = np.array([[1.0, 2.0], [0.0, -3.0], [0.5, 0.0]])
X = np.array([0.3, -0.7])


def bilinear(x, y):
    """x' A' y with its two derivatives."""
    return y @ A @ x, y @ A, A @ x


def test_a_linear_map_is_differentiated_exactly():
    assert np.allclose(numerical_jacobian(lambda x: A @ x, X), A, atol=1e-9)


def test_the_error_is_of_second_order():
    """Twice the step, four times the error: central differences."""
    error = [abs(numerical_jacobian(np.sin, np.array([1.0]), step) - np.cos(1.0)).item() for step in (1e-2, 2e-2)]
    assert error[1] / error[0] == pytest.approx(4, rel=1e-3)


def test_large_numbers_get_larger_steps():
    x = np.array([1e8])
    assert np.allclose(numerical_jacobian(np.square, x), 2e8, rtol=1e-6)


def test_shapes_of_values_are_kept():
    assert numerical_jacobian(lambda x: np.outer(x, x), X).shape == (2, 2, 2)
    assert numerical_jacobian(lambda x: np.zeros(3), np.zeros(0)).shape == (3, 0)


@pytest.mark.parametrize("F", [Frame2(np.array([1.0, 2, 3])), Frame3(np.array([1.0, 2, 3, 1, 0, 0, 0]))])
def test_frames_are_arguments_and_values(F):
    J = numerical_jacobian(lambda F: F, F)
    assert np.allclose(J, np.eye(F.size), atol=1e-9)


def test_a_right_function_passes():
    check_jacobians(bilinear, X, np.array([1.0, 2.0, 3.0]))


def test_an_argument_without_numbers_passes():
    check_jacobians(lambda x, n: (x, np.eye(2), np.zeros((2, 0))), X, np.zeros(0))


@pytest.mark.parametrize(
    "wrong, said",
    [
        (lambda x, y: bilinear(x, y)[:2], "got 1 Jacobians for 2 arguments"),
        (lambda x, y: (y @ A @ x, y @ A, -A @ x), "argument 2 differs"),
        (lambda x, y: (y @ A @ x, (y @ A)[None], A @ x), r"argument 1 has shape \(1, 2\)"),
        (lambda x, y: (y @ A @ x, y @ A, np.full(3, np.nan)), "argument 2 differs"),
        (lambda x, y: (y @ A @ x, y @ A + [0, 1e-4], A @ x), "argument 1 differs at entry .1.: got"),
    ],
)
def test_a_wrong_function_does_not(wrong, said):
    with pytest.raises(AssertionError, match=said):
        check_jacobians(wrong, X, np.array([1.0, 2.0, 3.0]))


def test_where_a_function_is_asked():
    """A millionth on each side, or a millionth of a number above one; another step if it is said."""
    asked = []
    numerical_jacobian(lambda x: asked.append(x) or x, np.array([0.5, -3.0]))
    assert np.allclose(np.array(asked) - [0.5, -3.0], [[1e-6, 0], [-1e-6, 0], [0, 3e-6], [0, -3e-6]], rtol=1e-6, atol=0)
    asked.clear()
    check_jacobians(lambda x: (asked.append(x) or x, np.eye(2)), np.array([0.5, -3.0]), step=1e-3)
    assert np.allclose(np.array(asked[1:]) - [0.5, -3.0], [[1e-3, 0], [-1e-3, 0], [0, 3e-3], [0, -3e-3]])


@pytest.mark.parametrize(
    ("tolerances", "limit"),
    [({}, 1e-6 + 4e-6), ({"rtol": 0.0}, 1e-6), ({"atol": 0.0}, 4e-6), ({"rtol": 1e-3, "atol": 1e-2}, 1.4e-2)],
)
def test_how_wrong_a_jacobian_may_be(tolerances, limit):
    """In terms of the largest entry of its own: 4 here."""

    def wrong_by(share):
        return lambda x: (np.array([4 * x[0], x[1]]), np.diag([4.0, 1.0 + share * limit]))

    for sign in (1, -1):
        check_jacobians(wrong_by(0.99 * sign), np.zeros(2), **tolerances)
        with pytest.raises(AssertionError, match=r"argument 1 differs at entry \[1, 1\]"):
            check_jacobians(wrong_by(1.01 * sign), np.zeros(2), **tolerances)


def test_of_equal_errors_the_first_is_named_and_of_others_the_largest():
    J = np.eye(3)
    for errors, entry in (
        ({(1, 0): 0.1, (2, 2): 0.1}, "1, 0"),
        ({(1, 0): 0.1, (2, 2): 0.1 * (1 + 5e-7)}, "1, 0"),  # equal but for rounding
        ({(1, 0): 0.1, (2, 2): 0.1 * (1 + 5e-6)}, "2, 2"),
        ({(1, 0): 9.0, (2, 2): np.nan}, "2, 2"),
        ({(1, 0): 9.0, (0, 2): -np.inf}, "0, 2"),
    ):
        wrong = J.copy()
        for at, error in errors.items():
            wrong[at] += error
        with pytest.raises(AssertionError, match=rf"differs at entry \[{entry}\]: got"):
            check_jacobians(lambda x, wrong=wrong: (x, wrong), np.zeros(3))
