"""What a scan measures: the sensor model that fits its columns, its noise by the scatter, its messages."""

from itertools import pairwise
from typing import Any

import numpy as np

from ...geometry import q2e, wrap
from ...toolbox.messages import Measurement
from .meaning import DESCRIPTOR, NOISE
from .plumb_bob import without_tangential

RANGE, BEARING, ELEVATION = ("range", "range_std"), ("bearing", "bearing_std_deg"), ("elevation", "elevation_std_deg")
PIXEL = ("px", "pixel_std"), ("py", "pixel_std")
PLANE = {
    "range_bearing": (RANGE, BEARING),
    "range": (RANGE,),
    "point_xy": (("x", "std"), ("y", "std")),
}
"""Sensor models of the plane: what they measure, each column and the key of its noise."""
SPACE = {
    "range_bearing_elevation": (RANGE, BEARING, ELEVATION),
    "range": (RANGE,),
    "pin_hole_depth": (*PIXEL, ("depth", "depth_std")),
    "stereo_pin_hole": (*PIXEL, ("disparity", "pixel_std")),
    "pin_hole": PIXEL,
    "point_xyz": (("x", "std"), ("y", "std"), ("z", "std")),
}
CAMERAS = "pin_hole", "pin_hole_depth", "stereo_pin_hole"
LEAST = {"range": 0.05, "bearing": 0.005, "elevation": 0.005, "std": 0.05, "pixel": 0.5, "depth": 0.05}
SHARE = 0.01
"""Without ids the noise of lengths is taken for this share of the usual distance, if that is more than `UNKNOWN`."""
LEAST["look"] = 1e-3
"""No noise is taken for smaller than this: m, rad, rad, m, pixels, m, and of a number of a descriptor."""
UNKNOWN = {"range": 0.1, "bearing": 0.03, "elevation": 0.03, "std": 0.1, "pixel": 1.0, "depth": 0.1}
"""Noise where the log cannot tell it."""
GATES = {1: 10.8, 2: 13.8, 3: 16.3}
"""Gate by the length of a measurement: one good innovation in a thousand does not pass."""
MANY = 100
"""So many landmarks make a map that is slow one by one."""
AHEAD = [-90.0, 0.0, -90.0]
"""Orientation of a camera that looks ahead, its z axis along the robot's x."""


