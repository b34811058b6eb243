"""The noise of a log, number by number, by the likelihood of its innovations: no truth is asked.

A first guess is cautious, and a filter that is told too much noise is not wrong, but it is not sharp either: its NIS
is below what is expected. Here each standard deviation of the scenario, of controls and of measurements, is moved until
the innovations of the log are as likely as can be:

    s(noise) = sum over innovations of min(z' Z^-1 z, gate) + log |Z|,

one number after the other, by a parabola over its logarithm. Of controls, of which a log often tells little, two
standard deviations more are taken, the largest noise that the log does not contradict: a filter that is told too little
is over-confident. `analysis.tuning` finds one factor for all of them, and
what is wrong beside the noise; it begins well where this ends.

Source: the prediction error decomposition of the likelihood (F. C. Schweppe, "Evaluation of likelihood functions for
Gaussian signals", IEEE Trans. Information Theory 11(1), 1965).
"""

from copy import deepcopy
from dataclasses import dataclass, field, replace

import numpy as np

from ..slam import KnownIds
from ..toolbox import UserData, universal_slam
from ..toolbox.recordings import Recording
from ..toolbox.scenario.robots import std_key
from .innovations import Innovations
from .tuning import OUTLIER, parabola

ENOUGH = 1000
"""So many measurements tell a standard deviation to 3 %; what comes later is not looked at."""
MOST_FRAMES = 6000
SWEEPS = np.log(2.0), np.log(2.0), np.log(1.3)
"""Steps of the parabolas, in the logarithm."""
FARTHEST = np.log(40.0)
"""No number moves farther from the guess."""
TELLS = 4.0
"""A parabola that rises by less on both sides, in -2 log likelihood, does not tell: two standard deviations."""
LITTLE = 1.0
"""What is gained by less than this is not gone after."""
CAUTIOUS = np.log(3.0)
"""Noise of controls is taken two standard deviations above the likeliest, by this at most: too little is worse."""
FEWEST = 30
"""Innovations that a log must have."""
MOST_REFUSED = 0.5
"""A fit after which the gate refuses a larger share explains nothing: it has fitted what is left."""
NIS_BAND = 0.3, 3.0
"""Nor does one after which the NIS is not within so many times what is expected; an honest one is near 1."""
OF_THE_START = "position_std", "orientation_std", "orientation_std_deg", "vel_std", "ang_vel_std_deg"


@dataclass
class NoiseFit:
    """Result of a fit.

    Parameters
    ----------
    scenario : dict
        The tables, with the noise that was found.
    recording : Recording
        With the covariances of controls that were found.
    changes : dict of str to (float, float)
        By key, `sensor.1.range_std`: what was guessed, and what was found.
    untold : list of str
        Keys of which the log does not tell; they stay.
    nis : (float, float)
        Mean of z' Z^-1 z over those used, before and after.
    expected : float
        The mean length of an innovation: what an honest filter has.
    n, frames, runs : int
        Innovations, frames, runs of the filter.
    refused : float
        Share of innovations that the gate refuses, after.
    """

    scenario: dict
    recording: Recording
    changes: dict = field(default_factory=dict)
    untold: list = field(default_factory=list)
    nis: tuple = (float("nan"), float("nan"))
    expected: float = float("nan")
    n: int = 0
    frames: int = 0
    runs: int = 0
    refused: float = 0.0

    @property
    def explains(self):
        """True if most innovations are as large as what was found says; else the guess is kept."""
        return self.refused <= MOST_REFUSED and NIS_BAND[0] < self.nis[1] / self.expected < NIS_BAND[1]

    def __str__(self):
        if not self.changes:
            return f"noise: {self.n} innovations are too few to tell it; the guess stays"
        if not self.explains:
            return (
                f"no noise explains this log: NIS {self.nis[0]:.2f} as guessed, {self.expected:.2g} is expected; "
                f"the likeliest noise refuses {100 * self.refused:.0f} % of {self.n:,} innovations, with a NIS of "
                f"{self.nis[1]:.2f}. The guess is kept.\nFirst look at the mounting (--set scan.position=[x,y], "
                "scan.orientation_deg), signs (clockwise), units and ids"
            )
        moved = ", ".join(f"{key} {old:.3g} -> {new:.3g}" for key, (old, new) in self.changes.items())
        words = [
            f"noise by the likelihood of {self.n:,} innovations in the first {self.frames:,} frames: {moved}",
            f"NIS, {self.expected:.2g} is expected: {self.nis[0]:.2f} as guessed, now {self.nis[1]:.2f}",
        ]
        return "\n".join(
            words + [f"the log does not tell, so the guess stays: {', '.join(self.untold)}"] * bool(self.untold)
        )


