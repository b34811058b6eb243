"""Latitude and longitude become metres to the east and to the north of a place."""

import numpy as np

A, F = 6378137.0, 1 / 298.257223563
"""Half of the large axis, m, and the flattening of the ellipsoid WGS 84."""
E2 = F * (2 - F)
WHOLE = 1e-7
"""Degrees of the whole numbers that receivers send."""


def to_metres(part, origin=None):
    """Columns x, y in the place of lat, lon.

    Parameters
    ----------
    part : dict of str to ndarray
        With lat and lon in degrees, or in whole numbers of 1e-7 degrees, and maybe z.
    origin : (float, float), optional
        Latitude and longitude of where x and y are zero; the first row if there is none.

    Returns
    -------
    dict of str to ndarray
    (float, float)
        The origin.

    Raises
    ------
    ValueError
        A latitude beyond the poles.
    """
    lat, lon = part["lat"], part["lon"]
    if np.abs(lat).max() > 360:
        lat, lon = WHOLE * lat, WHOLE * lon
    if np.abs(lat).max() > 90:
        raise ValueError(f"lat: degrees from -90 to 90 are needed, got {lat[np.argmax(np.abs(lat))]:.9g}")
    origin = origin or (float(lat[0]), float(lon[0]))
    east, north, _ = east_north_up(lat, lon, *origin)
    return {m: a for m, a in part.items() if m not in ("lat", "lon")} | {"x": east, "y": north}, origin


def east_north_up(lat, lon, lat0, lon0):
    """Place on the ellipsoid in the plane that touches it at (lat0, lon0): east, north, up.

    Degrees in, metres out; shape (n,) each.

    Source: B. Hofmann-Wellenhof, H. Lichtenegger, E. Wasle, "GNSS", Springer, 2008, eqs. 8.4 and 8.16.
    """
    way = _from_centre(lat, lon) - _from_centre(lat0, lon0)
    (s, c), (sl, cl) = ((np.sin(a), np.cos(a)) for a in np.deg2rad([lat0, lon0]))
    R = np.array([[-sl, cl, 0.0], [-s * cl, -s * sl, c], [c * cl, c * sl, s]])
    return np.moveaxis(way @ R.T, -1, 0)


def _from_centre(lat, lon):
    """Place on the ellipsoid as seen from the centre of the earth, m, shape (..., 3)."""
    lat, lon = np.deg2rad(lat), np.deg2rad(lon)
    N = A / np.sqrt(1 - E2 * np.sin(lat) ** 2)
    return np.stack([N * np.cos(lat) * np.cos(lon), N * np.cos(lat) * np.sin(lon), (1 - E2) * N * np.sin(lat)], -1)
