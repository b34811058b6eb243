"""Figures: ellipses, the map (MapFig), each sensor's measurement space (SenFig), panels, movies.

What may live here: matplotlib artists and what computes their points.
What may not: estimation; a figure only reads what the filter has written.
"""

from .ellipses import ellipse_points, ellipsoid_wires, half_axes, nan_separated, plot_ellipse, sigma_label
from .style import (
    DEAD_RECKONING,
    ESTIMATE,
    MEASUREMENT,
    OKABE_ITO,
    PREDICTED,
    REJECTED,
    TRUTH,
    UPDATED,
    line,
    points,
    use_style,
)

__all__ = [
    "DEAD_RECKONING",
    "ESTIMATE",
    "MEASUREMENT",
    "OKABE_ITO",
    "PREDICTED",
    "REJECTED",
    "TRUTH",
    "UPDATED",
    "ellipse_points",
    "ellipsoid_wires",
    "half_axes",
    "line",
    "nan_separated",
    "plot_ellipse",
    "points",
    "sigma_label",
    "use_style",
]
