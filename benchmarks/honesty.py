"""Is an estimator honest? The audit of this package, of GTSAM, of filterpy and of PythonRobotics.

    python -m benchmarks.honesty --python-robotics PATH/TO/ekf_slam.py

Three get the same measurements: the circuit of `world.py`, one round among 50 landmarks, with exactly the noise that
they are told. Each circuit has landmarks and noise of its own. PythonRobotics' file, which is not part of this project,
is run as it is: its own world, its own noise. Writes honesty.json, docs/images/audit.png and the table of
docs/audit.md. What cannot be imported is left out.
"""

import argparse
import contextlib
import importlib.util
import io
import json
import re
import tempfile
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from ekfslam_tutorial.analysis import History
from ekfslam_tutorial.analysis.audit import audit
from ekfslam_tutorial.analysis.estimates import Estimate, run_errors
from ekfslam_tutorial.analysis.rec_file import read_rec, write_rec
from ekfslam_tutorial.cli.files import find_scenario
from ekfslam_tutorial.geometry import Frame2
from ekfslam_tutorial.graphics import use_style
from ekfslam_tutorial.graphics.audit_picture import audit_picture
from ekfslam_tutorial.toolbox import UserData, universal_slam

from .ours import FAST, Step
from .world import U, circuit

RUNS, LANDMARKS = 40, 50
HERE = Path(__file__).resolve().parent
TABLE = HERE / "honesty.json"
PAGE = HERE.parent / "docs" / "audit.md"
MARKED = re.compile(r"<!-- honesty -->.*?<!-- /honesty -->", re.DOTALL)
PICTURE = HERE.parent / "docs" / "images" / "audit.png"


def world(seed):
    """The circuit, its first control noisy, too: there it is exact, and a filter that is told noise is too cautious."""
    circle, rng = circuit(LANDMARKS, rounds=1.0, seed=seed), np.random.default_rng([seed, 1])
    noisy = replace(circle.steps[0], u=np.sqrt(np.diag(U)) * rng.normal(size=3))
    return replace(circle, steps=[noisy, *circle.steps[1:]])


def filtered(make, world):
    """Run a filter with `step` and `state` over a circuit: an Estimate of its poses, with the map at its end."""
    peer, x, P = make(world), [], []
    for k in range(len(world.steps)):
        with contextlib.redirect_stdout(io.StringIO()):
            peer.step(k)
        mean, cov = peer.state()
        x.append(mean[:3])
        P.append(cov[:3, :3])
    return estimate(world, x, P, list(range(world.n_lmks)), mean[3:].reshape(-1, 2), cov[3:, 3:])


def estimate(world, x, P, ids, points, joint, axes="mixed"):
    """What came out, beside the truth. The first pose is the start, which is known, and says nothing."""
    truth = np.array([step.pose for step in world.steps])[1:]
    t = np.arange(1.0, len(world.steps))
    part = np.array(x)[1:], np.array(P)[1:]
    true_points = world.lmks[ids]
    return Estimate("circuit", Frame2(part[0]), t, part[1], axes, Frame2(truth), ids, points, joint, true_points)


class Ours(Step):
    """This package, one by one, as a user writes it."""

    def __init__(self, world):
        super().__init__(world, FAST.new_map(None), joint=False)


def gtsam_batch(world):
    """GTSAM's smoother with the marginal covariances of all poses, in the axes of the body, and of all landmarks."""
    import gtsam
    from gtsam.symbol_shorthand import L, X

    from .peers.gtsam_peer import Batch

    batch = Batch(world)
    for k in range(len(world.steps)):
        batch.step(k)
    marginals = gtsam.Marginals(batch.factors, batch.result)
    at = range(1, len(world.steps) + 1)
    poses = [batch.result.atPose2(X(k)) for k in at]
    x = [[p.x(), p.y(), p.theta()] for p in poses]
    P = [marginals.marginalCovariance(X(k)) for k in at]
    ids = sorted(batch.graph.known)
    points = np.array([batch.result.atPoint2(L(i)) for i in ids])
    keys = [L(i) for i in ids]
    joint = marginals.jointMarginalCovariance(keys)
    blocks = np.block([[joint.at(a, b) for b in keys] for a in keys])
    return estimate(world, x, P, ids, points, blocks, "body")


