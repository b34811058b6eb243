"""The verdicts on all listed wrong answers, and the states of some runs, as JSON: what two Pythons must agree on.

`python tests/course/verdicts.py FILE PART` writes them; PART is 1 for all, or n for every n-th wrong answer.
The Python of a browser runs the same file: see tests/browser/test_lite_verdicts.py.
"""

import contextlib
import io
import json
import sys
from pathlib import Path

import numpy as np

from ekfslam_tutorial.cli.files import find_scenario
from ekfslam_tutorial.course import registry
from ekfslam_tutorial.course.project import Project
from ekfslam_tutorial.toolbox import UserData, universal_slam

RUNS = {"range_bearing_2d": 60, "cloister_idp": 25, "two_robots_four_cameras": 8}  # frames


def verdicts(part):
    """Return, by exercise and answer, the verdict: status, link, hint, recognised misconception."""
    found, n = {}, 0
    for exercise in registry.everything():
        if isinstance(exercise, Project):
            continue
        answers = {"the solution": exercise.reference}
        for wrong in exercise.misconceptions:
            n += 1
            if n % part == 0:
                answers[wrong.name] = wrong.answer
        for name, answer in answers.items() if part == 1 or len(answers) > 1 else ():
            verdict = exercise.judge(answer)
            found[f"{exercise.id} {name}"] = [verdict.status, verdict.link, verdict.hint, verdict.misconception]
    return found


def states():
    """Return, by scenario, all states at its end and the standard deviations."""
    found = {}
    for name, frames in RUNS.items():
        data = UserData.from_toml(find_scenario(name), {"time.last": frames})
        *_, last = universal_slam(data)
        x, P = last.map.x, last.map.P
        found[name] = {"x": x.tolist(), "std": np.sqrt(np.abs(np.diag(P))).tolist()}
    return found


def main(target, part):
    """Write the file."""
    with contextlib.redirect_stdout(io.StringIO()):
        content = {"verdicts": verdicts(int(part)), "states": states()}
    Path(target).write_text(json.dumps(content), encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])
