"""Drawings of notebook 13: a ray, two Gaussians for one depth, anchors, and landmarks that become points."""

from statistics import NormalDist

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.patches import Rectangle

from ...graphics import ESTIMATE, TRUTH, points
from ...graphics.style import BLACK, BLUE, GREEN, GREY, ORANGE, VERMILLION
from ...models.landmarks import IdpPnt
from ...models.landmarks.projective import linearity
from ...models.sensors import PinHole
from ..controls import Choice, Float, Int
from ..widgets import explorable
from .nb13_runs import (
    DEPTH,
    DEPTH_STD,
    FORWARD,
    FRAMES,
    RHO,
    RHO_STD,
    births,
    one_point,
)

__all__ = ["DEPTH", "DEPTH_STD", "FORWARD", "FRAMES", "RHO", "RHO_STD"]

GATE = NormalDist().inv_cdf(0.995)  # of one number, in sigmas: 99 % lie within it
SHOWN = 3000  # points that are drawn, of all that are counted


# ---- figures of the notebook ----------------------------------------------------------------------------------------


def outside(error, var):
    """Share of errors outside the 99 % gate of one number."""
    return float(np.mean(np.asarray(error) ** 2 / np.asarray(var) > GATE**2))


def gate_figure(d, x, P, rho, P_rho):
    """Error over sigma against the true depth, for both filters. Returns (fig, caption)."""
    fig, axes = plt.subplots(1, 2, figsize=(12, 4.9), sharey=True, layout="constrained")
    cases = (("Gaussian in depth", (x - d) / np.sqrt(P)), ("Gaussian in inverse depth", (rho - 1 / d) / np.sqrt(P_rho)))
    shares = []
    for ax, (name, n) in zip(axes, cases, strict=True):
        out = np.abs(n) > GATE
        shares.append(100 * np.mean(out))
        shown = np.clip(n, -11.5, 11.5)
        ax.axhspan(-GATE, GATE, color=GREEN, alpha=0.2, linewidth=0, label="99 % gate")
        some = slice(0, SHOWN)
        inside = ~out[some]
        ax.plot(d[some][inside], shown[some][inside], ".", color=BLUE, markersize=3, label="inside")
        ax.plot(d[some][~inside], shown[some][~inside], "x", color=VERMILLION, markersize=4, label="outside")
        ax.set(xscale="log", xlabel="true depth (m)", ylim=(-12, 12), title=f"{name}: {shares[-1]:.0f} % outside")
        ax.set_xticks([2, 5, 10, 20, 50, 100], ["2", "5", "10", "20", "50", "100"])
        ax.minorticks_off()
    axes[0].set_ylabel("error / sigma of the filter (-)")
    axes[1].legend(loc="upper right", markerscale=3)
    return fig, (
        f"{len(d)} points, {FRAMES} angles each. Outside the 99 % gate: {shares[0]:.0f} % of the runs with a Gaussian "
        f"in depth, {shares[1]:.1f} % with a Gaussian in inverse depth. "
        f"Drawn: {min(SHOWN, len(d))} of them; errors beyond 12 sigma at the edge."
    )


def chain(F, S, l, P_ll, jacobians):
    """Both frames, ray and prior from above, and the Jacobians of the landmark. Returns (fig, caption)."""
    fig = plt.figure(figsize=(12.4, 5.0), layout="constrained")
    left, right = fig.subfigures(1, 2, width_ratios=(1, 1.35), squeeze=False)[0]
    ax = left.subplots()
    C = F.compose(S)[0]
    p, P_l = IdpPnt().point(l)
    std = np.sqrt(P_ll[5, 5])
    m = (p - l[:3]) * l[5]
    near, far = (l[:3] + m / (l[5] + k * std) for k in (2, -1.5))
    ax.plot(*np.transpose([near, far])[:2], color=ORANGE, linewidth=8, alpha=0.5, label="prior of ρ: +2σ to -1.5σ")
    ax.plot(*np.transpose([l[:3], far])[:2], color=GREY, linestyle=":", label="ray of the pixel")
    for G, name, look, down in ((F, "robot F", (0, 1), -14), (C, "camera F S", (2, 0), 12)):
        for k, color in zip(look, (VERMILLION, GREEN), strict=True):
            tip = G.t + 0.9 * G.R[:, k]
            ax.annotate("", tip[:2], G.t[:2], arrowprops={"arrowstyle": "-|>", "color": color, "linewidth": 2.2})
        ax.annotate(name, G.t[:2], (-8, down), textcoords="offset points", fontsize=12, ha="right")
    ax.plot(*l[:2], marker="s", color=BLACK, markersize=6, linestyle="none", label="anchor: where the camera is")
    ax.plot(*p[:2], **points(ESTIMATE, markersize=9), label="landmark at the mean of the prior")
    ax.set(xlabel="x (m)", ylabel="y (m)", aspect="equal", xlim=(-1.5, 8.5), ylim=(-3.6, 3.6))
    ax.legend(loc="upper left", fontsize=10)
    rows = ["x", "y", "z", "pitch", "yaw", "ρ"]
    names = (["x", "y", "z", "a", "b", "c", "d"], ["x", "y", "z", "a", "b", "c", "d"], ["u", "v"], ["ρ"])
    axes = right.subplots(1, 4, width_ratios=[J.shape[1] for J in jacobians], sharey=True)
    for ax, J, title, columns in zip(axes, jacobians, ("$L_F$", "$L_S$", "$L_y$", "$L_n$"), names, strict=True):
        shown = J / np.maximum(np.abs(J).max(), 1e-12)
        ax.imshow(shown, cmap="PuOr_r", vmin=-1, vmax=1, aspect="auto")
        ax.set_xticks(range(J.shape[1]), columns)
        ax.set_yticks(range(6), rows)
        ax.set_title(title)
        ax.tick_params(length=0)
        ax.grid(False)
    depth = [1 / (l[5] + k * std) for k in (2, -1.5)]
    return fig, (
        f"Left, from above: robot and camera, the ray, and the prior: {depth[0]:.1f} m to {depth[1]:.1f} m. Red "
        f"arrows look ahead. Right: the four Jacobians, each on its own scale, white is zero. The pixel moves pitch "
        f"and yaw only, the prior moves ρ only; both frames move the anchor and the angles, and none of them moves ρ."
    )


