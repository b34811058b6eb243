"""What a student calls in a notebook: check, hint, reveal, progress."""

from __future__ import annotations

import inspect
import textwrap

from . import logbook, registry
from .exercise import Exercise, Verdict
from .keep import remember
from .project import Project
from .told import tell

FALLBACK = "The reference solution is used below."


def check(id: str, answer=None):
    """Test an answer; return it if it passes, else say what is wrong and return the reference solution.

    So the rest of the notebook runs in any case.

    Parameters
    ----------
    id : str
        Number of the exercise, "02.3".
    answer : callable, dict or Run
        The student's function itself (no brackets), the dictionary of answers, or the run of a project.

    Returns
    -------
    callable or dict
        The answer, or the reference solution. A function comes back so that it returns float arrays where the solution
        does; `inspect.unwrap` gives the student's own. The reference knows that it is one: handed in again, it is
        neither judged nor counted. Of a project the `Verdict`.

    Raises
    ------
    ValueError
        If there is no exercise with this id.
    """
    exercise = registry.get(id)
    if isinstance(exercise, Project):
        return told(exercise, exercise.judge(answer))
    answer = inspect.unwrap(answer) if callable(answer) else answer
    if exercise.is_reference(answer):
        print(own_answer_wanted(exercise))
        return exercise.reference
    verdict = exercise.judge(answer)
    if verdict.status != "not attempted":
        logbook.attempt(id, verdict.passed)
        remember(id, answer if verdict.passed else None)
    said = report(exercise, verdict)
    print(said) if verdict.status == "not attempted" else tell(verdict.passed, said)
    return exercise.in_arrays(answer) if verdict.passed else exercise.reference


def own_answer_wanted(exercise) -> str:
    """Return what `check` prints when it gets the reference that an earlier check has handed out."""
    cell = f"def {exercise.name}(...)" if isinstance(exercise, Exercise) else f"{exercise.name} = {{...}}"
    return _wrapped(
        f"[{exercise.id}] not judged: `{exercise.name}` is the reference solution here, from an earlier check. Run the "
        f"cell with your own `{cell}` first, then this one."
    )


def told(project: Project, verdict: Verdict) -> Verdict:
    """Record and print the verdict on a run, and hand it on; the reference is never judged and never counted."""
    if verdict.status == "not attempted":
        print(f"[{project.id}] not attempted yet: this is a run of the reference. Write your loop in the cell above.")
        return verdict
    logbook.attempt(project.id, verdict.passed)
    what = verdict.note if verdict.passed else f"failed '{verdict.link}': {verdict.message}"
    before = not verdict.passed and logbook.read().get(project.id, logbook.EMPTY)["passed"]
    logbook.write(project.id, **({"last": what} if before else {"verdict": what, "last": None}))
    lines = [report(project, verdict).replace(f"{FALLBACK} ", "")]
    if verdict.note:
        lines.append(_wrapped(f"    {verdict.note}."))
    tell(verdict.passed, "\n".join(lines))
    return verdict


def hint(id: str, level: int | None = None):
    """Print the next hint of an exercise, or the one of the given level (1, 2 or 3)."""
    exercise = registry.get(id)
    most = len(exercise.hints)
    seen = logbook.read().get(id, logbook.EMPTY)["hints"]
    level = min(seen + 1, most) if level is None else level
    if level not in range(1, most + 1):
        raise ValueError(f"exercise {id} has the hints 1 to {most}, got {level!r}")
    logbook.write(id, hints=max(seen, level))
    more = f'hint("{id}", {level + 1})' if level < most else f'reveal("{id}")'
    print(_wrapped(f"[{id}] hint {level} of {most}: {exercise.hints[level - 1]}"))
    print(f"    More: {more}")


def reveal(id: str):
    """Print the reference solution of an exercise."""
    exercise = registry.get(id)
    logbook.write(id, revealed=True)
    print(f"# [{id}] {exercise.title}: one solution of many\n{exercise.source()}")


def progress(notebook: str | None = None):
    """Print what is done and what is open, for one notebook ("02") or for all.

    Returns
    -------
    None
        The summary is printed.
    """
    records = logbook.read()
    chosen = registry.everything() if notebook is None else registry.of_notebook(notebook)
    if not chosen:
        raise ValueError(f"there are no exercises of a notebook {notebook!r}")
    done = sum(bool(records.get(e.id, logbook.EMPTY)["passed"]) for e in chosen)
    if damage := logbook.damage():
        print(damage)
    print(f"{done} of {len(chosen)} exercises passed")
    width = max(8, *(len(exercise.id) + 1 for exercise in chosen))
    for exercise in chosen:
        record = records.get(exercise.id, logbook.EMPTY)
        print(f"  {exercise.id:{width}} {_state(record):24} {exercise.title}")
        for what in record.get("verdict"), record.get("last") and f"last try: {record['last']}":
            if what:
                print(textwrap.indent(textwrap.fill(what, 86), " " * 14))


def report(exercise, verdict: Verdict) -> str:
    """Return what `check` prints."""
    id = exercise.id
    if verdict.passed:
        return f"[{id}] passed"
    if verdict.status == "not attempted":
        return f"[{id}] not attempted yet: the reference solution is used below."
    end = "" if verdict.message.endswith(("?", ".")) else "."
    lines = [_wrapped(f"[{id}] failed '{verdict.link}': {verdict.message}{end}")]
    if verdict.hint:
        lines.append(_wrapped(f"    Hint: {verdict.hint}"))
    if verdict.printed.strip():
        lines.append("    Your function printed:")
        lines += [f"    | {line[:100]}" for line in verdict.printed.strip().splitlines()[:5]]
    lines.append(f'    {FALLBACK} More help: hint("{id}")')
    return "\n".join(lines)


def _wrapped(text: str) -> str:
    return textwrap.fill(text, 100, subsequent_indent="    ", initial_indent="", break_long_words=False)


def _state(record) -> str:
    if record["passed"]:
        return f"passed {record['passed'][:10]}"
    if record["tries"]:
        return f"tried {record['tries']} times" if record["tries"] > 1 else "tried once"
    return "not attempted"


__all__ = ["check", "hint", "own_answer_wanted", "progress", "report", "reveal"]
