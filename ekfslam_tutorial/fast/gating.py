"""Which landmarks can matter for the measurements of a frame: found without their covariances, so that most need none.

With the covariance Z = E + R of the innovation z, md2 = z' Z^-1 z is at least z_i^2 / Z_ii for every component i of z.
And E_ii, the variance of a sum of errors H_ij e_j, is at most (sum_j |H_ij| sigma_j)^2, however they are correlated. So

    z_i^2 > gate ((sum_j |H_ij| sigma_j)^2 + R_ii)    for any i

says that a pair does not pass the gate, and needs nothing but the standard deviations of the states.
"""

import numpy as np


def within_gate(map, table, raw, sensor, gate):
    """Landmarks that may be within a gate of some measurement; all others certainly are not.

    Parameters
    ----------
    map : Map
    table : Sightings
        Expectations of the landmarks.
    raw : raw measurements: `y` (k, m), and `R` (k, m, m) or None
    sensor : SensorModel
    gate : float
        Squared Mahalanobis distance.

    Returns
    -------
    ndarray of int
        Their indices in the table.
    """
    spread = np.zeros(table.e.shape)
    for r, J in table.blocks():
        if r is not None:
            spread += np.einsum("...ij,...j->...i", np.abs(J), np.sqrt(map.variances(r)))
    y = np.asarray(raw.y, float)[:, None, :]
    R = sensor.R if raw.R is None else np.asarray(raw.R, float)[:, None]
    z = sensor.residual(np.broadcast_to(y, (len(y), *table.e.shape)), table.e[None])
    with np.errstate(invalid="ignore"):  # where an expectation is not finite nothing is
        near = (z**2 <= gate * (spread**2 + np.diagonal(R, axis1=-2, axis2=-1))).all(-1)
    return np.flatnonzero(near.any(0))
