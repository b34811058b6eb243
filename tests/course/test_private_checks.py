"""A lecturer's own checks: EKFSLAM_PRIVATE_CHECKS names a folder of modules of the same form."""

import pytest

from ekfslam_tutorial.course import check, registry
from ekfslam_tutorial.course.exercises.nb02_q import q

HIDDEN = '''
from ekfslam_tutorial.course import expect
from ekfslam_tutorial.course.exercise import Exercise
from ekfslam_tutorial.course.exercises.nb02_q import q

more = Exercise("02.3", "more of it", q, hints=())

@more.link("hidden", "look at far landmarks")
def _(f, rng):
    import numpy as np
    expect.close(expect.results(f(np.array([1e4, 0.0]), np.zeros(3)), "l", "L_y")[0], [1e4, 0], "l")

def twice(a):
    """Return 2 a."""
    return 2 * a

new = Exercise("02.90", "A new one", twice, hints=("a", "b", "c"))

@new.link("value", "double it")
def _(f, rng):
    expect.close(expect.array(f(3.0), (), "the result"), 6.0, "the result")
'''


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv(registry.PRIVATE, str(tmp_path))
    registry.forget()
    yield tmp_path
    registry.forget()


def test_hidden_links_and_new_exercises(folder, capsys):
    (folder / "nb02_exam.py").write_text(HIDDEN)
    near_only = lambda y, x_r: q(y, x_r) if y[0] < 100 else (q(y, x_r)[0] * 2, q(y, x_r)[1])
    check("02.3", near_only)
    assert "failed 'hidden'" in capsys.readouterr().out
    assert check("02.3", q) is q
    assert check("02.90", lambda a: a + a)(5) == 10
    assert "[02.90] passed" in capsys.readouterr().out
    assert [e.id for e in registry.everything()].count("02.3") == 1
    wrong = registry.get("02.3").misconceptions[0]
    assert registry.get("02.3").judge(wrong.answer).misconception == wrong.name


def test_without_the_folder_only_public_checks(capsys):
    near_only = lambda y, x_r: q(y, x_r) if y[0] < 100 else (q(y, x_r)[0] * 2, q(y, x_r)[1])
    check("02.3", near_only)
    assert capsys.readouterr().out == "[02.3] passed\n"


def test_a_broken_module_is_named(folder):
    (folder / "nb02_exam.py").write_text("import no_such_module_at_all")
    with pytest.raises(ValueError, match=r"nb02_exam.py failed: ModuleNotFoundError"):
        check("02.3", q)


def test_a_folder_that_is_not_there_is_named(folder, monkeypatch):
    monkeypatch.setenv(registry.PRIVATE, str(folder / "nowhere"))
    registry.forget()
    with pytest.raises(ValueError, match="which is not a folder"):
        check("02.3", q)
