"""What a student sees: check, hint, reveal, progress; and a check that nothing can hang, flood or break."""

import inspect
import itertools
import json
import re
import subprocess
import sys
import threading

import numpy as np
import pytest

from ekfslam_tutorial.course import (
    audit,
    check,
    checks,
    deadline,
    expect,
    guard,
    hint,
    logbook,
    progress,
    registry,
    reveal,
    told,
)
from ekfslam_tutorial.course.diagnose import diagnose
from ekfslam_tutorial.course.exercise import Verdict
from ekfslam_tutorial.course.exercises.nb02_q import q
from ekfslam_tutorial.geometry import wrap


def own(y, x_r):
    """A student's right answer."""
    return q(y, x_r)


# --- the messages ---


def test_a_passed_answer_is_handed_back(capsys):
    def mine(y, x_r):
        return q(y, x_r)

    assert inspect.unwrap(check("02.3", mine)) is mine
    assert capsys.readouterr().out == "[02.3] passed\n"


def test_what_passed_gives_arrays_and_may_be_checked_again(capsys):
    def mine(y, x_r):
        l, L_y = q(y, x_r)
        return l.tolist(), [list(row) for row in L_y]

    for _ in range(2):
        mine = check("02.3", mine)
        l, L_y = mine(np.array([1.0, 0.2]), np.zeros(3))
        assert l.shape == (2,) and L_y.shape == (2, 2)
    assert capsys.readouterr().out == 2 * "[02.3] passed\n" and logbook.read()["02.3"]["tries"] == 2


def test_arrays_are_made_where_the_solution_gives_arrays(capsys):
    from ekfslam_tutorial.course.exercises.nb05_frame import slam_frame

    def mine(*args):
        x, P, ids = slam_frame(*args)
        return x.tolist(), P.tolist(), ids

    x, P, ids = check("05.5", mine)(np.zeros(3), np.eye(3), [], np.zeros(3), np.eye(3), [7], [[1.0, 0.0]], np.eye(2))
    assert x.shape == (5,) and P.shape == (5, 5) and ids == [7]


@pytest.mark.parametrize("exercise", [e for e in registry.everything() if e.misconceptions], ids=lambda e: e.id)
@pytest.mark.parametrize("before", ["wrong", "none", "syntax error"])
def test_the_reference_is_never_judged_and_never_counted(exercise, before, capsys):
    # A notebook: the exercise cell and, twice, the check cell `f = check(id, f)`.
    answer = {"wrong": exercise.misconceptions[0].answer, "none": None, "syntax error": None}[before]
    f = check(exercise.id, answer)
    tries = logbook.read().get(exercise.id, logbook.EMPTY)["tries"]
    capsys.readouterr()
    for _ in range(2):
        f = check(exercise.id, f)
        assert " ".join(capsys.readouterr().out.split()).startswith(f"[{exercise.id}] not judged: `{exercise.name}`")
    record = logbook.read().get(exercise.id, logbook.EMPTY)
    assert record["passed"] is None and record["tries"] == tries == (before == "wrong")


def test_a_missing_answer_gives_the_reference(capsys):
    def stub(y, x_r):
        raise NotImplementedError

    assert check("02.3", stub) is q
    assert check("02.3") is q
    line = "[02.3] not attempted yet: the reference solution is used below.\n"
    assert capsys.readouterr().out == 2 * line
    assert not logbook.read()


def test_a_wrong_answer_is_told_what_is_wrong_and_gives_the_reference(capsys):
    def mine(y, x_r):
        print("my own debugging")
        l, L_y = q(y, x_r)
        return l, L_y.T

    assert check("02.3", mine) is q
    out = capsys.readouterr().out
    assert out.startswith("[02.3] failed 'derivative': L_y[0, 1] = d(x_l)/d(bearing) is")
    assert "transpose" in out and 'hint("02.3")' in out and "reference solution is used below" in out
    assert out.count("my own debugging") <= 5
    assert max(len(line) for line in out.splitlines()) <= 110


