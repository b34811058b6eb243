"""Exercise 24.2: normalised cross-correlation."""

import numpy as np

from ..table import table


def ncc(patch, windows):
    """Normalised cross-correlation of a patch with n windows of an image.

    patch, shape (s, s), and windows, shape (n, s, s), hold grey values, whole numbers from 0 to 255. From each of them
    its own mean is taken off, and it is divided by its length, the root of the sum of the squares of what is left. The
    correlation is the sum of the products of what is then in the same places.
    Return n numbers from -1 to 1, shape (n,). Where the patch or a window is flat, all of one grey, it is 0.
    """
    a = patch - np.mean(patch)
    b = windows - np.mean(windows, axis=(1, 2), keepdims=True)
    length = np.sqrt(np.sum(a**2) * np.sum(b**2, axis=(1, 2)))
    return np.sum(a * b, axis=(1, 2)) / np.where(length > 0, length, 1.0)


def grey(rng, *shape):
    """Grey values as whole numbers, somewhere between 0 and 255."""
    return rng.integers(20, 230, shape).astype(float)


def case(rng, n=5, s=5):
    """A patch, and windows that have nothing to do with it."""
    return grey(rng, s, s), grey(rng, n, s, s)


def brighter(rng, gain, offset, n=4):
    """The same patch with other contrast and brightness, each window its own."""
    patch = grey(rng, 5, 5)
    return patch, np.array([gain * (k + 1) * patch + offset * k for k in range(n)])


def bytes_(rng):
    """As a camera gives them: 8 bits a pixel."""
    return rng.integers(0, 256, (5, 5)).astype(np.uint8), rng.integers(0, 256, (4, 5, 5)).astype(np.uint8)


def flat(rng):
    """Windows without any contrast, and a patch without."""
    windows = grey(rng, 4, 5, 5)
    windows[1] = 90.0
    windows[3] = 0.0
    return [(grey(rng, 5, 5), windows), (np.full((5, 5), 120.0), grey(rng, 3, 5, 5)), (np.full((5, 5), 80.0), windows)]


