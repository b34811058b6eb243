"""Which data sets there are, which of them are here, whether they are whole, and which recording a scenario means."""

import hashlib
from dataclasses import dataclass
from pathlib import Path

from ..toolbox.rendezvous import find_starts
from ..toolbox.tables import arguments, at, look_up
from . import lecture, lost_in_the_woods, mrclam, mrclam_twin, victoria_park
from .mrclam_log import ROBOTS, read_set
from .sources import ENVIRONMENT, data_folders, find_file


@dataclass(frozen=True)
class DataSet:
    """A data set of others, as its publisher hands it out. It is not part of this package: there is no licence to.

    Parameters
    ----------
    name : str
        As in the scenario's `[data] name`.
    title, home, citation : str
        What it is, where its publisher offers it, what to cite.
    parts : tuple of str
        The names of its zips, without `.zip`.
    sha256 : dict of str to str
        Checksums of the zips that this package was tested with.
    """

    name: str
    title: str
    home: str
    citation: str
    parts: tuple
    sha256: dict


MRCLAM = DataSet(
    name="mrclam",
    title="UTIAS Multi-Robot Cooperative Localization and Mapping (MRCLAM), nine sets",
    home="https://asrl.utias.utoronto.ca/datasets/mrclam/",
    citation=(
        "K. Y. K. Leung, Y. Halpern, T. D. Barfoot, H. H. T. Liu, The UTIAS Multi-Robot Cooperative Localization and "
        "Mapping Dataset, Int. J. Robotics Research 30(8):969-974, 2011"
    ),
    parts=tuple(f"MRCLAM_Dataset{n}" for n in range(1, 10)),
    sha256={
        "MRCLAM_Dataset7": "ef56f5c40930268cd8cd48699772030ffcf4bcecc9a2b73d4f1cee0638319bd3",
        "MRCLAM_Dataset9": "ec93e249b0abcd26790989ebe5e5a797625ab5630a5edd32a9d71f66f43bf938",
    },
)
DATASETS = (MRCLAM,)


@dataclass(frozen=True)
class Status:
    """What is known about one part of a data set.

    Parameters
    ----------
    part : str
    path : Path or None
        Where it is; None if it was not found.
    ok : bool or None
        Whether it could be read as a whole; None if that was not tried.
    message : str
        The same in words.
    """

    part: str
    path: Path | None
    ok: bool | None
    message: str


def check(dataset=MRCLAM, verify=True):
    """Look for all parts of a data set and, if asked, read each of them to the end.

    Parameters
    ----------
    dataset : DataSet
    verify : bool
        About a second for each part that is here.

    Returns
    -------
    list of Status
        In the order of `dataset.parts`.
    """
    return [_check_part(dataset, part, verify) for part in dataset.parts]


def _check_part(dataset, part, verify):
    source = mrclam.find_set(int(part[-1]))
    if source is None:
        return Status(part, None, None, "not found")
    if not verify:
        return Status(part, source.path, None, "found")
    try:
        log = read_set(source, ROBOTS)
    except (OSError, ValueError) as error:
        return Status(part, source.path, False, f"damaged: {error}")
    sightings = sum(len(robot.landmarks) + len(robot.robots) for robot in log.robots.values())
    what = f"whole: {sightings} sightings by {len(log.robots)} robots"
    return Status(part, source.path, True, f"{what}; {_checksum(dataset, part, source)}")


def _checksum(dataset, part, source):
    known = dataset.sha256.get(part)
    if not source.path.is_file():
        return "unpacked, so there is no checksum to compare"
    if known is None:
        return "no checksum is known to compare with"
    same = hashlib.sha256(source.path.read_bytes()).hexdigest() == known
    return "the file this was tested with" if same else "another edition than the file this was tested with"


