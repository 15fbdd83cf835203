# make reproduce, make test: each does all its set-up on a fresh machine; a second call is fast.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready
# Tests that call kernels, and end without the compiler; a law that Python calls is plain Python in either case.
KERNELS := tests/physics/test_driven.py tests/physics/test_line.py tests/physics/test_plant.py \
  tests/physics/arms/chain/test_chain_description.py tests/control/tracking/test_tracking_description.py \
  tests/identify/benches/rod/test_rod_laws.py
# One after the other, as what was compiled stays in memory; more processes than processors, as tests of rigs and pages wait.
PARTS := "tests/[a-h]*/" "tests/[i-o]*/" "tests/[p-z]* layflat-ros2/tests"
SIDE_BY_SIDE := -n 3 --dist loadscope --no-loadscope-reorder
# A computer that is busy with others can be too late for a rig: what fails has a second turn, by itself, and fails for good there.
AGAIN := --last-failed --last-failed-no-failures none
REALTIME = $$(grep -rl --include='*.py' mark.realtime tests layflat-ros2/tests)
NEWEST := build/newest-numba/venv/bin/python
V ?= 3.13
BY_NEWEST := --only "rollout paper-small" --only "ensemble paper-small" --only "stepped plant"

.DEFAULT_GOAL := help
.PHONY: help install wheel prebuilt wheels reproduce questions test test-python lint docs pictures bench newest-numba export-check conformance ros2-check mutants calibrate clean

help:  ## show what can be made
	@grep -E '^[a-z-]+:.*##' $(MAKEFILE_LIST) | awk -F ':.*## ' '{printf "  make %-12s %s\n", $$1, $$2}'

$(READY): pyproject.toml constraints.txt
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[dev]'
	@touch $@

install: $(READY)  ## set up .venv; `. .venv/bin/activate` then puts layflat on the path

wheel: $(READY)  ## build the pure wheel, whose kernels are compiled where it runs: dist/
	$(BIN)/python -m pip wheel --quiet --disable-pip-version-check --no-deps --wheel-dir dist .

prebuilt: $(READY)  ## build the machine code of the built-in machines, if sources differ (half an hour)
	$(BIN)/python -m wheels.prebuilt

wheels: wheel prebuilt  ## build wheels with that machine code for Linux, too, on x86-64 and 64-bit ARM: dist/
	for platform in x86_64 aarch64; do \
	  LAYFLAT_WHEEL=$$platform $(BIN)/python -m pip wheel --quiet --disable-pip-version-check --no-deps --wheel-dir dist . || exit 1; done

reproduce: $(READY)  ## reproduce the paper: build/reproduce/report.html and claims.json
	$(BIN)/layflat reproduce --out build/reproduce

questions: $(READY)  ## the same with the paper's open questions, studies of thousands of runs
	$(BIN)/layflat reproduce --out build/reproduce --questions

test: export PYTHONDONTWRITEBYTECODE :=  # hundreds of processes import the package
test: $(READY)  ## run the tests: side by side, those in real time alone, and some of kernels without compiler
	for part in $(PARTS); do \
	  $(BIN)/python -m pytest $(SIDE_BY_SIDE) -m "not realtime" $$part || $(BIN)/python -m pytest $(AGAIN) -m "not realtime" $$part || exit 1; done
	$(BIN)/python -m pytest -m realtime $(REALTIME) || $(BIN)/python -m pytest $(AGAIN) -m realtime $(REALTIME)
	NUMBA_DISABLE_JIT=1 $(BIN)/python -m pytest $(KERNELS)

test-python:  ## run the tests on another Python, such as V=3.13, with the newest of all that is needed
	python$(V) -m venv build/python-$(V)
	build/python-$(V)/bin/python -m pip install --quiet --disable-pip-version-check -e '.[dev]'
	LAYFLAT_CACHE_DIR=$(CURDIR)/build/python-$(V)/machine-code build/python-$(V)/bin/python -m pytest $(SIDE_BY_SIDE) -m "not realtime"

lint: $(READY)  ## style, language, types, import contracts
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/python -m lint.language
	$(BIN)/mypy
	$(BIN)/lint-imports

docs: $(READY)  ## build the documentation as a site: build/docs/index.html
	$(BIN)/python -m docs.site

pictures: $(READY)  ## take the pictures of the pages in docs anew, in a real browser (a minute, on a quiet computer)
	$(BIN)/python -m docs.pictures

bench: $(READY)  ## measure speed: build/bench.json
	$(BIN)/python -m benchmarks.run --out build/bench.json

newest-numba: export LAYFLAT_ANY_COMPILER := 1
newest-numba: export LAYFLAT_CACHE_DIR := $(CURDIR)/build/newest-numba/machine-code
newest-numba: $(READY)  ## try the newest numba, candidates too: the compiler's tests, and the same bits (ten minutes)
	$(BIN)/python -m benchmarks.digests $(BY_NEWEST) --out build/newest-numba/pinned.json
	$(PYTHON) -m venv build/newest-numba/venv
	$(NEWEST) -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[bench,cell,rig,study,test,tune]'
	$(NEWEST) -m pip install --quiet --disable-pip-version-check --upgrade --pre numba llvmlite
	$(NEWEST) -m pip list | grep -E '^(numba|llvmlite|numpy) '
	$(NEWEST) -m pytest tests/jit tests/lanes
	$(NEWEST) -m benchmarks.digests $(BY_NEWEST) --out build/newest-numba/newest.json --against build/newest-numba/pinned.json

export-check: export LAYFLAT_EXPORT_CHECK := 1
export-check: $(READY)  ## check every exported target with all built-in laws, also on simulated microcontrollers
	$(BIN)/python -m pytest tests/export
	$(BIN)/python -m tests.export.matrix

ros2-check: export LAYFLAT_ROS2_PREFIX := $(CURDIR)/build/ros2
ros2-check: $(READY)  ## check the package for ROS 2 with a real rosbridge server; needs a C++ compiler
	$(BIN)/python layflat-ros2/tests/ros2_prefix.py $(LAYFLAT_ROS2_PREFIX)
	$(BIN)/python -m pytest layflat-ros2/tests/test_real_rosbridge.py

conformance:  ## compare arms of other packages as other tools read them: docs/arm-conformance.md (a quarter of an hour)
	$(PYTHON) -m venv build/conformance
	build/conformance/bin/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[conformance]'
	build/conformance/bin/python -m pip install --quiet --disable-pip-version-check --no-deps robosuite==1.5.2 gymnasium-robotics==1.4.2
	build/conformance/bin/python -m benchmarks.conformance

mutants: $(READY)  ## do the tests see mistakes in physics and control? build/mutants.json (about two hours)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[mutants]'
	$(BIN)/python -m research.mutants --out build/mutants.json

calibrate: $(READY)  ## find anew, from anywhere, what the machine files mark as calibrated (a quarter of an hour)
	$(BIN)/python -m research.calibration --seed 2 --anew --write

clean:  ## remove what was built, but not the virtual environment
	rm -rf build .mypy_cache .ruff_cache .pytest_cache .import_linter_cache
