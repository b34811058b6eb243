"""Movies: what is written can be read again, is complete or not there, and bad input is named."""

import os
import stat

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.colors import to_rgb
from PIL import Image

from ekfslam_tutorial.graphics import OKABE_ITO, Movie, check_movie_path, grab, side_by_side, write_movie


def frames(n=5, shape=(31, 41, 3)):  # odd sizes, which MP4 does not take as they are
    images = []
    for i in range(n):
        image = np.full(shape, 255, dtype=np.uint8)
        image[:, i * 7 : i * 7 + 7] = [0, 114, 178]
        images.append(image)
    return images


@pytest.mark.parametrize("ending", ["gif", "webp"])
def test_a_movie_is_what_was_put_in(tmp_path, ending):
    path = write_movie(tmp_path / f"run.{ending}", frames(), fps=8)
    with Image.open(path) as movie:
        assert (movie.n_frames, movie.size) == (5, (41, 31))
        for i, image in enumerate(frames()):
            movie.seek(i)
            movie.load()
            assert movie.info["duration"] in (120, 125)  # GIF counts in hundredths of a second
            difference = np.abs(np.asarray(movie.convert("RGB")).astype(int) - image)
            assert difference.mean() < 12  # WebP is lossy; a wrong frame differs by 50
    assert [p.name for p in tmp_path.iterdir()] == [path.name]


def test_a_gif_keeps_white_and_the_colours_that_mark_a_few_points(tmp_path):
    rng = np.random.default_rng(0)
    image = rng.integers(0, 256, (100, 150, 1), dtype=np.uint8).repeat(3, axis=2)  # many greys
    image[:50] = 255
    colours = [np.rint(255 * np.array(to_rgb(colour))).astype(int) for colour in OKABE_ITO]
    for i, colour in enumerate(colours):
        image[10:12, 10 * i : 10 * i + 2] = colour
    path = write_movie(tmp_path / "run.gif", [image, image // 2])
    with Image.open(path) as movie:
        shown = np.asarray(movie.convert("RGB")).astype(int)
    assert (shown[0, 0] == 255).all()
    for i, colour in enumerate(colours):
        assert np.abs(shown[10, 10 * i] - colour).max() <= 2


def test_a_run_that_fails_leaves_no_file_and_keeps_the_old_one(tmp_path):
    path = tmp_path / "run.gif"
    path.write_bytes(b"old")
    with pytest.raises(RuntimeError, match="in the run"), Movie(path) as movie:
        movie.add(frames()[0])
        raise RuntimeError("in the run")
    assert path.read_bytes() == b"old" and list(tmp_path.iterdir()) == [path]


def test_a_run_that_is_stopped_keeps_the_film_so_far(tmp_path):
    with pytest.raises(KeyboardInterrupt), Movie(tmp_path / "run.gif") as movie:
        for image in frames(3):
            movie.add(image)
        raise KeyboardInterrupt
    with Image.open(tmp_path / "run.gif") as film:
        assert film.n_frames == 3


def test_no_frames_no_file(tmp_path):
    write_movie(tmp_path / "run.gif", [])
    assert list(tmp_path.iterdir()) == []


def test_bad_input_is_named(tmp_path):
    with pytest.raises(ValueError, match=r"\.gif, \.webp, \.mp4; got 'run\.avi'"):
        check_movie_path(tmp_path / "run.avi")
    with pytest.raises(NotADirectoryError, match="nowhere"):
        check_movie_path(tmp_path / "nowhere" / "run.gif")
    with pytest.raises(ValueError, match="more than 0 frames"):
        Movie(tmp_path / "run.gif", fps=0)
    with pytest.raises(ValueError, match=r"run.gif can show a frame for 66 s at most, got 0.001 frames per second"):
        Movie(tmp_path / "run.gif", fps=0.001)
    with pytest.raises(ValueError, match=r"run.webp can show a frame for 16777 s at most"):
        Movie(tmp_path / "run.webp", fps=1e-5)
    with Movie(tmp_path / "run.gif") as movie:
        movie.add(frames()[0])
        with pytest.raises(ValueError, match="uint8, got"):
            movie.add(np.zeros((31, 41, 3)))
        with pytest.raises(ValueError, match="one size"):
            movie.add(np.zeros((31, 42, 3), dtype=np.uint8))


@pytest.mark.parametrize("ending, longest", [("gif", 65.535), ("webp", 16777.215)])
def test_the_slowest_movie_can_be_written(tmp_path, ending, longest):
    path = write_movie(tmp_path / f"run.{ending}", frames()[:2], fps=1.0000001 / longest)
    assert path.stat().st_size > 0


def test_mp4_without_ffmpeg_is_one_sentence(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(RuntimeError, match="MP4 needs the program ffmpeg.*write a .gif or .webp instead"):
        check_movie_path(tmp_path / "run.mp4")


FAKE = """#!/bin/sh
for last; do :; done
case "$FAKE_FFMPEG" in
  fails) echo "no such codec" >&2; exit 1;;
  *) ls "$(dirname "$last")"/*.png | wc -l > "$last"; echo "$@" >> "$last";;
esac
"""


@pytest.fixture
def fake_ffmpeg(tmp_path, monkeypatch):
    """A program by that name which counts the frames: what we hand to ffmpeg is tested where it is not installed."""
    if os.name == "nt":
        pytest.skip("the stand-in is a shell script")
    folder = tmp_path / "bin"
    folder.mkdir()
    program = folder / "ffmpeg"
    program.write_text(FAKE)
    program.chmod(program.stat().st_mode | stat.S_IXUSR)
    monkeypatch.setenv("PATH", f"{folder}:/usr/bin:/bin")


def test_mp4_goes_to_ffmpeg_frame_by_frame(tmp_path, fake_ffmpeg):
    path = write_movie(tmp_path / "run.mp4", frames(), fps=12)
    count, command = path.read_text().split("\n")[:2]
    assert int(count) == 5 and "-framerate 12.0" in command and "yuv420p" in command and "pad=" in command


def test_a_failing_ffmpeg_is_reported_and_leaves_no_file(tmp_path, fake_ffmpeg, monkeypatch):
    monkeypatch.setenv("FAKE_FFMPEG", "fails")
    with pytest.raises(RuntimeError, match=r"ffmpeg could not write run\.mp4: no such codec"):
        write_movie(tmp_path / "run.mp4", frames())
    assert not (tmp_path / "run.mp4").exists()


def test_grab_and_side_by_side():
    fig = plt.figure(figsize=(2, 1), dpi=50, facecolor="black")
    image = grab(fig)
    assert image.shape == (50, 100, 3) and image.dtype == np.uint8 and image.max() == 0
    joined = side_by_side([image, np.zeros((80, 30, 3), dtype=np.uint8)])
    assert joined.shape == (80, 130, 3) and (joined[60, :100] == 255).all() and joined[60, 100:].max() == 0
