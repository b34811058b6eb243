"""Two robots that share landmarks help each other: their errors become correlated, and each is better than alone."""

import numpy as np
import pytest

from ekfslam_tutorial.ekf import Map
from ekfslam_tutorial.geometry import Frame2, Frame3, e2q, v2q
from ekfslam_tutorial.models.landmarks import EucPnt
from ekfslam_tutorial.models.motion import Odometry2, Odometry3
from ekfslam_tutorial.models.sensors import PinHoleDepth, RangeBearing
from ekfslam_tutorial.simulation import draw, worlds
from ekfslam_tutorial.slam import Options, Rob, Sen, correct_known_lmks, init_new_lmks, move, place

from .scenes import FORWARD, raw


class Team:
    """Robots on their rounds in one world, with one map.

    The truth, the noise of each robot's control and of each sensor are drawn by robot, so a robot alone goes through
    the same as in the team.
    """

    def __init__(self, seed, frame, motion, sensor, mount, starts, step, std_u, points, P0, **options):
        self.map, self.frame, self.lmks, self.obs = Map(), frame, {}, {}
        self.points, self.step, self.std_u = points, step, std_u
        self.opt = Options(**options)
        self.robots, self.sensors, self.truth, self.rng = {}, {}, {}, {}
        for id, start in starts.items():
            self.rng[id] = np.random.default_rng([seed, id])
            self.robots[id] = Rob(id, motion, U=np.diag(std_u**2), sensors=[id])
            self.sensors[id] = Sen(id, id, sensor, frame)
            self.truth[id] = frame(start)
            place(self.map, self.robots[id], frame(start + draw(self.rng[id], P0[id])).normalized()[0].x, P0[id])
            place(self.map, self.sensors[id], mount)

    def go(self, frames):
        for _ in range(frames):
            for id, rob in self.robots.items():
                self._turn(id, rob)
        return self

    def _turn(self, id, rob):
        rng, sen = self.rng[id], self.sensors[id]
        self.truth[id] = self.frame(rob.motion.move(self.truth[id].x, self.step, 0.1)[0]).normalized()[0]
        rob.u = self.step + self.std_u * rng.normal(size=len(self.step))
        move(self.map, rob, 0.1)
        p = sen.frame(self.map).to_frame(self.truth[id].to_frame(np.array(list(self.points.values())))[0])[0]
        y = sen.model.project(p)[0]
        y = y + rng.normal(size=y.shape) @ np.sqrt(sen.model.R)
        seen = np.asarray(sen.model.visible(y, p))
        measurements = raw(np.array(list(self.points))[seen], y[seen])
        _, new = correct_known_lmks(self.map, rob, sen, self.lmks, self.obs, measurements, self.opt)
        init_new_lmks(self.map, rob, sen, self.lmks, measurements, new, self.opt, 5)

    def error(self, id):
        """Squared position error, and its expectation."""
        r = slice(self.robots[id].r.start, self.robots[id].r.start + self.frame.dim)
        return np.sum((self.map.x[r] - self.truth[id].t) ** 2), np.trace(self.map.P[r, r])

    def correlation(self):
        """Largest correlation between coordinates of the two robots."""
        a, b = (slice(rob.r.start, rob.r.start + self.frame.dim) for rob in self.robots.values())
        P = self.map.P
        return np.abs(P[a, b] / np.sqrt(np.outer(np.diag(P[a, a]), np.diag(P[b, b])))).max()


def plane(seed, ids):
    """Half a round each: a robot ends where the other one began and knew its landmarks best."""
    starts = {1: np.array([0.0, -2.0, 0.0]), 2: np.array([0.0, 2.0, np.pi])}
    return Team(
        seed,
        Frame2,
        Odometry2(),
        RangeBearing(0.05, 0.01, max_range=3.0),
        np.zeros(3),
        {id: starts[id] for id in ids},
        np.array([0.25, 0.0, 2 * np.pi / 50]),
        np.array([0.02, 0.02, np.radians(0.3)]),
        dict(zip(*worlds.ring(10, 4.0), strict=True)),
        {id: 1e-6 * np.eye(3) for id in starts},
        lmk_type=EucPnt(2),
    ).go(25)


def space(seed, ids):
    """Two depth cameras in the cloister; the second robot does not quite know where it starts."""
    q = e2q(np.array([0.0, 0.0, 0.2]))[0]
    starts = {1: np.array([0.0, -5.0, 0.3, 1, 0, 0, 0]), 2: np.concatenate([[-1.5, -4.5, 0.3], q])}
    unsure = np.diag([4e-4] * 3 + [0.0] * 4)
    for axis, std in zip(np.eye(3), np.radians([0.5] * 3), strict=True):
        dq = v2q(std * axis)[0] - [1, 0, 0, 0]
        dq = np.concatenate([np.zeros(3), Frame3(starts[2]).compose(Frame3(np.concatenate([np.zeros(3), dq])))[0].q])
        unsure += np.outer(dq, dq)
    return Team(
        seed,
        Frame3,
        Odometry3(),
        PinHoleDepth(depth_std=0.05),
        FORWARD,
        {id: starts[id] for id in ids},
        np.array([0.08, 0, 0, 0, 0, np.radians(0.9)]),
        np.array([0.005] * 3 + [np.radians(0.1)] * 3),
        dict(zip(*worlds.cloister(), strict=True)),
        {1: np.zeros((7, 7)), 2: unsure},
        lmk_type=EucPnt(),
        n_updates=10,
    ).go(40)


@pytest.mark.parametrize("world, seeds", [(plane, 20), (space, 5)])
def test_each_is_better_than_alone(world, seeds):
    """Mean squared error over the seeds, and the variance that the filter states, of each robot at the end."""
    together = [world(seed, (1, 2)) for seed in range(seeds)]
    assert min(team.correlation() for team in together) > 0.05
    for id in (1, 2):
        alone = [world(seed, (id,)) for seed in range(seeds)]
        team_error, team_variance = np.mean([team.error(id) for team in together], 0)
        own_error, own_variance = np.mean([team.error(id) for team in alone], 0)
        assert team_variance < own_variance and team_error < own_error


def test_strangers_are_not_correlated():
    """Robots that see no landmark in common know nothing of each other."""
    team = plane(0, (1, 2))
    strangers = plane(0, (1,))
    r = strangers.map.add(np.zeros(3), np.eye(3))
    strangers.robots[2] = Rob(2, Odometry2(), r=r, u=np.ones(3), U=np.eye(3))
    move(strangers.map, strangers.robots[2], 0.1)
    assert strangers.correlation() == 0 and team.correlation() > 0.05
