"""Drawings of notebook 17: three ways to a NEES in space, the stored Monte Carlo, four anonymous landmark types."""

import matplotlib.pyplot as plt
import numpy as np
from scipy.stats import chi2

from ...analysis import anees_band, md2
from ...analysis import nees as tangent_nees
from ...geometry import Frame3, e2q, q2e, q2qc, q_prod, v2q, wrap
from ...graphics.style import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, SKY_BLUE, VERMILLION
from ..controls import Choice, Float, Toggle
from ..widgets import explorable
from .nb17_runs import FRAMES, KINDS, ODOMETRY, RUNS, final_nees, live, scenario, stored

__all__ = [
    "FRAMES",
    "KINDS",
    "ODOMETRY",
    "RUNS",
    "draws",
    "euler_nees",
    "final_nees",
    "live",
    "scenario",
    "stored",
    "subtracted_nees",
]

DOF = 6
LOOK = {
    "euc_depth": (VERMILLION, "x"),
    "hmg": (ORANGE, "s"),
    "ahm": (BLUE, "o"),
    "idp": (SKY_BLUE, "^"),
    "idp_euc": (PURPLE, "v"),
    "euc_camera": (GREEN, "D"),
}
LETTERS = {"A": "idp", "B": "euc_depth", "C": "ahm", "D": "hmg"}


# ---- errors of a pose -----------------------------------------------------------------------------------------------


def draws(n, sigma_deg=3.0, pitch_deg=0.0, flip=False, seed=17):
    """Poses of which the filter is honest by construction: its covariance is that of the errors.

    Parameters
    ----------
    n : int
    sigma_deg : float
        Standard deviation of the orientation, degrees on each axis; of the position: 0.1 m.
    pitch_deg : float
        Pitch of the estimate.
    flip : bool
        Half of the true quaternions are written with the other sign.

    Returns
    -------
    x : ndarray, shape (n, 7)
        Estimates: all the same.
    P : ndarray, shape (n, 7, 7)
        Their covariance, of rank 6.
    truth : ndarray, shape (n, 7)
    """
    rng = [np.random.default_rng(s) for s in np.random.SeedSequence(seed).spawn(2)]
    C = np.diag([0.1] * 3 + [np.radians(sigma_deg)] * 3) ** 2
    q = e2q(np.array([0.2, np.radians(pitch_deg), 0.7]))[0]
    T = np.zeros((7, 6))
    T[:3, :3], T[3:, 3:] = np.eye(3), q_prod(q, np.eye(4)[0])[2][:, 1:] / 2
    e = rng[0].standard_normal((n, 6)) @ np.sqrt(C)
    true_q = q_prod(np.broadcast_to(q, (n, 4)), q2qc(v2q(e[:, 3:])[0])[0])[0]
    if flip:
        true_q = true_q * np.where(rng[1].random(n) < 0.5, -1.0, 1.0)[:, None]
    x = np.tile(np.concatenate([np.zeros(3), q]), (n, 1))
    return x, np.tile(T @ C @ T.T, (n, 1, 1)), np.concatenate([-e[:, :3], true_q], 1)


def subtracted_nees(x, P, truth, added=1e-9):
    """What comes out where quaternions are subtracted, and a little is added to P to make it invertible."""
    e = x - truth
    return (e * np.linalg.solve(P + added * np.eye(7), e[..., None])[..., 0]).sum(-1)


def euler_nees(x, P, truth):
    """NEES of position and Euler angles, with the covariance brought along by their Jacobian."""
    a, A_q = q2e(x[..., 3:])
    J = np.zeros((*x.shape[:-1], 6, 7))
    J[..., :3, :3], J[..., 3:, 3:] = np.eye(3), A_q
    e = np.concatenate([x[..., :3] - truth[..., :3], wrap(a - q2e(truth[..., 3:])[0])], -1)
    return md2(e, J @ P @ np.swapaxes(J, -1, -2))


@explorable(
    sigma=Float(3.0, 0.5, 30.0, 0.5, "orientation, 1 sigma", "deg"),
    pitch=Float(0.0, 0.0, 88.0, 2.0, "pitch of the robot", "deg"),
    flip=Toggle(False, label="half of the true q with the other sign"),
    added=Choice(1e-9, {"1e-12": 1e-12, "1e-9": 1e-9, "1e-6": 1e-6, "1e-3": 1e-3}, label="added to P for q - q"),
    ranges={"tangent": (3, 12), "subtracted": (0, 1e14), "euler": (0, 1e9)},
)
def ways(sigma, pitch, flip, added):
    """1000 honest poses, and their NEES computed in three ways: only one of them is chi-square."""
    x, P, truth = draws(1000, sigma, pitch, flip)
    cases = (
        ("tangent space", tangent_nees(Frame3(x), P, Frame3(truth)), BLUE, "-"),
        ("q - q, with a little added to P", subtracted_nees(x, P, truth, added), VERMILLION, "--"),
        ("Euler angles", euler_nees(x, P, truth), ORANGE, ":"),
    )
    fig, ax = plt.subplots(figsize=(10.5, 4.8), layout="constrained")
    u = np.geomspace(0.3, 1e8, 400)
    ax.plot(u, 100 * chi2.cdf(u, DOF), color=BLACK, linewidth=7, alpha=0.25, label="chi-square, 6 dof: honest")
    share = 100 * (np.arange(1000) + 0.5) / 1000
    for name, n, color, dash in cases:
        ax.plot(np.sort(np.clip(n, 1e-3, 1e9)), share, color=color, linestyle=dash, linewidth=2.6, label=name)
    ax.set(xscale="log", xlim=(0.5, 1e7), ylim=(0, 100), xlabel="NEES (-)", ylabel="share of the poses below (%)")
    ax.minorticks_off()
    ax.legend(loc="lower right")
    means = [float(np.mean(n)) for _, n, *_ in cases]
    caption = (
        f"1000 honest poses; the mean NEES should be 6. Tangent space: {means[0]:.1f}. q - q: {_short(means[1])}. "
        f"Euler angles: {_short(means[2])}."
    )
    return fig, {"tangent": means[0], "subtracted": means[1], "euler": means[2], "caption": caption}


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
        step, angle = ODOMETRY[name]
        ax.set(yscale="log", xlabel="frame", ylim=(2, 6000), xlim=(0, FRAMES))
        ax.set_title(f"{name} odometry: {1000 * step:.0f} mm, {angle:g}° a step", loc="left")
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
