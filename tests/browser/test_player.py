"""The player in a real browser, as a page of its own: play, scrub, read, turn. No kernel, no server."""

import numpy as np
import pytest

from .pages import at, map_of, picture, place, readout

pytestmark = pytest.mark.browser

# --- playing ---


def test_it_plays_and_pauses(flat, open_log):
    page = open_log(flat)
    before = picture(page)
    page.get_by_role("button", name="Play").click()
    page.wait_for_function("player.at >= 3")
    page.get_by_role("button", name="Pause").click()
    stopped = at(page)
    page.wait_for_timeout(300)
    assert at(page) == stopped >= 3
    assert picture(page) != before


def test_it_stops_at_the_end_and_begins_again(flat, open_log):
    page = open_log(flat)
    page.evaluate("player.seek(37)")
    page.get_by_label("Speed").select_option("40")
    page.get_by_role("button", name="Play").click()
    page.wait_for_function("player.at === player.last && !player.playing")
    assert page.get_by_role("button", name="Play").is_visible()
    page.get_by_role("button", name="Play").click()
    page.wait_for_function("player.playing && player.at < 30")


def test_it_keeps_its_speed(flat, page, open_log):
    """20 frames a second are 20 frames in a second, also where drawing is late: then frames are left out.

    The clock of the page is the test's.
    """
    page.clock.install(time=0)
    open_log(flat)
    page.get_by_label("Speed").select_option("20")
    page.clock.pause_at(1000)
    page.evaluate("player.play()")
    page.clock.run_for(900)  # drawn every 16 ms
    assert at(page) == pytest.approx(18, abs=1)
    page.clock.fast_forward(900)  # nothing is drawn in all this time
    page.clock.run_for(50)
    assert at(page) == pytest.approx(37, abs=1)


def test_the_slider_scrubs(flat, open_log):
    page = open_log(flat)
    slider = page.get_by_role("slider", name="Frame")
    before = picture(page)
    slider.fill("31")
    assert at(page) == 31 and picture(page) != before
    box = slider.bounding_box()
    page.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    assert 18 <= at(page) <= 21


def test_everything_works_with_the_keyboard(flat, open_log):
    page = open_log(flat)
    map_of(page).focus()
    for key, expected in [("ArrowRight", 1), ("ArrowRight", 2), ("ArrowLeft", 1), ("End", 39), ("ArrowRight", 39)] + [
        ("ArrowLeft", 38),
        ("Home", 0),
        ("ArrowLeft", 0),
    ]:
        page.keyboard.press(key)
        assert at(page) == expected, key
    page.keyboard.press("Space")
    page.wait_for_function("player.at >= 2")
    page.keyboard.press("Space")
    assert not page.evaluate("player.playing")

    speed = page.get_by_label("Speed")
    for key, expected in ("+", "20"), ("+", "40"), ("+", "40"), ("-", "20"), ("-", "10"):
        page.keyboard.press(key)
        assert speed.input_value() == expected
    whole = picture(page)
    page.keyboard.press("PageUp")
    closer = picture(page)
    page.keyboard.press("Shift+ArrowRight")
    moved = picture(page)
    page.keyboard.press("0")
    assert len({whole, closer, moved}) == 3 and picture(page) == whole


def test_the_tab_key_reaches_everything_and_shows_where_it_is(flat, open_log):
    page = open_log(flat)
    page.evaluate("document.body.tabIndex = -1, document.body.focus()")
    seen = []
    for _ in range(12):
        page.keyboard.press("Tab")
        name, width = page.evaluate(
            """() => {
                const node = player.root.activeElement
                if (!node) return ['', 0]
                const ring = node === player.canvas ? player.stage : node
                return [node.ariaLabel ?? node.textContent, parseFloat(getComputedStyle(ring).outlineWidth)]
            }"""
        )
        seen.append(name)
        assert not name or width >= 2, f"no focus ring on {name}"
    words = " | ".join(seen)
    for name in "Map of", "Play", "Frame", "Speed", "Whole picture", "Keys", "truth", "σ":
        assert name in words
    page.get_by_text("Keys").focus()
    page.keyboard.press("Enter")
    assert page.get_by_text("play, pause").is_visible()


# --- reading ---