class Scan:
    """Sensor of a log.

    Parameters
    ----------
    log : Log

    Raises
    ------
    ValueError
        One sentence: its columns start no landmarks, or a camera is not known.
    """

    def __init__(self, log):
        self.log, self.part, self.entry = log, log.parts["scan"], log.plan["scan"]
        models = SPACE if log.space else PLANE
        whole = [kind for kind, fields in models.items() if {m for m, _ in fields} <= set(self.part)]
        if not whole or (log.space and whole == ["range"] and "bearing" in self.part):
            raise ValueError(
                f"scan: {', '.join(m for m in self.part if m != 't') or 'the time'} alone starts no landmarks"
                f"{' in space' * log.space}; needed are "
                + "; or ".join(", ".join(m for m, _ in fields) for fields in models.values())
            )
        self.kind = whole[0]
        self.fields = models[self.kind]
        ids = self.part.get("id", np.zeros(0))
        self.known = bool((ids[np.isfinite(ids)] >= 0).any())
        if self.kind == "range" and not self.known:
            raise ValueError(
                "scan: ranges, and neither bearings nor ids. Which column is the bearing: --set scan.bearing=COLUMN? "
                "Ranges alone cannot be told apart without the id of the beacon: --set scan.id=COLUMN"
            )

    def sensor(self):
        """Table of the sensor, with noise by the scatter of the log."""
        table: dict[str, Any] = {"type": self.kind}
        if self.kind in CAMERAS:
            table |= self._camera()
        if self.kind == "range" and self.log.space:
            table["dim"] = 3
        for key in dict.fromkeys(key for _, key in self.fields):
            std = max(self._std(m, key) for m, k in self.fields if k == key)
            table[key] = round(float(np.rad2deg(std)), 3) if key.endswith("_deg") else round(std, 4)
        if not self.known and self.own_noise() is None:
            guessed = ", ".join(f"{key} = {table[key]}" for key in dict.fromkeys(key for _, key in self.fields))
            self.log.said.append(f"without ids the scatter does not tell the noise, so it is a guess: {guessed}")
        return table | self._mounting()

    def landmark(self):
        """Table of the landmarks."""
        if self.kind == "range":
            return {"type": "euc_pnt", "hypotheses": 200 if self.log.space else 64}
        if self.kind == "pin_hole":
            self.log.said.append(
                "  a pixel does not tell how far a landmark is: at birth 2 m or more, about 4 m; non_obs_mean and "
                "non_obs_std (1/m) of [landmark] say so"
            )
            return {"type": "idp_pnt", "non_obs_mean": 0.25, "non_obs_std": 0.25}
        return {"type": "euc_pnt"}

    def options(self):
        """Table of the filter's options."""
        table: dict[str, Any] = {"association": "known_ids" if self.known else "nearest_neighbour"}
        if self.looks is not None and not self.known:
            table["association"] = {"type": "descriptors", "std": self._look_noise(self.looks)}
        if self.known and len(np.unique(self.part["id"])) > MANY:
            table |= {"joint": True}
            self.log.said.append(f"more than {MANY} landmarks: joint correction, which is much faster then")
        return table | {"md2_threshold": GATES[len(self.fields)]}

    @property
    def looks(self):
        """Descriptors of the measurements, shape (n, k); None if the log does not say."""
        columns = [a for m, a in self.part.items() if m.startswith(DESCRIPTOR)]
        return np.column_stack(columns) if columns else None

    def _look_noise(self, looks):
        """Noise of one number of a descriptor: as told, or by how near the next scan has one that looks alike."""
        told = self.entry.get("descriptor_std")
        if told is not None:
            return told
        _, start = np.unique(self.part["t"], return_index=True)
        scans = np.split(looks, start[1:])
        near = [np.linalg.norm(a[:, None] - b, axis=2).min(1) for a, b in pairwise(scans)]
        size = float(np.median(np.concatenate(near))) if near else 0.0
        std = float(f"{max(size / np.sqrt(2 * looks.shape[1]), LEAST['look']):.3g}")
        self.log.said.append(
            f"  descriptor: {looks.shape[1]} numbers, noise of each {std:g}, by the likest ones of next scans; "
            "--set scan.descriptor_std=... says otherwise"
        )
        return std

    def _mounting(self):
        """Mounting of the sensor on the robot, as far as it is told or the axes tell."""
        told = {key: self.entry[key] for key in ("position", "orientation_deg") if key in self.entry}
        if told:
            self.log.said.append(mounted(**told))
        pose = None if told else self.log.mount()
        if pose is not None:
            rpy = np.rad2deg(q2e(pose[3:])[0]).round(4) + 0.0
            angles = rpy.tolist() if self.log.space else float(rpy[2])
            told = {"position": pose[: 3 if self.log.space else 2].round(5).tolist(), "orientation_deg": angles}
            self.log.said.append(f"  mounted by /tf_static: {', '.join(f'{key} = {v}' for key, v in told.items())}")
        if not self.log.space or "orientation_deg" in told:
            return told
        if self.kind in CAMERAS:
            self.log.said.append(
                f"  the camera is taken to look ahead, orientation_deg = {AHEAD}; --set scan.orientation_deg=... , and "
                "scan.position=[x, y, z], if it is mounted otherwise"
            )
            return told | {"orientation_deg": AHEAD}
        if self.kind == "point_xyz" and (self._optical() or "optical" in self.log.frames["scan"]):
            self.log.said.append(
                f"  seen with z ahead, as by a camera: orientation_deg = {AHEAD}; scan.orientation_deg says otherwise"
            )
            return told | {"orientation_deg": AHEAD}
        return told

    def _optical(self):
        """Return True if z is ahead: never negative, and mostly the largest."""
        x, y, z = (self.part[m] for m in "xyz")
        return bool((z > 0).all() and np.median(z) > 2 * max(np.median(np.abs(x)), np.median(np.abs(y))))

    def _camera(self):
        """Intrinsic parameters of the camera: as told, or by its CameraInfo."""
        camera, told = self.log.parts.get("camera"), self.entry
        if "k" not in told and camera is None:
            raise ValueError(
                "scan: pixels need the camera: --set scan.k=[u0, v0, fu, fv] (pixels), or camera.from=TOPIC of its "
                "CameraInfo"
            )
        table = {"k": told["k"]} if "k" in told else {}
        if camera is not None:
            one = {m: float(a[0]) for m, a in camera.items()}
            table = {"k": [one["cx"], one["cy"], one["fx"], one["fy"]]} | table
            if "width" in one and "height" in one:
                table["image_size"] = [one["width"], one["height"]]
            table |= self._distortion([one.get(f"d{i}", 0.0) for i in range(1, 6)], table["k"])
        if "d" in told:
            table["d"] = told["d"]
        size = [float(np.ceil(self.part[m].max())) + 1 for m in ("px", "py")]
        table.setdefault("image_size", told.get("image_size", size))
        if "disparity" in self.part:
            baseline = told.get("baseline")
            if not isinstance(baseline, int | float) or not baseline > 0:
                raise ValueError(
                    f"scan: disparities need baseline, how far the cameras are apart in m, got {baseline!r}"
                )
            table["baseline"] = baseline
        self.log.said.append(f"  camera: {', '.join(f'{key} = {value}' for key, value in table.items())}")
        return table

    def _distortion(self, d, k):
        """Radial distortion; pixels are moved to where a lens without the tangential part would show them."""
        if self.entry.get("rectified") or not any(d) or self.kind == "stereo_pin_hole":
            return {}
        words = "  pixels are taken to be distorted as the CameraInfo says; scan.rectified=true if they are not"
        if d[2] or d[3]:
            seen = np.column_stack([self.part["px"], self.part["py"]])
            shown = without_tangential(seen, k, d)
            there = np.isfinite(shown).all(1)
            self.part |= {m: a[there] for m, a in (self.part | dict(zip(("px", "py"), shown.T, strict=True))).items()}
            off = np.linalg.norm(shown - seen, axis=1)[there].max(initial=0.0)
            words += f"; the tangential part is taken off, up to {off:.2g} pixels"
            words += f"; {(~there).sum():,} pixels that this lens does not have are left out" * bool((~there).any())
        self.log.said.append(words)
        return {"d": [d[0], d[1], *([d[4]] if d[4] else [])]}

    def own_noise(self):
        """Covariance R of each measurement, shape (n, m, m), where the log has columns for it; else None.

        Raises
        ------
        ValueError
            One sentence: a standard deviation that is not positive, or a matrix that is no covariance.
        """
        names, t = [m for m, _ in self.fields], self.part["t"]
        stds = [f"{m}_std" for m in names]
        covs = {(i, j): f"cov_{a}{b}" for j, b in enumerate(names) for i, a in enumerate(names[: j + 1])}
        R = np.zeros((len(t), len(names), len(names)))
        if set(covs.values()) <= set(self.part):
            for (i, j), m in covs.items():
                R[:, i, j] = R[:, j, i] = self.part[m]
            bad = np.linalg.eigvalsh(R)[:, 0] <= 0
            if bad.any():
                words = f"{', '.join(covs.values())} must be a positive definite covariance"
                raise ValueError(f"scan: {words}, but at {t[bad][0]:g} s they are not")
            return R
        if not set(stds) <= set(self.part):
            return None
        for i, m in enumerate(stds):
            std = self.part[m]
            if (std <= 0).any():
                raise ValueError(f"scan: {m} must be positive, but at {t[std <= 0][0]:g} s it is {std[std <= 0][0]:g}")
            R[:, i, i] = std**2
        return R

    def _std(self, meaning, key):
        """Noise of the sensor: the usual one of its measurements, where they have their own; else by the scatter."""
        R, i = self.own_noise(), [m for m, _ in self.fields].index(meaning)
        return self._scatter(meaning, key) if R is None else float(np.sqrt(np.median(R[:, i, i])))

    def _scatter(self, meaning, key):
        """Noise of a measurement by the scatter of neighbouring ones of the same landmark."""
        kind = key.removesuffix("_deg").removesuffix("_std")
        if not self.known:
            return max(UNKNOWN[kind], SHARE * self._far() if kind in ("range", "std") else 0.0)
        found = []
        for id in np.unique(self.part["id"][self.part["id"] >= 0]):
            a, t = (self.part[m][self.part["id"] == id] for m in (meaning, "t"))
            found.append(scatter(np.unwrap(a) if meaning == "bearing" else a, t))
        found = [std for std in found if np.isfinite(std)]
        return max(float(np.median(found)), LEAST[kind]) if found else UNKNOWN[kind]

    def blur(self, sensor):
        """How far off a measured landmark may be by the noise of the sensor's table, at the usual distance, m."""
        along = [sensor[key] for key in ("range_std", "std", "depth_std") if key in sensor]
        return max(along, default=0.0) + self._far() * np.deg2rad(sensor.get("bearing_std_deg", 0.0))

    def _far(self):
        """The usual distance of what is measured, m."""
        if "range" in self.part:
            return float(np.median(self.part["range"]))
        p = [self.part[m] for m in (*"xyz", "depth") if m in self.part]
        return float(np.median(np.linalg.norm(p, axis=0))) if p else 0.0

    def messages(self, sensor=1):
        """Measurements, those of one time together."""
        scan = self.part
        y = np.column_stack([wrap(scan[m]) if m == "bearing" else scan[m] for m, _ in self.fields])
        ids = np.full(len(y), -1)
        if "id" in scan:
            ids = np.where(np.isfinite(scan["id"]), scan["id"], -1).astype(int)
            ids = np.maximum(ids, -1)
        if self.known and (ids < 0).any():
            self.log.said.append(
                f"{(ids < 0).sum():,} measurements without an id are left out: known_ids cannot use them"
            )
        R, d, told = self.own_noise(), self.looks, [m for m in NOISE if m in scan]
        if R is not None:
            self.log.said.append(
                f"{', '.join(told)}: the noise of each measurement; --set scan.{told[0]}=false leaves it out"
            )
        elif told:
            needed = [f"{m}_std" for m, _ in self.fields]
            self.log.said.append(f"{', '.join(told)}: not used; needed are {', '.join(needed)}, or all of a covariance")
        times, start = np.unique(scan["t"], return_index=True)
        for time, rows in zip(times, np.split(np.arange(len(y)), start[1:]), strict=True):
            rows = rows[ids[rows] >= 0] if self.known else rows
            of_rows = lambda a, rows=rows: None if a is None else a[rows]
            yield Measurement(time, ids[rows], y[rows], sensor, R=of_rows(R), d=of_rows(d))


