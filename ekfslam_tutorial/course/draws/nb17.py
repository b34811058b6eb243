"""Drawings of notebook 17: three ways to a NEES in space, the stored Monte Carlo, four anonymous landmark types."""

from dataclasses import dataclass
from functools import cache
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from scipy.stats import chi2

from ... import __file__ as package_file
from ...analysis import anees_band
from ...graphics import MapFig, SenFig, grab, side_by_side
from ...graphics.style import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, SKY_BLUE, VERMILLION
from .. import figures
from ..controls import Choice, Float, Toggle
from ..widgets import explorable

DOF = 6
SIZE = 9.0, 6.6  # of map figure and sensor figure, inches
FRAMES, RUNS = 100, 25  # of the stored series
EVERY = 2  # frames that are stored: each second one
KINDS = {
    "euc_depth": "eucPnt, depth guessed",
    "hmg": "hmgPnt",
    "ahm": "ahmPnt",
    "idp": "idpPnt",
    "idp_euc": "idpPnt, later eucPnt",
    "euc_camera": "eucPnt, depth camera",
}
ODOMETRY = {"good": "3 mm, 0.03° a step", "poor": "10 mm, 0.1° a step"}
LOOK = {
    "euc_depth": (VERMILLION, "x"),
    "hmg": (ORANGE, "s"),
    "ahm": (BLUE, "o"),
    "idp": (SKY_BLUE, "^"),
    "idp_euc": (PURPLE, "v"),
    "euc_camera": (GREEN, "D"),
}
LETTERS = {"A": "idp", "B": "euc_depth", "C": "ahm", "D": "hmg"}


# ---- the stored series ----------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Series:
    """Runs of one kind: NEES of the robot's pose (6 dof), position error (m), numbers in the map.

    Each has the shape (runs, frames); `k` are the numbers of the frames.
    """

    k: np.ndarray
    nees: np.ndarray
    off: np.ndarray
    states: np.ndarray

    @property
    def anees(self):
        """Mean NEES over the runs, for each frame."""
        return self.nees.mean(0)

    @property
    def rms(self):
        """Root of the mean squared position error over the runs, m, for each frame."""
        return np.sqrt((self.off**2).mean(0))


def stored_path():
    """The file of the stored series, in an installed package or in the repository."""
    package = Path(package_file).resolve().parent
    folders = package / "_share" / "data", package.parent / "data"
    return next(folder for folder in folders if folder.is_dir()) / "consistency_3d.npz"


@cache
def stored(kind, odometry="good"):
    """A series of 25 runs from the file that `tools/make_consistency_3d.py` writes.

    Returns
    -------
    Series
    """
    with np.load(stored_path(), allow_pickle=False) as file:
        parts = [file[f"{kind}_{odometry}_{name}"].astype(float) for name in ("nees", "off", "states")]
        return Series(file["k"].astype(int), *parts)


# ---- errors of a pose -----------------------------------------------------------------------------------------------

WAYS = {
    "tangent space": (BLUE, "-"),
    "Euler angles": (ORANGE, ":"),
    "q - q, with a little added to P": (VERMILLION, "--"),
}


@explorable(
    sigma=Float(3.0, 0.5, 30.0, 0.5, "orientation, 1 sigma", "deg"),
    pitch=Float(88.0, 0.0, 88.0, 2.0, "pitch of the robot", "deg"),
    flip=Toggle(False, label="half of the true q with the other sign"),
    added=Choice(1e-9, {"1e-12": 1e-12, "1e-9": 1e-9, "1e-6": 1e-6, "1e-3": 1e-3}, label="added to P for q - q"),
    ranges={"tangent": (3, 12), "subtracted": (0, 1e14), "euler": (0, 1e9)},
)
def ways(honest_poses, pose_nees, euler_nees, subtracted_nees, sigma, pitch, flip, added):
    """1000 honest poses, and their NEES computed in three ways: only one of them is chi-square."""
    x, P, truth = honest_poses(1000, sigma, pitch, flip)
    tangent, euler = pose_nees(x, P, truth), euler_nees(x, P, truth)
    subtracted = subtracted_nees(x, P, truth, added)
    values = dict(zip(WAYS, (tangent, euler, subtracted), strict=True))
    fig, caption = _ways_figure(values)
    return fig, {"tangent": tangent.mean(), "euler": euler.mean(), "subtracted": subtracted.mean(), "caption": caption}


def _ways_figure(values):
    """NEES of honest poses in several ways, {way: (n,)}, beside the chi-square distribution. Returns (fig, caption)."""
    fig, ax = plt.subplots(figsize=(10.5, 4.8), layout="constrained")
    u = np.geomspace(0.3, 1e8, 400)
    ax.plot(u, 100 * chi2.sf(u, DOF), color=BLACK, linewidth=7, alpha=0.25, label="chi-square, 6 dof: honest")
    words = []
    for way, n in values.items():
        color, dash = WAYS[way]
        share = 100 * (1 - (np.arange(len(n)) + 0.5) / len(n))
        ax.plot(np.sort(np.clip(n, 1e-3, 1e9)), share, color=color, linestyle=dash, linewidth=2.6, label=way)
        words.append(f"{way} {_short(np.mean(n))}")
    ax.set(xscale="log", yscale="log", xlim=(0.5, 1e7), ylim=(0.1, 110))
    ax.set(xlabel="NEES (-)", ylabel="share of the poses above (%)")
    ax.set_yticks([0.1, 1, 10, 100], ["0.1", "1", "10", "100"])
    ax.minorticks_off()
    ax.legend(loc="upper right")
    return fig, f"{len(n)} honest poses. Mean NEES, which should be 6: {'; '.join(words)}."


