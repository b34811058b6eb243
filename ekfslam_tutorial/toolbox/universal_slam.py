"""The main loop (the manual's universalSLAM): simulate or play back, estimate, hand over each frame."""

import html
from dataclasses import dataclass, field, replace
from typing import Any

from ..ekf.html import map_html
from ..slam import let_go, reopen_gate, retry_lmks, tilt, wander
from . import engines
from .descriptors import described, remember
from .images.eyes import Eyes
from .rings import Rings
from .run_state import restore
from .scenario.agreement import can_start, started_by
from .sources import Replay, Simulation
from .structures import create_slam_structures
from .watch import Watch


@dataclass
class Snapshot:
    """A run after one of its frames.

    These are the live objects of the run, not copies: they are good until the next snapshot is drawn.

    Parameters
    ----------
    k : int
        Frame number.
    t, dt : float
        Seconds since the start, and since the frame before.
    map : Map
    robs, sens : list of Rob, list of Sen
    lmks : dict of int to Lmk
        By landmark id.
    obs : dict of (int, int) to Obs
        This frame's observations, by (sensor id, landmark id).
    raw : dict of int to SimObs
        This frame's measurements, by sensor id.
    met : dict of int to SimObs
        This frame's measurements of other robots, by sensor id, where a recording has them.
    events : list of Event
        What was done in this frame, in order.
    refused : set of int
        Ids of landmarks that were seen but not started, in any frame so far, because the map was full.
    truth : dict of int to ndarray
        True pose of each robot; NaN, or no entry, where it is not known.
    sim_robs, sim_sens : sequences of SimRob and SimSen
        Empty when a recording is played.
    sim_lmk : SimLmk or None
        True landmarks, where known.
    corrected : list of tuple
        What the corrections of this frame have done to the poses of the robots, in order: see `toolbox.watch`.
    rings : dict of int to Ring
        Beacons of which one does not know yet where on the ring of their ranges they are, by id: see `toolbox.rings`.
    named : bool
        The ids of landmarks are those of the world. False where the filter has numbered them itself.
    """

    k: int
    t: float
    dt: float
    map: Any
    robs: list
    sens: list
    lmks: dict
    obs: dict
    raw: dict
    met: dict
    events: list
    refused: set
    truth: dict
    sim_robs: Any
    sim_sens: Any
    sim_lmk: Any
    corrected: list = field(default_factory=list)
    rings: dict = field(default_factory=dict)
    named: bool = True

    def __repr__(self):
        used = sum(o.updated for o in self.obs.values())
        return (
            f"Snapshot(frame {self.k}, {self.t:.2f} s: {len(self.robs)} robots, {len(self.sens)} sensors, "
            f"{len(self.lmks)} landmarks, {used} observations used)"
        )

    def _repr_html_(self):
        owners = {f"{kind} {o.id}": o.r for kind, group in self._groups() for o in group if o.r is not None}
        return f"<b>{html.escape(repr(self))}</b><br>{map_html(self.map, owners)}"

    def _groups(self):
        things = ("robot", self.robs), ("sensor", self.sens), ("landmark", self.lmks.values())
        return *things, ("ring", self.rings.values())


class Run:
    """Iterator over the snapshots of a run; `len(run)` is the number of frames, for a progress bar.

    Parameters
    ----------
    snapshots : iterator of Snapshot
    n_frames : int
    engine : str, optional
        What computes the run: "plain", "fast", "fast, compiled"; None where it is none of the engines.
    """

    def __init__(self, snapshots, n_frames, engine=None):
        self._snapshots, self._n_frames, self.engine = snapshots, n_frames, engine

    def __len__(self):
        return self._n_frames

    def __iter__(self):
        return self

    def __next__(self):
        return next(self._snapshots)


def universal_slam(data, recording=None, seed=None, resume=None, engine=None):
    """Run a scenario.

    Parameters
    ----------
    data : UserData
    recording : Recording or Pictures, optional
        Controls and measurements to take instead of simulated ones; or images.
    seed : int, optional
        Instead of `data.seed`.
    resume : dict, optional
        What `run_state` has kept of the same run, by the same engine: only the frames after it are run, with the same
        numbers.
    engine : str, optional
        "plain" or "fast", instead of `data.options.engine`.

    Returns
    -------
    Run
        A generator of `Snapshot`, one for each frame, that also knows how many there will be in all, and in `engine`
        what computes them.

    Raises
    ------
    ValueError, TypeError
        At once, if the data do not fit together; later, if a measurement or a control is not finite.
    """
    if engine is not None:
        data = replace(data, options=replace(data.options, engine=engine))
    engine = engines.engine(data.options)
    if recording is None:
        source = Simulation(data, data.seed if seed is None else seed)
    elif hasattr(recording, "source"):  # pictures
        source = recording.source(data)
    else:
        source = Replay(data, recording)
    structures = create_slam_structures(data, source.sim_lmk, source.starts)
    n_frames = source.n_frames(structures[-1])
    return Run(_frames(data, engine, source, n_frames, resume, *structures), n_frames, engine.name)


