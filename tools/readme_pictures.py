"""The moving pictures of the README: the lecture's map, and two robots with four cameras in space.

``make pictures`` runs this file. Same seed, same pictures; each stays under 800 kB.
"""

import math
from pathlib import Path

import matplotlib.pyplot as plt

from ekfslam_tutorial.graphics import MapFig, Movie, grab, use_style
from ekfslam_tutorial.toolbox import UserData
from ekfslam_tutorial.toolbox.universal_slam import universal_slam

ROOT = Path(__file__).resolve().parent.parent
IMAGES = ROOT / "docs" / "images"
LIMIT = 800_000  # bytes
DPI = 70
# name: scenario, fixed limits in metres or None, frames per second, every how many-th frame, turn of the camera in deg
PICTURES = {
    "lecture": ("range_bearing_2d", [(-8, 8), (-6.5, 7)], 10, 2, 0),
    "two_robots": ("two_robots_four_cameras", [(-8, 8), (-8, 8), (-1, 3)], 6, 4, 40),
}


def main():
    use_style()
    for name in PICTURES:
        path = film(name)
        print(f"{path.relative_to(ROOT)}: {path.stat().st_size / 1e3:.0f} kB")
        if path.stat().st_size > LIMIT:
            raise SystemExit(f"{path.name} is larger than {LIMIT // 1000} kB: fewer frames, or smaller ones")


def film(name):
    """Run a scenario and write its film."""
    scenario, limits, fps, every, turn = PICTURES[name]
    data = UserData.from_toml(ROOT / "data" / "scenarios" / f"{scenario}.toml")
    run = universal_slam(data)
    figure = MapFig(next(run), limits=limits, labels=False, size=0.6, figsize=(9, 6.9))
    figure.fig.set_dpi(DPI)
    with Movie(IMAGES / f"{name}.webp", fps) as movie:
        for k, snapshot in enumerate(run):
            if k % every:
                continue
            if turn:
                figure.orbit(math.radians(turn) * every / len(run))
            figure.update(snapshot)
            movie.add(grab(figure.fig))
        last = grab(figure.fig)
        for _ in range(2 * int(fps)):  # the end stays for two seconds
            movie.add(last)
    plt.close(figure.fig)
    return IMAGES / f"{name}.webp"


if __name__ == "__main__":
    main()
