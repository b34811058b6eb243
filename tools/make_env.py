"""Build or repair the environment ``.venv`` next to this repository's ``requirements.txt``.

``make env`` runs this file; ``python tools/make_env.py`` does the same where there is no make. Standard
library only, and nothing that Python 3.6 cannot parse: an old Python gets a sentence, not a SyntaxError.

The file ``.venv/complete.json`` is written last. It says for which lock, which Python and which folder the
environment was made. If it is there and fits, nothing is done. If it is not there, the environment is
half-made and is built anew. If only the lock has changed, the environment is brought up to date in place.
"""

import sys

if sys.version_info < (3, 11):  # noqa: UP036
    sys.exit(
        f"ekfslam_tutorial needs Python 3.11 or newer; {sys.executable} is {sys.version.split()[0]}. "
        "Name a newer one: make env PYTHON=python3.12"
    )

import argparse
import contextlib
import hashlib
import importlib.util
import json
import os
import re
import shutil
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
VENV = ROOT / ".venv"
PYTHON = VENV / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
STAMP = VENV / "complete.json"
LOG = VENV / "install.log"
LOCK = ROOT / "requirements.txt"
NEEDED_MB = 1600  # measured: 1250 MB installed, and the downloads while they are unpacked

# What pip's log says, and what it means for the person in front of it. The first match counts.
CAUSES = [
    (
        r"No space left on device|Errno 28|not enough space|Disk quota exceeded",
        f"the disk is full: free about {NEEDED_MB} MB, then run the same command again",
    ),
    (
        r"DO NOT MATCH THE HASHES",
        "a downloaded package is not the file that the lock names: try again; if it stays, tell us",
    ),
    (
        r"Temporary failure in name resolution|Name or service not known|nodename nor servname"
        r"|getaddrinfo failed|NewConnectionError|Failed to establish a new connection|Network is unreachable"
        r"|Connection refused|Read timed out|ConnectTimeoutError|ProxyError|Connection reset",
        "the package index cannot be reached: check the network (and pip's proxy or mirror settings), "
        "then run the same command again; it goes on where it stopped",
    ),
    (
        r"CERTIFICATE_VERIFY_FAILED",
        "the package index's certificate is not trusted: set PIP_CERT to your network's certificate file",
    ),
    (
        r"No matching distribution found",
        "the package index offers no file of a locked package for this system or this Python",
    ),
    (r"Permission denied|Read-only file system", "the folder cannot be written: use a copy that you own"),
]


def main():
    parser = argparse.ArgumentParser(description="Build or repair .venv.")
    parser.add_argument("--this-python", action="store_true", help="rebuild if .venv has another version")
    options = parser.parse_args()
    try:
        if not fits(options.this_python):
            with one_at_a_time():
                if not fits(options.this_python):  # somebody else may have just built it
                    build(options.this_python)
    except OSError as error:
        cause = explain(str(error)) or str(error)
        sys.exit(f"Cannot build the environment {VENV}: {cause}.")
    except KeyboardInterrupt:
        sys.exit("\nStopped. The environment is half-made; the next `make env` completes it.")


# -- what there is ---


def wanted():
    """Return what a complete environment of this repository records of itself, Python aside."""
    digest = hashlib.sha256()
    for name in (
        "requirements.txt",
        "pyproject.toml",
        "ekfslam_tutorial/__init__.py",
    ):  # the last: the version
        digest.update((ROOT / name).read_bytes())
    return {"sources": digest.hexdigest(), "folder": str(ROOT)}


