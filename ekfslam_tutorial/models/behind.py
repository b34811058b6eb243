"""The state of a sensor with parameters: they stand behind its frame, as velocities do behind that of a robot."""

from typing import Any

import numpy as np


class _Behind:
    """A frame with parameters behind it: the numbers of the frame itself come first."""

    x: Any
    dim: Any
    size: Any
    plain: Any  # Frame2 or Frame3
    delay_at: Any

    def __reduce__(self):
        return _made, (self.plain, self.size - self.plain.size, self.delay_at, self.x)

    @property
    def o(self):
        return self.x[..., self.dim : self.plain.size]

    @property
    def a(self):
        """The parameters."""
        return self.x[..., self.plain.size :]

    @property
    def delay(self):
        """By how much the stamps of the sensor are late, s; None if that is no state."""
        return None if self.delay_at is None else self.x[..., self.delay_at]

    def normalized(self):
        """The same with its frame in the normal form. Returns N, N_f."""
        N, N_f = self.plain(self.x[: self.plain.size]).normalized()
        J = np.eye(self.size)
        J[: N.size, : N.size] = N_f
        kind: Any = type(self)
        return kind(np.concatenate([N.x, self.a])), J

    def minus(self, G):
        """Difference of the frames alone: see `Frame2.minus`."""
        return self.plain(self.x[: self.plain.size]).minus(G)


def frame_with(frame, n, delay_at=None) -> Any:
    """Class of the state of a sensor: a frame, and n parameters behind it.

    Parameters
    ----------
    frame : type
        Frame2 or Frame3.
    n : int
    delay_at : int, optional
        Which number of the state is the delay.

    Returns
    -------
    type
        A frame, with the parameters in `a`; its `size` counts them.

    See Also
    --------
    Calibrated : The sensor.
    state_class : The class that a sensor model needs.
    """
    return type(
        f"{frame.__name__}With{n}", (_Behind, frame), {"size": frame.size + n, "plain": frame, "delay_at": delay_at}
    )


def _made(frame, n, delay_at, x):
    return frame_with(frame, n, delay_at)(x)
