"""Do the checks do what they promise? ``python -m ekfslam_tutorial.course.audit [NN]``.

For whoever writes exercises, a lecturer's private ones too: the solution and every variant must pass, every
misconception must be rejected with its own hint, and nothing may take long.
"""

from __future__ import annotations

import sys
import time

from . import registry
from .project import Project

SECONDS = 1.0  # a student's machine may be slower, and a student's code, too


def complaints(exercise) -> list[str]:
    """Return what is wrong with an exercise, one sentence each."""
    found = []
    started = time.perf_counter()
    right = [("the solution", exercise.reference)] + [(v.name, v.answer) for v in exercise.variants]
    for name, answer in right:
        verdict = exercise.judge(answer)
        if not verdict.passed:
            found.append(f"right answer '{name}' fails '{verdict.link}': {verdict.message}")
    for m in exercise.misconceptions:
        verdict = exercise.judge(m.answer)
        if verdict.status != "failed":
            found.append(f"wrong answer '{m.name}': {verdict.status}")
        elif (verdict.misconception, verdict.hint) != (m.name, m.hint):
            got = f"taken for '{verdict.misconception}'" if verdict.misconception else "not recognised"
            found.append(f"wrong answer '{m.name}': {got}; failed '{verdict.link}': {verdict.message}")
    mean = (time.perf_counter() - started) / (len(right) + len(exercise.misconceptions))
    if mean > SECONDS:
        found.append(f"a check takes {mean:.2f} s")
    if len(exercise.hints) != 3:
        found.append(f"{len(exercise.hints)} hints instead of 3")
    if len(exercise.misconceptions) < 2:
        found.append("needs two misconceptions at least")
    return found


def main(arguments: list[str]) -> int:
    """Print one line per exercise, and every complaint."""
    bad, numbers = 0, {exercise.id.split(".")[0] for exercise in registry.everything()}
    unknown = sorted(set(arguments) - numbers)
    if unknown:
        print(f"no exercises of notebook {', '.join(unknown)}; there are {', '.join(sorted(numbers))}", file=sys.stderr)
        return 2
    for exercise in registry.everything():
        if isinstance(exercise, Project):  # of a run it would take minutes
            continue
        if arguments and exercise.id.split(".")[0] not in arguments:
            continue
        found = complaints(exercise)
        bad += len(found)
        counts = f"{len(exercise.misconceptions):3} wrong answers, {len(exercise.variants)} right ones in other words"
        print(f"{exercise.id:8} {counts}  {exercise.title}")
        for sentence in found:
            print(f"    {sentence}")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
