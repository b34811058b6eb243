"""Solà's own point scenario: one camera in the cloister, inverse-depth landmarks, 10 corrections a frame.

The run is simulated once and recorded; then the recording is played back, and the estimation of each frame is timed.
"""

import time

import numpy as np

from ekfslam_tutorial.toolbox import Recorder, UserData, universal_slam

from .clock import quiet, statistics
from .ours import COMPILED
from .peers.registry import ROOT

FILE = ROOT / "data" / "scenarios" / "cloister_idp.toml"
OCTAVE_MS = 34.0  # his toolbox under Octave, CPU for each estimated frame; measured elsewhere, not in this run


def run(repeats, frames=200):
    """Rows: variant, times of the estimation of one frame."""
    changes = {"sequential": {}, "joint": {"options.joint": True}}
    if COMPILED:
        changes |= {f"{way}, compiled": change | {"options.compiled": True} for way, change in changes.items()}
    data = {way: UserData.from_toml(FILE, {"time.last": frames} | change) for way, change in changes.items()}
    recorder = Recorder()
    for snapshot in universal_slam(data["sequential"]):
        recorder.add(snapshot)
    recording = recorder.recording("cloister")

    found = {name: [] for name in data}
    for _ in range(repeats):
        for name in data:
            found[name].append(play(data[name], recording))
    return [{"variant": name, "cpu_us": statistics(np.median(times, axis=0))} for name, times in found.items()]


def play(data, recording):
    """Seconds of CPU for each frame."""
    run, times = universal_slam(data, recording=recording), []
    with quiet():
        for _ in range(len(run)):
            start = time.thread_time_ns()
            next(run)
            times.append(1e-9 * (time.thread_time_ns() - start))
    return times
