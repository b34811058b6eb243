"""docs/scenarios.md lists the keys of a scenario file: all of them, and no others."""

import re
from pathlib import Path

import pytest

from ekfslam_tutorial.models import landmarks, motion, sensors
from ekfslam_tutorial.simulation import worlds
from ekfslam_tutorial.slam import Jcbb, KnownIds, NearestNeighbour
from ekfslam_tutorial.toolbox import FigureOptions, Landmark, Options, Robot, Sensor, Time
from ekfslam_tutorial.toolbox.descriptors import Descriptors
from ekfslam_tutorial.toolbox.images import ActiveSearch
from ekfslam_tutorial.toolbox.scenario.keys import exported, functions, parameters, snake
from ekfslam_tutorial.toolbox.scenario.reading import SECTIONS

ASSOCIATIONS = KnownIds, NearestNeighbour, Jcbb, Descriptors, ActiveSearch
REPOSITORY = Path(__file__).parents[2]
PAGE = (REPOSITORY / "docs" / "scenarios.md").read_text(encoding="utf-8")
GALLERY = (REPOSITORY / "docs" / "write_your_own.md").read_text(encoding="utf-8").partition("\n## Gallery\n")[2]


def section(title):
    """Text of one section of the page."""
    return re.split(r"^## ", PAGE.partition(f"\n## {title}\n")[2], flags=re.MULTILINE)[0]


def keys(title, head="key"):
    """First column of a table of a section, and the names of its other columns by row."""
    table = re.split(rf"^\| {head} \|.*\n\|---.*\n", section(title), flags=re.MULTILINE)[1].partition("\n\n")[0]
    rows = [line.split(" | ") for line in table.splitlines() if line.startswith("| `")]
    return {row[0].strip("| `"): [re.findall(r"`([^`]+)`(?: \((\d)\))?", cell) for cell in row[1:]] for row in rows}


@pytest.mark.parametrize(
    "title, cls, without, more",
    [
        ("`[time]`", Time, (), ()),
        ("`[[robot]]`", Robot, ("state", "state_std", "control", "control_std"), ()),
        ("`[[sensor]]`", Sensor, ("model", "params_std", "params_walk"), ("type",)),
        ("`[landmark]`", Landmark, ("model",), ("type",)),
        ("`[options]`", Options, ("lmk_type", "n", "N"), ()),
        ("`[figure]`", FigureOptions, (), ()),
    ],
)
def test_a_section_lists_its_keys(title, cls, without, more):
    assert set(keys(title)) == {*parameters(cls), *more} - set(without)


def test_the_page_has_all_sections():
    titles = set(re.findall(r"^## `\[+(\w+)\]+`$", PAGE, re.MULTILINE)) | set(keys("Top"))
    assert titles == set(SECTIONS)


def test_motion_models_and_their_fields():
    listed = keys("`[[robot]]`", "`motion`")
    assert set(listed) == set(exported(motion))
    for name, cells in listed.items():
        cls = exported(motion)[name]
        stated = [{key: int(n) for key, n in cell} for cell in cells]
        assert stated == [cls.control_fields, cls.state_fields], name


@pytest.mark.parametrize(
    "title, head, known",
    [
        ("`[[sensor]]`", "`type`", exported(sensors)),
        ("`[world]`", "`type`", functions(worlds)),
        ("`[options]`", "`association`", {snake(c.__name__): c for c in ASSOCIATIONS}),
    ],
)
def test_models_and_their_keys(title, head, known):
    listed = keys(title, head)
    assert set(listed) == set(known)
    for name, cells in listed.items():
        assert [key.removesuffix("_deg") for key, _ in cells[0]] == list(parameters(known[name])), name


def test_parameters_that_may_be_states_are_named():
    listed, known = keys("`[[sensor]]`", "sensor"), exported(sensors)
    named = {name: {key for key, _ in cells[0]} for row, cells in listed.items() for name in re.findall(r"\w+", row)}
    for name, cls in known.items():
        may = {*getattr(cls, "parameters", ()), *getattr(cls, "tied", ())} if name != "segment_cam" else set()
        assert may <= named.get(name, set()), name


def test_landmark_types_are_all_named():
    named = {name for cell in keys("`[landmark]`")["type"] for name, _ in cell}
    assert named == set(exported(landmarks))


# --- the gallery of docs/write_your_own.md ---


@pytest.mark.parametrize("role, module", [("sensor", sensors), ("landmark", landmarks), ("motion", motion)])
def test_the_gallery_has_every_model_and_a_scenario_of_it(role, module):
    table = GALLERY.partition(f"\n| {role} |")[2].partition("\n\n")[0]
    rows = [re.split(r"(?<!\\) \| ", line) for line in table.splitlines() if line.startswith("| `")]
    names = [re.findall(r"`(\w+)`", row[0]) for row in rows]
    assert sorted(name for row in names for name in row) == sorted(exported(module))
    for those, row in zip(names, rows, strict=True):
        files = [REPOSITORY / "data" / "scenarios" / f"{name}.toml" for name in re.findall(r"`(\w+)`", row[-1])]
        text = row[-1] + "".join(file.read_text(encoding="utf-8") for file in files)
        default = those == ["euc_pnt"]  # the landmarks of a scenario that names none
        assert default or files and [name for name in those if f'"{name}"' not in text] == []