def test_an_exception_shows_the_line(capsys):
    def mine(y, x_r):
        r, beta = y
        angle = beta + theta_of_the_robot  # noqa: F821
        return r * angle

    check("02.3", mine)
    out = " ".join(capsys.readouterr().out.split())
    assert "NameError: name 'theta_of_the_robot' is not defined, in line 3: `angle = beta + theta_of_the_robot" in out
    assert "Is the name spelt" in out


def test_an_exception_in_a_helper_shows_the_line_of_the_helper(capsys):
    def helper(y):
        return y.no_such_thing

    check("02.3", lambda y, x_r: helper(y))
    assert "in `helper`: `return y.no_such_thing`" in " ".join(capsys.readouterr().out.split())


def test_not_implemented_later_on_is_a_failure():
    def only_ahead(y, x_r):
        if x_r[2] != 0:
            raise NotImplementedError("turned robots")
        return q(y, x_r)

    calls = []

    def after_two(y, x_r):
        calls.append(1)
        if len(calls) > 2:
            raise NotImplementedError
        return q(y, x_r)

    assert registry.get("02.3").judge(only_ahead).status == "not attempted"  # the first call is a turned robot
    assert "NotImplementedError" in registry.get("02.3").judge(after_two).message


@pytest.mark.parametrize(
    "id, near", [("02.33", "'02.3'"), ("02.", "'02."), ("2.3", "'02.3'"), (2.3, "a text such as"), ("", "'00.1'")]
)
def test_an_unknown_id_names_the_nearest(id, near):
    with pytest.raises(ValueError, match=re.escape(near)):
        check(id, None)


def test_hints_come_one_by_one_and_then_the_solution(capsys):
    for level in (1, 2, 3, 3):
        hint("02.3")
        assert f"hint {level} of 3" in capsys.readouterr().out
    hint("02.3", 1)
    assert "hint 1 of 3" in capsys.readouterr().out
    with pytest.raises(ValueError, match="hints 1 to 3, got 4"):
        hint("02.3", 4)
    reveal("02.3")
    out = capsys.readouterr().out
    space = {"np": np}
    exec(out, space)
    assert registry.get("02.3").judge(space["q"]).passed
    assert logbook.read()["02.3"]["hints"] == 3 and logbook.read()["02.3"]["revealed"]


def test_progress_counts(capsys):
    check("02.3", own)
    check("02.2", lambda x, i, x_r: None)
    capsys.readouterr()
    progress("02")
    out = capsys.readouterr().out
    assert out.startswith("1 of 7 exercises passed")
    assert re.search(r"02\.3 +passed \d{4}-\d\d-\d\d", out) and re.search(r"02\.2 +tried once", out)
    assert re.search(r"02\.1 +not attempted", out)
    check("02.3", lambda y, x_r: None)  # once passed stays passed
    progress("02")
    assert "1 of 7" in capsys.readouterr().out
    with pytest.raises(ValueError, match="no exercises of a notebook '99'"):
        progress("99")


# --- the file ---


@pytest.mark.parametrize("content", ["", "{", "[]", '{"02.3": 7}', '{"02.3": {"tries": 1}}', "\x00\xff"])
def test_a_damaged_file_costs_nothing(own_progress, content):
    own_progress.write_text(content, encoding="utf-8")
    check("02.3", own)
    assert logbook.read()["02.3"]["passed"]


def test_a_folder_that_cannot_be_written_costs_nothing(tmp_path, monkeypatch, capsys):
    blocked = tmp_path / "file"
    blocked.write_text("not a folder")
    monkeypatch.setenv(logbook.VARIABLE, str(blocked / "progress.json"))
    assert inspect.unwrap(check("02.3", own)) is own
    assert "passed" in capsys.readouterr().out


def test_the_file_is_replaced_in_one_step(own_progress, monkeypatch):
    check("02.3", own)
    before = own_progress.read_text()

    def broken(*args):
        raise OSError("disk full")

    monkeypatch.setattr(logbook.os, "replace", broken)
    check("02.2", lambda x, i, x_r: None)
    assert own_progress.read_text() == before
    kept = {path.name for path in own_progress.parent.glob(f"*{own_progress.stem}*")}
    assert kept == {own_progress.name, logbook.backup().name}  # no part
    json.loads(before)


