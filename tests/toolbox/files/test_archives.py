"""Zip and npz files that nobody should write: refused in one sentence, in little time and memory."""

import io
import json
import struct
import tracemalloc
import zipfile

import numpy as np
import pytest

from ekfslam_tutorial.analysis import series
from ekfslam_tutorial.datasets.mrclam_log import read_set
from ekfslam_tutorial.datasets.sources import Source
from ekfslam_tutorial.datasets.victoria_park import read_log
from ekfslam_tutorial.toolbox import Recording, UserData
from ekfslam_tutorial.toolbox.files import value_file
from ekfslam_tutorial.toolbox.files.archives import read_npz
from tests.pace import Watch

READERS = {"read_npz": read_npz, "recording": Recording.load, "checkpoint": value_file.load, "series": series.read}
READERS["victoria park"] = read_log
MEMORY = 20e6
"""Bytes that a reader may take for a file of at most 100 kB that it refuses."""


def npy(header, data=b"", version=b"\x01\x00"):
    header = header.encode()
    return b"\x93NUMPY" + version + struct.pack("<H" if version[0] == 1 else "<I", len(header)) + header + data


def head(descr="'<f8'", shape="(2,)"):
    return f"{{'descr': {descr}, 'fortran_order': False, 'shape': {shape}, }}\n"


def zipped(path, members, compression=zipfile.ZIP_STORED):
    with zipfile.ZipFile(path, "w", compression) as archive:
        for name, data in members.items():
            archive.writestr(name, data)
    return path


def pickled():
    file = io.BytesIO()
    np.save(file, np.array([print, {}], dtype=object), allow_pickle=True)
    return file.getvalue()


HOSTILE = {
    "a million million numbers": npy(head(shape="(1000000000000,)")),
    "more than can be counted": npy(head(shape="(99999999999, 99999999999, 99999999999)")),
    "rows of nothing": npy(head(shape="(1000000000, 0)")),
    "empty texts": npy(head("'<U0'", "(1000000000,)")),
    "a text of 4 GB": npy(head("'<U999999999'", "()")),
    "negative": npy(head(shape="(-2,)"), bytes(16)),
    "objects": npy(head("'|O'"), bytes(16)),
    "a pickle": pickled(),
    "structures": npy(head("[('a', '<f8'), ('b', '<f8')]", "(1,)"), bytes(16)),
    "structures in structures": npy(head("[('a'," * 300 + "'<f8'" + ")]" * 300, "(1,)"), bytes(16)),
    "dates": npy(head("'<M8[s]'"), bytes(16)),
    "raw bytes": npy(head("'|V8'"), bytes(16)),
    "brackets": npy("(" * 60_000),
    "a header of 4 GB": b"\x93NUMPY\x02\x00" + b"\xff\xff\xff\xff" + bytes(100),
    "code": npy("__import__('os').system('false')"),
    "version 9": npy(head(), bytes(16), b"\x09\x00"),
    "too short": npy(head(), bytes(15)),
    "too long": npy(head(), bytes(17)),
    "letters beyond all": npy(head("'<U1'", "()"), b"\xff" * 4),
    "no array": b"\x00" * 100,
    "nothing": b"",
}


def refused(read, path):
    """The sentence in which it is refused; what it costs is bounded."""
    with Watch() as it:
        tracemalloc.start()
        try:
            with pytest.raises(ValueError) as caught:
                read(path)
            peak = tracemalloc.get_traced_memory()[1]
        finally:
            tracemalloc.stop()
    assert peak < MEMORY
    assert it.seconds < 2.0  # far more than it takes
    sentence = str(caught.value)
    assert sentence and "\n" not in sentence and len(sentence) < 500
    return sentence


@pytest.mark.parametrize("reader", READERS)
@pytest.mark.parametrize("member", HOSTILE)
def test_no_array_is_read_but_of_numbers_and_texts_with_their_bytes(tmp_path, member, reader):
    refused(READERS[reader], zipped(tmp_path / "x.npz", {"t.npy": HOSTILE[member]}))