correlation = table(
    "24.2 Normalised cross-correlation",
    ncc,
    hints=(
        "Two things must not count: how bright the light is, and how strong the contrast. The mean takes the first.",
        "a = patch - mean, b = window - mean of that window; sum(a b) / sqrt(sum(a^2) sum(b^2)). Sums go over axis=(1, 2).",
        "np.mean(windows, axis=(1, 2), keepdims=True) has the shape (n, 1, 1): it can be taken off. Divide by the length where it is above 0, by 1 elsewhere.",
    ),
    returns="score",
    cases={
        "any": lambda rng: [case(rng), case(rng, 2, 7), case(rng, 1, 3)],
        "itself": lambda rng: [brighter(rng, 1.0, 0.0, 1)],
        "light": lambda rng: [brighter(rng, 1.0, 30.0), brighter(rng, 1.0, -12.0)],
        "contrast": lambda rng: [brighter(rng, 0.5, 10.0), brighter(rng, 0.2, 0.0), brighter(rng, 0.003, 90.0)],
        "negative": lambda rng: [brighter(rng, -1.0, 200.0, 2)],
        "flat": flat,
        "bytes": lambda rng: [bytes_(rng) for _ in range(3)],
    },
    checks="""
    a patch and itself | score | itself   | The correlation of a patch with itself is 1: sum(a b) is divided by both lengths, sqrt(sum(a^2)) and sqrt(sum(b^2)).
    more light         | score | light    | Each window is the patch times a factor, plus a constant: 1 comes out. The constant goes with the mean, of each window its own; the factor goes with the length of what is left.
    more contrast      | score | contrast | A factor on all pixels, here also a small one, which makes decimals and little contrast: 1 comes out. The factor goes with the length of what is left without the mean. Only a window of one grey is flat.
    a negative         | score | negative | Where the patch is bright the window is dark: -1. Keep the sign.
    any windows        | score | any      | sum(a b) / sqrt(sum(a^2) sum(b^2)), over the rows and columns of each window.
    flat windows       | score | flat     | A flat window has the length 0, and so has a flat patch; 0 / 0 is no number. The correlation is 0 there; the other windows of such a case are compared as ever.
    8 bits             | score | bytes    | Grey values of 8 bits have no room for squares: change them into float before you multiply.
    """,
    wrong="""
    mean over the windows | np.mean(windows, axis=(1, 2), keepdims=True) -> np.mean(windows, axis=0) | That is the mean over the windows, pixel by pixel (axis 0). Each window has its own mean: axis=(1, 2).
    mean not taken off: Take the mean off, of the patch and of each window: else a bright place correlates with everything.
        a = patch - np.mean(patch) -> a = patch + 0.0
        b = windows - np.mean(windows, axis=(1, 2), keepdims=True) -> b = windows + 0.0
    mean of the windows not taken off | b = windows - np.mean(windows, axis=(1, 2), keepdims=True) -> b = windows + 0.0 | Each window has its own brightness: take its mean off, too.
    mean of the patch not taken off | a = patch - np.mean(patch) -> a = patch + 0.0 | The patch has a brightness of its own: take its mean off, too.
    one mean for all windows | np.mean(windows, axis=(1, 2), keepdims=True) -> np.mean(windows) | Each window has its own mean: np.mean(windows, axis=(1, 2), keepdims=True).
    mean of the patch for all | np.mean(windows, axis=(1, 2), keepdims=True) -> np.mean(patch) | From each window *its own* mean is taken off, not that of the patch.
    not divided | / np.where(length > 0, length, 1.0) -> / 1.0 | Divide by both lengths: without that, a window of strong contrast wins whatever it shows.
    divided by the patch alone | np.sum(a**2) * np.sum(b**2, axis=(1, 2)) -> np.sum(a**2) ** 2 + 0 * np.sum(b**2, axis=(1, 2)) | Divide by the length of the window, too: its contrast must not count.
    divided by the window alone | np.sum(a**2) * np.sum(b**2, axis=(1, 2)) -> np.sum(b**2, axis=(1, 2)) ** 2 | Divide by the length of the patch, too.
    no root | np.sqrt(np.sum(a**2) * np.sum(b**2, axis=(1, 2))) -> np.sum(a**2) * np.sum(b**2, axis=(1, 2)) | The length is the *root* of the sum of the squares.
    lengths added | np.sum(a**2) * np.sum( -> np.sum(a**2) + np.sum( | The two lengths are multiplied, not added.
    one length for all windows | np.sum(b**2, axis=(1, 2)) -> np.sum(b**2) | Each window has its own length: sum over axis=(1, 2) only.
    mean of the products | return np.sum(a * b, axis=(1, 2)) -> return np.mean(a * b, axis=(1, 2)) | A sum above and sums below: or means above and below, but not mixed.
    absolute value | return np.sum(a * b, axis=(1, 2)) -> return np.abs(np.sum(a * b, axis=(1, 2))) | A negative is no match: keep the sign.
    squared | return np.sum(a * b, axis=(1, 2)) -> return np.sum(a * b, axis=(1, 2)) ** 2 | No square: the sign tells a patch from its negative.
    distance | return np.sum(a * b, axis=(1, 2)) -> return np.sum((a - b) ** 2, axis=(1, 2)) | That is a squared difference: it grows with more light. Here the *products* are summed.
    flat is not a number | np.where(length > 0, length, 1.0) -> length | A flat window has the length 0: 0 / 0 is not a number. There the correlation is 0.
    flat counts as one | return np.sum(a * b, axis=(1, 2)) / np.where(length > 0, length, 1.0) -> return np.where(length > 0, np.sum(a * b, axis=(1, 2)) / np.where(length > 0, length, 1.0), 1.0) | Where a window is flat there is nothing to compare: there the correlation is 0, not 1.
    no root for the windows | np.sqrt(np.sum(a**2) * np.sum(b**2, axis=(1, 2))) -> np.sqrt(np.sum(a**2)) * np.sum(b**2, axis=(1, 2)) | The length of a window is the *root* of the sum of its squares, as that of the patch is.
    no root for the patch | np.sqrt(np.sum(a**2) * np.sum(b**2, axis=(1, 2))) -> np.sum(a**2) * np.sqrt(np.sum(b**2, axis=(1, 2))) | The length of the patch is the *root* of the sum of its squares, as that of a window is.
    a mean for each row | np.mean(windows, axis=(1, 2), keepdims=True) -> np.mean(windows, axis=2, keepdims=True) | Each window has one mean, of all its pixels, not one for each row: axis=(1, 2).
    negative ones cut off | return np.sum(a * b, axis=(1, 2)) -> return np.maximum(0, np.sum(a * b, axis=(1, 2))) | Where the patch is bright and the window dark the correlation is negative, down to -1: leave it so.
    largest singular value for the length: The length of a window is the root of the sum of the squares of all its pixels. `np.linalg.norm` with ord=2 and two axes is another norm: leave ord out.
        np.sum(b**2, axis=(1, 2)) -> np.linalg.norm(b, 2, axis=(1, 2)) ** 2
    patch turned over | a = patch - np.mean(patch) -> a = (patch - np.mean(patch))[::-1, ::-1] | What is in the *same* places is multiplied. Turned over, as in a convolution, the patch is another one.
    a mean for each column | np.mean(windows, axis=(1, 2), keepdims=True) -> np.mean(windows, axis=1, keepdims=True) | Each window has one mean, of all its pixels, not one for each column: axis=(1, 2).
    too large by the side: Yours is larger by a factor, the side of the window: lengths are roots of *sums* of squares. With standard deviations in their place, roots of means, divide by the number of pixels, too.
        length = np.sqrt(np.sum(a**2) * np.sum(b**2, axis=(1, 2))) -> length = np.sqrt(np.sum(a**2) * np.sum(b**2, axis=(1, 2))) / len(patch)
    lengths before the mean is off | length = np.sqrt(np.sum(a**2) * np.sum(b**2, axis=(1, 2))) -> length = np.sqrt(np.sum(np.square(patch + 0.0)) * np.sum(np.square(windows + 0.0), axis=(1, 2))) | The length is that of what is left after the mean is off, of the patch and of each window.
    all flat as soon as one is | / np.where(length > 0, length, 1.0) -> / np.where(length > 0, length, 1.0) * (length > 0).all() | Only the flat window has the correlation 0: the others are compared as ever.
    """,
)
