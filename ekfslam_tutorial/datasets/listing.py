"""Which data sets of others there are, which of them are here, and whether they are whole: `ekfslam data`."""

import gzip
import hashlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from . import euroc_v101, lost_in_the_woods, monoslam_desk, mrclam, plaza, starry_night, victoria_park
from .mrclam_log import ROBOTS, read_set
from .sources import ENVIRONMENT, Source, data_folders, find_file


def _mrclam_whole(path):
    log = read_set(Source(path), ROBOTS)
    sightings = sum(len(robot.landmarks) + len(robot.robots) for robot in log.robots.values())
    return f"{sightings} sightings by {len(log.robots)} robots"


def _file_digest(path):
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _mrclam_digest(path):
    """Digest of what the files for the estimation say, whoever packed or unpacked them: names, then numbers."""
    source, digest = Source(path), hashlib.sha256()
    robots = [f"Robot{n}_{what}.dat" for n in ROBOTS for what in ("Odometry", "Measurement")]
    for name in ("Barcodes.dat", "Landmark_Groundtruth.dat", *robots):
        rows = (line.split() for line in source.read(name).splitlines() if not line.lstrip().startswith(b"#"))
        digest.update(b"\n".join([name.encode(), *(b" ".join(row) for row in rows if row)]))
    return digest.hexdigest()


def _woods_whole(path):
    rec = lost_in_the_woods.load(path)
    return f"{len(rec)} frames, {len(rec.raw[1].y)} sightings"


def _park_whole(path):
    log = victoria_park.read_log(path)
    return f"{len(log.scan_t)} scans, {len(log.detections)} detections"


def _stars_whole(path):
    rec = starry_night.load(path)
    return f"{len(rec)} frames, {len(rec.raw[1].y)} sightings"


def _euroc_whole(path):
    rec = euroc_v101.load(path)
    return f"{len(rec)} frames, {len(rec.raw[1].y)} sightings"


def _unpacked_digest(path):
    data = gzip.decompress(path.read_bytes()) if path.suffix == ".gz" else path.read_bytes()
    return hashlib.sha256(data).hexdigest()


def _desk_whole(path):
    files = monoslam_desk.image_files(path)
    cut_off = next((p for p in files if not p.stat().st_size), None)
    if cut_off is not None:
        raise ValueError(f"{cut_off} is empty")
    return f"{len(files)} images"


