"""What a message costs, and the worst of them: `python -m benchmarks.stream`. Seconds of the processor, of one thread.

A robot drives round 100 landmarks, with a frame each 0.1 s for a minute. In order, and with 20 % of the messages late
by up to half a second, which is the filter's horizon. Each message is worked on at once.
"""

import gc
import time

import numpy as np

from ekfslam_tutorial.toolbox import Recorder, UserData, as_stream, universal_slam

SCENARIO = {
    "world": {"type": "ring", "n": 100, "radius": 12.0},
    "time": {"dt": 0.1, "last": 600},
    "robot": [
        {"motion": "unicycle", "position": [0, -10], "v": 1.0, "w_deg": 5.73, "v_std": 0.02, "w_std_deg": 0.5},
    ],
    "sensor": [{"type": "range_bearing", "range_std": 0.1, "bearing_std_deg": 1.0, "max_range": 6.0}],
}
ENGINES = {
    "plain": {"engine": "plain", "joint": True},
    "fast": {"engine": "fast", "joint": True},
    "fast, compiled": {"engine": "fast", "joint": True, "compiled": True},
}
LATE, SHARE = 0.5, 0.2


def recorded(options):
    """The scenario with one engine, and the recording of its simulation."""
    data, recorder = UserData.from_dict(SCENARIO | {"options": options}), Recorder()
    for now in universal_slam(data):
        recorder.add(now)
    return data, recorder.recording("circuit")


def costs(data, recording, late):
    """Seconds for each message, and for each time of measurement, in the order in which they arrive."""
    slam, messages = as_stream(data, recording, horizon=LATE)
    rng = np.random.default_rng(1)
    delay = np.where(rng.random(len(messages)) < SHARE * late, rng.uniform(0, LATE, len(messages)), 0.0)
    spent = []
    for i in np.argsort([m.t for m in messages] + delay, kind="stable"):
        began = time.thread_time()
        slam.add(messages[i])
        slam.update()
        spent.append(time.thread_time() - began)
    return np.array(spent)


def main():
    """Print the table of docs/performance.md, and what a full pass of Python's collector takes."""
    print("| a message, ms: median; 99 %; worst | in order | 20 % late |")
    print("| --- | ---: | ---: |")
    for name, options in ENGINES.items():
        run, cells = recorded(options), []
        costs(*run, late=True)  # what is loaded or compiled at the first time
        for late in (False, True):
            ms = 1e3 * costs(*run, late)
            cells.append(f"{np.median(ms):.2f}; {np.quantile(ms, 0.99):.1f}; {ms.max():.1f}")
        print(f"| {name} | {' | '.join(cells)} |", flush=True)
    began = time.thread_time()
    gc.collect()
    print(f"a full pass of the collector: {1e3 * (time.thread_time() - began):.1f} ms")


if __name__ == "__main__":
    main()