def fit_noise(scenario, recording, after_run=lambda: None, told=()):
    """Find the noise of a log by the likelihood of its innovations.

    Parameters
    ----------
    scenario : dict
        Tables of a scenario file, with a guess of each standard deviation, not too small.
    recording : Recording
    after_run : callable
        Is called after each run of the filter.
    told : list of str
        Keys that are known otherwise, `sensor.2.heading_std_deg`, and stay.

    Returns
    -------
    NoiseFit

    See Also
    --------
    tune : One factor for all of it, and clock, mounting and bias.
    """
    return _Fit(scenario, recording, after_run, told).all()


class _Fit:
    def __init__(self, scenario, recording, after_run, told=()):
        self.scenario, self.recording, self.after_run = scenario, recording, after_run
        counts = sum(np.diff(log.offsets) for log in recording.raw.values())
        k = int(np.searchsorted(np.cumsum(counts), ENOUGH)) + 1
        self.last = min(k, len(recording), MOST_FRAMES)
        self.numbers = [number for number in numbers(scenario, recording) if number.name not in told]
        self.runs, self.known = 0, {}
        self.above = {}  # of each logarithm: how far above the likeliest one the log contradicts it

    def all(self):
        found, whole = NoiseFit(self.scenario, self.recording, frames=self.last), self.recording
        at = {number.name: 0.0 for number in self.numbers}  # logarithms of factors on the guess
        found.n = len(self.run(at, first=True))
        if found.n < FEWEST:
            return found
        before, told = self.run(at), set()
        for step in SWEEPS:
            told |= {name for name in at if self.move(at, name, step)}
        at |= {n.name: at[n.name] + self.above.get(n.name, 0.0) for n in self.numbers if n.entry[0] == "robot"}
        after, found.untold = self.run(at), [name for name in at if name not in told]
        found.expected, found.runs, found.n = before.dof(), self.runs, len(before)
        found.nis, found.refused = (before.size() * before.dof(), after.size() * after.dof()), after.refused()
        found.changes = {n.name: (n.value, float(n.value * np.exp(at[n.name]))) for n in self.numbers}
        self.recording = whole  # with the ids of the log
        if found.explains:
            found.scenario, found.recording = self.with_noise(at)
        return found

    def move(self, at, key, step):
        """Move one number to the foot of its valley; return False if the log does not tell of it."""
        values = {x: self.surprise(at | {key: x}) for x in (at[key] - step, at[key], at[key] + step)}
        while True:
            best, vertex, bend = parabola(values)
            second = sorted(values.values())[1]
            if vertex is not None or abs(best) > FARTHEST or second - values[best] < LITTLE:
                break
            values |= {x: self.surprise(at | {key: x}) for x in (best - step, best + step) if x not in values}
        if max(values.values()) - values[best] < TELLS:
            return False
        if vertex is not None:
            values[vertex] = self.surprise(at | {key: vertex})
            at[key] = min(values, key=lambda x: values[x])
            self.above[key] = min((TELLS / bend) ** 0.5, CAUTIOUS)
        else:  # less does not make the log more likely
            rise = np.array(sorted((values[x] - values[best], x) for x in values if x >= best))
            at[key], self.above[key] = best, float(np.interp(TELLS, rise[:, 0], rise[:, 1])) - best
        return True

    def surprise(self, at):
        """-2 log likelihood of the log with these factors, up to a constant."""
        key = tuple(at.values())
        if key not in self.known:
            innovations = self.run(at)
            self.known[key] = innovations.surprise(self.cap) * self.n
        return self.known[key]

    def run(self, at, first=False):
        """Innovations of the first frames; the first run says whose measurement each is, where ids are not known."""
        table, recording = self.with_noise(at)
        data = UserData.from_dict(table | {"time": table.get("time", {}) | {"last": self.last}})
        innovations, whose = Innovations(), {}
        by_id = getattr(data.options.association, "by_id", False)
        if not by_id and not first:
            data = replace(data, options=replace(data.options, association=KnownIds()))
        for now in universal_slam(data, recording):
            innovations.add(now)
            if first and not by_id:
                whose[now.k] = [(o.sen, o.index, o.lmk) for o in now.obs.values() if o.matched]
        if first:
            self.cap, self.n = min(data.options.md2_threshold, OUTLIER), len(innovations)
            if not by_id:
                self.recording = named(self.recording, whose)
        self.runs += 1
        self.after_run()
        return innovations

    def with_noise(self, at):
        """The scenario and the recording with these logarithms of factors."""
        table, robots = deepcopy(self.scenario), dict(self.recording.robots)
        for number in self.numbers:
            number.times(float(np.exp(at[number.name])), table, robots)
        return table, replace(self.recording, robots=robots)


