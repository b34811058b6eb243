"""Drawings of notebook 18: five robots of MRCLAM that see each other, in one filter and in five."""

import matplotlib.pyplot as plt
import numpy as np

from ...analysis import align
from ...geometry import Frame2
from ...graphics import ESTIMATE, MEASUREMENT, TRUTH, UPDATED, StateLog, line, plot_ellipse, points, sigma_label
from ...graphics.artists import HALO
from ...graphics.style import BLACK, BLUE, GREEN, GREY, ORANGE, SKY_BLUE, VERMILLION
from ...graphics.style import ROBOTS as COLOURS
from ..controls import Choice, Float, Toggle
from ..logs.nb18 import ROBOTS, SECONDS, TWIN, frames, recording, survey
from ..widgets import explorable
from .parts import robot, true_landmarks
from .parts import say as say

WAYS = ("alone", "five filters that\ntell each other", "one filter,\nlandmarks only", "one filter,\nrobots see robots")
LOOKS = ((GREY, ".."), (ORANGE, "//"), (SKY_BLUE, "\\\\"), (BLUE, ""))
POINTS = 150  # of a path that is drawn
HUES = COLOURS[: len(ROBOTS)]
DASHES = ("-", (0, (6, 2)), (0, (3, 1, 1, 1)), (0, (1, 1)), (0, (8, 2, 2, 2)))


def sightings_figure(which):
    """Who sees whom: a table of counts, robots and landmarks. Returns (fig, caption)."""
    rec, n = recording(which), frames(which)
    ids = [*ROBOTS, *survey(which)]
    count = np.zeros((len(ROBOTS), len(ids)), int)
    for a, r in enumerate(ROBOTS):
        for log in (rec.met[r], rec.raw[r]):
            seen = log.ids[: log.offsets[n]]
            count[a] += [int((seen == i).sum()) for i in ids]
    fig, ax = plt.subplots(figsize=(11, 4.2), layout="constrained")
    image = ax.imshow(np.where(count > 0, count, np.nan), cmap="cividis", aspect="auto", vmin=0)
    for (a, j), c in np.ndenumerate(count):
        text, dark = ("—", False) if a == j else (str(c), c < 0.6 * count.max() and c > 0)
        ax.text(j, a, text, ha="center", va="center", fontsize=11, color="w" if dark else BLACK)
    ax.axvline(len(ROBOTS) - 0.5, color=VERMILLION, linewidth=3)
    ax.set_xticks(range(len(ids)), [str(i) for i in ids])
    ax.set_yticks(range(len(ROBOTS)), [f"robot {r}" for r in ROBOTS])
    ax.set(xlabel="seen: robots 1 to 5, then landmarks", title=f"{which}: sightings in {SECONDS[which]:.0f} s")
    ax.grid(False)
    fig.colorbar(image, label="sightings", pad=0.01)
    met = count[:, : len(ROBOTS)]
    return fig, (
        f"{which.capitalize()} {rec.name}, the first {SECONDS[which]:.0f} s: {count.sum()} sightings, "
        f"{met.sum()} of them of robots. Of the {len(ROBOTS) * (len(ROBOTS) - 1)} pairs of robots (who, whom) "
        f"{(met > 0).sum()} occur."
    )


