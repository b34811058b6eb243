"""Panels: the numbers that they state, and pictures that are not empty."""

import matplotlib.pyplot as plt
import numpy as np
import pytest
from scipy.stats import chi2

from ekfslam_tutorial.graphics import (
    consistency_panel,
    cost_panel,
    covariance_panel,
    error_panel,
    error_panels,
    film_strip,
    grab,
    map_picture,
)
from ekfslam_tutorial.graphics.artists import Labels


def legend(ax):
    return [t.get_text() for t in ax.get_legend().get_texts()]


def test_error_panel_marks_what_lies_outside_and_counts_it():
    t = np.arange(10.0)
    error = np.zeros(10)
    error[[3, 7]] = [0.31, -0.5]
    error[9] = np.nan
    ax = error_panel(t, error, np.full(10, 0.1), k=3, name="x", unit="m")
    marked = next(line for line in ax.lines if line.get_marker() == "|")
    np.testing.assert_array_equal(marked.get_xdata(), [3, 7])
    assert marked.get_transform() != ax.transData and set(marked.get_ydata()) == {0}  # at the edge, on no curve
    assert "outside: 22.2 %" in legend(ax)  # 2 of the 9 that are known
    assert any("±3σ" in text and "99.7 %" in text for text in legend(ax))
    assert ax.get_ylabel() == "x (m)" and ax.get_xlabel() == "t (s)"


def test_a_moment_without_sight_does_not_press_the_panel_into_a_line():
    t = np.arange(200.0)
    sigma = np.where(t < 4, 10.0, 0.1)
    ax = error_panel(t, 0.1 * np.sin(t), sigma, legend=False)
    assert 0.3 < ax.get_ylim()[1] < 1
    assert any("band up to ±30 m" in text.get_text() for text in ax.texts)
    whole = error_panel(t, 0.1 * np.sin(t), np.linspace(0.1, 0.5, 200), legend=False)
    assert whole.get_ylim()[1] > 1.5 and not any("band up to" in text.get_text() for text in whole.texts)


def test_error_panel_without_outliers_says_nothing_of_them():
    ax = error_panel(np.arange(3.0), np.zeros(3), np.ones(3))
    assert not any("outside" in text for text in legend(ax))


def test_an_error_is_not_joined_across_a_gap_and_a_lonely_one_is_seen():
    """The true pose may be known for a second, then 200 s later once: a line between them would be invented."""
    t = np.array([0.0, 0.1, 0.2, 0.3, 0.4, 200.0])
    ax = error_panel(t, np.arange(6.0), np.ones(6), legend=False)
    curve = next(line for line in ax.lines if line.get_label() == "estimate - truth")
    x, y = (np.asarray(a, float) for a in (curve.get_xdata(), curve.get_ydata()))
    assert np.isnan(y[5]) and 0.4 < x[5] < 200 and y[6] == 5.0
    (dots,) = ax.containers
    assert dots[0].get_xdata().tolist() == [200.0]
    assert ax.get_legend() is None and any("outside: 33.3 %" in text.get_text() for text in ax.texts)  # 4 and 5 of 6


def test_error_panels_share_time_and_name_each():
    axes = error_panels(np.arange(5.0), np.zeros((5, 3)), np.ones((5, 3)), names="xyz", units=["m", "m", "rad"])
    assert [ax.get_ylabel() for ax in axes] == ["x (m)", "y (m)", "z (rad)"]
    assert len({id(ax.figure) for ax in axes}) == 1


@pytest.mark.parametrize("runs", [1, 20])
def test_consistency_panel_holds_an_honest_filter(runs):
    """500 means of chi-square values: the share in the 95 % band has a standard deviation of 1 %."""
    rng = np.random.default_rng(5)
    value = rng.chisquare(3 * runs, 500) / runs
    ax = consistency_panel(np.arange(500.0), value, 3, runs=runs)
    share = next(float(text.split(":")[1].split("%")[0]) for text in legend(ax) if "in the band" in text)
    assert 91 <= share <= 99  # four standard deviations
    vertices = ax.collections[0].get_paths()[0].vertices[:, 1]
    band = chi2.ppf([0.025, 0.975], 3 * runs) / runs
    assert (vertices.min(), vertices.max()) == pytest.approx(tuple(band))


def test_consistency_panel_with_changing_dof_and_gaps():
    dof = np.array([2.0, 4.0, 0.0, 6.0])
    value = np.array([2.0, 50.0, np.nan, 6.0])
    ax = consistency_panel(np.arange(4.0), value, dof, name="NIS")
    above = next(line for line in ax.lines if line.get_label() == "over-confident")
    np.testing.assert_array_equal(above.get_xdata(), [1])
    assert "NIS: 67 % in the band" in legend(ax)


