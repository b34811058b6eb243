"""A project: the student writes an experiment, scenario and loop, and the run is judged.

A module of a project (``projects/nb13.py``) holds the scenario and the loop of the reference::

    project = Project(
        "13.project", "One eye in the cloister", loop, scenario=SCENARIO, start=START, hints=("level 1", "level 2"),
        asks=(asks.robots("odometry3"), asks.sensors("pin_hole"), asks.frames(60, 200)), band=(3.0, 12.0),
    )

In the notebook it is one cell, which ends with ``run = experiment("13.project", scenario, loop)``, and the check below
it, ``verdict = check("13.project", run)``. Nothing that the student says of the run is believed: the loop is run again
with other seeds, and NEES, errors and the size of the map come from its estimates and the truth of the simulator.
"""

from __future__ import annotations

import ast
import inspect
import os
import textwrap
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..toolbox import UserData
from . import deadline
from .exercise import Verdict
from .expect import Failed
from .trial import LATELY, OFTEN, Trial, run_trial

SEEDS = tuple(range(101, 107))  # the runs of a check, besides the student's own
SECONDS = 30.0  # for one run
CLAIMS = 0.94, 1.6, 1.7  # sigmas over those of the reference: robots at least and at most, landmarks at most
LEAST = 0.6  # share of the landmarks seen often that must be in the map


@dataclass
class Run:
    """What ``experiment`` gives back: one run, and all that is needed for others like it.

    `reference` is true for the run that a notebook goes on with when there is no loop yet: it is never judged.
    """

    project: Project
    scenario: str
    loop: Any
    data: Any = None
    trial: Trial | None = None
    failed: Failed | None = None
    reference: bool = False

    def __repr__(self):
        whose = "the reference" if self.reference else "your"
        return (
            f"Run({self.project.id}, {whose} loop, {self.project.summary([self.trial]) if self.trial else 'not run'})"
        )


@dataclass(frozen=True)
class Scores:
    """What is measured of some runs together.

    Parameters
    ----------
    nees, first, last : float
        Mean NEES of the robots over all frames, over the first third, and over the last third.
    dof : int
        Mean NEES of an honest filter: 3 in the plane, 6 in space.
    error, sigma : float
        Position in the last third of the run: root mean square error, and what the filter claims (m).
    dead_error, dead_sigma : float
        The same of dead reckoning, with the same controls.
    landmarks, seen : float
        Landmarks in the map at the end, and how many were seen in five frames or more: the mean of a run.
    share : float
        Of the landmarks that were seen so often, the part that is in the map.
    lately : float
        The same of those that were seen in the last frames of the run, too.
    landmark_nees, landmark_error : float
        Median over the landmarks at the end: NEES over the number of coordinates, and error (m).
    mounting_nees, mounting_sigma : float
        Of the angles of mountings that are estimated: mean NEES at the end (honest 3), and their sigma as a part of
        that at the start; NaN where there is none.
    claim, landmark_claim : float
        Sigma of the robots, and median sigma of the landmarks, over those of the reference with the same data. The
        reference uses every measurement once: nobody can honestly claim less.
    size : int
        Most numbers in x.
    frames : int
    seconds : float
        Of the slowest run.
    """

    nees: float
    first: float
    last: float
    dof: int
    error: float
    sigma: float
    dead_error: float
    dead_sigma: float
    landmarks: float
    seen: float
    share: float
    lately: float
    landmark_nees: float
    landmark_error: float
    mounting_nees: float
    mounting_sigma: float
    claim: float
    landmark_claim: float
    size: int
    frames: int
    seconds: float


