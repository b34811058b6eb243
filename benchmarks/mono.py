"""One frame of monocular SLAM in space: 100 inverse-depth landmarks, 13 states of the camera, n = 613, 20 corrections.

The whole frame is what `correct_known_lmks` does: project all landmarks, choose the 20 most uncertain, project again,
correct. The filter alone gets the 20 blocks of the first frame.
"""

from types import SimpleNamespace

import numpy as np

from ekfslam_tutorial.geometry import Frame3, e2q
from ekfslam_tutorial.models import retro_project
from ekfslam_tutorial.models.landmarks import IdpPnt
from ekfslam_tutorial.models.motion import ConstantVelocity
from ekfslam_tutorial.models.sensors import PinHole
from ekfslam_tutorial.slam import Lmk, Options, Rob, Sen, place, project_lmks

from .agreement import compared
from .clock import Variant, compare
from .machine import bandwidth_variant, gemm_variant, gflops, gigabytes, limit_us, triangle_bytes
from .ours import COMPILED, FAST, PLAIN, warm

LMKS, UPDATES, FRAMES = 100, 20, 20
AHEAD = np.concatenate([np.zeros(3), e2q(np.radians([-90, 0, -90]))[0]])  # a camera that looks ahead


class Scene:
    """A camera at the origin, landmarks in front of it, and frames of noisy measurements of all of them."""

    def __init__(self, joint=False, house=FAST, seed=1, **how):
        rng = np.random.default_rng(seed)
        self.house, self.map, kind = house, house.new_map(**how), IdpPnt()
        camera = PinHole(image_size=(640, 480), k=(320, 240, 320, 320), pixel_std=1.0)
        self.rob, self.sen = Rob(1, ConstantVelocity(), sensors=[1]), Sen(1, 1, camera, Frame3)
        self.opt = Options(lmk_type=kind, n_updates=UPDATES, joint=joint, error="additive")
        place(self.map, self.sen, AHEAD)

        pose = np.concatenate([np.eye(7)[3], np.zeros(6)])
        y = rng.uniform([20, 20], [620, 460], (LMKS, 2))
        rho = 1 / rng.uniform(2, 20, (LMKS, 1))
        Rf, Sf = Frame3(pose[:7]), Frame3(AHEAD)
        lmks = [retro_project(Rf, Sf, camera, kind, *prior)[0] for prior in zip(y, rho, strict=True)]
        truth = np.concatenate([pose, *lmks])
        shared = rng.normal(size=(len(truth), 6)) * 0.002
        P = shared @ shared.T + 0.003**2 * np.eye(len(truth))
        shift = shared @ rng.normal(size=6) + 0.003 * rng.normal(size=len(truth))

        self.rob.r = self.map.add(truth[:13] + shift[:13], P[:13, :13])
        self.lmks, self.obs = {}, {}
        for i in range(LMKS):
            r = slice(13 + 6 * i, 19 + 6 * i)
            self.lmks[i] = Lmk(i, kind, r=self.map.add(truth[r] + shift[r], P[r, r], P[r, : r.start]), slot=i)
        noise = rng.normal(size=(FRAMES, LMKS, 2))
        self.raws = [SimpleNamespace(ids=np.arange(LMKS), y=y + dy, R=None) for dy in noise]

    def step(self, k):
        """One frame."""
        raw = self.raws[k % FRAMES]
        self.house.correct_known_lmks(self.map, self.rob, self.sen, self.lmks, self.obs, raw, self.opt)

    def blocks(self):
        """Of the first landmarks: ranges (K, 6), z (K, 2), H_r (K, 2, 7), H_l (K, 2, 6), and R."""
        seen = project_lmks(self.map, self.rob, self.sen, [self.lmks[i] for i in range(UPDATES)])
        z = np.array([self.raws[0].y[o.lmk] - o.e for o in seen])
        ranges = [self.lmks[o.lmk].r for o in seen]
        return ranges, z, np.array([o.E_r for o in seen]), np.array([o.E_l for o in seen]), self.sen.model.R