def test_consistency_panel_is_not_joined_across_gaps():
    """100 frames, 50 s of nothing, 100 frames: curve and band have a hole, the numbers stay as they are."""
    t = np.concatenate([0.1 * np.arange(100), 60 + 0.1 * np.arange(100)])
    ax = consistency_panel(t, np.full(200, 2.0), 2.0)
    drawn = next(l for l in ax.lines if "in the band" in str(l.get_label()))
    x, y = (np.asarray(a, float) for a in (drawn.get_xdata(), drawn.get_ydata()))
    assert len(x) == 201 and np.isnan(y[100]) and np.isfinite(np.delete(y, 100)).all() and 10 < x[100] < 60
    assert len(ax.collections[0].get_paths()) == 2
    assert "NEES: 100 % in the band" in legend(ax)


def test_consistency_panel_takes_means_of_different_numbers_of_values():
    runs = np.array([1, 10, 100])
    ax = consistency_panel(np.arange(3.0), np.full(3, 2.0), 2.0, runs=runs)
    path = ax.collections[0].get_paths()[0].vertices
    for t, n in enumerate(runs):
        np.testing.assert_allclose(path[path[:, 0] == t, 1].max(), chi2.ppf(0.975, 2 * n) / n)
    assert "mean of" not in ax.get_ylabel()


def test_cost_panel_shows_times_and_the_size_of_the_map():
    ax = cost_panel(np.arange(300.0), np.full(300, 2e-3), np.arange(300))
    dots = next(l for l in ax.lines if "each frame" in str(l.get_label()))
    np.testing.assert_allclose(np.asarray(dots.get_ydata(), float), 2.0)
    assert "0.6 s in all" in legend(ax)[0] and ax.get_ylabel() == "time of a frame (ms)"
    (right,) = [a for a in ax.figure.axes if a is not ax]
    assert right.get_ylabel() == "landmarks (-)" and right.lines[0].get_ydata()[-1] == 299


def test_covariance_panel_normalises_divides_and_names():
    P = np.diag([4.0, 4.0, 0.01, 1.0, 1.0])
    P[0, 3] = P[3, 0] = -1.0
    ax = covariance_panel(P, {"rob": slice(0, 3), "L7": 2})
    A = np.asarray(ax.images[0].get_array())
    assert A[0, 3] == pytest.approx(-0.5) and np.diag(A) == pytest.approx(np.ones(5))
    assert ax.images[0].get_clim() == (-1, 1)
    assert [t.get_text() for t in ax.get_yticklabels()] == ["rob", "L7"]
    assert [line.get_ydata()[0] for line in ax.lines[::2]] == [2.5]

    raw = covariance_panel(P, {"L7": slice(3, 5), "rob": slice(0, 2)}, correlation=False)
    A = raw.images[0].get_array()
    assert A.shape == (4, 4) and A[0, 2] == -1.0
    low, high = raw.images[0].get_clim()
    assert low == -high == -4.0


def test_covariance_panel_of_a_known_state_and_of_many_blocks():
    P = np.zeros((60, 60))
    P[3:, 3:] = np.eye(57)
    ax = covariance_panel(P, {f"L{i}": 3 for i in range(20)})
    assert np.isfinite(ax.images[0].get_array()).all()
    assert 0 < sum(bool(t.get_text()) for t in ax.get_yticklabels()) <= 16


def test_film_strip_lays_out_rows():
    images = [np.full((30, 40, 3), v, dtype=np.uint8) for v in (0, 60, 120, 180, 240)]
    fig = film_strip(images, ["a", "b", "c", "d", "e"], columns=3)
    assert len(fig.axes) == 6 and [len(ax.images) for ax in fig.axes] == [1, 1, 1, 1, 1, 0]
    assert [ax.get_title() for ax in fig.axes[:5]] == list("abcde")
    with pytest.raises(ValueError, match="at least one image"):
        film_strip([])


def circle(n=50, d=2):
    a = np.linspace(0, 5, n)
    return np.stack([5 * np.cos(a), 5 * np.sin(a), 0.2 * a], axis=1)[:, :d]