def as_it_is(path, seed):
    """PythonRobotics' own simulation, its `main` without the drawing. Its start is told as uncertain by 1 m, 1 rad."""
    spec = importlib.util.spec_from_file_location("ekf_slam", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    try:
        module.jacob_motion(np.zeros((3, 1)), np.zeros((2, 1)))
    except ValueError:  # written for an older numpy
        jacob_motion = module.jacob_motion
        module.jacob_motion = lambda x, u: jacob_motion(x, u[:, 0])
    np.random.seed(seed)  # noqa: NPY002 (it draws from the global generator)
    places = np.array([[10.0, -2.0], [15.0, 10.0], [3.0, 15.0], [-5.0, 20.0]])
    x, true, dead, P = np.zeros((3, 1)), np.zeros((3, 1)), np.zeros((3, 1)), np.eye(3)
    out, covs, poses = [], [], []
    for _ in range(int(module.SIM_TIME / module.DT)):
        with contextlib.redirect_stdout(io.StringIO()):
            true, z, dead, u = module.observation(true, dead, module.calc_input(), places)
            x, P = module.ekf_slam(x, P, u, z)
        out.append(x[:3, 0])
        covs.append((P[:3, :3] + P[:3, :3].T) / 2)
        poses.append(true[:, 0])
    t = module.DT * np.arange(1, len(out) + 1)
    return Estimate("its own world", Frame2(np.array(out)), t, np.array(covs), truth=Frame2(np.array(poses)))


def scenario(seed):
    """The scenario range_bearing_2d, four rounds: a larger noise, for which an EKF is not linear enough."""
    history = History()
    data = UserData.from_toml(find_scenario("range_bearing_2d"), {"time.last": 200})
    for _ in history.watch(universal_slam(data, seed=seed)):
        pass
    with tempfile.TemporaryDirectory() as folder:
        write_rec(Path(folder) / "estimate.rec", history)
        return read_rec(Path(folder) / "estimate.rec")


def contestants(path):
    """Names, versions and functions of a seed; those that are not there as a sentence."""
    from ekfslam_tutorial import __version__

    yield f"ekfslam_tutorial {__version__}, EKF one by one", lambda seed: filtered(Ours, world(seed))
    yield f"ekfslam_tutorial {__version__}, range_bearing_2d", scenario
    if importlib.util.find_spec("filterpy"):
        from .peers.filterpy_peer import FilterPy

        yield f"filterpy {version('filterpy')}, EKF one by one", lambda seed: filtered(FilterPy, world(seed))
    if importlib.util.find_spec("gtsam"):
        yield f"GTSAM {version('gtsam')}, Levenberg-Marquardt, marginals", lambda seed: gtsam_batch(world(seed))
    if path:
        yield "PythonRobotics ekf_slam.py, its own world and noise", lambda seed: as_it_is(path, seed)


def main():
    """Audit all, write the files and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--python-robotics", metavar="FILE", help="its SLAM/EKFSLAM/ekf_slam.py")
    parser.add_argument("--runs", type=int, default=RUNS)
    options = parser.parse_args()
    kept = {"runs": options.runs, "landmarks": LANDMARKS, "peers": {}}
    for name, make in contestants(options.python_robotics):
        found = audit([run_errors(make(seed), "fixed") for seed in range(1, options.runs + 1)])
        kept["peers"][name] = found.summary()
        print(f"{name}: {found.verdict}", flush=True)
        if "range_bearing_2d" in name:
            use_style(dpi=80)
            fig = audit_picture(found)
            fig.savefig(PICTURE)
            plt.close(fig)
    TABLE.write_text(json.dumps(kept, indent=1) + "\n", encoding="utf-8")
    text = PAGE.read_text(encoding="utf-8")
    PAGE.write_text(MARKED.sub(lambda _: marked(kept), text), encoding="utf-8")


def marked(kept):
    """Return the table of the page, with its marks."""
    rows = ["| estimator | pose: NEES / dof | band | map | verdict | runs for 1.2 |", "|" + "---|" * 6]
    for name, s in kept["peers"].items():
        pose, lmks = s["pose"], s["map"]
        land = f"{lmks['ratio']:.2f} ({lmks['low']:.2f} to {lmks['high']:.2f})" if lmks["runs"] else "-"
        band = f"{pose['low']:.2f} to {pose['high']:.2f}"
        rows.append(f"| {name} | {pose['ratio']:.2f} | {band} | {land} | **{s['verdict']}** | {pose['runs_needed']} |")
    return "\n".join(["<!-- honesty -->", *rows, "<!-- /honesty -->"])


if __name__ == "__main__":
    main()
