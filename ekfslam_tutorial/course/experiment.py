"""A student's experiment in a notebook: the run of a project, seen while it runs."""

from __future__ import annotations

import textwrap

from . import registry
from .live import Watch
from .project import Project, Run, is_stub


def experiment(id: str, scenario: str, loop) -> Run:
    """Run an experiment of one's own and show it: map figure and sensor figure, live, side by side.

    Where the loop is not written yet, the reference runs, so that the notebook goes on; a line says so.

    Parameters
    ----------
    id : str
        Number of the project, "13.project".
    scenario : str
        TOML, as in a scenario file.
    loop : generator function
        Takes a `World`, yields ``x, P, lmks`` after each frame.

    Returns
    -------
    Run
        For `check`.
    """
    project = registry.get(id)
    if not isinstance(project, Project):
        raise ValueError(f"{id} is an exercise, not a project: it is checked, not run")
    watch = Watch(project.title, project.sensor)
    run = project.run(scenario, loop, watch=watch) if not is_stub(loop) else None
    if run is None or (run.trial is not None and not run.trial.attempted):
        print(f"[{id}] The loop is not written yet: this is a run of the reference.")
        watch = Watch(project.title, project.sensor)
        run = project.run(project.scenario, project.loop, reference=True, watch=watch)
    if run.failed is not None:
        begun, whole = run.trial is not None, run.trial is not None and len(run.trial.t) == run.trial.frames
        what = "The result is not used" if whole else "The run ended early" if begun else "The run has not begun"
        print(textwrap.fill(f"[{id}] {what}: {run.failed}", 100, subsequent_indent="    "))
    if run.trial is not None and run.trial.printed:
        print(run.trial.printed)
    if run.trial is not None and run.trial.t:
        n = len(run.trial.t)
        after = f"{'' if n == run.trial.frames else 'a run that ended early, after '}{n} frame{'s' * (n != 1)}"
        of = project.summary([run.trial]) if run.failed is None else after
        watch.finish(f"The last picture of {of}. {project.remark}".strip())
    return run