@pytest.mark.parametrize("name", ["flat", "space"])
def test_the_mouse_reads_a_landmark(name, request, open_log):
    log = request.getfixturevalue(name)
    page = open_log(log)
    page.evaluate("player.seek(20)")
    picture(page)
    frame = log.frames()[20]
    alone = page.evaluate(
        """() => {
            const far = (a, b) => Math.hypot(a.x - b.x, a.y - b.y), {items} = player.scene
            const alone = items.filter(a => items.every(b => a === b || far(a, b) > 30))
            return alone.map(a => a.key)
        }"""
    )
    o = next(o for o in frame.obs if o.lmk in alone)
    page.mouse.move(*place(page, o.lmk))
    text = readout(page).replace("−", "-")
    p, L = frame.lmks[o.lmk]
    assert f"Landmark {o.lmk}: {'corrected' if o.updated else 'rejected'}" in text
    for axis, mean, sigma in zip("xyz", p, np.sqrt(np.diag(L @ L.T)), strict=False):
        assert f"{axis} (m)\t{mean:.2f}\t{float(f'{sigma:.2g}'):g}" in text
    assert f"d² = {float(f'{o.md2:.3g}'):g}" in text
    factor = {"m": 1, "px": 1, "rad": 180 / np.pi}
    for i, unit in enumerate(page.evaluate("[...player.log.sensors.values()][0].units")):
        z = float(f"{o.z[i] * factor[unit]:.2g}")
        assert f"\t{z:g}\t{float(f'{o.std[i] * factor[unit]:.2g}'):g}" in text
    assert "nearest true landmark" in text and "half-axes" in text and "correlation" in text

    page.mouse.move(2, 2)
    assert "Point at a landmark" in readout(page)


def test_a_click_keeps_a_landmark(flat, open_log):
    page = open_log(flat)
    page.evaluate("player.seek(20)")
    picture(page)
    lmk = flat.frames()[20].obs[0].lmk
    page.mouse.click(*place(page, lmk))
    page.mouse.move(2, 2)
    assert f"Landmark {lmk}:" in readout(page)
    page.keyboard.press("ArrowRight")
    assert f"Landmark {lmk}:" in readout(page)  # in the next frame too
    page.keyboard.press("Escape")
    assert "Point at" in readout(page)


def test_the_arrow_keys_read_all_landmarks(flat, open_log):
    page = open_log(flat)
    page.evaluate("player.seek(39)")
    before = picture(page)
    map_of(page).focus()
    heads = []
    for _ in range(len(flat.frames()[39].lmks) + 2):
        page.keyboard.press("ArrowDown")
        heads.append(readout(page).splitlines()[0].split(":")[0])
    assert heads[0] == heads[-1] == "Dala"  # the robot, then all landmarks, then the robot again
    assert heads[1:-1] == [f"Landmark {id}" for id in sorted(flat.frames()[39].lmks)]
    assert picture(page) != before
    page.keyboard.press("ArrowUp")
    assert readout(page).startswith(heads[-2])


def test_the_legend_hides_and_shows(flat, open_log):
    page = open_log(flat)
    page.evaluate("player.seek(30)")
    whole = picture(page)
    pictures = [whole]
    for layer in "truth", "ellipse", "measurement", "name", "fan":
        button = page.locator(f".legend button[data-layer={layer}]")
        button.click()
        assert button.get_attribute("aria-pressed") == "false"
        pictures.append(picture(page))
        button.press("Space")
        assert button.get_attribute("aria-pressed") == "true"
        assert picture(page) == whole
    assert len(set(pictures)) == 6
    assert not page.evaluate("player.playing")  # the space bar was the button's


# --- the picture ---


def test_space_can_be_turned_and_zoomed(space, open_log):
    page = open_log(space)
    page.evaluate("player.seek(20)")
    pictures = [picture(page)]
    box = map_of(page).bounding_box()
    x, y = box["x"] + 5, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 120, y + 40, steps=4)
    page.mouse.up()
    pictures.append(picture(page))
    azimuth, elevation = page.evaluate("[player.scene.camera.azimuth, player.scene.camera.elevation]")
    map_of(page).focus()
    page.keyboard.press("Shift+ArrowLeft")
    page.keyboard.press("Shift+ArrowDown")
    pictures.append(picture(page))
    again = page.evaluate("[player.scene.camera.azimuth, player.scene.camera.elevation]")
    assert again[0] > azimuth and again[1] > elevation
    page.mouse.wheel(0, -300)
    pictures.append(picture(page))
    page.get_by_role("button", name="Whole picture").click()
    pictures.append(picture(page))
    assert len(set(pictures)) == 5
    assert at(page) == 20


def test_the_plane_can_be_moved_and_zoomed(flat, open_log):
    page = open_log(flat)
    page.evaluate("player.seek(20)")
    key = flat.frames()[20].obs[0].lmk
    x, y = place(page, key)
    page.mouse.move(x, y)
    page.mouse.wheel(0, -400)
    picture(page)
    assert place(page, key) == pytest.approx((x, y), abs=1)  # zoomed 1.8 times about the pointer, a whole pixel
    page.mouse.down()
    page.mouse.move(x - 60, y + 30, steps=5)
    page.mouse.up()
    picture(page)
    assert place(page, key) == pytest.approx((x - 60, y + 30), abs=4.5)  # the first pixels make it a drag
