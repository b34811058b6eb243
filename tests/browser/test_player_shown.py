"""What the player shows, against what Python reads from the same log; and numbers that cannot be shown."""

import json

import numpy as np
import pytest

from ekfslam_tutorial.geometry import Frame2, Frame3
from ekfslam_tutorial.graphics.player import StateLog, write_player_html
from ekfslam_tutorial.graphics.style import ROBOTS

from .conftest import visit
from .pages import map_of, picture, readout

pytestmark = pytest.mark.browser


@pytest.mark.parametrize("name", ["flat", "space"])
def test_the_player_reads_what_python_reads(name, request, open_log):
    """Two readers of the format, written apart, agree in every number of every frame."""
    log = request.getfixturevalue(name)
    page = open_log(log)
    read = page.evaluate(
        """player.log.frames.map(f => ({
            k: f.k, t: f.t, lmks: [...f.lmks], robots: [...f.robots], truth: [...f.truth], world: [...f.world],
            obs: f.obs.map(o => ({...o, z: o.nu.map((v, i) => v * o.std[i])})), fresh: f.fresh, missed: f.missed,
            sens: [...f.sens],
        }))"""
    )
    assert len(read) == len(log)
    for got, frame in zip(read, log.frames(), strict=True):
        d = len(next(iter(frame.lmks.values()))[0])
        assert (got["k"], got["t"], got["fresh"]) == (frame.k, frame.t, frame.new)
        assert got["missed"] == [lmk for _, lmk in frame.missed]
        assert {id for id, _ in got["lmks"]} == set(frame.lmks)
        for id, lmk in got["lmks"]:
            assert np.allclose(lmk["p"], frame.lmks[id][0], atol=1e-9)
            assert np.allclose(lmk["L"], frame.lmks[id][1], atol=1e-12)
        for id, robot in got["robots"]:
            x, L, std = frame.robots[id]
            assert np.allclose(robot["p"], x[:d], atol=1e-9)
            assert robot["L"] is None and (L == 0).all() or np.allclose(robot["L"], L, atol=1e-12)
            assert d == 3 or np.isclose(robot["std"], std)
        for key, poses in ("truth", frame.truth), ("sens", frame.sens):
            assert {id: pose["p"] for id, pose in got[key]} == {
                id: pytest.approx(x[:d], abs=1e-9) for id, x in poses.items()
            }
        for id, pose in got["sens"]:
            assert np.allclose(pose["R"], rotation(frame.sens[id], d), atol=2e-4)  # quaternions of 4 digits
        assert [(o["sen"], o["lmk"], o["used"]) for o in got["obs"]] == [
            (str(o.sen), o.lmk, o.updated) for o in frame.obs
        ]
        for o, obs in zip(got["obs"], frame.obs, strict=True):
            assert np.allclose([o["md2"], *o["z"], *o["std"]], [obs.md2, *obs.z, *obs.std])
            assert (o["point"] is None) == (obs.point is None)
            assert obs.point is None or np.allclose(o["point"], obs.point)


def rotation(x, d):
    return (Frame2 if d == 2 else Frame3)(x).normalized()[0].R


def test_ellipses_stand_where_they_should(flat, open_log):
    """The outline of an ellipse in the picture, against points of it that are projected one by one."""
    page = open_log(flat)
    outlines = page.evaluate(
        """() => {
            const {camera, k} = player.scene
            return [...player.log.frames.at(-1).lmks.values()].map(({p, L}) => [camera.outline(p, L, k),
                Array.from({length: 90}, (_, n) => [Math.cos(n * Math.PI / 45), Math.sin(n * Math.PI / 45)])
                    .map(u => camera.project(p.map((v, i) => v + k * (L[i][0] * u[0] + L[i][1] * u[1]))))])
        }"""
    )
    assert len(outlines) > 5
    for o, points in outlines:
        c, s = np.cos(o["angle"]), np.sin(o["angle"])
        x, y = ((np.array(points) - [o["x"], o["y"]]) @ [[c, -s], [s, c]]).T
        assert np.allclose(np.hypot(x / o["major"], y / o["minor"]), 1.0, atol=1e-6)