@pytest.mark.parametrize("reader", READERS)
def test_zip_bombs(tmp_path, reader):
    read = READERS[reader]
    zeros = npy(head(shape="(12500000,)"), bytes(100_000_000))
    assert "would unpack to 95 MB" in refused(
        read, zipped(tmp_path / "big.npz", {"t.npy": zeros}, zipfile.ZIP_DEFLATED)
    )
    many = {f"{k}.npy": npy(head(shape="(12500,)"), bytes(100_000)) for k in range(1000)}
    path = zipped(tmp_path / "many.npz", many, zipfile.ZIP_DEFLATED)
    assert "would unpack to" in refused(read, path)


def test_a_zip_that_lies_about_a_size_gives_no_more_than_it_says(tmp_path):
    data = bytes(50_000_000)
    path = zipped(tmp_path / "x.npz", {"t.npy": data}, zipfile.ZIP_DEFLATED)
    raw = path.read_bytes().replace(struct.pack("<I", len(data)), struct.pack("<I", 100))
    path.write_bytes(raw)
    refused(read_npz, path)


def test_too_many_members(tmp_path):
    path = zipped(tmp_path / "x.npz", {str(k): b"" for k in range(10_001)})
    with pytest.raises(ValueError, match="it holds 10001 files"):
        read_npz(path)


def test_members_that_share_their_bytes_count_each_time(tmp_path):
    """An archive of overlapping members: a thousand names for one piece of compressed zeros."""
    path = zipped(tmp_path / "x.npz", {"t.npy": bytes(1_000_000)}, zipfile.ZIP_DEFLATED)
    raw = path.read_bytes()
    start = raw.rindex(b"PK\x01\x02")
    end = raw.rindex(b"PK\x05\x06")
    entry, local = raw[start:end], raw[:start]
    directory = entry * 1000
    last = struct.pack("<4sHHHHIIH", b"PK\x05\x06", 0, 0, 1000, 1000, len(directory), len(local), 0)
    path.write_bytes(local + directory + last)
    assert "would unpack to 954 MB" in refused(read_npz, path)


def test_what_numpy_writes_is_read_as_numpy_reads_it(tmp_path):
    rng = np.random.default_rng(1)
    arrays = {
        "flat": rng.normal(size=5),
        "fortran": np.asfortranarray(rng.normal(size=(3, 4))),
        "big_endian": rng.normal(size=4).astype(">f8"),
        "whole": np.arange(4, dtype=np.int16),
        "none": np.zeros((7, 0)),
        "one": np.float32(2.5),
        "truth": np.array([True, False]),
        "text": np.array("what it is é"),
        "texts": np.array(["a", "", "ccc"]),
        "complex_shape": rng.normal(size=(2, 1, 3, 0, 5)),
    }
    for save in np.savez, np.savez_compressed:
        save(tmp_path / "x.npz", **arrays)
        got = read_npz(tmp_path / "x.npz")
        with np.load(tmp_path / "x.npz") as wanted:
            assert list(got) == wanted.files
            for name in got:
                assert got[name].dtype == wanted[name].dtype and np.array_equal(got[name], wanted[name])
                assert got[name].flags.writeable and np.isfortran(got[name]) == np.isfortran(wanted[name])


def test_numbers_that_are_none(tmp_path):
    """Floods of NaN, and infinities, in every array of a recording that the estimator would see."""
    whole = {"format": "ekfslam recording 1", "name": "x", "notes": np.zeros(0, "U1"), "t": np.arange(1, 4.0)}
    whole |= {"robots": np.array([1]), "sensors": np.array([1]), "robot1_u": np.ones((3, 2))}
    whole |= {"robot1_U": np.tile(np.eye(2), (3, 1, 1)), "sensor1_offsets": np.array([0, 1, 1, 2])}
    whole |= {"sensor1_ids": np.array([3, 4]), "sensor1_y": np.ones((2, 2))}
    whole |= {"landmark_ids": np.array([3, 4]), "landmark_points": np.ones((2, 2))}
    path = tmp_path / "x.npz"
    np.savez(path, **whole)
    assert len(Recording.load(path)) == 3
    for name in "t", "robot1_u", "robot1_U", "sensor1_y", "landmark_points":
        for value in np.nan, np.inf, -np.inf:
            np.savez(path, **(whole | {name: np.full_like(whole[name], value)}))
            assert "must be finite" in refused(Recording.load, path)
        for kind in "S5", "U5", bool:
            np.savez(path, **(whole | {name: np.zeros(whole[name].shape, kind)}))
            assert "must be numbers" in refused(Recording.load, path)
        np.savez(path, **(whole | {name: whole[name].astype(complex)}))
        assert "no array of numbers" in refused(Recording.load, path)


