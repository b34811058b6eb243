"""Scenario files: user data as TOML.

A model is `type = "its_name"` with its parameters beside it. The name is the class name in small letters,
`range_bearing` for RangeBearing; all classes that the package exports are known. Angles are in degrees in keys that
end in `_deg`, and in radians without the ending.
"""

import copy
import inspect
import tomllib
from functools import partial

import numpy as np

from ...models import landmarks, motion, sensors
from ...models.calibrated import UNIVERSAL
from ...models.protocols import VALUES, lacking
from ...simulation import worlds
from ...slam import association
from ..descriptors import Descriptors
from ..images import ActiveSearch
from ..user_input import MAIN, errors_at, finite_array, short_text
from .keys import (
    arguments,
    check_keys,
    construct,
    exported,
    functions,
    keys_of,
    look_up,
    parameters,
    radian_keys,
    snake,
    to_degrees,
)
from .overrides import override
from .robots import Robot, Sensor, std_key
from .sections import Data, FigureOptions, Landmark, Options, Surveyed, Time, World

DEEP = "this is nested too deeply"
SECTIONS = ("name", "seed", "time", "world", "robot", "sensor", "landmark", "options", "figure", "data", "convert")


def read_toml(path):
    """Read the nested tables of a TOML file.

    Parameters
    ----------
    path : Path

    Returns
    -------
    dict

    Raises
    ------
    FileNotFoundError
    ValueError
    """
    if not path.is_file():
        raise FileNotFoundError(f"no scenario file {path}")
    try:
        return parse_toml(path.read_text(encoding="utf-8"))
    except UnicodeDecodeError as error:
        raise ValueError(f"this is not a text in UTF-8: {error}") from error


def parse_toml(text):
    """Read the nested tables of a text in TOML.

    Parameters
    ----------
    text : str

    Returns
    -------
    dict

    Raises
    ------
    ValueError
    """
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise ValueError(f"this is not TOML: {error}") from error
    except RecursionError:
        raise ValueError(DEEP) from None


def read_table(table, overrides=None, models=()):
    """Read the parts of the user's data from nested tables; see `UserData.from_toml` for the arguments.

    Returns
    -------
    values : dict
        What stands at the top of the file, as it is.
    parts : dict
        What was made of the sections.

    Raises
    ------
    ValueError, TypeError
    """
    try:
        table = copy.deepcopy(table)
    except RecursionError:
        raise ValueError(DEEP) from None
    for key, value in (overrides or {}).items():
        override(table, key, value)
    check_keys(table, SECTIONS)
    known = Known(models)

    robots = _entries(table, "robot", known.robot)
    frame = robots[0].frame if robots else None
    parts = {
        "robots": robots,
        "sensors": _entries(table, "sensor", partial(known.sensor, frame=frame)),
        "landmark": _section(table, "landmark", partial(known.landmark, frame=frame)),
        "world": _section(table, "world", known.world) if "world" in table else None,
        "data": _section(table, "data", _data) if "data" in table else None,
        "options": _section(table, "options", known.options),
        "time": _section(table, "time", partial(_without_models, Time)),
        "figure": _section(table, "figure", partial(_without_models, FigureOptions)),
    }
    return {key: table[key] for key in ("name", "seed") if key in table}, parts


def _section(table, name, read):
    with errors_at(f"[{name}]"):
        if not isinstance(table.get(name, {}), dict):
            raise ValueError(f"this must be one table, written [{name}], got {short_text(table[name])}")
        return read(dict(table.get(name, {})))


def _entries(table, name, read, inside=""):
    """Read the entries [[name]], or [[inside.name]]; one without an id gets its number, from 1."""
    entries = table.get(name, [])
    entries = [entries] if isinstance(entries, dict) else entries
    if not isinstance(entries, list) or not all(isinstance(entry, dict) for entry in entries):
        raise ValueError(f"{name} must be tables, each written [[{inside}{name}]], got {short_text(entries)}")
    made = []
    for number, entry in enumerate(entries, 1):
        with errors_at(f"{name} {short_text(entry.get('id', number))}"):
            made.append(read({"id": number} | entry))
    return made


def _without_models(cls, entry):
    """Make an object of a class whose keys are just its parameters."""
    entry = to_degrees(entry, list(parameters(cls)))
    check_keys(entry, parameters(cls))
    return construct(cls, entry)


def _data(entry):
    return construct(Data, {"name": entry.pop("name")} if "name" in entry else {}, params=entry)


