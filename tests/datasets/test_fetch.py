"""`ekfslam data fetch` against servers on loopback that are slow, break off, lie, and go. No publisher is asked."""

import builtins
import json
import socket
import zipfile

import pytest

from ekfslam_tutorial.cli import main
from ekfslam_tutorial.datasets import mrclam_twin
from ekfslam_tutorial.datasets import registry as addresses
from ekfslam_tutorial.datasets.fetch import PINS, fetch
from tests.datasets.servers import serve, serve_ftp

PART = "MRCLAM_Dataset2"
FILE = f"{PART}.zip"


@pytest.fixture(scope="module")
def zipped(tmp_path_factory):
    """The bytes of a zip of the simulated twin: some 100 kB."""
    folder = tmp_path_factory.mktemp("twin")
    files = mrclam_twin.write(folder / PART, duration=30.0)
    with zipfile.ZipFile(folder / FILE, "w") as archive:  # as it is, so that a cut is seen in its end only
        for file in sorted(files.iterdir()):
            archive.write(file, f"{PART}/{file.name}")
    return (folder / FILE).read_bytes()


@pytest.fixture
def get(tmp_path):
    """Fetch from a server into the folder of this test."""
    return lambda url, **more: fetch("mrclam", tmp_path, [PART], {PART: url}, pause=0.01, **more)


def names(folder):
    return sorted(p.name for p in folder.iterdir())


@pytest.mark.parametrize("manner", [(), ("slow",), ("no range",), ("no tag",), ("no length",)], ids=str)
def test_it_comes_whole(zipped, get, tmp_path, manner):
    seen = []
    with serve(zipped, *manner) as server:
        (line,) = get(server.url, progress=lambda part: lambda done, total: seen.append((done, total)))
    assert "fetched and whole" in line and "no checksum is published" in line
    assert (tmp_path / FILE).read_bytes() == zipped
    assert names(tmp_path) == [FILE, PINS]
    assert seen[-1] == (len(zipped), None if "no length" in manner else len(zipped)) and seen == sorted(seen)


def test_a_second_call_fetches_nothing(zipped, get, tmp_path):
    with serve(zipped) as server:
        get(server.url)
        assert "is there already, with the right checksum" in get(server.url)[0]
        assert len(server.asked) == 1
    (tmp_path / FILE).write_bytes(b"changed")
    assert "is not the right one" in get("http://127.0.0.1:9/")[0]


def test_it_goes_on_within_one_call(zipped, get, tmp_path):
    with serve(zipped, "breaks", "heals") as server:
        get(server.url)
        first, second = server.asked
        assert first == 0 < second <= len(zipped) // 2  # a piece that was not whole may be asked for again
    assert (tmp_path / FILE).read_bytes() == zipped


def test_it_goes_on_in_a_later_call(zipped, get, tmp_path):
    """The server breaks off each time: nothing is under the final name, and what came is not asked for again."""
    with serve(zipped, "breaks") as server:
        with pytest.raises(ConnectionError, match="bytes are kept; call it again to go on") as caught:
            get(server.url)
        assert FILE not in names(tmp_path) and f"{FILE}.part" in names(tmp_path)
        assert "\n" not in str(caught.value) and "ekfslam data import PATH" in str(caught.value)
        kept = (tmp_path / f"{FILE}.part").stat().st_size
        server.manner = set()
        get(server.url)
        assert server.asked[-1] == kept > len(zipped) / 2
    assert (tmp_path / FILE).read_bytes() == zipped and names(tmp_path) == [FILE, PINS]


def test_another_edition_is_not_joined_to_what_is_there(zipped, get, tmp_path):
    """Between two calls the file on the server has changed: it is fetched from its beginning."""
    with serve(bytes(len(zipped)), "breaks") as server:
        with pytest.raises(ConnectionError):
            get(server.url)
        server.data, server.manner, server.tag = zipped, set(), '"second"'
        get(server.url)
    assert (tmp_path / FILE).read_bytes() == zipped


@pytest.mark.parametrize("manner", ["no range", "no tag"])
def test_a_server_that_cannot_go_on_is_asked_for_all_of_it(zipped, get, tmp_path, manner):
    with serve(zipped, manner, "breaks", "heals") as server:
        get(server.url)
    assert (tmp_path / FILE).read_bytes() == zipped


@pytest.mark.parametrize(
    "data, reason",
    [
        (b"<!DOCTYPE html><html><body>Please log in</body></html>", "a page of text"),
        (b"\n <HTML><head>", "a page of text"),
        (b"something else", "no zip file"),
        (b"", "no zip file"),
        ("cut", "no zip file"),
        ("overwritten", "damaged"),
        ("other", "no file Barcodes.dat"),
    ],
    ids=lambda value: str(value)[:12],
)
def test_content_that_is_not_the_data_set(zipped, get, tmp_path, data, reason):
    if data == "cut":
        data = zipped[:-100]
    elif data == "overwritten":
        data = zipped[:5000] + bytes(50) + zipped[5050:]
    elif data == "other":
        with zipfile.ZipFile(tmp_path / "other.zip", "w") as archive:
            archive.writestr("readme.txt", "hello")
        data = (tmp_path / "other.zip").read_bytes()
        (tmp_path / "other.zip").unlink()
    with serve(data) as server, pytest.raises(ValueError, match=reason) as caught:
        get(server.url)
    assert "\n" not in str(caught.value) and "ekfslam data import PATH" in str(caught.value)
    assert names(tmp_path) == []


