"""What a hint says is true by itself: what it tells to belong stands in the solution, at the place that it names."""

import inspect
import linecache
import time

import numpy as np
import pytest

from ekfslam_tutorial.course import expect, own_words, pairs, registry
from ekfslam_tutorial.course.diagnose import diagnose
from ekfslam_tutorial.course.exercise import Exercise


def of(id) -> Exercise:
    exercise = registry.get(id)
    assert isinstance(exercise, Exercise)
    return exercise


def answer(id, *places):
    """The solution with some places written otherwise, as from a cell whose text can be read."""
    solution = of(id).solution
    text = inspect.getsource(solution)
    for old, new in places:
        assert text.count(old) == 1, f"{old!r} stands {text.count(old)} times"
        text = text.replace(old, new)
    name, space = f"<cell {id} {len(linecache.cache)}>", dict(solution.__globals__)
    linecache.cache[name] = len(text), None, text.splitlines(keepends=True), name
    exec(compile(text, name, "exec"), space)
    return space[solution.__name__]


@pytest.mark.parametrize(
    ("id", "told", "places"),
    [  # one mistake, which looks like a listed one with a slip in it
        ("01.2", "entries of the third column are exchanged", [("-d * s], [0, 1, d * c]", "d * c], [0, 1, -d * s]")]),
        ("04.1", "the sine stands in the row of x_l", [("-r * s], [0, 1, r * c]", "r * c], [0, 1, -r * s]")]),
        ("09.3", "No ideal value is asked for", [("np.argmin(nis)", "np.argmin(np.abs(nis - 1))")]),
        ("05.2", "Angles are in radians", [("wrap(np.arctan2", "np.degrees(np.arctan2")]),
    ],
)  # fmt: skip
def test_a_slip_within_a_mistake_is_no_second_one(id, told, places):
    hint = of(id).judge(answer(id, *places)).hint
    assert told in hint and "Two things" not in hint and "stood where" not in hint, hint


def test_of_two_mistakes_each_is_told_as_it_is():
    """theta - beta, and a sign in L_r: not the same mistake told twice."""
    verdict = of("04.1").judge(answer("04.1", ("x_r[2] + y[1]", "x_r[2] - y[1]"), ("0, -r * s", "0, r * s")))
    first, then = verdict.hint.split(" Then: ")
    assert "`x_r[2] - y[1]` stood where `x_r[2] + y[1]` belongs, in `a`" in first and "L_r has a minus sign" in then


def test_a_block_is_named_by_its_place():
    """H holds the same block twice; the one of the robot is wrong."""
    wrong = "-np.array([[dx / r, dy / r], [-dy / r2, 2 * dx / r2]]), [0, -1], E_l"
    hint = of("05.2").judge(answer("05.2", ("-E_l, [0, -1], E_l", wrong))).hint
    assert "in `-E_l`, in `H[:, :2]`" in hint, hint


def test_a_small_expression_is_told_with_its_line():
    """The same product stands, right, in another line of the student's."""
    hint = of("05.1").judge(answer("05.1", ("c * u[0] - s * u[1]", "c * u[0] + s * u[1]"))).hint
    assert "X_x" in hint or "[1, 2]" in hint, hint


def test_a_pair_of_slips_at_one_place_is_none():
    exercise = of("04.1")
    some = [pairs.Change(slip) for slip in exercise.slips() if slip.quoted and "`x_r[2] " in slip.hint][:6]
    at = [change.hunks[0][:2] for change in some]
    crossed = [(a, b) for a, (s, e) in zip(some, at, strict=True) for b, (t, f) in zip(some, at, strict=True)
               if a is not b and s < f and t < e]  # fmt: skip
    assert crossed and not any(pairs._merged(*pair) for pair in crossed)


# ---- what the student has written -----------------------------------------------------------------------


def test_formulas_are_compared_without_names_brackets_and_order():
    def one(a, b):
        d = b - a
        return np.cos(2 * d) * a

    def other(a, b):
        return a * np.cos((-a + b) * 2)

    returned = [[k for k in own_words.formulas(f) or () if k.startswith("Return")] for f in (one, other)]
    assert len(returned[0]) == 1 and returned[0] == returned[1]


def test_what_the_student_has_written_already_is_not_asked_for():
    exercise = of("05.2")
    slip = next(s for s in exercise.slips() if "`np.arctan2(dx, dy)` stood where" in s.hint)
    right, wrong = answer("05.2"), answer("05.2", ("np.arctan2(dy, dx)", "np.arctan2(dx, dy)"))
    assert own_words.doubtful(slip, own_words.formulas(right))
    assert not own_words.doubtful(slip, own_words.formulas(wrong))
    assert not own_words.doubtful(slip, own_words.formulas(eval("lambda x, l: None")))


# ---- an index, None, True ----------------------------------------------------------------------------------


@pytest.fixture
def without(monkeypatch):
    """Take a mistake off the list."""

    def taken_off(exercise, name):
        others = [mistake for mistake in exercise.misconceptions if mistake.name != name]
        assert len(others) < len(exercise.misconceptions)
        monkeypatch.setattr(exercise, "misconceptions", others)
        pairs.changes.cache_clear()

    yield taken_off
    pairs.changes.cache_clear()