@pytest.mark.parametrize(
    "text",
    [
        "a = " + "[" * 50_000,
        "a = " + "{b = " * 20_000,
        "[" + "a." * 10_000 + "b]",
        "[[a." + "a." * 10_000 + "b]]\nx = 1",
    ],
    ids=["arrays", "tables", "dots", "entries"],
)
def test_toml_that_is_nested_too_deeply(tmp_path, text):
    path = tmp_path / "deep.toml"
    path.write_text(text)
    assert "deep.toml" in refused(UserData.from_toml, path)


@pytest.mark.parametrize("text", ["[" * 50_000, '{"a":' * 50_000], ids=["lists", "tables"])
def test_json_that_is_nested_too_deeply(tmp_path, text):
    (tmp_path / "recording.json").write_text(text)
    assert "recording.json" in refused(Recording.load, tmp_path)


def test_a_csv_file_of_nan_and_of_wide_lines(tmp_path):
    (tmp_path / "recording.json").write_text(json.dumps({"format": "ekfslam recording 1", "name": "x"}))
    for content in "t\n" + "nan\n" * 20_000, "t\n" + "1," * 50_000, "t" * 100_000 + "\n1\n", "a," * 30_000 + "\n":
        (tmp_path / "frames.csv").write_text(content)
        assert "frames.csv, line" in refused(Recording.load, tmp_path)


def test_whole_numbers_beyond_64_bits(tmp_path):
    """Found by the fuzzer: Python reads them, an array cannot hold them."""
    (tmp_path / "recording.json").write_text(json.dumps({"format": "ekfslam recording 1", "name": "x"}))
    (tmp_path / "frames.csv").write_text("t\n1\n")
    for number in "18446744073709551616", "-9223372036854775809", "9" * 400:
        (tmp_path / "sensor-1.csv").write_text(f"frame,id,y1\n0,{number},1\n")
        assert "sensor-1.csv, line 2: id must be a whole number" in refused(Recording.load, tmp_path)


@pytest.mark.parametrize("barcode", ["5.5", "1e308", "-9e18"])
def test_barcodes_that_are_no_numbers_of_anything(tmp_path, barcode):
    (tmp_path / "Barcodes.dat").write_text(f"1 {barcode}\n")
    assert "which is no such number" in refused(lambda p: read_set(Source(p), (1,)), tmp_path)


def test_a_zip_of_a_data_set_that_unpacks_to_too_much(tmp_path):
    files = {"Barcodes.dat": b" " * 200_000_000}
    path = zipped(tmp_path / "MRCLAM_Dataset1.zip", files, zipfile.ZIP_DEFLATED)
    assert "would unpack to 191 MB" in refused(lambda p: Source(p).read("Barcodes.dat"), path)


def test_names_in_a_zip_lead_nowhere(tmp_path, monkeypatch):
    """Files are read from a zip by their last name, in memory: nothing is written, whatever the path in it."""
    monkeypatch.chdir(tmp_path)
    names = ["../up.dat", "/tmp/absolute.dat", "C:\\windows\\drive.dat", "C:drive.dat", "a/../../b.dat"]
    path = zipped(tmp_path / "x.zip", dict.fromkeys(names, b"1 2\n"))
    source = Source(path)
    for name in source.names():
        assert source.read(name) == b"1 2\n"
    assert [p.name for p in tmp_path.rglob("*")] == ["x.zip"]
