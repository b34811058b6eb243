"""Which data sets are here, and which recording a scenario means."""

import shutil
from pathlib import Path

import numpy as np
import pytest

from ekfslam_tutorial.datasets import DATASETS, check, load_recording, mrclam_twin, prepare, report
from ekfslam_tutorial.datasets.listing import MRCLAM
from ekfslam_tutorial.geometry import Frame2
from ekfslam_tutorial.toolbox import Data, UserData

SCENARIOS = Path(__file__).parents[2] / "data" / "scenarios"


@pytest.fixture(scope="module")
def twin(tmp_path_factory):
    return mrclam_twin.write(tmp_path_factory.mktemp("made") / "MRCLAM_Dataset2", duration=30.0)


@pytest.fixture
def data(tmp_path, monkeypatch, twin):
    """A data folder with set 2, a damaged set 4, and nothing else."""
    shutil.copytree(twin, tmp_path / "MRCLAM_Dataset2")
    (tmp_path / "MRCLAM_Dataset4.zip").write_bytes(b"PK\x03\x04 not all of it")
    monkeypatch.setenv("EKFSLAM_DATA", str(tmp_path))
    return tmp_path


def test_check_tells_whole_damaged_and_missing_apart(data):
    states = {s.part: s for s in check()}
    assert len(states) == 9
    assert states["MRCLAM_Dataset2"].ok is True and "no checksum is known" in states["MRCLAM_Dataset2"].message
    assert states["MRCLAM_Dataset4"].ok is False and "not a complete zip" in states["MRCLAM_Dataset4"].message
    assert states["MRCLAM_Dataset7"].ok is None and states["MRCLAM_Dataset7"].path is None


def test_check_without_reading(data):
    states = {s.part: s for s in check(verify=False)}
    assert states["MRCLAM_Dataset4"].message == "found" and states["MRCLAM_Dataset4"].ok is None


def test_a_file_that_is_cut_off_is_named(data):
    path = data / "MRCLAM_Dataset2" / "Robot3_Measurement.dat"
    path.write_bytes(path.read_bytes()[:-4])
    (state,) = [s for s in check() if s.part == "MRCLAM_Dataset2"]
    assert state.ok is False
    assert "Robot3_Measurement.dat, line" in state.message and "is it cut off?" in state.message


def test_the_numbers_are_compared_with_the_known_checksum_however_they_are_packed(data, twin, monkeypatch):
    """As a folder, as a zip, with other line ends, and with files that no estimation needs: the same data."""
    shutil.make_archive(str(data / "MRCLAM_Dataset9"), "zip", twin.parent, twin.name)
    state = lambda: next(s for s in check() if s.part == "MRCLAM_Dataset9")
    assert state().ok is True and "not the data this was tested with" in state().message
    monkeypatch.setitem(MRCLAM.sha256, "MRCLAM_Dataset9", MRCLAM.digest(twin))
    assert "; the data this was tested with" in state().message

    (data / "MRCLAM_Dataset9.zip").unlink()
    folder = shutil.copytree(twin, data / "MRCLAM_Dataset9")
    (folder / "notes.txt").write_text("mine")
    file = folder / "Robot1_Odometry.dat"
    file.write_bytes(file.read_bytes().replace(b"\n", b"\r\n"))
    assert "; the data this was tested with" in state().message
    *rows, last = file.read_text().splitlines()
    file.write_text("\n".join([*rows, last.replace("1", "2", 1)]) + "\n")
    assert "not the data this was tested with" in state().message


def test_real_zips_have_the_known_checksums(data_dir):
    found = [s for s in check() if s.path and s.path.suffix == ".zip" and s.part[-1] in "79"]
    if not found:
        pytest.skip("no zip of set 7 or 9 below EKFSLAM_DATA")
    for s in found:
        assert s.ok and "; the data this was tested with" in s.message


def test_report(data, monkeypatch, tmp_path):
    text, ok = report()
    assert not ok
    assert f"looking in {data}" in text
    for words in (
        "MRCLAM_Dataset3  not found",
        "damaged: ",
        "whole: ",
        "asrl.utias.utoronto.ca",
        "Please cite: K. Y. K. Leung",
    ):
        assert words in text
    (data / "MRCLAM_Dataset4.zip").unlink()
    assert report()[1]
    monkeypatch.delenv("EKFSLAM_DATA")
    assert "set EKFSLAM_DATA to the folder with your data sets" in report()[0]


def test_single_files_are_listed_too(data):
    np.savez(data / "victoria_park_detections.npz", nothing=np.zeros(3))
    park = next(d for d in DATASETS if d.name == "victoria_park")
    (state,) = check(park)
    assert state.ok is False and "is not the file of Victoria Park" in state.message
    text, ok = report()
    assert not ok
    for words in ("victoria_park_detections.npz  damaged", "dataset2.mat  not found", "T. D. Barfoot", "J. E. Guivant"):
        assert words in text


