"""State logs: what happened in a run, small enough to be stored in a notebook and played there.

A log records states, not pictures. A frame holds only what has changed, so 100 frames take about 60 kB as JSON; the
format is described in `StateLog`.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from ..states import TruthInMap
from .coding import METRE, RADIAN
from .frames import Decoder, LogFrame
from .images import image_of
from .recorder import Memory, frame_record, header

Array = np.ndarray

FORMAT, VERSION = "ekfslam_tutorial state log", 1


class StateLog:
    """A log of a run, filled snapshot by snapshot, that the player plays.

    Parameters
    ----------
    title : str
        What the run is, for the heading of the player.
    k : float
        Ellipses are drawn at k sigma.
    period : int
        Take every `period`-th snapshot. Landmarks that are started or deleted in between are not forgotten.
    align : bool, optional
        Show the truth in the frame of the map; see `MapFig`.
    images : int
        Every so many frames of the log have the image of the camera, if there is one; 0 is none. An image of 320 x 240
        pixels takes about 12 kB.

    Notes
    -----
    `to_json` gives ``{"format", "version", "title", "k", "dim", "units", "robots", "sensors", "frames"}``. Positions
    are integers in millimetres, headings in 1e-4 rad, quaternions in 1e-4. ``x`` is a position in the map's frame,
    followed in a pose by the heading or the quaternion [a b c d]. ``cov`` is ``e, L11, L21, L22, ...``: the lower
    triangle of L with ``L L' = P``, in units of ``2**e`` metres. A sensor has id, robot, name, units and point (it
    measures points), and what is known of fov and reach (rad, m) and of view: half the width and half the height of a
    camera's picture at distance 1. A frame is a dictionary with the keys

    =========  =======================================================================================================
    k, t       frame number, and seconds since the start
    rob        ``[id, x, cov]`` of every robot, and in the plane the std of the heading; a known robot has no ``cov``,
               one without a finite place nothing but its id
    true       ``[id, x]`` of every robot whose true pose is known
    sen        ``[id, x]`` of the sensors that have moved on their robot: all of them in the first frame
    lmk        of the landmarks that have changed ``[id, dx]``, the step from where it was (at first, from the
               origin), or ``[id, dx, cov]``. A known one has a zero ``cov``; null stands for a ``cov`` that is not
               finite; one without a finite place has nothing but its id
    lin        ``[id, x1, x2, cov1, cov2]`` of the lines of which an end has changed: both ends, as far as it was seen
    edge       ``[id, x1, x2]`` of the true edges, once
    gone, new  ids of landmarks that were deleted, then of those that were started
    used,      ``{sensor id: [[landmark id, md2, z ..., std of z ...], ...]}``: the innovations that corrected the map,
    rejected   and those outside the gate. md2 is in hundredths, z in hundredths of its std. Where the sensor measures
               distances, the measured point follows, as seen from the corrected robot
    missed     ``{sensor id: [landmark id, ...]}``: looked for, and not found
    world      ``[id, x]`` of the true landmarks, in the frame in which they become known
    note       ``[what, landmark id]``: other events, for example ["refused", 7] because the map was full
    img        address of a JPEG that is in it: what the first camera sees. ``images`` beside ``frames`` says how many
               frames of the run there are for one
    whole      1 in a frame that begins anew: nothing before it counts
    =========  =======================================================================================================

    Keys without content are left out. A landmark is written again when its mean has moved by more than 0.2 of its
    standard deviation, or its standard deviation has changed by more than 10 %, in any direction; below 1 cm, of 1 cm.
    So what is read back is never further from the run than that, plus rounding.

    Examples
    --------
    >>> log = StateLog("two rounds")
    >>> for snapshot in universal_slam(userdata):
    ...     frame = log.add(snapshot)
    >>> log.save("two_rounds.json")              # or replay(log), in a notebook
    """

    def __init__(self, title: str = "", k: float = 3, period: int = 1, align: bool | None = None, images: int = 0):
        if int(period) != period or period < 1:
            raise ValueError(f"period must be 1, 2, 3 ..., got {period}")
        if not (np.isfinite(k) and k > 0):
            raise ValueError(f"ellipses are drawn at a positive number of sigmas, got k = {k}")
        self.title, self.k, self.period, self.align = str(title), float(k), int(period), align
        self.images = int(images)
        self.head: dict[str, Any] | None = None
        self.records: list[dict[str, Any]] = []
        self._seen = 0
        self._between: list = []  # events of the snapshots that were passed over
        self._memory = Memory()
        self._truth: TruthInMap | None = None

    def __len__(self) -> int:
        return len(self.records)

    def add(self, snapshot) -> dict[str, Any] | None:
        """Take a snapshot and return its record; None if it is one of those that `period` leaves out."""
        due, self._seen = self._seen % self.period == 0, self._seen + 1
        self._between += snapshot.events
        if not due:
            return None
        if self.head is None or self._truth is None:
            self.head = header(snapshot)
            self._truth = TruthInMap(not snapshot.sim_robs if self.align is None else self.align)
        record = frame_record(snapshot, self._between, self._truth, self._memory)
        self._between = []
        if self.images and len(self.records) % self.images == 0 and (image := image_of(snapshot)):
            record["img"] = image
            self.head["images"] = self.images * self.period
        self.records.append(record)
        return record

    def whole(self, snapshot) -> dict[str, Any]:
        """Return a record of all that is known now, for a viewer that has not seen the frames before."""
        if self._truth is None:
            raise ValueError("nothing was added to the log yet")
        return {"whole": 1, **frame_record(snapshot, snapshot.events, self._truth, Memory())}

    def frames(self) -> list[LogFrame]:
        """Return what a viewer sees in each frame, read back from the records."""
        if self.head is None:
            return []
        decoder = Decoder(self.head)
        return [decoder.read(record) for record in self.records]

    # ------------------------------------------------------------------------------------------------------------ JSON

    def to_dict(self, frames: bool = True) -> dict[str, Any]:
        """Return the log as plain lists, dictionaries and numbers; without frames, only what is said once."""
        first = {"format": FORMAT, "version": VERSION, "title": self.title, "k": self.k}
        units = {"units": {"m": METRE, "rad": RADIAN}}
        rest = self.head or {"dim": 2, "robots": [], "sensors": []}
        return {**first, **units, **rest, "frames": self.records if frames else []}

    def to_json(self) -> str:
        """Return the log as JSON, without a blank too many."""
        return json.dumps(self.to_dict(), separators=(",", ":"), ensure_ascii=False, allow_nan=False)

    @classmethod
    def from_json(cls, text: str) -> StateLog:
        """Return the log that `to_json` wrote.

        Parameters
        ----------
        text : str

        Raises
        ------
        ValueError
            If it is not such a log, saying what is wrong and in which frame.
        """
        try:
            data = json.loads(text)
        except json.JSONDecodeError as error:
            raise ValueError(f"a state log is JSON, and this is not: {error}") from error
        if not isinstance(data, dict) or data.get("format") != FORMAT:
            raise ValueError(f'a state log begins with {{"format": "{FORMAT}"}}; this text does not')
        if data.get("version") != VERSION:
            raise ValueError(f"this state log has version {data.get('version')}; this program reads version {VERSION}")
        missing = {"title", "k", "units", "dim", "robots", "sensors", "frames"} - set(data)
        if missing:
            raise ValueError(f"the state log lacks {', '.join(sorted(missing))}")
        if data["units"] != {"m": METRE, "rad": RADIAN}:
            raise ValueError(f"the units of a state log are {METRE} m and {RADIAN} rad, got {data['units']}")
        log = cls(data["title"], data["k"])
        log.head = {key: data[key] for key in ("dim", "robots", "sensors", "images") if key in data}
        log.records = data["frames"]
        log.frames()  # reads every record, and complains about the first that it cannot read
        return log

    def save(self, path: str | Path) -> None:
        """Write the log as a JSON file."""
        Path(path).write_text(self.to_json() + "\n", encoding="utf-8")

    @classmethod
    def load(cls, path: str | Path) -> StateLog:
        """Read the log from a JSON file."""
        return cls.from_json(Path(path).read_text(encoding="utf-8"))
