"""The sign lamps of notebook 01: one prediction and one correction with a mistake in them, and who notices."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache

import matplotlib.pyplot as plt
import numpy as np

from ...analysis.consistency import anees_band, md2
from ...geometry import Frame2, numerical_jacobian, wrap
from ...graphics.style import BLACK, GREEN, GREY, LIGHT_GREY, VERMILLION
from ...models.sensors import RangeBearing
from ..controls import Choice, Float
from ..exercises.nb01_innovation import innovation
from ..exercises.nb01_move import move
from ..widgets import explorable
from .nb01 import expected

RUNS, SEED = 1000, 8
SPEED, DT = 3.0, 0.5  # m/s, s
START_P = np.diag([0.1, 0.1, np.radians(3.0)]) ** 2
U = np.diag([0.2, np.radians(4.0)]) ** 2
SENSOR = RangeBearing(0.1, np.radians(2.0))
LANDMARK = np.array([3.0, 1.0])  # from where the robot expects to be after the step, along its own axes; m
NAMES = {"F_x": ("x", "y", "θ"), "F_u": ("v", "w"), "H": ("x", "y", "θ")}


@dataclass(frozen=True)
class Formulas:
    """What the filter computes with: three Jacobians, and the innovations of many measurements."""

    F_x: np.ndarray
    F_u: np.ndarray
    H: np.ndarray
    z: np.ndarray


def _flipped(matrix: str, *entry) -> Callable[[Formulas, Formulas], Formulas]:
    """A mistake: the sign of one entry, or of one row, of one of the matrices."""

    def mistake(f: Formulas, late: Formulas) -> Formulas:
        J = getattr(f, matrix).copy()
        J[entry] *= -1
        return replace(f, **{matrix: J})

    return mistake


# Each gets the right formulas, and the same Jacobians taken after the move; it returns the wrong ones.
MISTAKES: dict[str, Callable[[Formulas, Formulas], Formulas]] = {
    "none": lambda f, late: f,
    "F_x: sign of the sine": _flipped("F_x", 0, 2),
    "F_x: sign of the cosine": _flipped("F_x", 1, 2),
    "F_x, F_u: taken after the move": lambda f, late: replace(f, F_x=late.F_x, F_u=late.F_u),
    "F_u: sine and cosine swapped": lambda f, late: replace(f, F_u=f.F_u[[1, 0, 2]]),
    "H: sign of the range's row": _flipped("H", 0),
    "H: +1 for the heading": _flipped("H", 1, 2),
    "z: expected minus measured": lambda f, late: replace(f, z=-f.z),
}


@lru_cache(32)
def tried(mistake: str, heading_deg: float, rate_deg: float):
    """One prediction and one correction from 1000 true poses.

    Parameters
    ----------
    mistake : str
        One of `MISTAKES`.
    heading_deg, rate_deg : float
        Heading of the estimate before the step, turn rate in it.

    Returns
    -------
    used, numeric : Formulas
        What the filter used, and what finite differences say.
    nees, nis : tuple of ndarray, shape (RUNS,)
        NEES of the predicted and of the corrected pose; NIS.
    """
    start, motion, sight = (np.random.default_rng(s) for s in np.random.SeedSequence(SEED).spawn(3))
    x0, u = np.array([0.0, 0.0, np.radians(heading_deg)]), np.array([SPEED, np.radians(rate_deg)])
    x, F_x, F_u = move(x0, u, DT)
    a = x[2] + np.arctan2(LANDMARK[1], LANDMARK[0])
    p = x[:2] + np.hypot(*LANDMARK) * np.array([np.cos(a), np.sin(a)])
    e, H = expected(SENSOR, x, p)

    truth = x0 + start.standard_normal((RUNS, 3)) @ np.sqrt(START_P)
    noisy = u + motion.standard_normal((RUNS, 2)) @ np.sqrt(U)
    step = np.column_stack([noisy[:, 0] * DT, np.zeros(RUNS), noisy[:, 1] * DT])  # `move`, of all at once
    truth = Frame2(truth).compose(Frame2(step))[0].x
    y = SENSOR.project(Frame2(truth).to_frame(p)[0])[0] + sight.standard_normal((RUNS, 2)) @ np.sqrt(SENSOR.R)

    _, late_x, late_u = move(x, u, DT)
    right = Formulas(F_x, F_u, H, innovation(y, e))
    used = MISTAKES[mistake](right, replace(right, F_x=late_x, F_u=late_u))
    numeric = replace(
        right,
        F_x=numerical_jacobian(lambda v: move(v, u, DT)[0], x0),
        F_u=numerical_jacobian(lambda v: move(x0, v, DT)[0], u),
        H=numerical_jacobian(lambda v: expected(SENSOR, v, p)[0], x),
    )
    P = used.F_x @ START_P @ used.F_x.T + used.F_u @ U @ used.F_u.T
    Z = used.H @ P @ used.H.T + SENSOR.R
    K = np.linalg.solve(Z, used.H @ P).T
    corrected = x + used.z @ K.T
    return used, numeric, (_nees(x - truth, P), _nees(corrected - truth, P - K @ Z @ K.T)), md2(used.z, Z)


def _nees(error, P):
    return md2(np.column_stack([error[:, :2], wrap(error[:, 2])]), P)


@explorable(
    mistake=Choice("z: expected minus measured", list(MISTAKES), "mistake"),
    heading=Float(30.0, -180.0, 180.0, 10.0, "heading before the step", "deg"),
    rate=Float(40.0, 0.0, 60.0, 10.0, "turn rate", "deg/s"),
    ranges={"red_entries": (0, 9), "red_readings": (0, 3)},
)
def sign_lamp(mistake, heading, rate):
    """A lamp for each entry of the Jacobians, and for each reading of the filter: which goes red?"""
    used, numeric, (predicted, corrected), nis = tried(mistake, heading, rate)
    fig = plt.figure(figsize=(12, 5.2))
    red = _entries(fig.add_axes((0.0, 0.0, 0.47, 0.9)), used, numeric)
    rows = ("NEES of the prediction", predicted, 3), ("NIS", nis, 2), ("NEES after the correction", corrected, 3)
    alarms = _readings(fig.add_axes((0.52, 0.14, 0.46, 0.76)), rows)
    fig.text(0.01, 0.94, "written, against finite differences", fontsize=14)
    fig.text(0.52, 0.94, f"{RUNS} runs: one step, one measurement", fontsize=14)
    readings = ", ".join(alarms) or "none"
    caption = (
        f"Mistake: {mistake}; heading {heading:.0f} deg, turn rate {rate:.0f} deg/s. Red: {red} of 21 entries; "
        f"readings: {readings}. NEES of the prediction {predicted.mean():.2g} (honest: 3), NIS {nis.mean():.2g} (2), "
        f"NEES after the correction {corrected.mean():.2g} (3)."
    )
    return fig, {"red_entries": red, "red_readings": len(alarms), "caption": caption}


def _entries(ax, used, numeric):
    """Draw the three Jacobians with a lamp at each entry; return how many are red."""
    ax.set(xlim=(0, 10), ylim=(0, 9.6))
    ax.set_axis_off()
    lamps: dict[bool, list] = {True: [], False: []}
    for name, left, top, rows in (("F_x", 1.1, 8.2, "xyθ"), ("F_u", 7.0, 8.2, "xyθ"), ("H", 1.1, 2.9, "rβ")):
        J, N = getattr(used, name), getattr(numeric, name)
        ax.text(left - 1.0, top + 0.75, name, fontsize=15, weight="bold", va="center")
        for j, column in enumerate(NAMES[name]):
            ax.text(left + 1.7 * j + 0.55, top + 0.75, column, fontsize=13, va="center", ha="center", color=GREY)
        for i, row in enumerate(rows):
            ax.text(left - 0.5, top - 1.3 * i, row, fontsize=13, va="center", ha="center", color=GREY)
            for j in range(J.shape[1]):
                good = abs(J[i, j] - N[i, j]) < 1e-6
                lamps[good].append((left + 1.7 * j, top - 1.3 * i))
                text = _short(J[i, j]) if good else f"{_short(J[i, j])}\n({_short(N[i, j])})"
                weight = "normal" if good else "bold"
                ax.text(left + 1.7 * j + 0.28, top - 1.3 * i, text, fontsize=12, va="center", weight=weight)
    for good, color, marker, label in (
        (True, GREEN, "o", "agrees"),
        (False, VERMILLION, "X", "does not (right value)"),
    ):
        at = np.reshape(lamps[good], (-1, 2))
        ax.plot(*at.T, marker, color=color, markersize=12, linestyle="none", label=label)
    ax.legend(loc="lower right", fontsize=11, frameon=False)
    return len(lamps[False])


def _short(number):
    return f"{round(number, 2) + 0.0:.2f}"  # no minus before a zero


def _readings(ax, rows):
    """Draw each reading relative to its honest value, with the band of honest filters; return the names of the red."""
    low, high, alarms = 0.3, 30.0, []
    for y, (name, values, dof) in zip(range(len(rows), 0, -1), rows, strict=True):
        band = np.array(anees_band(dof, RUNS, 0.999))
        good = band[0] <= values.mean() <= band[1]
        ax.plot([low, high], [y, y], color=LIGHT_GREY, linewidth=13, solid_capstyle="butt", zorder=1)
        ax.plot(band / dof, [y, y], color=GREEN, linewidth=13, solid_capstyle="butt", zorder=2)
        at = np.clip(values.mean() / dof, low, high)
        color, marker = (GREEN, "o") if good else (VERMILLION, "X")
        ax.plot(at, y, marker, color=color, markeredgecolor=BLACK, markersize=14, zorder=3)
        ax.text(low, y + 0.24, f"{name}: {values.mean():.3g} (honest: {dof})", fontsize=13)
        alarms += [] if good else [name]
    ax.set(xscale="log", xlim=(low, high), ylim=(0.6, 3.6), yticks=[], xlabel="reading / honest reading; green: honest")
    ax.set_xticks([0.3, 1, 3, 10, 30], ["0.3", "1", "3", "10", "30"])
    ax.minorticks_off()
    ax.grid(False)
    ax.spines["left"].set_visible(False)
    return alarms
