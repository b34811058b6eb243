"""Drawings of notebook 12: a wall in a lens, the fold, what moves a pixel, a ray with a prior, a calibration."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.patches import Rectangle

from ...analysis.consistency import md2
from ...geometry import Frame3, e2q
from ...graphics import (
    ESTIMATE,
    MEASUREMENT,
    PREDICTED,
    TRUTH,
    line,
    nan_separated,
    plot_ellipse,
    points,
    sigma_label,
)
from ...graphics.style import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, SKY_BLUE, VERMILLION
from ...models.sensors.lens import distort, inv_distortion
from ...models.sensors.pin_hole import inv_pin_hole, pin_hole
from ..controls import Choice, Float, Int
from ..widgets import explorable
from .nb12_runs import (
    NAMES,
    SIZE,
    START,
    START_STD,
    TRUE,
    Calibration,
    K,
    board,
    corner,
    fold_of,
    in_lens,
    model_error,
    wall,
    ways_back,
)
from .space import Space

__all__ = ["FORWARD", "SIZE", "START", "START_STD", "TRUE", "Calibration", "K", "board", "fold_of"]

NARROW = np.array([320.0, 240.0, 450.0, 450.0])  # k of a camera with a smaller angle of view
FORWARD = np.concatenate([[0, 0, 0.6], e2q(np.array([-np.pi / 2, 0, -np.pi / 2]))[0]])  # looks ahead, 0.6 m above


def picture_axes(ax, margin=0.0, title=""):
    """Make axes of the image: pixels, v downwards, and the border of the sensor."""
    ax.add_patch(Rectangle((0, 0), *SIZE, fill=False, edgecolor=BLACK, linewidth=2.2, zorder=5))
    ax.set(xlim=(-margin, SIZE[0] + margin), ylim=(SIZE[1] + margin, -margin), aspect="equal")
    ax.set(xlabel="u (px)", ylabel="v (px)")
    ax.set_title(title, loc="left")
    ax.grid(False)


# ---- figures of the notebook ----------------------------------------------------------------------------------------


def ways_figure(d):
    """Errors of some ways back through the lens, over the radius. Returns (fig, caption)."""
    r = np.linspace(0, min(corner(), 0.97 * fold_of(d)), 120)
    errors = ways_back(d, r)
    looks = (
        (VERMILLION, "-."),
        (ORANGE, (0, (5, 1))),
        (PURPLE, ":"),
        (SKY_BLUE, "--"),
        (GREEN, (0, (1, 1))),
        (BLUE, "-"),
    )
    fig, ax = plt.subplots(figsize=(11, 5), layout="constrained")
    for (name, e), (color, dash) in zip(errors.items(), looks, strict=True):
        ax.semilogy(r, np.maximum(e, 1e-4), color=color, linestyle=dash, linewidth=2.6, label=name)
    ax.axhline(1, color=GREY, linewidth=1.2)
    ax.text(0.005, 1.2, "1 px", fontsize=12, color=GREY)
    ax.set(
        xlabel="radius of the ideal point, |[x/z, y/z]|  (right end: the corner)", ylabel="error of the way back (px)"
    )
    ax.set(ylim=(7e-5, 300), xlim=(0, r[-1]))
    ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
    worst = {name: e.max() for name, e in errors.items()}
    words = ", ".join(f"{name}: {e:.2g} px" for name, e in list(worst.items())[:-1])
    exact = "less than 0.0001 px" if worst["Newton"] < 1e-4 else f"{worst['Newton']:.2g} px"
    return fig, f"Worst errors. {words}. Newton: {exact}. Errors below 0.0001 px are drawn there."


def map_and_image_figure(Rf, P, Sf, points_in_world, expected, measured, k=K, d=(-0.25,)):
    """Robot and landmarks in space, and the image of its camera: expected pixels with 3-sigma ellipses, measured ones.

    Parameters
    ----------
    Rf, Sf : Frame3
        Robot in the world, with the covariance P, shape (7, 7); camera on the robot.
    points_in_world : ndarray, shape (n, 3)
    expected : dict of int to (u, Z)
        Pixel and covariance of each landmark that the camera should see, by its number.
    measured : dict of int to ndarray
        Pixel that it has seen.

    Returns
    -------
    fig, caption
    """
    fig = plt.figure(figsize=(12.6, 5.4))
    left, image = fig.add_axes((0.01, 0.17, 0.52, 0.75)), fig.add_axes((0.6, 0.2, 0.39, 0.72))
    space = Space(left, ((-1, 1), (-1, 1)), azim=-150, elev=38, title="map figure")
    corners = space.xy(np.vstack([points_in_world, [Rf.t]]))
    (u0, s0), (u1, s1) = corners.min(0) - 0.5, corners.max(0) + 0.5
    left.set(xlim=(u0, u1), ylim=(s0, s1))
    space.ground(15, 2.0)
    space.curves(np.stack([points_in_world, points_in_world * [1, 1, 0]], 1), color=GREY, linewidth=0.7)
    seen = sorted(expected)
    space.line(points_in_world, **points(TRUTH, markersize=8, markeredgewidth=1.0), label="landmarks, known")
    eye = Rf.from_frame(Sf.t)[0]
    rays = np.stack([np.broadcast_to(eye, (len(seen), 3)), points_in_world[seen]], 1)
    space.curves(rays, **line(MEASUREMENT, linewidth=0.9), label="rays to those expected in the image")
    space.robot(Rf, 0.45, **line(ESTIMATE, linewidth=1.6))
    space.ellipsoid(Rf.t, P[:3, :3] + 1e-9 * np.eye(3), 3, **line(ESTIMATE, linewidth=1.2), label=sigma_label(3, 3))
    left.legend(loc="upper center", bbox_to_anchor=(0.5, -0.02), ncols=2, frameon=False)
    u, Z = np.array([expected[i][0] for i in seen]), np.array([expected[i][1] for i in seen])
    plot_ellipse(image, u, Z, 3, **line(PREDICTED, linewidth=1.3), label=f"expected, {sigma_label(3)}")
    image.plot(*u.T, **points(PREDICTED, markersize=5), zorder=6)
    image.plot(*np.array(list(measured.values())).T, **points(MEASUREMENT, markersize=10), zorder=7, label="measured")
    picture_axes(image, 25, "sensor figure")
    image.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=2, frameon=False)
    both = [i for i in seen if i in measured]
    inside = sum(md2(measured[i] - expected[i][0], expected[i][1]) < 9 for i in both)
    depth = np.linalg.norm(points_in_world[seen] - eye, axis=1)
    wide = 3 * np.sqrt(Z[:, 0, 0])
    near, far = np.argmin(depth), np.argmax(depth)
    return fig, (
        f"{len(seen)} of {len(points_in_world)} landmarks are expected in the image; {inside} of {len(both)} measured "
        f"pixels lie in their 3-sigma ellipses. To the side 3 sigma is {wide[near]:.0f} px for the nearest landmark, "
        f"{depth[near]:.1f} m away, and {wide[far]:.0f} px for the one furthest away, {depth[far]:.1f} m."
    )


def correction(d, n=4, k=K):
    """Correction vector of n numbers for a lens d, as in the manual."""
    return inv_distortion(d, n, k)


# ---- widgets --------------------------------------------------------------------------------------------------------


@explorable(
    d2=Float(-0.25, -0.5, 0.5, 0.01, "d2 (K2)"),
    d4=Float(0.0, -0.3, 0.3, 0.01, "d4 (K4)"),
    ranges={"corner": (0, 2000), "bend": (0, 2000)},
)
def lens(d2, d4):
    """A straight wall seen through a lens."""
    d = np.array([d2, d4])
    fold = fold_of(d)
    fig = plt.figure(figsize=(10.5, 6))
    ax = fig.add_axes((0.08, 0.1, 0.67, 0.87))
    curves = wall()
    ax.plot(*nan_separated(np.array([K[:2] + K[2:] * c for c in curves])).T, color=GREY, linestyle=":", linewidth=1.2,
            label="ideal lens")  # fmt: skip
    bent = np.array([in_lens(c, d) for c in curves])
    ax.plot(*nan_separated(bent).T, color=BLUE, linewidth=2, label="this lens")
    p = np.array([[0.75, -0.5], [0.0, -0.5]])  # two points of one straight line of the wall
    moved = distort(p, d)[0]
    ax.plot(*(K[:2] + K[2:] * p).T, **points(TRUTH, markersize=15), label="two points, ideal lens")
    ax.plot(*(K[:2] + K[2:] * moved).T, **points(ESTIMATE, markersize=9), label="the same, this lens")
    rim = ""
    if fold < 3:
        a, rd = np.linspace(0, 2 * np.pi, 100), fold * (1 + d2 * fold**2 + d4 * fold**4)
        ax.plot(*(K[:2, None] + K[2:, None] * rd * [np.cos(a), np.sin(a)]), color=VERMILLION, linestyle="--",
                linewidth=2.5, label="fold: no light outside")  # fmt: skip
        rim = f" It folds back at the radius {fold:.2f}; the ideal corner has {corner():.2f}."
    picture_axes(ax, 60)
    ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
    up = np.array([1.0, 0.75])
    off = float(K[2] * np.linalg.norm(distort(up, d)[0] - up))
    bend = float(K[3] * abs(moved[0, 1] - moved[1, 1]))
    where = distort(up, d)[0][0] - 1
    kind = "nothing is bent" if not d.any() else "barrel" if where < 0 else "pincushion"
    caption = (
        f"d2 = {d2:.2f}, d4 = {d4:.2f}: {kind}. The corner of the image moves by {off:.0f} px. The two points are on "
        f"one straight line of the wall; in the image their rows differ by {bend:.1f} px.{rim}"
    )
    return fig, {"corner": off, "bend": bend, "caption": caption}


@explorable(
    d2=Float(-0.3, -0.5, 0.3, 0.01, "d2 (K2)"),
    d4=Float(0.0, -0.3, 0.3, 0.01, "d4 (K4)"),
    r=Float(1.4, 0.1, 2.0, 0.05, "radius of a point, |[x/z, y/z]|"),
    ranges={"rd": (-20, 20)},
)
def fold(d2, d4, r):
    """Where the lens is no longer one to one: two radii with the same pixel."""
    d, grid = np.array([d2, d4]), np.linspace(0, 2.05, 300)
    g = lambda r: r * (1 + d2 * r**2 + d4 * r**4)
    edge, rd = fold_of(d), float(g(r))
    fig, ax = plt.subplots(figsize=(10.5, 5), layout="constrained")
    ax.plot(grid, grid, color=GREY, linestyle=":", linewidth=2, label="ideal lens")
    ax.plot(grid, g(grid), color=BLUE, linewidth=2.8, label="this lens")
    if edge < 2.05:
        ax.axvspan(edge, 2.05, facecolor=VERMILLION, alpha=0.14, linewidth=0, hatch="//", edgecolor=VERMILLION,
                   label="beyond the fold")  # fmt: skip
        ax.plot(edge, g(edge), marker="v", color=VERMILLION, markersize=13, linestyle="none", label="fold")
    ax.plot(r, rd, **points(ESTIMATE, markersize=11), label="the point")
    roots = np.roots([d4, 0, d2, 0, 1, -rd])
    others = np.sort(roots[(np.abs(roots.imag) < 1e-7) & (roots.real > 0)].real)
    others = others[(np.abs(others - r) > 1e-3) & (others < 2.05)]
    ax.axhline(rd, color=BLACK, linewidth=1, linestyle="--")
    if len(others):
        ax.plot(others, g(others), **points(MEASUREMENT, markersize=16, markeredgewidth=3), label="same pixel")
    ax.set(xlabel="radius before the lens (-)", ylabel="radius behind the lens (-)", xlim=(0, 2.05), ylim=(-0.4, 2.05))
    ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
    if rd < 0:
        says = "it would land on the other side of the axis: nonsense"
    elif r >= edge:
        twin = f", where a point at {others[0]:.2f} lands, too" if len(others) else ""
        says = f"beyond the fold. The formula gives {rd:.2f}{twin}; no light comes there"
    else:
        says = f"before the fold: it is seen at {rd:.2f}, and the lens can be inverted there"
    bound = f"The fold is at {edge:.2f}." if np.isfinite(edge) else "This lens never folds."
    return fig, {"rd": rd, "caption": f"d2 = {d2:.2f}, d4 = {d4:.2f}. {bound} A point at radius {r:.2f} is {says}."}


def _pose_change(i, size):
    """The frame of a camera that has moved by `size` along axis i, or turned about it (i from 3 on)."""
    t, e = np.zeros(3), np.zeros(3)
    (t if i < 3 else e)[i % 3] = size
    return Frame3(np.concatenate([t, e2q(e)[0]]))


CHANGES = {
    "u0: centre, 10 px": ("k", 0, 10.0),
    "au: focal length, 10 px": ("k", 2, 10.0),
    "d2: by 0.1": ("d", 0, 0.1),
    "d4: by 0.1": ("d", 1, 0.1),
    "camera 10 cm to the right": ("s", 0, 0.1),
    "camera 10 cm ahead": ("s", 2, 0.1),
    "camera turned right by 2°": ("s", 4, np.radians(2)),
    "camera rolled by 2°": ("s", 5, np.radians(2)),
}


@explorable(
    what=Choice("d2: by 0.1", list(CHANGES), label="change"),
    depth=Float(4.0, 1.0, 20.0, 1.0, "depth of the points", "m"),
    d2=Float(-0.2, -0.3, 0.2, 0.05, "d2 of the lens"),
    ranges={"middle": (0, 200), "edge": (0, 400)},
)
def flow(what, depth, d2):
    """How the pixels of a grid move when one parameter, or the pose of the camera, changes a little."""
    kind, i, size = CHANGES[what]
    d = np.array([d2, 0.0])
    u = np.stack(np.meshgrid(np.linspace(20, 620, 13), np.linspace(20, 460, 10)), -1).reshape(-1, 2)
    p = depth * np.column_stack([(u - K[:2]) / K[2:], np.ones(len(u))])
    before, U_p, U_k, U_d = pin_hole(p, K, d)
    if kind == "s":
        change = _pose_change(i, size).to_frame(p)[0] - p
        step = (U_p @ change[..., None])[..., 0]
    else:
        step = size * (U_k if kind == "k" else U_d)[..., i]
    fig, ax = plt.subplots(figsize=(9.6, 6.2), layout="constrained")
    ax.plot(*before.T, marker="o", color=GREY, markersize=4, linestyle="none")
    ax.quiver(*before.T, *step.T, color=BLUE, angles="xy", scale_units="xy", scale=1, width=0.004, zorder=4)
    picture_axes(ax, 25, f"{what}: arrows show the motion of the pixels")
    length = np.linalg.norm(step, axis=1)
    r = np.linalg.norm(u - K[:2], axis=1)
    middle, edge = float(length[np.argmin(r)]), float(length[np.argmax(r)])
    caption = (
        f"{what}, points {depth:.0f} m ahead, first order: they move by {middle:.1f} px next to the centre of the "
        f"image and by {edge:.1f} px in its corner."
    )
    return fig, {"middle": middle, "edge": edge, "caption": caption}


@explorable(
    u=Int(440, 0, 640, 20, "pixel column u", "px"),
    v=Int(180, 0, 480, 20, "pixel row v", "px"),
    s=Float(3.0, 1.0, 5.0, 0.25, "prior of the depth, mean", "m"),
    s_std=Float(0.5, 0.0, 1.0, 0.05, "prior of the depth, 1 sigma", "m"),
    noise=Float(5.0, 1.0, 20.0, 1.0, "noise of a pixel, 1 sigma", "px"),
    ranges={"along": (0, 5), "across": (0, 2)},
)
def ray(u, v, s, s_std, noise):
    """A pixel, its ray, and the point that a prior of the depth makes of it."""
    k, c = NARROW, correction((-0.1,), k=NARROW)
    p, P_u, P_s, _, _ = inv_pin_hole(np.array([u, v], float), np.array([s]), k, c)
    P = noise**2 * P_u @ P_u.T + s_std**2 * P_s @ P_s.T
    Sf = Frame3(FORWARD)
    l, _, L_p = Sf.from_frame(p)
    L, direction = L_p @ P @ L_p.T, P_s[:, 0]
    fig, ax = plt.subplots(figsize=(11, 5.6), layout="constrained")
    space = Space(ax, ((-1.6, 6.2), (-1.1, 2.7)), azim=-112, elev=22)
    space.ground(5)
    space.robot(Frame3(np.eye(7)[3]), 0.35)
    eye = Sf.t
    border = np.array([[0, 0], [640, 0], [640, 480], [0, 480], [0, 0]], float)
    rim = Sf.from_frame(inv_pin_hole(border, np.full((5, 1), 0.5), k, c)[0])[0]
    space.line(rim, color=BLACK, linewidth=1.8, label="image, drawn 0.5 m ahead")
    space.curves(np.stack([np.broadcast_to(eye, (4, 3)), rim[:4]], 1), color=GREY, linewidth=1)
    far = Sf.from_frame(7 * direction)[0]
    space.line([eye, far], color=ORANGE, linestyle=":", linewidth=2.6, label="ray of the pixel")
    space.line(
        Sf.from_frame(0.5 * direction)[0], **points(MEASUREMENT, markersize=13, markeredgewidth=3), label="pixel"
    )
    space.ellipsoid(l, L + 1e-12 * np.eye(3), 3, color=BLUE, linewidth=1.3, label=sigma_label(3, 3))
    space.line(l, **points(ESTIMATE, markersize=8), label="point at the mean of the prior")
    ax.legend(loc="upper left", frameon=False)
    m = direction / np.linalg.norm(direction)
    along = float(np.sqrt(max(m @ P @ m, 0)))
    across = float(np.sqrt(max(np.trace(P) - m @ P @ m, 0) / 2))
    caption = (
        f"Point at ({', '.join(f'{c + 0.0:.2f}' for c in l.round(6))}) m. 1 sigma along the ray {along:.2f} m, from "
        f"the prior of the depth; across it {across:.3f} m, from the noise of the pixel. Its depth has the sigma "
        f"{np.sqrt(P[2, 2]):.2f} m: the prior's, whatever the pixel."
    )
    return fig, {"along": along, "across": across, "caption": caption}


@explorable(
    views=Int(10, 1, 20, label="views of the board", play=500),
    part=Float(0.3, 0.2, 1.0, 0.1, "part of the image that the board fills"),
    noise=Choice(0.5, {"0.1 px": 0.1, "0.5 px": 0.5, "2 px": 2.0}, label="noise of a pixel, sigma"),
    n_d=Choice(2, {"none": 0, "d2": 1, "d2, d4": 2, "d2, d4, d6": 3}, label="distortion in the filter"),
    seed=Int(0, 0, 9, label="noise number"),
    ranges={"corner": (0, 1e4), "nis": (0, 1e6)},
)
def calibration(calibrate, views, part, noise, n_d, seed):
    """An EKF whose state is k and d: what it has learnt, and what it says about the parts that it has not seen."""
    c = calibrate(views, part, noise, n_d, seed)
    r = np.linspace(0, 1.2, 100)
    error, sigma = model_error(c, r)
    fig, (im, ax) = plt.subplots(1, 2, figsize=(12.4, 4.9), width_ratios=(1, 1.15))
    fig.subplots_adjust(left=0.06, right=0.98, bottom=0.13, top=0.92, wspace=0.22)  # quicker than a layout engine
    im.plot(*c.pixels.T, **points(MEASUREMENT, markersize=8), label="corners of the board")
    scale = 20 / max(noise, 1e-9)
    im.quiver(*c.pixels.T, *(scale * c.residuals).T, color=BLUE, angles="xy", scale_units="xy", scale=1, width=0.004)
    picture_axes(im, 0, f"last view; arrows: residuals, {scale:.0f} times")
    covered = 1.25 * part
    ax.axvspan(0, min(covered, 1.2), color=GREEN, alpha=0.16, linewidth=0, label="board was here")
    ax.fill_between(r, -2 * sigma, 2 * sigma, color=BLUE, alpha=0.25, linewidth=0, label="2σ of the filter")
    ax.plot(r, 2 * sigma, color=BLUE, linewidth=1)
    ax.plot(r, -2 * sigma, color=BLUE, linewidth=1)
    ax.plot(r, error, color=BLACK, linewidth=2.6, linestyle="--", label="error of the model")
    top = 10.0 ** np.ceil(np.log10(max(2.2 * sigma.max(), 1.1 * np.abs(error).max(), 0.3)))
    ax.set(xlim=(0, 1.2), xlabel="radius along the diagonal (-)", ylabel="error of a pixel (px)")
    ax.set_ylim(-top / (2 if 2 * max(2 * sigma.max(), np.abs(error).max()) < top else 1) * 1.05, None)
    low = ax.get_ylim()[0]
    ax.set_ylim(low, -low)
    ax.locator_params(nbins=5)
    ax.legend(loc="upper left", ncols=2, fontsize=11)
    n = 4 + n_d
    std = np.sqrt(np.diag(c.P))
    words = ", ".join(f"{NAMES[i]} {c.x[i]:.3g} ± {std[i]:.1g}" for i in (2, *range(4, n)))
    honest = "honest is 1" if abs(c.nis - 1) < 0.15 else "honest is 1: the model does not fit the lens"
    caption = (
        f"After {views} view{'s' * (views != 1)}: {words} (1 sigma). At radius 1.2 the model is off by "
        f"{abs(error[-1]):.2g} px, its 2 sigma is {2 * sigma[-1]:.2g} px. NIS per number {c.nis:.3g}; {honest}."
    )
    return fig, {"corner": float(abs(error[-1])), "nis": c.nis, "caption": caption}
