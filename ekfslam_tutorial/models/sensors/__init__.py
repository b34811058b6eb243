"""Sensors: y, Y_p = project(p) and back. One file each; the export line below is the whole registration."""

from .bearing_only2 import BearingOnly2
from .omni_cam import OmniCam
from .pin_hole import PinHole
from .pin_hole_depth import PinHoleDepth
from .range_bearing import RangeBearing

__all__ = ["BearingOnly2", "OmniCam", "PinHole", "PinHoleDepth", "RangeBearing"]