class Filter:
    """20 corrections with given blocks."""

    def __init__(self, joint):
        scene = Scene()
        self.map, self.joint, self.rob = scene.map, joint, slice(0, 7)
        self.ranges, self.z, self.H_r, self.H_l, self.R = scene.blocks()
        self.rows = np.array([range(r.start, r.stop) for r in self.ranges])

    def step(self, k):
        """All 20."""
        if self.joint:
            FAST.update(self.map, ((self.rob, self.H_r), (self.rows, self.H_l)), self.z, self.R)
            return
        for r, z, H_r, H_l in zip(self.ranges, self.z, self.H_r, self.H_l, strict=True):
            FAST.update(self.map, ((self.rob, H_r), (r, H_l)), z, self.R)

    def state(self):
        """Mean and covariance."""
        return np.array(self.map.x), np.array(self.map.P)


class Textbook:
    """The same with dense matrices."""

    def __init__(self, joint):
        scene = Scene()
        self.x, self.P = np.array(scene.map.x), np.array(scene.map.P)
        ranges, z, H_r, H_l, R = scene.blocks()
        H = np.zeros((UPDATES, 2, len(self.x)))
        for i, r in enumerate(ranges):
            H[i, :, :7], H[i, :, r] = H_r[i], H_l[i]
        K = UPDATES if joint else 1
        self.stacks = [
            (H[i : i + K].reshape(2 * K, -1), z[i : i + K].ravel(), np.kron(np.eye(K), R)) for i in range(0, UPDATES, K)
        ]

    def step(self, k):
        """All 20."""
        for H, z, R in self.stacks:
            K = self.P @ H.T @ np.linalg.inv(H @ self.P @ H.T + R)
            self.x = self.x + K @ z
            self.P = (np.eye(len(self.x)) - K @ H) @ self.P

    def state(self):
        """Mean and covariance."""
        return self.x, self.P


MAKERS = {
    "whole frame, sequential": ("step", lambda: Scene(joint=False)),
    "whole frame, joint": ("step", lambda: Scene(joint=True)),
    "whole frame, sequential, compiled": ("step", warm(lambda: Scene(joint=False, compiled=True))),
    "whole frame, joint, compiled": ("step", warm(lambda: Scene(joint=True, compiled=True))),
    "whole frame, sequential, plain": ("step", lambda: Scene(joint=False, house=PLAIN)),
    "whole frame, joint, plain": ("step", lambda: Scene(joint=True, house=PLAIN)),
    "filter, sequential": ("filter", lambda: Filter(joint=False)),
    "filter, joint": ("filter", lambda: Filter(joint=True)),
    "textbook numpy, sequential": ("peer", lambda: Textbook(joint=False)),
    "textbook numpy, joint": ("peer", lambda: Textbook(joint=True)),
}


def check():
    """Rows for the table of agreements."""
    rows = []
    for joint, word in (False, "sequential"), (True, "joint"):
        dense = Textbook(joint)
        dense.step(0)

        def state(joint=joint):
            filter = Filter(joint)
            filter.step(0)
            return filter.state()

        rows.append(compared(f"3D monocular, filter, {word}", state, dense.state(), "textbook, given blocks"))
    return rows


def run(budget):
    """Rows: variant, kind, times; the limits too."""
    variants = [
        Variant(name, lambda make=make: make().step, singly=True, info={"kind": kind})
        for name, (kind, make) in MAKERS.items()
        if COMPILED or "compiled" not in name
    ]
    n = 13 + 6 * LMKS
    results = compare([*variants, gemm_variant(), bandwidth_variant(triangle_bytes(n))], budget)
    rates = gflops(results.pop("dgemm")), gigabytes(results.pop("in place"))
    rows = [{"n": n, "variant": name} | result for name, result in results.items()]
    for name, rank, times in ("limit, joint", 2 * UPDATES, 1), ("limit, sequential", 2, UPDATES):
        us = limit_us(n, rank, times, *rates)
        rows.append(
            {"n": n, "variant": name, "kind": "limit", "cpu_us": {"median": us}}
            | {"gflops": rates[0], "gb_per_s": rates[1]}
        )
    return rows
