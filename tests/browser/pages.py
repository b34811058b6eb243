"""What the tests ask a page with a player in it. The page itself has the player as `window.player`."""


def picture(page):
    """The picture as it is: waits for the next drawing, and returns a text that differs if the picture does."""
    return page.evaluate(
        "new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => done(player.canvas.toDataURL()))))"
    )


def at(page):
    return page.evaluate("player.at")


def map_of(page):
    return page.get_by_role("application")


def readout(page):
    page.evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
    return page.locator(".readout").inner_text()


def place(page, key):
    """Where a landmark is in the window."""
    box = map_of(page).bounding_box()
    x, y = page.evaluate("key => { const i = player.scene.items.find(i => i.key === key); return [i.x, i.y] }", key)
    return box["x"] + x, box["y"] + y


def resize(page, width, height):
    """Give the window another size, and wait until the page has heard of it and has been laid out anew."""
    page.set_viewport_size({"width": width, "height": height})
    page.evaluate(
        """async ([width, height]) => {
            while (innerWidth !== width || innerHeight !== height) await new Promise(requestAnimationFrame)
            for (const _ of [1, 2]) await new Promise(requestAnimationFrame)
        }""",
        [width, height],
    )
