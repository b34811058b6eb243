"""A world that can be photographed: boards with a texture, and the image that a camera has of them.

Each pixel's ray is followed to the nearest board, lens and all. So what is in the image is known to a part of a pixel.
"""

from dataclasses import dataclass

import numpy as np

GRAIN = 0.004
"""Length of a texture element, m: about what a pixel sees of a desk."""


@dataclass(frozen=True)
class Board:
    """A rectangle in space with a texture.

    Parameters
    ----------
    corner : ndarray, shape (3,)
        Where row 0 and column 0 of the texture are, m.
    right, down : ndarray, shape (3,)
        Unit vectors along its rows and down its columns.
    texture : ndarray, shape (rows, columns)
        Grey values, one every `GRAIN`.
    """

    corner: np.ndarray
    right: np.ndarray
    down: np.ndarray
    texture: np.ndarray

    def point(self, row, column):
        """The place of a texture element in the world, m."""
        return self.corner + GRAIN * (column * self.right + row * self.down)


def board(rng, corner, right, down, width, height):
    """A board with a random texture: smooth clouds, and patches with edges and corners.

    Parameters
    ----------
    rng : numpy.random.Generator
    corner, right, down : sequence of 3 float
    width, height : float
        Metres.
    """
    from scipy.ndimage import gaussian_filter  # here and below: few need it, and all would wait for it

    shape = (int(height / GRAIN) + 1, int(width / GRAIN) + 1)
    texture = 130 + 350 * gaussian_filter(rng.normal(size=shape), 8.0)
    for _ in range(int(shape[0] * shape[1] / 700)):
        row, column, h, w = *(rng.random(2) * shape), *rng.integers(4, 22, 2)
        texture[int(row) : int(row) + h, int(column) : int(column) + w] = rng.uniform(30, 230)
    texture = gaussian_filter(texture, 0.6).clip(0, 255)
    return Board(np.array(corner, float), np.array(right, float), np.array(down, float), texture)


def with_black_rectangle(board, row, column, width, height):
    """The same board with a black rectangle on white.

    Parameters
    ----------
    board : Board
    row, column : int
        Texture element that its upper left corner is at.
    width, height : float
        Metres.

    Returns
    -------
    board : Board
    corners : ndarray, shape (4, 3)
        In the world, from the upper left one clockwise.
    """
    texture, white = board.texture.copy(), 8
    # an edge lies between two elements, where linear interpolation has the mean of both
    h, w = height / GRAIN, width / GRAIN
    rows, columns = np.ogrid[: texture.shape[0], : texture.shape[1]]
    near = (rows > row - white) & (rows < row + h + white) & (columns > column - white) & (columns < column + w + white)
    texture[near] = 215.0
    cover = lambda x, low, high: np.clip(np.minimum(x - low, high - x) + 0.5, 0, 1)
    black = cover(rows, row, row + h) * cover(columns, column, column + w)
    texture = np.where(near, 215.0 - 200.0 * black, texture)
    corners = [board.point(row + a * h, column + b * w) for a, b in ((0, 0), (0, 1), (1, 1), (1, 0))]
    return Board(board.corner, board.right, board.down, texture), np.array(corners)


class Room:
    """Boards, and images of them.

    Parameters
    ----------
    boards : sequence of Board
    sensor : SensorModel
        A camera with an `image_size`.
    """

    def __init__(self, boards, sensor):
        self.boards, self.sensor = boards, sensor
        width, height = (round(n) for n in sensor.image_size)
        pixels = np.stack(np.meshgrid(np.arange(width), np.arange(height)), -1).astype(float)
        self.rays = sensor.retro(pixels)[0]

    def image(self, camera, noise=0.0, rng=None):
        """Image that a camera sees.

        Parameters
        ----------
        camera : Frame3
            In the world.
        noise : float
            Standard deviation of grey values.
        rng : numpy.random.Generator, optional

        Returns
        -------
        ndarray of uint8, shape (height, width)
            Black where no board is.
        """
        from scipy.ndimage import map_coordinates

        rays = self.rays @ camera.R.T
        grey = np.zeros(rays.shape[:2])
        for b, near, at, _ in self._hits(camera, rays):
            grey[near] = map_coordinates(b.texture, at, order=1)
        if noise:
            rng = np.random.default_rng(0) if rng is None else rng
            grey = grey + rng.normal(0, noise, grey.shape)
        return np.rint(grey).clip(0, 255).astype(np.uint8)

    def points(self, camera, pixels):
        """Points of the world that a camera sees at some pixels, and the boards that they are on.

        Parameters
        ----------
        camera : Frame3
        pixels : ndarray, shape (n, 2)

        Returns
        -------
        p : ndarray, shape (n, 3)
            NaN where no board is.
        board : ndarray of int, shape (n,)
            Number of the board; -1 where there is none.
        """
        rays = self.sensor.retro(np.asarray(pixels, float))[0] @ camera.R.T
        p, board = np.full(rays.shape, np.nan), np.full(len(rays), -1)
        for i, (_, near, _, far) in enumerate(self._hits(camera, rays)):
            p[near], board[near] = camera.t + far[:, None] * rays[near], i
        return p, board

    def _hits(self, camera, rays):
        """Board by board: which rays meet it before all boards so far, where in its texture, and how far out."""
        nearest = np.full(rays.shape[:-1], np.inf)
        for b in self.boards:
            normal = np.cross(b.right, b.down)
            with np.errstate(divide="ignore", invalid="ignore"):
                far = (normal @ (b.corner - camera.t)) / (rays @ normal)
            near = (far > 0) & (far < nearest)
            p = camera.t + far[near][:, None] * rays[near] - b.corner
            at = np.stack([p @ b.down, p @ b.right]) / GRAIN
            inside = ((at >= 0) & (at <= np.array(b.texture.shape)[:, None] - 1)).all(0)
            near[near] = inside
            nearest[near] = far[near]
            yield b, near, at[:, inside], far[near]
