"""What the user writes as a whole (the manual's userData), as Python objects or as a TOML file.

Degrees are allowed in it and only in it, in keys that end in `_deg`; `start` and `control` methods hand on SI units and
radians.
"""

from dataclasses import dataclass, field, replace
from pathlib import Path

from ...models.landmarks import EucPnt
from ..user_input import check_id, check_kind, errors_at
from .agreement import check_agreement
from .keys import construct
from .reading import parse_toml, read_table, read_toml
from .robots import Robot, Sensor
from .sections import Data, FigureOptions, Landmark, Options, Time, World


@dataclass(kw_only=True)
class UserData:
    """User data: all the user has to say (manual: userData).

    Parameters
    ----------
    name : str
    seed : int
        Of everything random.
    robots, sensors : list of Robot, list of Sensor
    landmark : Landmark
    world : World, optional
        Not needed with a recording.
    time : Time
    options : Options
    figure : FigureOptions
    data : Data, optional
    """

    name: str = "unnamed"
    seed: int = 1
    robots: list
    sensors: list = field(default_factory=list)
    landmark: Landmark = field(default_factory=Landmark)
    world: World | None = None
    time: Time = field(default_factory=Time)
    options: Options = field(default_factory=Options)
    figure: FigureOptions = field(default_factory=FigureOptions)
    data: Data | None = None

    def __post_init__(self):
        check_id("seed", self.seed)
        self._check_kinds()
        if self.robots and self.landmark.model is None:
            self.landmark = replace(self.landmark, model=EucPnt(self.frame.dim))
        check_agreement(self)

    def _check_kinds(self):
        """Refuse objects of other classes; `slam.Options`, for one, does not know the size of the map."""
        kinds = {"landmark": Landmark, "time": Time, "options": Options, "figure": FigureOptions}
        kinds |= {name: kind for name, kind in (("world", World), ("data", Data)) if getattr(self, name) is not None}
        for name, kind in kinds.items():
            check_kind(name, getattr(self, name), kind)
        for name, kind in (("robots", Robot), ("sensors", Sensor)):
            for entry in getattr(self, name):
                check_kind(f"each of {name}", entry, kind)

    @property
    def frame(self):
        """Frame2 or Frame3: whether the whole scenario is in the plane or in space."""
        return self.robots[0].frame

    @property
    def named(self):
        """True if landmarks have the ids of those in the world: they are known, or measurements carry their ids.

        False where the association numbers them as they come.
        """
        return not self.landmark.in_map or getattr(self.options.association, "by_id", False)

    @classmethod
    def from_toml(cls, path, overrides=None, models=()):
        """Read a scenario file.

        Parameters
        ----------
        path : path
        overrides : dict, optional
            Values by dotted key, which replace those of the file: {"data.set": 7, "robot.1.dx_std": 0.01}.
        models : iterable of classes
            The reader's own motion models, sensors and landmark types, to be named in the file like the package's.

        Raises
        ------
        FileNotFoundError
        ValueError, TypeError
            One sentence: file, entry, key, what was got and what was possible.
        """
        path = Path(path)
        with errors_at(path.name):
            return cls.from_dict({"name": path.stem} | read_toml(path), overrides, models)

    @classmethod
    def from_text(cls, text, overrides=None, models=()):
        """Read the text of a scenario file.

        Parameters
        ----------
        text : str
            What would stand in the file.
        overrides, models
            As in `from_toml`.

        Raises
        ------
        ValueError, TypeError
            One sentence: entry, key, what was got and what was possible.
        """
        return cls.from_dict(parse_toml(text), overrides, models)

    @classmethod
    def from_dict(cls, table, overrides=None, models=()):
        """Read a dictionary that looks like the file."""
        values, parts = read_table(table, overrides, models)
        return construct(cls, values, **parts)

    def slam_options(self):
        """The options as the steps of `slam` take them: with landmark type and prior."""
        n, N = self.landmark.prior()
        return replace(self.options, lmk_type=self.landmark.model, n=n, N=N)

    def for_robots(self, ids):
        """The same scenario with these robots instead: copies of the first robot, each with copies of its sensors.

        A robot's only sensor takes the robot's id; several take 10 id + 1, 10 id + 2, ...
        """
        first = self.robots[0]
        own = [s for s in self.sensors if s.robot == first.id]
        number = lambda i, j: i if len(own) == 1 else 10 * i + j + 1
        return replace(
            self,
            robots=[replace(first, id=i, name=f"robot {i}") for i in ids],
            sensors=[replace(s, id=number(i, j), robot=i) for i in ids for j, s in enumerate(own)],
        )