class Known:
    """Names that a file may use: what the package exports, and classes of the reader's own."""

    def __init__(self, models=()):
        self.own = own = {snake(cls.__name__): cls for cls in models}
        having = lambda known, method: known | {n: c for n, c in own.items() if hasattr(c, method)}
        is_association = lambda cls: inspect.isclass(cls) and hasattr(cls, "birth_id")
        associations = {snake(n): c for n, c in inspect.getmembers(association, is_association)}
        self.motions = having(exported(motion), MAIN["motion"])
        self.sensors = having(exported(sensors), MAIN["sensor"])
        self.landmarks = having(exported(landmarks), MAIN["landmark"])
        self.associations = having(
            associations | {"active_search": ActiveSearch, "descriptors": Descriptors}, "birth_id"
        )
        self.worlds = functions(worlds)

    def _model(self, role, kind, name, known):
        """The class of a name; one of the reader's own that has not the method of this role is told so."""
        cls = self.own.get(name) if isinstance(name, str) and name not in known else None
        if cls is not None:
            raise ValueError(
                f"{cls.__name__} has no method {MAIN[role]}, so it is no {kind}; known: {', '.join(known)}"
            )
        return look_up(kind, name, known)

    def robot(self, entry):
        """Read a robot: its own keys, its motion model's, and start values and controls by the model's fields."""
        cls = self._model("motion", "motion model", _pop(entry, "motion", self.motions), self.motions)
        if absent := lacking(cls, ("control_fields", "state_fields")):  # they say which keys there are
            raise ValueError(f"{cls.__name__} has {absent}; a motion has {', '.join(VALUES['motion'])}, move")
        own = _keys(Robot, without=("motion", "state", "state_std", "control", "control_std"))
        groups = _groups(cls)
        params, entry = _split(entry, cls, [*own, *groups], key="motion")

        entry = to_degrees(entry, [*own, *groups])
        values = {}
        for key in [key for key in entry if key in groups]:
            group, name = groups[key]
            values.setdefault(group, {})[name] = entry.pop(key)
        return construct(Robot, entry, motion=cls(**arguments(cls, params)), **values)

    def sensor(self, entry, frame):
        """Read a sensor: its own keys and those of its model."""
        cls = self._model("sensor", "sensor type", _pop(entry, "type", self.sensors), self.sensors)
        own, groups = _keys(Sensor, without=("model", "params_std", "params_walk")), _parameter_keys(cls)
        said, entry = {k: entry[k] for k in groups if k in entry}, {k: v for k, v in entry.items() if k not in groups}
        params, entry = _split(entry, cls, own, key="type")
        made = {"model": cls(**arguments(cls, params))}
        for key, value in said.items():
            (group, name), radians = (
                groups[key],
                np.deg2rad(finite_array(key, value)) if key.endswith("_deg") else value,
            )
            made.setdefault(group, {})[name] = radians
        if "landmark" in entry:
            with errors_at("landmark"):
                made["landmark"] = self.landmark_type(entry.pop("landmark"), frame)
        return construct(Sensor, to_degrees(entry, own), **made)

    def landmark(self, entry, frame):
        """Read how landmarks are stored."""
        own, made = _keys(Landmark, without=("model",)), {}
        if "type" in entry:
            cls = self._model("landmark", "landmark type", entry["type"], self.landmarks)
            params, entry = _split({k: v for k, v in entry.items() if k != "type"}, cls, own, key="type")
            made["model"] = self.landmark_type({"type": snake(cls.__name__)} | params, frame)
        check_keys(entry, ["type", *own])
        if "surveyed" in entry:
            made["surveyed"] = _entries(entry, "surveyed", partial(_without_models, Surveyed), "landmark.")
            del entry["surveyed"]
        return construct(Landmark, entry, **made)

    def landmark_type(self, entry, frame):
        """Read a landmark type, from its name or a table. One that exists in 2D and in 3D is as the robots are."""
        params = {"type": entry} if isinstance(entry, str) else dict(entry)
        cls = self._model("landmark", "landmark type", _pop(params, "type", self.landmarks), self.landmarks)
        if frame is not None and "dim" in parameters(cls):
            params = {"dim": frame.dim} | params
        return cls(**arguments(cls, params))

    def world(self, entry):
        """Read a world: a function of `simulation.worlds` and its arguments."""
        function = look_up("world", _pop(entry, "type", self.worlds), self.worlds)
        values = arguments(function, entry)
        takes_rng = "rng" in inspect.signature(function).parameters
        return World(build=partial(_build, function, takes_rng, values), type=function.__name__)

    def options(self, entry):
        """Read the options; the association is a name, or a table with `type` and parameters."""
        known, made = _keys(Options, without=("lmk_type", "n", "N")), {}
        check_keys(entry, known)
        if "association" in entry:
            given = entry.pop("association")
            with errors_at("association"):
                params = {"type": given} if isinstance(given, str) else dict(given)
                cls = look_up("association", _pop(params, "type", self.associations), self.associations)
                made["association"] = cls(**arguments(cls, params))
        return construct(Options, entry, **made)


def _build(function, takes_rng, values, rng):
    """Build the landmarks of a world. (A function of its own, so that user data can be sent to another process.)"""
    return function(rng, **values) if takes_rng else function(**values)


def _pop(entry, key, known):
    if key not in entry:
        raise ValueError(f"{key} is missing; known: {', '.join(known)}")
    return entry.pop(key)


def _keys(cls, without):
    return [name for name in parameters(cls) if name not in without]


def _split(entry, cls, own, key):
    """The parameters of a model and the keys of its owner, from a table that has both; the owner's come first."""
    known = [key, *own, *(k for k in keys_of(cls) if k not in own)]
    params = parameters(cls)
    check_keys(entry, known, also=[*radian_keys(known), *(f"{name}_deg" for name in params), *params])
    mine = {k: v for k, v in entry.items() if k not in own and k not in radian_keys(own)}
    return mine, {k: v for k, v in entry.items() if k not in mine}


def _parameter_keys(sensor):
    """Return where keys of parameters that may be states go: "k_std" -> ("params_std", "k")."""
    angles, keys = getattr(sensor, "angles", ()), {}
    for name in (*getattr(sensor, "parameters", ()), *getattr(sensor, "tied", ()), *UNIVERSAL):
        deg = "_deg" if name in angles else ""
        keys |= {f"{name}_{what}{deg}": (f"params_{what}", name) for what in ("std", "walk")}
    return {key: where for key, where in keys.items() if key not in parameters(sensor)}


def _groups(motion):
    """Return where a robot's keys for controls and start values go: "da_std_deg" -> ("control_std", "da_deg")."""
    groups = {}
    for group, names in (("control", motion.control_fields), ("state", motion.state_fields)):
        for name in names:
            groups[name], groups[std_key(name)] = (group, name), (f"{group}_std", name)
    return groups
