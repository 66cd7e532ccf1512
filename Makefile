# Thin: everything real is in pyproject.toml and in the package. Each target sets up what it needs.
#
#   make run      set up, then trace the integrating sphere into out/integrating-sphere
#   make test     set up with the test tools, then lint, types and the whole suite (what CI does)
#   make docs     set up likewise, then build the documentation into docs/_build/html
#   make lint | types | bench | gpu | clean
#
# Variables: VENV=.venv   POCL=auto|debian|pypi|none   INTEL=none|pypi   PYTHON=…   PYTEST_ARGS=…
#   WORKERS=2    processes that run tests: a CPU device compiles kernels on one core (0: this one)
#   POCL=auto    Debian's pocl-opencl-icd where it may be installed, else the one of PyPI
#   INTEL=pypi   Intel's CPU runtime as well, which is proprietary (none: not installed, the default)
#   POCL=debian  Debian's or stop;  POCL=pypi  never ask apt;  POCL=none  the machine has a device

VENV  ?= .venv
POCL  ?= auto
INTEL ?= none
PYTHON ?=
PYTEST_ARGS ?=
WORKERS ?= 2

SETUP := VENV='$(VENV)' POCL='$(POCL)' INTEL='$(INTEL)' PYTHON='$(PYTHON)' sh .ci/setup
BIN   := $(VENV)/bin
TESTS := $(VENV)/.stamp-test$(if $(filter pypi,$(INTEL)),-intel)
INPUTS := pyproject.toml .ci/setup

.PHONY: run test lint types docs pages bench gpu clean
.DELETE_ON_ERROR:

run: $(VENV)/.stamp-run
	$(BIN)/photizon run integrating-sphere --out out/integrating-sphere

test: lint types
	$(BIN)/python -m pytest -n $(WORKERS) --dist loadfile --no-loadscope-reorder $(PYTEST_ARGS)

lint: $(TESTS)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(TESTS)
	$(BIN)/mypy

# Warnings are errors; nothing is fetched.
docs: $(TESTS)
	$(BIN)/python -m sphinx -W --keep-going -n -b html docs docs/_build/html

# Every example of every page, with what it prints; the tests run those that are quick.
pages: $(TESTS)
	$(BIN)/python -m pytest -n $(WORKERS) -m "not tracers" tests/docs/test_examples.py

bench: $(VENV)/.stamp-run
	$(BIN)/python -m benchmarks

# On a machine with a GPU; needs nothing but numpy, mako and pyopencl there.
gpu: $(VENV)/.stamp-run
	$(BIN)/python benchmarks/gpu.py

$(VENV)/.stamp-run: $(INPUTS)
	@$(SETUP) run

# The tests compare both PoCLs, so that of PyPI is installed beside Debian's.
$(TESTS): $(INPUTS)
	@$(SETUP) test

clean:
	rm -rf $(VENV) build dist .pytest_cache .mypy_cache .ruff_cache .hypothesis \
	    docs/_build docs/parts
