# make reproduce, make test: each does all its set-up on a fresh machine; a second call is fast.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready
BENCH_LAWS := tests/identify/benches/*/test_*_laws.py tests/identify/benches/vessel/test_real_gas.py

.DEFAULT_GOAL := help
.PHONY: help install wheel reproduce questions test test-nojit lint pictures bench conformance mutants calibrate clean

help:  ## show what can be made
	@grep -E '^[a-z-]+:.*##' $(MAKEFILE_LIST) | awk -F ':.*## ' '{printf "  make %-12s %s\n", $$1, $$2}'

$(READY): pyproject.toml constraints.txt
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[dev]'
	@touch $@

install: $(READY)  ## set up .venv; `. .venv/bin/activate` then puts layflat on the path

wheel: $(READY)  ## build the wheel: dist/
	$(BIN)/python -m pip wheel --quiet --disable-pip-version-check --no-deps --wheel-dir dist .

reproduce: $(READY)  ## reproduce the paper: build/reproduce/report.html and claims.json
	$(BIN)/layflat reproduce --out build/reproduce

questions: $(READY)  ## the same with the paper's open questions, studies of thousands of runs
	$(BIN)/layflat reproduce --out build/reproduce --questions

test: export PYTHONDONTWRITEBYTECODE :=  # hundreds of processes import the package
test: $(READY)  ## run the tests: side by side, those in real time alone, and the laws' own without compiler
	$(BIN)/python -m pytest -n 2 --dist loadscope -m "not realtime"
	$(BIN)/python -m pytest -m realtime $$(grep -rl --include='*.py' mark.realtime tests)
	NUMBA_DISABLE_JIT=1 $(BIN)/python -m pytest -n 2 --dist loadscope tests/physics tests/control $(BENCH_LAWS)

lint: $(READY)  ## style, types, import contracts
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

pictures: $(READY)  ## take the pictures of the pages in docs anew, in a real browser (a minute, on a quiet computer)
	$(BIN)/python -m docs.pictures

bench: $(READY)  ## measure speed: build/bench.json
	$(BIN)/python -m benchmarks.run --out build/bench.json

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