def recorded():
    """Return what ``.venv`` records of itself, or an empty dict if it is missing or half-made."""
    try:
        stamp = json.loads(STAMP.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return stamp if isinstance(stamp, dict) else {}


def alive():
    """Tell whether the interpreter of ``.venv`` starts."""
    try:
        return subprocess.run([str(PYTHON), "-I", "-S", "-c", ""], capture_output=True).returncode == 0
    except OSError:
        return False


def packages():
    """Return the names in ``site-packages``: one folder and one ``NAME-VERSION.dist-info`` per package."""
    folders = [*VENV.glob("lib/python3*/site-packages"), *VENV.glob("Lib/site-packages")]
    return {path.name for folder in folders for path in folder.iterdir() if path.name != "__pycache__"}


def usable(this_python):
    """Tell whether ``.venv`` was made here, still runs, and has lost no package since it was complete."""
    has = recorded()
    if has.get("folder") != str(ROOT) or (this_python and has.get("python") != version()):
        return False
    return alive() and packages().issuperset(has.get("packages", []))


def fits(this_python):
    """Tell whether nothing has to be done."""
    return usable(this_python) and recorded().get("sources") == wanted()["sources"]


def version():
    return f"{sys.version_info[0]}.{sys.version_info[1]}"


# -- the work ---


def build(this_python):
    if usable(this_python):
        say("The lock or pyproject.toml has changed: bringing .venv up to date")
    else:
        create()
    pip("install", "--require-hashes", "--only-binary=:all:", "-r", "requirements.txt", steps=count_locked())
    pip("install", "--no-deps", "--no-build-isolation", "--editable", ".")
    record()
    say(f"The environment .venv is ready ({size_mb(VENV)} MB, Python {recorded()['python']})")


def create():
    """Make an empty ``.venv`` in place of whatever is there."""
    check_venv_module()
    free_mb = shutil.disk_usage(ROOT).free // 10**6
    if free_mb < NEEDED_MB:
        sys.exit(f"The environment needs about {NEEDED_MB} MB and only {free_mb} MB are free on this disk.")
    if VENV.is_symlink():
        VENV.unlink()
    elif VENV.exists():
        say("The environment .venv is incomplete, damaged, moved, or has another Python: building it anew")
        shutil.rmtree(VENV)
    else:
        say(f"Building the environment .venv with Python {version()} (once; about 330 MB are downloaded)")
    run = subprocess.run([sys.executable, "-m", "venv", str(VENV)], capture_output=True, text=True, cwd=ROOT)
    if run.returncode:
        text = run.stdout + run.stderr
        sys.exit(f"Cannot make the folder {VENV}: {explain(text) or text.strip().splitlines()[-1]}.")


def check_venv_module():
    if all(importlib.util.find_spec(name) for name in ("venv", "ensurepip")):
        return
    sys.exit(
        f"This Python ({sys.executable}) has no venv module. On Debian and Ubuntu: "
        f"sudo apt install python3-venv (or python{version()}-venv)."
    )


def pip(*arguments, steps=0):
    """Run pip inside ``.venv``; show a counter, keep everything in ``.venv/install.log``."""
    command = [str(PYTHON), "-m", "pip", "--disable-pip-version-check", "--no-input", *arguments]
    # These settings of the user would put packages elsewhere, or hide what the venv holds.
    misleading = ("PIP_USER", "PIP_TARGET", "PIP_PREFIX", "PIP_ROOT", "PIP_QUIET", "PYTHONPATH", "PYTHONHOME")
    environment = {name: value for name, value in os.environ.items() if name not in misleading}
    done = 0
    with LOG.open("a", encoding="utf-8") as log:
        process = subprocess.Popen(
            command,
            cwd=ROOT,
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            encoding="utf-8",
            errors="replace",
        )
        for line in process.stdout or ():
            log.write(line)
            if steps and line.startswith(("Collecting ", "Processing ", "Requirement already satisfied: ")):
                done += 1
                progress(f"package {done} of at most {steps}", done)
            elif steps and line.startswith("Installing collected"):
                progress(f"unpacking {done} packages (half a minute)", 0)
    if steps and sys.stdout.isatty():
        print()
    if process.wait():
        fail()


def fail():
    lines = LOG.read_text(encoding="utf-8", errors="replace").splitlines()
    cause = explain("\n".join(lines))
    if cause is None:
        errors = [line for line in lines if line.startswith("ERROR")] or lines[-1:]
        cause = errors[0] if errors else "pip failed without a message"
    sys.exit(f"Cannot install the packages: {cause}.\n(pip's full report: {LOG.relative_to(ROOT)})")


def explain(text):
    """Return the sentence for the first known cause named in ``text``, or None."""
    return next((meaning for pattern, meaning in CAUSES if re.search(pattern, text)), None)


def record():
    """Write the stamp in one step, as the very last thing."""
    code = "import sys; print(sys.version_info[0], sys.version_info[1], sep='.')"
    run = subprocess.run([str(PYTHON), "-c", code], capture_output=True, text=True, check=True)
    partial = STAMP.with_suffix(".part")
    state = {**wanted(), "python": run.stdout.strip(), "packages": sorted(packages())}
    text = json.dumps(state, indent=1)
    partial.write_text(text + "\n", encoding="utf-8")
    os.replace(partial, STAMP)


def count_locked():
    return len(re.findall(r"^[A-Za-z0-9]", LOCK.read_text(encoding="utf-8"), re.MULTILINE))


def size_mb(folder):
    return round(sum(f.stat().st_size for f in folder.rglob("*") if f.is_file() and not f.is_symlink()) / 1e6)


@contextlib.contextmanager
def one_at_a_time():
    """Let a second `make env` in the same folder wait for the first (where the system can lock files)."""
    try:
        import fcntl
    except ImportError:
        yield
        return
    with open(LOCK, "rb") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            say("Another `make env` is at work in this folder: waiting for it")
            fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def say(text):
    print(text, flush=True)


def progress(text, step):
    """Overwrite one line on a terminal; elsewhere print every 25th."""
    if sys.stdout.isatty():
        print(f"\r  {text:60}", end="", flush=True)
    elif step % 25 == 0:
        say("  " + text)


if __name__ == "__main__":
    main()
