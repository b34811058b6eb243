# Two commands do everything, set-up included:
#   make lab     JupyterLab on your copy of the notebooks
#   make test    every test and every notebook
# All paths are relative, so the folder may have spaces and accents in its name.

PYTHON ?= python3
VENV   := .venv/bin/python
SITE   := build/site

# One BLAS thread: faster than two on these small matrices, and the same result everywhere.
export OPENBLAS_NUM_THREADS ?= 1

# `make env PYTHON=python3.12` means that Python; plain `make env` takes .venv as it is.
ifneq ($(origin PYTHON),file)
ENV_ARGS := --this-python
endif

.DEFAULT_GOAL := help
.PHONY: help env lab test test-browser notebooks bench bench-quick contents pictures ogl site lite lint format lock audit sbom clean mutants

help:  ## list these targets
	@sed -n 's/^\([a-z-]*\):.*  ## /\1\t/p' Makefile | while IFS='	' read -r name text; do printf 'make %-13s %s\n' "$$name" "$$text"; done

env:  ## build .venv if it is missing, broken or older than the lock (PYTHON=python3.12 takes that one)
	@command -v "$(PYTHON)" >/dev/null 2>&1 || { echo "There is no program '$(PYTHON)' here: install Python 3.11 or newer, or name one: make env PYTHON=python3.12" >&2; exit 1; }
	@"$(PYTHON)" tools/make_env.py $(ENV_ARGS)

# JupyterLab's own defaults stay: it listens on loopback and asks for its token.
lab: env  ## open JupyterLab on a copy of the notebooks, my_notebooks/ (LAB_ARGS is passed on: LAB_ARGS=--no-browser)
	@$(VENV) -m ekfslam_tutorial lab my_notebooks --lab $(LAB_ARGS)

test: env  ## run every test, then every notebook, but for what needs a browser (TEST_ARGS is passed to pytest on tests/)
	@$(VENV) tools/run_tests.py $(TEST_ARGS)

test-browser: env  ## the site, JupyterLab, players and slides in a real browser, and three notebooks of make lite (EKFSLAM_BROWSER=all: all)
	@EKFSLAM_BROWSER="$${EKFSLAM_BROWSER:-lite}" $(VENV) tools/run_tests.py --browser $(TEST_ARGS)

mutants: env  ## change the core in one place at a time and see whether its tests find out: 30 minutes, goes on where it was stopped
	@$(VENV) tools/mutants.py $(MUTANTS_ARGS)

notebooks: env  ## re-run every notebook on a fresh kernel and store its outputs (NB=notebooks/02_... takes one)
	@$(VENV) tools/build_notebooks.py $(NB)

contents: env  ## write the tables of contents anew: README, docs/notebooks.md, notebook 00, small pictures
	@$(VENV) -m ekfslam_tutorial.course.contents

pictures: env  ## draw the moving pictures of the README anew
	@$(VENV) tools/readme_pictures.py

ogl:  ## join the parts of the WebGL library OGL that the player in space uses, anew (needs npm)
	@command -v npm >/dev/null 2>&1 || { echo "make ogl needs the program npm, a part of Node" >&2; exit 1; }
	@mkdir -p build/ogl && cp tools/ogl/* build/ogl && npm install --prefix build/ogl --silent --no-audit --no-fund
	@cd build/ogl && npx esbuild entry.js --bundle --minify --format=iife --global-name=OGL --log-level=warning --banner:js='/* OGL 1.0.11 by Nathan Gordon and contributors, in the public domain (Unlicense); joined by `make ogl` */' --outfile=../../ekfslam_tutorial/graphics/player/ogl.min.js

site: env  ## build the course site in build/site (no network is needed, neither here nor to read it)
	@$(VENV) -m sphinx -q -W --keep-going -j auto -c docs -d "$(SITE)/../trees" . "$(SITE)"
	@echo "The site is ready: $(SITE)/index.html"

# The first time it fetches JupyterLite and Pyodide, about 80 MB; afterwards it needs no network.
lite: env  ## build the course as a static site in build/lite: Python in the browser, nothing to install
	@$(VENV) tools/build_lite.py

# The benchmark has an environment of its own, with the peers in it. Leave the machine alone meanwhile.
bench:  ## measure the speed beside other programs: at most 10 minutes, writes benchmarks/RESULTS.md
	@"$(PYTHON)" benchmarks/make_env.py
	@build/bench-env/bin/python -m benchmarks $(BENCH_ARGS)

bench-quick:  ## the same in a minute, a part of it: writes build/bench-quick/RESULTS.md
	@"$(PYTHON)" benchmarks/make_env.py
	@build/bench-env/bin/python -m benchmarks --plan quick --out build/bench-quick $(BENCH_ARGS)

# pyright runs on Node: the system's, else the one that playwright brings.
lint: env  ## ruff check, ruff format --check, pyright, numpydoc
	@$(VENV) -m ruff check --output-format concise --quiet
	@$(VENV) -m ruff format --check --quiet
	@PATH="$$PATH:$$($(VENV) -c 'import pathlib, playwright; print(pathlib.Path(playwright.__file__).parent / "driver")')" PYRIGHT_PYTHON_IGNORE_WARNINGS=1 $(VENV) -m pyright
	@find ekfslam_tutorial -name '*.py' -exec $(VENV) -m numpydoc lint {} +

format: env  ## let ruff mend and format the code and the notebooks
	@$(VENV) -m ruff check --fix --quiet
	@$(VENV) -m ruff format

lock:  ## write requirements.txt and requirements-images.txt anew from pyproject.toml (needs uv; LOCK_ARGS=--upgrade takes newer versions)
	@command -v uv >/dev/null 2>&1 || { echo "make lock needs the program uv: install it outside .venv, for example with pipx install uv" >&2; exit 1; }
	@uv pip compile --universal --python-version 3.11 --generate-hashes --no-emit-index-url --no-emit-find-links --no-header --annotation-style line --only-binary :all: --extra lab --extra test --extra data --extra cluster --extra compiled --extra site $(LOCK_ARGS) --quiet --output-file requirements.txt pyproject.toml
	@"$(PYTHON)" -c 'import tomllib; print(*tomllib.load(open("pyproject.toml", "rb"))["project"]["optional-dependencies"]["images"], sep="\n")' | uv pip compile --universal --python-version 3.11 --generate-hashes --no-deps --no-emit-index-url --no-emit-find-links --no-header --no-annotate --only-binary :all: $(LOCK_ARGS) --quiet --output-file requirements-images.txt -

# Both programs have environments of their own: what they need is not a part of the course.
audit:  ## ask whether a locked package has a known security hole (needs pipx and the network)
	@command -v pipx >/dev/null 2>&1 || { echo "make audit needs the program pipx" >&2; exit 1; }
	@pipx run pip-audit --require-hashes --disable-pip -r requirements.txt -r requirements-images.txt

sbom:  ## write build/sbom.json: every locked package, its version and hashes, as CycloneDX (needs pipx)
	@command -v pipx >/dev/null 2>&1 || { echo "make sbom needs the program pipx" >&2; exit 1; }
	@mkdir -p build && pipx run --spec cyclonedx-bom cyclonedx-py requirements --of JSON -o build/sbom.json --pyproject pyproject.toml requirements.txt
	@echo "written: build/sbom.json"

clean:  ## remove .venv, build/ and all caches
	@rm -rf .venv build dist .pytest_cache .ruff_cache .hypothesis
	@find . -name __pycache__ -type d -prune -exec rm -rf {} +
