# make run: set up everything and mine the embedded sample; make test: set up everything and pass the tests.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
MINING := $(VENV)/.mining
READY := $(VENV)/.ready
PIP := $(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt

.PHONY: run test setup check bench docs repro clean
.DEFAULT_GOAL := run

run: $(MINING)
	$(BIN)/python -m pipeline.run

# A file stays on one worker, with what its tests share. A single file runs faster without workers: pytest FILE.
PYTEST := $(BIN)/python -m pytest --numprocesses auto --maxprocesses 8 --dist loadfile

test: setup
	$(PYTEST)

setup: $(READY)

# What mining needs, and no more: the tests, the guide and DVC bring a hundred packages of their own.
$(MINING): pyproject.toml constraints.txt
	$(PYTHON) -c 'import sys; sys.exit("RIOT needs Python 3.11 or newer; set PYTHON=…") if sys.version_info < (3, 11) else None'
	$(PYTHON) -m venv $(VENV)
	$(PIP) --editable '.[mine]'
	touch $@

$(READY): $(MINING)
	$(PIP) --editable '.[dev,dvc,docs]'
	touch $@

# Everything that CI runs: format, lint, types, layers, and all tests of make test and of whole machinery, in one go.
check: setup
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/mypy benchmarks/*.py
	$(BIN)/lint-imports
	$(PYTEST) -m 'not slow and not chaos and not fuzz'

# The stages of dvc.yaml; then `dvc metrics show`, `dvc plots show`, with $(BIN) in the PATH. DVC brings some seventy
# packages of its own, which is why it is an extra, but whoever clones this should not have to ask for it.
repro: setup
	PATH="$(abspath $(BIN)):$$PATH" dvc repro

bench: setup
	$(BIN)/python benchmarks/run.py

# The guide: build/site/index.html. Its search needs a server: python -m http.server --directory build/site
# Pictures of the studio come from its tests, where there is a Chromium.
docs: setup
	$(BIN)/python -m pytest -m system -k fits_its_screen --pictures build/studio tests/integration/test_studio_pages.py
	NO_MKDOCS_2_WARNING=1 $(BIN)/python -m mkdocs build --quiet

clean:
	rm -rf $(VENV) build *.egg-info