def effect_figure(which, s, x, P, k=3):
    """All robots and landmarks before and after one sighting of a robot. Returns (fig, caption)."""
    fig, (ax, bars) = plt.subplots(1, 2, figsize=(13, 6.4), width_ratios=[1.25, 1], layout="constrained")
    std = lambda C, r: float(np.sqrt(np.trace(C[r, r][:2, :2])))
    for looks, mean, C in ((MEASUREMENT, s["x"], s["P"]), (UPDATED, x, P)):
        places = [slice(r.start, r.start + 2) for r in s["robots"].values()]
        l, B = np.array([mean[r] for r in places]), np.array([C[r, r] for r in places])
        word = "before" if looks is MEASUREMENT else "after"
        plot_ellipse(ax, l, B, k, **line(looks, linewidth=2), label=f"{word}, {sigma_label(k)}")
        ax.plot(*l.T, **points(looks, markersize=8))
    l = np.array([x[r] for r in s["lmks"].values()])
    ax.plot(*l.T, **points(ESTIMATE, markersize=4), label="landmarks")
    for (r, place), hue in zip(s["robots"].items(), HUES, strict=False):
        robot(ax, x[place], size=0.3, facecolor=hue, edgecolor=BLACK)
        look = dict(fontsize=16, weight="bold", zorder=9, **HALO)
        ax.annotate(f"{r}", tuple(x[place][:2]), (7, 7), textcoords="offset points", **look)
    a, b = (x[s["robots"][s[i]]][:2] for i in "ab")
    ax.annotate("", b, a, arrowprops=dict(arrowstyle="->", color=VERMILLION, linewidth=2), zorder=8)
    ax.set(xlabel="x (m)", ylabel="y (m)", aspect="equal", title=f"robot {s['a']} sees robot {s['b']}")
    below = dict(loc="upper center", bbox_to_anchor=(0.5, -0.15), fontsize=12, frameon=False)
    ax.legend(ncols=2, **below)

    owners = [(f"robot {r}", p) for r, p in s["robots"].items()] + [(f"lmk {i}", p) for i, p in s["lmks"].items()]
    less = [100 * (1 - std(P, p) / std(s["P"], p)) for _, p in owners]
    kinds = ["seen" if o == f"robot {s['b']}" else "sees" if o == f"robot {s['a']}" else "other" for o, _ in owners]
    for kind, color, hatch in (("seen", GREEN, ""), ("sees", ORANGE, "//"), ("other", SKY_BLUE, "..")):
        at = [i for i, what in enumerate(kinds) if what == kind]
        bars.barh(at, [less[i] for i in at], color=color, hatch=hatch, edgecolor="w", label=kind)
    bars.set_yticks(range(len(owners)), [o for o, _ in owners], fontsize=11)
    bars.invert_yaxis()
    bars.set(xlabel="standard deviation of the position: smaller by (%)")
    bars.legend(ncols=3, **below)
    of = dict(zip([o for o, _ in owners], less, strict=True))
    third = max((of[f"robot {r}"], f"robot {r}") for r in s["robots"] if r not in (s["a"], s["b"]))
    return fig, (
        f"{which.capitalize()}, {s['t']:.0f} s: one sighting of robot {s['b']} by robot {s['a']} makes the standard "
        f"deviation of robot {s['b']} smaller by {of['robot ' + str(s['b'])]:.0f} %, of robot {s['a']} by "
        f"{of['robot ' + str(s['a'])]:.0f} %, and of {third[1]}, which has no part in it, by {third[0]:.0f} %."
    )


# ---- four ways ------------------------------------------------------------------------------------------------------


def _figures(five, one):
    """ATE (4, 5), NEES (4, 5) and NIS (4, 5): ways by robots; NaN where the truth is not known."""
    ways = [{str(r): h.summary() for r, h in way.items()} for way in five] + [h.summary()["robots"] for h in one]
    names = "ate_rmse_m", "nees_mean", "nis_mean"
    return tuple(np.array([[way[str(r)][n] for r in ROBOTS] for way in ways], float) for n in names)


def four_ways_figure(which, alone, telling, landmarks_only, one):
    """Error and honesty of each robot in four ways. Returns (fig, caption).

    Parameters
    ----------
    which : str
    alone, telling : dict of int to History
        Of five filters, by robot.
    landmarks_only, one : History
        Of one filter.
    """
    ate, nees, nis = _figures((alone, telling), (landmarks_only, one))
    fig, axes = plt.subplots(1, 2, figsize=(13, 5.6), layout="constrained")
    for ax, values, name in zip(axes, (ate, nees), ("ATE (m)", "mean NEES (honest: 3)"), strict=True):
        for i, (way, (color, hatch)) in enumerate(zip(WAYS, LOOKS, strict=True)):
            at = np.arange(len(ROBOTS)) + 0.2 * (i - 1.5)
            ax.bar(at, values[i], 0.19, color=color, hatch=hatch, edgecolor="w", label=way)
        ax.set_xticks(range(len(ROBOTS)), [f"robot {r}" for r in ROBOTS])
        ax.set_ylabel(name)
    axes[1].axhline(3, color=BLACK, linestyle=":", linewidth=1.5)
    axes[1].set(yscale="log", ylim=(0.5, 100))
    axes[1].set_yticks([1, 3, 10, 30, 100], ["1", "3", "10", "30", "100"])
    axes[1].minorticks_off()
    axes[0].set_title(f"{which}, {SECONDS[which]:.0f} s")
    fig.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=4, fontsize=12, frameon=False)
    with np.errstate(invalid="ignore"):
        m, n, i = (np.nanmedian(v, axis=1) for v in (ate, nees, nis))
    return fig, (
        f"{which.capitalize()}, medians over the robots. ATE: alone {m[0]:.2f} m, telling {m[1]:.2f} m, "
        f"one filter, landmarks only, {m[2]:.2f} m, with sightings {m[3]:.2f} m. "
        f"NEES: {n[0]:.1f}, {n[1]:.1f}, {n[2]:.1f} and {n[3]:.1f}. "
        f"NIS: {i[0]:.2f}, {i[1]:.2f}, {i[2]:.2f} and {i[3]:.2f}."
    )


