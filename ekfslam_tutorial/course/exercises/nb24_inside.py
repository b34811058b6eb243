import numpy as np


def inside(pixels, e, S, k):
    """Which pixels are worth a look: those inside the k-sigma ellipse of what is expected.

    pixels, shape (n, 2), are places [u, v] in the image (px). The filter expects the landmark at e, shape (2,), and
    S, shape (2, 2), is the covariance of the innovation: that of the expectation and of the noise (px^2). A pixel on the
    ellipse counts as inside.
    Return n truth values, shape (n,).
    """
    z = pixels - e
    return np.sum(z * np.linalg.solve(S, z.T).T, axis=1) <= k**2
