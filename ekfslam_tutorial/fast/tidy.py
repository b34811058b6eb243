"""Around corrections: who comes first, and which landmarks become Euclidean. As `slam/upkeep.py`, on quick maps."""

import numpy as np

from .core import ALIKE, EUCLIDEAN
from .filter import transform


def most_uncertain(table, ks, n_max):
    """Return these rows of a table by decreasing uncertainty of the expectation, det(E), at most n_max of them."""
    if not ks:
        return []
    size = np.linalg.slogdet(table.E[ks])[1].round(ALIKE)
    order = np.argsort(-size, kind="stable")[:n_max]
    return [ks[i] for i in order.tolist()]


def tidy(map, lmk, camera, opt):
    """Tidy up after a correction: inverse distances stay positive; what has become linear becomes Euclidean."""
    if lmk.r is None:
        return
    if hasattr(lmk.type, "ahead"):
        l = map.state(lmk.r)
        ahead = lmk.type.ahead(l, opt.min_rho)
        if ahead is not l:
            map.set_mean(lmk.r, ahead)
    if opt.reparametrize and hasattr(lmk.type, "linearity"):
        l = map.state(lmk.r)
        if lmk.type.linearity(l, map.block(lmk.r), camera) < opt.lin_test:
            p, P_l = lmk.type.point(l)
            lmk.type, lmk.r = EUCLIDEAN[len(p)], transform(map, lmk.r, p, P_l)
