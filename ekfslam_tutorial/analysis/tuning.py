"""Noise, mounting, clock and bias from a log alone: no truth is asked.

In this order, because each makes the next one easier:

1. the share of the noise that lasts while a robot stands still, by the scatter of what it sees there;
2. how late the controls are, by likelihood: a parabola through three runs or more;
3. the yaw of each sensor, as a state of the filter (`frame_in_map`);
4. by how much ranges are too long, by likelihood;
5. one factor on R and U: by the likelihood where the innovations are white. Else by two numbers that do not err in the
   same way, of which it is the geometric mean: the sums of corrections (`analysis.corrections`), along the axes of the
   map or of the robot, whichever are too large by more; and what the residuals do to the pose (`analysis.influence`).
   Of several robots in one map the sums are those that each robot's own looks make of its pose: what one robot sees
   moves all that are correlated with it, and so each look counts once.

What was found is kept only if it is three standard deviations from nothing; these are widened by the root of the
correction ratio, for errors that last make a log look longer than it is.
"""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ..ekf import chi_square
from ..toolbox.adjusted import RATES, STEPS, places, sightings_from_one_place
from ..toolbox.universal_slam import universal_slam
from .corrections import FEWEST, SecondSums, correction_ratio
from .factors import GraphMaker
from .influence import influence
from .innovations import Innovations

YAW_STD_DEG = 2.0
"""How well a mounting is known to begin with."""
SURE = 3.0
"""So many standard deviations from nothing is something."""
CLOCK_STEP, BIAS_STEP = 0.05, 1.0
"""Steps of the parabolas: s, or a frame if that is longer; and standard deviations of the range."""
MOST_RUNS, NEAR = 8, 0.25
"""Of one parabola; it is found if its vertex is so near to the lowest run, in steps."""
FLAT = 1e-9
"""Runs that differ by less in their surprise do not differ."""
AXES = "map", "robot"
"""Corrections are summed along the axes of the one and of the other."""
OFTEN = 0.02
"""So large a share of the sightings must be repetitions, from a place where the robot stands."""
WHITE = 0.1
"""Innovations with less correlation than this, and chance, from one to the next of a landmark are white."""
OUTLIER = 25.0
"""A squared innovation counts as at most this, or as the gate, in the likelihood."""
CLOSE = 0.03
"""A factor that changes by less than this is found."""
ROUNDS = 4
BLIND = (
    "errors common to all measurements, but for a turned sensor and a range that is too long",
    "the filter's own over-confidence where its models are far from linear",
    "noise that is told too large, where errors last: the sums of corrections tell no factor below 1",
    "the ratio of R to U, and which of controls and ranges is wrong where they disagree",
)
"""What nothing of this can see."""


class Stopped(Exception):
    """The user has stopped the tuning."""


@dataclass(frozen=True)
class Finding:
    """One number that the log has told.

    Parameters
    ----------
    what, unit : str
    value, std : float
        std is one standard deviation, widened by the root of the correction ratio.
    kept : bool
        It is in the scenario.
    why_not : str
        Why it is not.
    """

    what: str
    unit: str
    value: float
    std: float
    kept: bool
    why_not: str = "not sure enough"

    def __str__(self):
        fate = "kept" if self.kept else f"not kept: {self.why_not}"
        return f"{self.what}: {self.value:+.3g} +- {self.std:.2g} {self.unit} ({fate})"


@dataclass
class Tuning:
    """Result of `tune`.

    Parameters
    ----------
    findings : list of Finding
    factor : float
        Of R and U. NaN if the log is too short.
    band : (float, float)
        95 % band of the factor, from the number of blocks, or innovations, alone.
    by : str
        What the factor was found by, in words.
    before, after : CorrectionRatio or None
        Of the first run and of the last one, with all that was found.
    nis : (float, float), expected : float
        Mean NIS of innovations that were used, of the first run and of the last one; and their mean length.
    sensor, robot : dict
        Changes for all sensors, and for all robots, of the scenario, but for the factor.
    complete : bool
        False if it was stopped: what was found so far is right, and not all.
    """

    findings: list = field(default_factory=list)
    factor: float = float("nan")
    band: tuple = (float("nan"), float("nan"))
    by: str = ""
    before: Any = None
    after: Any = None
    nis: tuple = (float("nan"), float("nan"))
    expected: float = float("nan")
    sensor: dict = field(default_factory=dict)
    robot: dict = field(default_factory=dict)
    complete: bool = False


