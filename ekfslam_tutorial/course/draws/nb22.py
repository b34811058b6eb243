"""Drawings of notebook 22: a line before a camera, a robot between edges, a fan of lines, NEES, what has been seen."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.patches import Rectangle

from ...ekf import chi_square
from ...geometry import Frame3, e2q, unit
from ...graphics import ESTIMATE, MEASUREMENT, PREDICTED, TRUTH, line, points
from ...graphics.style import BLUE, GREEN, GREY, LIGHT_GREY, ORANGE, VERMILLION
from ...models.landmarks import PlkLin
from ...models.landmarks.lines import plane_base
from ...models.sensors import SegmentCam
from ..controls import Choice, Float
from ..widgets import explorable
from .space import Space

CAMERA = SegmentCam(pixel_std=1.0)
SIZE = np.array(CAMERA.image_size)
EDGE = np.array([[-1.2, 0.5, 4.0], [1.2, -0.5, 4.0]])  # in the first camera: x right, y down, z ahead
LEFT = Frame3(np.concatenate([[0, 0, 0.6], e2q(np.radians([-90, 0, 0]))[0]]))  # on a robot: looks to the left
UPRIGHT = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])  # from camera axes to those of the drawing, z up


def image_axes(ax, title=""):
    """Make axes of the image: pixels, v downwards, and its border."""
    ax.add_patch(Rectangle((0, 0), *SIZE, fill=False, edgecolor=GREY, linewidth=2.2, zorder=5))
    ax.set(xlim=(-25, SIZE[0] + 25), ylim=(SIZE[1] + 25, -25), aspect="equal", xlabel="u (px)", ylabel="v (px)")
    ax.set_title(title, loc="left")
    ax.grid(False)


# ---- what a camera sees of a line -----------------------------------------------------------------------------------


def moved_edge(along=0.0, across=0.0, in_image=0.0, depth=0.0, tilt=0.0):
    """The edge, shifted along itself and across in the image, turned in the image, then shifted and tilted in depth.

    The last two happen in the plane through the first camera and the edge: a shift in it, and a turn about the place
    where the ray through the middle meets it.
    """
    middle, half = EDGE.mean(0), (EDGE[1] - EDGE[0]) / 2
    way, n = unit(half)[0], unit(np.cross(*EDGE))[0]
    deep = np.cross(n, way)  # in the plane, across the edge
    deep = deep * np.sign(deep[2])
    a = np.radians(in_image)
    turned = np.cos(a) * half + np.sin(a) * np.cross([0, 0, 1.0], half)
    middle, half = middle + across * n, turned
    n = unit(np.cross(middle - half, middle + half))[0]
    way = unit(half)[0]
    deep = np.cross(n, way) * np.sign(np.cross(n, way)[2])
    b = np.radians(tilt)
    ray = unit(middle)[0]
    way = np.cos(b) * way + np.sin(b) * deep
    middle = middle + depth * ray + along * way
    return np.stack([middle - np.linalg.norm(half) * way, middle + np.linalg.norm(half) * way])


def image_of(edge, at):
    """Image line and segment of an edge for a camera at the place `at`, which looks as the first one does."""
    p = edge - at
    y, seen = CAMERA.segments(p.ravel())
    e, _ = CAMERA.project(np.cross(p[0], p[1]))
    return e, y.reshape(2, 2), bool(seen)


def apart(e, ends):
    """Largest distance (px) of the points `ends` from an image line."""
    return float(np.abs(ends @ e[:2] + e[2]).max())


@explorable(
    along=Float(0.6, -1.0, 1.0, 0.1, "shift along itself", "m"),
    across=Float(0.0, -0.8, 0.8, 0.1, "shift across, in the image", "m"),
    in_image=Float(0.0, -40.0, 40.0, 5.0, "turn in the image", "deg"),
    depth=Float(0.0, -1.5, 3.0, 0.25, "shift in depth, in its plane", "m"),
    tilt=Float(0.0, -50.0, 50.0, 5.0, "turn in depth, in its plane", "deg"),
    eye=Choice("first", ["first", "second"], label="picture of the camera"),
    ranges={"moved": (0, 1e5), "ends": (0, 1e5)},
)
def aperture(along, across, in_image, depth, tilt, eye):
    """A line turned about and shifted: what of it changes in the image of one camera, and of a second one?"""
    places = {"first": np.zeros(3), "second": np.array([0.5, 1.2, 0.0])}
    edge, at = moved_edge(along, across, in_image, depth, tilt), places[eye]
    e0, y0, _ = image_of(EDGE, at)
    _, y, seen = image_of(edge, at)
    fig, (left, right) = plt.subplots(1, 2, figsize=(12, 4.9), width_ratios=(1, 1.1), layout="constrained")
    space = Space(left, ((-2.9, 3.9), (-2.6, 3.2)), azim=-65, elev=22, title="from outside")
    up = lambda p: np.asarray(p) @ UPRIGHT.T
    plane = np.array([at, *(at + 1.35 * (EDGE - at)), at])
    left.fill(
        *space.xy(up(plane)).T, color=ORANGE, alpha=0.2, linewidth=0, label="plane through this camera and the edge"
    )
    far = lambda p: p.mean(0) + np.array([[-3.0], [3.0]]) * (p[1] - p[0])
    space.line(up(far(EDGE)), color=LIGHT_GREY, linewidth=1.2)
    space.line(up(EDGE), color=GREY, linewidth=5, alpha=0.7, label="edge before")
    space.line(up(edge), **line(ESTIMATE, linewidth=3), label="edge now")
    for name, place in places.items():
        mine = {"color": BLUE if name == eye else GREY, "marker": "^", "markersize": 12, "linestyle": "none"}
        space.line(up(place), **mine)
        space.text(up(place), f"{name} camera", xytext=(10, -14))
    left.legend(loc="upper left", bbox_to_anchor=(0.0, 0.02), frameon=False)
    image_axes(right, f"image of the {eye} camera")
    way = np.array([-e0[1], e0[0]])
    right.plot(*(y0.mean(0) + np.array([[-900], [900]]) * way).T, color=LIGHT_GREY, linewidth=2)
    right.plot(*y0.T, color=GREY, linewidth=5, alpha=0.7)
    if seen:
        right.plot(*y.T, **line(ESTIMATE, linewidth=3))
        right.plot(*y.T, **points(MEASUREMENT, markersize=13), label="ends of the segment")
        right.legend(loc="upper left")
    moved, ends = (apart(e0, y), float(np.linalg.norm(y - y0, axis=1).max())) if seen else (0.0, 0.0)
    says = f"Its ends move by up to {ends:.0f} px, and they are up to {moved:.0f} px away from the line that it was."
    return fig, {
        "moved": moved,
        "ends": ends,
        "caption": f"The edge in the image of the {eye} camera. {says if seen else 'It is not in the image any more.'}",
    }


# ---- figures of the notebook ----------------------------------------------------------------------------------------


def slide_figure(runs):
    """Error along the edges, with 3 sigma: {name: (truth, x, sigma)}, each (n, 3). Returns (fig, caption)."""
    fig, axes = plt.subplots(1, len(runs), figsize=(12.4, 4.1), sharex=True, layout="constrained")
    words = []
    for ax, (name, (truth, x, sigma)) in zip(axes, runs.items(), strict=True):
        k, error = np.arange(1, len(x) + 1), x[:, 0] - truth[:, 0]
        ax.fill_between(k, -3 * sigma[:, 0], 3 * sigma[:, 0], color=BLUE, alpha=0.2, linewidth=0, label="3 σ (99.7 %)")
        inside = abs(error[-1]) < 3 * sigma[-1, 0]
        ax.plot(k, error, color=BLUE if inside else VERMILLION, linewidth=2.4, label="error along the edges")
        ax.axhline(0, color=GREY, linewidth=0.8)
        ax.set(xlabel="frame (-)")
        ax.set_title(name, loc="left")
        ax.legend(loc="lower left")
        words.append(
            f"{name}: drove {truth[-1, 0]:.2f} m, says {x[-1, 0]:.2f} m, sigma {sigma[-1, 0]:.3f} m along and "
            f"{sigma[-1, 1]:.3f} m across"
        )
    axes[0].set_ylabel("error along the edges (m)")
    return fig, f"Each on its own scale. {'; '.join(words)}."


def fan_figure(l, b, std, truth):
    """Lines that a prior allows in the plane of one segment, from outside and in the plane. Returns (fig, caption)."""
    n = l[:3]
    e1, e2, *_ = plane_base(n)
    fig, ax = plt.subplots(figsize=(10.2, 4.9), layout="constrained")
    flat = lambda p: np.stack([p @ e1, p @ e2 * np.sign(e2[2])], -1)
    t = np.linspace(-14, 14, 2)
    count = 0
    for u1 in np.linspace(-2, 2, 7):
        for u2 in np.linspace(-2, 2, 7):
            if np.hypot(u1, u2) > 2.01:
                continue
            p0, d, *_ = PlkLin().support(np.concatenate([n, (b[0] + u1 * std) * e1 + (b[1] + u2 * std) * e2]))
            ax.plot(*flat(p0 + t[:, None] * d).T, color=BLUE, alpha=0.3, linewidth=1.0)
            count += 1
    p0, d, *_ = PlkLin().support(l)
    ax.plot(*flat(p0 + t[:, None] * d).T, **line(ESTIMATE, linewidth=3), label="mean of the prior")
    ax.plot([], [], color=BLUE, alpha=0.5, linewidth=1.0, label="others within 2 σ")
    rays = flat(np.stack([p / np.linalg.norm(p) for p in truth]))
    for i, r in enumerate(rays):
        ax.plot(*np.stack([0 * r, 30 * r]).T, color=ORANGE, linewidth=2.2, linestyle=":",
                label=None if i else "rays of the two ends")  # fmt: skip
    ax.plot(*flat(truth).T, **line(TRUTH, linewidth=2.4), label="true edge")
    ax.plot(0, 0, marker="^", color=GREY, markersize=14, linestyle="none", label="camera")
    ax.set(xlim=(-7, 7), ylim=(-1, 9), aspect="equal", xlabel="in the plane, parallel to the image (m)")
    ax.set_ylabel("in the plane, away (m)")
    ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False)
    far = 1 / np.linalg.norm(l[3:])
    true_far = np.linalg.norm(np.cross(*truth)) / np.linalg.norm(truth[1] - truth[0])
    return fig, (
        f"The plane of one segment, and {count} lines that the prior allows in it. All of them give the same segment. "
        f"The mean is {far:.1f} m from the camera, the true edge {true_far:.1f} m."
    )


def nees_figure(results):
    """NEES of lines by several filters: {name: (N,) array}, with the 99 % band of the mean. Returns (fig, caption)."""
    fig, ax = plt.subplots(figsize=(11, 0.75 * len(results) + 1.9), layout="constrained")
    runs = len(next(iter(results.values())))
    low, high = (chi_square.quantile(p, 4 * runs) / runs for p in (0.005, 0.995))
    words = []
    for i, (name, nees) in enumerate(results.items()):
        mean, median = nees.mean(), np.median(nees)
        ax.plot(np.clip(nees, 0.1, 3e4), i + np.linspace(-0.25, 0.25, runs), ".", color=GREY, markersize=4)
        inside = low <= mean <= high
        ax.plot(min(mean, 3e4), i, marker="D" if inside else "X", color=BLUE if inside else VERMILLION, markersize=13)
        words.append(f"{name}: mean {mean:.3g}, median {median:.2g}")
    ax.axvspan(low, high, color=GREEN, alpha=0.35, linewidth=0, label=f"99 % band of the mean: {low:.1f} to {high:.1f}")
    ax.plot([], [], "D", color=BLUE, label="mean, in the band")
    ax.plot([], [], "X", color=VERMILLION, label="mean, outside")
    ax.plot([], [], ".", color=GREY, label="one line")
    ax.set(xscale="log", xlim=(0.09, 4e4), xlabel="NEES in 4 degrees of freedom (-)", ylim=(len(results) - 0.5, -0.5))
    ax.set_yticks(range(len(results)), list(results))
    ax.minorticks_off()
    fig.legend(loc="outside lower center", ncols=4)
    return fig, f"{runs} lines each, band {low:.1f} to {high:.1f}. {'; '.join(words)}."


def seen_figure(true, seen, kept):
    """What is seen of a line in each frame, and what is remembered: (n, 2) each. Returns (fig, caption)."""
    fig, ax = plt.subplots(figsize=(10.6, 4.2), layout="constrained")
    k = np.arange(1, len(seen) + 1)
    ax.hlines(k, kept[:, 0], kept[:, 1], **{**line(ESTIMATE), "linewidth": 9}, alpha=0.35, label="remembered")
    ax.hlines(k, seen[:, 0], seen[:, 1], color=ORANGE, linewidth=3, label="seen in this frame")
    for i, t in enumerate(true):
        ax.axvline(t, **line(TRUTH, linewidth=1.6), label=None if i else "true ends")
    ax.set(xlabel="place on the line, t (m)", ylabel="frame (-)", ylim=(len(seen) + 0.7, 0.3))
    ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False)
    share = np.ptp(kept[-1]) / np.ptp(true)
    return fig, (
        f"In one frame {np.ptp(seen, axis=1).min():.1f} to {np.ptp(seen, axis=1).max():.1f} m of {np.ptp(true):.0f} m "
        f"are in the picture. After {len(seen)} frames {np.ptp(kept[-1]):.1f} m are remembered, {100 * share:.0f} %."
    )


def bent_figure(lens, edge):
    """An edge through a lens, and the straight line through its measured ends. Returns (fig, caption)."""
    fig, ax = plt.subplots(figsize=(7.6, 5.2), layout="constrained")
    image_axes(ax)
    u = lens.camera.project(edge[0] + np.linspace(0, 1, 60)[:, None] * (edge[1] - edge[0]))[0]
    ends = u[[0, -1]]
    n = np.array([ends[0, 1] - ends[1, 1], ends[1, 0] - ends[0, 0]])
    n = n / np.linalg.norm(n)
    ideal = CAMERA.camera.project(edge)[0]
    ax.plot(*u.T, **line(ESTIMATE, linewidth=3), label="image of the edge")
    ax.plot(*ends.T, **points(MEASUREMENT, markersize=14), label="measured ends")
    ax.plot(*ends.T, **line(MEASUREMENT, linewidth=2), label="straight line through them")
    ax.plot(*ideal.T, **line(PREDICTED, linewidth=2.4), label="image without the lens")
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=2, frameon=False)
    off = np.abs((u - ends[0]) @ n).max()
    moved = np.linalg.norm(ends - ideal, axis=1)
    return fig, (
        f"The middle of the edge is {off:.0f} px from the line through its ends; the ends themselves are "
        f"{moved.min():.0f} and {moved.max():.0f} px from where they would be without the lens."
    )
