"""Exercise 24.1: a patch of an image, its mean and its contrast."""

import numpy as np


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