def test_ellipsoids_stand_where_they_should(space, open_log):
    """What WebGL draws of one ellipsoid reaches as far as points of its surface that are projected one by one."""
    page = open_log(space)
    boxes = page.evaluate(
        """() => {
            const {scene} = player, {camera, stage, k, ratio, context, canvas} = scene, out = []
            const box = points => [0, 1].flatMap(i => [Math.min, Math.max].map(f => f(...points.map(p => p[i]))))
            for (const [id, {p, L}] of player.log.frames.at(-1).lmks) {
                const cloud = []
                for (let i = 0; i < 40; i++) for (let j = 0; j < 80; j++) {
                    const a = Math.PI * i / 39, b = 2 * Math.PI * j / 80
                    const u = [Math.sin(a) * Math.cos(b), Math.sin(a) * Math.sin(b), Math.cos(a)]
                    cloud.push(camera.project(p.map((v, n) => v + k * (L[n][0]*u[0] + L[n][1]*u[1] + L[n][2]*u[2]))))
                }
                if (cloud.some(at => !at)) continue
                const [x0, x1, y0, y1] = box(cloud), [w, h] = camera.size
                if (Math.max(x1 - x0, y1 - y0) < 12 || x0 < 0 || y0 < 0 || x1 > w || y1 > h) continue
                stage.clear()
                const alone = new Map([[id, {p, L}]])
                stage.shapes('ball', scene.ellipsoids({robots: new Map(), lmks: alone, lines: new Map()}, new Map()), 0)
                stage.draw(camera.view(), [w, h])
                context.clearRect(0, 0, ...scene.area)
                context.drawImage(stage.canvas, 0, stage.canvas.height - h * ratio, w * ratio, h * ratio, 0, 0, w, h)
                const {data, width} = context.getImageData(0, 0, canvas.width, canvas.height), drawn = []
                for (let i = 0; i < data.length / 4; i++) {
                    const x = (i % width) / ratio, y = Math.floor(i / width) / ratio
                    if (data[4 * i + 3] && data[4 * i] < 250 && x < w) drawn.push([x, y])
                }
                out.push([[x0, x1, y0, y1], box(drawn)])
            }
            return out
        }"""
    )
    assert len(boxes) > 3
    for expected, drawn in boxes:
        assert drawn == pytest.approx(expected, abs=4)  # pixels; a body of 18 by 9 faces does not reach the tips


def test_every_frame_can_be_drawn(flat, space, open_log):
    for log in flat, space:
        page = open_log(log)
        pictures = [
            page.evaluate("i => { player.seek(i); player.draw(); return player.canvas.toDataURL().length }", i)
            for i in range(len(log))
        ]
        assert min(pictures) > 5000
        states = page.locator(".legend").inner_text()
        assert "σ" in states and "rejected" in states


def test_words_for_those_who_do_not_see_the_picture(flat, open_log):
    page = open_log(flat)
    page.evaluate("player.seek(20)")
    picture(page)
    frame = flat.frames()[20]
    used = sum(o.updated for o in frame.obs)
    words = page.get_by_role("status").inner_text()
    assert (
        words.startswith(flat.title)
        and f"frame {frame.k}, t = {frame.t:.1f} s" in words
        and f"{used} corrected" in words
    )
    slider = page.get_by_role("slider", name="Frame")
    assert f"frame {frame.k}" in slider.get_attribute("aria-valuetext")
    assert (slider.get_attribute("min"), slider.get_attribute("max")) == ("0", "39")
    assert "test of range_bearing_2d" in map_of(page).get_attribute("aria-label")
    for role, name in ("button", "Play"), ("combobox", "Speed"), ("button", "Whole picture"):
        assert page.get_by_role(role, name=name).is_visible()


