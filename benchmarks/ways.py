"""Each peer in its better way: which variants are ways of the same program, and which of them is the quickest."""

from .results import least, ratio

WAYS = {
    "filterpy": ("filterpy", "filterpy, joint", "filterpy, joint, motion by hand"),
    "filterpy, blocks given": ("filterpy, blocks given", "filterpy, joint, motion by hand, blocks given"),
    "PythonRobotics": ("PythonRobotics", "PythonRobotics, known ids", "PythonRobotics, joint"),
    "Robotics Toolbox": ("Robotics Toolbox", "Robotics Toolbox, joseph=False"),
    "Stone Soup": ("Stone Soup updater", "Stone Soup updater, tuned"),
    "numba loops": ("numba loops", "numba loops, joint"),
    "textbook numpy": ("textbook numpy, sequential", "textbook numpy, joint"),
}
TOTALS = {
    "filterpy": WAYS["filterpy"],
    "GTSAM iSAM2": ("GTSAM iSAM2", "GTSAM iSAM2, partial check"),
    "GTSAM batch": ("GTSAM batch", "GTSAM batch, Gauss-Newton"),
    "MRPT": ("MRPT, joint", "MRPT, one by one"),  # told how far the sensor sees
}
SIZES = (10, 100, 500)


def ours(r, n_lmks, m, kind, compiled=True):
    """Microseconds of the package: the fastest way; joint or, for one landmark, one by one, and compiled if wanted."""
    ways = ["joint"] if m > 1 else ["sequential", "joint"]
    ways += [f"{way}, compiled" for way in ways] * compiled
    return least(*(r.us(n_lmks, m, f"{kind}, {way}") for way in ways))


def quickest(r, n_lmks, m, peer):
    """Microseconds of a step of a peer in its better way, and the name of that; (None, None) if none was measured."""
    found = [(r.us(n_lmks, m, way), way) for way in WAYS[peer]]
    return min((one for one in found if one[0]), default=(None, None))


def quickest_total(r, n_lmks, peer):
    """Seconds of a circuit of a peer in its better way, or None."""
    return least(*(r.total(n_lmks, way) for way in TOTALS[peer]))


def fair(r):
    """Rows: kind (step, filter), m, n_lmks, peer, way, and how many times faster this package is: compiled, numpy."""
    rows = []
    for kind in "step", "filter":
        for m in 10, 1:
            for peer in WAYS:
                if kind == "step" and "given" in peer:
                    continue  # a part of theirs beside a whole of ours
                for n in SIZES:
                    us, way = quickest(r, n, m, peer)
                    if us:
                        row = {"kind": kind, "m": m, "n_lmks": n, "peer": peer, "way": way}
                        ratios = (ratio(us, ours(r, n, m, kind, compiled)) for compiled in (True, False))
                        rows.append(row | dict(zip(("compiled", "numpy"), ratios, strict=True)))
    return rows
