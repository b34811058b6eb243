"""The figure: time of a step over the number of landmarks, on two logarithmic axes, and the whole circuit."""

import matplotlib

matplotlib.use("agg")
import matplotlib.pyplot as plt

from .results import Results
from .ways import TOTALS, WAYS, quickest, quickest_total

BLUE, SKY, GREEN, ORANGE, RED, PURPLE, YELLOW, GREY = (
    "#0072B2",
    "#56B4E9",
    "#009E73",
    "#E69F00",
    "#D55E00",
    "#CC79A7",
    "#F0E442",
    "#777777",
)
# Colours of Okabe and Ito. Ours: thick and solid; peers: thin and dashed, each with a marker of its own.
STYLES = {
    "filter, joint": ("this package: filter, joint", BLUE, "-", "o"),
    "filter, joint, compressed": ("this package: filter, compressed, mean", SKY, "-", "D"),
    "step, joint": ("this package: whole step, joint", GREEN, "-", "s"),
    "step, joint, compiled": ("this package: whole step, compiled", RED, "-", "p"),
    "step, joint, compressed": ("this package: whole step, compressed", GREEN, ":", "D"),
    "step, sequential": ("this package: whole step, one by one", SKY, ":", "s"),
    "step, joint, plain": ("this package: whole step, the readable core", YELLOW, "-", "s"),
    "filterpy": ("filterpy, one by one", RED, ":", "^"),
    "filterpy better": ("filterpy, its better way", RED, "--", "^"),
    "PythonRobotics, known ids": ("PythonRobotics, known ids, one by one", ORANGE, ":", "v"),
    "PythonRobotics better": ("PythonRobotics, its better way", ORANGE, "--", "v"),
    "Robotics Toolbox better": ("Robotics Toolbox, its better way, simulator included", PURPLE, "--", "P"),
    "Stone Soup better": ("Stone Soup, its better way", PURPLE, "--", "X"),
    "numba loops better": ("numba, plain loops", GREY, "--", "*"),
    "textbook numpy, joint": ("textbook numpy, joint", GREY, "--", "x"),
    "GTSAM iSAM2 better": ("GTSAM iSAM2 (smoothing)", ORANGE, "--", "<"),
    "GTSAM batch better": ("GTSAM batch (once, at the end)", GREY, "--", ">"),
    "MRPT, one by one": ("MRPT (C++), one by one", PURPLE, "--", "h"),
    "MRPT, joint": ("MRPT (C++), joint", PURPLE, ":", "H"),
}
BETTER = " better"  # the ending of a name that stands for all ways of a peer: the quickest of them


def draw(results, path):
    """Draw the figure of a run.

    Parameters
    ----------
    results : Results
    path : Path
        PNG.
    """
    fig, axs = plt.subplots(1, 3, figsize=(13.5, 6.6), constrained_layout=True)
    for ax, m in zip(axs, (10, 1), strict=False):
        _grid(ax, results, m)
    _circuit(axs[2], results)
    handles = {}
    for ax in axs:
        for handle, label in zip(*ax.get_legend_handles_labels(), strict=True):
            handles.setdefault(label, handle)
        ax.set_xlabel("landmarks in the map, N")
        ax.grid(True, which="major", color="#dddddd", linewidth=0.8)
        for side in "top", "right":
            ax.spines[side].set_visible(False)
    fig.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=4, frameon=False, fontsize=9)
    fig.savefig(path, dpi=110)
    plt.close(fig)


def _grid(ax, results, m):
    for name, (label, colour, line, marker) in STYLES.items():
        which = "mean" if "compressed" in name else "median"
        us = lambda n, name=name, which=which: results.us(n, m, name, which)
        if name.endswith(BETTER):
            peer = name.removesuffix(BETTER)
            us = lambda n, peer=peer: quickest(results, n, m, peer)[0] if peer in WAYS else None
        points = [(n, us(n)) for n in results.sizes("grid")]
        _line(ax, [(n, us) for n, us in points if us], label, colour, line, marker)
    limit = [(n, results.limit(n, m)) for n in results.sizes("grid") if results.limit(n, m)]
    if limit:
        n, us = zip(*limit, strict=True)
        low = min(us) / 2
        ax.plot(n, us, color="black", linewidth=1.5, label="physical limit of a joint correction")
        ax.fill_between(n, low, us, color="black", alpha=0.12, linewidth=0)
        ax.set_ylim(bottom=low)
    _log(ax)
    ax.set_ylabel("CPU time of one step, microseconds")
    ax.set_title(f"{m} landmark{'s' if m > 1 else ''} seen in each step")


def _circuit(ax, results):
    for name, (label, colour, line, marker) in STYLES.items():
        total = lambda n, name=name: results.total(n, name)
        if name.endswith(BETTER):
            peer = name.removesuffix(BETTER)
            total = lambda n, peer=peer: quickest_total(results, n, peer) if peer in TOTALS else None
        points = [(n, total(n)) for n in results.sizes("circuit")]
        _line(ax, [(n, s) for n, s in points if s], label, colour, line, marker)
    _log(ax)
    ax.set_ylabel("CPU time of the whole circuit, seconds")
    ax.set_title("from an empty map, 1.1 rounds, 10 seen")


def _line(ax, points, label, colour, line, marker):
    if points:
        ours = label.startswith("this package")
        ax.plot(
            *zip(*points, strict=True),
            color=colour,
            linestyle=line,
            marker=marker,
            linewidth=2.6 if ours else 1.2,
            markersize=7 if ours else 6,
            markerfacecolor=colour if ours else "white",
            label=label,
        )


def _log(ax):
    ax.set_xscale("log")
    ax.set_yscale("log")
    ticks = [10, 50, 100, 200, 500, 1000]
    ax.set_xticks(ticks, [str(t) for t in ticks])
    ax.minorticks_off()


if __name__ == "__main__":
    from pathlib import Path

    here = Path(__file__).parent
    draw(Results.load(here / "results.json"), here / "speed.png")
