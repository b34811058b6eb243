"""Filter and smoother in one picture: both paths beside the truth, their errors and what they believe of them."""

import matplotlib.pyplot as plt
import numpy as np

from .ellipses import plot_ellipse
from .style import ESTIMATE, PREDICTED, TRUTH, line, points

ELLIPSES = 12
"""So many of a path are drawn."""


def smoother_picture(t, filtered, smoothed, truth=None, mean=None, true_points=None, title=""):
    """Draw the estimate of a filter and of a smoother.

    Parameters
    ----------
    t : ndarray, shape (F,)
        s.
    filtered, smoothed : tuple of (ndarray, ndarray)
        Positions (F, d) and their covariances (F, d, d), m; of what is beyond the plane only the error is drawn.
    truth : ndarray, shape (F, d), optional
        NaN where it is not known.
    mean, true_points : ndarray, shape (n, d), optional
        Landmarks of the smoother, and the true ones.
    title : str

    Returns
    -------
    matplotlib Figure
        On the left the paths from above with some ellipses of 3 sigma, on the right the distance from the truth over
        time, and the sigma that each believes.
    """
    fig, (plane, error) = plt.subplots(1, 2, figsize=(13, 6), layout="constrained")
    if truth is not None:
        plane.plot(*truth[:, :2].T, **line(TRUTH), label="truth")
    if true_points is not None:
        plane.plot(*true_points[:, :2].T, **points(TRUTH))
    some = np.unique(np.linspace(0, len(t) - 1, ELLIPSES).astype(int))
    for (x, P), style, name in ((filtered, PREDICTED, "filter"), (smoothed, ESTIMATE, "smoother")):
        plane.plot(*x[:, :2].T, **line(style), label=name)
        for k in some:
            plot_ellipse(plane, x[k, :2], P[k, :2, :2], **line(style, linewidth=0.8))
        sigma = np.sqrt(np.trace(P, axis1=1, axis2=2))
        if truth is not None:
            error.plot(t, np.linalg.norm(x - truth, axis=1), **line(style), label=f"{name}: error")
        error.plot(t, sigma, **line(style, linestyle=":"), label=f"{name}: 1 sigma")
    if mean is not None and len(mean):
        plane.plot(*mean[:, :2].T, **points(ESTIMATE))
    plane.set(xlabel="x (m)", ylabel="y (m)", aspect="equal", title="from above, ellipses of 3 sigma")
    told = "error and what each believes of it" if truth is not None else "what each believes of its error"
    error.set(xlabel="t (s)", ylabel="position (m)", ylim=(0, None), title=told)
    for ax, columns in ((plane, 3), (error, 2)):
        ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.12), ncols=columns, frameon=False)
    fig.suptitle(title)
    return fig
