"""Ellipses and ellipsoids: every point on the quadric, also for singular covariances and many at once."""

import json

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import pytest
from scipy.stats import chi2

from ekfslam_tutorial.graphics import (
    ESTIMATE,
    OKABE_ITO,
    ellipse_points,
    ellipsoid_wires,
    half_axes,
    nan_separated,
    plot_ellipse,
    points,
    sigma_label,
    style,
)


def random_cov(rng, *shape, d):
    A = rng.normal(size=(*shape, d, d))
    return A @ np.swapaxes(A, -1, -2)


def quadratic_form(p, mean, cov):
    """(p - mean)' inv(cov) (p - mean) for curves p (..., n, d)."""
    v = p - mean[..., None, :]
    return np.einsum("...ni,...ij,...nj->...n", v, np.linalg.inv(cov), v)


@pytest.mark.parametrize("k", [1, 3, 2.5])
def test_ellipse_points_satisfy_the_quadratic_form_over_leading_axes(k):
    rng = np.random.default_rng(1)
    mean, cov = rng.normal(size=(4, 5, 2)), random_cov(rng, 4, 5, d=2)
    p = ellipse_points(mean, cov, k, n=40)
    assert p.shape == (4, 5, 40, 2)
    np.testing.assert_allclose(quadratic_form(p, mean, cov), k * k, rtol=1e-6)  # 1e-16 x condition number 1e8
    np.testing.assert_allclose(p[..., 0, :], p[..., -1, :], atol=1e-12)  # closed


def test_ellipsoid_wires_are_great_circles_in_the_principal_planes():
    rng = np.random.default_rng(2)
    mean, cov = rng.normal(size=(7, 3)), random_cov(rng, 7, d=3) + 0.01 * np.eye(3)
    w = ellipsoid_wires(mean, cov, 3, n=21)
    assert w.shape == (7, 3, 21, 3)
    np.testing.assert_allclose(quadratic_form(w, mean[:, None], cov[:, None]), 9, rtol=1e-6)
    # Curve i lies in the plane of two principal axes: its third principal coordinate is zero.
    V = np.linalg.eigh(cov)[1]
    u = np.einsum("nij,ncpi->ncpj", V, w - mean[:, None, None])
    for curve, axis in [(0, 2), (1, 0), (2, 1)]:
        np.testing.assert_allclose(u[:, curve, :, axis], 0, atol=1e-9)


def test_one_covariance_is_broadcast_over_many_means():
    p = ellipse_points(np.zeros((6, 2)), np.eye(2))
    assert p.shape == (6, 60, 2)


@pytest.mark.parametrize(
    "cov",
    [
        np.zeros((2, 2)),
        np.diag([4.0, 0.0]),
        np.array([[1.0, 2.0], [2.0, 4.0]]),  # rank 1
        np.array([[1.0, 1.0], [1.0, 1.0 - 1e-15]]),  # slightly indefinite by rounding
    ],
)
def test_singular_covariance_is_drawn_as_a_segment_or_a_point(cov):
    p = ellipse_points([1.0, -2.0], cov, 3)
    assert np.isfinite(p).all()
    A = half_axes(cov)
    np.testing.assert_allclose(A @ A.T, cov, atol=1e-14)
    extent = np.abs(p - [1.0, -2.0]).max(axis=0)  # 60 points miss the tip by at most 1 - cos(pi / 59)
    np.testing.assert_allclose(extent, 3 * np.sqrt(np.diag(cov)), rtol=2e-3, atol=1e-7)


def test_singular_ellipsoid():
    w = ellipsoid_wires(np.zeros(3), np.diag([1.0, 0.0, 0.0]))
    assert np.isfinite(w).all() and np.ptp(w[..., 1:]) == 0


def test_not_finite_covariance_is_nan_for_that_one_only():
    cov = np.stack([np.eye(2), np.full((2, 2), np.nan)])
    p = ellipse_points(np.zeros((2, 2)), cov)
    assert np.isfinite(p[0]).all() and np.isnan(p[1]).all()


def test_wrong_shapes_are_named():
    with pytest.raises(ValueError, match=r"\(3,\)"):
        ellipse_points(np.zeros(3), np.eye(3))
    with pytest.raises(ValueError, match=r"\(2, 2\)"):
        ellipsoid_wires(np.zeros(2), np.eye(2))


def test_plot_ellipse_draws_all_as_one_line_without_markers():
    fig, ax = plt.subplots()
    artist = plot_ellipse(ax, np.zeros((3, 2)), np.eye(2), k=2, n=10, **ESTIMATE, label=sigma_label(2))
    x = artist.get_xdata()
    assert len(ax.lines) == 1 and len(x) == 3 * 11 and np.isnan(x).sum() == 3
    assert artist.get_marker() == "None" and artist.get_label() == "2σ ellipse (86.5 %)"
    plt.close(fig)


@pytest.mark.parametrize("dim", [1, 2, 3])
@pytest.mark.parametrize("k", [1, 2, 3])
def test_sigma_label_states_the_probability_inside(k, dim):
    assert f"({100 * chi2(dim).cdf(k**2):.1f} %)" in sigma_label(k, dim)


def test_nan_separated_keeps_every_curve():
    curves = np.arange(24.0).reshape(3, 4, 2)
    joined = nan_separated(curves)
    parts = np.split(joined, np.flatnonzero(np.isnan(joined[:, 0])))
    np.testing.assert_array_equal(np.concatenate([p[np.isfinite(p[:, 0])] for p in parts]), curves.reshape(-1, 2))


ROLES = ["TRUTH", "ESTIMATE", "MEASUREMENT", "REJECTED", "PREDICTED", "UPDATED", "DEAD_RECKONING"]


def test_roles_differ_in_colour_and_in_marker():
    roles = [getattr(style, name) for name in ROLES]
    assert len({r["marker"] for r in roles}) == len({r["color"] for r in roles}) == len(roles)
    assert {r["color"] for r in roles} <= {*OKABE_ITO, style.GREY}


def test_styles_are_accepted_by_plot():
    fig, ax = plt.subplots()
    for name in ROLES:
        role = getattr(style, name)
        ax.plot([0, 1], [0, 1], **role)
        assert ax.plot([0, 1], [0, 1], **style.line(role))[0].get_marker() == "None"
        assert ax.plot([0, 1], [0, 1], **points(role))[0].get_linestyle() == "None"
    plt.close(fig)


def test_use_style_has_no_font_below_12_points():
    with plt.rc_context():
        style.use_style()
        for key in ["font.size", "axes.labelsize", "xtick.labelsize", "ytick.labelsize", "legend.fontsize"]:
            assert plt.rcParams[key] >= 12


def test_ellipses_recorded_from_the_toolbox_lie_on_ours(golden_dir):
    """The toolbox orders its points as its SVD does, so points are compared as members of the same curve."""
    checked = 0
    for record in json.loads((golden_dir / "functions" / "graphics.json").read_text()):
        if record["fn"] not in ("golden_c2e", "golden_c3e") or record.get("degenerate"):
            continue
        mean, cov, k, _ = (np.array(arg["value"], dtype=float) for arg in record["args"])
        p = np.array([out["value"][0] for out in record["outs"]], dtype=float).T
        on_unit_sphere = np.linalg.solve(half_axes(cov), (p - mean[:, 0]).T)
        np.testing.assert_allclose(np.linalg.norm(on_unit_sphere, axis=0), k.item(), rtol=1e-9)
        checked += 1
    assert checked >= 5
