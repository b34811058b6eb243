"""Point landmarks and how a map stores them. One file each; the export line below is the whole registration."""

from .ahm_pnt import AhmPnt
from .beacon import Beacon
from .euc_pnt import EucPnt
from .hmg_pnt import HmgPnt
from .idp_pnt import IdpPnt

__all__ = ["AhmPnt", "Beacon", "EucPnt", "HmgPnt", "IdpPnt"]
