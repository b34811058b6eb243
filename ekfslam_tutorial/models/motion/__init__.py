"""Motion models: x2, X_x, X_u = move(x, u, dt). One file each; the export line below is the whole registration."""

from .constant_velocity import ConstantVelocity
from .odometry2 import Odometry2
from .odometry3 import Odometry3
from .unicycle import Unicycle
from .vehicle import Vehicle

__all__ = ["ConstantVelocity", "Odometry2", "Odometry3", "Unicycle", "Vehicle"]
