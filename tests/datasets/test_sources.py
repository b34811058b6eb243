"""Folders and zips below EKFSLAM_DATA."""

import os
import zipfile

import pytest

from ekfslam_tutorial.datasets.sources import Source, data_folders, find


@pytest.fixture
def folder(tmp_path):
    """data/Set1.zip, data/deep/Set2/a.dat, data/set1/set1/a.dat, data/other."""
    deep = tmp_path / "deep" / "Set2"
    deep.mkdir(parents=True)
    (deep / "a.dat").write_text("two")
    (tmp_path / "set1" / "set1").mkdir(parents=True)
    (tmp_path / "set1" / "set1" / "a.dat").write_text("one")
    with zipfile.ZipFile(tmp_path / "Set1.zip", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("Set1/a.dat", "one, zipped " * 100)
        archive.writestr("Set1/b.dat", "b")
    (tmp_path / "Set1.txt").write_text("not a set")
    return tmp_path


def test_find_takes_folders_before_zips_and_looks_one_level_deep(folder):
    names = [s.path.relative_to(folder).as_posix() for s in find(r"set\d", [folder])]
    assert names == ["deep/Set2", "set1", "set1/set1", "Set1.zip"]


def test_find_takes_the_folder_itself(folder):
    assert [s.path for s in find("set2", [folder / "deep" / "Set2"])] == [folder / "deep" / "Set2"]


def test_the_pattern_is_for_the_whole_name(folder):
    assert find("set", [folder]) == []


def test_zip_and_folder_read_alike(folder):
    assert Source(folder / "Set1.zip").read("b.dat") == b"b"
    assert Source(folder / "Set1.zip").names() == {"a.dat": "Set1/a.dat", "b.dat": "Set1/b.dat"}
    assert Source(folder / "set1").read("a.dat") == b"one"


def test_missing_in_a_zip(folder):
    with pytest.raises(FileNotFoundError, match=r"Set1\.zip: no file c\.dat; there is: a\.dat, b\.dat"):
        Source(folder / "Set1.zip").read("c.dat")


def test_a_zip_that_is_cut_off(folder):
    path = folder / "Set1.zip"
    path.write_bytes(path.read_bytes()[:-30])
    with pytest.raises(ValueError, match=r"Set1\.zip is not a complete zip file .*; download it again"):
        Source(path).read("a.dat")


def test_a_zip_with_damaged_content(folder):
    path = folder / "Set1.zip"
    content = bytearray(path.read_bytes())
    content[45:55] = b"0123456789"
    path.write_bytes(content)
    with pytest.raises(ValueError, match=r"Set1\.zip: Set1/a\.dat in this zip is damaged"):
        Source(path).read("a.dat")


def test_data_folders(monkeypatch, tmp_path):
    monkeypatch.delenv("EKFSLAM_DATA", raising=False)
    assert data_folders() == []
    (tmp_path / "two").mkdir()
    monkeypatch.setenv("EKFSLAM_DATA", os.pathsep.join([str(tmp_path), str(tmp_path / "two")]))
    assert data_folders() == [tmp_path, tmp_path / "two"]


def test_data_folder_that_does_not_exist(monkeypatch, tmp_path):
    monkeypatch.setenv("EKFSLAM_DATA", str(tmp_path / "nowhere"))
    with pytest.raises(FileNotFoundError, match="EKFSLAM_DATA names the folder .*nowhere, which does not exist"):
        data_folders()
