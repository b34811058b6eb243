"""Calibrate Victoria Park: one least squares over all poses, trees and seven constants, without GPS.

    python tools/calibrate_park.py

Who belongs to whom is taken from a run of the scenario. The residuals are those of the detections, with robust weights
(Cauchy), and of the motion between two scans in the truck's axes: along, across and turn. Gauss-Newton on the sparse
normal equations. docs/data_tuning.md has the results.
"""

import argparse
from dataclasses import asdict
from pathlib import Path

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.linalg import splu

from ekfslam_tutorial.datasets import victoria_park
from ekfslam_tutorial.geometry import Frame2, wrap
from ekfslam_tutorial.models.motion import Vehicle
from ekfslam_tutorial.models.sensors.range_bearing import polar
from ekfslam_tutorial.toolbox import UserData, universal_slam

SCENARIO = Path(__file__).resolve().parents[1] / "data" / "scenarios" / "victoria_park.toml"
RANGE_STD, BEARING_STD = 0.1, np.radians(0.5)
SPEED_STD, TURN_STD, SLIP = 0.2, np.radians(1.0), 0.05  # m/s, rad of steering, share of the way
LEAST = 1e-3  # m and rad, of a step of which there is nothing to be said
CONSTANTS = ("bearing", "per_diameter", "steer_scale", "steer_offset", "delay", "range", "speed_scale")


def matched(log):
    """A run of the scenario: poses (F, 3), and of each detection that was used its frame, its row and its tree."""
    recording = victoria_park.recording(log)
    good = np.flatnonzero(
        (log.detections[:, 0] < victoria_park.MAX_RANGE) & (log.detections[:, 2] < victoria_park.MAX_DIAMETER)
    )
    poses, rows = [], []
    for k, now in enumerate(universal_slam(UserData.from_toml(SCENARIO), recording)):
        poses.append(now.robs[0].state(now.map))
        first = recording.raw[1].offsets[k]
        rows += [(k, good[first + o.index], o.lmk) for o in now.obs.values() if o.updated]
    frame, row, tree = np.array(rows).T
    _, tree, count = np.unique(tree, return_inverse=True, return_counts=True)
    often = count[tree] >= 3
    _, tree = np.unique(tree[often], return_inverse=True)
    return np.array(poses), frame[often], row[often], tree


class Problem:
    """Residuals of everything, as functions of poses, trees and constants."""

    def __init__(self, log, frame, row, tree):
        self.log, self.frame, self.tree = log, frame, tree
        self.seen = log.detections[row]
        self.dt = np.diff(log.scan_t)

    def measured(self, c):
        """Range and bearing (M, 2) of the detections, calibrated."""
        r, b, d = self.seen.T
        return np.column_stack([r + c["range"] + c["per_diameter"] * d, b + c["bearing"]])

    def sightings(self, c, x, trees):
        """Whitened residuals (M, 2) of the detections, and their derivatives by pose and tree."""
        p, P_x, P_l = Frame2(x[self.frame]).to_frame(trees[self.tree])
        e, E_p = polar(p)
        z = self.measured(c) - e
        z[:, 1] = wrap(z[:, 1])
        w = 1 / np.array([RANGE_STD, BEARING_STD])
        return z * w, -w[:, None] * (E_p @ P_x), -w[:, None] * (E_p @ P_l)

    def motion(self, c, x):
        """Whitened residuals (F - 1, 3) of the steps, and their derivatives by the poses before and after."""
        odometry = self.log.odometry * [1, c["speed_scale"], c["steer_scale"]] + [c["delay"], 0, c["steer_offset"]]
        u, _ = victoria_park.commands(odometry, self.log.scan_t)
        u, car = u[1:], Vehicle()
        told = car.move(np.zeros(3), u * self.dt[:, None] ** [1, 0, 0], 1.0)[0]  # a step of 1 s at v dt is the same
        F, I_x = Frame2(x[:-1]).inverse()
        step, S_f, S_x = F.compose(Frame2(x[1:]))
        e = step.x - told
        e[:, 2] = wrap(e[:, 2])
        # what the turn does at the laser is no side slip of the axle
        lever = np.zeros((len(e), 3, 3)) + np.eye(3)
        lever[:, 0, 2], lever[:, 1, 2] = car.left, -car.ahead
        way = np.abs(u[:, 0]) * self.dt
        std = np.column_stack([SPEED_STD * self.dt, SLIP * way, way / car.wheelbase * TURN_STD]) * (way > 0)[:, None]
        W = lever / (std + LEAST)[:, :, None]
        return (W @ e[..., None])[..., 0], W @ S_f @ I_x, W @ S_x


