"""Project 17: make a run in space honest, and show it by a band."""

import time

import numpy as np

from ...analysis import anees_band
from ...toolbox import universal_slam
from .. import asks, deadline, guard
from ..exercises.nb17_band import in_band
from ..exercises.nb17_nees import pose_nees
from ..expect import Failed
from ..project import Project, Symptom, scores
from ..trial import Trial

RUNS = 8  # of the Monte Carlo that a check makes
ERROR = 0.6  # of the error of dead reckoning: more is no SLAM

SCENARIO = """
name = "honest in the cloister"
seed = 1
time = {dt = 0.1, last = 60}
world = {type = "cloister"}
landmark = {type = "euc_pnt"}
options = {n_inits = [10, 1], n_updates = 10}

[[robot]]
motion = "odometry3"
position = [0, -5, 0]
dx = [0.08, 0, 0]
da_deg = [0, 0, 0.9]
dx_std = 0.01
da_std_deg = 0.1

[[sensor]]
type = "pin_hole_depth"
position = [0, 0, 0.6]
orientation_deg = [-90, 0, -90]
pixel_std = 1.0
depth_std = 0.1
"""

START = """
name = "dishonest in the cloister"
seed = 1
time = {dt = 0.1, last = 60}
world = {type = "cloister"}
landmark = {type = "hmg_pnt", non_obs_mean = 0.2, non_obs_std = 0.1}
options = {n_inits = [10, 1], init_margin = 25.6, n_updates = 10}

[[robot]]
motion = "odometry3"
position = [0, -5, 0]
dx = [0.08, 0, 0]
da_deg = [0, 0, 0.9]
dx_std = 0.01
da_std_deg = 0.1

[[sensor]]
type = "pin_hole"
position = [0, 0, 0.6]
orientation_deg = [-90, 0, -90]
pixel_std = 1.0
# The robot, the world and the noise of the pixels are given. The camera, the landmark and the options are yours.
"""


def loop(data, seeds):
    """Measure how honest a scenario is, from several runs.

    data: the scenario, as `universal_slam(data, seed=seed)` takes it. seeds: one for each run.
    After each frame `now` of a run, with rob = now.robs[0], the estimated pose is now.map.x[rob.r], shape (7,), its
    covariance now.map.P[rob.r, rob.r], shape (7, 7), and the true pose now.truth[rob.id], shape (7,).
    Return the NEES, shape (runs, frames), by your `pose_nees`, which takes N poses at once (N may be 1); and for each
    frame whether the filter is honest, True or False, shape (frames,), by your `in_band`.
    """
    nees = []
    for seed in seeds:
        row = []
        for now in universal_slam(data, seed=seed):
            rob = now.robs[0]
            pose, true = now.map.x[rob.r], now.truth[rob.id]
            row += list(pose_nees(pose[None], now.map.P[rob.r, rob.r][None], true[None]))
        nees.append(row)
    return np.array(nees), in_band(np.array(nees), 6)


