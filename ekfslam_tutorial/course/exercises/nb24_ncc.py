import numpy as np


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
