"""How honest the errors are in space: many robots with a stereo camera, on the same rounds among the same landmarks.

    python -m benchmarks.honest [--runs 30] [--rounds 10] [--landmarks 36]

It takes some minutes. The equations of the filter are those of `fast.Batch`, which the tests hold against the core.
Pose NEES per degree of freedom (1 is right) and position RMSE are means over all runs, and all frames but the first.
"""

import argparse
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ekfslam_tutorial.fast import Batch
from ekfslam_tutorial.geometry import ORIGIN, Frame3, e2q
from ekfslam_tutorial.models.landmarks import EucPnt
from ekfslam_tutorial.models.motion import Odometry3
from ekfslam_tutorial.models.observation import observe, retro_project

ROB, POINT, MOTION = slice(0, 7), EucPnt(3), Odometry3()
FRAMES = 70  # of a round
SIZE = np.array([640.0, 480.0])
MOUNT = Frame3(np.concatenate([[0.1, 0.0, 0.1], e2q(np.radians([-90.0, 0.0, -90.0]))[0]]))  # a camera that looks ahead


@dataclass(frozen=True)
class Stereo:
    """Two cameras side by side: y = [u, v, u', v'], pixels; both see the same row, with noise of its own."""

    std: float = 2**0.5
    k: tuple = (320.0, 240.0, 480.0, 480.0)
    base: float = 0.24
    reach: float = 7.0

    dim: ClassVar[int] = 3
    bearing_only: ClassVar[bool] = False

    @property
    def R(self):
        """Noise of the four numbers."""
        return self.std**2 * np.eye(4)

    def project(self, p):
        """Point in the left camera to pixels."""
        u0, v0, fu, fv = self.k
        x, y, z = np.moveaxis(p, -1, 0)
        Y_p = np.zeros((*p.shape[:-1], 4, 3))
        Y_p[..., 0, 0] = Y_p[..., 2, 0] = fu / z
        Y_p[..., 1, 1] = Y_p[..., 3, 1] = fv / z
        Y_p[..., 0, 2], Y_p[..., 2, 2] = -fu * x / z**2, -fu * (x - self.base) / z**2
        Y_p[..., 1, 2] = Y_p[..., 3, 2] = -fv * y / z**2
        v = fv * y / z + v0
        return np.stack([fu * x / z + u0, v, fu * (x - self.base) / z + u0, v], -1), Y_p

    def retro(self, y):
        """Pixels to a point: the distance by the disparity, 2 pixels at least."""
        u0, v0, fu, fv = self.k
        far = y[..., 0] - y[..., 2] < 2
        d = np.where(far, 2.0, y[..., 0] - y[..., 2])
        z = fu * self.base / d
        a, b = (y[..., 0] - u0) / fu, ((y[..., 1] + y[..., 3]) / 2 - v0) / fv
        Z_u = np.where(far, 0.0, -z / d)
        P_y = np.zeros((*y.shape[:-1], 3, 4))
        for i, ray in enumerate((a, b, 1.0)):
            P_y[..., i, 0], P_y[..., i, 2] = ray * Z_u, -ray * Z_u
        P_y[..., 0, 0] += z / fu
        P_y[..., 1, 1] = P_y[..., 1, 3] = z / fv / 2
        return np.stack([a * z, b * z, z], -1), P_y

    def residual(self, y, e):
        """Difference of pixels."""
        return y - e

    def visible(self, y, p):
        """In the image, before the camera, and near enough."""
        near = (p[..., 2] > 0.8) & (np.linalg.norm(p, axis=-1) < self.reach)
        return near & (np.abs(p[..., 0]) < 1.4 * p[..., 2]) & (np.abs(p[..., 1]) < 1.2 * p[..., 2])


class World:
    """A circle with some heave, roll and pitch, among landmarks.

    Parameters
    ----------
    n : int
        Landmarks.
    frames : int
    sensor : SensorModel
    seed : int
    radius : float
        Of the circle, m.
    """

    def __init__(self, n, frames, sensor, seed=0, radius=5.0):
        rng, k = np.random.default_rng(seed), np.arange(frames)
        a, r = rng.uniform(0, 2 * np.pi, n), radius * rng.uniform(0.4, 1.7, n)
        self.points = np.stack([r * np.cos(a), r * np.sin(a), rng.uniform(-2, 2, n)], -1)
        self.u, turn = np.zeros((frames, 6)), 2 * np.pi / FRAMES
        self.u[:, 0], self.u[:, 2] = turn * radius, 0.05 * np.sin(2 * np.pi * k / 31)
        self.u[:, 3:] = np.stack([0.03 * np.cos(2 * np.pi * k / 23), 0.02 * np.cos(3 * turn * k), turn + 0 * k], -1)
        self.poses = [Frame3([0.0, -radius, 0.0, 1.0, 0.0, 0.0, 0.0])]
        for u in self.u[1:]:
            self.poses.append(Frame3(MOTION.move(self.poses[-1].x, u, 1.0)[0]).normalized()[0])
        seen = [MOUNT.to_frame(F.to_frame(self.points)[0])[0] for F in self.poses]
        with np.errstate(all="ignore"):
            self.y = np.array([sensor.project(p)[0] for p in seen])
            self.seen = np.array([sensor.visible(y, p) for y, p in zip(self.y, seen, strict=True)])