class Honest(Project):
    """A project whose loop is a Monte Carlo: it measures how honest a scenario is, and that is measured beside it."""

    beside_reference = False  # but beside the package, with the same seeds

    def __init__(self, *args, share, **options):
        super().__init__(*args, **options)
        self.share = share

    def trial(self, run, seed, watch=None):
        """Run the scenario by the package and measure it; hand the loop the same seed."""
        trial, began = Trial(seed), time.perf_counter()
        try:
            for now in universal_slam(run.data, seed=seed):
                if watch is not None and watch.live:
                    watch.take(now)
                note(trial, now)
        except (ValueError, TypeError) as error:
            trial.failed = Failed(
                f"the scenario does not run: {error}", "See which landmark a camera can start: section 2."
            )
            return trial
        trial.seconds, trial.frames = time.perf_counter() - began, len(trial.t)
        trial.measure()
        if seed == run.data.seed:  # the student's own run: eight seeds, of which this is the first
            self.ask(run, trial)
        return trial

    def ask(self, run, trial):
        """Let the student's loop measure; what it returns is in `trial.told`, or why it did not in `trial.failed`."""
        seeds = self.all_seeds(run)
        try:
            value, trial.printed = deadline.run(lambda: self.answer(run.loop, run.data, seeds), self.limit)
            if value is None:
                trial.attempted = False
                return
            trial.told = told(value, len(seeds), len(trial.t))
        except deadline.TookTooLong:
            trial.failed = Failed(
                f"your loop took more than {self.limit:g} s for {len(seeds)} runs and was stopped{deadline.HOW}",
                "One `universal_slam(data, seed=seed)` for each seed, and no second loop over the frames inside.",
            )
        except Failed as failed:
            trial.failed = failed

    @staticmethod
    def answer(loop, data, seeds):
        """Call the student's function; None if it is not written yet."""
        try:
            return loop(data, list(seeds))
        except NotImplementedError:
            return None
        except Exception as error:
            raise Failed(guard._blame(loop, error), guard._advice(error)) from None

    def all_seeds(self, run):
        """The seed of the scenario, and others."""
        return [run.data.seed, *(s for s in self.seeds if s != run.data.seed)][:RUNS]

    def measured(self, trials, reference=None):
        """What some runs show: is the student's measure right, and is the scenario honest?"""
        return _Shown(trials)

    def judge(self, run):
        """Judge a run: the same runs are made again, one after the other, and their NEES compared with the student's."""
        seeds, self.seeds = self.seeds, tuple(self.all_seeds(run)[1:]) if getattr(run, "data", None) else self.seeds
        try:
            return super().judge(run)
        finally:
            self.seeds = seeds

    def summary(self, trials):
        """One line on some runs."""
        if any(t is None or t.failed or not t.errors for t in trials):
            return "no result"
        s = _Shown(trials)
        if len(trials) == 1:
            nees = f"NEES of the first run {s.anees[-1]:.1f} in the last frame, {s.mean:.1f} in the mean (honest 6)"
        else:
            nees = (
                f"{s.runs} runs, mean NEES {s.mean:.1f} (honest 6), in the 95 % band {s.low:.1f} to {s.high:.1f} in "
                f"{100 * s.inside:.0f} % of the frames"
            )
        return (
            f"{s.frames} frames: {nees}; position off by {s.error:.2f} m in the last third (dead reckoning {s.dead:.2f} m), "
            f"{s.landmarks:.0f} landmarks in {s.numbers} numbers"
        )


def note(trial, now):
    """Note a frame: the pose of the robot, and that of dead reckoning."""
    rob, truth = now.robs[0], now.truth[now.robs[0].id]
    n = rob.motion.frame.size
    trial.t.append(now.t)
    trial.size.append(len(now.lmks))
    trial.numbers = max(trial.numbers, now.map.n_used)
    pose = now.map.x[rob.r][:n], now.map.P[rob.r, rob.r][:n, :n]
    x, P = getattr(trial, "reckoned", pose)
    if len(trial.t) > 1:
        x, X_x, X_u = rob.motion.move(x, rob.u, now.dt)
        P = X_x @ P @ X_x.T + X_u @ rob.U @ X_u.T
    trial.reckoned = x, P
    trial.note(rob, pose, trial.reckoned, truth)


def told(value, runs, frames):
    """The student's (nees, inside), checked."""
    if not isinstance(value, tuple | list) or len(value) != 2:
        got = "one array" if isinstance(value, np.ndarray) else type(value).__name__
        if hasattr(value, "__next__"):
            raise Failed("your loop has a `yield`: here a loop returns, so it must end with `return nees, inside`")
        raise Failed(f"your loop returns {got}: it must end with `return nees, inside`")
    nees, inside = (np.asarray(v) for v in value)
    for name, got, want in (("nees", nees.shape, (runs, frames)), ("inside", inside.shape, (frames,))):
        if got != want:
            raise Failed(
                f"{name} must have the shape {want}, got {got}",
                f"One row for each of the {runs} runs, one number for each of the {frames} frames.",
            )
    return nees.astype(float), inside.astype(bool)


