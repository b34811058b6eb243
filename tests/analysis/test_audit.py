"""The audit on errors whose truth is known: its band holds, its power is what it says, and it sees what is wrong."""

import json

import numpy as np
import pytest

from ekfslam_tutorial.analysis import anees_band
from ekfslam_tutorial.analysis.audit import (
    LEVELS,
    RunErrors,
    audit,
    effective_dof,
    judge,
    power,
    runs_needed,
    whitened,
)


def correlated(rng, shape, rho, constant=0.0):
    """Numbers N(0, 1) of shape (..., F, d): first-order Markov in time, and a part that stays the same over a run."""
    u = rng.normal(size=shape)
    for t in range(1, shape[-2]):
        u[..., t, :] = rho * u[..., t - 1, :] + np.sqrt(1 - rho**2) * u[..., t, :]
    return np.sqrt(1 - constant) * u + np.sqrt(constant) * rng.normal(size=(*shape[:-2], 1, shape[-1]))


def covariance(rng, n):
    A = rng.normal(size=(n, n))
    return np.diag([0.1] * n) @ (A @ A.T + np.eye(n)) @ np.diag([0.1] * n)


def localisation(rng, runs, frames=100):
    """A Kalman filter of position, heading and what disturbs them, all runs at once: honest, errors correlated in time.

    Errors follow e' = A (I - K H) e + noise; the covariances are those of the filter. Returns e and P, (R, F, 3).
    """
    A = np.array([[1.0, 0.02, 0.1], [-0.02, 1.0, 0.05], [0.0, 0.0, 0.98]])
    Q, H, R = 1e-3 * np.diag([1.0, 1.0, 0.3]), np.eye(2, 3), 4e-3 * np.eye(2)
    P = 1e-2 * np.eye(3)
    e, out, covs = rng.multivariate_normal(np.zeros(3), P, runs), [], []
    for _ in range(frames):
        e = e @ A.T + rng.multivariate_normal(np.zeros(3), Q, runs)
        P = A @ P @ A.T + Q
        K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
        z = -e @ H.T + rng.multivariate_normal(np.zeros(2), R, runs)  # innovation: truth less estimate, and noise
        e, P = e + z @ K.T, P - K @ H @ P
        out.append(e)
        covs.append(P)
    return np.swapaxes(out, 0, 1), np.broadcast_to(covs, (runs, frames, 3, 3))


def as_runs(e, P, factor=1.0):
    return [
        RunErrors(f"run {k}", np.arange(float(len(a))), a, b / factor)
        for k, (a, b) in enumerate(zip(e, P, strict=True))
    ]


@pytest.fixture(scope="module")
def many():
    return localisation(np.random.default_rng(7), 20_000, 60)


def test_the_band_of_one_run_holds_for_1000(many):
    """Regions of 95 % hold the last pose of 1,000 runs in 95 % +- 1.5 %: 2.2 sigma of a share of 0.95 among 1,000."""
    e, P = many
    found = audit(as_runs(e[:1000], P[:1000]))
    assert abs(found.last[0.95] - 0.95) < 0.015 and abs(found.coverage[0.95] - 0.95) < 0.015
    assert found.verdict == "honest"
    assert all(abs(found.last[p] - p) < 3.3 * np.sqrt(p * (1 - p) / 1000) for p in LEVELS)  # 99.9 % bands


def test_the_verdict_on_20_honest_runs_is_right_in_95_percent():
    """1,000 audits of 20 runs each, errors strongly correlated: inside the 95 % band in 95 % +- 1.5 %."""
    rng = np.random.default_rng(3)
    u = correlated(rng, (1000, 20, 60, 3), 0.8)
    inside = [judge((a**2).mean(), effective_dof(a, rng), 20).word == "as it should be" for a in u]
    assert abs(np.mean(inside) - 0.95) <= 0.015


@pytest.mark.parametrize(("rho", "constant"), [(0.0, 0.0), (0.9, 0.0), (0.7, 0.3)])
def test_degrees_of_freedom_are_those_of_the_variance(rho, constant):
    """20 runs: within 30 % of (F d)^2 / sum |C_st|^2, in the mean of 100 audits within 8 %; a bias does not matter."""
    rng, F = np.random.default_rng(5), 80
    lag = np.abs(np.subtract.outer(np.arange(F), np.arange(F)))
    C = (1 - constant) * rho**lag + constant
    right = (F * 3) ** 2 / (3 * (C**2).sum())
    found = [effective_dof(correlated(rng, (20, F, 3), rho, constant), rng) for _ in range(100)]
    assert np.mean(found) == pytest.approx(right, rel=0.08)
    biased = effective_dof(correlated(rng, (400, F, 3), rho, constant) + 0.4, rng)
    grown = 1 + 0.4**2  # the squares are larger, the spread is not
    assert biased / grown**2 == pytest.approx(right, rel=0.12) or biased == F * 3


