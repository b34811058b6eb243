"""`ekfslam data import`: recognised by content, checked, copied; nothing overwritten, nothing outside its folder."""

import io
import zipfile

import numpy as np
import pytest
from scipy.io import savemat

from ekfslam_tutorial.cli import main
from ekfslam_tutorial.datasets import mrclam_twin, plaza
from ekfslam_tutorial.datasets.arrivals import ARRAYS, bring, recognise, whole

PARK = "victoria_park_detections.npz"


@pytest.fixture(scope="module")
def twin(tmp_path_factory):
    return mrclam_twin.write(tmp_path_factory.mktemp("twin") / "MRCLAM_Dataset2", duration=30.0)


def park(path):
    three = {k: np.arange(3.0) for k in ("odo_t_ms", "speed", "steering", "gps_t_ms", "gps_x", "gps_y", "scan_t_ms")}
    trees = {k: np.ones(2) for k in ("det_range", "det_bearing", "det_diameter")}
    np.savez(path, **three, **trees, det_per_scan=np.array([1, 0, 1]))
    return path


def woods(path, n=5):
    m = {k: np.zeros((n, 1)) for k in ("t", "v", "om", "x_true", "y_true", "th_true", "true_valid")}
    m |= {"r": np.ones((n, 17)), "b": np.zeros((n, 17)), "l": np.zeros((17, 2)), "t": 0.1 * np.arange(n)[:, None]}
    savemat(path, m | dict.fromkeys(("d", "r_var", "b_var", "v_var", "om_var"), 0.1), do_compression=True)
    return path


def odometry(path):
    savemat(path, {k: np.arange(4.0) for k in ("time", "speed", "steering")})
    return path


def gps(path):
    savemat(path, {k: np.arange(4.0) for k in ("timeGps", "Lo_m", "La_m")})
    return path


def scans(path):
    savemat(path, {"LASER": np.full((3, 361), 8000, np.uint16), "TLsr": np.arange(3.0)})
    return path


MAKE = {PARK: park, "dataset2.mat": woods, "aa3_dr.mat": odometry, "aa3_gpsx.mat": gps, "aa3_lsr2.mat": scans}


def pack(path, folder_or_files, prefix=""):
    files = folder_or_files if isinstance(folder_or_files, dict) else {}
    if not files:
        files = {f"{prefix}{p.name}": p.read_bytes() for p in folder_or_files.iterdir()}
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in files.items():
            archive.writestr(name, data)
    return path


def below(folder):
    return sorted(p.relative_to(folder).as_posix() for p in folder.rglob("*") if p.is_file())


@pytest.mark.parametrize("part", MAKE)
def test_files_are_known_by_their_content(tmp_path, part):
    """Under a wrong name, alone, in a folder and in a zip."""
    odd = MAKE[part](tmp_path / f"download-1{part[-4:]}")
    assert set(MAKE) | set(plaza.FILES.values()) == set(ARRAYS) and recognise(odd) == part
    bring(odd, tmp_path / "a")
    assert (tmp_path / "a" / part).read_bytes() == odd.read_bytes()
    folder = tmp_path / "mine"
    (folder / "deeper").mkdir(parents=True)
    MAKE[part](folder / "deeper" / f"x{part[-4:]}")
    bring(folder, tmp_path / "b")
    archive = pack(tmp_path / "any.zip", {f"some/where/{part}": odd.read_bytes(), "readme.txt": b"hello"})
    bring(archive, tmp_path / "c")
    assert below(tmp_path / "b") == below(tmp_path / "c") == [part]
    whole(tmp_path / "c" / part, part)


def test_mrclam_packed_and_unpacked(tmp_path, twin):
    to = tmp_path / "to"
    bring(twin, to)
    assert below(to) == sorted(f"MRCLAM_Dataset2/{p.name}" for p in twin.iterdir())
    bring(pack(tmp_path / "MRCLAM5.zip", twin), to)
    bring(pack(tmp_path / "download.zip", twin, "MRSLAM_Dataset4/"), to)
    assert {"MRCLAM_Dataset5.zip", "MRCLAM_Dataset4.zip"} < set(below(to))
    with pytest.raises(ValueError, match="which one"):
        bring(pack(tmp_path / "download.zip", twin), to)


def test_nothing_is_overwritten_without_force(tmp_path, twin):
    to, file = tmp_path / "to", park(tmp_path / "x.npz")
    for path, name in (file, PARK), (twin, "MRCLAM_Dataset2"):
        bring(path, to)
        with pytest.raises(FileExistsError, match=f"{name} is there already; --force replaces it"):
            bring(path, to)
    (to / PARK).write_bytes(b"old")
    (to / "MRCLAM_Dataset2" / "old.txt").write_text("old")
    bring(file, to, force=True)
    bring(twin, to, force=True)
    assert (to / PARK).read_bytes() == file.read_bytes() and "MRCLAM_Dataset2/old.txt" not in below(to)


