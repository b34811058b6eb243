"""Bodies: what a robot and a sensor look like, as faces in their own frames, and how faces move with a frame.

Robots point forward along x (in space: x forward, y left, z up). Sensors in space look along z (x right, y down).
"""

from __future__ import annotations

import numpy as np

Array = np.ndarray

_ARROW = np.array([[1.0, 0.0], [-0.7, 0.6], [-0.35, 0.0], [-0.7, -0.6]])
_FAN = np.array([[0.0, 0.0], [0.6, 0.35], [0.6, -0.35]])
_HULL = np.array([[1.0, 0.0], [0.45, 0.5], [-0.8, 0.5], [-0.8, -0.5], [0.45, -0.5]])


def robot_body(dim: int, size: float) -> list[Array]:
    """Return the faces (n, dim) of a robot that is about 2 `size` long: an arrowhead, or a hull with a bow."""
    if dim == 2:
        return [size * _ARROW]
    low, high = (np.column_stack([_HULL, np.full(len(_HULL), z)]) for z in (-0.15, 0.3))
    sides = [np.stack([low[i - 1], low[i], high[i], high[i - 1]]) for i in range(len(_HULL))]
    return [size * face for face in (low, high, *sides)]


def sensor_body(dim: int, size: float) -> list[Array]:
    """Return the faces of a sensor: a small fan in the plane, a viewing pyramid with its upper side marked in space."""
    if dim == 2:
        return [size * _FAN]
    w, h = 0.6, 0.45
    corners = np.array([[-w, -h, 1.0], [w, -h, 1.0], [w, h, 1.0], [-w, h, 1.0]])
    sides = [np.stack([np.zeros(3), corners[i - 1], corners[i]]) for i in range(4)]
    up = np.array([[-0.3, -1.2 * h, 1.0], [0.3, -1.2 * h, 1.0], [0.0, -1.9 * h, 1.0]])
    return [size * face for face in (corners, *sides, up)]


def move_faces(faces: list[Array], frame) -> list[Array]:
    """Return the faces in the parent of `frame`."""
    return [face @ frame.R.T + frame.t for face in faces]


def outline(faces: list[Array]) -> Array:
    """Return the edges of the faces as one drawing (m, d): each face closed, NaN between them."""
    gap = np.full((1, faces[0].shape[1]), np.nan)
    return np.concatenate([part for face in faces for part in (face, face[:1], gap)])


def ground_grid(limits: Array, step: float, height: float = 0.0) -> Array:
    """Return the lines of the floor over the x and y limits, every `step` metres, as curves (lines, 2, d)."""
    limits = np.asarray(limits, dtype=float)
    (x0, x1), (y0, y1) = limits[:2]
    xs, ys = ticks(limits[0], step), ticks(limits[1], step)
    lines = [[[x, y0], [x, y1]] for x in xs] + [[[x0, y], [x1, y]] for y in ys]
    flat = np.array(lines, dtype=float).reshape(-1, 2, 2)
    if len(limits) == 2:
        return flat
    return np.concatenate([flat, np.full((len(flat), 2, 1), height)], axis=-1)


def ticks(limits: Array, step: float) -> Array:
    """Return the multiples of `step` between two limits."""
    low, high = limits
    return step * np.arange(np.ceil(low / step - 1e-9), np.floor(high / step + 1e-9) + 1)


def nice_step(extent: float, n: int = 8) -> float:
    """Return 1, 2 or 5 times a power of ten, so that about `n` steps make the extent."""
    raw = extent / n
    power = 10.0 ** np.floor(np.log10(raw))
    return power * next(m for m in (1, 2, 5, 10) if m * power >= raw * (1 - 1e-9))