# ---- widgets --------------------------------------------------------------------------------------------------------


@explorable(
    u=Int(420, 0, 640, 20, "pixel column u", "px"),
    mean=Float(0.25, 0.02, 0.6, 0.02, "prior of rho, mean", "1/m"),
    std=Float(0.12, 0.01, 0.3, 0.01, "prior of rho, 1 sigma", "1/m"),
    base=Float(1.0, 0.0, 3.0, 0.25, "second camera to the right", "m"),
    ranges={"near": (0, 100), "pixels": (0, 1e5)},
)
def ray(u, mean, std, base):
    """A pixel, its ray and the band of the prior; and where a second camera would look for it."""
    camera = PinHole()
    v = camera.retro(np.array([float(u), 240.0]))[0]
    m = v / np.linalg.norm(v)
    x, z = m[0], m[2]
    rho = np.array([mean + 2 * std, mean, mean - 2 * std])
    s = 1 / np.maximum(rho, 1e-6)  # at or beyond infinity: far away
    p = np.outer(s, m)
    other = camera.project(p - [base, 0, 0])[0][:, 0]

    fig, (ax, im) = plt.subplots(2, 1, figsize=(11, 5.8), height_ratios=(4.2, 1), layout="constrained")
    reach = 24.0
    shown = np.clip(s, 0, 3 * reach)
    ax.plot([0, 3 * reach * z], [0, 3 * reach * x], color=GREY, linestyle=":", label="ray of the pixel")
    ax.plot(shown[[0, 2]] * z, shown[[0, 2]] * x, color=ORANGE, linewidth=8, alpha=0.5, label="prior, 2σ")
    ax.plot(s[1] * z, s[1] * x, **points(ESTIMATE, markersize=9), label="at the mean of the prior")
    for place, name in ((0, "camera"), (base, "second camera")):
        ax.plot(0, place, marker=">", color=BLACK, markersize=12, linestyle="none")
        off = (-12, 4 if place == 0 else -14)
        ax.annotate(name, (0, place), off, textcoords="offset points", fontsize=12, ha="right")
    ax.set(xlim=(-5.5, reach), ylim=(-9, 9), xlabel="ahead (m)", ylabel="to the right (m)")
    ax.invert_yaxis()
    ax.legend(loc="upper right", ncols=3)
    low, high = np.clip(np.sort(other[[0, 2]]), -2000, 2000)
    im.plot([low, high], [0, 0], color=ORANGE, linewidth=8, alpha=0.5)
    im.plot(other[1], 0, **points(ESTIMATE, markersize=9))
    im.axvspan(0, 640, color=GREY, alpha=0.15, linewidth=0)
    im.set(xlim=(-200, 840), ylim=(-1, 1), yticks=[], xlabel="column in the second picture (px); grey: the picture")
    im.grid(False)
    far = f"{s[2]:.1f} m" if rho[2] > 0.001 else "infinity"
    width = float(abs(other[0] - other[2]))
    where = (
        f"The second camera must look for it along {width:.0f} columns."
        if base > 0
        else "A camera at the same place sees all of it in one pixel: it learns nothing about the distance."
    )
    return fig, {
        "near": float(s[0]),
        "pixels": width,
        "caption": f"The pixel fixes the ray. The prior puts the point between {s[0]:.1f} m and {far} (2σ). {where}",
    }


