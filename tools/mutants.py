"""Change the core in one place at a time, and see whether its tests find out: `make mutants`.

First each file of tests is run once, and it is noted which functions each test visits. Then changes are drawn by
chance, and for each of them the tests that visit its function are run, nearest and quickest first, until one fails.
The files are not touched. All tests are collected once; for each change the function gets its new code in a copy of
that process. What survives that, and what is changed outside of a function, is tried again: the changed module is made
when it is imported, in a process of its own.

A change that makes no difference is listed with its reason in tools/equivalent_mutants.toml; it is left out.

Results are appended to build/mutants/results.jsonl and never made twice as long as neither the file nor the tests have
changed. Stop it whenever you like; the next call goes on. Survivors are listed at the end, and in survivors.txt.
"""

import argparse
import gc
import hashlib
import importlib.abc
import importlib.machinery
import json
import os
import random
import resource
import signal
import sys
import time
import tomllib
import types
from pathlib import Path

import mutations
import numpy as np

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = ROOT / "ekfslam_tutorial"
CORE = "geometry", "models", "ekf", "slam"
TESTS = [*(f"tests/{folder}/test_*.py" for folder in ("geometry", "models", "ekf", "slam", "numerics", "toolbox"))]
TESTS += ["tests/simulation/test_*.py", "tests/golden/test_functions.py"]
TESTS += ["tests/fast/test_alike.py", "tests/fast/test_own_noise.py", "tests/fast/test_kinds_of_numbers.py"]
TESTS += [
    "tests/fast/test_inputs.py",
    "tests/fast/test_errors.py",
    "tests/fast/test_gating.py",
    "tests/fast/test_symbols.py",
]
LEFT_OUT = "tests/toolbox/test_clock.py", "tests/toolbox/test_scenarios.py"
"""Tests of which each takes longer than `LONG`: what they visit is not worth the minutes."""
SECONDS = 20.0
"""Of tests for one mutant, and ..."""
LONG = 4.0
"""... a test that takes longer is left out."""
SHORT = 0.05, 0.5
"""Tests up to these seconds go before longer ones, wherever they are; of those alike the nearest go first."""
PATIENCE = 20.0, 8.0
"""A mutant may take so many seconds of the processor, and so many times what the tests took: then it is found, too."""
MEMORY = 4 * 2**30
"""Bytes that a mutant may take."""
EQUIVALENT = ROOT / "tools" / "equivalent_mutants.toml"


class Changed(importlib.abc.MetaPathFinder, importlib.machinery.SourceFileLoader):
    """Import of one module in its changed form."""

    def __init__(self, path, number):
        name = ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")
        super().__init__(name, str(path))
        self.number = number

    def find_spec(self, fullname, path=None, target=None):
        """Return the spec of the changed module, None for all others."""
        if fullname != self.name:
            return None
        return importlib.machinery.ModuleSpec(fullname, self, origin=self.path)

    def get_code(self, fullname):
        """Return the code of the changed source; nothing is cached."""
        tree = mutations.mutated(Path(self.path).read_text(encoding="utf-8"), self.number)
        return compile(tree, self.path, "exec", dont_inherit=True)


class Visits:
    """Pytest plugin that notes the functions of the core that each test visits, and how long it takes."""

    def __init__(self):
        self.tests = {}

    def pytest_runtest_logreport(self, report):
        """Forget what fails or is skipped: it finds nothing."""
        if not report.passed:
            self.tests.pop(report.nodeid, None)

    def pytest_runtest_protocol(self, item):
        """Note the functions from the set-up of a test on."""
        seen = {}

        def note(frame, *_):
            seen[id(frame.f_code)] = frame.f_code  # to compare two of them takes long

        self.tests[item.nodeid] = {"s": 0.0, "visits": seen}
        self.start = time.process_time()
        sys.settrace(note)  # it returns None: lines are not traced

    def pytest_runtest_teardown(self, item):
        """The rest is of no interest."""
        sys.settrace(None)
        if item.nodeid in self.tests:
            core, test = tuple(str(PACKAGE / folder) + os.sep for folder in CORE), self.tests[item.nodeid]
            mine = [code for code in test["visits"].values() if code.co_filename.startswith(core)]
            name = lambda code: (os.path.relpath(code.co_filename, ROOT), code.co_qualname.replace(".<lambda>", ""))
            test |= {"s": round(time.process_time() - self.start, 4), "visits": {name(code) for code in mine}}