def mounted(position=None, orientation_deg=0.0):
    """A line on where a sensor is: its place on the robot, and how it is turned, as they were told."""
    at = (0.0, 0.0) if position is None else position
    try:
        place = ", ".join(f"{axis} {float(a):g}" for axis, a in zip("xyz", at, strict=False))
        if np.ndim(orientation_deg):
            turned = f"roll, pitch, yaw {orientation_deg} deg"
        else:
            turned = f"turned {abs(orientation_deg):g} deg to the {'left' if orientation_deg >= 0 else 'right'}"
    except TypeError as error:
        raise ValueError(
            "scan: position is [x, y], m, and orientation_deg a number, of the sensors of all robots alike; got "
            f"{position!r} and {orientation_deg!r}. Where they differ, say it in [[sensor]] of scenario.toml"
        ) from error
    return f"  the sensor is at {place} m, {turned}"


def scatter(a, t=None):
    """Standard deviation of white noise on a smooth signal, by its differences; NaN if there are too few.

    A divided difference of order k is a sum of k + 1 neighbours whose weights take a polynomial of degree k - 1 away,
    whatever the times between them. It is divided by the length of its weights. What is left of the signal comes on
    top: the order of the least is taken.
    """
    t = np.arange(len(a)) if t is None else t
    apart = np.append(True, np.diff(t) > 0)  # a second one at the same time tells no slope
    a, t = a[apart], t[apart]
    if len(a) < 8:
        return float("nan")

    def of_order(k):
        """Scatter of the divided differences of k + 1 neighbours, each with the variance of one number."""
        T, A = (np.lib.stride_tricks.sliding_window_view(x, k + 1) for x in (t, a))
        way = T[:, :, None] - T[:, None] + np.eye(k + 1)
        w = 1 / way.prod(2)
        d = (w * A).sum(1) / np.linalg.norm(w, axis=1)
        return 1.4826 * np.median(np.abs(d - np.median(d)))

    return float(min(map(of_order, (2, 3, 4))))
