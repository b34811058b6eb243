"""The loader of Starry Night on a file made here, the twin, and the wrong sign of the angular velocity."""

import numpy as np
import pytest
from scipy.io import savemat

from ekfslam_tutorial import datasets
from ekfslam_tutorial.datasets import starry_night
from ekfslam_tutorial.toolbox import UserData, universal_slam


@pytest.fixture
def stars(tmp_path):
    n, rng = 12, np.random.default_rng(1)
    column = lambda *shape: rng.normal(size=shape)
    pixels = rng.uniform(10, 600, (4, n, 20))
    pixels[:, rng.random((n, 20)) < 0.3] = -1
    a = {"t": 3 + 0.1 * np.arange(n)[None], "theta_vk_i": column(3, n), "r_i_vk_i": column(3, n)}
    a |= {"v_vk_vk_i": column(3, n), "w_vk_vk_i": column(3, n), "y_k_j": pixels, "rho_i_pj_i": column(3, 20)}
    a |= {"v_var": np.full((3, 1), 0.01), "w_var": np.full((3, 1), 0.04), "y_var": np.array([[30.0, 100, 50, 300]]).T}
    savemat(tmp_path / "dataset3.mat", a)
    return tmp_path, a


def test_the_loader(stars):
    folder, a = stars
    rec = starry_night.load(folder)
    assert len(rec) == 12 and rec.t[0] == 0 and "its sign is wrong" in rec.notes[0]
    np.testing.assert_allclose(rec.robots[1].u[0], 0)
    rates = np.concatenate([a["v_vk_vk_i"][:, 4], -a["w_vk_vk_i"][:, 4]])
    np.testing.assert_allclose(rec.robots[1].u[5], 0.1 * rates)
    np.testing.assert_allclose(rec.robots[1].U[5], 0.01 * np.diag([0.01] * 3 + [0.04] * 3))
    np.testing.assert_allclose(rec.truth[1][7, :3], a["r_i_vk_i"][:, 7])
    seen = np.flatnonzero(a["y_k_j"][0, 3] != -1)
    frame = rec.raw[1][3]
    np.testing.assert_array_equal(frame.ids, seen + 1)
    u, v, r, w = a["y_k_j"][:, 3, seen]
    np.testing.assert_allclose(frame.y, np.stack([u, (3 * v + w) / 4, u - r], -1))  # rows of variance 100 and 300
    np.testing.assert_allclose(frame.R[0], [[30, 0, 30], [0, 75, 0], [30, 0, 80]])


def test_a_piece(stars):
    whole, piece = starry_night.load(stars[0]), starry_night.load(stars[0], first=4, last=8)
    assert len(piece) == 5 and piece.t[0] == 0
    np.testing.assert_allclose(piece.truth[1], whole.truth[1][4:9])
    np.testing.assert_allclose(piece.robots[1].u[1:], whole.robots[1].u[5:9])
    with pytest.raises(ValueError, match="it has the frames 0 to 11, asked for are 4 to 12"):
        starry_night.load(stars[0], 4, 12)


def test_damaged_files(stars, tmp_path):
    folder, a = stars
    with pytest.raises(FileNotFoundError, match="Starry Night: no dataset3.*mat in"):
        starry_night.load(tmp_path / "nowhere")
    del a["y_var"]
    savemat(folder / "dataset3.mat", a)
    with pytest.raises(ValueError, match="is not the file of Starry Night: it has no array y_var"):
        starry_night.load(folder)
    savemat(folder / "dataset3.mat", a | {"y_var": [[1.0]] * 4, "v_vk_vk_i": np.zeros((3, 5))})
    with pytest.raises(ValueError, match=r"v_vk_vk_i has shape \(3, 5\), wanted is \(3, 12\)"):
        starry_night.load(folder)


def run(n=250, **overrides):
    """Position error and its squared Mahalanobis distance over a run of the twin."""
    data = UserData.from_toml("data/scenarios/starry_night.toml", overrides)
    data, recording = datasets.prepare(data)
    errors, nees = [], []
    for now in universal_slam(data, recording):
        r = now.robs[0].r
        e = now.map.x[r][:3] - now.truth[1][:3]
        P = now.map.P[r, r][:3, :3]
        errors.append(e @ e)
        if now.k > data.time.first:
            nees.append(e @ np.linalg.solve(P, e))
        if now.k == n:
            return np.sqrt(np.mean(errors)), np.mean(nees)
    raise AssertionError("the run is too short")


def test_the_twin_runs_and_says_what_it_is(monkeypatch):
    """0.05 m: a sighting at 2.5 m has a depth noise of 0.5 m, some 15 points are seen 250 times."""
    monkeypatch.delenv("EKFSLAM_DATA", raising=False)
    data, recording = datasets.prepare(UserData.from_toml("data/scenarios/starry_night.toml"))
    assert "the simulated twin runs instead" in recording.notes[0] and len(recording) == 950
    error, nees = run()
    assert error < 0.05 and nees < 9
