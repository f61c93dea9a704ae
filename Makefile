# For a person: `make demo` and `make test`. Each makes its own environment in $(VENV) first.
# `make VENV=/elsewhere test` puts it elsewhere; `make PYTHON=/usr/bin/python3.13 test` picks one.

VENV ?= .venv
# Tests of one file share what they compile, so a file stays with one of the processes.
PYTEST := python -m pytest -n 2 --dist loadfile
DEMO ?= demo
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip --disable-pip-version-check install --quiet -c constraints.txt
INSTALL_INPUTS := pyproject.toml constraints.txt src/selfmotion/_version.py

.DEFAULT_GOAL := help
.PHONY: help demo test test-long docs benchmarks lint ruff format-check types imports format golden constraints clean

help:
	@echo "make demo         install into $(VENV) and run the demonstration; says where the report lies"
	@echo "make test         install into $(VENV) and run the tests"
	@echo "make test-long    also the studies that take minutes"
	@echo "make docs         build the documentation site into docs/_build/html"
	@echo "make benchmarks   run benchmarks/ beside their peers (ten minutes); writes docs/benchmarks.md"
	@echo "make lint         what .ci/run checks besides the tests"
	@echo "make format       let ruff put the code into shape"
	@echo "make golden       write docs/cli/*.json anew"
	@echo "make constraints  write constraints.txt anew with the newest versions"
	@echo "make clean        remove $(VENV) and caches"

demo: $(VENV)/.installed
	$(BIN)/selfmotion demo --out "$(DEMO)"
	@for report in "$(abspath $(DEMO))"/*.html; do echo "The report: $$report"; done

test: $(VENV)/.installed-dev
	$(BIN)/$(PYTEST)

test-long: $(VENV)/.installed-dev
	$(BIN)/$(PYTEST) -m "long or not long"

# Runs the examples of the gallery; a warning is an error.
docs: $(VENV)/.installed-dev
	$(BIN)/python -m sphinx -b html -W --keep-going -q docs docs/_build/html
	@echo "The site: $(abspath docs/_build/html/index.html)"

# Peers that cannot be installed are left out; the page says which.
benchmarks: $(VENV)/.installed-dev
	@while read -r peer; do $(PIP) "$$peer" || echo "left out: $$peer" >&2; done < benchmarks/peers.txt
	$(BIN)/python benchmarks/run_all.py

# The linters, one target each: pre-commit and .ci/run call these very lines.
lint: ruff format-check types imports

ruff: $(VENV)/.installed-dev
	$(BIN)/ruff check .

format-check: $(VENV)/.installed-dev
	$(BIN)/ruff format --check .

types: $(VENV)/.installed-dev
	$(BIN)/python -m pyright --pythonpath $(BIN)/python

imports: $(VENV)/.installed-dev
	$(BIN)/lint-imports

format: $(VENV)/.installed-dev
	$(BIN)/ruff check --fix-only .
	$(BIN)/ruff format .

golden: $(VENV)/.installed-dev
	$(BIN)/python -m tests.cli.golden

$(VENV)/.installed: $(VENV)/.made $(INSTALL_INPUTS)
	@echo "Installing selfmotion and what it needs into $(VENV)"
	@$(PIP) -e .
	@touch $@

$(VENV)/.installed-dev: $(VENV)/.made $(INSTALL_INPUTS)
	@echo "Installing selfmotion and its development tools into $(VENV)"
	@$(PIP) -e ".[dev]"
	@touch $@ $(VENV)/.installed

# An interpreter counts if it runs and is new enough: names on the path may be empty shells.
FIND_PYTHON = for candidate in $(or $(PYTHON),python3 python3.13 python3.12 python3.11 python); do \
	    "$$candidate" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null \
	        && { echo "$$candidate"; break; }; done

$(VENV)/.made:
	@python=$$($(FIND_PYTHON)); \
	if [ -z "$$python" ]; then \
	    echo "selfmotion needs Python 3.11 or newer, and none was found." >&2; \
	    echo "Install one, or name it: make PYTHON=/path/to/python3 ..." >&2; exit 1; fi; \
	"$$python" -m venv "$(VENV)" || { \
	    echo "$$python could not make an environment; on Debian and Ubuntu: apt install python3-venv" >&2; \
	    rm -rf "$(VENV)"; exit 1; }
	@touch $@

# Every extra together, so that one file serves all; opensim has wheels for some platforms only.
constraints:
	@scratch=$$(mktemp -d) && python=$$($(FIND_PYTHON)) && \
	"$$python" -m venv "$$scratch/venv" && \
	"$$scratch/venv/bin/pip" install --quiet hatchling ".[dev,opensim]" && \
	{ sed '/^[^#]/d' constraints.txt; \
	  "$$scratch/venv/bin/pip" freeze --exclude selfmotion | tr 'A-Z_' 'a-z-' | LC_ALL=C sort; \
	} > "$$scratch/constraints.txt" && \
	mv "$$scratch/constraints.txt" constraints.txt && rm -rf "$$scratch"

clean:
	rm -rf "$(VENV)" .pytest_cache .ruff_cache .import_linter_cache .hypothesis build dist
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
