"""NEES, NIS, their bands, and the honesty meter."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import chi2

from ekfslam_tutorial.analysis import anees_band, chi2_band, coverage, honesty, k_sigma, md2, nees, nis
from ekfslam_tutorial.geometry import Frame2, Frame3, q_prod, v2q


def covariance(rng, n):
    A = rng.normal(size=(n, n))
    return A @ A.T + 0.1 * np.eye(n)


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 8))
def test_md2_is_the_textbook_formula_and_does_not_depend_on_units(seed, n):
    rng = np.random.default_rng(seed)
    e, P = rng.normal(size=n), covariance(rng, n)
    units = 10.0 ** rng.uniform(-6, 6, n)
    expected = e @ np.linalg.inv(P) @ e
    assert md2(e, P) == pytest.approx(expected, rel=1e-7)
    assert md2(units * e, units[:, None] * P * units) == pytest.approx(expected, rel=1e-7)


def test_md2_broadcasts(rng):
    e, P = rng.normal(size=(5, 4, 3)), np.stack([covariance(rng, 3) for _ in range(4)])
    out = md2(e, P)
    assert out.shape == (5, 4)
    assert out[2, 1] == pytest.approx(e[2, 1] @ np.linalg.inv(P[1]) @ e[2, 1])


@pytest.mark.parametrize(
    "P", [np.zeros((2, 2)), np.ones((2, 2)), np.diag([1.0, -1.0]), np.diag([1.0, np.nan]), np.array([[1, 2], [2, 1.0]])]
)
def test_md2_of_what_is_no_covariance_is_nan(P):
    assert np.isnan(md2(np.ones(2), P))
    both = md2(np.ones((2, 2)), np.stack([P, np.eye(2)]))
    assert np.isnan(both[0]) and both[1] == 2.0


def test_md2_of_wrong_shapes():
    with pytest.raises(ValueError, match=r"an error of 3 numbers needs a covariance of shape \(3, 3\), got \(2, 2\)"):
        md2(np.ones(3), np.eye(2))


def test_nees_in_the_plane_wraps_the_heading():
    estimate, truth = Frame2([1.0, 2.0, np.pi - 0.01]), Frame2([1.1, 2.0, -np.pi + 0.01])
    assert nees(estimate, np.diag([0.01, 0.04, 0.0004]), truth) == pytest.approx(1 + 1)


def test_nees_of_an_honest_estimate_is_chi_square(rng):
    """2D: 3 degrees of freedom. The mean of 2000 draws, in the 99.9 % band."""
    P = covariance(rng, 3) * 0.01
    e = rng.multivariate_normal(np.zeros(3), P, 2000)
    truth = Frame2(rng.uniform(-3, 3, (2000, 3)))
    values = nees(Frame2(truth.x + e), P, truth)
    low, high = anees_band(3, 2000, 0.999)
    assert low < values.mean() < high


def test_nees_in_space_has_six_degrees_of_freedom_although_the_quaternion_has_four_numbers(rng):
    """Errors drawn in the tangent space; the 7 x 7 covariance is what they become, singular along q."""
    P6 = covariance(rng, 6) * 1e-4
    e = rng.multivariate_normal(np.zeros(6), P6, 2000)
    q = rng.normal(size=4)
    q /= np.linalg.norm(q)
    truth = Frame3(np.concatenate([[1.0, 2, 3], q]))
    dq, Q_v = v2q(e[:, 3:])
    q2, _, Q_dq = q_prod(q, dq)
    estimate = Frame3(np.concatenate([truth.t + e[:, :3], q2], -1))
    T = np.zeros((2000, 7, 6))
    T[:, :3, :3], T[:, 3:, 3:] = np.eye(3), Q_dq @ Q_v
    P7 = T @ P6 @ np.swapaxes(T, 1, 2)
    assert np.linalg.eigvalsh(P7[0])[0] < 1e-12
    values = nees(estimate, P7, truth)
    low, high = anees_band(6, 2000, 0.999)
    assert low < values.mean() < high
    np.testing.assert_allclose(values, md2(e, P6), rtol=1e-3)  # linearised about the estimate: errors of 0.01 rad


def test_nees_of_an_unknown_truth_is_nan():
    assert np.isnan(nees(Frame2(np.zeros(3)), np.eye(3), Frame2(np.full(3, np.nan))))


def test_nis_is_md2_of_the_innovation():
    assert nis([0.3, 0.1], np.diag([0.09, 0.01])) == pytest.approx(2.0)


def test_bands():
    """20 runs of 3 degrees of freedom: 2.02 to 4.16, as in the course."""
    assert anees_band(3, 20) == pytest.approx((2.024, 4.165), abs=1e-3)
    assert chi2_band(3, 0.99) == pytest.approx((0.0717, 12.838), abs=1e-3)
    low, high = chi2_band(6, 0.9)
    assert chi2.cdf(high, 6) - chi2.cdf(low, 6) == pytest.approx(0.9)
    assert chi2.cdf(low, 6) == pytest.approx(0.05)


@pytest.mark.parametrize("confidence", [0.0, 1.0, 95])
def test_bands_of_no_probability(confidence):
    with pytest.raises(ValueError, match="confidence is a probability between 0 and 1, got"):
        chi2_band(2, confidence)


def test_coverage_counts_points_inside_the_ellipse(rng):
    """1-sigma holds 39 % in 2D and 20 % in 3D; Monte Carlo, 20000 points: 4 standard deviations are 0.014."""
    for n in (1, 2, 3):
        points = rng.normal(size=(20000, n))
        for k in (1, 2, 3):
            inside = ((points**2).sum(1) < k * k).mean()
            assert coverage(k, n) == pytest.approx(inside, abs=0.014)
    assert coverage(1, 2) == pytest.approx(0.3935, abs=1e-4)
    assert coverage(k_sigma(0.99, 2), 2) == pytest.approx(0.99)


# --- the honesty meter ---


def runs(rng, factor=1.0, N=100):
    """Errors of N runs and what a filter says about them: covariances `factor` times the right ones."""
    P = covariance(rng, 3) * 0.01
    return rng.multivariate_normal(np.zeros(3), P, N), np.broadcast_to(factor * P, (N, 3, 3))


@pytest.mark.parametrize(
    ("factor", "word"), [(1.0, "as it should be"), (0.25, "over-confident"), (4.0, "too cautious")]
)
def test_the_meter_judges_nees(rng, factor, word):
    e, P = runs(rng, factor)
    meter = honesty(e, P)
    assert meter.verdicts()["nees"] == word
    assert meter.honest == (factor == 1.0)
    assert meter.rmse == pytest.approx(np.sqrt((e[:, :2] ** 2).sum(1).mean()))


def test_the_meter_judges_nis(rng):
    e, P = runs(rng)
    values = chi2.rvs(2, size=400, random_state=1)
    assert honesty(e, P, nis=values).verdicts()["nis"] == "as it should be"
    assert honesty(e, P, nis=3 * values).verdicts()["nis"] == "over-confident"
    assert not honesty(e, P, nis=3 * values).honest
    assert honesty(e, P).verdicts()["nis"] == "not known"


def test_the_meter_sees_a_matrix_that_is_no_covariance(rng):
    e, P = runs(rng)
    skew = np.eye(4)
    skew[0, 1] = 1e-3
    meter = honesty(e, P, map_P=skew)
    assert meter.verdicts()["symmetric"] == "no" and not meter.honest
    meter = honesty(e, P, map_P=np.diag([1.0, 1.0, -1e-6]))
    assert meter.verdicts()["psd"] == "no" and not meter.honest
    assert honesty(e, P, map_P=np.diag([1.0, 0.0])).honest, "a known state is no fault"


def test_the_band_is_wider_for_few_independent_runs(rng):
    e, P = runs(rng)
    one, all_ = honesty(e, P, runs=1), honesty(e, P)
    assert one.nees == all_.nees
    assert one.nees_band[1] > all_.nees_band[1] and one.nees_band[0] < all_.nees_band[0]


def test_the_meter_is_read_aloud(rng):
    e, P = runs(rng, 0.25)
    text = repr(honesty(e, P, nis=[2.0, 2.1]))
    lines = text.splitlines()
    assert [line.split()[0] for line in lines] == ["RMSE", "NEES", "NIS", "P", "P"]
    assert "over-confident" in lines[1] and "as it should be" in lines[2]


def test_a_mean_that_is_not_known(rng):
    meter = honesty(np.zeros((3, 3)), np.zeros((3, 3, 3)))
    assert np.isnan(meter.nees) and meter.verdicts()["nees"] == "not known"


def test_wrong_shapes():
    with pytest.raises(ValueError, match=r"need covariances of shape \(N, n, n\), got \(4, 3\) and \(3, 3\)"):
        honesty(np.zeros((4, 3)), np.eye(3))
