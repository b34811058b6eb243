"""Re-run every notebook on a fresh kernel, in order, and store its outputs in one normal form.

``make notebooks`` runs this file; file names as arguments take only those. The stored outputs are what
readers see on a code-hosting site and what ``make test`` compares with: this command
makes them, never a hand.

A notebook keeps its old file if a cell fails, if an output holds a path of this computer, if a widget stands
in a cell that is not tagged ``nbval-ignore-output``, or if the file would be larger than 600 kB. The new file
replaces the old one in one step.
"""

import os
import re
import sys
import tempfile
import time
from pathlib import Path

import nbformat
from nbclient import NotebookClient
from nbclient.exceptions import CellExecutionError

ROOT = Path(__file__).resolve().parent.parent
FOLDER = ROOT / "notebooks"
LIMIT_KB = 600
CELL_TIMEOUT_S = 600
WIDGET = "application/vnd.jupyter.widget-view+json"
COLOURS = re.compile(r"\x1b\[[0-9;]*m")
PASSING = {"execution", "collapsed", "scrolled", "ExecuteTime"}  # cell metadata that says nothing to a reader
KERNELSPEC = {"display_name": "Python 3 (ipykernel)", "language": "python", "name": "python3"}


class Refused(Exception):
    """The notebook was run, but its outputs must not be stored; the message says why."""


def main(names):
    paths = [Path(name).resolve() for name in names] or sorted(FOLDER.glob("*.ipynb"))
    if not paths:
        return f"There is no notebook in {FOLDER.name}/."
    bad = []
    with tempfile.TemporaryDirectory() as folder:
        environment = own_environment(folder)
        for path in paths:
            started = time.monotonic()
            print(f"{path.name:44}", end=" ", flush=True)
            try:
                text = build(path, environment)
                replace(path, text)
                print(f"{len(text.encode()) / 1000:6.0f} kB {time.monotonic() - started:6.1f} s", flush=True)
            except (Refused, CellExecutionError, OSError, ValueError) as error:
                bad.append(path.name)
                print(f"NOT STORED\n{COLOURS.sub('', str(error))}\n", flush=True)
    return f"Not stored: {', '.join(bad)}." if bad else 0


def own_environment(folder):
    """Return the kernel's environment: nothing of the user's own settings gets into the outputs."""
    environment = {name: value for name, value in os.environ.items() if name != "MPLBACKEND"}  # the kernel's: inline
    progress = os.path.join(folder, "progress.json")  # nobody has done an exercise yet
    mine = os.path.join(folder, "my_slam.py")  # and nothing is kept
    own = {"IPYTHONDIR": folder, "EKFSLAM_PROGRESS": progress, "EKFSLAM_MY_SLAM": mine}
    return environment | {"OPENBLAS_NUM_THREADS": "1"} | own


def build(path, environment):
    """Return the text of the notebook at `path`, run and normalised."""
    nb = nbformat.read(path, as_version=4)
    for cell in nb.cells:
        cell.metadata = {key: value for key, value in cell.metadata.items() if key not in PASSING}
        if cell.cell_type == "code":
            cell.outputs, cell.execution_count = [], None
    client = NotebookClient(
        nb,
        timeout=CELL_TIMEOUT_S,
        kernel_name="python3",
        coalesce_streams=True,
        record_timing=False,
        store_widget_state=False,
        extra_arguments=["--IPKernelApp.log_level=ERROR"],
        resources={"metadata": {"path": str(path.parent)}},
    )
    client.execute(env=environment)
    normalise(nb, number=path.name.split("_")[0])
    check(nb)
    text = nbformat.writes(nb) + "\n"
    if len(text.encode()) > LIMIT_KB * 1000:
        raise Refused(f"the file would have {len(text.encode()) // 1000} kB; the limit is {LIMIT_KB} kB")
    return text


def normalise(nb, number):
    """Drop what changes from run to run or from computer to computer."""
    nb.nbformat_minor = 5
    language = {key: value for key, value in nb.metadata.get("language_info", {}).items() if key != "version"}
    nb.metadata = {**nb.metadata, "kernelspec": KERNELSPEC, "language_info": language}
    nb.metadata.pop("widgets", None)
    name_cells(nb, number)
    code = [cell for cell in nb.cells if cell.cell_type == "code" and cell.source.strip()]
    for count, cell in enumerate(code, start=1):
        cell.execution_count = count
        for output in cell.outputs:
            if output.output_type == "execute_result":
                output.execution_count = count
            if WIDGET in output.get("data", {}):
                still_picture(cell, output)


def still_picture(cell, output):
    """Put a sentence in place of a widget: without its kernel it would show as an error."""
    if "nbval-ignore-output" not in cell.metadata.get("tags", []):
        raise Refused(f"cell {cell.id} shows a widget but is not tagged 'nbval-ignore-output'")
    output.data = {"text/plain": "(Run this cell in JupyterLab to get the controls.)"}
    output.metadata = {}


def name_cells(nb, number):
    """Give every cell a readable id such as ``04-check-2``; an id of that form stays."""
    taken = {cell.id for cell in nb.cells}
    seen = set()
    for cell in nb.cells:
        if cell.id.startswith(f"{number}-") and cell.id not in seen:
            seen.add(cell.id)
            continue
        tags = [tag for tag in cell.metadata.get("tags", []) if re.fullmatch(r"[a-z]+", tag)]
        kind = tags[0] if tags else {"markdown": "text"}.get(cell.cell_type, cell.cell_type)
        free = (f"{number}-{kind}-{i}" for i in range(1, len(nb.cells) + 1))
        cell.id = next(name for name in free if name not in taken | seen)
        seen.add(cell.id)


def check(nb):
    """Refuse error outputs and paths of this computer."""
    here = {str(ROOT), str(Path.home()), sys.prefix} - {"/"}
    for cell in nb.cells:
        for output in cell.get("outputs", []):
            if output.output_type == "error":
                raise Refused(f"cell {cell.id} ends in {output.ename}: {output.evalue}")
            found = next((path for path in here if path in str(output)), None)
            if found:
                raise Refused(f"an output of cell {cell.id} holds a path of this computer ({found})")


def replace(path, text):
    """Write `text` to `path` in one step; leave an equal file untouched."""
    if path.read_text(encoding="utf-8") == text:
        return
    partial = path.with_suffix(".part")
    try:
        partial.write_text(text, encoding="utf-8", newline="\n")
        os.replace(partial, path)
    finally:
        partial.unlink(missing_ok=True)


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1:]))
    except KeyboardInterrupt:
        sys.exit("\nStopped; the notebook that was running keeps its old file.")
