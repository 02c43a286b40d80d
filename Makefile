# make setup   leave the pinned environment in .venv (skipped while environment.txt is unchanged)
# make test    setup, then the tests
# make paper   setup, then the main job: recordings in, parameters, tables and figures out
#              make paper DATA=DIR reads the data sets in DIR
# make docs    setup, then the documentation in out/site, every link checked
# make mutants setup, then change one line behind each claim at a time: the tests must notice
# make fresh   setup, then build the wheel, install it in a fresh environment with all that it requires,
#              fetched as a user would, and run the demo there; make fresh FRESH=python3.13 on another Python
# make states  setup, then results/README.md: which results were made by the code as it is
# make lint    setup, then lint, format check and type check
# make clean   remove the environment, the caches and what a run wrote (results/ stays)

VENV := .venv
PYTHON := $(VENV)/bin/python
STAMP := $(VENV)/environment.sha256
# Two workers share the machine with whatever else runs on it.
WORKERS ?= 2
DATA ?=
FRESH ?= $(PYTHON)

# Where a shell forbids bytecode, every run would compile the whole package anew.
unexport PYTHONDONTWRITEBYTECODE

# Tests and studies run in parallel already: more BLAS threads would only wait for one another.
test paper: export OMP_NUM_THREADS = 1

.DEFAULT_GOAL := help
.PHONY: help setup test paper docs mutants fresh states lint clean

help:
	@sed -n 's/^# \{0,1\}//p;/^$$/q' Makefile

setup: $(STAMP)

# The stamp holds the hash of environment.txt, so that a fresh checkout time does not reinstall.
$(STAMP): environment.txt
	@if [ -f $@ ] && sha256sum --check --status $@; then touch $@; exit 0; fi; \
	set -e; \
	for candidate in python3.11 python3; do \
	  if command -v $$candidate >/dev/null 2>&1 && \
	     $$candidate -c 'import sys; sys.exit(sys.version_info[:2] != (3, 11))' 2>/dev/null; then \
	    python=$$candidate; break; \
	  fi; \
	done; \
	if [ -z "$${python:-}" ]; then \
	  echo "make setup: needs Python 3.11; neither python3.11 nor python3 on the PATH is that." >&2; \
	  exit 1; \
	fi; \
	echo "Setting up $(VENV) with $$python"; \
	$$python -m venv --clear $(VENV) || { \
	  echo "make setup: $$python cannot make an environment; on Debian and Ubuntu install python3.11-venv." >&2; \
	  exit 1; \
	}; \
	$(PYTHON) -m pip install --quiet --disable-pip-version-check --require-hashes -r environment.txt; \
	sha256sum environment.txt > $@

# A file stays on one worker: its tests share what is costly to make. Files keep their order, in
# which the longest do not come last.
test: setup
	$(PYTHON) -m pytest -n $(WORKERS) --dist loadfile --no-loadscope-reorder

paper: setup
	$(PYTHON) -m studies.paper $(if $(DATA),--data "$(DATA)")

docs: export NO_MKDOCS_2_WARNING = 1
docs: setup
	$(PYTHON) -m mkdocs build --strict --quiet
	@echo "open out/site/index.html"

mutants: setup
	$(PYTHON) -m tests.mutants

fresh: setup
	rm -rf out/fresh build
	$(PYTHON) -m build --wheel --no-isolation --outdir out/fresh/dist
	$(FRESH) -m venv out/fresh/env
	out/fresh/env/bin/python -m pip install --quiet --disable-pip-version-check "$$(echo out/fresh/dist/*.whl)[ros,mujoco]"
	cd out/fresh && env/bin/oed --version && env/bin/oed demo --smoke --out demo

states: setup
	$(PYTHON) -m studies.result_states

lint: setup
	$(PYTHON) -m ruff check .
	$(PYTHON) -m ruff format --check .
	$(PYTHON) -m basedpyright

clean:
	rm -rf $(VENV) out build dist .pytest_cache .ruff_cache .hypothesis .numba_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
