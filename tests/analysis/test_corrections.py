"""The correction ratio on filters whose honesty is known: 60 runs of 15 minutes at once, three states, no landmark."""

import numpy as np
import pytest

from ekfslam_tutorial.analysis import History, md2
from ekfslam_tutorial.analysis.corrections import (
    LENGTHS,
    SecondSums,
    along_the_robot,
    block_sums,
    correction_ratio,
    corrections,
    squared_sums,
)
from ekfslam_tutorial.geometry import Frame2, Frame3
from ekfslam_tutorial.toolbox import UserData, universal_slam

RUNS, SECONDS = 60, 900
U, R = np.diag([0.02, 0.02, 0.01]) ** 2, np.diag([0.3, 0.1]) ** 2


def filters(factor=1.0, lasting=0.0, seed=1):
    """Filters of a walking state, measured once a second by two of its numbers in turn.

    Parameters
    ----------
    factor : float
        The noise, U and R, is so many times what the filters are told.
    lasting : float
        Errors of the measurements die away with this time constant, s; 0: they are white.

    Returns
    -------
    t : (K,); a : (RUNS, K, 3); A : (K, 3, 3); nees : float, the mean of the second half
    """
    rng = np.random.default_rng(seed)
    x, m, P = np.zeros((RUNS, 3)), np.zeros((RUNS, 3)), np.diag([0.1, 0.1, 0.05]) ** 2
    rho, v = np.exp(-1 / lasting) if lasting else 0.0, np.zeros((RUNS, 2))
    a, A, nees = [], [], []
    for k in range(SECONDS):
        x = x + np.sqrt(factor) * rng.standard_normal(x.shape) @ np.sqrt(U)
        P = P + U
        v = rho * v + np.sqrt(1 - rho**2) * rng.standard_normal(v.shape)
        H = np.roll(np.eye(3), k, axis=1)[:2]
        z = (x - m) @ H.T + np.sqrt(factor) * v @ np.sqrt(R)
        K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
        a.append(z @ K.T)
        A.append(K @ H @ P)
        m, P = m + a[-1], P - A[-1]
        nees.append(md2(m - x, P).mean() / 3)
    return np.arange(SECONDS) + 0.5, np.stack(a, 1), np.array(A), float(np.mean(nees[SECONDS // 2 :]))


def ratios(t, a, A):
    return np.array([correction_ratio([(t, each, A)]).value for each in a])


def test_of_white_noise_the_median_is_at_most_1_2():
    t, a, A, nees = filters()
    found = [correction_ratio([(t, each, A)]) for each in a]
    c = np.array([max(1.0, f.value) for f in found])
    assert nees == pytest.approx(1, abs=0.1)
    assert 1.0 <= np.median(c) <= 1.2
    assert np.quantile(c, 0.95) < 1.8  # 1.71 was measured on logs of this length
    assert not any(f.too_large for f in found)  # 1 in 10,000 would be, by chance


@pytest.mark.parametrize("factor", [3.0, 9.0])
def test_noise_told_too_small_is_found(factor):
    t, a, A, nees = filters(factor)
    c = ratios(t, a, A)
    assert nees == pytest.approx(factor, rel=0.15)
    assert 0.9 < np.median(c) / factor < 1.3  # the largest of six figures: above rather than below
    assert sum(correction_ratio([(t, each, A)]).too_large for each in a) >= RUNS - 1


def test_noise_told_too_large_has_a_small_ratio_and_no_factor_below_one():
    t, a, A, _ = filters(0.25)
    found = [correction_ratio([(t, each, A)]) for each in a]
    assert 0.2 < np.median([f.value for f in found]) < 0.35
    assert {f.factor for f in found} == {1.0}


@pytest.mark.parametrize("lasting", [2.0, 8.0])
def test_errors_that_last_are_found(lasting):
    """The factor that is needed is the NEES; c is within a third of it in the median."""
    t, a, A, nees = filters(lasting=lasting)
    assert nees > 1.15
    assert 0.67 < np.median(ratios(t, a, A)) / nees < 1.5


def test_robots_together_are_one_longer_log():
    t, a, A, _ = filters(3.0)
    one, five = correction_ratio([(t, a[0], A)]), correction_ratio([(t, each, A) for each in a[:5]])
    assert five.by_length[1][1] == 5 * one.by_length[1][1] and five.limit < one.limit


def test_a_short_run_says_nothing():
    t, a, A, _ = filters()
    short = correction_ratio([(t[:3], a[0, :3], A[:3])])
    assert np.isnan(short.value) and short.factor == 1.0 and not short.too_large and short.by_length == {}
    assert correction_ratio([]).by_length == {}


def test_blocks_without_a_direction_count_fewer_degrees_of_freedom():
    g, V = (
        np.array([[1.0, 0.0], [1.0, 2.0], [3.0, 1.0]]),
        np.array([np.diag([4.0, 1.0]), np.ones((2, 2)), np.zeros((2, 2))]),
    )
    total, dof = squared_sums(g, V)
    assert dof == 3  # two of the first block, one of the second, whose numbers go together, none of the third
    assert total == pytest.approx(1 / 4 + 1.5**2)


@pytest.mark.parametrize("frame", [Frame2, Frame3])
def test_along_the_robot_nothing_changes_for_a_single_correction(frame):
    """It is the same correction, seen from another side: its size is the same, and its angles are."""
    rng = np.random.default_rng(6)
    F = frame(frame(rng.standard_normal((4, frame.size))).normalized()[0].x)
    a, B = rng.standard_normal((4, frame.dof)), rng.standard_normal((4, frame.dof, frame.dof))
    A = B @ np.swapaxes(B, 1, 2)
    seen, V = along_the_robot(F, a, A)
    np.testing.assert_allclose(seen[:, F.dim :], a[:, F.dim :])
    np.testing.assert_allclose(seen[:, : F.dim], [one.T @ p for one, p in zip(F.R, a[:, : F.dim], strict=True)])
    np.testing.assert_allclose(md2(seen, V), md2(a, A))


def test_what_turns_with_the_robot_is_seen_along_its_axes_only():
    """A robot drives rounds of 20 s, and each correction draws it ahead: along the map they cancel each other."""
    rng = np.random.default_rng(7)
    ratio = {}
    for along_robot in (False, True):
        sums = SecondSums(Frame2, along_robot=along_robot)
        for k in range(600):
            heading = 2 * np.pi * k / 20
            ahead = np.array([np.cos(heading), np.sin(heading), 0.0])
            x0 = np.array([0.0, 0.0, heading])
            error = 0.1 * rng.standard_normal(3)
            sums.add(k + 0.5, x0, 0.02 * np.eye(3), x0 + error + 0.05 * ahead, 0.01 * np.eye(3))
        ratio[along_robot] = correction_ratio([sums.arrays])
    assert all(ratio[False].by_length[T][0] < 1.6 for T in (60, 120))
    assert ratio[True].too_large and ratio[True].value > 3 and all(ratio[True].by_length[T][0] > 2.5 for T in (60, 120))


def test_of_honest_runs_hardly_one_in_forty_is_sure():
    """The largest of six lengths is asked, and they share the chance of 2.5 %: at most 15 of 300, a 99 % band.

    With that chance for each length 16 were. Each of 60 whose noise is too small is sure.
    """
    ratio_of = lambda t, a, A: [correction_ratio([(t, each, A)]) for each in a]
    honest = [ratio for seed in range(1, 6) for ratio in ratio_of(*filters(seed=seed)[:3])]
    assert len(honest) == 300 and sum(ratio.sure for ratio in honest) <= 15
    assert all(ratio.sure for ratio in ratio_of(*filters(3.0)[:3]))
    assert not correction_ratio([]).sure


def test_sums_over_blocks():
    t, g, V = block_sums(np.array([0.1, 2.9, 3.0, 9.5]), np.array([[1.0], [2.0], [4.0], [8.0]]), np.ones((4, 1, 1)), 3)
    assert t.tolist() == [0, 3, 9] and g.ravel().tolist() == [3, 4, 8] and V.ravel().tolist() == [2, 1, 1]
    assert (
        all(long % short == 0 for short, long in zip((1, 1, 1, 30), (3, 10, 60, 120), strict=True)) and LENGTHS[0] == 1
    )


def test_what_is_summed_on_the_way_is_the_sum():
    rng = np.random.default_rng(3)
    sums, rows = SecondSums(Frame2), []
    for k in range(700):
        x0, x1 = rng.standard_normal((2, 3))
        rows.append((0.01 * k + 5, x0, np.eye(3), x1, 0.5 * np.eye(3)))
        sums.add(*rows[-1])
        if k == 300:
            sums = SecondSums(Frame2, sums.rows)  # as a checkpoint does it
    t, *poses = (np.array(column) for column in zip(*rows, strict=True))
    a, A = corrections(Frame2, *poses)
    for mine, plain in zip(sums.arrays, block_sums(t, a, A, 1), strict=True):
        np.testing.assert_allclose(mine, plain, atol=1e-12)


def test_in_space_a_correction_has_six_numbers():
    """P0 - P1 is K S K' of the state with its quaternion; seen in the tangent space."""
    rng = np.random.default_rng(4)
    F = Frame3(np.r_[1.0, 2, 3, 1, 0, 0, 0])
    _, E = F.minus(F)
    J = np.linalg.pinv(E)
    P, S = np.eye(6), np.diag(rng.uniform(0.1, 0.5, 6))
    v = 1e-6 * rng.standard_normal(6)
    a, A = corrections(Frame3, F.x[None], (J @ P @ J.T)[None], (F.x + J @ v)[None], (J @ (P - S) @ J.T)[None])
    np.testing.assert_allclose(A[0], S, atol=1e-12)
    np.testing.assert_allclose(a[0], v, atol=1e-10)


@pytest.mark.parametrize("frame", [Frame2, Frame3])
def test_a_covariance_that_was_turned_with_the_world_is_turned_back(frame):
    """T as it is derived: what a small turn of the world does to the state, before and after; differences by hand."""
    rng = np.random.default_rng(5)
    n, dof = frame.size, frame.dof
    F0 = frame(rng.standard_normal(n)).normalized()[0]
    F1 = frame(F0.x + 0.3 * rng.standard_normal(n)).normalized()[0]

    def turn_of_the_world(F):
        k, h = dof - F.dim, 1e-6
        steps = np.eye(k) * h
        if k == 1:
            turned = [Frame2([0, 0, s[0]]).compose(F)[0].x for s in steps]
        else:
            turned = [Frame3(np.r_[0, 0, 0, 1, s / 2]).normalized()[0].compose(F)[0].x for s in steps]
        return np.array([(x - F.x) / h for x in turned]).T

    B0, B1 = turn_of_the_world(F0), turn_of_the_world(F1)
    T = np.eye(n) + (B1 - B0) @ np.linalg.pinv(np.where(np.arange(n)[:, None] < F0.dim, 0, B0))
    E0 = F0.minus(F0)[1]
    J = np.linalg.pinv(E0)
    P, S = np.diag(rng.uniform(1, 2, dof)), np.diag(rng.uniform(0.1, 0.5, dof))
    P1 = T @ J @ (P - S) @ J.T @ T.T
    _, A = corrections(frame, F0.x[None], (J @ P @ J.T)[None], F1.x[None], P1[None], np.array([True]))
    np.testing.assert_allclose(A[0], S, atol=1e-5)
    _, wrong = corrections(frame, F0.x[None], (J @ P @ J.T)[None], F1.x[None], P1[None], np.array([False]))
    assert abs(wrong[0] - S).max() > 0.01


# --- in a run ---


def run(seed=1, **overrides):
    data = UserData.from_toml(
        "data/scenarios/range_bearing_2d.toml", {k.replace("__", "."): v for k, v in overrides.items()}
    )
    history = History()
    for s in universal_slam(data, seed=seed):
        history.add(s)
    return history


@pytest.fixture(autouse=True)
def at_the_root(monkeypatch, request):
    monkeypatch.chdir(request.config.rootpath)


def test_both_engines_have_the_same_ratio():
    plain, fast = (run(time__last=40, options__engine=e).correction_ratio() for e in ("plain", "fast"))
    assert plain.by_length and plain.value == pytest.approx(fast.value, rel=1e-6)


def test_an_honest_run_is_not_warned_of_and_noise_told_too_small_is():
    honest = [run(seed).correction_ratio() for seed in (1, 2)]
    assert not any(r.too_large for r in honest)
    small = [run(seed, sensor__noise_factor=0.2, robot__noise_factor=0.2).correction_ratio() for seed in (1, 2)]
    assert all(r.too_large and 2.5 < r.value < 12 for r in small)  # 5 is right


def test_a_robot_whose_pose_is_known_has_none():
    figures = run(robot__in_map=False, time__last=10).summary()
    assert figures["correction_ratio"] is None and figures["correction_ratio_limit"] is None