@explorable(
    leave=Choice(3, {"nobody": 0, **{f"robot {r}": r for r in ROBOTS}}, label="leave out"),
    met=Toggle(True, label="use the sightings of robots"),
    run=True,
    ranges={"ate": (0, 2)},
)
def leave_out(one_filter, which, leave, met):
    """One minute of the log in one filter, without one of the robots: what do the others lose?"""
    some = one_filter(which, met, tuple(r for r in ROBOTS if r != leave), 60.0)
    whole = one_filter(which, True, ROBOTS, 60.0)
    of = lambda h: {int(r): f["ate_rmse_m"] or 0.0 for r, f in h.summary()["robots"].items()}
    error, all_five = of(some), of(whole)
    fig, (ax, bars) = plt.subplots(1, 2, figsize=(12.5, 5.6), width_ratios=[1.2, 1], layout="constrained")
    _paths(ax, which, some)
    for values, width, color, name in ((all_five, 0.8, GREY, "all five, with sightings"), (error, 0.5, BLUE, "now")):
        hatch = ".." if name == "now" else ""
        bars.bar(list(values), list(values.values()), width, color=color, hatch=hatch, label=name)
    top = 1.3 * max(*all_five.values(), *error.values())
    bars.set(xticks=ROBOTS, xlabel="robot", ylabel="ATE (m)", ylim=(0, top))
    bars.legend(loc="upper left", fontsize=12)
    names, ate = ", ".join(str(r) for r in error), some.summary()["ate_rmse_m"] or 0.0
    caption = (
        f"{which.capitalize()}, 60 s, robots {names} in one filter, {'with' if met else 'without'} sightings of "
        f"robots: ATE {ate:.2f} m. All five, with sightings: {whole.summary()['ate_rmse_m'] or 0.0:.2f} m."
    )
    return fig, {"ate": ate, "caption": caption}


# ---- the gauge ------------------------------------------------------------------------------------------------------


