"""`ekfslam new sensor|landmark|motion NAME`: a model that works from the first minute, to be changed into one's own.

This is section 5 of the manual as a habit: the file says what is needed, its test says whether it is there.
"""

import ast
import keyword
import re
import sys
from importlib.metadata import packages_distributions
from pathlib import Path

from ..models import landmarks, motion, sensors
from ..toolbox.scenario.keys import exported
from .files import replacing, writable_folder

TEMPLATES = Path(__file__).parent / "templates"
EXPORTS = {"sensor": sensors, "landmark": landmarks, "motion": motion}
FOLDER = {"sensor": "sensors", "landmark": "landmarks", "motion": "motion"}


def main(options):
    """Run the command."""
    name, cls = names(options.name)
    known = exported(EXPORTS[options.kind])
    if name in known:
        raise ValueError(
            f"the package has a {options.kind} {name!r} already; known: {', '.join(known)}; take another name"
        )
    if name in sys.stdlib_module_names or name in packages_distributions():
        raise ValueError(f"{name}.py would hide the module {name!r} that other programs import; take another name")
    folder = writable_folder(options.dir)
    paths = [folder / f"{name}.py", folder / f"test_{name}.py"]
    for path in paths:
        if path.exists():
            raise FileExistsError(f"{path} is there already, and nothing is overwritten; take another name")
    for path, template in zip(paths, (f"{options.kind}.py", f"test_{options.kind}.txt"), strict=True):
        text = (TEMPLATES / template).read_text(encoding="utf-8")
        text = bare(text) if options.bare and path == paths[0] else text
        with replacing(path) as part:
            part.write_text(filled(text, options.kind, name, cls), encoding="utf-8")
    print(f"written: {paths[0]} (the model) and {paths[1]} (its test)")
    print(f"next: python -m pytest {paths[1]}, then change the model and run it again")
    print(f"in a scenario: ekfslam run SCENARIO --models {paths[0]}, with {usage(options.kind, name)}")
    print(f"into the package: move it to ekfslam_tutorial/models/{FOLDER[options.kind]}/ and add one export line there")
    return 0


def names(name):
    """Name of the file and of the class: my_sonar and MySonar, whichever of the two was given."""
    words = re.findall(r"[A-Z]?[a-z0-9]+|[A-Z]+(?![a-z])", name) if re.fullmatch(r"[A-Za-z]\w*", name) else []
    small = "_".join(words).lower()
    if not words or keyword.iskeyword(small) or not small.isascii():
        raise ValueError(
            f"{name!r} is no name for a model; write small letters, digits and underscores, as in my_sonar"
        )
    return small, "".join(word.capitalize() for word in small.split("_"))


def usage(kind, name):
    """Say how a scenario names the model."""
    return f'motion = "{name}"' if kind == "motion" else f'type = "{name}"'


def bare(text):
    """A template whose methods have no bodies: a run stops exactly where the first one is needed.

    Each method keeps its first line and its docstring, and raises NotImplementedError with its own name.
    """
    lines = text.splitlines()
    methods = [f for c in ast.parse(text).body if isinstance(c, ast.ClassDef) for f in c.body]
    for f in reversed([f for f in methods if isinstance(f, ast.FunctionDef)]):
        first = f.body[1] if ast.get_docstring(f) and len(f.body) > 1 else f.body[0]
        stop = f'{" " * first.col_offset}raise NotImplementedError("{f.name}: your code here")'
        lines[first.lineno - 1 : f.end_lineno] = [stop]
    return "\n".join(lines) + "\n"


def filled(text, kind, name, cls):
    """A template with the names put in."""
    return text.replace(f"New{kind.capitalize()}", cls).replace(f"new_{kind}", name)
