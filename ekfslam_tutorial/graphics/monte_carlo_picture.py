"""The picture of many runs: whether the filter is honest, and how large its errors are beside what it expects."""

import matplotlib.pyplot as plt
import numpy as np

from .panels import consistency_panel
from .style import ESTIMATE, LIGHT_GREY, PREDICTED, line

SHOWN = 30
"""Of the single runs so many are drawn."""


def monte_carlo_picture(result, robot=None, probability=0.95):
    """Draw NEES, position error and heading error of a robot over time.

    Parameters
    ----------
    result : analysis.MonteCarlo
    robot : int, optional
        Its id; the first robot if not given.
    probability : float
        Of the band that the mean NEES of an honest filter stays in.

    Returns
    -------
    matplotlib Figure
        Above the mean NEES over the runs with its band. Below the errors of single runs, their root mean square over
        the runs, and 1 sigma: what the filter expects that root mean square to be.
    """
    k = 0 if robot is None else result.robots.index(robot)
    runs, anees = len(result.runs) - len(result.failures), result.over_time("nees")[:, k]
    fig, (above, middle, below) = plt.subplots(3, 1, figsize=(9.2, 9.5), sharex=True, layout="constrained")
    if np.isfinite(anees).any():
        consistency_panel(result.t, anees, result.dof, runs, probability, "NEES of the pose", ax=above)
        above.set(xlabel="", ylabel=f"NEES, mean of {runs} runs (-)")
    else:
        above.text(0.5, 0.5, "the pose is not estimated", ha="center", va="center", transform=above.transAxes)
        above.set_axis_off()
    _errors(middle, result, "position", k, 1.0, "position error (m)")
    _errors(below, result, "heading", k, 180 / np.pi, f"{'heading' if result.dim == 2 else 'rotation'} error (deg)")
    below.set_xlabel("t (s)")
    which = f", robot {result.robots[k]}" if len(result.robots) > 1 else ""
    fig.suptitle(f"{result.name}{which}: {len(result.runs)} runs")
    return fig


def _errors(ax, result, name, k, scale, label):
    """Errors of single runs, of all runs together, and what the filter expects."""
    single = scale * getattr(result, name)[:SHOWN, :, k]
    rms, std = (scale * result.over_time(n)[:, k] for n in (name, f"{name}_std"))
    for i, error in enumerate(single):
        ax.plot(
            result.t, error, color=LIGHT_GREY, linewidth=0.6, label=f"{len(single)} single runs" if i == 0 else None
        )
    ax.plot(result.t, rms, **line(ESTIMATE), label=f"RMSE over {len(result.runs) - len(result.failures)} runs")
    ax.plot(result.t, std, **line(PREDICTED), label="1σ: what the filter expects it to be")
    known = np.concatenate([rms, std])[np.isfinite(np.concatenate([rms, std]))]
    ax.set(ylabel=label, ylim=(0, 2.2 * known.max() if known.size and known.max() > 0 else 1.0))
    ax.legend(loc="lower left", bbox_to_anchor=(0, 1), borderaxespad=0, ncols=3, frameon=False)