def scores(trials, reference=None) -> Scores:
    """Measure some runs of one loop together; `reference` is a run of the reference with the data of the first."""
    tracks = [np.array(rows) for trial in trials for rows in trial.errors.values()]  # (frames, 3) each
    dead = [np.array(rows) for trial in trials for rows in trial.dead.values()]
    n = min(len(track) for track in tracks)
    third = max(n // 3, 1)
    nees = np.array([track[:n, 2] for track in tracks])
    rms = lambda rows, column: float(np.sqrt(np.nanmean([np.nanmean(r[n - third : n, column] ** 2) for r in rows])))
    often = [{id for id, k in t.sightings.items() if k >= OFTEN} for t in trials]
    pairs = list(zip(often, trials, strict=True))
    lmks = np.array([row for t in trials for row in t.landmarks], float).reshape(-1, 4)
    mountings = np.array([row for t in trials for row in t.mountings], float).reshape(-1, 2)
    with np.errstate(all="ignore"):
        return Scores(
            nees=_mean(nees),
            first=_mean(nees[:, :third]),
            last=_mean(nees[:, n - third :]),
            dof=next(iter(trials[0].dof.values())),
            error=rms(tracks, 0),
            sigma=rms(tracks, 1),
            dead_error=rms(dead, 0),
            dead_sigma=rms(dead, 1),
            landmarks=float(np.mean([t.size[-1] for t in trials])),
            seen=float(np.mean([len(ids) for ids in often])),
            share=_share(often, trials),
            lately=_share([{i for i in ids if t.latest[i] > len(t.t) - LATELY} for ids, t in pairs], trials),
            landmark_nees=float(np.nanmedian(lmks[:, 2])) if np.isfinite(lmks[:, 2]).any() else np.nan,
            landmark_error=float(np.median(lmks[:, 0])) if len(lmks) else np.nan,
            mounting_nees=_mean(mountings[:, 0]) if len(mountings) else np.nan,
            mounting_sigma=float(mountings[:, 1].mean()) if len(mountings) else np.nan,
            claim=_sigma(trials[0]) / _sigma(reference) if reference else np.nan,
            landmark_claim=_landmark_sigma(trials[0]) / _landmark_sigma(reference) if reference else np.nan,
            size=max(t.numbers for t in trials),
            frames=n,
            seconds=max(t.seconds for t in trials),
        )


def _share(wanted, trials) -> float:
    """The part of the wanted landmarks, a set of ids for each trial, that is in the map at the end."""
    return sum(len(ids & t.known) for ids, t in zip(wanted, trials, strict=True)) / max(sum(map(len, wanted)), 1)


def _sigma(trial) -> float:
    """Root mean square sigma of the positions of the robots, over all frames."""
    return float(np.sqrt(np.mean([np.array(rows)[:, 1] ** 2 for rows in trial.errors.values()])))


def _landmark_sigma(trial) -> float:
    """Median sigma of the landmarks at the end."""
    return float(np.median([row[1] for row in trial.landmarks])) if trial.landmarks else np.nan


def _mean(a) -> float:
    """Mean of what is finite; infinite where hardly anything is: a covariance that is singular promises too much."""
    fine = np.isfinite(a)
    return float(a[fine].mean()) if fine.mean() > 0.5 else np.inf


@dataclass(frozen=True)
class Symptom:
    """Something wrong with a run that can be measured, and where to look for its cause.

    Parameters
    ----------
    name : str
        What was tested.
    shows : callable
        (Scores, Project) -> bool.
    says : str
        What was measured, with the fields of `Scores`, and `p` the project: ``"{s.nees:.1f}"``.
    hint : str
    """

    name: str
    shows: Callable
    says: str
    hint: str


SYMPTOMS = (
    Symptom(
        "the noise of the motion",
        lambda s, p: np.isinf(s.nees),
        "P of a robot is singular in most frames: a part of its pose is claimed to be known exactly",
        "Every step adds noise: X_u U X_u' belongs in the block of the robot, in every frame.",
    ),
    Symptom(
        "the map",
        lambda s, p: s.share < p.least,
        "{s.landmarks:.0f} landmarks are in the map at the end, of {s.seen:.0f} that were seen in five frames or more",
        "Births fail, or stop: is a landmark started in every frame in which a new one is seen, not in the first only? "
        "Is it put into `lmks` with its range? Is the limit on births too low, or a known landmark started again?",
    ),
    Symptom(
        "corrections",
        lambda s, p: s.sigma > 0.9 * s.dead_sigma and s.error > 0.6 * s.dead_error,
        "the robots are off by {s.error:.2f} m, and claim {s.sigma:.2f} m: as much as without any measurement "
        "({s.dead_error:.2f} m, {s.dead_sigma:.2f} m)",
        "The error grows with the distance, as in dead reckoning: no correction reaches the robot. Are known landmarks "
        "corrected with? Does the gate let anything through? Does H have the columns of the robot, or only those of "
        "the landmark? Is the cross-covariance of a new landmark with the robot in P?",
    ),
    Symptom(
        "the covariance is corrected",
        lambda s, p: s.sigma > 0.9 * s.dead_sigma,
        "the robots are off by {s.error:.2f} m only, but claim {s.sigma:.2f} m: as much as without any measurement",
        "x is corrected and P is not: P - K Z K' belongs to every correction.",
    ),
    Symptom(
        "better than nothing",
        lambda s, p: s.error > 1.5 * max(s.dead_sigma, s.dead_error),
        "the robots are off by {s.error:.2f} m; without any measurement it would be {s.dead_error:.2f} m",
        "The corrections make it worse. The sign of the innovation (measured minus expected), the sign of a "
        "Jacobian, the order of the results of `observe` and of the frames in `retro_project`, a mounting that is left "
        "out, the control of another robot, or the range of another landmark: print z of the first correction; "
        "with a good start it is a few times the noise of the sensor. If it is: is R in Z? Has a birth the covariance "
        "of its prior, L_n N L_n'?",
    ),
    Symptom(
        "the mean is corrected",
        lambda s, p: s.nees > p.band[1] and abs(s.error / s.dead_error - 1) < 0.002,
        "the robots are off by {s.error:.2f} m, just as without any measurement, but claim {s.sigma:.2f} m",
        "P is corrected and x is not: x + K z belongs to every correction.",
    ),
    Symptom(
        "honest",
        lambda s, p: s.nees > p.band[1] and s.last > 1.5 * s.first,
        "the mean NEES is {s.nees:.1f} (band {p.band[0]:g} to {p.band[1]:g}, honest {s.dof}), and it grows: "
        "{s.first:.1f} in the first third, {s.last:.1f} in the last",
        "The filter becomes too sure on its way. Noise in the filter that is too small (X_u U X_u', or R)? A Jacobian "
        "that is wrong (compare it with `numerical_jacobian`)? A new landmark without its cross-covariance with *all* "
        "of the map, or at the wrong place? A measurement that starts a landmark and corrects, too? The control of "
        "another robot?",
    ),
    Symptom(
        "honest",
        lambda s, p: s.nees > p.band[1],
        "the mean NEES is {s.nees:.1f} (band {p.band[0]:g} to {p.band[1]:g}, honest {s.dof}), from the beginning on",
        "Too sure from the first frames on. Noise in the filter that is too small (X_u U X_u' in every frame, or R)? "
        "The P of the start left out, the control of another robot, or the mounting in the chain of frames? A "
        "measurement that is used twice: it corrects twice, or starts a landmark and corrects, too?",
    ),
    Symptom(
        "honest",
        lambda s, p: s.nees < p.band[0],
        "the mean NEES is {s.nees:.1f} (band {p.band[0]:g} to {p.band[1]:g}, honest {s.dof}): the filter claims "
        "{s.sigma:.2f} m and is off by {s.error:.2f} m only",
        "Too cautious: is a noise counted twice, or a standard deviation where a variance belongs (U and R are "
        "covariances already)? Does the gate throw good measurements away?",
    ),
    Symptom(
        "no more is claimed than can be known",
        lambda s, p: s.claim < p.claims[0],
        "the sigma of the robots is {s.claim:.3f} times that of the reference with the same data, which uses every "
        "measurement once (at least {p.claims[0]:g})",
        "More is claimed than the data say. Is a measurement used twice, for example to start a landmark and to "
        "correct? Does a new landmark come in without its covariance with *all* of the map? Is a Jacobian too small, "
        "X_x for example, that carries the uncertainty of the heading into the position? Or is an inverse-depth "
        "landmark made a point too early?",
    ),
    Symptom(
        "all is used",
        lambda s, p: s.claim > p.claims[1] or s.landmark_claim > p.claims[2],
        "the sigma of the robots is {s.claim:.2f} times that of the reference with the same data (at most "
        "{p.claims[1]:g}), the sigma of the landmarks {s.landmark_claim:.2f} times (at most {p.claims[2]:g})",
        "Too cautious: are all landmarks in view corrected in every frame? Does the gate refuse good measurements, as "
        "an angle in z is not wrapped? Is R that of the sensor, and U that of the frame, both variances and both "
        "counted once?",
    ),
    Symptom(
        "the error",
        lambda s, p: s.error > p.gain * s.dead_sigma,
        "the robots are off by {s.error:.2f} m in the last third; {p.gain:g} times the sigma of dead reckoning is "
        "{p.gain_m:.2f} m",
        "Honest, but it learns little: are all known landmarks of a frame used, in every frame? Is the gate too "
        "narrow, or R too large?",
    ),
    Symptom(
        "the landmarks",
        lambda s, p: s.landmark_nees > p.landmark_band,
        "the robots are right, the landmarks are not: their NEES over 3 is {s.landmark_nees:.1f} in the median (at "
        "most {p.landmark_band:g})",
        "Look at the birth: L_y R L_y', the prior L_n N L_n', and at the conversion to a Euclidean point.",
    ),
)


class Project:
    """An experiment that the student sets up, runs and is told about.

    Parameters
    ----------
    id, title : str
        "13.project".
    loop : generator function
        The reference. Its signature and docstring are those of the student's stub.
    scenario : str
        The reference's scenario, TOML.
    start : str
        What the student begins with: the same with gaps.
    hints : two str
    asks : sequence of callables
        Each takes the `UserData` and returns a sentence if the scenario is not the one of the task, else None.
    band : two float
        Where the mean NEES of right runs lies: measured over many seeds and settings, wider than the chi-square band,
        as an EKF is not linear and frames of one run are not independent.
    gain : float
        The error must stay below this share of the sigma of dead reckoning.
    least : float
        Share of the landmarks seen often that must be in the map.
    claims : three float
        Least and most sigma of the robots over that of the reference with the same data, and most of the landmarks.
    landmark_band : float
        Largest median of NEES / 3 of the landmarks (an honest one has 0.8).
    before, symptoms : sequence of Symptom
        Symptoms of this project alone, looked at first; and those of all projects.
    seeds : sequence of int
        Of the runs of a check, besides the student's own.
    seconds : float
        Limit for one run.
    sensor : int, optional
        Whose measurement space is shown.
    recording : callable, optional
        UserData -> Recording: a real log instead of the simulation.
    helpers : sequence of functions
        Other functions of the reference's cell, before the loop.
    """

    name, may_change = "run", ()
    remark = ""  # on the last picture
    beside_reference = True  # a run is measured beside one of the reference with the same data
    misconceptions, variants = (), ()  # of a run they are too slow for every audit: see tests/course/test_projects.py

    def __init__(
        self, id, title, loop, *, scenario, start, hints, asks=(), band, gain=0.75, least=LEAST, claims=CLAIMS,
        landmark_band=3.0, before=(), symptoms=SYMPTOMS, seeds=SEEDS, seconds=SECONDS, sensor=None,
        recording=None, helpers=(),
    ):  # fmt: skip
        self.id, self.title, self.loop, self.hints = id, title, loop, tuple(hints)
        self.scenario, self.start, self.asks = scenario, start, tuple(asks)
        self.band, self.gain, self.least, self.claims, self.landmark_band = band, gain, least, claims, landmark_band
        self._kept: dict = {}
        self.symptoms, self.seeds = (*before, *symptoms), tuple(seeds)
        self.seconds, self.sensor, self.recording, self.helpers = seconds, sensor, recording, tuple(helpers)

    # ---- the texts of the cell -----------------------------------------------------------------------------------

    @property
    def _last_line(self):
        return f'run = experiment("{self.id}", scenario, loop)'

    def _cell(self, scenario, *functions):
        return "\n".join(
            [f'scenario = """{scenario}"""', *(f"\n\n{text}" for text in functions), f"\n\n{self._last_line}"]
        )

    def source(self) -> str:
        """Return the reference as text for a notebook cell."""
        return self._cell(self.scenario, *self.texts())

    def texts(self) -> list[str]:
        """Return the functions of the reference, as text."""
        return [*map(_source, self.helpers), _source(self.loop)]

    def stub(self) -> str:
        """Return the text of the cell as a student gets it."""
        source = _source(self.loop)
        head = source.splitlines()[: _end_of_docstring(source)]
        return self._cell(self.start, "\n".join([*head, "    raise NotImplementedError  # your code here"]))

    def solution_between(self, begin, end) -> str:
        """Return the cell with all that the student must change between two marks, for nbgrader."""
        source = _source(self.loop)
        lines = source.splitlines()
        cut = _end_of_docstring(source)
        body = [*lines[:cut], f"    {begin}", *lines[cut:], "", *map(_source, self.helpers), "",
                f'scenario = """{self.scenario}"""', f"    {end}"]  # fmt: skip
        return self._cell(self.start, "\n".join(body))

    # ---- running -------------------------------------------------------------------------------------------------

    @property
    def reference(self) -> Run:
        """A run of the reference, which knows that it is one."""
        return self.run(self.scenario, self.loop, reference=True)

    def read(self, scenario):
        """Return the `UserData` of a text.

        Raises
        ------
        Failed
            With the reader's sentence, or with what the task asks for.
        """
        if not isinstance(scenario, str):
            raise Failed(f"the scenario is a text in TOML, got {type(scenario).__name__}", "Keep the three quotes.")
        try:
            data = UserData.from_text(scenario)
            answer = next((sentence for ask in self.asks if (sentence := ask(data))), None)
        except (ValueError, TypeError) as error:
            raise Failed(f"the scenario: {error}", "All keys are in docs/scenarios.md.") from None
        if answer:
            raise Failed(f"the scenario is not the one of the task: {answer}", "Read the task once more.")
        return data

    def run(self, scenario, loop, reference=False, watch=None) -> Run:
        """Run an experiment; what goes wrong is in the result."""
        run = Run(self, scenario, loop, reference=reference)
        try:
            run.data = self.read(scenario)
        except Failed as failed:
            run.failed = failed
            return run
        run.trial = self.trial(run, run.data.seed, watch)
        run.failed = run.trial.failed
        return run

    def trial(self, run, seed, watch=None) -> Trial:
        """Run the loop of a run with a seed."""
        recording = self.recording(run.data) if self.recording else None
        return run_trial(run.data, run.loop, seed, self.limit, recording, watch)

    @property
    def limit(self) -> float:
        """Seconds for one run; ``EKFSLAM_CHECK_SECONDS`` may give more."""
        return max(self.seconds * deadline.SLOWER, float(os.environ.get("EKFSLAM_CHECK_SECONDS", 0)))

    # ---- judging -------------------------------------------------------------------------------------------------

    @property
    def links(self):
        """What is tested, in order: as many as nbgrader notes."""
        return ("scenario", "loop", *(symptom.name for symptom in self.symptoms))

    def judge(self, run) -> Verdict:
        """Judge a run, and runs of its loop with other seeds. The reference is not judged."""
        if run is None or run is Ellipsis:
            return Verdict("not attempted")
        if not isinstance(run, Run) or run.project.id != self.id:
            got = f"a run of {run.project.id}" if isinstance(run, Run) else type(run).__name__
            hint = f"Run the cell that ends with `{self._last_line}`."
            return Verdict("failed", "is a run", f"a run of this project is wanted, got {got}", hint)
        if run.reference or (run.trial is not None and not run.trial.attempted):
            return Verdict("not attempted")
        if run.failed is not None:
            link = "scenario" if run.trial is None else "loop"
            return Verdict("failed", link, str(run.failed), run.failed.hint, printed=getattr(run.trial, "printed", ""))
        trials = [run.trial]
        for seed in self.seeds if self.recording is None else ():
            again = self.trial(run, seed)
            trials.append(again)
            if again.failed is not None:
                return Verdict("failed", "loop", f"with the seed {seed}: {again.failed}", again.failed.hint)
        return self.verdict(trials, self.kept_reference(run) if self.beside_reference else None)

    def kept_reference(self, run) -> Trial | None:
        """The reference with the data of a run; it is computed once for each scenario. None if it fails there."""
        if run.scenario not in self._kept:
            reference = Run(self, run.scenario, self.loop, run.data, reference=True)
            trial = self.trial(reference, run.data.seed)
            self._kept[run.scenario] = None if trial.failed else trial
        return self._kept[run.scenario]

    def verdict(self, trials, reference=None) -> Verdict:
        """What some runs of one loop show; `reference` is the reference with the data of the first."""
        s, summary = self.measured(trials, reference), self.summary(trials)
        p = _Stated(self, s)
        summary += f"; {s.seconds:.1f} s for a run"
        for symptom in self.symptoms:
            if symptom.shows(s, self):
                return Verdict(
                    "failed", symptom.name, symptom.says.format(s=s, p=p), symptom.hint, seconds=s.seconds, note=summary
                )
        return Verdict("passed", seconds=s.seconds, note=summary)

    def measured(self, trials, reference=None):
        """What the symptoms look at."""
        return scores(trials, reference)

    def summary(self, trials) -> str:
        """One line on some runs: NEES and its band, error, map."""
        if any(t is None or t.failed or not t.errors for t in trials):
            return "no result"
        s = scores(trials)
        runs = f"{len(trials)} runs of {s.frames} frames" if len(trials) > 1 else f"{s.frames} frames"
        known = (
            f", angles of the mounting known to {100 * s.mounting_sigma:.0f} % of the start"
            if s.mounting_sigma >= 0
            else ""
        )
        return (
            f"{runs}: mean NEES {s.nees:.1f} (honest {s.dof}, band {self.band[0]:g} to {self.band[1]:g}), position off "
            f"by {s.error:.2f} m in the last third (dead reckoning {s.dead_error:.2f} m), {s.landmarks:.0f} landmarks "
            f"in the map ({100 * s.share:.0f} % of those seen often), median error of a landmark "
            f"{s.landmark_error:.2f} m{known}"
        )


@dataclass
class _Stated:
    """A project's limits, for the sentences."""

    project: Project
    scores: Scores

    def __getattr__(self, name):
        return getattr(self.project, name)

    @property
    def gain_m(self):
        return self.project.gain * self.scores.dead_sigma


def is_stub(loop) -> bool:
    """Return True for a loop that is not begun: it yields nothing, and raises NotImplementedError."""
    names = getattr(getattr(loop, "__code__", None), "co_names", ())
    return "NotImplementedError" in names and not inspect.isgeneratorfunction(loop)


def _end_of_docstring(source) -> int | None:
    """The last line of a function's docstring."""
    function = ast.parse(source).body[0]
    assert isinstance(function, ast.FunctionDef)
    return function.body[0].end_lineno


def _source(function) -> str:
    return textwrap.dedent(inspect.getsource(function)).rstrip()
