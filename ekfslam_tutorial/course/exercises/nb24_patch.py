"""Exercise 24.1: a patch of an image, its mean and its contrast."""

import numpy as np

from ..table import table


def patch_of(image, y, h):
    """The patch around a pixel, its mean and its contrast.

    image, shape (rows, columns), holds grey values, whole numbers from 0 to 255. y = [u; v], shape (2,), is a place in
    it (px): u counts the columns, v the rows. It is rounded to the next whole pixel (`np.rint`); at least h pixels are
    around that one on each side.
    Return the patch, shape (2 h + 1, 2 h + 1), with that pixel in its middle, its mean, and its contrast: the standard
    deviation of its grey values, the root of the mean of (grey - mean)^2.
    """
    u, v = np.rint(y).astype(int)
    patch = image[v - h : v + h + 1, u - h : u + h + 1].astype(float)
    return patch, np.mean(patch), np.std(patch)


def image(rng, dark=False):
    """A small image, wider than high; of whole numbers, as a camera gives it."""
    high = 60 if dark else 256
    return rng.integers(0, high, (40, 60)).astype(np.uint8)


def case(rng, y, h=3, **look):
    """An image and a place in it."""
    return image(rng, **look), np.array(y, float), h


cut = table(
    "24.1 A patch of the image",
    patch_of,
    hints=(
        "An image is an array of rows: its first index is v, its second is u. A slice ends before its last number.",
        "Round y to whole numbers first. Rows v - h to v + h, so image[v - h : v + h + 1, ...].",
        "Cut image[v - h : v + h + 1, u - h : u + h + 1] and take np.mean and np.std of it.",
    ),
    returns="patch, mean, contrast",
    cases={
        "any": lambda rng: [case(rng, y, h) for y, h in (([40, 20], 3), ([12, 30], 5), ([50, 9], 1), ([30, 25], 2))],
        "between": lambda rng: [case(rng, y) for y in ([40.6, 20.2], [12.4, 30.7], [50.8, 9.9], [20.5, 11.5])],
        "at the edge": lambda rng: [case(rng, y) for y in ([3, 3], [56, 36], [3, 36])],
        "bright": lambda rng: [(np.full((20, 20), 200, np.uint8), np.array([10.0, 9.0]), 4), case(rng, [30, 20], 6)],
    },
    checks="""
    size and place    | patch    | any         | The patch has 2 h + 1 rows and columns, and the pixel y = [u; v] is in its middle: v is the row, u the column.
    between pixels    | patch    | between     | A place between pixels counts as the nearest whole pixel, by np.rint: 40.6 is 41. A half goes to the even number: 20.5 is 20, 11.5 is 12.
    at the edge       | patch    | at the edge | A patch that just fits into the image is cut like any other.
    mean              | mean     | any         | The sum of the grey values of the patch, as floats, divided by their number.
    contrast          | contrast | any         | The root of the mean of (grey - mean)^2 in the patch, with the grey values as floats.
    bright patches    | mean, contrast | bright | Grey values are whole numbers of 8 bits: 200 + 200 has no room in them. Change them into float first.
    """,
    wrong="""
    u and v swapped | image[v - h : v + h + 1, u - h : u + h + 1] -> image[u - h : u + h + 1, v - h : v + h + 1] | An image is an array of rows: the first index is v (down), the second u (to the right).
    transposed | u - h : u + h + 1].astype(float) -> u - h : u + h + 1].astype(float).T | The rows of the patch are rows of the image: do not turn it.
    one row too few | image[v - h : v + h + 1, u - h : u + h + 1] -> image[v - h : v + h, u - h : u + h] | A slice ends *before* its last number: v - h : v + h + 1 has 2 h + 1 rows.
    y at the corner | image[v - h : v + h + 1, u - h : u + h + 1] -> image[v : v + 2 * h + 1, u : u + 2 * h + 1] | The pixel y is in the middle of the patch, h to each side, not at its corner.
    cut off instead of rounded | np.rint(y).astype(int) -> y.astype(int) | Cut off, 40.6 becomes 40. Round first, np.rint.
    rounded up | np.rint(y) -> np.ceil(y) | np.ceil rounds up always; the *nearest* whole pixel is np.rint.
    patch less its mean | return patch, -> return patch - np.mean(patch), | Return the grey values as they are; the mean is taken off later.
    variance | np.std(patch) -> np.var(patch) | The contrast is a standard deviation: the root of the variance.
    n - 1 | np.std(patch) -> np.std(patch, ddof=1) | The mean of (grey - mean)^2: divide by the number of pixels, not by one less.
    brightest less darkest | np.std(patch) -> np.ptp(patch) | Brightest less darkest hangs on two pixels: the contrast is the standard deviation of all.
    mean distance | np.std(patch) -> np.mean(np.abs(patch - np.mean(patch))) | The root of the mean of the *squares*, not the mean of the absolute values.
    median | np.mean(patch), -> np.median(patch), | The mean, not the median.
    mean of each column | np.mean(patch), -> patch.mean(axis=0), | One mean for the whole patch, a number: without axis=0.
    mean of the image | np.mean(patch), -> np.mean(image), | The mean of the patch, not of the whole image.
    contrast of the image | np.std(patch) -> np.std(image) | The contrast of the patch, not of the whole image.
    mean and contrast swapped | return patch, np.mean(patch), np.std(patch) -> return patch, np.std(patch), np.mean(patch) | First the mean, then the contrast.
    mean not taken off | np.std(patch) -> np.sqrt(np.mean(patch**2)) | The contrast is the spread about the mean: take the mean off before the squares.
    one pixel too far up and left | image[v - h : v + h + 1, u - h : u + h + 1] -> image[v - h - 1 : v + h, u - h - 1 : u + h] | The pixel is in the middle: rows v - h to v + h, both of them included, and so with the columns.
    upside down | u - h : u + h + 1].astype(float) -> u - h : u + h + 1].astype(float)[::-1] | v counts downwards, as the rows of the image do: leave them in their order.
    sum of the squares | np.std(patch) -> np.sqrt(np.sum((patch - np.mean(patch)) ** 2)) | The root of the *mean* of the squares: divide their sum by the number of pixels.
    mean of the contrasts of the columns | np.std(patch) -> np.std(patch, axis=0).mean() | One contrast for the whole patch: all grey values about its one mean, not the mean over the columns.
    turned round | patch = image[v - h : v + h + 1, u - h : u + h + 1].astype(float) -> patch = image[v - h : v + h + 1, u - h : u + h + 1].astype(float)[::-1, ::-1] | What is above and to the left of the pixel stands there in the patch, too: v + dv, u + du.
    squares of bytes: Grey values of 8 bits have no room for their squares, which are counted modulo 256. Change the patch into float before you multiply: .astype(float).
        np.std(patch) -> np.sqrt(max(np.mean(np.square(patch.astype(np.uint8))) - np.mean(patch) ** 2, 0.0))
    squares of bytes, a root of less than nothing: Grey values of 8 bits have no room for their squares, which are counted modulo 256. Change the patch into float before you multiply: .astype(float).
        np.std(patch) -> np.sqrt(np.mean(np.square(patch.astype(np.uint8))) - np.mean(patch) ** 2)
    differences of bytes: Grey values of 8 bits have no room for differences below zero, nor for squares: both are counted modulo 256. Change the patch into float before you subtract: .astype(float).
        np.std(patch) -> np.sqrt(np.mean(np.square(patch.astype(np.uint8) - np.mean(patch).astype(np.uint8))))
    """,
)
