"""How good an estimate is, and whether it knows it.

Lives here: errors against a known truth, alignment of maps, statistics of consistency, and the many runs they need.
May not: draw, or know a model of its own.
"""

from ..geometry import align
from .batch_slam import BatchSnapshot, batch_slam, why_not_batched
from .consistency import Honesty, anees_band, chi2_band, coverage, honesty, k_sigma, md2, nees, nis
from .errors import History
from .monte_carlo import monte_carlo
from .monte_carlo_result import MonteCarlo
from .series import run_seeds

__all__ = [
    "BatchSnapshot",
    "History",
    "Honesty",
    "MonteCarlo",
    "align",
    "anees_band",
    "batch_slam",
    "chi2_band",
    "coverage",
    "honesty",
    "k_sigma",
    "md2",
    "monte_carlo",
    "nees",
    "nis",
    "run_seeds",
    "why_not_batched",
]