def test_the_home_folder_is_the_default(monkeypatch, tmp_path):
    monkeypatch.delenv(logbook.VARIABLE)
    monkeypatch.setattr(logbook.Path, "home", lambda: tmp_path)
    assert logbook.path() == tmp_path / ".ekfslam" / "progress.json"


# --- time-outs ---


@pytest.fixture
def patience(monkeypatch):
    """The limit for students, and how long each wait for a thread was asked to be (s)."""
    monkeypatch.delenv("EKFSLAM_CHECK_SECONDS")
    monkeypatch.setattr(deadline, "_kept_waiting", lambda *_: False)  # as on a quiet computer
    asked, join = [], threading.Thread.join
    monkeypatch.setattr(threading.Thread, "join", lambda self, s=None: (asked.append(s), join(self, s))[1])
    return asked


@pytest.fixture
def all_end():
    """At the end, no thread of the test runs any more: each is waited for as long as it takes."""
    before = threading.enumerate()
    yield
    for thread in threading.enumerate():
        if thread not in before:
            threading.Thread.join(thread)


def forever(*args):
    while True:
        pass


def prints_forever(*args):
    while True:
        print("x" * 1000)


@pytest.mark.parametrize("answer", [forever, prints_forever])
def test_an_endless_loop_is_stopped(answer, capsys, patience, all_end):
    assert check("02.3", answer) is q
    assert patience[0] == 1.5 and sum(patience) < 2.0  # 0.3 s to stop it
    out = capsys.readouterr().out
    assert "took more than 1.5 s" in out and "loop that does not end" in out and len(out) < 1000


def test_on_a_busy_computer_seconds_of_the_processor_count(monkeypatch):
    """A third of the processor: three times as long. A thread that sleeps is not waited for, and none for ever."""

    def for_how_long(share, seconds=2.0):
        monkeypatch.setattr(deadline, "_at_work", lambda clock: share * passed)
        passed = seconds
        while deadline._kept_waiting(None, seconds, passed):
            passed += seconds / 5
        return passed / seconds

    assert for_how_long(1.0) == 1 and for_how_long(1 / 3) == pytest.approx(3) and for_how_long(0.02) == 1
    assert for_how_long(0.15) == pytest.approx(deadline.BUSY)


def test_a_thread_that_sleeps_is_not_at_work():
    begun, awake, clock = threading.Event(), threading.Event(), []
    thread = threading.Thread(target=lambda: (clock.append(deadline._clock()), begun.set(), awake.wait()))
    thread.start()
    begun.wait()
    assert 0 <= deadline._at_work(clock[0]) < 0.1
    awake.set()
    thread.join()
    assert deadline._at_work(clock[0]) >= 0  # a thread that has ended, too


STUBBORN = """
from ekfslam_tutorial.course import check

def mine(y, x_r):
    while True:
        try:
            print("x" * 1000)
        except:
            pass

check("02.3", mine)
print("the notebook goes on")
"""


