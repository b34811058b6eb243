"""A recorded run: its robots, sensors, options, controls and measurements, as this package's objects.

NAME.json holds the parameters, NAME.npz the arrays. A single robot or sensor is stored as a dict, several as a list; a
matrix as {"shape", "data"}, a vector as a list, a vector of one number as a number. Indices are counted from 1.
"""

import json
from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np

from ekfslam_tutorial.ekf import Map
from ekfslam_tutorial.geometry import Frame3
from ekfslam_tutorial.models.landmarks import AhmLin, AhmPnt, EucPnt, HmgLin, HmgPnt, IdpLin, IdpPnt
from ekfslam_tutorial.models.motion import ConstantVelocity, Odometry3
from ekfslam_tutorial.models.sensors import OmniCam, PinHole, PinHoleDepth, SegmentCam
from ekfslam_tutorial.slam import KnownIds, Options, Rob, Sen, place

from .births import (
    FreeAplLin,
    FreePlkLin,
    RecordedAhmLin,
    RecordedAhmPnt,
    RecordedHmgLin,
    RecordedHmgPnt,
    RecordedOdometry3,
    RecordedPlkLin,
)

POINTS = {"eucPnt": EucPnt(), "idpPnt": IdpPnt(), "ahmPnt": AhmPnt(), "hmgPnt": HmgPnt()}
LINES = {"plkLin": FreePlkLin(), "aplLin": FreeAplLin(), "idpLin": IdpLin(), "hmgLin": HmgLin(), "ahmLin": AhmLin()}
LANDMARKS = POINTS | LINES
BIRTHS = {  # types with a recorded derivative that is not the exact one
    "ahmPnt": RecordedAhmPnt(),
    "hmgPnt": RecordedHmgPnt(),
    "ahmLin": RecordedAhmLin(),
    "hmgLin": RecordedHmgLin(),
    "plkLin": RecordedPlkLin(),
}
MOTIONS = {"odometry": Odometry3(), "constVel": ConstantVelocity()}
TYPES = tuple(LANDMARKS)  # in the order of their type codes, 1 to 9
FAR = 8.0  # metres from the point nearest to the origin: how far the recorded Plücker lines reach to both sides


@dataclass
class Scenario:
    """A recorded run.

    Parameters
    ----------
    name : str
    data : dict
        Parameters, from NAME.json.
    arrays : dict of str to ndarray
        From NAME.npz.
    """

    name: str
    data: dict
    arrays: dict

    @classmethod
    def load(cls, folder, name):
        """Read NAME.json and NAME.npz."""
        data = json.loads((folder / f"{name}.json").read_text(encoding="utf-8"))
        with np.load(folder / f"{name}.npz") as arrays:
            return cls(name, data, dict(arrays))

    @property
    def type(self):
        """Word for the landmark type."""
        return self.data["Opt"]["init"]["initType"]

    @property
    def n_frames(self):
        return len(self.arrays["frame"])

    @property
    def n_robots(self):
        return len(several(self.data["Robot"]))

    def positions(self, what):
        """Positions of a state in the recorded map, counted from 0; empty if it is not in the map."""
        return np.ravel(self.arrays[f"range_{what}"]).astype(int) - 1

    def start(self, births=False, new_map=Map):
        """A map with the robots and sensors at their places, and the options.

        Parameters
        ----------
        births : bool
            Take the landmark class whose birth imitates the recorded approximation.
        new_map : callable
            Makes a map of a capacity.

        Returns
        -------
        map : Map
        robots : dict of int to Rob
        sensors : dict of int to Sen
        opt : Options
        """
        map = new_map(self.arrays["map_x"].shape[1])
        robots = {i: self._robot(i, robot) for i, robot in numbered(self.data["Robot"])}
        if births and self.type == "plkLin":
            robots = {i: replace(rob, motion=RecordedOdometry3()) for i, rob in robots.items()}
        sensors = {i: self._sensor(i, sensor) for i, sensor in numbered(self.data["Sensor"])}
        for i, sensor in sensors.items():
            robots[sensor.robot].sensors.append(i)
        for i, robot in robots.items():
            place(map, robot, *self._initial(self.positions(f"rob{i}")))
        frames = vectors(self.data["senFrame"])
        for i, sensor in sensors.items():
            positions = self.positions(f"sen{i}")
            place(map, sensor, *(self._initial(positions) if positions.size else (frames[i - 1],)))
        opt = self.options()
        return map, robots, sensors, replace(opt, lmk_type=BIRTHS[self.type]) if births else opt

    def _initial(self, positions):
        return self.arrays["map_x0"][positions], self.arrays["map_P0"][np.ix_(positions, positions)]

    def _robot(self, i, robot):
        control = several(self.data["robCon"])[i - 1]
        return Rob(i, MOTIONS[robot["motion"]], name=robot["name"], U=matrix(control["U"]))

    def _sensor(self, i, sensor):
        carried = self.data["robSensors"]
        carried = [vector(c) for c in (carried if self.n_robots > 1 else [carried])]
        robot = next(k for k, ids in enumerate(carried, 1) if i in ids)
        model = camera(sensor, several(self.data["senPar"])[i - 1])
        if self.type in LINES:
            least = 1.0 if self.type in ("plkLin", "aplLin") else self.data["Opt"]["obs"]["lines"]["minLength"]
            names = ("k", "d", "c", "image_size", "pixel_std")
            model = SegmentCam(**{name: getattr(model, name) for name in names}, min_length=least)
        return Sen(i, robot, model, Frame3, name=sensor["name"])

    def options(self):
        """The recorded options in this package's words."""
        correct, init = self.data["Opt"]["correct"], self.data["Opt"]["init"]
        prior = init.get(self.type, init["idpPnt"])
        return Options(
            lmk_type=LANDMARKS[self.type],
            n=vector(prior["nonObsMean"]),
            N=np.diag(vector(prior["nonObsStd"]) ** 2),
            association=RecordedChoice(),
            n_updates=int(correct["nUpdates"]),
            md2_threshold=correct["MD2th"],
            reproject=bool(correct["reprojectLmks"]),
            reparametrize=bool(correct["reparametrize"]),
            lin_test=correct["linTestIdp"],
            n_inits=tuple(int(n) for n in init["nbrInits"]),
            max_lmks=int(self.data["Opt"]["map"]["numLmks"]),
            min_search=10,
            min_match_ratio=0.1,
            min_inlier_ratio=0.5,
            min_rho=0.001,
            ends="keep",
            error="additive",  # the recorded program is the textbook's filter
        )

    def control(self, frame, rob):
        """Control of a robot in a frame, counted from 0."""
        return self.arrays[f"u_rob{rob}"][frame]

    def raw(self, frame, sen):
        """Measurements of a sensor in a frame, and which landmarks were started then, where chance decided it."""
        kind = "seg" if self.type in LINES else "pts"
        off, ids, y = (self.arrays[f"{kind}_sen{sen}_{name}"] for name in ("off", "id", "y"))
        rows = slice(off[frame], off[frame + 1])
        return SimpleNamespace(ids=ids[rows].astype(int), y=y[rows], R=None, started=self._started(frame, sen))

    def segment(self, id):
        """True ends of a segment, as two points."""
        of = self.data["SimLmk"]["segments"]
        x = matrix(of["coord"])[:, vector(of["id"]).astype(int).tolist().index(id)]
        return x[:3], x[3:]

    def _started(self, frame, sen):
        if self.data["branch"] != "graph":
            return None
        ev = self.arrays["ev_int"]
        return ev[(ev[:, 0] == 3) & (ev[:, 1] == frame + 1) & (ev[:, 3] == sen), 5].tolist()


