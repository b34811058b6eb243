"""Images as measurements: a known patch is found where it is, warped as it should look, and counted once."""

import json

import numpy as np
import pytest

from ekfslam_tutorial import datasets
from ekfslam_tutorial.cli import main
from ekfslam_tutorial.cli.files import find_scenario
from ekfslam_tutorial.datasets import monoslam_desk
from ekfslam_tutorial.geometry import Frame3, e2q
from ekfslam_tutorial.models.sensors import DavisonCam
from ekfslam_tutorial.simulation.textured import Room
from ekfslam_tutorial.toolbox import Data, UserData, universal_slam
from ekfslam_tutorial.toolbox.images import ActiveSearch, Pictures, extra, frames
from ekfslam_tutorial.toolbox.images.appearance import affine_maps, look_at, warped
from ekfslam_tutorial.toolbox.images.matching import find_patch
from ekfslam_tutorial.toolbox.images.target import Target

CAMERA = DavisonCam(margin=8.0)
FRAMES = 30


def needs_opencv(test):
    """Mark a test that needs the extra `images`."""
    return pytest.mark.skipif(extra.find_spec("cv2") is None, reason="OpenCV, the extra images, is not installed")(test)


@pytest.fixture(scope="module")
def room():
    """Room of the twin, and the true corners of its rectangle."""
    boards, corners = monoslam_desk.office(np.random.default_rng(1))
    return Room(boards, CAMERA), corners


@pytest.fixture(scope="module")
def twin():
    """A second of images of the twin."""
    return monoslam_desk.twin(n=FRAMES)


def pose(*angles, t=(0.0, 0.0, 0.0)):
    return Frame3(np.concatenate([t, e2q(np.array(angles))[0]]))


# --- without OpenCV ---


def test_without_opencv_one_sentence_says_what_to_do(monkeypatch, capsys, tmp_path):
    monkeypatch.setattr(extra, "find_spec", lambda name: None)
    extra.opencv.cache_clear()
    assert main(["run", "monoslam_desk", "--out", str(tmp_path)]) == 2
    said = capsys.readouterr().err
    assert "images need OpenCV: pip install 'ekfslam_tutorial[images]'" in said and "Traceback" not in said
    extra.opencv.cache_clear()


def test_a_rendered_point_has_the_grey_of_its_texture(room):
    """What a pixel shows is the texture where its ray meets the nearest board."""
    camera, (room, corners) = pose(0.05, -0.1, 0.03, t=(0.05, 0.02, 0.0)), room
    image = room.image(camera)
    middle = CAMERA.project((corners.mean(0) - camera.t) @ camera.R)[0]
    beside = CAMERA.project((corners[0] - [0.012, 0.012, 0.0] - camera.t) @ camera.R)[0]
    grey = lambda p: image[round(p[1]), round(p[0])]
    assert grey(middle) < 25 and grey(beside) > 200


@pytest.mark.parametrize(
    ("wrong", "said"), [({"score": 1.0}, "between -1 and 1"), ({"most": 0}, "positive"), ({"births": -1}, "0 or more")]
)
def test_wrong_parameters_are_refused(wrong, said):
    with pytest.raises(ValueError, match=said):
        ActiveSearch(**wrong)


# --- one patch ---


@needs_opencv
@pytest.mark.parametrize("shift", [(0.0, 0.0), (3.0, -2.0), (1.5, 2.25)], ids=str)
def test_a_known_patch_is_found_where_it_is(shift):
    """To a quarter of a pixel, with half the contrast and another brightness."""
    v, u = np.mgrid[:100, :120].astype(float)
    grey = lambda du, dv: 120 + 50 * np.sin((u - du) / 3.1) * np.cos((v - dv) / 2.7) + 20 * np.sin((u - du) / 11)
    at = np.array([60.0, 50.0])
    patch = np.rint(grey(0, 0)).astype(np.uint8)[43:58, 53:68]
    y, score = find_patch(np.rint(0.5 * grey(*shift) + 30).astype(np.uint8), patch, at, 4.0 * np.eye(2))
    np.testing.assert_allclose(y, at + shift, atol=0.25)
    assert score > 0.95


@needs_opencv
def test_it_is_not_looked_for_outside_its_ellipse():
    image = np.zeros((100, 120), np.uint8)
    image[40:60, 80:90] = 200
    y, score = find_patch(image, image[33:48, 73:88], np.array([60.0, 40.0]), np.diag([4.0, 4.0]))
    assert score < 0.9
    y, score = find_patch(image, image[33:48, 73:88], np.array([60.0, 40.0]), np.diag([64.0, 4.0]))
    assert score == pytest.approx(1.0, abs=1e-5) and np.allclose(y, [80, 40], atol=0.5)