@dataclass
class Trial:
    """A run with some changes, as far as the search needs it."""

    ratio: Any
    axes: str
    innovations: Innovations
    yaws: dict
    cap: float

    @property
    def surprise(self):
        """-2 log likelihood of an innovation, on average."""
        return self.innovations.surprise(self.cap)


def tune(data, recording, progress=lambda name, n_frames: lambda: None):
    """Find what a log tells about its noise, mounting, clock and bias.

    Parameters
    ----------
    data : UserData
        A scenario that fits the recording: see `datasets.prepare`.
    recording : Recording or None
        None for the scenario's own simulation.
    progress : callable
        (name of a run, number of its frames) -> a function to call after each frame. It may raise `Stopped`.

    Returns
    -------
    Tuning
    """
    search = _Search(data, recording, progress)
    try:
        search.all()
    except Stopped:
        pass
    return search.found


class _Search:
    """The search, step after step; what was found so far is in `found` at any time."""

    def __init__(self, data, recording, progress):
        self.data, self.recording, self.progress, self.found = data, recording, progress, Tuning()

    def all(self):
        self.now = self.run("as it is")
        self.found.before, first = self.now.ratio, self.now.innovations
        self.settle_factor()
        if self.recording is not None:
            self.halts()
            self.clock()
        self.yaw()
        if self.recording is not None:
            self.bias()
        self.factor()
        self.found.expected = first.dof()
        self.found.nis = tuple(one.size() * one.dof() for one in (first, self.now.innovations))
        self.found.complete = True

    def run(self, name, sensor=None, robot=None):
        """Run the scenario with what was found so far, and with some more changes."""
        data = changed(self.data, self.found.sensor | (sensor or {}), self.found.robot | (robot or {}))
        run = universal_slam(data, self.recording)
        after_frame = self.progress(name, len(run))
        sums = {axes: {r.id: SecondSums(r.frame, along_robot=axes == "robot") for r in data.robots} for axes in AXES}
        innovations, s = Innovations(), None
        for s in run:
            for id, by, *poses in s.corrected:
                if by == id:  # in a map of several robots each look counts once
                    for each in sums.values():
                        each[id].add(s.t, *poses)
            innovations.add(s)
            after_frame()
        ratios = {axes: correction_ratio([one.arrays for one in each.values()]) for axes, each in sums.items()}
        axes = max(AXES, key=lambda axes: np.nan_to_num(ratios[axes].value))
        return Trial(ratios[axes], axes, innovations, _yaws(s), min(data.options.md2_threshold, OUTLIER))

    # --- halts ---

    def halts(self):
        """The share of the noise that lasts while a robot stands still.

        There the same error is measured again and again: what a landmark's sightings from one place scatter is less
        than R says. White noise that is told too large does so, too; but its innovations are white.
        """
        r, n = self.now.innovations.whiteness()
        motions = {robot.id: robot.motion for robot in self.data.robots}
        if any(motion.size != motion.frame.size for motion in motions.values()):
            return
        parts = [self.scatter(s, motions[s.robot]) for s in self.data.sensors]
        total, dof, n_numbers = (sum(column) for column in zip(*parts, strict=True))
        if not dof:
            return
        share, chance = 1 - total / dof, np.sqrt(2 / dof)
        white = not n or abs(r) < WHITE + SURE / np.sqrt(n)
        kept = bool(dof >= max(FEWEST, OFTEN * n_numbers) and share > SURE * chance and not white)
        what = "share of the noise that lasts while the robot stands"
        self.found.findings.append(Finding(what, "of R", float(share), float(chance * total / dof), kept))
        if kept:
            self.found.sensor |= {"lasting": round(float(share), 4)}
            self.now = self.run("with sightings from one place counted once")
            self.settle_factor()

    def scatter(self, sensor, motion):
        """Sum of the squared distances, in terms of R, of sightings from the mean of those from one place; its degrees
        of freedom; how many numbers were measured."""
        log, model = self.recording.raw[sensor.id], sensor.model
        if not len(log.y):
            return 0.0, 0, 0
        group, size = sightings_from_one_place(log, places(self.recording.robots[sensor.robot].u, motion))
        first = np.unique(group, return_index=True)[1]
        z = model.residual(log.y, log.y[first][group])
        mean = np.zeros((len(size), z.shape[1]))
        np.add.at(mean, group, z / size[group][:, None])
        z = z - mean[group]
        R = sensor.noise_factor * (np.tile(model.R, (len(z), 1, 1)) if log.R is None else log.R)
        total = np.einsum("ki,ki->", z, np.linalg.solve(R, z[..., None])[..., 0])
        return float(total), int((size - 1).sum()) * z.shape[1], z.size

    # --- mounting ---

    def yaw(self):
        """The yaw of all sensors in the plane as states; kept if one of them is surely not as it was said.

        That of a single sensor is written down as it was found, and how well: a run then begins with it, and does not
        turn its map when it learns of it. Of several the scenario has one entry, so their states begin at the old yaw.
        Ranges alone are the same, however their sensor is turned.
        """
        if all(getattr(s.model, "units", ()) == ("m",) for s in self.data.sensors):
            return
        fixed = [s for s in self.data.sensors if not s.frame_in_map]
        if not fixed or len(fixed) < len(self.data.sensors) or self.data.frame.dim != 2:
            return
        state = {"frame_in_map": True, "orientation_std_deg": YAW_STD_DEG}
        trial = self.run("with the sensors' yaw as states", sensor=state)
        wide = np.sqrt(trial.ratio.factor)
        start = {s.id: float(np.ravel(s.orientation_deg)[0]) if s.orientation_deg is not None else 0.0 for s in fixed}
        off = {id: (yaw - start[id], wide * std) for id, (yaw, std) in trial.yaws.items()}
        kept = any(abs(value) > SURE * std for value, std in off.values())
        self.found.findings += [Finding(f"yaw of sensor {id}", "deg", *each, kept) for id, each in off.items()]
        if kept:
            self.found.sensor |= state
            self.now = trial
            if len(off) == 1:
                ((id, (value, std)),) = off.items()
                self.found.sensor |= {
                    "orientation_deg": round(start[id] + value, 3),
                    "orientation_std_deg": round(float(std), 3),
                }
                self.now = self.run("with the yaw that was found")
            self.settle_factor()

    # --- what is found by likelihood ---

    def clock(self):
        """Delay of the controls, the same for all.

        Runs are compared whose controls are whole frames apart, or nearly. In between, two controls are averaged, which
        makes their noise smaller: such runs look better than they are.
        And each run has the noise of other controls: it must gain more than that may do by chance.
        """
        if all(isinstance(robot.motion, STEPS + RATES) for robot in self.data.robots):
            start = self.data.robots[0].clock_offset
            change = lambda value: {"robot": {"clock_offset": start + value}}
            self.by_likelihood("controls later than their stamps by", "s", self.frame_step(), change, whole=True)

    def frame_step(self):
        """Usual time between two frames, s."""
        dt = np.diff(self.recording.t)
        return max(CLOCK_STEP, float(np.median(dt[dt > 0]))) if (dt > 0).any() else CLOCK_STEP

    def bias(self):
        """By how much the ranges are too long, of all sensors alike.

        A bias below the standard deviation that the filter is told is not kept: R covers it, and an odometry that is
        some per cent too long looks the same.
        """
        model = self.data.sensors[0].model
        units = getattr(model, "units", ())
        if units.count("m") != 1 or any(type(s.model) is not type(model) for s in self.data.sensors):
            return
        j, start = units.index("m"), self.data.sensors[0].biases()
        change = lambda value: {"sensor": {"bias": (start + value * np.eye(len(units))[j]).tolist()}}
        self.by_likelihood("ranges too long by", "m", BIAS_STEP * self.range_std(j), change, self.range_std(j))

    def range_std(self, j):
        """Typical standard deviation of number j of a measurement."""
        logs = [self.recording.raw[s.id].R for s in self.data.sensors]
        R = [s.model.R[None] if own is None else own for s, own in zip(self.data.sensors, logs, strict=True)]
        return float(np.sqrt(np.median(np.concatenate([each[:, j, j] for each in R]))))

    def by_likelihood(self, what, unit, step, change, least=0.0, whole=False):
        """The value with the greatest likelihood, by the vertex of a parabola; kept if surely more than `least`.

        With `whole`, runs are made at whole steps only.
        """
        trials = {0.0: self.now}
        at = lambda k: self.run(f"{what} {k * step:+.3g} {unit}", **change(k * step))
        trials |= {k: at(k) for k in (-1.0, 1.0)}
        while len(trials) < MOST_RUNS:
            best, vertex, _ = parabola({k: trial.surprise for k, trial in trials.items()})
            if vertex is None and best in (min(trials), max(trials)) and FLAT < self.spread(trials):
                trials[2 * best] = at(2 * best)
            elif vertex is None or abs(vertex - best) < NEAR or (whole and round(vertex) in trials):
                break
            else:
                k = float(round(vertex)) if whole else vertex
                trials[k] = at(k)
        best, vertex, bend = parabola({k: trial.surprise for k, trial in trials.items()})
        if vertex is None or self.spread(trials) < FLAT:  # no minimum: the log does not tell
            self.found.findings.append(Finding(what, unit, 0.0, float("inf"), False, "the log does not tell"))
            return
        value, middle = step * vertex, best
        n, wide = len(trials[middle].innovations), np.sqrt(trials[middle].ratio.factor)
        std = wide * step / np.sqrt(n * bend)
        kept, why_not = bool(abs(value) > least + SURE * std), "not sure enough: nothing is within three sigma"
        if not kept and abs(value) > SURE * std:
            why_not = f"R covers it: {least:.2g} {unit}"
        if kept:
            trial = self.run(f"{what} {value:+.3g} {unit}", **change(value))
            chance = SURE * np.sqrt(4 * n * trial.innovations.dof()) if whole else 0.0
            kept = n * (self.now.surprise - trial.surprise) > chance
            why_not = "not sure enough: with it, the log is not more likely than chance makes it"
        if kept:
            self.now = trial
            for part, values in change(value).items():
                getattr(self.found, part).update(values)
            self.settle_factor()
        self.found.findings.append(Finding(what, unit, float(value), float(std), kept, why_not))

    @staticmethod
    def spread(trials):
        """Largest difference of the surprise."""
        return float(np.ptp([trial.surprise for trial in trials.values()]))

    # --- noise ---

    def settle_factor(self):
        """The factor by the sums of corrections, of the run so far; 1 if it may be so large by chance."""
        ratio = self.now.ratio
        self.set_factor(
            factor_of_both(ratio, None), "sums of corrections", ratio.by_length.get(ratio.seconds, (0, 0))[1]
        )
        if not np.isfinite(ratio.value):
            self.found.factor, self.found.by = float("nan"), "nothing: the log is too short"

    def set_factor(self, factor, by, dof):
        """Note a factor, its origin and its band."""
        band = [dof / float(chi_square.quantile(p, dof)) for p in (0.975, 0.025)] if dof else [np.nan] * 2
        self.found.factor, self.found.by = float(factor), by
        self.found.band = tuple(float(factor * b) for b in band)

    def factor(self):
        """One factor on R and U, and a last run with it."""
        as_it_is, (r, n) = self.now, self.now.innovations.whiteness()
        if n and abs(r) < WHITE + SURE / np.sqrt(n):
            self.by_size(r)
        if self.now.ratio.too_large:  # not white, or white and not enough
            self.now = as_it_is
            self.settle_factor()
        if np.isfinite(self.found.factor) and self.now is as_it_is:
            self.by_lasting_errors()
            self.found.by += f"; innovations correlate by {r:.2f}"
            self.now = self.with_factor(self.found.factor)
        self.found.after = self.now.ratio

    def by_lasting_errors(self):
        """The sums of corrections tell that errors last; the residuals, what they do to the pose."""
        ratio, its, why_not = self.now.ratio, None, ""
        if ratio.value > 1:
            try:
                its = self.what_residuals_do()
            except ValueError as error:  # lines, an IMU, or a run too far from its smooth path
                why_not = f"; by these alone, for {error}"
        sums = f" over {ratio.seconds} s along the axes of the {self.now.axes}"
        if its is None:
            self.found.by += (
                sums + f" ({ratio.value:.2f} may be chance)" * (ratio.value > 1 and not ratio.sure) + why_not
            )
            return
        if np.isfinite(its.scale):
            scale, std = 100 * its.scale, 100 * its.scale_std
            why_not = "the log does not say which of the two is wrong" if its.disagree else "not sure enough"
            self.found.findings.append(Finding("controls longer than ranges say by", "%", scale, std, False, why_not))
        factor = factor_of_both(ratio, its)
        self.set_factor(factor, "sums of corrections", ratio.by_length[ratio.seconds][1])
        self.found.by += f"{sums} ({ratio.value:.2f}) and what residuals do to the pose ({its.factor:.2f})"
        self.found.by += "; it may be chance" * (factor == 1)

    def what_residuals_do(self):
        """The influence of the residuals of the run so far."""
        data = changed(self.data, self.found.sensor, self.found.robot)
        maker, run = GraphMaker(data, self.recording), universal_slam(data, self.recording)
        after_frame = self.progress("once more, for its residuals", len(run))
        for s in run:
            maker.add(s)
            after_frame()
        return influence(maker.finish(), lambda: self.progress("what residuals do to the pose", 1)())

    def by_size(self, r):
        """White innovations: the mean of z' Z^-1 z over what it should be is the factor of greatest likelihood.

        It is 1 where chance explains the difference, as it is by the sums of corrections.
        """
        factor = 1.0
        for _ in range(ROUNDS):
            innovations = self.now.innovations
            m, gate = innovations.dof(), self.data.options.md2_threshold
            passed = float(chi_square.cdf(gate, m + 2) / chi_square.cdf(gate, m)) if gate < np.inf else 1.0
            step = innovations.size() / passed
            factor *= step
            by = f"likelihood: innovations are white, they correlate by {r:.2f}"
            self.set_factor(factor, by, len(innovations) * m)
            self.now = self.with_factor(factor)
            if abs(step - 1) < CLOSE:
                break
        low, high = self.found.band
        if low <= 1 <= high:
            self.found.factor, self.found.by = 1.0, f"{by}; {factor:.2f} may be chance"
            self.now = self.with_factor(1.0)

    def with_factor(self, factor):
        sensor, robot = ({"noise_factor": factor * e[0].noise_factor} for e in (self.data.sensors, self.data.robots))
        return self.run(f"R and U times {factor:.3g}", sensor, robot)


