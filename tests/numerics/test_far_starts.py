"""A start that nobody knows beside a map that is known to a centimetre: right, or refused."""

import numpy as np
import pytest

from ekfslam_tutorial.toolbox import Recorder, UserData, universal_slam
from ekfslam_tutorial.toolbox.scenario.agreement import noise_at_one_metre

TABLE = {
    "time": {"dt": 0.5, "last": 100},
    "world": {"type": "lecture"},
    "robot": [{"id": 1, "motion": "unicycle", "position": [0.0, -4.0], "v": 1.0, "w_deg": 14.4, "v_std": 0.1}],
    "sensor": [{"id": 1, "robot": 1, "type": "range_bearing", "range_std": 0.1, "bearing_std_deg": 1.0}],
}
TABLE["robot"][0] |= {"w_std_deg": 2.0, "orientation_std_deg": np.degrees(1e-3)}
TABLE["sensor"][0] |= {"max_range": 5.0}


def scenario(std, **options):
    return UserData.from_dict(TABLE, {"robot.1.position_std": std} | {f"options.{k}": v for k, v in options.items()})


@pytest.fixture(scope="module")
def log():
    recorder = Recorder()
    for s in universal_slam(scenario(0.0)):
        recorder.add(s)
    played = recorder.recording("from a start that is known")
    played.truth = {}
    return played


def distances(std, log, **options):
    """Distances between all landmarks, and their sigmas. Where the map lies in the world does not enter."""
    *_, s = universal_slam(scenario(std, **options), log)
    lmks = [s.lmks[id] for id in sorted(s.lmks)]
    i, j = np.triu_indices(len(lmks), 1)
    p = np.array([lmk.state(s.map) for lmk in lmks])
    d = np.linalg.norm(p[i] - p[j], axis=-1)
    P, r = s.map.P, [lmk.r for lmk in lmks]
    S = np.array([P[r[a], r[a]] + P[r[b], r[b]] - P[r[a], r[b]] - P[r[b], r[a]] for a, b in zip(i, j, strict=True)])
    u = (p[i] - p[j]) / d[:, None]
    return d, np.sqrt(np.einsum("ki,kij,kj->k", u, S, u))


@pytest.mark.parametrize(
    "options", [{"engine": "plain"}, {"engine": "fast"}, {"engine": "fast", "joint": True}], ids=str
)
def test_the_map_is_that_of_a_known_start(options, log):
    """As far from knowing as is allowed: 8.7 km. To a hundredth of a sigma, and of their ratio."""
    near, sigma = distances(0.0, log, **options)
    far, far_sigma = distances(8.7e3, log, **options)
    assert np.abs(far - near).max() < 0.01 * sigma.min() and np.abs(far_sigma / sigma - 1).max() < 0.01


@pytest.mark.parametrize("engine", ["plain", "fast"])
def test_what_a_covariance_has_no_digits_for_is_refused(engine):
    """With 1e5 m, distances were up to 0.7 sigma off, without a word."""
    words = r"robot 1: position_std = 100000 m beside 0.017 m of noise of sensor 1 leaves no digits for the map; "
    with pytest.raises(ValueError, match=words + r"take at most 8.7e\+03 m, or 0: the start is the origin"):
        scenario(1e5, engine=engine)
    known = UserData.from_dict(TABLE, {"robot.1.position_std": 1e5, "landmark.in_map": False})
    assert known.robots[0].position_std == 1e5  # known landmarks say where it is: nothing small beside anything large


def test_the_noise_of_a_sensor_in_metres():
    class Camera:
        R = 4.0 * np.eye(1)

        def project(self, p):
            if p[0] <= 0:
                raise ZeroDivisionError
            return np.array([500 * p[1] / p[0]]), np.array([[-500 * p[1] / p[0] ** 2, 500 / p[0]]])

    assert noise_at_one_metre(Camera(), 2) == pytest.approx(2 / 500)
    Camera.project = lambda self, p: (p, np.full((1, 2), np.nan))
    assert noise_at_one_metre(Camera(), 2) == np.inf
