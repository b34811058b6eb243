"""`ekfslam notebooks DEST`: the notebooks in a folder of the student's own, where nothing is ever overwritten."""

import filecmp
import shutil
import sys
from pathlib import Path

from .files import replacing, shipped, writable_folder

SKIP = shutil.ignore_patterns(".ipynb_checkpoints", "__pycache__", ".*")


def main(options):
    """Run the command."""
    source = shipped("notebooks")
    if not any(source.glob("*.ipynb")):
        raise FileNotFoundError(f"there are no notebooks in {source}; install the package again")
    destination = Path(options.destination)
    if destination.resolve() == source.resolve():
        raise ValueError(f"{destination} is where the notebooks come from; name another folder")
    writable_folder(destination)
    copied, kept = copy(source, destination)
    print(f"{len(copied)} files copied to {destination}" + (", those there already left as they are" if kept else ""))
    for path in kept:
        print(f"  kept: {path} differs from the package's; move yours away to get that one", file=sys.stderr)
    print(f"next: jupyter lab {destination}")
    return 0


def copy(source, destination):
    """Copy a tree without touching a file that is there.

    Returns
    -------
    copied, kept : list of Path
        Below `destination`; kept are files that were there and differ.
    """
    copied, kept = [], []
    for folder in (source, *sorted(p for p in source.rglob("*") if p.is_dir())):
        names = sorted(p.name for p in folder.iterdir())
        ignored = SKIP(str(folder), names)
        if any(part in SKIP(str(folder), [part]) for part in folder.relative_to(source).parts):
            continue
        for path in (folder / name for name in names if name not in ignored):
            target = destination / path.relative_to(source)
            if path.is_dir():
                target.mkdir(exist_ok=True)
            elif target.exists():
                kept += [] if filecmp.cmp(path, target, shallow=False) else [target]
            else:
                with replacing(target) as part:
                    shutil.copyfile(path, part)
                copied.append(target)
    return copied, kept
