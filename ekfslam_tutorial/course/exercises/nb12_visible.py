"""Exercise 12.3: which points does the camera see?"""

import numpy as np

from ..table import table


def visible(p, u, size, fold):
    """Which of N points does the camera see?

    p, shape (N, 3), are the points in the frame of the camera, z ahead; z is never zero. u, shape (N, 2), are the
    pixels that the model gives for them. size, shape (2,), is [width, height] of the image in pixels; its corner is
    the pixel [0, 0], and points on its border count as seen.
    fold, a number, is the length of up = [x/z, y/z] at which the lens folds back, maybe infinite: only points nearer
    to the axis are seen.
    Return N truth values, shape (N,).
    """
    inside = np.all((u >= 0) & (u <= size), axis=1)
    ahead = p[:, 2] > 0
    r = np.linalg.norm(p[:, :2], axis=1) / np.abs(p[:, 2])
    return inside & ahead & (r < fold)


SIZE, UPRIGHT = np.array([640.0, 480.0]), np.array([480.0, 640.0])


def in_image(rng, n):
    """Pixels well inside the image."""
    return rng.uniform([20, 20], [300, 220], (n, 2))


def in_front(rng, n, r=0.5):
    """Points ahead of the camera, near ones, too, at the distance r from its axis."""
    a, z = rng.uniform(-np.pi, np.pi, n), rng.permutation(np.geomspace(0.05, 8, n))
    return z[:, None] * np.column_stack([r * np.cos(a), r * np.sin(a), np.ones(n)])


def pixels(rng, us, size=SIZE):
    """Two points for each pair of pixels, so that a message can show them."""
    us = np.array(us, float)
    return [(in_front(rng, 2), us[i : i + 2], size, np.inf) for i in range(0, len(us), 2)]


def radii(rng, one, other, fold):
    """One point nearer to the axis than the other."""
    return [(np.vstack([in_front(rng, 1, one), in_front(rng, 1, other)]), in_image(rng, 2), SIZE, fold)] * 2


OUT = [[-5, 240], [300, 200], [645, 240], [320, -5], [320, 485], [500, 470], [630, 300], [-3, -3], [700, 500], [5, 5]]
OUT += [[-0.3, 240], [640.4, 200], [320, -0.7], [300, 480.6]]  # by less than a pixel
CORNERS = [[0, 0], [640, 480], [0, 480], [640, 0], [0, 300], [300, 480]]
ON_THE_FOLD = np.array([[3.0, 0, 3], [0, -2, 2], [0.5, 0, 1], [0, 4, 2]])  # at 1, 1, 1/2 and 2, exactly


def _random(rng):
    p = np.vstack([in_front(rng, 20, 0.6), in_front(rng, 10, 1.2), in_front(rng, 10, 3.0), -in_front(rng, 20, 0.6)])
    return p, rng.uniform(-200, 850, (60, 2)), SIZE, 0.9