def test_a_factor_of_1_2_is_found_in_99_percent_by_20_runs():
    """120 audits of 20 runs each of a filter whose covariances are too small by 1.2, and 25 where they are too large.

    One run of 150 poses is worth some 70 independent numbers here, of its 450.
    """
    e, P = localisation(np.random.default_rng(11), 2400, 150)
    words = [audit(as_runs(e[k : k + 20], P[k : k + 20], 1.2)).verdict for k in range(0, 2400, 20)]
    assert np.mean([w == "over-confident" for w in words]) >= 0.99
    wide = [audit(as_runs(e[k : k + 20], P[k : k + 20], 1 / 1.2)).verdict for k in range(0, 500, 20)]
    assert np.mean([w == "too cautious" for w in wide]) >= 0.96


def test_the_power_is_what_it_says():
    """Runs of 12 independent poses: as many as are said to find 1.2 with 90 % find it in 90 % +- 4 % of 1,000 tries."""
    rng = np.random.default_rng(2)
    n = runs_needed(36)
    ratios = 1.2 * rng.chisquare(36 * n, 1000) / (36 * n)
    found = np.mean([judge(r, 36, n).word == "over-confident" for r in ratios])
    assert abs(found - 0.9) < 0.04
    assert power(36 * n) >= 0.9 > power(36 * (n - 1))


def test_one_run_says_so_too(rng):
    """With one run the correlation is measured along it; 200 honest ones: inside the 95 % band in 90 to 99 %."""
    u = correlated(rng, (200, 300, 3), 0.9)
    inside = [judge((a**2).mean(), effective_dof([a]), 1).word == "as it should be" for a in u]
    assert 0.90 <= np.mean(inside) <= 0.99
    found = audit(as_runs(u[:1], np.broadcast_to(np.eye(3), (1, 300, 3, 3))))
    assert "as far as 1 run can tell" in found.sentence and found.pose.runs_needed > 1


def test_whitened_errors_have_the_length_of_the_mahalanobis_distance(rng):
    P = np.array([covariance(rng, 6) for _ in range(5)])
    e = rng.normal(size=(5, 6))
    want = np.einsum("ni,nij,nj->n", e, np.linalg.inv(P), e)
    np.testing.assert_allclose((whitened(e, P) ** 2).sum(1), want, rtol=1e-9)
    P[2] = 0
    assert np.isnan(whitened(e, P)[2]).all() and np.isfinite(whitened(e, P)[3]).all()


def test_every_part_is_heard(rng):
    """Honest poses, a map that is too sure, white innovations: over-confident, by the map; three bands, wider."""
    e, P = localisation(rng, 12)
    nis = np.tile([2.0, 2.0], (400, 1))
    more = lambda: dict(map_nees=60.0, map_dof=20, z=rng.normal(size=(400, 2)), nis=nis)
    runs = [RunErrors(r.name, r.t, r.e, r.P, **more()) for r in as_runs(e, P)]
    found = audit(runs)
    assert found.verdict == "over-confident" and found.map.ratio == pytest.approx(3.0)
    assert found.pose.word == "as it should be" == found.innovations.word
    assert found.level == pytest.approx(1 - 0.05 / 3) and found.white
    low, high = anees_band(20, 12, found.level)
    assert (found.map.low, found.map.high) == (pytest.approx(low / 20), pytest.approx(high / 20))


def test_innovations_that_last_are_seen(rng):
    e, P = localisation(rng, 2)
    z = correlated(rng, (400, 2), 0.5)
    z[200] = np.nan  # another series begins
    a, b = as_runs(e, P)
    runs = [RunErrors(r.name, r.t, r.e, r.P, z=z) for r in (a, b)]
    found = audit(runs)
    assert found.whiteness[0] == pytest.approx(0.5, abs=0.1) and not found.white


def test_the_summary_is_json(rng):
    e, P = localisation(rng, 3)
    s = json.loads(json.dumps(audit(as_runs(e, P)).summary(), allow_nan=False))
    assert s["runs"] == 3 and s["map"]["ratio"] is None and s["pose"]["word"] and len(s["per_run"]) == 3
    assert s["pose"]["low"] < 1 < s["pose"]["high"] and s["map"]["runs_needed"] is None


def test_what_cannot_be_audited(rng):
    with pytest.raises(ValueError, match="at least one run"):
        audit([])
    flat = RunErrors("a", np.zeros(2), np.zeros((2, 3)), np.zeros((2, 3, 3)))
    space = RunErrors("b", np.zeros(2), np.zeros((2, 6)), np.zeros((2, 6, 6)))
    with pytest.raises(ValueError, match="some runs are in the plane"):
        audit([flat, space])
    assert audit([flat]).verdict == "not known", "a pose that is known has no NEES"