@needs_opencv
def test_warped_patches_look_like_the_image(room):
    """Turned by 40 degrees and 10 cm aside: the warped patch correlates well, the patch as it was less."""
    (room, corners), first = room, pose(0.0, 0.0, 0.0)
    second = pose(0.0, 0.12, np.deg2rad(40), t=(0.1, 0.02, 0.08))
    images = [room.image(camera) for camera in (first, second)]
    see = lambda camera: CAMERA.project((corners - camera.t) @ camera.R)[0]
    looks = [look_at(images[0], y, first) for y in see(first)]
    maps, better = affine_maps(CAMERA, looks, corners, second), []
    for look, A, y in zip(looks, maps, see(second), strict=True):
        found, score = find_patch(images[1], warped(look, A), y, np.eye(2))
        _, still = find_patch(images[1], look["patch"][14:29, 14:29], y, np.eye(2))
        np.testing.assert_allclose(found, y, atol=1.0)
        better.append(score - still)
        assert score > 0.95
    assert np.mean(better) > 0.05
    # the affine map is what finite differences of the exact way of a point on the plane give: at birth, nothing changes
    np.testing.assert_allclose(affine_maps(CAMERA, looks, corners, first), np.tile(np.eye(2), (4, 1, 1)), atol=1e-9)


@needs_opencv
def test_the_target_is_found_with_an_honest_covariance(room):
    """Its twelve coordinates: the squared Mahalanobis distance is below 33, 99.9 % of twelve."""
    (room, corners), camera = room, pose(0.03, -0.1, 0.02, t=(0.03, -0.02, -0.05))
    given = Target(*monoslam_desk.TARGET).find(room.image(camera), CAMERA)
    e = (given.points - (corners - camera.t) @ camera.R).ravel()
    assert e @ np.linalg.solve(given.P, e) < 33
    np.testing.assert_allclose(given.pixels, CAMERA.project((corners - camera.t) @ camera.R)[0], atol=1.0)


# --- a run ---


def scenario(engine="fast"):
    return UserData.from_toml(find_scenario("monoslam_desk"), {"options.engine": engine})


def run(twin, engine="fast", last=FRAMES):
    log = Pictures("twin", frames.Images(twin.frames[:last]), twin.target, 20, {1: twin.truth[1][:last]})
    log.corners = twin.corners
    return universal_slam(scenario(engine), log)


@pytest.fixture(scope="module")
def seen(twin):
    """What a run has done, frame by frame: counts before and after, events, positions."""
    rows = []
    for s in run(twin):
        counts = {i: (lmk.n_search, lmk.n_match, lmk.n_inlier) for i, lmk in s.lmks.items()}
        used = {o.lmk for o in s.obs.values() if o.updated}
        there = {o.lmk for o in s.obs.values() if o.visible}
        rows.append((counts, list(s.events), used, there, s.robs[0].frame(s.map).t - s.truth[1][:3], s.raw[1]))
        given = [lmk.id for lmk in s.lmks.values() if lmk.appearance["given"]]
        assert given == ([1, 2, 3, 4] if s.k <= 20 else [])  # they are forgotten then
        assert all(lmk.appearance["patch"].shape == (43, 43) for lmk in s.lmks.values())
    return rows


@needs_opencv
def test_the_twin_is_followed(seen):
    """Within 2 cm over a second, with 20 landmarks or more in each frame."""
    assert max(np.linalg.norm(row[4]) for row in seen) < 0.02
    assert min(len(row[2]) for row in seen[1:]) >= 20


@needs_opencv
def test_each_landmark_counts_once_a_frame(seen):
    for (before, *_), (after, events, used, there, _, raw) in zip(seen, seen[1:], strict=False):
        found = set(raw.app) & {i for i, app in raw.app.items() if app.y is not None}
        for i in set(before) & set(after):
            step = tuple(np.subtract(after[i], before[i]))
            assert step == (int(i in there), int(i in found), int(i in used))
        searched = [e.lmk for e in events if e.kind == "search"]
        assert sorted(searched) == sorted(there) and used <= found <= there
        assert all(app.curr is None or app.curr.shape == app.pred.shape for app in raw.app.values())


