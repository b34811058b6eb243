"""Put OpenCV, as `requirements-images.txt` locks it, into ``build/images``: for the tests of images alone.

``make test`` runs this file. The environment ``.venv`` has no OpenCV: it is an extra of 60 MB that most of the course
does without. Nothing is done where the folder has been made from this lock. Where OpenCV cannot be had, the last line
says why, and the tests of images skip.
"""

import hashlib
import shutil
import subprocess
import sys
from pathlib import Path

from make_env import explain

ROOT = Path(__file__).resolve().parent.parent
LOCK = ROOT / "requirements-images.txt"


def main(folder=ROOT / "build" / "images", lock=LOCK):
    """Make the folder, or end with one sentence that says why it cannot be made."""
    stamp, wanted = folder / "complete.txt", hashlib.sha256(lock.read_bytes()).hexdigest()
    if stamp.is_file() and stamp.read_text() == wanted:
        return
    shutil.rmtree(folder, ignore_errors=True)
    command = [sys.executable, "-m", "pip", "--disable-pip-version-check", "--no-input", "install", "--no-deps"]
    command += ["--require-hashes", "--only-binary=:all:", "--target", str(folder), "-r", str(lock)]
    pip = subprocess.run(command, capture_output=True, text=True)
    if pip.returncode:
        errors = [line for line in pip.stderr.splitlines() if line.startswith("ERROR")]
        sys.exit(f"OpenCV cannot be fetched: {explain(pip.stdout + pip.stderr) or (errors or ['pip failed'])[0]}")
    stamp.write_text(wanted)  # the last thing: a folder without it is half-made


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