class Chosen:
    """Pytest plugin that runs some of the tests only, in a given order."""

    def __init__(self, ids):
        self.order = {id: i for i, id in enumerate(ids)}

    def pytest_collection_modifyitems(self, items):
        """Keep the chosen ones."""
        items[:] = sorted((i for i in items if i.nodeid in self.order), key=lambda i: self.order[i.nodeid])


class Session:
    """Pytest plugin that collects all tests, and then runs some of them for one mutant after the other.

    A mutant is a copy of this process in which functions have the code of the changed source. What they have made
    before, when tests were collected, is not made anew.

    Parameters
    ----------
    asked, told : file
        Of questions and answers: a file, the number of its mutation, tests and seconds; and what became of it, as the
        exit code of a process.
    """

    def __init__(self, asked, told):
        self.asked, self.told, self.is_mutant = asked, told, False

    def pytest_runtestloop(self, session):
        """Run no tests but those that are asked for."""
        items = {item.nodeid: item for item in session.items}
        for line in self.asked:
            path, number, ids, limit = json.loads(line)
            chosen = [items[id] for id in ids if id in items]
            print(_copied(lambda: self._run(Path(path), number, chosen), limit), file=self.told, flush=True)  # noqa: B023
        return True

    def _run(self, path, number, items):
        if not swap(path, number):
            return 0
        self.is_mutant = True
        for item, after in zip(items, [*items[1:], None], strict=True):
            item.config.hook.pytest_runtest_protocol(item=item, nextitem=after)
        return 0

    def pytest_runtest_logreport(self, report):
        """End with the first test that fails."""
        if self.is_mutant and report.failed:
            os._exit(1)


def swap(path, number):
    """Give all functions of a file that has been imported the code of its changed source. Returns how many it has."""
    tree, codes, n = mutations.mutated(path.read_text("utf-8"), number), {}, 0
    inside = [compile(tree, str(path), "exec", dont_inherit=True)]
    for code in inside:
        inside += [const for const in code.co_consts if isinstance(const, types.CodeType)]
        codes[code.co_qualname, code.co_firstlineno] = code
    for function in [each for each in gc.get_objects() if type(each) is types.FunctionType]:
        old = function.__code__
        new = codes.get((old.co_qualname, old.co_firstlineno)) if old.co_filename == str(path) else None
        if new is not None and new.co_freevars == old.co_freevars:
            function.__code__, n = new, n + 1
    return n


class Quick:
    """A process with a `Session`, to be asked; it begins with the first question."""

    def __init__(self, out):
        self.out, self.pipes = out, None

    def _begin(self):
        (asked, ask), (hear, told) = os.pipe(), os.pipe()
        if not os.fork():
            os.setsid()
            for end in (ask, hear):
                os.close(end)
            session = Session(open(asked, encoding="utf-8"), open(told, "w", encoding="utf-8"))
            _pytest([str(file.relative_to(ROOT)) for file in _files()], session, self.out / "session.txt")
            os._exit(0)
        for end in (asked, told):
            os.close(end)
        return open(ask, "w", encoding="utf-8"), open(hear, encoding="utf-8")

    def run(self, file, mutation, chosen, tests):
        """Run the chosen tests on one mutant of a function. Returns what became of it, or None if it has survived."""
        if not (mutation.function and chosen):
            return None
        ask, hear = self.pipes = self.pipes or self._begin()
        start = time.monotonic()
        print(json.dumps([str(file), mutation.number, chosen, _limit(chosen, tests)]), file=ask, flush=True)
        answer = hear.readline()
        if not answer:
            raise RuntimeError(f"the tests cannot be collected: see {self.out / 'session.txt'}")
        by = int(answer)  # 1 of a test that failed, less than 0 of one that did not end
        return {"status": "killed", "by": by, "s": round(time.monotonic() - start, 2)} if by == 1 or by < 0 else None


