"""ROS 1 and ROS 2 bags and MCAP as tables, by the library `rosbags`: no ROS is needed.

A topic is a table. Fields of a message become columns, `twist.twist.linear.x`; a quaternion `orientation` also gives
`orientation.yaw`. A message that holds a list of things, landmarks or detections, gives a row for each of them, and so
does one with arrays of the same length. `t` is the stamp of the header, or else when the bag took the message, s. Words
of things in a list, their names, are numbered by the alphabet. A `CameraInfo` gives one row: intrinsic parameters.
"""

from dataclasses import dataclass, field, fields
from pathlib import Path

import numpy as np

EXTRA = "bags are read by the package rosbags: pip install ekfslam_tutorial[bags]"
RAW = ("LaserScan", "PointCloud2", "PointCloud", "Image", "CompressedImage", "OccupancyGrid", "TFMessage")
"""Messages without landmarks, or without numbers that are any use here."""
COVARIANCES = (4, 9, 36)
"""Lengths of arrays that are covariances if their name says so."""


def is_bag(path):
    """Tell a bag by its name: .bag, .mcap, .db3, or a folder with metadata.yaml."""
    return path.suffix in (".bag", ".mcap", ".db3") or (path / "metadata.yaml").is_file()


def read_bag(path):
    """Read all topics of a bag.

    Parameters
    ----------
    path : path

    Returns
    -------
    list of (str, dict, list, str, str, dict)
        Topic, columns, notes, type of its messages, frame in which they are; of `/tf_static` what is mounted where.

    Raises
    ------
    ValueError
        One sentence: `rosbags` is not installed, or the bag is damaged.
    """
    try:
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_typestore
    except ImportError as error:
        raise ValueError(f"{path}: {EXTRA}") from error
    path = Path(path)
    try:
        with AnyReader([path], default_typestore=get_typestore(Stores.LATEST)) as bag:
            topics = topics_of(bag)
    except Exception as error:  # of many kinds, by what is broken
        said = " ".join(str(error).split())[:200] or type(error).__name__
        raise ValueError(f"{path} is no bag that can be read: {said}") from error
    if not any(topic.rows for topic in topics.values()):
        there = ", ".join(f"{name} ({topic.kind})" for name, topic in topics.items()) or "none"
        raise ValueError(f"{path} holds no messages that could be of use; topics there: {there}")
    return [
        (name, columns(topic.rows, topic.notes), tuple(topic.notes), topic.kind, topic.frame, topic.mounts)
        for name, topic in topics.items()
    ]


@dataclass
class Topic:
    """Content of the messages of a topic: rows, notes, their type, their frame, what is mounted where."""

    kind: str
    rows: list = field(default_factory=list)
    notes: list = field(default_factory=list)
    frame: str = ""
    mounts: dict = field(default_factory=dict)

    def add(self, message, stamp):
        """Take a message, s."""
        self.frame = self.frame or frame_of(message)
        if hasattr(message, "transforms"):
            self.mounts |= mounted(message)
        elif not hasattr(message, "distortion_model"):
            self.rows += rows_of(message, stamp)
        elif not self.rows:
            self.rows.append(camera_row(message, self.notes))


def topics_of(bag):
    """All topics of an open bag, {name: Topic}; of raw data no message is read."""
    topics, wanted = {}, []
    for connection in bag.connections:
        topic = topics.setdefault(connection.topic, Topic(connection.msgtype))
        if topic.kind.rpartition("/")[2] not in RAW or connection.topic.endswith("tf_static"):
            wanted.append(connection)
        elif not topic.notes:
            topic.notes.append(f"{topic.kind}: raw data, no landmarks in it; a detector must find them first")
    for connection, stamp, data in bag.messages(wanted) if wanted else ():
        topics[connection.topic].add(bag.deserialize(data, connection.msgtype), stamp * 1e-9)
    return topics


def columns(rows, notes):
    """Columns of rows that are dictionaries; words become numbers, by the alphabet, and a note says so."""
    found = {}
    for name in dict.fromkeys(name for row in rows for name in row):
        cells = [row.get(name, np.nan) for row in rows]
        words = sorted({cell for cell in cells if isinstance(cell, str) and cell})
        if words:
            number = {word: k for k, word in enumerate(words, 1)}
            cells = [number.get(cell, np.nan) if isinstance(cell, str) else cell for cell in cells]
            notes.append(f"column {name} holds words: {len(words)} different, numbered by the alphabet")
        if not words or len(number) > 1:  # one word says nothing
            found[name] = np.array([np.nan if isinstance(cell, str) else cell for cell in cells], float)
    return found


