"""Compile what the course imports, by the Python that will import it: `node tools/lite/run.mjs SITE compile.py WHEEL`.

A browser has no disk on which Python could keep compiled modules: it would compile them anew at each start, which takes
longer than all the rest of the import. So they come as one more package, whose files lie down beside the modules. It
also has what matplotlib finds out about its fonts.
"""

import contextlib
import importlib
import io
import py_compile
import site
import sys
import tempfile
import zipfile
from pathlib import Path

from matplotlib.font_manager import fontManager, json_dump

NAME, VERSION = "course_compiled", "1.0"
WANTED = """IPython IPython.core.completer IPython.core.magics IPython.display numpy numpy.random scipy.linalg
scipy.optimize scipy.sparse.linalg scipy.special scipy.stats matplotlib.pyplot matplotlib_inline.backend_inline
matplotlib.animation mpl_toolkits.mplot3d PIL.Image PIL.PngImagePlugin ipywidgets anywidget
comm sqlite3 ekfslam_tutorial.analysis ekfslam_tutorial.course ekfslam_tutorial.datasets""".split()
WHOLE = "ekfslam_tutorial", "ipykernel", "pyodide_kernel"  # imported or not
SITE = Path(site.getsitepackages()[0])


def main(target):
    """Import, compile, and write the wheel."""
    for name in WANTED:
        importlib.import_module(name)
    files = {
        Path(m.__file__) for m in list(sys.modules.values()) if getattr(m, "__file__", None) is not None and m.__file__
    }
    files |= {path for name in WHOLE for path in (SITE / name).rglob("*.py")}
    content = {}
    for path in sorted(files):
        if path.suffix == ".py" and path.is_relative_to(SITE):
            place, code = compiled(path)
            content[place] = code
    content["matplotlib/fontlist.json"] = fonts()  # Pyodide's matplotlib looks for it there
    content[f"{NAME}/__init__.py"] = b""
    content[f"{NAME}-{VERSION}.dist-info/METADATA"] = (
        f"Metadata-Version: 2.1\nName: {NAME}\nVersion: {VERSION}\n".encode()
    )
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as wheel:
        for name, data in content.items():
            wheel.writestr(zipfile.ZipInfo(name, (2020, 1, 1, 0, 0, 0)), data, zipfile.ZIP_DEFLATED)


def fonts():
    """What matplotlib knows about its fonts, as it would keep it."""
    with tempfile.NamedTemporaryFile() as file:
        json_dump(fontManager, file.name)
        return Path(file.name).read_bytes()


def compiled(path):
    """Return where the compiled module lies below the packages, and what it holds."""
    unchecked = py_compile.PycInvalidationMode.UNCHECKED_HASH  # the source is never another
    with contextlib.redirect_stderr(io.StringIO()):  # warnings about the text of other people's packages
        place = str(py_compile.compile(str(path), doraise=True, invalidation_mode=unchecked))
    return str(Path(place).relative_to(SITE)), Path(place).read_bytes()


main(*sys.argv[1:])
