"""First-estimates Jacobians: an EKF-SLAM that does not learn its heading from nothing (`Options.first_estimates`).

No measurement tells where the whole scene, robot and landmarks, lies in the world. A shift of all by a metre, or a turn
of all about the origin, changes none of them: with J a quarter turn, errors along the three columns of

    N = [[I, J p], [0, 1], [I, J l1], [I, J l2], ...]        p, l1, l2 positions,  [0, 1] heading

are unobservable: H N = 0. The EKF computes each H at its latest estimate. Two sightings of a landmark then have two
different N, only the shifts are common to both, and the filter believes that it has measured the turn: its heading
becomes too certain. The cure: one p for each instant and one l for each landmark in *all* Jacobians: the first estimate
there is. That of a landmark is from its birth; that of a pose is the prediction, before any correction.

G. P. Huang, A. I. Mourikis, S. I. Roumeliotis, "Analysis and improvement of the consistency of extended Kalman filter
based SLAM", ICRA 2008, section V; and "Observability-based rules for designing consistent EKF SLAM estimators", IJRR
29(5), 2010. Values, e and x, are computed from the latest estimate, as ever.
"""

import numpy as np

from ..models.landmarks import EucPnt
from ..models.observation import observe


def check_first_estimates(frame, lmk_types):
    """Refuse what first-estimates Jacobians are not made for.

    Parameters
    ----------
    frame : type
        Frame2 or Frame3, of the robot.
    lmk_types : iterable of LmkType

    Raises
    ------
    ValueError
    """
    others = [type(t).__name__ for t in lmk_types if t != EucPnt(2)]
    if frame.dim != 2 or others:
        got = "a robot in space" if frame.dim != 2 else f"landmarks of type {others[0]}"
        raise ValueError(f"first_estimates is for robots in the plane and Euclidean points, got {got}")


def note_first_estimates(map, rob, lmks):
    """Note the first estimates of what has none yet: it is in the map, and no correction has been made by it.

    Parameters
    ----------
    map : Map
    rob : Rob
        Gets `first`, its pose; `move` notes the later ones. A known pose is always its own first estimate.
    lmks : dict of int to Lmk
        Those in the map get `first`, their position; `add_landmark` notes that of a new one.
    """
    if rob.first is None:
        check_first_estimates(rob.motion.frame, [lmk.type for lmk in lmks.values()])
    if rob.first is None or rob.r is None:
        rob.first = rob.state(map)
    for lmk in lmks.values():
        if lmk.r is not None and lmk.first is None:
            lmk.first = lmk.state(map)


def transport(first, x):
    """Matrix from errors about the first estimate of a pose to errors about the present one, x, along N.

        T [J p1, 1] = [J p, 1]:    T = [[I, J (p - p1)], [0, 1]]

    A Jacobian by the present pose, times T, is one by the first pose as far as N is concerned: X_x T N1 = N2 for the
    motion, L_r T N1 = J l for the birth of a landmark l.

    Parameters
    ----------
    first, x : ndarray, shape (..., 3)

    Returns
    -------
    ndarray, shape (..., 3, 3)
    """
    T = np.zeros((*x.shape, 3))
    T[...] = np.eye(3)
    T[..., 0, 2], T[..., 1, 2] = first[..., 1] - x[..., 1], x[..., 0] - first[..., 0]
    return T


def first_jacobians(rob, sen, Sf, lmks):
    """E_r, E_s, E_l of the landmarks of a stack, at the first estimates of the robot's pose and of the landmarks.

    Parameters
    ----------
    rob, sen : Rob, Sen
    Sf : Frame2
        Frame of the sensor on the robot.
    lmks : list of Lmk
        All in the map, or all known.

    Returns
    -------
    E_r, E_s, E_l : ndarray, shape (K, m, 3), (K, m, 3) and (K, m, 2)
    """
    l = np.array([lmk.x if lmk.r is None else lmk.first for lmk in lmks])
    return observe(rob.motion.frame(rob.first), Sf, sen.model, lmks[0].type, l)[1:]
