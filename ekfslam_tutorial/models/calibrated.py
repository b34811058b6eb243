"""A sensor some of whose parameters are states: focal length, bias, delay. `Sen.frame_type` of it has them, too."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from .behind import frame_with

UNIVERSAL = "bias", "delay"
"""Parameters that the observation chain knows how to give to any sensor of points; they begin at zero."""


@dataclass(frozen=True)
class Calibrated:
    """A sensor model with parameters that are states of the map: they stand behind its frame in `Sen`'s state.

    A model says in `parameters` which of its fields may be, and has the derivatives by them, in that order:
    `project_parameters(p)` and, if it has `retro`, `retro_parameters(y)`. It may say in `tied` which numbers move
    several of a field together, and how, in `tie(name)`: the focal length of a camera. Any sensor of points may have a
    `bias` of what it measures, y = h + bias; and a `delay` of its stamps, s, if its robot has a velocity (see
    `Moving.compose`).

    What `project` gets has the parameters behind the point, [p; parameters], as `to_sensor` puts them there; what
    `retro` gets has them behind the measurement. Without them, the parameters are those of the model.

    Parameters
    ----------
    model : SensorModel
    names : tuple of str
        Which parameters are states.

    Raises
    ------
    ValueError
        For a parameter that cannot be one.

    See Also
    --------
    state_class : The class of its state.
    seen_with, begun_with : How its parameters come into the observation chain.
    check_parameters : Tests the derivatives of a model by its parameters.
    """

    model: Any
    names: tuple

    def __post_init__(self):
        kind, own = type(self.model).__name__, tuple(getattr(self.model, "parameters", ()))
        own += tuple(getattr(self.model, "tied", ()))
        known = () if hasattr(self.model, "innovation") else own + UNIVERSAL  # a line is another thing than a point
        for name in self.names:
            if name not in known:
                raise ValueError(f"{name!r} of {kind} cannot be a state; possible: {', '.join(known) or 'none'}")
        if len(set(self.names)) < len(self.names):
            raise ValueError(f"{kind}: a parameter is named twice in {list(self.names)}")
        if both := [
            n for n in self.names if n in getattr(self.model, "tied", ()) and self.model.tie(n)[0] in self.names
        ]:
            raise ValueError(f"{kind}: {both[0]} is a part of {self.model.tie(both[0])[0]}; let one of them be a state")
        if "d" in self.names and getattr(self.model, "c", None) is not None:
            raise ValueError(f"{kind}: c is the inverse of one d only; leave it out where d is a state")

    def __getattr__(self, name):
        if name.startswith("__") or name == "model":
            raise AttributeError(name)
        if name == "asks_robot" and "delay" in self.names:
            return "moving"
        if name == "retro":  # it has the way back if its model has it
            return self._retro if hasattr(self.model, "retro") else self.model.retro
        return getattr(self.model, name)

    @property
    def start(self):
        """The model's own values of the parameters, one after the other."""
        return np.concatenate([np.ravel(self._value(name)) for name in self.names]).astype(float)

    def _value(self, name):
        if name == "bias":
            return np.zeros(len(self.model.R))
        if name in getattr(self.model, "tied", ()):
            return self.model.tie(name)[2]
        return 0.0 if name == "delay" else getattr(self.model, name)

    def slices(self):
        """Slice of each parameter among all, by name.

        See Also
        --------
        at : The model with them.
        """
        ends = np.cumsum([np.size(self._value(name)) for name in self.names]).tolist()
        return {n: slice(a, b) for n, a, b in zip(self.names, [0, *ends], ends, strict=False)}

    def at(self, a):
        """The model with these parameters, and the bias.

        See Also
        --------
        start : The parameters that the model has by itself.
        """
        at, tied = self.slices(), getattr(self.model, "tied", ())
        values = {n: a[at[n]] for n in self.names if n not in (*UNIVERSAL, *tied)}
        for of, K, start, value in ((*self.model.tie(n), a[at[n]]) for n in self.names if n in tied):
            values[of] = np.asarray(getattr(self.model, of)) + K * (value - start)
        given = {n: tuple(v.tolist()) if np.ndim(getattr(self.model, n)) else v.item() for n, v in values.items()}
        return replace(self.model, **given) if given else self.model, a[at["bias"]] if "bias" in at else 0.0

    def _parted(self, v, n):
        """Split [v; parameters] after n numbers: v, the model at them, the bias, and whether there are any."""
        there = v.shape[-1] > n
        a = v.reshape(-1, v.shape[-1])[0, n:] if there and v.size else self.start
        return v[..., :n], *self.at(a), there

    def _size(self):
        """Length of what the model itself gets: a point, or a frame, and a velocity behind it."""
        d = self.model.dim
        dof = 3 if d == 2 else 6
        point = (3 if d == 2 else 7) if hasattr(self.model, "without_lmks") else d
        return point + dof * (getattr(self.model, "asks_robot", "") == "moving")

    def project(self, v):
        """Measurement by the model of [v; parameters]. Returns y, Y_v; derivatives by the parameters come last."""
        v, model, bias, there = self._parted(v, self._size())
        y, Y_v = model.project(v)
        if not there:
            return y, Y_v
        Y_v = np.broadcast_to(Y_v, (*y.shape, v.shape[-1]))
        return y + bias, np.concatenate([Y_v, self._by(getattr(model, "project_parameters", None), v, y, 1.0)], -1)

    def _retro(self, y):
        """The way back from [y; parameters]. Returns v, V_y; derivatives by the parameters come last."""
        y, model, bias, there = self._parted(y, len(self.model.R))
        v, V_y = model.retro(y - bias)
        if not there:
            return v, V_y
        V_y = np.broadcast_to(V_y, (*v.shape, y.shape[-1]))
        return v, np.concatenate([V_y, self._by(getattr(model, "retro_parameters", None), y - bias, v, -V_y)], -1)

    def _by(self, derivatives, v, out, by_bias):
        """Derivatives of `out` by all parameters, side by side; the delay has been told to the frame already."""
        J = np.zeros((*out.shape, len(self.start)))
        known = dict(zip(getattr(self.model, "parameters", ()), derivatives(v)[1:], strict=True)) if derivatives else {}
        for name in getattr(self.model, "tied", ()) if derivatives else ():
            of, K, _ = self.model.tie(name)
            known[name] = (known[of] @ K)[..., None]
        for name, at in self.slices().items():
            if name != "delay":
                bias = by_bias * np.eye(out.shape[-1]) if np.ndim(by_bias) == 0 else by_bias
                J[..., at] = bias if name == "bias" else known[name]
        return J

    def visible(self, y, v):
        """Return True for each point that the model sees with these parameters."""
        v, model, bias, _ = self._parted(v, self._size())
        return model.visible(y - bias, v)


