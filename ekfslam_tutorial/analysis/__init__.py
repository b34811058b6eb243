"""How good an estimate is, and whether it knows it.

Lives here: errors against a known truth, alignment of maps, and statistics of consistency.
May not: estimate, read files, draw.
"""

from ..geometry import align
from .consistency import Honesty, anees_band, chi2_band, coverage, honesty, k_sigma, md2, nees, nis
from .errors import History

__all__ = [
    "History",
    "Honesty",
    "align",
    "anees_band",
    "chi2_band",
    "coverage",
    "honesty",
    "k_sigma",
    "md2",
    "nees",
    "nis",
]