def main():
    """Run as many mutants as asked for, or as fit into the time."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n\n")[0])
    parser.add_argument("--minutes", type=float, default=30, help="stop after so many minutes; default 30")
    parser.add_argument("--sample", type=int, help="stop after so many mutants")
    parser.add_argument("--seed", type=int, default=1, help="of the order in which they are drawn")
    parser.add_argument("--only", default="", help="files whose path has this in it: slam/steps")
    parser.add_argument("--out", type=Path, default=ROOT / "build" / "mutants")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    end = time.monotonic() + 60 * options.minutes
    os.chdir(ROOT)
    sys.path.insert(0, str(ROOT))
    tests = visited(options.out)
    files = sorted(path for folder in CORE for path in (PACKAGE / folder).rglob("*.py"))
    same = equivalent(EQUIVALENT.read_text("utf-8"))
    drawn = [(f, m) for f in files if options.only in f.as_posix() for m in different(f, same)]
    random.Random(options.seed).shuffle(drawn)
    log, known = options.out / "results.jsonl", results(options.out / "results.jsonl")
    done, quick = [], Quick(options.out)
    try:
        for file, mutation in drawn:
            if time.monotonic() > end or (options.sample is not None and len(done) >= options.sample):
                break
            chosen = tests_for(file, mutation, tests)
            key = _digest(file.read_text("utf-8"), mutation, [(id, _text(id.split("::")[0])) for id in chosen])
            if key not in known:
                where = f"{file.relative_to(ROOT).as_posix()}:{mutation.line}"
                became = quick.run(file, mutation, chosen, tests) or run(file, mutation, chosen, tests)
                known[key] = {"key": key, "where": where, "what": mutation.what} | became
                with open(log, "a", encoding="utf-8") as out:
                    out.write(json.dumps(known[key]) + "\n")
            done.append(known[key])
            print(f"\r{len(done)} of {len(drawn)}: {share(done)}", end="", flush=True)
    except KeyboardInterrupt:
        pass
    report(options.out, done, len(drawn))


def equivalent(text):
    """Changes that make no difference, of a TOML file: a set of (file, line of the source, change)."""
    return {(entry["file"], entry["line"], entry["change"]) for entry in tomllib.loads(text)["same"]}


def different(file, same):
    """The changes of a file but those that make no difference."""
    text = file.read_text("utf-8")
    lines, name = [line.strip() for line in text.splitlines()], file.relative_to(PACKAGE).as_posix()
    return [m for m in mutations.mutations(text) if (name, lines[m.line - 1], m.what) not in same]


def visited(out):
    """The tests of the core, the functions each visits and its seconds.

    A file of tests is run anew if its text has changed. What it visits is kept one by one: this can be stopped, too.
    """
    path = out / "visits.json"
    kept = json.loads(path.read_text("utf-8")) if path.exists() else {}
    files = _files()
    for i, file in enumerate(files):
        name, text = str(file.relative_to(ROOT)), _text(file)
        if kept.get(name, {}).get("text") != text:
            print(f"\r{i} of {len(files)} files of tests: what do they visit?", end="", flush=True)
            kept[name] = {"text": text, "tests": _visits(name, out)}
            path.write_text(json.dumps(kept), encoding="utf-8")
    print()
    return {id: test for file in files for id, test in kept[str(file.relative_to(ROOT))]["tests"].items()}


def _files():
    """All files of tests that are asked."""
    files = [file for pattern in TESTS for file in sorted(ROOT.glob(pattern))]
    return [file for file in files if file.relative_to(ROOT).as_posix() not in LEFT_OUT]


def _visits(name, out):
    """Run one file of tests in a copy of this process."""
    read, write = os.pipe()
    if not (child := os.fork()):
        os.close(read)
        plugin = Visits()
        _pytest([name], plugin, out / "visits.txt")
        tests = {id: {"s": t["s"], "visits": sorted(t["visits"])} for id, t in plugin.tests.items() if t["s"] < LONG}
        with open(write, "w", encoding="utf-8") as file:
            json.dump(tests, file)
        os._exit(0)
    os.close(write)
    with open(read, encoding="utf-8") as file:
        tests = file.read()
    os.waitpid(child, 0)
    return json.loads(tests or "{}")


def tests_for(file, mutation, tests):
    """The tests that visit the function of a mutation, or its file: the quickest, those of its own folder first."""
    path = str(file.relative_to(ROOT))
    place = [path, mutation.function]
    mine = [id for id, t in tests.items() if place in t["visits"]]
    if not mutation.function:  # of the whole file; who visits nothing looks at values: at any
        mine = [id for id, t in tests.items() if not t["visits"] or any(visit[0] == path for visit in t["visits"])]
    seconds, chosen = 0.0, []
    for id in sorted(mine, key=lambda id: tests[id]["s"]):
        seconds += tests[id]["s"]
        if seconds > SECONDS:
            break
        chosen.append(id)
    near = f"tests/{path.split('/')[1]}/"
    return sorted(chosen, key=lambda id: (np.searchsorted(SHORT, tests[id]["s"]), not id.startswith(near)))


def run(file, mutation, chosen, tests):
    """Run the chosen tests on one mutant, in a copy of this process. Returns what became of it."""
    if not chosen:
        return {"status": "survived", "by": "no test visits it", "s": 0.0}
    start = time.monotonic()

    def changed():
        sys.meta_path.insert(0, Changed(file, mutation.number))
        return _pytest(sorted({id.split("::")[0] for id in chosen}), Chosen(chosen), os.devnull)

    by = _copied(changed, _limit(chosen, tests))
    return {"status": "survived" if by == 0 else "killed", "by": by, "s": round(time.monotonic() - start, 2)}


def _limit(chosen, tests):
    """Seconds of the processor that a mutant may take."""
    return int(PATIENCE[0] + PATIENCE[1] * sum(tests[id]["s"] for id in chosen))


def _copied(do, limit):
    """Exit code of a copy of this process that does something, which gives the code; below zero if it was stopped."""
    if not (child := os.fork()):
        resource.setrlimit(resource.RLIMIT_CPU, (limit, limit))  # of this process alone, however busy the computer is
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
        os.setsid()  # what it does to its group, it does to itself
        try:
            os._exit(int(do()))
        except BaseException:
            os._exit(70)
    done = False
    try:
        by = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        done = True
    finally:
        if not done:
            os.kill(child, signal.SIGKILL)
            os.waitpid(child, 0)
    return by


def _pytest(paths, plugin, said):
    """Run pytest in this process, its words in a file."""
    import pytest

    os.environ |= {"OPENBLAS_NUM_THREADS": "1", "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}
    with open(said, "w", encoding="utf-8") as file:
        for output in (1, 2):
            os.dup2(file.fileno(), output)
        words = ["-x"] if isinstance(plugin, Chosen) else []
        return pytest.main(["-q", "-p", "no:cacheprovider", "-p", "pytest_timeout", *words, *paths], [plugin])


def results(path):
    """What is known from calls before, by key; a line that was torn is left out."""
    known = {}
    if path.exists():
        for line in path.read_text("utf-8").splitlines():
            try:
                entry = json.loads(line)
                known[entry["key"]] = entry
            except (ValueError, KeyError):
                continue
    return known


def share(done):
    """The mutants found so far, in words."""
    killed = sum(entry["status"] == "killed" for entry in done)
    return f"{killed} of {len(done)} found ({100 * killed / max(len(done), 1):.1f} %)"


def report(out, done, n_all):
    """Print the survivors, and write them to a file."""
    lines = [
        f"{e['where']}: {e['what']}" + (" (no test visits it)" if e["s"] == 0 else "")
        for e in done
        if e["status"] == "survived"
    ]
    (out / "survivors.txt").write_text("".join(f"{line}\n" for line in sorted(lines)), encoding="utf-8")
    print(f"\n{share(done)}, of {n_all} possible ones; survivors, also in {out / 'survivors.txt'}:")
    print("\n".join(sorted(lines)) or "none")


_texts = {}


def _text(path):
    path = Path(ROOT, path)
    if path not in _texts:
        _texts[path] = hashlib.sha256(path.read_bytes()).hexdigest()
    return _texts[path]


def _digest(*parts):
    return hashlib.sha256(repr(parts).encode()).hexdigest()[:20]


if __name__ == "__main__":
    import hypothesis  # noqa: F401  what every mutant needs is imported once
    import matplotlib.pyplot  # noqa: F401
    import psutil  # noqa: F401
    import pytest_timeout  # noqa: F401
    import scipy.linalg
    import scipy.spatial.transform
    import scipy.stats  # noqa: F401

    main()