def test_a_loop_that_catches_everything_does_not_hold_the_notebook(patience):
    # In a process of its own: where such a loop cannot be stopped, it stays as a silent thread until the end.
    run = subprocess.run([sys.executable, "-c", STUBBORN], capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr[-2000:]
    assert run.stdout.startswith("[02.3] failed") and run.stdout.endswith("the notebook goes on\n")
    assert len(run.stdout) < 1000 and len(run.stderr) < 1000


def test_a_sleeping_answer_does_not_hold_the_notebook(monkeypatch, capsys, all_end):
    """The check comes back while the answer still waits, for something that comes only afterwards."""
    awake = threading.Event()
    monkeypatch.setenv("EKFSLAM_CHECK_SECONDS", "0.2")
    check("02.3", lambda y, x_r: awake.wait())
    assert "took more than 0.2 s" in capsys.readouterr().out
    print("the notebook goes on printing")
    assert capsys.readouterr().out == "the notebook goes on printing\n"
    awake.set()


def test_a_limit_that_is_no_number_is_named(monkeypatch):
    monkeypatch.setenv("EKFSLAM_CHECK_SECONDS", "soon")
    with pytest.raises(ValueError, match="EKFSLAM_CHECK_SECONDS must be a number of seconds, got 'soon'"):
        check("02.3", lambda y, x_r: y)


def test_an_endless_recursion_is_an_error(capsys):
    def deep(y, x_r):
        return deep(y, x_r)

    check("02.3", deep)
    assert "RecursionError" in capsys.readouterr().out


def test_prints_are_bounded_and_standard_output_is_given_back(capsys):
    before = sys.stdout, sys.stderr
    value, printed = deadline.run(lambda: [print("x" * 100) for _ in range(10_000)] and 7, 200)
    assert value == 7 and len(printed) == 2000
    with pytest.raises(deadline.TookTooLong):
        deadline.run(forever, 0.1)
    with pytest.raises(ZeroDivisionError):
        deadline.run(lambda: 1 / 0, 200)
    assert (sys.stdout, sys.stderr) == before
    assert capsys.readouterr().out == ""


def test_without_threads_a_check_still_works(monkeypatch, capsys):
    def none(self):
        raise RuntimeError("can't start new thread")

    monkeypatch.setattr(threading.Thread, "start", none)
    check("02.3", own)
    assert capsys.readouterr().out == "[02.3] passed\n"


@pytest.mark.skipif(sys.version_info < (3, 12), reason="Python looks at itself from 3.12 on")
def test_without_threads_a_loop_is_stopped_by_a_look_at_the_clock(monkeypatch):
    def none(self):
        raise RuntimeError("can't start new thread")

    def stubborn():
        while True:
            try:
                pass
            except:  # noqa: E722
                pass

    monkeypatch.setattr(threading.Thread, "start", none)
    for job in (stubborn, lambda: [i for i in itertools.count()]):
        with pytest.raises(deadline.TookTooLong):
            deadline.run(job, 0.1)
    assert deadline.run(lambda: sum(i for i in range(1000)), 200) == (499500, "")
    assert sys.monitoring.get_tool(deadline._TOOL) is None


# --- comparing results ---


@pytest.mark.parametrize(
    "a, b, same",
    [
        ([1, 2], np.array([1.0, 2.0]), True),
        ([[1], [2]], [1, 2], False),
        ((1, [2, 3]), (1, [2, 3]), True),
        ({"a": np.eye(2)}, {"a": np.eye(2)}, True),
        ({"a": 1}, {"b": 1}, False),
        (None, 0, False),
        ("a", "a", True),
        (np.nan, np.nan, True),
        (registry.get("02.3"), registry.get("02.3"), True),
        (1j, 1j, True),
    ],
)
def test_equal(a, b, same):
    assert guard.equal(a, b) is same


def test_a_list_that_holds_itself_is_no_array():
    """Numpy would make one of more and more entries, until the memory is full."""
    ids = [1, 2]
    ids += [ids, ids]
    assert guard.numbers(ids) is None
    assert guard.numbers([[[1.0]]]).shape == (1, 1, 1)


def test_a_report_without_a_hint_has_no_empty_line():
    verdict = checks.Verdict("failed", "link", "message")
    assert "\n\n" not in checks.report(registry.get("02.3"), verdict)


def test_a_large_number_is_not_off_by_whole_turns():
    want = np.array([[0.3, 0.1], [0.1, 0.2]])
    assert "turns" not in diagnose(1e6 * np.eye(2), want)
    assert "whole turns" in diagnose(want + 2 * np.pi, want)


def test_a_length_that_was_wrapped_is_not_to_be_wrapped():
    advice, other = "wrap the angle", "only an angle is wrapped"
    for got, want in (([4 - 2 * np.pi, 0.2], [4, 0.2]), (5 - 2 * np.pi, 5.0)):
        assert other in diagnose(got, want) and advice not in diagnose(got, want)
    assert advice in diagnose([4, 0.2 - 2 * np.pi], [4, 0.2])
    both = diagnose([4 - 2 * np.pi, 0.2 - 2 * np.pi], [4, 0.2])
    assert other not in both and advice not in both


@pytest.mark.parametrize("id", ["01.3", "05.1", "05.3"])
def test_a_state_that_was_wrapped_is_not_to_be_wrapped(id):
    def mine(*args):
        result = registry.get(id).solution(*args)
        return (wrap(result[0]), *result[1:]) if isinstance(result, tuple) else wrap(result)

    message = registry.get(id).judge(mine).message
    assert "only an angle is wrapped" in message and "wrap the angle" not in message


@pytest.mark.parametrize("order", [lambda rows: np.sort(rows, axis=0), lambda rows: rows[np.lexsort(rows.T[::-1])]])
def test_small_numbers_beside_a_time_stamp_have_not_lost_their_decimals(order):
    def mine(rows):
        return order(rows), *registry.get("09.1").solution(rows)[1:]

    message = registry.get("09.1").judge(mine).message
    assert "rows" in message and "decimals" not in message


def test_slips_beside_a_time_stamp_are_those_of_each_entry():
    want = np.array([[1.25e9, 0.26, 5.67], [1.25e9 + 1.5, -0.77, 4.23]])
    assert "lost its decimals" in diagnose(want.round(), want, 1e-11)
    assert "lost its decimals" in diagnose([3, -2], [3.4, -2.2])
    assert "decimals" not in diagnose([0, 0, 1], [0, 0, 0.7071])  # one small number is near a whole one by chance
    assert "rounded to 1" in diagnose(want.round(1), want, 1e-11)
    assert diagnose(want + [0, 0.3, 0], want, 1e-11) == "Wrong at [0, 1], [1, 1] only."


def test_two_numbers_that_differ_are_shown_so():
    """The numbers of a message differ, however near they are; else they have few digits."""
    with pytest.raises(expect.Failed, match=r"^e is \[0\.09996, .*it should be \[0\.1, "):
        expect.close([2 * np.sin(0.05), 0, 0], [0.1, 0, 0], "e")
    with pytest.raises(expect.Failed, match=r"^e is 0\.3, it should be 0\.3000003\."):
        expect.close(0.3, 0.3 + 3e-7, "e", 1e-9)
    with pytest.raises(expect.Failed, match=r"^e is 2, it should be 2\.000003\."):
        expect.angle(2.0, 2.0 + 3e-6, "e")
    with pytest.raises(expect.Failed, match=r"^J\[0, 0\] is 2\.0001, finite differences give 2\."):
        expect.jacobian(np.array([[2.0001]]), lambda x: 2 * x, np.ones(1), "J")
    with pytest.raises(expect.Failed, match=r"is not symmetric: \[0, 1\] is 0\.10001, \[1, 0\] is 0\.1$"):
        expect.symmetric(np.array([[1, 0.10001], [0.1, 1]]), "P")
    with pytest.raises(expect.Failed, match=r"e is \[0\.1235, 0\. +\], it should be \[0\.2, 0\. +\]"):
        expect.close([0.123456789, 0], [0.2, 0], "e")


@pytest.mark.parametrize(
    ("answer", "advice"),
    [(lambda y, x_r: np.ones(2) + np.ones(3)[3:], "starts at 0"), (lambda y, x_r: (y, x_r).sum(), "several results")],
)
def test_slips_of_everybody_are_explained(capsys, answer, advice):
    check("02.3", answer)
    assert advice in " ".join(capsys.readouterr().out.split())


def test_a_message_that_asks_ends_in_one_mark():
    said = checks.report(registry.get("02.3"), Verdict("failed", "shape", "is it the transpose?"))
    assert "is it the transpose?\n" in said


def test_audit_of_exercises_that_there_are_not(capsys):
    assert audit.main(["99", "02"]) == 2
    assert "no exercises of notebook 99; there are 00, 01, 02" in capsys.readouterr().err


# --- what a slip sentence knows of what is compared ---


def test_only_a_covariance_is_told_of_variances_and_of_counting_twice():
    P = np.array([[0.25, 0.02], [0.02, 0.16]])
    assert "twice?" in diagnose(P / 2, P) and "variances" in diagnose(np.sqrt(P), P)
    for number in (np.array(3.7), np.array([3.7, 1.2])):
        assert diagnose(number / 2, number) == "Yours is exactly half."
        assert diagnose(np.sqrt(number), number) == "Yours is the square root."


def test_a_covariance_that_is_not_symmetric_is_told():
    P = np.array([[0.25, 0.02, 0.01], [0.02, 0.16, 0.03], [0.01, 0.03, 0.09]])
    assert "not symmetric" in diagnose(P + np.triu(0.1 * P, 1), P)
    assert diagnose(P * [[1, 1, 1], [0, 1, 1], [1, 1, 1]], P) == "Missing (zero) at [1, 0]."
    assert "symmetric" not in diagnose(np.array([[1.0, 0.2], [0, 1.0]]), np.eye(2))  # may be any matrix


def test_a_number_that_is_zero_is_not_told_twice():
    assert diagnose(0.0, -0.2) == "" and diagnose([0.0, 0.0], [1.0, 2.0]) == "Yours is zero."


def test_a_whole_turn_without_brackets_is_told():
    angles = np.array([0.4, 2.0, -3.5, 9.0])
    slipped = (angles + np.pi) % 2 * np.pi - np.pi
    assert "brackets" in diagnose(slipped, wrap(angles))
    assert "brackets" in diagnose(slipped[2], wrap(angles[2]))
    assert "brackets" in diagnose([4.2, slipped[3]], [4.2, wrap(angles[3])])
    assert "brackets" not in diagnose([4.2, 0.7], [4.2, wrap(angles[3])])


def test_one_entry_in_degrees_is_told():
    assert "In degrees at [1]" in diagnose([4.0, np.degrees(0.3)], [4.0, 0.3])


def test_an_exception_does_not_hide_what_is_tested():
    def far(y, x_r):
        return q(y, x_r) if y[0] < 20 else q(y, x_r[:2])

    link = registry.get("02.3").links[-1]
    verdict = registry.get("02.3").judge(far)
    assert verdict.link == link.name and "raised IndexError" in verdict.message
    assert verdict.hint.endswith(f"What is tested here: {link.help}")


@pytest.mark.parametrize(
    "given, advice",
    [
        ([np.eye(2)], "[item.copy() for item in F]"),
        ([1, 2], "list(F)"),
        (np.eye(2), "np.array(F, dtype=float)"),
        (np.array([1, 2]), "np.array(F)"),
    ],
)
def test_how_to_copy_depends_on_what_it_is(given, advice):
    def spoil(F):
        F[0] = F[0] + 1
        return F

    with pytest.raises(expect.Failed) as failed:
        guard.Guarded(spoil, names=("F",))(given)
    assert advice in failed.value.hint


# --- at a glance ---


class Kernel:
    """A shell that is not a terminal's."""


@pytest.mark.parametrize(("passed", "mark", "line"), [(True, "✓", "solid"), (False, "✗", "dashed")])
def test_in_a_notebook_a_verdict_has_colour_and_shape_beside_its_words(passed, mark, line, monkeypatch, capsys):
    shown = []
    monkeypatch.setattr(told, "get_ipython", Kernel)
    monkeypatch.setattr(told, "display", lambda data, raw: shown.append(data))
    told.tell(passed, "[02.3] a <b>\n    second line")
    assert shown[0]["text/plain"] == "[02.3] a <b>\n    second line" and capsys.readouterr().out == ""
    page = shown[0]["text/html"]
    assert mark in page and f"6px {line} #" in page and "[02.3] a &lt;b&gt;\n    second line" in page


def test_pass_and_fail_differ_in_all_that_is_seen():
    one, other = told.LOOK[True], told.LOOK[False]
    assert all(a != b for a, b in zip(one, other, strict=True))


def test_a_verdict_of_check_is_shown_so(monkeypatch):
    seen = []
    monkeypatch.setattr(checks, "tell", lambda passed, text: seen.append((passed, text)))
    check("02.3", own)
    check("02.3", lambda *_: None)
    assert [passed for passed, _ in seen] == [True, False] and seen[0][1] == "[02.3] passed"


def test_on_a_terminal_it_is_coloured_unless_that_is_not_wanted(monkeypatch, capsys):
    monkeypatch.setattr(told.sys.stdout, "isatty", lambda: True, raising=False)
    monkeypatch.delenv("NO_COLOR", raising=False)
    told.tell(False, "[02.3] failed\n    more")
    assert capsys.readouterr().out == "\x1b[1;33m✗ [02.3] failed\x1b[0m\n    more\n"
    monkeypatch.setenv("NO_COLOR", "1")
    told.tell(True, "[02.3] passed")
    assert capsys.readouterr().out == "[02.3] passed\n"
