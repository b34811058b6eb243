"""What a table of an exercise takes as right, and what it says of the rest."""

import numpy as np

from ekfslam_tutorial.course import edits
from ekfslam_tutorial.course.table import at, table

HINTS = ("a first hint that is long enough", "a second one that is long enough", "a third one that is long enough")


def asked(solution, returns, cases, checks, **options):
    """A table with one case and no wrong answers."""
    return table(
        "99.1 A test",
        solution,
        hints=HINTS,
        returns=returns,
        cases={"any": cases},
        checks=checks,
        wrong="",
        **options,
    )


def above(x, limit):
    """Return the entries above a limit, as rows [entry, its square]."""
    x = x[x > limit]
    return np.column_stack([x, x**2])


def entries(rng):
    return [(np.arange(4.0), limit) for limit in (9.0, 1.0)]


def test_an_empty_list_has_no_axes_but_an_empty_array_has():
    exercise = asked(above, "rows", entries, "rows | rows | any | Each entry has its row.")
    assert exercise.judge(lambda x, limit: [[v, v * v] for v in x if v > limit]).passed
    verdict = exercise.judge(lambda x, limit: np.array([[v, v * v] for v in x if v > limit]))
    assert verdict.status == "failed" and "shape (0,), it must be (0, 2)" in verdict.message


def test_a_result_of_the_wrong_length_is_shown_with_the_arguments():
    def first(rng):
        return [(np.arange(4.0), 1.0)]

    exercise = asked(above, "rows", first, "rows | rows | any | Each entry has its row.")
    exercise.links.pop(0)  # the one that asks for the form only
    verdict = exercise.judge(lambda x, limit: above(x, 0.0))
    assert "has shape (3, 2), it must be (2, 2)" in verdict.message and "limit = 1" in verdict.message
    assert verdict.hint == "Each entry has its row."


def half(q, a):
    """Return q, turned round by its own sign, and its derivative by a."""
    return a * q, np.outer(q, [1.0])


def unit(rng):
    q = rng.normal(size=2)
    return [(q / np.linalg.norm(q), a) for a in (0.5, 2.0)]


def test_results_that_mean_the_same_are_settled():
    def settled(got, want):
        side = 1 if got[0] @ want[0] >= 0 else -1
        return [side * part for part in got]

    checks = "both | q | any | Value.\nslope | Q_a | any | Derivative."
    exercise = asked(half, "q, Q_a", unit, checks, settled=settled)
    assert exercise.judge(lambda q, a: [-part for part in half(q, a)]).passed
    verdict = exercise.judge(lambda q, a: (-half(q, a)[0], half(q, a)[1]))  # the sign of one of the two
    assert verdict.status == "failed" and verdict.link == "slope"


def length(q):
    """Return |q|, and its derivative."""
    r = np.sqrt(q @ q)
    return np.array([r]), (q / r)[None]


def test_a_jacobian_may_differ_where_no_state_is():
    def across(q):
        return np.eye(2) - np.outer(q, q)

    cases = lambda rng: [(args[0],) for args in unit(rng)]
    for checks in ("value | R_q | any | The derivative.", "slope | d R_q / q | any | The derivative."):
        exercise = asked(length, "r, R_q", cases, checks, jacobians={"R_q": "r"}, along={"R_q": across})
        assert exercise.judge(lambda q: (length(q)[0], 3 * length(q)[1])).passed  # along q nothing is asked
        wrong = exercise.judge(lambda q: (length(q)[0], length(q)[1] + [[-q[1], q[0]]]))
        assert wrong.status == "failed" and wrong.hint == "The derivative."


def direction(x, y):
    """Return the angle of [x, y], and its distance."""
    return np.array([np.hypot(x, y), np.arctan2(y, x)])


def test_whole_turns_do_not_count_and_degrees_are_named():
    cases = lambda rng: [(3.0, 4.0), (-1.0, 0.0), (-1.0, -2.0)]
    exercise = asked(direction, "p", cases, "angle | p | any | Two numbers.", angles={"p": 1})
    assert exercise.judge(lambda x, y: direction(x, y) + [0, 6 * np.pi]).passed
    verdict = exercise.judge(lambda x, y: [np.hypot(x, y), np.degrees(np.arctan2(y, x))])
    assert "degrees" in verdict.message


def test_truth_values_of_one_number_may_have_any_type():
    def large(x):
        """Return whether x is large."""
        return x[0] > 1

    cases = lambda rng: [(np.array([v]),) for v in (0.0, 2.0)]
    exercise = asked(large, "flag", cases, "flag | flag | any | One truth value.")
    assert exercise.judge(lambda x: bool(x[0] > 1)).passed and exercise.judge(lambda x: int(x[0] > 1)).passed
    assert "shape (1,)" in exercise.judge(lambda x: x > 1).message


def test_a_name_with_a_colon_ends_in_two():
    (found,) = edits.blocks("U_p: not divided :: d(x/z)/dx is 1/z.\n    / z -> * 1")
    assert found == ("U_p: not divided", "d(x/z)/dx is 1/z.", [("/ z", "* 1")])


def test_small_numbers_are_shown_and_rounding_is_not():
    U = np.diag([4e-4, 1e-4, 1.234e-4])
    U[0, 1] = 1e-19
    assert at(["U"], [U]) == "U = [[0.0004, 0, 0], [0, 0.0001, 0], [0, 0, 0.000123]]"
    assert at(["x"], [np.array([1.0, 0.5, 1e-9])]) == "x = [1. , 0.5, 0. ]"