# ---- a run, seen ----------------------------------------------------------------------------------------------------


def two_figures(run, title=""):
    """Map figure and sensor figure of a run, side by side, in its last frame. Returns (fig, caption)."""
    figs, now = [], None
    for now in run:
        if not figs:
            maps = MapFig(now, title=title, labels=False, figsize=SIZE)
            figs = [maps, SenFig(now, labels=False, figsize=SIZE)]
        for fig in figs:
            fig.update(now)
    assert now is not None  # a run has frames
    for fig in figs:
        fig.fig.set_dpi(figures.DPI)
    image = side_by_side([grab(fig.fig) for fig in figs])
    for fig in figs:
        plt.close(fig.fig)
    fig = plt.figure(figsize=(image.shape[1] / figures.DPI, image.shape[0] / figures.DPI))
    ax = fig.add_axes((0, 0, 1, 1))
    ax.imshow(image)
    ax.set_axis_off()
    rob = now.robs[0]
    off = np.linalg.norm(now.map.x[rob.r][:3] - now.truth[rob.id][:3])
    sigma = np.sqrt(np.trace(now.map.P[rob.r, rob.r][:3, :3]))
    used = sum(o.updated for o in now.obs.values())
    return fig, (
        f"{title}, frame {now.k}: {len(now.lmks)} landmarks in the map, {used} pixels used in this frame. The robot is "
        f"off by {100 * off:.1f} cm, and the filter claims {100 * sigma:.1f} cm (1 sigma)."
    )


def _short(n):
    return f"{n:.1f}" if n < 100 else f"{n:.0f}" if n < 1000 else f"{n:.0e}"


# ---- the Monte Carlo ------------------------------------------------------------------------------------------------


def _band(ax, runs, confidence=0.95):
    low, high = anees_band(DOF, runs, confidence)
    ax.axhspan(low, high, color=GREEN, alpha=0.25, linewidth=0)
    return low, high


def _curve(ax, kind, y, k, label=None, **style):
    color, marker = LOOK[kind]
    look = {
        "color": color,
        "marker": marker,
        "markevery": (2 * list(LOOK).index(kind) % 11, 11),
        "markersize": 7,
        "linewidth": 2.2,
        **style,
    }
    ax.plot(k, y, label=label or KINDS[kind], **look)


def nees_figure():
    """Mean NEES over the frames, for all kinds, with good and with poor odometry. Returns (fig, caption)."""
    fig, axes = plt.subplots(1, 2, figsize=(12, 5.2), sharey=True, layout="constrained")
    ends = {}
    for ax, name in zip(axes, ODOMETRY, strict=True):
        low, high = _band(ax, RUNS)
        for kind in KINDS:
            s = stored(kind, name)
            ends[name, kind] = s.anees[-1]
            _curve(ax, kind, s.anees, s.k)
        ax.set(yscale="log", xlabel="frame", ylim=(2, 6000), xlim=(0, FRAMES))
        ax.set_title(f"{name} odometry: {ODOMETRY[name]}", loc="left")
    axes[0].set_ylabel(f"mean NEES of {RUNS} runs, 6 dof (-)")
    axes[0].fill_between([], [], [], color=GREEN, alpha=0.3, label=f"95 % band, {low:.1f} to {high:.1f}")
    handles, labels = axes[0].get_legend_handles_labels()
    fig.legend(handles, labels, loc="outside lower center", ncols=4)
    text = "; ".join(f"{KINDS[k]} {_short(ends['good', k])} and {_short(ends['poor', k])}" for k in KINDS)
    return fig, f"Mean NEES in the last frame, good and poor odometry: {text}. Band {low:.1f} to {high:.1f}."