def seen_with(Rf, Sf, sensor, v, V_r, V_s, V_l):
    """Point that a sensor sees, and behind it all else that it asks for: its velocity, its parameters.

    Parameters
    ----------
    Rf : Frame2, Frame3 or Moving
    Sf : Frame2, Frame3, or of a `frame_with`
    sensor : SensorModel
    v, V_r, V_s, V_l
        As of `to_sensor`, without.

    Returns
    -------
    v : ndarray, shape (..., d + dof + k)
    V_r, V_s, V_l : ndarray, shape (..., d + dof + k, size)

    See Also
    --------
    Moving.velocity : The velocity.
    Calibrated.project : What becomes of it.
    """
    parts = [(v, V_r, V_s, V_l)]
    if getattr(sensor.model if isinstance(sensor, Calibrated) else sensor, "asks_robot", "") == "moving":
        parts.append((*Rf.velocity(Sf), np.zeros((1, 0))))
    if hasattr(Sf, "a"):
        k = len(Sf.a)
        parts.append((Sf.a, np.zeros((k, 0)), np.eye(Sf.size)[-k:], np.zeros((k, 0))))
    shape, ends = v.shape[:-1], np.cumsum([p[0].shape[-1] for p in parts]).tolist()
    seen = [np.zeros((*shape, ends[-1]))]
    seen += [np.zeros((*shape, ends[-1], n)) for n in (Rf.size, Sf.size, V_l.shape[-1])]
    for (value, *by), a, b in zip(parts, [0, *ends], ends, strict=False):
        seen[0][..., a:b] = value
        for whole, J in zip(seen[1:], by, strict=True):
            whole[..., a:b, : J.shape[-1]] = J
    return tuple(seen)


def begun_with(Sf, L_s, L_y, m):
    """Derivatives of a birth from [y; parameters]: those by the parameters go to L_s, those by y stay.

    Parameters
    ----------
    Sf : of a `frame_with`
    L_s, L_y : ndarray, shape (..., n, ·)
        By the frame, or the whole state; and by [y; parameters].
    m : int
        How many numbers y has.

    Returns
    -------
    L_s, L_y : ndarray, shape (..., n, Sf.size) and (..., n, m)

    See Also
    --------
    seen_with : The same of the direct model.
    """
    whole = np.zeros((*L_y.shape[:-1], Sf.size))
    whole[..., : L_s.shape[-1]] = L_s
    whole[..., Sf.size - len(Sf.a) :] += L_y[..., m:]
    return whole, L_y[..., :m]


def state_class(frame, sensor) -> Any:
    """Class of the state of a sensor on its robot: `frame` itself, or with the parameters that are states behind it.

    See Also
    --------
    frame_with : Makes it.
    """
    if not isinstance(sensor, Calibrated):
        return frame
    delay = sensor.slices().get("delay")
    return frame_with(frame, len(sensor.start), None if delay is None else frame.size + delay.start)
