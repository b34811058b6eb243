"""EuRoC V1_01 smoothed by GTSAM as a whole: what a batch makes of the log that the scenario `euroc_v101` filters.

    python -m benchmarks.flight [--set data.last=300 ...]

needs the log (`ekfslam data fetch euroc_v101`), and the package gtsam, which the environment of `make bench` has. The
noise of the IMU, the camera and the tracks are the scenario's. IMU factors are preintegrated (C. Forster et al., IEEE
Transactions on Robotics 33(1), 2017); each track is one smart factor, in which its point is eliminated. It begins at
the path of the filter.
"""

import argparse
import time
from itertools import chain
from pathlib import Path

import numpy as np

from ekfslam_tutorial.analysis.inertial import rotation_rmse, upright
from ekfslam_tutorial.datasets import prepare
from ekfslam_tutorial.geometry import Frame3, e2q
from ekfslam_tutorial.toolbox import UserData, universal_slam
from ekfslam_tutorial.toolbox.scenario.overrides import parse_override

try:
    import gtsam
    from gtsam.symbol_shorthand import B, V, X
except ImportError as error:
    raise SystemExit("benchmarks.flight needs GTSAM: pip install gtsam") from error

SCENARIO = Path(__file__).parents[1] / "data" / "scenarios" / "euroc_v101.toml"
PIXEL_STD = 2.0
"""Pixels. The scenario says 1.0, and that points wander, which smart factors cannot."""
SHORTEST = 3
"""Frames. A shorter track says little of where the camera was."""
OUTLIER = 4.0
"""A smart factor whose mean error is beyond so many sigma is left out: tracks slip."""


def pose(x):
    """GTSAM's pose of the first seven numbers of a state."""
    return gtsam.Pose3(gtsam.Rot3.Quaternion(*x[3:7]), x[:3])


def biases(x):
    """GTSAM's biases, accelerometer first, of the state of an `Imu`."""
    return gtsam.imuBias.ConstantBias(x[13:16], x[10:13])


def imu_factors(log, model, start):
    """One factor between neighbouring frames. The densities are the model's."""
    params, I = gtsam.PreintegrationCombinedParams.MakeSharedU(-model.gravity[2]), np.eye(3)
    params.setGyroscopeCovariance(model.gyro_noise**2 * I)
    params.setAccelerometerCovariance(model.acc_noise**2 * I)
    params.setBiasOmegaCovariance(model.gyro_walk**2 * I)
    params.setBiasAccCovariance(model.acc_walk**2 * I)
    params.setIntegrationCovariance(1e-10 * I)
    for k in range(1, len(log)):
        sums, rows = gtsam.PreintegratedCombinedMeasurements(params, biases(start)), log.rows(k)
        for u, dt in zip(log.u[rows], log.dt[rows], strict=True):
            if dt > 0:
                sums.integrateMeasurement(u[3:6], u[:3], dt)
        yield gtsam.CombinedImuFactor(X(k - 1), V(k - 1), X(k), V(k), B(k - 1), B(k), sums)


def smart_factors(raw, sensor, sigma):
    """One factor for each track: its point is where it fits best."""
    u0, v0, fu, fv = sensor.model.k
    lens = gtsam.Cal3_S2(fu, fv, 0.0, u0, v0)
    mounting = pose([*sensor.position, *e2q(np.radians(sensor.orientation_deg))[0]])
    noise, how = gtsam.noiseModel.Isotropic.Sigma(2, sigma), gtsam.SmartProjectionParams()
    how.setDegeneracyMode(gtsam.DegeneracyMode.ZERO_ON_DEGENERACY)
    how.setDynamicOutlierRejectionThreshold(OUTLIER * sigma)
    tracks = {}
    for k, seen in enumerate(raw):
        for i, y in zip(seen.ids.tolist(), seen.y, strict=True):
            tracks.setdefault(i, []).append((y, k))
    for track in tracks.values():
        if len(track) >= SHORTEST:
            factor = gtsam.SmartProjectionPoseFactorCal3_S2(noise, lens, mounting, how)
            for y, k in track:
                factor.add(y, X(k))
            yield factor


def priors(start, P):
    """What is known of the first state: at rest; biases as the filter knows them; yaw and place are the gauge."""
    sigmas, known = gtsam.noiseModel.Diagonal.Sigmas, np.sqrt(np.diag(P))
    yield gtsam.PriorFactorPose3(X(0), pose(start), sigmas(np.array([0.1, 0.1, 1e-3, 1e-3, 1e-3, 1e-3])))
    yield gtsam.PriorFactorVector(V(0), start[7:10], sigmas(np.full(3, 0.05)))
    yield gtsam.PriorFactorConstantBias(B(0), biases(start), sigmas(np.concatenate([known[13:16], known[10:13]])))


def main(words=None):
    """Filter, smooth, compare both with the truth."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="change a key of the scenario")
    parser.add_argument("--pixel-std", type=float, default=PIXEL_STD, help="of the smart factors")
    args = parser.parse_args(words)
    data, recording = prepare(UserData.from_toml(SCENARIO, dict(map(parse_override, args.set))))
    log, raw = recording.robots[1], recording.raw[1]
    filtered = np.array([snapshot.map.x[snapshot.robs[0].r].copy() for snapshot in universal_slam(data, recording)])
    start, P = recording.starts[1]
    factors, guess = gtsam.NonlinearFactorGraph(), gtsam.Values()
    imu, tracks = imu_factors(log, data.robots[0].motion, start), smart_factors(raw, data.sensors[0], args.pixel_std)
    for factor in chain(priors(start, P), imu, tracks):
        factors.add(factor)
    for k, x in enumerate(filtered):
        guess.insert(X(k), pose(x))
        guess.insert(V(k), x[7:10])
        guess.insert(B(k), biases(x))
    began, before = time.perf_counter(), factors.error(guess)
    found = gtsam.LevenbergMarquardtOptimizer(factors, guess).optimize()
    seconds = time.perf_counter() - began
    smoothed = [found.atPose3(X(k)) for k in range(len(filtered))]
    smoothed = np.array([[*p.translation(), *np.roll(p.rotation().toQuaternion().coeffs(), 1)] for p in smoothed])

    truth = recording.truth[1]
    known = np.isfinite(truth).all(axis=1)
    after = factors.error(found)
    print(f"{len(filtered)} frames, {factors.size()} factors; error {before:.0f} -> {after:.0f}, {seconds:.1f} s")
    for name, x in (("filter", filtered[known]), ("GTSAM, batch", smoothed[known])):
        F = upright(x[:, :3], truth[known, :3])
        points = F.from_frame(x[:, :3])[0]
        off = np.sqrt(((points - truth[known, :3]) ** 2).sum(1).mean())
        aligned = np.array([[*t, *F.compose(Frame3(pose))[0].q] for t, pose in zip(points, x[:, :7], strict=True)])
        turned = np.rad2deg(rotation_rmse(aligned, truth[known]))
        print(f"{name:14s} position {off:.4f} m (aligned in position and yaw), orientation {turned:.2f} deg")


if __name__ == "__main__":
    main()
