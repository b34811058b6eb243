import numpy as np


def agreeing(z, E, R, limit):
    """1-point RANSAC: the largest set of matches that one of them explains.

    z, shape (K, 2), are the innovations of K matches of one frame (px). E, shape (K, 2, K, 2), is the joint covariance of
    what was expected: E[j, :, i] is H_j P H_i', shape (2, 2). R, shape (2, 2), is the noise of each match.
    If the map were corrected by match i alone, the expectation of match j would move by E_ji (E_ii + R)^-1 z_i. The matches
    whose innovation is then shorter than `limit` (px) agree with match i.
    Return K truth values: the set of the match with which most agree; of the first such one, if there are several.
    """
    best = np.zeros(len(z), bool)
    for i in range(len(z)):
        move = E[:, :, i] @ np.linalg.solve(E[i, :, i] + R, z[i])
        agree = np.linalg.norm(z - move, axis=1) < limit
        if agree.sum() > best.sum():
            best = agree
    return best
