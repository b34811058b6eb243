"""Drawings of notebook 24: patches, correlations, search ellipses in images, and the map that grows beside them."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.patches import Rectangle
from numpy.lib.stride_tricks import sliding_window_view

from ...analysis import nees
from ...geometry import Frame3
from ...graphics import ESTIMATE, MEASUREMENT, PREDICTED, TRUTH, line, plot_ellipse, points, sigma_label
from ...graphics.style import BLUE, GREEN, GREY, ORANGE, PURPLE, VERMILLION, Style
from ...models.landmarks import EucPnt, IdpPnt
from ..controls import Float
from ..logs.nb24 import CAMERA, FPS, film, given
from ..widgets import explorable

__all__ = ["CAMERA", "FPS", "film", "given"]

H = 5
KINDS = {6: IdpPnt(), 3: EucPnt(3)}
LOOKS: dict[str, Style] = {
    "used": dict(color=GREEN, linestyle="-", linewidth=1.8),
    "refused": dict(color=VERMILLION, linestyle="-", linewidth=2.4),
    "not found": dict(color=PURPLE, linestyle=":", linewidth=2.0),
}


def picture(ax, image, title=""):
    """Show an image with its axes in pixels."""
    rows, columns = image.shape
    few = np.round(np.asarray(image, float) / 28) * 28  # fewer greys make a smaller file
    ax.imshow(few, cmap="gray", vmin=0, vmax=255, interpolation="nearest")
    ax.set(xlabel="u (px)", ylabel="v (px)", xlim=(-0.5, columns - 0.5), ylim=(rows - 0.5, -0.5))
    ax.set_title(title, loc="left")
    ax.grid(False)


def patch_figure(image, y, patch):
    """An image, and one patch of it with its grey values. Returns (fig, caption)."""
    h, (u, v) = len(patch) // 2, np.rint(y)
    fig, (left, right) = plt.subplots(1, 2, figsize=(10.5, 4.4), layout="constrained", width_ratios=(1.35, 1))
    picture(left, image, "what the camera hands over")
    left.add_patch(
        Rectangle((u - h - 0.5, v - h - 0.5), 2 * h + 1, 2 * h + 1, fill=False, edgecolor=ORANGE, linewidth=2.5)
    )
    right.imshow(patch, cmap="gray", vmin=0, vmax=255, extent=(u - h - 0.5, u + h + 0.5, v + h + 0.5, v - h - 0.5))
    for i, row in enumerate(patch):
        for j, grey in enumerate(row):
            color = "white" if grey < 110 else "black"
            right.text(u - h + j, v - h + i, f"{grey:.0f}", ha="center", va="center", fontsize=9, color=color)
    right.set(xlabel="u (px)", ylabel="v (px)")
    right.set_title("the patch: all that the filter remembers of it", loc="left")
    right.grid(False)
    return fig, (
        f"An image of {image.shape[1]} x {image.shape[0]} pixels, and the patch of {len(patch)} x {len(patch)} around "
        f"[{u:.0f}, {v:.0f}]: mean {patch.mean():.0f}, contrast {patch.std():.0f}."
    )


def everywhere_figure(image, scores, y, e, S):
    """Correlation of a patch with every place of an image, and the ellipse where the filter expects it.

    scores, shape (rows - 2 H, columns - 2 H). Returns (fig, caption).
    """
    v, u = np.nonzero(scores > 0.8)
    z = np.column_stack([u, v]) + H - e
    near = np.einsum("ni,ij,nj->n", z, np.linalg.inv(S), z) <= 9
    fig, (left, right) = plt.subplots(1, 2, figsize=(11, 4.3), layout="constrained", sharex=True, sharey=True)
    rows, columns = image.shape
    shown = right.imshow(
        np.round(scores, 1),
        cmap="PuOr_r",
        vmin=-1,
        vmax=1,
        extent=(H - 0.5, columns - H - 0.5, rows - H - 0.5, H - 0.5),
    )
    fig.colorbar(shown, ax=right, label="correlation with the patch (-)", shrink=0.9)
    picture(left, image, "image 10")
    left.plot(u[~near] + H, v[~near] + H, "x", color=VERMILLION, markersize=10, markeredgewidth=2.2,
              label="correlation above 0.8: another place")  # fmt: skip
    left.plot(u[near] + H, v[near] + H, **points(MEASUREMENT, markersize=11), label="correlation above 0.8: the corner")
    for ax in (left, right):
        plot_ellipse(ax, e, S, 3, **line(PREDICTED, linewidth=2.2), label=f"expected, {sigma_label(3)}")
    right.set(xlabel="u (px)")
    right.set_title("the same patch, at every place", loc="left")
    right.grid(False)
    fig.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    inside = np.pi * 9 * np.sqrt(np.linalg.det(S))
    return fig, (
        f"Of {scores.size} places {len(u)} have a correlation above 0.8: {near.sum()} of them inside the 3-sigma "
        f"ellipse, {(~near).sum()} elsewhere. The ellipse holds about {inside:.0f} pixels, "
        f"{100 * inside / scores.size:.1f} % of the image."
    )


@explorable(
    du=Float(0.0, -12.0, 12.0, 1.0, "expectation, off along u", "px"),
    sigma=Float(3.0, 1.0, 6.0, 0.5, "sigma of the expectation", "px"),
    gain=Float(1.0, 0.2, 2.0, 0.1, "gain of the light"),
    offset=Float(0.0, -60.0, 60.0, 10.0, "offset of the light"),
    ranges={"score": (-1, 1.0001), "off": (0, 60), "looked": (1, 2000)},
)
def search(image, patch, y, ncc, inside, du, sigma, gain, offset):
    """Look for a patch in an image whose light has changed, inside the ellipse of an expectation that is off."""
    other = np.clip(gain * image.astype(float) + offset, 0, 255)
    e, S = y + [du, 0.0], sigma**2 * np.array([[1.0, 0.4], [0.4, 1.0]])
    low, high = (
        np.maximum(np.ceil(e - 3 * sigma), H),
        np.minimum(np.floor(e + 3 * sigma), np.array(image.shape[::-1]) - 1 - H),
    )
    u, v = (a.astype(int) for a in np.meshgrid(np.arange(low[0], high[0] + 1), np.arange(low[1], high[1] + 1)))
    pixels = np.column_stack([u.ravel(), v.ravel()])
    views = sliding_window_view(other, (2 * H + 1, 2 * H + 1))[pixels[:, 1] - H, pixels[:, 0] - H]
    within = np.asarray(inside(pixels, e, S, 3), bool)
    score = np.where(within, ncc(patch, views), np.nan)
    best = pixels[np.nanargmax(score)]
    fig, (left, middle, right) = plt.subplots(
        1, 3, figsize=(11.5, 4.2), layout="constrained", width_ratios=(1.3, 0.8, 1)
    )
    picture(left, other, "image 10, in this light")
    plot_ellipse(left, e, S, 3, **line(PREDICTED, linewidth=2), label=f"expected, {sigma_label(3)}")
    left.plot(*y, **points(TRUTH, markersize=14, markeredgewidth=1.5), label="the corner")
    left.plot(*best, **points(MEASUREMENT, markersize=13), label="best match")
    middle.imshow(patch, cmap="gray", vmin=0, vmax=255)
    middle.set(xticks=[], yticks=[])
    middle.set_title("patch, from image 0", loc="left")
    extent = (u.min() - 0.5, u.max() + 0.5, v.max() + 0.5, v.min() - 0.5)
    shown = right.imshow(score.reshape(u.shape), cmap="PuOr_r", vmin=-1, vmax=1, extent=extent)
    fig.colorbar(shown, ax=right, label="correlation (-)", shrink=0.8)
    right.plot(*best, **points(MEASUREMENT, markersize=13))
    right.set(xlabel="u (px)", ylabel="v (px)")
    right.set_title("inside the ellipse", loc="left")
    for ax in (middle, right):
        ax.grid(False)
    fig.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    top, off = float(np.nanmax(score)), float(np.linalg.norm(best - y))
    said = "found" if top > 0.8 and off < 3 else "a wrong match" if top > 0.8 else "not found"
    return fig, {
        "score": top,
        "off": off,
        "looked": int(within.sum()),
        "caption": f"{within.sum()} pixels are looked at. The best has a correlation of {top:.2f}, {off:.0f} px from "
        f"the corner: with a threshold of 0.8, {said}.",
    }


def corners_figure(image, where, scores, corners):
    """How good a corner each place is, and the best ones. Returns (fig, caption)."""
    fig, (left, right) = plt.subplots(1, 2, figsize=(11, 4.2), layout="constrained", sharex=True, sharey=True)
    picture(left, image, f"the {len(corners)} best corners")
    left.plot(*np.array(corners).T, **points(MEASUREMENT, markersize=14))
    dots = right.scatter(*where.T, c=np.log10(np.maximum(scores, 1.0)), s=9, marker="s", cmap="viridis")
    fig.colorbar(dots, ax=right, label="log10 of the smaller eigenvalue", shrink=0.9)
    right.set(xlabel="u (px)", aspect="equal")
    right.set_title("both slopes must be there", loc="left")
    right.grid(False)
    share = np.mean(scores > 0.1 * scores.max())
    return (
        fig,
        f"{len(corners)} corners, 10 px or more apart. {100 * share:.1f} % of the places have a tenth of the best "
        "score.",
    )


# ---- runs -----------------------------------------------------------------------------------------------------------


def strip_figure(film, frames, at):
    """Three images of a run: what was looked for, found, refused, not found. Returns (fig, caption)."""
    fig, axes = plt.subplots(1, len(at), figsize=(3.6 * len(at), 3.7), layout="constrained")
    words = []
    for ax, k in zip(axes, at, strict=True):
        picture(ax, film.frames[k], f"image {k}")
        looked = frames[k].looked
        for state, look in LOOKS.items():
            mine = [(e, S, y) for _, e, S, y, s in looked if s == state]
            if mine:
                e, S, y = (np.array(a) for a in zip(*mine, strict=True))
                plot_ellipse(ax, e, S, 3, **look)
                if state != "not found":
                    mark = points(MEASUREMENT, markersize=8) if state == "used" else dict(
                        marker="x", color=VERMILLION, markersize=11, markeredgewidth=2.5, linestyle="none")  # fmt: skip
                    ax.plot(*y.T, **mark)
        count = [sum(s == state for *_, s in looked) for state in LOOKS]
        words.append(f"image {k}: {count[0]} used, {count[1]} refused, {count[2]} not found")
    handles = [axes[0].plot([], [], **look)[0] for look in LOOKS.values()]
    names = ["found and used", "found, refused", "not found"]
    fig.legend(handles, [f"{n}, {sigma_label(3)}" for n in names], loc="outside lower center", ncols=len(at))
    return fig, "; ".join(words).capitalize() + "."


def measured(film, frames):
    """Position error (mm), its 3 sigma (mm) and NEES, for each image of a run: shape (frames, 3)."""
    rows = []
    for now, true in zip(frames, film.truth[1], strict=True):
        e = now.x[:3] - true[:3]
        sigma = np.sqrt(np.trace(now.P[:3, :3]))
        honest = nees(Frame3(now.x[:7]), now.P[:7, :7], Frame3(true)) if now.k else np.nan
        rows.append((1000 * np.linalg.norm(e), 3000 * sigma, honest))
    return np.array(rows)


def scale(film, now):
    """How large the estimated map is: the median, over the landmarks, of estimated over true distance to the start."""
    ratios = []
    for id, r in now.lmks.items():
        true = film.corners[id - 1] if now.born[id] is None else film.truths(0, now.born[id])[0][0]
        ratios.append(np.linalg.norm(KINDS[r.stop - r.start].point(now.x[r])[0]) / np.linalg.norm(true))
    return float(np.nanmedian(ratios))


def errors_figure(film, runs, mark=None):
    """Errors of the position over the images, for some runs {name: frames}. Returns (fig, caption)."""
    fig, ax = plt.subplots(figsize=(10.5, 4.2), layout="constrained")
    looks = (BLUE, "-"), (VERMILLION, "--"), (PURPLE, ":"), (GREEN, "-.")
    words = []
    for (name, frames), (color, dash) in zip(runs.items(), looks, strict=False):
        rows, k = measured(film, frames), np.arange(1, len(frames))
        ax.semilogy(k, rows[1:, 0], color=color, linestyle=dash, linewidth=2.6, label=f"{name}: error")
        ax.semilogy(k, rows[1:, 1], color=color, linestyle=dash, linewidth=1.0, label=f"{name}: 3σ of the filter")
        words.append(
            f"{name}: {rows[-15:, 0].mean():.0f} mm in the last second, mean NEES {np.nanmean(rows[:, 2]):.1f}"
        )
    if mark is not None:
        ax.axvline(mark, color=GREY, linewidth=1.5)
    ax.set(xlabel="image (15 in a second)", ylabel="position of the camera (mm)")
    low, high = ax.get_ylim()
    ticks = [t for t in (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000) if low < t < high]
    ax.set_yticks(ticks, [f"{t}" for t in ticks])
    ax.minorticks_off()
    ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
    return fig, "; ".join(words) + " (honest 6)."


def above_figure(film, runs):
    """The maps of some runs from above, each beside the truth. Returns (fig, caption)."""
    fig, axes = plt.subplots(1, len(runs), figsize=(12, 4.4), layout="constrained", sharex=True, sharey=True)
    words = []
    for ax, (name, frames) in zip(axes, runs.items(), strict=True):
        now = frames[-1]
        true = [film.corners[id - 1] if y is None else film.truths(0, y)[0][0] for id, y in now.born.items()]
        ax.plot(
            *np.array(true)[:, [0, 2]].T, **points(TRUTH, markersize=9, markeredgewidth=1.0), label="landmarks, true"
        )
        p = np.array([KINDS[r.stop - r.start].point(now.x[r])[0] for r in now.lmks.values()])
        ax.plot(*p[:, [0, 2]].T, **points(ESTIMATE, markersize=6), label="estimate")
        ax.plot(*film.truth[1][:, [0, 2]].T, **line(TRUTH, linewidth=1.5), label="path, true")
        ax.plot(*np.array([f.x[[0, 2]] for f in frames]).T, **line(ESTIMATE, linewidth=2), label="path, estimate")
        s = scale(film, now)
        ax.set(xlabel="x (m)", xlim=(-1.7, 2.1), ylim=(-0.4, 2.4), aspect="equal")
        ax.set_title(f"{name}:\nscale {s:.2f}", loc="left")
        words.append(f"{name}: scale {s:.2f}, mean NIS {np.mean([f.nis for f in frames[1:]]):.2f}")
    axes[0].set_ylabel("z, ahead (m)")
    fig.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
    return fig, "; ".join(words) + " (NIS over its degrees of freedom)."
