"""Which recording a scenario means."""

from pathlib import Path

from ..toolbox.images.extra import opencv
from ..toolbox.rendezvous import find_starts
from ..toolbox.scenario.keys import arguments, look_up
from ..toolbox.user_input import errors_at
from . import (
    euroc_v101,
    lecture,
    lost_in_the_woods,
    monoslam_desk,
    mrclam,
    mrclam_twin,
    plaza,
    starry_night,
    victoria_park,
    victoria_park_raw,
    victoria_park_twin,
)
from .sources import ENVIRONMENT, data_folders, find_file

ADDRESSES = {
    "mrclam": {f"MRCLAM_Dataset{n}": f"ftp://asrl3.utias.utoronto.ca/MRCLAM/MRCLAM{n}.zip" for n in range(1, 10)},
}
"""Data set -> part -> where its publisher offers it to programs. The others are offered on pages, for people."""

CHECKSUMS = {
    "dataset2.mat": "bbaeae95687376f115c9a8bf637097c65ce275f3bc66cc2cd8cd2755608682d9",
    "aa3_dr.mat": "6ce2c4f757023b7d275cc14f24ff2ffcca21ea68cfa360bc854e620a706eb358",
    "aa3_gpsx.mat": "521fc4c6e0ea3851ffb463c3d9c0578044e9178c4fb87f37c703bb587f38c755",
}
"""SHA-256 of files as their publishers hand them out. Those of the zips of MRCLAM are not known."""


def _mrclam(set: int = 9, robots: tuple = (3,), path: str | None = None):
    """A set of MRCLAM; when it is not here and no path was given, the simulated twin, which says so."""
    if not 1 <= set <= 9:
        raise ValueError(f"set: MRCLAM has the sets 1 to 9, got {set}")
    if path is not None or mrclam.find_set(set) is not None:
        return mrclam.load(set, robots, path)
    twin = mrclam_twin.load(robots)
    missing = f"MRCLAM set {set} is not found {_nowhere()}"
    twin.notes.insert(0, f"{missing}: the simulated twin runs instead. See `ekfslam data`.")
    return twin


def _mrclam_twin(robots: tuple = (1,), seed: int = 1, duration: float = 300.0):
    return mrclam_twin.load(robots, seed, duration)


def _euroc_v101(path: str | None = None, first: int = 0, last: int | None = None, clock_std: float | None = None):
    """EuRoC V1_01; when it is not here and no path was given, the simulated twin, which says so."""
    if path is not None or find_file(euroc_v101.FILE) is not None:
        return euroc_v101.load(path, first, last, clock_std)
    from . import euroc_twin  # here: scipy's rotations take a while to load

    twin = euroc_twin.twin(clock_std=clock_std)
    missing = f"EuRoC V1_01 is not found {_nowhere()}"
    twin.notes.insert(0, f"{missing}: the simulated twin runs instead. See `ekfslam data`.")
    return twin


def _lecture():
    return lecture.load_data()


def _lost_in_the_woods(path: str | None = None, max_range: float = lost_in_the_woods.MAX_RANGE):
    if path is None and find_file(lost_in_the_woods.FILE) is None:
        return lost_in_the_woods.twin()
    return lost_in_the_woods.load(path, max_range)


def _monoslam_desk(
    path: str | None = None,
    camera: int | None = None,
    first: int = 0,
    last: int | None = None,
    step: int = 1,
    target: tuple | None = None,
    forget: int | None = None,
):
    """The images of MonoSLAM's desk; when they are not here and no path was given, the rendered twin, which says so.

    With a camera or a video file it is that which is watched.
    """
    opencv()
    if camera is not None or (path is not None and not Path(path).is_dir()):
        return monoslam_desk.own(path, camera, first, last, step, target or (), forget)
    target = monoslam_desk.TARGET if target is None else target
    if path is not None or monoslam_desk.find_frames() is not None:
        return monoslam_desk.load(path, first, last, step, target, forget)
    n = monoslam_desk.TWIN if last is None else last - first + 1
    twin = monoslam_desk.twin(n=n, step=step, forget=forget)
    missing = f"{monoslam_desk.NAME} is not found {_nowhere()}"
    twin.notes.insert(0, f"{missing}: the simulated twin runs instead. See `ekfslam data`.")
    return twin


def _plaza(set: int = 2, path: str | None = None):
    """A set of Plaza; when it is not here and no path was given, the simulated twin, which says so."""
    if path is not None or set not in plaza.FILES or find_file(plaza.FILES[set]) is not None:
        return plaza.load(set, path)
    twin = plaza.twin()
    twin.notes.insert(0, f"Plaza {set} is not found {_nowhere()}: the simulated twin runs instead. See `ekfslam data`.")
    return twin


def _starry_night(path: str | None = None, first: int = 0, last: int | None = None, sign: float = starry_night.SIGN):
    """Starry Night; when it is not here and no path was given, the simulated twin, which says so."""
    if path is not None or find_file(starry_night.FILE) is not None:
        return starry_night.load(path, first, last, sign)
    twin = starry_night.twin()
    missing = f"Starry Night is not found {_nowhere()}"
    twin.notes.insert(0, f"{missing}: the simulated twin runs instead. See `ekfslam data`.")
    return twin


def _victoria_park(path: str | None = None, raw: bool = False):
    """Victoria Park; when it is not here and no path was given, the simulated twin, which says so."""
    if raw or find_file(victoria_park.FILE, path) is None and find_file(victoria_park_raw.SCANS, path) is not None:
        rec = victoria_park.recording(victoria_park_raw.read_raw_log(path), victoria_park_raw.OWN_CALIBRATION)
        rec.notes.insert(0, "trees found in the raw scans by the detector of this package")
        return rec
    if path is not None or find_file(victoria_park.FILE) is not None:
        return victoria_park.load(path)
    twin = victoria_park_twin.load()
    missing = f"Victoria Park is not found {_nowhere()}"
    twin.notes.insert(0, f"{missing}: the simulated twin runs instead. See `ekfslam data`.")
    return twin


def _victoria_park_twin(seed: int = 1, duration: float = 240.0, raw: bool = False):
    return victoria_park_twin.load(seed, duration, raw)


def _nowhere():
    return f"in {', '.join(map(str, data_folders()))}" if data_folders() else f"({ENVIRONMENT} is not set)"


LOADERS = {
    "euroc_v101": _euroc_v101,
    "mrclam": _mrclam,
    "mrclam_twin": _mrclam_twin,
    "lecture": _lecture,
    "lost_in_the_woods": _lost_in_the_woods,
    "monoslam_desk": _monoslam_desk,
    "plaza": _plaza,
    "starry_night": _starry_night,
    "victoria_park": _victoria_park,
    "victoria_park_twin": _victoria_park_twin,
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
    with errors_at(f"data {data.name!r}"):
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
