"""The player as HTML, as a live view, as strip and caption: what can be said without a browser."""

import base64
import builtins
import gzip
import html
import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from ekfslam_tutorial.graphics import style
from ekfslam_tutorial.graphics.player import (
    StateLog,
    log_caption,
    log_strip,
    player_frame,
    player_html,
    player_module,
    player_options,
    write_player_html,
)


@pytest.fixture
def log(run):
    """A short run in the plane."""
    log = StateLog("a run")
    for s in run(True, time_last=12):
        log.add(s)
    return log


@pytest.fixture
def run(run):
    """The same with keyword names for dotted keys: time_last for time.last."""
    return lambda flat, **changes: run(flat, **{k.replace("time_", "time."): v for k, v in changes.items()})


@pytest.mark.parametrize("space, most", [(False, 50_000), (True, 112_000)])
def test_the_player_is_one_module_that_needs_nothing(space, most):
    module = player_module(space)
    assert not re.search(r"\bimport\b|\bfetch\b|XMLHttpRequest|WebSocket|https?://|\beval\b", module)
    assert len(re.findall(r"^export default", module, re.MULTILINE)) == 1
    assert "export function mount(" in module
    assert "</script" not in module.lower() and "<!--" not in module  # it stands in a script element
    assert len(module) <= most  # it stands in every notebook output
    assert ("OGL.Renderer" in module) is space


def test_the_library_says_which_it_is():
    asked = json.loads((Path(__file__).parents[2] / "tools" / "ogl" / "package.json").read_text())["dependencies"][
        "ogl"
    ]
    assert player_module().split("*/")[0].endswith("(Unlicense); joined by `make ogl` ")
    assert f"/* OGL {asked} by Nathan Gordon and contributors, in the public domain" in player_module()


def test_colours_and_shapes_are_those_of_the_figures():
    styles = player_options(2, 3)["styles"]
    for role in "truth", "estimate", "measurement", "rejected", "predicted", "updated":
        assert styles[role] == getattr(style, role.upper())
    looks = [(s["color"], s["marker"]) for s in styles.values()]
    assert len(set(looks)) == len({m for _, m in looks}) == len(looks)  # shapes alone tell them apart


@pytest.mark.parametrize("k, dim, words", [(3, 2, "3σ ellipse (98.9 %)"), (2, 3, "2σ ellipsoid (73.9 %)")])
def test_the_legend_says_how_many_sigmas(k, dim, words):
    assert player_options(dim, k)["sigma"] == words


def test_the_frame_is_one_element_in_a_sandbox(log):
    frame = player_frame(log)
    (tag,) = re.findall(r"<iframe ([^']*)srcdoc='[^']*'></iframe>", frame)
    assert 'sandbox="allow-scripts"' in tag and 'title="Player: a run"' in tag
    document = html.unescape(re.search(r"srcdoc='([^']*)'", frame)[1])
    packed = re.search(r'atob\("([^"]*)"\)', document)[1]
    assert gzip.decompress(base64.b64decode(packed)).decode() == player_html(log)
    assert player_frame(log) == frame and len(frame) < 0.6 * len(player_html(log))


def test_the_page_holds_the_log(log, tmp_path):
    path = write_player_html(tmp_path / "player.html", log)
    text = path.read_text(encoding="utf-8")
    assert text == player_html(log, page=True)
    assert log.to_json() in text
    assert '<html lang="en">' in text and "<title>a run</title>" in text and 'name="viewport"' in text


@pytest.mark.parametrize("title", ["</script><b>", "<!--<script>", 'it\'s "R&D" σ', "]]>\\n"])
def test_a_title_is_only_a_title(log, title):
    log.title = title
    text = player_html(log)
    assert text.count("<script") == text.count("</script>") == 1
    assert f"<title>{html.escape(title, quote=False)}</title>" in text
    assert "<!--" not in text.split("<script", 1)[1]
    frame = player_frame(log)
    assert frame.count("'") == 2


def test_an_empty_log_is_no_page(tmp_path):
    with pytest.raises(ValueError, match="no frame"):
        write_player_html(tmp_path / "player.html", StateLog())
    assert list(tmp_path.iterdir()) == []


# --- strip and caption ---


@pytest.mark.parametrize("flat", [True, False])
def test_the_strip_shows_frames_and_one_legend(run, flat):
    log = StateLog("a run")
    for s in run(flat, time_last=9):
        log.add(s)
    fig = log_strip(log, n=3)
    assert [ax.get_title().split(",")[0] for ax in fig.axes] == ["frame 4", "frame 6", "frame 9"]
    assert len(fig.legends) == 1 and all(ax.get_legend() is None for ax in fig.axes)
    words = [text.get_text() for text in fig.legends[0].get_texts()]
    assert any("σ" in w for w in words) and "true path" in words
    assert len({ax.get_xlim() for ax in fig.axes}) == 1


@pytest.mark.parametrize("flat", [True, False])
def test_the_strip_without_landmarks_shows_how_uncertain_the_robot_is(run, flat):
    log = StateLog()
    for s in run(flat, sensor=[]):
        log.add(s)
    fig = log_strip(log)
    words = [text.get_text() for text in fig.legends[0].get_texts()]
    assert "estimated landmark" not in words  # there is none
    (ellipse,) = [w for w in words if "σ" in w]
    sizes = []
    for ax in fig.axes:
        curve = [c for c in ax.lines if c.get_label() == ellipse][-1]
        points = np.array(curve.get_data_3d() if not flat else curve.get_data())
        sizes.append(np.nanmax(points, axis=1) - np.nanmin(points, axis=1))
    assert (np.diff(sizes, axis=0)[:, :2] > 0).all()  # no sensor: it grows


