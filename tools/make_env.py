"""Build or repair the environment ``.venv`` next to this repository's ``requirements.txt``.

``make env`` runs this file; ``python tools/make_env.py`` does the same where there is no make. Standard library
only. This file must also *parse* on old Pythons, so that they get a sentence instead of a SyntaxError.

The file ``.venv/complete.json`` is written last. It says for which lock, which Python and which folder the
environment was made. If it is there and fits, nothing is done; if it is not there, the environment is half-made and
is built anew; if only the lock has changed, the environment is brought up to date in place.
"""

import sys

if sys.version_info < (3, 11):
    sys.exit(
        "ekfslam_tutorial needs Python 3.11 or newer, this is Python %d.%d (%s). Name a newer one: make env PYTHON=python3.12"
        % (sys.version_info[0], sys.version_info[1], sys.executable)
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
NEEDED_MB = 1100  # measured: 850 MB installed, and the downloads while they are unpacked

# What pip's log says, and what it means for the person in front of it. The first match counts.
CAUSES = [
    (
        r"No space left on device|Errno 28|not enough space|Disk quota exceeded",
        "the disk is full: free about %d MB, then run the same command again" % NEEDED_MB,
    ),
    (
        r"DO NOT MATCH THE HASHES",
        "a downloaded package is not the file that the lock names: try again; if it stays, do not install it and tell us",
    ),
    (
        r"Temporary failure in name resolution|Name or service not known|NewConnectionError|nodename nor servname"
        r"|getaddrinfo failed|Failed to establish a new connection|Network is unreachable|Connection refused"
        r"|Read timed out|ConnectTimeoutError|ProxyError|Connection reset",
        "the package index cannot be reached: check the network (and pip's proxy or mirror settings), "
        "then run the same command again; it goes on where it stopped",
    ),
    (
        r"CERTIFICATE_VERIFY_FAILED",
        "the package index's certificate is not trusted: set PIP_CERT to your organisation's certificate file",
    ),
    (
        r"No matching distribution found",
        "the package index offers no file of a locked package for this system or this Python",
    ),
    (r"Permission denied|Read-only file system", "the folder cannot be written: use a copy that you own"),
]


def main():
    parser = argparse.ArgumentParser(description="Build or repair .venv.")
    parser.add_argument("--this-python", action="store_true", help="rebuild if .venv uses another Python version")
    options = parser.parse_args()
    try:
        if not fits(options.this_python):
            with one_at_a_time():
                if not fits(options.this_python):  # somebody else may have just built it
                    build(options.this_python)
    except OSError as error:
        cause = explain(str(error)) or str(error)
        sys.exit("Cannot build the environment %s: %s." % (VENV, cause))
    except KeyboardInterrupt:
        sys.exit("\nStopped. The environment is half-made; the next `make env` completes it.")


# -- what there is ----------------------------------------------------------------------------------------------


def wanted():
    """Return what a complete environment of this repository records of itself, Python aside."""
    digest = hashlib.sha256()
    for name in ("requirements.txt", "pyproject.toml"):
        digest.update((ROOT / name).read_bytes())
    return {"sources": digest.hexdigest(), "folder": str(ROOT)}


def recorded():
    """Return what ``.venv`` records of itself, or an empty dict if it is missing or half-made."""
    try:
        return json.loads(STAMP.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}


def alive():
    """Tell whether the interpreter of ``.venv`` starts and is new enough."""
    if not PYTHON.exists():
        return False
    code = "import sys; sys.exit(sys.version_info < (3, 11))"
    try:
        return subprocess.run([str(PYTHON), "-I", "-S", "-c", code], capture_output=True).returncode == 0
    except OSError:
        return False


def usable(this_python):
    """Tell whether ``.venv`` was once complete, here, and for a Python that still runs."""
    has = recorded()
    same_python = has.get("python") == version() or not this_python
    return bool(has) and same_python and has.get("folder") == str(ROOT) and alive()


def fits(this_python):
    """Tell whether nothing has to be done."""
    return usable(this_python) and recorded()["sources"] == wanted()["sources"]


def version():
    return "%d.%d" % sys.version_info[:2]


# -- the work ---------------------------------------------------------------------------------------------------


def build(this_python):
    if usable(this_python):
        say("The lock or pyproject.toml has changed: bringing .venv up to date")
    else:
        create()
    pip("install", "--require-hashes", "--only-binary=:all:", "-r", "requirements.txt", steps=count_locked())
    pip("install", "--no-deps", "--no-build-isolation", "--editable", ".")
    record()
    say("The environment .venv is ready (%s MB, Python %s)" % (size_mb(VENV), recorded()["python"]))


def create():
    """Make an empty ``.venv`` in place of whatever is there."""
    check_venv_module()
    free_mb = shutil.disk_usage(ROOT).free // 10**6
    if free_mb < NEEDED_MB:
        sys.exit("The environment needs about %d MB and only %d MB are free on this disk." % (NEEDED_MB, free_mb))
    if VENV.is_symlink():
        VENV.unlink()
    elif VENV.exists():
        say("The environment .venv is incomplete, or was made elsewhere or for another Python: building it anew")
        shutil.rmtree(VENV)
    else:
        say("Building the environment .venv with Python %s (once; about 260 MB are downloaded)" % version())
    run = subprocess.run([sys.executable, "-m", "venv", str(VENV)], capture_output=True, text=True, cwd=ROOT)
    if run.returncode:
        text = run.stdout + run.stderr
        sys.exit("python -m venv failed: %s." % (explain(text) or text.strip().splitlines()[-1]))


def check_venv_module():
    if all(importlib.util.find_spec(name) for name in ("venv", "ensurepip")):
        return
    sys.exit(
        "This Python (%s) has no venv module. On Debian and Ubuntu: sudo apt install python3-venv (or python%s-venv)."
        % (sys.executable, version())
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
        for line in process.stdout:
            log.write(line)
            if steps and line.startswith("Collecting "):
                done += 1
                progress("fetching package %d of about %d" % (done, steps), done)
            elif steps and line.startswith("Installing collected"):
                progress("unpacking about %d packages (half a minute)" % steps, 0)
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
    sys.exit("Cannot install the packages: %s.\n(pip's full report: %s)" % (cause, LOG.relative_to(ROOT)))


def explain(text):
    """Return the sentence for the first known cause named in ``text``, or None."""
    return next((meaning for pattern, meaning in CAUSES if re.search(pattern, text)), None)


def record():
    """Write the stamp in one step, as the very last thing."""
    run = subprocess.run(
        [str(PYTHON), "-c", "import sys; print('%d.%d' % sys.version_info[:2])"], capture_output=True, text=True
    )
    partial = STAMP.with_suffix(".part")
    partial.write_text(json.dumps(dict(wanted(), python=run.stdout.strip()), indent=1) + "\n", encoding="utf-8")
    os.replace(partial, STAMP)


def count_locked():
    return sum(re.match(r"[A-Za-z0-9]", line) is not None for line in LOCK.read_text(encoding="utf-8").splitlines())


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
        print("\r  %-60s" % text, end="", flush=True)
    elif step % 25 == 0:
        say("  " + text)


if __name__ == "__main__":
    main()