seen = table(
    "12.3 What the camera sees",
    visible,
    hints=(
        "Three conditions, and all of them must hold: ahead of the camera, in the image, not beyond the fold.",
        "Ahead: z > 0. In the image: 0 <= u <= width, 0 <= v <= height. Before the fold: sqrt(x^2 + y^2) / z < fold.",
        "Join arrays of truth values with &, each in brackets: (a > 0) & (b < c). u >= 0 tests both columns at once; np.all(..., axis=1) joins them.",
    ),
    returns="seen",
    cases={
        "any": lambda rng: [(in_front(rng, n), in_image(rng, n), SIZE, np.inf) for n in (4, 3, 2, 1)],
        "behind": lambda rng: [
            (side * in_front(rng, n), in_image(rng, n), SIZE, fold)
            for side, n, fold in ((-1, 2, np.inf), (1, 2, 0.7), (-1, 2, 0.7), (-1, 4, np.inf))
        ],
        "image": lambda rng: [
            *pixels(rng, OUT),
            *pixels(rng, [[300, 700], [700, 300], [460, 620], [300, 500]], UPRIGHT),
        ],
        "border": lambda rng: pixels(rng, CORNERS),
        "fold": lambda rng: [*radii(rng, 0.5, 1.5, 0.7), *radii(rng, 0.95, 1.05, 1.0), *radii(rng, 0.65, 0.78, 0.7)],
        "on the fold": lambda rng: [(ON_THE_FOLD, in_image(rng, 4), SIZE, 1.0)],
        "random": lambda rng: [_random(rng) for _ in range(3)],
    },
    checks="""
    one truth value for each point | seen | any    | All these points are seen: ahead, near or far, in the image, and fold is infinite. One truth value for each row: & joins conditions, np.all(..., axis=1) the columns of u.
    behind the camera              | seen | behind | All these points are in the image, and [x/z, y/z] has the length 0.5, less than fold. Those with z > 0 are seen, those with z < 0 are behind the camera. The formula gives the same pixel for p and -p.
    outside the image              | seen | image  | Each point is judged by its own pixel: seen are those with 0 <= u <= width and 0 <= v <= height, four borders.
    on the border                  | seen | border | All these points are on the border, some in a corner, and are seen: 0 <= u <= width and 0 <= v <= height, four borders.
    beyond the fold                | seen | fold   | Seen is what is nearer to the axis than the fold: sqrt(x^2 + y^2) / z is less than fold. Here this holds for one of two points. Beyond the fold two points share a pixel.
    on the fold                    | seen | on the fold | Points nearer to the axis than the fold are seen. Here [x/z, y/z] has the lengths 1, 1, 0.5 and 2, and fold is 1: the third point is seen.
    all together                   | seen | random | A point is seen where all three hold: z > 0, the pixel in the image, the radius less than fold. Here some points fail one of them, some two.
    """,
    wrong="""
    no test of the depth | p[:, 2] > 0 -> p[:, 2] != 0 | A point behind the camera has a pixel, too: that of the point -p. Only z > 0 is ahead.
    z turned round | p[:, 2] > 0 -> p[:, 2] < 0 | z points ahead: what is seen has z > 0.
    x ahead | p[:, 2] > 0 -> p[:, 0] > 0 | The camera's axes are x right, y down, z ahead: z > 0.
    width and height swapped | u <= size -> u <= size[::-1] | size is [width, height]: u goes with the width, v with the height.
    centre of the image at zero | (u >= 0) & (u <= size) -> np.abs(u) <= size / 2 | Pixels are counted from the corner: from 0 to the width, not from minus half.
    one coordinate is enough | np.all( -> np.any( | Both u and v must be inside, one is not enough.
    left and upper border forgotten | (u >= 0) & (u <= size) -> u <= size | A pixel may be negative: 0 <= u is a condition, too.
    right and lower border forgotten | (u >= 0) & (u <= size) -> u >= 0 | The image ends at its width and height: u <= width, v <= height.
    border not seen | (u >= 0) & (u <= size) -> (u > 0) & (u < size) | Points on the border count as seen: >= and <=.
    image not tested | inside & ahead -> ahead | The pixel must lie in the image: 0 <= u <= width, 0 <= v <= height.
    no test of the fold | & (r < fold) -> & True | A point beyond the fold gets a pixel inside the image, but the light does not come there. Test sqrt(x^2 + y^2) / z < fold.
    fold in metres | axis=1) / np.abs(p[:, 2]) -> axis=1) | fold is a length of up = [x/z, y/z]: divide by z before you compare.
    radius not rooted | (r < fold) -> (r**2 < fold) | x^2 + y^2 is the square of the radius: take the root, or square the fold.
    fold on each axis | (r < fold) -> np.all(np.abs(p[:, :2] / p[:, 2:]) < fold, axis=1) | The lens is round: the length of [x/z, y/z] counts, not each of the two.
    beyond, not before | (r < fold) -> (r > fold) | What is seen lies before the fold: radius < fold.
    the fold itself | (r < fold) -> (r <= fold) | Only points *nearer* to the axis than the fold are seen: <, not <=.
    distance for depth | np.abs(p[:, 2]) -> np.linalg.norm(p, axis=1) | up = [x/z, y/z] is divided by the depth z, not by the distance of the point.
    length of the whole vector | np.linalg.norm(p[:, :2], axis=1) -> np.linalg.norm(p, axis=1) | Each point has a radius of its own, sqrt((x/z)^2 + (y/z)^2), of two numbers of its own row: neither z/z = 1 nor the other points belong to it.
    border at the last pixel | (u <= size) -> (u <= size - 1) | Points on the border count as seen, and the border is at the width and the height themselves: u <= width, neither < nor width - 1.
    one condition is enough: All three must hold: & (and), not | (or).
        inside & ahead & (r < fold) -> inside | ahead | (r < fold)
    cut to whole pixels | inside = np.all((u >= 0) & (u <= size), axis=1) -> u = np.trunc(u); inside = np.all((u >= 0) & (u <= size), axis=1) | A pixel at -0.3 lies outside: compare u as it is, not cut or rounded to whole numbers.
    a metre ahead at least | p[:, 2] > 0 -> p[:, 2] > 1 | What is near is seen, too: each z > 0 is ahead.
    an infinite fold: no test of the image | return inside & -> return (inside | ~np.isfinite(fold)) & | Without a fold the other two conditions still hold: inside the image, and ahead.
    an infinite fold: no test of the depth | return inside & ahead -> return inside & (ahead | ~np.isfinite(fold)) | Without a fold the other two conditions still hold: inside the image, and ahead.
    """,
)
