"""MATLAB files that nobody should write."""

import struct
import tracemalloc
import zlib

import numpy as np
import pytest
from scipy.io import loadmat, savemat

from ekfslam_tutorial.datasets.matlab import read_mat


def make(path, arrays, compressed=True):
    savemat(path, arrays, do_compression=compressed)
    return path


@pytest.mark.parametrize("compressed", [True, False])
def test_numbers_are_read(tmp_path, compressed):
    x = np.arange(6.0).reshape(2, 3)
    path = make(tmp_path / "x.mat", {"x": x, "n": np.uint16([1, 2]), "text": "hello", "cell": {"a": 1}}, compressed)
    got = read_mat(path)
    assert set(got) == {"x", "n"} and np.array_equal(got["x"], x) and got["n"].dtype == np.uint16
    assert set(read_mat(path, ("x", "absent", "text"))) == {"x"}


KINDS = ["f8", "f4", "i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8", "?"]


@pytest.mark.parametrize("compressed", [True, False])
def test_they_are_read_as_scipy_reads_them(tmp_path, compressed, rng):
    """Types, shapes and names of all lengths; complex numbers are left out."""
    arrays = {"long_name_" + kind.replace("?", "b"): rng.integers(0, 99, (3, 5)).astype(kind) for kind in KINDS}
    shapes = {"a": (0, 0), "ab": (1, 1), "abc": (2, 3, 4), "abcd": (1, 3), "abcde": (7, 1)}
    arrays |= {name: rng.normal(size=shape) for name, shape in shapes.items()}
    path = make(tmp_path / "x.mat", arrays | {"z": np.array([1j])}, compressed)
    got, want = read_mat(path), loadmat(path)
    assert set(got) == set(arrays)
    for name, x in got.items():
        assert x.dtype == want[name].dtype and x.shape == want[name].shape and np.array_equal(x, want[name]), name


def by_hand(order, kind=6, stored=9, shape=(1, 2), values=(1.5, -2.0), parts=4):
    """A file with one array x, as bytes; the numbers are doubles, whatever `stored` says of them."""
    element = lambda kind, content: struct.pack(order + "II", kind, len(content)) + content + bytes(-len(content) % 8)
    inside = [
        element(6, struct.pack(order + "II", kind, 0)),
        element(5, struct.pack(f"{order}{len(shape)}i", *shape)),
        struct.pack(order + "I", 1 << 16 | 1) + b"x\0\0\0",
        element(stored, struct.pack(f"{order}{len(values)}d", *values)),
    ]
    head = b"MATLAB 5.0 by hand".ljust(124) + struct.pack(order + "H", 0x0100) + (b"IM" if order == "<" else b"MI")
    return head + element(14, b"".join(inside[:parts]))


@pytest.mark.parametrize("order", ["<", ">"])
def test_both_orders_of_bytes(tmp_path, order):
    path = tmp_path / "x.mat"
    path.write_bytes(by_hand(order))
    assert np.array_equal(read_mat(path)["x"], [[1.5, -2.0]]) and np.array_equal(loadmat(path)["x"], [[1.5, -2.0]])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (dict(stored=0x3309), "x is stored as type 13065, which is no type of numbers"),  # scipy crashes at these
        (dict(stored=8), "x is stored as type 8, which"),
        (dict(stored=0), "x is stored as type 0, which"),
        (dict(shape=(-1, -2)), r"x is said to have the shape \(-1, -2\) and holds 2 numbers"),
        (dict(shape=()), "damaged"),
        (dict(shape=(2**31 - 1,) * 9), "is said to have the shape"),
        (dict(parts=3), "x is stored as type 0"),
        (dict(parts=2), "an array has no name"),
    ],
)
def test_codes_that_mean_nothing(tmp_path, change, message):
    path = tmp_path / "x.mat"
    path.write_bytes(by_hand("<", **change))
    with pytest.raises(ValueError, match=message) as caught:
        read_mat(path)
    assert str(caught.value).startswith(f"{path} is damaged or no MATLAB file (")


def test_a_bomb(tmp_path):
    """100 MB of zeros in 100 kB."""
    path = make(tmp_path / "x.mat", {"x": np.zeros(12_500_000)})
    assert path.stat().st_size < 200_000
    tracemalloc.start()
    try:
        with pytest.raises(ValueError, match="would unpack to more than .. MB"):
            read_mat(path)
        assert tracemalloc.get_traced_memory()[1] < 20e6
    finally:
        tracemalloc.stop()


def test_a_shape_that_asks_for_all_memory(tmp_path):
    path = make(tmp_path / "x.mat", {"x": np.zeros((2, 3))}, compressed=False)
    data = bytearray(path.read_bytes())
    at = data.index(struct.pack("<II", 2, 3))
    data[at : at + 8] = struct.pack("<II", 2**30, 2**30)
    path.write_bytes(data)
    with pytest.raises(ValueError, match="x is said to have the shape"):
        read_mat(path)


def test_whatever_is_in_it_there_is_one_sentence(tmp_path):
    """Cuts and overwritten bytes of a file, compressed and not, seed 1."""
    rng, path = np.random.default_rng(1), tmp_path / "x.mat"
    for compressed in True, False:
        whole = make(
            path, {"x": np.arange(12.0).reshape(3, 4), "s": {"a": [1, 2]}, "y": np.eye(2)}, compressed
        ).read_bytes()
        for k in range(300):
            data = bytearray(whole[: rng.integers(len(whole))] if k % 3 == 0 else whole)
            for _ in range(rng.integers(1, 4)):
                if data:
                    data[rng.integers(len(data))] = rng.integers(256)
            if compressed and k % 3 == 1:  # behind the checksum of zlib
                inside = bytearray(np.arange(40.0).tobytes())
                inside[: len(whole) // 4] = rng.bytes(len(whole) // 4)
                packed = zlib.compress(bytes(inside))
                data = bytearray(whole[:128] + struct.pack("<II", 15, len(packed)) + packed)
            path.write_bytes(data)
            try:
                read_mat(path)
            except ValueError as error:
                assert str(path) in str(error) and "\n" not in str(error)
