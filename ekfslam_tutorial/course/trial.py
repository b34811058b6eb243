"""One run of a student's own loop: what the loop is given, what it hands back, and how that is measured.

The loop gets a `World`, which holds what a filter may know, and no truth. It yields its whole estimate after each
frame. All numbers of a verdict are computed here, from the estimates and the truth of the simulator.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any

import numpy as np

from ..analysis.consistency import md2
from ..models.landmarks import AhmPnt, EucPnt, HmgPnt, IdpPnt
from ..toolbox.sources import Replay, Simulation
from ..toolbox.structures import create_slam_structures
from . import deadline, expect, guard
from .expect import Failed

LANDMARKS = {3: {t.size: t for t in (EucPnt(3), HmgPnt(3), IdpPnt(), AhmPnt(3))}, 2: {2: EucPnt(2)}}
"""Landmark types by dimension of the world and by how many numbers a landmark has."""
OFTEN = 5  # a landmark that was seen in so many frames should be in the map
OTHER_SENSOR = "Two numbers against three: does e come from the sensor that measured y (`world.sens[id - 1]`)? "
LATELY = 10  # frames: what was seen in the last ones is what a robot needs now


class World:
    """What a loop is given: all that a filter may know of an experiment, frame by frame.

    Attributes
    ----------
    robs, sens : list of Rob, list of Sen
        As in notebook 14: `rob.motion`, `rob.r`, `rob.sensors`; `sen.model`, `sen.x` or `sen.r`, `sen.robot`.
    x, P : ndarray
        The map before the first frame: robots, and mountings that are estimated.
    options : Options
        Of the scenario; `options.n`, `options.N` are the prior, and `options.lmk_type` the type of landmarks.
    kinds : dict of int to LmkType
        Landmark types by how many numbers a landmark has.
    given : ndarray or None
        Of a film: places that are known before it begins.
    view : SimpleNamespace or None
        The present frame, as the loop has got it.
    """

    given = view = None

    def __init__(self, data, seed, recording=None):
        made = getattr(recording, "source", lambda data: Replay(data, recording))  # a film makes its own
        self._source = source = Simulation(data, seed) if recording is None else made(data)
        map, self.robs, self.sens, self._known, tim = create_slam_structures(data, source.sim_lmk, source.starts)
        self.x, self.P, self.start_P, self.options = map.x.copy(), map.P.copy(), map.P.copy(), data.slam_options()
        self._frames, self._now = source.n_frames(tim), None
        self.k, self._t, self.kinds = 0, 0.0, dict(LANDMARKS[data.frame.dim])

    def __len__(self):
        return self._frames

    def __iter__(self):
        """Yield each frame: `k`, `t`, `dt`, controls `u` and `U` by robot, `seen` and `met` by sensor.

        `seen[1]` is the list of pairs (landmark id, measurement) of sensor 1; `met[1]` the same of other robots. Of a
        film `image[1]` is the image, and `seen[1]` is empty: whoever looks at the image fills it.
        """
        while self.k < self._frames:
            now = self._now = self._source.frame(self.k)
            self.k, self._t = self.k + 1, now.t
            pairs = lambda obs: [(int(id), np.array(y)) for id, y in zip(obs.ids, obs.y, strict=True)]
            self.view = SimpleNamespace(
                k=self.k,
                t=now.t,
                dt=now.dt,
                u={id: np.array(u) for id, (u, _, _) in now.controls.items()},
                U={id: np.array(U) for id, (_, U, _) in now.controls.items()},
                seen={id: pairs(obs) for id, obs in now.raw.items()},
                met={id: pairs(obs) for id, obs in now.met.items()},
                image={id: obs.image.copy() for id, obs in now.raw.items() if hasattr(obs, "image")},
            )
            yield self.view


@dataclass
class Estimate:
    """What a loop has yielded after one frame: the whole map, and which part of it is which landmark."""

    x: np.ndarray
    P: np.ndarray
    lmks: dict[int, slice]


@dataclass
class Trial:
    """One run of a loop with one seed; `failed` says why it ended early, if it did."""

    seed: int
    frames: int = 0  # of a whole run
    t: list = field(default_factory=list)
    size: list = field(default_factory=list)  # landmarks in the map
    poses: dict = field(default_factory=dict)  # by robot, for `measure`: rows of x, P, those of dead reckoning, truth
    errors: dict = field(default_factory=dict)  # by robot: rows of (position error, sigma, NEES), of the filter ...
    dead: dict = field(default_factory=dict)  # ... and of dead reckoning
    sightings: dict = field(default_factory=dict)  # in how many frames a landmark was seen, by id
    latest: dict = field(default_factory=dict)  # in which frame a landmark was seen last, by id
    landmarks: list = field(default_factory=list)  # at the end: (error, sigma, NEES / dim, distance)
    known: set = field(default_factory=set)  # ids in the map at the end
    dof: dict = field(default_factory=dict)  # of the NEES, by robot
    mountings: list = field(default_factory=list)  # at the end: (NEES of the angles, their sigma / at start)
    numbers: int = 0  # most in x
    seconds: float = 0.0
    failed: Failed | None = None
    attempted: bool = True
    path: Any = None  # what a project keeps of it besides,
    noise: Any = None  # and of what the filter was told
    printed: str = ""

    def add(self, world, estimate, reckoning):
        """Note what is to be measured of one frame."""
        truth, self.t = world._now.truth, [*self.t, world._t]
        self.size.append(len(estimate.lmks))
        self.numbers = max(self.numbers, len(estimate.x))
        for obs in world._now.raw.values():
            for id in {int(i) for i in obs.ids} - {-1}:
                self.sightings[id] = self.sightings.get(id, 0) + 1
                self.latest[id] = len(self.t)
        for rob in world.robs:
            if rob.r is None or rob.id not in truth:
                continue
            self.note(rob, (estimate.x[rob.r], estimate.P[rob.r, rob.r]), reckoning[rob.id], truth[rob.id])

    def note(self, rob, pose, dead, truth):
        """Keep a pose and what dead reckoning says, each with its covariance, and the true one."""
        self.dof[rob.id] = rob.motion.frame.dof
        _, rows = self.poses.setdefault(rob.id, (rob.motion.frame, []))
        rows.append([np.array(a, float) for a in (*pose, *dead, truth)])

    def measure(self):
        """Measure the poses of all frames at once: that is much quicker than one by one."""
        for id, (frame, rows) in self.poses.items():
            x, P, dead_x, dead_P, truth = map(np.array, zip(*rows, strict=True))
            self.errors[id] = pose_errors(frame, x, P, truth)
            self.dead[id] = pose_errors(frame, dead_x, dead_P, truth)
        self.poses = {}

    def finish(self, world, estimate):
        """Measure the map at the end: landmarks, and mountings."""
        self.known = set(estimate.lmks)
        sim = world._source.sim_lmk
        places = {} if sim is None else dict(zip(sim.ids.tolist(), sim.points, strict=True))
        dim = world.robs[0].motion.frame.dim
        for id, r in estimate.lmks.items():
            if id in places:
                p, P_l = LANDMARKS[dim][r.stop - r.start].point(estimate.x[r])
                P = P_l @ estimate.P[r, r] @ P_l.T
                e, far = p - places[id], np.linalg.norm(places[id] - estimate.x[:dim])
                if np.isfinite(P).all():
                    self.landmarks.append((np.linalg.norm(e), np.sqrt(np.trace(P)), float(md2(e, P)) / dim, far))
        for sen, true in zip(world.sens, world._source.sim_sens, strict=False):
            if sen.r is not None:
                angles = slice(sen.r.start + dim, sen.r.stop)
                e, E_s = sen.frame_type(estimate.x[sen.r]).minus(true.frame)
                C = (E_s @ estimate.P[sen.r, sen.r] @ E_s.T)[dim:, dim:]
                now, then = (np.trace(P[angles, angles]) for P in (estimate.P, world.start_P))
                self.mountings.append((float(md2(e[dim:], C)), np.sqrt(max(now, 0) / then) if then > 0 else 1.0))


def pose_errors(frame, x, P, truth):
    """Position error (m), sigma of the position (m) and NEES of poses, shape (..., 3); NaN where no truth is known."""
    n, d = frame.size, frame.dim
    e, E_x = frame(x[..., :n]).minus(frame(truth))
    C = E_x @ P[..., :n, :n] @ np.swapaxes(E_x, -1, -2)
    variance = np.trace(C[..., :d, :d], axis1=-2, axis2=-1)
    return np.stack([np.linalg.norm(e[..., :d], axis=-1), np.sqrt(np.maximum(variance, 0)), md2(e, C)], -1)


def run_trial(data, loop, seed, seconds, recording=None, watch=None, trial=None, given=None) -> Trial:
    """Run a loop once, and measure it against the truth.

    Parameters
    ----------
    data : UserData
    loop : generator function
        The student's: it takes a `World` and yields (x, P, lmks) after each frame.
    seed : int
    seconds : float
        A loop that takes longer is stopped.
    recording : Recording, optional
        Instead of the simulation.
    watch : callable, optional
        Called with (world, estimate before the frame, estimate) after each frame.
    trial : Trial, optional
        One that measures more.
    given : ndarray, optional
        `World.given`.

    Returns
    -------
    Trial
        What the student's code does wrong is in it; nothing is raised.
    """
    trial, world = trial or Trial(seed), World(data, seed, recording)
    trial.frames = len(world)
    world.given = given
    estimated = [rob for rob in world.robs if rob.r is not None]
    reckoning = {rob.id: (world.x[rob.r].copy(), world.P[rob.r, rob.r].copy()) for rob in estimated}
    before = Estimate(world.x.copy(), world.P.copy(), {})
    steps = estimate = None
    try:
        for i in range(len(world)):
            started = time.perf_counter()
            if steps is None:
                steps = begin(loop, world)
            estimate = next_estimate(loop, steps, world, i, seconds - trial.seconds, trial)
            trial.seconds += time.perf_counter() - started
            for rob in estimated:
                reckoning[rob.id] = reckon(rob, *reckoning[rob.id], world._now)
            trial.add(world, estimate, reckoning)
            if watch is not None:
                watch(world, before, estimate)
            before = estimate
        assert estimate is not None
        expect.psd(estimate.P, "P at the end", 1e-7)
        trial.finish(world, estimate)
    except NotImplementedError:
        trial.attempted = False
    except deadline.TookTooLong:
        trial.failed = Failed(
            f"your loop took more than {seconds:g} s for {world.k} of {len(world)} frames and was stopped"
            f"{deadline.HOW}",
            "Look for a loop that does not end, for an inverse of a large matrix (only Z, of the size of a "
            "measurement, is ever inverted), and for landmarks that are added again and again. If only the computer is "
            "slow or busy, give it more time with the environment variable EKFSLAM_CHECK_SECONDS.",
        )
    except Failed as failed:
        trial.failed = failed
    trial.measure()
    return trial


def begin(loop, world):
    """Call the loop, which must be a generator function."""
    try:
        steps = loop(world)
    except NotImplementedError:
        raise
    except Exception as error:
        raise Failed(blame(loop, error), advice(error)) from None
    if not hasattr(steps, "__next__"):
        raise Failed(
            f"your loop returns {type(steps).__name__}: it must `yield x, P, lmks` after each frame",
            "`yield` hands the estimate over and goes on with the next frame; `return` would end the loop.",
        )
    return steps


def next_estimate(loop, steps, world, i, seconds, trial) -> Estimate:
    """Let the loop do one frame; return its estimate, checked and copied."""

    def job():
        try:
            return "yielded", next(steps)
        except StopIteration:
            return "ended", None
        except NotImplementedError:
            return "stub", None
        except Exception as error:
            return "raised", error

    (what, value), printed = deadline.run(job, max(seconds, 0.01))
    trial.printed = (trial.printed + printed)[:2000]
    if what == "stub":
        raise NotImplementedError
    if what == "raised":
        raise Failed(f"{blame(loop, value)} (frame {world.k})", advice(value))
    if what == "ended" or world.k != i + 1:
        raise Failed(
            f"your loop has yielded {i + (what == 'yielded')} times when {world.k} of {len(world)} frames were over",
            "`yield x, P, lmks` once for each frame: at the end of the `for` over the frames, and inside it.",
        )
    return checked(value, world)


def blame(loop, error) -> str:
    """One sentence: the exception, and the line of the student's code."""
    return guard._blame(loop, error).replace("your function", "your loop", 1)