def test_a_checksum_that_is_not_the_one_of_the_first_time(zipped, get, tmp_path):
    with serve(zipped) as server:
        get(server.url)
        (tmp_path / FILE).unlink()
        server.data = zipped[:-2] + b"\x01\x00x"  # a comment at its end: whole, but another file
        with pytest.raises(ValueError, match="its checksum is not the one of the first download"):
            get(server.url)
        assert names(tmp_path) == [PINS]
        server.data = zipped
        assert "the right one" in get(server.url)[0]


def test_a_checksum_that_is_published(zipped, tmp_path, monkeypatch):
    monkeypatch.setitem(addresses.CHECKSUMS, FILE, "0" * 64)
    with serve(zipped) as server, pytest.raises(ValueError, match="its checksum is not the one it should have"):
        fetch("mrclam", tmp_path, [PART], {PART: server.url}, pause=0.01)
    assert names(tmp_path) == []


def test_damaged_checksums_are_not_taken_for_none(get, tmp_path):
    for text in "{", "[]", '{"a": 1}', "[" * 10_000:
        (tmp_path / PINS).write_text(text)
        with pytest.raises(ValueError, match="is damaged; remove it"):
            get("http://127.0.0.1:9/")


def test_a_host_that_is_gone(get, tmp_path):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))  # not listening: the connection is refused
        with pytest.raises(ConnectionError, match="Get it by hand from https://asrl") as caught:
            get(f"http://127.0.0.1:{taken.getsockname()[1]}/file")
        assert "\n" not in str(caught.value) and len(str(caught.value)) < 600
        with pytest.raises(ConnectionError, match="Get it by hand"):
            get(f"ftp://127.0.0.1:{taken.getsockname()[1]}/file")
    with pytest.raises(ConnectionError, match="Get it by hand"):
        get("http://no-such-host.invalid/file")
    assert names(tmp_path) == []


def test_a_file_that_is_gone(zipped, get, tmp_path):
    with serve(zipped, "missing") as server, pytest.raises(ConnectionError, match="404"):
        get(server.url)
    with serve_ftp(zipped) as server, pytest.raises(ConnectionError, match="550 no such file"):
        get(server.url + "x")
    assert names(tmp_path) == []


def test_ftp(zipped, get, tmp_path):
    with serve_ftp(zipped, "breaks") as server:
        with pytest.raises(ConnectionError, match="bytes are kept"):
            get(server.url)
        kept = (tmp_path / f"{FILE}.part").stat().st_size
        server.manner = set()
        get(server.url)
        assert server.asked[-1] == kept > len(zipped) / 2
    assert (tmp_path / FILE).read_bytes() == zipped and names(tmp_path) == [FILE, PINS]


def test_an_endless_file_is_given_up(zipped, get, tmp_path, monkeypatch):
    monkeypatch.setattr("ekfslam_tutorial.datasets.transfer.LIMIT", 50_000)
    with serve(zipped, "no length") as server, pytest.raises(ValueError, match="more than the file should have"):
        get(server.url)
    assert FILE not in names(tmp_path)


def test_the_command(zipped, tmp_path, monkeypatch, capsys):
    monkeypatch.delenv("EKFSLAM_DATA", raising=False)
    with serve(zipped) as server:
        monkeypatch.setitem(addresses.ADDRESSES["mrclam"], PART, server.url)
        assert main(["data", "fetch", "mrclam", "--set", "2", "--to", str(tmp_path / "new")]) == 0
        out = capsys.readouterr().out
        assert "Please cite: K. Y. K. Leung" in out and f"{FILE}: fetched and whole" in out
        assert main(["data", "fetch", "mrclam", "--set", "2"]) == 2
        assert "say where to put it: --to DIR, or set EKFSLAM_DATA" in capsys.readouterr().err
        for words, sentence in (
            (["mrclan"], "unknown data set 'mrclan'"),
            (["mrclam", "--set", "10"], "mrclam has no part 'MRCLAM_Dataset10'"),
            (["victoria_park"], "has no address that a program could fetch it from. Get it by hand from http"),
            (["lost_in_the_woods", "--set", "1"], "has no sets"),
        ):
            assert main(["data", "fetch", *words, "--to", str(tmp_path)]) == 2
            err = capsys.readouterr().err
            assert sentence in err and err.count("\n") == 1
        monkeypatch.setenv("EKFSLAM_DATA", str(tmp_path / "new"))
        assert main(["data", "--quick"]) == 0
        assert f"{PART}  found" in capsys.readouterr().out


def test_without_pooch(tmp_path, monkeypatch, capsys):
    real = builtins.__import__

    def without(name, *rest, **more):
        if name == "pooch":
            raise ImportError(name)
        return real(name, *rest, **more)

    monkeypatch.setattr(builtins, "__import__", without)
    assert main(["data", "fetch", "mrclam", "--set", "2", "--to", str(tmp_path)]) == 2
    assert "pip install ekfslam_tutorial[data]" in capsys.readouterr().err


def test_addresses_are_of_parts_that_exist():
    from ekfslam_tutorial.datasets import DATASETS

    known = {d.name: d.parts for d in DATASETS}
    for name, urls in addresses.ADDRESSES.items():
        assert set(urls) <= set(known[name])
        assert all(url.split(":")[0] in ("https", "http", "ftp") for url in urls.values())
    assert json.dumps(addresses.CHECKSUMS) and all(len(c) == 64 for c in addresses.CHECKSUMS.values())