class _Shown:
    """Numbers of some runs, and what the student says of them."""

    def __init__(self, trials):
        self.nees = np.array([np.array(rows)[:, 2] for t in trials for rows in t.errors.values()])
        self.runs, self.frames = self.nees.shape
        self.anees, self.mean = self.nees.mean(0), float(self.nees.mean())
        self.low, self.high = anees_band(6, self.runs)
        own = (self.anees > self.low) & (self.anees < self.high)
        self.inside, third = float(own.mean()), max(self.frames // 3, 1)
        self.percent = 100 * self.inside
        self.first, self.last = float(self.anees[:third].mean()), float(self.anees[-third:].mean())
        s = scores(trials)
        self.error, self.dead, self.landmarks, self.numbers = s.error, s.dead_error, s.landmarks, s.size
        self.seconds = max(t.seconds for t in trials)
        said, said_inside = getattr(trials[0], "told", (self.nees, own))
        self.told = float(said.mean())
        self.agrees = said.shape != self.nees.shape or np.allclose(said, self.nees, rtol=1e-3)
        self.told_percent = 100 * float(said_inside.mean())
        sure = np.abs(np.subtract.outer([self.low, self.high], self.anees)).min(0) > 0.01 * self.low  # not at a limit
        self.band_agrees = said.shape != self.nees.shape or not np.any((said_inside != own) & sure)


SYMPTOMS = (
    Symptom(
        "the measure",
        lambda s, p: not s.agrees,
        "your loop says that the mean NEES is {s.told:.2f}; it is {s.mean:.2f} in the same {s.runs} runs",
        "Does each run get its own seed? Is it the estimated pose with *its* covariance, now.map.P[rob.r, rob.r], and the true one of the same frame? Is the NEES that of `pose_nees`, neither a mean over the frames nor over p?",
    ),
    Symptom(
        "the band",
        lambda s, p: not s.band_agrees,
        "your loop says that the filter is honest in {s.told_percent:.0f} % of the frames; it is in {s.percent:.0f} %",
        "in_band(nees, 6) wants the NEES of all runs, shape (runs, frames), and says True or False for each frame.",
    ),
    Symptom(
        "honest",
        lambda s, p: s.inside < p.share and s.mean < s.low,
        "the mean NEES is {s.mean:.1f}, below the band {s.low:.1f} to {s.high:.1f}",
        "Too cautious: measurements are thrown away, or the noise is told too large.",
    ),
    Symptom(
        "honest",
        lambda s, p: s.inside < p.share and s.first > 2 * s.high,
        "the mean NEES is {s.mean:.0f}, far above the band {s.low:.1f} to {s.high:.1f} from the first frames on",
        "A prior that is too sure, or a depth that is guessed: something is known that nobody has measured. Look at the landmark's type, non_obs_mean and non_obs_std. With a depth camera: is depth_std in metres (0.1)?",
    ),
    Symptom(
        "honest",
        lambda s, p: s.inside < p.share,
        "the mean NEES is in the band {s.low:.1f} to {s.high:.1f} in {s.percent:.0f} % of the frames only; it is {s.first:.1f} in the first third and {s.last:.1f} in the last",
        "It becomes too sure on its way: an unknown depth, seen from poses that are off. With this odometry no way of storing a landmark is enough, anchor or not. What measured the depth in section 2?",
    ),
    Symptom(
        "a map",
        lambda s, p: s.error > ERROR * s.dead,
        "the robot is off by {s.error:.2f} m in the last third, dead reckoning by {s.dead:.2f} m",
        "A filter that corrects with nothing, or with little, is honest and useless. Are landmarks started (n_inits), and used (n_updates)?",
    ),
)


def _drives(data):
    u = np.atleast_2d(data.robots[0].controls())
    if np.linalg.norm(u[:, :3], axis=1).mean() < 0.07 or np.abs(u[:, 5]).mean() < np.radians(0.5):
        return "the robot hardly moves: dx and da_deg are those of the task"
    return None


project = Honest(
    "17.project",
    "An honest run in space",
    loop,
    scenario=SCENARIO,
    start=START,
    hints=(
        "The loop is that of section 2, once for each seed: a list of rows, an array at the end, and in_band of the whole. The scenario: section 2 says which of the six ways was honest with poor odometry.",
        'x[None], P[None], truth[None] are one pose for pose_nees. A camera that measures the depth is type = "pin_hole_depth" with depth_std = 0.1 (m); its landmarks are "euc_pnt".',
    ),
    asks=(
        asks.robots("odometry3"),
        asks.frames(50, 100),
        asks.points(20),
        asks.noise(dx_std=0.01, da_std_deg=0.1, pixels=0.9),
        asks.estimated(),
        _drives,
    ),
    band=(0.0, 0.0),
    share=0.75,
    symptoms=SYMPTOMS,
    seeds=(2, 3, 4, 5, 6, 7, 8, 9),
    seconds=60.0,
)
