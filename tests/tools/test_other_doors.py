"""The other ways in (conda, Binder, Docker, a devcontainer, CI) use the same lock and name what exists."""

import json
import os
import re
import tomllib
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[2]
WORKFLOWS = sorted((ROOT / ".github" / "workflows").glob("*.yml"))
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
FIRST = re.search(r"[\d.]+", PROJECT["requires-python"]).group()
VERSIONS = [c.rsplit(" ", 1)[-1] for c in PROJECT["classifiers"] if re.search(r"Python :: 3\.\d+$", c)]
PACKAGE = "pip install --no-deps --no-build-isolation -e ."


def steps(path):
    jobs = yaml.safe_load(path.read_text(encoding="utf-8"))["jobs"]
    return [step for job in jobs.values() for step in job["steps"]]


def test_the_classifiers_begin_with_the_oldest_python_allowed():
    assert VERSIONS[0] == FIRST


def test_conda_and_binder_take_the_lock():
    environment = yaml.safe_load((ROOT / "environment.yml").read_text(encoding="utf-8"))
    python, *_, pip = environment["dependencies"]
    assert python.removeprefix("python=") in VERSIONS
    assert pip == {"pip": ["-r requirements.txt"]}
    assert PACKAGE in (ROOT / "postBuild").read_text(encoding="utf-8")
    assert os.name == "nt" or os.access(ROOT / "postBuild", os.X_OK)


def test_docker_takes_the_lock_with_its_hashes_and_keeps_the_token():
    text = (ROOT / "Dockerfile").read_text(encoding="utf-8")
    assert re.search(r"^FROM python:(\S+)-slim$", text, re.MULTILINE).group(1) in VERSIONS
    assert "--require-hashes --only-binary=:all: -r requirements.txt" in text
    assert "USER student" in text and "-p 127.0.0.1:8888:8888" in text
    assert (ROOT / ".dockerignore").read_text(encoding="utf-8").split().count(".venv") == 1


def test_the_devcontainer_is_that_image():
    box = json.loads((ROOT / ".devcontainer" / "devcontainer.json").read_text(encoding="utf-8"))
    assert (ROOT / ".devcontainer" / box["build"]["dockerfile"]).resolve() == ROOT / "Dockerfile"
    assert "--no-deps --no-build-isolation -e ." in box["postCreateCommand"]
    assert box["remoteUser"] == "student"


@pytest.mark.parametrize("path", WORKFLOWS, ids=lambda p: p.stem)
def test_a_workflow_calls_what_exists(path):
    targets = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE))
    commands = [step["run"] for step in steps(path) if "run" in step]
    assert commands and all(step.get("uses", "x@v1").count("@") == 1 for step in steps(path))
    for command in commands:
        assert set(re.findall(r"^make ([a-z-]+)", command)) <= targets, command
        for file in re.findall(r"\S+\.(?:py|txt)\b", command):
            assert (ROOT / file).exists(), command


def test_ci_runs_the_oldest_and_the_newest_python():
    jobs = yaml.safe_load((ROOT / ".github/workflows/tests.yml").read_text(encoding="utf-8"))["jobs"]
    assert jobs["linux"]["strategy"]["matrix"]["python"] == [VERSIONS[0], VERSIONS[-1]]
    assert "continue-on-error" not in jobs["linux"] and jobs["others"]["continue-on-error"] is True


def test_nothing_switches_off_the_token():
    """JupyterLab keeps its token, whoever starts it."""
    switch = re.compile(r"""(token|password)\s*=\s*(''|""|None|"?$)|disable_check_xsrf|allow_origin\s*=\s*['"]?\*""")
    files = [ROOT / "Makefile", ROOT / "Dockerfile", ROOT / "postBuild", *WORKFLOWS]
    files += [*(ROOT / "tools").glob("*.py"), *(ROOT / "ekfslam_tutorial").rglob("*.py")]
    for path in files:
        lines = [x for x in path.read_text(encoding="utf-8").splitlines() if "jupyter" in x.lower() or "ServerApp" in x]
        assert not [x for x in lines if switch.search(x)], path
