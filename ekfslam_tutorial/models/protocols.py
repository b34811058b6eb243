"""What a model must be able to do.

The protocols are structural: a class that has these methods is a model, whatever it inherits from. `contracts.py` has
the tests that say whether it can.
"""

from typing import Any, Protocol

METHODS = {
    "motion": ("move",),
    "sensor": ("project", "residual", "visible"),
    "landmark": ("to_frame", "from_frame", "point", "ray"),
    "line": ("to_frame", "from_frame", "normal", "support", "from_rays"),
}
VALUES = {
    "motion": ("frame", "size", "control_fields", "state_fields"),
    "sensor": ("R", "bearing_only"),
    "landmark": ("size",),
    "line": ("size",),
}
"""What no run can do without; `contracts.py` says what else a model may have."""


def lacking(model, names):
    """Say which of the methods and values a model, or a class, does not have: "no method visible, no R", or "".

    Nothing is called: a property that fails is there all the same.
    """
    there = dir(model)
    absent = [name for name in names if name not in there and not hasattr(model, name)]
    methods = [name for those in METHODS.values() for name in those]
    return ", ".join(f"no {'method ' if name in methods else ''}{name}" for name in absent)


class MotionModel(Protocol):
    """Motion model, how a robot moves: see `models.motion`.

    It may have a method `part(u, U, f)`: the share f of a control in time, and its covariance, as `Odometry2` has it. A
    control without is a velocity: it stays, and its white noise U is divided by f.

    See Also
    --------
    check_motion : Tests one.
    """

    frame: Any  # Frame2 or Frame3; the first frame.size numbers of the state are the robot's frame
    size: int  # length of the state
    control_fields: Any  # {"dx": 2, "da_deg": 1}: the parts of the control and their lengths
    state_fields: Any  # the parts of the state after the frame

    def move(self, x, u, dt) -> tuple:
        """Move a state by a control in dt seconds: x2, X_x, X_u."""
        ...


class SensorModel(Protocol):
    """Sensor model, what a sensor measures: see `models.sensors`.

    It may have a `max_range`, m: `visible` is false for all that is further away, and large maps are searched by it.

    Its innovation need not be y - e. With `innovation(y, e)`, which returns z, Z_y, Z_e, it is what that says; E and R
    are carried to it by the Jacobians. Such a sensor says in `asks` which method of a landmark it asks for, and in
    `starts` which one begins it: `SegmentCam` asks lines for their `normal`, and starts them `from_rays`.

    See Also
    --------
    check_sensor : Tests one.
    """

    bearing_only: Any  # True: measures a direction; a landmark's birth needs a prior

    @property
    def R(self) -> Any:
        """Measurement noise covariance."""
        ...

    def project(self, p) -> tuple:
        """Point, or ray, in the sensor frame to measurement: y, Y_p."""
        ...

    def retro(self, y) -> tuple:
        """Measurement to ray, or point, in the sensor frame: v, V_y. Invariant: project(retro(y)[0])[0] == y.

        May be missing: such a sensor corrects with landmarks that others have started.
        """
        ...

    def residual(self, y, e) -> Any:
        """Innovation y - e, angles wrapped."""
        ...

    def visible(self, y, p) -> Any:
        """Return True for each point that can be seen."""
        ...


class LmkType(Protocol):
    """Landmark type, how a map stores a landmark: see `models.landmarks`. `from_ray` or `from_point` may be missing.

    See Also
    --------
    check_landmark : Tests one.
    """

    @property
    def size(self) -> int:
        """Length of the state."""
        ...

    def to_frame(self, F, l) -> tuple:
        """Express landmarks in frame F: l_F, LF_f, LF_l."""
        ...

    def from_frame(self, F, l) -> tuple:
        """Bring landmarks from F to its parent: l, L_f, L_lf. Invariant: to_frame(F, from_frame(F, l)[0])[0] == l."""
        ...

    def point(self, l) -> tuple:
        """Euclidean point: p, P_l."""
        ...

    def ray(self, l) -> tuple:
        """Point up to a positive scale: v, V_l."""
        ...


class LineType(Protocol):
    """Line type, how a map stores a line: see `models.landmarks.lines`.

    `to_frame` and `from_frame` are those of a `LmkType`. A type whose numbers must keep a condition has
    `normalized(l)`, which returns l, L_l: it is called after each correction.

    See Also
    --------
    check_landmark : Tests one, too.
    """

    size: int
    priors: (
        Any  # what the prior's mean is times, where the user gives one number for the two that a segment leaves open
    )

    def normal(self, l) -> tuple:
        """Normal of the plane through the origin in which the line lies, of any length: n, N_l."""
        ...

    def support(self, l) -> tuple:
        """A point of the line and its direction: p0, d, P0_l, D_l."""
        ...

    def from_rays(self, v, n) -> tuple:
        """Line that is seen along two rays v = [v1; v2], with a prior n of two numbers: l, L_v, L_n."""
        ...