@needs_opencv
def test_fast_is_plain(twin):
    """The same landmarks, and poses to rounding, by both engines."""
    for plain, quick in zip(run(twin, "plain", 12), run(twin, "fast", 12), strict=True):
        assert plain.events == quick.events
        np.testing.assert_allclose(plain.robs[0].state(plain.map), quick.robs[0].state(quick.map), atol=1e-8)


@needs_opencv
def test_a_wrong_match_is_refused_and_counted(twin):
    """An image in which something has moved: what moved is found, refused, and corrects nothing."""
    images = list(twin.frames[:12])
    for s in universal_slam(scenario(), Pictures("still", frames.Images(images), twin.target)):
        last = {o.lmk: np.array(o.e) for o in s.obs.values() if o.updated}
    images.append(images[-1].copy())
    id, (u, v) = next((i, e) for i, e in last.items() if (e > 40).all() and e[0] < 280 and e[1] < 200)
    u, v = round(float(u)), round(float(v))
    images[-1][v - 12 : v + 13, u - 12 : u + 13] = images[-2][v - 12 : v + 13, u - 16 : u + 9]  # 4 pixels to the right
    *_, s = universal_slam(scenario(), Pictures("moved", frames.Images(images), twin.target))
    o = s.obs[1, id]
    assert o.matched and not o.updated and not next(e.flag for e in s.events if e.kind == "innovation" and e.lmk == id)
    assert sum(o.updated for o in s.obs.values()) > 15


# --- where images come from ---


@needs_opencv
def test_folders_videos_and_pieces(twin, tmp_path):
    cv2 = extra.opencv()
    (tmp_path / "monoslam_desk" / "frames").mkdir(parents=True)
    for i in range(8):
        cv2.imwrite(str(tmp_path / "monoslam_desk" / "frames" / f"{i:04d}.png"), twin.frames[i])
    log = monoslam_desk.load(tmp_path / "monoslam_desk", first=2, last=6, step=2)
    assert log.frames.numbers == [2, 4, 6] and np.allclose(log.t, [0, 2 / 30, 4 / 30])
    np.testing.assert_array_equal(log.frames[1], twin.frames[4])
    with pytest.raises(ValueError, match="it has the images 0 to 7, asked for are 0 to 9"):
        monoslam_desk.load(tmp_path / "monoslam_desk", last=9)
    with pytest.raises(FileNotFoundError, match="no images"):
        monoslam_desk.load(tmp_path / "nowhere")
    film = cv2.VideoWriter(str(tmp_path / "a.avi"), cv2.VideoWriter_fourcc(*"MJPG"), 30, (320, 240))
    for i in range(5):
        film.write(cv2.cvtColor(twin.frames[i], cv2.COLOR_GRAY2BGR))
    film.release()
    log = datasets.load_recording(Data(name="monoslam_desk", params={"path": str(tmp_path / "a.avi")}))
    assert len(log) == 5 and "a guess" in log.notes[0]
    assert np.abs(log.frames[3].astype(float) - twin.frames[3]).mean() < 8


@needs_opencv
def test_without_a_camera_there_is_one_sentence_and_nothing_else(tmp_path, capfd):
    assert main(["run", "monoslam", "--camera", "97", "--out", str(tmp_path / "out")]) == 2
    (line,) = capfd.readouterr().err.splitlines()  # the drivers' own words are not among it
    assert "there is no camera 97 here" in line and line.endswith("--camera FILE")


@needs_opencv
def test_the_command_runs_the_twin_and_says_so(tmp_path, monkeypatch, capsys):
    monkeypatch.delenv("EKFSLAM_DATA", raising=False)
    assert main(["run", "monoslam_desk", "--out", str(tmp_path), "--set", "data.last=14"]) == 0
    assert "the simulated twin runs instead" in capsys.readouterr().err
    figures = json.loads((tmp_path / "result.json").read_text())
    wanted = "ate_aligned_m", "rotation_rmse_deg", "nees_per_dof", "landmark_rmse_aligned_m", "frames_per_s"
    assert figures["frames"] == 15 and all(figures[name] is not None for name in wanted)
    assert figures["ate_aligned_m"] < 0.01 and figures["landmark_rmse_aligned_m"] < 0.05
    assert {"map.png", "sensor-1.png", "view.html", "trajectory-1.tum"} <= {p.name for p in tmp_path.iterdir()}
    page = (tmp_path / "view.html").read_text()
    assert page.count("data:image/jpeg;base64,") == 15 and '"images":1' in page  # one of each frame
    assert len(page) < 5e5