def factor_of_both(ratio, its):
    """One factor by the sums of corrections and by what the residuals do to the pose: their geometric mean.

    The sums see all errors that last, and shout at those of the controls, which the pose forgets at the next landmark.
    The residuals tell what reaches the pose, and do not see what all measurements have in common. It is 1 if neither
    surely tells that something lasts.

    Parameters
    ----------
    ratio : CorrectionRatio
    its : Influence or None
        None where the run cannot be smoothed: the sums decide alone.
    """
    if its is None:
        return ratio.factor if ratio.sure else 1.0
    lasts = ratio.value > 1 and (ratio.sure or its.disagree)
    return float(np.sqrt(ratio.factor * its.factor)) if lasts else 1.0


def parabola(values):
    """The lowest of some values of a function, and the parabola through it and its neighbours.

    Parameters
    ----------
    values : dict of float to float
        Function values, by argument.

    Returns
    -------
    best : float
        The argument of the lowest value.
    vertex : float or None
        Where the parabola is lowest; None if the lowest value is at an end.
    bend : float
        Half its second derivative.
    """
    at = sorted(values)
    best = min(at, key=values.get)
    i = at.index(best)
    if i in (0, len(at) - 1):
        return best, None, 0.0
    bend, slope, _ = np.polyfit(np.array(at[i - 1 : i + 2]) - best, [values[k] for k in at[i - 1 : i + 2]], 2)
    return best, float(best - slope / (2 * bend)), float(bend)


def changed(data, sensor, robot):
    """A scenario with some attributes of all its sensors, and of all its robots, changed."""
    sensors, robots = [replace(s, **sensor) for s in data.sensors], [replace(r, **robot) for r in data.robots]
    return replace(data, sensors=sensors, robots=robots)


def _yaws(snapshot):
    """Yaw and its standard deviation, deg, of the sensors in the map, in the plane, by id."""
    yaws = {}
    for sen in snapshot.sens:
        if sen.r is not None and sen.r.stop - sen.r.start == 3:
            x, P = sen.state(snapshot.map), snapshot.map.block(sen.r)
            yaws[sen.id] = float(np.rad2deg(x[2])), float(np.rad2deg(np.sqrt(P[2, 2])))
    return yaws
