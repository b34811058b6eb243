"""Drawing of notebook 19: what one step of EKF-SLAM costs, against the number of landmarks.

`cost` is a widget (`explore(nb19_cost.cost)`): the curves of the stored table, read off at a size. `cost_figure` is the
same picture without the widget: `show(*cost_figure(10))`, or `show(*cost_figure(10, {200: {"textbook": 4e-2}}))` with
seconds that were measured on this machine.

Four ways to write the same filter, all with the same result: the textbook's full matrices (n^3 operations), only the
blocks that are not zero (n^2 for each landmark), one joint correction of one triangle of P (n^2 once), and the
compressed filter (the mean of its steps, those included that put all back). They stand in the notebook;
`tools/measure_cost.py` measures them for the table. The dashed line is what the machine allows for a correction of the
whole covariance. `slope` gives the exponents.
"""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from ...graphics.style import BLACK, BLUE, GREEN, GREY, ORANGE, VERMILLION
from ..controls import Choice
from ..widgets import explorable

TABLE = Path(__file__).with_name("nb19_cost.json")
SIZES, SEEN = (10, 20, 50, 100, 200, 500, 1000), (1, 10)
LOOKS = {
    "textbook": ("full matrices, as in the formulas", VERMILLION, "x"),
    "blocks": ("only the blocks, one landmark after another", ORANGE, "s"),
    "joint": ("one joint correction, one triangle of P", BLUE, "o"),
    "compressed": ("compressed, mean", GREEN, "D"),
}


@cache
def stored() -> dict:
    """The table that comes with the course: `machine`, and `rows` of n_lmks, m and microseconds by way."""
    return json.loads(TABLE.read_text(encoding="utf-8"))


def curve(name: str, m: int) -> tuple[np.ndarray, np.ndarray]:
    """Numbers of landmarks and seconds of one step, from the stored table."""
    rows = [row for row in stored()["rows"] if row["m"] == m and name in row]
    return np.array([row["n_lmks"] for row in rows]), 1e-6 * np.array([row[name] for row in rows])


def cost_figure(m: int, here: dict | None = None):
    """Seconds of one step over the number of landmarks in the map, both in powers of ten. Returns (fig, caption).

    Parameters
    ----------
    m : int
        Landmarks seen in a step: 1 or 10.
    here : dict of int to (dict of str to float), optional
        Measured on this machine: seconds by way, by the number of landmarks.
    """
    fig, ax = plt.subplots(figsize=(9.5, 6.0), layout="constrained")
    for name, (label, color, marker) in LOOKS.items():
        n, seconds = curve(name, m)
        ax.plot(n, 1e3 * seconds, color=color, marker=marker, markersize=6, linewidth=2, label=label)
    ax.plot(*_milli(curve("limit", m)), color=BLACK, linestyle="--", label="what the machine allows for all of P")
    for power, (n, seconds) in ((3, curve("textbook", m)), (2, curve("joint", m))):
        tail = n[-3:]
        ax.plot(tail, 2.2e3 * seconds[-1] * (tail / tail[-1]) ** power, color=GREY, linestyle=":", linewidth=1.5)
        ax.annotate(f"$N^{power}$", (tail[0], 2.2e3 * seconds[-1] * (tail[0] / tail[-1]) ** power), (-4, 4),
                    textcoords="offset points", ha="right", color=GREY, fontsize=13)  # fmt: skip
    for n_lmks, ways in (here or {}).items():
        for name, seconds in ways.items():
            _, color, marker = LOOKS[name]
            ax.plot(n_lmks, 1e3 * seconds, marker, color=color, markersize=13, fillstyle="none", markeredgewidth=2)
    if here:
        ax.plot([], [], "o", color=GREY, markersize=13, fillstyle="none", markeredgewidth=2, label="measured here, now")
    ax.set(xscale="log", yscale="log", xlabel="landmarks in the map (-)", ylabel="one step (ms of processor time)")
    ax.set(xlim=(8, 1300), ylim=(3e-3, 1e4), xticks=SIZES, xticklabels=SIZES)
    ax.minorticks_off()
    ax.legend(loc="upper left", fontsize=11)
    return fig, _caption(m, here)


def _milli(n_seconds):
    return n_seconds[0], 1e3 * n_seconds[1]


def _caption(m, here):
    last = {name: curve(name, m)[1][-1] for name in (*LOOKS, "limit")}
    words = (
        f"{SIZES[-1]} landmarks in the map, {m} seen in a step: full matrices {_time(last['textbook'])}, "
        f"only the blocks {_time(last['blocks'])}, joint {_time(last['joint'])}, "
        f"compressed {_time(last['compressed'])}; "
        f"the machine ({stored()['machine']}) would allow {_time(last['limit'])} for all of P."
    )
    for n_lmks, ways in (here or {}).items():
        words += f" Here, with {n_lmks}: {', '.join(f'{name} {_time(s)}' for name, s in ways.items())}."
    return words


def _time(seconds):
    unit, factor = next((u for u in ((" s", 1.0), (" ms", 1e3)) if seconds * u[1] >= 1), (" µs", 1e6))
    return f"{seconds * factor:.2g}{unit}" if seconds * factor < 100 else f"{seconds * factor:.0f}{unit}"


def slope(name: str, m: int) -> float:
    """The exponent p of a curve at its end: between its last two sizes the cost grows as N^p."""
    n, seconds = curve(name, m)
    return float(np.diff(np.log(seconds[-2:]))[0] / np.diff(np.log(n[-2:]))[0])


@explorable(
    seen=Choice(10, list(SEEN), "landmarks seen in a step"),
    lmks=Choice(1000, list(SIZES), "landmarks in the map"),
    ranges={"exponent_textbook": (2.5, 3.5), "exponent_joint": (1.2, 4), "joint_over_limit": (1, 30)},
)
def cost(seen, lmks):
    """The stored curves, read off at one size: so many scans a second could be used."""
    fig, _ = cost_figure(seen)
    fig.axes[0].axvline(lmks, color=BLACK, linewidth=1)
    at = {name: float(curve(name, seen)[1][curve(name, seen)[0] == lmks][0]) for name in LOOKS}
    told = ", ".join(f"{name} {_time(s)} ({1 / s:.2g} steps a second)" for name, s in at.items())
    ratio = curve("joint", seen)[1][-1] / curve("limit", seen)[1][-1]
    facts = {f"exponent_{name}": slope(name, seen) for name in LOOKS}
    return fig, {**facts, "joint_over_limit": ratio, "caption": f"{lmks} landmarks, {seen} seen in a step: {told}."}
