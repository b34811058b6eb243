"""Sensors: y, Y_p = project(p) and back. One file each; the export line below is the whole registration."""

from .bearing_only2 import BearingOnly2
from .compass import Compass
from .davison_cam import DavisonCam
from .doppler import Doppler
from .gps import Gps
from .ground_flow import GroundFlow
from .omni_cam import OmniCam
from .pin_hole import PinHole
from .pin_hole_depth import PinHoleDepth
from .point import PointXY, PointXYZ
from .range import Range
from .range_bearing import RangeBearing
from .range_bearing_elevation import RangeBearingElevation
from .range_rate import RangeRate
from .segment_cam import SegmentCam
from .stereo_pin_hole import StereoPinHole
from .wheel_speed import WheelSpeed

__all__ = [
    "BearingOnly2",
    "Compass",
    "DavisonCam",
    "Doppler",
    "Gps",
    "GroundFlow",
    "OmniCam",
    "PinHole",
    "PinHoleDepth",
    "PointXY",
    "PointXYZ",
    "Range",
    "RangeBearing",
    "RangeBearingElevation",
    "RangeRate",
    "SegmentCam",
    "StereoPinHole",
    "WheelSpeed",
]