def run(world, sensor, error, seeds, U, joint=True):
    """Pose NEES and squared error of the position of all runs in every frame but the first, each (frames - 1, R).

    The noise of run i is that of its seed.
    """
    frames, N, R = len(world.u), len(world.points), len(seeds)
    rngs = [np.random.default_rng(seed) for seed in seeds]
    controls = world.u + np.array([rng.normal(size=(frames, 6)) for rng in rngs]) * np.sqrt(np.diag(U))
    noise = sensor.std * np.array([rng.normal(size=(frames, N, 4)) for rng in rngs])
    x, P, born, scores = np.zeros((R, 7 + 3 * N)), np.zeros((R, 7 + 3 * N, 7 + 3 * N)), [], []
    x[:, ROB] = world.poses[0].x
    batch = Batch(x, P)
    for k, true in enumerate(world.poses):
        if k:
            batch.predict(ROB, *MOTION.move(batch.x[:, ROB], controls[:, k], 1.0), U)
            normalize(batch)
        seen = np.flatnonzero(world.seen[k])
        y = world.y[k] + noise[:, k]
        known = [i for i in seen.tolist() if i in born]
        for some in [known] if joint and known else [[i] for i in known]:
            correct(batch, sensor, some, y, error)
            normalize(batch)
        for i in seen.tolist():
            if i not in born:
                start(batch, sensor, i, y[:, i])
                born.append(i)
        F = Frame3(batch.x[:, ROB])
        if k:
            e, E_f = F.minus(true)
            C = E_f @ batch.P[:, ROB, ROB] @ np.swapaxes(E_f, -1, -2)
            scores.append(((e * np.linalg.solve(C, e[..., None])[..., 0]).sum(-1), (e[:, :3] ** 2).sum(-1)))
    return np.moveaxis(np.array(scores), 1, 0), batch


def normalize(batch):
    """Quaternions of length one."""
    N, N_f = Frame3(batch.x[:, ROB]).normalized()
    batch.predict(ROB, N.x, N_f, np.zeros((7, 1)), np.zeros((1, 1)))


def lmk(i):
    """Range of landmark i."""
    return slice(7 + 3 * i, 10 + 3 * i)


def correct(batch, sensor, some, y, error):
    """Correct all runs by these landmarks at once, projected at the present estimate."""
    F, J, z = Frame3(batch.x[:, ROB]), [], []
    for i in some:
        e, E_r, _, E_l = observe(F, MOUNT, sensor, POINT, batch.x[:, lmk(i)])
        H = np.zeros((*e.shape, 3 * len(some)))
        at = 3 * some.index(i)
        H[..., at : at + 3] = E_l
        J.append((E_r, H))
        z.append(sensor.residual(y[:, i], e))
    r = np.concatenate([np.arange(7 + 3 * i, 10 + 3 * i) for i in some])
    blocks = (
        (ROB, np.concatenate([E_r for E_r, _ in J], 1)),
        (np.tile(r, (len(F.x), 1)), np.concatenate([H for _, H in J], 1)),
    )
    B = gauge(batch) if error == "invariant" else None
    batch.correct(blocks, np.concatenate(z, 1), np.kron(np.eye(len(some)), sensor.R))
    if B is not None:
        batch.carry(ROB, B, gauge(batch))


def gauge(batch):
    """How the states of all runs move with the world, shape (R, n, 6); see `slam.gauge`."""
    O, x = ORIGIN[3], batch.x
    B = np.zeros((*x.shape, 6))
    B[:, ROB] = O.compose(Frame3(x[:, ROB]))[1] @ O.X_step
    l = x[:, 7:].reshape(len(x), -1, 3)
    B[:, 7:] = -(POINT.to_frame(O, l)[1] @ O.X_step).reshape(len(x), -1, 6)
    return B


def start(batch, sensor, i, y):
    """A new landmark in all runs."""
    F = Frame3(batch.x[:, ROB])
    l, L_r, _, L_y, _ = retro_project(F, MOUNT, sensor, POINT, y, np.zeros((len(y), 0)))
    Q = L_y @ sensor.R @ np.swapaxes(L_y, -1, -2)
    batch.augment(lmk(i), np.arange(len(y)), l, ((ROB, L_r),), Q)


def main():
    """Print a table."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.honest", description=__doc__.splitlines()[0])
    for name, default in (("runs", 30), ("rounds", 10), ("landmarks", 36)):
        parser.add_argument(f"--{name}", type=int, default=default)
    args = parser.parse_args()
    sensor, U = Stereo(), np.diag([0.05**2] * 3 + [np.radians(1.0) ** 2] * 3)
    world = World(args.landmarks, FRAMES * args.rounds, sensor)
    print(f"{args.runs} runs, {args.rounds} rounds of {FRAMES} frames, {args.landmarks} landmarks")
    for joint in (True, False):
        for error in ("additive", "invariant"):
            (nees, squared), _ = run(world, sensor, error, range(args.runs), U, joint)
            way = "joint" if joint else "one by one"
            print(
                f"{way:10} {error:9}  NEES / 6: {nees.mean() / 6:.2f}  RMSE: {np.sqrt(squared.mean()):.3f} m",
                flush=True,
            )


if __name__ == "__main__":
    main()
