"""How good can the path of a filter be? At each instant the optimum of what was measured until then, its last pose.

    python tools/causal_optimum.py plaza --every 2.5
    python tools/causal_optimum.py plaza --set data.set=1 --every 8

A filter cannot know what comes later, so the optimum of a whole log is not what it is to be held against. Here the
measurements until an instant are smoothed, linearised until nothing moves, and only the pose of that instant is kept;
then those until the next one, and so on. What it costs in accuracy that a pose is asked for at once is in that path
already; what a filter has lost besides, by linearising once and by not knowing yet where a beacon is, is not. The
search begins at the optimum of the whole log, so of two mirror images it takes the right one, which no filter knows.
"""

import argparse

import numpy as np

from ekfslam_tutorial import datasets
from ekfslam_tutorial.analysis.factors import Graph, Guess, Motion, Prior, graph_of
from ekfslam_tutorial.analysis.progress import bar
from ekfslam_tutorial.analysis.smoother import smooth
from ekfslam_tutorial.cli.files import find_scenario
from ekfslam_tutorial.cli.smoothing import laid_on, rmse, truth_of
from ekfslam_tutorial.toolbox import UserData, parse_override

FAR = 100.0
"""What fewer than three ranges leave open of a beacon is held with this standard deviation: m, and all its numbers."""


def causal(graph, frames, after_frame=lambda: None):
    """Pose of the one robot at some frames, each by what was measured until then.

    Parameters
    ----------
    graph : Graph
        At the optimum of the whole run; it stays what it is, but for the noise that its factors remember.
    frames : list of int
        Rising.
    after_frame : callable

    Returns
    -------
    ndarray, shape (K, n)
    """
    (robot,) = graph.robots
    best, found = graph.values, []
    for k in frames:
        looks = [look for look in graph.looks if look.k <= k]
        seen = sorted({key for look in looks for key in look.lmks})
        stiff = [f for f in graph.stiff if when(f) <= k and getattr(f, "lmk", None) in (None, *seen)]
        stiff += [Prior([key], best[key], FAR**2 * np.eye(len(best[key]))) for key in seen]
        keys = [*(("robot", robot, i) for i in range(k + 1)), *seen]
        part = Graph({key: best[key].copy() for key in keys}, graph.frames, stiff, looks, graph.t[: k + 1], graph.types)
        found.append(smooth(part).graph.values["robot", robot, k])
        after_frame()
    return np.array(found)


def when(factor):
    """Frame from which on a factor holds."""
    return factor.after[2] if isinstance(factor, Motion) else factor.k if isinstance(factor, Guess) else 0


def main(words=None):
    """Print the errors of filter, causal optimum and smoother at the same frames."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenario")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE")
    parser.add_argument("--after", type=float, default=0.0, help="no pose before so many seconds: aligned without them")
    parser.add_argument("--every", type=float, default=5.0, help="seconds from one pose to the next")
    options = parser.parse_args(words)
    overrides = dict(map(parse_override, options.set))
    data, recording = datasets.prepare(UserData.from_toml(find_scenario(options.scenario), overrides))
    batch = smooth(graph_of(data, recording))
    graph, t = batch.graph, np.array(batch.graph.t)
    (robot,) = graph.robots
    d = graph.frames["robot", robot].dim
    frames = np.unique(
        [*np.searchsorted(t, np.arange(options.after + options.every, t[-1], options.every)), len(t) - 1]
    )
    truth = truth_of(batch, robot)[frames, :d]
    with bar(len(frames), "poses") as done:
        paths = {"causal optimum": causal(graph, frames.tolist(), done.update)}
    paths |= {"filter": batch.filtered(robot)[0][frames], "smoother": batch.track(robot)[0][frames]}
    print(f"{len(frames)} poses of {recording.name if recording else data.name}: RMSE m, aligned m")
    for name, x in paths.items():
        x = x[:, :d]
        print(f"{name:15s} {rmse(x, truth):.3f} {rmse(x, laid_on(truth, x)(truth)):.3f}")


if __name__ == "__main__":
    main()