def test_a_slip_that_shows_in_an_index_only_is_not_told_beside_another_mistake(without):
    """A root too many; and a gate that is a bit too narrow, as by many a slip."""
    exercise, narrow = of("07.1"), ("np.shape(zs)[1])", "np.shape(zs)[1] - 1)")
    both = answer("07.1", narrow, ("else None), d2", "else None), np.sqrt(d2)"))
    assert "m degrees of freedom, not m - 1" in exercise.judge(both).hint
    without(exercise, "one degree of freedom less")
    hint = exercise.judge(both).hint
    assert "A root too many" in hint and "Two things" not in hint, hint


def test_of_several_slips_with_the_same_truth_values_none_is_told(without):
    """The length of [x/z, y/z, 1] is beyond the fold where that of several other vectors is."""
    exercise, whole = of("12.3"), answer("12.3", ("np.linalg.norm(p[:, :2]", "np.linalg.norm(p"))
    assert exercise.judge(whole).misconception
    without(exercise, "length of the whole vector")
    verdict = exercise.judge(whole)
    assert verdict.status == "failed" and not verdict.misconception and "stood where" not in verdict.hint, verdict.hint


# ---- numbers ----------------------------------------------------------------------------------------------


def test_degrees_are_told_by_57_3_and_not_by_60_however_small():
    small = 3e-8 * np.eye(2)
    assert "degrees" in diagnose(small * np.radians(1), small)
    assert "degrees" not in diagnose(small / 60, small) + diagnose(small / 60**2, small)


def test_small_numbers_are_shown_by_the_digits_that_count():
    with pytest.raises(expect.Failed, match=r"U is \[8e-12, 0\], it should be \[3e-08, 0\]"):
        expect.close([8e-12, 0], [3e-8, 0], "U", rtol=1e-6, atol=0)


@pytest.mark.filterwarnings("error")
def test_division_by_one_less_is_named_though_one_run_gives_infinity(recwarn):
    over = lambda e, P, c: (np.divide(np.sum(right(e, P, c)[0] * len(e)), len(e) - 1), right(e, P, c)[1])
    right = of("03.2").solution
    verdict = of("03.2").judge(over)
    assert "divide the sum by N, not by N - 1" in verdict.hint and not recwarn.list


@pytest.mark.filterwarnings("error")
def test_no_warning_of_a_tried_mistake_reaches_the_student():
    middle = answer("01.2", ("np.cos(x[2])", "np.cos(x[2] + u[1] * dt / 2)"), ("np.sin(x[2])", "np.sin(x[2] + 1)"))
    assert of("01.2").judge(middle).status == "failed"


def test_what_is_found_does_not_depend_on_the_clock(monkeypatch):
    """Two mistakes; then on a computer on which all takes the processor three times as long."""
    exercise = of("02.4")

    def both(x, P, y, x_r, R):
        x_new, P_new = exercise.solution(x, P, y, x_r, R @ R)
        turn = np.array([[-1, 0], [0, 1]])
        return x_new, np.block([[P_new[:-2, :-2], P_new[:-2, -2:]], [P_new[-2:, :-2], turn @ P_new[-2:, -2:] @ turn]])

    told, now = exercise.judge(both).hint, time.process_time
    monkeypatch.setattr(time, "process_time", lambda: 3 * now())
    assert exercise.judge(both).hint == told and told.startswith("Two things")


def test_who_calls_a_function_rightly_is_not_sent_into_it():
    """`q` is right and its result is spoilt; then q is written anew, and wrong."""
    called = answer("02.4", ("l, L_y = q(y, x_r)", "l, L_y = q(y, x_r); l = l - x_r[:2]"))
    anew = answer("02.4", ("l, L_y = q(y, x_r)", "a = y[1] + x_r[2]; c, s = np.cos(a), np.sin(a); "
                           "l, L_y = y[0] * np.array([c, s]), np.array([[c, -y[0] * s], [s, y[0] * c]])"))  # fmt: skip
    hints = [of("02.4").judge(f).hint for f in (called, anew)]
    assert hints[0].startswith("What you make of `q` comes out as if there were a mistake in it: That is the landmark")
    assert hints[1].startswith("As in `q`. That is the landmark as seen from the robot")


def test_two_mistakes_are_found_beside_results_of_which_several_forms_are_right():
    """The yaw of q is free in 23.4, so its results are compared in a form of their own."""
    wrong = answer("23.4", ("w.mean(0)", "-w.mean(0)"), ("acc_bias_std / 9.81", "acc_bias_std"))
    hint = of("23.4").judge(wrong).hint
    assert "the bias is what is measured" in hint and "the angle is b / 9.81" in hint, hint


def test_a_listed_mistake_in_another_form_comes_before_a_step_that_is_as_if_it_were_another():
    """P - K H P with Z for its inverse: as if Z were the inverse of H P H' + R, which nobody has written."""
    text = ("P - K @ Z @ K.T", "P - K @ H @ P"), ("np.linalg.inv(Z)", "Z")
    assert "a large uncertainty of the innovation makes a small gain" in of("01.4").judge(answer("01.4", *text)).hint


def test_a_line_that_stands_as_in_the_solution_is_not_the_wrong_one():
    """[[I, 0], [D_n, D_v]] is right. D_n is not, and J' P J is not: both together look like another order of blocks."""
    both = answer("22.4", ("np.outer(n, v - 2 * s * n)", "np.outer(v - 2 * s * n, n)"), ("J @ P @ J.T", "J.T @ P @ J"))
    assert of("22.4").judge(both).misconception == "J' P J + outer product turned round"