@dataclass(frozen=True)
class RecordedChoice:
    """Known ids, and new landmarks as the recorded program chooses them.

    Those that lie inside the image by a 25th of its width, the lowest id first; lines wherever they are; or, where it
    chose at random, the recorded ones.
    """

    def __call__(self, map, obs, raw, sensor):
        matches = KnownIds()(map, obs, raw, sensor)
        if raw.started is not None:
            matches.new = [int(np.flatnonzero(raw.ids == id)[0]) for id in raw.started]
        elif not hasattr(sensor, "innovation"):
            u = raw.y[:, :2]
            size = np.asarray(sensor.image_size)
            margin = size[0] / 25
            inside = ((u >= margin) & (u <= size - margin)).all(-1)
            matches.new = [i for i in matches.new if inside[i]]
        return matches

    def birth_id(self, raw, i, lmks):
        return KnownIds().birth_id(raw, i, lmks)


def camera(sensor, par):
    """Sensor model of a recorded sensor, from what the user wrote and what the program derived from it."""
    k, d, c = vector(par["k"]), vector(par["d"]), vector(par.get("c", sensor.get("invDistortion", [])))
    size = tuple(vector(par["imSize"]))
    if sensor["type"] == "omniCam":
        return OmniCam(tuple(k), tuple(d), c=tuple(c), image_size=size, pixel_std=float(par["pixErr"]))
    c = tuple(c) if len(c) else None
    if sensor["type"] == "pinHoleDepth":
        std = np.sqrt(np.diag(matrix(par["cov"])))
        return PinHoleDepth(tuple(k), tuple(d), c=c, image_size=size, pixel_std=std[0], depth_std=std[2])
    if sensor["type"] == "pinHole":
        return PinHole(tuple(k), tuple(d), c=c, image_size=size, pixel_std=float(par["pixErr"]))
    raise ValueError(f"unknown recorded sensor type {sensor['type']!r}; known: pinHole, pinHoleDepth, omniCam")


def several(x):
    """One record, or a list of them, as a list."""
    return x if isinstance(x, list) else [x]


def numbered(x):
    return enumerate(several(x), 1)


def vector(x):
    """A recorded vector as a 1-D array: a list, a single number, or a matrix of one row or column."""
    return np.ravel(matrix(x) if isinstance(x, dict) else np.asarray(x, float))


def vectors(x):
    """One recorded vector, or a list of them, as a list of arrays."""
    many = isinstance(x, list) and x and isinstance(x[0], list | dict)
    return [vector(v) for v in (x if many else [x])]


def matrix(x):
    """A recorded matrix as an array of its shape."""
    return np.reshape(np.asarray(x["data"], float), x["shape"]) if isinstance(x, dict) else np.atleast_2d(x)