@pytest.mark.parametrize("d", [2, 3])
def test_map_picture_states_its_numbers(d):
    truth = circle(d=d)
    path = truth + np.array([0.3, -0.4, 0.0])[:d]
    true_points = np.random.default_rng(0).uniform(-4, 4, (6, d))
    mean = true_points[[0, 2, 5]].copy()
    mean[1, 0] += 0.25
    cov = np.broadcast_to(np.diag([0.04, 0.01, 0.01][:d]), (3, d, d))
    ax, caption = map_picture(
        path, mean, cov, [1, 3, 6], true_path=truth, true_points=true_points, true_ids=[1, 2, 3, 4, 5, 6], title="test"
    )
    assert caption == (
        "3 landmarks mapped, median 3σ radius 0.6 m, largest landmark error 0.25 m, position RMSE 0.5 m."
    )
    image = grab(ax.figure)
    assert (image < 250).any(axis=2).mean() > 0.01
    texts = [t.get_text() for t in ax.figure.legends[0].get_texts()]
    assert {"estimated path", "true path", "true landmark", "estimated landmark"} <= set(texts)
    assert any("3σ" in text for text in texts)


def test_map_picture_of_two_robots_without_truth():
    paths = {"ann": circle(), "bob": 0.5 * circle()}
    ax, caption = map_picture(paths, np.zeros((0, 2)), np.zeros((0, 2, 2)))
    assert caption == "0 landmarks mapped."
    assert grab(ax.figure).std() > 0


def test_map_picture_with_gaps_in_the_truth_and_only_some_truths():
    truth = circle()
    truth[10:20] = np.nan
    _, caption = map_picture(
        {"ann": circle(), "bob": circle()}, np.zeros((1, 2)), np.zeros((1, 2, 2)), [4], true_path={"ann": truth}
    )
    assert "RMSE of ann 0 m" in caption and "bob" not in caption


def test_map_picture_is_not_stretched_by_a_landmark_at_the_horizon():
    mean, cov = np.array([[0.0, 1.0], [900.0, 0.0]]), np.array([0.01 * np.eye(2), 1e6 * np.eye(2)])
    ax, _ = map_picture(circle(), mean, cov)
    assert max(ax.get_xlim()) < 20


def test_map_picture_has_room_for_whole_ellipses():
    """A landmark at the edge of the world, of which the filter knows little."""
    ax, _ = map_picture(circle(), np.array([[-5.0, 0.0]]), np.diag([1.0, 0.01])[None])
    (drawn,) = (line for line in ax.lines if "3σ" in str(line.get_label()))
    x, y = drawn.get_data()
    assert min(ax.get_xlim()) < np.nanmin(x) == pytest.approx(-8, abs=0.01)
    assert np.isfinite(x).sum() == np.isfinite(y).sum() == 60  # one closed curve: nothing is cut


@pytest.mark.parametrize(("d", "most"), [(2, 100), (3, 40)])
def test_map_picture_names_no_crowd(d, most):
    for n in most, most + 1:
        mean = np.random.default_rng(0).uniform(-4, 4, (n, d))
        ax, _ = map_picture(circle(d=d), mean, np.broadcast_to(0.01 * np.eye(d), (n, d, d)))
        (labels,) = (artist for artist in ax.collections if isinstance(artist, Labels))
        shown = range(int(0.95 * n), n + 1) if n == most else [0]  # in the plane: but for those that find no room
        assert len(labels.where) in shown


def test_labels_apart_hide_neither_each_other_nor_a_point():
    """Sixty points and forty stars in a corner: the first has its label, others where there is room; no boxes meet."""
    fig, ax = plt.subplots(figsize=(6, 6))
    ax.set(xlim=(0, 1), ylim=(0, 1))
    rng = np.random.default_rng(1)
    where, stars = dict(enumerate(rng.uniform(0, 0.4, (60, 2)))), rng.uniform(0, 0.4, (40, 2))
    labels = Labels(ax, size=11, apart=True, marks=stars)
    labels.put(where)
    assert 0 in labels.where and 10 < len(labels.where) < 60
    fig.canvas.draw()
    boxes = []
    for path, p in zip(labels.get_paths(), ax.transData.transform(labels.get_offsets()), strict=True):
        box = path.get_extents(labels.get_transform())
        boxes.append((box.x0 + p[0], box.y0 + p[1], box.x1 + p[0], box.y1 + p[1]))
    for i, a in enumerate(boxes):
        assert not any(a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3] for b in boxes[:i])
        marks = ax.transData.transform([*where.values(), *stars])
        assert not any(a[0] < x < a[2] and a[1] < y < a[3] for x, y in marks)


def test_map_picture_draws_into_given_axes():
    _, axes = plt.subplots(1, 2)
    ax, _ = map_picture(circle(), np.zeros((1, 2)), np.eye(2)[None], ax=axes[1])
    assert ax is axes[1] and not axes[0].lines and ax.get_legend() is not None