@explorable(
    d=Float(20.0, 2.0, 100.0, 1.0, "true depth", "m"),
    base=Float(0.05, 0.05, 5.0, 0.05, "way of the camera to the side", "m"),
    noise=Choice(0.1, {"0.02°": 0.02, "0.1°": 0.1, "0.5°": 0.5}, label="noise of an angle, sigma"),
    seed=Int(0, 0, 9, label="noise number"),
    ranges={"nees_depth": (0, 1e9), "nees_rho": (0, 60), "linearity": (0, 1e9)},
)
def posterior(d, base, noise, seed):
    """What is known of one depth after 20 angles: exactly, with a Gaussian in depth, and in inverse depth."""
    (x, P), (rho, V), grid, log_p = one_point(d, base / FRAMES, FRAMES, np.radians(noise), seed)
    sx, sr = np.sqrt(P), np.sqrt(V)
    curves = (
        (log_p, BLACK, "--", "exact"),
        (np.log(grid) - (grid - x) ** 2 / (2 * P), VERMILLION, "-.", "Gaussian in depth"),
        (-np.log(grid) - (1 / grid - rho) ** 2 / (2 * V), BLUE, "-", "Gaussian in inverse depth"),
    )
    fig, ax = plt.subplots(figsize=(11, 4.7), layout="constrained")
    for y, color, dash, name in curves:
        y = np.exp(y - np.max(y))
        ax.plot(grid, y, color=color, linestyle=dash, linewidth=2.4, label=name)
        ax.fill_between(grid, 0, y, color=color, alpha=0.1, linewidth=0)
    ax.plot([d, d], [0, 1.08], color=BLACK, linewidth=1)
    ax.plot(d, 1.08, **points(TRUTH, markersize=13), label="true depth")
    ax.set(xscale="log", xlim=(1, 1000), ylim=(0, 1.35), yticks=[], xlabel="depth (m)")
    ax.set_ylabel("density over log depth,\nscaled to height 1")
    ax.set_xticks([1, 2, 5, 10, 20, 50, 100, 1000], ["1", "2", "5", "10", "20", "50", "100", "1000"])
    ax.minorticks_off()
    ax.legend(loc="upper center", ncols=4, fontsize=11)
    n_depth, n_rho = (x - d) ** 2 / P, (rho - 1 / d) ** 2 / V
    safe = max(abs(rho), 1e-3)
    L = float(linearity(np.zeros(2), np.array([1.0, 0.0]), safe, V, np.array([0.0, base])))
    verdict = "three Euclidean numbers will do" if L < 0.1 else "too early for a Euclidean point"
    bound = 1 / (rho - 2 * sr) if rho > 2 * sr else np.inf
    far = f"{bound:.3g} m" if np.isfinite(bound) else "infinity"
    caption = (
        f"True depth {d:.0f} m. In depth: {x:.3g} m, 2σ {2 * sx:.2g} m, NEES {n_depth:.2g}. In inverse depth: "
        f"{1 / (rho + 2 * sr):.3g} m to {far} (2σ), NEES {n_rho:.2g}. Honest is about 1, the 99 % gate is "
        f"{GATE**2:.1f}. Linearity index {L:.2g}: {verdict}."
    )
    return fig, {"nees_depth": n_depth, "nees_rho": n_rho, "linearity": L, "caption": caption}


@explorable(
    count=Int(3, 1, 5, label="landmarks born"),
    moved=Float(0.0, 0.0, 3.0, 0.25, "drive between two births", "m"),
    ranges={"anchors": (0, 1.000001)},
)
def anchors(count, moved):
    """Correlations after the birth of some inverse-depth landmarks: their anchors are the camera."""
    map, ranges = births(count, moved)
    keep = np.concatenate([np.arange(3), *(np.arange(r.start, r.stop) for r in ranges[1:])])
    P = map.P[np.ix_(keep, keep)]
    sigma = np.sqrt(np.diag(P))
    C = P / np.outer(sigma, sigma)
    fig, ax = plt.subplots(figsize=(8.6, 6.3), layout="constrained")
    picture = ax.imshow(C, cmap="PuOr_r", vmin=-1, vmax=1)
    fig.colorbar(picture, ax=ax, label="correlation (-)", shrink=0.85)
    edges = [0, 3, *(3 + 6 * (i + 1) for i in range(count))]
    for e in edges[1:-1]:
        ax.axhline(e - 0.5, color=BLACK, linewidth=1)
        ax.axvline(e - 0.5, color=BLACK, linewidth=1)
    for i in range(count):
        for j in (0, *(3 + 6 * k for k in range(count))):
            if j != 3 + 6 * i:
                ax.add_patch(Rectangle((j - 0.5, 2.5 + 6 * i), 3, 3, fill=False, edgecolor=GREEN, linewidth=3))
    middle = [(a + b - 1) / 2 for a, b in zip(edges[:-1], edges[1:], strict=True)]
    names = ["camera\nx y z", *(f"landmark {i + 1}" for i in range(count))]
    ax.set_xticks(middle, names)
    ax.set_yticks(middle, names)
    ax.tick_params(length=0)
    ax.grid(False)
    first, last = 3, 3 + 6 * (count - 1)
    c_camera = float(np.diag(C[:3, last : last + 3]).min())
    says = f"the anchor of the last one and the camera {c_camera:.2f}"
    c = c_camera
    if count > 1:
        c = float(np.diag(C[first : first + 3, last : last + 3]).min())
        says = f"the anchors of the first and the last {c:.2f}, {says}"
    caption = (
        f"{count} landmarks, {moved:.2f} m between two births. Correlation on each axis, at the end: {says}. "
        "Green frames: the blocks of the anchors."
    )
    return fig, {"anchors": c, "caption": caption}
