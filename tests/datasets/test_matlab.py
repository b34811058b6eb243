"""MATLAB files that nobody should write."""

import struct
import tracemalloc
import zlib

import numpy as np
import pytest
from scipy.io import savemat

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
