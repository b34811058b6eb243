"""The changes that `make mutants` makes: each is one, compiles, and the import of a changed module is a changed one."""

import ast
import sys
from pathlib import Path

import pytest

TOOLS = Path(__file__).resolve().parents[2] / "tools"
sys.path.insert(0, str(TOOLS))
import mutants  # noqa: E402
import mutations  # noqa: E402

sys.path.remove(str(TOOLS))
TEXT = '''"""Words stay: 1 < 2."""
import math
LIMIT = 3


class Thing:
    size = 2

    def grow(self, by=1):
        """Return 1 + 1."""
        if by < LIMIT and not self.size:
            raise ValueError(f"at most {LIMIT}")
        self.size += by
        return [max(i, by) for i in range(2) if i]


def turn(P, x):
    """Turn."""
    return (P @ x).T - math.sin(0.5)
'''


def words():
    return {(m.function, m.what) for m in mutations.mutations(TEXT)}


def test_what_is_changed():
    found = words()
    for change in (
        ("", "3 -> 4"),
        ("Thing.grow", "by < LIMIT -> by <= LIMIT"),
        ("Thing.grow", "by < LIMIT -> by >= LIMIT"),
        ("Thing.grow", "by < LIMIT and (not self.size) -> by < LIMIT or not self.size"),
        ("Thing.grow", "not self.size -> self.size"),
        ("Thing.grow", "self.size += by -> self.size -= by"),
        ("Thing.grow", "self.size += by -> pass"),
        ("Thing.grow", "max -> min"),
        ("Thing.grow", "for i in range(2) if i -> for i in range(2)"),
        ("turn", "P @ x -> x @ P"),
        ("turn", "(P @ x).T -> P @ x"),
        ("turn", "math.sin -> math.cos"),
        ("turn", "0.5 -> 1.0"),
    ):
        assert change in {(f, w.strip()) for f, w in found}, (change, sorted(found))


def test_words_stay_and_each_change_is_one():
    """No docstring, no sentence of an error, no default in a signature; all compile, and no two are the same."""
    texts = [ast.unparse(mutations.mutated(TEXT, m.number)) for m in mutations.mutations(TEXT)]
    assert len(set(texts)) == len(texts) and ast.unparse(ast.parse(TEXT)) not in texts
    for text in texts:
        compile(text, "changed", "exec")
        assert "at most {LIMIT}" in text or "raise" not in text
        assert "1 < 2" in text and "by=1" in text and "Return 1 + 1" in text


def test_every_file_of_the_core_can_be_changed():
    n = 0
    for path in (file for folder in mutants.CORE for file in sorted((mutants.PACKAGE / folder).rglob("*.py"))):
        text = path.read_text(encoding="utf-8")
        found = mutations.mutations(text)
        n += len(found)
        for m in found[::40]:
            assert ast.dump(mutations.mutated(text, m.number)) != ast.dump(ast.parse(text)), (path, m)
    assert n > 1500


def test_each_change_that_makes_no_difference_is_one_that_can_be_made():
    """A line whose code has changed since is no excuse any more."""
    text = mutants.EQUIVALENT.read_text("utf-8")
    listed = mutants.equivalent(text)
    assert len(listed) == text.count("[[same]]") == text.count("why = ")
    for file in {file for file, *_ in listed}:
        mine = [entry for entry in listed if entry[0] == file]
        path = mutants.PACKAGE / file
        possible = mutants.different(path, set())
        assert all(len(possible) > len(mutants.different(path, {entry})) for entry in mine)


def test_a_changed_module_is_imported(tmp_path, monkeypatch):
    (tmp_path / "thing.py").write_text(TEXT)
    monkeypatch.setattr(mutants, "ROOT", tmp_path)
    number = next(m.number for m in mutations.mutations(TEXT) if m.what == "3 -> 4")
    monkeypatch.setattr(sys, "meta_path", [mutants.Changed(tmp_path / "thing.py", number), *sys.meta_path])
    import thing

    try:
        assert thing.LIMIT == 4 and thing.Thing.grow.__code__.co_filename == str(tmp_path / "thing.py")
    finally:
        del sys.modules["thing"]


