"""The course site: every notebook and every page of docs/, searchable, with nothing fetched from another host.

The source folder is the repository itself, so that the links between notebooks and pages work here as they do on
GitHub: ``make site`` calls ``sphinx-build -c docs . build/site``. The README is the front page.
"""

import json
import os
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import ekfslam_tutorial

sys.path.insert(0, str(Path(__file__).parent))

import equations  # beside this file, as is the next
import front

project = "ekfslam_tutorial"
author = "The ekfslam_tutorial authors"
copyright = author  # Sphinx's name for it
release = version = ekfslam_tutorial.__version__

extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.mathjax", "numpydoc", "sphinx_design"]
root_doc = "README"
include_patterns = ["*.md", "docs/**", "notebooks/*.ipynb", "benchmarks/*.md"]
exclude_patterns = ["**/.ipynb_checkpoints"]

# The notebooks are shown as they were stored: `make notebooks` is what runs them.
nb_execution_mode = "off"
myst_enable_extensions = ["dollarmath", "amsmath", "colon_fence"]
myst_heading_anchors = 4

autodoc_member_order = "bysource"
autodoc_typehints = "none"  # numpydoc's sections say types and shapes
numpydoc_show_class_members = False
numpydoc_class_members_toctree = False

html_theme = "sphinx_book_theme"
html_title = "EKF-SLAM: a course and a toolbox"
html_favicon = "_site/favicon.svg"
html_logo = "_site/logo.svg"
html_context = {"default_mode": "light"}
# MathJax is taken from the files of sphinx-mathjax-offline. As an extension it does not say whether pages may be read
# by several processes at once, which is a warning, and a warning is a failure here.
html_static_path = ["_site", str(Path(find_spec("sphinx-mathjax-offline").origin).parent / "static")]
mathjax_path = "mathjax/tex-chtml.js"
html_css_files = ["site.css"]
html_js_files = ["site.js"]
html_additional_pages = {"index": "redirect.html"}
templates_path = ["_site"]
html_show_sourcelink = False
html_copy_source = False


def repository():
    """Return where the sources are: as GitHub's workflow says, else git; nothing if neither knows."""
    if name := os.environ.get("GITHUB_REPOSITORY"):
        return f"{os.environ.get('GITHUB_SERVER_URL', 'https://github.com')}/{name}"
    command = ["git", "remote", "get-url", "origin"]
    try:
        remote = subprocess.run(command, cwd=Path(__file__).parent, capture_output=True, text=True).stdout.strip()
    except FileNotFoundError:
        return ""
    return remote.removesuffix(".git") if remote.startswith("https://") else ""


html_theme_options = {
    "repository_url": repository(),
    "use_repository_button": bool(repository()),
    "navbar_persistent": [],
    "show_toc_level": 2,
    "use_download_button": False,
    "use_fullscreen_button": False,
    "collapse_navigation": True,
}

# -- what GitHub shows and Sphinx must be told ---

CONTENTS = """
```{toctree}
:hidden:
:caption: The course
:glob:

notebooks/*
```

```{toctree}
:hidden:
:caption: The toolbox
:glob:

docs/gallery
docs/README
docs/*
benchmarks/README
benchmarks/RESULTS
```

```{toctree}
:hidden:
:caption: Every name

docs/api/core
docs/api/fast
docs/api/toolbox
docs/api/course
```

```{toctree}
:hidden:
:caption: The project

CHANGELOG
CONTRIBUTING
```
"""


def read(app, name, source):
    """Give the README the list of all pages, and put pictures attached to a notebook's text into that text."""
    if name == root_doc:
        source[0] += CONTENTS
    if not name.startswith("notebooks/"):
        source[0] = front.page(name, source[0])
    if name.startswith("notebooks/"):
        source[0] = unattached(source[0])


def unattached(text):
    notebook = json.loads(text)
    for cell in notebook["cells"]:
        for name, picture in cell.pop("attachments", {}).items():
            ((kind, data),) = picture.items()
            cell["source"] = "".join(cell["source"]).replace(f"attachment:{name}", f"data:{kind};base64,{data}")
    return json.dumps(notebook)


def escape(app, what, name, obj, options, lines):
    """Show |q| and (*shape, n) in a docstring as they are written: to reStructuredText they are marks."""
    for i, line in enumerate(lines):
        parts = line.split("``")
        parts[::2] = [part.replace("|", "\\|").replace("(*", "(\\*") for part in parts[::2]]
        lines[i] = "``".join(parts)


def setup(app):
    app.connect("builder-inited", front.build)
    app.connect("build-finished", front.copy)
    app.connect("source-read", read)
    app.connect("autodoc-process-docstring", equations.render, priority=390)
    app.connect("autodoc-process-docstring", escape, priority=400)  # before numpydoc's