def size_figure():
    """Numbers in the map over the frames, and what a correction costs. Returns (fig, caption)."""
    fig, (left, right) = plt.subplots(1, 2, figsize=(12, 4.8), width_ratios=(1.7, 1), layout="constrained")
    shown = [k for k in KINDS if k != "euc_camera"]
    cost = {}
    for kind in shown:
        s = stored(kind, "good")
        mean = s.states.mean(0)
        cost[kind] = (s.states**2).mean() / (stored("euc_depth", "good").states ** 2).mean()
        _curve(left, kind, mean, s.k)
    left.set(xlabel="frame", ylabel="numbers in the map", ylim=(0, None), xlim=(0, FRAMES))
    left.legend(loc="upper left")
    at = np.arange(len(shown))[::-1]
    bars = right.barh(at, list(cost.values()), color=[LOOK[k][0] for k in shown])
    right.bar_label(bars, [f" {c:.1f}" for c in cost.values()], fontsize=13)
    right.set_yticks(at, [KINDS[k] for k in shown])
    right.set(xlabel="mean size of P (eucPnt: 1)", xlim=(0, 1.2 * max(cost.values())))
    right.grid(False)
    text = ", ".join(f"{KINDS[k]} {stored(k, 'good').states[:, -1].mean():.0f}" for k in shown)
    return fig, (
        f"Numbers in the map in the last frame: {text}. Over all frames the covariance, and so a correction, is on "
        f"average {cost['ahm']:.1f} times as large with 7 numbers as with 3."
    )


def anonymous_figure():
    """Four landmark types without names: NEES with good and poor odometry; error and size. Returns (fig, caption)."""
    fig, axes = plt.subplots(2, 4, figsize=(12, 5.6), sharex=True, sharey=True, layout="constrained")
    lines = []
    for j, (letter, kind) in enumerate(LETTERS.items()):
        for ax, name in zip(axes[:, j], ODOMETRY, strict=True):
            s = stored(kind, name)
            _band(ax, RUNS)
            ax.plot(s.k, s.anees, color=BLACK, linewidth=2.4)
            ax.set(yscale="log", ylim=(2, 6000))
        axes[0, j].set_title(letter, fontsize=18, weight="bold")
        axes[1, j].set_xlabel("frame")
        good, poor = stored(kind, "good"), stored(kind, "poor")
        lines.append(
            f"{letter}: {good.states[:, -1].mean():.0f} numbers for {landmarks(kind)} landmarks, NEES "
            f"{_short(good.anees[-1])} and {_short(poor.anees[-1])}, "
            f"off by {good.rms[-1]:.2g} m and {poor.rms[-1]:.2g} m"
        )
    for ax, name in zip(axes[:, 0], ODOMETRY, strict=True):
        ax.set_ylabel(f"{name} odometry\nmean NEES (-)")
    return fig, f"In the last frame, good and poor odometry. {'. '.join(lines)}. Shaded: the 95 % band."


def landmarks(kind):
    """Landmarks in the map at the end, from the numbers in it."""
    size = {"idp": 6, "euc_depth": 3, "ahm": 7, "hmg": 4}[kind]
    return int(round((stored(kind, "good").states[:, -1].mean() - 7) / size))


@explorable(
    kind=Choice("idp", {name: kind for kind, name in KINDS.items()}, label="landmarks"),
    odometry=Choice("good", list(ODOMETRY), label="odometry"),
    what=Choice("nees", {"NEES": "nees", "position error": "off", "numbers in the map": "states"}, label="reading"),
    single=Toggle(True, label="show each run"),
    ranges={"end": (0, 1e5), "inside": (0, 1)},
)
def dashboard(kind, odometry, what, single):
    """The stored series: one reading of one kind of landmarks, the other kinds behind it."""
    s = stored(kind, odometry)
    fig, ax = plt.subplots(figsize=(11, 5), layout="constrained")
    low, high = anees_band(DOF, RUNS)
    mean = {"nees": lambda t: t.anees, "off": lambda t: t.rms, "states": lambda t: t.states.mean(0)}[what]
    for other in KINDS:
        if other != kind:
            ax.plot(s.k, mean(stored(other, odometry)), color=GREY, linewidth=1.2, alpha=0.7)
    if single:
        ax.plot(s.k, getattr(s, what).T, color=LOOK[kind][0], linewidth=0.6, alpha=0.45)
    _curve(ax, kind, mean(s), s.k, label=f"{KINDS[kind]}: " + ("RMS" if what == "off" else "mean") + " of 25 runs",
           linewidth=3.2)  # fmt: skip
    ax.plot([], [], color=GREY, label="the other kinds")
    if what == "nees":
        ax.axhspan(low, high, color=GREEN, alpha=0.25, linewidth=0, label=f"95 % band, {low:.1f} to {high:.1f}")
        ax.set(yscale="log", ylim=(0.5, 2e4), ylabel="NEES of the pose, 6 dof (-)")
    elif what == "off":
        ax.set(yscale="log", ylim=(1e-3, 4), ylabel="position error (m)")
    else:
        ax.set(ylim=(0, 280), ylabel="numbers in the map")
    ax.set(xlim=(0, FRAMES), xlabel="frame")
    ax.minorticks_off()
    ax.legend(loc="upper left")
    inside = float(np.mean((s.anees >= low) & (s.anees <= high)))
    end = float(mean(s)[-1])
    words = {"nees": "mean NEES", "off": "RMS position error (m)", "states": "numbers in the map"}[what]
    caption = (
        f"{KINDS[kind]}, {odometry} odometry: {words} in the last frame {end:.3g}. The mean NEES of 25 runs is in its "
        f"95 % band in {100 * inside:.0f} % of the frames."
    )
    return fig, {"end": end, "inside": inside, "caption": caption}