def _plaza_whole(path):
    rec = plaza.load(path=path)
    assert rec.landmarks is not None  # the file has the survey
    return f"{len(rec.raw[1].y)} ranges to {len(rec.landmarks.ids)} beacons"


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
        The names of its zips, without `.zip`, or of its files.
    sha256 : dict of str to str
        By part, the `digest` of the data that this package was tested with.
    find : callable
        Part -> where it is, a Path, or None.
    whole : callable
        Path -> what is in it, in words; it reads the part to its end, and raises OSError or ValueError if it cannot.
    put : str
        How the files are to be put there.
    digest : callable
        Path -> SHA-256 of what is in it, as a hexadecimal number; by default of the file itself.
    wheel : str
        The Python package, with its version, that has the parts among its files; empty where there is none.
    """

    name: str
    title: str
    home: str
    citation: str
    parts: tuple
    sha256: dict
    find: Callable
    whole: Callable
    put: str = "Put the files"
    digest: Callable = _file_digest
    wheel: str = ""


def _find_mrclam(part):
    source = mrclam.find_set(int(part[-1]))
    return None if source is None else source.path


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
        "MRCLAM_Dataset7": "f87f95d4f42f9f543421dd440ad2ade27b043bb0014de2974589eff0f61a8f2e",
        "MRCLAM_Dataset9": "abf0e6b27cf0bc10261e7200c8b2a0cb20ba8f77fe0c460709b985776d4854b7",
    },
    find=_find_mrclam,
    whole=_mrclam_whole,
    put="Put the zips, packed or unpacked,",
    digest=_mrclam_digest,
)
PARK = DataSet(
    name="victoria_park",
    title="Victoria Park, ACFR, University of Sydney: a truck among trees",
    home="http://www-personal.acfr.usyd.edu.au/nebot/victoria_park.htm",
    citation=(
        "J. E. Guivant, E. M. Nebot, Optimization of the simultaneous localization and map-building algorithm for "
        "real-time implementation, IEEE Trans. Robotics and Automation 17(3):242-257, 2001"
    ),
    parts=(victoria_park.FILE,),
    sha256={victoria_park.FILE: "3816a3eb3aef1133823a3791d4361ef72891c3bd26cd3c037528950decc9a347"},
    find=find_file,
    whole=_park_whole,
    put="Put them, or the publisher's aa3_lsr2.mat, aa3_dr.mat and aa3_gpsx.mat,",
)
WOODS = DataSet(
    name="lost_in_the_woods",
    title="Lost in the Woods, course AER1513, University of Toronto: a robot among tubes",
    home="https://github.com/utiasASRL/aer1513",
    citation="T. D. Barfoot, Lost in the Woods Dataset, AER1513: State Estimation for Aerospace Vehicles",
    parts=(lost_in_the_woods.FILE,),
    sha256={lost_in_the_woods.FILE: "bbaeae95687376f115c9a8bf637097c65ce275f3bc66cc2cd8cd2755608682d9"},
    find=find_file,
    whole=_woods_whole,
)
STARS = DataSet(
    name="starry_night",
    title="Starry Night, course AER1513, University of Toronto: a stereo camera before twenty points",
    home="https://github.com/utiasASRL/aer1513",
    citation="T. D. Barfoot, Starry Night Dataset, AER1513: State Estimation for Aerospace Vehicles",
    parts=(starry_night.FILE,),
    sha256={},
    find=find_file,
    whole=_stars_whole,
)
PLAZA = DataSet(
    name="plaza",
    title="Plaza, Carnegie Mellon University: a mower that hears four radio beacons, two sets",
    home=plaza.HOME,
    citation=(
        "J. Djugash, B. Hamner, S. Roth, Navigating with ranging radios: five data sets with ground truth, J. Field "
        "Robotics 26(9):689-695, 2009"
    ),
    parts=tuple(plaza.FILES.values()),
    sha256=plaza.SHA256,
    find=find_file,
    whole=_plaza_whole,
    wheel=plaza.WHEEL,
)
EUROC = DataSet(
    name="euroc_v101",
    title="EuRoC V1_01_easy, ETH Zurich: a flying robot with an IMU and a camera, 30 s",
    home=euroc_v101.HOME,
    citation=(
        "M. Burri et al., The EuRoC micro aerial vehicle datasets, Int. J. Robotics Research 35(10):1157-1163, 2016"
    ),
    parts=(euroc_v101.PART,),
    sha256={euroc_v101.PART: euroc_v101.SHA256},
    find=lambda part: find_file(f"{part}*"),
    whole=_euroc_whole,
    digest=_unpacked_digest,
    wheel=euroc_v101.WHEEL,
)
DESK = DataSet(
    name="monoslam_desk",
    title="MonoSLAM's test sequence, Oxford and Imperial College: a camera in the hand before a desk",
    home="https://www.doc.ic.ac.uk/~ajd/Scene/index.html",
    citation=(
        "A. J. Davison, I. D. Reid, N. D. Molton, O. Stasse, MonoSLAM: Real-Time Single Camera SLAM, IEEE Trans. "
        "Pattern Analysis and Machine Intelligence 29(6):1052-1067, 2007"
    ),
    parts=("monoslam_desk/frames",),
    sha256={},
    find=lambda part: monoslam_desk.find_frames(),
    whole=_desk_whole,
    put="Put its images, frames/0000.png (or .pgm) and so on, in a folder monoslam_desk",
)
DATASETS = (MRCLAM, PARK, WOODS, STARS, PLAZA, EUROC, DESK)


@dataclass(frozen=True)
class Status:
    """State of what is known about one part of a data set.

    Parameters
    ----------
    part : str
    path : Path or None
        Where it is; None if it was not found.
    ok : bool or None
        True if it could be read as a whole; None if that was not tried.
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
    path = dataset.find(part)
    if path is None:
        return Status(part, None, None, "not found")
    if not verify:
        return Status(part, path, None, "found")
    try:
        what = dataset.whole(path)
    except (OSError, ValueError) as error:
        return Status(part, path, False, f"damaged: {error}")
    return Status(part, path, True, f"whole: {what}; {_checksum(dataset, part, path)}")


def _checksum(dataset, part, path):
    known = dataset.sha256.get(part)
    if known is None:
        return "no checksum is known to compare with"
    return "the data this was tested with" if dataset.digest(path) == known else "not the data this was tested with"


def report(verify=True):
    """Return what `ekfslam data` prints.

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
                f"  {dataset.put} into the folder that {ENVIRONMENT} names.",
                "  They come without a licence text: use them, do not pass them on.",
            ]
        lines += [f"  Please cite: {dataset.citation}.", ""]
    lines += ["mrclam_twin, victoria_park_twin: simulated logs, made when asked for; nothing to download."]
    return "\n".join(lines), ok