def frame_of(message):
    """The frame in which a message is; of an odometry that of the robot."""
    header = getattr(getattr(message, "header", None), "frame_id", "")
    return str(getattr(message, "child_frame_id", "") or header).lstrip("/")


def mounted(message):
    """Mountings: {frame: (frame that carries it, pose [t; q] in it)}."""
    found = {}
    for tf in message.transforms:
        t, q = tf.transform.translation, tf.transform.rotation
        pose = np.array([t.x, t.y, t.z, q.w, q.x, q.y, q.z])
        found[tf.child_frame_id.lstrip("/")] = tf.header.frame_id.lstrip("/"), pose
    return found


def camera_row(message, notes):
    """The row of a `CameraInfo`: intrinsic parameters, size of the image, distortion."""
    values = {name.lower(): getattr(message, name) for name in ("K", "D", "k", "d") if hasattr(message, name)}
    k, d = np.asarray(values["k"], float), np.asarray(values["d"], float)
    row = {"fx": k[0], "fy": k[4], "cx": k[2], "cy": k[5]}
    row |= {"width": float(message.width), "height": float(message.height)}
    if message.distortion_model in ("plumb_bob", "") or not d.any():
        return row | {f"d{i}": value for i, value in enumerate(d[:5], 1)}
    notes.append(f"distortion {message.distortion_model} is not known here: pixels are taken to be rectified")
    return row


def rows_of(message, stamp):
    """Rows of a message: one, or one for each thing in its list; an empty list gives a row with the time only."""
    row = {"t": stamp}
    lists, arrays = _fields(message, "", row)
    row["t"] = _stamp(row, "header.") or stamp
    row = {name: value for name, value in row.items() if not name.startswith("header.") and ".stamp." not in name}
    row = {name: value for name, value in row.items() if not isinstance(value, str)}
    if lists:
        name, things = max(lists.items(), key=lambda item: len(item[1]))
        beside = {key: a for key, a in arrays.items() if len(a) == len(things)}  # ids in a list of their own
        rows = []
        for k, thing in enumerate(things):
            own = _thing(thing, f"{name}.")
            row["t"] = _stamp(own, f"{name}.header.") or row["t"]
            own |= {key: float(a[k]) for key, a in beside.items()}
            rows.append(row | {key: value for key, value in own.items() if ".header." not in key})
        return rows or [row]
    lengths = [len(a) for a in arrays.values()]
    if lengths:
        n = max(set(lengths), key=lengths.count)
        same = {name: a for name, a in arrays.items() if len(a) == n}
        return [row | {name: float(a[k]) for name, a in same.items()} for k in range(n)] or [row]
    return [row]


def _thing(thing, before):
    """Numbers and words of a thing in a list; of what it has in lists of its own, those of the first."""
    row = {}
    lists, arrays = _fields(thing, before, row)
    for name, inner in lists.items():
        if inner and len(inner) < 3:  # results of a detection, the best one first; not corners, contours
            row |= _thing(inner[0], f"{name}.")
    return row | {name: float(a[0]) for name, a in arrays.items() if len(a) == 1}


def _stamp(row, before):
    """The time of a header, s; 0 where there is none."""
    return row.get(f"{before}stamp.sec", 0.0) + 1e-9 * row.get(f"{before}stamp.nanosec", 0.0)


def _fields(message, before, row):
    """Put the numbers of a message into a row; return its lists of messages, and its arrays of numbers."""
    lists, arrays = {}, {}
    for key in (f.name for f in fields(message) if not f.name.startswith("__")):
        value, name = getattr(message, key), before + key
        if isinstance(value, bool | int | float | np.number):
            row[name] = float(value)
        elif isinstance(value, str):
            row[name] = float(value) if value.lstrip("-").isdigit() else value
        elif hasattr(value, "__dataclass_fields__"):
            more = _fields(value, f"{name}.", row)
            lists |= more[0]
            arrays |= more[1]
            if {"x", "y", "z", "w"} <= set(value.__dataclass_fields__):
                x, y, z, w = value.x, value.y, value.z, value.w
                row[f"{name}.yaw"] = float(np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)))
        elif isinstance(value, list | tuple) and (not value or hasattr(value[0], "__dataclass_fields__")):
            lists[name] = value
        elif isinstance(value, np.ndarray | list | tuple):
            a = np.asarray(value)
            is_covariance = "covariance" in key and a.size in COVARIANCES
            if a.ndim == 1 and a.dtype.kind in "iuf" and not is_covariance:
                arrays[name] = a
    return lists, arrays
