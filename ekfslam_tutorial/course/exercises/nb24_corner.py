import numpy as np


def corner_score(windows):
    """How good a corner each of n windows of an image is: the smaller eigenvalue of Shi and Tomasi.

    windows, shape (n, s, s), are grey values. The slopes along the columns and along the rows are those of
    `g_v, g_u = np.gradient(windows, axis=(1, 2))`, each of the shape (n, s, s). Summed over a window, the products of
    the slopes make the matrix A = [[sum g_u g_u, sum g_u g_v], [sum g_u g_v, sum g_v g_v]].
    Return the smaller eigenvalue of each A, shape (n,).
    """
    g_v, g_u = np.gradient(windows, axis=(1, 2))
    g = np.stack([g_u, g_v], axis=1)
    A = np.einsum("niab,njab->nij", g, g)
    return np.linalg.eigvalsh(A)[:, 0]
