"""An exercise as a table: what its lines mean, and that a line that means nothing is an error at once."""

import numpy as np
import pytest

from ekfslam_tutorial.course import edits
from ekfslam_tutorial.course.table import rows, table


def scaled(x, a):
    """Return a x, its Jacobian, and which entry is the largest."""
    y = a * x
    return y, a * np.eye(len(x)), int(np.argmax(y))


def made(checks, wrong="forgets a | a * x -> x | The factor a has no effect.", **options):
    return table(
        "99.1 Scaling",
        scaled,
        hints=("Look at the units of x and y.", "Every entry is multiplied.", "y = a * x, and so on."),
        returns="y, Y_x, i",
        jacobians={"Y_x": "y"},
        cases={"any": lambda rng: [(rng.normal(size=3), a) for a in (2.0, -0.5)]},
        checks=checks,
        wrong=wrong,
        **options,
    )


ALL = """
size  | y            | any | Is every entry multiplied?
slope | d Y_x[0] / x | any | The derivative is the factor.
both  | Y_x[:, 1], i | any | Rows are outputs.
"""


def test_a_line_about_several_results_is_a_link_for_each():
    assert [link.name for link in made(ALL).links] == ["the results", "size", "slope", "both", "both: i"]
    assert rows("a | P[:2, 3:], x | any | Why?") == [["a", "P[:2, 3:]", "any", "Why?"], ["a: x", "x", "any", "Why?"]]


def test_a_row_of_a_jacobian_is_compared_alone():
    second = lambda x, a: (a * x, np.diag([a, 7.0, a]), scaled(x, a)[2])
    assert made(ALL).judge(second).link == "both"
    first = lambda x, a: (a * x, np.diag([7.0, a, a]), scaled(x, a)[2])
    assert made(ALL).judge(first).link == "slope"


def test_messages_say_the_arguments_and_the_kind_of_a_result():
    index = made(ALL, kinds={"i": "an index counted from 0"}, shown=lambda x, a: f"a factor of {a:g}")
    verdict = index.judge(lambda x, a: (*scaled(x, a)[:2], np.int64(9)))
    assert verdict.link == "both: i"
    assert verdict.message.startswith("i (an index counted from 0) is 9 for a factor of 2, it should be ")


def sides(x, a):
    """Return the sign of each entry of x, and whether the first is above a."""
    return np.sign(x).astype(int), x[0] > a


def test_whole_numbers_and_truth_values_are_shown_as_such_and_no_slip_explains_them():
    """An index is no length with a sign, and False is not "zero"."""
    exercise = table(
        "99.2 Sides",
        sides,
        hints=("Look at the sign of x.", "One number for each entry.", "np.sign(x), and x[0] > a."),
        returns="side, above",
        cases={"any": lambda rng: [(np.array([2.0, -1.0, 0.0]), 0.999999)]},
        checks="side | side | any | Left or right?\nabove | above | any | Above a?",
        wrong="all to the right | np.sign(x) -> np.abs(np.sign(x)) | Some are on the left.",
    )
    for wrong, got, want in (
        (([-1, 1, 0], True), "side is [-1, 1, 0]", "should be [1, -1, 0]. The entries are in the wrong order"),
        (([0, 0, 0], True), "side is [0, 0, 0]", "should be [1, -1, 0]"),
        (([1, -1, 0], False), "above is False", "should be True"),
    ):
        message = f"{got} for x = [ 2., -1.,  0.], a = 0.999999, it {want}"
        assert exercise.judge(lambda x, a, wrong=wrong: wrong).message == message
    assert exercise.judge(lambda x, a: ([1.0, -1.0, 0.0], 1)).passed  # other types, the same numbers


def test_true_is_no_index():
    exercise = made("which | i | any | Look for the largest.")
    verdict = exercise.judge(lambda x, a: (*scaled(x, a)[:2], [False, True, 2][scaled(x, a)[2]]))
    assert verdict.status == "failed" and verdict.message.startswith("i is ")


def test_a_result_may_be_compared_more_roughly():
    near = lambda x, a: (a * x * (1 + 1e-4), *scaled(x, a)[1:])
    assert not made(ALL).judge(near).passed
    assert made(ALL, rtol={"y": 1e-3}).judge(near).passed


def test_a_wrong_answer_is_a_row_or_a_block_with_as_many_edits_as_it_needs():
    found = edits.blocks(
        """
        one    | a -> b        | The first.
        two    | x[a | b] -> x | The second.
            c -> d
        three: The third
        goes on.
            e -> f
        """
    )
    assert found == [
        ("one", "The first.", [("a", "b")]),
        ("two", "The second.", [("x[a | b]", "x"), ("c", "d")]),
        ("three", "The third goes on.", [("e", "f")]),
    ]


@pytest.mark.parametrize(
    "text, told",
    [
        ("one | a -> b -> c | Why?", "an edit is written `old -> new`, got 'a -> b -> c'"),
        ("one | a | Why?", "an edit is written `old -> new`, got 'a'"),
        ("one", "a wrong answer is written `name | edit | hint`"),
        ("one: Why?", "the wrong answer 'one' has no edit"),
    ],
)
def test_a_line_that_means_nothing_is_an_error(text, told):
    with pytest.raises(ValueError, match=".*") as error:
        edits.blocks(text)
    assert str(error.value).startswith(told)


def test_an_edit_must_match_one_place():
    with pytest.raises(ValueError, match="'a' stands . times in the solution; an edit needs one place"):
        made(ALL, "many | a -> b | Why?")
