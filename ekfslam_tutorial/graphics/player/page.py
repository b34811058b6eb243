"""The player as a web page: one HTML file that needs nothing else, or a frame in a notebook's output."""

from __future__ import annotations

import base64
import gzip
import html
import json
import re
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from ..bodies import robot_body, sensor_body
from ..ellipses import sigma_label
from ..style import ESTIMATE, GREY, MEASUREMENT, PREDICTED, REJECTED, ROBOTS, TRUTH, UPDATED
from .state_log import StateLog

PARTS = ("log", "camera", "element", "pen", "scene", "legend", "readout", "hands", "player", "live")
SPACE = ("orbit", "shaders", "stage", "space")
"""The source files of the player, each before those that import it; the others are for space only."""

HEIGHT = "clamp(540px, 1120px - 75vw, 860px)"
"""Of the player in a notebook: on a narrow screen the legend and the readout stand below the picture."""

UNPACK = """<!DOCTYPE html><meta charset="utf-8"><body><script>
(async () => {
if (!window.DecompressionStream) return document.body.append("The player needs a browser of 2023 or later.")
const bytes = Uint8Array.from(atob("%s"), c => c.charCodeAt(0))
const text = await new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"))).text()
document.open(), document.write(text), document.close()
})()
</script>"""
"""A document that unpacks another one, base64 of gzip, and becomes it."""

_STYLES = {
    "truth": TRUTH,
    "estimate": ESTIMATE,
    "measurement": MEASUREMENT,
    "rejected": REJECTED,
    "predicted": PREDICTED,
    "updated": UPDATED,
    "deleted": {"color": GREY, "marker": "0", "linestyle": "-", "fillstyle": "none"},
}


@cache
def player_module(space: bool = True) -> str:
    """Return the player as one JavaScript module: `mount`, and the live view as its default export.

    The source files import each other; here they follow one another, without these imports and without comments.
    For `space` the library OGL comes first: its parts that the player uses, as `make ogl` has joined them.
    """
    folder = files(__name__.rpartition(".")[0])
    read = lambda name: (folder / name).read_text(encoding="utf-8")
    css = re.sub(r"\s+", " ", read("player.css"))
    lines = [f"const CSS = {json.dumps(css)}"]
    if space:
        lines += read("ogl.min.js").splitlines()
    after = PARTS.index("scene") + 1
    for part in [*PARTS[:after], *(SPACE if space else ()), *PARTS[after:]]:
        lines += [
            line.strip() for line in read(f"{part}.js").splitlines() if not re.match(r"import .* from '\./", line)
        ]
    return "\n".join(line for line in lines if line and not line.startswith("//")) + "\n"


def player_options(dim: int, k: float, **others: Any) -> dict[str, Any]:
    """Return what the player takes from the package: styles, shapes of robot and sensor, words for the legend."""
    bodies = {"robot": robot_body(dim, 1.0), "sensor": sensor_body(dim, 1.0)}
    shapes = {name: [np.round(face, 3).tolist() for face in faces] for name, faces in bodies.items()}
    return {"styles": _STYLES, "robots": ROBOTS, "bodies": shapes, "sigma": sigma_label(k, dim), **others}


def player_html(log: StateLog, page: bool = False) -> str:
    """Return a whole HTML document that plays the log, without any request to anywhere.

    Parameters
    ----------
    log : StateLog
    page : bool
        It is a page of its own, not a frame in another page: it takes the whole window, and the wheel always zooms.
    """
    data = log.to_dict()
    options = json.dumps(player_options(data["dim"], log.k, page=page), separators=(",", ":"))
    title = html.escape(log.title or "Replay", quote=False)
    state = log.to_json().replace("<", "\\u003c")  # a title could end the script
    script = (
        f"{player_module(data['dim'] == 3)}\nconst host = document.getElementById('player')\n"
        f"window.player = mount(host, {state}, {options})\n"
        "if (location.hash === '#play' && !matchMedia('(prefers-reduced-motion: reduce)').matches) player.play()\n"
    )
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{title}</title>\n"
        "<style>html, body { margin: 0; height: 100%; background: #fff } #player { height: 100% }</style>\n"
        f'</head>\n<body>\n<div id="player"></div>\n<script type="module">\n{script}</script>\n'
        "<noscript>The player needs JavaScript.</noscript>\n</body>\n</html>\n"
    )


def player_frame(log: StateLog) -> str:
    """Return the player as one HTML element for a notebook's output.

    It is an ``iframe`` with its document inside (``srcdoc``), in a sandbox of its own: the page's styles and keys do
    not reach the player, and the player cannot touch the page. The document is packed by gzip, which makes a stored
    notebook smaller by 30 to 80 kB; the browser unpacks it.
    """
    packed = base64.b64encode(gzip.compress(player_html(log).encode(), mtime=0)).decode()
    source = (UNPACK % packed).replace("&", "&amp;").replace("'", "&#39;")
    label = html.escape(f"Player: {log.title}" if log.title else "Player")
    return (
        f'<iframe title="{label}" sandbox="allow-scripts" allow="fullscreen" '
        f"style=\"width: 100%; height: {HEIGHT}; border: 0\" srcdoc='{source}'></iframe>"
    )


def write_player_html(path: str | Path, log: StateLog) -> Path:
    """Write a page that plays the log: open it in any browser, without a server and without a network.

    Parameters
    ----------
    path : path
        The file; its folder must exist.
    log : StateLog

    Returns
    -------
    Path
        The file.

    Raises
    ------
    ValueError
        If the log has no frame.
    """
    if len(log) == 0:
        raise ValueError("there is nothing to play: the state log has no frame")
    path = Path(path)
    path.write_text(player_html(log, page=True), encoding="utf-8")
    return path