def report(verify=True):
    """What `ekfslam data` prints.

    Returns
    -------
    text : str
    ok : bool
        False if something that is here is damaged.
    """
    folders = data_folders()
    where = ", ".join(map(str, folders)) or f"no folder: set {ENVIRONMENT} to the folder with your data sets"
    lines, ok = [f"looking in {where}", ""], True
    for dataset in DATASETS:
        statuses = check(dataset, verify)
        ok &= all(s.ok is not False for s in statuses)
        width = max(len(s.part) for s in statuses)
        lines += [f"{dataset.name}: {dataset.title}"]
        lines += [f"  {s.part:<{width}}  {s.message}{f'  ({s.path})' if s.path else ''}" for s in statuses]
        if any(s.path is None for s in statuses):
            lines += [
                f"  To get what is missing: {dataset.home}",
                f"  Put the zips, packed or unpacked, into the folder that {ENVIRONMENT} names.",
                "  They come without a licence text: use them, do not pass them on.",
            ]
        lines += [f"  Please cite: {dataset.citation}.", ""]
    lines += ["mrclam_twin: simulated logs in the same files, made when asked for; nothing to download."]
    return "\n".join(lines), ok


# --- from a scenario to its recording --------------------------------------------------------------------------------


def _mrclam(set: int = 9, robots: tuple = (3,), path: str | None = None):
    """A set of MRCLAM; when it is not here and no path was given, the simulated twin, which says so."""
    if not 1 <= set <= 9:
        raise ValueError(f"set: MRCLAM has the sets 1 to 9, got {set}")
    if path is not None or mrclam.find_set(set) is not None:
        return mrclam.load(set, robots, path)
    twin = mrclam_twin.load(robots)
    where = f"in {', '.join(map(str, data_folders()))}" if data_folders() else f"({ENVIRONMENT} is not set)"
    twin.notes.insert(0, f"MRCLAM set {set} is not found {where}: the simulated twin runs instead. See `ekfslam data`.")
    return twin


def _mrclam_twin(robots: tuple = (1,), seed: int = 1, duration: float = 300.0):
    return mrclam_twin.load(robots, seed, duration)


def _lecture():
    return lecture.load_data()


def _lost_in_the_woods(path: str | None = None, max_range: float = lost_in_the_woods.MAX_RANGE):
    if path is None and find_file(lost_in_the_woods.FILE) is None:
        return lost_in_the_woods.twin()
    return lost_in_the_woods.load(path, max_range)


def _victoria_park(path: str | None = None):
    return victoria_park.load(path)


LOADERS = {
    "mrclam": _mrclam,
    "mrclam_twin": _mrclam_twin,
    "lecture": _lecture,
    "lost_in_the_woods": _lost_in_the_woods,
    "victoria_park": _victoria_park,
}


def load_recording(data):
    """The recording that a scenario's `[data]` names.

    Parameters
    ----------
    data : toolbox.Data
        A name of `LOADERS`, and parameters of that loader.

    Returns
    -------
    Recording
        Its notes tell what was dropped or put right, and first of all if it is a simulated one in place of a real one.

    Raises
    ------
    ValueError
        Unknown name or parameter, with the nearest known one; a damaged file, with its line.
    FileNotFoundError
        A path that was given does not lead to the data.
    """
    loader = look_up("data set", data.name, LOADERS)
    with at(f"data {data.name!r}"):
        values = arguments(loader, data.params)
    return loader(**values)


def prepare(userdata):
    """A scenario and the recording it is to run on.

    Parameters
    ----------
    userdata : toolbox.UserData

    Returns
    -------
    userdata : UserData
        If the recording has other robots than the scenario, the first robot of the scenario stands for each of them.
        A given start is then that of the first one; where the others start relative to it is found from the landmarks
        that they have in common. Without a given start each begins where the ground truth does; but on a known map
        (localisation) the landmarks tell it.
    recording : Recording or None
        None for a simulation: the scenario has no `[data]`.

    Raises
    ------
    ValueError
        If a start has to be found and the robots have too few landmarks in common.
    """
    if userdata.data is None:
        return userdata, None
    recording = load_recording(userdata.data)
    ids, first, together = list(recording.robots), userdata.robots[0], False
    if {robot.id for robot in userdata.robots} != set(ids):
        userdata = userdata.for_robots(ids)
        together = len(ids) > 1 and first.position is not None
    lost = not userdata.landmark.in_map and all(robot.position is None for robot in userdata.robots)
    if lost or together:
        userdata, note = find_starts(userdata, recording)
        recording.notes.append(note)
    return userdata, recording