def test_what_is_damaged_does_not_arrive(tmp_path, twin):
    to = tmp_path / "to"
    bring(park(tmp_path / "x.npz"), to)
    kept = below(to), (to / PARK).read_bytes()
    arrays = dict(np.load(tmp_path / "x.npz"))
    np.savez(tmp_path / "x.npz", **(arrays | {"det_per_scan": np.array([1, 1, 1])}))
    (twin / "Robot3_Odometry.dat").rename(twin / "hidden")
    cut = pack(tmp_path / "MRCLAM_Dataset3.zip", twin)
    try:
        for path in tmp_path / "x.npz", twin, cut:
            with pytest.raises(ValueError) as caught:
                bring(path, to, force=True)
            assert "\n" not in str(caught.value)
    finally:
        (twin / "hidden").rename(twin / "Robot3_Odometry.dat")
    assert (below(to), (to / PARK).read_bytes()) == kept
    assert [p.name for p in to.iterdir()] == [PARK]  # no temporary folders, either


@pytest.mark.parametrize(
    "content",
    [b"", b"<html>not found</html>", b"PK\x03\x04 cut", b"MATLAB 5.0 MAT-file" + b"\xff" * 500, b"\x93NUMPY" * 9],
    ids=["empty", "page", "zip", "matlab", "npy"],
)
def test_what_is_not_known_is_refused(tmp_path, content):
    for name in "x.zip", "x.mat", "MRCLAM_Dataset3.zip":
        (tmp_path / name).write_bytes(content)
        with pytest.raises(ValueError, match="data set|zip"):
            bring(tmp_path / name, tmp_path / "to")
    assert below(tmp_path / "to") == []


def test_folders_without_anything(tmp_path):
    (tmp_path / "empty").mkdir()
    with pytest.raises(ValueError, match="holds no data set"):
        bring(tmp_path / "empty", tmp_path / "to")
    with pytest.raises(FileNotFoundError, match="there is no"):
        bring(tmp_path / "nowhere", tmp_path / "to")


def test_names_in_a_zip_lead_nowhere(tmp_path):
    """Up, absolute, drives of Windows, links: only the last name counts, and the file lies in the folder."""
    data = park(tmp_path / "x.npz").read_bytes()
    inside = tmp_path / "deep" / "inside"
    for path in f"../../{PARK}", f"/{PARK}", f"C:\\{PARK}", f"..\\..\\{PARK}", f"a/../../../{PARK}", f"//host/{PARK}":
        bring(pack(tmp_path / "x.zip", {path: data}), inside / "to", force=True)
        assert below(inside) == [f"to/{PARK}"] and below(tmp_path / "deep") == [f"inside/to/{PARK}"]
    link = zipfile.ZipInfo(PARK)
    link.external_attr = 0o120777 << 16
    with zipfile.ZipFile(tmp_path / "link.zip", "w") as archive:
        archive.writestr(link, "/etc/hostname")
    with pytest.raises(ValueError):
        bring(tmp_path / "link.zip", tmp_path / "other")
    assert not list((tmp_path / "other").iterdir())


def test_links_in_a_folder_are_not_followed(tmp_path, twin):
    (tmp_path / "mine").mkdir()
    try:
        (tmp_path / "mine" / "x.npz").symlink_to(park(tmp_path / "secret.npz"))
    except OSError:
        pytest.skip("no symbolic links here")
    with pytest.raises(ValueError, match="holds no data set"):
        bring(tmp_path / "mine", tmp_path / "to")


def test_bombs(tmp_path):
    zeros = io.BytesIO()
    with zipfile.ZipFile(zeros, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("MRCLAM_Dataset1/Barcodes.dat", bytes(100_000_000))
    (tmp_path / "x.zip").write_bytes(zeros.getvalue())
    with pytest.raises(ValueError, match="would unpack to 95 MB"):
        bring(tmp_path / "x.zip", tmp_path / "to")


def test_the_command(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("EKFSLAM_DATA", str(tmp_path / "to"))
    (tmp_path / "to").mkdir()
    file = woods(tmp_path / "x.mat")
    assert main(["data", "import", str(file)]) == 0
    assert "dataset2.mat: checked and copied to" in capsys.readouterr().out
    assert main(["data", "import", str(file)]) == 2
    assert "is there already; --force replaces it" in capsys.readouterr().err
    assert main(["data", "import", str(file), "--force"]) == 0
    assert main(["data", "import", str(file), "--to", str(tmp_path / "other")]) == 0
    assert (tmp_path / "other" / "dataset2.mat").exists()
    capsys.readouterr()
    assert main(["data"]) == 0
    assert "whole: 5 frames" in capsys.readouterr().out