def named(recording, whose):
    """A recording with the ids that a filter found; -1 where it found none.

    Parameters
    ----------
    recording : Recording
    whose : dict of int to list of (int, int, int)
        By frame: sensor, row of its measurements, landmark.
    """
    ids = {id: np.full(len(log.ids), -1) for id, log in recording.raw.items()}
    for k, rows in whose.items():
        for sensor, row, lmk in rows:
            ids[sensor][recording.raw[sensor].offsets[k - 1] + row] = lmk
    return replace(recording, raw={id: replace(log, ids=ids[id]) for id, log in recording.raw.items()})


class Number:
    """A standard deviation that can be found: of the scenario, of controls with a U of their own, or of both.

    Parameters
    ----------
    entry : (str, int)
        Its part of the scenario, and which: "sensor", 0.
    key : str
    value : float
        The guess.
    robot : int, optional
        Whose U in the recording goes with it, in these `columns`.
    """

    def __init__(self, entry, key, value, robot=None, columns=None):
        self.entry, self.key, self.value, self.robot, self.columns = entry, key, float(value), robot, columns
        self.name = f"{entry[0]}.{entry[1] + 1}.{key}"

    def times(self, factor, scenario, robots):
        """Put the factor into tables and into controls, both one's own copies."""
        table = scenario[self.entry[0]][self.entry[1]]
        if self.key in table:
            table[self.key] = float(f"{self.value * factor:.3g}")
        if self.robot is not None:
            log = robots[self.robot]
            d = np.ones(log.u.shape[1])
            d[self.columns] = factor
            robots[self.robot] = replace(log, U=d[:, None] * log.U * d)


def numbers(scenario, recording):
    """All `Number`s of a scenario and its recording."""
    data, found = UserData.from_dict(scenario), []
    for i, (entry, sensor) in enumerate(zip(scenario["sensor"], data.sensors, strict=True)):
        if sensor.id in recording.raw and recording.raw[sensor.id].R is not None:
            continue  # each measurement has its own
        found += [Number(("sensor", i), key, v) for key, v in entry.items() if key == "std" or "_std" in key]
    for i, (entry, robot) in enumerate(zip(scenario["robot"], data.robots, strict=True)):
        found += [Number(("robot", i), key, entry[key]) for key in ("gyro_noise", "acc_noise") if key in entry]
        log, at = recording.robots.get(robot.id), 0
        for name, n in robot.motion.control_fields.items():
            key, columns = std_key(name), slice(at, at + n)
            at += n
            if log is not None and log.U is not None:
                std = float(np.sqrt(np.median(np.diagonal(log.U, axis1=1, axis2=2)[:, columns])))
                std = entry.get(key, np.rad2deg(std) if key.endswith("_deg") else std)
                found.append(Number(("robot", i), key, std, robot.id, columns))
            elif key in entry:
                found.append(Number(("robot", i), key, entry[key]))
    return [number for number in found if number.key not in OF_THE_START and number.value > 0]