def solve(problem, c, x, iterations=8):
    """Gauss-Newton. Returns the constants and their standard deviations."""
    frame, tree, y = problem.frame, problem.tree, problem.measured(c)
    a = x[frame, 2] + y[:, 1]
    ends = x[frame, :2] + y[:, :1] * np.column_stack([np.cos(a), np.sin(a)])
    trees = np.column_stack([np.bincount(tree, p) / np.bincount(tree) for p in ends.T])
    n_x, n_l = x.size, trees.size
    of_pose = lambda k: 3 * k[:, None] + np.arange(3)
    steps = np.arange(len(x) - 1)
    for _ in range(iterations):
        z, Z_x, Z_l = problem.sightings(c, x, trees)
        m, M_a, M_b = problem.motion(c, x)
        w = 1 / np.sqrt(1 + (z**2).sum(1) / 4)
        blocks = [(0, Z_x * w[:, None, None], of_pose(frame))]
        blocks += [(0, Z_l * w[:, None, None], n_x + 2 * tree[:, None] + np.arange(2))]
        blocks += [(z.size, M_a, of_pose(steps)), (z.size, M_b, of_pose(steps + 1))]
        entries = [_entries(*block) for block in blocks]
        for k, name in enumerate(CONSTANTS):
            h = 1e-5
            moved = c | {name: c[name] + h}
            column = [(problem.sightings(moved, x, trees)[0] - z) * w[:, None], problem.motion(moved, x)[0] - m]
            d = np.concatenate([part.ravel() for part in column]) / h
            entries.append((np.arange(len(d)), np.full(len(d), n_x + n_l + k), d))
        rows, columns, values = (np.concatenate(part) for part in zip(*entries, strict=True))
        J = csr_matrix((values, (rows, columns)), shape=(z.size + m.size, n_x + n_l + len(CONSTANTS)))
        residual = np.concatenate([(z * w[:, None]).ravel(), m.ravel()])
        H = (J.T @ J).tolil()
        H[:3, :3] += 1e8 * np.eye(3)  # the first pose is the origin
        lu = splu(H.tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
        dx = -lu.solve(J.T @ residual)
        x, trees = x + dx[:n_x].reshape(-1, 3), trees + dx[n_x : n_x + n_l].reshape(-1, 2)
        c = {name: c[name] + dx[n_x + n_l + k] for k, name in enumerate(CONSTANTS)}
    units = np.zeros((len(CONSTANTS), n_x + n_l + len(CONSTANTS)))
    units[:, n_x + n_l :] = np.eye(len(CONSTANTS))
    return c, np.sqrt([lu.solve(unit)[n_x + n_l + k] for k, unit in enumerate(units)])


def _entries(first, blocks, columns):
    """Rows, columns and values of a stack (K, a, b) of blocks, which stand one below the other from `first` on."""
    K, a, b = blocks.shape
    rows = first + np.arange(K * a).reshape(K, a, 1) + np.zeros(b, int)
    return rows.ravel(), np.broadcast_to(columns[:, None], blocks.shape).ravel(), blocks.ravel()


def main():
    """Run the calibration and print it."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--path", help="the file, or a folder with it; without it, below the folders of EKFSLAM_DATA")
    log = victoria_park.read_log(parser.parse_args().path)
    x, *who = matched(log)
    x[:, 2] = np.unwrap(x[:, 2])
    start = asdict(victoria_park.CALIBRATION) | {"range": 0.0, "speed_scale": 1.0}
    found, std = solve(Problem(log, *who), start, x)
    for (name, value), s in zip(found.items(), std, strict=True):
        scale, unit = (180 / np.pi, "deg") if name in ("bearing", "steer_offset") else (1, "")
        print(f"{name:14} {scale * value:8.4f} +- {scale * s:.4f} {unit}")


if __name__ == "__main__":
    main()