def test_a_function_that_is_there_gets_its_new_code(tmp_path, monkeypatch):
    """Methods, properties and what has been made inside of a function; nothing else of the file, and no other file."""
    text = (
        "def half(x):\n    return x / 2\n\n\nclass Thing:\n    size = 2\n\n    @property\n    def double(self):\n"
        "        return self.size * 2\n\n\ndef adder(n):\n    def add(x):\n        return x + n\n\n    return add\n"
    )
    path = tmp_path / "things.py"
    path.write_text(text)
    monkeypatch.syspath_prepend(tmp_path)
    import things

    add, half = things.adder(3), things.half
    number = {(m.function, m.what): m.number for m in mutations.mutations(text)}
    assert (half(8), things.Thing().double, add(4)) == (4, 4, 7)
    try:
        assert mutants.swap(path, number["half", "x / 2 -> x * 2"]) == 4
        assert (half(8), things.Thing().double, add(4)) == (16, 4, 7)
        mutants.swap(path, number["Thing.double", "2 -> 3"])
        assert (half(8), things.Thing().double, add(4)) == (4, 6, 7)
        mutants.swap(path, number["adder.<locals>.add", "x + n -> x - n"])
        assert (half(8), things.Thing().double, add(4), things.adder(1)(4)) == (4, 4, 1, 3)
    finally:
        del sys.modules["things"]


def test_the_tests_that_visit_a_function_are_chosen_the_nearest_and_quickest_first(monkeypatch):
    path = mutants.PACKAGE / "geometry" / "angles.py"
    name = str(path.relative_to(mutants.ROOT))
    test = lambda s, *visits: {"s": s, "visits": [[name, v] for v in visits]}
    tests = {
        "slow": test(3.0, "wrap"),
        "quick": test(0.1, "wrap"),
        "other": test(0.1, "turn"),
        "long": test(50.0, "wrap"),
        "looks at values": test(0.2),
    }
    change = mutations.Mutation(0, 1, "wrap", "")
    assert mutants.tests_for(path, change, tests) == ["quick", "slow"]
    assert mutants.tests_for(path, mutations.Mutation(0, 1, "", ""), tests) == [
        "quick",
        "other",
        "looks at values",
        "slow",
    ]
    assert mutants.tests_for(path, mutations.Mutation(0, 1, "nobody", ""), tests) == []
    assert mutants.run(path, change, [], tests)["status"] == "survived"
    near = {"tests/geometry/test_a.py::one": test(0.2, "wrap"), "tests/geometry/test_b.py::two": test(2.0, "wrap")}
    one, two = near
    assert mutants.tests_for(path, change, tests | near) == [one, "quick", two, "slow"]


def test_a_torn_line_of_the_results_is_left_out(tmp_path):
    (tmp_path / "results.jsonl").write_text('{"key": "a", "status": "killed"}\n{"key": "b", "sta')
    assert list(mutants.results(tmp_path / "results.jsonl")) == ["a"]
    assert mutants.share([{"status": "killed"}, {"status": "survived"}]) == "1 of 2 found (50.0 %)"


@pytest.mark.skipif(not hasattr(mutants.os, "fork"), reason="this system cannot fork")
def test_a_mutant_is_found(tmp_path, monkeypatch):
    """From end to end, on a package of one function with one test: found, and then not done again."""
    core = tmp_path / "ekfslam_tutorial" / "geometry"
    core.mkdir(parents=True), (tmp_path / "tests").mkdir()
    (core.parent / "__init__.py").write_text(""), (core / "__init__.py").write_text("")
    (core / "half.py").write_text("def half(x):\n    return x / 2\n")
    test = "from ekfslam_tutorial.geometry.half import half\n\ndef test_half():\n    assert half({}) == {}\n"
    script = (
        "import sys; sys.path.insert(0, {!r}); import mutants, pytest_timeout; from pathlib import Path; "
        "mutants.ROOT = Path({!r}); mutants.PACKAGE = mutants.ROOT / 'ekfslam_tutorial'; "
        "mutants.TESTS = ['tests/test_half.py']; mutants.main()"
    )
    words = [sys.executable, "-c", script.format(str(TOOLS), str(tmp_path)), "--out", str(tmp_path / "out")]

    def said(text):
        (tmp_path / "tests" / "test_half.py").write_text(text)
        import subprocess

        done = subprocess.run(words, capture_output=True, text=True, cwd=tmp_path)
        assert done.returncode == 0, done.stderr
        return done.stdout

    weak = said(test.format("0.0", "0.0"))  # of x / 2 -> x * 2, 2 -> 3, 2 -> 1 it finds none
    assert "0 of 3 found (0.0 %), of 3 possible ones" in weak and "geometry/half.py:2: x / 2 -> x * 2" in weak
    assert "3 of 3 found (100.0 %)" in said(test.format("3.0", "1.5"))
    lines = (tmp_path / "out" / "results.jsonl").read_text().splitlines()
    said(test.format("3.0", "1.5"))
    assert (tmp_path / "out" / "results.jsonl").read_text().splitlines() == lines and len(lines) == 6
