"""Figures: ellipses, the map (MapFig), each sensor's measurement space (SenFig), panels, movies, the replay player.

What may live here: matplotlib artists and what computes their points.
What may not: estimation; a figure only reads what the filter has written.
"""

from .ellipses import ellipse_points, ellipsoid_wires, half_axes, nan_separated, plot_ellipse, sigma_label
from .map_fig import MapFig
from .monte_carlo_picture import monte_carlo_picture
from .movie import Movie, check_movie_path, grab, side_by_side, write_movie
from .panels import consistency_panel, cost_panel, covariance_panel, error_panel, error_panels, film_strip
from .picture import map_picture
from .player import StateLog, write_player_html
from .sen_fig import SenFig
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
    "MapFig",
    "Movie",
    "OKABE_ITO",
    "PREDICTED",
    "REJECTED",
    "SenFig",
    "StateLog",
    "TRUTH",
    "UPDATED",
    "check_movie_path",
    "consistency_panel",
    "cost_panel",
    "covariance_panel",
    "ellipse_points",
    "ellipsoid_wires",
    "error_panel",
    "error_panels",
    "film_strip",
    "grab",
    "half_axes",
    "line",
    "map_picture",
    "monte_carlo_picture",
    "nan_separated",
    "plot_ellipse",
    "points",
    "side_by_side",
    "sigma_label",
    "use_style",
    "write_movie",
    "write_player_html",
]
