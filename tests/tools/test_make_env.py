"""`make env`: when it builds, when it repairs, when it does nothing. The package installer is a stand-in here."""

import json
import shutil
import sys

import pytest

from tools import make_env


@pytest.fixture
def repo(tmp_path, monkeypatch):
    """A small repository, with a stand-in for pip that notes its calls and "installs" one package."""
    for name in ("requirements.txt", "pyproject.toml", "ekfslam_tutorial/__init__.py"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(name)
    venv = tmp_path / ".venv"
    monkeypatch.setattr(make_env, "ROOT", tmp_path)
    monkeypatch.setattr(make_env, "VENV", venv)
    monkeypatch.setattr(make_env, "STAMP", venv / "complete.json")
    monkeypatch.setattr(make_env, "LOG", venv / "install.log")
    monkeypatch.setattr(make_env, "LOCK", tmp_path / "requirements.txt")
    monkeypatch.setattr(make_env, "PYTHON", venv / make_env.PYTHON.relative_to(make_env.PYTHON.parents[1]))
    monkeypatch.setattr(sys, "argv", ["make_env.py"])

    def create():
        shutil.rmtree(venv, ignore_errors=True)
        site(venv).mkdir(parents=True)
        make_env.PYTHON.parent.mkdir(parents=True, exist_ok=True)
        make_env.PYTHON.symlink_to(sys.executable)
        calls.append("create")

    def pip(*arguments, steps=0):
        (site(venv) / "numpy").mkdir(exist_ok=True)
        calls.append("pip")

    calls = []
    monkeypatch.setattr(make_env, "create", create)
    monkeypatch.setattr(make_env, "pip", pip)
    return tmp_path, calls


def site(venv):
    return venv / "lib" / "python3" / "site-packages"


def run(calls):
    """Run `make env` once; return what it did."""
    calls.clear()
    make_env.main()
    return list(calls)


FROM_NEW = ["create", "pip", "pip"]
UP_TO_DATE = ["pip", "pip"]


def test_builds_once(repo):
    root, calls = repo
    assert run(calls) == FROM_NEW
    assert run(calls) == []


@pytest.mark.parametrize("name", ["requirements.txt", "pyproject.toml"])
def test_a_changed_lock_is_brought_in_without_building_anew(repo, name):
    root, calls = repo
    run(calls)
    (root / name).write_text("changed")
    assert run(calls) == UP_TO_DATE
    assert run(calls) == []


@pytest.mark.parametrize(
    "harm",
    [
        lambda venv: (venv / "complete.json").unlink(),
        lambda venv: (venv / "complete.json").write_text('{"fold'),
        lambda venv: (venv / "complete.json").write_text("[]"),
        lambda venv: make_env.PYTHON.unlink(),
        lambda venv: (make_env.PYTHON.unlink(), make_env.PYTHON.symlink_to(venv / "no such python")),
        lambda venv: shutil.rmtree(site(venv) / "numpy"),
    ],
    ids=["half-made", "torn stamp", "strange stamp", "no interpreter", "interpreter moved", "package lost"],
)
def test_a_broken_environment_is_built_anew(repo, harm):
    root, calls = repo
    run(calls)
    harm(root / ".venv")
    assert run(calls) == FROM_NEW
    assert run(calls) == []


def test_a_package_added_by_the_user_does_no_harm(repo):
    root, calls = repo
    run(calls)
    (site(root / ".venv") / "another").mkdir()
    assert run(calls) == []


def test_a_moved_folder_is_built_anew(repo, monkeypatch):
    root, calls = repo
    run(calls)
    stamp = json.loads(make_env.STAMP.read_text())
    make_env.STAMP.write_text(json.dumps({**stamp, "folder": "elsewhere"}))
    assert run(calls) == FROM_NEW


def test_another_python_counts_only_if_it_was_named(repo, monkeypatch):
    root, calls = repo
    run(calls)
    monkeypatch.setattr(make_env, "version", lambda: "3.99")
    assert run(calls) == []
    monkeypatch.setattr(sys, "argv", ["make_env.py", "--this-python"])
    assert run(calls) == FROM_NEW


def test_a_failed_install_leaves_no_stamp(repo, monkeypatch):
    root, calls = repo
    good = make_env.pip
    monkeypatch.setattr(make_env, "pip", lambda *arguments, steps=0: sys.exit("no network"))
    with pytest.raises(SystemExit, match="no network"):
        run(calls)
    assert not make_env.STAMP.exists()
    monkeypatch.setattr(make_env, "pip", good)
    assert run(calls) == FROM_NEW


@pytest.mark.parametrize(
    "log, word",
    [
        ("ERROR: Could not install packages due to an OSError: [Errno 28] No space left on device", "disk is full"),
        ("NewConnectionError('...: [Errno -3] Temporary failure in name resolution')", "check the network"),
        ("ERROR: THESE PACKAGES DO NOT MATCH THE HASHES FROM THE REQUIREMENTS FILE.", "not the file"),
        ("[SSL: CERTIFICATE_VERIFY_FAILED] certificate verify failed", "PIP_CERT"),
        ("ERROR: No matching distribution found for numpy==99", "no file of a locked package"),
        ("[Errno 13] Permission denied: 'x'", "cannot be written"),
    ],
)
def test_pip_failures_are_explained(log, word):
    assert word in (make_env.explain(log) or "")


def test_an_unknown_failure_is_not_explained_away():
    assert make_env.explain("ERROR: something else") is None


def test_pip_says_why_and_stops(repo, monkeypatch):
    """The real runner, with an interpreter call that fails as pip does on a full disk."""
    root, calls = repo
    run(calls)
    monkeypatch.undo()
    monkeypatch.setattr(make_env, "ROOT", root)
    monkeypatch.setattr(make_env, "LOG", root / ".venv" / "install.log")
    fake = root / "pip.py"
    fake.write_text("import sys; print('OSError: [Errno 28] No space left on device'); sys.exit(1)")
    monkeypatch.setattr(make_env, "PYTHON", fake)
    popen = make_env.subprocess.Popen
    monkeypatch.setattr(
        make_env.subprocess, "Popen", lambda command, **options: popen([sys.executable, command[0]], **options)
    )
    with pytest.raises(SystemExit, match="the disk is full"):
        make_env.pip("install", "numpy")