def test_the_real_files_of_park_and_woods_are_those_this_was_tested_with(data_dir):
    states = [s for d in DATASETS if d.name in ("victoria_park", "lost_in_the_woods") for s in check(d) if s.path]
    if not states:
        pytest.skip("neither Victoria Park nor Lost in the Woods is below EKFSLAM_DATA")
    for s in states:
        assert s.ok and "; the data this was tested with" in s.message


@pytest.mark.parametrize(("name", "title"), [("victoria_park", "Victoria Park"), ("lost_in_the_woods", "the Woods")])
def test_park_and_woods_have_twins_too(data, name, title):
    notes = load_recording(Data(name=name)).notes
    assert "simulated twin" in notes[0] and title in notes[0]
    with pytest.raises(FileNotFoundError):
        load_recording(Data(name=name, params={"path": str(data)}))


def test_missing_logs_are_replaced_by_the_twin_which_says_so(data):
    recording = load_recording(Data(name="mrclam", params={"set": 3, "robots": [2]}))
    assert recording.notes[0].startswith(f"MRCLAM set 3 is not found in {data}: the simulated twin runs instead")
    assert list(recording.robots) == [2]


def test_a_path_that_was_given_is_never_replaced(data):
    with pytest.raises(FileNotFoundError, match="MRCLAM set 3 is not found in"):
        load_recording(Data(name="mrclam", params={"set": 3, "path": str(data)}))
    assert (
        load_recording(Data(name="mrclam", params={"set": 2, "robots": [4], "path": str(data)})).name
        == "MRCLAM_Dataset2"
    )


@pytest.mark.parametrize(
    ("name", "params", "words"),
    [
        (
            "mrclm",
            {},
            "unknown data set 'mrclm'; known: euroc_v101, mrclam, mrclam_twin, lecture, lost_in_the_woods, "
            "monoslam_desk, plaza, starry_night, victoria_park, victoria_park_twin; "
            "did you mean 'mrclam'",
        ),
        (
            "mrclam",
            {"robot": [1]},
            "data 'mrclam': unknown key 'robot'; possible: set, robots, path; did you mean 'robots'",
        ),
        ("mrclam", {"set": "nine"}, "set must be a whole number"),
        ("mrclam", {"set": 12}, "MRCLAM has the sets 1 to 9, got 12"),
        ("mrclam", {"set": 2, "robots": [1, 7]}, "MRCLAM robots must be some of"),
        ("mrclam_twin", {"duration": 0}, "more than 10 s"),
    ],
)
def test_wrong_names_and_values(data, name, params, words):
    with pytest.raises(ValueError) as error:
        load_recording(Data(name=name, params=params))
    assert words in str(error.value)


def test_prepare_makes_a_robot_for_each_in_the_data(data):
    userdata = UserData.from_toml(SCENARIOS / "mrclam_single.toml", {"data.set": 2, "data.robots": [2, 4]})
    userdata.robots[0].position = None
    userdata, recording = prepare(userdata)
    assert [r.id for r in userdata.robots] == [s.id for s in userdata.sensors] == [2, 4]
    assert [s.robot for s in userdata.sensors] == [2, 4]
    assert recording.name == "MRCLAM_Dataset2"


def test_prepare_leaves_a_simulation_alone():
    userdata = UserData(robots=UserData.from_toml(SCENARIOS / "mrclam_twin.toml").robots)
    assert prepare(userdata) == (userdata, None)


def test_prepare_finds_where_the_others_start():
    """Two robots of the twin; the first one is the origin. The alignment is good to far less than its START_STD."""
    changes = {"data.robots": [2, 4], "data.duration": 150, "data.seed": 3}
    userdata, recording = prepare(UserData.from_toml(SCENARIOS / "mrclam_twin.toml", changes))
    first, second = userdata.robots
    frames = [Frame2(recording.truth[i][0]) for i in (2, 4)]
    true = frames[0].inverse()[0].compose(frames[1])[0]
    assert first.position == [0, 0] and first.position_std == 0
    np.testing.assert_allclose(second.position, true.t, atol=0.5)
    assert any("relative to robot 2" in note for note in recording.notes)


def test_prepare_places_a_lost_robot_on_the_known_map(data):
    """The landmarks say where it is; not the true pose."""
    userdata = UserData.from_toml(SCENARIOS / "mrclam_localisation.toml")
    userdata.data = Data(name="mrclam_twin", params={"robots": [3], "duration": 100.0})
    userdata, recording = prepare(userdata)
    (robot,) = userdata.robots
    np.testing.assert_allclose(robot.position, recording.truth[3][0][:2], atol=0.5)
    assert robot.position_std > 0
