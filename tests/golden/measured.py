"""What a recorded run gives: computed once, though tests of several files, in several processes, ask for it."""

import functools
import hashlib
import json
import os
from pathlib import Path

import ekfslam_tutorial
from ekfslam_tutorial.toolbox.files.writing import replacing

from .runs import compare_run

SOURCES = Path(ekfslam_tutorial.__file__).parent, Path(__file__).parent


@functools.cache
def measured(folder, name, engine="plain"):
    """Return the lines of `compare_run`. Processes share them in the folder EKFSLAM_TEST_CACHE, if there is one.

    They are kept by the bytes of the recording and of all code: another filter, or another recording, is measured anew.
    """
    shared = os.environ.get("EKFSLAM_TEST_CACHE")
    kept = shared and Path(shared, f"golden-{name}-{engine}-{_bytes_of(folder, name)}.json")
    if kept and kept.exists():
        return json.loads(kept.read_text())
    lines = list(compare_run(folder, name, engine))
    if kept:
        with replacing(kept) as part:
            part.write_text(json.dumps(lines))
    return lines


def _bytes_of(folder, name):
    """Return a short text that is another one where anything is another one that the lines come from."""
    files = [folder / of for of in (f"runs/{name}.json", f"runs/{name}.npz", f"exact/{name}.npz")]
    digest = hashlib.sha256(_bytes_of_code())
    for path in filter(Path.exists, files):
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


@functools.cache
def _bytes_of_code():
    return b"".join(path.read_bytes() for source in SOURCES for path in sorted(source.rglob("*.py")))