@pytest.mark.parametrize("flat", [True, False])
def test_labels_of_the_strip_are_not_cut(run, flat):
    log = StateLog()
    for s in run(flat, time_last=9):
        log.add(s)
    style.use_style()
    fig = log_strip(log)
    fig.canvas.draw()
    boxes = [axis.get_tightbbox() for ax in fig.axes for axis in (ax.xaxis, ax.yaxis, getattr(ax, "zaxis", ax.xaxis))]
    assert all(box.x0 > 0 and box.x1 < fig.bbox.width for box in boxes)
    assert all(ax.get_zlabel() for ax in fig.axes if not flat)
    cells = np.linspace(0, fig.bbox.width, len(fig.axes) + 1)
    for ax, left, right in zip(fig.axes, cells, cells[1:], strict=False):
        box = (ax.zaxis if not flat else ax.yaxis).get_tightbbox()
        assert left <= box.x0 and box.x1 <= right  # nor under the next picture


def test_a_strip_of_one_frame(run):
    log = StateLog()
    log.add(next(run(True)))
    assert len(log_strip(log, n=3).axes) == 1


def test_a_strip_of_chosen_frames(run):
    log = StateLog(period=2)
    for s in run(True, time_last=9):
        log.add(s)
    assert [ax.get_title().split(",")[0] for ax in log_strip(log, at=(3, 7)).axes] == ["frame 3", "frame 7"]
    with pytest.raises(ValueError, match="no frame 4; it has 5 of 1 to 9"):
        log_strip(log, at=(3, 4))


def test_the_caption_of_a_known_robot_states_no_error_of_it(run):
    log = StateLog()
    for s in run(True, **{"robot.1.in_map": False}):
        log.add(s)
    assert "true position" not in log_caption(log)


def test_the_caption_counts(run):
    log, used, rejected = StateLog(), 0, 0
    for s in run(True):
        log.add(s)
        used += sum(o.updated for o in s.obs.values())
        rejected += sum(o.matched and not o.updated for o in s.obs.values())
    caption = log_caption(log)
    error = np.linalg.norm(s.robs[0].frame(s.map).t - s.truth[1][:2])
    assert f"{len(log)} frames" in caption
    assert f"{used} measurements used, {rejected} rejected" in caption
    assert f"{len(s.lmks)} landmarks in the map" in caption
    stated = float(re.search(r"the robot ([\d.]+) m from its true position", caption)[1])
    assert stated == pytest.approx(error, rel=0.05, abs=0.002)


def test_the_caption_counts_no_part_of_the_measurements(run):
    log = StateLog(period=2)
    for s in run(True):
        log.add(s)
    assert any(frame.obs for frame in log.frames())
    assert re.match(r"\d+ frames, [\d.]+ s\. At the end: ", log_caption(log))  # half of them: no number of the run


def test_the_caption_of_a_run_without_sensor_names_no_measurement(run):
    log = StateLog()
    for s in run(True, sensor=[]):
        log.add(s)
    assert "measurement" not in log_caption(log)


@pytest.mark.parametrize("what", [log_strip, log_caption])
def test_nothing_to_show(what):
    with pytest.raises(ValueError, match="no frame"):
        what(StateLog())


def test_replay_shows_strip_caption_and_player(log, monkeypatch):
    shown = []
    monkeypatch.setattr("ekfslam_tutorial.course.figures.display", lambda data, **_: shown.append(data))
    monkeypatch.setattr("ekfslam_tutorial.course.playback.display", lambda data, **_: shown.append(data))
    from ekfslam_tutorial.course import replay

    replay(log, "Two rounds.")
    strip, caption, player = shown
    assert "image/png" in strip
    assert " ".join(caption["text/plain"].split()) == f"Two rounds. {log_caption(log)}"
    assert player["text/html"] == player_frame(log)
    assert "12 frames" in player["text/plain"]


# --- the live view ---


def test_the_live_view_sends_complete_frames(run):
    pytest.importorskip("anywidget", reason="the package anywidget is not installed")
    from ekfslam_tutorial.graphics.player import LivePlayer

    live, sent = LivePlayer("live", period=2), []
    live.send = sent.append
    assert live.head is None
    for s in run(True, time_last=6):
        live.add(s)
    assert [m["total"] for m in sent] == [1, 2, 3]
    assert live.head["dim"] == 2 and live.head["frames"] == [] and live.options["sigma"].startswith("3σ")
    alone = StateLog.from_json(json.dumps({**live.head, "frames": sent[-1]["frames"]})).frames()[0]
    assert alone.lmks.keys() == s.lmks.keys() if s.k == alone.k else live.state_log.frames()[-1].lmks.keys()

    live._handle_custom_msg("the whole log, please", [])
    assert sent[-1] == {"frames": live.state_log.records, "total": 3, "whole": True}


def test_without_anywidget_the_message_says_what_to_do(monkeypatch):
    real = builtins.__import__

    def missing(name, *arguments, **more):
        if name == "anywidget":
            raise ModuleNotFoundError("No module named 'anywidget'")
        return real(name, *arguments, **more)

    monkeypatch.setattr(builtins, "__import__", missing)
    monkeypatch.delitem(sys.modules, "ekfslam_tutorial.graphics.player.live", raising=False)
    with pytest.raises(ImportError, match="pip install anywidget"):
        from ekfslam_tutorial.graphics.player import LivePlayer  # noqa: F401


def test_the_player_is_imported_without_anywidget():
    code = "import sys, ekfslam_tutorial.course, ekfslam_tutorial.graphics.player; print('anywidget' in sys.modules)"
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert out.strip() == "False"
