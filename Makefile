# From a fresh clone: `make demo`, `make test`. Needs Python 3.11, make and pip; nothing else.
PY ?= python3
VENV := .venv
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt
STAMP := $(VENV)/.installed
# Tests need more: their own tools, and the simulators of others in which our FMUs must run.
TESTING := $(VENV)/.installed-testing

.PHONY: install demo test lint bench interop verify clean
install: $(TESTING)

$(STAMP): pyproject.toml constraints.txt
	$(PY) -m venv $(VENV)
	$(PIP) -e '.[cross,train-networks]'
	touch $@

$(TESTING): $(STAMP)
	$(PIP) -e '.[cross,train-networks,daq,dev,interop,cluster]'
	# Only to compare our reader of catman files with; what it depends on stays away.
	$(PIP) --no-deps --target build/apread apread==1.1.3 || echo "apread is not to be had: one test skips"
	touch $@

demo: $(STAMP)
	$(BIN)/tribofmu demo -o build/demo

# Two processes with one thread each: threads of both that wait for each other take many times as long.
test: $(TESTING)
	OMP_NUM_THREADS=1 $(BIN)/python -m pytest -n 2 --dist loadscope tests

lint: $(TESTING)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

bench: $(TESTING)
	$(BIN)/python -m tests.benchmarks -o docs/benchmarks.md

interop: $(TESTING)
	$(BIN)/python -m tests.interop -o docs/interoperability.md

verify: $(TESTING)
	$(BIN)/tribofmu verify -o docs/verification.md

clean:
	rm -rf $(VENV) build .pytest_cache .mypy_cache .ruff_cache
