"""Motion models: x2, X_x, X_u = move(x, u, dt). One file each; the export line below is the whole registration."""

from .ackermann import Ackermann
from .constant_turn import ConstantTurn
from .constant_velocity import ConstantVelocity
from .differential_drive import DifferentialDrive
from .imu import Imu
from .imu_clock import ImuClock
from .odometry2 import Odometry2
from .odometry3 import Odometry3
from .unicycle import Unicycle
from .vehicle import Vehicle

__all__ = [
    "Ackermann",
    "ConstantTurn",
    "ConstantVelocity",
    "DifferentialDrive",
    "Imu",
    "ImuClock",
    "Odometry2",
    "Odometry3",
    "Unicycle",
    "Vehicle",
]
