"""Where many landmarks are: those of one type at once."""

import numpy as np


def points_of(map, lmks):
    """Euclidean points of landmarks, and their derivatives.

    Parameters
    ----------
    map : Map, or a map of the wing
    lmks : sequence of Lmk

    Returns
    -------
    p : ndarray, shape (n, d)
        Metres, in the frame of the map.
    P_l : list of ndarray, shape (d, size)
        By the state of each.

    See Also
    --------
    ekfslam_tutorial.slam.Lmk.point : The same for one, with its covariance.
    """
    p, P_l, kinds = [np.zeros(0)] * len(lmks), [np.zeros((0, 0))] * len(lmks), [lmk.type for lmk in lmks]
    for kind in dict.fromkeys(kinds):
        these = [i for i, other in enumerate(kinds) if other == kind]
        points, J = kind.point(np.array([lmks[i].state(map) for i in these]))
        for i, point, J_i in zip(these, points, np.broadcast_to(J, (len(these), *J.shape[-2:])), strict=True):
            p[i], P_l[i] = point, J_i
    return np.array(p), P_l