def advice(error) -> str:
    """What to look at first in a loop: in one of several sensors, that the two sides are of the same one."""
    two_and_three = any(f"shapes {shapes}" in str(error) for shapes in ("(2,) (3,)", "(3,) (2,)"))
    return (OTHER_SENSOR if two_and_three else "") + guard._advice(error)


def checked(value, world) -> Estimate:
    """The student's (x, P, lmks) as an `Estimate`; raise `Failed` if it cannot be one."""
    x, P, lmks = expect.results(value, "x", "P", "lmks")
    at, n = f" after frame {world.k}", np.size(x)
    x = expect.array(x, n, f"x{at}")
    P = expect.array(P, (n, n), f"P{at}")
    if n < len(world.x):
        raise Failed(f"x{at} has {n} numbers: the robots alone have {len(world.x)}")
    if not isinstance(lmks, dict):
        raise Failed(f"lmks{at} must be a dictionary, landmark id: slice; got {type(lmks).__name__}")
    sizes = LANDMARKS[world.robs[0].motion.frame.dim]
    used = np.zeros(n, int)
    used[: len(world.x)] = 1
    for id, r in lmks.items():
        if not isinstance(r, slice) or r.start is None or r.stop is None:
            raise Failed(f"lmks[{id}]{at} must be a slice of x, got {r!r}")
        if r.stop > n or r.stop - r.start not in sizes:
            possible = " or ".join(map(str, sizes))
            raise Failed(f"lmks[{id}]{at} is {r.start}:{r.stop} of {n} numbers: a landmark has {possible}")
        used[r] += 1
    if (used > 1).any():
        raise Failed(f"x[{int(np.argmax(used > 1))}]{at} belongs to two: the ranges of `lmks` overlap")
    expect.symmetric(P, f"P{at}", 1e-5)
    std = np.sqrt(np.maximum(np.diag(P), 0))
    if (np.diag(P) < -1e-9 * np.abs(P).max(initial=0)).any():
        i = int(np.argmin(np.diag(P)))
        raise Failed(f"P[{i}, {i}]{at} is {P[i, i]:.3g}: a variance is never negative")
    if (np.abs(P) > 1.001 * np.outer(std, std) + 1e-7 * max(np.abs(P).max(initial=0), 1e-12)).any():
        raise Failed(
            f"P{at} has a correlation beyond 1: no covariance can have that",
            "A covariance between two states and their variances change together: is a row, a column or a block of "
            "P left out where something is born, moved or corrected?",
        )
    return Estimate(x.copy(), (P + P.T) / 2, dict(lmks))


def reckon(rob, x, P, now):
    """One step of dead reckoning of one robot: mean and covariance."""
    u, U, _ = now.controls[rob.id]
    x, X_x, X_u = rob.motion.move(x, u, now.dt)
    return x, X_x @ P @ X_x.T + X_u @ U @ X_u.T
