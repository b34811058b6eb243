"""Landmarks, points and lines. One file each; the export line below is the whole registration."""

from .ahm_lin import AhmLin
from .ahm_pnt import AhmPnt
from .apl_lin import AplLin
from .beacon import Beacon
from .euc_pnt import EucPnt
from .hmg_lin import HmgLin
from .hmg_pnt import HmgPnt
from .idp_lin import IdpLin
from .idp_pnt import IdpPnt
from .plk_lin import PlkLin

__all__ = [
    "AhmLin",
    "AhmPnt",
    "AplLin",
    "Beacon",
    "EucPnt",
    "HmgLin",
    "HmgPnt",
    "IdpLin",
    "IdpPnt",
    "PlkLin",
]