def test_each_robot_has_its_colour_and_each_camera_its_picture(two_robots, open_log):
    page = open_log(two_robots)
    assert page.evaluate("[1, 2].map(id => player.scene.color(id))") == list(ROBOTS[:2])
    page.evaluate("player.seek(9)")
    whole = picture(page)
    assert page.evaluate("player.scene.views.map(sensor => sensor.name)") == [
        "Micropix",
        "side camera",
        "RGB-D",
        "wide lens",
    ]
    colours = "[...player.scene.robots(player.log.frames[9])].map(robot => robot.color)"
    assert page.evaluate(colours) == list(ROBOTS[:2])
    for layer in "view", "fan":
        page.locator(f".legend button[data-layer={layer}]").click()
        assert picture(page) != whole
        whole = picture(page)
    assert page.evaluate("player.scene.room()") == 0


def test_without_webgl_there_are_still_marks_and_words(chromium, space, tmp_path):
    page = visit(chromium, viewport={"width": 1024, "height": 720})
    page.add_init_script(
        "const get = HTMLCanvasElement.prototype.getContext\n"
        "HTMLCanvasElement.prototype.getContext = function (kind, ...more) {"
        " return kind === '2d' ? get.call(this, kind, ...more) : null }"
    )
    page.goto(write_player_html(tmp_path / "player.html", space).as_uri())
    page.wait_for_function("window.player?.drawn > 0")
    page.evaluate("player.seek(20)")
    map_of(page).press("ArrowDown")
    assert "mean" in readout(page)
    assert page.evaluate("player.scene.stage.gl") is None
    assert page.problems == []
    page.context.close()


def test_hostile_numbers_are_drawn_without_complaint(page, tmp_path):
    """Nothing, infinity, an ellipsoid that reaches behind the eye, a point: frame after frame, no error."""
    for d in 2, 3:
        n, low = {2: 3, 3: 7}[d], d * (d + 1) // 2
        pose = [1, *[0] * (n - 1 if d == 2 else d), *([1] if d == 2 else [10000, 0, 0, 0])]
        rows = [[1], [2, *[1000] * d], [3, *[1500] * d, None], [4, *[2000] * d, 0, *[0] * low]]
        rows += [
            [5, *[-900] * d, 13, *[100] * low],
            [6, *[999_999_999] * d, -3, *[1] * low],
            [7, *[-500] * d, -900, *[1] * low],
        ]
        obs = {"1": [[5, None, None, None, None, None], [99, 100, 10, 20, 0.1, 0.1]]}
        frames = [
            {"k": 1, "t": 0, "rob": [[1]]},
            {
                "k": 2,
                "t": 0.1,
                "rob": [pose],
                "sen": [pose],
                "lmk": rows,
                "new": [1, 99],
                "used": obs,
                "missed": {"1": [2, 98]},
            },
            {
                "k": 3,
                "t": 0.2,
                "rob": [[1]],
                "gone": [1, 2, 3],
                "rejected": obs,
                "note": [["refused", 4], ["recovery", -1]],
            },
            {"k": 4, "t": 0.3, "rob": [pose], "true": [pose], "world": [[1], [2, *[5] * d]], "gone": [5]},
        ]
        sensors = [{"id": 1, "robot": 1, "name": "s", "units": ["px", "rad"], "point": False}]
        head = json.loads(StateLog().to_json()) | {"dim": d, "robots": [{"id": 1, "name": "r"}], "sensors": sensors}
        log = StateLog.from_json(json.dumps(head | {"frames": frames}))
        page.goto(write_player_html(tmp_path / "player.html", log).as_uri())
        known = page.evaluate("player.log.frames.map(f => [[...f.lmks.keys()], f.lost.length])")
        assert known == [[[], 0], [list(range(1, 8)), 0], [[4, 5, 6, 7], 2], [[4, 6, 7], 1]]
        for i in range(4):
            page.evaluate("i => { player.seek(i); player.draw() }", i)
            for _ in range(9):
                page.evaluate("player.cycle(1); player.draw()")
        page.evaluate("player.log.frames.length = 0; player.grown(); player.draw()")
        assert "waiting" in page.get_by_role("status").inner_text()
    assert page.problems == []