def _frames(data, engine, source, n_frames, resume, map, robs, sens, lmks, tim):
    """Run the loop: simulation, estimation, visualization."""
    loop, first = Loop(data, engine, map, robs, sens, lmks), 0
    if resume is not None:
        loop.restore(resume)
        first = resume["frames"]
        for i in range(first):
            source.frame(i)  # draws the same random numbers as then

    for i in range(first, n_frames):
        # 1. SIMULATION, or the next frame of a recording
        now = source.frame(i)

        # 2. ESTIMATION
        events, corrected = loop.step(now, i)

        # 3. VISUALIZATION, or whatever the caller does with a frame
        yield loop.snapshot(tim.first + i, now, events, corrected, source)


class Loop:
    """Map and records of a run, and what a frame does to them: `universal_slam` and `OnlineSlam` are both made of it.

    Parameters
    ----------
    data : UserData
    engine : Engine
    map, robs, sens, lmks
        As `create_slam_structures` makes them.
    """

    def __init__(self, data, engine, map, robs, sens, lmks):
        self.data, self.engine, self.opt = data, engine, data.slam_options()
        self.map, self.robs, self.sens, self.lmks = map, robs, sens, lmks
        self.obs, self.refused = {}, set()
        self.rings, self.eyes = Rings(data.landmark.hypotheses, data.landmark.model), Eyes()
        self._sen_of = {sen.id: sen for sen in sens}
        self._starts = {s.id: data.landmark.in_map and can_start(s.model, started_by(data, s)) for s in data.sensors}

    def step(self, now, i):
        """Estimate from the data of one frame.

        Parameters
        ----------
        now : Frame
        i : int
            How many frames there were before.

        Returns
        -------
        events : list of Event
        corrected : list of tuple
            As `Snapshot` has them.
        """
        engine, opt, sen_of = self.engine, self.opt, self._sen_of
        map, robs, lmks, obs, rings, eyes = self.map, self.robs, self.lmks, self.obs, self.rings, self.eyes
        events, watch = [], Watch(map, robs, opt)
        for key in [key for key in obs if key[0] in now.idle]:
            del obs[key]
        wander(map, lmks, now.dt, opt)
        tilt(map, self.sens, now.dt)
        for rob in robs:
            if rob.id in now.controls:
                self.move(rob, now)
            for sen in (sen_of[id] for id in rob.sensors if id not in now.idle):
                raw = described(now.raw[sen.id], lmks)
                eyes.look(rob, sen, lmks, raw)
                with watch.by(rob), rings.carried(map, rob, opt):
                    if hasattr(sen.model, "without_lmks"):
                        done, new = engine.correct_without_lmks(map, rob, sen, obs, raw, opt, lmks), []
                    else:
                        done, new = engine.correct_known_lmks(map, rob, sen, lmks, obs, raw, opt)
                done += reopen_gate(map, rob, done, opt, lmks)
                done += retry_lmks(map, rob, done, opt, lmks)
                n_max = None if opt.n_inits is None else opt.n_inits[min(i, 1)]
                if self._starts[sen.id]:
                    done += engine.init_new_lmks(map, rob, sen, lmks, raw, new, opt, n_max)
                elif rings.starts(sen.model):
                    with watch.by(rob):
                        done += rings.see(map, rob, sen, lmks, raw, opt, n_max)
                events += done + let_go(map, rob, sen, lmks, done, opt)
                events += eyes.remember(map, rob, sen, lmks, raw)
                remember(sen, lmks, obs, raw)
        for rob in robs:  # all have moved now, so one can be seen by the other
            for sen in (sen_of[id] for id in rob.sensors if id in now.met):
                with watch.by(rob), rings.carried(map, rob, opt):
                    events += engine.correct_met_robots(map, rob, sen, robs, now.met[sen.id], opt, lmks)
        self.refused = {*self.refused, *(e.lmk for e in events if e.kind == "refused")}.difference(lmks)
        return events, watch.seen

    def move(self, rob, now):
        """Move a robot by its control in this frame; or put it where it is known to be."""
        rob.u, rob.U, dt = now.controls[rob.id]
        rob.dt = dt
        if rob.r is None:
            rob.x[: rob.motion.frame.size] = now.truth[rob.id]
        else:
            with self.rings.moved(self.map, rob, dt):
                self.engine.move(self.map, rob, dt)

    def snapshot(self, k, now, events, corrected, source):
        """Return the run after frame k, as a `Snapshot`; the source knows the true world, where there is one."""
        return Snapshot(
            k=k,
            t=now.t,
            dt=now.dt,
            map=self.map,
            robs=self.robs,
            sens=self.sens,
            lmks=self.lmks,
            obs=self.obs,
            raw=now.raw,
            met=now.met,
            events=events,
            refused=self.refused,
            truth=now.truth,
            sim_robs=source.sim_robs,
            sim_sens=source.sim_sens,
            sim_lmk=source.sim_lmk,
            corrected=corrected,
            rings=self.rings.live,
            named=self.data.named,
        )

    def restore(self, state):
        """Go back, or on, to what `run_state` has kept."""
        self.lmks, self.refused, self.rings.live = restore(state, self.data, self.map, self.robs, self.sens)
        self.obs, self.eyes = {}, Eyes(found=True)