def alignment_figure(which, paths, truths, F, ates):
    """Five paths under one alignment, and under one each. Returns (fig, caption)."""
    fig, axes = plt.subplots(1, 2, figsize=(11.6, 5.5), layout="constrained")
    own = [align(p, t) for p, t in zip(paths, truths, strict=True)]
    for ax, aligned, title in (
        (axes[0], [Frame2(F)] * len(paths), "one alignment for all: 3 numbers"),
        (axes[1], own, f"one for each robot: {3 * len(paths)} numbers"),
    ):
        for i, (p, t, G) in enumerate(zip(paths, truths, aligned, strict=True)):
            some = slice(None, None, max(len(p) // POINTS, 1))
            q = G.from_frame(p[some])[0]
            ax.plot(*t[some].T, **line(TRUTH, linewidth=1.0), label="truth" if i == 0 else None)
            ax.plot(*q.T, color=HUES[i], linestyle=DASHES[i], linewidth=1.6, label=f"robot {i + 1}")
        ax.set(xlabel="x (m)", ylabel="y (m)", aspect="equal", title=title)
        ax.set_adjustable("datalim")
    fig.legend(*axes[0].get_legend_handles_labels(), loc="outside right upper", frameon=False)
    apart = [np.sqrt(((G.from_frame(p)[0] - t) ** 2).sum(1).mean()) for p, t, G in zip(paths, truths, own, strict=True)]
    return fig, (
        f"{which.capitalize()}: ATE of the robots with one alignment {', '.join(f'{a:.3f}' for a in ates)} m; each "
        f"aligned on its own {', '.join(f'{a:.3f}' for a in apart)} m, which hides how they lie relative to each other."
    )


# ---- maps -----------------------------------------------------------------------------------------------------------


def map_error(l, truth):
    """RMSE of a map (2 n,) after alignment with the survey (n, 2), m."""
    p = np.reshape(l, (-1, 2))
    return float(np.sqrt(((align(p, truth).from_frame(p)[0] - truth) ** 2).sum(1).mean()))


def maps_figure(which, truth, maps, by_landmark, together, one):
    """Maps averaged landmark by landmark, and with full covariances. Returns (fig, caption).

    Parameters
    ----------
    which : str
    truth : (n, 2)
    maps : list of (2 n,)
        Of each robot alone.
    by_landmark, together, one : (2 n,)
        Averaged; fused; that of one filter for all.
    """
    fig = plt.figure(figsize=(13, 6.2), layout="constrained")
    own = [map_error(l, truth) for l in maps]
    errors = [map_error(l, truth) for l in (by_landmark, together)]
    both = map_error(one, truth)
    left, middle, bars = fig.subplots(1, 3, width_ratios=[1, 1, 1.7])
    for ax, l, title in (
        (left, by_landmark, "landmark\nby landmark"),
        (middle, together, "with the whole\ncovariances"),
    ):
        p = np.reshape(l, (-1, 2))
        p = align(p, truth).from_frame(p)[0]
        ax.plot(*np.transpose([p, p + 5 * (p - truth)], (2, 0, 1)), color=VERMILLION, linewidth=2)
        ax.plot([], [], color=VERMILLION, linewidth=2, label="error, 5 times")
        true_landmarks(ax, truth)
        ax.plot(*p.T, **points(ESTIMATE, markersize=5), label="five maps in one")
        ax.set(xlabel="x (m)", aspect="equal", title=title)
        ax.set_adjustable("datalim")
    left.set_ylabel("y (m)")
    fig.legend(*left.get_legend_handles_labels(), loc="outside lower left", ncols=3, fontsize=12, frameon=False)
    names = [f"robot {r} alone" for r in ROBOTS] + ["landmark by landmark", "whole covariances", "one filter"]
    colors, hatches = [GREY] * 5 + [VERMILLION, GREEN, BLUE], [".."] * 5 + ["//", "", "\\\\"]
    bars.barh(names, [*own, *errors, both], color=colors, hatch=hatches, edgecolor="w")
    bars.invert_yaxis()
    bars.set(xlabel="error of the landmarks, RMSE (m)", title=which)
    return fig, (
        f"{which.capitalize()}, {len(truth)} landmarks, error after alignment: each map on its own "
        f"{', '.join(f'{e:.2f}' for e in own)} m; averaged landmark by landmark {errors[0]:.3f} m; with the whole "
        f"covariances {errors[1]:.3f} m; one filter for all, without sightings of robots, {both:.3f} m."
    )


# ---- two robots and a third -----------------------------------------------------------------------------------------


@explorable(
    rho=Float(0.8, 0.0, 0.95, 0.05, "correlation of robot 2 with robot 3", "", "Both have seen the same landmarks"),
    turn=Float(3.0, 0.5, 20.0, 0.5, "heading of robot 1, sigma", "deg"),
    way=Choice("joint", {"both are uncertain": "joint", "robot 2 is exact": "known"}, label="robot 1 thinks that"),
    ranges={"seen": (0, 2), "third": (0, 2)},
)
def one_sighting(rho, turn, way):
    """Robot 1 sees robot 2. What happens to robot 3, which sees nothing?"""
    x = np.array([0.0, 0, 0.2, 4.0, 1.2, 2.0, 2.0, -2.5, 0.5])
    std = np.array([0.25, 0.1, np.radians(turn), 0.8, 0.5, 0.3, 0.8, 0.5, 0.3])
    C = np.eye(9)
    for i in (3, 4):
        C[i, i + 3] = C[i + 3, i] = rho
    P = C * np.outer(std, std)
    l = x[3:5] - x[:2]
    r = np.hypot(*l)
    E_l = np.array([l / r, [-l[1] / r**2, l[0] / r**2]])
    H = np.zeros((2, 9))
    H[:, :2], H[:, 2], H[:, 3:5] = -E_l, [0, -1], E_l
    if way == "known":
        H[:, 3:5] = 0
    Z = H @ P @ H.T + np.diag([0.1**2, np.radians(2) ** 2])
    K = np.linalg.solve(Z, H @ P).T
    after = P - K @ Z @ K.T
    fig, ax = plt.subplots(figsize=(8.4, 5.6), layout="constrained")
    for B, looks, name in ((P, MEASUREMENT, "before"), (after, UPDATED, "after")):
        at = [slice(i, i + 2) for i in (0, 3, 6)]
        blocks = np.array([B[s, s] for s in at])
        plot_ellipse(
            ax, np.array([x[s] for s in at]), blocks, 2, **line(looks, linewidth=2.2), label=f"{name}, {sigma_label(2)}"
        )
    for i, color in zip((0, 3, 6), HUES, strict=False):
        robot(ax, x[i : i + 3], facecolor=color, edgecolor=BLACK, size=0.35)
        paper = dict(facecolor="w", edgecolor="none", alpha=0.85, pad=1)
        place: dict = dict(xytext=(-22, -38), textcoords="offset points", fontsize=13, bbox=paper, zorder=9)
        ax.annotate(f"robot {i // 3 + 1}", tuple(x[i : i + 2]), **place)
    ax.annotate("", tuple(x[3:5]), tuple(x[:2]), arrowprops=dict(arrowstyle="->", color=VERMILLION, linewidth=2))
    ax.set(xlim=(-2, 6.5), ylim=(-4.4, 3.4), xlabel="x (m)", ylabel="y (m)", aspect="equal")
    ax.legend(loc="upper left")
    size = lambda B, i: float(np.sqrt(np.trace(B[i : i + 2, i : i + 2])))
    caption = "Position sigma before and after: " + ", ".join(
        f"robot {i // 3 + 1} {size(P, i):.2f} and {size(after, i):.2f} m" for i in (0, 3, 6)
    )
    return fig, {"seen": size(after, 3), "third": size(after, 6), "caption": caption + "."}


# ---- player and paths -----------------------------------------------------------------------------------------------


def film(which, run, pictures=40):
    """A run as a state log. The ground truth of a real log stays where it is: only estimates are kept."""
    log = StateLog(f"five robots, {which}", period=max(len(run) // pictures, 1))
    for now in run:
        if which != TWIN:
            now.truth, now.sim_lmk, now.obs = {}, None, {}
        log.add(now)
    return log


def film_strip(log, n=3):
    """Frames of the film side by side. Each robot has its look; the landmarks lie too close to be numbered."""
    frames = log.frames()
    fig, axes = plt.subplots(1, n, figsize=(13, 4.4), sharex=True, sharey=True, layout="constrained")
    for ax, last in zip(axes, np.linspace(0, len(frames) - 1, n + 1).round().astype(int)[1:], strict=True):
        now = frames[last]
        l, L = (np.array(a) for a in zip(*(m for m in now.lmks.values() if np.isfinite(m[1]).all()), strict=True))
        plot_ellipse(ax, l, L @ L.swapaxes(1, 2), log.k, **line(ESTIMATE, linewidth=1.1), label=sigma_label(log.k))
        ax.plot(*l.T, **points(ESTIMATE, markersize=4), label="landmarks")
        for r, color, dash in zip(ROBOTS, HUES, DASHES, strict=True):
            path = np.array([frame.robots[r][0][:2] for frame in frames[: last + 1]])
            ax.plot(*path.T, color=color, linestyle=dash, linewidth=1.4, label=f"robot {r}")
            robot(ax, now.robots[r][0][:3], size=0.35, facecolor=color, edgecolor=BLACK)
        ax.set(xlabel="x (m)", aspect="equal", title=f"frame {now.k}, t = {now.t:.1f} s")
    axes[0].set_ylabel("y (m)")
    fig.legend(*axes[-1].get_legend_handles_labels(), loc="outside lower center", ncols=7, fontsize=12, frameon=False)
    return fig


def _paths(ax, which, history):
    """Paths of all robots of a history after alignment, and the landmarks."""
    F = history.alignment()[0] or Frame2(np.zeros(3))
    true_landmarks(ax, list(survey(which).values()))
    for r in history.robots:
        track = history.track(r).moved(F)
        i = r - 1
        ax.plot(
            *track.x[:: max(len(track.x) // POINTS, 1), :2].T,
            color=HUES[i],
            linestyle=DASHES[i],
            linewidth=1.5,
            label=f"robot {r}",
        )
        robot(ax, track.x[-1], size=0.3, facecolor=HUES[i], edgecolor=BLACK)
    ax.set(xlabel="x (m)", ylabel="y (m)", aspect="equal")
    ax.set_adjustable("datalim")
    ax.legend(fontsize=11, loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
